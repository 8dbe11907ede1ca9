"""Fragility of a damage state from demands over its threshold, by stripes, incremental dynamic analysis or a cloud.

All three give the median θ and the dispersion β of P(reached | im) = Φ(ln(im/θ)/β):

- stripes: from which motions reach the state at each intensity (Baker 2015, as `fragility.fit`);
- ida: from the intensity at which each motion first reaches it, its capacity (Vamvatsikos and Cornell 2002). That of a
  motion which does not reach it at the highest level is above that level, and one which reaches it at the lowest is not
  above that; that of a demand which jumps lies anywhere between two levels. Maximum likelihood counts them as such
  (Tobin 1958, Olsen 1978; concave for intervals too, Burridge 1981);
- cloud: from the regression ln demand = a + b ln im + ε (Cornell et al. 2002, Jalayer 2003): θ is where the median
  demand is the threshold, exp(−a/b) with demands over the threshold, and β = σ/b. A collapse, which has no demand, has
  no place in it.

Standard errors hold for recordings whose motions are not independent (sandwich by recording). `drawn` fits many
weighted samples at once, for a bootstrap of recordings.
"""

from __future__ import annotations

from collections.abc import Callable
from math import nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.statistics import fragility as curves
from pounding_risk.statistics.fragility import ALONE, FLAT, Fit, Shown
from pounding_risk.statistics.proportions import numbered

Array = NDArray[np.float64]
Labels = NDArray[np.int64]

# Where a capacity is, of the tested levels; NONE where no run is known, BETWEEN where only two levels enclose it.
BELOW, KNOWN, ABOVE, NONE, BETWEEN = -1, 0, 1, 2, 3
MOST_STEPS, CLOSE = 60, 1e-10  # Newton steps, and the decrement of the likelihood at which they end
FULL_STEP = 0.25  # a decrement, by run, from which on steps are shortened
CELLS = 2e6  # of the arrays that many samples are fitted with at once
FEWEST, LINE = 3, 1e-6  # runs of a cloud, and the deviation below which they lie on one line


class Observed(NamedTuple):
    """Intensities and demands over the threshold of a state, (motions, levels), and the motions' recordings."""

    ims: Array
    ratios: Array  # NaN where a run failed, infinite where the building collapsed
    recordings: Labels  # (motions,) from 0 without gaps
    shown: Shown = curves.plain  # writes an intensity in a sentence
    jumps: bool = False  # the demand is no straight line between levels: it begins with a touch, or ends at a cap


class Capacities(NamedTuple):
    """The intensity at which each motion first reaches a state, and whether it is known."""

    reached_at: Array  # (motions,); of one that is not known the level next to it, NaN where no run is known
    status: NDArray[np.int8]  # BELOW, KNOWN, ABOVE, NONE or BETWEEN
    falls_back: NDArray[np.bool_]  # a higher level does not reach the state, though a lower one did
    below: Array  # the level below ``reached_at`` where the status is BETWEEN, else as it


def capacities(ims: Array, ratios: Array, jumps: bool = False) -> Capacities:
    """First crossings of the threshold, by straight lines between the levels of each motion.

    A demand that ``jumps`` is at no straight line: a contact force is 0 until the gap closes, and stays at F_E once the
    contact yields, where a line to a threshold of F_E would end at the upper level. Its first crossing lies between two
    levels, of which ``reached_at`` has the upper one. Levels whose run failed are left out. Nothing is said between the
    lowest level and an intensity of 0.

    >>> first = capacities(np.array([[1.0, 2.0, 3.0]]), np.array([[0.5, 0.9, 1.3]]))
    >>> float(first.reached_at[0].round(6)), int(first.status[0])
    (2.25, 0)
    """
    reached_at, status = np.full(len(ims), np.nan), np.full(len(ims), NONE, dtype=np.int8)
    falls_back, below = np.zeros(len(ims), dtype=bool), np.full(len(ims), np.nan)
    for motion, (all_ims, all_ratios) in enumerate(zip(ims, ratios, strict=True)):
        runs = np.flatnonzero(~np.isnan(all_ratios))
        runs = runs[np.argsort(all_ims[runs], kind="stable")]
        im, ratio = all_ims[runs], all_ratios[runs]
        is_reached = ratio >= 1.0
        if not runs.size:
            continue
        if not is_reached.any():
            reached_at[motion], status[motion] = im[-1], ABOVE
            continue
        first = int(is_reached.argmax())
        falls_back[motion] = not is_reached[first:].all()
        if first == 0:
            reached_at[motion], status[motion] = im[0], BELOW
            continue
        if jumps or np.isinf(ratio[first]):  # a line to a collapse has no crossing
            reached_at[motion], status[motion], below[motion] = im[first], BETWEEN, im[first - 1]
            continue
        share = (1.0 - ratio[first - 1]) / (ratio[first] - ratio[first - 1])
        reached_at[motion], status[motion] = im[first - 1] + share * (im[first] - im[first - 1]), KNOWN
    return Capacities(reached_at, status, falls_back, np.where(status == BETWEEN, below, reached_at))


