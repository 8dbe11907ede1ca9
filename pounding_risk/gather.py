"""The ground motions of a scene: what names, files, folders and sets stand for, read, turned to the row and scaled.

A file may hold several components and a folder may hold more than records. Verticals do not drive a row, so that a
pattern, a folder and a file of several components stand for their horizontals; whatever is left out is told.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from math import isclose, isfinite
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk import record_sets, scaling
from pounding_risk.errors import RecordError, SceneError
from pounding_risk.formats import is_record
from pounding_risk.manifest import read_manifest, source_of
from pounding_risk.models.effects import wave_of
from pounding_risk.motions import Motion, read_motion
from pounding_risk.noise import shared_corners
from pounding_risk.processing import DEFAULT_CHAIN
from pounding_risk.progress import Progress
from pounding_risk.quality import OF_BUILDINGS, failed, quality
from pounding_risk.record_request import RecordRequest, Spectral, matching
from pounding_risk.recordings import recording
from pounding_risk.rotation import rotated
from pounding_risk.sources import (
    RAW,
    Source,
    components,
    file_name,
    is_vertical,
    lowest_usable,
    open_source,
    parted,
)
from pounding_risk.study import Study

BESIDE = ".xml"  # StationXML, which belongs to the records beside it
SAME_PEAK = 1e-9  # another version of a library may filter with other roundings


class Gathered(NamedTuple):
    """Motions, and a sentence for each thing that was left out."""

    motions: tuple[Motion, ...]
    left_out: tuple[str, ...]


def motions_of(study: Study) -> tuple[Motion, ...]:
    """The motions of `gathered`."""
    return gathered(study).motions


def gathered(study: Study) -> Gathered:
    """The scene's ground motions, one per record, before polarity and the grid's amplitudes, and what was left out.

    Raises as `gather`, and SceneError where no file is a record and where a record ends before a passing wave has
    reached both buildings.
    """
    found = gather(study.records, study.folder, scaled=study.grid.pgas == (None,))
    found = found._replace(motions=tuple(_for_buildings(motion, study) for motion in found.motions))
    if not found.motions:
        asked = ", ".join(study.records.files)
        left = f"; left out: {', '.join(found.left_out)}" if found.left_out else ""
        raise SceneError(study.source, [f"records.files: {asked} matches no record{left}; check the folder"])
    lag = abs(getattr(wave_of(study.effects), "lag", 0.0))
    for motion in found.motions:
        if lag >= motion.duration:
            told = f"the wave needs {lag:g} s between the buildings, and {motion.name} lasts {motion.duration:g} s"
            raise SceneError(study.source, [f"effects.wave_passage: {told}; check velocity and distance"])
    return found


def _for_buildings(motion: Motion, study: Study) -> Motion:
    """The motion, flagged where it is too coarse or was filtered too narrowly for these buildings."""
    periods = [building.period for building in study.buildings if not building.is_rigid]
    if not periods:
        return motion
    findings = quality(
        motion.acceleration,
        motion.dt,
        shortest_period=min(periods),
        longest_period=max(periods),
        usable=lowest_usable(motion.record),
        checks=OF_BUILDINGS,
    )
    return replace(motion, flags=(*motion.flags, *failed(findings)))


def gather(request: RecordRequest, folder: Path, *, scaled: bool = True, progress: Progress | None = None) -> Gathered:
    """The motions that a request stands for, in its order, before polarity.

    ``folder`` is what files are relative to; without ``scaled`` the motions keep their amplitude, whatever the request
    says of it. ``progress`` is called with (read, all).

    Raises RecordError for a record that cannot be used, two records of one name, and a component without its
    partner where the row has a direction.
    """
    if request.manifest:
        return Gathered(tuple(_of_manifest(request, folder)), ())
    left_out: list[str] = []
    sources = _sources(request, folder, left_out)
    groups: list[tuple[Source, ...]] = [(source,) for source in sources]
    if request.direction is not None:
        groups = pairs(sources)
    motions = []
    for number, group in enumerate(groups, start=1):
        motions.append(treated(request, group, scaled=scaled))
        if progress is not None:
            progress(number, len(groups))
    if request.to_median is not None and scaled:
        motions = _to_median(request, motions)
    return Gathered(tuple(_distinct(motions)), tuple(left_out))


def _sources(request: RecordRequest, folder: Path, left_out: list[str]) -> list[Source]:
    """Every record that the request names; a sentence in ``left_out`` for each that is not taken."""
    if request.set:
        return [record_sets.load(member) for member in record_sets.members(request.set)]
    found = [open_source(name) for name in request.names]
    for pattern in request.files:
        named = sources_named(pattern, folder, left_out, unit=request.unit or None, dt=request.dt)
        found += horizontals(list(named), left_out)
    return list({(source.record["file"], source.name): source for source in found}.values())


def sources_named(
    pattern: str,
    folder: Path,
    left_out: list[str],
    *,
    unit: str | None = None,
    dt: float | None = None,
    lenient: bool = False,
) -> Iterator[Source]:
    """Every component of every file that a name, a pattern or a folder stands for.

    What is no record is left out of a folder, and told in ``left_out``; with ``lenient`` a damaged record is too.
    """
    in_folder = (folder / pattern).is_dir()
    for path in matching(folder, pattern):
        if in_folder and not is_record(path):
            left_out += [] if path.suffix.lower() == BESIDE else [f"{path} is not a record"]
            continue
        try:
            if parted(path)[1]:
                yield open_source(path, unit=unit, dt=dt)
            else:
                yield from components(path, unit=unit, dt=dt)
        except RecordError as error:
            if not (in_folder and lenient):
                raise
            left_out.append(str(error).partition(";")[0])


def horizontals(sources: list[Source], left_out: list[str]) -> list[Source]:
    """The records that may drive a row, or the one that there is, which was meant."""
    if len(sources) == 1:
        return sources
    left_out += [f"{source.record['id']} is vertical" for source in sources if is_vertical(source.record)]
    return [source for source in sources if not is_vertical(source.record)]


def _of_manifest(request: RecordRequest, folder: Path) -> Iterator[Motion]:
    """The records of a manifest with their factors; raises RecordError where one is not what the manifest says."""
    path = folder / request.manifest
    rows = read_manifest(path)
    if not rows:
        raise RecordError(f"{path}: names no record; choose again")
    for number, row in enumerate(rows, start=2):
        _check_row(f"{path}, line {number}", row)
        source = open_source(source_of(row, path.parent), unit=request.unit or None, dt=request.dt)
        if source.record["sha256"] != row["sha256"]:
            raise RecordError(
                f"{path}, line {number}: {row['name']} has another checksum than the manifest says: the file was "
                "changed; fetch it again, or choose again"
            )
        motion = replace(read_motion(source, processing=request.processing), name=row["name"])
        if row["factor"] != 1.0:
            motion = scaling.by_factor(motion, row["factor"], f"the factor of {path.name}")
        if not isclose(motion.pga, row["PGA [m/s2]"], rel_tol=SAME_PEAK):
            raise RecordError(
                f"{path}, line {number}: {row['name']} has a PGA of {motion.pga:g} m/s² after its factor, the manifest "
                f"says {row['PGA [m/s2]']:g}: it was processed, cut or turned otherwise; choose again"
            )
        if request.window is not None:
            motion = motion.cut(*request.window)
        if request.scale is not None:
            motion = scaling.by_factor(motion, request.scale)
        yield motion.with_tail(request.tail) if request.tail else motion


def _check_row(place: str, row: Mapping[str, Any]) -> None:
    """Refuse a row of a manifest without a name or a PGA, or with a factor that scales nothing."""
    empty = [key for key in ("name", "PGA [m/s2]", "factor") if row[key] is None]
    if empty:
        raise RecordError(f"{place}: {' and '.join(empty)} left empty; choose again")
    if not (isfinite(row["factor"]) and row["factor"] > 0.0):
        raise RecordError(f"{place}: the factor is {row['factor']:g}; it must be greater than 0 and finite")


def pairs(sources: Sequence[Source]) -> list[tuple[Source, ...]]:
    """The two horizontals of each recording; raises RecordError where there are not two."""
    recordings: dict[Any, list[Source]] = {}
    for source in sources:
        recordings.setdefault(recording(source.record, source.name), []).append(source)
    for found in recordings.values():
        if len(found) != 2:
            listed = ", ".join(file_name(source) for source in found)
            raise RecordError(
                f"direction: of {_recording(found[0])} there is {listed}; a row's direction takes the two "
                "horizontal components of each recording: name both, or leave direction out"
            )
    return [tuple(found) for found in recordings.values()]


def _recording(source: Source) -> str:
    record = source.record
    return " at ".join(str(record[key]) for key in ("event", "station") if record.get(key)) or source.name


def treated(request: RecordRequest, group: tuple[Source, ...], *, scaled: bool = True) -> Motion:
    """The motion of one component, or of two turned to the row, processed, cut and scaled as the request wants it."""
    window, pga = request.window, request.pga if scaled else None
    scale = request.scale if scaled and request.to_median is None else None
    if len(group) == 1 and request.sa is None and request.to_median is None:
        return read_motion(
            group[0], window=window, pga=pga, scale=scale, processing=request.processing, tail=request.tail
        )
    motion = _turned(request, group) if len(group) == 2 else read_motion(group[0], processing=request.processing)
    if window is not None:
        motion = motion.cut(*window)
    if pga is not None:
        motion = motion.scaled_to(pga)
    if scale is not None:
        motion = scaling.by_factor(motion, scale)
    if request.sa is not None and scaled:
        assert request.sa.value is not None
        motion = scaling.to_spectral_acceleration(motion, request.sa.value, request.sa.period, request.sa.damping)
    return motion.with_tail(request.tail) if request.tail and not (request.to_median and scaled) else motion


def _turned(request: RecordRequest, pair: tuple[Source, ...]) -> Motion:
    """Both horizontals, processed alike, in the direction of the row."""
    assert request.direction is not None
    processing: Any = request.processing
    words: tuple[str, ...] = ()
    flags: tuple[str, ...] = ()
    if processing == "auto" and all(source.record["state"] == RAW for source in pair):
        processing, words, flags = _one_band(pair)
    first, second = (read_motion(source, processing=processing) for source in pair)
    motion = rotated(first, second, request.direction)
    return replace(motion, processing=(*motion.processing, *words), flags=tuple(dict.fromkeys((*motion.flags, *flags))))


def _one_band(pair: tuple[Source, ...]) -> tuple[list[dict[str, Any]], tuple[str, ...], tuple[str, ...]]:
    """The default chain with the stricter corners of both components, so that both keep the same frequencies.

    With a sentence that says why the corners are where they are, and doubts.
    """
    steps = [{"step": step.name, **step.options} for step in DEFAULT_CHAIN]
    at = next(place for place, step in enumerate(steps) if step["step"] == "bandpass")
    before = [read_motion(source, processing=steps[:at]) for source in pair]
    if before[0].dt != before[1].dt:  # `rotated` refuses them
        return steps, (), ()
    found = shared_corners([motion.acceleration for motion in before], before[0].dt)
    steps[at] |= {"low": found.low, "high": found.high}
    return steps, (f"corners of the band-pass: {found.words}",), found.flags


def _to_median(request: RecordRequest, motions: Sequence[Motion]) -> list[Motion]:
    """The motions at the ensemble's median, then times the common factor; both components of a recording share one."""
    aim = request.to_median
    measure = f"sa({aim.period!r} s)" if isinstance(aim, Spectral) else str(aim)
    damping = aim.damping if isinstance(aim, Spectral) else 0.05
    groups = [recording(motion.record, motion.name) for motion in motions]
    found = list(scaling.to_median(motions, measure, groups=groups, damping=damping))
    if request.scale is not None:
        found = [scaling.by_factor(motion, request.scale) for motion in found]
    return [motion.with_tail(request.tail) for motion in found] if request.tail else found


def _distinct(motions: Sequence[Motion]) -> list[Motion]:
    """Motions with names of their own: those that share one are named as their files, then with folders or numbers."""
    names = [motion.name for motion in motions]
    for longer in (_as_file, _in_folder):
        again = {name for name in names if names.count(name) > 1}
        names = [longer(motion) if name in again else name for motion, name in zip(motions, names, strict=True)]
    again = {name for name in names if names.count(name) > 1}
    names = [f"{name} ({at})" if name in again else name for at, name in enumerate(names, start=1)]
    return [replace(motion, name=name) for motion, name in zip(motions, names, strict=True)]


def _as_file(motion: Motion) -> str:
    return Path(str(motion.record.get("source") or motion.name)).name


def _in_folder(motion: Motion) -> str:
    return "/".join(Path(str(motion.record.get("source") or motion.name)).parts[-2:])
