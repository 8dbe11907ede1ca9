"""Effects: what a scene may add to its contact law, to the ground motion under it, or to its buildings.

An effect of yielding wraps a law and changes some of its verbs; one of the ground gives each building a motion of its
own; one of buildings, in `building_effects`, changes their storeys or what they stand on. A scene without effects hands
the kernels the bare law on level ground, so that an effect that is not named is not in the machine code. An effect that
is added here is found by the scene reader, the commands and the tests. Effects act in the order of this module,
whatever the order in a scene.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf, isnan, nan
from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.law import complete
from pounding_risk.models.contact.laws import snake_case
from pounding_risk.models.effects.building import BUILDING_EFFECTS
from pounding_risk.models.ground import Passing, delayed
from pounding_risk.units import Quantity

RATIO = Quantity("1", 0.0, inf, "ratio of unloading to loading stiffness", open_low=True, open_high=True, example="1.5")
LENGTH = Quantity("m", 0.0, inf, "length over which the impact deforms", open_low=True, open_high=True, example="0.6 m")
APPARENT = Quantity("m/s", 1.0, inf, "apparent velocity of the wave along the row", open_high=True, example="1000 m/s")
DISTANCE = Quantity("m", 0.0, inf, "distance between the buildings' supports", open_high=True, example="20 m")
STRENGTH = Quantity("Pa", 8e6, 130e6, "mean concrete strength f_cm", example="30 MPa")

# Strain rates of the codes' formulas [1/s]: where hardening begins in compression, and where it steepens.
QUASI_STATIC, FAST = 30e-6, 30.0


# What an effect passes on to the law inside.


def inner_begin(self, e, speed, mass):
    """The inner law's."""
    return self.law.begin(e, speed, mass)


def inner_force(self, memory, delta, rate, approaching):
    """The inner law's."""
    return self.law.force(memory, delta, rate, approaching)


def inner_plateau(self, delta, strength):
    """The inner law's."""
    return self.law.plateau(delta, strength)


def inner_stored(self, delta, strength):
    """The inner law's."""
    return self.law.stored(delta, strength)


def inner_ceiling(self, yield_force):
    """The inner law's."""
    return self.law.ceiling(yield_force)


def inner_floor(self):
    """The inner law's."""
    return self.law.floor()


def inner_yields_at(self, force):
    """The inner law's."""
    return self.law.yields_at(force)


def inner_hardening(self, speed):
    """The inner law's."""
    return self.law.hardening(speed)


def inner_resume(self, memory, worn):
    """The inner law's."""
    return self.law.resume(memory, worn)


def inner_turn(self, memory, delta, strength):
    """The inner law's."""
    return self.law.turn(memory, delta, strength)


def inner_turned(self, memory, delta, approaching):
    """The inner law's."""
    return self.law.turned(memory, delta, approaching)


def inner_yielded(self, loss):
    """The inner law's."""
    return self.law.yielded(loss)


def inner_worn(self, memory):
    """The inner law's."""
    return self.law.worn(memory)


def inner_held(self, memory, delta, strength):
    """The inner law's."""
    return self.law.held(memory, delta, strength)


PASSED_ON = {name.removeprefix("inner_"): verb for name, verb in vars().copy().items() if name.startswith("inner_")}


EFFECTS: dict[str, type] = {}  # by name, in the order in which they wrap a law


def effect(reference: str, options: Mapping[str, Any], optional: tuple[str, ...] = (), needs: tuple[str, ...] = ()):
    """Make a class an effect: scenes know its name.

    ``options`` are the keys that a scene gives it, each a `Quantity` or the words it may be; all but the ``optional``
    ones must be there. ``needs`` are the effects that it acts on. A class with ``grounds`` acts on the ground motion,
    one with ``built`` on buildings; any other wraps a law, and passes on every verb of it that it does not say itself.
    """

    def known(kind: Any) -> Any:
        kind.reference, kind.options, kind.optional, kind.needs = reference, options, optional, needs
        name = snake_case(kind.__name__)
        EFFECTS[name] = kind
        if not acts_on_law(name):
            return kind
        for verb, passed_on in PASSED_ON.items():
            if verb not in vars(kind):
                setattr(kind, verb, passed_on)
        return complete(kind)

    return known


def acts_on_ground(name: str) -> bool:
    """True for an effect that changes the ground motion and leaves the contact law as it is."""
    return hasattr(EFFECTS[name], "grounds")


def acts_on_buildings(name: str) -> bool:
    """True for an effect that changes what stands on the ground, and leaves contact law and motion as they are."""
    return hasattr(EFFECTS[name], "built")


