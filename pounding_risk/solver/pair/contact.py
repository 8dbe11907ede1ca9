"""One contact, from the touch to the moment the bodies part, and its entries in the counters."""

from __future__ import annotations

from math import sqrt

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import (
    APPROACH,
    AT_END,
    CONTACT_TIME,
    COUNT,
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
    WORN,
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
from pounding_risk.solver.pair.events import NONE, PART, TURN, YIELD, dip_of, refine_event, switched, take_step
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

    ``peaks`` = (uncapped force, transmitted force, penetration), ``yielding`` = (dent, energy lost with it).
    """
    state = state_of(workspace.states, BEGIN)
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    energy_after = energy_of((impact.left, impact.right), state)
    work = workspace.states[BEGIN, 4]
    workspace.counters[ENERGY] = max(workspace.counters[ENERGY], energy_after)
    workspace.counters[RESIDUAL] += energy_after - energy_at_touch - (workspace.states[BEGIN, 6] - work)
    loss, hysteresis, worn = law_ends(impact.law, impact.memory, delta, impact.strength, work, yielding[1])
    workspace.counters[VISCOUS] += loss - hysteresis
    workspace.counters[PLASTIC] += yielding[1] + hysteresis
    workspace.counters[SET] += yielding[0]
    workspace.counters[WORN] = worn
    workspace.counters[CONTACT_TIME] += duration
    workspace.counters[IMPULSE] += workspace.states[BEGIN, 5]
    workspace.counters[DEMAND] = max(workspace.counters[DEMAND], peaks[0])
    workspace.counters[PEAK_FORCE] = max(workspace.counters[PEAK_FORCE], peaks[1])
    workspace.counters[PENETRATION] = max(workspace.counters[PENETRATION], peaks[2])
    workspace.high[0] = max(workspace.high[0], impact.gap - yielding[0] + peaks[2])


@kernel
def write_contact(log, values, workspace):
    """Append one row to the list of contacts."""
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
def with_dent(impact, memory, dent):
    """The contact with a gap that is wider by a dent, and with a new memory of the law."""
    i = impact
    return Impact(
        i.left,
        i.right,
        i.law,
        i.gap + dent,
        i.strength,
        i.least_force,
        memory,
        i.speed_scale,
        i.depth_scale,
        i.still_speed,
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
            )
            write_polynomial(impact, phase, (s, h), workspace)
            fraction = min(dip_of(YIELD, impact_of_level, phase, (s, h), workspace), 1.0)
            length = h * min(refine_event(YIELD, fraction, impact_of_level, phase, (s, h), workspace), 1.0)
        square = (s + length) * (s + length)
        log.first[log.used[2]] = touched + square * square
        log.used[2] += 1


@kernel
def integrate_contact(pair, free, law, limits, rtol, start, state, workspace, log):
    """One contact from the touch at ``start`` = (node, time after it) to the moment the bodies part.

    Returns (how it ended, node, time after it, state then).
    """
    node, offset = start
    right = pair[1]
    ground = free.passage.stretch(free.ground, free.step, node, offset)
    state = ground.across(right, state, 0.0)
    impact, speed, e = new_impact(pair, free.fastest, law, limits, state, workspace.counters[WORN])
    rtol = min(rtol, REBOUND_SHARE * e)
    workspace.states[BEGIN, :] = 0.0
    for part in range(4):
        workspace.states[BEGIN, part] = state[part]
    touched = free.passage.moment(free.step, node) + offset
    energy = touch_down(impact, limits.restitution.beyond(speed), touched, speed, workspace)
    # Where no contact's own peak is logged, only a force above the run's peak so far needs to be searched for.
    logs_contacts, logs_steps = log.levels.size > 0 or log.contacts.shape[0] > 0, log.steps.shape[0] > 0
    peak = 0.0 if logs_contacts else workspace.counters[DEMAND]
    plateau, depth, yielded, stalled, known = 0.0, 0.0, 0, 0, False
    dented, lost = 0.0, 0.0
    # The present stretch of ground motion: its first node, after the touch, its nodes, and the clock at its end.
    since, ahead = -offset, nodes_ahead(free, node, rtol)
    until = clock_at(since + ahead * free.passage.width(free.step, node))
    s, h = 0.0, sqrt(sqrt(0.3 * impact.depth_scale / impact.speed_scale))
    phase = Phase(True, ELASTIC, ground)
    slopes(impact, phase, s, state, workspace, FIRST_STAGE)
    if logs_steps:
        write_step(log, touched, transmitted(impact, phase, state), ground.apart(right, state, 0.0), workspace)
    workspace.counters[IMPLICIT], unsettled = 0.0, True
    finish = EXHAUSTED
    while workspace.counters[STEPS] < MAX_STEPS:
        if workspace.counters[WORKED] > WORK_AT_LEAST + WORK_A_SECOND * (touched + s * s * s * s):
            break
        remaining = until - s
        if remaining <= 1e-13 * s:
            node += ahead
            if node >= free.ground.size - 1:
                finish = AT_END
                break
            since, ahead = free.passage.moment(free.step, node) - touched, nodes_ahead(free, node, rtol)
            until = clock_at(since + ahead * free.passage.width(free.step, node))
            ground = free.passage.stretch(free.ground, free.step, node, -since)
            phase = Phase(phase.approaching, phase.region, ground)
            slopes(impact, phase, s, state, workspace, FIRST_STAGE)
            continue
        if unsettled:
            choose_method(impact, phase, s, min(h, remaining), workspace)
        moved, event, h, attempts = take_step(impact, phase, (s, h, remaining, known), rtol, workspace)
        workspace.counters[STEPS] += attempts
        # Steps that are refused, and events, are where a damper may be found too quick for an explicit step.
        unsettled = attempts > 1 or event != NONE or workspace.counters[IMPLICIT] > 0.0
        if moved <= 0.0 and event == NONE:
            finish = UNDERFLOW if moved == 0.0 else NOT_FINITE
            break
        before = peak
        peak = update_peaks(impact, phase, (s, moved), peak, workspace)
        # The step may end on another event where the force just meets F_E: that counts as well.
        met = event == YIELD or (yielded == 0 and peak > before and peak >= impact.strength)
        if log.levels.size > 0:
            mark_levels(impact, phase, (s, moved, touched), peak, workspace, log)
        s += moved
        for part in range(7):
            workspace.states[BEGIN, part] = workspace.states[END, part]
        state = state_of(workspace.states, BEGIN)
        since_touch = s * s * s * s
        time = touched + since_touch
        delta = state[0] - state[1] - impact.gap
        if phase.region == YIELDING:
            plateau = max(plateau, transmitted(impact, phase, state))
        if logs_steps:
            write_step(log, time, transmitted(impact, phase, state), ground.apart(right, state, since_touch), workspace)
        # Events that follow each other without progress are rounding; a few are harmless, many are a defect.
        stalled = stalled + 1 if moved <= 1e-12 * s else 0
        if event == PART or stalled > 50:
            finish = FINISHED if event == PART else UNDERFLOW
            break
        retraced = True
        if event == TURN:
            if phase.approaching:
                depth = max(depth, delta + dented)
            yielding = phase.region == YIELDING
            memory, dent, taken = law_turns(law, impact.memory, delta, impact.strength, phase.approaching, yielding)
            retraced = not dent >= 0.0
            # What stays widens the gap, here and for the contacts after this one.
            impact = with_dent(impact, memory, 0.0 if retraced else dent)
            if not retraced:
                dented, lost = dented + dent, lost + taken
        if met and phase.region == ELASTIC:
            peak, plateau = max(peak, impact.strength), max(plateau, impact.strength)
            yielded += 1
            if yielded == 1:
                workspace.counters[YIELDS] += 1.0
                if workspace.counters[YIELDS] == 1.0:
                    workspace.counters[FIRST_YIELD] = time
        known = event == NONE
        if known:
            for part in range(FELT + 1):
                workspace.slopes[FIRST_STAGE, part] = workspace.slopes[LAST, part]
            for signal in range(SIGNALS):
                workspace.readings[BEGIN, signal] = workspace.readings[END, signal]
                workspace.reading_slopes[BEGIN, signal] = workspace.reading_slopes[END, signal]
        else:
            phase = switched(event, phase)
            if not retraced:
                phase = Phase(phase.approaching, ELASTIC, phase.ground)
            slopes(impact, phase, s, state, workspace, FIRST_STAGE)
    depth = max(depth, state[0] - state[1] - impact.gap + dented)
    duration = s * s * s * s
    force = plateau if yielded > 0 else min(peak, impact.strength)
    for level in range(log.levels.size):
        log.reached[level] += 1.0 if log.levels[level] <= peak else 0.0
    lift_off(impact, energy, (peak, force, depth), (dented, lost), duration, workspace)
    write_contact(log, (touched, touched + duration, speed, e, force, peak, depth, float(yielded)), workspace)
    after, width = duration - since, free.passage.width(free.step, node)
    while ahead > 1 and after >= width:
        node, after, ahead = node + 1, after - width, ahead - 1
    return finish, node, after, ground.apart(right, state, duration)
