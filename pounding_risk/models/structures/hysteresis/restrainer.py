"""A hook or cable: it pulls once it is stretched by more than its slack, and never pushes."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import BEGIN, OWN, STIFFNESS, follow_line

ORDER = 50
WORDS = "pulls past a slack and does not push"
REFERENCE = "piecewise linear, without loss"
OPTIONS: tuple[str, ...] = ()
USE = "link"
SLACK = OWN


def own_numbers(law, stiffness, drifts, shears):
    """The slack, which stands in place of the displacement at yield."""
    return [drifts[0]]


def refusal(slopes):
    """Never anything: a hook has no backbone."""
    return ""


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`. Its displacement is u_left − u_right, below zero where stretched."""
    event, slack = slots[0], numbers[SLACK]
    if event == BEGIN or event > 0.0:
        return follow_line(numbers, slots, (0.0, 0.0, 0.0), 0.0, (-slack, inf))
    return follow_line(numbers, slots, (-slack, 0.0, numbers[STIFFNESS]), 0.0, (-inf, -slack))


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
