"""Equations of motion in contact, of a group of neighbours of which some touch.

State: u and v of every dof of the group; quadratures: impulse and work of every contact, and the power that ground and
dampers put in. The clock is s with τ = s⁴ since the last touch in the group, for the reason given in `pair.equations`.
"""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.equations import SHARE, SLACK, YIELDING
from pounding_risk.solver.row.building import coupling_force, energy_of, ground_load
from pounding_risk.solver.row.contact_points import across_and_rate, power_through_ground, push_apart
from pounding_risk.solver.row.ground import ArrivingRowInterval, PlaneRowInterval, UniformRowInterval
from pounding_risk.solver.row.ground_dof import place_ground, push_ground, top_of
from pounding_risk.solver.row.inertia import divide_by_mass, has_inertia
from pounding_risk.solver.row.laws import law_force, law_plateau
from pounding_risk.solver.row.link import accelerate_braces, add_link_forces, link_energy
from pounding_risk.solver.row.workspace import (
    BAND,
    BOTTOM,
    CONSTANT,
    COUPLED,
    DRIVEN,
    END,
    FIRST,
    INVERSE,
    MASS,
    NOW,
    SLOPE,
    SLOPES,
    START,
    TANGENT,
    VELOCITY,
)

ROUNDING = 1e-13  # of the energy: what sums over many floors may be off by


class Group(NamedTuple):
    """Neighbours that are integrated together, and quantities that change only where a contact begins or ends."""

    first: int  # building
    last: int
    low: int  # the first dof, and one past the last
    high: int
    origin: float  # of the clock, after the node [s]
    ground: UniformRowInterval | PlaneRowInterval | ArrivingRowInterval  # after the node
    depth: float  # scales of the error control: m
    speed: float  # m/s
    watched_first: int  # building, a spectator or of the group
    watched_last: int
    terms: int  # of the spectators' Taylor series
    tolerance: float  # relative, of a step


@small
def ground_at(group, s):
    """The ground motion from s of the group's clock on, its own x counted from there."""
    return group.ground.later(group.origin + s * s * s * s)


@small
def transmitted(run, k, delta, rate):
    """Force that the buildings feel at contact ``k`` [N] on its present branch, at δ [m] and its rate [m/s]."""
    region = int(run.contacts[k].region)
    if region == SLACK:
        return 0.0
    if region == YIELDING:
        return law_plateau(run, k, delta, run.contacts[k].strength)
    return uncapped(run, k, delta, rate)


@small
def uncapped(run, k, delta, rate):
    """The force of contact ``k``'s law without cap or cut [N], at δ [m] and its rate [m/s]."""
    return law_force(run, k, delta, rate, run.contacts[k].approaching)


@small
def subtract_damping(row, b, speed, dofs, out):
    """Take the dampers' forces C · row ``speed`` from row ``out``; C is symmetric, and columns add up side by side."""
    first, last, band = row.frame[FIRST, b], top_of(row, b), row.frame[BAND, b]
    if band > 1:
        for j in range(first, last):
            rate = dofs[speed, j]
            for i in range(max(first, j - band), min(last, j + band + 1)):
                dofs[out, i] -= row.damping[j, i - first] * rate
        return
    # A floor and its neighbours: too few for a loop of their own.
    below, rate = 0.0, 0.0
    above = dofs[speed, first] if last > first else 0.0
    for i in range(first, last):
        below, rate, above = rate, above, dofs[speed, i + 1] if i + 1 < last else 0.0
        force = row.damping[i, i - first] * rate
        if band == 1 and i > first:
            force += row.damping[i, i - first - 1] * below
        if band == 1 and i + 1 < last:
            force += row.damping[i, i - first + 1] * above
        dofs[out, i] -= force


@small
def accelerate_mass(row, i, state, pull, dofs, out):
    """As `accelerate_building`, of one that is a single mass."""
    u, v = dofs[state, i], dofs[state + VELOCITY, i]
    push = -row.floors[MASS, i] * pull.real - row.damping[i, 0] * v
    dofs[out, i] = (push - (dofs[TANGENT, i] * u + dofs[CONSTANT, i])) * row.floors[INVERSE, i]
    return push * v


@small
def accelerate_building(row, b, state, pull, dofs, out):
    """ü of building ``b`` without contact from rows ``state`` to row ``out``; ``pull`` is a_g.

    Of one with a mass matrix the forces. Returns the power that ground and dampers put in.
    """
    first, last = row.frame[FIRST, b], top_of(row, b)
    if last - first == 1 and row.frame[COUPLED, b] == 0:
        return accelerate_mass(row, first, state, pull, dofs, out)
    for i in range(first, last):
        dofs[out, i] = -ground_load(row, DRIVEN, i, pull)
    subtract_damping(row, b, state + VELOCITY, dofs, out)
    power = 0.0
    above = dofs[TANGENT, first] * dofs[state, first] + dofs[CONSTANT, first] if last > first else 0.0
    for i in range(first, last):
        shear, above = above, 0.0
        if i + 1 < last:
            above = dofs[TANGENT, i + 1] * (dofs[state, i + 1] - dofs[state, i]) + dofs[CONSTANT, i + 1]
        push = dofs[out, i]
        power += push * dofs[state + VELOCITY, i]
        dofs[out, i] = (push + (above - shear)) * row.floors[INVERSE, i]
    if row.frame[COUPLED, b] > 0:
        couple(row, b, state, dofs, out)
    return power


