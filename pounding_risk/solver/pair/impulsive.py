"""A touch whose velocities jump.

What rebounds slower than rtol times the fastest free closing speed, onto a building that presses on it, does not
rebound: bounces shrink by e each, so what is left of a train of them then is a relative displacement of the order of
(rtol × that speed)² over twice the acceleration that presses. Nor does what would rise by no more than displacements
round by, those of the grounds among them.

A model may give its jump a largest force and a duration: they are noted, and the motion is that of the jump all the
same. Its contact then lasts that long at least, though no longer than the record.
"""

from __future__ import annotations

from math import isnan, nan

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.counters import (
    BUSY,
    CONTACT_TIME,
    DEMAND,
    ENERGY,
    FINISHED,
    IMPULSE,
    PEAK_FORCE,
    RESIDUAL,
    VISCOUS,
)
from pounding_risk.solver.pair.contact import touch_down, write_contact, write_step
from pounding_risk.solver.pair.equations import energy_of, state_of
from pounding_risk.solver.pair.joined import (
    ROUNDING,
    joined_motion,
    load_whole,
    make_joint,
    move_joined,
    presses,
    state_set_apart,
    write_state,
    write_tension,
)
from pounding_risk.solver.pair.taylor import expand
from pounding_risk.solver.workspace import BEGIN, LEFT, SIGNAL


@small
def record_push(push, touched, workspace, log):
    """Enter the largest force of a jump, NaN for none that is finite, before what may follow it."""
    workspace.counters[DEMAND] = max(workspace.counters[DEMAND], push) if not isnan(push) else nan
    while log.used[2] < log.levels.size and log.levels[log.used[2]] <= push:
        log.first[log.used[2]] = touched
        log.used[2] += 1


@small
def settle_force(push, largest, rests, workspace, log):
    """The largest force of a contact, from that of its jump and of the joined motion, entered in the counters."""
    peak_so_far = workspace.counters[PEAK_FORCE]
    if isnan(push):
        if rests:
            workspace.counters[PEAK_FORCE] = largest if not peak_so_far > largest else peak_so_far
            return largest
        if peak_so_far == 0.0:
            workspace.counters[PEAK_FORCE] = nan
        return nan
    force = max(push, largest)
    workspace.counters[PEAK_FORCE] = max(peak_so_far, force)
    workspace.counters[DEMAND] = max(workspace.counters[DEMAND], force)
    for level in range(log.levels.size):
        log.reached[level] += 1.0 if log.levels[level] <= force else 0.0
    return force


@kernel
def impulsive_contact(pair, free, law, limits, rtol, start, state, workspace, log):
    """One touch at ``start`` = (node, time after it), and the joined motion where it does not rebound.

    Returns (how it ended, node, time after it, state then), as `integrate_contact` does. Where the impulse of a jump
    has no finite force the largest force is that of the joined motion, NaN where there has been none, and the force
    that a law would have without a cap is NaN.
    """
    node, offset = start
    joint = make_joint(pair, limits.gap)
    mass, series = joint.oscillator.mass, workspace.search.series
    ground = free.passage.interval(free.ground, free.step, node, offset)
    place_right = state[1]
    state = ground.across(joint.right, state, 0.0)
    spread = state[1] - place_right  # of the grounds
    touched = free.passage.moment(free.step, node) + offset
    speed = max(state[2] - state[3], 0.0)
    e = limits.restitution.at(speed)
    workspace.states[BEGIN, :] = 0.0
    write_state(workspace, state)
    energy = touch_down(joint, limits.restitution.beyond(speed), touched, speed, workspace)
    workspace.high[0] = max(workspace.high[0], limits.gap)
    write_step(log, touched, 0.0, ground.from_own_ground(joint.right, state, 0.0), workspace)
    x, rate = joined_motion(joint, state)
    expand(joint.oscillator, x, rate, load_whole(joint, ground), workspace.search, LEFT, free.terms)
    pressed = presses(series, write_tension(joint, ground, free.terms, workspace))
    ratio, hardness, lasts = law.strike(e, pair[0].inverse_mass, pair[1].inverse_mass)
    rebound, push = ratio * speed, hardness * speed
    # A bounce of speed w under the acceleration A rises by w² / (2 A).
    low_rebound = -2.0 * series[SIGNAL, 0] * ROUNDING * (abs(state[0]) + abs(state[1]) + abs(spread))
    if pressed and (rebound <= rtol * free.fastest or rebound * rebound <= low_rebound):
        rebound = 0.0
    rests = pressed and rebound == 0.0
    force = -mass * series[SIGNAL, 0] if rests else 0.0
    state = (state[0], state[1], rate - joint.share_right * rebound, rate + joint.share_left * rebound)
    write_state(workspace, state)
    workspace.states[BEGIN, 4] = 0.5 * mass * (speed - rebound) * (speed + rebound)
    workspace.states[BEGIN, 5] = mass * (speed + rebound)
    workspace.counters[VISCOUS] += workspace.states[BEGIN, 4]
    taken_along = ground.taken_along(joint.right, workspace.states[BEGIN, 5], state[3])
    workspace.counters[RESIDUAL] += energy_of(pair, state) - energy + workspace.states[BEGIN, 4] + taken_along
    state = ground.from_own_ground(joint.right, state, 0.0)
    write_step(log, touched, force if isnan(push) else max(push, force), state, workspace)
    record_push(push, touched, workspace, log)
    finish, largest = FINISHED, 0.0
    if rests:
        finish, node, offset, state, largest = move_joined(joint, free, (node, offset), x, rate, workspace, log)
    force = settle_force(push, largest, rests, workspace, log)
    state = state_set_apart(joint, state, workspace.states[BEGIN, 1] - state[1])
    stop = free.passage.moment(free.step, free.ground.size - 1)
    end_time = max(free.passage.moment(free.step, node) + offset, min(touched + lasts, stop))
    duration = max(end_time - touched, 0.0)
    workspace.counters[ENERGY] = max(workspace.counters[ENERGY], energy_of(pair, state_of(workspace.states, BEGIN)))
    # The next touch may come while the floors still press.
    workspace.counters[CONTACT_TIME] += max(end_time - max(touched, workspace.counters[BUSY]), 0.0)
    workspace.counters[BUSY] = end_time
    workspace.counters[IMPULSE] += workspace.states[BEGIN, 5]
    uncapped = nan if isnan(push) else force
    write_contact(log, (touched, touched + duration, speed, e, force, uncapped, 0.0, 0.0), workspace)
    return finish, node, offset, state