# ------------------------------------------------------------------------------------------------ stripes


def fit_stripes(observed: Observed) -> Fit:
    """The fit to which runs reach the state, of all that did not fail."""
    is_known = ~np.isnan(observed.ratios)
    if not is_known.any():
        return Fit(fault="no run is known")
    labels = np.broadcast_to(observed.recordings[:, None], is_known.shape)[is_known]
    return curves.fit(observed.ims[is_known], observed.ratios[is_known] >= 1.0, numbered(labels), observed.shown)


def drawn_stripes(observed: Observed, weights: Array) -> Array:
    """ln θ and β of each weighted sample, (samples, 2), by Newton's steps for all at once; NaN where there is none."""
    from scipy.sparse import csr_matrix

    motion, level = np.nonzero(~np.isnan(observed.ratios))
    levels, columns = np.unique(observed.ims[motion, level], return_inverse=True)
    is_reached = (observed.ratios[motion, level] >= 1.0).astype(float)
    shape = (len(observed.ims), levels.size)
    runs = csr_matrix((np.ones(motion.size), (motion, columns)), shape)
    counts = csr_matrix((is_reached, (motion, columns)), shape)
    if levels.size < 2:
        return np.full((len(weights), 2), np.nan)
    logs = np.log(levels)
    middle, scale = float(logs.mean()), float(logs.std())
    fits = []
    for block in _sample_blocks(weights, levels.size):
        # (samples, intensities): runs at each intensity, and those that reach the state
        of_runs, of_counts = (np.asarray((table.T @ block.T).T) for table in (runs, counts))
        a, b = _probit((logs - middle) / scale, of_counts, of_runs - of_counts)
        is_curve = b > scale / FLAT
        b = np.where(is_curve, b, np.nan)
        fits.append(np.stack([middle - scale * a / b, scale / b], axis=1))
    return np.concatenate(fits)


def _probit(log_im: Array, hits: Array, misses: Array) -> tuple[Array, Array]:
    """Coefficients of P = Φ(a + b ln im) for counts (samples, im); NaN where the likelihood has no maximum."""
    a, b = np.zeros(len(hits)), np.zeros(len(hits))
    gain, total = np.full(len(hits), np.inf), (hits + misses).sum(axis=1)
    for _ in range(MOST_STEPS):
        line = a[:, None] + b[:, None] * log_im
        up, down = _mills_ratio(line), _mills_ratio(-line)
        score = hits * up - misses * down
        weight = hits * up * (up + line) + misses * down * (down - line)
        system = (weight.sum(axis=1), (weight * log_im).sum(axis=1), (weight * log_im * log_im).sum(axis=1))
        step, gain = _newton_step(system, (score.sum(axis=1), (score * log_im).sum(axis=1)), total)
        a, b = a + step[0], b + step[1]
        if (gain < CLOSE).all():
            break
    # Where all or none are hits there is no curve, and where hits and misses part the slope grows without end.
    highest_miss = np.where(misses > 0.0, log_im, -np.inf).max(axis=1)
    lowest_hit = np.where(hits > 0.0, log_im, np.inf).min(axis=1)
    is_parted = ~(gain < CLOSE) | (highest_miss <= lowest_hit)
    return np.where(is_parted, np.nan, a), np.where(is_parted, np.nan, b)


# ------------------------------------------------------------------------------------------------ capacities


