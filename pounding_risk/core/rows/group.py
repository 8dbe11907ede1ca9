"""A group of neighbours over one node interval: flights and contacts in turn, while others fly on their own."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit import kernel
from pounding_risk.core.collide import ELASTIC, SLACK, YIELDING
from pounding_risk.core.events import CUT, NONE, PART, TURN, YIELD
from pounding_risk.core.rows.chain import energy_of, lay_series, place_on, raise_peaks, soften
from pounding_risk.core.rows.events import ROUNDED, STRAIN, TOUCH, drift_in, fill_spectators, take_step
from pounding_risk.core.rows.flight import across, compliance, raise_reach, search_point
from pounding_risk.core.rows.layout import (
    BOTTOM,
    BRANCH,
    CLOSED,
    CONSTANT,
    END,
    ENERGY,
    GAP,
    LAST,
    LIMIT,
    NODE,
    NOW,
    PACE,
    PLASTIC,
    REGION,
    RESIDUAL,
    SLOPE,
    SLOPES,
    STATUS,
    STEPS,
    TANGENT,
    TRIAL,
    WORK,
)
from pounding_risk.core.rows.stage import Group, load, slopes
from pounding_risk.core.rows.touch import lift_off, note_yield, own_tolerance, scales, touch_down, turn
from pounding_risk.core.rows.watch import watch_floors, watch_points
from pounding_risk.core.series import SIGNAL, first_rise
from pounding_risk.core.tally import COUNT as TOUCHES
from pounding_risk.core.tally import (
    EXHAUSTED,
    IMPULSE,
    MAX_CONTACTS,
    MAX_STEPS,
    NOT_FINITE,
    TOO_MANY_CONTACTS,
    UNDERFLOW,
)

FLOWN, GROW, FAILED = 0, 1, 2  # how a stretch ends


@kernel
def any_closed(row, run, first, last):
    """True where two of these buildings touch."""
    for k in range(row.start[first], row.start[last]):
        if run.book[k, CLOSED] > 0.0:
            return True
    return False


@kernel
def copy_state(row, run, first, last, source, target):
    """Rows of u and v of these buildings."""
    for i in range(row.first[first], row.first[last + 1]):
        run.desk[target, i] = run.desk[source, i]
        run.desk[target + 1, i] = run.desk[source + 1, i]


@kernel
def press(row, run, law, rule, group, time, pull):
    """Begin every contact of the group that is about to press, its state in rows NOW; returns how many."""
    count = 0
    ready = False
    for k in range(row.start[group.first], row.start[group.last]):
        if run.book[k, CLOSED] > 0.0 or compliance(row, k) == 0.0:
            continue
        if across(row, k, run.desk, NOW) - run.book[k, GAP] < -ROUNDED:
            continue
        rate = across(row, k, run.desk, NOW + 1)
        if rate == 0.0:
            # Closed at rest: what decides is how both sides would move on.
            if not ready:
                load(row, run, law, group, NOW, pull, TRIAL)
                ready = True
            rate = across(row, k, run.desk, TRIAL)
        if rate > 0.0:
            touch_down(row, run, law, rule, k, time)
            count += 1
    return count


@kernel
def next_strain(row, run, i, stop, terms):
    """When the storey below dof ``i`` changes its branch on (0, stop] of a flight, or −1."""
    board, series, live = run.board, run.series, run.live
    bottom = row.floors[BOTTOM, i] > 0.0
    branch = live[BRANCH, i]
    if branch != 0.0:
        for n in range(terms - 1):
            rate = (n + 1) * (series[i, n + 1] - (0.0 if bottom else series[i - 1, n + 1]))
            board[SIGNAL, n] = -branch * rate
        return first_rise(board, terms - 1, 0.0, stop)
    found = -1.0
    for side in range(2):
        sign = 1.0 - 2.0 * side
        for n in range(terms):
            board[SIGNAL, n] = sign * (series[i, n] - (0.0 if bottom else series[i - 1, n]))
        level = row.floors[LIMIT, i] + sign * live[PLASTIC, i]
        at = first_rise(board, terms, level, stop if found < 0.0 else found)
        found = at if at >= 0.0 else found
    return found


@kernel
def switch_storey(row, run, i, line):
    """The storey below dof ``i`` changes its branch, its state in rows ``line``; returns the change of the potential."""
    live = run.live
    drift = drift_in(row, run.desk, line, i)
    before = 0.5 * live[TANGENT, i] * drift * drift + live[CONSTANT, i] * drift
    branch = live[BRANCH, i]
    if branch == 0.0:
        soften(row, live, i, 1.0 if drift > live[PLASTIC, i] else -1.0)
    else:
        live[PLASTIC, i] = drift - branch * row.floors[LIMIT, i]
        soften(row, live, i, 0.0)
    return 0.5 * live[TANGENT, i] * drift * drift + live[CONSTANT, i] * drift - before


@kernel
def lay_all(row, run, watch, pull, rise, terms):
    """Lay the series of all watched buildings from rows NOW; spectators have been brought there."""
    for b in range(watch[0], watch[1] + 1):
        lay_series(row, run, b, NOW, pull, rise, terms)


@kernel
def fly_group(row, run, group, watch, stop, pull, rise, terms):
    """Fly from rows NOW, whose series are laid, to the first touch or change of a storey, at most for ``stop``.

    Returns (time flown, interface whose spectator is touched or −1, storey that changes or −1). Peaks are raised.
    """
    edge, storey = -1, -1
    for i in range(watch[0], watch[1]):
        outer = i < group.first or i >= group.last
        for k in range(row.start[i], row.start[i + 1]):
            if compliance(row, k) == 0.0:
                continue
            found = search_point(row, run, k, run.book[k, GAP], stop, terms)
            if found >= 0.0:
                if outer:
                    return found, i, -1
                stop = found
    for b in range(group.first, group.last + 1):
        if row.bends[b]:
            for i in range(row.first[b], row.first[b + 1]):
                if row.floors[LIMIT, i] < inf:
                    found = next_strain(row, run, i, stop, terms)
                    if found >= 0.0:
                        stop, storey = found, i
    for b in range(group.first, group.last + 1):
        raise_peaks(row, run, b, pull, rise, stop, terms)
    for k in range(row.start[watch[0]], row.start[watch[1]]):
        raise_reach(row, run, k, stop, terms)
    return stop, edge, storey


@kernel
def group_energy(row, run, group, line):
    """Mechanical energy of the group [J]."""
    total = 0.0
    for b in range(group.first, group.last + 1):
        total += energy_of(row, run.live, b, line, run.desk)
    return total


@kernel
def close_step(row, run, group):
    """Rows END become rows NOW, and the quadratures of the step go into the sums; returns the energy that came in."""
    points = run.gaps.size
    for i in range(group.low, group.high):
        run.desk[NOW, i] = run.desk[END, i]
        run.desk[NOW + 1, i] = run.desk[END + 1, i]
    came = run.quads[SLOPES, 2 * points]
    for k in range(row.start[group.first], row.start[group.last]):
        if run.book[k, CLOSED] > 0.0:
            run.tally[k, IMPULSE] += run.quads[SLOPES, k]
            run.book[k, WORK] += run.quads[SLOPES, points + k]
            came -= run.quads[SLOPES, points + k]
    return came


@kernel
def happen(row, run, law, rule, kind, k, time, line):
    """What an event changes in the book; returns (whether a contact began or ended, change of the potential)."""
    book = run.book
    if kind == TURN:
        turn(row, run, law, k, max(across(row, k, run.desk, line) - book[k, GAP], 0.0))
    elif kind == YIELD:
        if int(book[k, REGION]) == ELASTIC:
            note_yield(run, k, time)
            book[k, REGION] = float(YIELDING)
        else:
            book[k, REGION] = float(ELASTIC)
    elif kind == CUT:
        book[k, REGION] = float(ELASTIC if int(book[k, REGION]) == SLACK else SLACK)
    elif kind == PART:
        lift_off(row, run, law, k, time, line, book[k, WORK])
        book[k, WORK] = 0.0
        return True, 0.0
    elif kind == TOUCH:
        book[k, WORK] = 0.0
        touch_down(row, run, law, rule, k, time)
        return True, 0.0
    elif kind == STRAIN:
        return False, switch_storey(row, run, k, line)
    return False, 0.0


@kernel
def collide_group(row, run, law, rule, span, watch, window, t, base, terms, rtol):
    """Integrate a group with contacts from rows NOW at ``t`` after the node until all have parted or the interval ends.

    ``span`` = (first, last building), ``window`` = (time of the node, step, a_g, its slope), ``base`` the start of the
    spectators' series. Returns (how it ended, time after the node, interface of a touched spectator or −1).
    """
    moment, step, pull, rise = window
    low, high = row.first[span[0]], row.first[span[1] + 1]
    tolerance, stalled = rtol, 0
    renewed, known = True, False
    group = Group(span[0], span[1], low, high, 0.0, pull, rise, 1.0, 1.0)
    s = h = now = 0.0
    energy = group_energy(row, run, group, NOW)
    run.whole[ENERGY] = max(run.whole[ENERGY], energy)
    came = 0.0
    while True:
        if renewed:
            if not any_closed(row, run, span[0], span[1]):
                break
            touched, depth, speed, pace = scales(row, run, span[0], span[1])
            origin = touched - moment
            group = Group(span[0], span[1], low, high, origin, pull, rise, depth, speed)
            tolerance = rtol
            for k in range(row.start[span[0]], row.start[span[1]]):
                if run.book[k, CLOSED] > 0.0:
                    tolerance = own_tolerance(run, k, tolerance)
            s = sqrt(sqrt(max(t - origin, 0.0)))
            h = sqrt(sqrt(max(t - origin, 0.0) + pace)) - s
            now, renewed, known = moment + origin, False, False
        left = sqrt(sqrt(step - group.origin)) - s
        if left <= 1e-13 * s or t >= step:
            t = step
            break
        if run.whole[STEPS] > MAX_STEPS:
            run.whole[STATUS] = float(EXHAUSTED)
            return FAILED, t, -1
        fill_spectators(row, run, group, watch, t - base, terms, NOW)
        if known:
            for i in range(low, high):
                run.desk[SLOPE, i] = run.desk[SLOPE + LAST, i]
                run.desk[SLOPE + SLOPES, i] = run.desk[SLOPE + SLOPES + LAST, i]
            for column in range(2 * run.gaps.size + 1):
                run.quads[0, column] = run.quads[LAST, column]
        else:
            slopes(row, run, law, group, s, NOW, 0)
        moved, kind, k, h, attempts, laid = take_step(row, run, law, group, watch, (s, h, base), left, terms, tolerance)
        run.whole[STEPS] += attempts
        if moved <= 0.0 and kind == NONE:
            run.whole[STATUS] = float(UNDERFLOW if moved == 0.0 else NOT_FINITE)
            return FAILED, t, -1
        if kind == TOUCH and not row.start[span[0]] <= k < row.start[span[1]]:
            # A neighbour that has only looked on is struck: the interval is made again with it in the group.
            edge = span[0] - 1 if k < row.start[span[0]] else span[1]
            return GROW, t, edge
        laid = watch_floors(row, run, law, group, (s, moved, base), terms, laid)
        watch_points(row, run, law, group, watch, (s, moved, base), terms, now, laid)
        s += moved
        t = group.origin + s * s * s * s
        came += close_step(row, run, group)
        for each in range(row.start[span[0]], row.start[span[1]]):
            run.book[each, PACE] = (s + h) ** 4 - s**4
        stalled = stalled + 1 if moved <= 1e-12 * s else 0
        if stalled > 50 + row.ends.shape[0]:
            run.whole[STATUS] = float(UNDERFLOW)
            return FAILED, t, -1
        known = kind == NONE
        if kind != NONE:
            renewed, jump = happen(row, run, law, rule, kind, k, moment + t, NOW)
            came += jump
            if kind == TOUCH:
                press(row, run, law, rule, group, moment + t, pull + rise * t)
            if renewed and too_many(row, run, span):
                run.whole[STATUS] = float(TOO_MANY_CONTACTS)
                return FAILED, t, -1
    after = group_energy(row, run, group, NOW)
    run.whole[ENERGY] = max(run.whole[ENERGY], after)
    run.whole[RESIDUAL] += after - energy - came
    return FLOWN, t, -1


@kernel
def too_many(row, run, span):
    """True where a contact point has had more contacts than a run may."""
    for k in range(row.start[span[0]], row.start[span[1]]):
        if run.tally[k, TOUCHES] > MAX_CONTACTS:
            return True
    return False


@kernel
def advance(row, run, law, rule, span, watch, window, terms, rtol):
    """A group over one node interval, from rows NODE to rows NOW.

    Returns (FLOWN, −1), (GROW, interface that must be tied too) or (FAILED, −1), the run's status set.
    """
    moment, step, pull, rise = window
    group = Group(span[0], span[1], row.first[span[0]], row.first[span[1] + 1], 0.0, pull, rise, 1.0, 1.0)
    copy_state(row, run, watch[0], watch[1], NODE, NOW)
    t = base = 0.0
    lay_all(row, run, watch, pull, rise, terms)
    turns = 0
    while True:
        press(row, run, law, rule, group, moment + t, pull + rise * t)
        if any_closed(row, run, span[0], span[1]):
            how, t, edge = collide_group(row, run, law, rule, span, watch, window, t, base, terms, rtol)
            if how != FLOWN:
                return how, edge
            if t >= step:
                return FLOWN, -1
            fill_spectators(row, run, group, watch, t - base, terms, NOW)
            base = t
            lay_all(row, run, watch, pull + rise * t, rise, terms)
        left = step - t
        flown, edge, storey = fly_group(row, run, group, watch, left, pull + rise * t, rise, terms)
        if edge >= 0:
            return GROW, edge
        for b in range(watch[0], watch[1] + 1):
            place_on(row, run, b, flown, terms, NOW)
        t += flown
        if flown >= left:
            return FLOWN, -1
        turns += 1
        if turns > MAX_CONTACTS:
            run.whole[STATUS] = float(TOO_MANY_CONTACTS)
            return FAILED, -1
        if storey >= 0:
            switch_storey(row, run, storey, NOW)
        else:
            strike(row, run, law, rule, group, moment + t)
        base = t
        lay_all(row, run, watch, pull + rise * t, rise, terms)


@kernel
def strike(row, run, law, rule, group, time):
    """Begin the contact that a flight has ended on: the open point that stands closest to its gap and closes."""
    best, which = -inf, -1
    for k in range(row.start[group.first], row.start[group.last]):
        if run.book[k, CLOSED] == 0.0 and compliance(row, k) > 0.0:
            delta = across(row, k, run.desk, NOW) - run.book[k, GAP]
            if delta > best and across(row, k, run.desk, NOW + 1) > 0.0:
                best, which = delta, k
    if which >= 0:
        touch_down(row, run, law, rule, which, time)
