"""The motion without contact of all samples of a scene at once: whether neighbours ever touch follows from it alone.

`free_motion` gives, for every sample and motion, how far each gap is closed, and how far each building moves alone. No
contact is run. Single masses on one ground that start from rest are followed side by side, by `PairList`; any other
scene sample by sample, by the solver that a scan of it has, which takes a hundred times as long.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import size_words
from pounding_risk._common.progress import Progress
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.ensemble.job_choice import grid_job_of, job_kind
from pounding_risk.ensemble.limits import check_memory, free_memory
from pounding_risk.ensemble.plausibility import of_input, of_varied_masses
from pounding_risk.errors import SceneError
from pounding_risk.models.effects import acts_on_law
from pounding_risk.models.structures.contact_points import FLOOR
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.ensemble import MotionEnsemble
from pounding_risk.motions.intensity import LEAST_PERIOD
from pounding_risk.motions.levels import driven
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.request import AS_RECORDED, POLARITIES
from pounding_risk.results import labels
from pounding_risk.results.attributes import as_text, read_attribute
from pounding_risk.results.provenance import provenance
from pounding_risk.results.scene_axes import MOTIONS_DRAWN, axis_coordinates
from pounding_risk.results.variables import described
from pounding_risk.scene.motions import as_before, check_arrivals, for_periods, gathered
from pounding_risk.scene.overrides import override
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.scene_axis import SceneAxis, labels_of
from pounding_risk.scene.sections import KEYS
from pounding_risk.scene.toml import KeyPath, parse_toml
from pounding_risk.scene.uncertain import DrawnMotions, sample_axis
from pounding_risk.scene.variants import Variants, check_one_scene
from pounding_risk.solver.pair.listed_closings import PairList
from pounding_risk.studies.study import Batches

Array = NDArray[np.float64]

AT_ONCE = "all samples at once, as single masses on one ground that start from rest"
ONE_BY_ONE = "sample by sample, by the solver of the scene"
ROUNDING = 1e-14  # relative, of a period that follows from mass and stiffness
FACTS = {  # of a building, which may differ from sample to sample
    "mass": ("kg", "mass of the building"),
    "period": ("s", "first period of vibration of the building"),
    "damping": ("1", "damping ratio of the building"),
    "height": ("m", "level of the roof; NaN where not given"),
}
OF_CONTACT = ("contact_model", "yield_force", "contact_point", "storey")  # dimensions that no motion here has


class Facts(NamedTuple):
    """Numbers of the scene in each sample."""

    buildings: dict[str, Array]  # of `FACTS`: (samples, buildings); period 0 of a rigid one
    gaps: Array  # (samples, interfaces) [m]


def free_motion(
    scene: Scene | str | Path, points: Any = None, workers: int | None = None, progress: Progress | None = None
) -> xr.Dataset:
    """The motion without contact of every sample of the uncertain numbers of a scene, under every motion.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene with [uncertain], or the path of its file.
    points : array, optional
        (samples, uncertain numbers) between 0 and 1, at which the numbers are drawn instead of at the scene's own; with
        a further column where motions are drawn.
    workers : int, optional
        Number of threads; one per processor by default. Results do not depend on it.
    progress : callable, optional
        Called with the parts of the work that are done, and the number of all.

    Returns
    -------
    xarray.Dataset
        ``peak_closing_free`` (sample, record, polarity, pga where the grid has several, interface) [m], the largest
        u_left - u_right, and ``peak_displacement_free`` (the same, building) [m]. The values of each uncertain number
        are a coordinate along ``sample``. Where a motion is drawn with each sample, ``record`` and ``polarity`` are
        coordinates too, and no dimensions. The attribute ``free_motion`` says how the samples were solved; ``notes``
        say where contact is not decided by the motion without contact alone.

    Raises
    ------
    SceneError
        For a scene with faults, without uncertain numbers, or with axes of numbers in [grid]; for more samples than
        memory holds; and where a sample has numbers that no scene can have.
    PoundingError
        For points of another shape, or outside the unit cube.
    RecordError
        For a record that cannot be used.
    """
    study = as_scene(scene)
    if study.uncertain is None:
        example = '"building.frame.period" = {distribution = "lognormal", median = "0.5 s", dispersion = 0.2}'
        raise SceneError(study.source, [f"uncertain: the scene has no samples; write [uncertain] with {example}"])
    if points is not None:
        return free_along(study, sample_axis(study.uncertain, points), workers, progress, points)
    dataset = free_along(study, study.uncertain.axis, workers, progress, study.uncertain.points())
    notes = [*study.uncertain.notes(), *read_attribute(dataset, "notes", [])]
    return dataset.assign_attrs(notes=as_text(notes))


def free_along(
    study: Scene, axis: SceneAxis, workers: int | None = None, progress: Progress | None = None, points: Any = None
) -> xr.Dataset:
    """`free_motion` of the scenes along one axis, whatever it is of, instead of those of samples.

    Of samples ``points`` are those by which a motion is drawn with each, where the scene asks for that.
    """
    other_axes = tuple(other for other in study.axes if other.keys != axis.keys)
    check_one_scene(study.updated(axes=other_axes), "uncertainty")
    base = study.updated(axes=())
    ensemble = gathered(base)
    records, polarities, amplitudes = len(ensemble.motions), len(base.records.polarities), len(base.grid.amplitudes)
    drawn = None
    if points is not None and study.uncertain is not None and study.uncertain.is_drawn:
        drawn = study.uncertain.drawn_motions(records, polarities, points)
        records = polarities = 1
    facts, job = job_of(base, axis, ensemble.motions, drawn)
    motions = (axis.size, records, polarities, amplitudes)
    size = 16.0 * np.prod(motions) * (2 * len(study.buildings) - 1)
    if (free := free_memory()) and size > free:
        fault = (
            f"uncertain: {axis.size} samples under {records * polarities * amplitudes} motions take "
            f"{size_words(size)}, and {size_words(free)} of memory are free; take fewer samples or records"
        )
        raise SceneError(study.source, [fault])
    closing = np.empty((*motions, len(study.interfaces)))
    peaks = np.empty((*motions, len(study.buildings)))

    def keep(batches: range, chunk: Chunk) -> None:
        for k, number in enumerate(batches):
            place = job.place(number)
            for array, name in ((closing, "closing"), (peaks, "peaks")):
                array[place] = chunk[name][k][: len(array[place])]

    job.run(keep, workers, progress)
    return dataset_of(study, axis, ensemble, (facts, job.words, drawn), closing, peaks)


# --------------------------------------------------------------------------------------------- who solves the samples


class FreeJob(Batches):
    """The motions without contact of all samples in batches; of each its closings and peaks."""

    words: str

    def place(self, number: int) -> tuple[Any, ...]:
        """Where a batch stands in arrays of (samples, records, ...); past their length its values are padding."""
        raise NotImplementedError


class AtOnce(FreeJob):
    """Single masses, one record a batch: all samples, or those that are drawn with it.

    Twice the motion is twice the closing.
    """

    words = AT_ONCE

    def __init__(self, study: Scene, motions: tuple[Motion, ...], facts: Facts, drawn: DrawnMotions | None = None):
        self.study, self.motions, self.drawn = study, motions, drawn
        self.numbers = [facts.buildings[name] for name in ("period", "damping")]
        count, buildings = self.numbers[0].shape
        self.records = range(len(motions)) if drawn is None else np.unique(drawn.records).tolist()
        self.samples = [np.arange(count) if drawn is None else np.flatnonzero(drawn.records == n) for n in self.records]
        self.pairs = self._pairs(self.samples[0]) if drawn is None else None  # the same for all records
        self.batches = len(self.records)
        self.most = max(map(len, self.samples))
        motion_count = len(study.records.polarities) * len(study.grid.amplitudes)
        self.bytes_per_batch = 8 * motion_count * self.most * (2 * buildings - 1)

    def one(self, number: int) -> Chunk:
        """(1, samples, polarities, amplitudes, interfaces) and (1, samples, polarities, amplitudes, buildings).

        Of drawn motions each sample has one polarity, and samples are padded to the most of any batch.
        """
        samples, motion = self.samples[number], self.motions[self.records[number]]
        closings = (self.pairs or self._pairs(samples)).closings(motion.acceleration, motion.dt)
        amplitudes = self.study.grid.amplitudes
        factors = np.array(
            [1.0 if level is None else driven(motion, AS_RECORDED, level).pga / motion.pga for level in amplitudes]
        )
        senses = [POLARITIES.index(polarity) for polarity in self.study.records.polarities]
        closing = closings.closing.reshape(2, samples.size, -1)[senses].transpose(1, 0, 2)
        left, right = (peaks.reshape(samples.size, -1) for peaks in (closings.left, closings.right))
        peaks = np.repeat(np.concatenate([left, right[:, -1:]], axis=1)[:, None], len(senses), axis=1)
        if self.drawn is not None:
            places = np.arange(samples.size), self.drawn.polarities[samples]
            padding = (0, self.most - samples.size), (0, 0), (0, 0)
            closing, peaks = (np.pad(array[places][:, None], padding) for array in (closing, peaks))
        outputs = {"closing": closing, "peaks": peaks}
        return {name: output[None, :, :, None] * factors[:, None] for name, output in outputs.items()}

    def place(self, number: int) -> tuple[Any, ...]:
        return (slice(None), number) if self.drawn is None else (self.samples[number], 0)

    def _pairs(self, samples: NDArray[np.int64]) -> PairList:
        """The neighbours of these samples."""
        sides = (slice(0, -1), slice(1, None))
        return PairList(*(tuple(number[samples, side].ravel() for number in self.numbers) for side in sides))


class OneByOne(FreeJob):
    """Scenes one after the other, each by the job of its scan; those that move alike once.

    Where a motion is ``drawn`` with each sample its scene runs under that one.
    """

    words = ONE_BY_ONE

    def __init__(self, scenes: Sequence[Scene], motions: tuple[Motion, ...], drawn: DrawnMotions | None = None):
        self.motions, self.drawn = motions, drawn
        samples: dict[Any, list[int]] = {}
        for number, scene in enumerate(scenes):
            key = job_kind(scene).alone_key(scene), scene.bumpers, self._motion(number)
            samples.setdefault(key, []).append(number)
        self.places = list(samples.values())
        self.scenes = [scenes[numbers[0]] for numbers in self.places]
        for scene in self.scenes:
            check_memory(scene, motions)
            check_arrivals(scene, motions)
        self.batches = len(self.scenes)
        first = self.scenes[0]
        count = len(motions) * len(first.records.polarities) * len(first.grid.amplitudes)
        self.bytes_per_batch = 8 * count * (2 * len(first.buildings) - 1)

    def one(self, number: int) -> Chunk:
        """(1, 1, records, polarities, amplitudes, interfaces) and the same of buildings."""
        scene, motions, motion = self.scenes[number], self.motions, self._motion(self.places[number][0])
        if motion:
            scene = scene.updated(records=scene.records._replace(polarities=(scene.records.polarities[motion[1]],)))
            motions = (motions[motion[0]],)
        free = grid_job_of(ScanInput(scene, motions)).free_values()
        return {"closing": free["peak_closing"][None, None], "peaks": free["peak_displacement"][None, None]}

    def place(self, number: int) -> tuple[Any, ...]:
        return (self.places[number],)

    def _motion(self, sample: int) -> tuple[int, ...]:
        """Record and polarity of a sample; nothing where it has all."""
        drawn = self.drawn
        return () if drawn is None else (int(drawn.records[sample]), int(drawn.polarities[sample]))


def job_of(
    study: Scene, axis: SceneAxis, motions: tuple[Motion, ...], drawn: DrawnMotions | None
) -> tuple[Facts, FreeJob]:
    """How the samples of a scene without axes are solved, with the numbers of each: the only place that chooses."""
    facts = facts_of_masses(study, axis)
    if facts is not None:
        periods = facts.buildings["period"]
        if periods[periods > 0.0].min(initial=np.inf) >= LEAST_PERIOD * max(motion.dt for motion in motions):
            return facts, AtOnce(study, motions, facts, drawn)
    variants = Variants(study.updated(axes=(axis,)))
    scenes = [variants.scene(number) for number in range(axis.size)]
    buildings = {
        name: np.array([[float(getattr(body, name)) for body in scene.buildings] for scene in scenes]) for name in FACTS
    }
    facts = Facts(buildings, np.array([[interface.gap for interface in scene.interfaces] for scene in scenes]))
    return facts, OneByOne(scenes, motions, drawn)


# ----------------------------------------------------------------------------- numbers of all samples, without scenes


def facts_of_masses(study: Scene, axis: SceneAxis) -> Facts | None:
    """Numbers of single masses on one ground in every sample, without a scene for each; None for other buildings.

    Where a mass varies, the period of its building may be stated or follow from a stiffness: that is decided by the
    scenes of the first and the last sample, and of those with the least and the largest value of each number.
    """
    if not is_of_masses(study):
        return None
    columns = columns_of(study, axis)
    if columns is None:
        return None
    variants = Variants(study.updated(axes=(axis,)))
    ends = (int(end) for column in columns.values() for end in (column.argmin(), column.argmax()))
    probes = {number: variants.scene(number) for number in sorted({0, axis.size - 1, *ends})}
    for by_stiffness in (False, True):
        facts = _facts(study, columns, axis.size, by_stiffness)
        if all(_holds(facts, number, scene) for number, scene in probes.items()):
            return facts
    return None


def is_of_masses(study: Scene) -> bool:
    """True for single masses and walls on one ground that start from rest, stay linear and only meet floor to floor."""
    for building in study.buildings:
        if not isinstance(building, Building) or building.initial_displacement or building.initial_velocity:
            return False
    if study.supports or study.bumpers or study.links:
        return False
    is_of_laws = all(acts_on_law(effect.name) for effect in study.effects)
    return is_of_laws and all(point.kind == FLOOR for point in study.points)


def columns_of(study: Scene, axis: SceneAxis) -> dict[KeyPath, Array] | None:
    """The values [SI] along an axis of each number that it sets in the tables of a scene; None where one is a text."""
    tables = parse_toml(study.text, study.source)
    columns: dict[KeyPath, Array] = {}
    for key, values in zip(axis.keys, axis.values, strict=True):
        axis_labels = labels_of(values)
        if axis_labels.unit is None:
            return None
        scratch = {name: [dict(table) for table in tables.get(name, [])] for name in ("building", "interface")}
        scratch["effects"] = dict(tables.get("effects", {}))  # type: ignore[assignment]
        for path in override(scratch, f"{key}=0", KEYS, study.source):
            columns[path] = np.array(axis_labels.values)
    return columns


def _facts(study: Scene, columns: dict[KeyPath, Array], count: int, by_stiffness: bool) -> Facts:
    """Numbers in every sample; ``by_stiffness`` where a mass changes the period of its building."""
    buildings: dict[str, list[Array]] = {name: [] for name in FACTS}
    for place, building in enumerate(study.buildings):
        varied = {str(path[2]): column for path, column in columns.items() if path[:2] == ("building", place)}
        numbers = {name: varied.get(name, np.full(count, float(getattr(building, name)))) for name in FACTS}
        if not building.is_rigid and "period" not in varied and ("stiffness" in varied or by_stiffness):
            stiffness = varied.get("stiffness", np.full(count, cast(Building, building).stiffness))
            numbers["period"] = 2.0 * np.pi * np.sqrt(numbers["mass"] / stiffness)
        for name, column in numbers.items():
            buildings[name].append(column)
    is_shared = len(parse_toml(study.text, study.source).get("interface", [])) == 1
    gaps = [
        columns.get(("interface", 0 if is_shared else place, "gap"), np.full(count, interface.gap))
        for place, interface in enumerate(study.interfaces)
    ]
    return Facts({name: np.stack(column, axis=1) for name, column in buildings.items()}, np.stack(gaps, axis=1))


def _holds(facts: Facts, number: int, scene: Scene) -> bool:
    """True where the scene of a sample has these numbers."""
    if not is_of_masses(scene):
        return False
    here = [[column[number, place] for column in facts.buildings.values()] for place in range(len(scene.buildings))]
    building_facts = [[getattr(building, name) for name in facts.buildings] for building in scene.buildings]
    gaps = facts.gaps[number], [interface.gap for interface in scene.interfaces]
    return all(np.allclose(kept, own, rtol=ROUNDING, atol=0.0) for kept, own in ((here, building_facts), gaps))


# --------------------------------------------------------------------------------------------------------- the dataset


def dataset_of(
    study: Scene,
    axis: SceneAxis,
    ensemble: MotionEnsemble,
    work: tuple[Facts, str, DrawnMotions | None],
    closing: Array,
    peaks: Array,
) -> xr.Dataset:
    """The dataset of the motions without contact of samples; ``work`` is the numbers, how they were solved, motions."""
    base = study.updated(axes=())
    facts, words, drawn = work
    periods = facts.buildings["period"]
    moving = [of_one[of_one > 0.0].tolist() for of_one in periods.T]
    motions = tuple(for_periods(motion, moving) for motion in as_before(ensemble.motions, base))
    coordinates = grid_job_of(ScanInput(base, motions)).coordinates()
    dataset = labels.skeleton(base, motions, {}, coordinates).drop_dims(OF_CONTACT, errors="ignore")
    axes = labels.axes_of_motions(base)
    single = {} if axes[-1] in dataset.sizes else {axes[-1]: 0}
    if drawn is not None:
        dataset = labels.with_drawn_motions(dataset.isel(record=[0], polarity=[0]), base, motions, drawn)
        single |= dict.fromkeys(axes[:-1], 0)
    peak_words = "largest displacement relative to the ground under the building; without contact"
    for name, values, dim, long_name in (
        ("peak_closing_free", closing, "interface", labels.NEEDED + labels.WITH_BUMPERS * bool(study.bumpers)),
        ("peak_displacement_free", peaks, "building", peak_words),
    ):
        variable = xr.Variable((axis.name, *axes, dim), values, described("m", long_name)).isel(single)
        dataset = dataset.assign({name: variable})
    varied = of_varied_masses(base.buildings, facts.buildings["mass"], facts.buildings["period"])
    sample_attrs = {} if study.uncertain is None else study.uncertain.attributes()
    dataset = dataset.assign_coords(axis_coordinates((axis,), sample_attrs) | _differing(facts, axis))
    lists = {"left_out": list(ensemble.left_out), "copies": list(ensemble.copies)}
    dataset.attrs = {
        "Conventions": labels.CONVENTIONS,
        "title": f"{study.name}: motion without contact of samples".removeprefix(": "),
        "source": "pounding_risk: motion without contact, exact between the samples of the ground motion",
        **labels.made_from(study, motions),
        **provenance(study, motions, screening=True, check_fraction=0.0),
        **labels.flags_of(base, motions),
        **({} if drawn is None else {MOTIONS_DRAWN: len(motions) * len(base.records.polarities)}),
        "free_motion": words,
        "notes": as_text([*pushed_notes(base), *varied, *of_input(base, motions)]),
        **{name: as_text(sentences) for name, sentences in lists.items() if sentences},
    }
    return dataset


def pushed_notes(study: Scene) -> list[str]:
    """A sentence where the motion without contact alone does not decide contact: in a row."""
    if len(study.interfaces) == 1:
        return []
    return [
        f"{', '.join(study.interface_names)}: neighbours further along the row may push a building across a gap that "
        "the motion without contact leaves open, or hold it back from one that it closes; what is said of contact from "
        "this motion alone is of each gap as if the others were not closed"
    ]


def _differing(facts: Facts, axis: SceneAxis) -> dict[str, Any]:
    """Coordinates of what differs from sample to sample."""
    differing: dict[str, Any] = {}
    for name, (unit, long_name) in FACTS.items():
        values = facts.buildings[name]
        if (values != values[0]).any():
            is_unknown = values == 0.0 if name == "height" else facts.buildings["period"] == 0.0
            attributes = described(unit, long_name)
            differing[f"building_{name}"] = ((axis.name, "building"), np.where(is_unknown, np.nan, values), attributes)
    if (facts.gaps != facts.gaps[0]).any():
        attributes = described("m", "clear distance at rest of each interface in each sample")
        differing["sample_gap"] = ((axis.name, "interface"), facts.gaps, attributes)
    return differing
