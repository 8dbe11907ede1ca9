"""One run of a row: from node to node, each building on its own or with the neighbours that it touches.

Buildings that neither touch nor are about to fly on their own, exactly, by a map from node to node; what lies between
two nodes is searched only where a bound leaves room for a touch or a new peak. Neighbours of which some touch form a
group that is integrated together (`group`). A building next to a group looks on; should the group strike it, the
interval is made again with it as a member. What a row costs follows its contacts and its buildings, not their product.
"""

from __future__ import annotations

from math import inf, nan, sqrt

import numpy as np

from pounding_risk._jit import borrowed, kernel, small
from pounding_risk.core.rows.chain import accelerate, bounds, lay_series, raise_between, soften, step_over
from pounding_risk.core.rows.flight import across, bend_across, compliance, raise_reach, search_point, wider
from pounding_risk.core.rows.group import FAILED, FLOWN, advance, any_closed
from pounding_risk.core.rows.layout import (
    A_END,
    A_NUDGED,
    A_START,
    BRANCH,
    CLOSED,
    DRIFT,
    ENERGY,
    GAP,
    GREW,
    INVERSE,
    LIMIT,
    NEXT,
    NODE,
    NOW,
    PLASTIC,
    RESIDUAL,
    STATUS,
    WORK,
    Row,
    Run,
)
from pounding_risk.core.rows.touch import lift_off
from pounding_risk.core.series import crest_bound
from pounding_risk.core.tally import (
    COMPLETE,
    COUNT,
    ENERGY_OPEN,
    FIRST_TOUCH,
    FIRST_YIELD,
    NOT_FINITE,
    OPEN_FLOOR,
    OPEN_SHARE,
)

WATCHED = 7  # status of a run that a touch at a watched point has ended


@small
def borrow_row(row):
    """The row with its arrays' references not counted."""
    return Row(
        borrowed(row.first),
        borrowed(row.start),
        borrowed(row.ends),
        borrowed(row.shares),
        borrowed(row.floors),
        borrowed(row.damping),
        borrowed(row.maps),
        borrowed(row.map_start),
        borrowed(row.bends),
    )


@small
def borrow_run(run):
    """The run with its arrays' references not counted."""
    return Run(
        borrowed(run.gaps),
        borrowed(run.strengths),
        borrowed(run.laws),
        borrowed(run.rules),
        borrowed(run.watched),
        borrowed(run.fastest),
        borrowed(run.levels),
        borrowed(run.first),
        borrowed(run.reached),
        borrowed(run.book),
        borrowed(run.tally),
        borrowed(run.reach),
        borrowed(run.peaks),
        borrowed(run.live),
        borrowed(run.whole),
        borrowed(run.desk),
        borrowed(run.quads),
        borrowed(run.series),
        borrowed(run.table),
        borrowed(run.board),
        borrowed(run.kept),
    )


@kernel
def begin_run(row, run):
    """A row at rest."""
    for i in range(row.floors.shape[1]):
        run.live[PLASTIC, i] = 0.0
        soften(row, run.live, i, 0.0)
        for line in range(NODE, NOW):
            run.desk[line, i] = 0.0
    run.tally[:, :] = 0.0
    run.book[:, :] = 0.0
    for k in range(run.gaps.size):
        run.tally[k, FIRST_TOUCH] = nan
        run.tally[k, FIRST_YIELD] = nan
        run.book[k, GAP] = run.gaps[k]
    run.reach[:, :] = 0.0
    run.peaks[:, :] = 0.0
    run.whole[:] = 0.0
    run.whole[GREW] = -1.0


@kernel
def is_elastic(row, run, b):
    """True where no storey of a building is yielding."""
    if row.bends[b]:
        for i in range(row.first[b], row.first[b + 1]):
            if run.live[BRANCH, i] != 0.0:
                return False
    return True


@kernel
def may_yield(row, run, b, swing, step):
    """True where a storey's drift may pass its limit within the node interval, by the bound of `chain.bounds`."""
    below = below_end = below_bend = 0.0
    for i in range(row.first[b], row.first[b + 1]):
        bend = sqrt(swing * row.floors[INVERSE, i])
        here, there, rest = run.desk[NODE, i], run.desk[NEXT, i], run.live[PLASTIC, i]
        top = max(abs(here - below - rest), abs(there - below_end - rest)) + 0.125 * step * step * (bend + below_bend)
        if not top < row.floors[LIMIT, i]:
            return True
        below, below_end, below_bend = here, there, bend
    return False


