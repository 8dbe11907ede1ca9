"""Cases of a row in parts against the whole row at once: nothing changes, and nothing is solved twice."""

from itertools import pairwise
from math import inf

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from row_cases import LEVELS, cases_of
from row_cases import limits_of as limits

from pounding_risk.models.contact.laws import Linear, ViscousElastoplastic
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import Point, automatic_points
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.read import read_motion
from pounding_risk.solver.counters import COMPLETE, COUNT, DEMAND, ENERGY, FIRST_YIELD, RESIDUAL, STEPS, YIELDS
from pounding_risk.solver.row.api import HIGHEST
from pounding_risk.solver.row.cases import Cases
from pounding_risk.solver.row.model import RowModel

LAW = ViscousElastoplastic(2.75e9)


@pytest.fixture(scope="module")
def motion():
    """Five seconds with the strongest shaking of El Centro 1940, at 0.5 g."""
    found = read_motion("RSN6-180", window=(0.5, 5.5)).scaled_to("0.5 g")
    return found.acceleration, found.dt


def frame(name: str, storeys: int, stiffness: float) -> Storeys:
    return Storeys(name, (200e3,) * storeys, (stiffness,) * storeys, (3.0,) * storeys)


def row(*buildings) -> RowModel:
    points = [
        Point(place, *meeting)
        for place in range(len(buildings) - 1)
        for meeting in automatic_points(buildings[place], buildings[place + 1])
    ]
    return RowModel([chain_of(building) for building in buildings], points)


def cases(model: RowModel, motion, law=LAW) -> Cases:
    return cases_of(model, law, motion, constant(0.65))


def same(one, other):
    """Array-equal but for the ledgers of steps and energy, which are those of the parts that were solved together."""
    kept = [column for column in range(one.points.shape[1]) if column not in (STEPS, ENERGY, RESIDUAL)]
    assert np.array_equal(one.points[:, kept], other.points[:, kept], equal_nan=True)
    assert np.array_equal(one.floors, other.floors)
    assert np.array_equal(one.rest, other.rest)
    assert one.status == other.status == COMPLETE


FLEXIBLE, STIFF = Building("flexible", 500e3, 0.9, 0.05), Building("stiff", 300e3, 0.25, 0.05)
MIXED = (
    frame("A", 3, 9e7),
    frame("B", 2, 4e8),
    FLEXIBLE,
    STIFF,
    Building.rigid("wall"),
    frame("C", 2, 6e7),
    frame("D", 2, 6e7),
    frame("E", 3, 5e7),
)


@pytest.fixture(scope="module")
def mixed(motion):
    """The row of eight and its cases, which keep their runs."""
    model = row(*MIXED)
    return model, cases(model, motion)


def test_parts_are_the_whole_row(mixed):
    """Eight buildings of every kind; gaps such that some interfaces close and others stay open."""
    model, one = mixed
    needed = [one.driven.free.points[start:stop, HIGHEST].max() for start, stop in pairwise(model.bounds)]
    for open_ones in ({2, 3}, {0, 1, 4, 5}):
        gaps = [3.0 * need + 0.02 if place in open_ones else 0.4 * need for place, need in enumerate(needed)]
        together, answered = one.in_parts(limits(model, gaps))
        assert len(answered) >= 2
        same(together, one.whole(limits(model, gaps)))
        assert together.points[:, COUNT].sum() > 0


@settings(max_examples=8)
@given(
    shares=st.lists(st.sampled_from([0.3, 0.8, 1.02, 1.3, 4.0]), min_size=7, max_size=7),
    strength=st.sampled_from([inf, 6e5, 1e8]),
)
def test_whatever_the_gaps_parts_are_the_whole_row(mixed, shares, strength):
    """Gaps as shares of what the free motion needs; those between 1 and 2 close where pounding pushes.

    Two neighbours are equal, so that the free motion needs no gap between them.
    """
    model, one = mixed
    needed = [one.driven.free.points[start:stop, HIGHEST].max() for start, stop in pairwise(model.bounds)]
    assert needed[5] == 0.0
    gaps = [share * need + (0.02 if share == 4.0 else 0.0) for share, need in zip(shares, needed, strict=True)]
    together, _ = one.in_parts(limits(model, gaps, strength))
    same(together, one.whole(limits(model, gaps, strength)))


