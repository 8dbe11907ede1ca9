"""Records whose spectra have the mean and the standard deviation of a target: simulated spectra, then replacement.

After Baker and Lee (2018) and Jayaram, Lin and Baker (2011), in short: as many spectra as records are wanted are drawn
from the target's distribution of ln Sa, with the correlations between periods of Baker and Jayaram (2008), and have its
mean and deviation at each period exactly; each takes the unused candidate that is closest to it. Then each choice in
turn is replaced by the candidate that most reduces Σ (m − μ)² + (s − σ)² over the periods, m and s being the mean and
the standard deviation of ln Sa of the choices, until none does.

Where the target is conditioned on Sa at a period, every candidate is scaled to it there; elsewhere to its simulated
spectrum, by the factor of least squares in ln Sa.

References
----------
Baker and Jayaram (2008), Earthquake Spectra 24(1), 299-317. Jayaram, Lin and Baker (2011), Earthquake Spectra 27(3),
797-815. Baker and Lee (2018), Journal of Earthquake Engineering 22(6), 1031-1047.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Hashable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.motions.processing.signals import Samples

SEED = 20080301
PASSES = 20


class Aim(NamedTuple):
    """What the choices shall have at each period [s]: mean and deviation of ln Sa, and the period of conditioning."""

    periods: Samples
    mean: Samples
    deviation: Samples
    pivot: float | None


class Limits(NamedTuple):
    """Least and largest factor, and at most so many choices of one earthquake."""

    factors: tuple[float, float]
    per_event: int | None = None


class Choice(NamedTuple):
    """A candidate, by its position, and its factor."""

    position: int
    factor: float


def correlation(periods: Samples) -> Samples:
    """Correlation of ln Sa between periods [s] from 0.01 to 10 s (Baker and Jayaram 2008), shape (n, n)."""
    at = np.clip(np.asarray(periods, dtype=np.float64), 0.01, 10.0)
    low, high = np.minimum.outer(at, at), np.maximum.outer(at, at)
    first = 1.0 - np.cos(np.pi / 2.0 - 0.366 * np.log(high / np.maximum(low, 0.109)))
    fading = 1.0 - 1.0 / (1.0 + np.exp(np.minimum(100.0 * high - 5.0, 700.0)))
    second = np.where(high < 0.2, 1.0 - 0.105 * fading * (high - low) / (high - 0.0099), 0.0)
    third = np.where(high < 0.109, second, first)
    fourth = first + 0.5 * (np.sqrt(third) - third) * (1.0 + np.cos(np.pi * low / 0.109))
    among = np.where(high < 0.2, np.minimum(second, fourth), fourth)
    return np.asarray(np.where(high <= 0.109, second, np.where(low > 0.109, first, among)))


def simulated(aim: Aim, count: int) -> Samples:
    """Spectra of ln Sa with the mean and the deviation of an aim, exactly, shape (count, periods)."""
    periods = aim.periods if aim.pivot is None else np.append(aim.periods, aim.pivot)
    r = correlation(periods)
    if aim.pivot is not None:
        at_pivot = r[-1, :-1]
        left = np.sqrt(np.maximum(1.0 - at_pivot**2, 0.0))
        scale = np.outer(left, left)
        r = np.divide(r[:-1, :-1] - np.outer(at_pivot, at_pivot), scale, out=np.zeros_like(scale), where=scale > 1e-9)
    eigenvalues, vectors = np.linalg.eigh(r)
    drawn = np.random.default_rng(SEED).standard_normal((count, len(eigenvalues)))
    drawn = drawn @ (vectors * np.sqrt(np.maximum(eigenvalues, 0.0))).T
    drawn -= drawn.mean(axis=0)
    spread = drawn.std(axis=0, ddof=1)
    return aim.mean + aim.deviation * np.divide(drawn, spread, out=np.zeros_like(drawn), where=spread > 1e-12)


def match(
    logs: Samples, fixed: Samples | None, aim: Aim, count: int, limits: Limits, events: Sequence[Hashable]
) -> list[Choice]:
    """Choose candidates whose spectra together have the mean and the deviation of an aim.

    ``logs`` is ln Sa of the candidates before scaling, (candidates, periods), ``events`` the earthquake of each. Where
    the aim is conditioned at a period ``fixed`` has the logarithm of the factor of each, else None, and ``limits``
    bound it. ``count`` is two at least and no more than there are candidates; fewer are chosen where the limit on
    earthquakes leaves no more.
    """
    spectra = simulated(aim, count)
    chosen: list[int] = []
    factors: list[Samples] = []
    with np.errstate(divide="ignore"):
        low, high = np.log(limits.factors)
    for spectrum in spectra:
        # Logarithms of the factors of all candidates for this spectrum.
        factor = np.asarray(np.clip((spectrum - logs).mean(axis=1), low, high)) if fixed is None else fixed
        cost = ((logs + factor[:, None] - spectrum) ** 2).sum(axis=1)
        cost[~_allowed(chosen, events, limits)] = np.inf
        best = int(np.argmin(cost))
        if not np.isfinite(cost[best]):
            break
        chosen.append(best)
        factors.append(factor)
    _replace(logs, chosen, factors, aim, limits, events)
    return [Choice(one, float(np.exp(factor[one]))) for one, factor in zip(chosen, factors, strict=True)]


def _allowed(chosen: Sequence[int], events: Sequence[Hashable], limits: Limits) -> NDArray[np.bool_]:
    """Candidates that may still be chosen beside those that are."""
    counts = Counter(events[one] for one in chosen)
    full = {event for event, number in counts.items() if limits.per_event is not None and number >= limits.per_event}
    allowed = np.array([event not in full for event in events])
    allowed[list(chosen)] = False
    return allowed


def _replace(
    logs: Samples, chosen: list[int], factors: Sequence[Samples], aim: Aim, limits: Limits, events: Sequence[Hashable]
) -> None:
    """Replace choices, in place, by candidates that bring mean and deviation closer, until none does."""
    n = len(chosen)
    if n < 2:
        return
    for _ in range(PASSES):
        before = list(chosen)
        for place in range(n):
            others = [at for at in range(n) if at != place]
            rows = np.array([logs[chosen[at]] + factors[at][chosen[at]] for at in others])
            mine = logs + factors[place][:, None]
            mean = (rows.sum(axis=0) + mine) / n
            square = ((rows - rows.mean(axis=0)) ** 2).sum(axis=0) + (1.0 - 1.0 / n) * (mine - rows.mean(axis=0)) ** 2
            error = ((mean - aim.mean) ** 2 + (np.sqrt(square / (n - 1)) - aim.deviation) ** 2).sum(axis=1)
            error[~_allowed([chosen[at] for at in others], events, limits)] = np.inf
            best = int(np.argmin(error))
            if error[best] < error[chosen[place]] * (1.0 - 1e-12):
                chosen[place] = best
        if chosen == before:
            return
