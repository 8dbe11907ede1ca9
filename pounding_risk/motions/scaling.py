"""Scaling motions by one factor: to a PGA, to a spectral acceleration, to the median of their ensemble.

Each function multiplies a motion by one number, adds a sentence that says which and why, and flags a factor outside
0.25 to 4 and a PGA that no earthquake has. Sa is the pseudo-spectral acceleration ω² max|u|, as in codes and in models
of ground motion; with 5 % damping the absolute one is up to 2 % larger at periods up to 1 s (in the FEMA P-695 sets),
and more at longer ones.

    >>> import numpy as np
    >>> from pounding_risk.motions.motion import Motion
    >>> from pounding_risk.motions import scaling
    >>> motion = Motion("swell", np.sin(np.arange(0.0, 20.0, 0.01)), 0.01, {})
    >>> round(scaling.to_spectral_acceleration(motion, "0.3 g", "0.5 s").pga, 3)
    2.875
"""

from __future__ import annotations

import re
from collections.abc import Callable, Hashable, Sequence
from math import exp, inf, isfinite, log
from typing import Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.motion import Motion, in_si
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import DAMPING, PERIOD, PGA, SCALE, STANDARD_GRAVITY, Quantity, shown

PGV = Quantity("m/s", 0.0, inf, "peak ground velocity", open_low=True, open_high=True, example="0.3 m/s")
MEAN_PERIODS = 10  # in the mean of Sa over a range, evenly in the logarithm
# How a measure grows with the motion: Arias intensity with its square.
POWERS = {"pga": 1.0, "pgv": 1.0, "pgd": 1.0, "cav": 1.0, "arias": 2.0}
_SA = re.compile(r"sa\((.+)\)", re.IGNORECASE)


def by_factor(motion: Motion, factor: float | str, aim: str = "") -> Motion:
    """Scale a motion by a factor.

    Parameters
    ----------
    motion : Motion
        The motion.
    factor : float or str
        Factor, above 0.
    aim : str
        Words for the history of the motion, such as the value that the factor reaches.

    Returns
    -------
    Motion
        The motion times the factor. Raises RecordError for a factor that is not above 0.
    """
    return motion.scaled(in_si("scale", factor, SCALE), aim)


def to_pga(motion: Motion, pga: float | str) -> Motion:
    """Scale a motion to a peak ground acceleration.

    Parameters
    ----------
    motion : Motion
        The motion.
    pga : float or str
        max|a| after scaling [m/s², or text such as "0.5 g"].

    Returns
    -------
    Motion
        The motion times one factor.
    """
    return motion.scaled_to(pga)


def to_pgv(motion: Motion, pgv: float | str) -> Motion:
    """Scale a motion to a peak ground velocity.

    Parameters
    ----------
    motion : Motion
        The motion.
    pgv : float or str
        max|v| after scaling, the velocity from rest [m/s, or text such as "30 cm/s"].

    Returns
    -------
    Motion
        The motion times one factor. Raises RecordError for a motion of zeros.
    """
    return by_factor(motion, *factor_to(motion, "pgv", in_si("pgv", pgv, PGV)))


def to_spectral_acceleration(motion: Motion, value: float | str, period: float | str, damping: float = 0.05) -> Motion:
    """Scale a motion to a spectral acceleration at one period.

    Parameters
    ----------
    motion : Motion
        The motion; the oscillator is followed to the end of the record and no further.
    value : float or str
        Pseudo-spectral acceleration after scaling [m/s², or text such as "0.4 g"].
    period : float or str
        Period of the oscillator [s].
    damping : float
        Damping ratio of the oscillator.

    Returns
    -------
    Motion
        The motion times one factor; the value is reached to rounding.

    Raises
    ------
    RecordError
        For a value, period or damping ratio out of range, and for a motion of zeros.
    """
    target, at = in_si("value", value, PGA), in_si("period", period, PERIOD)
    return by_factor(motion, *factor_to(motion, "sa", target, (at,), damping))


