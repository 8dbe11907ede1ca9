"""The key `isolation` of a building: an inline table with the isolators under its slab."""

from __future__ import annotations

from math import inf
from typing import Any

from pounding_risk.models.structures.isolation import YIELD_DISPLACEMENT, Isolators
from pounding_risk.scene.keys import Key, Number, Several, Table, inline, measured
from pounding_risk.scene.toml import KeyPath
from pounding_risk.units import FLOOR_MASS, STIFFNESS, STOREY_HEIGHT, Quantity

LENGTH = Quantity("m", 0.0, inf, "radius of a pendulum", open_low=True, open_high=True, example="2.2 m")
# Below it the slab vibrates so fast before it yields that a record takes hours.
YIELDING = LENGTH._replace(low=1e-8, open_low=False, words="yield displacement of isolators", example="10 mm")
STRENGTH = Quantity("N", 0.0, inf, "characteristic strength", open_high=True, example="900 kN")
FRICTION = Quantity("1", 0.0, 1.0, "coefficient of friction", example="0.05")
DASHPOT = Quantity("N*s/m", 0.0, inf, "dashpot", open_high=True, example="200 kN s/m")
BEARINGS, SLIDERS = ("strength", "stiffness"), ("friction", "radius")
EXAMPLE = (
    '{slab_mass = "600 t", height = "1.5 m", strength = "900 kN", stiffness = "5 MN/m", yield_displacement = "10 mm"}'
)


class Isolation(Table):
    """Isolators under a building, all of them together, and the slab on them.

    Bilinear with kinematic hardening: by ``strength`` and ``stiffness``, as lead-rubber bearings have them, or by
    ``friction`` and ``radius`` of friction pendulums and the weight of the slab and all floors.
    """

    slab_mass: float = measured(
        FLOOR_MASS._replace(low=1.0, open_low=False), "Mass of the slab on the isolators.", '"600 t"'
    ).required()
    height: float = measured(
        STOREY_HEIGHT, "Height of the slab above the ground, as of a moat wall around it.", '"1.5 m"'
    ).required()
    strength: float | None = measured(
        STRENGTH,
        "Characteristic strength: force at zero displacement on the branch that yields; 0 for linear isolators.",
        absent="friction times the weight",
    ).defaults_to(None)
    stiffness: float | None = measured(
        STIFFNESS, "Stiffness past yield.", '"5 MN/m"', "the weight over radius"
    ).defaults_to(None)
    friction: float | None = measured(
        FRICTION, "Coefficient of friction of pendulums, the same at every speed.", absent="strength is given"
    ).defaults_to(None)
    radius: float | None = measured(LENGTH, "Radius of the sliding surface.", absent="stiffness is given").defaults_to(
        None
    )
    yield_displacement: float = measured(
        YIELDING,
        "Displacement at yield: before it the stiffness is that past yield plus strength over this.",
        absent='"1 mm"',
    ).defaults_to(YIELD_DISPLACEMENT)
    damping: float = measured(DASHPOT, "Dashpot between slab and ground.", absent="none").defaults_to(0.0)

    @classmethod
    def of(cls, isolators: Isolators) -> Any:
        """The table of isolators, every value stated that they have."""
        return cls.from_values({key: parameter for key, parameter in vars(isolators).items() if parameter is not None})

    def isolators(self) -> Isolators:
        """The isolators as buildings of `models.structures` have them."""
        return Isolators(**{key: getattr(self, key) for key in self.key_names()})


def _isolation(value: Any, number: Number) -> Isolation:
    """A table that says strength and stiffness, or friction and radius."""
    table: Isolation = inline(Isolation, "isolation", value, number, EXAMPLE)
    has = [key for key in (*BEARINGS, *SLIDERS) if getattr(table, key) is not None]
    whole = next((pair for pair in (BEARINGS, SLIDERS) if set(pair) <= set(has)), ())
    if whole:
        words = f"{' and '.join(whole)} are given, and say it already; remove one or the other"
        excess: list[tuple[KeyPath, str]] = [((key,), words) for key in has if key not in whole]
        if excess:
            raise Several(excess)
        return table
    needed = SLIDERS if has and set(has) <= set(SLIDERS) else BEARINGS
    missing = next(key for key in needed if key not in has)
    others = "friction and radius, of pendulums" if needed == BEARINGS else "strength and stiffness, of bearings"
    lacks = Isolation.keys()[missing].lacks(missing)
    raise Several([((missing,), f"{lacks}; isolators have {' and '.join(needed)}, or {others}")])


ISOLATION = Key(
    "Isolators under the building, with a slab on them: its storey 1 and floor 1.",
    _isolation,
    EXAMPLE,
    "the building stands on the ground",
    write=lambda table: table.written(),
    schema={"$ref": "#/$defs/IsolationTable"},
)
