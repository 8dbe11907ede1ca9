"""A scene once it is read: numbers in SI, every default filled in, ready to be run or written down again."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk import units as quantities
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS, is_instant, needs_floors
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.laws.bilinear import DESIGN_PENETRATION
from pounding_risk.models.contact.relation import AS_PUBLISHED, related
from pounding_risk.models.effects import EFFECTS, written_option
from pounding_risk.models.restitution import NAMED, Restitution
from pounding_risk.models.structures.contact_points import COLUMN, FLOOR_DEPTH, LevelRule, Point, floor_words
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.request import RecordRequest
from pounding_risk.scene.buildings import building_table
from pounding_risk.scene.toml import write_toml
from pounding_risk.units import GAP, PGA, SPEED, STOREY_HEIGHT, YIELD_FORCE, Quantity, say, shown

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
        kinds = EFFECTS[self.name].options
        return {
            key: written_option(value, kinds[key]) if isinstance(kinds[key], Quantity) else value
            for key, value in self.options
        }


class Grid(NamedTuple):
    """The values of each dimension; one value, the scene's own, where the scene names no grid for it.

    ``pgas`` is ``(None,)`` where the records keep their amplitude or are scaled by a factor.
    """

    gaps: tuple[float, ...]  # m, ascending
    yield_forces: tuple[float, ...]  # N, ascending, inf last
    contact_models: tuple[str, ...]  # in the order written
    pgas: tuple[float | None, ...]  # m/s², ascending


class Neighbour(NamedTuple):
    """What stands between two neighbours."""

    gap: float  # m
    stiffness: float | None  # in the unit of the scene's contact model
    restitution: Restitution
    restitution_words: str
    yield_force: float  # N, of floors; inf without yielding
    column_yield_force: float  # N, of columns that are hit part-way up; inf without yielding
    points: tuple[Point, ...]  # from the ground up
    levels: LevelRule = LevelRule()  # when two floors are one contact point
    given: bool = False  # whether the scene gives the points; else they follow from the heights


@dataclass(frozen=True, repr=False)
class Scene(ShortRepr):
    """One scene: buildings, what stands between neighbours, the ground motions and the grid of cases.

    Gap, stiffness, restitution and yield force are those of the first interface; `at` gives each. Two scenes are equal
    where they ask for the same runs; ``text``, ``source`` and ``overrides`` say where one came from and do not count.
    """

    name: str
    buildings: tuple[Building | Storeys, ...]  # left to right
    neighbours: tuple[Neighbour, ...]  # what stands between each two buildings, left to right
    law_name: str
    plastic_exponent: float  # of van_mier
    design_penetration: float  # of bilinear [m]; 0 follows the approach speed
    equal_terms: EqualTerms | None
    records: RecordRequest
    grid: Grid
    rtol: float
    effects: tuple[Effect, ...] = ()  # in the order in which they wrap a law
    relation: str = AS_PUBLISHED  # of restitution and damping
    is_row: bool = False  # whether the row solver runs it: all but two masses that meet mass to mass
    gridded_interface: str | None = None  # "left | right", the only one whose gap the grid varies; None for all
    text: str = field(default="", compare=False, repr=False)
    source: str = field(default="scene", compare=False)
    overrides: tuple[str, ...] = field(default=(), compare=False)

    def facts(self) -> Iterable[tuple[str, str]]:
        """What stands where, under which motions, and how many cases there are."""
        grid = self.grid
        yield "name", self.name
        yield "buildings", " | ".join(building.name for building in self.buildings)
        yield "gaps", _ends(grid.gaps, GAP)
        yield "contact models", ", ".join(grid.contact_models)
        yield "yield forces", _ends(grid.yield_forces, YIELD_FORCE)
        if self.effects:
            yield "effects", ", ".join(effect.name for effect in self.effects)
        asked = self.records
        yield "records", ", ".join(asked.names or asked.files) or asked.set or asked.manifest

    @property
    def gap(self) -> float:
        """Clear distance at the first interface [m]."""
        return self.neighbours[0].gap

    @property
    def stiffness(self) -> float | None:
        """Contact stiffness of the first interface [N/m or N/m^1.5, as the law has it]; None where no model has one."""
        return self.neighbours[0].stiffness

    @property
    def restitution(self) -> Restitution:
        """Relation e(v) of the first interface."""
        return self.neighbours[0].restitution

    @property
    def restitution_words(self) -> str:
        """Name of the relation at the first interface, the number, or `NO_RESTITUTION`."""
        return self.neighbours[0].restitution_words

    @property
    def yield_force(self) -> float:
        """Yield force of the floors at the first interface [N]; inf without yielding."""
        return self.neighbours[0].yield_force

    def with_interfaces(self, **changes: Any) -> Scene:
        """The scene with these values of `Neighbour` at every interface."""
        return replace(self, neighbours=tuple(neighbour._replace(**changes) for neighbour in self.neighbours))

    @property
    def interface_names(self) -> tuple[str, ...]:
        """The name "left | right" of each interface."""
        names = [building.name for building in self.buildings]
        return tuple(interface_name(left, right) for left, right in pairwise(names))

    @property
    def points(self) -> tuple[Point, ...]:
        """The contact points, interface by interface from the ground up."""
        return tuple(point for neighbour in self.neighbours for point in neighbour.points)

    @property
    def pair(self) -> tuple[Building, Building]:
        """The two single masses, left and right; raises SceneError where the scene is a row."""
        left, right = (
            building for building in needs_pair(self, "this command").buildings if isinstance(building, Building)
        )
        return left, right

    def at(self, place: int) -> Scene:
        """The scene of interface ``place`` alone, from 0: its two buildings and what stands between them."""
        if not self.is_row:
            return self
        here, grid = self.neighbours[place], self.grid
        gaps = grid.gaps if self.gridded_interface in (None, self.interface_names[place]) else (here.gap,)
        forces = grid.yield_forces if len(grid.yield_forces) > 1 else (here.yield_force,)
        return replace(
            self,
            buildings=self.buildings[place : place + 2],
            grid=grid._replace(gaps=gaps, yield_forces=forces),
            neighbours=(here._replace(points=tuple(point._replace(interface=0) for point in here.points)),),
            gridded_interface=None,
        )

    def law_at(self, place: int, name: str | None = None, stiffness: float | None = None) -> Any:
        """The contact law ``name`` with the stiffness of interface ``place``, from 0. Raises as `law`."""
        return self.at(place).law(name, stiffness)

    def interface_gaps(self, gap: float) -> tuple[float, ...]:
        """The gap of each interface where that of the grid is ``gap`` [m]."""
        named = self.gridded_interface
        pairs = zip(self.interface_names, self.neighbours, strict=True)
        return tuple(gap if named in (None, name) else neighbour.gap for name, neighbour in pairs)

    def point_yield_forces(self, force: float | None = None) -> tuple[float, ...]:
        """The yield force of each of `points` [N] where that of floors is ``force``; None for each interface's own.

        A grid of one yield force leaves every interface its own. Columns keep theirs.
        """
        return tuple(
            neighbour.column_yield_force
            if point.kind == COLUMN
            else (neighbour.yield_force if force is None else force)
            for neighbour in self.neighbours
            for point in neighbour.points
        )

    @property
    def striking_mass(self) -> float:
        """m1 m2 / (m1 + m2) of what strikes at the first interface [kg]; the other's mass where one is rigid.

        A single mass strikes whole, a building of storeys with a floor of average mass.
        """
        left, right = (_inverse_mass(building) for building in self.buildings[:2])
        return 1.0 / (left + right)

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
            return law.between(*self.buildings[:2])
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
        return tuple(
            each.name for each in self.buildings if not each.is_rigid and not getattr(each, "floor_length", 0.0)
        )

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
        effects = {effect.name: effect.written() for effect in self.effects}
        return {
            "scene": {"name": self.name},
            "building": [building_table(each) | self._depth(place) for place, each in enumerate(self.buildings)],
            "interface": [self.at(place)._interface() for place in range(len(self.neighbours))],
            **({"effects": effects} if effects else {}),
            "records": self.records.written(),
            "grid": self._grid(),
            "solver": {"rtol": self.rtol},
        }

    def to_toml(self) -> str:
        """`resolved` as the text of a scene file; reading it gives an equal study."""
        return write_toml(self.resolved())

    def _grid(self) -> dict[str, Any]:
        named, forces = self.gridded_interface, self.grid.yield_forces
        own = {neighbour.yield_force for neighbour in self.neighbours}
        # A grid of one yield force would be that of every interface; where they differ, each keeps its own.
        told = (
            {"yield_force": [exact(force, YIELD_FORCE) for force in forces]} if len(forces) > 1 or len(own) < 2 else {}
        )
        pgas = [exact(pga, PGA) for pga in self.grid.pgas if pga is not None]
        return {
            "gap": [exact(gap, GAP) for gap in self.grid.gaps],
            **({"interface": named} if named else {}),
            **told,
            "contact_model": list(self.grid.contact_models),
            **({"pga": pgas} if pgas else {}),
        }

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
        return table | self._points()

    def _points(self) -> dict[str, Any]:
        """Where the two meet, as a scene file has it; nothing of a pair."""
        if not self.is_row:
            return {}
        here = self.neighbours[0]
        column = (
            {}
            if here.column_yield_force == inf
            else {"column_yield_force": exact(here.column_yield_force, YIELD_FORCE)}
        )
        given = [
            {"left": floor_words(point.left_floor), "right": floor_words(point.right_floor)} for point in here.points
        ]
        tolerance = here.levels.tolerance
        return {
            **column,
            **({} if tolerance is None else {"tolerance": exact(tolerance, STOREY_HEIGHT)}),
            **({"contact": given} if here.given else {}),
        }

    def _depth(self, place: int) -> dict[str, Any]:
        """The depth of the floors of building ``place``, as a scene file has it; nothing of a pair."""
        if not self.is_row:
            return {}
        is_last = place == len(self.neighbours)
        levels = self.neighbours[place - is_last].levels
        return {"floor_depth": exact(levels.right_depth if is_last else levels.left_depth, FLOOR_DEPTH)}

    def _stiffness(self) -> dict[str, Any]:
        if self.stiffness is None:
            return {}
        return {"stiffness": exact(self.stiffness, stiffness_quantity(known_law(self.stiff_name)))}

    def _restitution(self) -> dict[str, Any]:
        if self.restitution_words == NO_RESTITUTION:
            return {}
        value = self.restitution_words if self.restitution_words in NAMED else self.restitution.c0
        return {"restitution": value if self.relation == AS_PUBLISHED else {"value": value, "relation": self.relation}}


def exact(value: float, quantity: Quantity) -> str | float:
    """As `units.exact`; a study changed in memory may hold numpy's numbers, which would be written otherwise."""
    return quantities.exact(float(value), quantity)