def to_mean_spectral_acceleration(
    motion: Motion, value: float | str, periods: tuple[float | str, float | str], damping: float = 0.05
) -> Motion:
    """Scale a motion to a mean spectral acceleration over a range of periods.

    The mean is Sa_avg, geometric, over 10 periods evenly spaced in the logarithm, ends included (Baker and Cornell
    2006; Eads, Miranda and Lignos 2015; Kohrangi, Bazzurro, Vamvatsikos and Spillatura 2017).

    Parameters
    ----------
    motion : Motion
        The motion.
    value : float or str
        Sa_avg after scaling [m/s², or text such as "0.4 g"].
    periods : (float or str, float or str)
        Shortest and longest period [s].
    damping : float
        Damping ratio of the oscillators.

    Returns
    -------
    Motion
        The motion times one factor.

    Raises
    ------
    RecordError
        As `to_spectral_acceleration`, and for an empty range of periods.
    """
    return by_factor(motion, *factor_to(motion, "sa_avg", in_si("value", value, PGA), period_range(periods), damping))


def factor_to(
    motion: Motion, measure: str, target: float, periods: tuple[float, ...] = (), damping: float = 0.05
) -> tuple[float, str]:
    """The factor with which "pgv", "sa" or "sa_avg" of a motion is a target [SI], and that aim in words.

    ``periods`` [s] are that of "sa", or both ends of the range of "sa_avg". Raises RecordError for a motion of zeros.
    """
    damped = f"{100.0 * damping:g} %) of {target / STANDARD_GRAVITY:.5g} g"
    if measure == "pgv":
        value, aim = peak_velocities([motion])[0], f"PGV of {100.0 * target:.5g} cm/s"
    elif measure == "sa":
        value, aim = spectral_accelerations([motion], periods, damping)[0, 0], f"Sa({periods[0]:g} s, {damped}"
    else:
        value = mean_spectral_accelerations([motion], periods, damping)[0]
        aim = f"mean Sa({periods[0]:g} to {periods[1]:g} s, {damped}"
    return _ratio(target, float(value), motion.name), aim


def to_median(
    motions: Sequence[Motion],
    measure: str | Callable[[Motion], float],
    *,
    groups: Sequence[Hashable] | None = None,
    damping: float = 0.05,
) -> tuple[Motion, ...]:
    """Scale motions to the median of their ensemble in one measure.

    Parameters
    ----------
    motions : sequence of Motion
        The ensemble.
    measure : str or callable
        "pga", "pgv", "pgd", "cav", "arias" (whose factor is the root of the ratio), "sa(0.5 s)", or a function of a
        motion that grows in proportion to it.
    groups : sequence of hashable, optional
        One label for each motion. Motions of one label share the factor of their geometric mean, as both components of
        a station in FEMA P-695, whose NM is ``to_median(motions, "pgv", groups=stations)`` but for its own PGV.
    damping : float
        Damping ratio of the oscillators, for "sa(...)".

    Returns
    -------
    tuple of Motion
        Each motion times its factor.

    Raises
    ------
    RecordError
        For no motions, an unknown measure, a number of labels other than that of the motions, and motions of zeros.
    """
    labels = list(range(len(motions)) if groups is None else groups)
    if not motions or len(labels) != len(motions):
        raise RecordError(
            f"{len(motions)} motions and {len(labels)} labels of groups; give one motion or more, and a label for each"
        )
    values, words = measured(motions, measure, damping)
    for motion, value in zip(motions, values, strict=True):
        _ratio(1.0, value, motion.name)  # names the motion that no factor scales
    means = {
        label: _geometric_mean([value for value, own_label in zip(values, labels, strict=True) if own_label == label])
        for label in labels
    }
    median = float(np.median(list(means.values())))
    power = POWERS.get(measure.lower(), 1.0) if isinstance(measure, str) else 1.0
    aim = f"the median {words} of {len(means)} {'motions' if groups is None else 'groups'}"
    factors = [(median / means[label]) ** (1.0 / power) for label in labels]
    return tuple(by_factor(motion, factor, aim) for motion, factor in zip(motions, factors, strict=True))


