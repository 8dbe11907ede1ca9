"""Distributions, their points and their correlation, against `scipy.stats` and closed forms."""

from math import asin, inf, pi, sqrt

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy import stats
from sentences import refusal

from pounding_risk.scene.distributions import KINDS, Discrete, Lognormal, Normal, Triangular, Uniform
from pounding_risk.scene.uncertain import (
    GROWING,
    METHODS,
    Correlation,
    UncertainNumber,
    UncertainNumbers,
    cholesky,
    points_of,
)
from pounding_risk.units import DAMPING, INITIAL_DISPLACEMENT, MASS, RESTITUTION

PAIRS = [
    (Normal(3.0, 0.5), stats.norm(3.0, 0.5)),
    (Lognormal(2.0, 0.4), stats.lognorm(0.4, scale=2.0)),
    (Uniform(1.0, 4.0), stats.uniform(1.0, 3.0)),
    (Triangular(1.0, 2.0, 5.0), stats.triang(0.25, 1.0, 4.0)),
    (Triangular(1.0, 1.0, 5.0), stats.triang(0.0, 1.0, 4.0)),
    (Triangular(1.0, 5.0, 5.0), stats.triang(1.0, 1.0, 4.0)),
]
SHARES = np.array([1e-9, 1e-3, 0.2, 0.25, 0.5, 0.9, 1.0 - 1e-9])


def number(distribution, quantity=INITIAL_DISPLACEMENT, low=-inf, high=inf):
    return UncertainNumber("building.frame.mass", distribution, quantity, low, high)


def in_si(values):
    return np.array([value if isinstance(value, float) else float(value.partition(" ")[0]) for value in values])


@pytest.mark.parametrize(("own", "scipys"), PAIRS)
def test_quantiles_and_probabilities_are_those_of_scipy(own, scipys):
    assert np.allclose(own.quantile(SHARES), scipys.ppf(SHARES), rtol=1e-12)
    for value in (0.5, 1.0, 1.7, 2.0, 3.0, 5.0, 7.0):
        assert own.below(value) == pytest.approx(scipys.cdf(value), rel=1e-12, abs=1e-15)
    assert set(KINDS) == {"normal", "lognormal", "uniform", "triangular", "discrete"}


def test_a_cut_distribution_is_what_is_left_of_it():
    """`scipy.stats.truncnorm` is the conditional distribution of a normal one, which bounds of the number cut too."""
    cut = number(Normal(0.05, 0.05), DAMPING, high=0.12)
    left = stats.truncnorm(-1.0, 1.4, 0.05, 0.05)
    assert np.allclose(in_si(cut.values(SHARES)), left.ppf(SHARES), rtol=1e-9)
    assert cut.left == pytest.approx(stats.norm.cdf(1.4) - stats.norm.cdf(-1.0), rel=1e-12)
    assert "cut at 0 and 0.12, which leaves out 23.9 % of it" in cut.words()
    assert number(Normal(8e5, 8e4), MASS).cut_words() == ""


@given(st.floats(-2.0, 2.0), st.floats(0.01, 3.0), st.floats(0.0, 1.0))
def test_every_value_is_one_that_the_number_may_have(mean, deviation, share):
    one = number(Normal(mean, deviation), RESTITUTION)
    if one.left > 1e-6:
        (value,) = in_si(one.values(np.array([share])))
        assert RESTITUTION.allows(value)


def test_discrete_values_have_their_weights():
    """Of evenly spread points each value takes its share exactly."""
    one = number(Discrete.of(values=["linear", "hertz", "jankowski"], weights=[1, 2, 5]), None)
    values = one.values((np.arange(800) + 0.5) / 800)
    assert [values.count(name) for name in ("linear", "hertz", "jankowski")] == [100, 200, 500]
    assert one.words() == "discrete, linear (12.5 %), hertz (25 %), jankowski (62.5 %)"