def fit_ida(observed: Observed) -> Fit:
    """The fit to capacities, of which those beyond the levels, or only between two, are known as such."""
    enclosed, is_known = _enclosed_capacities(observed)
    labels = numbered(observed.recordings[is_known])
    fault = _capacity_fault(enclosed, observed, labels)
    if fault:
        return Fit(fault=fault)
    scaled, middle, scale = enclosed.scaled()
    (delta,), (gamma,) = _tobit(scaled, np.ones((1, labels.size)))
    if not np.isfinite(gamma):
        return Fit(fault="the capacities determine no curve; scan more levels")
    # ln θ and β from δ and γ, η = γ x − δ; the observed information goes with them, for the gradient is zero.
    jacobian = np.array([[scale / gamma, -scale * delta / gamma**2], [0.0, -scale / gamma**2]])
    slopes, (top, side, low) = _likelihood_slopes(scaled, np.array([delta]), np.array([gamma]))
    inverse = jacobian @ np.linalg.inv(np.array([[top.sum(), side.sum()], [side.sum(), low.sum()]]))
    root = inverse @ curves.by_recording(np.stack([slopes[0][0], slopes[1][0]], axis=1), labels)
    fitted = curves.fit_of(middle + scale * delta / gamma, scale / gamma, inverse @ jacobian.T, root)
    tested_ims = observed.ims[~np.isnan(observed.ratios)]
    return curves.fit_or_fault(fitted, _curve_fault(fitted, tested_ims, observed.shown))


class EnclosedCapacities(NamedTuple):
    """Logarithms of capacities between ``low`` and ``high``: alike where one is known, infinite beyond the levels."""

    low: Array
    high: Array

    @property
    def finite(self) -> Array:
        """One number for each: the middle, or the end that is finite."""
        ends = np.stack([self.low, self.high])
        return np.asarray(np.where(np.isfinite(ends), ends, 0.0).sum(axis=0) / np.isfinite(ends).sum(axis=0))

    def scaled(self) -> tuple[EnclosedCapacities, float, float]:
        """With a mean of 0 and a deviation of 1, which a fit takes, and the mean and deviation."""
        middle, scale = float(self.finite.mean()), float(self.finite.std())
        return EnclosedCapacities((self.low - middle) / scale, (self.high - middle) / scale), middle, scale

    @property
    def inner(self) -> NDArray[np.bool_]:
        """Those within the levels, whether known or between two."""
        return np.asarray(np.isfinite(self.low) & np.isfinite(self.high))

    @property
    def is_known(self) -> NDArray[np.bool_]:
        """Capacities that are known: both ends are one."""
        return np.asarray(self.low == self.high)


def _enclosed_capacities(observed: Observed) -> tuple[EnclosedCapacities, NDArray[np.bool_]]:
    """The ends between which the capacities lie, of the motions of which a run is known."""
    first = capacities(observed.ims, observed.ratios, observed.jumps)
    known = first.status != NONE
    status, high, low = first.status[known], np.log(first.reached_at[known]), np.log(first.below[known])
    return EnclosedCapacities(np.where(status == BELOW, -np.inf, low), np.where(status == ABOVE, np.inf, high)), known


def _capacity_fault(enclosed: EnclosedCapacities, observed: Observed, labels: Labels) -> str:
    """Sentence on why capacities give no curve; "" where they do."""
    if observed.ims.shape[1] < 2:
        return "each motion has one level: incremental dynamic analysis needs several; scan more, or take a cloud"
    if not labels.size:
        return "no run is known"
    if np.isinf(enclosed.high).all():
        return "no motion reaches the state at the levels that were tested: scan stronger motions"
    if np.isinf(enclosed.low).all():
        return "every motion reaches the state at its lowest level: scan weaker motions"
    if np.ptp(labels) == 0:
        return ALONE
    known_logs = enclosed.low[enclosed.is_known]
    if enclosed.inner.sum() < 2 or (known_logs.size and curves.of_one_intensity(np.exp(known_logs))):
        return "fewer than two motions reach the state between their levels: the dispersion is not known; scan more"
    if not known_logs.size and enclosed.low.max() <= enclosed.high.min():
        return "one intensity may be the capacity of every motion: the dispersion is not known; scan levels between"
    return ""


