"""One contact, from the touch to the moment the bodies part, and what it leaves in the tally."""

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
from pounding_risk.solver.pair.events import (
    NONE,
    PART,
    TURN,
    YIELD,
    dip_of,
    settle,
    switched,
    take_step,
)
from pounding_risk.solver.pair.flight import SIGNALS
from pounding_risk.solver.pair.implicit import choose_method
from pounding_risk.solver.pair.peaks import watch_step
from pounding_risk.solver.pair.readings import FORCE
from pounding_risk.solver.pair.stages import (
    ELASTIC,
    LAST,
    REBOUND_SHARE,
    YIELDING,
    Impact,
    Phase,
    begin,
    energy_of,
    slopes,
    state_of,
    transmitted,
)
from pounding_risk.solver.pair.step import spread
from pounding_risk.solver.pair.taylor import (
    END,
    HERE,
    HERE_SLOPE,
    HIGH,
    NEXT,
    NEXT_SLOPE,
    STAGES,
    STATE,
    TALLY,
)


@kernel
def write_step(log, time, force, state, desk):
    """Append one row of the time history in contact, each building seen from its own ground."""
    row = log.used[1]
    if row < log.steps.shape[0]:
        log.steps[row, 0] = time
        for part in range(4):
            log.steps[row, 1 + part] = state[part]
        log.steps[row, 5] = force
        log.steps[row, 6] = desk[STATE, 4]
        log.steps[row, 7] = desk[STATE, 5]
    log.used[1] = row + 1


@kernel
def touch_down(impact, held, touched, speed, desk):
    """Enter a new contact in the tally; returns the mechanical energy at the touch."""
    state = state_of(desk, STATE)
    if desk[TALLY, COUNT] == 0.0:
        desk[TALLY, FIRST_TOUCH] = touched
    desk[TALLY, COUNT] += 1.0
    desk[TALLY, APPROACH] = max(desk[TALLY, APPROACH], speed)
    desk[TALLY, HELD] += 1.0 if held else 0.0
    energy = energy_of((impact.left, impact.right), state)
    desk[TALLY, ENERGY] = max(desk[TALLY, ENERGY], energy)
    return energy


@kernel
def lift_off(impact, energy, peaks, yielding, duration, desk):
    """Close a contact in the tally.

    ``peaks`` = (uncapped force, transmitted force, penetration), ``yielding`` = (dent, energy lost with it).
    """
    state = state_of(desk, STATE)
    delta = max(state[0] - state[1] - impact.gap, 0.0)
    after = energy_of((impact.left, impact.right), state)
    work = desk[STATE, 4]
    desk[TALLY, ENERGY] = max(desk[TALLY, ENERGY], after)
    desk[TALLY, RESIDUAL] += after - energy - (desk[STATE, 6] - work)
    loss = work - impact.law.held(impact.memory, delta, impact.strength) - yielding[1]
    hysteresis = impact.law.yielded(loss)
    desk[TALLY, VISCOUS] += loss - hysteresis
    desk[TALLY, PLASTIC] += yielding[1] + hysteresis
    desk[TALLY, SET] += yielding[0]
    desk[TALLY, WORN] = impact.law.worn(impact.memory)
    desk[TALLY, CONTACT_TIME] += duration
    desk[TALLY, IMPULSE] += desk[STATE, 5]
    desk[TALLY, DEMAND] = max(desk[TALLY, DEMAND], peaks[0])
    desk[TALLY, PEAK_FORCE] = max(desk[TALLY, PEAK_FORCE], peaks[1])
    desk[TALLY, PENETRATION] = max(desk[TALLY, PENETRATION], peaks[2])
    desk[HIGH, 0] = max(desk[HIGH, 0], impact.gap - yielding[0] + peaks[2])


@kernel
def write_contact(log, values, desk):
    """Append one row to the list of contacts."""
    row = log.used[0]
    if row < log.contacts.shape[0]:
        state = state_of(desk, STATE)
        for column in range(8):
            log.contacts[row, column] = values[column]
        log.contacts[row, 8] = state[3] - state[2]
        log.contacts[row, 9] = desk[STATE, 5]
        log.contacts[row, 10] = desk[STATE, 4]
        log.contacts[row, 11] = log.used[1]
    log.used[0] = row + 1


@small
def widened(impact, memory, dent):
    """The contact with a gap that is wider by a dent, and what it remembers since."""
    i = impact
    return Impact(i.left, i.right, i.law, i.gap + dent, i.strength, i.least, memory, i.speed, i.depth, i.still)


@kernel
def mark_levels(impact, phase, span, peak, desk, log):
    """Time the levels that the uncapped force reaches first on this step, ``span`` = (s, length, time of touch)."""
    s, h, touched = span
    while log.used[2] < log.levels.size and log.levels[log.used[2]] <= peak:
        level = log.levels[log.used[2]]
        length = 0.0
        if desk[HERE, FORCE] < level:
            i = impact
            watched = Impact(i.left, i.right, i.law, i.gap, level, i.least, i.memory, i.speed, i.depth, i.still)
            spread(impact, phase, (s, h), desk)
            place = min(dip_of(YIELD, watched, phase, (s, h), desk), 1.0)
            length = h * min(settle(YIELD, place, watched, phase, (s, h), desk), 1.0)
        square = (s + length) * (s + length)
        log.first[log.used[2]] = touched + square * square
        log.used[2] += 1


