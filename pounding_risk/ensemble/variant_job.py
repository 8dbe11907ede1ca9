"""The job of a scene with axes of its numbers: for each place along them the grid of the scene at that place.

The batches of one place follow each other, so that a batch is solved, checked and written as by a scan of that scene
alone; what the scenes share is computed once.
"""

from __future__ import annotations

import json
from collections import Counter
from collections.abc import Callable
from functools import cached_property, lru_cache
from hashlib import blake2b
from typing import Any, NamedTuple

import numpy as np
from xarray import Variable

from pounding_risk._common.once import Shared
from pounding_risk.ensemble.chunks import Chunk, by_scene, joined, merged
from pounding_risk.ensemble.grid_job import GridJob
from pounding_risk.ensemble.job import DatasetWriter, Finish, Job, ScanInput, never
from pounding_risk.ensemble.known_samples import KnownSamples
from pounding_risk.ensemble.plausibility import of_input, with_ranges
from pounding_risk.motions.motion import Motion
from pounding_risk.results.along import Stack, leaves_of
from pounding_risk.results.attributes import SCENE_AXES, VARIANTS, as_text
from pounding_risk.results.labels import axes_of_motions, flags_of, made_from, with_drawn_motions
from pounding_risk.results.layout import Template
from pounding_risk.results.scene_axes import MOTIONS_DRAWN, axis_coordinates, axis_text
from pounding_risk.results.variables import own_dims
from pounding_risk.scene.motions import as_before, for_buildings
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.scene_axis import SAMPLE, SceneAxis, alone
from pounding_risk.scene.uncertain import DrawnMotions
from pounding_risk.scene.variants import Variants

JOBS = 1000  # of places along the axes that are kept, some 10 kB each
PARTS = "parts"  # the attribute that counts the parts of a row's cases
_path_text = lru_cache(maxsize=1024)(as_text)  # of paths in nested tables, which are equal in every scene


class Gathered(NamedTuple):
    """What the datasets of all scenes have beside their cases, by place along the axes."""

    free: Stack  # of motions without contact
    coords: Stack  # of buildings, storeys, interfaces and contact points
    tables: Stack  # of the resolved scenes
    attributes: Stack
    notes: dict[str, None]  # of any scene, in order
    flags: dict[str, dict[str, None]]  # of each motion, for any scene


