"""Peak-oriented hysteresis with pinching, softer unloading and strength that is lost with dissipated energy.

From zero shear a storey is loaded towards the largest drift that it has had in that direction, the yield drift at
least, and from there on along its backbone. With pinching it goes there by way of a softer point. It unloads with

    k_u = k (d_max / d_y)^(−β), no softer than the secant to its largest drift,

and returns on the same line to the path that it has left. Where shear passes zero, the backbone of the direction that
follows is multiplied by 1 − (E_i / (E_t − Σ E))^c, E_i the energy dissipated since the last passage.
"""

from __future__ import annotations

from math import inf

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import (
    BEGIN,
    COUNT,
    LAST_SLOPE,
    LOWER,
    OWN,
    STIFFNESS,
    STRENGTH,
    TURN,
    UNLOADING,
    UPPER,
    WORK,
    follow_line,
    follow_path,
)

ORDER = 30
WORDS = "each cycle is loaded towards the largest drift before, with or without pinching and loss of strength"
REFERENCE = (
    "Clough (1966); Takeda, Sozen and Nielsen (1970); Ibarra, Medina and Krawinkler (2005), Earthquake Engineering and "
    "Structural Dynamics 34"
)
USE = "storey"
OPTIONS = ("pinching_drift", "pinching_force", "unloading", "energy_capacity", "energy_exponent")
# Own parameters; the direction of the present path; where it starts, its pinch point and its target, (drift, shear)
# counted positive in its direction; largest drifts and shares of strength, upwards and downwards; work at the last
# passage through zero shear; (drift, shear) of the backbone's points.
(
    PINCH_DRIFT, PINCH_FORCE, EXPONENT, CAPACITY, ENERGY_EXPONENT, SIDE, RELOAD, PINCH, PINCH_SHEAR, TARGET,
    TARGET_SHEAR, PEAK_UP, PEAK_DOWN, LEFT_UP, LEFT_DOWN, PASSED, POINTS,
) = range(OWN, OWN + 17)  # fmt: skip
LOST = 2.0  # in place of a direction, of a storey without strength


def own_numbers(law, stiffness, drifts, shears):
    """The rule's parameters, a memory without any drift, and the backbone."""
    capacity = law.energy_capacity * shears[0] * drifts[0]
    parameters = [law.pinching_drift, law.pinching_force, law.unloading, capacity, law.energy_exponent]
    memory = [0.0] * 6 + [drifts[0], drifts[0], 1.0, 1.0, 0.0]
    return [*parameters, *memory, *(number for point in zip(drifts, shears, strict=True) for number in point)]


def refusal(slopes):
    """What a backbone of these slopes over the elastic one lacks for the rule; "" where it is one."""
    is_soft = min(slopes) >= -1.0 and max(slopes) < 1.0
    return "" if is_soft else "a backbone no branch of which is as steep as the elastic one"


@small
def backbone_at(numbers, drift):
    """(shear, slope, drift where the piece ends) of the backbone with its full strength, from the yield drift on."""
    count = int(numbers[COUNT])
    piece = 0
    while piece + 1 < count and drift >= numbers[POINTS + 2 * piece + 2] * (1.0 - 1e-12):
        piece += 1
    start, shear = numbers[POINTS + 2 * piece], numbers[POINTS + 2 * piece + 1]
    if piece + 1 == count:
        slope, stop = numbers[LAST_SLOPE], inf
    else:
        stop = numbers[POINTS + 2 * piece + 2]
        slope = (numbers[POINTS + 2 * piece + 3] - shear) / (stop - start)
    return shear + slope * (drift - start), slope, stop


@small
def share_left(numbers, side):
    """The share of its strength that a direction has left."""
    return numbers[LEFT_UP] if side > 0.0 else numbers[LEFT_DOWN]


@small
def largest_drift(numbers, side):
    """The largest drift in a direction so far, the yield drift at least."""
    return numbers[PEAK_UP] if side > 0.0 else numbers[PEAK_DOWN]


@small
def unloading_stiffness(numbers, side):
    """k_u of a direction [N/m]."""
    peak, stiffness = largest_drift(numbers, side), numbers[STIFFNESS]
    if numbers[EXPONENT] == 0.0:
        return stiffness
    secant = share_left(numbers, side) * backbone_at(numbers, peak)[0] / peak
    return max(stiffness * (peak / numbers[POINTS]) ** -numbers[EXPONENT], secant)


