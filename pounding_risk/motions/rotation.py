"""Rotation of two horizontal components to one direction: that of the row of buildings, or any other.

>>> import numpy as np
>>> from pounding_risk.motions.motion import Motion
>>> from pounding_risk.motions.rotation import rotated
>>> north = Motion("n", np.array([1.0, 2.0, 0.0]), 0.01, {"azimuth": 0.0})
>>> east = Motion("e", np.array([0.0, 2.0, 1.0]), 0.01, {"azimuth": 90.0})
>>> rotated(north, east, 90.0).acceleration.round(12).tolist()
[0.0, 2.0, 1.0]
>>> rotated(north, east, 45.0).acceleration.round(6).tolist()
[0.707107, 2.828427, 0.707107]
"""

from __future__ import annotations

from math import cos, isfinite, radians, sin
from typing import Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.motion import Motion, seconds_after
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.record import SAME_STEP, recording
from pounding_risk.units import shown

SQUARE = 2.0  # degrees by which components called perpendicular may miss it
LEAST_ANGLE = 10.0  # degrees between components: below, the motion across them is mostly noise
OFF_GRID = 0.05  # samples by which two starts may miss whole steps
# Facts of a record that a rotated motion keeps where both components state the same.
SHARED = (
    *("event", "magnitude", "date", "distance_km", "vs30", "station", "sensor", "recording"),
    *("state", "format", "file", "origin", "terms", "polarity", "factor"),
    *("site", "longitude", "latitude", "site_distance_km", "site_factor"),
)
# Of what filters left of the components, both have only the narrower band.
NARROWER = {"low_corner": max, "lowest_usable_frequency": max, "high_corner": min}


def rotated(first: Motion, second: Motion, direction: float, *, azimuths: tuple[float, float] | None = None) -> Motion:
    """Rotate two horizontal components of one recording to a direction.

    Parameters
    ----------
    first : Motion
        One component.
    second : Motion
        The other, with the same time step.
    direction : float
        Direction of the result [degrees clockwise from north].
    azimuths : (float, float), optional
        Azimuths of the components [degrees], in place of those of their records.

    Returns
    -------
    Motion
        The motion along the direction, over the time that both components cover.

    Raises
    ------
    RecordError
        For time steps that differ, a direction or azimuth that is no finite number, components less than 10° from one
        line, only one known azimuth, and no time in common.

    Notes
    -----
    a(θ) = a1 cos(θ − α1) + a2 cos(θ − α2) for components perpendicular to 2°, so that a² along θ and across it add up
    to a1² + a2². Components at another angle are solved for the vector whose projections on α1 and α2 they are,
    a(θ) = [a1 sin(α2 − θ) + a2 sin(θ − α1)] / sin(α2 − α1), and the sentence says so.

    Where no azimuth is known the direction counts from the first component, the second 90° clockwise from it, with a
    flag. Components that state when they start are aligned by it, to the nearest sample, others at their first samples.
    """
    if not _is_number(direction):
        raise RecordError(f"direction: {shown(direction)} is no finite number; write degrees clockwise from north")
    if abs(first.dt - second.dt) > SAME_STEP * first.dt:
        raise RecordError(
            f"{first.name} has a time step of {first.dt:g} s, {second.name} of {second.dt:g} s; both must have the "
            "same: resample one of them"
        )
    azimuth_pair = _azimuths(first, second, azimuths)
    samples, words, doubts = _aligned(first, second)
    along, angle = _weights(float(direction), *(azimuth_pair or (0.0, 90.0)))
    if abs(sin(radians(angle))) < sin(radians(LEAST_ANGLE)):
        raise RecordError(
            f"{first.name} and {second.name} are {angle:g}° apart, almost along one line; two horizontal components "
            "that cross are needed: check the azimuths"
        )
    turned = samples[0] * along[0] + samples[1] * along[1]
    weights = f"{first.name} times {along[0]:.6g} and {second.name} times {along[1]:.6g}"
    from_north = "clockwise from the first"
    if azimuth_pair:
        from_north = f"clockwise from north, from {azimuth_pair[0]:g}° and {azimuth_pair[1]:g}°"
    sentence = f"rotation: {weights}, to {direction:g}° {from_north}"
    if not _is_square(angle):
        sentence += f"; the components are {angle:g}° apart and were solved for as such"
    if recording(first.record, "") != recording(second.record, ""):
        doubts += (f"{first.name} and {second.name} are not of one event, date and station",)
    if not azimuth_pair:
        doubts += (f"the azimuths are unknown: {direction:g}° counts from {first.name}",)
    return Motion(
        f"{first.name}+{second.name}@{direction:g}",
        turned,
        first.dt,
        _record(first, second, direction if azimuth_pair else None),
        processing=(*(f"{one.name}: {step}" for one in (first, second) for step in one.processing), *words, sentence),
        flags=tuple(
            dict.fromkeys((*(f"{one.name}: {flag}" for one in (first, second) for flag in one.flags), *doubts))
        ),
    )