def test_a_row_that_nothing_closes_is_not_run(motion):
    model = row(FLEXIBLE, STIFF, FLEXIBLE._replace(period=1.2))
    one = cases(model, motion)
    needed = one.driven.free.points[:, HIGHEST]
    together, answered = one.in_parts(limits(model, needed))
    assert answered == []
    same(together, one.driven.free)
    same(together, one.whole(limits(model, needed)))


def test_pounding_closes_a_gap_that_the_free_motion_leaves_open(motion):
    """The flexible building drives the stiff one into the wall, which it does not reach by itself."""
    model = row(FLEXIBLE, STIFF, Building.rigid("wall"), STIFF)
    one = cases(model, motion)
    needed = one.driven.free.points[:, HIGHEST]
    gaps = [0.2 * needed[0], 1.02 * needed[1], 10.0]
    together, answered = one.in_parts(limits(model, gaps))
    assert len(answered) == 2, "solved once, grown, solved again"
    assert together.points[1, COUNT] > 0
    same(together, one.whole(limits(model, gaps)))


def test_equal_parts_are_solved_once(motion):
    """Two equal couples with equal neighbours, far from each other: one run, and both have its answer."""
    couple = (FLEXIBLE, STIFF)
    wall = Building.rigid("wall")
    model = row(wall, *couple, wall, *couple, wall)
    one = cases(model, motion)
    needed = one.driven.free.points[1, HIGHEST]
    gaps = [9.0, 0.3 * needed, 9.0, 9.0, 0.3 * needed, 9.0]
    together, answered = one.in_parts(limits(model, gaps))
    assert len(answered) == 2 and answered[0].key == answered[1].key
    same(together, one.whole(limits(model, gaps)))
    assert np.array_equal(together.points[1], together.points[4], equal_nan=True)
    wider = one.in_parts(limits(model, [9.0, 0.3 * needed, 9.0, 9.0, 0.31 * needed, 9.0]))[1]
    assert wider[0].key == answered[0].key != wider[1].key, "another gap is another run, the first is known"


def test_a_yield_force_above_the_largest_force_is_known(motion):
    model = row(FLEXIBLE, STIFF, FLEXIBLE)
    one = cases(model, motion)
    gaps = [0.3 * need for need in one.driven.free.points[:, HIGHEST]]
    free, _ = one.in_parts(limits(model, gaps))
    demand = free.points[:, DEMAND].max()
    above, answered = one.in_parts(limits(model, gaps, 1.001 * demand))
    assert [each.known for each in answered] == [True]
    same(above, one.whole(limits(model, gaps, 1.001 * demand)))
    below, answered = one.in_parts(limits(model, gaps, 0.5 * demand))
    assert [each.known for each in answered] == [False]
    assert not np.array_equal(below.floors, above.floors)
    same(below, one.whole(limits(model, gaps, 0.5 * demand)))


def test_a_law_without_a_cap_runs_once_for_every_yield_force(motion):
    """Contacts whose force reaches a level are counted from one run; the largest force says whether there are any."""
    model = row(FLEXIBLE, STIFF, FLEXIBLE)
    one = cases(model, motion, Linear(2e8))
    gaps = [0.3 * need for need in one.driven.free.points[:, HIGHEST]]
    force = one.whole(limits(model, gaps)).points[:, DEMAND]
    assert LEVELS[1] < force.max() < LEVELS[2], "two levels are reached, the other is not"
    keys = set()
    for level in (*LEVELS, inf):
        together, answered = one.in_parts(limits(model, gaps, level))
        same(together, one.whole(limits(model, gaps, level)))
        assert np.array_equal(together.points[:, YIELDS] > 0.0, force >= level)
        assert np.array_equal(np.isfinite(together.points[:, FIRST_YIELD]), force >= level)
        keys |= {each.key for each in answered}
    assert len(keys) == 1
