"""Largest closings of two linear buildings without contact over the periods of both, under an ensemble of motions.

`questions.spectra.spectra` is the call that users make: it adds what rules require.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted, size_words
from pounding_risk._common.order import enough_for
from pounding_risk._common.progress import Progress
from pounding_risk._jit.sources import source_digest
from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.effects import acts_on_buildings, acts_on_ground
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.intensity import LEAST_PERIOD
from pounding_risk.motions.levels import Level, driven
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.request import AS_RECORDED, POLARITIES, RecordRequest
from pounding_risk.results.attributes import DATASET_VERSION, VERSION, as_text, versions
from pounding_risk.results.labels import CONVENTIONS
from pounding_risk.results.opened import Results
from pounding_risk.results.provenance import text_digest
from pounding_risk.results.variables import described
from pounding_risk.scene.motions import for_periods, gathered
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.records import Records, records_of
from pounding_risk.scene.scene import Scene, own_amplitude
from pounding_risk.scene.toml import write_toml
from pounding_risk.solver.pair.closings import largest_closings
from pounding_risk.studies.study import Batches, motion_coordinates
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
    """Motions at the amplitude of a study, and the attributes of its dataset on them."""

    motions: tuple[Motion, ...]
    polarities: tuple[str, ...]
    attrs: dict[str, Any]
    level: Level | None = None  # where the grid of a scene sets the amplitude


# ----------------------------------------------------------------------------------------------------- the options


def rising_axis(ends: Any, num: int, spacing: str, name: str, quantity: Quantity) -> Array:
    """Values of an axis in SI, from the two ends of a range or as they are listed; raises PoundingError."""
    unit = "" if quantity.unit == "1" else f" {quantity.unit}"
    noun = name.rpartition("_")[2]  # periods of right_periods
    if isinstance(ends, str) or np.ndim(ends) != 1 or len(ends) < 2:
        raise PoundingError(
            f'{name}: {shown(ends)} is no range; give its ends, such as "0.1{unit}" and "2{unit}", or a list of {noun}'
        )
    values = np.array([si(end, quantity, name) for end in ends])
    if (np.diff(values) <= 0.0).any():
        first = int((np.diff(values) <= 0.0).argmax())
        raise PoundingError(
            f"{name}: {values[first + 1]:g}{unit} follows {values[first]:g}{unit}; write {noun} in rising order"
        )
    if spacing not in SPACINGS:
        raise PoundingError(f"spacing: {shown(spacing)} is none; it may be {' or '.join(SPACINGS)}")
    if values.size > 2:
        return values
    if isinstance(num, bool) or not isinstance(num, int | np.integer) or not 2 <= num <= MOST_PERIODS:
        raise PoundingError(
            f"num: {shown(num)} is not a number of {noun}; write a whole number from 2 to {MOST_PERIODS}"
        )
    spaced = np.geomspace if spacing == "log" else np.linspace
    return np.asarray(spaced(values[0], values[1], num))


def damping_pair(damping: Any, scene_ratios: tuple[float, float] | None) -> tuple[float, float]:
    """Damping ratios, left and right: one for both, two, or those that the scene states."""
    if damping is None:
        return scene_ratios or (USUAL_DAMPING, USUAL_DAMPING)
    values = [damping] if isinstance(damping, str) or np.ndim(damping) == 0 else list(damping)
    if len(values) not in (1, 2):
        raise PoundingError(f"damping: {counted(len(values), 'value')}; give one for both buildings, or left and right")
    ratios = [si(ratio, DAMPING, "damping") for ratio in values]
    return ratios[0], ratios[-1]


# ------------------------------------------------------------------------------------------------------ the motions


def opened(source: Source) -> Scene | Records | RecordRequest | Sequence[Motion]:
    """The scene of a file or of tables; records and motions as they are."""
    return as_scene(source) if isinstance(source, Scene | Mapping | str | Path) else source


def stated_damping(source: Any) -> tuple[float, float] | None:
    """Damping ratios of the buildings of a scene, None for records.

    Raises SceneError unless the buildings are two single masses that move on one ground from rest.
    """
    if not isinstance(source, Scene):
        return None
    faults = []
    repair = "name its records instead of the scene"
    if len(source.buildings) != 2:
        faults.append(f"building: there are {len(source.buildings)}, and gap spectra are of a pair; {repair}")
    for building in source.buildings:
        key = f"building.{building.name}"
        if building.is_rigid:
            faults.append(
                f"{key}: is rigid, so that the gap needed is the spectral displacement of the other; {repair}"
            )
        elif not isinstance(building, Building):
            faults.append(f"{key}: has storeys, and a spectrum is of single masses; {repair}")
        elif building.displacement_history:
            faults.append(f"{key}: moves as files say, and not with the periods of a spectrum; {repair}")
        elif building.initial_displacement or building.initial_velocity:
            faults.append(f"{key}: does not start from rest, and no amplitude scales that; remove its initial state")
    if any(source.bumpers):
        faults.append("interface.bumper_length: gaps here are clear of bumpers; remove it, and add its length to them")
    if source.links:
        faults.append("interface: a link joins the two, and periods here are those of single masses; remove its keys")
    are_masses = all(isinstance(building, Building) for building in source.buildings)
    if are_masses and any((point.left_floor, point.right_floor) != (1.0, 1.0) for point in source.points):
        faults.append("building: they meet part-way up one of them, and here mass meets mass; remove their heights")
    for effect in source.effects:
        if acts_on_ground(effect.name) or acts_on_buildings(effect.name):
            faults.append(
                f"effects.{effect.name}: changes the motion without contact of masses on one ground; remove it"
            )
    if source.supports and not any(acts_on_ground(effect.name) for effect in source.effects):
        faults.append(
            "building: stand on grounds of their own, and a spectrum is of masses on one ground; remove ground_factor, "
            "ground_delay, ground_velocity and ground_record"
        )
    if faults:
        raise SceneError(source.source, faults)
    left, right = source.pair
    return left.damping, right.damping


def shaking_of(source: Any, periods: Array) -> Shaking:
    """The motions of a scene, of a request for records, or as they are given, flagged where they do not suit periods.

    Those of a scene are at its own amplitude, or the largest of its grid. Raises as `gathered` and `read_ensemble`, and
    PoundingError for another source and where there are no motions.
    """
    ends, level = (float(periods.min()), float(periods.max())), None
    left_out: tuple[str, ...] = ()
    if isinstance(source, Scene):
        if relation := source.grid.measure.relation:
            sentence = f"its periods are {relation}, and here that period varies; write them in s"
            raise SceneError(source.source, [f"records.intensity: {sentence}"])
        buildings = (building._replace(period=end) for building, end in zip(source.pair, ends, strict=True))
        ensemble = gathered(source.updated(buildings=tuple(buildings)))
        level, left_out = own_amplitude(source), ensemble.left_out
        motions = tuple(driven(motion, AS_RECORDED, level) for motion in ensemble.motions)
        polarities, text = source.records.polarities, source.to_toml()
        attrs = {
            "scene": source.text or text,
            "scene_resolved": text,
            "scene_sha256": text_digest(text),
            "scene_file": source.source.encode(errors="backslashreplace").decode(),
            "overrides": as_text(list(source.overrides)),
        }
    elif isinstance(source, Records | RecordRequest):
        if isinstance(source, Records) and source.intensity:
            raise PoundingError(
                "intensity: records without a scene have one amplitude; give pga, sa or scale in place of intensity"
            )
        request = source.request() if isinstance(source, Records) else source
        ensemble = read_ensemble(request, Path())
        motions, polarities, left_out = ensemble.motions, request.polarities, ensemble.left_out
        attrs = {"scene_resolved": write_toml({"records": records_of(request).written()})}
    else:
        motions = tuple(source) if isinstance(source, Sequence) else ()
        if not motions or not all(isinstance(motion, Motion) for motion in motions):
            raise PoundingError(
                f"{shown(source)} holds no motions; give a scene, pr.Records, or a list of what pr.read_motion returns"
            )
        polarities, attrs = POLARITIES, {"amplitude": "as given"}
    if not isinstance(source, Scene):  # `gathered` has flagged its motions
        motions = tuple(for_periods(motion, [ends]) for motion in motions)
    if not motions:
        raise PoundingError("no record is left to take a spectrum of; check the names, the files or the folder")
    if left_out:
        attrs["left_out"] = as_text(list(left_out))
    names = [motion.name for motion in motions]
    unique = [name if names.count(name) == 1 else f"{name} ({place})" for place, name in enumerate(names, start=1)]
    renamed = (replace(motion, name=name) for motion, name in zip(motions, unique, strict=True))
    return Shaking(tuple(renamed), polarities, attrs, level)


# ------------------------------------------------------------------------------------------------------- the closings


class ClosingsJob(Batches):
    """Largest closings of all pairs, one motion a batch."""

    def __init__(self, motions: Sequence[Motion], sides: tuple[Oscillators, Oscillators]):
        self.motions, self.sides = motions, sides
        self.batches = len(motions)
        sizes = [side.periods.size for side in sides]
        self.bytes_per_batch = 8 * (len(POLARITIES) * sizes[0] * sizes[1] + sum(sizes))

    def one(self, number: int) -> Chunk:
        """Closings [m] of a motion and of it reversed, and peaks of both sides."""
        motion, (left, right) = self.motions[number], self.sides
        closings = largest_closings(motion.acceleration, motion.dt, left.numbers, right.numbers)
        return {name: getattr(closings, name)[None] for name in ("closing", *SIDES)}


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
            f"num: {count} periods under {counted(len(motions), 'record')} take {size_words(needed)} of memory, more "
            f"than {size_words(MOST_BYTES)}; take fewer periods or records"
        )
    shortest = min(side.periods[0] for side in sides)
    for motion in motions:
        if shortest < LEAST_PERIOD * motion.dt:
            raise PoundingError(
                f"periods: {shortest:g} s is too short for {motion.name}, whose time step is {motion.dt:g} s; begin at "
                f"{LEAST_PERIOD * motion.dt:g} s or above"
            )
    return job.solved(workers, progress)


def gap_dataset(
    shaking: Shaking,
    sides: tuple[Oscillators, Oscillators],
    results: Chunk,
    percentiles: Sequence[float],
    keep_motions: bool,
) -> xr.Dataset:
    """The dataset of closings: percentiles [%] over records and polarities; with ``keep_motions`` each one's too."""
    motions, polarities = shaking.motions, shaking.polarities
    values = results["closing"][:, [POLARITIES.index(polarity) for polarity in polarities]]
    gaps = enough_for(values.reshape(-1, *values.shape[2:]), percentiles, axis=0)
    population = f"percentile over {counted(len(motions), 'record')} and their polarities"
    periods = ("left_period", "right_period")
    words = f"gap that a share of the motions needs, {population} of the largest u_left - u_right"
    variables: dict[str, Any] = {"required_gap": (("percentile", *periods), gaps, described("m", words))}
    coords: dict[str, Any] = {
        "percentile": ("percentile", list(percentiles), described("%", "share of the motions that need no more"))
    }
    coords |= motion_coordinates(motions, polarities, shaking.level)
    for side, period, oscillators in zip(SIDES, periods, sides, strict=True):
        # Each record once for each polarity, as in the gap: both have the same peak.
        peaks = enough_for(np.repeat(results[side], len(polarities), axis=0), percentiles, axis=0)
        words = f"spectral displacement of the {side} building"
        attributes = described("m", f"{words} under each record")
        variables |= {
            f"{side}_displacement": (("percentile", period), peaks, described("m", f"{words}, {population}")),
            f"{side}_displacement_of_record": (("record", period), results[side], attributes),
        }
        coords[period] = (period, oscillators.periods, described("s", f"period of the {side} building"))
        coords[f"{side}_damping"] = ((), oscillators.damping, described("1", f"damping ratio of the {side} building"))
    if keep_motions:
        words = "gap that each motion needs: largest u_left - u_right of the continuous motion without contact"
        variables["required_gap_of_motion"] = (("record", "polarity", *periods), values, described("m", words))
    return with_amplitude(xr.Dataset(variables, coords, spectra_attributes(shaking)))


def with_amplitude(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with its amplitude in words, unless the motions were given as they are."""
    return dataset.assign_attrs({"amplitude": Results(dataset).amplitude_words()} | dataset.attrs)


def spectra_attributes(shaking: Shaking) -> dict[str, Any]:
    """Attributes from which the dataset can be recomputed."""
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
