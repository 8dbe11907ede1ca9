"""Contact laws of a row, called by address: each contact point may have a law of its own.

Its numbers stand in a row of `Run.laws`, and behind them what its contact remembers, be it one number or several; the
verbs are those of `pair.laws`.
"""

from __future__ import annotations

from pounding_risk._jit.calls import call_at, call_on
from pounding_risk._jit.compile import kernel, small


@small
def law_force(run, k, delta, rate, approaching):
    """The force of contact ``k``'s law without cap or cut [N] at δ [m] and its rate [m/s]."""
    return call_at(run.contacts[k].force_verb, run.laws, k, delta, rate, approaching)


@small
def law_plateau(run, k, delta, strength):
    """The force of contact ``k``'s law past yield [N], at δ [m], of a law that yields at ``strength`` [N]."""
    return call_at(run.contacts[k].plateau_verb, run.laws, k, delta, strength, 0.0)


@kernel
def law_begin(run, k, e, speed, mass, scale):
    """(strength, smallest force, scale of penetration, knee) of a contact that begins, its memory written down."""
    contact, arguments = run.contacts[k], run.workspace.law_arguments
    for slot, value in enumerate((e, speed, mass, contact.damage, contact.yield_force, scale)):
        arguments[slot] = value
    call_on(contact.begin_verb, run.laws, k, arguments)
    return arguments[0], arguments[1], arguments[2], arguments[3]


@kernel
def law_turn(run, k, delta, strength, approaching, yielding):
    """(indentation or below zero, energy lost with it, knee) of a contact whose motion turns, its memory written."""
    arguments = run.workspace.law_arguments
    for slot, value in enumerate((delta, strength, approaching, yielding)):
        arguments[slot] = value
    call_on(run.contacts[k].turn_verb, run.laws, k, arguments)
    return arguments[0], arguments[1], arguments[2]


@kernel
def law_part(run, k, delta, strength, work):
    """(loss, part of it that hysteresis takes, what is left for later contacts) of a contact that parts."""
    arguments = run.workspace.law_arguments
    for slot, value in enumerate((delta, strength, work, 0.0)):
        arguments[slot] = value
    call_on(run.contacts[k].part_verb, run.laws, k, arguments)
    return arguments[0], arguments[1], arguments[2]
