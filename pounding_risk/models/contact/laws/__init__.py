"""Contact laws: the force between two buildings as a function of penetration and its rate.

A law is a NamedTuple whose fields are its parameters and whose methods are its physics. A kernel never asks
which law it has: it says ``law.force(...)``. A law that is added here is found by every command, by the
conformance tests and by the docs.

Symbols: δ penetration [m, > 0 in contact], δ̇ its rate [m/s, > 0 on approach], F force [N, > 0 compression],
k stiffness [N/m], β stiffness [N/m^1.5], m = m1 m2 / (m1 + m2), v0 approach speed at the touch, e restitution.
"""

from __future__ import annotations

import inspect
import sys
from math import inf, log, pi, sqrt
from typing import Annotated, NamedTuple, Protocol, get_type_hints

from pounding_risk._jit.compile import kernel, speaks
from pounding_risk.models.contact.law import complete
from pounding_risk.units import Quantity

LINEAR_STIFFNESS = Quantity("N/m", 0.0, inf, "contact stiffness k", open_low=True, open_high=True)
HERTZ_STIFFNESS = Quantity("N/m^1.5", 0.0, inf, "impact stiffness β", open_low=True, open_high=True)
DESIGN_PENETRATION = Quantity(
    "m", 0.0, inf, "design penetration δ_m of the bilinear law", open_high=True, example="10 mm"
)
EXPONENT = Quantity("1", 0.0, 1.5, "exponent n of the plastic branch")

# Laws that divide by v0 have no value for a touch from rest. Slower touches than this count as this fast; the
# published fits of restitution start some hundred times higher.
SLOWEST_TOUCH = 1e-4  # m/s


@speaks
class ContactLaw(Protocol):
    """What the kernels ask of a law."""

    def begin(self, e, speed, mass):
        """What this contact remembers of its start: a damping constant."""

    def force(self, memory, delta, rate, approaching):
        """Force without any cap; smooth in (δ, δ̇) for a given ``approaching``."""

    def plateau(self, delta, strength):
        """Force transmitted while the uncapped force exceeds ``strength``."""

    def stored(self, delta, strength):
        """Energy that comes back if the bodies part slowly from δ [J]."""

    def ceiling(self, yield_force):
        """The force at which the law yields: ``yield_force``, or infinity for a law without a cap."""

    def floor(self):
        """The smallest force: 0 where tension is cut, minus infinity otherwise."""


@kernel
def hertz_work(stiffness, delta):
    """∫ β x^1.5 dx from 0 to δ = 0.4 β δ^2.5."""
    return 0.4 * stiffness * delta * delta * sqrt(delta)


@kernel
def capped_hertz_work(stiffness, delta, strength):
    """∫ min(β x^1.5, F_E) dx from 0 to δ."""
    force = stiffness * delta * sqrt(delta)
    if force <= strength:
        return hertz_work(stiffness, delta)
    yields_at = (strength / stiffness) ** (2.0 / 3.0)
    return hertz_work(stiffness, yields_at) + strength * (delta - yields_at)


@kernel
def kelvin_voigt_ratio(e):
    """ξ = −ln e / sqrt(π² + ln² e) (Anagnostopoulos 1988)."""
    fall = -log(e)
    return fall / sqrt(pi * pi + fall * fall)


@kernel
def jankowski_ratio(e):
    """ξ = (9 √5 / 2) (1 − e²) / (e (e (9π − 16) + 16)) (Jankowski 2006; the 2011 paper's eq. 2b, 3b)."""
    return 4.5 * sqrt(5.0) * (1.0 - e * e) / (e * (e * (9.0 * pi - 16.0) + 16.0))


@kernel
def exact_hertz_damping(e):
    """The d on (0, 1/e) with exp[d (1 + e)] = (1 + d) / (1 − d e): then e is achieved, whatever the exponent.

    Newton's rule on g(d) = d (1 + e) + ln(1 − d e) − ln(1 + d), kept inside a bracket; g > 0 left of the root. Near
    e = 1, where g is all rounding, the root's series in 1 − e, good to 1e-15.
    """
    lost = 1.0 - e
    if lost < 1e-3:
        return lost * (1.5 + lost * (1.5 + lost * (1.35 + lost * 1.2)))
    low, high = 0.0, 1.0 / e
    d = min(1.6 * (1.0 - e) / e, 0.999 / e)
    for _ in range(200):
        room = 1.0 - d * e
        value = d * (1.0 + e) + log(room) - log(1.0 + d) if room > 0.0 else -1.0
        if value > 0.0:
            low = d
        else:
            high = d
        slope = 1.0 + e - e / room - 1.0 / (1.0 + d) if room > 0.0 else 0.0
        new = d - value / slope if slope < 0.0 else low
        if not low < new < high:
            new = 0.5 * (low + high)
        if abs(new - d) <= 1e-15 * d:
            break
        d = new
    return d


