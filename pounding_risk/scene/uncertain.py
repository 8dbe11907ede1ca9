"""The numbers of a scene that nobody knows exactly, and the samples of them along which a scan runs.

Samples stand at points in the unit cube. Those of "sobol" and "random" are one sequence each: the points of fewer
samples are the first of more.
"""

from __future__ import annotations

import warnings
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from math import inf, log2, nextafter, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.scene.distributions import VALUE, WIDTH, Array, Continuous, Discrete, Distribution
from pounding_risk.scene.scene_axis import SAMPLE, SceneAxis
from pounding_risk.units import Quantity, exact, say

GIVEN = "given"  # the method of points that the scene gives
ALL, DRAWN = "all", "drawn"  # the motions of a sample: every one of the records, or one that is drawn with it
LEAST_CUT = 1e-6  # a cut of less than this is not reported
LEAST_LEFT = 1e-6  # a distribution with less probability than this between its ends lies outside; this has ten digits
LEAST_VARIANCE = 1e-12  # of a number, given the numbers before it; below it they determine the number
SOBOL, HYPERCUBE, RANDOM = "sobol", "latin hypercube", "random"
METHODS = (SOBOL, HYPERCUBE, RANDOM)
GROWING = (SOBOL, RANDOM)  # to which samples can be added
EDGE = 2.0**-53  # a point at 0 or 1, where a quantile may be infinite, stands this far inside


def points_of(method: str, samples: int, dimensions: int, seed: int) -> Array:
    """Independent points in the open unit cube, one row for each sample; the same for the same seed."""
    generator = np.random.default_rng(seed)
    if method == RANDOM:
        return inside(generator.random((samples, dimensions)))  # row by row, so that more samples only follow
    from scipy.stats import qmc  # takes longer to import than a scene takes to be read

    if method == HYPERCUBE:
        return inside(qmc.LatinHypercube(dimensions, seed=generator).random(samples))
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of samples that are no power of two, which `UncertainNumbers.notes` reports
        return inside(qmc.Sobol(dimensions, scramble=True, seed=generator).random(samples))


def inside(points: Array) -> Array:
    """The points with those at an end of [0, 1] just inside."""
    return np.clip(points, EDGE, 1.0 - EDGE)


def cholesky(matrix: Sequence[Sequence[float]]) -> list[list[float]] | None:
    """The lower factor L of a symmetric matrix L Lᵀ, by rows; None where it is not positive definite.

    Written out, so that its bits do not depend on a library.
    """
    factor = [[0.0] * len(matrix) for _ in matrix]
    for row, elements in enumerate(matrix):
        for column in range(row + 1):
            remainder = elements[column] - sum(factor[row][k] * factor[column][k] for k in range(column))
            if column < row:
                factor[row][column] = remainder / factor[column][column]
            elif remainder > LEAST_VARIANCE:
                factor[row][row] = sqrt(remainder)
            else:
                return None
    return factor


def correlated(points: Array, matrix: Sequence[Sequence[float]]) -> Array:
    """Points whose standard normals, number by number, have this positive definite correlation matrix.

    A Gaussian copula: a column that is correlated with none before it stays as it is.
    """
    from scipy.special import ndtr, ndtri

    factor = cholesky(matrix)
    assert factor is not None, "checked when the scene was read"
    joint = points.copy()
    normals = ndtri(points)
    for row, weights in enumerate(factor):
        if any(weights[:row]):
            # Column by column and no matrix product, whose bits depend on how many samples there are.
            total = normals[:, row] * weights[row]
            for column in range(row):
                total = total + normals[:, column] * weights[column]
            joint[:, row] = ndtr(total)
    return inside(joint)


class DrawnMotions(NamedTuple):
    """The one motion of each sample, by its place among the records and among the polarities of a scene."""

    records: NDArray[np.int64]
    polarities: NDArray[np.int64]


class Correlation(NamedTuple):
    """The correlation of the standard normals behind two numbers."""

    between: tuple[str, str]
    value: float


