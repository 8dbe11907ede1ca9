"""One contact, from the touch to the moment the bodies part, and its entries in the counters."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import (
    APPROACH,
    AT_END,
    CONTACT_TIME,
    COUNT,
    DAMAGE,
    DEMAND,
    ENERGY,
    EXHAUSTED,
    FINISHED,
    FIRST_TOUCH,
    FIRST_YIELD,
    HELD,
    IMPLICIT,
    IMPULSE,
    MAX_STEPS,
    NOT_FINITE,
    PEAK_FORCE,
    PENETRATION,
    PLASTIC,
    RESIDUAL,
    SET,
    STEPS,
    UNDERFLOW,
    VISCOUS,
    WORK_A_SECOND,
    WORK_AT_LEAST,
    WORKED,
    YIELDS,
)
from pounding_risk.solver.pair.equations import (
    ELASTIC,
    REBOUND_SHARE,
    YIELDING,
    Impact,
    Phase,
    energy_of,
    new_impact,
    slopes,
    state_of,
    transmitted,
)
from pounding_risk.solver.pair.events import KNEE, NONE, PART, TURN, YIELD, dip_of, refine_event, switched, take_step
from pounding_risk.solver.pair.implicit import choose_method, write_polynomial
from pounding_risk.solver.pair.law_verbs import law_ends, law_turns
from pounding_risk.solver.pair.peaks import FORCE, update_peaks
from pounding_risk.solver.workspace import BEGIN, END, FELT, FIRST_STAGE, LAST, SIGNALS

PASSES_NODES = 1e-3  # the rtol from which on steps pass nodes between samples


@kernel
def write_step(log, time, force, state, workspace):
    """Append one row of the time history in contact, each building seen from its own ground."""
    row = log.used[1]
    if row < log.steps.shape[0]:
        log.steps[row, 0] = time
        for part in range(4):
            log.steps[row, 1 + part] = state[part]
        log.steps[row, 5] = force
        log.steps[row, 6] = workspace.states[BEGIN, 4]
        log.steps[row, 7] = workspace.states[BEGIN, 5]
    log.used[1] = row + 1


@kernel
def touch_down(impact, beyond_range, touched, speed, workspace):
    """Enter a new contact in the counters; returns the mechanical energy at the touch."""
    state = state_of(workspace.states, BEGIN)
    if workspace.counters[COUNT] == 0.0:
        workspace.counters[FIRST_TOUCH] = touched
    workspace.counters[COUNT] += 1.0
    workspace.counters[APPROACH] = max(workspace.counters[APPROACH], speed)
    workspace.counters[HELD] += 1.0 if beyond_range else 0.0
    energy = energy_of((impact.left, impact.right), state)
    workspace.counters[ENERGY] = max(workspace.counters[ENERGY], energy)
    return energy


@kernel
def lift_off(impact, energy_at_touch, peaks, yielding, duration, workspace):
    """Close a contact in the counters.

    ``peaks`` = (uncapped force, transmitted force, penetration), ``yielding`` = (indentation, energy lost with it).
    """
    state = state_of(workspace.states, BEGIN)
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    energy_after = energy_of((impact.left, impact.right), state)
    work = workspace.states[BEGIN, 4]
    workspace.counters[ENERGY] = max(workspace.counters[ENERGY], energy_after)
    workspace.counters[RESIDUAL] += energy_after - energy_at_touch - (workspace.states[BEGIN, 6] - work)
    loss, hysteresis, damage = law_ends(impact.law, impact.memory, delta, impact.strength, work, yielding[1])
    workspace.counters[VISCOUS] += loss - hysteresis
    workspace.counters[PLASTIC] += yielding[1] + hysteresis
    workspace.counters[SET] += yielding[0]
    workspace.counters[DAMAGE] = damage
    workspace.counters[CONTACT_TIME] += duration
    workspace.counters[IMPULSE] += workspace.states[BEGIN, 5]
    workspace.counters[DEMAND] = max(workspace.counters[DEMAND], peaks[0])
    workspace.counters[PEAK_FORCE] = max(workspace.counters[PEAK_FORCE], peaks[1])
    workspace.counters[PENETRATION] = max(workspace.counters[PENETRATION], peaks[2])
    workspace.high[0] = max(workspace.high[0], impact.gap - yielding[0] + peaks[2])


@kernel
def write_contact(log, values, workspace):
    """Append a row to ``log.contacts``: ``values`` are its first eight columns, the others those at BEGIN."""
    row = log.used[0]
    if row < log.contacts.shape[0]:
        state = state_of(workspace.states, BEGIN)
        for column in range(8):
            log.contacts[row, column] = values[column]
        log.contacts[row, 8] = state[3] - state[2]
        log.contacts[row, 9] = workspace.states[BEGIN, 5]
        log.contacts[row, 10] = workspace.states[BEGIN, 4]
        log.contacts[row, 11] = log.used[1]
    log.used[0] = row + 1


@small
def clock_at(time):
    """The clock s of a contact at a time after the touch [s]."""
    return sqrt(sqrt(max(time, 0.0)))


@small
def nodes_ahead(free, node, rtol):
    """How many nodes ahead a step may reach: to the next, or where few digits are asked for to the next sample.

    A step that is tried across nodes within a sample is refused more often; from four digits on that costs more than
    ending steps at nodes.
    """
    return free.passage.straight(node) if rtol >= PASSES_NODES else 1


@small
def changed(impact, memory, indentation, knee):
    """The contact with a gap that is wider by an indentation, a new memory of the law, and another knee ahead."""
    i = impact
    return Impact(
        i.left,
        i.right,
        i.law,
        i.gap + indentation,
        i.strength,
        i.least_force,
        memory,
        i.speed_scale,
        i.depth_scale,
        i.still_speed,
        knee,
    )


@kernel
def mark_levels(impact, phase, span, peak, workspace, log):
    """Time the levels that the uncapped force reaches first on this step, ``span`` = (s, length, time of touch)."""
    s, h, touched = span
    while log.used[2] < log.levels.size and log.levels[log.used[2]] <= peak:
        level = log.levels[log.used[2]]
        length = 0.0
        if workspace.readings[BEGIN, FORCE] < level:
            i = impact
            impact_of_level = Impact(
                i.left,
                i.right,
                i.law,
                i.gap,
                level,
                i.least_force,
                i.memory,
                i.speed_scale,
                i.depth_scale,
                i.still_speed,
                i.knee_depth,
            )
            write_polynomial(impact, phase, (s, h), workspace)
            fraction = min(dip_of(YIELD, impact_of_level, phase, (s, h), workspace), 1.0)
            length = h * min(refine_event(YIELD, fraction, impact_of_level, phase, (s, h), workspace), 1.0)
        square = (s + length) * (s + length)
        log.first[log.used[2]] = touched + square * square
        log.used[2] += 1


@small
def stretch_from(free, node, since, rtol):
    """(nodes, clock at its end) of the segment of ground motion after a node, ``since`` [s] after the touch."""
    nodes = nodes_ahead(free, node, rtol)
    return nodes, clock_at(since + nodes * free.passage.width(free.step, node))


@small
def begin_at_step_end(workspace):
    """Slopes and readings at the end of a step become those at the beginning of the next one."""
    for part in range(FELT + 1):
        workspace.slopes[FIRST_STAGE, part] = workspace.slopes[LAST, part]
    for signal in range(SIGNALS):
        workspace.readings[BEGIN, signal] = workspace.readings[END, signal]
        workspace.reading_slopes[BEGIN, signal] = workspace.reading_slopes[END, signal]


@small
def turn_motion(impact, phase, delta):
    """(contact, indentation or a number that is not at least 0, energy lost with it) once the motion has turned at δ.

    An indentation stays: it widens the gap, here and for the contacts after this one.
    """
    yielding = phase.region == YIELDING
    memory, indentation, energy_lost, knee = law_turns(
        impact.law, impact.memory, delta, impact.strength, phase.approaching, yielding
    )
    return changed(impact, memory, max(indentation, 0.0), knee), indentation, energy_lost


@small
def count_yield(yields, time, workspace):
    """Enter in the counters that the uncapped force has met F_E, for the first of the ``yields`` of a contact."""
    if yields == 1:
        workspace.counters[YIELDS] += 1.0
        if workspace.counters[YIELDS] == 1.0:
            workspace.counters[FIRST_YIELD] = time


@small
def close_contact(impact, touch, peaks, yielding, duration, workspace, log):
    """Enter a contact that has ended in the counters and in the log.

    ``touch`` = (time, approach speed, restitution, energy then), ``peaks`` = (uncapped force, force past yield,
    penetration), ``yielding`` = (times, indentation, energy lost with indentations).
    """
    touched, speed, e, energy = touch
    peak, plateau, depth = peaks
    yields, indented, lost = yielding
    force = plateau if yields > 0 else min(peak, impact.strength)
    for level in range(log.levels.size):
        log.reached[level] += 1.0 if log.levels[level] <= peak else 0.0
    lift_off(impact, energy, (peak, force, depth), (indented, lost), duration, workspace)
    write_contact(log, (touched, touched + duration, speed, e, force, peak, depth, float(yields)), workspace)


@small
def node_before(free, node, nodes, time):
    """(node, time after it) of a time after the first node of a segment of so many nodes."""
    width = free.passage.width(free.step, node)
    while nodes > 1 and time >= width:
        node, time, nodes = node + 1, time - width, nodes - 1
    return node, time


@kernel
def integrate_contact(pair, free, law, limits, rtol, start, state, workspace, log):
    """One contact from the touch at ``start`` = (node, time after it) to the moment the bodies part.

    ``state`` = (u_left, u_right, v_left, v_right) is that at the touch, each building seen from its own ground. Leaves
    what the contact has done in the counters, the largest and smallest signals and the log. Returns (how it ended,
    node, time after it, state then).
    """
    node, offset = start
    right = pair[1]
    ground = free.passage.interval(free.ground, free.step, node, offset)
    state = ground.across(right, state, 0.0)
    impact, speed, e = new_impact(pair, free.fastest, law, limits, state, workspace.counters[DAMAGE])
    rtol = min(rtol, REBOUND_SHARE * e)
    workspace.states[BEGIN, :] = 0.0
    for part in range(4):
        workspace.states[BEGIN, part] = state[part]
    touched = free.passage.moment(free.step, node) + offset
    energy = touch_down(impact, limits.restitution.beyond(speed), touched, speed, workspace)
    # Where no contact's own peak is logged, only a force above the run's peak so far needs to be searched for.
    logs_contacts, logs_steps = log.levels.size > 0 or log.contacts.shape[0] > 0, log.steps.shape[0] > 0
    peak = 0.0 if logs_contacts else workspace.counters[DEMAND]
    plateau, depth, yields, stalled, has_readings = 0.0, 0.0, 0, 0, False
    indented, lost = 0.0, 0.0
    # The present segment of ground motion: its first node, after the touch, its nodes, and the clock at its end.
    since = -offset
    nodes, until = stretch_from(free, node, since, rtol)
    s, h = 0.0, sqrt(sqrt(0.3 * impact.depth_scale / impact.speed_scale))
    phase = Phase(True, ELASTIC, ground)
    slopes(impact, phase, s, state, workspace, FIRST_STAGE)
    if logs_steps:
        write_step(
            log, touched, transmitted(impact, phase, state), ground.from_own_ground(right, state, 0.0), workspace
        )
    workspace.counters[IMPLICIT], unsettled = 0.0, True
    finish = EXHAUSTED
    while workspace.counters[STEPS] < MAX_STEPS:
        if workspace.counters[WORKED] > WORK_AT_LEAST + WORK_A_SECOND * (touched + s * s * s * s):
            break
        remaining = until - s
        if remaining <= 1e-13 * s:
            node += nodes
            if node >= free.ground.size - 1:
                finish = AT_END
                break
            since = free.passage.moment(free.step, node) - touched
            nodes, until = stretch_from(free, node, since, rtol)
            ground = free.passage.interval(free.ground, free.step, node, -since)
            phase = Phase(phase.approaching, phase.region, ground)
            slopes(impact, phase, s, state, workspace, FIRST_STAGE)
            continue
        if unsettled:
            choose_method(impact, phase, s, min(h, remaining), workspace)
        length, event, h, attempts = take_step(impact, phase, (s, h, remaining, has_readings), rtol, workspace)
        workspace.counters[STEPS] += attempts
        # Steps that are refused, and events, are where a damper may be found too quick for an explicit step.
        unsettled = attempts > 1 or event != NONE or workspace.counters[IMPLICIT] > 0.0
        if length <= 0.0 and event == NONE:
            finish = UNDERFLOW if length == 0.0 else NOT_FINITE
            break
        peak_before = peak
        peak = update_peaks(impact, phase, (s, length), peak, workspace)
        # The step may end on another event where the force just meets F_E: that counts as well.
        meets_strength = event == YIELD or (yields == 0 and peak > peak_before and peak >= impact.strength)
        if log.levels.size > 0:
            mark_levels(impact, phase, (s, length, touched), peak, workspace, log)
        s += length
        for part in range(7):
            workspace.states[BEGIN, part] = workspace.states[END, part]
        state = state_of(workspace.states, BEGIN)
        since_touch = s * s * s * s
        if phase.region == YIELDING:
            plateau = max(plateau, transmitted(impact, phase, state))
        if logs_steps:
            apart = ground.from_own_ground(right, state, since_touch)
            write_step(log, touched + since_touch, transmitted(impact, phase, state), apart, workspace)
        # Events that follow each other without progress are rounding; a few are harmless, many are a defect.
        stalled = stalled + 1 if length <= 1e-12 * s else 0
        if event == PART or stalled > 50:
            finish = FINISHED if event == PART else UNDERFLOW
            break
        indentation = -1.0
        if event == TURN:
            delta = state[0] - state[1] - impact.gap
            if phase.approaching:
                depth = max(depth, delta + indented)
            impact, indentation, energy_lost = turn_motion(impact, phase, delta)
            if indentation >= 0.0:
                indented, lost = indented + indentation, lost + energy_lost
        elif event == KNEE:
            impact = changed(impact, impact.memory, 0.0, inf)
        if meets_strength and phase.region == ELASTIC:
            peak, plateau = max(peak, impact.strength), max(plateau, impact.strength)
            yields += 1
            count_yield(yields, touched + since_touch, workspace)
        has_readings = event == NONE
        if has_readings:
            begin_at_step_end(workspace)
        else:
            phase = switched(event, phase)
            if indentation >= 0.0:
                phase = Phase(phase.approaching, ELASTIC, phase.ground)
            slopes(impact, phase, s, state, workspace, FIRST_STAGE)
    depth = max(depth, state[0] - state[1] - impact.gap + indented)
    duration = s * s * s * s
    close_contact(
        impact, (touched, speed, e, energy), (peak, plateau, depth), (yields, indented, lost), duration, workspace, log
    )
    node, after_node = node_before(free, node, nodes, duration - since)
    return finish, node, after_node, ground.from_own_ground(right, state, duration)
