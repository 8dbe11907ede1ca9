"""The buildings of a street, and the rules that fill the values missing in its table; every filled value is noted."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from math import inf, isnan, nan
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH, USUAL_DEPTH
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.models.structures.typologies import EUROPEAN, known_typology
from pounding_risk.streets.hazus import (
    FAMILIES,
    LEVELS,
    OF_TYPOLOGY,
    Chain,
    Type,
    chain,
    family_of,
    level_of,
    type_of,
)
from pounding_risk.streets.table import AREA, HEIGHT, LOAD, STOREYS, Entry, Mapped
from pounding_risk.units import (
    DAMPING,
    DIRECTION,
    GAP,
    MASS,
    PERIOD,
    STANDARD_GRAVITY,
    STIFFNESS,
    STOREY_STRENGTH,
    Quantity,
    say,
    shown,
    si,
)

LOWEST_STOREY, HIGHEST_STOREY = 2.0, 6.0  # m; a storey outside is doubted
LIMIT = Quantity("m", 0.0, inf, "gap that parts rows", open_low=True, open_high=True, example="1 m")
RESOLUTION = Quantity("m", 0.0, 100.0, "resolution of footprints", example="0.5 m")
FACING = Quantity("1", 0.0, 1.0, "share of a front", open_high=True, example="0.1")
STATED = "stated for buildings without one"
CHAINS = ("typology", "hazus")
OF_HAZUS = ("hazus type", "code level")  # columns that no storeys of a typology are made of

Fill = Callable[[str, str, str], None]  # column, value, rule


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
        Whether coordinates of footprints are in metres, not longitude and latitude.
    chain : {"typology", "hazus"}
        What storeys are made of: a typology, with the period of a code; or a type of Hazus, with its period, strengths
        and limits of damage.
    code_level : {"high", "moderate", "low", "pre"}
        Level of the seismic code by which buildings were designed, for ``chain`` "hazus".
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
    code_level: str = "moderate"

    def __post_init__(self) -> None:
        for name, quantity in _RANGES.items():
            value = getattr(self, name)
            if value is not None:
                object.__setattr__(self, name, si(value, quantity, f"rules, {name}"))
        if self.storeys is not None and self.storeys != int(self.storeys):
            raise PoundingError(f"rules, storeys: {self.storeys} is no whole number; write one such as 3")
        known_typology(self.typology)
        for name, known in (("chain", CHAINS), ("code_level", LEVELS)):
            value = getattr(self, name)
            if value not in known:
                hint = nearest(value, known) if isinstance(value, str) else ""
                option = f"--{name.replace('_', '-')} ({name} in Python)"
                raise PoundingError(f"{option}: {shown(value)} is none{hint}; it may be {', '.join(known)}")


_RANGES = {
    "storey_height": HEIGHT,
    "damping": DAMPING,
    "floor_load": LOAD,
    "floor_area": AREA,
    "floor_depth": FLOOR_DEPTH,
    "least_facing": FACING,
    "gap": GAP,
    "limit": LIMIT,
    "survey": GAP,
    "axis": DIRECTION,
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
    doubts: list[str]


def unnamed(number: int) -> str:
    """The name of a building without one, the ``number``-th of its file."""
    return f"building {number}"


def house(number: int, entry: Entry, rules: Rules, notes: Notes) -> House:
    """The building of an entry, the ``number``-th of its file, with missing values filled in."""
    values = entry.values
    name, street = values.get("name", unnamed(number)), values.get("street", "")
    where = f"{entry.place}, {name}"

    def fill(column: str, value: str, rule: str) -> None:
        notes.filled.append(Filled(street, name, column, value, rule))

    by_type = ("typology",) if "hazus type" in values else ()
    unused = by_type if rules.chain == "hazus" else OF_HAZUS
    for column, value, rule in entry.derived:
        if column not in unused:
            fill(column, value, rule)
    if "name" not in values:
        fill("name", name, "its place in the file")
    of_type = FAMILIES[family_of(values["hazus type"])].typology if family_of(values.get("hazus type", "")) else ""
    named = values.get("typology") or of_type or rules.typology
    typology = "_".join(named.lower().split())  # "Concrete frame" is concrete_frame
    family = _family(where, values, typology, rules, notes)
    height, storeys = _size(where, values, _of_height(family, values, rules), notes, fill)
    if "typology" not in values and "hazus type" not in (values if family else ()):
        fill("typology", typology, f"its hazus type {values['hazus type']}" if of_type else STATED)
    kind = type_of(family, storeys) if family else None
    _check_typology(where, typology, height, "period" in values or kind is not None, notes)
    damping = values.get("damping", kind.damping if kind else rules.damping)
    if "damping" not in values:
        fill("damping", say(damping, DAMPING), f"Hazus, {kind.name}" if kind else STATED)
    walls = values.get("left wall", nan), values.get("right wall", nan)
    if walls[0] >= walls[1]:
        notes.faults.append(f"{where}, right wall: is not to the right of its left wall; exchange the two")
    mass = _floor_mass(where, entry, rules, notes, fill)
    depth = values.get("floor depth", rules.floor_depth)
    if "floor depth" not in values:
        fill("floor depth", say(depth, FLOOR_DEPTH), STATED)
    facts = (height, storeys, typology, mass, damping, values.get("period"), depth, values.get("gap", nan))
    storey_chain = (
        None if kind is None or isnan(mass) else _chain(where, kind, values, (storeys, mass), rules, notes, fill)
    )
    return House(name, street, *facts, walls, entry.footprint, entry.mapped, entry.place, storey_chain)


def _family(where: str, values: Mapping[str, Any], typology: str, rules: Rules, notes: Notes) -> str:
    """The family of Hazus that storeys are made of: as given, or that of the typology; "" for storeys of a typology."""
    if rules.chain != "hazus":
        return ""
    given = values.get("hazus type", "")
    family = family_of(given) if given else OF_TYPOLOGY.get(typology.removesuffix(EUROPEAN), "")
    if family and type_of(family, 1) is not None:
        return family
    if given:
        known = ", ".join(name for name in FAMILIES if type_of(name, 1))
        notes.faults.append(f"{where}, hazus type: {shown(given)} has no storeys here; it may be {known}")
    return ""


def _of_height(family: str, values: Mapping[str, Any], rules: Rules) -> Rules:
    """The rules with the height of a storey of a type, where the height follows from it."""
    kind = type_of(family, values["storeys"]) if family and "storeys" in values and "height" not in values else None
    return replace(rules, storey_height=kind.storey_height) if kind else rules


def _chain(
    where: str,
    kind: Type,
    values: Mapping[str, Any],
    size: tuple[int, float],
    rules: Rules,
    notes: Notes,
    fill: Fill,
) -> Chain | None:
    """Storeys by Hazus for a number of them and a mass of a floor, each value listed."""
    given = values.get("code level", rules.code_level).lower()
    family = family_of(kind.name)
    level = level_of(family, given)
    if given not in LEVELS:
        notes.faults.append(f"{where}, code level: {shown(given)} is none; it may be {', '.join(LEVELS)}")
        return None
    if "hazus type" not in values:
        fill("hazus type", kind.name, f"{FAMILIES[family].words}, as its typology")
    if level != given:
        fill("code level", level, f"the manual has no {given} code of {family}")
    elif "code level" not in values:
        fill("code level", level, STATED)
    made = chain(kind, level, *size, period=values.get("period"))
    strengths = tuple(_in_digits(strength) for strength in made.strengths)
    made = made._replace(stiffness=_in_digits(made.stiffness), strengths=strengths)
    rule = f"Hazus, {kind.name} of {level} code"
    if "period" not in values:
        fill("period", say(made.period, PERIOD), f"Hazus, {kind.name}: {kind.period:.4g} s a storey")
    fill("storey stiffness", say(made.stiffness, STIFFNESS), "its period and masses, all storeys equal")
    fill("storey strengths", f"{say(made.strengths[0], STOREY_STRENGTH)} at the ground", rule)
    fill("damage limits", ", ".join(f"{100.0 * drift:.4g} %" for drift in made.drifts), rule)
    return made


def _in_digits(value: float) -> float:
    return float(f"{value:.6g}")


def _check_typology(where: str, name: str, height: float, has_period: bool, notes: Notes) -> None:
    """Note a fault for an unknown typology, and for one whose period is for lower buildings."""
    try:
        kind = known_typology(name)
        if not has_period and not isnan(height):
            kind.period(height)
    except PoundingError as error:
        notes.faults.append(f"{where}, typology: {error}")


def _size(where: str, values: Mapping[str, Any], rules: Rules, notes: Notes, fill: Fill) -> tuple[float, int]:
    """Height and number of storeys; where one is missing it follows from the other."""
    usual = rules.storey_height
    if "height" not in values and "storeys" not in values and rules.storeys is None:
        notes.faults.append(f"{where}: gives neither height nor storeys; write one of the two, or state --storeys")
        return nan, 1
    if "height" not in values:
        storeys = values.get("storeys", rules.storeys)
        storeys = round(storeys)
        if "storeys" not in values:
            fill("storeys", str(storeys), "stated for buildings without height and storeys")
        height = storeys * usual
        fill("height", f"{height:g} m", f"its storeys at {usual:g} m each")
        return height, storeys
    height = values["height"]
    if "storeys" not in values:
        storeys = max(round(height / usual), 1)
        if storeys > MOST_STOREYS:
            words = f"{height:g} m would be {storeys} storeys of {usual:g} m, {MOST_STOREYS} are the most"
            notes.faults.append(f"{where}, height: {words}; check its unit")
        fill("storeys", str(storeys), f"its height at {usual:g} m a storey")
        return height, storeys
    storeys = values["storeys"]
    if not LOWEST_STOREY <= height / storeys <= HIGHEST_STOREY:
        words = f"{storeys} storeys in {height:g} m are {height / storeys:.2g} m each"
        notes.doubts.append(f"{where}: {words}; check both, and the unit of the height")
    return height, storeys


def _floor_mass(where: str, entry: Entry, rules: Rules, notes: Notes, fill: Fill) -> float:
    """Mass of each floor: as given, or of its area under a load."""
    values = entry.values
    if "floor mass" in values:
        for column in ("floor area", "floor load"):
            if column in values:
                notes.doubts.append(f"{where}: its {column} is not used, as its floor mass is given")
        return float(values["floor mass"])
    size = values.get("floor area")
    if size is None and entry.footprint is not None:
        size = round(entry.footprint.area, 2)
        fill("floor area", f"{size:g} m²", "that of its footprint")
    elif size is None and rules.floor_area is not None:
        size = rules.floor_area
        fill("floor area", f"{size:g} m²", STATED)
    elif size is None:
        notes.faults.append(
            f"{where}: gives neither floor mass nor floor area; write one, or state an area for all such"
        )
        return nan
    load = values.get("floor load", rules.floor_load)
    if "floor load" not in values:
        fill("floor load", f"{load / 1e3:g} kN/m²", STATED)
    mass = float(round(size * load / STANDARD_GRAVITY))
    fill("floor mass", say(mass, MASS, 6), "floor area × floor load / g")
    return mass