def acts_on_law(name: str) -> bool:
    """True for an effect that wraps the contact law."""
    return not acts_on_ground(name) and not acts_on_buildings(name)


def refusal(kind: Any, name: str = "") -> str:
    """Why the effect ``name``, by default any of yielding, does not act on this class of law; "" where it does."""
    if kind.capped or (name and not acts_on_law(name)):
        return ""
    return "has no yield force, so that nothing yields"


def bare(law: Any) -> Any:
    """The law without its effects."""
    while hasattr(law, "law"):
        law = law.law
    return law


def with_effects(law: Any, effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> Any:
    """The law wrapped in these effects, (name, options) each, in their order here.

    Raises PoundingError for a law that an effect does not act on.
    """
    asked = {name: dict(options) for name, options in effects if acts_on_law(name)}
    why = refusal(type(bare(law)))
    if asked and why:
        kind = snake_case(type(bare(law)).__name__)
        raise PoundingError(f"{', '.join(asked)}: {kind} {why}; remove the effect, or leave {kind} out")
    for name in EFFECTS:
        if name in asked:
            law = EFFECTS[name].on(law, **asked[name])  # type: ignore[attr-defined]
    return law


def wave_of(effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> WavePassage | None:
    """What these effects, (name, options) each, do to the ground motion; None where they leave it as it is."""
    waves = [EFFECTS[name].on(**dict(options)) for name, options in effects if acts_on_ground(name)]  # type: ignore[attr-defined]
    if len(waves) > 1:
        raise PoundingError(
            "effects: two of them change the ground motion, and it cannot be known in which order; keep one"
        )
    return waves[0] if waves else None


def building_effects(effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]]) -> tuple[Any, ...]:
    """Those of these effects, (name, options) each, that act on buildings, in their order here."""
    asked = {name: dict(options) for name, options in effects if acts_on_buildings(name)}
    return tuple(EFFECTS[name].on(**asked[name]) for name in EFFECTS if name in asked)  # type: ignore[attr-defined]


def references(law: Any) -> str:
    """Where a law and its effects are from."""
    return f"{references(law.law)}; {law.reference}" if hasattr(law, "law") else law.reference


@effect(
    reference="CEB-FIP Model Code 1990 and fib Model Code 2010: concrete under high strain rates, compression",
    options={"code": ("mc1990", "mc2010"), "length": LENGTH, "strength": STRENGTH},
    optional=("strength",),
)
class StrainRate(NamedTuple):
    """Dynamic increase of the yield force: F_E × DIF(ε̇), ε̇ = approach speed / length at the touch.

    DIF = (ε̇/ε̇0)^a up to 30/s, b (ε̇/ε̇0)^(1/3) above, ε̇0 = 30e-6/s; 1 below. CEB-FIP Model Code 1990: a = 1.026 α,
    b = 10^(6.156 α − 2), α = 1 / (5 + 0.9 f_cm), f_cm in MPa. fib Model Code 2010: a = 0.014, b = 0.012. Concrete in
    compression. At 0.5 m/s over 0.6 m the codes give factors of 1.39 (f_cm 30 MPa) and 1.15: the choice matters.

    >>> round(StrainRate.on(None, code="mc2010", length=0.6).hardening(0.5), 3)
    1.154
    """

    law: Any
    length: float  # m
    rise: float  # a
    far: float  # b

    @classmethod
    def on(cls, law: Any, code: str, length: float, strength: float = nan) -> StrainRate:
        """The law with this hardening; ``length`` [m], ``strength`` f_cm [Pa].

        Raises PoundingError where Model Code 1990 is given no strength.
        """
        if code == "mc1990":
            if isnan(strength):
                raise PoundingError('strain_rate: code mc1990 asks for the concrete; write strength = "30 MPa"')
            alpha = 1.0 / (5.0 + 0.9 * strength / 1e6)
            return cls(law, length, 1.026 * alpha, 10.0 ** (6.156 * alpha - 2.0))
        return cls(law, length, 0.014, 0.012)

    def hardening(self, speed):
        rate = speed / self.length / QUASI_STATIC
        if rate <= 1.0:
            return 1.0
        return rate**self.rise if rate * QUASI_STATIC <= FAST else self.far * rate ** (1.0 / 3.0)


