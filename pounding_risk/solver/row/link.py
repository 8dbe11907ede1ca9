"""Links with laws: what they add to the elastic links of their bodies.

A body has the stiffness k of its links in its matrix. One with a law has the force V(x) in place of k x, x = u_left −
u_right between its ends: on each branch

    V − k x = (t − k) x + c

which is added here to accelerations, Taylor series and energies.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import (
    BEGIN,
    COMING,
    CONSTANT,
    LOWER,
    OWNER,
    POTENTIAL,
    SLOPE,
    STIFFNESS,
    UPPER,
)
from pounding_risk.solver.row.contact_points import across, push_apart
from pounding_risk.solver.row.law_events import advance_law, next_event_of_law
from pounding_risk.solver.row.workspace import INVERSE


@small
def is_link_of(run, k, first, last):
    """True where point ``k`` is a link with a law, in one of the bodies ``first`` to ``last``."""
    return run.links[k, STIFFNESS] > 0.0 and first <= run.links[k, OWNER] <= last


@small
def excess(links, k, x):
    """V − k x of a link [N]."""
    return (links[k, SLOPE] - links[k, STIFFNESS]) * x + links[k, CONSTANT]


@kernel
def begin_links(row, run, line):
    """The laws of all links follow from rest to the state in rows ``line``, on one way."""
    links, slots = run.links, run.workspace.law_arguments
    for k in range(links.shape[0]):
        if links[k, STIFFNESS] > 0.0:
            advance_law(links, slots, k, BEGIN, 0.0)
            x = across(row, k, run.dofs, line)
            while x > links[k, UPPER]:
                advance_law(links, slots, k, 1.0, links[k, UPPER])
            while x < links[k, LOWER]:
                advance_law(links, slots, k, -1.0, links[k, LOWER])


@kernel
def add_link_forces(row, run, first, last, state, out):
    """Add to row ``out`` of accelerations what the links of these bodies do beyond elastic ones."""
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, first, last):
            force = excess(run.links, k, across(row, k, run.dofs, state))
            push_apart(row, k, force, run.dofs, out)


@kernel
def add_link_terms(row, run, b, n, share):
    """Add the term n + 2 of the Taylor series of body ``b`` that its links bring beyond elastic ones."""
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, b, b):
            force = (run.links[k, SLOPE] - run.links[k, STIFFNESS]) * term_of(row, run, k, n)
            force += run.links[k, CONSTANT] if n == 0 else 0.0
            for end in range(4):
                i = row.ends[k, end]
                if i >= 0:
                    run.series[i, n + 2] -= share * row.shares[k, end] * row.floors[INVERSE, i] * force


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
            total += potential(run.links, k, across(row, k, run.dofs, line))
    return total


@small
def potential(links, k, x):
    """Integral of V − k x, which would be given back [J]."""
    return (0.5 * (links[k, SLOPE] - links[k, STIFFNESS]) * x + links[k, CONSTANT]) * x + links[k, POTENTIAL]


@kernel
def next_event_of_link(row, run, k, stop, terms):
    """When link ``k`` changes its branch on (0, stop] of a flight, or −1."""
    spare = row.floors.shape[1]
    for n in range(terms):
        run.series[spare, n] = term_of(row, run, k, n)
    return next_event_of_law(run, run.links, k, spare, stop, terms)


@kernel
def switch_link(row, run, k, line):
    """Link ``k`` changes its branch, its state in rows ``line``; returns how its potential changes."""
    x = across(row, k, run.dofs, line)
    before = potential(run.links, k, x)
    advance_law(run.links, run.workspace.law_arguments, k, run.links[k, COMING], x)
    return potential(run.links, k, x) - before