# Verbs that several laws share; a class below takes them by name.


def forgets(self, e, speed, mass):
    """No damping to remember."""
    return 0.0


def flat(self, delta, strength):
    """Ideally plastic."""
    return strength


def never_yields(self, yield_force):
    """A law without a cap."""
    return inf


def yields(self, yield_force):
    """A law with a cap."""
    return yield_force


def may_pull(self):
    """No cut at zero force."""
    return -inf


def linear_energy(self, delta, strength):
    """k δ² / 2."""
    return 0.5 * self.stiffness * delta * delta


def hertz_energy(self, delta, strength):
    """0.4 β δ^2.5."""
    return hertz_work(self.stiffness, delta)


def kelvin_voigt_damping(self, e, speed, mass):
    """c = 2 ξ sqrt(k m)."""
    return 2.0 * kelvin_voigt_ratio(e) * sqrt(self.stiffness * mass)


def kelvin_voigt_force(self, memory, delta, rate, approaching):
    """k δ + c δ̇."""
    return self.stiffness * delta + memory * rate


def hertz_force(self, memory, delta, rate, approaching):
    """β δ^1.5."""
    return self.stiffness * (delta * sqrt(delta))


def hertz_damp_force(self, memory, delta, rate, approaching):
    """β δ^1.5 (1 + (d / v0) δ̇)."""
    return self.stiffness * (delta * sqrt(delta)) * (1.0 + memory * rate)


def jankowski_damping(self, e, speed, mass):
    """2 ξ sqrt(β m), so that c̄ = this times δ^(1/4)."""
    return 2.0 * jankowski_ratio(e) * sqrt(self.stiffness * mass)


def jankowski_force(self, memory, delta, rate, approaching):
    """β δ^1.5, on approach with c̄ δ̇."""
    root = sqrt(delta)
    spring = self.stiffness * (delta * root)
    return spring + memory * sqrt(root) * rate if approaching else spring


def hertz_yields_at(self, force):
    """(F / β)^(2/3)."""
    return (force / self.stiffness) ** (2.0 / 3.0)


class Linear(NamedTuple):
    """Linear spring: F = k δ. Elastic, e = 1; peak force v0 sqrt(k m), duration π sqrt(m/k).

    >>> Linear(1e8).force(0.0, 0.01, 1.0, True)
    1000000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "linear spring"
    capped = False
    needs_restitution = False

    begin = forgets

    def force(self, memory, delta, rate, approaching):
        return self.stiffness * delta

    plateau = flat
    stored = linear_energy
    ceiling = never_yields
    floor = may_pull


class KelvinVoigt(NamedTuple):
    """Spring and dashpot side by side, as published: F = k δ + c δ̇ until δ is zero again.

    c = 2 ξ sqrt(k m), ξ = −ln e / sqrt(π² + ln² e). The force starts at c v0 and pulls before separation;
    e is achieved exactly.

    >>> KelvinVoigt(1e8).force(2e5, 0.01, 1.0, True)
    1200000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "Anagnostopoulos (1988), Earthquake Engineering and Structural Dynamics 16"
    capped = False
    needs_restitution = True

    begin = kelvin_voigt_damping
    force = kelvin_voigt_force
    plateau = flat
    stored = linear_energy
    ceiling = never_yields
    floor = may_pull


class KelvinVoigtTensionCut(NamedTuple):
    """Kelvin-Voigt that cannot pull: F = max(0, k δ + c δ̇), same ξ(e).

    The e achieved is larger than the e asked for: exp[−(ξ/s)(π − atan2(2 ξ s, 1 − 2 ξ²))], s = sqrt(1 − ξ²).

    >>> KelvinVoigtTensionCut(1e8).floor()
    0.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "Komodromos et al. (2007), Earthquake Engineering and Structural Dynamics 36"
    capped = False
    needs_restitution = True

    begin = kelvin_voigt_damping
    force = kelvin_voigt_force
    plateau = flat
    stored = linear_energy
    ceiling = never_yields

    def floor(self):
        return 0.0


class ModifiedKelvinVoigt(NamedTuple):
    """Dashpot on approach only: F = k δ + c δ̇ (δ̇ > 0), F = k δ (δ̇ ≤ 0).

    c = 2 ξ sqrt(k m), ξ = (1 − e²) / (e (e (π − 2) + 2)); the e achieved is within 0.007 of the e asked for.

    >>> ModifiedKelvinVoigt(1e8).force(2e5, 0.01, -1.0, False)
    1000000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]

    reference = "Mahmoud and Jankowski (2011), modified linear viscoelastic model"
    capped = False
    needs_restitution = True

    def begin(self, e, speed, mass):
        ratio = (1.0 - e * e) / (e * (e * (pi - 2.0) + 2.0))
        return 2.0 * ratio * sqrt(self.stiffness * mass)

    def force(self, memory, delta, rate, approaching):
        spring = self.stiffness * delta
        return spring + memory * rate if approaching else spring

    plateau = flat
    stored = linear_energy
    ceiling = never_yields
    floor = may_pull