class VariantJob(Job):
    """The grids of all scenes along the axes of one; raises as the job of each of them, naming its values.

    Axes that change the motion without contact come first: those behind them share it.
    """

    def __init__(self, scan_input: ScanInput, kind: type[GridJob]):
        study = self.study = scan_input.study
        self.scan_input, self._kind = scan_input, kind
        self.variants = Variants(study, ordered_axes(study, kind))
        self._jobs: Shared[GridJob] = Shared(JOBS)
        self._caches: dict[str, Shared[Any]] | None = None
        self._peaks: dict[Any, Any] = {}
        self._unflagged = as_before(scan_input.motions, study)
        self.drawn: DrawnMotions | None = None  # the motion of each sample, where it has one
        if study.uncertain is not None and study.uncertain.is_drawn:
            self.drawn = study.uncertain.drawn_motions(len(scan_input.motions), len(study.records.polarities))
        self._first = self._made(0)
        self._caches, self.each, self.width = self._first.caches, self._first.batches, self._first.width
        self.batches = self.each * self.variants.count
        self.shape = (*self.variants.shape, *self._first.shape)
        self.bytes_per_batch = self._first.bytes_per_batch
        self.known: KnownSamples | None = None  # whose cases are not solved

    def places(self, number: int) -> dict[str, int]:
        """The place of a scene along each axis, by its name."""
        return dict(zip((axis.name for axis in self.variants.axes), self.variants.places(number), strict=True))

    def is_known(self, number: int) -> bool:
        """True for a scene whose cases are known."""
        return self.known is not None and self.known.has(self.places(number))

    def known_batches(self) -> list[range]:
        """The batches of all scenes whose cases are known, in as few ranges as possible."""
        if self.known is None:
            return []
        numbers = filter(self.is_known, range(self.variants.count))
        return merged(range(number * self.each, (number + 1) * self.each) for number in numbers)

    def job(self, number: int) -> GridJob:
        """The job of the scene of this number."""
        return self._jobs.of(number, lambda: self._made(number))

    def _made(self, number: int) -> GridJob:
        scene, motions, motion = self._driven(number)
        job: GridJob = self._kind(self.scan_input._replace(study=scene, motions=motions))  # type: ignore[call-arg]
        job.number, job.free_key = number, (self._kind.alone_key(scene), motion)
        job.peaks = self._peaks.setdefault(motion, {})
        if self._caches is not None:
            job.caches = self._caches
            job.own_kernels = self._first.own_kernels
        else:
            job.own_kernels = job.worth_kernels(self.variants.count)
        return job

    def _driven(self, number: int) -> tuple[Scene, tuple[Motion, ...], tuple[int, ...]]:
        """A scene by its number, its motions with the doubts that follow from its periods, and which one was drawn."""
        scene, motions = self.variants.scene(number), self._unflagged
        if self.drawn is None:
            return scene, for_buildings(motions, scene), ()
        sample = self.places(number)[SAMPLE]
        record, polarity = int(self.drawn.records[sample]), int(self.drawn.polarities[sample])
        motions = motions[record : record + 1]
        records = scene.records._replace(polarities=scene.records.polarities[polarity : polarity + 1])
        if motions[0].name in records.names:
            records = records._replace(names=(motions[0].name,))
        return scene.updated(records=records), for_buildings(motions, scene), (record, polarity)

    @cached_property
    def prepared(self) -> str:
        """Digest of what the first and the last scene's runs are made of, which depends on the kind of processor."""
        digests = [self.job(number).prepared for number in (0, self.variants.count - 1)]
        return blake2b("".join(digests).encode(), digest_size=16).hexdigest()

    def law_at(self, batch: int) -> int:
        return self._first.law_at(batch % self.each)

    def solve(self, batches: range, stop: Callable[[], bool] = never) -> Chunk | None:
        chunks: list[Chunk] = []
        for number, scene_batches, _ in by_scene(batches, self.each):
            chunk = self.job(number).solve(scene_batches, stop)
            if chunk is None:
                return None
            chunks.append(chunk)
        return joined(chunks)

    @cached_property
    def template(self) -> Template:
        """The dataset without the values of its cases: variables that differ along an axis have it as a dimension."""
        base, gathered = self._first.template, self._gathered()
        names = tuple(axis.name for axis in self.variants.axes)
        about = {} if self.study.uncertain is None else self.study.uncertain.attributes()
        skeleton = base.skeleton.assign_coords(axis_coordinates(self.variants.axes, about))
        # Where a gap is drawn its label is the stated one, and `interface_gap` says which each sample has.
        skeleton = skeleton.assign_coords(gap=base.skeleton["gap"].variable.copy(data=np.array(self.study.grid.gaps)))
        motions = axes_of_motions(self.study)
        single_places = {} if motions[-1] in skeleton.sizes else {motions[-1]: 0}  # which is no dimension
        if self.drawn is not None:
            skeleton = with_drawn_motions(skeleton, self.study, self.scan_input.motions, self.drawn)
            single_places |= dict.fromkeys(motions[:-1], 0)
        for name, (along, array) in gathered.free.differing().items():
            dims = (*(names[axis] for axis in along), *motions, *own_dims(name))
            variable = Variable(dims, array, base.skeleton[name].attrs).isel(single_places)
            skeleton = skeleton.assign({name: variable})
        coordinates = self._first.coordinates(whole=True)
        for name, (along, array) in gathered.coords.differing().items():
            dims, _, about = coordinates[name]
            variable = Variable((*(names[axis] for axis in along), *dims), array, about)
            skeleton = skeleton.assign_coords({name: variable.isel(single_places, missing_dims="ignore")})
        skeleton.attrs = self._attributes(dict(base.skeleton.attrs), gathered)
        return Template(skeleton, base.cases, self.shape, names)

    def _gathered(self) -> Gathered:
        """The variables and attributes of all scenes beside their cases."""
        free, coords, tables, attributes = (Stack(self.variants.shape) for _ in range(4))
        gathered = Gathered(free, coords, tables, attributes, {}, {})
        for number in range(self.variants.count):
            job = self.job(number)
            gathered.free.add(number, self._free(number, job))
            coordinates = job.coordinates(whole=True)
            gathered.coords.add(number, {name: np.asarray(facts[1]) for name, facts in coordinates.items()})
            gathered.tables.add(number, _leaves(job.study))
            notes = of_input(job.study, job.scan_input.motions)
            note_attrs = {"notes": as_text(list(notes))} if notes else {}
            flags = flags_of(job.study, job.scan_input.motions)
            gathered.attributes.add(number, job.numbers() | flags | note_attrs)
            gathered.notes.update(dict.fromkeys(notes))
            for name, doubts in json.loads(flags["flags"]).items():
                gathered.flags.setdefault(name, {}).update(dict.fromkeys(doubts))
        return gathered

    def _free(self, number: int, job: GridJob) -> dict[str, Any]:
        """The variables of the motions of a scene without contact."""
        if self.known is not None and self.is_known(number):
            return self.known.free(self.places(number), (f"{name}_free" for name in job.free_outputs(job.study)))
        return {f"{name}_free": array for name, array in job.free_values().items()}

    def _attributes(self, first: dict[str, Any], gathered: Gathered) -> dict[str, Any]:
        """The attributes of the whole dataset from those of the first scene; those that differ are stated by place."""
        study_leaves = _leaves(self.study)
        # Tables that are the same in all scenes and unlike the study's own are stated too.
        tables = [
            row for row in gathered.tables.as_lists(whole=True) if row[1] or study_leaves.get(row[0], row) != row[2]
        ]
        variants = {"tables": tables, "attributes": gathered.attributes.as_lists()}
        differing = {name for name, *_ in variants["attributes"]}
        uncertain = self.study.uncertain
        place_notes = with_ranges(gathered.notes, self.study)
        notes = [*(() if uncertain is None else uncertain.notes()), *place_notes]
        if uncertain is not None and "notes" not in differing:
            variants["attributes"].append(["notes", [], as_text(place_notes) if place_notes else None])
        attrs = {name: attribute for name, attribute in first.items() if name not in differing}
        attrs |= made_from(self.study, self.scan_input.motions)
        if self.drawn is not None:
            attrs[MOTIONS_DRAWN] = len(self.scan_input.motions) * len(self.study.records.polarities)
        attrs |= {SCENE_AXES: axis_text(self.variants.axes), VARIANTS: as_text(variants)}
        attrs["flags"] = as_text({name: list(flags) for name, flags in gathered.flags.items() if flags})
        return attrs | ({"notes": as_text(notes)} if notes else {})

    def writer(self) -> VariantWriter:
        return VariantWriter(self)


