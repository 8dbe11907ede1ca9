"""Baseline correction of the processing chain, by a polynomial or by offsets in acceleration; see
`pounding_risk.motions.processing`.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import DRIFT_OF_PEAK, ORDER, Done, step, whole
from pounding_risk.motions.processing.signals import Samples, energy_time, quiet_before, velocity_displacement
from pounding_risk.units import TIME

POLYNOMIAL, BILINEAR = "polynomial", "bilinear"
STRONG = (0.05, 0.95)  # of the energy: between them the shaking is strong, and shifts a baseline
SETTLING = 0.5  # of the earthquake's length up to 95 % of its energy, after that: then its waves have passed
SHORTEST_END = 10.0  # s after that from which an offset is read


@step("baseline", scheme=(POLYNOMIAL, BILINEAR), order=ORDER, start=TIME, end=TIME)
def baseline(
    samples: Samples,
    dt: float,
    *,
    scheme: str = POLYNOMIAL,
    order: float | None = None,
    start: float | None = None,
    end: float | None = None,
) -> Done:
    """Correct the baseline, which makes velocity and displacement drift.

    "polynomial": the second derivative of a polynomial of ``order`` (6) fitted to the displacement. Its constant and
    linear coefficients are zero, so the motion still starts from rest (PEER NGA-West2, Ancheta et al. 2013). Time runs
    from 0 to 1 in the fit, which keeps it well-conditioned. It comes after a band-pass, and leaves no permanent
    displacement.

    "bilinear": offsets in acceleration, for a raw record less its mean before the earthquake, in place of the
    band-pass's lower corner. A line v = v0 + a_f t is fitted to the velocity of the quiet end. Without times the
    offset a_f is subtracted from where that line is zero (Boore 2001), without free parameters. With ``start`` and
    ``end`` [s], t1 and t2, or where the line has no zero in the shaking, a_m = (v0 + a_f t2)/(t2 - t1) is subtracted
    between them and a_f from t2 on, so that velocity stays continuous (Iwan et al. 1985); t1 and t2 are the times of
    5 % and 95 % of the energy unless given. A permanent displacement stays and is reported, with the value that
    another choice of times gives, as it depends on them (Boore 2001).

    Velocity that does not come to rest is flagged, displacement only for a polynomial. Raises RecordError for options
    of the other scheme, times that do not rise, and less than 10 s of quiet at the end to read an offset from.
    """
    if scheme == BILINEAR:
        if order is not None:
            raise RecordError('order is one of a polynomial; leave it out, or write scheme = "polynomial"')
        return _bilinear(samples, dt, (start, end))
    if start is not None or end is not None:
        raise RecordError('start and end are times of offsets; leave them out, or write scheme = "bilinear"')
    degree = whole(6 if order is None else order, "a baseline", 2)
    duration = (len(samples) - 1) * dt
    share = np.linspace(0.0, 1.0, len(samples))
    powers = np.arange(2, degree + 1)
    _, displacement = velocity_displacement(samples, dt)
    fit = np.linalg.lstsq(share[:, None] ** powers, displacement, rcond=None)[0]
    bend = (share[:, None] ** (powers - 2)) @ (fit * powers * (powers - 1)) / duration**2
    corrected = samples - bend
    sentence = f"baseline: subtracted the second derivative of an order-{degree} polynomial in displacement"
    words, flags = _ends(corrected, dt, ("velocity", "displacement"))
    return Done(corrected, f"{sentence}; {words}", flags)


class _Shaking(NamedTuple):
    """Times [s] of the arrival, of 5 and 95 % of the energy, and of the end of the waves."""

    arrival: float
    strong: tuple[float, float]
    quiet_from: float


class _Line(NamedTuple):
    """Velocity of the quiet end: ``speed`` [m/s] at time zero and ``slope`` [m/s²], the offset after the shaking."""

    speed: float
    slope: float

    def at(self, time: float) -> float:
        return self.speed + self.slope * time


def _bilinear(samples: Samples, dt: float, given: tuple[float | None, float | None]) -> Done:
    shaking = _shaking(samples, dt, given[1])
    line = _line(samples, dt, shaking.quiet_from)
    zero = -line.speed / line.slope if line.slope else -1.0
    if given == (None, None) and shaking.arrival <= zero <= shaking.quiet_from:
        corrected = samples - line.slope * _unit_step(len(samples), dt, zero)
        words = f"offset of {line.slope:.4g} m/s² subtracted from {zero:.4g} s on"
        others = shaking.strong
    else:
        start, end = (usual if time is None else time for time, usual in zip(given, shaking.strong, strict=True))
        if end <= start:
            raise RecordError(
                f"offsets from {start:.4g} s to {end:.4g} s: the times do not rise; write an end after the start"
            )
        times = (start, end)
        corrected = samples - _offsets(len(samples), dt, line, times)
        middle = line.at(times[1]) / (times[1] - times[0])
        words = f"offsets of {middle:.4g} m/s² from {times[0]:.4g} to {times[1]:.4g} s and {line.slope:.4g} after"
        others = (shaking.arrival, shaking.quiet_from)
    instead = samples - _offsets(len(samples), dt, line, others)
    quiet_end = slice(round(shaking.quiet_from / dt), None)
    displacement, otherwise = (
        100.0 * float(velocity_displacement(trace, dt)[1][quiet_end].mean()) for trace in (corrected, instead)
    )
    other_words = f"{otherwise:.3g} cm with offsets from {others[0]:.4g} and {others[1]:.4g} s on"
    permanent = f"permanent displacement {displacement:.3g} cm ({other_words})"
    ends, flags = _ends(corrected, dt, ("velocity",))
    fitted = f"fitted to the velocity after {shaking.quiet_from:.4g} s"
    return Done(corrected, f"baseline: bilinear, {words}, {fitted}; {permanent}; {ends}", flags)


def _shaking(samples: Samples, dt: float, end: float | None) -> _Shaking:
    """The times of the shaking; the quiet end begins after the ``end`` of the offsets where that is given."""
    arrival = quiet_before(samples, dt)
    first, last = (energy_time(samples, dt, share) for share in STRONG)
    if not arrival < last > first:
        raise RecordError('the record has no shaking in which its baseline could shift; write scheme = "polynomial"')
    quiet_from = max(last + SETTLING * (last - arrival), end or 0.0)
    quiet = (len(samples) - 1) * dt - quiet_from
    if quiet < SHORTEST_END:
        raise RecordError(
            f"the bilinear scheme reads the offset from {SHORTEST_END:g} s or more of quiet after the shaking, the "
            f'record ends {max(quiet, 0.0):.3g} s after it; take a longer record, or scheme = "polynomial"'
        )
    return _Shaking(arrival, (first, last), quiet_from)


def _line(samples: Samples, dt: float, quiet_from: float) -> _Line:
    """The line through the velocity from ``quiet_from`` [s] to the end (least squares, about its middle)."""
    velocity = velocity_displacement(samples, dt)[0][round(quiet_from / dt) :]
    time = np.arange(len(samples))[round(quiet_from / dt) :] * dt
    middle = float(time.mean())
    slope = float((time - middle) @ velocity / ((time - middle) @ (time - middle)))
    return _Line(float(velocity.mean()) - slope * middle, slope)


def _offsets(count: int, dt: float, line: _Line, times: tuple[float, float]) -> Samples:
    """The offsets [m/s²]: a_m between the two times and a_f after them."""
    middle = line.at(times[1]) / (times[1] - times[0])
    first, second = (_unit_step(count, dt, time) for time in times)
    return middle * first + (line.slope - middle) * second


def _unit_step(count: int, dt: float, time: float) -> Samples:
    """Zero before ``time`` and one after it, with a ramp of one step so that its integral is exact."""
    return np.clip(np.arange(count) - time / dt + 0.5, 0.0, 1.0)


def _ends(samples: Samples, dt: float, at_rest: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
    """Peaks and last values of velocity and displacement in words; flags for those that do not end at rest."""
    flags, words = [], []
    for name, trace, unit in zip(
        ("velocity", "displacement"), velocity_displacement(samples, dt), ("cm/s", "cm"), strict=True
    ):
        peak, last = 100.0 * float(np.abs(trace).max()), 100.0 * float(trace[-1])
        words.append(f"peak {name} {peak:.4g} {unit}, at the end {last:.3g}")
        if name in at_rest and abs(last) > DRIFT_OF_PEAK * peak:
            share = 100.0 * abs(last) / peak
            flags.append(f"after baseline correction the {name} ends at {share:.0f} % of its peak")
    return ", ".join(words), tuple(flags)
