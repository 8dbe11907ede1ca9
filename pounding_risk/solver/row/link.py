"""Links with laws: what they add to the elastic links of their bodies.

A body has the stiffness k of its links in its matrix. One with a law has the force V(x) in place of k x, x = u_left −
u_right between its ends: on each branch

    V − k x = (t − k) x + c

which is added here to accelerations, Taylor series and energies. A law along the rate has ẋ in place of x and a damping
in place of k; what it takes is power. Its branches are of flights alone, in contact it is asked for its force.
"""

from __future__ import annotations

from pounding_risk._jit.calls import call_on
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import (
    ALONG_RATE,
    AT,
    AT_FORCE,
    BEGIN,
    BRACE,
    BRACE_DOF,
    COMING,
    CONSTANT,
    FASTEST,
    LONGEST,
    LOWER,
    OWNER,
    POTENTIAL,
    SHORTENING,
    SLOPE,
    STAY,
    STIFFNESS,
    TAKEN,
    UPPER,
    VERB,
)
from pounding_risk.solver.pair.taylor import SIGNAL, highest
from pounding_risk.solver.row.contact_points import across, push_apart
from pounding_risk.solver.row.law_events import advance_law, margin, next_event_of_law
from pounding_risk.solver.row.workspace import INVERSE, VELOCITY


@small
def is_link_of(run, k, first, last):
    """True where point ``k`` is a link with a law, in one of the bodies ``first`` to ``last``."""
    return run.links[k, STIFFNESS] > 0.0 and first <= run.links[k, OWNER] <= last


@small
def follows_rate(run, k):
    """True where the law of a link follows the rate of its stretch."""
    return run.links[k, ALONG_RATE] > 0.0


@small
def is_braced(run, k):
    """True where a damper acts on a brace."""
    return run.links[k, BRACE] > 0.0


@small
def brace_of(run, k):
    """The dof of a brace: its deformation y, and ẏ; below zero where its damper pulls."""
    return int(run.links[k, BRACE_DOF])


@kernel
def damper_speed(run, k, y):
    """Speed of a damper on a brace that is deformed by y, without chords; its slope to the second slot after it."""
    slots = run.workspace.law_arguments
    slots[0], slots[1] = AT_FORCE, run.links[k, BRACE] * y
    call_on(run.links[k, VERB], run.links, k, slots)
    return slots[2]


@kernel
def followed(row, run, k, line):
    """What the law of a link follows, x, ẋ or ẋ − ẏ, of the state in rows ``line``."""
    if is_braced(run, k):
        return damper_speed(run, k, run.dofs[line, brace_of(run, k)])
    return across(row, k, run.dofs, line + VELOCITY if follows_rate(run, k) else line)


@small
def excess(links, k, x):
    """V − k x of a link [N]; of a law along the rate V − k ẋ."""
    return (links[k, SLOPE] - links[k, STIFFNESS]) * x + links[k, CONSTANT]


@kernel
def force_in_contact(run, k, x):
    """As `excess` in contact, where a law along the rate has no branches; of a brace deformed by x its force."""
    if not follows_rate(run, k):
        return excess(run.links, k, x)
    if is_braced(run, k):
        return run.links[k, BRACE] * x
    slots = run.workspace.law_arguments
    slots[0], slots[1] = AT, x
    call_on(run.links[k, VERB], run.links, k, slots)
    return slots[2] - run.links[k, STIFFNESS] * x


@kernel
def settle_links(row, run, first, last, line):
    """Laws along the rate, of these bodies, take the branch of the state in rows ``line``, at the start of a flight."""
    links, slots = run.links, run.workspace.law_arguments
    for k in range(links.shape[0]):
        if is_link_of(run, k, first, last) and follows_rate(run, k):
            if is_braced(run, k):
                follow_brace(links, slots, k, links[k, BRACE] * run.dofs[line, brace_of(run, k)])
            else:
                follow_to(links, slots, k, followed(row, run, k, line))


