"""Smooth hysteresis of Bouc, Wen and Baber, by chords.

With x = d / d_y and the hysteretic part ζ of the shear, V = α k d + (1 − α) V_y ζ:

    dζ/dx = (A − ν |ζ|^n (1 − β + β sgn(ζ dx))) / η,     A = 1 − δ_A e,  ν = 1 + δ_ν e,  η = 1 + δ_η e

e is the energy that ζ has taken, over V_y d_y. From turn to turn ζ follows from the drift alone, so that a storey is
loaded along lines beside that curve, about `CHORD` of V_y from it at most. ζ and e themselves are kept on the
curve, whatever the lines do: each line leads to where a chord, moved by two thirds of its sag, ends, so that forces are
as often too large as too small and no error is left behind by a turn.
"""

from __future__ import annotations

from math import sqrt

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import (
    BEGIN,
    LAST_SLOPE,
    LOWER,
    OWN,
    STIFFNESS,
    STRENGTH,
    TURN,
    UNLOADING,
    UPPER,
    follow_line,
    follow_path,
)

ORDER = 40
WORDS = "smooth hysteresis, with or without degradation"
REFERENCE = (
    "Wen (1976), Journal of the Engineering Mechanics Division 102; Baber and Wen (1981), Journal of the Engineering "
    "Mechanics Division 107"
)
USE = "storey"
OPTIONS = ("exponent", "beta", "delta_a", "delta_nu", "delta_eta")
CHORD = 2e-4
STEERED = 0.05  # of the elastic slope, by which a line may be steered towards the curve: short ones are not turned
# Own parameters; ζ and the drift over d_y where the present line began, the energy e there, and the direction.
YIELDS, EXPONENT, BETA, DELTA_A, DELTA_NU, DELTA_ETA, PART, PLACE, ENERGY, SIDE = range(OWN, OWN + 10)


def own_numbers(law, stiffness, drifts, shears):
    """The rule's parameters, and a memory at rest."""
    return [drifts[0], law.exponent, law.beta, law.delta_a, law.delta_nu, law.delta_eta, 0.0, 0.0, 0.0, 0.0]


def refusal(slopes):
    """What a backbone of these slopes over the elastic one lacks for the rule; "" where it is one."""
    is_line = len(slopes) == 1 and 0.0 <= slopes[0] < 1.0
    return "" if is_line else "no backbone: its curve is that of exponent, and of hardening of inelastic_storeys"


@small
def rise(numbers, part, energy, side):
    """dζ/dx at ζ = ``part`` in a direction."""
    opening = 1.0 - numbers[BETA] + (numbers[BETA] if part * side >= 0.0 else -numbers[BETA])
    strength = (1.0 + numbers[DELTA_NU] * energy) * abs(part) ** numbers[EXPONENT]
    return (max(1.0 - numbers[DELTA_A] * energy, 0.0) - strength * opening) / (1.0 + numbers[DELTA_ETA] * energy)


@small
def step_of_part(numbers, part, energy, side, length):
    """ζ a chord of ``length`` on, by a step of Runge and Kutta's fourth order, whose error is far below `CHORD`."""
    half = 0.5 * length * side
    share = 1.0 - numbers[LAST_SLOPE] / numbers[STIFFNESS]
    first = rise(numbers, part, energy, side)
    midway = energy + share * half * (part + 0.5 * half * first)
    second = rise(numbers, part + half * first, midway, side)
    third = rise(numbers, part + half * second, midway, side)
    fourth = rise(numbers, part + 2.0 * half * third, energy + 2.0 * share * half * (part + half * second), side)
    return part + half * (first + 2.0 * second + 2.0 * third + fourth) / 3.0


@small
def chord_length(numbers, part, energy, side):
    """How far a chord may go from ζ = ``part`` [d_y]: it is off the curve by an eighth of its bend times h²."""
    nudge = 1e-6 * side
    bend = (rise(numbers, part + nudge, energy, side) - rise(numbers, part - nudge, energy, side)) / 2e-6
    bend = abs(bend * rise(numbers, part, energy, side))
    longest = 0.25 / max(numbers[EXPONENT], 1.0)
    length = longest if bend * longest * longest <= 8.0 * CHORD else sqrt(8.0 * CHORD / bend)
    if part * side < 0.0 and step_of_part(numbers, part, energy, side, length) * side > 0.0:
        # The curve may have a corner at ζ = 0: a chord ends there.
        low, high = 0.0, length
        for _ in range(40):
            length = 0.5 * (low + high)
            if step_of_part(numbers, part, energy, side, length) * side > 0.0:
                high = length
            else:
                low = length
    return length


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`."""
    event, drift, shear = slots[0], slots[1], slots[2]
    yields, stiffness, hardening = numbers[YIELDS], numbers[STIFFNESS], numbers[LAST_SLOPE]
    soft = stiffness - hardening  # of ζ, times d_y
    held = 0.0  # ζ by the shear, on the line
    if event != BEGIN:
        # Landed on the end of a line to rounding, the line is over; a turn lies on it.
        held = (shear - hardening * drift) / (soft * yields)
        if event != TURN:
            drift = max(drift, numbers[UPPER]) if event > 0.0 else min(drift, numbers[LOWER])
        moved = abs(drift / yields - numbers[PLACE])
        along = event if event != TURN else numbers[SIDE]
        part, energy = numbers[PART], numbers[ENERGY]
        midway = step_of_part(numbers, part, energy, along, 0.5 * moved)
        numbers[PART] = step_of_part(numbers, part, energy, along, moved)
        numbers[ENERGY] += (soft / stiffness) * (part + 4.0 * midway + numbers[PART]) / 6.0 * moved * along
        numbers[PLACE], numbers[SIDE] = drift / yields, along if event != TURN else -along
    part, energy, side = numbers[PART], numbers[ENERGY], numbers[SIDE]
    share = max(1.0 - numbers[DELTA_A] * energy, 0.0) / (1.0 + numbers[DELTA_NU] * energy)
    numbers[STRENGTH] = share ** (1.0 / numbers[EXPONENT])  # what ζ tends to, (A/ν)^(1/n)
    toward = side if side != 0.0 else 1.0
    length = chord_length(numbers, part, energy, toward)
    if side == 0.0:
        length *= 0.5  # there is no loop within the line at rest
    end = step_of_part(numbers, part, energy, toward, length)
    sag = step_of_part(numbers, part, energy, toward, 0.5 * length) - 0.5 * (part + end)
    steered = min(max(part + 2.0 / 3.0 * sag - held, -STEERED * length), STEERED * length)
    slope = hardening + soft * (end - part + steered) / (toward * length)
    if side == 0.0:  # at rest both directions begin alike
        return follow_line(numbers, slots, (0.0, 0.0, slope), 0.0, (-length * yields, length * yields))
    numbers[UNLOADING] = max(hardening + soft * rise(numbers, part, energy, -side), 0.01 * stiffness)
    line = side * drift, side * (hardening * drift + soft * yields * held), slope
    return follow_path(numbers, slots, line, side, side * drift + length * yields)


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
