"""How a contact begins, turns and ends in its law: of a law in the kernel, and of one called by address."""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._jit.compile import by_verb, kernel, small


@kernel
def depth_of(law, energy, guess):
    """Penetration at which an uncapped law has stored ``energy``: a scale, good to a tenth."""
    depth = guess
    for _ in range(200):
        stored = law.stored(depth, inf)
        if not stored > 0.0:
            depth *= 1e3
            continue
        ratio = energy / stored
        if 0.8 < ratio < 1.25:
            break
        depth *= sqrt(ratio)
    return depth


@small
def starts_itself(law, e, speed, mass, damage, limit, scale):
    """(memory, force at which the law yields, smallest force, scale of penetration, knee) of a contact that begins.

    ``damage`` is the damage that earlier contacts have left, ``limit`` the yield force, ``scale`` that of the velocity.
    """
    memory = law.resume(law.begin(e, speed, mass), damage)
    strength = law.ceiling(limit) * law.hardening(speed)
    depth = depth_of(law, 0.5 * mass * scale * scale, 1e-2 * scale)
    return memory, strength, law.floor(), depth, law.knee(memory, True)


@small
def turns_itself(law, memory, delta, strength, approaching, yielding):
    """(memory, indentation, energy lost, knee) once the motion has turned at δ; one below zero leaves the gap."""
    memory = law.turned(memory, delta, approaching)
    if approaching:
        changed, indentation, energy_lost = (
            law.turn(memory, delta, strength) if yielding else law.crushed(memory, delta)
        )
        if indentation >= 0.0:
            return changed, indentation, energy_lost, law.knee(changed, False)
    return memory, -1.0, 0.0, law.knee(memory, not approaching)


@small
def ends_itself(law, memory, delta, strength, work, lost):
    """(loss, the part of it that hysteresis takes, damage left behind) of a contact that parts.

    ``work`` is that of its force, ``lost`` what indentations have taken of it.
    """
    loss = 0.0 if law.conserves() else work - law.held(memory, delta, strength) - lost
    return loss, law.yielded(loss), law.damage(memory)


@small
def starts_called(law, e, speed, mass, damage, limit, scale):
    """As `starts_itself`, of a law called by address; the memory is with its numbers, and given back as 0."""
    return law.begin_contact(e, speed, mass, damage, limit, scale)


@small
def turns_called(law, memory, delta, strength, approaching, yielding):
    """As `turns_itself`, of a law called by address; the memory is with its numbers, and given back as 0."""
    return law.turn_contact(memory, delta, strength, approaching, yielding)


@small
def ends_called(law, memory, delta, strength, work, lost):
    """As `ends_itself`, of a law called by address, whose memory is with its numbers."""
    return law.end_contact(memory, delta, strength, work, lost)


law_starts = by_verb("begin_contact", 0, starts_called, starts_itself)
law_turns = by_verb("turn_contact", 0, turns_called, turns_itself)
law_ends = by_verb("end_contact", 0, ends_called, ends_itself)