class Hertz(NamedTuple):
    """Hertz spring: F = β δ^1.5. Elastic, e = 1; peak force β^(2/5) (1.25 m v0²)^(3/5).

    >>> Hertz(1e9).force(0.0, 0.01, 1.0, True)
    1000000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Hertz (1881); Goldsmith (2001), Impact"
    capped = False
    needs_restitution = False

    begin = forgets
    force = hertz_force
    plateau = flat
    stored = hertz_energy
    ceiling = never_yields
    floor = may_pull


class HertzDamp(NamedTuple):
    """Hertz spring with penetration-proportional damping: F = β δ^1.5 (1 + d δ̇/v0), d = 0.75 (1 − e²).

    The published d is far too small below e = 0.8: 0.65 asked for gives 0.775.

    >>> HertzDamp(1e9).force(0.5, 0.01, 1.0, True)
    1500000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Muthukumar and DesRoches (2006), Earthquake Engineering and Structural Dynamics 35"
    capped = False
    needs_restitution = True

    def begin(self, e, speed, mass):
        return 0.75 * (1.0 - e * e) / max(speed, SLOWEST_TOUCH)

    force = hertz_damp_force
    plateau = flat
    stored = hertz_energy
    ceiling = never_yields
    floor = may_pull


class HertzDampExact(NamedTuple):
    """Hertz-damp with the d that returns the e asked for: exp[d (1 + e)] = (1 + d) / (1 − d e).

    >>> round(HertzDampExact(1e9).begin(0.65, 1.0, 1.0), 5)
    0.7931
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Hunt and Crossley form; exact d by separation of variables; Ye, Li and Zhu (2009) for the need"
    capped = False
    needs_restitution = True

    def begin(self, e, speed, mass):
        return exact_hertz_damping(e) / max(speed, SLOWEST_TOUCH)

    force = hertz_damp_force
    plateau = flat
    stored = hertz_energy
    ceiling = never_yields
    floor = may_pull


class Jankowski(NamedTuple):
    """Nonlinear viscoelastic: F = β δ^1.5 + c̄ δ̇ on approach, F = β δ^1.5 on restitution.

    c̄ = 2 ξ sqrt(β sqrt(δ) m), ξ = (9 √5 / 2)(1 − e²) / (e (e (9π − 16) + 16)). The e achieved depends on ξ
    alone and is within 0.009 of the e asked for.

    >>> Jankowski(1e9).force(1e6, 1e-4, 1.0, True)
    101000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Jankowski (2005, 2006); Khatiwada et al. (2011) eq. 2, 2a, 2b"
    capped = False
    needs_restitution = True

    begin = jankowski_damping
    force = jankowski_force
    plateau = flat
    stored = hertz_energy
    ceiling = never_yields
    floor = may_pull


