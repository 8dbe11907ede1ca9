"""Contact laws called by address, so that one compiled solver serves every law.

A law's numbers stand in a row, and behind them what its contact remembers, be it one number or several. Its verbs are
compiled once for each kind of law, in a fraction of the time that a solver takes, and kept in the cache of kernels. A
call costs some nanoseconds more than a law whose own code is in the kernel, and gives the same bits.
"""

from __future__ import annotations

from math import inf, isfinite
from typing import Any, NamedTuple, Protocol

import numpy as np

from pounding_risk._jit.calls import (
    ENTERING,
    address_of,
    call_numbers,
    call_slots,
    entry_of_numbers,
    entry_of_slots,
    lay_at,
    leaves_of,
    model_at,
    numbers_of,
    read_slot,
    write_slots,
)
from pounding_risk._jit.compile import apart, kernel, lowered, small, speaks
from pounding_risk.solver.pair.law_verbs import ends_itself, starts_itself, turns_itself

SLOTS = 6  # numbers that a verb is given and gives back
Verbs = tuple[int, tuple[float, ...]]

_VERBS: dict[tuple[Any, ...], Verbs] = {}


@small
def force(law, blank, numbers, delta, rate, approaching):
    """``law.force`` [N] at penetration ``delta`` [m] and closing speed ``rate`` [m/s].

    ``numbers`` are the law's own and behind them the memory; ``law`` and ``blank`` tell by their types how many there
    are.
    """
    memory = model_at(blank, numbers, leaves_of(law))
    return model_at(law, numbers, 0).force(memory, delta, rate, approaching > 0.0)


@small
def plateau(law, blank, numbers, delta, strength, unused):
    """``law.plateau`` [N] at penetration ``delta`` [m], of a law that yields at ``strength`` [N]."""
    return model_at(law, numbers, 0).plateau(delta, strength)


@small
def begin(law, blank, numbers, slots):
    """`starts_itself`: a contact begins.

    ``slots`` hold e, approach speed [m/s], mass [kg], damage so far, yield force [N] and scale of velocity [m/s]; then
    the force at which the law yields [N], its smallest force [N], the scale of penetration [m] and that of the knee
    ahead [m]. The memory is written behind the law's numbers. Returns 0.
    """
    memory, strength, least, depth, knee = starts_itself(
        model_at(law, numbers, 0), slots[0], slots[1], slots[2], slots[3], slots[4], slots[5]
    )
    lay_at(memory, numbers, leaves_of(law))
    slots[0], slots[1], slots[2], slots[3] = strength, least, depth, knee
    return 0.0


@small
def turn(law, blank, numbers, slots):
    """`turns_itself`: the motion of a contact turns.

    ``slots`` hold δ [m], the force at which the law yields [N], whether the bodies approach and whether the law yields
    (1 or 0); then the indentation [m], below zero for none, the energy lost with it [J] and the penetration of the knee
    ahead [m]. The memory is written behind the law's numbers. Returns 0.
    """
    memory, indentation, energy_lost, knee = turns_itself(
        model_at(law, numbers, 0),
        model_at(blank, numbers, leaves_of(law)),
        slots[0],
        slots[1],
        slots[2] > 0.0,
        slots[3] > 0.0,
    )
    lay_at(memory, numbers, leaves_of(law))
    slots[0], slots[1], slots[2] = indentation, energy_lost, knee
    return 0.0


@small
def part(law, blank, numbers, slots):
    """`ends_itself`: a contact ends.

    ``slots`` hold δ [m], the force at which the law yields [N], the work of the force and what indentations have taken
    of it [J]; then the loss [J], the part of it that hysteresis takes [J] and the damage left behind. Returns 0.
    """
    memory = model_at(blank, numbers, leaves_of(law))
    slots[0], slots[1], slots[2] = ends_itself(
        model_at(law, numbers, 0), memory, slots[0], slots[1], slots[2], slots[3]
    )
    return 0.0


@small
def strike(law, blank, numbers, slots):
    """``law.strike`` of a model whose velocities jump.

    ``slots`` hold e and 1/mass of the left and the right building [1/kg]; then the ratio of rebound to approach speed,
    the largest force over the approach speed [N s/m] and the duration [s]. Returns 0.
    """
    slots[0], slots[1], slots[2] = model_at(law, numbers, 0).strike(slots[0], slots[1], slots[2])
    return 0.0


@kernel
def force_verbs(law, blank, out):
    """Write the addresses of `force`, `plateau`, `begin`, `turn` and `part` for laws of this kind to ``out``."""
    out[0] = entry_of_numbers(force, law, blank)
    out[1] = entry_of_numbers(plateau, law, blank)
    out[2] = entry_of_slots(begin, law, blank)
    out[3] = entry_of_slots(turn, law, blank)
    out[4] = entry_of_slots(part, law, blank)


@kernel
def jump_verbs(law, blank, out):
    """Write the address of `strike` for models of this kind to ``out``."""
    out[0] = entry_of_slots(strike, law, blank)


def kind_of(law) -> tuple[Any, ...]:
    """The class of a law and of every model inside it: an effect is another law around another one."""
    return apart(type(law)), *(kind_of(value) for value in law if isinstance(value, tuple))


