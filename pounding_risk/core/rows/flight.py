"""Contact points of buildings in flight: where they stand, and the search for touches and peaks of their distance."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit import kernel
from pounding_risk.core.rows.layout import HIGHEST, INVERSE, LOWEST
from pounding_risk.core.series import SIGNAL, first_rise, highest


@kernel
def across(row, k, desk, line):
    """u_left − u_right at contact point ``k`` from a row of the desk (of v: its rate)."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += row.shares[k, end] * desk[line, i]
    return total


@kernel
def compliance(row, k):
    """1/m of both sides of contact point ``k``: B M⁻¹ Bᵀ, which for two masses is 1/m1 + 1/m2 [1/kg]."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += row.shares[k, end] ** 2 * row.floors[INVERSE, i]
    return total


@kernel
def push_apart(row, k, force, desk, line):
    """Add the accelerations that a contact force gives to the floors at both ends to a row of the desk."""
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            desk[line, i] -= row.shares[k, end] * row.floors[INVERSE, i] * force


@kernel
def lay_across(row, run, k, terms):
    """The series of u_left − u_right at contact point ``k`` onto the board."""
    board = run.board
    for n in range(terms):
        board[SIGNAL, n] = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            share = row.shares[k, end]
            for n in range(terms):
                board[SIGNAL, n] += share * run.series[i, n]


@kernel
def search_point(row, run, k, gap, stop, terms):
    """When contact point ``k`` touches on (0, stop], or −1; the series of both buildings stand."""
    lay_across(row, run, k, terms)
    return first_rise(run.board, terms, gap, stop)


@kernel
def raise_reach(row, run, k, stop, terms):
    """Raise the extremes of u_left − u_right at contact point ``k`` by those on [0, stop] of its series."""
    lay_across(row, run, k, terms)
    run.book[k, HIGHEST] = highest(run.board, SIGNAL, terms, 1.0, stop, run.book[k, HIGHEST])
    run.book[k, LOWEST] = -highest(run.board, SIGNAL, terms, -1.0, stop, -run.book[k, LOWEST])


@kernel
def bend_across(row, k):
    """|second derivative of u_left − u_right| over sqrt(2 E), E the larger bound of both buildings' motion."""
    total = 0.0
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            total += abs(row.shares[k, end]) * sqrt(row.floors[INVERSE, i])
    return total


@kernel
def wider(run, k, here, there, span, bend):
    """True where a new extreme of a distance may lie inside a stretch of flight; those at its end are entered."""
    eighth = 0.125 * span * span * bend
    run.book[k, HIGHEST] = max(run.book[k, HIGHEST], there)
    run.book[k, LOWEST] = min(run.book[k, LOWEST], there)
    top, bottom = max(here, there) + eighth, min(here, there) - eighth
    # What is not finite is searched, and ends the run with its status.
    return top > run.book[k, HIGHEST] or bottom < run.book[k, LOWEST] or not abs(top) < inf
