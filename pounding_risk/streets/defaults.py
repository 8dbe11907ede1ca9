"""The buildings of a street, and the rules that fill the values missing in its table; every filled value is noted."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass
from math import inf, isnan, nan
from typing import Any, NamedTuple

from pounding_risk import units
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH, USUAL_DEPTH
from pounding_risk.models.structures.storeys import MOST_STOREYS, generated
from pounding_risk.models.structures.typologies import EUROPEAN, known_typology
from pounding_risk.streets.hazus import FAMILIES, LEVELS, NO_CODE, OF_TYPOLOGY, Chain, Type, chain, family_of, type_of
from pounding_risk.streets.inventory._lines import Notes as Doubts
from pounding_risk.streets.table import AREA, HEIGHT, LOAD, STOREYS, Entry, Mapped
from pounding_risk.units import DAMPING, GAP, STANDARD_GRAVITY, Quantity, say, shown, si, unknown

LOWEST_STOREY, HIGHEST_STOREY = 2.0, 6.0  # m; a storey outside is doubted
HIGH = (
    f"a storey would be lower than {LOWEST_STOREY:g} m or higher than {HIGHEST_STOREY:g} m; check height and storeys, "
    "and the unit of the height"
)
UNLIKE = 2.0  # ratio of a floor's area to that of the footprint above which, or below its inverse, both are doubted
AREA_DOUBT = "the floor area is less than half or more than twice that of the footprint; check its unit"
LIMIT = Quantity("m", 0.0, inf, "gap that parts rows", open_low=True, open_high=True, example="1 m")
RESOLUTION = Quantity("m", 0.0, 100.0, "resolution of footprints", example="0.5 m")
FACING = Quantity("1", 0.0, 1.0, "share of a front", open_high=True, example="0.1")
STATED = "stated for buildings without one"
CHAINS = ("typology", "hazus")
OF_HAZUS = ("hazus type", "code level")  # columns that no storeys of a typology are made of


@dataclass(frozen=True)
class Rules:
    """How a street's table is read: values for what it does not give, and what makes a row.

    Numbers are in SI, text has its unit ("3 m").

    Parameters
    ----------
    storey_height : float or str
        Height of a storey [m], from which the storeys follow, or the height.
    typology : str
        Typology; "masonry" has the C_t of "all other structural systems" in ASCE 7.
    damping : float or str
        Damping ratio of a building.
    floor_load : float or str
        Weight of a floor with its walls and its share of live load [Pa].
    floor_area : float or str, optional
        Area of a floor [m²]. Without it a building without floor mass, area and footprint is a fault.
    floor_depth : float or str
        Depth of the floors [m]; floors that overlap in height meet floor to floor.
    gap : float or str
        Gap between neighbours [m].
    limit : float or str
        Buildings with a gap below it are one row [m].
    survey : float or str
        Accuracy of the walls [m]: overlaps up to it are gaps of 0.
    least_facing : float or str
        Share of the shorter front; two that face each other over less are no neighbours.
    metres : bool
        Whether coordinates of footprints are metres east and north, not longitude and latitude.
    chain : {"typology", "hazus"}
        What storeys are made of: a typology, with the period of a code; or a type of Hazus, with its period, strengths
        and limits of damage.
    code_level : {"high", "moderate", "low", "pre"}, optional
        Level of the seismic code by which buildings were designed, "moderate" by default, for ``chain`` "hazus" alone.
    axis : float or str, optional
        Direction of a street from left to right [degrees clockwise from north]; without it each street has the
        direction of its own walls.
    resolution : float or str, optional
        How far off measured gaps may be [m]: each is then uniform within so much. Without it that is what the file
        says, such as the last decimal of its coordinates.
    storeys : int, optional
        Storeys of a building without height and storeys, which without it is a fault.

    Raises
    ------
    PoundingError
        For a value out of range.
    """

    storey_height: float = 3.0
    typology: str = "masonry"
    damping: float = 0.05
    floor_load: float = 10e3
    floor_area: float | None = None
    floor_depth: float = USUAL_DEPTH
    gap: float = 0.0
    limit: float = 1.0
    survey: float = 0.1
    least_facing: float = 0.0
    metres: bool = False
    axis: float | None = None
    resolution: float | None = None
    storeys: int | None = None
    chain: str = "typology"
    code_level: str | None = None

    def __post_init__(self) -> None:
        for name, quantity in RANGES.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, si(value, quantity, f"rules, {name}"))
        if self.storeys is not None and self.storeys != int(self.storeys):
            raise PoundingError(f"rules, storeys: {self.storeys} is no whole number; write one such as 3")
        try:
            known_typology(self.typology)
        except PoundingError as error:
            raise PoundingError(f"--typology (typology in Python): {error}") from None
        for name, allowed in (("chain", CHAINS), ("code_level", LEVELS)):
            value = getattr(self, name)
            if value is not None and value not in allowed:
                option = f"--{name.replace('_', '-')} ({name} in Python)"
                raise PoundingError(f"{option}: {unknown(value, 'none', allowed)}")
        if self.code_level is not None and self.chain != "hazus":
            raise PoundingError("--code-level: is that of storeys by hazus; add --chain hazus, or leave it out")


RANGES = {  # of the numbers of `Rules`
    "storey_height": HEIGHT,
    "damping": DAMPING,
    "floor_load": LOAD,
    "floor_area": AREA,
    "floor_depth": FLOOR_DEPTH,
    "least_facing": FACING,
    "gap": GAP,
    "limit": LIMIT,
    "survey": GAP,
    "axis": units.DIRECTION,
    "resolution": RESOLUTION,
    "storeys": STOREYS,
}


class House(NamedTuple):
    """One building of a street, with every value that a scene needs, in SI."""

    name: str
    street: str
    height: float  # m
    storeys: int
    typology: str
    floor_mass: float  # kg
    damping: float
    period: float | None = None  # s; None is the typology's
    floor_depth: float = USUAL_DEPTH  # m
    gap: float = nan  # m, as given, to the building on its right
    walls: tuple[float, float] = (nan, nan)  # m along the street, left and right
    footprint: Any = None  # a polygon of shapely, m east and north of the middle of all footprints
    mapped: Mapped | None = None
    place: str = ""  # in its file, such as "feature 3"
    chain: Chain | None = None  # its storeys by Hazus


class Filled(NamedTuple):
    """A value that the table does not give: street, building, column, the value in words, and the rule that gave it."""

    street: str
    building: str
    column: str
    value: str
    rule: str


class Notes(NamedTuple):
    """Faults, filled values and doubts noted while a table is read."""

    faults: list[str]
    filled: list[Filled]
    doubts: Doubts


def unnamed(number: int) -> str:
    """The name of a building without one, the ``number``-th of its file."""
    return f"building {number}"


class Completed:
    """An entry, the ``number``-th of its file, whose missing values are filled by rule, each with a note."""

    def __init__(self, number: int, entry: Entry, rules: Rules, notes: Notes) -> None:
        self.entry, self.values, self.rules, self.notes = entry, entry.values, rules, notes
        self.name, self.street = self.values.get("name", unnamed(number)), self.values.get("street", "")
        self.place_and_name = f"{entry.place}, {self.name}"

    def fill(self, column: str, value: str, rule: str) -> None:
        """Note a value that a rule gave."""
        self.notes.filled.append(Filled(self.street, self.name, column, value, rule))

    def fault(self, words: str) -> None:
        """Note a fault; ``words`` begin with the column, or with what the entry does."""
        self.notes.faults.append(f"{self.place_and_name}{words}")

    def doubt(self, detail: str, words: str) -> None:
        """Note a doubt, once for all buildings with the same ``words``."""
        self.notes.doubts.add(f"{self.place_and_name} ({detail})" if detail else self.place_and_name, words)

    def house(self) -> House:
        """The building of the entry, with the values that its rules fill in."""
        values, rules = self.values, self.rules
        by_type = ("typology",) if "hazus type" in values else ()
        unused = by_type if rules.chain == "hazus" else OF_HAZUS
        for column, value, rule in self.entry.derived:
            if column not in unused:
                self.fill(column, value, rule)
        if "name" not in values:
            self.fill("name", self.name, "its number among the buildings that were read")
        type_typology = (
            FAMILIES[family_of(values["hazus type"])].typology if family_of(values.get("hazus type", "")) else ""
        )
        typology_text = values.get("typology") or type_typology or rules.typology
        typology = "_".join(typology_text.lower().split())  # "Concrete frame" is concrete_frame
        family = self._family(typology)
        height, storeys = self._size(family)
        if "typology" not in values and "hazus type" not in (values if family else ()):
            self.fill("typology", typology, f"its hazus type {values['hazus type']}" if type_typology else STATED)
        kind = type_of(family, storeys) if family else None
        try:
            typology_kind = known_typology(typology)
            if "period" not in values and kind is None and not isnan(height):
                typology_kind.period(height)
        except PoundingError as error:
            self.fault(f", typology: {error}")
        damping = values.get("damping", kind.damping if kind else rules.damping)
        if "damping" not in values:
            self.fill("damping", say(damping, DAMPING), f"Hazus, {kind.name}" if kind else STATED)
        walls = values.get("left wall", nan), values.get("right wall", nan)
        if walls[0] >= walls[1]:
            self.fault(", right wall: is not to the right of its left wall; exchange the two")
        mass = self._floor_mass()
        depth = values.get("floor depth", rules.floor_depth)
        if "floor depth" not in values:
            self.fill("floor depth", say(depth, FLOOR_DEPTH), STATED)
        facts = (height, storeys, typology, mass, damping, values.get("period"), depth, values.get("gap", nan))
        storey_chain = None if kind is None or isnan(mass) else self._chain(kind, storeys, mass)
        if kind is None:
            with suppress(PoundingError):  # whose fault is noted above, or by the scene
                self._generated(height, storeys, typology, mass)
        entry = self.entry
        return House(self.name, self.street, *facts, walls, entry.footprint, entry.mapped, entry.place, storey_chain)

    def _generated(self, height: float, storeys: int, typology: str, mass: float) -> None:
        """List the values that the scene generates from a typology: period, stiffnesses and strengths of storeys."""
        kind, period = known_typology(typology), self.values.get("period")
        made = generated(self.name, height=height, storeys=storeys, typology=typology, floor_mass=mass, period=period)
        if period is None:
            rule = f"{kind.words}: {kind.period_words}, {kind.code.reference}"
            self.fill("period", say(kind.period(height), units.PERIOD), rule)
        stiffness, strength = say(made.stiffnesses[0], units.STIFFNESS), say(made.strengths[0], units.STOREY_STRENGTH)
        rule = f"its period, and a first mode of the shape {kind.shape_words}"
        self.fill("storey stiffness", f"{stiffness} at the ground", rule)
        rule = "the yield acceleration of its typology, where [effects] has inelastic_storeys"
        self.fill("storey strengths", f"{strength} at the ground", rule)

    def _family(self, typology: str) -> str:
        """The family of Hazus that storeys are made of: as given, or of the typology; "" for storeys of a typology."""
        if self.rules.chain != "hazus":
            return ""
        hazus_type = self.values.get("hazus type", "")
        family = family_of(hazus_type) if hazus_type else OF_TYPOLOGY.get(typology.removesuffix(EUROPEAN), "")
        if family and type_of(family, 1) is not None:
            return family
        if hazus_type:
            types_text = ", ".join(name for name in FAMILIES if type_of(name, 1))
            self.fault(f", hazus type: {shown(hazus_type)} has no storeys here; it may be {types_text}")
        return ""

    def _chain(self, kind: Type, storeys: int, mass: float) -> Chain | None:
        """Storeys by Hazus for a number of them and a mass of a floor, each value listed."""
        values, family = self.values, family_of(kind.name)
        code_level = values.get("code level", self.rules.code_level or "moderate").lower()
        level = "low" if family in NO_CODE and code_level in ("high", "moderate") else code_level
        if code_level not in LEVELS:
            self.fault(f", code level: {shown(code_level)} is none; it may be {', '.join(LEVELS)}")
            return None
        if "hazus type" not in values:
            self.fill("hazus type", kind.name, f"{FAMILIES[family].words}, as its typology")
        if level != code_level:
            self.fill("code level", level, f"the manual has no {code_level} code of {family}")
        elif "code level" not in values:
            self.fill("code level", level, STATED)
        exact = chain(kind, level, storeys, mass, period=values.get("period"))
        stiffness, *strengths = (float(f"{number:.6g}") for number in (exact.stiffness, *exact.strengths))
        rule = f"Hazus, {kind.name} of {level} code"
        if "period" not in values:
            self.fill("period", say(exact.period, units.PERIOD), f"Hazus, {kind.name}: {kind.period:.4g} s a storey")
        self.fill("storey stiffness", say(stiffness, units.STIFFNESS), "its period and masses, all storeys equal")
        self.fill("storey strengths", f"{say(strengths[0], units.STOREY_STRENGTH)} at the ground", rule)
        self.fill("damage limits", ", ".join(f"{100.0 * drift:.4g} %" for drift in exact.drifts), rule)
        return exact._replace(stiffness=stiffness, strengths=tuple(strengths))

    def _size(self, family: str) -> tuple[float, int]:
        """Height and number of storeys; where one is missing it follows from the other."""
        values, storey_height = self.values, self.rules.storey_height
        if "height" not in values:
            storeys = values.get("storeys", self.rules.storeys)
            if storeys is None:
                self.fault(": gives neither height nor storeys; write one of the two, or state --storeys")
                return nan, 1
            kind = type_of(family, storeys) if family and "storeys" in values else None
            storey_height, storeys = kind.storey_height if kind else storey_height, round(storeys)
            if "storeys" not in values:
                self.fill("storeys", str(storeys), "stated for buildings without height and storeys")
            height = storeys * storey_height
            self.fill("height", f"{height:g} m", f"its storeys at {storey_height:g} m each")
            return height, storeys
        height = values["height"]
        if "storeys" not in values:
            storeys = max(round(height / storey_height), 1)
            if storeys > MOST_STOREYS:
                words = f"{height:g} m would be {storeys} storeys of {storey_height:g} m, {MOST_STOREYS} are the most"
                self.fault(f", height: {words}; check its unit")
            self.fill("storeys", str(storeys), f"its height at {storey_height:g} m a storey")
            return height, storeys
        storeys = values["storeys"]
        if not LOWEST_STOREY <= height / storeys <= HIGHEST_STOREY:
            self.doubt(f"{storeys} storeys in {height:.4g} m", HIGH)
        return height, storeys

    def _floor_mass(self) -> float:
        """Mass of each floor: as given, or of its area under a load."""
        values, footprint, area = self.values, self.entry.footprint, self.rules.floor_area
        if "floor mass" in values:
            for column in ("floor area", "floor load"):
                if column in values:
                    self.doubt("", f"its {column} is not used, as its floor mass is given")
            return float(values["floor mass"])
        floor_area = values.get("floor area")
        if floor_area is None and footprint is not None:
            floor_area = round(footprint.area, 2)
            self.fill("floor area", f"{floor_area:g} m²", "that of its footprint")
        elif floor_area is None and area is not None:
            floor_area = area
            self.fill("floor area", f"{floor_area:g} m²", STATED)
        elif floor_area is None:
            self.fault(": gives neither floor mass nor floor area; write one, or state an area for all such")
            return nan
        elif footprint is not None and not 1.0 / UNLIKE <= floor_area / footprint.area <= UNLIKE:
            self.doubt(f"{floor_area:.4g} m² over {footprint.area:.4g} m²", AREA_DOUBT)
        load = values.get("floor load", self.rules.floor_load)
        if "floor load" not in values:
            self.fill("floor load", f"{load / 1e3:g} kN/m²", STATED)
        mass = float(round(floor_area * load / STANDARD_GRAVITY))
        self.fill("floor mass", say(mass, units.MASS, 6), "floor area × floor load / g")
        return mass