@effect(reference="plastic penetration with memory; Khatiwada et al. (2011) name gap widening as ignored", options={})
class PermanentSet(NamedTuple):
    """Yielding leaves a dent: what is pressed in past the elastic penetration at F_E stays and widens the gap.

    Where the motion turns back on the plateau at δ, δ_p = δ − (F_E/β)^(2/3) is added to the gap, and the law goes on
    from δ − δ_p. The dent takes F_E δ_p. Without viscosity e = v_y / v0, v_y² = 0.8 F_E^(5/3) β^(−2/3) / m. This is
    the memory that the published law lacks; Khatiwada et al. (2011) name the widening of the gap as ignored.
    """

    law: Any

    @classmethod
    def on(cls, law: Any) -> PermanentSet:
        """The law with this memory; raises PoundingError for a law that hardens on its plateau."""
        if getattr(bare(law), "plastic_exponent", 0.0) != 0.0:
            raise PoundingError(
                "permanent_set: van_mier with a plastic_exponent above 0 hardens while it yields, and what it "
                "remembers of that is not published; write plastic_exponent = 0, or remove permanent_set"
            )
        return cls(law)

    def turn(self, memory, delta, strength):
        force = self.law.plateau(delta, strength)
        springs_back = min(self.law.yields_at(force), delta)
        lost = self.law.stored(delta, strength) - self.law.stored(springs_back, inf)
        return memory, delta - springs_back, lost


@effect(
    reference="stiffness after yielding; Khatiwada et al. (2011) name it as altered by chipping, spalling and dents",
    options={"ratio": RATIO},
    needs=("permanent_set",),
)
class UnloadingStiffness(NamedTuple):
    """After yielding the contact is stiffer or softer: ratio × β while it unloads and in all contacts after it.

    Unloading starts at the force of the plateau, so that δ_p = δ − (F_E / (ratio β))^(2/3); where a soft contact
    would spring back by more than δ, it springs back by δ with the stiffness that takes. Acts on what
    `PermanentSet` leaves. Khatiwada et al. (2011) name both as changed by chipping, spalling and dents.
    """

    law: Any
    ratio: float

    @classmethod
    def on(cls, law: Any, ratio: float) -> UnloadingStiffness:
        """The law with this stiffness after yielding, over that before."""
        return cls(law, ratio)

    # The memory is that of the law inside and the factor on its spring.

    def begin(self, e, speed, mass):
        return self.law.begin(e, speed, mass), 1.0

    def resume(self, memory, worn):
        return self.law.resume(memory[0], worn), worn if worn > 0.0 else 1.0

    def force(self, memory, delta, rate, approaching):
        spring = self.law.force(memory[0], delta, 0.0, False)
        return self.law.force(memory[0], delta, rate, approaching) + (memory[1] - 1.0) * spring

    def turn(self, memory, delta, strength):
        force = self.law.plateau(delta, strength)
        springs_back = min(self.law.yields_at(force / self.ratio), delta)
        factor = force / self.law.force(memory[0], springs_back, 0.0, False)
        lost = self.held(memory, delta, strength) - factor * self.law.stored(springs_back, inf)
        return (memory[0], factor), delta - springs_back, lost

    def turned(self, memory, delta, approaching):
        return self.law.turned(memory[0], delta, approaching), memory[1]

    def held(self, memory, delta, strength):
        yields_at = self.law.yields_at(strength / memory[1])
        if not delta > yields_at:
            return memory[1] * self.law.stored(delta, inf)
        return memory[1] * self.law.stored(yields_at, inf) + strength * (delta - yields_at)

    def worn(self, memory):
        return memory[1] if memory[1] != 1.0 else 0.0


@effect(
    reference="Der Kiureghian (1996), A coherency model for spatially varying ground motions: the wave-passage effect",
    options={"velocity": APPARENT, "distance": DISTANCE, "towards": ("left", "right")},
    optional=("towards",),
)
class WavePassage(NamedTuple):
    """The motion reaches one building later than the other, by τ = distance / apparent velocity; a_far(t) = a(t − τ).

    The ground itself then moves the buildings together and apart, by about τ times its velocity. The later
    motion is the same as the prompt one, sample by sample, whatever part of a sample τ ends in.

    >>> WavePassage.on(velocity=500.0, distance=20.0).lag
    0.04
    """

    lag: float  # s, by which the right building has the motion later; below zero the left one has

    @classmethod
    def on(cls, velocity: float, distance: float, towards: str = "right") -> WavePassage:
        """A wave that travels ``towards`` the right or left building; apparent velocity [m/s], distance [m]."""
        return cls(distance / velocity if towards == "right" else -distance / velocity)

    def grounds(self, ground: Any, step: float) -> Passing:
        """The motion under each building, from a_g [m/s²] at samples ``step`` [s] apart."""
        return delayed(ground, step, self.lag)


for building_effect in BUILDING_EFFECTS:
    effect(building_effect.reference, building_effect.options, building_effect.optional)(building_effect)
