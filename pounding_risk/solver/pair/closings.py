"""Largest closings without contact between linear oscillators on one ground: every left one with every right one.

All oscillators pass the same nodes, at least 32 of the shortest period, with the exact map of a ground acceleration
that is linear in between (`motions.spectra.series`), sixteen oscillators side by side. The nodes come in slabs of 128.
Each slab holds u and u̇ of all oscillators in the processor's cache, and the differences u_left − u_right of all pairs
are taken there; nothing longer is stored than the states at the beginning of each slab. The slab of strongest response
goes first, so that most of the others cannot exceed what is found and are passed over. `listed_closings` takes chosen
pairs instead of all.

Between two nodes a difference d exceeds its values at both by h² / 8 max|d̈| at most. Here d̈ = p_left − p_right with
p = ü + a_g = −(2 ζ ω u̇ + ω² u), as the ground cancels, and p between nodes is bounded by its values at nodes and by the
ground's (`fill_maps`). Wherever that bound exceeds the largest value so far, d is expanded from the first of both nodes
as a power series of 12 terms, whose rest is below 1e-16 of the response, and its maximum is found by Newton's method
where the series is concave, and by bisection to 1e-12 of the value elsewhere. The maximum over time of the continuous
motion is therefore that of d but for rounding and these 1e-12.

A period of 0 is an oscillator that moves with the ground; a pair of it with another one has the peaks of the other.
"""

from __future__ import annotations

from math import inf, pi
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._jit.compile import kernel, small
from pounding_risk.motions.spectra import larger, parts_of, series

SLAB = 128  # steps
ROOM = SLAB + 4  # numbers of a slab's nodes: both ends are among them, and loops go by fours
TERMS = 12  # of the series in ω h ≤ 0.2
NEWTON = 6  # steps; the first guess is that of a parabola, and the series is nearly one
TIGHT = 1e-12  # of the largest value, that a bisection may miss
LANES = 16  # oscillators side by side: with fewer, each step waits for the one before
# Columns of the maps: u and u̇ after a step from 1 in u, u̇, a_g and its rise; then the numbers of the oscillator.
U, V, OMEGA2, TWO_ZETA_OMEGA, MOVES, SPREAD = 0, 4, 8, 9, 10, 11
COLUMNS = 12
HIGHEST, LOWEST, PULL = 0, 1, 2  # of a slab: largest and smallest u, and a bound of |p|
# Rows of the desk, of one number for each lane: the columns U and V of the maps, then u and u̇ at a node.
AT, RATE = 8, 9
ROWS = 10


class Oscillators(NamedTuple):
    """Oscillators and the room in which they pass a slab."""

    maps: Any  # (oscillators, COLUMNS)
    paths: Any  # (u and u̇, oscillators, ROOM)
    extents: Any  # (oscillators, 3)
    terms: Any  # (TERMS,) of a difference between two nodes, in the time over the step
    desk: Any  # (ROWS * LANES,) of the oscillators that go side by side


def room_for(count: int) -> Oscillators:
    """Room for so many oscillators, which `fill_maps` writes into."""
    return Oscillators(
        np.empty((count, COLUMNS)),
        np.zeros((2, count, ROOM)),
        np.empty((count, 3)),
        np.empty(TERMS),
        np.zeros(ROWS * LANES),
    )


@kernel
def fill_maps(periods, dampings, h, maps):
    """Coefficients of one step of every oscillator.

    ``SPREAD`` is s of max|p| ≤ (max|p| at nodes + s max|a_g|) / (1 − s) between nodes: with M the largest |p|,
    |p̈| ≤ 2 ζ ω (|ṗ| + |ȧ_g|) + ω² (M + |a_g|), |ṗ| ≤ 2 M / h + h |p̈| / 2 and |ȧ_g| ≤ 2 max|a_g| / h.
    """
    for k in range(periods.size):
        for column in range(COLUMNS):
            maps[k, column] = 0.0
        if periods[k] > 0.0:
            omega = 2.0 * pi / periods[k]
            maps[k, OMEGA2], maps[k, TWO_ZETA_OMEGA], maps[k, MOVES] = omega * omega, 2.0 * dampings[k] * omega, 1.0
            turn = omega * h
            maps[k, SPREAD] = turn * (0.5 * dampings[k] + 0.125 * turn) / (1.0 - dampings[k] * turn)
            for kind in range(4):
                maps[k, U + kind], maps[k, V + kind] = series(kind, omega * omega, 2.0 * dampings[k] * omega, h)