def _is_number(value: Any) -> bool:
    return isinstance(value, int | float | np.integer | np.floating) and not isinstance(value, bool) and isfinite(value)


def _azimuths(first: Motion, second: Motion, stated: tuple[float, float] | None) -> tuple[float, float] | None:
    """Azimuths of both components [degrees]; None where neither is known."""
    azimuth_pair = tuple(stated) if stated is not None else (first.record.get("azimuth"), second.record.get("azimuth"))
    if azimuth_pair == (None, None):
        return None
    for motion, azimuth in zip((first, second), azimuth_pair, strict=True):
        if not _is_number(azimuth):
            raise RecordError(
                f"{motion.name}: its azimuth is {shown(azimuth)}; give both, such as azimuths = (0.0, 90.0), in "
                "degrees clockwise from north (a vertical component has none)"
            )
    return float(azimuth_pair[0]), float(azimuth_pair[1])  # type: ignore[arg-type]


def _weights(direction: float, first: float, second: float) -> tuple[tuple[float, float], float]:
    """Weight of each component along ``direction``, and the angle between them, from 0 to 360 [degrees]."""
    angle = (second - first) % 360.0
    if _is_square(angle):
        return (cos(radians(direction - first)), cos(radians(direction - second))), angle
    scale = sin(radians(angle)) or 1.0  # components along one line are refused
    return (sin(radians(second - direction)) / scale, sin(radians(direction - first)) / scale), angle


def _is_square(angle: float) -> bool:
    return abs(angle % 180.0 - 90.0) <= SQUARE


def _aligned(first: Motion, second: Motion) -> tuple[tuple[Samples, Samples], tuple[str, ...], tuple[str, ...]]:
    """Samples of both components at the same times, sentences about what was cut, and flags."""
    starts = [motion.record.get("start") for motion in (first, second)]
    later = seconds_after(first.record, second.record) / first.dt
    shift = round(later)
    gone = (max(0, shift), max(0, -shift))
    both = [motion.acceleration[count:] for motion, count in zip((first, second), gone, strict=True)]
    count = min(len(samples) for samples in both)
    if count < 2:
        spans = [
            f"{one.duration:g} s{f' from {at}' if at else ''}" for one, at in zip((first, second), starts, strict=True)
        ]
        raise RecordError(
            f"{first.name} and {second.name} share {count} samples: {' and '.join(spans)}; take two components of one "
            "recording"
        )
    words = []
    for motion, start, samples in zip((first, second), gone, both, strict=True):
        end = len(samples) - count
        if start or end:
            words.append(
                f"cut: {start * motion.dt:g} s from the start, {end * motion.dt:g} s from the end of {motion.name}"
            )
    doubts: tuple[str, ...] = ()
    if abs(later - shift) > OFF_GRID:
        off = 1000.0 * abs(later - shift) * first.dt
        doubts = (f"{first.name} and {second.name} are sampled {off:.2g} ms apart, and were not interpolated",)
    return (both[0][:count], both[1][:count]), tuple(words), doubts


def _record(first: Motion, second: Motion, azimuth: float | None) -> dict[str, Any]:
    """Facts that both records state alike, and both values of the facts that distinguish the components."""
    one, other = first.record, second.record
    record = {key: one[key] for key in SHARED if key in one and one[key] == other.get(key)}
    for key in ("id", "file", "sha256", "component"):
        both = dict.fromkeys(str(facts[key]) for facts in (one, other) if facts.get(key))
        if both:
            record[key] = " + ".join(both)
    if one.get("start") and other.get("start"):
        record["start"] = max(one["start"], other["start"])
    for key, stricter in NARROWER.items():
        corners = [facts[key] for facts in (one, other) if facts.get(key)]
        if corners:
            record[key] = stricter(corners)
    return {**record, "azimuth": None if azimuth is None else azimuth % 360.0}
