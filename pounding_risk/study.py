"""A scene once it is read: numbers in SI, every default filled in, ready to be run or written down again."""

from __future__ import annotations

from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact import DESIGN_PENETRATION, stiffness_quantity
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.instant import CONTACT_MODELS, is_instant, needs_floors
from pounding_risk.models.restitution import NAMED, Restitution
from pounding_risk.models.structures import Building
from pounding_risk.quantities import (
    FLOOR_LENGTH,
    GAP,
    MASS,
    PERIOD,
    PGA,
    SPEED,
    WAVE_SPEED,
    YIELD_FORCE,
    Quantity,
    exact,
    shown,
)
from pounding_risk.record_request import RecordRequest
from pounding_risk.relations import AS_PUBLISHED, related
from pounding_risk.scene_text import nearest, write_toml

EQUAL_TERMS = ("peak force", "penetration")  # what laws with a k and laws with a β can be made to agree in
NO_RESTITUTION = "not given"
PARAMETERS = ("plastic_exponent", "design_penetration")  # of single laws, beside their stiffness


class EqualTerms(NamedTuple):
    """How the stiffness of the grid's other laws follows: equal ``same`` in an impact at ``speed``.

    Of the laws of the other family; with ``every_law`` of all but the scene's own, since equal β do not make equal
    blows either.
    """

    same: str
    speed: float  # m/s
    every_law: bool = False


class Effect(NamedTuple):
    """One effect that the scene names, with its options in SI."""

    name: str
    options: tuple[tuple[str, Any], ...] = ()

    def written(self) -> dict[str, Any]:
        """The options as a scene file has them: quantities as text, exact."""
        kinds = EFFECTS[self.name].options  # type: ignore[attr-defined]
        return {
            key: exact(value, kinds[key]) if isinstance(kinds[key], Quantity) else value for key, value in self.options
        }


class Grid(NamedTuple):
    """The values of each dimension; one value, the scene's own, where the scene names no grid for it.

    ``pgas`` is ``(None,)`` where the records keep their amplitude or are scaled by a factor.
    """

    gaps: tuple[float, ...]  # m, ascending
    yield_forces: tuple[float, ...]  # N, ascending, inf last
    contact_models: tuple[str, ...]  # in the order written
    pgas: tuple[float | None, ...]  # m/s², ascending


