"""The linear spring, alone and with a dashpot: Kelvin-Voigt as published, without tension, and on approach only."""

from __future__ import annotations

from math import exp, log, pi, sqrt
from typing import Annotated, NamedTuple

from pounding_risk._jit.compile import small
from pounding_risk.models.contact.damping import approach_ratio, positive_root
from pounding_risk.models.contact.law import (
    LINEAR_STIFFNESS,
    flat,
    linear_energy,
    may_pull,
    never_yields,
    undamped,
    without_damper,
)

ORDER = 10


class Linear(NamedTuple):
    """Linear spring: F = k δ. Elastic, e = 1; peak force v0 sqrt(k m), duration π sqrt(m/k).

    >>> Linear(1e8).force(0.0, 0.01, 1.0, True)
    1000000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "linear spring"
    capped, needs_restitution = False, False

    begin, conserves = undamped, without_damper

    def force(self, memory, delta, rate, approaching):
        return self.stiffness * delta

    plateau, stored, ceiling, floor = flat, linear_energy, never_yields, may_pull


@small
def kelvin_voigt_ratio(e):
    """ξ = −ln e / sqrt(π² + ln² e) (Anagnostopoulos 1988)."""
    fall = -log(e)
    return fall / sqrt(pi * pi + fall * fall)


def kelvin_voigt_damping(self, e, speed, mass):
    """c = 2 ξ sqrt(k m)."""
    return 2.0 * kelvin_voigt_ratio(e) * sqrt(self.stiffness * mass)


def kelvin_voigt_force(self, memory, delta, rate, approaching):
    """k δ + c δ̇."""
    return self.stiffness * delta + memory * rate


class KelvinVoigt(NamedTuple):
    """Spring and dashpot side by side, as published: F = k δ + c δ̇ until δ is zero again.

    c = 2 ξ sqrt(k m), ξ = −ln e / sqrt(π² + ln² e). The force starts at c v0 and pulls before separation;
    e is achieved exactly.

    >>> KelvinVoigt(1e8).force(2e5, 0.01, 1.0, True)
    1200000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "Anagnostopoulos (1988), Earthquake Engineering and Structural Dynamics 16"
    capped, needs_restitution = False, True

    begin, force, plateau = kelvin_voigt_damping, kelvin_voigt_force, flat
    stored, ceiling, floor = linear_energy, never_yields, may_pull


class KelvinVoigtTensionCut(NamedTuple):
    """Kelvin-Voigt that cannot pull: F = max(0, k δ + c δ̇), same ξ(e).

    The e achieved is larger than the e asked for: exp[−(ξ/s)(π − atan2(2 ξ s, 1 − 2 ξ²))], s = sqrt(1 − ξ²).

    >>> KelvinVoigtTensionCut(1e8).floor()
    0.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "Komodromos et al. (2007), Earthquake Engineering and Structural Dynamics 36"
    capped, needs_restitution = False, True

    begin, force, plateau = kelvin_voigt_damping, kelvin_voigt_force, flat
    stored, ceiling = linear_energy, never_yields

    def floor(self):
        return 0.0


class KelvinVoigtTensionCutExact(KelvinVoigtTensionCut):
    """Kelvin-Voigt that cannot pull: c = 2 ξ sqrt(k m), exp[−2 (ξ/s) atan2(s, ξ)] = e, s = sqrt(1 − ξ²).

    >>> round(KelvinVoigtTensionCutExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.14994
    """

    __slots__ = ()

    def begin(self, e, speed, mass):
        return 2.0 * approach_ratio(sqrt(e)) * sqrt(self.stiffness * mass)


class ModifiedKelvinVoigt(NamedTuple):
    """Dashpot on approach only: F = k δ + c δ̇ (δ̇ > 0), F = k δ (δ̇ ≤ 0).

    c = 2 ξ sqrt(k m), ξ = (1 − e²) / (e (e (π − 2) + 2)); the e achieved is within 0.007 of the e asked for.

    >>> ModifiedKelvinVoigt(1e8).force(2e5, 0.01, -1.0, False)
    1000000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "Mahmoud and Jankowski (2011), modified linear viscoelastic model"
    capped, needs_restitution = False, True

    def begin(self, e, speed, mass):
        ratio = (1.0 - e * e) / (e * (e * (pi - 2.0) + 2.0))
        return 2.0 * ratio * sqrt(self.stiffness * mass)

    def force(self, memory, delta, rate, approaching):
        spring = self.stiffness * delta
        return spring + memory * rate if approaching else spring

    plateau, stored, ceiling, floor = flat, linear_energy, never_yields, may_pull


class ModifiedKelvinVoigtExact(ModifiedKelvinVoigt):
    """Dashpot on approach only: c = 2 ξ sqrt(k m), exp[−(ξ/s) atan2(s, ξ)] = e, s = sqrt(1 − ξ²).

    >>> round(ModifiedKelvinVoigtExact(1.0).begin(0.65, 1.0, 1.0) / 2.0, 5)
    0.32929
    """

    __slots__ = ()

    def begin(self, e, speed, mass):
        return 2.0 * approach_ratio(e) * sqrt(self.stiffness * mass)


def kelvin_voigt_restitution(ratio: float) -> float:
    """e = exp(−π ξ / sqrt(1 − ξ²)), from ξ = −ln e / sqrt(π² + ln² e); Anagnostopoulos (1988)."""
    return exp(-pi * ratio / sqrt(1.0 - ratio * ratio))


def modified_kelvin_voigt_restitution(ratio: float) -> float:
    """The root in (0, 1] of (ξ (π − 2) + 1) e² + 2 ξ e − 1 = 0; Mahmoud and Jankowski (2011)."""
    return positive_root(ratio * (pi - 2.0) + 1.0, ratio, 1.0)


EXACT = {
    KelvinVoigt: KelvinVoigt,
    KelvinVoigtTensionCut: KelvinVoigtTensionCutExact,
    ModifiedKelvinVoigt: ModifiedKelvinVoigtExact,
}
RESTITUTION_OF_RATIO = {
    KelvinVoigt: (kelvin_voigt_restitution, 1.0),
    KelvinVoigtTensionCut: (kelvin_voigt_restitution, 1.0),
    ModifiedKelvinVoigt: (modified_kelvin_voigt_restitution, 1e6),
}
