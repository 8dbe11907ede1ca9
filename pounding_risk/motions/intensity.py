"""Intensity measures of a ground motion: peaks, intensities, durations and response spectra.

Arrays in m/s² at equal steps go in, SI units come out; nothing else of the package is needed:

    >>> import numpy as np
    >>> from pounding_risk.motions import intensity
    >>> shaking = np.sin(2 * np.pi * np.arange(0, 10, 0.01))    # 1 Hz, 1 m/s²
    >>> measures = intensity.measure(shaking, 0.01)
    >>> round(measures.pgv, 3), round(measures.arias, 2)
    (0.318, 0.8)
    >>> round(float(intensity.response_spectra(shaking, 0.01, [1.0]).acceleration[0]), 2)
    9.62

a_g is linear between the samples and zero before the first, as in a run. Peaks are those of the continuous motion, not
of its samples, within the record: append zeros (`Motion.with_tail`) for the response of long periods after its end.
Integrals over time are exact but for rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import isfinite, nan, pi
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from pounding_risk.errors import PoundingError, RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.record import check_samples
from pounding_risk.motions.spectra import directions, spectra
from pounding_risk.units import DAMPING, STANDARD_GRAVITY, bounds

ANGLES = np.arange(180)  # degrees from the first component towards the second; the others are these reversed
LEAST_PERIOD = 0.1  # of the time step: stiffer oscillators move with the ground, and cost ever more


@dataclass(frozen=True)
class Measures:
    """Intensity measures of one component of ground motion."""

    pga: float  # peak ground acceleration max|a| [m/s²]
    pgv: float  # peak ground velocity max|v|, from rest [m/s]
    pgd: float  # peak ground displacement max|u|, from rest [m]
    arias: float  # Arias intensity [m/s]
    cav: float  # cumulative absolute velocity [m/s]
    d5_75: float  # significant duration, 5 to 75 % of the Arias intensity [s]; NaN where nothing moves
    d5_95: float  # 5 to 95 % [s]


@dataclass(frozen=True, eq=False)
class Spectra:
    """Response spectra of linear oscillators; arrays of shape (periods,), or (records, periods) for several records."""

    periods: Samples  # s
    damping: float  # ratio of critical
    displacement: Samples  # Sd = max|u|, relative to the ground [m]
    velocity: Samples  # Sv = max|u̇|, relative to the ground [m/s]
    acceleration: Samples  # Sa = max|ü + a_g|, absolute [m/s²]

    @property
    def pseudo_velocity(self) -> Samples:
        """PSV = ω Sd [m/s]."""
        return self.displacement * (2.0 * pi / self.periods)

    @property
    def pseudo_acceleration(self) -> Samples:
        """PSA = ω² Sd [m/s²]; Sa itself where nothing damps."""
        return self.displacement * (2.0 * pi / self.periods) ** 2


@dataclass(frozen=True, eq=False)
class Rotated:
    """Pseudo-spectral acceleration of two horizontal components along every direction (Boore 2010).

    ``acceleration`` is PSA [m/s²] of shape (periods, 180), one column a degree from the first component towards the
    second; ``pga`` the peak ground acceleration [m/s²] along each. RotD50 is the median over the directions, RotD100
    the largest.
    """

    periods: Samples  # s
    damping: float  # ratio of critical
    acceleration: Samples
    pga: Samples

    def rotd(self, percentile: float) -> Samples:
        """RotDnn of PSA [m/s²], shape (periods,): 50 and 100 are the usual ones."""
        return np.asarray(np.percentile(self.acceleration, percentile, axis=1))

    def rotd_pga(self, percentile: float) -> float:
        """RotDnn of the peak ground acceleration [m/s²]."""
        return float(np.percentile(self.pga, percentile))


def measure(acceleration: ArrayLike, dt: float) -> Measures:
    """Compute peaks, intensities and durations of one component.

    Parameters
    ----------
    acceleration : array_like, shape (n,)
        Ground acceleration [m/s²].
    dt : float
        Time step [s].

    Returns
    -------
    Measures
        PGA, PGV, PGD, Arias intensity, CAV, D5-75 and D5-95, in SI.

    Raises
    ------
    RecordError
        For fewer than two samples, samples that are not finite, and a time step that is not above zero.
    """
    a = _checked(acceleration, dt)
    pgv, pgd = _peaks_of_motion(a, dt)
    husid = husid_curve(a, dt)
    start, middle, end = (_time_of(share, husid, dt) for share in (0.05, 0.75, 0.95))
    return Measures(
        pga=float(np.abs(a).max()),
        pgv=pgv,
        pgd=pgd,
        arias=float(husid[-1]),
        cav=cumulative_absolute_velocity(a, dt),
        d5_75=middle - start,
        d5_95=end - start,
    )


def peak_ground_velocity(acceleration: ArrayLike, dt: float) -> float:
    """Compute max|v| [m/s], from rest, of samples as `measure` takes them.

    Exact for linear a: local maxima between samples count.
    """
    return _peaks_of_motion(_checked(acceleration, dt), dt)[0]


def husid_curve(acceleration: ArrayLike, dt: float) -> Samples:
    """Compute the Arias intensity up to each sample, π / (2 g) ∫ a² dt.

    Parameters
    ----------
    acceleration : array_like, shape (n,)
        Ground acceleration [m/s²].
    dt : float
        Time step [s].

    Returns
    -------
    array, shape (n,)
        Arias intensity [m/s]; the last value is that of the record. Raises as `measure`.

    References
    ----------
    Arias (1970); Husid (1969). Exact for linear a: h (a0² + a0 a1 + a1²) / 3 in each interval.
    """
    a = _checked(acceleration, dt)
    before, after = a[:-1], a[1:]
    squares = dt / 3.0 * (before * before + before * after + after * after)
    return np.append(0.0, np.cumsum(squares)) * (pi / (2.0 * STANDARD_GRAVITY))


def cumulative_absolute_velocity(acceleration: ArrayLike, dt: float) -> float:
    """Compute CAV = ∫ |a| dt.

    Parameters
    ----------
    acceleration : array_like, shape (n,)
        Ground acceleration [m/s²].
    dt : float
        Time step [s].

    Returns
    -------
    float
        CAV [m/s], exact for linear a, also where it changes sign between samples. Raises as `measure`.

    References
    ----------
    EPRI (1988).
    """
    a = _checked(acceleration, dt)
    before, after = np.abs(a[:-1]), np.abs(a[1:])
    areas = 0.5 * dt * (before + after)
    crossed = a[:-1] * a[1:] < 0.0
    before, after = before[crossed], after[crossed]
    areas[crossed] = 0.5 * dt * (before * before + after * after) / (before + after)  # two triangles
    return float(areas.sum())


def significant_duration(acceleration: ArrayLike, dt: float, shares: tuple[float, float] = (0.05, 0.95)) -> float:
    """Compute the time between two shares of the Arias intensity.

    Parameters
    ----------
    acceleration : array_like, shape (n,)
        Ground acceleration [m/s²].
    dt : float
        Time step [s].
    shares : (float, float)
        Shares of the Arias intensity at the start and at the end.

    Returns
    -------
    float
        Duration [s], the Husid curve taken as linear between samples; NaN for a motion of zeros. Raises as `measure`.

    References
    ----------
    Trifunac and Brady (1975).
    """
    husid = husid_curve(acceleration, dt)
    return _time_of(shares[1], husid, dt) - _time_of(shares[0], husid, dt)


def response_spectra(
    acceleration: ArrayLike | Sequence[Samples], dt: ArrayLike, periods: ArrayLike, damping: float = 0.05
) -> Spectra:
    """Compute Sd, Sv and Sa of linear oscillators, for one record or several at once.

    Parameters
    ----------
    acceleration : array_like, shape (n,), or sequence of such arrays
        Ground acceleration [m/s²] of one record, or of several of any lengths.
    dt : float or array_like, shape (records,)
        Time step [s].
    periods : array_like, shape (periods,)
        Periods of the oscillators [s], in any order.
    damping : float
        Damping ratio.

    Returns
    -------
    Spectra
        Peaks from rest, in SI. Local maxima between samples are found to 4e-6 or better.

    Raises
    ------
    RecordError
        For a record that `measure` refuses.
    PoundingError
        For a period or damping ratio out of range.

    References
    ----------
    ü + 2 ζ ω u̇ + ω² u = −a_g, exact for linear a_g: Nigam and Jennings (1969). See `pounding_risk.motions.spectra`.
    """
    alone = len(acceleration) == 0 or np.ndim(acceleration[0]) == 0  # type: ignore[arg-type,index]
    records: Sequence[Any] = [acceleration] if alone else list(acceleration)  # type: ignore[arg-type]
    steps = np.array(np.broadcast_to(np.asarray(dt, dtype=float), (len(records),)))
    samples = [
        _checked(record, step, f"record {k}") for k, (record, step) in enumerate(zip(records, steps, strict=True))
    ]
    valid = _checked_periods(periods, damping, steps.max(initial=0.0))
    order = np.argsort(valid)
    starts = np.append(0, np.cumsum([record.size for record in samples]))
    peaks = np.empty((3, len(samples), valid.size))
    peaks[:, :, order] = spectra(np.concatenate([*samples, []]), starts, steps, valid[order], float(damping))
    return Spectra(valid, float(damping), *(peaks[:, 0] if alone else peaks))


def rotated_spectra(
    components: tuple[ArrayLike, ArrayLike], dt: float, periods: ArrayLike, damping: float = 0.05
) -> Rotated:
    """Compute PSA of two perpendicular horizontal components along every direction: RotD50, RotD100.

    Parameters
    ----------
    components : (array_like, array_like), shape (n,) each
        Accelerations of the components [m/s²], at the same times.
    dt : float
        Time step [s].
    periods : array_like, shape (periods,)
        Periods of the oscillators [s].
    damping : float
        Damping ratio.

    Returns
    -------
    Rotated
        PSA [m/s²] and PGA [m/s²] along 180 directions. The response along a direction is that to both components,
        combined; its peak is the largest over time, local maxima between samples included, to 1e-5 at 5 % damping.

    Raises
    ------
    RecordError
        For components of different lengths, and for a record that `measure` refuses.
    PoundingError
        For a period or damping ratio out of range.

    References
    ----------
    Boore (2010).
    """
    first, second = (_checked(component, dt, f"component {k}") for k, component in enumerate(components))
    if first.size != second.size:
        raise RecordError(
            f"the components have {first.size} and {second.size} samples; both must be at the same times: cut them to "
            "the same start and length"
        )
    valid = _checked_periods(periods, damping, dt)
    turns = np.array([np.cos(np.deg2rad(ANGLES)), np.sin(np.deg2rad(ANGLES))])
    peaks = directions(first, second, float(dt), valid, float(damping), turns)
    pga = np.array([np.abs(c * first + s * second).max() for c, s in turns.T])
    return Rotated(valid, float(damping), peaks * ((2.0 * pi / valid) ** 2)[:, None], pga)


def _checked(acceleration: Any, dt: float, name: str = "the acceleration") -> Samples:
    check_samples(acceleration, dt, name)
    return np.ascontiguousarray(acceleration, dtype=np.float64)


def _checked_periods(periods: ArrayLike, damping: float, dt: float) -> Samples:
    if not DAMPING.allows(damping):
        raise PoundingError(
            f"damping {damping:g} is out of range: a damping ratio must be {bounds(DAMPING)}; 5 % is 0.05"
        )
    checked = np.atleast_1d(np.array(periods, dtype=np.float64))
    for period in checked:
        if not (isfinite(period) and period >= LEAST_PERIOD * dt):
            raise PoundingError(
                f"period {period:g} s is out of range: with a time step of {dt:g} s it must be at least "
                f"{LEAST_PERIOD * dt:g} s and finite; stiffer oscillators move with the ground, Sa = PGA"
            )
    return checked


def _peaks_of_motion(a: Samples, dt: float) -> tuple[float, float]:
    """max|v| and max|u| from rest; between samples v is a parabola and u a cubic."""
    before, after = a[:-1], a[1:]
    v = np.append(0.0, np.cumsum(0.5 * dt * (before + after)))
    u = np.append(0.0, np.cumsum(dt * v[:-1] + dt * dt / 6.0 * (2.0 * before + after)))
    turns = before * after < 0.0
    local_maxima = v[:-1][turns] + 0.5 * dt * before[turns] ** 2 / (before[turns] - after[turns])
    pgv = max(np.abs(v).max(), np.abs(local_maxima).max(initial=0.0))
    # u at the zeros of v inside an interval, up to two of them; 0 where there is none.
    push, slope, speed = a[:-1], np.diff(a) / dt, v[:-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        # v + a x + ȧ x² / 2 = 0, in the form that does not cancel; NaN or infinite where there is no root.
        both = -(push + np.copysign(np.sqrt(push * push - 2.0 * slope * speed), push))
        roots = [both / slope, 2.0 * speed / both]
    inside = [np.where((root > 0.0) & (root < dt), root, nan) for root in roots]
    turned = [np.nan_to_num(u[:-1] + root * (speed + root * (0.5 * push + root * slope / 6.0))) for root in inside]
    return float(pgv), float(max(np.abs(displacements).max() for displacements in (u, *turned)))


def _time_of(share: float, husid: Samples, dt: float) -> float:
    """Time at which the Husid curve, linear between samples, reaches a share of its end [s]."""
    if husid[-1] <= 0.0:
        return nan
    return float(np.interp(share * husid[-1], husid, np.arange(husid.size) * dt))