@dataclass(frozen=True)
class UncertainNumber:
    """A number of a scene, or several that have one value, and its distribution.

    Attributes
    ----------
    key : str
        Its address, as `--set` takes it.
    distribution : Distribution
        In SI, before it is cut.
    quantity : Quantity or None
        Unit and bounds of the number; None of discrete values, which are as a scene file has them.
    low, high : float
        Where the scene cuts it.
    """

    key: str
    distribution: Distribution
    quantity: Quantity | None
    low: float = -inf
    high: float = inf

    @property
    def ends(self) -> tuple[float, float]:
        """The range that the number may have, by its own bounds and by the scene."""
        if self.quantity is None:
            return -inf, inf
        return max(self.quantity.low, self.low), min(self.quantity.high, self.high)

    @property
    def left(self) -> float:
        """The probability of the distribution that lies between the ends."""
        return self._below(self.ends[1]) - self._below(self.ends[0])

    def _below(self, end: float) -> float:
        """The probability of less than one of the ends; those of discrete values are infinite."""
        if isinstance(self.distribution, Continuous) and abs(end) < inf:
            return self.distribution.below(end)
        return float(end > 0.0)

    def values(self, probability: Array) -> tuple[Any, ...]:
        """The values that are not reached with these probabilities, as a scene file has them.

        For a distribution that is cut these are the values of the part that is left.
        """
        if isinstance(self.distribution, Discrete):
            return tuple(self.distribution.values[place] for place in self.distribution.places(probability))
        assert isinstance(self.distribution, Continuous) and self.quantity is not None
        low, high = self.ends
        start = self._below(low)
        numbers = self.distribution.quantile(inside(start + self.left * probability))
        bounds = self.quantity
        if bounds.open_low and low == bounds.low:
            low = nextafter(low, inf)
        if bounds.open_high and high == bounds.high:
            high = nextafter(high, -inf)
        return tuple(exact(number, bounds) for number in np.clip(numbers, low, high).tolist())

    def words(self) -> str:
        """The distribution, such as "lognormal, median 1 s, dispersion 0.2", and where it is cut."""
        words = self.distribution.words(self._said)
        return f"{words}, {cut}" if (cut := self.cut_words()) else words

    def cut_words(self) -> str:
        """Where the distribution is cut, and how much that leaves out; "" where that is nothing."""
        left_out = 1.0 - self.left
        if left_out < LEAST_CUT:
            return ""
        cut_ends = [end for end in self.ends if 0.0 < self._below(end) < 1.0]
        return f"cut at {' and '.join(map(self._said, cut_ends))}, which leaves out {100.0 * left_out:.3g} % of it"

    def _said(self, number: float) -> str:
        return str(number) if self.quantity is None else say(number, self.quantity)

    def written(self) -> dict[str, Any]:
        """As a scene file has it."""
        cut_keys = {name: end for name, end in (("low", self.low), ("high", self.high)) if abs(end) < inf}
        kinds = self.distribution.takes
        parameters = self.distribution.keys() | cut_keys
        texts = {
            key: exact(parameter, self.quantity)
            for key, parameter in parameters.items()
            if self.quantity is not None and (key not in kinds or kinds[key].kind in (VALUE, WIDTH))
        }
        return {"distribution": self.distribution.name()} | parameters | texts


