"""Kinematic hardening of a multilinear backbone: the rule of Masing."""

from __future__ import annotations

from itertools import pairwise
from math import inf

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import BEGIN, COUNT, LAST_SLOPE, OWN, TURN, follow_line

ORDER = 10
WORDS = "kinematic hardening: after a turn each branch is twice as long as on the backbone"
REFERENCE = "Masing (1926); Iwan (1966), Journal of Applied Mechanics 33"
USE = "storey"
OPTIONS: tuple[str, ...] = ()
# Of each element: stiffness [N/m], drift at which it slips, the drift at which it is at rest, whether it slips (±1).
WIDTH = 4


def own_numbers(law, stiffness, drifts, shears):
    """Elements in parallel whose sum has this backbone: each elastic up to its drift, then at its shear."""
    slopes = [stiffness, *law.slopes(stiffness, drifts, shears)]
    changes = [before - after for before, after in pairwise(slopes)]
    return [number for change, drift in zip(changes, drifts, strict=True) for number in (change, drift, 0.0, 0.0)]


def refusal(slopes):
    """What a backbone of these slopes over the elastic one lacks for the rule; "" where it is one."""
    is_concave = all(after <= before for before, after in pairwise((1.0, *slopes)))
    return "" if is_concave and slopes[-1] >= 0.0 else "a backbone that grows no steeper and never falls"


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`."""
    event, drift, shear = slots[0], slots[1], slots[2]
    count = int(numbers[COUNT])
    if event in (BEGIN, TURN):
        for element in range(count):
            own = OWN + WIDTH * element
            if event == TURN and numbers[own + 3] != 0.0:
                numbers[own + 2] = drift - numbers[own + 3] * numbers[own + 1]
            numbers[own + 3] = 0.0
    else:
        # The element that slips at this end of the branch, and those that slip with it.
        nearest = inf
        for element in range(count):
            own = OWN + WIDTH * element
            if numbers[own + 3] == 0.0:
                nearest = min(nearest, event * numbers[own + 2] + numbers[own + 1])
        for element in range(count):
            own = OWN + WIDTH * element
            end = event * numbers[own + 2] + numbers[own + 1]
            if numbers[own + 3] == 0.0 and end <= nearest + 1e-12 * numbers[own + 1]:
                numbers[own + 3] = event
    slope, lower, upper, direction = numbers[LAST_SLOPE], -inf, inf, 0.0
    for element in range(count):
        own = OWN + WIDTH * element
        if numbers[own + 3] == 0.0:
            slope += numbers[own]
            lower = max(lower, numbers[own + 2] - numbers[own + 1])
            upper = min(upper, numbers[own + 2] + numbers[own + 1])
        else:
            direction = numbers[own + 3]
    if direction > 0.0:
        lower = -inf
    elif direction < 0.0:
        upper = inf
    return follow_line(numbers, slots, (drift, shear, slope), direction, (lower, upper))


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