def measured(
    motions: Sequence[Motion], measure: str | Callable[[Motion], float], damping: float = 0.05
) -> tuple[list[float], str]:
    """The value of a measure, as in `to_median`, of each motion [SI], and the measure in words."""
    if not isinstance(measure, str):
        return [float(measure(motion)) for motion in motions], getattr(measure, "__name__", "measure")
    name, inside = measure.strip().lower(), _SA.fullmatch(measure.strip())
    if inside:
        period = in_si("measure", inside[1], PERIOD)
        spectra = spectral_accelerations(motions, [period], damping)
        return [float(value) for value in spectra[:, 0]], f"Sa({period:g} s, {100.0 * damping:g} %)"
    if name not in POWERS:
        raise RecordError(
            f'measure: {shown(measure)} is not one; it may be {", ".join(POWERS)}, "sa(0.5 s)" or a function'
        )
    from pounding_risk.motions.intensity import measure as measure_all

    values = [getattr(measure_all(motion.acceleration, motion.dt), name) for motion in motions]
    return values, "Arias intensity" if name == "arias" else name.upper()


def spectral_accelerations(motions: Sequence[Motion], periods: Any, damping: float = 0.05) -> Samples:
    """Pseudo-spectral acceleration [m/s²] of each motion at each of ``periods`` [s], shape (motions, periods)."""
    from pounding_risk.motions.intensity import response_spectra  # compiled, and reading a record needs none of it

    if not DAMPING.allows(damping):
        raise RecordError(f"damping: {damping:g} is no damping ratio; write one from 0 to below 1, such as 0.05")
    samples = [motion.acceleration for motion in motions]
    return response_spectra(samples, [motion.dt for motion in motions], periods, damping).pseudo_acceleration


def mean_spectral_accelerations(motions: Sequence[Motion], periods: Sequence[float], damping: float = 0.05) -> Samples:
    """Sa_avg [m/s²] of each motion over a range of periods [s], as `to_mean_spectral_acceleration` has it."""
    spectra = spectral_accelerations(motions, mean_periods(*periods), damping)
    # Of still ground there is no logarithm.
    return np.array([_geometric_mean(row) if (row > 0.0).all() else 0.0 for row in spectra])


def mean_periods(low: float, high: float) -> Samples:
    """The periods [s] over which a mean of Sa is taken, evenly in the logarithm, ends included."""
    return np.geomspace(low, high, MEAN_PERIODS)


def peak_velocities(motions: Sequence[Motion]) -> Samples:
    """Peak ground velocity [m/s] of each motion, from rest."""
    from pounding_risk.motions.intensity import peak_ground_velocity

    return np.array([peak_ground_velocity(motion.acceleration, motion.dt) for motion in motions])


def period_range(periods: Any) -> tuple[float, float]:
    """Two rising periods [s], numbers or text with a unit; raises RecordError for anything else."""
    if isinstance(periods, str) or not isinstance(periods, Sequence) or len(periods) != 2:
        raise RecordError(f"periods: {shown(periods)} is not a range; give two periods such as (0.2, 2.0)")
    low, high = (in_si("periods", period, PERIOD) for period in periods)
    if not low < high:
        raise RecordError(f"periods: {low:g} to {high:g} s is empty; write the shorter period first")
    return low, high


def _ratio(target: float, value: float, name: str) -> float:
    """The factor from a measured ``value`` to ``target``; raises RecordError for a value that no factor scales."""
    if not (isfinite(value) and value > 0.0):
        raise RecordError(f"{name}: what is to be scaled is {value:g}, which no factor scales; check record and window")
    return target / float(value)


def _geometric_mean(values: Any) -> float:
    return exp(sum(log(value) for value in values) / len(values))