@small
def load(numbers, slots, side, reach):
    """Load towards ``side`` from a drift ``reach`` on: to the pinch point, to the target, or along the backbone."""
    numbers[SIDE] = side
    numbers[UNLOADING] = unloading_stiffness(numbers, side)
    if reach >= numbers[TARGET] * (1.0 - 1e-12):
        share = share_left(numbers, side)
        shear, slope, corner = backbone_at(numbers, reach)
        return follow_path(numbers, slots, (reach, share * shear, share * slope), side, corner)
    if reach >= numbers[PINCH] - 1e-12 * numbers[POINTS]:
        slope = (numbers[TARGET_SHEAR] - numbers[PINCH_SHEAR]) / (numbers[TARGET] - numbers[PINCH])
        line = numbers[PINCH], numbers[PINCH_SHEAR], slope
        return follow_path(numbers, slots, line, side, numbers[TARGET])
    slope = numbers[PINCH_SHEAR] / (numbers[PINCH] - numbers[RELOAD])
    return follow_path(numbers, slots, (numbers[RELOAD], 0.0, slope), side, numbers[PINCH])


@small
def unload(numbers, slots, drift, shear):
    """The motion turns: unload to zero shear, or back to the path that is left."""
    side = numbers[SIDE]
    reach, force = side * drift, max(side * shear, 0.0)
    if reach >= numbers[TARGET] * (1.0 - 1e-12):
        numbers[TARGET], numbers[TARGET_SHEAR] = reach, force
        if side > 0.0:
            numbers[PEAK_UP] = max(numbers[PEAK_UP], reach)
        else:
            numbers[PEAK_DOWN] = max(numbers[PEAK_DOWN], reach)
    stiffness = unloading_stiffness(numbers, side)
    numbers[UNLOADING] = stiffness
    zero = reach - force / stiffness
    ends = (zero, reach) if side > 0.0 else (-reach, -zero)
    return follow_line(numbers, slots, (drift, shear, stiffness), 0.0, ends)


@small
def weaken(numbers, side):
    """The backbone of direction ``side`` loses strength by the energy since the last passage through zero shear."""
    spent = max(numbers[WORK] - numbers[PASSED], 0.0)
    remaining = numbers[CAPACITY] - numbers[WORK]
    numbers[PASSED] = numbers[WORK]
    if numbers[CAPACITY] == inf or spent == 0.0:
        return
    lost = 1.0 if remaining <= spent else (spent / remaining) ** numbers[ENERGY_EXPONENT]
    if side > 0.0:
        numbers[LEFT_UP] *= 1.0 - lost
    else:
        numbers[LEFT_DOWN] *= 1.0 - lost
    numbers[STRENGTH] = min(numbers[LEFT_UP], numbers[LEFT_DOWN])


@small
def pass_zero(numbers, slots, drift):
    """Shear passes zero: load the other direction, towards its largest drift."""
    side = -numbers[SIDE]
    weaken(numbers, side)
    if numbers[STRENGTH] <= 0.0:
        numbers[SIDE] = LOST
        return follow_line(numbers, slots, (drift, 0.0, 0.0), 0.0, (-inf, inf))
    stiffness, share = unloading_stiffness(numbers, side), share_left(numbers, side)
    reload, target = side * drift, largest_drift(numbers, side)
    shear = share * backbone_at(numbers, target)[0]
    if target - reload < shear / stiffness:
        # No path is steeper than unloading is.
        target = reload + shear / stiffness
        shear = share * backbone_at(numbers, target)[0]
    pinch_shear = numbers[PINCH_FORCE] * shear
    pinch = reload + (target - (shear - pinch_shear) / stiffness - reload) * numbers[PINCH_DRIFT]
    if pinch >= target or numbers[PINCH_FORCE] >= 1.0:
        pinch, pinch_shear = reload, 0.0
    elif pinch - reload < pinch_shear / stiffness:
        # Along the unloading stiffness to where it meets the line from the pinch point to the target.
        slope = min((shear - pinch_shear) / (target - pinch), (1.0 - 1e-9) * stiffness)
        pinch = (pinch_shear - slope * pinch + stiffness * reload) / (stiffness - slope)
        pinch_shear = stiffness * (pinch - reload)
    numbers[RELOAD], numbers[PINCH], numbers[PINCH_SHEAR] = reload, pinch, pinch_shear
    numbers[TARGET], numbers[TARGET_SHEAR] = target, shear
    return load(numbers, slots, side, reload)


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`."""
    event, drift, shear = slots[0], slots[1], slots[2]
    yields = numbers[POINTS]
    if event == BEGIN:
        return follow_line(numbers, slots, (drift, shear, numbers[STIFFNESS]), 0.0, (-yields, yields))
    if event == TURN:
        return unload(numbers, slots, drift, shear)
    # Landed on an end to rounding, the branch is over.
    reach = max(event * drift, numbers[UPPER] if event > 0.0 else -numbers[LOWER])
    if numbers[SIDE] == 0.0:
        numbers[TARGET], numbers[TARGET_SHEAR] = yields, numbers[POINTS + 1]
        return load(numbers, slots, event, reach)
    if event == numbers[SIDE]:
        return load(numbers, slots, event, reach)
    return pass_zero(numbers, slots, drift)


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