@small
def step_lanes(here, rise, desk):
    """All lanes to the next node; a_g is ``here`` at this one and rises by ``rise``.

    The largest values are not kept here: a store that only larger values reach takes the processor longer than all
    else.
    """
    for lane in range(LANES):
        u, v = desk[AT * LANES + lane], desk[RATE * LANES + lane]
        desk[AT * LANES + lane] = (
            desk[U * LANES + lane] * u
            + desk[(U + 1) * LANES + lane] * v
            + (desk[(U + 2) * LANES + lane] * here + desk[(U + 3) * LANES + lane] * rise)
        )
        desk[RATE * LANES + lane] = (
            desk[V * LANES + lane] * u
            + desk[(V + 1) * LANES + lane] * v
            + (desk[(V + 2) * LANES + lane] * here + desk[(V + 3) * LANES + lane] * rise)
        )


@kernel
def follow_slab(nodes, first, steps, states, those):
    """Each oscillator from its state at node ``first`` through a slab; its state becomes that at the end.

    Fills u and u̇ at the nodes, those after the last as the last, and `PULL`. Lanes without an oscillator go along.
    """
    maps, paths, desk = those.maps, those.paths, those.desk
    shaking = 0.0
    for node in range(first, first + steps + 1):
        shaking = larger(abs(nodes[node]), shaking)
    for start in range(0, states.shape[0], LANES):
        few = min(LANES, states.shape[0] - start)
        for lane in range(few):
            k = start + lane
            for column in range(AT):
                desk[column * LANES + lane] = maps[k, column]
            desk[AT * LANES + lane], desk[RATE * LANES + lane] = states[k, 0], states[k, 1]
            paths[0, k, 0], paths[1, k, 0] = states[k, 0], states[k, 1]
        for step in range(steps):
            here = nodes[first + step]
            step_lanes(here, nodes[first + step + 1] - here, desk)
            for lane in range(few):
                paths[0, start + lane, step + 1] = desk[AT * LANES + lane]
                paths[1, start + lane, step + 1] = desk[RATE * LANES + lane]
    for k in range(states.shape[0]):
        for part in range(2):
            states[k, part] = paths[part, k, steps]
            for node in range(steps + 1, ROOM):
                paths[part, k, node] = states[k, part]
        spread, pull = maps[k, SPREAD], pull_of(paths[0, k], paths[1, k], maps[k])
        those.extents[k, PULL] = (pull + spread * shaking) / (1.0 - spread) if maps[k, MOVES] > 0.0 else shaking


@kernel
def pull_of(u, v, numbers):
    """The largest |p| at the nodes of a slab."""
    fade, stiffness = numbers[TWO_ZETA_OMEGA], numbers[OMEGA2]
    a = b = c = d = 0.0
    for node in range(0, ROOM, 4):
        a = larger(abs(fade * v[node] + stiffness * u[node]), a)
        b = larger(abs(fade * v[node + 1] + stiffness * u[node + 1]), b)
        c = larger(abs(fade * v[node + 2] + stiffness * u[node + 2]), c)
        d = larger(abs(fade * v[node + 3] + stiffness * u[node + 3]), d)
    return larger(larger(a, b), larger(c, d))


@kernel
def measure_slab(count, those):
    """The largest and the smallest u of each oscillator at the nodes of the slab."""
    for k in range(count):
        u = those.paths[0, k]
        a = b = c = d = e = f = g = h = -inf
        for node in range(0, ROOM, 4):
            a, b = larger(u[node], a), larger(u[node + 1], b)
            c, d = larger(u[node + 2], c), larger(u[node + 3], d)
            e, f = larger(-u[node], e), larger(-u[node + 1], f)
            g, h = larger(-u[node + 2], g), larger(-u[node + 3], h)
        those.extents[k, HIGHEST] = larger(larger(a, b), larger(c, d))
        those.extents[k, LOWEST] = -larger(larger(e, f), larger(g, h))


@kernel
def begin_slabs(nodes, starts, strengths, those):
    """Every oscillator through the whole motion: its states at the beginning of each slab, and its largest |u| in it.

    ``starts[0]`` holds the states at the beginning.
    """
    for slab in range(strengths.shape[0]):
        first = slab * SLAB
        steps = min(SLAB, nodes.size - 1 - first)
        for k in range(starts.shape[1]):
            starts[slab + 1, k, 0], starts[slab + 1, k, 1] = starts[slab, k, 0], starts[slab, k, 1]
        follow_slab(nodes, first, steps, starts[slab + 1], those)
        measure_slab(starts.shape[1], those)
        for k in range(starts.shape[1]):
            strengths[slab, k] = larger(those.extents[k, HIGHEST], -those.extents[k, LOWEST])


