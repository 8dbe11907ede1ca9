"""Isotropic hardening of a multilinear backbone: yielding in one direction strengthens the other as much."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import (
    BEGIN,
    COUNT,
    LAST_SLOPE,
    OWN,
    STIFFNESS,
    TURN,
    follow_line,
    follow_path,
)

ORDER = 20
WORDS = "isotropic hardening: the yield shear follows the backbone with all plastic travel, in both directions"
REFERENCE = "Odqvist (1933) for the rule; code_aster, test SDND124A, for a storey with it"
USE = "storey"
OPTIONS: tuple[str, ...] = ()
# Plastic travel when the present branch began [m], drift and shear then, the direction of its loading, 0 while it is
# elastic; (travel, shear) of the backbone's points.
TRAVEL, START, START_SHEAR, SIDE, POINTS = range(OWN, OWN + 5)


def own_numbers(law, stiffness, drifts, shears):
    """No travel yet, and the shears over the plastic travel at which they are reached."""
    points = [number for d, v in zip(drifts, shears, strict=True) for number in (d - v / stiffness, v)]
    return [0.0, 0.0, 0.0, 0.0, *points]


def refusal(slopes):
    """What a backbone of these slopes over the elastic one lacks for the rule; "" where it is one."""
    return "" if max(slopes) < 1.0 else "a backbone whose branches past yield are softer than the elastic one"


@small
def piece_at(numbers, travel):
    """(shear, slope over drift, travel where it ends) of the backbone at a plastic travel."""
    count, stiffness = int(numbers[COUNT]), numbers[STIFFNESS]
    piece = 0
    while piece + 1 < count and travel >= numbers[POINTS + 2 * piece + 2] * (1.0 - 1e-12):
        piece += 1
    start, shear = numbers[POINTS + 2 * piece], numbers[POINTS + 2 * piece + 1]
    if piece + 1 == count:
        slope, stop = numbers[LAST_SLOPE], inf
        rise = slope * stiffness / (stiffness - slope)
    else:
        stop = numbers[POINTS + 2 * piece + 2]
        rise = (numbers[POINTS + 2 * piece + 3] - shear) / (stop - start)
        slope = rise * stiffness / (stiffness + rise)
    return shear + rise * (travel - start), slope, stop


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`."""
    event, drift, shear = slots[0], slots[1], slots[2]
    stiffness, side = numbers[STIFFNESS], numbers[SIDE]
    if side != 0.0:
        plastic = side * (drift - numbers[START]) - side * (shear - numbers[START_SHEAR]) / stiffness
        travel = numbers[TRAVEL] + plastic
        # Landed on a corner to rounding, the branch is over.
        numbers[TRAVEL] = travel if event == TURN else max(travel, piece_at(numbers, numbers[TRAVEL])[2])
    if event in (BEGIN, TURN):
        limit = piece_at(numbers, numbers[TRAVEL])[0]
        numbers[SIDE] = 0.0
        ends = drift - (shear + limit) / stiffness, drift + (limit - shear) / stiffness
        return follow_line(numbers, slots, (drift, shear, stiffness), 0.0, ends)
    numbers[SIDE], numbers[START], numbers[START_SHEAR] = event, drift, shear
    _, slope, stop = piece_at(numbers, numbers[TRAVEL])
    corner = event * drift + (stop - numbers[TRAVEL]) / (1.0 - slope / stiffness)
    return follow_path(numbers, slots, (event * drift, event * shear, slope), event, corner)


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
