"""Laws of storeys and links (`models.structures.hysteresis`): their events, branches and work."""

from __future__ import annotations

from pounding_risk._jit.calls import call_on
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import (
    BEGIN,
    COLLAPSE,
    COMING,
    CONSTANT,
    DIRECTION,
    DRIFT,
    LOWER,
    PACE,
    POTENTIAL,
    SHEAR,
    SIZE,
    SLOPE,
    STIFFNESS,
    TURN,
    UNLOADING,
    UPPER,
    VERB,
    WORK,
)
from pounding_risk.solver.pair.taylor import SIGNAL, first_rise

# A storey yields this many times its limit off, so that rounding does not switch it back and forth.
OVER = 1.0 + 1e-12
ROUNDED = 1e-15  # m


@small
def margin(numbers, i):
    """How far past an end of its branch a law changes it [m]: more than displacements of metres round by."""
    return (OVER - 1.0) * numbers[i, SIZE] + ROUNDED


@kernel
def middle_and_half(numbers, i):
    """The middle and half the width of the branch on which a law is elastic [m]."""
    lower, upper = numbers[i, LOWER], numbers[i, UPPER]
    return 0.5 * (lower + upper), 0.5 * (upper - lower)


@kernel
def advance_law(numbers, slots, i, event, drift):
    """Follow a law past an event: its branch stands in its row of ``numbers``. Returns whether a storey collapsed."""
    shear = numbers[i, SLOPE] * drift + numbers[i, CONSTANT]
    numbers[i, WORK] += 0.5 * (numbers[i, SHEAR] + shear) * (drift - numbers[i, DRIFT])
    if abs(drift) >= numbers[i, COLLAPSE]:
        numbers[i, DRIFT] = drift
        return True
    if event == BEGIN:
        numbers[i, UNLOADING] = numbers[i, STIFFNESS]
    slots[0], slots[1], slots[2] = event, drift, shear
    call_on(numbers[i, VERB], numbers, i, slots)
    tangent, constant, numbers[i, DIRECTION] = slots[0], slots[1], slots[2]
    shear = tangent * drift + constant
    numbers[i, DRIFT], numbers[i, SHEAR] = drift, shear
    numbers[i, LOWER] = max(numbers[i, LOWER], -numbers[i, COLLAPSE])
    numbers[i, UPPER] = min(numbers[i, UPPER], numbers[i, COLLAPSE])
    # Of the work, what unloading would give back.
    recoverable = 0.5 * shear * shear / numbers[i, UNLOADING]
    numbers[i, POTENTIAL] = recoverable - (0.5 * tangent * drift + constant) * drift
    return False


@kernel
def next_event_of_law(run, numbers, i, signal, stop, terms):
    """When a law changes its branch on (0, stop] of a flight, or −1; which event it is goes to COMING of its numbers.

    Row ``signal`` of ``run.series`` has the drift's Taylor coefficients.
    """
    search = run.workspace.search
    direction, earliest = numbers[i, DIRECTION], -1.0
    slack = margin(numbers, i)
    for side in range(2):
        sign = 1.0 - 2.0 * side
        if direction != 0.0 and sign != direction:
            continue
        for n in range(terms):
            search.series[SIGNAL, n] = sign * run.series[signal, n]
        end = (numbers[i, UPPER] if sign > 0.0 else -numbers[i, LOWER]) + slack
        time = first_rise(search, terms, end, stop if earliest < 0.0 else earliest)
        if time >= 0.0:
            earliest, numbers[i, COMING] = time, sign
    if direction != 0.0:
        for n in range(terms - 1):
            search.series[SIGNAL, n] = -direction * (n + 1) * run.series[signal, n + 1]
        time = first_rise(search, terms - 1, slack * numbers[i, PACE], stop if earliest < 0.0 else earliest)
        if time >= 0.0:
            earliest, numbers[i, COMING] = time, TURN
    return earliest


@small
def strain_margin(numbers, i, drift, rate):
    """(margin, its slope per unit of the drift's) of a turn, or of an end of a branch that is followed both ways."""
    direction, slack = numbers[i, DIRECTION], margin(numbers, i)
    if direction != 0.0:
        return direction * rate + slack * numbers[i, PACE], 0.0
    above, below = numbers[i, UPPER] - drift, drift - numbers[i, LOWER]  # one of them may be infinite
    return (above + slack, -1.0) if above < below else (below + slack, 1.0)


@small
def corner_margin(numbers, i, drift):
    """(margin, its slope per unit of the drift's) of the end of a branch of loading."""
    side = numbers[i, DIRECTION]
    corner = numbers[i, UPPER] if side > 0.0 else -numbers[i, LOWER]
    return corner + margin(numbers, i) - side * drift, -side


@kernel
def note_event(numbers, i, is_corner, drift):
    """Note which event a law meets at a drift."""
    if is_corner:
        numbers[i, COMING] = numbers[i, DIRECTION]
    elif numbers[i, DIRECTION] != 0.0:
        numbers[i, COMING] = TURN
    else:
        numbers[i, COMING] = 1.0 if numbers[i, UPPER] - drift < drift - numbers[i, LOWER] else -1.0