@kernel
def follow_brace(links, slots, k, force):
    """The law of a damper on a brace goes on to the chord that has this force."""
    slack = margin(links, k)
    while (force - links[k, CONSTANT]) / links[k, SLOPE] > links[k, UPPER] + slack:
        advance_law(links, slots, k, 1.0, links[k, UPPER])
    while (force - links[k, CONSTANT]) / links[k, SLOPE] < links[k, LOWER] - slack:
        advance_law(links, slots, k, -1.0, links[k, LOWER])


@kernel
def follow_to(links, slots, k, x):
    """The law of a link goes on to x branch by branch."""
    slack = margin(links, k)
    while x > links[k, UPPER] + slack:
        advance_law(links, slots, k, 1.0, links[k, UPPER])
    while x < links[k, LOWER] - slack:
        advance_law(links, slots, k, -1.0, links[k, LOWER])


@kernel
def begin_links(row, run, line):
    """The laws of all links follow from rest to the state in rows ``line``, on one way."""
    links, slots = run.links, run.workspace.law_arguments
    for k in range(links.shape[0]):
        if links[k, STIFFNESS] > 0.0:
            advance_law(links, slots, k, BEGIN, 0.0)
            x = followed(row, run, k, line)
            links[k, FASTEST] = abs(x)
            follow_to(links, slots, k, x)


@kernel
def add_link_forces(row, run, first, last, state, out):
    """Add to row ``out`` of accelerations what the links of these bodies do beyond linear ones.

    Returns the power that dampers of them put in, below zero where they take it.
    """
    power = 0.0
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, first, last):
            x = followed(row, run, k, state)
            force = force_in_contact(run, k, run.dofs[state, brace_of(run, k)] if is_braced(run, k) else x)
            push_apart(row, k, force, run.dofs, out)
            if follows_rate(run, k):
                power -= force * x
            if is_braced(run, k):
                rate = across(row, k, run.dofs, state + VELOCITY) - x
                run.dofs[state + VELOCITY, brace_of(run, k)] = rate
    return power


@kernel
def accelerate_braces(row, run, first, last, state, out):
    """ÿ of the braces of these bodies to row ``out``, where the accelerations of their ends stand: ẏ = ẋ − s(y)."""
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, first, last) and is_braced(run, k):
            i = brace_of(run, k)
            damper_speed(run, k, run.dofs[state, i])
            slope = run.links[k, BRACE] * run.workspace.law_arguments[3]
            run.dofs[out, i] = across(row, k, run.dofs, out) - slope * run.dofs[state + VELOCITY, i]


@kernel
def add_link_terms(row, run, b, n, share):
    """Add the term n + 2 of the Taylor series of body ``b`` that its links bring beyond linear ones."""
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, b, b):
            if is_braced(run, k):
                i = brace_of(run, k)
                force = run.links[k, BRACE] * run.series[i, n]
                run.series[i, n + 1] = term_of(row, run, k, n + 1) - speed_term(run, k, n) / (n + 1)
                add_term(row, run, k, n, share * force)
                continue
            x = (n + 1) * term_of(row, run, k, n + 1) if follows_rate(run, k) else term_of(row, run, k, n)
            force = (run.links[k, SLOPE] - run.links[k, STIFFNESS]) * x
            force += run.links[k, CONSTANT] if n == 0 else 0.0
            add_term(row, run, k, n, share * force)


@small
def add_term(row, run, k, n, force):
    """Take a force at the ends of a point from the terms n + 2 of their series."""
    for end in range(4):
        i = row.ends[k, end]
        if i >= 0:
            run.series[i, n + 2] -= row.shares[k, end] * row.floors[INVERSE, i] * force


@small
def speed_term(run, k, n):
    """Term n of the series of the speed of a damper on a brace, on its chord."""
    force = run.links[k, BRACE] * run.series[brace_of(run, k), n] - (run.links[k, CONSTANT] if n == 0 else 0.0)
    return force / run.links[k, SLOPE]


@small
def term_of(row, run, k, n):
    """Term n of the Taylor series of x of a point."""
    total = 0.0
    for end in range(4):
        if row.ends[k, end] >= 0:
            total += row.shares[k, end] * run.series[row.ends[k, end], n]
    return total