def ordered_axes(study: Scene, kind: type[GridJob]) -> tuple[SceneAxis, ...]:
    """The axes, those first along which the motion without contact changes."""
    variants = Variants(study)
    keys: dict[str, set[Any]] = {axis.name: set() for axis in variants.axes}
    for axis, place, overrides in alone(variants.axes):
        if place in (0, axis.size - 1):
            keys[axis.name].add(kind.alone_key(variants.made(overrides)))
    return tuple(sorted(variants.axes, key=lambda axis: len(keys[axis.name]) == 1))


def _leaves(study: Scene) -> dict[str, Any]:
    """The values of the resolved tables of a scene by their paths."""
    return {_path_text(path): leaf for path, leaf in leaves_of(study.resolved())}


class VariantWriter:
    """The writers of all scenes, one after the other; see `job.DatasetWriter`."""

    def __init__(self, job: VariantJob):
        self._job = job
        self._number = -1
        self._writer: DatasetWriter | None = None
        self._patches: list[tuple[int, Chunk]] = []
        self._counts = Stack(job.variants.shape)
        self._parts: Counter[str] = Counter()

    def values(self, batches: range, chunk: Chunk) -> Chunk:
        variables: list[Chunk] = []
        for number, scene_batches, rows in by_scene(batches, self._job.each):
            if number != self._number:
                self._close()
                self._number, self._writer = number, self._job.job(number).writer()
            assert self._writer is not None, "opened just now"
            variables.append(self._writer.values(scene_batches, {name: values[rows] for name, values in chunk.items()}))
        return joined(variables)

    def known(self, batches: range) -> Chunk:
        """Every case variable of these batches, whose scenes are known."""
        job, variables = self._job, []
        assert job.known is not None, "asked of known batches alone"
        for number, scene_batches, _ in by_scene(batches, job.each):
            places = job.places(number)
            if number != self._number:
                self._close()
                self._number = number
                if counts := job.known.attribute(PARTS, places):
                    self._parts.update(json.loads(counts))
                    self._counts.add(number, {PARTS: counts})
            arrays = job.known.cases(places, job.template)
            variables.append({name: array[scene_batches.start : scene_batches.stop] for name, array in arrays.items()})
        return joined(variables)

    def _close(self) -> None:
        """Take the corrections and counts of the writer of a scene after its last batch."""
        if self._writer is None:
            return
        finish, first = self._writer.finish(), self._number * self._job.each
        self._patches += [(first + batch, patch) for batch, patch in finish.patches]
        if finish.counts:
            self._parts.update(finish.counts)
            self._counts.add(self._number, {PARTS: as_text(finish.counts)})
        self._writer = None

    def finish(self) -> Finish:
        """The corrections of all scenes, and their counts together."""
        self._close()
        attrs = {PARTS: as_text(dict(self._parts))} if self._parts else {}
        if self._parts:
            counts = self._counts.as_lists(whole=True)
            variants = json.loads(self._job.template.skeleton.attrs[VARIANTS])
            attrs[VARIANTS] = as_text(variants | {"attributes": [*variants["attributes"], *counts]})
        return Finish(attrs, tuple(self._patches), dict(self._parts))