@kernel
def pound(pair, free, law, limits, rtol, start, state, desk, log):
    """One contact from the touch at ``start`` = (node, time after it) to the moment the bodies part.

    Returns (how it ended, node, time after it, state then).
    """
    node, offset = start
    right = pair[1]
    ground = free.passage.stretch(free.ground, free.step, node, offset)
    state = ground.across(right, state, 0.0)
    impact, speed, e = begin(pair, free.fastest, law, limits, state, desk[TALLY, WORN])
    rtol = min(rtol, REBOUND_SHARE * e)
    desk[STATE, :8] = 0.0
    for part in range(4):
        desk[STATE, part] = state[part]
    touched = free.passage.moment(free.step, node) + offset
    energy = touch_down(impact, limits[2].beyond(speed), touched, speed, desk)
    # Where nobody asks for this contact's own peak, only one above the run's peak so far is worth the search.
    each = log.levels.size > 0 or log.contacts.shape[0] > 0
    peak = 0.0 if each else desk[TALLY, DEMAND]
    plateau, depth, yielded, stalled, known = 0.0, 0.0, 0, 0, False
    dented, lost = 0.0, 0.0
    since = -offset  # of the current node, after the touch
    s, h = 0.0, sqrt(sqrt(0.3 * impact.depth / impact.speed))
    phase = Phase(True, ELASTIC, ground)
    slopes(impact, phase, s, state, desk, STAGES)
    write_step(log, touched, transmitted(impact, phase, state), ground.apart(right, state, 0.0), desk)
    desk[TALLY, IMPLICIT], unsettled = 0.0, True
    finish = EXHAUSTED
    while desk[TALLY, STEPS] < MAX_STEPS:
        if desk[TALLY, WORKED] > WORK_AT_LEAST + WORK_A_SECOND * (touched + s * s * s * s):
            break
        left = sqrt(sqrt(max(since + free.passage.width(free.step, node), 0.0))) - s
        if left <= 1e-13 * s:
            node += 1
            if node >= free.ground.size - 1:
                finish = AT_END
                break
            since = free.passage.moment(free.step, node) - touched
            ground = free.passage.stretch(free.ground, free.step, node, -since)
            phase = Phase(phase.approaching, phase.region, ground)
            slopes(impact, phase, s, state, desk, STAGES)
            continue
        if unsettled:
            choose_method(impact, phase, s, min(h, left), desk)
        moved, event, h, attempts = take_step(impact, phase, (s, h, left, known), rtol, desk)
        desk[TALLY, STEPS] += attempts
        # Steps that are refused, and events, are where a damper may be found too quick for an explicit step.
        unsettled = attempts > 1 or event != NONE or desk[TALLY, IMPLICIT] > 0.0
        if moved <= 0.0 and event == NONE:
            finish = UNDERFLOW if moved == 0.0 else NOT_FINITE
            break
        before = peak
        peak = watch_step(impact, phase, (s, moved), peak, desk)
        # The step may end on another event where the force just meets F_E: that counts as well.
        met = event == YIELD or (yielded == 0 and peak > before and peak >= impact.strength)
        if log.levels.size > 0:
            mark_levels(impact, phase, (s, moved, touched), peak, desk, log)
        s += moved
        for part in range(7):
            desk[STATE, part] = desk[END, part]
        state = state_of(desk, STATE)
        since_touch = s * s * s * s
        time = touched + since_touch
        delta = state[0] - state[1] - impact.gap
        if phase.region == YIELDING:
            plateau = max(plateau, transmitted(impact, phase, state))
        write_step(log, time, transmitted(impact, phase, state), ground.apart(right, state, since_touch), desk)
        # Events that follow each other without progress are rounding; a few are harmless, many are a defect.
        stalled = stalled + 1 if moved <= 1e-12 * s else 0
        if event == PART or stalled > 50:
            finish = FINISHED if event == PART else UNDERFLOW
            break
        retraced = True
        if event == TURN:
            impact = widened(impact, law.turned(impact.memory, delta, phase.approaching), 0.0)
        if event == TURN and phase.approaching:
            depth = max(depth, delta + dented)
            if phase.region == YIELDING:
                memory, dent, taken = law.turn(impact.memory, delta, impact.strength)
                if dent >= 0.0:
                    # What stays widens the gap, here and for the contacts after this one.
                    impact = widened(impact, memory, dent)
                    dented, lost, retraced = dented + dent, lost + taken, False
        if met and phase.region == ELASTIC:
            peak, plateau = max(peak, impact.strength), max(plateau, impact.strength)
            yielded += 1
            if yielded == 1:
                desk[TALLY, YIELDS] += 1.0
                if desk[TALLY, YIELDS] == 1.0:
                    desk[TALLY, FIRST_YIELD] = time
        known = event == NONE
        if known:
            for part in range(7):
                desk[STAGES, part] = desk[LAST, part]
            for watch in range(SIGNALS):
                desk[HERE, watch] = desk[NEXT, watch]
                desk[HERE_SLOPE, watch] = desk[NEXT_SLOPE, watch]
        else:
            phase = switched(event, phase)
            if not retraced:
                phase = Phase(phase.approaching, ELASTIC, phase.ground)
            slopes(impact, phase, s, state, desk, STAGES)
    depth = max(depth, state[0] - state[1] - impact.gap + dented)
    duration = s * s * s * s
    force = plateau if yielded > 0 else min(peak, impact.strength)
    for level in range(log.levels.size):
        log.reached[level] += 1.0 if log.levels[level] <= peak else 0.0
    lift_off(impact, energy, (peak, force, depth), (dented, lost), duration, desk)
    write_contact(log, (touched, touched + duration, speed, e, force, peak, depth, float(yielded)), desk)
    return finish, node, duration - since, ground.apart(right, state, duration)
