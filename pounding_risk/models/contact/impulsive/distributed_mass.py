"""The distributed-mass model: floors as elastic bars that collide end to end."""

from __future__ import annotations

from collections.abc import Iterator
from math import exp, expm1, floor, inf, log, log1p
from typing import Annotated, Any, NamedTuple

from pounding_risk._jit.compile import kernel
from pounding_risk.models.contact.law import never_yields
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED
from pounding_risk.units import FLOOR_LENGTH, WAVE_SPEED

ORDER = 20
EQUAL = 1.0 - 1e-12  # impedances that differ by less are equal: their waves leave no force that goes on


@kernel
def floor_of(length, speed, inverse_mass):
    """(there and back of a wave [s], 1 / impedance [m/(N s)]) of a floor; a rigid building is a wall: (inf, 0)."""
    if inverse_mass == 0.0:
        return inf, 0.0
    return 2.0 * length / speed, length * inverse_mass / speed


@kernel
def short_and_long(law, left, right):
    """`floor_of` both floors, the one whose wave is back first in front; of equals the softer one."""
    one = floor_of(law.left_length, law.left_speed, left)
    other = floor_of(law.right_length, law.right_speed, right)
    if one[0] < other[0] or (one[0] == other[0] and one[1] >= other[1]):
        return one, other
    return other, one


@kernel
def stepped_sum(give, total, steps):
    """(1 + r + r² + … over ``steps``, which need not be whole; 1 − r^K (1 − q f)), K + f = steps, q = 1 − r.

    r = (total − 2 give) / total, in a form that keeps its digits where r is close to 1.
    """
    fall = 2.0 * give / total
    whole = floor(steps)
    part = steps - whole
    rate = log1p(-fall) if fall < 0.5 else log((total - 2.0 * give) / total)
    left = exp(whole * rate)
    return -expm1(whole * rate) / fall + part * left, left * (1.0 - fall * part)


class DistributedMass(NamedTuple):
    """The floors as elastic bars that collide end to end: one-dimensional waves, no loss of material.

    A floor of length L, wave speed c and the building's mass m has impedance Z = m c / L and sends a wave back after
    T = 2 L / c. At the touch F0 = v0 / (1/Z1 + 1/Z2). With s the floor of the shorter T, l the other, τ = T_s / T_l:

        Z_s ≤ Z_l:  F = F0 for T_s, then they part;  e = (Z_l − Z_s + 2 Z_s τ) / (Z_s + Z_l)
        Z_s > Z_l:  F = F0 r^k from k T_s to (k + 1) T_s, r = (Z_s − Z_l) / (Z_s + Z_l), until they part at T_l;
                    e = τ (1 + r) (1 + r + … + r^(K−1) + f r^K) − r^K (1 − f (1 − r)),  K + f = 1 / τ, K whole

    e is that of the masses' centres; what is missing, (1 − e²) m v0² / 2, is left as waves in the floors. 0 ≤ e ≤ 1:
    in the first line τ ≤ 1, in the second the sum is at least r^K / τ, and no energy is made. Equal Z give
    e = L_s / L_l where c is the same; a rigid building is a wall: e = 1, F0 = v0 Z for T.

    The buildings' velocities jump at the touch, for T is short beside their periods, and every touch finds the floors
    without waves. A floor that carries more than its own mass has c = L sqrt(K / m), K = E A / L its stiffness.

    >>> [round(number, 3) for number in DistributedMass(10.0, 20.0).strike(1.0, 2e-6, 1e-6)]
    [0.5, 87500000.0, 0.006]
    """

    left_length: Annotated[float, FLOOR_LENGTH]
    right_length: Annotated[float, FLOOR_LENGTH]
    left_speed: Annotated[float, WAVE_SPEED] = CONCRETE_WAVE_SPEED
    right_speed: Annotated[float, WAVE_SPEED] = CONCRETE_WAVE_SPEED

    reference = "Cole et al. (2011), effects of mass distribution, Earthquake Engineering and Structural Dynamics 40"
    capped, needs_restitution = False, False
    only_in_pairs = "the waves of one touch would still be in a floor when its other neighbour strikes it"

    ceiling = never_yields

    @classmethod
    def between(cls, left: Any, right: Any) -> DistributedMass:
        """The model between two `Building`s, each with its ``floor_length`` and ``wave_speed``."""
        numbers = left.floor_length, right.floor_length, left.wave_speed, right.wave_speed
        return cls(*numbers)  # type: ignore[call-arg]

    def strike(self, e, left, right):
        (back, give), (later, other) = short_and_long(self, left, right)
        total, share = give + other, back / later
        if give >= EQUAL * other:
            ratio, lasts = (give - other + 2.0 * other * share) / total, back
        else:
            summed, rest = stepped_sum(give, total, later / back)
            ratio, lasts = 2.0 * other / total * share * summed - rest, later
        # Within the bounds but for rounding.
        return min(max(ratio, 0.0), 1.0), 1.0 / total, lasts

    def course(self, left: float, right: float) -> Iterator[tuple[float, float, float]]:
        """The steps of the force between inverse masses: (start [s], end [s], force over approach speed [N s/m])."""
        (back, give), (later, other) = short_and_long(self, left, right)
        total = give + other
        ends = back if give >= EQUAL * other else later
        force, count = 1.0 / total, 0
        while count * back < ends:
            yield count * back, min((count + 1) * back, ends), force
            force *= (other - give) / total
            count += 1
