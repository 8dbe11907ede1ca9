"""A group of neighbours over one node interval: flights and contacts in turn, while others fly on their own."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import (
    COLLAPSED,
    EXHAUSTED,
    IMPULSE,
    MAX_CONTACTS,
    MAX_STEPS,
    NOT_FINITE,
    TOO_MANY_CONTACTS,
    UNDERFLOW,
    WORK_A_SECOND,
    WORK_AT_LEAST,
)
from pounding_risk.solver.counters import COUNT as TOUCHES
from pounding_risk.solver.pair.equations import ELASTIC, SLACK, YIELDING
from pounding_risk.solver.pair.events import CUT, KNEE, NONE, PART, TURN, YIELD
from pounding_risk.solver.row.building import place_on
from pounding_risk.solver.row.contact import (
    lift_off,
    note_yield,
    scales,
    slowest_scale,
    tolerance_of,
    touch_down,
    turn_motion,
)
from pounding_risk.solver.row.contact_points import across, begin_unwatched_extremes, compliance
from pounding_risk.solver.row.equations import Group, accelerate_group, note_energy, slopes
from pounding_risk.solver.row.event_functions import CORNER, ROUNDED, STRAIN, TOUCH, event_function, is_possible
from pounding_risk.solver.row.events import fill_spectators, take_step
from pounding_risk.solver.row.flight_by_series import copy_state, fly_group, write_all_series, write_spectator_series
from pounding_risk.solver.row.implicit import choose_method
from pounding_risk.solver.row.law_events import note_event
from pounding_risk.solver.row.link import is_link_of
from pounding_risk.solver.row.peaks import update_floor_peaks, update_point_peaks
from pounding_risk.solver.row.storey import drift_in, has_law, switch_storey
from pounding_risk.solver.row.trace import write_line
from pounding_risk.solver.row.workspace import (
    CONSTANT,
    END,
    FIRST,
    LAST,
    NODE,
    NOW,
    SLOPE,
    SLOPES,
    START,
    TANGENT,
    TRIAL,
    VELOCITY,
)

FLOWN, GROW, FAILED = 0, 1, 2  # how a segment ends
ALIKE = 1e-13  # of a_g: neighbours at rest that begin to move alike press each other by rounding at most


@kernel
def any_closed(row, run, first, last):
    """True where a contact point between the buildings ``first`` to ``last`` is closed."""
    closed = False
    for k in range(row.frame[START, first], row.frame[START, last]):
        closed = closed or run.contacts[k].closed > 0.0
    return closed


@small
def touches(row, run, k):
    """True where contact point ``k`` is open with its gap closed, in rows NOW, to rounding."""
    if run.contacts[k].closed > 0.0 or compliance(row, k) == 0.0:
        return False
    return across(row, k, run.dofs, NOW) - run.contacts[k].gap >= -ROUNDED


@kernel
def begin_contacts(row, run, group, time, ground):
    """Begin every contact of the group that is about to press, its state in rows NOW.

    ``ground`` begins now. Returns the interface of a building that looks on and is pressed at once, or −1 for none.
    """
    ready = False
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if not touches(row, run, k):
            continue
        rate = across(row, k, run.dofs, NOW + VELOCITY)
        if rate == 0.0:
            # Closed at rest: what decides is how both sides would move on.
            if not ready:
                accelerate_group(row, run, group, NOW, ground, TRIAL)
                ready = True
            rate = across(row, k, run.dofs, TRIAL)
            if rate <= ALIKE * ground.largest_pull(group.first, group.last):
                continue
        if rate > 0.0:
            touch_down(row, run, k, time, slowest_scale(row, run, group.first, group.last, time))
    return begin_driven_contacts(row, run, group, time, ground)


@kernel
def begin_driven_contacts(row, run, group, time, ground):
    """Begin contacts that are closed at rest where a building is pressed against its neighbour by the one behind it.

    As the masses are lumped, a contact that begins at ``time`` moves all those that touch and would otherwise go on
    alike at once, however little; how soon that is more than rounding depends on the steps. Returns as
    `begin_contacts`.
    """
    has_begun = True
    while has_begun:
        has_begun = False
        for i in range(group.watched_first, group.watched_last):
            if not is_driven(row, run, group, i, time) or not go_on_alike(row, run, ground, i):
                continue
            for k in range(row.frame[START, i], row.frame[START, i + 1]):
                if touches(row, run, k):
                    if not group.first <= i < group.last:
                        return i
                    touch_down(row, run, k, time, slowest_scale(row, run, group.first, group.last, time))
                    has_begun = True
    return -1


@kernel
def go_on_alike(row, run, ground, i):
    """True where both buildings of interface ``i`` have the same motion from rows NOW on, as long as none is touched.

    They are equal, in the same state and under the same ground, or at rest and unloaded.
    """
    left, right, end = row.frame[FIRST, i], row.frame[FIRST, i + 1], row.frame[FIRST, i + 2]
    (pull, rise), (right_pull, right_rise) = ground.under(i), ground.under(i + 1)
    is_still = pull == 0.0 and rise == 0.0 and right_pull == 0.0 and right_rise == 0.0
    for d in range(left, end):
        is_moving = run.dofs[NOW, d] != 0.0 or run.dofs[NOW + VELOCITY, d] != 0.0 or run.dofs[CONSTANT, d] != 0.0
        is_still = is_still and not is_moving
    if is_still:
        return True
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, i, i + 1):
            return False
    are_alike = pull == right_pull and rise == right_rise and right - left == end - right
    if are_alike:
        for d in range(left, right):
            other = d + right - left
            for line in (NOW, NOW + VELOCITY, TANGENT, CONSTANT):
                are_alike = are_alike and run.dofs[line, d] == run.dofs[line, other]
            for number in range(row.floors.shape[0]):
                are_alike = are_alike and row.floors[number, d] == row.floors[number, other]
            for column in range(run.storeys.shape[1]):
                are_alike = are_alike and run.storeys[d, column] == run.storeys[other, column]
            for column in range(row.damping.shape[1]):
                are_alike = are_alike and row.damping[d, column] == row.damping[other, column]
            for column in range(row.coupling.shape[1]):
                are_alike = are_alike and row.coupling[d, column] == row.coupling[other, column]
            for column in range(row.inertia.shape[1]):
                are_alike = are_alike and row.inertia[d, column] == row.inertia[other, column]
    return are_alike


@kernel
def is_driven(row, run, group, i, time):
    """True where interface ``i`` is open and a contact of the next one, on either side, begins at ``time``."""
    if any_closed(row, run, i, i + 1):
        return False
    for beside in (i - 1, i + 1):
        if group.first <= beside < group.last:
            for k in range(row.frame[START, beside], row.frame[START, beside + 1]):
                if run.contacts[k].closed > 0.0 and run.contacts[k].touch_time == time:
                    return True
    return False


@kernel
def close_step(row, run, group):
    """Rows END become rows NOW, and the quadratures of the step go into the sums; returns the energy that came in."""
    points = run.laws.shape[0]
    for i in range(group.low, group.high):
        run.dofs[NOW, i] = run.dofs[END, i]
        run.dofs[NOW + VELOCITY, i] = run.dofs[END + VELOCITY, i]
    energy_in = run.quadratures[SLOPES, 2 * points]
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            run.contacts[k].counters[IMPULSE] += run.quadratures[SLOPES, k]
            run.contacts[k].work += run.quadratures[SLOPES, points + k]
            energy_in -= run.quadratures[SLOPES, points + k]
    return energy_in


@kernel
def apply_event(row, run, group, kind, k, time):
    """Apply an event to its contact or storey; returns (whether a contact began or ended, change of the potential)."""
    if kind in (STRAIN, CORNER):
        if k >= row.floors.shape[1]:
            link = k - row.floors.shape[1]
            note_event(run.links, link, kind == CORNER, across(row, link, run.dofs, NOW))
        elif has_law(run, k):
            note_event(run.storeys, k, kind == CORNER, drift_in(row, run.dofs, NOW, k))
        return False, switch_storey(row, run, k, NOW)
    contact = run.contacts[k]
    if kind == TURN:
        turn_motion(row, run, k, max(across(row, k, run.dofs, NOW) - contact.gap, 0.0))
    elif kind == YIELD:
        if int(contact.region) == ELASTIC:
            note_yield(run, k, time)
            contact.region = float(YIELDING)
        else:
            contact.region = float(ELASTIC)
    elif kind == KNEE:
        contact.knee_depth = inf
    elif kind == CUT:
        contact.region = float(ELASTIC if int(contact.region) == SLACK else SLACK)
    elif kind == PART:
        lift_off(row, run, k, time, NOW, contact.work)
        contact.work = 0.0
        return True, 0.0
    elif kind == TOUCH:
        contact.work = 0.0
        touch_down(row, run, k, time, slowest_scale(row, run, group.first, group.last, time))
        return True, 0.0
    return False, 0.0


@kernel
def resting_group(row, span, watch, ground, terms, rtol):
    """A group of the buildings of ``span`` that looks out to those of ``watch``, its clock and scales not set yet."""
    low, high = row.frame[FIRST, span[0]], row.frame[FIRST, span[1] + 1]
    return Group(span[0], span[1], low, high, 0.0, ground, 1.0, 1.0, watch[0], watch[1], terms, rtol)


@kernel
def group_in_contact(row, run, group, moment):
    """(the group with clock, scales and tolerance of its present contacts, length that its next step should have [s]).

    ``moment`` is the time of the node; the tolerance that ``group`` has is the largest.
    """
    touched, depth, speed, pace = scales(row, run, group.first, group.last)
    tolerance = group.tolerance
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            tolerance = tolerance_of(run, k, tolerance)
    g = group
    timed = Group(
        g.first,
        g.last,
        g.low,
        g.high,
        touched - moment,
        g.ground,
        depth,
        speed,
        g.watched_first,
        g.watched_last,
        g.terms,
        tolerance,
    )
    return timed, pace


@kernel
def begin_at_step_end(row, run, group):
    """Slopes at the end of a step become those at the start of the next one."""
    points = run.laws.shape[0]
    for i in range(group.low, group.high):
        run.dofs[SLOPE, i] = run.dofs[SLOPE + LAST, i]
        run.dofs[SLOPE + SLOPES, i] = run.dofs[SLOPE + SLOPES + LAST, i]
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        for column in (k, points + k):
            run.quadratures[0, column] = run.quadratures[LAST, column]
    run.quadratures[0, 2 * points] = run.quadratures[LAST, 2 * points]


@kernel
def note_next_step(row, run, group, s, h):
    """Note the time that a step of length ``h`` from s takes, for the clock of the next touch."""
    # Products: interpreted, a power is the library's, and rounds otherwise.
    start, end = s * s * s * s, (s + h) * (s + h) * (s + h) * (s + h)
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        run.contacts[k].next_step = end - start


@kernel
def is_exhausted(row, run, time):
    """True where a run has taken more steps, or evaluations, than one may up to this time [s]."""
    allowed = (WORK_AT_LEAST + WORK_A_SECOND * time) * row.floors.shape[1]
    return run.workspace.steps > MAX_STEPS or run.workspace.evaluations > allowed


@small
def fail(run, status):
    """Set the status of a run that cannot go on; returns FAILED."""
    run.workspace.status = float(status)
    return FAILED


@kernel
def integrate_contact(row, run, members, window, t, base):
    """Integrate a group with contacts from rows NOW at ``t`` after the node until all have parted or the interval ends.

    ``members`` is a `resting_group`, ``window`` = (time of the node, step, the ground motion), ``base`` the start of
    the spectators' series. Returns (how it ended, time after the node, interface of a touched spectator or −1).
    """
    moment, step, ground = window
    group = members
    has_changed, has_slopes, unsettled, stalled = True, False, True, 0
    run.workspace.implicit = 0.0
    s = h = 0.0
    energy_before = note_energy(row, run, group)
    energy_in = 0.0
    while True:
        if has_changed:
            if not any_closed(row, run, members.first, members.last):
                break
            group, pace = group_in_contact(row, run, members, moment)
            s = sqrt(sqrt(max(t - group.origin, 0.0)))
            h = sqrt(sqrt(max(t - group.origin, 0.0) + pace)) - s
            has_changed, has_slopes = False, False
            if run.workspace.line_room > 0.0:
                write_line(row, run, group, moment + t)
        remaining = sqrt(sqrt(step - group.origin)) - s
        if remaining <= 1e-13 * s or t >= step:
            t = step
            break
        if is_exhausted(row, run, moment + t):
            return fail(run, EXHAUSTED), t, -1
        fill_spectators(row, run, group, t - base, NOW)
        if has_slopes:
            begin_at_step_end(row, run, group)
        else:
            slopes(row, run, group, s, NOW, 0)
        if unsettled:
            choose_method(row, run, group, s, min(h, remaining))
        length, kind, k, h, attempts = take_step(row, run, group, (s, h, base), remaining)
        run.workspace.steps += attempts
        # Steps that are refused, and events, are where a damper may be found too quick for an explicit step.
        unsettled = attempts > 1 or kind != NONE or run.workspace.implicit > 0.0
        if length <= 0.0 and kind == NONE:
            return fail(run, UNDERFLOW if length == 0.0 else NOT_FINITE), t, -1
        if kind == TOUCH and not row.frame[START, group.first] <= k < row.frame[START, group.last]:
            # A neighbour that has only looked on is struck: the interval is repeated with it in the group.
            return GROW, t, group.first - 1 if k < row.frame[START, group.first] else group.last
        update_floor_peaks(row, run, group, (s, length, base))
        update_point_peaks(row, run, group, (s, length, base), moment + group.origin)
        s += length
        t = group.origin + s * s * s * s
        energy_in += close_step(row, run, group)
        if run.workspace.line_room > 0.0:
            write_line(row, run, group, moment + t)
        note_next_step(row, run, group, s, h)
        stalled = stalled + 1 if length <= 1e-12 * s else 0
        if stalled > 50 + row.ends.shape[0]:
            return fail(run, UNDERFLOW), t, -1
        has_slopes = kind == NONE
        if kind != NONE:
            has_changed, of_images, of_event = apply_with_mirror_images(row, run, group, kind, k, moment + t)
            energy_in = energy_in + of_images + of_event
            if int(run.workspace.status) == COLLAPSED:
                run.workspace.collapse_time = moment + t
                return FAILED, t, -1
            if kind == TOUCH:
                fill_spectators(row, run, group, t - base, NOW)
                edge = begin_contacts(row, run, group, moment + t, ground.later(t))
                if edge >= 0:
                    return GROW, t, edge
            if has_changed and too_many(row, run, group):
                return fail(run, TOO_MANY_CONTACTS), t, -1
    run.workspace.residual += note_energy(row, run, group) - energy_before - energy_in
    return FLOWN, t, -1


@kernel
def apply_with_mirror_images(row, run, group, kind, k, time):
    """Apply an event, and those of the mirror images of ``k``, whose event functions are its own to the last bit.

    One after the other they would be a rounding apart, and a row that is symmetric would not stay so. Returns (whether
    a contact began or ended, change of the potential of the images, of ``k`` [J]).
    """
    has_changed, of_images = False, 0.0
    if kind != TOUCH:
        value = event_function(row, run, kind, k, True)[0]
        first, last = row.frame[START, group.first], row.frame[START, group.last]
        if kind in (STRAIN, CORNER):
            first, last = group.low, group.high
            if k >= row.floors.shape[1]:
                first, last = row.floors.shape[1], row.floors.shape[1] + run.links.shape[0]
        for j in range(first, last):
            is_link = kind in (STRAIN, CORNER) and j >= row.floors.shape[1]
            if is_link and not is_link_of(run, j - row.floors.shape[1], group.first, group.last):
                continue
            if j != k and is_possible(row, run, kind, j) and event_function(row, run, kind, j, True)[0] == value:
                image_changed, change = apply_event(row, run, group, kind, j, time)
                has_changed, of_images = has_changed or image_changed, of_images + change
    event_changed, of_event = apply_event(row, run, group, kind, k, time)
    return has_changed or event_changed, of_images, of_event


@kernel
def too_many(row, run, group):
    """True where a contact point of the group has had more contacts than a run may."""
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].counters[TOUCHES] > MAX_CONTACTS:
            return True
    return False


@kernel
def solve_group(row, run, span, watch, window, terms, rtol):
    """A group over one node interval, from rows NODE to rows NOW.

    Returns (FLOWN, −1), (GROW, interface that must be tied too) or (FAILED, −1), the run's status set.
    """
    moment, step, ground = window
    group = resting_group(row, span, watch, ground, terms, rtol)
    copy_state(row, run, watch[0], watch[1], NODE, NOW)
    begin_unwatched_extremes(row, run, span, watch)
    t = base = 0.0
    write_spectator_series(row, run, span, watch, ground, terms)
    turns = 0
    while True:
        edge = begin_contacts(row, run, group, moment + t, ground.later(t))
        if edge >= 0:
            return GROW, edge
        if any_closed(row, run, span[0], span[1]):
            outcome, t, edge = integrate_contact(row, run, group, window, t, base)
            if outcome != FLOWN:
                return outcome, edge
            if t >= step:
                return FLOWN, -1
            fill_spectators(row, run, group, t - base, NOW)
        base = t
        ground_now = ground.later(t)
        write_all_series(row, run, watch, ground_now, terms)
        remaining = step - t
        flown, point, storey = fly_group(row, run, span, watch, remaining, ground_now, terms)
        if point >= 0 and not row.frame[START, span[0]] <= point < row.frame[START, span[1]]:
            return GROW, span[0] - 1 if point < row.frame[START, span[0]] else span[1]
        for b in range(watch[0], watch[1] + 1):
            place_on(row, run, b, flown, terms, NOW)
        t += flown
        if flown >= remaining:
            return FLOWN, -1
        turns += 1
        if turns > MAX_CONTACTS:
            return fail(run, TOO_MANY_CONTACTS), -1
        if storey >= 0:
            switch_storey(row, run, storey, NOW)
            if int(run.workspace.status) == COLLAPSED:
                run.workspace.collapse_time = moment + t
                return FAILED, -1
        else:
            # Neighbours that start from rest with a closed gap may meet before their speed is more than rounding.
            touch_down(row, run, point, moment + t, slowest_scale(row, run, span[0], span[1], moment + t))
        base = t
        write_spectator_series(row, run, span, watch, ground.later(t), terms)