@dataclass(frozen=True)
class Study:
    """One scene: two buildings, what stands between them, the ground motions and the grid of cases.

    Two studies are equal where they ask for the same runs; ``text``, ``source`` and ``overrides`` say where
    one came from and do not count.
    """

    name: str
    buildings: tuple[Building, Building]  # left, right
    gap: float  # m
    law_name: str
    stiffness: float | None  # N/m or N/m^1.5, as the law has it; None where no model of the scene takes one
    plastic_exponent: float  # of van_mier
    design_penetration: float  # of bilinear [m]; 0 follows the approach speed
    restitution: Restitution
    restitution_words: str  # the relation's name, the number, or NO_RESTITUTION
    yield_force: float  # N, inf without yielding
    equal_terms: EqualTerms | None
    records: RecordRequest
    grid: Grid
    rtol: float
    effects: tuple[Effect, ...] = ()  # in the order in which they wrap a law
    relation: str = AS_PUBLISHED  # of restitution and damping
    text: str = field(default="", compare=False, repr=False)
    source: str = field(default="scene", compare=False)
    overrides: tuple[str, ...] = field(default=(), compare=False)

    def law(self, name: str | None = None, stiffness: float | None = None) -> Any:
        """The contact law ``name`` (the scene's own by default) with the scene's stiffness.

        A law whose stiffness has the other unit (k in N/m against β in N/m^1.5) has no value of its own in
        the scene: pass the ``stiffness`` that the scene's equal terms lead to. Raises SceneError without it, and
        for a law that needs a restitution or the buildings' floors where the scene gives none; as `law_class` for a
        name.
        """
        name = name or self.law_name
        law = self.law_class(name)
        if law.needs_restitution and self.restitution_words == NO_RESTITUTION:
            advice = 'write restitution = 0.65, or restitution = "concrete", in [[interface]]'
            raise SceneError(self.source, [f"{name} needs a restitution, and the scene gives none; {advice}"])
        if needs_floors(law):
            if short := self.without_floor():
                advice = 'write floor_length = "20 m" in its [[building]]'
                raise SceneError(self.source, [f"{name} needs a length of every floor, {short[0]} has none; {advice}"])
            return law.between(*self.buildings)
        if is_instant(law):
            return law()
        if stiffness is None and self.stiffness is None:
            unit = stiffness_quantity(law).unit
            sentence = f"{name} needs a stiffness in {unit}, and the scene gives none; write it in [[interface]]"
            raise SceneError(self.source, [sentence])
        if stiffness is None and self._other_family(name):
            unit, own = stiffness_quantity(law).unit, stiffness_quantity(known_law(self.stiff_name)).unit
            sentence = (
                f"{name} takes a stiffness in {unit}, the scene gives one in {own} for {self.stiff_name}; "
                f'write equal_terms = {{same = "{EQUAL_TERMS[0]}", speed = "0.5 m/s"}} in [[interface]], '
                "from which it follows"
            )
            raise SceneError(self.source, [sentence])
        values: dict[str, Any] = {"stiffness": self.stiffness if stiffness is None else float(stiffness)}
        values |= {key: getattr(self, key) for key in PARAMETERS if key in law._fields}
        return law(**values)

    def without_floor(self) -> tuple[str, ...]:
        """The buildings of which a model of colliding floors would miss the length; a rigid one is a wall."""
        return tuple(each.name for each in self.buildings if not each.is_rigid and each.floor_length == 0.0)

    def law_class(self, name: str) -> Any:
        """The class of a contact law under the scene's damping relation.

        Raises PoundingError for a name that is no law's, and for a law that the relation is not known for.
        """
        return related(known_law(name), self.relation)

    def needs_equal_terms(self, name: str) -> bool:
        """True where the law's stiffness follows from the scene's equal terms, and is not the scene's own."""
        if is_instant(known_law(name)) or self.stiffness is None:
            return False
        if self.equal_terms and self.equal_terms.every_law:
            return name != self.stiff_name
        return self._other_family(name)

    def _other_family(self, name: str) -> bool:
        """True where the law's stiffness has another unit than the scene's."""
        return stiffness_quantity(known_law(name)).unit != stiffness_quantity(known_law(self.stiff_name)).unit

    @property
    def stiff_name(self) -> str:
        """The contact model whose stiffness the scene gives: its own, or the grid's first that takes one."""
        return stiff_model(self.law_name, self.grid.contact_models) or self.law_name

    @property
    def folder(self) -> Path:
        """The folder that record files are relative to: the scene file's."""
        return Path(self.source).parent

    def resolved(self) -> dict[str, Any]:
        """The scene as a dict of the scene file's shape, every value stated, quantities exact in SI units."""
        grid = {
            "gap": [exact(gap, GAP) for gap in self.grid.gaps],
            "yield_force": [exact(force, YIELD_FORCE) for force in self.grid.yield_forces],
            "contact_model": list(self.grid.contact_models),
        }
        pgas = [exact(pga, PGA) for pga in self.grid.pgas if pga is not None]
        effects = {effect.name: effect.written() for effect in self.effects}
        return {
            "scene": {"name": self.name},
            "building": [_building(building) for building in self.buildings],
            "interface": [self._interface()],
            **({"effects": effects} if effects else {}),
            "records": self.records.written(),
            "grid": {**grid, "pga": pgas} if pgas else grid,
            "solver": {"rtol": self.rtol},
        }

    def to_toml(self) -> str:
        """`resolved` as the text of a scene file; reading it gives an equal study."""
        return write_toml(self.resolved())

    def _interface(self) -> dict[str, Any]:
        table: dict[str, Any] = {
            "gap": exact(self.gap, GAP),
            "contact_model": self.law_name,
            **self._stiffness(),
            **self._restitution(),
            "yield_force": exact(self.yield_force, YIELD_FORCE),
        }
        if "van_mier" in (self.law_name, *self.grid.contact_models):
            table["plastic_exponent"] = self.plastic_exponent
        if "bilinear" in (self.law_name, *self.grid.contact_models):
            table["design_penetration"] = exact(self.design_penetration, DESIGN_PENETRATION)
        if self.equal_terms:
            table["equal_terms"] = {
                "same": self.equal_terms.same,
                "speed": exact(self.equal_terms.speed, SPEED),
                **({"every_law": True} if self.equal_terms.every_law else {}),
            }
        return table

    def _stiffness(self) -> dict[str, Any]:
        if self.stiffness is None:
            return {}
        return {"stiffness": exact(self.stiffness, stiffness_quantity(known_law(self.stiff_name)))}

    def _restitution(self) -> dict[str, Any]:
        if self.restitution_words == NO_RESTITUTION:
            return {}
        value = self.restitution_words if self.restitution_words in NAMED else self.restitution.c0
        return {"restitution": value if self.relation == AS_PUBLISHED else {"value": value, "relation": self.relation}}


def stiff_model(own: str, gridded: tuple[str, ...]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own, *gridded) if not is_instant(CONTACT_MODELS[name])), None)


def known_law(name: str) -> Any:
    """The class of a contact model; raises PoundingError, with the nearest name, where there is none."""
    if name not in CONTACT_MODELS:
        raise PoundingError(unknown_law(name))
    return CONTACT_MODELS[name]


def unknown_law(name: str) -> str:
    """A sentence for a contact model that is not there."""
    return f"{shown(name)} is not a contact model{nearest(name, CONTACT_MODELS)}; it may be {', '.join(CONTACT_MODELS)}"


def _building(building: Building) -> dict[str, Any]:
    if building.is_rigid:
        mass = {"mass": exact(building.mass, MASS)} if MASS.allows(building.mass) else {}
        return {"name": building.name, "rigid": True, **mass}
    return {
        "name": building.name,
        "mass": exact(building.mass, MASS),
        "period": exact(building.period, PERIOD),
        "damping": building.damping,
        **_floor(building),
    }


def _floor(building: Building) -> dict[str, Any]:
    """The floor's length and wave speed, where it has a length."""
    if building.floor_length == 0.0:
        return {}
    lengths = exact(building.floor_length, FLOOR_LENGTH), exact(building.wave_speed, WAVE_SPEED)
    return dict(zip(("floor_length", "wave_speed"), lengths, strict=True))