def memory_of(law) -> Any:
    """What a contact of this law remembers at its start, known by its form alone: a number, or a tuple of them."""
    return _of_floats(law.resume(law.begin(0.65, 1.0, 1.0), 0.0))


def _of_floats(memory):
    return tuple(map(_of_floats, memory)) if isinstance(memory, tuple) else float(memory)


def verb_kernel(law) -> tuple[Any, tuple[Any, ...]]:
    """The kernel that knows the addresses of the law's verbs, and its arguments; the last one takes them."""
    if hasattr(law, "strike"):
        return jump_verbs, (law, 0.0, np.zeros(1))
    return force_verbs, (law, memory_of(law), np.zeros(5))


def verbs_of(law) -> Verbs:
    """Of a law of this kind: how many numbers it takes with the memory of its contact, and where its verbs stand.

    These are force, plateau, begin, turn and part; of a model whose velocities jump, strike. ``law`` is `lowered`.
    """
    kind = kind_of(law)
    with ENTERING:
        if kind not in _VERBS:
            addresses, (_, memory, out) = verb_kernel(law)
            addresses(law, memory, out)
            _VERBS[kind] = len(numbers_of((law, memory))), tuple(out.tolist())
        return _VERBS[kind]


@speaks
class CalledVerbs(Protocol):
    """The methods of a law by address that stand for several of `models.contact.law.ContactLaw`.

    In compiled code no named tuple may have a field of such a name: the method would be found in its place.
    """

    def begin_contact(self, e, speed, mass, damage, limit, scale):
        """As `law_verbs.starts_itself`, with 0 in place of the memory."""

    def turn_contact(self, memory, delta, strength, approaching, yielding):
        """As `law_verbs.turns_itself`, with 0 in place of the memory."""

    def end_contact(self, memory, delta, strength, work, lost):
        """As `law_verbs.ends_itself`; ``memory`` plays no part."""


class CalledLaw(NamedTuple):
    """Any law with a force: where its numbers, its slots and its verbs stand. One contact at a time has its memory."""

    numbers: float = 0.0
    slots: float = 0.0
    force_verb: float = 0.0
    plateau_verb: float = 0.0
    begin_verb: float = 0.0
    turn_verb: float = 0.0
    part_verb: float = 0.0
    capped: float = 0.0

    def force(self, memory, delta, rate, approaching):
        return call_numbers(self.force_verb, self.numbers, delta, rate, 1.0 if approaching else 0.0)

    def plateau(self, delta, strength):
        return call_numbers(self.plateau_verb, self.numbers, delta, strength, 0.0)

    def ceiling(self, yield_force):
        return yield_force if self.capped > 0.0 else inf

    def begin_contact(self, e, speed, mass, damage, limit, scale):
        write_slots(self.slots, (e, speed, mass, damage, limit, scale))
        call_slots(self.begin_verb, self.numbers, self.slots)
        ceiling, floor, depth = read_slot(self.slots, 0), read_slot(self.slots, 1), read_slot(self.slots, 2)
        return 0.0, ceiling, floor, depth, read_slot(self.slots, 3)

    def turn_contact(self, memory, delta, strength, approaching, yielding):
        write_slots(self.slots, (delta, strength, 1.0 if approaching else 0.0, 1.0 if yielding else 0.0))
        call_slots(self.turn_verb, self.numbers, self.slots)
        return 0.0, read_slot(self.slots, 0), read_slot(self.slots, 1), read_slot(self.slots, 2)

    def end_contact(self, memory, delta, strength, work, lost):
        write_slots(self.slots, (delta, strength, work, lost))
        call_slots(self.part_verb, self.numbers, self.slots)
        return read_slot(self.slots, 0), read_slot(self.slots, 1), read_slot(self.slots, 2)


class CalledJump(NamedTuple):
    """Any model whose velocities jump: where its numbers, its slots and its verb stand."""

    numbers: float = 0.0
    slots: float = 0.0
    strike_verb: float = 0.0

    def ceiling(self, yield_force):
        return inf

    def strike(self, e, left, right):
        write_slots(self.slots, (e, left, right))
        call_slots(self.strike_verb, self.numbers, self.slots)
        return read_slot(self.slots, 0), read_slot(self.slots, 1), read_slot(self.slots, 2)


class HeldLaw(CalledLaw):
    """A `CalledLaw` that holds its own numbers."""

    row: Any


class HeldJump(CalledJump):
    """A `CalledJump` that holds its own numbers."""

    row: Any


def unnamed(law) -> HeldLaw | HeldJump:
    """What `by_address` gives for such a law, without numbers: for the sake of its type."""
    return HeldJump() if hasattr(law, "strike") else HeldLaw()


def by_address(law) -> HeldLaw | HeldJump:
    """The law, called by address. One thread may use it at a time, and must keep it as long as a kernel has it."""
    law_of_floats = lowered(law)
    room, verbs = verbs_of(law_of_floats)
    row, slots = np.zeros(room), np.zeros(SLOTS)
    row[: len(numbers_of(law_of_floats))] = numbers_of(law_of_floats)
    addresses = address_of(row), address_of(slots)
    called: HeldLaw | HeldJump
    if hasattr(law, "strike"):
        called = HeldJump._make((*addresses, *verbs))
    else:
        called = HeldLaw._make((*addresses, *verbs, float(isfinite(law_of_floats.ceiling(1.0)))))
    called.row = row, slots
    return called