@kernel
def link_energy(row, run, first, last, line):
    """Potential of the links of these bodies beyond that of elastic ones [J]."""
    total = 0.0
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, first, last):
            if is_braced(run, k):
                total += 0.5 * run.links[k, BRACE] * run.dofs[line, brace_of(run, k)] ** 2
            else:
                total += potential(run.links, k, followed(row, run, k, line))
    return total


@small
def potential(links, k, x):
    """Integral of V − k x, which would be given back [J]: nothing by a damper."""
    if links[k, ALONG_RATE] > 0.0:
        return 0.0
    return (0.5 * (links[k, SLOPE] - links[k, STIFFNESS]) * x + links[k, CONSTANT]) * x + links[k, POTENTIAL]


@kernel
def next_event_of_link(row, run, k, stop, terms):
    """When link ``k`` changes its branch on (0, stop] of a flight, or −1."""
    spare, count = row.floors.shape[1], write_followed(row, run, k, terms)
    reach = longest_flight(run.links, k) if follows_rate(run, k) else stop
    time = next_event_of_law(run, run.links, k, spare, min(stop, reach), count)
    if time < 0.0 and reach < stop:
        run.links[k, COMING], time = STAY, reach
    return time


@small
def longest_flight(links, k):
    """For how long a Taylor series sums to rounding on the branch of a law along the rate [s]."""
    if links[k, BRACE] > 0.0:
        return links[k, LONGEST] / (1.0 + links[k, SHORTENING] / links[k, SLOPE])
    return links[k, LONGEST] / (1.0 + max(links[k, SLOPE] - links[k, STIFFNESS], 0.0) * links[k, SHORTENING])


@kernel
def write_followed(row, run, k, terms):
    """The series of what the law of a link follows, to the spare row of the series; returns how many terms it has."""
    spare = row.floors.shape[1]
    if is_braced(run, k):
        for n in range(terms - 1):
            run.series[spare, n] = speed_term(run, k, n)
        return terms - 1
    if follows_rate(run, k):
        for n in range(terms - 1):
            run.series[spare, n] = (n + 1) * term_of(row, run, k, n + 1)
        return terms - 1
    for n in range(terms):
        run.series[spare, n] = term_of(row, run, k, n)
    return terms


@kernel
def note_link_speeds(row, run, first, last, stop, terms):
    """Largest speeds and energies of laws along the rate, of these bodies, go on by a flight on [0, stop]."""
    search, spare = run.workspace.search, row.floors.shape[1]
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, first, last) and follows_rate(run, k):
            count = write_followed(row, run, k, terms)
            for n in range(count):
                search.series[SIGNAL, n] = run.series[spare, n]
            best = highest(search, SIGNAL, count, 1.0, stop, run.links[k, FASTEST])
            run.links[k, FASTEST] = highest(search, SIGNAL, count, -1.0, stop, best)
            run.links[k, TAKEN] += energy_in_flight(run, k, count, stop)


@kernel
def energy_in_flight(run, k, count, stop):
    """∫ V ẋ dt on a branch of a law along the rate [J]; its series of so many terms stands in the workspace."""
    speed, scale = run.workspace.search.series[SIGNAL], 1.0
    travel = square = 0.0
    for n in range(count):
        travel += scale * speed[n] / (n + 1)
        power = scale
        for m in range(count):
            square += power * speed[n] * speed[m] / (n + m + 1)
            power *= stop
        scale *= stop
    return stop * (run.links[k, SLOPE] * square + run.links[k, CONSTANT] * travel)


@kernel
def switch_link(row, run, k, line):
    """Link ``k`` changes its branch, its state in rows ``line``; returns how its potential changes."""
    if run.links[k, COMING] == STAY:
        return 0.0
    x = followed(row, run, k, line)
    before = potential(run.links, k, x)
    advance_law(run.links, run.workspace.law_arguments, k, run.links[k, COMING], x)
    return potential(run.links, k, x) - before
