"""Largest closings of all pairs, and of chosen ones, against SciPy's matrix exponential and the solver of one pair."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.linalg import expm
from scipy.optimize import minimize_scalar
from scipy.signal import lsim

from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.intensity import response_spectra
from pounding_risk.motions.read import read_motion
from pounding_risk.solver.pair import closings, listed_closings
from pounding_risk.solver.pair.api import free_response, oscillators
from pounding_risk.solver.pair.closings import SLAB, TERMS, largest_closings
from pounding_risk.solver.pair.listed_closings import CHUNK, PairList

FINE = 100  # nodes of the witness in the shortest period


def noise(seed: int, n: int) -> np.ndarray:
    """A burst with a corner at every sample."""
    return np.random.default_rng(seed).standard_normal(n) * np.sin(np.pi * np.arange(n) / max(n - 1, 1))


def side(periods, damping: float = 0.05):
    periods = np.atleast_1d(np.asarray(periods, dtype=float))
    return periods, np.full(periods.size, damping)


def system(left, right) -> np.ndarray:
    """Matrix of u_L, u̇_L, u_R, u̇_R, a_g and its slope; a rigid building is a row of zeros."""
    matrix = np.zeros((6, 6))
    for at, (period, damping) in ((0, left), (2, right)):
        omega = 2.0 * np.pi / period
        matrix[at, at + 1], matrix[at + 1, at], matrix[at + 1, at + 1] = 1.0, -(omega**2), -2.0 * damping * omega
        matrix[at + 1, 4] = -1.0
    matrix[4, 5] = 1.0
    return matrix


def true_closings(ground, dt, left, right) -> tuple[float, float]:
    """Largest u_L - u_R and u_R - u_L of one pair: by matrix exponentials at fine nodes, and between the highest."""
    parts = int(np.ceil(FINE * dt / min(left[0], right[0])))
    matrix, h = system(left, right), dt / parts
    fine = np.interp(np.arange((ground.size - 1) * parts + 1) / parts, np.arange(ground.size), ground)
    motion = matrix[:4, :4], matrix[:4, 4:5], np.eye(4), np.zeros((4, 1))
    states = lsim(motion, fine, np.arange(fine.size) * h)[1]
    found = []
    for sign in (1.0, -1.0):
        d = sign * (states[:, 0] - states[:, 2])
        best = max(float(d.max()), 0.0)
        for node in np.argsort(-d)[:6]:
            for first in (node - 1, node):
                if not 0 <= first < fine.size - 1:
                    continue
                start = np.append(states[first], [fine[first], (fine[first + 1] - fine[first]) / h])

                def opening(x, start=start, sign=sign):
                    state = expm(matrix * x) @ start
                    return -sign * (state[0] - state[2])

                best = max(
                    best, -minimize_scalar(opening, bounds=(0.0, h), method="bounded", options={"xatol": 1e-9}).fun
                )
        found.append(best)
    return found[0], found[1]


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 10**6),
    n=st.sampled_from([2, 3, SLAB // 4, SLAB + 1, 300]),
    dt=st.sampled_from([0.005, 0.02]),
    left=st.tuples(st.floats(0.05, 2.0), st.floats(0.0, 0.9)),
    right=st.tuples(st.floats(0.05, 2.0), st.floats(0.0, 0.9)),
)
def test_closings_are_those_of_matrix_exponentials(seed, n, dt, left, right):
    ground = noise(seed, n) + 0.1  # it ends and begins with a jump
    found = largest_closings(ground, dt, side(*left), side(*right))
    size = max(float(found.left[0]), float(found.right[0]))
    truth = true_closings(ground, dt, left, right)
    np.testing.assert_allclose(found.closing[:, 0, 0], truth, rtol=0.0, atol=1e-10 * size)


def test_the_solver_of_one_pair_agrees():
    motion = read_motion("RSN6-180", window=("0 s", "12 s"))
    periods, others = np.geomspace(0.07, 3.0, 9), np.geomspace(0.1, 2.0, 7)
    found = largest_closings(motion.acceleration, motion.dt, side(periods, 0.03), side(others, 0.08))
    for row, left in enumerate(periods):
        for column, right in enumerate(others):
            pair = oscillators(Building("left", 1.0, left, 0.03), Building("right", 1.0, right, 0.08))
            free = free_response(pair, motion.acceleration, motion.dt)
            alone = free.high[:, 0].max(), -free.low[:, 0].min()
            np.testing.assert_allclose(found.closing[:, row, column], alone, rtol=1e-11)


def test_peaks_are_spectral_displacements():
    motion = read_motion("RSN1690-090", window=("0 s", "15 s"))
    periods = np.geomspace(0.05, 4.0, 30)
    found = largest_closings(motion.acceleration, motion.dt, side(periods), side(periods, 0.2))
    for peaks, damping in ((found.left, 0.05), (found.right, 0.2)):
        spectrum = response_spectra(motion.acceleration, motion.dt, periods, damping).displacement
        np.testing.assert_allclose(peaks, spectrum, rtol=4e-6)  # the local maxima of spectra are found to so much


def test_equal_sides_are_antisymmetric_and_the_diagonal_is_still():
    ground, periods = noise(3, 700), np.geomspace(0.1, 2.0, 12)
    alike = largest_closings(ground, 0.01, side(periods), side(periods))
    np.testing.assert_array_equal(alike.closing[1], alike.closing[0].T)
    np.testing.assert_array_equal(np.diagonal(alike.closing, axis1=1, axis2=2), 0.0)
    np.testing.assert_array_equal(alike.left, alike.right)
    # The other branch, in which both sides are followed for themselves.
    turned = largest_closings(ground, 0.01, side(periods), side(periods[::-1]))
    np.testing.assert_allclose(turned.closing[:, :, ::-1], alike.closing, rtol=1e-11, atol=1e-15)


def test_a_reversed_or_scaled_motion_changes_nothing_else():
    ground, (left, right) = noise(4, 500), (side([0.2, 0.9], 0.02), side([0.3, 0.5, 1.4], 0.07))
    found = largest_closings(ground, 0.01, left, right)
    np.testing.assert_array_equal(largest_closings(-ground, 0.01, left, right).closing, found.closing[::-1])
    np.testing.assert_array_equal(largest_closings(4.0 * ground, 0.01, left, right).closing, 4.0 * found.closing)
    exchanged = largest_closings(ground, 0.01, right, left).closing
    np.testing.assert_allclose(exchanged, found.closing[::-1].transpose(0, 2, 1), rtol=1e-12)


def test_no_order_of_the_slabs_changes_the_closings(monkeypatch):
    ground, periods = noise(5, 3 * SLAB), np.geomspace(0.1, 1.0, 8)
    found = largest_closings(ground, 0.01, side(periods), side(periods, 0.1)).closing
    for order in (
        lambda strengths: np.arange(len(strengths)),
        lambda strengths: np.arange(len(strengths))[::-1].copy(),
    ):
        monkeypatch.setattr(closings, "strongest_first", order)
        again = largest_closings(ground, 0.01, side(periods), side(periods, 0.1)).closing
        np.testing.assert_allclose(again, found, rtol=1e-11)


def test_still_ground_closes_nothing():
    found = largest_closings(np.zeros(300), 0.01, side([0.1, 1.0]), side([0.5], 0.1))
    assert not found.closing.any() and not found.left.any() and not found.right.any()


SERIES = st.lists(st.integers(-1000, 1000), min_size=TERMS, max_size=TERMS)


@settings(max_examples=200, deadline=None)
@given(values=SERIES, shrink=st.floats(0.05, 1.0), best=st.floats(-2.0, 2.0))
def test_the_crest_of_a_series_is_found(values, shrink, best):
    """Against the best of many points and of a search around each of the highest, for series of every shape."""
    terms = 1e-3 * np.array(values) * shrink ** np.arange(TERMS)
    polynomial = np.polynomial.Polynomial(terms)
    points = np.linspace(0.0, 1.0, 501)
    heights = polynomial(points)
    truth = max(best, float(heights.max()))
    for place in np.argsort(-heights)[:5]:
        bounds = points[max(place - 1, 0)], points[min(place + 1, 500)]
        searched = minimize_scalar(lambda x: -polynomial(x), bounds=bounds, method="bounded", options={"xatol": 1e-9})
        truth = max(truth, -searched.fun)
    bend = float(np.abs(terms[2:] * np.arange(2, TERMS) * np.arange(1, TERMS - 1)).sum())
    tolerance = 1e-12 * (10.0 + bend)
    assert abs(closings.maximum_of(terms, best) - truth) < tolerance
    assert abs(closings.bisected(terms, bend, best) - truth) < tolerance


def drawn(count: int, seed: int = 1):
    """Periods and dampings of so many pairs, about 0.5 s beside 1 s."""
    random = np.random.default_rng(seed).standard_normal((4, count))
    periods, dampings = np.exp(0.3 * random[:2]), 0.05 * np.exp(0.4 * random[2:])
    return (0.5 * periods[0], dampings[0]), (periods[1], dampings[1])


def taken(sides, where):
    return tuple(tuple(values[where] for values in side) for side in sides)


def assert_same_bits(one, other):
    for mine, its in zip(one, other, strict=True):
        np.testing.assert_array_equal(mine, its)


@pytest.mark.parametrize("n", [2, SLAB // 4, SLAB + 1, 700])
def test_pairs_are_those_of_the_product_of_both_sides(n):
    """Bit for bit where nodes are of one width; in other nodes nearly. The product is that of matrix exponentials."""
    ground, (left, right) = noise(2, n) + 0.1, drawn(9)  # it ends and begins with a jump
    product = largest_closings(ground, 0.005, left, right)
    found = PairList(left, right).closings(ground, 0.005)
    np.testing.assert_array_equal(found.closing, np.diagonal(product.closing, axis1=1, axis2=2))
    np.testing.assert_array_equal([found.left, found.right], [product.left, product.right])
    finer = largest_closings(
        ground, 0.005, *(tuple(np.append(values, 0.04) for values in side) for side in (left, right))
    )
    np.testing.assert_allclose(found.closing, np.diagonal(finer.closing, axis1=1, axis2=2)[:, :-1], rtol=1e-11)


def test_no_other_pair_changes_the_bits_of_one(monkeypatch):
    """Whatever their order, their number, the chunks that hold them, and how stiff another one is."""
    count = CHUNK + 5
    ground, sides = noise(3, 400), drawn(count)
    whole = PairList(*sides).closings(ground, 0.01)
    order = np.random.default_rng(2).permutation(count)
    shuffled = PairList(*taken(sides, order)).closings(ground, 0.01)
    assert_same_bits((whole.closing[:, order], whole.left[order], whole.right[order]), shuffled)
    stiff = tuple(tuple(np.append(values[:3], 0.011) for values in side) for side in sides)
    beside = PairList(*stiff).closings(ground, 0.01)
    assert_same_bits((whole.closing[:, :3], whole.left[:3], whole.right[:3]), (part[..., :3] for part in beside))
    monkeypatch.setattr(listed_closings, "CHUNK", 3)
    assert_same_bits(whole, PairList(*sides).closings(ground, 0.01))


def test_oscillators_and_pairs_that_are_equal_are_followed_once():
    (periods, dampings), right = drawn(10)
    same = np.full(10, periods[0]), np.full(10, dampings[0])
    pairs = PairList(tuple(np.tile(values, 3) for values in same), tuple(np.tile(values, 3) for values in right))
    (batch,) = pairs.batches(0.005)
    assert len(batch.pairs) == 10 + 11  # the pairs, and each oscillator alone
    assert batch.oscillators[0].size == 1 + 11  # with the ground
    found = pairs.closings(noise(4, 300), 0.005)
    assert np.unique(found.left).size == 1
    np.testing.assert_array_equal(found.closing[:, :10], found.closing[:, 20:])


def test_nodes_are_no_finer_than_each_pair_needs():
    periods = np.array([0.02, 0.2, 2.0])
    batches = PairList(side(periods), side(np.full(3, 2.0))).batches(0.01)
    assert [(batch.parts, len(batch.pairs)) for batch in batches] == [(1, 1 + 1), (2, 1 + 1), (16, 1 + 1)]


def test_a_rigid_neighbour_leaves_the_motion_of_the_other():
    ground, (left, right) = noise(5, 600), drawn(6)
    walls = np.zeros(6), np.zeros(6)
    found, turned = PairList(left, walls).closings(ground, 0.01), PairList(walls, left).closings(ground, 0.01)
    np.testing.assert_array_equal(found.closing.max(axis=0), found.left)
    np.testing.assert_array_equal(turned.closing, found.closing[::-1])
    assert not found.right.any()
    assert not any(part.any() for part in PairList(walls, walls).closings(ground, 0.01))
    np.testing.assert_array_equal(found.left, PairList(left, right).closings(ground, 0.01).left)


def test_limits_of_very_short_and_very_long_periods():
    """A stiff mass has u = -a_g / w² and hardly moves; a soft one stays where it is, u = -x_g."""
    dt, count = 0.01, 400
    ground = np.sin(np.pi * np.arange(count + 1) / count)  # a push without end, of which x_g is known
    stiff, soft = 0.002, 1e5
    found = PairList(side([stiff, soft], 0.3), side([soft, 0.0], 0.0)).closings(ground, dt)
    x = np.pi / (count * dt)
    travelled = (count * dt) / x - np.sin(x * count * dt) / x**2
    np.testing.assert_allclose(found.left, [(stiff / (2.0 * np.pi)) ** 2, travelled], rtol=1e-4)
    np.testing.assert_allclose(found.closing[0], [travelled, 0.0], rtol=1e-4, atol=1e-12)
    np.testing.assert_allclose(found.closing[1], [0.0, travelled], rtol=1e-4, atol=1e-12)
