"""The values of a scene, with the names, gaps, contact points, forces and contact laws that follow from them."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field, fields
from itertools import pairwise
from math import inf, isnan
from operator import attrgetter
from pathlib import Path
from typing import Any, NamedTuple, Self

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk._common.words import short_list
from pounding_risk.errors import SceneError
from pounding_risk.models.contact.impulsive import is_instant, needs_floors
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import related
from pounding_risk.models.contact.table import TABULATED
from pounding_risk.models.effects import supports_of
from pounding_risk.models.ground import Support
from pounding_risk.models.structures.contact_points import COLUMN, Point
from pounding_risk.models.structures.links import Link
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.levels import PEAK, Level, Measure
from pounding_risk.motions.request import RecordRequest
from pounding_risk.scene.interfaces import (
    EQUAL_TERMS_EXAMPLE,
    NO_RESTITUTION,
    PARAMETERS,
    interface_name,
    known_law,
    needed_restitution,
)
from pounding_risk.scene.resolved_interfaces import ResolvedInterface, stiff_model
from pounding_risk.scene.scene_axis import SceneAxis
from pounding_risk.scene.tables import Effect
from pounding_risk.scene.uncertain import UncertainNumbers
from pounding_risk.units import GAP, YIELD_FORCE, say

OF_EACH_INTERFACE = "each interface's own"  # label of the contact models of a scene whose interfaces differ in theirs
OF_RESTITUTION = {"restitution": "rule", "restitution_words": "words", "relation": "relation"}  # of `GivenRestitution`


class Axes(NamedTuple):
    """The values of each dimension; one value, the scene's own, where the scene names no grid for it.

    ``amplitudes`` is ``(None,)`` where the records keep their amplitude, or have the one that [records] brings them to.
    """

    gaps: tuple[float, ...]  # m, ascending
    yield_forces: tuple[float, ...]  # N, ascending, inf last
    contact_models: tuple[str, ...]  # in the order written
    amplitudes: tuple[Level | None, ...]  # of one measure, ascending

    @property
    def measure(self) -> Measure:
        """The measure of the amplitudes; PGA where there are none."""
        return self.amplitudes[0].measure if self.amplitudes[0] is not None else PEAK

    @property
    def levels(self) -> tuple[float | None, ...]:
        """The value of each amplitude in its measure [SI]."""
        return tuple(None if level is None else level.value for level in self.amplitudes)


def _of_first_interface(path: str, words: str) -> Any:
    """A property of a scene: that of its first interface."""
    value = attrgetter(path)
    return property(lambda scene: value(scene.interfaces[0]), doc=f"{words[:-1]}, at the first interface.")


@dataclass(frozen=True, repr=False, init=False, eq=False)
class SceneValues(ShortRepr):
    """What a scene asks for, every value in SI; see `scene.Scene`, which is made of Python or of tables."""

    name: str
    buildings: tuple[Building | Storeys, ...]
    interfaces: tuple[ResolvedInterface, ...]
    records: RecordRequest
    grid: Axes
    rtol: float
    effects: tuple[Effect, ...]  # in the order in which they wrap a law
    is_row: bool  # whether the row solver runs it: all but two masses that meet mass to mass
    gridded_interface: str | None  # "left | right", the only one whose gap the grid varies; None for all
    axes: tuple[SceneAxis, ...]  # of other numbers of the scene, slowest first; see `scene.variants`
    uncertain: UncertainNumbers | None  # whose samples are the last of the axes
    damage: tuple[Any, ...] = field(compare=False)  # `DamageState`
    text: str = field(compare=False)
    source: str = field(compare=False)
    overrides: tuple[str, ...] = field(compare=False)
    # What makes of the scene at a place along the axes the one that is run there; see `scene.variants`.
    at_every_place: Callable[[Any], Any] | None = field(compare=False, default=None)

    # What the first interface says.
    gap = _of_first_interface("gap", "Clear distance [m].")
    stiffness = _of_first_interface("stiffness", "Contact stiffness [N/m or N/m^1.5]; None where no model has one.")
    restitution = _of_first_interface("restitution.rule", "Relation e(v).")
    restitution_words = _of_first_interface(
        "restitution.words", "Name of e(v), number, damping ratio, or `NO_RESTITUTION`."
    )
    relation = _of_first_interface("restitution.relation", "Relation of restitution and damping.")
    yield_force = _of_first_interface("yield_force", "Yield force of the floors [N]; inf without yielding.")
    equal_terms = _of_first_interface("equal_terms", "How the stiffness of other contact models follows.")
    design_penetration = _of_first_interface("design_penetration", "Penetration for which bilinear is set up [m].")

    @classmethod
    def made(cls, settings: Mapping[str, Any]) -> Self:
        """The scene of these values of its fields, which are not checked."""
        scene = object.__new__(cls)
        if unknown := set(settings) - {key.name for key in fields(cls)}:
            raise TypeError(f"a scene has no field {', '.join(sorted(unknown))}")
        scene.__dict__.update(settings)
        return scene

    def updated(self, **values: Any) -> Self:
        """The scene with these fields, which are not checked; a field of interfaces is set at every one.

        ``restitution``, ``restitution_words`` and ``relation`` set the properties of these names.
        """
        interfaces = values.get("interfaces", self.interfaces)
        if restitution := {OF_RESTITUTION[key]: values.pop(key) for key in OF_RESTITUTION if key in values}:
            interfaces = [item.updated(restitution=item.restitution._replace(**restitution)) for item in interfaces]
        facts = {key: values.pop(key) for key in list(values) if key in ResolvedInterface.model_fields}
        values["interfaces"] = tuple(item.updated(**facts) if facts else item for item in interfaces)
        return type(self).made({key.name: getattr(self, key.name) for key in fields(self)} | values)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, SceneValues) and self._compared() == other._compared()

    def __hash__(self) -> int:
        return hash(self._compared())

    def _compared(self) -> tuple[Any, ...]:
        """The fields that are equal if two scenes ask for the same runs; an unknown level is inf, not NaN."""
        interfaces = tuple(
            interface.updated(
                points=tuple(point._replace(level=inf) if isnan(point.level) else point for point in interface.points)
            )
            for interface in self.interfaces
        )
        settings = (getattr(self, key.name) for key in fields(self) if key.compare and key.name != "interfaces")
        return (interfaces, *settings)

    # -------------------------------------------------------------------------------------------- reading

    def facts(self) -> Iterable[tuple[str, str]]:
        """The name, buildings, gaps, contact models, axes, effects and records of the scene, in words."""
        grid = self.grid
        yield "name", self.name
        yield "buildings", " | ".join(building.name for building in self.buildings)
        yield "gaps", short_list([say(gap, GAP) for gap in grid.gaps], 3)
        yield "contact models", ", ".join(grid.contact_models)
        yield "yield forces", short_list([say(force, YIELD_FORCE) for force in grid.yield_forces], 3)
        yield from self.axis_words()
        if self.effects:
            yield "effects", ", ".join(effect.name for effect in self.effects)
        records = self.records
        generated = (recipe.text() for recipe in records.generated)
        names = ", ".join(records.names or records.files or generated)
        yield "records", names or records.set or records.manifest or records.sites

    def axis_words(self) -> Iterator[tuple[str, str]]:
        """The keys and values of the axes of numbers, and the distributions of the numbers that are drawn."""
        yield from ((", ".join(axis.keys), axis.words()) for axis in self.axes if not axis.dimension)
        if self.uncertain is not None:
            yield from self.uncertain.described()

    @property
    def contact_model(self) -> str:
        """Contact model of the interfaces; `OF_EACH_INTERFACE` where they differ in theirs."""
        names = {interface.contact_model for interface in self.interfaces}
        return self.interfaces[0].contact_model if len(names) == 1 else OF_EACH_INTERFACE

    @property
    def interface_names(self) -> tuple[str, ...]:
        """The name "left | right" of each interface."""
        names = [building.name for building in self.buildings]
        return tuple(interface_name(left, right) for left, right in pairwise(names))

    @property
    def points(self) -> tuple[Point, ...]:
        """The contact points, interface by interface from the ground up."""
        return tuple(point for interface in self.interfaces for point in interface.points)

    @property
    def links(self) -> tuple[Link, ...]:
        """The springs and dashpots between neighbours."""
        return tuple(link for interface in self.interfaces for link in interface.links)

    @property
    def bumpers(self) -> tuple[float, ...]:
        """How much of the gap of each interface its bumpers take up [m]; none where no table has the key."""
        lengths = [interface.bumper_length for interface in self.interfaces]
        return () if lengths[0] is None else tuple(length or 0.0 for length in lengths)

    @property
    def supports(self) -> tuple[Support, ...]:
        """The support of each building, with the delay of a passing wave; none where all stand on the records."""
        return supports_of(self.buildings, self.effects)

    @property
    def lag(self) -> float:
        """Time from the arrival of the ground motion at the first building to that at the last [s]."""
        return max((support.delay for support in self.supports), default=0.0)

    @property
    def pair(self) -> tuple[Building, Building]:
        """The two single masses, left and right, of a scene that is no row."""
        left, right = self.buildings
        assert isinstance(left, Building) and isinstance(right, Building)
        return left, right

    @property
    def model_names(self) -> tuple[str, ...]:
        """The contact models of the interfaces, which `simulate` runs, and of the grid."""
        own_models = (interface.contact_model for interface in self.interfaces)
        return tuple(dict.fromkeys((*own_models, *self._gridded_models)))

    def models_of(self, *labels: str) -> tuple[str, ...]:
        """The contact models that labels of the dataset's contact models stand for, each once."""
        own_models = tuple(interface.contact_model for interface in self.interfaces)
        return tuple(
            dict.fromkeys(name for label in labels for name in (own_models if label == OF_EACH_INTERFACE else (label,)))
        )

    @property
    def _gridded_models(self) -> tuple[str, ...]:
        return tuple(name for name in self.grid.contact_models if name != OF_EACH_INTERFACE)

    def at(self, place: int) -> Self:
        """The scene of interface ``place`` alone, from 0: its two buildings and what stands between them."""
        if len(self.interfaces) == 1:
            return self
        interface, grid = self.interfaces[place], self.grid
        gaps = grid.gaps if self.gridded_interface in (None, self.interface_names[place]) else (interface.gap,)
        forces = grid.yield_forces if len(grid.yield_forces) > 1 else (interface.yield_force,)
        models = tuple(interface.contact_model if name == OF_EACH_INTERFACE else name for name in grid.contact_models)
        return self.updated(
            buildings=self.buildings[place : place + 2],
            grid=grid._replace(gaps=gaps, yield_forces=forces, contact_models=models),
            interfaces=(
                interface.updated(
                    points=tuple(point._replace(interface=0) for point in interface.points),
                    links=tuple(link._replace(interface=0) for link in interface.links),
                ),
            ),
            gridded_interface=None,
            damage=(),
        )

    def interface_gaps(self, gap: float) -> tuple[float, ...]:
        """The gap of each interface where that of the grid is ``gap`` [m]."""
        gridded_name = self.gridded_interface
        pairs = zip(self.interface_names, self.interfaces, strict=True)
        return tuple(gap if gridded_name in (None, name) else interface.gap for name, interface in pairs)

    def point_yield_forces(self, force: float | None = None) -> tuple[float, ...]:
        """The yield force of each of `points` [N] where that of floors is ``force``; None for each interface's own.

        A grid of one yield force leaves every interface its own. Columns keep theirs. Either end of a face that
        rotates has half of its floor's.
        """
        return tuple(
            self.column_force(point)
            if point.kind == COLUMN
            else (interface.yield_force if force is None else force) * (1.0 if point.across == inf else 0.5)
            for interface in self.interfaces
            for point in interface.points
        )

    def column_force(self, point: Point) -> float:
        """The force at which the struck column of a contact point yields [N]: its building's, or the interface's."""
        own_force = self.own_column_force(point)
        return self.interfaces[point.interface].column_yield_force if own_force == inf else own_force

    def own_column_force(self, point: Point) -> float:
        """The column strength of the building that is struck at a contact point [N]; infinite where it has none."""
        struck = self.struck_building(point)
        return inf if struck is None else self.buildings[struck].column_strength

    def struck_building(self, point: Point) -> int | None:
        """Whose column a floor strikes at a contact point, by its place in the row; None where floors meet."""
        floors = enumerate((point.left_floor, point.right_floor), point.interface)
        struck_places = (place for place, floor in floors if floor != int(floor) and not self.buildings[place].is_rigid)
        return next(struck_places, None)

    @property
    def striking_mass(self) -> float:
        """m1 m2 / (m1 + m2) of what strikes at the first interface [kg]; the other's mass where one is rigid.

        A single mass strikes whole, a building of storeys with a floor of average mass.
        """
        left, right = (
            len(building.masses) / building.mass
            if isinstance(building, Storeys)
            else building.oscillator().inverse_mass
            for building in self.buildings[:2]
        )
        return 1.0 / (left + right)

    # -------------------------------------------------------------------------------------------- contact laws

    def law(self, name: str | None = None, stiffness: float | None = None) -> Any:
        """The contact law ``name`` (the first interface's own by default) with the first interface's stiffness.

        A law whose stiffness has the other unit (k in N/m against β in N/m^1.5) has no value of its own in
        the scene: pass the ``stiffness`` that the scene's equal terms lead to. Raises SceneError without it, and
        for a law that needs a restitution or the buildings' floors where the scene gives none; as `law_class` for a
        name.
        """
        name = self._own_name(name)
        law = self.law_class(name)
        if law.needs_restitution and self.restitution_words == NO_RESTITUTION:
            raise SceneError(self.source, [needed_restitution(name)])
        if needs_floors(law):
            if names := self.without_floor():
                advice = 'write floor_length = "20 m" in its [[building]]'
                raise SceneError(self.source, [f"{name} needs a length of every floor, {names[0]} has none; {advice}"])
            return law.between(*self.buildings[:2])
        if is_instant(law):
            return law()
        if fault := self.lacks_table(name):
            raise SceneError(self.source, [fault])
        table = self.interfaces[0].table
        if stiffness is None and table is not None and name == TABULATED != self.stiff_name:
            stiffness = table.stiffness
        if stiffness is None and self.stiffness is None:
            unit = stiffness_quantity(law).unit
            sentence = f"{name} needs a stiffness in {unit}, and the scene gives none; write it in [[interface]]"
            raise SceneError(self.source, [sentence])
        if stiffness is None and self._other_family(name):
            unit, own_unit = stiffness_quantity(law).unit, stiffness_quantity(known_law(self.stiff_name)).unit
            sentence = (
                f"{name} takes a stiffness in {unit}, the scene gives one in {own_unit} for {self.stiff_name}; "
                f"write equal_terms = {EQUAL_TERMS_EXAMPLE} in [[interface]], from which it follows"
            )
            raise SceneError(self.source, [sentence])
        parameters: dict[str, Any] = {"stiffness": self.stiffness if stiffness is None else float(stiffness)}
        parameters |= {key: getattr(self.interfaces[0], key) for key in PARAMETERS if key in law._fields}
        return law(**parameters)

    def lacks_table(self, name: str) -> str:
        """Why a contact model lacks its table of forces; "" for other names, and where the scene gives one."""
        if name != TABULATED or self.interfaces[0].table is not None:
            return ""
        return f'the scene gives no table of forces; write table = "bumper.csv" in [[interface]] for {TABULATED}'

    def _own_name(self, name: str | None) -> str:
        return self.interfaces[0].contact_model if name in (None, OF_EACH_INTERFACE) else str(name)

    def without_floor(self) -> tuple[str, ...]:
        """The buildings that lack the length of their floor, for a model of colliding floors; a rigid one is a wall."""
        return tuple(
            building.name
            for building in self.buildings
            if not building.is_rigid and not getattr(building, "floor_length", 0.0)
        )

    def law_class(self, name: str) -> Any:
        """The class of a contact law under the scene's damping relation.

        Raises PoundingError for a name that is no law's, and for a law that the relation is not known for.
        """
        return related(known_law(self._own_name(name)), self.relation)

    def needs_equal_terms(self, name: str) -> bool:
        """True where the law's stiffness follows from the scene's equal terms, and is not the scene's own."""
        name = self._own_name(name)
        if is_instant(known_law(name)) or self.stiffness is None:
            return False
        if self.equal_terms and self.equal_terms.every_law:
            return name != self.stiff_name
        return self._other_family(name)

    def _other_family(self, name: str) -> bool:
        """True where the law's stiffness has another unit than the scene's; that of a table is its own."""
        if name == TABULATED:
            return False
        return stiffness_quantity(known_law(name)).unit != stiffness_quantity(known_law(self.stiff_name)).unit

    @property
    def stiff_name(self) -> str:
        """The contact model whose stiffness the scene gives: its own, or the grid's first that takes one."""
        own_name = self.interfaces[0].contact_model
        return stiff_model(own_name, self._gridded_models) or own_name

    @property
    def folder(self) -> Path:
        """The folder that record files are relative to: the scene file's."""
        return Path(self.source).parent
