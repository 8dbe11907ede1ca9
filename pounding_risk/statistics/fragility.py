"""Lognormal fragility by maximum likelihood: P(failure | im) = Φ(ln(im/θ)/β), θ the median, β the dispersion.

Each motion is observed at its own intensity, or many stand at the same few intensities (multiple stripes); the
likelihood is the same, that of Baker, Earthquake Spectra 31 (2015). Of contact between linear buildings more is
known: a motion closes the gap once scaled by gap over closing, so that the curve is that of these intensities.

A curve that the motions do not determine is refused with a sentence, and no annual rate follows from it: a curve from
one intensity, one whose dispersion does not differ from zero by its own error, and one whose median lies outside the
intensities of the motions.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import nan

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Labels = NDArray[np.int64]
Shown = Callable[[float, int], str]  # an intensity in so many digits, as the sentence of a refusal writes it

STEPS, CLOSE = 100, 1e-10  # Newton steps at most, and the decrement of the likelihood at which they end
FLAT = 5.0  # a dispersion beyond which a curve says nothing: 16 to 84 % are then a factor of 22,000 apart
# Intensities that differ by less than this share are one. Scaling leaves them 1e-9 apart, the solver's tolerance and a
# spectrum read between its periods up to 1e-3, and none of that is shaking of another strength.
ALIKE = 1e-3
# A dispersion is carried by the motions where it is more than so many of its own standard errors: 95 % one-sided, by
# Wald's test that failures grow with the intensity. The error is as large where they almost part at one intensity.
CARRIED = 1.645
ALONE = "one recording has no dispersion between recordings: give more records"


def plain(im: float, digits: int) -> str:
    """An intensity as a number without a unit."""
    return f"{im:.{digits}g}"


@dataclass(frozen=True)
class Stripe:
    """Number of motions at one intensity [SI], and how many of them fail."""

    im: float
    count: int
    runs: int


@dataclass(frozen=True)
class Fit:
    """Median and dispersion with standard errors; ``fault`` is the sentence that says why there are none (NaN).

    ``se_median`` is that of ln θ, a share of the median; ``se_dispersion`` that of β. Both are from the observed
    information, as if motions were independent; those ``_recordings`` hold for recordings whose motions are not (the
    sandwich of Huber and White, by recording). ``correlation`` is that of the estimates of ln θ and β, by recording, of
    which there are ``recordings``.
    """

    median: float = nan
    dispersion: float = nan
    se_median: float = nan
    se_dispersion: float = nan
    se_median_recordings: float = nan
    se_dispersion_recordings: float = nan
    correlation: float = nan
    fault: str = ""
    recordings: int = 0

    @property
    def errors(self) -> tuple[float, float]:
        """The larger standard error of ln θ and of β: few recordings show too little of how alike they are."""
        return (max(self.se_median, self.se_median_recordings), max(self.se_dispersion, self.se_dispersion_recordings))


def fragility_curve(im: Array, median: Array | float, dispersion: Array | float) -> Array:
    """Probability of failure at an intensity, Φ(ln(im/θ)/β), θ the median and β the dispersion.

    >>> float(fragility_curve(np.array(2.0), 2.0, 0.4))
    0.5
    """
    from scipy.special import ndtr

    return np.asarray(ndtr(np.log(np.asarray(im) / median) / dispersion))


def stripes_of(im: Array, failed: NDArray[np.bool_]) -> tuple[Stripe, ...]:
    """The motions counted by intensity, in rising order; those `of_one_intensity` are one stripe at their median."""
    if of_one_intensity(im):
        return (Stripe(float(np.median(im)), int(failed.sum()), int(failed.size)),)
    levels, places = np.unique(im, return_inverse=True)
    runs, counts = np.bincount(places), np.bincount(places, failed)
    return tuple(Stripe(float(a), int(k), int(n)) for a, k, n in zip(levels, counts, runs, strict=True))


def fit(im: Array, failed: NDArray[np.bool_], recordings: Labels, shown: Shown = plain) -> Fit:
    """Median and dispersion by maximum likelihood from failures and their intensities.

    In ln im this is a probit regression, whose likelihood is concave: Newton's steps find its one maximum. It has none
    where all motions have one intensity, where the failures are all or none, or no survivor is stronger than one of
    them; a curve that is flat or falls with intensity is no fragility, and neither is one whose dispersion its error
    does not tell from none or whose median lies outside the intensities. All are the `Fit`'s ``fault``.

    Intensities [SI], failures and numbers from 0 of the recordings are by run; ``shown`` writes an intensity.
    """
    fault = unfit(im, failed, shown) or (ALONE if np.ptp(recordings) == 0 else "")
    if fault:
        return Fit(fault=fault)
    logs = np.log(im)
    middle, scale = float(logs.mean()), float(logs.std())
    design = np.stack([np.ones_like(logs), (logs - middle) / scale], axis=1)
    (a, b), curvature, scores = _probit(design, np.where(failed, 1.0, -1.0))
    if b <= scale / FLAT:
        trend = "become rarer" if b <= 0.0 else "hardly become more frequent"
        return Fit(fault=f"failures {trend} as the intensity grows: this measure does not govern them")
    # ln θ and β from a + b x; the observed information goes with them, for the gradient is zero.
    jacobian = np.array([[-scale / b, scale * a / b**2], [0.0, -scale / b**2]])
    inverse = jacobian @ np.linalg.inv(curvature)
    fitted = fit_of(middle - scale * a / b, scale / b, inverse @ jacobian.T, inverse @ by_recording(scores, recordings))
    return fit_or_fault(fitted, not_carried(fitted, im, shown) or outside(fitted.median, im, shown))


def fit_capacities(capacities: Array, recordings: Labels) -> Fit:
    """Median and dispersion of the intensities at which the motions fail, all of them known.

    θ = exp(mean ln), β the deviation (1/n, maximum likelihood); standard errors β/√n and β/√(2n).
    """
    if not (capacities.min() > 0.0 and np.isfinite(capacities).all()):
        return Fit(
            fault="a closed gap is touched by the weakest motion, and a motion that closes nothing never does it"
        )
    if np.ptp(recordings) == 0:
        return Fit(fault=ALONE)
    logs = np.log(capacities)
    if of_one_intensity(capacities):
        return Fit(fault="motions that all fail at one intensity have no dispersion; give more records")
    middle, spread = float(logs.mean()), float(logs.std())
    z = (logs - middle) / spread
    scores = np.stack([z, z**2 - 1.0], axis=1) / spread
    inverse = np.diag([spread**2, 0.5 * spread**2]) / logs.size
    return fit_of(middle, spread, inverse, inverse @ by_recording(scores, recordings))


def unfit(im: Array, failed: NDArray[np.bool_], shown: Shown = plain) -> str:
    """Sentence on why no curve can be fitted; "" where one can."""
    if of_one_intensity(im):
        intensity = shown(float(np.median(im)), 4)
        repair = "scan the motions as recorded, or at several values of grid.pga or levels of records.intensity"
        return f"all motions have one intensity, {intensity}: a curve needs several; {repair}"
    count = int(failed.sum())
    if count in (0, failed.size):
        reach = "all" if count else "none"
        return f"{reach} of the {failed.size} runs reach it: a curve needs some that do and some that do not"
    if im[~failed].max() <= im[failed].min():
        return "no run that does not reach it is at a higher intensity than one that does: the dispersion may be 0"
    return ""


def of_one_intensity(im: Array) -> bool:
    """True where intensities differ by no more than scaling and solving leave them apart (`ALIKE`)."""
    return bool(np.ptp(im) <= ALIKE * im.max(initial=0.0))


def not_carried(fitted: Fit, im: Array, shown: Shown = plain) -> str:
    """Sentence on why the motions do not determine the fitted dispersion; "" where they do."""
    error = fitted.errors[1]
    if error * CARRIED < fitted.dispersion:
        return ""
    return (
        f"so few motions, between {_span(im, shown)}, carry no dispersion: it would be {fitted.dispersion:.2g} "
        f"with a standard error of {error:.2g}; scan more records, or amplitudes further apart"
    )


def outside(median: float, im: Array, shown: Shown = plain) -> str:
    """Sentence on why a median outside the tested intensities is refused; "" where it lies among them."""
    if im.min() <= median <= im.max():
        return ""
    side, repair = ("above", "stronger") if median > im.max() else ("below", "weaker")
    return (
        f"the median of the fit, {shown(median, 3)}, lies {side} the intensities that were tested, "
        f"between {_span(im, shown)}: scan {repair} motions"
    )


def _span(im: Array, shown: Shown) -> str:
    """Lowest and highest intensity, in words."""
    return f"{shown(float(im.min()), 3)} and {shown(float(im.max()), 3)}"


def fit_or_fault(fitted: Fit, fault: str) -> Fit:
    """The fit, or an empty one that carries the fault where there is one."""
    return Fit(fault=fault) if fault else fitted


def _probit(design: Array, sign: Array) -> tuple[Array, Array, Array]:
    """Coefficients of P = Φ(x b), observed information, and scores by motion; ``sign`` is 1 or −1."""
    from scipy.special import log_ndtr

    coefficients = np.zeros(design.shape[1])
    best = float(log_ndtr(sign * (design @ coefficients)).sum())
    for _ in range(STEPS):
        scores, curvature = _slopes(design, sign, coefficients)
        step = np.linalg.solve(curvature, scores.sum(axis=0))
        gain = float(scores.sum(axis=0) @ step)
        size = 1.0
        while (new := float(log_ndtr(sign * (design @ (coefficients + size * step))).sum())) < best and size > 1e-9:
            size *= 0.5
        coefficients, best = coefficients + size * step, new
        if gain < CLOSE:
            break
    scores, curvature = _slopes(design, sign, coefficients)
    return coefficients, curvature, scores


def _slopes(design: Array, sign: Array, coefficients: Array) -> tuple[Array, Array]:
    """Scores by motion, and the observed information of all: λ x and Σ λ(λ + η) x xᵀ, λ = ±φ(η)/Φ(±η)."""
    from scipy.special import log_ndtr

    line = design @ coefficients
    ratio = sign * np.exp(-0.5 * line**2 - log_ndtr(sign * line)) / np.sqrt(2.0 * np.pi)
    weights = ratio * (ratio + line)
    return ratio[:, None] * design, (design * weights[:, None]).T @ design


def by_recording(scores: Array, recordings: Labels) -> Array:
    """R/(R − 1) Σ g gᵀ over recordings, g the sum of a recording's scores, as its root: (parameters, recordings)."""
    sums = np.stack([np.bincount(recordings, column) for column in scores.T])
    groups = sums.shape[1]
    return sums * np.sqrt(groups / (groups - 1.0))


def fit_of(log_median: float, dispersion: float, covariance: Array, root: Array) -> Fit:
    """A fit from its two estimates, their covariance, and the root of that by recording."""
    errors = np.sqrt(np.diag(covariance))
    by_cluster = root @ root.T
    recording_errors = np.sqrt(np.diag(by_cluster))
    return Fit(
        median=float(np.exp(log_median)),
        dispersion=float(dispersion),
        se_median=float(errors[0]),
        se_dispersion=float(errors[1]),
        se_median_recordings=float(recording_errors[0]),
        se_dispersion_recordings=float(recording_errors[1]),
        correlation=float(by_cluster[0, 1] / recording_errors.prod()) if recording_errors.prod() > 0.0 else nan,
        recordings=root.shape[1],
    )