@kernel
def spread_of(one, other):
    """The largest of one − other, and the largest of other − one, at the nodes of a slab."""
    a = b = c = d = e = f = g = h = -inf
    for node in range(0, ROOM, 4):
        first, second = one[node] - other[node], one[node + 1] - other[node + 1]
        third, fourth = one[node + 2] - other[node + 2], one[node + 3] - other[node + 3]
        a, b, c, d = larger(first, a), larger(second, b), larger(third, c), larger(fourth, d)
        e, f, g, h = larger(-first, e), larger(-second, f), larger(-third, g), larger(-fourth, h)
    return larger(larger(a, b), larger(c, d)), larger(larger(e, f), larger(g, h))


@small
def write_terms(pair, sign, step, load, h, those):
    """The series of ± (u_left − u_right) after a node; ``load`` is a_g there and its rise to the next node."""
    terms = those.terms
    for n in range(TERMS):
        terms[n] = 0.0
    for side in range(2):
        k = pair[0] if side == 0 else pair[1]
        factor = sign if side == 0 else -sign
        moves = h * h * those.maps[k, MOVES]
        fade, stiffness = h * those.maps[k, TWO_ZETA_OMEGA], h * h * those.maps[k, OMEGA2]
        now, after = those.paths[0, k, step], h * those.paths[1, k, step]
        terms[0] += factor * now
        terms[1] += factor * after
        for n in range(TERMS - 2):
            push = load[0] if n == 0 else (load[1] if n == 1 else 0.0)
            new = -(moves * push + fade * (n + 1) * after + stiffness * now) / ((n + 1) * (n + 2))
            terms[n + 2] += factor * new
            now, after = after, new


@kernel
def value_at(terms, x):
    """Value at x of a power series with these coefficients, the lowest power first."""
    value = terms[TERMS - 1]
    for n in range(TERMS - 2, -1, -1):
        value = value * x + terms[n]
    return value


@kernel
def slope_and_bend(terms, x):
    """First and second derivative of the series at x."""
    slope, bend = (TERMS - 1) * terms[TERMS - 1], 0.0
    for n in range(TERMS - 2, 0, -1):
        bend = bend * x + slope
        slope = slope * x + n * terms[n]
    return slope, bend


@kernel
def bisected(terms, bend, best):
    """The larger of ``best`` and the largest value of the series on [0, 1]; no |second derivative| is above ``bend``.

    Goes through halves, quarters and so on from left to right, and divides those that may hold more.
    """
    number, width = 0, 1.0
    while number * width < 1.0:
        ends = larger(value_at(terms, number * width), value_at(terms, (number + 1) * width))
        best = larger(ends, best)
        if ends + 0.125 * bend * width * width > best + TIGHT * larger(best, bend):
            number, width = 2 * number, 0.5 * width
            continue
        number += 1
        while number % 2 == 0 and width < 1.0:
            number, width = number // 2, 2.0 * width
    return best


@kernel
def maximum_of(terms, best):
    """The larger of ``best`` and the largest value of the series on [0, 1]."""
    bend, rest = 2.0 * terms[2], 0.0  # the second derivative is within bend ± rest
    for n in range(3, TERMS):
        rest += n * (n - 1) * abs(terms[n])
    best = larger(larger(terms[0], value_at(terms, 1.0)), best)
    if bend >= rest:
        return best
    if bend + 2.0 * rest >= 0.0:
        return bisected(terms, abs(bend) + rest, best)
    start, stop = terms[1], slope_and_bend(terms, 1.0)[0]
    if start <= 0.0 or stop >= 0.0:
        return best
    x = start / (start - stop)
    for _ in range(NEWTON):
        slope, curve = slope_and_bend(terms, x)
        x = min(max(x - slope / curve, 0.0), 1.0)
    return larger(value_at(terms, x), best)


@kernel
def search_slab(nodes, span, pair, sign, h, limits, those):
    """The larger of the closing so far and that between the nodes of a slab.

    ``span`` is the slab's first node and its steps; ``limits`` what a value between nodes may be above both, and the
    closing so far.
    """
    reach, best = limits
    one, other = those.paths[0, pair[0]], those.paths[0, pair[1]]
    here = sign * (one[0] - other[0])
    for step in range(span[1]):
        there = sign * (one[step + 1] - other[step + 1])
        if larger(here, there) + reach > best:
            ground = nodes[span[0] + step]
            write_terms(pair, sign, step, (ground, nodes[span[0] + step + 1] - ground), h, those)
            best = maximum_of(those.terms, best)
        here = there
    return best