def drawn_ida(observed: Observed, weights: Array) -> Array:
    """As `drawn_stripes`, from the capacities."""
    enclosed, is_known = _enclosed_capacities(observed)
    if enclosed.inner.sum() < 2 or enclosed.finite.std() == 0.0:
        return np.full((len(weights), 2), np.nan)
    scaled, middle, scale = enclosed.scaled()
    fits = []
    for block in _sample_blocks(weights[:, is_known], enclosed.low.size):
        delta, gamma = _tobit(scaled, block)
        fits.append(np.stack([middle + scale * delta / gamma, scale / gamma], axis=1))
    return np.concatenate(fits)


def _tobit(enclosed: EnclosedCapacities, weights: Array) -> tuple[Array, Array]:
    """δ = μ/σ and γ = 1/σ of a normal x that is partly enclosed, by weighted sample; NaN without a maximum.

    In these the likelihood is concave (Olsen 1978, Burridge 1981): Σ w (ln γ − η²/2) of the known, and
    Σ w ln (Φ(η_high) − Φ(η_low)) of the others.
    """
    inner_weight, finite = weights[:, enclosed.inner].sum(axis=1), enclosed.finite
    total = weights.sum(axis=1)
    mean = weights @ finite / total
    deviation = np.sqrt(np.maximum(weights @ finite**2 / total - mean**2, 1e-12))
    gamma = 1.0 / deviation
    delta = mean * gamma
    gain = np.full(len(weights), np.inf)
    with np.errstate(all="ignore"):  # samples that have no maximum leave the range, which their gain shows
        for _ in range(MOST_STEPS):
            slopes, curvature = _likelihood_slopes(enclosed, delta, gamma)
            system = tuple((derivative * weights).sum(axis=1) for derivative in curvature)
            score = tuple((derivative * weights).sum(axis=1) for derivative in slopes)
            step, gain = _newton_step(system, score, total)
            factor = np.where(gamma + step[1] > 0.0, 1.0, 0.5 * gamma / np.abs(step[1]))
            delta, gamma = delta + factor * step[0], gamma + factor * step[1]
            if (gain < CLOSE).all():
                break
    # Without a known capacity the dispersion has no limit where one intensity may be the capacity of all.
    is_drawn = weights > 0.0
    lowest_high = np.where(is_drawn, enclosed.high, np.inf).min(axis=1)
    is_determined = np.where(is_drawn, enclosed.low, -np.inf).max(axis=1) > lowest_high
    is_determined |= (is_drawn & enclosed.is_known).any(axis=1)
    has_none = ~(gain < CLOSE) | (inner_weight <= 0.0) | (gamma > 1e6) | ~is_determined
    return np.where(has_none, np.nan, delta), np.where(has_none, np.nan, gamma)


def _likelihood_slopes(
    enclosed: EnclosedCapacities, delta: Array, gamma: Array
) -> tuple[tuple[Array, Array], tuple[Array, Array, Array]]:
    """Derivatives of the log-likelihood by δ and γ, and the second ones with their sign changed, (samples, motions).

    With p = φ(η_high)/D, q = φ(η_low)/D and D = Φ(η_high) − Φ(η_low) the first derivatives by η_high and η_low are p
    and −q, and the second with their sign changed p (η_high + p), q (q − η_low), and −p q across.
    """
    ends = [np.where(np.isfinite(end), end, 0.0) for end in (enclosed.high, enclosed.low)]
    up, down = ((gamma[:, None] * end - delta[:, None]) for end in ends)
    highest, lowest = (
        np.where(np.isfinite(enclosed.high), up, np.inf),
        np.where(np.isfinite(enclosed.low), down, -np.inf),
    )
    p, q = _densities_at_ends(highest, lowest)
    p, q = np.where(enclosed.is_known, -up, p), np.where(enclosed.is_known, 0.0, q)
    high, low = np.where(enclosed.is_known, 1.0, p * (up + p)), q * (q - down)
    across, of_known = -p * q, np.where(enclosed.is_known, 1.0 / gamma[:, None], 0.0)
    slopes = q - p, p * ends[0] - q * ends[1] + of_known
    top = high + 2.0 * across + low
    side = -(high * ends[0] + across * (ends[0] + ends[1]) + low * ends[1])
    bottom = high * ends[0] ** 2 + 2.0 * across * ends[0] * ends[1] + low * ends[1] ** 2 + of_known**2
    return slopes, (top, side, bottom)


