"""A contact of a row, from its touch to its parting, and its entries in the counters."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import (
    APPROACH,
    CONTACT_TIME,
    COUNT,
    DEMAND,
    FIRST_TOUCH,
    FIRST_YIELD,
    HELD,
    PEAK_FORCE,
    PENETRATION,
    PLASTIC,
    SET,
    VISCOUS,
    YIELDS,
)
from pounding_risk.solver.pair.equations import ELASTIC, REBOUND_SHARE, ROUNDING
from pounding_risk.solver.row.contact_points import across, compliance
from pounding_risk.solver.row.event_functions import ROUNDED
from pounding_risk.solver.row.laws import law_begin, law_part, law_turn
from pounding_risk.solver.row.workspace import NOW, START, VELOCITY

SLOW = 1e-3  # of the fastest motion: slower contacts are measured by this


@kernel
def slowest_scale(row, run, first, last, time):
    """The least scale of speed of a contact that begins at ``time`` between the buildings ``first`` to ``last`` [m/s].

    A contact that another one drives touches with next to no speed, by which no error could be measured: its scale is
    a part of the others' speeds. Those that begin at the same instant count as they close then, begun or not.
    """
    fastest = 0.0
    for k in range(row.frame[START, first], row.frame[START, last]):
        contact = run.contacts[k]
        if contact.closed > 0.0 and contact.touch_time < time:
            fastest = max(fastest, contact.speed_scale)
        if contact.closed > 0.0 or across(row, k, run.dofs, NOW) - contact.gap >= -ROUNDED:
            fastest = max(fastest, abs(across(row, k, run.dofs, NOW + VELOCITY)))
    return SLOW * fastest


@kernel
def touch_down(row, run, k, time, slowest):
    """Contact ``k`` begins at ``time`` with the state in rows NOW; its scale of speed is at least ``slowest`` [m/s]."""
    contact, dofs = run.contacts[k], run.dofs
    rule = Restitution(contact.rule[0], contact.rule[1], contact.rule[2], contact.rule[3], contact.rule[4])
    speed = max(across(row, k, dofs, NOW + VELOCITY), 0.0)
    mass = 1.0 / compliance(row, k)
    e = rule.at(speed)
    scale = max(speed, SLOW * contact.fastest, slowest, 1e-12)
    strength, least_force, depth, contact.knee_depth = law_begin(run, k, e, speed, mass, scale)
    size = 0.0
    for end in range(row.passage.point_ends()):
        if row.ends[k, end] >= 0:
            size = max(size, abs(dofs[NOW, row.ends[k, end]]))
    contact.closed = 1.0
    contact.strength, contact.least_force = strength, least_force
    contact.speed_scale, contact.depth_scale = scale, depth
    # As the pair has it: δ is a difference of displacements, and what they round by becomes a speed.
    contact.still_speed = (1e-14 + 4.0 * ROUNDING * size / depth) * scale
    contact.approaching, contact.region = 1.0, float(ELASTIC)
    contact.touch_time, contact.approach_speed, contact.restitution = time, speed, e
    # Local maxima below the largest force so far are of no account, unless each contact's own are asked for.
    needs_own_peak = run.timed.shape[2] > 0 or run.workspace.line_room > 0.0
    contact.peak_force = 0.0 if needs_own_peak else contact.counters[DEMAND]
    contact.plateau_force = contact.peak_penetration = contact.yields = contact.indentation = contact.plastic_energy = (
        0.0
    )
    contact.next_step = 0.3 * depth / scale
    if contact.counters[COUNT] == 0.0:
        contact.counters[FIRST_TOUCH] = time
    contact.counters[COUNT] += 1.0
    contact.counters[APPROACH] = max(contact.counters[APPROACH], speed)
    contact.counters[HELD] += 1.0 if rule.beyond(speed) else 0.0


@kernel
def tolerance_of(run, k, rtol):
    """What comes back of a contact is e times what came: its error must stay a small part of that."""
    return min(rtol, REBOUND_SHARE * run.contacts[k].restitution)


@kernel
def turn_motion(row, run, k, delta):
    """The motion of contact ``k`` turns at ``delta``; as in `pair.contact.integrate_contact`."""
    contact = run.contacts[k]
    approaching = contact.approaching > 0.0
    if approaching:
        contact.peak_penetration = max(contact.peak_penetration, delta + contact.indentation)
    indentation, energy_lost, contact.knee_depth = law_turn(
        run, k, delta, contact.strength, contact.approaching, contact.region
    )
    if indentation >= 0.0:
        # What stays widens the gap, here and for the contacts after this one.
        contact.gap += indentation
        contact.indentation += indentation
        contact.plastic_energy += energy_lost
        contact.region = float(ELASTIC)
    contact.approaching = 0.0 if approaching else 1.0


@kernel
def note_yield(run, k, time):
    """Enter in contact ``k`` and its counters that its uncapped force has met F_E at ``time`` [s]."""
    contact = run.contacts[k]
    contact.peak_force, contact.plateau_force = (
        max(contact.peak_force, contact.strength),
        max(contact.plateau_force, contact.strength),
    )
    contact.yields += 1.0
    if contact.yields == 1.0:
        contact.counters[YIELDS] += 1.0
        if contact.counters[YIELDS] == 1.0:
            contact.counters[FIRST_YIELD] = time


@kernel
def lift_off(row, run, k, time, line, work):
    """Contact ``k`` ends at ``time``, its state in rows ``line``; ``work`` is what its force has taken in all [J]."""
    contact = run.contacts[k]
    delta = max(across(row, k, run.dofs, line) - contact.gap, 0.0)
    contact.peak_penetration = max(contact.peak_penetration, delta + contact.indentation)
    loss, hysteresis, damage = law_part(run, k, delta, contact.strength, work - contact.plastic_energy)
    contact.counters[VISCOUS] += loss - hysteresis
    contact.counters[PLASTIC] += contact.plastic_energy + hysteresis
    contact.counters[SET] += contact.indentation
    contact.damage = damage
    contact.counters[CONTACT_TIME] += time - contact.touch_time
    force = contact.plateau_force if contact.yields > 0.0 else min(contact.peak_force, contact.strength)
    contact.counters[DEMAND] = max(contact.counters[DEMAND], contact.peak_force)
    contact.counters[PEAK_FORCE] = max(contact.counters[PEAK_FORCE], force)
    contact.counters[PENETRATION] = max(contact.counters[PENETRATION], contact.peak_penetration)
    contact.highest = max(contact.highest, contact.gap - contact.indentation + contact.peak_penetration)
    for level in range(run.timed.shape[2]):
        run.timed[2, k, level] += 1.0 if run.timed[0, k, level] <= contact.peak_force else 0.0
    contact.closed = 0.0


@kernel
def scales(row, run, first, last):
    """(when the last touch was, smallest scale of penetration, of speed, shortest pace) of a group's contacts."""
    touched, depth, speed, pace = -inf, inf, inf, inf
    for k in range(row.frame[START, first], row.frame[START, last]):
        contact = run.contacts[k]
        if contact.closed > 0.0:
            touched = max(touched, contact.touch_time)
            depth, speed = min(depth, contact.depth_scale), min(speed, contact.speed_scale)
            pace = min(pace, contact.next_step)
    return touched, depth, speed, pace
