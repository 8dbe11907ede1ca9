"""The ground motions of a scene: records named, found in files, folders, sets or a manifest, turned to the row, scaled.

A file may hold several components and a folder more than records. Verticals do not drive a row, so that a
pattern, a folder and a file of several components stand for their horizontals; a sentence names what is left out.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from math import isclose
from pathlib import Path
from types import MappingProxyType
from typing import Any, NamedTuple

from pounding_risk._common.progress import Progress
from pounding_risk._common.tables import Row
from pounding_risk.errors import RecordError
from pounding_risk.motions import read, record_sets, scaling
from pounding_risk.motions.formats import is_record, matching, split_component
from pounding_risk.motions.manifest import manifest_rows, source_of
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing import DEFAULT_CHAIN, Step, read_steps
from pounding_risk.motions.processing.noise import NOISE, shared_corners
from pounding_risk.motions.read import components, file_name, generated_sources, open_source
from pounding_risk.motions.record import (
    FACTOR_OF_SITE,
    GENERATED,
    RAW,
    STATED,
    Copy,
    Source,
    copies,
    is_vertical,
    recording,
    recording_words,
)
from pounding_risk.motions.request import RecordRequest, conflicts
from pounding_risk.motions.rotation import rotated
from pounding_risk.motions.sites.event_grid import grid_sources, is_grid, sources_at
from pounding_risk.motions.sites.places import SiteRequest
from pounding_risk.units import STANDARD_GRAVITY

BESIDE = ".xml"  # StationXML, which belongs to the records beside it
SAME_PEAK = 1e-9  # another version of a library may filter with other roundings


class MotionEnsemble(NamedTuple):
    """The motions of a request, a sentence for each record that was left out, and one for each copy of another."""

    motions: tuple[Motion, ...]
    left_out: tuple[str, ...]
    copies: tuple[str, ...] = ()


class _Chosen(NamedTuple):
    """A record of a request, with the row of a manifest that names it and what that states."""

    source: Source
    row: Row | None = None
    stated: Mapping[str, Any] = MappingProxyType({})

    @property
    def factor(self) -> float:
        """The factor of the manifest, or of the site; 1 without one."""
        return float(self.source.record.get(FACTOR_OF_SITE, 1.0) if self.row is None else self.stated["factor"])


def read_ensemble(
    request: RecordRequest, folder: Path, *, scaled: bool = True, progress: Progress | None = None
) -> MotionEnsemble:
    """Read, process and treat the motions of a request, in its order and in the polarity of the records.

    Paths of the request are relative to ``folder``. Without ``scaled`` the records keep their amplitude, whatever the
    request says of it. ``progress`` is called with the number of motions read and their total. Names of motions are
    distinct. Raises RecordError for keys that exclude each other, a record that cannot be used, and a component without
    its partner where the row has a direction.
    """
    for key, sentence in conflicts(request.given()):
        raise RecordError(f"records.{key}: {sentence}")
    left_out: list[str] = []
    chosen = list(_of_manifest(request, folder) if request.manifest else _of_sources(request, folder, left_out))
    one_size = not scaled or request.pga is not None or request.sa is not None
    chosen, repeated, copied = _without_copies(chosen, one_size)
    groups: list[tuple[Source, ...]] = [(record.source,) for record in chosen]
    if request.direction is not None:
        groups = pairs([record.source for record in chosen], repeated)
    motions = []
    for number, group in enumerate(groups, start=1):
        motion = _in_direction(request, group)
        motions.append(_as_chosen(motion, chosen[number - 1], request.manifest) if request.manifest else motion)
        if progress is not None:
            progress(number, len(groups))
    motions = read.treated(motions, request if scaled else request.unscaled())
    return MotionEnsemble(tuple(_distinct(motions)), (*left_out, *repeated), (*repeated, *copied))


def _of_sources(request: RecordRequest, folder: Path, left_out: list[str]) -> Iterator[_Chosen]:
    """Every record that the request names; a sentence for each one left out is added to ``left_out``."""
    stated: dict[str, Any] = {"unit": request.unit or None, "dt": request.dt}
    if request.generated:
        sources = [source for recipe in request.generated for source in generated_sources(recipe)]
    elif request.set:
        sources = [open_source(record_sets.load(member), **stated) for member in record_sets.members(request.set)]
    else:
        sources = [open_source(name, **stated) for name in request.names]
    for pattern in request.files:
        sources += horizontals(list(sources_named(pattern, folder, left_out, **stated)), left_out)
    if request.sites:
        wanted = None if request.place is None else SiteRequest(request.place)
        sources = horizontals(list(grid_sources(folder / request.sites, wanted, **stated)), left_out)
    return map(_Chosen, each_once(sources))


def each_once(sources: Iterable[Source]) -> list[Source]:
    """The records without those named again; the same file with another factor, of a site, is another record."""
    once = {
        (one.record["file"], one.name, one.record.get("site"), one.record.get(FACTOR_OF_SITE)): one for one in sources
    }
    return list(once.values())


def _without_copies(chosen: list[_Chosen], one_size: bool) -> tuple[list[_Chosen], list[str], list[str]]:
    """The records without those that would drive the same runs as an earlier one.

    With a sentence for each that is left out, and one for each other copy, which stays and shares its recording.
    ``one_size`` is True where all motions are scaled to one amplitude, so that their own does not distinguish them.
    """
    same = copies([(record.source.trace.data * record.factor, record.source.trace.stats.delta) for record in chosen])
    repeated = [copy for copy in same if copy.is_same_motion(any_size=one_size)]
    left_out = []
    for copy in repeated:
        first, second = (chosen[number].source for number in (copy.original, copy.place))
        same_file = first.record["file"] != second.record["file"] and first.record["sha256"] == second.record["sha256"]
        words = "is a copy of the file" if same_file else "holds the same motion as"
        left_out.append(f"{second.name} {words} {first.name}, which is used once")
    sentences = [_in_one_recording(copy, chosen) for copy in same if copy not in repeated]
    gone = {copy.place for copy in repeated}
    return [record for number, record in enumerate(chosen) if number not in gone], left_out, sentences


def _in_one_recording(copy: Copy, chosen: list[_Chosen]) -> str:
    """Assign a copy, and what shares its recording, to the recording of its original; returns the sentence about it."""
    first, second = (chosen[index].source for index in (copy.original, copy.place))
    keys = [recording(record.source.record, record.source.name) for record in chosen]
    for index, key in enumerate(keys):
        if key in (keys[copy.original], keys[copy.place]):
            record = {**chosen[index].source.record, STATED: recording_words(keys[copy.original])}
            chosen[index] = chosen[index]._replace(source=chosen[index].source._replace(record=record))
    doubt = f"the record {first.name} {copy.words()}: one recording, counted as one"
    source = chosen[copy.place].source
    chosen[copy.place] = chosen[copy.place]._replace(source=source._replace(doubts=(*source.doubts, doubt)))
    return f"{second.name} is {doubt}"


def sources_named(
    pattern: str, folder: Path, left_out: list[str], *, lenient: bool = False, **stated: Any
) -> Iterator[Source]:
    """Every component of every file that a name, a pattern or a folder stands for.

    A grid of sites stands for the motions of all, with a site after "#" for those of one (`sites.event_grid`).
    Files of a folder that are no records are left out, with a sentence in ``left_out``; with ``lenient`` damaged
    records are too. ``stated`` are unit and dt [s] of files that do not state theirs, as `open_source` takes them.
    """
    in_folder = (folder / pattern).is_dir()
    for path in matching(folder, pattern):
        file, component = split_component(path)
        if not in_folder and is_grid(file):
            yield from sources_at(file, component, **stated)
            continue
        if in_folder and not is_record(path):
            left_out += [] if path.suffix.lower() == BESIDE else [f"{path} is not a record"]
            continue
        try:
            yield from [open_source(path, **stated)] if component else components(path, **stated)
        except RecordError as error:
            if not (in_folder and lenient):
                raise
            left_out.append(str(error).partition(";")[0])


def horizontals(sources: list[Source], left_out: list[str]) -> list[Source]:
    """The horizontal components of several records; a single record is taken whatever its direction."""
    if len(sources) == 1:
        return sources
    left_out += [f"{source.record['id']} is vertical" for source in sources if is_vertical(source.record)]
    return [source for source in sources if not is_vertical(source.record)]


def _of_manifest(request: RecordRequest, folder: Path) -> Iterator[_Chosen]:
    """The records of a manifest; raises RecordError where the checksum of one is not that of the manifest."""
    path = folder / request.manifest
    rows = manifest_rows(path)
    if not rows:
        raise RecordError(f"{path}: names no record; choose again")
    for row, cells in rows:
        empty = [key for key in ("name", "PGA [m/s2]", "factor") if cells[key] is None]
        if empty:
            raise row.fault(f"{' and '.join(empty)} left empty; choose again")
        if not cells["factor"] > 0.0:
            raise row.fault(f"the factor is {cells['factor']:g}; it must be greater than 0: choose again")
        source = open_source(source_of(row, cells), unit=request.unit or None, dt=request.dt)
        if source.record["sha256"] != cells["sha256"]:
            words = "has another checksum than the manifest says: the file was changed; fetch it again, or choose again"
            raise row.fault(f"{cells['name']} {words}")
        yield _Chosen(source, row, cells)


def _as_chosen(motion: Motion, chosen: _Chosen, manifest: str) -> Motion:
    """A motion under its name and with its factor of a manifest; raises RecordError where its PGA is another one."""
    assert chosen.row is not None
    motion = replace(motion, name=chosen.stated["name"])
    if chosen.factor != 1.0:
        motion = scaling.by_factor(motion, chosen.factor, f"the factor of {Path(manifest).name}")
    if not isclose(motion.pga, chosen.stated["PGA [m/s2]"], rel_tol=SAME_PEAK):
        raise chosen.row.fault(
            f"{motion.name} has a PGA of {motion.pga:g} m/s² after its factor, the manifest says "
            f"{chosen.stated['PGA [m/s2]']:g}: it was processed, cut or turned otherwise; choose again"
        )
    return motion


def pairs(sources: Sequence[Source], repeated: Sequence[str] = ()) -> list[tuple[Source, ...]]:
    """The two horizontals of each recording; raises RecordError for a recording with another number of components.

    ``repeated`` are sentences about copies that were left out before.
    """
    recordings: dict[Any, list[Source]] = {}
    for source in sources:
        recordings.setdefault(recording(source.record, source.name), []).append(source)
    for pair in recordings.values():
        if len(pair) != 2:
            record, listed = pair[0].record, ", ".join(file_name(source) for source in pair)
            facts = [str(record[key]) for key in ("event", "station") if record.get(key)]
            without = f"; excluded: {'; '.join(repeated)}" if repeated else ""
            raise RecordError(
                f"direction: of {' at '.join(facts) or pair[0].name} there is {listed}; a row's direction takes the "
                f"two horizontal components of each recording: name both (as one aftershock or ground_record "
                f'"RSN753-000+RSN753-090", or a pattern of files such as "my/*.AT2"), or leave direction out{without}'
            )
    return [tuple(pair) for pair in recordings.values()]


def treated(request: RecordRequest, group: tuple[Source, ...]) -> Motion:
    """The motion of one component, or of two turned to the row, processed, cut and scaled as the request wants it."""
    return read.treated([_in_direction(request, group)], request)[0]


def _in_direction(request: RecordRequest, group: tuple[Source, ...]) -> Motion:
    """One component, or both horizontals, processed alike and turned to the direction of the row."""
    if len(group) == 1:
        return read.processed(group[0], request.processing)
    assert request.direction is not None
    processing: Any = request.processing
    words: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    if processing == "auto" and all(source.record["state"] == RAW for source in group):
        processing = DEFAULT_CHAIN
    if not isinstance(processing, str):
        processing, words, flags = _one_band(group, processing)
    first, second = (read.processed(source, processing) for source in group)
    motion = rotated(first, second, request.direction)
    if request.both:
        across = rotated(first, second, request.direction - 90.0)
        words = (*words, f"beside it the motion 90° to its left: PGA {across.pga / STANDARD_GRAVITY:.5g} g")
        motion = replace(motion, across=across.acceleration)
    return replace(motion, processing=(*motion.processing, *words)).doubted(flags)


def _one_band(
    pair: tuple[Source, ...], chain: Sequence[Mapping[str, Any] | Step]
) -> tuple[list[Step], tuple[str, ...], tuple[str, ...]]:
    """A chain with the stricter corners of both components, so that both keep the same frequencies.

    That is of the first band-pass that takes one from the noise. Returns the steps, a sentence that says why the
    corners are where they are, and flags.
    """
    steps = list(read_steps(chain))
    at = next((place for place, step in enumerate(steps) if _is_open(step)), -1)
    if at < 0:
        return steps, (), ()
    before = [read.processed(source, steps[:at]) for source in pair]
    if before[0].dt != before[1].dt:  # `rotated` refuses them
        return steps, (), ()
    corners = shared_corners([motion.acceleration for motion in before], before[0].dt)
    steps[at] = Step(steps[at].name, {"low": corners.low, "high": corners.high, **steps[at].options})
    return steps, (f"corners of the band-pass: {corners.words}",), corners.flags


def _is_open(step: Step) -> bool:
    """Whether a step is a band-pass that takes a corner from the noise of its record."""
    is_noise = step.options.get("corners", NOISE) == NOISE
    return step.name == "bandpass" and is_noise and not {"low", "high"} <= set(step.options)


def _distinct(motions: Sequence[Motion]) -> list[Motion]:
    """Motions with distinct names: where several share one, the file's, then with its folder, then with a number."""
    names = [motion.name for motion in motions]
    for count in (1, 2):
        again = {name for name in names if names.count(name) > 1}
        for at, motion in enumerate(motions):
            if names[at] in again:
                # The whole recipe of a generated motion.
                source = str(motion.record.get("source") or motion.name)
                folders = (source,) if motion.record.get("state") == GENERATED else Path(source).parts
                names[at] = "/".join(folders[-count:])
    again = {name for name in names if names.count(name) > 1}
    names = [f"{name} ({at})" if name in again else name for at, name in enumerate(names, start=1)]
    return [replace(motion, name=name) for motion, name in zip(motions, names, strict=True)]