@pytest.mark.parametrize("method", METHODS)
def test_points_are_spread_and_follow_their_seed(method):
    """Means of 1024 independent points: six standard errors of 1/√(12 n); other methods are spread better."""
    points = points_of(method, 1024, 3, 7)
    assert np.all((points > 0.0) & (points < 1.0))
    assert np.array_equal(points, points_of(method, 1024, 3, 7))
    assert not np.array_equal(points, points_of(method, 1024, 3, 8))
    assert np.allclose(points.mean(axis=0), 0.5, atol=6.0 / sqrt(12 * 1024))
    if method != "random":  # one point in each of 1024 layers of every number
        assert all(len(set(np.floor(column * 1024))) == 1024 for column in points.T)


@pytest.mark.parametrize("method", GROWING)
def test_the_points_of_fewer_samples_are_the_first_of_more(method):
    more = points_of(method, 100, 5, 3)
    for fewer in (1, 8, 37):
        assert np.array_equal(points_of(method, fewer, 5, 3), more[:fewer])


def numbers(*correlations, samples=4096):
    kinds = (Lognormal(1.0, 0.5), Normal(5.0, 1.0), Uniform(0.0, 1.0), Lognormal(3.0, 0.2))
    drawn = tuple(UncertainNumber(key, kind, INITIAL_DISPLACEMENT) for key, kind in zip("abcd", kinds, strict=True))
    return UncertainNumbers(drawn, samples, "sobol", 1, tuple(Correlation(*one) for one in correlations))


def test_correlations_of_the_normals_are_reached():
    """Rank correlation 6/π asin(ρ/2), and ρ of logarithms; what is not named stays independent.

    The error of n = 4096 independent pairs would be 1/√n = 0.016; Sobol points stay within a third of it.
    """
    asked = [(("a", "b"), 0.7), (("c", "b"), -0.4), (("d", "a"), 0.3)]
    study = numbers(*asked)
    values = np.array([in_si(one) for one in study.values_at(study.points())])
    ranks = stats.spearmanr(values.T).statistic
    expected = np.eye(4)
    for (one, other), rho in asked:
        place = "abcd".index(one), "abcd".index(other)
        expected[place] = expected[place[::-1]] = 6.0 / pi * asin(rho / 2.0)
    assert np.allclose(ranks, expected, atol=0.005)
    assert np.corrcoef(np.log(values[0]), values[1])[0, 1] == pytest.approx(0.7, abs=0.005)


def test_correlated_values_do_not_depend_on_how_many_there_are():
    few, many = numbers((("a", "b"), 0.7), (("d", "b"), 0.2), samples=37), numbers((("a", "b"), 0.7), (("d", "b"), 0.2))
    assert few.values_at(few.points()) == tuple(one[:37] for one in many.values_at(many.points()))


def test_uncorrelated_numbers_keep_their_bits():
    free, tied = numbers(samples=64), numbers((("a", "b"), 0.7), samples=64)
    before, after = (one.values_at(one.points()) for one in (free, tied))
    assert [x == y for x, y in zip(before, after, strict=True)] == [True, False, True, True]


def test_a_matrix_that_no_numbers_have_is_found():
    bad = [[1.0, 0.9, -0.9], [0.9, 1.0, 0.9], [-0.9, 0.9, 1.0]]
    good = [[1.0, 0.5, 0.2], [0.5, 1.0, 0.1], [0.2, 0.1, 1.0]]
    assert cholesky(bad) is None and np.linalg.eigvalsh(bad)[0] < 0.0
    assert np.allclose(cholesky(good), np.linalg.cholesky(good), rtol=1e-15)


def test_points_of_another_shape_or_outside_are_refused(says):
    shapes = ([0.5] * 4, [[0.5] * 3], [[0.5, 0.5, 0.5, 1.5]], [[np.nan] * 4])
    says([refusal(numbers().values_at, points) for points in shapes])