@dataclass(frozen=True)
class UncertainNumbers:
    """The uncertain numbers of a scene, and how they are drawn.

    Attributes
    ----------
    numbers : tuple of UncertainNumber
        Each with its key and its distribution.
    samples : int
        How many samples a scan has.
    method : str
        "sobol" (scrambled), "latin hypercube" or "random"; "given" of points that the scene gives.
    seed : int
        Of the points.
    correlations : tuple of Correlation
        Of the standard normals behind the numbers (a Gaussian copula): of lognormal numbers that of their logarithms.
        A discrete number takes its values in the order in which the scene has them.
    given : tuple of tuple of float
        The points that the scene gives, one for each sample.
    motions : str
        "all": every sample runs under every motion; "drawn": each under one, by a further coordinate of its point.
    """

    numbers: tuple[UncertainNumber, ...]
    samples: int
    method: str
    seed: int
    correlations: tuple[Correlation, ...] = ()
    given: tuple[tuple[float, ...], ...] = ()
    motions: str = ALL

    @property
    def keys(self) -> tuple[str, ...]:
        """The addresses of the numbers, as `--set` takes them."""
        return tuple(number.key for number in self.numbers)

    @property
    def is_drawn(self) -> bool:
        """True where each sample runs under one motion, which is drawn with it."""
        return self.motions == DRAWN

    @property
    def columns(self) -> int:
        """How many coordinates a point has: one for each number, and one for the motion where it is drawn."""
        return len(self.numbers) + self.is_drawn

    def points(self) -> Array:
        """The points (samples, columns) in the open unit cube at which samples are drawn, not yet correlated.

        The last column is that of the motion, where motions are drawn.
        """
        if self.given:
            return inside(np.array(self.given, dtype=float))
        return points_of(self.method, self.samples, self.columns, self.seed)

    def drawn_motions(self, records: int, polarities: int, points: Any = None) -> DrawnMotions:
        """The motion of each sample: every pair of record and polarity is as likely as any other.

        The pairs, polarity by polarity of each record, share the last coordinate of a point equally. So points of a
        design that is balanced along it draw every motion as often as any other, to within one or two.
        """
        cube = self.points() if points is None else inside(self._checked(points))
        pairs = records * polarities
        places = np.minimum((cube[:, -1] * pairs).astype(np.int64), pairs - 1)
        return DrawnMotions(places // polarities, places % polarities)

    def values_at(self, points: Any) -> tuple[tuple[Any, ...], ...]:
        """The values of each number at independent points of the unit cube, as a scene file has them.

        Parameters
        ----------
        points : array
            (samples, numbers), between 0 and 1; with a further column where motions are drawn.

        Raises
        ------
        PoundingError
            For points of another shape, or outside.
        """
        cube = inside(self._checked(points))[:, : len(self.numbers)]
        drawn = correlated(cube, self.matrix) if self.correlations else cube
        return tuple(number.values(drawn[:, column]) for column, number in enumerate(self.numbers))

    def _checked(self, points: Any) -> Array:
        """The points as an array; raises PoundingError for another shape, and outside the unit cube."""
        cube = np.asarray(points, dtype=float)
        if cube.ndim != 2 or cube.shape[1] != self.columns or not np.all((cube >= 0.0) & (cube <= 1.0)):
            raise PoundingError(
                f"points of shape {cube.shape}: they are (samples, {self.columns}), one column for each of "
                f"{', '.join([*self.keys, *['the drawn motion'] * self.is_drawn])}, and between 0 and 1"
            )
        return cube

    @cached_property
    def matrix(self) -> tuple[tuple[float, ...], ...]:
        """The correlation matrix of the standard normals behind the numbers."""
        matrix = np.eye(len(self.numbers))
        for correlation in self.correlations:
            row, column = map(self.keys.index, correlation.between)
            matrix[row, column] = matrix[column, row] = correlation.value
        return tuple(map(tuple, matrix.tolist()))

    @property
    def drawn(self) -> str:
        """How the samples are drawn, such as "sobol, seed 1"."""
        method_text = "at points that are given" if self.given else f"{self.method}, seed {self.seed}"
        return f"{method_text}, each under one motion that is drawn with it" if self.is_drawn else method_text

    @cached_property
    def axis(self) -> SceneAxis:
        """The dimension of a scan along which the samples lie."""
        return sample_axis(self)

    def with_points(self, points: Any) -> UncertainNumbers:
        """The same numbers at points that are given, such as those of another design; see `values_at`."""
        points_checked = tuple(map(tuple, self._checked(points).tolist()))
        return replace(self, samples=len(points_checked), method=GIVEN, seed=0, given=points_checked)

    def described(self) -> Iterator[tuple[str, str]]:
        """How many samples there are and how they are drawn, and each number with its distribution."""
        yield "samples", f"{self.samples}, {self.drawn}"
        yield from ((number.key, number.words()) for number in self.numbers)
        for correlation in self.correlations:
            yield "correlation", f"{correlation.value:g} of {' and '.join(correlation.between)} (Gaussian copula)"

    def attributes(self) -> dict[str, dict[str, str]]:
        """What a dataset says of its labels: how the samples are drawn, and the distribution of each number."""
        return {SAMPLE: {"drawn": self.drawn}} | {item.key: {"distribution": item.words()} for item in self.numbers}

    def notes(self) -> Iterator[str]:
        """Sentences on distributions that are cut, Sobol points out of balance, and a correlated hypercube."""
        for number in self.numbers:
            if cut := number.cut_words():
                yield f"{number.key}: {number.distribution.name()}, {cut}; the samples are of the rest"
        if self.method == HYPERCUBE and self.correlations:
            names = [key for index, key in enumerate(self.keys) if any(self.matrix[index][:index])]
            yield (
                f"a Latin hypercube stratifies numbers before they are correlated: {', '.join(names)} are spread as of "
                "random points"
            )
        if self.method == SOBOL and log2(self.samples) % 1.0:
            lower = 2 ** int(log2(self.samples))
            yield (
                f"{self.samples} samples are no power of two, for which alone Sobol points are balanced; {lower} or "
                f"{2 * lower} are better spread"
            )


def stated(uncertain: UncertainNumbers | None, axes: Sequence[SceneAxis]) -> tuple[str, ...]:
    """Sentences of a call that runs the scene itself, on its uncertain numbers and those along its axes."""
    sentences = []
    if uncertain is not None:
        sentences.append(f"the uncertain numbers are at the values that the scene states: {', '.join(uncertain.keys)}")
    if axis_keys := [key for axis in axes if axis.name != SAMPLE for key in axis.keys]:
        sentences.append(
            "the numbers along axes of the grid are at the values of the scene's own tables, or as without the key "
            f"where no table has it, and --set takes others: {', '.join(axis_keys)}"
        )
    return tuple(sentences)


def sample_axis(uncertain: UncertainNumbers, points: Any = None) -> SceneAxis:
    """The axis of a scan along which uncertain numbers have their values at points of a design.

    Parameters
    ----------
    uncertain : UncertainNumbers
        Those of a scene, ``scene.uncertain``.
    points : array, optional
        (samples, numbers), from 0 to 1 and independent; by default the scene's own.

    Returns
    -------
    SceneAxis
        The dimension ``sample``, along which all numbers move.

    Raises
    ------
    PoundingError
        For points of another shape, or outside.
    """
    labels = uncertain.values_at(uncertain.points() if points is None else points)
    return SceneAxis(uncertain.keys, labels, SAMPLE)