@kernel
def close_pairs(nodes, h, order, starts, first_right, those, closings):
    """Largest u_left − u_right and u_right − u_left of every pair, into ``closings`` (left, right, 2).

    ``order`` is that of the slabs, whose states at the beginning are ``starts`` (they are overwritten). The right
    oscillators are those from ``first_right`` on; where it is 0 both sides are the same oscillators, and only pairs
    with a later right one are followed.
    """
    extents, paths = those.extents, those.paths
    n_left, n_right = closings.shape[0], closings.shape[1]
    for slab in order:
        first = slab * SLAB
        steps = min(SLAB, nodes.size - 1 - first)
        follow_slab(nodes, first, steps, starts[slab], those)
        measure_slab(starts.shape[1], those)
        for left in range(n_left):
            for column in range(left + 1 if first_right == 0 else 0, n_right):
                right = first_right + column
                reach = 0.125 * h * h * (extents[left, PULL] + extents[right, PULL])
                closing, opening = closings[left, column, 0], closings[left, column, 1]
                if (
                    extents[left, HIGHEST] - extents[right, LOWEST] + reach <= closing
                    and extents[right, HIGHEST] - extents[left, LOWEST] + reach <= opening
                ):
                    continue
                ahead, behind = spread_of(paths[0, left], paths[0, right])
                closing, opening = larger(ahead, closing), larger(behind, opening)
                if ahead + reach > closing:
                    limits = reach, closing
                    closing = search_slab(nodes, (first, steps), (left, right), 1.0, h, limits, those)
                if behind + reach > opening:
                    limits = reach, opening
                    opening = search_slab(nodes, (first, steps), (left, right), -1.0, h, limits, those)
                closings[left, column, 0], closings[left, column, 1] = closing, opening


class Closings(NamedTuple):
    """Largest closings and peaks of oscillators under one motion [m]."""

    closing: np.ndarray  # (polarities, left, right): of the motion, and of the motion reversed
    left: np.ndarray  # (left,) max|u|
    right: np.ndarray  # (right,)


def largest_closings(acceleration, dt, left, right) -> Closings:
    """Largest u_left − u_right from rest of every left oscillator with every right one, and the peaks of each.

    Parameters
    ----------
    acceleration : ndarray, shape (n,)
        Ground acceleration [m/s²], linear between the samples.
    dt : float
        Time step [s].
    left, right : pair of ndarray
        Periods [s] and damping ratios of the oscillators of a side, in any order; each period above 0.

    Returns
    -------
    Closings
        For the motion and for the motion reversed; at least 0, as both start from rest.
    """
    sides = [tuple(np.append(values, 0.0) for values in side) for side in (left, right)]
    alike = all(np.array_equal(one, other) for one, other in zip(*sides, strict=True))
    periods, dampings = sides[0] if alike else (np.concatenate(both) for both in zip(*sides, strict=True))
    n_left, n_right = sides[0][0].size, sides[1][0].size
    parts = parts_of(dt, periods[periods > 0.0].min())
    nodes = divided(acceleration, parts)
    searched = room_for(periods.size)
    fill_maps(periods, dampings, dt / parts, searched.maps)
    slabs = -(-(nodes.size - 1) // SLAB)
    starts, strengths = np.zeros((slabs + 1, periods.size, 2)), np.empty((slabs, periods.size))
    begin_slabs(nodes, starts, strengths, searched)
    closings = np.zeros((n_left, n_right, 2))
    first_right = 0 if alike else n_left
    close_pairs(nodes, dt / parts, strongest_first(strengths), starts, first_right, searched, closings)
    if alike:
        closings += closings.transpose(1, 0, 2)[..., ::-1]  # zero below the diagonal before
    peaks = closings.max(axis=2)
    both = np.ascontiguousarray(closings[:-1, :-1].transpose(2, 0, 1))
    return Closings(both, peaks[:-1, -1], peaks[-1, :-1])


def divided(acceleration, parts):
    """The ground at its nodes: each interval between samples in ``parts``."""
    samples = np.asarray(acceleration, dtype=np.float64)
    return np.interp(np.arange((samples.size - 1) * parts + 1) / parts, np.arange(samples.size), samples)


def strongest_first(strengths):
    """The numbers of the slabs by their strengths (slabs, oscillators), each oscillator's in shares of its largest."""
    largest = strengths.max(axis=0)
    shares = np.divide(strengths, largest, out=np.zeros_like(strengths), where=largest > 0.0)
    return np.argsort(-shares.sum(axis=1), kind="stable")