@kernel
def couple(row, b, state, dofs, out):
    """Add to row ``out`` what springs beside the storeys do, and take out storeys between two buildings of one body."""
    first = row.frame[FIRST, b]
    for i in range(first, top_of(row, b)):
        force = coupling_force(row, b, i, state, dofs)
        if i > first and row.floors[BOTTOM, i] > 0.0:
            # `accelerate_building` has put this storey on the roof of the building before.
            between = dofs[TANGENT, i] * (dofs[state, i] - dofs[state, i - 1]) + dofs[CONSTANT, i]
            dofs[out, i - 1] -= between * row.floors[INVERSE, i - 1]
            force += dofs[TANGENT, i] * dofs[state, i - 1]
        dofs[out, i] -= force * row.floors[INVERSE, i]


@kernel
def accelerate_group(row, run, group, state, ground, out):
    """ü of the group under ground and contacts, from rows ``state`` into row ``out``; returns the power put in.

    ``ground`` begins now; what the ground itself has moved by is not left to the integration, and written to ``state``.
    """
    power = 0.0
    for b in range(group.first, group.last + 1):
        place_ground(row, b, ground, run.dofs, state)
        power += accelerate_building(row, b, state, ground.under(b)[0], run.dofs, out)
        push_ground(row, b, ground, run.dofs, out)
    if run.links.shape[0] > 0:
        power += add_link_forces(row, run, group.first, group.last, state, out)
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            distance, rate = across_and_rate(row, k, run.dofs, state)
            force = transmitted(run, k, max(distance - run.contacts[k].gap, 0.0), rate)
            push_apart(row, k, force, run.dofs, out)
            power = power_through_ground(row, k, power, force, run.dofs, state + VELOCITY)
            run.quadratures[SLOPES + 1, k] = force
            run.quadratures[SLOPES + 1, run.laws.shape[0] + k] = force * rate
    if row.inertia.shape[1] > 0:
        for b in range(group.first, group.last + 1):
            if has_inertia(row, b):
                divide_by_mass(row, b, run.dofs[out])
    if run.links.shape[0] > 0:
        accelerate_braces(row, run, group.first, group.last, state, out)
    return power


@kernel
def slopes(row, run, group, s, state, stage):
    """d(state)/ds = 4 s³ d(state)/dt of the group at a stage."""
    dofs, quadratures, points = run.dofs, run.quadratures, run.laws.shape[0]
    clock = 4.0 * s * s * s
    line = SLOPE + stage
    power = accelerate_group(row, run, group, state, ground_at(group, s), line + SLOPES)
    for i in range(group.low, group.high):
        dofs[line, i] = clock * dofs[state + VELOCITY, i]
    for i in range(group.low, group.high):
        dofs[line + SLOPES, i] *= clock
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            quadratures[stage, k] = clock * quadratures[SLOPES + 1, k]
            quadratures[stage, points + k] = clock * quadratures[SLOPES + 1, points + k]
    quadratures[stage, 2 * points] = clock * power


@kernel
def group_energy(row, run, group, line):
    """Mechanical energy of the group [J], u and v of its dofs in rows ``line`` and after."""
    total = 0.0
    for b in range(group.first, group.last + 1):
        total += energy_of(row, b, line, run.dofs)
    if run.links.shape[0] > 0:
        total += link_energy(row, run, group.first, group.last, line)
    return total


@kernel
def is_balanced(row, run, group):
    """True where the energy of the group over a step has changed by what came in, to the step's share of the tolerance.

    An error estimate is a difference of two methods and may vanish by chance; the work of the contacts does not. The
    energy that it is measured by is that of the group: a group takes the same steps whatever else moves in the row.
    """
    points = run.laws.shape[0]
    energy_in = run.quadratures[SLOPES, 2 * points]
    largest = 0.0
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        if run.contacts[k].closed > 0.0:
            energy_in -= run.quadratures[SLOPES, points + k]
            largest = max(largest, run.contacts[k].energy)
    change = group_energy(row, run, group, END) - group_energy(row, run, group, NOW)
    return abs(change - energy_in) <= (SHARE * group.tolerance + ROUNDING) * largest


@kernel
def note_energy(row, run, group):
    """The group's energy in rows NOW [J], noted as the largest so far where it is: of its contacts, and of the run."""
    energy = group_energy(row, run, group, NOW)
    for k in range(row.frame[START, group.first], row.frame[START, group.last]):
        run.contacts[k].energy = max(run.contacts[k].energy, energy)
    run.workspace.energy = max(run.workspace.energy, energy)
    return energy