def _densities_at_ends(up: Array, down: Array) -> tuple[Array, Array]:
    """φ(up)/D and φ(down)/D with D = Φ(up) − Φ(down), also far in a tail, where both are mirrored to the left one."""
    from scipy.special import log_ndtr

    is_right = down > 0.0
    far, near = log_ndtr(np.where(is_right, -down, up)), log_ndtr(np.where(is_right, -up, down))
    with np.errstate(all="ignore"):  # of known capacities, which have no interval
        log_d = far + np.log1p(-np.exp(near - far)) + 0.5 * np.log(2.0 * np.pi)
        return np.exp(-0.5 * up**2 - log_d), np.exp(-0.5 * down**2 - log_d)


# ------------------------------------------------------------------------------------------------ cloud


def fit_cloud(observed: Observed) -> Fit:
    """The fit of the regression of ln demand on ln im over all runs that did not fail."""
    is_known = ~np.isnan(observed.ratios)
    labels = numbered(np.broadcast_to(observed.recordings[:, None], is_known.shape)[is_known])
    with np.errstate(divide="ignore"):
        log_im, log_demand = np.log(observed.ims[is_known]), np.log(observed.ratios[is_known])
    fault = _cloud_fault(log_im, log_demand, labels)
    if fault:
        return Fit(fault=fault)
    moments = np.array([[product.sum() for product in _products(log_im, log_demand)]])
    a, b, sigma = _demand_regression(moments)[0].tolist()
    if b <= 0.0 or sigma >= FLAT * b:
        trend = "fall" if b <= 0.0 else "hardly grow"
        return Fit(fault=f"the demands {trend} with the intensity: this measure does not govern them")
    if sigma <= LINE:
        return Fit(fault="the demands lie on one line: they have no dispersion")
    residuals = log_demand - a - b * log_im
    scores = np.stack([residuals, residuals * log_im, residuals**2 / sigma - sigma], axis=1) / sigma**2
    count = float(log_im.size)
    _, of_im, _, of_im_im, *_ = moments[0]
    curvature = np.array([[count, of_im, 0.0], [of_im, of_im_im, 0.0], [0.0, 0.0, 2.0 * count]]) / sigma**2
    jacobian = np.array([[-1.0 / b, a / b**2, 0.0], [0.0, -sigma / b**2, 1.0 / b]])
    inverse = jacobian @ np.linalg.inv(curvature)
    fitted = curves.fit_of(-a / b, sigma / b, inverse @ jacobian.T, inverse @ curves.by_recording(scores, labels))
    ims = np.exp(log_im)
    return curves.fit_or_fault(fitted, _curve_fault(fitted, ims, observed.shown))


def _cloud_fault(log_im: Array, log_demand: Array, labels: Labels) -> str:
    """Sentence on why a cloud gives no curve; "" where it does."""
    if log_im.size < FEWEST:
        return f"{log_im.size} runs are known: a cloud needs {FEWEST} at least"
    zeros = int(np.isneginf(log_demand).sum())
    if zeros:
        return f"the demand is 0 in {zeros} of {log_demand.size} runs, which has no logarithm; take stripes"
    if collapsed := int(np.isposinf(log_demand).sum()):
        cause = "whose demand is not known; take stripes, which count them as reached"
        return f"the building collapses in {collapsed} of {log_demand.size} runs, {cause}"
    if np.ptp(labels) == 0:
        return ALONE
    if curves.of_one_intensity(np.exp(log_im)):
        return "all motions have one intensity: a cloud needs several; take the motions as recorded"
    return ""


def drawn_cloud(observed: Observed, weights: Array) -> Array:
    """As `drawn_stripes`, from the regression."""
    is_used = np.isfinite(observed.ratios) & (observed.ratios > 0.0)
    log_im = np.log(np.where(is_used, observed.ims, 1.0))
    log_demand = np.log(np.where(is_used, observed.ratios, 1.0))
    sums = np.stack([(product * is_used).sum(axis=1) for product in _products(log_im, log_demand)])
    a, b, sigma = _demand_regression(weights @ sums.T).T
    b = np.where((b > 0.0) & (sigma < FLAT * b) & (sigma > LINE), b, np.nan)
    return np.stack([-a / b, sigma / b], axis=1)


