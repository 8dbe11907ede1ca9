"""Which buildings are solved together: the closed interfaces' parts, and how they grow and join."""

from __future__ import annotations

from itertools import pairwise

from hypothesis import given
from hypothesis import strategies as st

from pounding_risk.solver.row.partition import HELD, LEFTWARDS, RIGHTWARDS, Span, gathered, solved_spans, tied


def test_closed_interfaces_tie_buildings():
    assert tied([False, False]) == []
    assert tied([True, True, False, False, True]) == [Span(0, 2), Span(4, 5)]


def test_parts_side_by_side_are_one():
    """With one open interface between them each would watch a neighbour that does not move freely."""
    assert tied([True, False, True]) == [Span(0, 3)]
    assert tied([True, False, False, True]) == [Span(0, 1), Span(3, 4)]


@given(st.lists(st.booleans(), max_size=12))
def test_every_closed_interface_lies_in_one_part(closed):
    """And parts hold nothing that they need not: their outermost interfaces are closed, and none is beside another."""
    parts = tied(closed)
    for place, shut in enumerate(closed):
        inside = [part for part in parts if part.first <= place < part.last]
        assert len(inside) <= 1
        assert inside or not shut
    for part in parts:
        assert closed[part.first] and closed[part.last - 1]
    assert all(after.first - before.last >= 2 for before, after in pairwise(parts))


@given(st.lists(st.booleans(), min_size=1, max_size=10), st.sets(st.integers(0, 9)))
def test_growth_is_the_smallest_that_holds(closed, pressed):
    """Against a plain fixed point: a part that reaches an interface that pounding presses shut takes it in."""
    pressed = {place for place in pressed if place < len(closed)}
    solved = []

    def solve(span):
        solved.append(span)
        if span.first - 1 in pressed:
            return span, LEFTWARDS
        return span, RIGHTWARDS if span.last in pressed else HELD

    expected = list(closed)
    while True:
        parts = tied(expected)
        beside = {place for part in parts for place in (part.first - 1, part.last)} & pressed
        if not beside:
            break
        for place in beside:
            expected[place] = True
    found = solved_spans(tied(closed), solve)
    assert list(found) == parts and all(found[span] == span for span in found)
    assert len(solved) == len(set(solved)), "a part was solved twice"


def test_a_part_that_grows_joins_the_next():
    """Three parts; the first grows into the building between it and the second, which it then stands beside."""
    asked = []

    def solve(span):
        asked.append(span)
        return len(asked), RIGHTWARDS if span == Span(0, 1) else HELD

    assert solved_spans([Span(0, 1), Span(3, 4), Span(7, 8)], solve) == {Span(0, 4): 2, Span(7, 8): 3}
    assert asked == [Span(0, 1), Span(0, 4), Span(7, 8)]


def test_overlapping_spans_are_gathered():
    assert gathered([Span(4, 6), Span(0, 1), Span(1, 2)]) == [Span(0, 2), Span(4, 6)]
