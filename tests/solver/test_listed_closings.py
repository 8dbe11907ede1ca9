"""Largest closings of chosen pairs against the product of both sides, and limits."""

from __future__ import annotations

import numpy as np
import pytest
from test_closings import noise, side

from pounding_risk.solver.pair import listed_closings
from pounding_risk.solver.pair.closings import SLAB, largest_closings
from pounding_risk.solver.pair.listed_closings import CHUNK, PairList


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
