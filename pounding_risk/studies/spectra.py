"""Largest closings of two linear buildings without contact over the periods of both, under an ensemble of motions.

`assessment.spectra.spectra` is the call that users make: it adds what rules ask for.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from os import cpu_count
from pathlib import Path
from typing import Any, NamedTuple, cast

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.order import enough_for
from pounding_risk._common.progress import Progress
from pounding_risk._jit.sources import source_digest
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.job import Job
from pounding_risk.ensemble.threads import Pending, Threads
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.effects import acts_on_buildings, acts_on_ground
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.intensity import LEAST_PERIOD
from pounding_risk.motions.levels import Level, driven
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.request import AS_RECORDED, POLARITIES, RecordRequest
from pounding_risk.results.attributes import as_text, versions
from pounding_risk.results.check import DATASET_VERSION, VERSION
from pounding_risk.results.labels import CONVENTIONS, measure_attributes
from pounding_risk.results.opened import Results
from pounding_risk.results.provenance import text_digest
from pounding_risk.results.variables import described
from pounding_risk.scene.motions import for_periods, gathered
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.records import Records, records_of
from pounding_risk.scene.scene import Scene, own_amplitude
from pounding_risk.scene.toml import write_toml
from pounding_risk.solver.pair.closings import largest_closings
from pounding_risk.units import DAMPING, Quantity, shown, si

Array = NDArray[np.float64]
Source = Scene | Mapping[str, Any] | str | Path | Records | RecordRequest | Sequence[Motion]

SIDES = ("left", "right")
SPACINGS = ("log", "linear")
USUAL_DAMPING = 0.05
MOST_PERIODS = 1000  # of a side
MOST_BYTES = 4e9  # of all closings while their percentiles are taken
COPIES = 3  # of the closings at that time: NumPy sorts a copy


class Oscillators(NamedTuple):
    """The oscillators of one side."""

    periods: Array  # s, rising
    damping: float

    @property
    def numbers(self) -> tuple[Array, Array]:
        """Periods [s] and damping ratios, one each."""
        return self.periods, np.full(self.periods.size, self.damping)


class Shaking(NamedTuple):
    """Motions at the amplitude of a study, and what its dataset says of them."""

    motions: tuple[Motion, ...]
    polarities: tuple[str, ...]
    attrs: dict[str, Any]
    level: Level | None = None  # where the grid of a scene sets the amplitude


# ---------------------------------------------------------------------------------------------- what is asked for


def rising_axis(values: Any, num: int, spacing: str, name: str, quantity: Quantity) -> Array:
    """Values of an axis in SI, from the two ends of a range or as they are listed; raises PoundingError."""
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    what = name.rpartition("_")[2]  # periods of right_periods
    if isinstance(values, str) or np.ndim(values) != 1 or len(values) < 2:
        raise PoundingError(
            f'{name}: {shown(values)} is no range; give its ends, such as "0.1{unit}" and "2{unit}", or a list of '
            f"{what}"
        )
    read = np.array([si(value, quantity, name) for value in values])
    if (np.diff(read) <= 0.0).any():
        first = int((np.diff(read) <= 0.0).argmax())
        raise PoundingError(
            f"{name}: {read[first + 1]:g}{unit} follows {read[first]:g}{unit}; write {what} in rising order"
        )
    if spacing not in SPACINGS:
        raise PoundingError(f"spacing: {shown(spacing)} is none; it may be {' or '.join(SPACINGS)}")
    if read.size > 2:
        return read
    if isinstance(num, bool) or not isinstance(num, int | np.integer) or not 2 <= num <= MOST_PERIODS:
        raise PoundingError(
            f"num: {shown(num)} is not a number of {what}; write a whole number from 2 to {MOST_PERIODS}"
        )
    between = np.geomspace if spacing == "log" else np.linspace
    return np.asarray(between(read[0], read[1], num))


def damping_pair(damping: Any, stated: tuple[float, float] | None) -> tuple[float, float]:
    """Damping ratios, left and right: one for both, two, or those that the scene states."""
    if damping is None:
        return stated or (USUAL_DAMPING, USUAL_DAMPING)
    both = [damping] if isinstance(damping, str) or np.ndim(damping) == 0 else list(damping)
    if len(both) not in (1, 2):
        raise PoundingError(f"damping: {counted(len(both), 'value')}; give one for both buildings, or left and right")
    ratios = [si(value, DAMPING, "damping") for value in both]
    return ratios[0], ratios[-1]


# ------------------------------------------------------------------------------------------------------ the motions


def opened(source: Source) -> Scene | Records | RecordRequest | Sequence[Motion]:
    """The scene of a file or of tables; records and motions as they are."""
    return as_scene(source) if isinstance(source, Scene | Mapping | str | Path) else source


def stated_damping(source: Any) -> tuple[float, float] | None:
    """Damping ratios of the buildings of a scene, None for records; raises SceneError for buildings it is not for."""
    if not isinstance(source, Scene):
        return None
    left, right = _linear_pair(source)
    return left.damping, right.damping


def _linear_pair(study: Scene) -> tuple[Building, Building]:
    """The two single masses of a scene that move on one ground from rest; raises SceneError for anything else."""
    faults = []
    instead = "name its records instead of the scene"
    if len(study.buildings) != 2:
        faults.append(f"building: there are {len(study.buildings)}, and a spectrum is of two; {instead}")
    for building in study.buildings:
        where = f"building.{building.name}"
        if building.is_rigid:
            faults.append(
                f"{where}: is rigid, so that the gap needed is the spectral displacement of the other; {instead}"
            )
        elif not isinstance(building, Building):
            faults.append(f"{where}: has storeys, and a spectrum is of single masses; {instead}")
        elif building.initial_displacement or building.initial_velocity:
            faults.append(f"{where}: does not start from rest, and no amplitude scales that; remove its initial state")
    for effect in study.effects:
        if acts_on_ground(effect.name) or acts_on_buildings(effect.name):
            faults.append(
                f"effects.{effect.name}: changes the motion without contact of masses on one ground; remove it"
            )
    if study.supports and not any(acts_on_ground(effect.name) for effect in study.effects):
        faults.append(
            "building: stand on grounds of their own, and a spectrum is of masses on one ground; remove ground_factor, "
            "ground_delay, ground_velocity and ground_record"
        )
    if faults:
        raise SceneError(study.source, faults)
    return study.pair


def shaking_of(source: Any, periods: Array) -> Shaking:
    """The motions of a scene, of a request for records, or as they are given, flagged where they do not suit periods.

    Raises as `gathered` and `read_ensemble`, and PoundingError for what is none of these.
    """
    if isinstance(source, Scene):
        return _of_scene(source, periods)
    if isinstance(source, Records | RecordRequest):
        if isinstance(source, Records) and source.intensity:
            raise PoundingError(
                "intensity: records without a scene have one amplitude; give pga, sa or scale in place of intensity"
            )
        request = source.request() if isinstance(source, Records) else source
        ensemble = read_ensemble(request, Path())
        motions = tuple(for_periods(motion, (periods.min(), periods.max())) for motion in ensemble.motions)
        attrs = {"scene_resolved": write_toml({"records": records_of(request).written()})}
        attrs |= {"left_out": as_text(list(ensemble.left_out))} if ensemble.left_out else {}
        return _checked(Shaking(motions, request.polarities, attrs))
    given: tuple[Any, ...] = tuple(source) if isinstance(source, Sequence) else ()
    if not given or not all(isinstance(motion, Motion) for motion in given):
        raise PoundingError(
            f"{shown(source)} holds no motions; give a scene, pr.Records, or a list of what pr.read_motion returns"
        )
    flagged = tuple(for_periods(motion, (periods.min(), periods.max())) for motion in given)
    return _checked(Shaking(flagged, POLARITIES, {"amplitude": "as given"}))


def _of_scene(study: Scene, periods: Array) -> Shaking:
    """Motions of a scene at its own amplitude, or the largest of its grid."""
    if relation := study.grid.measure.relation:
        sentence = f"its periods are {relation}, and here that period varies; write them in s"
        raise SceneError(study.source, [f"records.intensity: {sentence}"])
    left, right = study.pair
    ends = left._replace(period=float(periods.min())), right._replace(period=float(periods.max()))
    ensemble = gathered(study.updated(buildings=ends))
    level = own_amplitude(study)
    motions = tuple(driven(motion, AS_RECORDED, level) for motion in ensemble.motions)
    text = study.to_toml()
    attrs = {
        "scene": study.text or text,
        "scene_resolved": text,
        "scene_sha256": text_digest(text),
        "scene_file": study.source.encode(errors="backslashreplace").decode(),
        "overrides": as_text(list(study.overrides)),
        **({"left_out": as_text(list(ensemble.left_out))} if ensemble.left_out else {}),
    }
    return _checked(Shaking(motions, study.records.polarities, attrs, level))


def _checked(shaking: Shaking) -> Shaking:
    """The motions under distinct names; raises PoundingError where there are none."""
    if not shaking.motions:
        raise PoundingError("no record is left to take a spectrum of; check the names, the files or the folder")
    names = [motion.name for motion in shaking.motions]
    named = [name if names.count(name) == 1 else f"{name} ({place})" for place, name in enumerate(names, start=1)]
    motions = (replace(motion, name=name) for motion, name in zip(shaking.motions, named, strict=True))
    return shaking._replace(motions=tuple(motions))


# ------------------------------------------------------------------------------------------------------- the closings


class ClosingsJob:
    """Largest closings of all pairs, one motion a batch, as the threads of a scan take it."""

    def __init__(self, motions: Sequence[Motion], sides: tuple[Oscillators, Oscillators]):
        self.motions, self.sides = motions, sides
        sizes = [side.periods.size for side in sides]
        self.bytes_per_batch = 8 * (len(POLARITIES) * sizes[0] * sizes[1] + sum(sizes))

    def solve(self, batches: range, stop: Callable[[], bool]) -> Chunk | None:
        """Closings [m] of these motions and of them reversed, and peaks of both sides; None where it was stopped."""
        results = []
        for number in batches:
            if stop():
                return None
            motion, (left, right) = self.motions[number], self.sides
            results.append(largest_closings(motion.acceleration, motion.dt, left.numbers, right.numbers))
        return {name: np.stack([getattr(one, name) for one in results]) for name in ("closing", *SIDES)}


def closings(
    motions: Sequence[Motion],
    sides: tuple[Oscillators, Oscillators],
    workers: int | None = None,
    progress: Progress | None = None,
) -> Chunk:
    """Largest closings [m] of every pair under every motion, (motions, polarities, left, right), and peaks of each.

    Raises PoundingError where they are more than `MOST_BYTES` while percentiles are taken, and for periods that are
    too short for the time step of a motion.
    """
    job = ClosingsJob(motions, sides)
    if (needed := COPIES * len(motions) * job.bytes_per_batch) > MOST_BYTES:
        count = " × ".join(str(side.periods.size) for side in sides)
        raise PoundingError(
            f"num: {count} periods under {counted(len(motions), 'record')} take {needed / 1e9:.1f} GB of memory, more "
            f"than {MOST_BYTES / 1e9:g} GB; take fewer periods or records"
        )
    shortest = min(side.periods[0] for side in sides)
    for motion in motions:
        if shortest < LEAST_PERIOD * motion.dt:
            raise PoundingError(
                f"periods: {shortest:g} s is too short for {motion.name}, whose time step is {motion.dt:g} s; begin at "
                f"{LEAST_PERIOD * motion.dt:g} s or above"
            )
    pending = Pending([range(len(motions))], lambda _: 0, bytes_per_batch=job.bytes_per_batch)
    chunks: dict[int, Chunk] = {}
    done = [0]

    def keep(batches: range, chunk: Chunk, seconds: float) -> None:
        chunks[batches.start] = chunk
        done[0] += len(batches)
        if progress is not None:
            progress(done[0], len(motions))

    Threads(workers or cpu_count() or 1).run(cast(Job, job), pending, keep)
    return {name: np.concatenate([chunks[start][name] for start in sorted(chunks)]) for name in ("closing", *SIDES)}


def gap_dataset(
    shaking: Shaking,
    sides: tuple[Oscillators, Oscillators],
    found: Chunk,
    percentiles: Sequence[float],
    keep_motions: bool,
) -> xr.Dataset:
    """The dataset of closings: percentiles [%] over records and polarities; with ``keep_motions`` each one's too."""
    motions, polarities = shaking.motions, shaking.polarities
    chosen = found["closing"][:, [POLARITIES.index(polarity) for polarity in polarities]]
    gaps = enough_for(chosen.reshape(-1, *chosen.shape[2:]), percentiles, axis=0)
    population = f"percentile over {counted(len(motions), 'record')} and their polarities"
    variables: dict[str, Any] = {
        "required_gap": (
            ("percentile", "left_period", "right_period"),
            gaps,
            described("m", f"gap that a share of the motions needs, {population} of the largest u_left - u_right"),
        )
    }
    for side in SIDES:
        # Each record once for each polarity, as in the gap: both have the same peak.
        peaks = np.repeat(found[side], len(polarities), axis=0)
        words = f"spectral displacement of the {side} building, {population}"
        of_side = ("percentile", f"{side}_period"), enough_for(peaks, percentiles, axis=0)
        variables[f"{side}_displacement"] = (*of_side, described("m", words))
        words = f"spectral displacement of the {side} building under each record"
        variables[f"{side}_displacement_of_record"] = (
            ("record", f"{side}_period"),
            found[side],
            described("m", words),
        )
    if keep_motions:
        words = "gap that each motion needs: largest u_left - u_right of the continuous motion without contact"
        variables["required_gap_of_motion"] = (
            ("record", "polarity", "left_period", "right_period"),
            chosen,
            described("m", words),
        )
    coords: dict[str, Any] = {
        "percentile": ("percentile", list(percentiles), described("%", "share of the motions that need no more")),
        "record": ("record", [motion.name for motion in motions], {"long_name": "ground motion"}),
        "polarity": ("polarity", list(polarities), {"long_name": "sign of the ground motion"}),
        "record_pga": (
            "record",
            [motion.pga for motion in motions],
            described("m/s2", "peak ground acceleration that the buildings felt"),
        ),
    }
    for side, oscillators in zip(SIDES, sides, strict=True):
        words = f"period of the {side} building"
        coords[f"{side}_period"] = (f"{side}_period", oscillators.periods, described("s", words))
        coords[f"{side}_damping"] = ((), oscillators.damping, described("1", f"damping ratio of the {side} building"))
    level = shaking.level
    if level is not None:
        coords[level.measure.axis] = ((), level.value, measure_attributes(level.measure))
    dataset = xr.Dataset(variables, coords, spectra_attributes(shaking))
    if "amplitude" not in dataset.attrs:
        dataset.attrs["amplitude"] = Results(dataset).amplitude_words()
    return dataset


def spectra_attributes(shaking: Shaking) -> dict[str, Any]:
    """What it takes to make the dataset again."""
    motions = shaking.motions
    return {
        "Conventions": CONVENTIONS,
        VERSION: DATASET_VERSION,
        "title": "Required gap over the periods of two buildings",
        "source": "pounding_risk: linear oscillators, exact between the samples of the ground motion",
        **shaking.attrs,
        "records": as_text([{**motion.record, "name": motion.name, "dt": motion.dt} for motion in motions]),
        "processing": as_text({motion.name: list(motion.processing) for motion in motions}),
        "flags": as_text({motion.name: list(motion.flags) for motion in motions if motion.flags}),
        "motions_sha256": as_text({motion.name: motion.digest for motion in motions}),
        "kernels_digest": source_digest(),
        "versions": as_text(versions()),
    }