def _products(log_im: Array, log_demand: Array) -> tuple[Array, ...]:
    """What a regression takes the sums of: 1, both logarithms, their squares and their product between these."""
    return np.ones_like(log_im), log_im, log_demand, log_im * log_im, log_im * log_demand, log_demand * log_demand


def _demand_regression(moments: Array) -> Array:
    """a, b and σ (n − 2) of ln demand = a + b ln im, from rows of the sums of `_products`."""
    count, im, demand, im_im, im_demand, demand_demand = moments.T
    with np.errstate(all="ignore"):  # a sample of one intensity has no slope: NaN
        squares, products = im_im - im * im / count, im_demand - im * demand / count
        b = products / squares
        residual = demand_demand - demand * demand / count - b * products
        sigma = np.sqrt(np.maximum(residual, 0.0) / (count - 2.0))
        return np.stack([(demand - b * im) / count, b, sigma], axis=1)


# ------------------------------------------------------------------------------------------------ all methods


class Method(NamedTuple):
    """How a fragility follows from demands: for one sample with errors, and for many weighted ones."""

    words: str
    fit: Callable[[Observed], Fit]
    drawn: Callable[[Observed, Array], Array]


METHODS = {
    "stripes": Method("maximum likelihood of who reaches the state at each intensity", fit_stripes, drawn_stripes),
    "ida": Method("maximum likelihood of the intensity at which each motion first reaches it", fit_ida, drawn_ida),
    "cloud": Method("regression of the logarithms of demands on those of intensities", fit_cloud, drawn_cloud),
}


def bootstrap_weights(recordings: Labels, draws: int, seed: int) -> Array:
    """How often each motion is in each of so many samples of whole recordings, drawn with replacement."""
    groups = int(recordings.max(initial=-1)) + 1
    counts = np.random.default_rng(seed).multinomial(groups, np.full(groups, 1.0 / groups), size=draws)
    return np.asarray(counts[:, recordings], dtype=float)


def expanded_tail(confidence: float, count: int) -> float:
    """The share of the samples below the lower bound: Φ(−√(n/(n − 1)) t), t Student's quantile with n − 1 degrees.

    The plain share, half of 1 − ``confidence``, makes bounds from few recordings too narrow: a bootstrap takes the
    spread of n for that of all, and a normal tail for Student's (Hesterberg, The American Statistician 69 (2015)).

    >>> round(expanded_tail(0.95, 22), 4)
    0.0166
    """
    from scipy.special import ndtr, stdtrit

    if count < 2:
        return 0.5 * (1.0 - confidence)
    return float(ndtr(-np.sqrt(count / (count - 1.0)) * stdtrit(count - 1.0, 0.5 * (1.0 + confidence))))


def _curve_fault(fitted: Fit, tested: Array, shown: Shown) -> str:
    """Sentence on why a fit is refused; "" where it is not."""
    return curves.not_carried(fitted, tested, shown) or curves.outside(fitted.median, tested, shown)


def _sample_blocks(weights: Array, width: int) -> list[Array]:
    """The samples in parts whose arrays of so many columns are not too large."""
    return np.array_split(weights, max(1, int(np.ceil(len(weights) * width / CELLS))))


def _mills_ratio(line: Array) -> Array:
    """φ(η)/Φ(η), also far in the tail."""
    from scipy.special import log_ndtr

    return np.asarray(np.exp(-0.5 * line**2 - log_ndtr(line)) / np.sqrt(2.0 * np.pi))


def _newton_step(
    system: tuple[Array, Array, Array], score: tuple[Array, Array], total: Array
) -> tuple[tuple[Array, Array], Array]:
    """Newton's step of two unknowns for many samples, shortened where it is large, and its decrement.

    ``system`` holds the curvature's first diagonal element, the one beside it, and the second; ``total`` is the number
    of runs in each sample.
    """
    (top, side, low), (first, second) = system, score
    with np.errstate(all="ignore"):
        determinant = top * low - side * side
        first_step = (low * first - side * second) / determinant
        second_step = (top * second - side * first) / determinant
        gain = first_step * first + second_step * second
        size = np.maximum(gain, 0.0) / total
        factor = np.where(size > FULL_STEP, 1.0 / (1.0 + np.sqrt(size)), 1.0)
    gain = np.where(determinant > 0.0, gain, nan)
    return (first_step * factor, second_step * factor), gain