@kernel
def predict(row, run, b, window, swings):
    """Building ``b`` over one node interval on its own: rows NODE to rows NEXT, ü at the node in A_START.

    Leaves 2 E of its bounds in ``swings``; returns False where a storey yields, or may.
    """
    _, step, pull, rise = window
    swings[0, b] = swings[1, b] = 0.0
    if row.first[b] == row.first[b + 1]:
        return True
    if row.bends[b] and not is_elastic(row, run, b):
        return False
    accelerate(row, run.live, b, NODE, pull, run.desk, A_START)
    step_over(row, run.live, b, pull, rise, run.desk, NODE, NEXT)
    swings[0, b], swings[1, b] = bounds(row, run.live, b, rise, run.desk, NODE, A_START, A_NUDGED)
    return not (row.bends[b] and may_yield(row, run, b, swings[0, b], step))


@kernel
def meets(row, run, interface, window, swings, terms):
    """True where two buildings that both fly alone touch within the node interval."""
    _, step, pull, rise = window
    swing = sqrt(max(swings[0, interface], swings[0, interface + 1]))
    laid = False
    for k in range(row.start[interface], row.start[interface + 1]):
        here, there = across(row, k, run.desk, NODE), across(row, k, run.desk, NEXT)
        bend = swing * bend_across(row, k)
        top = max(here, there) + 0.125 * step * step * bend
        if not top > run.book[k, GAP] or compliance(row, k) == 0.0:
            continue
        if crest_bound(here, there, step, bend) > run.book[k, GAP]:
            if not laid:
                lay_series(row, run, interface, NODE, pull, rise, terms)
                lay_series(row, run, interface + 1, NODE, pull, rise, terms)
                laid = True
            if search_point(row, run, k, run.book[k, GAP], step, terms) >= 0.0:
                return True
    return False


@kernel
def stand_apart(row, run, interface, window, swings, terms):
    """Raise the extremes of the distances between two buildings that have both flown alone."""
    _, step, pull, rise = window
    swing = sqrt(max(swings[0, interface], swings[0, interface + 1]))
    laid = False
    for k in range(row.start[interface], row.start[interface + 1]):
        here, there = across(row, k, run.desk, NODE), across(row, k, run.desk, NEXT)
        if wider(run, k, here, there, step, swing * bend_across(row, k)):
            if not laid:
                lay_series(row, run, interface, NODE, pull, rise, terms)
                lay_series(row, run, interface + 1, NODE, pull, rise, terms)
                laid = True
            raise_reach(row, run, k, step, terms)


@kernel
def keep(row, run, back):
    """Keep, or bring back, what an interval changes, so that it can be made again."""
    place = 0
    for line in range(4):
        for i in range(row.floors.shape[1]):
            place = swap(run.kept, place, run.peaks, line, i, back)
            place = swap(run.kept, place, run.live, line, i, back)
    for k in range(run.gaps.size):
        for column in range(run.book.shape[1]):
            place = swap(run.kept, place, run.book, k, column, back)
        for column in range(run.tally.shape[1]):
            place = swap(run.kept, place, run.tally, k, column, back)
        for side in range(2):
            place = swap(run.kept, place, run.reach, side, k, back)
        for level in range(run.levels.size):
            place = swap(run.kept, place, run.first, k, level, back)
            place = swap(run.kept, place, run.reached, k, level, back)
    for column in range(5):
        if back:
            run.whole[column] = run.kept[place]
        else:
            run.kept[place] = run.whole[column]
        place += 1


@small
def swap(kept, place, array, line, column, back):
    """One number to or from what is kept; returns the next place."""
    if back:
        array[line, column] = kept[place]
    else:
        kept[place] = array[line, column]
    return place + 1


@kernel
def interval(row, run, law, rule, tied, busy, swings, window, terms, rtol):
    """The whole row over one node interval, rows NODE to rows NEXT; returns False where the run has ended.

    ``tied`` (interfaces), ``busy`` (buildings that need their group) and ``swings`` are this function's own.
    """
    buildings = row.first.size - 1
    some = False
    for b in range(buildings):
        busy[b] = not predict(row, run, b, window, swings)
        some = some or busy[b]
    for i in range(buildings - 1):
        tied[i] = any_closed(row, run, i, i + 1)
        if not (tied[i] or busy[i] or busy[i + 1]):
            tied[i] = meets(row, run, i, window, swings, terms)
        some = some or tied[i]
    if some:
        keep(row, run, False)
        for i in range(buildings - 1):
            if tied[i]:
                busy[i] = busy[i + 1] = True
        while True:
            how, edge = solve_groups(row, run, law, rule, tied, busy, window, terms, rtol)
            if how == FAILED:
                return False
            if how == FLOWN:
                break
            # A building that has only looked on is struck: the interval is made again with it as a member.
            keep(row, run, True)
            tied[edge] = busy[edge] = busy[edge + 1] = True
    step, pull, rise = window[1], window[2], window[3]
    for b in range(buildings):
        if not busy[b]:
            accelerate(row, run.live, b, NEXT, pull + rise * step, run.desk, A_END)
            ends = NODE, NEXT, A_START, A_END
            raise_between(row, run, b, ends, (swings[0, b], swings[1, b]), pull, rise, step, terms, False)
    for i in range(buildings - 1):
        if not (busy[i] or busy[i + 1]):
            stand_apart(row, run, i, window, swings, terms)
    return True


