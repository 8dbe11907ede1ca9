"""A damper whose force is a power of its speed, F = c |v|^α sgn v with v in m/s, by chords.

A rule along the speed: what stands as drift in `_numbers` is the speed [m/s] here, and a slope is a damping. Below
`LEAST` the force is linear, as the power has no finite slope at rest. From there on chords between speeds in a fixed
ratio are off the power by at most `CHORD` of it, on either side. In contact, where a run takes steps, they are not
needed: the force is the power itself.
"""

from __future__ import annotations

from math import exp, inf, sqrt

from pounding_risk._jit.calls import entry_of_slots
from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.structures.hysteresis._numbers import AT, AT_FORCE, BEGIN, LOWER, OWN, UPPER, follow_line

ORDER = 60
WORDS = "a damper whose force is a power of its speed"
REFERENCE = "F = c |v|^α sgn v, as makers of fluid viscous dampers give it"
OPTIONS: tuple[str, ...] = ()
USE = "link"
LEAST = 1e-3  # m/s
CHORD = 2e-4
COEFFICIENT, EXPONENT, AT_REST, RATIO, RAISED = range(OWN, OWN + 5)


def damping_at_rest(coefficient, exponent):
    """Damping below `LEAST` [N s/m] of a damper of ``coefficient`` [N (s/m)^α]; for α < 1 the largest of any speed."""
    return coefficient if exponent == 1.0 else raised(exponent) * coefficient * LEAST ** (exponent - 1.0)


def raised(exponent):
    """Ends of chords over the power: a chord is below it between them for α < 1, above it for α > 1."""
    return 1.0 + CHORD if exponent < 1.0 else 1.0 - CHORD


def own_numbers(law, stiffness, drifts, shears):
    """c, α and c at rest, and the ratio of the speeds at both ends of a chord; infinite where the damper is linear."""
    exponent = law.exponent
    at_rest = damping_at_rest(stiffness, exponent)
    if exponent == 1.0:
        return [stiffness, exponent, at_rest, inf, 1.0]
    # A chord over a ratio r is off the power by α |1 − α| ln(r)² / 8 of it at most, half of which is put on each side.
    ratio = exp(min(sqrt(16.0 * CHORD / (exponent * abs(1.0 - exponent))), 0.5))
    return [stiffness, exponent, at_rest, ratio, raised(exponent)]


def refusal(slopes):
    """Never anything: a damper has no backbone."""
    return ""


@small
def power_at(numbers, speed):
    """c |v|^α sgn v [N]."""
    force = numbers[COEFFICIENT] * abs(speed) ** numbers[EXPONENT]
    return force if speed > 0.0 else -force


@small
def force_at(numbers, speed):
    """The force without chords [N], linear below `LEAST`."""
    if numbers[RATIO] == inf:
        return numbers[COEFFICIENT] * speed
    return power_at(numbers, speed) if abs(speed) >= LEAST else power_at(numbers, LEAST) * speed / LEAST


@small
def speed_at(numbers, force):
    """The speed at a force [m/s], and its slope [m/(N s)]: the inverse of `force_at`."""
    least = 0.0 if numbers[RATIO] == inf else power_at(numbers, LEAST)
    if abs(force) <= least or numbers[RATIO] == inf:
        slope = LEAST / least if least > 0.0 else 1.0 / numbers[COEFFICIENT]
        return force * slope, slope
    speed = (abs(force) / numbers[COEFFICIENT]) ** (1.0 / numbers[EXPONENT])
    return (speed if force > 0.0 else -speed), speed / (numbers[EXPONENT] * abs(force))


@small
def advance(law, blank, numbers, slots):
    """The branch after an event: see `_numbers`."""
    event, ratio = slots[0], numbers[RATIO]
    if event == AT:
        slots[2] = force_at(numbers, slots[1])
        return 0.0
    if event == AT_FORCE:
        slots[2], slots[3] = speed_at(numbers, slots[1])
        return 0.0
    if event == BEGIN or ratio == inf:
        end = inf if ratio == inf else LEAST
        return follow_line(numbers, slots, (0.0, 0.0, numbers[AT_REST]), 0.0, (-end, end))
    start = numbers[UPPER] if event > 0.0 else numbers[LOWER]
    is_least = abs(start) <= (1.0 + 1e-9) * LEAST
    if event * start > 0.0:
        stop = start * ratio
    elif is_least:
        return follow_line(numbers, slots, (0.0, 0.0, numbers[AT_REST]), 0.0, (-LEAST, LEAST))
    else:
        stop = start / ratio
    ends = numbers[RAISED]
    first, last = ends * power_at(numbers, start), ends * power_at(numbers, stop)
    line = start, first, (last - first) / (stop - start)
    return follow_line(numbers, slots, line, 0.0, (min(start, stop), max(start, stop)))


@kernel
def write_entry(out):
    """Write the address of `advance` to ``out``."""
    out[0] = entry_of_slots(advance, 0.0, 0.0)
