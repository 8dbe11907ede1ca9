"""Where the numbers of a storey's law stand in its row: those that every law has, then the law's own.

A law is called at an event of its storey with the slots (event, drift, shear) and gives back the branch that follows:
slots (TANGENT, CONSTANT, direction), V = TANGENT d + CONSTANT, and in its row the drifts at which the branch ends. A
branch of direction 0 is followed both ways; one of ±1 is left where the drift's rate changes its sign.
"""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import small

# Written by the solver: the address of the law, the event that the storey meets next, work done on the storey [J], and
# drift [m] and shear [N] at its last event; drift at which it has collapsed. By the law: drifts at which its branch
# ends, tangent and constant of the branch, stiffness with which it would unload now, the smaller of the shares of its
# strength that are left in the two directions. Then the elastic stiffness, points of the backbone from yield on, and
# the slope past the last of them.
(
    VERB,
    COMING,
    WORK,
    DRIFT,
    SHEAR,
    COLLAPSE,
    LOWER,
    UPPER,
    SLOPE,
    CONSTANT,
    UNLOADING,
    STRENGTH,
    STIFFNESS,
    COUNT,
    LAST_SLOPE,
    OWN,
) = range(16)
BEGIN, TURN = 0.0, 2.0  # events; ±1 where the drift passes the upper or the lower end of its branch


@small
def follow_line(numbers, slots, line, direction, ends):
    """Give back the branch through ``line`` = (drift, shear, slope), between the drifts ``ends``."""
    slots[0] = numbers[SLOPE] = line[2]
    slots[1] = numbers[CONSTANT] = line[1] - line[2] * line[0]
    slots[2] = direction
    numbers[LOWER], numbers[UPPER] = ends[0], ends[1]
    return 0.0


@small
def follow_path(numbers, slots, line, side, corner):
    """Give back a branch of loading towards ``side``, in drifts and shears counted positive there, up to a corner."""
    ends = (-inf, corner) if side > 0.0 else (-corner, inf)
    return follow_line(numbers, slots, (side * line[0], side * line[1], line[2]), side, ends)