@kernel
def solve_groups(row, run, law, rule, tied, busy, window, terms, rtol):
    """Every group of busy buildings over the interval: (how it ended, interface to tie where a group grows).

    Busy buildings side by side are one group even where they do not touch: each would have to look on at the other's
    contacts.
    """
    buildings = row.first.size - 1
    b = 0
    while b < buildings:
        if not busy[b]:
            b += 1
            continue
        last = b
        while last < buildings - 1 and busy[last + 1]:
            last += 1
        watch = max(b - 1, 0), min(last + 1, buildings - 1)
        how, edge = advance(row, run, law, rule, (b, last), watch, window, terms, rtol)
        if how != FLOWN:
            return how, edge
        for i in range(row.first[b], row.first[last + 1]):
            run.desk[NEXT, i] = run.desk[NOW, i]
            run.desk[NEXT + 1, i] = run.desk[NOW + 1, i]
        b = last + 1
    return FLOWN, -1


@kernel
def struck(run):
    """A watched contact point that is closed, or −1."""
    for k in range(run.gaps.size):
        if run.watched[k] > 0.0 and (run.book[k, CLOSED] > 0.0 or run.tally[k, COUNT] > 0.0):
            return k
    return -1


@kernel
def march(row, run, law, rule, ground, step, terms, rtol, survey, states):
    """One run from rest to the end of the record; everything is left in ``run``.

    ``survey`` is true for a run without contact, which finds the fastest closing; ``states`` (nodes, 2, D) takes u and v at every node where it has rows.
    """
    row, run, ground, states = borrow_row(row), borrow_run(run), borrowed(ground), borrowed(states)
    begin_run(row, run)
    buildings = row.first.size - 1
    tied, busy = np.zeros(buildings, dtype=np.bool_), np.zeros(buildings, dtype=np.bool_)
    swings = np.zeros((2, buildings))
    dofs = row.floors.shape[1]
    nodes = ground.size - 1
    for node in range(nodes):
        rise = (ground[node + 1] - ground[node]) / step
        window = node * step, step, ground[node], rise
        if not interval(row, run, law, rule, tied, busy, swings, window, terms, rtol):
            break
        for i in range(dofs):
            run.desk[NODE, i] = run.desk[NEXT, i]
            run.desk[NODE + 1, i] = run.desk[NEXT + 1, i]
        for k in range(run.gaps.size):
            if survey:
                run.fastest[k] = max(run.fastest[k], abs(across(row, k, run.desk, NODE + 1)))
        if states.shape[0] > node + 1:
            for i in range(dofs):
                states[node + 1, 0, i] = run.desk[NODE, i]
                states[node + 1, 1, i] = run.desk[NODE + 1, i]
        place = struck(run)
        if place >= 0:
            run.whole[STATUS], run.whole[GREW] = float(WATCHED), float(place)
            break
    end_run(row, run, nodes * step, law, rtol)


@kernel
def end_run(row, run, time, law, rtol):
    """Contacts that outlast the record are closed, and the status is set where nothing has set it."""
    total = 0.0
    for k in range(run.gaps.size):
        if run.book[k, CLOSED] > 0.0 and run.whole[STATUS] == COMPLETE:
            lift_off(row, run, law, k, time, NODE, run.book[k, WORK])
        for column in range(18):
            value = run.tally[k, column]
            if column != FIRST_TOUCH and column != FIRST_YIELD:
                total += abs(value)
        total += abs(run.reach[0, k]) + abs(run.reach[1, k])
    for i in range(row.floors.shape[1]):
        total += abs(run.desk[NODE, i]) + abs(run.desk[NODE + 1, i]) + run.peaks[DRIFT, i]
    if run.whole[STATUS] != COMPLETE:
        return
    if not total < inf:
        run.whole[STATUS] = float(NOT_FINITE)
    elif not abs(run.whole[RESIDUAL]) <= (OPEN_SHARE * rtol + OPEN_FLOOR) * run.whole[ENERGY]:
        run.whole[STATUS] = float(ENERGY_OPEN)
