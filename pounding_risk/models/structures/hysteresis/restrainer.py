"""A spring between neighbours that may pull past a slack alone, and may break."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import BEGIN, OWN, SLOPE, STIFFNESS, follow_line

ORDER = 50
WORDS = "pulls past a slack and does not push, or breaks"
REFERENCE = "piecewise linear; nothing is lost but the energy of a spring that breaks"
OPTIONS: tuple[str, ...] = ()
USE = "link"
SLACK, REACH = OWN, OWN + 1


def own_numbers(law, stiffness, drifts, shears):
    """The slack, −∞ for a spring that pushes too, and the deformation at which it breaks, of drifts of a backbone."""
    return [drifts[0], inf]


def refusal(slopes):
    """Never anything: a restrainer has no backbone."""
    return ""


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`. Its displacement is u_left − u_right, below zero where stretched."""
    event, slack, reach = slots[0], numbers[SLACK], numbers[REACH]
    pushes = slack == -inf
    if event != BEGIN and numbers[SLOPE] > 0.0 and (event < 0.0 or pushes):
        return follow_line(numbers, slots, (0.0, 0.0, 0.0), 0.0, (-inf, inf))
    if pushes:
        return follow_line(numbers, slots, (0.0, 0.0, numbers[STIFFNESS]), 0.0, (-reach, reach))
    if event == BEGIN or event > 0.0:
        return follow_line(numbers, slots, (0.0, 0.0, 0.0), 0.0, (-slack, inf))
    return follow_line(numbers, slots, (-slack, 0.0, numbers[STIFFNESS]), 0.0, (-slack - reach, -slack))


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