class Bilinear(NamedTuple):
    """Bilinear truss: K1 up to δ_y, then K2; back along K1 and K2 through the origin. The loop is the loss, no damper.

    With K = β sqrt(δ_m), E = β δ_m^2.5 (1 − e²) / 2.5, δ_y = 0.1 δ_m: K1 = K + E / (0.1 δ_m²), K2 = K − E / (0.9 δ_m²),
    so that the force at δ_m is K δ_m and the loop to δ_m takes E. The e achieved is larger than the e asked for,
    sqrt((1 − q) / (1 + q)), q = 0.4 (1 − e²), at δ_m, and depends on how far δ goes. δ_m = 0 stands for the
    penetration of a Hertz spring at this approach speed, (1.25 m v0² / β)^0.4; then e is the same at any speed.

    >>> round(Bilinear(1e9, 0.01).force(Bilinear(1e9, 0.01).begin(1.0, 1.0, 1.0), 0.005, 0.0, True))
    500000
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]
    design_penetration: Annotated[float, DESIGN_PENETRATION] = 0.0

    reference = "Muthukumar and DesRoches (2006); OpenSees ImpactMaterial for the form"
    capped = False
    needs_restitution = True

    def begin(self, e, speed, mass):
        depth = self.design_penetration
        if depth == 0.0:
            fast = max(speed, SLOWEST_TOUCH)
            depth = (1.25 * mass * fast * fast / self.stiffness) ** 0.4
        whole = self.stiffness * sqrt(depth)
        loop = self.stiffness * depth**2.5 * (1.0 - e * e) / 2.5
        yields_at = 0.1 * depth
        steep = loop / (yields_at * depth) + loop / ((depth - yields_at) * depth)  # K1 − K2
        # K2, K1 − K2, δ_y, and the place from which the elastic part is measured.
        return whole - loop / ((depth - yields_at) * depth), steep, yields_at, 0.0

    def force(self, memory, delta, rate, approaching):
        flat, steep, yields_at, anchor = memory
        return flat * delta + steep * min(max(delta - anchor, 0.0), yields_at)

    def turned(self, memory, delta, approaching):
        flat, steep, yields_at, anchor = memory
        anchor = max(anchor, delta - yields_at) if approaching else min(anchor, delta)
        return flat, steep, yields_at, anchor

    plateau = flat

    def stored(self, delta, strength):
        depth = self.design_penetration
        return 0.5 * self.stiffness * sqrt(max(depth, delta)) * delta * delta

    def held(self, memory, delta, strength):
        flat, steep, yields_at, anchor = memory
        elastic = min(max(delta - anchor, 0.0), yields_at)
        return 0.5 * (flat * delta * delta + steep * elastic * elastic)

    def yielded(self, loss):
        return loss

    ceiling = never_yields
    floor = may_pull


class VanMier(NamedTuple):
    """Elastoplastic: F = K_e δ^1.5 below yield, F = K_p δ^n past it, the same path on unloading.

    K_p follows from continuity at F_E: K_p = F_E / δ_y^n, δ_y = (F_E / K_e)^(2/3). n = 0 is ideally plastic;
    n = 1.5 is Hertz again. The published model gives no general K_e, K_p or n.

    >>> VanMier(1e9, 0.0).plateau(1.0, 5e5)
    500000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]
    plastic_exponent: Annotated[float, EXPONENT] = 0.0

    reference = "van Mier et al. (1991), Journal of Structural Engineering 117; Khatiwada et al. (2011) eq. 1"
    capped = True
    needs_restitution = False

    begin = forgets
    force = hertz_force
    yields_at = hertz_yields_at

    def plateau(self, delta, strength):
        return strength * (delta / self.yields_at(strength)) ** self.plastic_exponent

    def stored(self, delta, strength):
        if self.stiffness * delta * sqrt(delta) <= strength:
            return hertz_work(self.stiffness, delta)
        n = self.plastic_exponent
        yields_at = self.yields_at(strength)
        plastic = strength * yields_at * ((delta / yields_at) ** (n + 1.0) - 1.0) / (n + 1.0)
        return hertz_work(self.stiffness, yields_at) + plastic

    ceiling = yields
    floor = may_pull


class ViscousElastoplastic(NamedTuple):
    """Jankowski's force, cut at the yield force F_E in both phases, exactly as published.

    F = β δ^1.5 + c̄ δ̇ (approach) or β δ^1.5 (restitution) where that is below F_E, else F = F_E. Read
    literally the plateau is retraced on unloading: yielding dissipates nothing and clips the viscous loss, so
    that a lower F_E rebounds *more*.

    >>> ViscousElastoplastic(1e9).plateau(0.02, 4.5e5)
    450000.0
    """

    stiffness: Annotated[float, HERTZ_STIFFNESS]

    reference = "Khatiwada et al. (2011), Development of pounding model for adjacent structures, eq. 3, 3a, 3b"
    capped = True
    needs_restitution = True

    begin = jankowski_damping
    force = jankowski_force
    yields_at = hertz_yields_at
    plateau = flat

    def stored(self, delta, strength):
        return capped_hertz_work(self.stiffness, delta, strength)

    ceiling = yields
    floor = may_pull


def snake_case(name: str) -> str:
    """Scene-file name of a class: ``HertzDampExact`` is ``hertz_damp_exact``."""
    return "".join(f"_{letter.lower()}" if letter.isupper() else letter for letter in name).lstrip("_")


def _laws() -> dict[str, type]:
    verbs = [name for name in vars(ContactLaw) if not name.startswith("_")]
    found = {}
    for name, member in vars(sys.modules[__name__]).items():
        is_law = inspect.isclass(member) and issubclass(member, tuple) and hasattr(member, "_fields")
        if is_law and all(verb in vars(member) for verb in verbs):
            found[snake_case(name)] = complete(member)
    return found


LAWS: dict[str, type] = _laws()  # a user's own are added as they are defined
SHIPPED = tuple(LAWS)


def stiffness_quantity(law: type) -> Quantity:
    """Unit and bounds of a law's stiffness, as stated beside its field."""
    return get_type_hints(law, include_extras=True)["stiffness"].__metadata__[0]