def stiff_model(own: str, gridded: tuple[str, ...]) -> str | None:
    """The first of these contact models that takes a stiffness, or None: instant ones take none."""
    return next((name for name in (own, *gridded) if not is_instant(CONTACT_MODELS[name])), None)


def known_law(name: str) -> Any:
    """The class of a contact model; raises PoundingError, with the nearest name, where there is none."""
    if not isinstance(name, str) or name not in CONTACT_MODELS:
        raise PoundingError(unknown_law(name))
    return CONTACT_MODELS[name]


def unknown_law(name: object) -> str:
    """A sentence for a contact model that is not there."""
    hint = nearest(name, CONTACT_MODELS) if isinstance(name, str) else ""
    return f"{shown(name)} is not a contact model{hint}; it may be {', '.join(CONTACT_MODELS)}"


def interface_name(left: str, right: str) -> str:
    """How the interface between two buildings is called."""
    return f"{left} | {right}"


def needs_pair(study: Scene, command: str) -> Scene:
    """The study; raises SceneError where ``command``, which runs two single masses, is given a row."""
    if study.is_row:
        count = len(study.buildings)
        raise SceneError(
            study.source,
            [
                f"{command} runs two single masses that meet mass to mass, and this scene is a row of {count} "
                "buildings or has storeys; use scan, or write a scene of the two masses"
            ],
        )
    return study


def _inverse_mass(building: Building | Storeys) -> float:
    """1/m [1/kg] of the mass that collides: of storeys that of a mean floor; 0 for a rigid wall."""
    if isinstance(building, Storeys):
        return len(building.masses) / building.mass
    return building.oscillator().inverse_mass


def _ends(values: Sequence[float], quantity: Quantity) -> str:
    """The values of an axis of the grid, or how many there are and the two at its ends."""
    if len(values) <= 3:
        return ", ".join(say(value, quantity) for value in values)
    return f"{len(values)} from {say(values[0], quantity)} to {say(values[-1], quantity)}"


def own_laws(study: Scene) -> dict[str, str]:
    """Digests of the code of those contact laws of the scene that are not the package's."""
    from pounding_risk.models.contact.register import is_own, law_digest

    kinds = {name: known_law(name) for name in (study.law_name, *study.grid.contact_models)}
    return {name: law_digest(kind) for name, kind in kinds.items() if is_own(kind)}
