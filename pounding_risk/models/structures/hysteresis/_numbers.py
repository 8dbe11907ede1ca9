"""Where the numbers of a storey's law stand in its row: those that every law has, then the law's own.

A law is called at an event of its storey with the slots (event, drift, shear) and gives back the branch that follows:
slots (TANGENT, CONSTANT, direction), V = TANGENT d + CONSTANT, and in its row the drifts at which the branch ends. A
branch of direction 0 is followed both ways; one of ±1 is left where the drift's rate changes its sign.
"""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import small

# Written by the solver: the address of the law, the event that is met next, work done [J], drift [m] and shear [N] at
# the last event, drift at which a storey has collapsed, direction of the branch, and its potential at no drift [J].
# By the law: drifts at which the branch ends, its tangent and constant, stiffness with which it would unload now, the
# smaller of the shares of strength that are left in the two directions. Given: the elastic stiffness, the drift at
# yield, the rate of a vibration on the stiffness [1/s], points of the backbone from yield on, the slope past the last
# of them; of a link the body that it is in, and whether the law follows the rate of its stretch, not the stretch. Such
# a law has the longest flight on its STIFFNESS [s] and what a slope beyond that shortens it by [m/(N s)]; the solver
# writes its largest speed [m/s] and the energy that it has taken [J]. On a brace, a spring in series, of a stiffness
# above zero [N/m], it follows what is left of the rate of the stretch beside that of the brace, whose deformation is a
# dof; then flights are shortened by a stiffness over the slope.
(
    VERB, COMING, WORK, DRIFT, SHEAR, COLLAPSE, DIRECTION, POTENTIAL, LOWER, UPPER, SLOPE, CONSTANT, UNLOADING,
    STRENGTH, STIFFNESS, SIZE, PACE, COUNT, LAST_SLOPE, OWNER, ALONG_RATE, LONGEST, SHORTENING, FASTEST, TAKEN, BRACE,
    BRACE_DOF, OWN,
) = range(28)  # fmt: skip
# Events; ±1 where the drift passes the upper or the lower end of its branch, STAY where a flight only ends.
BEGIN, TURN, STAY = 0.0, 2.0, 4.0
# No events: a law along the rate is asked for its force at a speed, given back in place of the shear; or for the speed
# at a force, and for how it rises with the force.
AT, AT_FORCE = 3.0, 5.0


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
