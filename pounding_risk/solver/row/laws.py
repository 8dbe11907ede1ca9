"""Contact laws for the row solver: called by address, so that one compiled solver serves every law.

The pair's kernels hold the law's own code, and are compiled for every law. A row's are some five times as large, and
what a contact costs there is the buildings' motion: a call costs less than a twentieth of it. Each contact point may
have a law of its own. Its numbers stand in a row of `Run.laws`, and behind them what its contact remembers, be it one
number or several.
"""

from __future__ import annotations

from typing import Any

from pounding_risk._jit.calls import ENTERING, as_row, call_at, call_on, entry_of, lay_model, model_of, numbers_of
from pounding_risk._jit.compile import apart, kernel, small
from pounding_risk.solver.pair.stages import depth_of

Verbs = tuple[int, tuple[float, ...]]

_VERBS: dict[tuple[Any, ...], Verbs] = {}


def kind_of(law) -> tuple[Any, ...]:
    """The class of a law and of every model inside it: an effect is another law around another one."""
    return apart(type(law)), *(kind_of(value) for value in law if isinstance(value, tuple))


def memory_of(law) -> Any:
    """What a contact of this law remembers at its start, to be told by its form alone: a number, or a tuple of them."""
    return law.resume(law.begin(0.65, 1.0, 1.0), 0.0)


def verbs_of(law) -> Verbs:
    """Of a law of this kind: how many numbers it takes with the memory of its contact, and where its verbs stand.

    These are force, plateau, begin, turn and part, as the row solver asks for them.
    """
    kind = kind_of(law)
    with ENTERING:
        if kind not in _VERBS:
            _VERBS[kind] = _compiled(law)
    return _VERBS[kind]


def _compiled(law) -> Verbs:
    """As `verbs_of`; ``law`` is one of its kind, its numbers play no part."""
    template, blank, count = law, memory_of(law), len(numbers_of(law))
    room = count + len(numbers_of((blank,)))

    def force(numbers, delta, rate, approaching):
        given = as_row(numbers, room)
        memory = model_of(blank, given, 0, count)
        return model_of(template, given, 0, 0).force(memory, delta, rate, approaching > 0.0)

    def plateau(numbers, delta, strength, unused):
        return model_of(template, as_row(numbers, room), 0, 0).plateau(delta, strength)

    def begin(numbers, slots):
        given = as_row(numbers, room)
        own = model_of(template, given, 0, 0)
        e, speed, mass = slots[0], slots[1], slots[2]
        worn, limit, scale = slots[3], slots[4], slots[5]
        lay_model(own.resume(own.begin(e, speed, mass), worn), given, 0, count)
        slots[0] = own.ceiling(limit) * own.hardening(speed)
        slots[1] = own.floor()
        slots[2] = depth_of(own, 0.5 * mass * scale * scale, 1e-2 * scale)
        return 0.0

    def turn(numbers, slots):
        given = as_row(numbers, room)
        own = model_of(template, given, 0, 0)
        delta, strength, approaching, yielding = slots[0], slots[1], slots[2] > 0.0, slots[3] > 0.0
        memory = own.turned(model_of(blank, given, 0, count), delta, approaching)
        lay_model(memory, given, 0, count)
        slots[0], slots[1] = -1.0, 0.0
        if approaching and yielding:
            changed, dent, taken = own.turn(memory, delta, strength)
            if dent >= 0.0:
                lay_model(changed, given, 0, count)
                slots[0], slots[1] = dent, taken
        return 0.0

    def part(numbers, slots):
        given = as_row(numbers, room)
        own, memory = model_of(template, given, 0, 0), model_of(blank, given, 0, count)
        loss = slots[2] - own.held(memory, slots[0], slots[1])
        slots[0], slots[1], slots[2] = loss, own.yielded(loss), own.worn(memory)
        return 0.0

    return room, (entry_of(force, 3), entry_of(plateau, 3), entry_of(begin, 1), entry_of(turn, 1), entry_of(part, 1))


@small
def law_force(run, k, delta, rate, approaching):
    """The uncapped force of contact ``k``."""
    return call_at(run.contacts[k].force_verb, run.laws, k, delta, rate, approaching)


@small
def law_plateau(run, k, delta, strength):
    """The force of contact ``k`` past yield."""
    return call_at(run.contacts[k].plateau_verb, run.laws, k, delta, strength, 0.0)


@kernel
def law_begin(run, k, e, speed, mass, worn, scale, limit):
    """(strength, smallest force, scale of penetration) of a contact that begins, its memory written down."""
    arguments = run.workspace.law_arguments
    for place, value in enumerate((e, speed, mass, worn, limit, scale)):
        arguments[place] = value
    call_on(run.contacts[k].begin_verb, run.laws, k, arguments)
    return arguments[0], arguments[1], arguments[2]


@kernel
def law_turn(run, k, delta, strength, approaching, yielding):
    """(dent or below zero, energy lost with it) of a contact whose motion turns, its memory written down."""
    arguments = run.workspace.law_arguments
    for place, value in enumerate((delta, strength, approaching, yielding)):
        arguments[place] = value
    call_on(run.contacts[k].turn_verb, run.laws, k, arguments)
    return arguments[0], arguments[1]


@kernel
def law_part(run, k, delta, strength, work):
    """(loss, part of it that hysteresis takes, what is left for later contacts) of a contact that parts."""
    arguments = run.workspace.law_arguments
    for place, value in enumerate((delta, strength, work)):
        arguments[place] = value
    call_on(run.contacts[k].part_verb, run.laws, k, arguments)
    return arguments[0], arguments[1], arguments[2]
