"""The [[damage]] tables of a scene: states of damage, each reached where one demand is at least a threshold.

A kind of demand is one entry of `DEMANDS`: from it follow the key of [[damage]], its words, unit and range, and where
the datasets of `scan` have it, with contact and without. No run reads a state, so that states may also be given after
a scan.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import create_model

from pounding_risk._common.words import nearest
from pounding_risk.errors import SceneError
from pounding_risk.scene.keys import (
    Key,
    Section,
    Table,
    in_text,
    measured,
    read_section,
    repeated_names,
    text,
    whole_from,
)
from pounding_risk.scene.toml import Fault, key_lines, parse_toml, read_text, sentences
from pounding_risk.units import Quantity, article, say, shown

# Keys that say where a demand acts.
OF_BUILDINGS, OF_INTERFACES, OF_LINKS = ("building", "storey"), ("interface", "contact_point"), ("interface",)
LARGEST_DRIFT = 0.3  # of a storey's height: 0.5 was meant as 0.5 %
_SHARE = '"0.5 %" or 0.005'


class Demand(NamedTuple):
    """A kind of demand on a building or an interface, and the variables of a dataset of `scan` that have it.

    ``storeys`` names the variable by building and storey, whose largest value counts; datasets of two single masses
    have ``mass`` instead, by building. Demands on interfaces are by contact point or interface, those on ``links`` by
    interface. The same names with ``_free`` are the demands without contact, where a demand on an interface is 0.
    """

    key: str
    quantity: Quantity
    words: str
    example: str = ""  # where it is not that of the quantity
    storeys: str = ""
    mass: str = ""
    interfaces: str = ""
    links: str = ""
    per_height: bool = False  # over the height of the storey
    points: str = ""  # the only kind of contact points that count
    absent: str = ""  # what a dataset without it lacks, and the repair

    @property
    def places(self) -> tuple[str, ...]:
        """The keys that say where it is."""
        return OF_INTERFACES if self.interfaces else OF_LINKS if self.links else OF_BUILDINGS

    @property
    def of_structure(self) -> bool:
        """Whether it is a deformation of storeys, which is no damage of isolators."""
        return self.per_height or self.key == "ductility"

    @property
    def unit(self) -> str:
        """Its unit as `units.SHOWN` has it: a share of a height is shown in per cent, its numbers are fractions."""
        return "%" if self.per_height else self.quantity.unit.replace("m/s^2", "m/s2")

    def say(self, threshold: float) -> str:
        """A threshold as an engineer writes it: 0.5 %, 20 mm, 3."""
        return f"{100.0 * threshold:.6g} %" if self.per_height else say(threshold, self.quantity, 6)


def _at_most(unit: str, words: str, example: str, high: float = inf) -> Quantity:
    """A positive quantity."""
    return Quantity(unit, 0.0, high, words, open_low=True, open_high=True, example=example)


NO_HEIGHT = "no height is known; write storey_heights, or the height of a single mass, in its [[building]], and scan"
NO_YIELDING = (
    "no storey of it yields; write storey_strengths in its [[building]], of one storey where it is a single mass, and "
    "inelastic_storeys = {} in [effects], and scan"
)
NO_COLUMN = "no floor meets a column there; take contact_force"
NO_LINK = "no link joins them; write link_stiffness or link_damping in their [[interface]], and scan"
NO_SPRING = "no link there has a spring; take link_stretch"
NO_DAMPER = "no damper there has a peak of its force; write link_exponent or link_brace_stiffness, and scan"
DEMANDS = (
    Demand(
        "drift",
        _at_most("1", "storey drift ratio", _SHARE, LARGEST_DRIFT),
        "storey drift",
        '"0.5 %"',
        storeys="storey_drift",
        mass="peak_displacement",
        per_height=True,
        absent=NO_HEIGHT,
    ),
    Demand(
        "residual_drift",
        _at_most("1", "residual drift ratio", _SHARE, LARGEST_DRIFT),
        "residual drift, the plastic storey drift at the end",
        '"0.2 %"',
        storeys="storey_residual_drift",
        per_height=True,
        absent=NO_YIELDING,
    ),
    Demand(
        "displacement",
        _at_most("m", "displacement", "20 mm"),
        "floor displacement, relative to the ground",
        storeys="storey_displacement",
        mass="peak_displacement",
    ),
    Demand(
        "ductility",
        _at_most("1", "ductility", "3"),
        "ductility, storey drift over the drift at yield",
        storeys="storey_ductility",
        absent=NO_YIELDING,
    ),
    Demand(
        "acceleration",
        _at_most("m/s^2", "floor acceleration", "0.9 g"),
        "floor acceleration, absolute",
        storeys="storey_acceleration",
        mass="peak_floor_acceleration",
    ),
    Demand(
        "storey_shear",
        _at_most("N", "storey shear", "900 kN"),
        "storey shear, in all columns of the storey together",
        storeys="storey_shear",
        mass="peak_storey_shear",
    ),
    Demand("contact_force", _at_most("N", "contact force", "2 MN"), "contact force", interfaces="peak_contact_force"),
    Demand(
        "column_shear",
        _at_most("N", "force on a column", "400 kN"),
        "force on a column, with which a floor strikes it: the most that it may have to carry in shear",
        interfaces="peak_contact_force",
        points="column",
        absent=NO_COLUMN,
    ),
    Demand(
        "link_stretch",
        _at_most("m", "stretch of a link", "100 mm"),
        "stretch of a link, by which its ends have parted",
        links="peak_link_stretch",
        absent=NO_LINK,
    ),
    Demand(
        "link_shortening",
        _at_most("m", "shortening of a link", "40 mm"),
        "shortening of a link, by which its ends have approached",
        links="peak_link_shortening",
        absent=NO_LINK,
    ),
    Demand(
        "link_spring_force",
        _at_most("N", "force of a link's spring", "500 kN"),
        "force of a link's spring, without the dashpot beside it",
        links="peak_link_spring_force",
        absent=NO_SPRING,
    ),
    Demand(
        "link_damper_force",
        _at_most("N", "force of a damper", "500 kN"),
        "force of a damper with link_exponent or on a brace, without the spring beside it",
        links="peak_link_damper_force",
        absent=NO_DAMPER,
    ),
)


# ------------------------------------------------------------------------------------------------ keys


NO_STOREY = "is not the number of a storey; write a whole number from 1, the lowest"


class State(Table):
    """A state of damage: its name and where it is; `DamageState` has the thresholds too."""

    name: str = text("What tables and figures call the state; each has its own.", "slight").required()
    building: str = text("The only building that counts.", "frame", "any building").defaults_to("")
    storey: int = Key(
        "The only storey that counts, from 1 at the ground.",
        lambda value, number: whole_from(value, 1, inf, NO_STOREY),
        "1",
        "any storey; of drifts and ductility those above isolators",
        schema={"type": "integer"},
    ).defaults_to(0)
    interface: str = text(
        "The only interface that counts, by its buildings.", "frame | masonry", "any interface"
    ).defaults_to("")
    contact_point: str = text(
        "The only contact point that counts, by its label in the dataset.", "A 2 | B 2", "any contact point"
    ).defaults_to("")

    @property
    def demand(self) -> Demand:
        """The kind of demand that it is reached by."""
        return next(demand for demand in DEMANDS if getattr(self, demand.key) is not None)

    @property
    def threshold(self) -> float:
        """The demand at which it is reached, in SI."""
        return float(getattr(self, self.demand.key))

    @property
    def words(self) -> str:
        """Such as "storey drift of frame ≥ 0.5 %"."""
        names = [getattr(self, place) for place in self.demand.places]
        if "interface" in self.demand.places:
            place_text = f" at {names[-1] or names[0]}" if any(names) else ""
        else:
            place_text = f" of storey {names[1]}" if names[1] else ""
            place_text += f" of {names[0]}" if names[0] else ""
        return f"{self.demand.words.partition(',')[0]}{place_text} ≥ {self.demand.say(self.threshold)}"


REACHED, ELSE = "Reached where this is at least so much: {}.", "another demand has the threshold"
_create: Any = create_model  # the types of fields that are made here are not known to a checker of types
DamageState: Any = _create(
    "DamageState",
    __base__=State,
    __doc__="""A state of damage: its name, where it is, and the threshold of one demand.""",
    __module__=__name__,
    **{
        one.key: (float | None, measured(one.quantity, REACHED.format(one.words), one.example, ELSE).defaults_to(None))
        for one in DEMANDS
    },
)


# ------------------------------------------------------------------------------------------------ checks


def damage_checks(states: Sequence[Section], buildings: Sequence[str]) -> Iterator[Fault]:
    """All faults that more than one key of the states takes part in; ``buildings`` are the scene's by name."""
    interfaces = [f"{left} | {right}" for left, right in pairwise(buildings)]
    yield from repeated_names(states, "state")
    for keys in states:
        yield from _demand_faults(keys)
        for place, known_names in (("building", buildings), ("interface", interfaces)):
            name = keys.get(place)
            if name and name not in known_names:
                names_text = ", ".join(known_names)
                yield keys.fault(
                    place, f"{shown(name)} is no {place} of the scene{nearest(name, known_names)}; it has {names_text}"
                )


def _demand_faults(keys: Section) -> Iterator[Fault]:
    """Faults of a state without a threshold, with several, or with a place that its demand does not take."""
    demands = [demand for demand in DEMANDS if demand.key in keys]
    if not demands:
        keys_text = ", ".join(demand.key for demand in DEMANDS)
        sentence = f'has no threshold; write drift = "0.5 %", or another of {keys_text}'
        yield Fault(keys.path, sentence, absent=True)
    for demand in demands[1:]:
        yield keys.fault(
            demand.key,
            f"{demands[0].key} and {demand.key} are both given, and a state is reached by one demand; write a "
            "[[damage]] table for each",
        )
    for place in (*OF_BUILDINGS, *OF_INTERFACES) if demands else ():
        if place in keys and place not in demands[0].places:
            yield keys.fault(
                place,
                f"{demands[0].key} is no demand on {article(place.replace('_', ' '))}; write "
                f"{' or '.join(demands[0].places)}, or remove {place}",
            )


def unknown_key(key: str) -> str:
    """An unknown key of [[damage]], with the nearest known one."""
    known_keys = DamageState.key_names()
    meant_key = "column_shear" if key.startswith("column") else key  # not contact_force, whose letters are nearer
    return f"unknown key{nearest(meant_key, known_keys)}; [[damage]] takes {', '.join(known_keys)}"


def read_states(states: Any, buildings: Sequence[str], source: str = "states") -> tuple[Any, ...]:
    """States of damage from a file, the text of one, tables, or `DamageState`.

    Parameters
    ----------
    states : path, str, mapping, or sequence of mapping or DamageState
        A TOML file whose [[damage]] tables are those of a scene, or such tables.
    buildings : sequence of str
        Names of the buildings, left to right.
    source : str
        What sentences call the tables where they are of no file.

    Returns
    -------
    tuple of DamageState
        In the order in which they are given.

    Raises
    ------
    SceneError
        With every fault.
    """
    file_content, lines = states, {}
    if isinstance(states, str | Path):
        is_text = isinstance(states, str) and "\n" in states
        content = str(states) if is_text else read_text(Path(states))
        source = source if is_text else str(states)
        file_content, lines = parse_toml(content, source), key_lines(content)
    raw = dict(file_content) if isinstance(file_content, Mapping) else {"damage": _tables(file_content)}
    faults = [
        Fault((name,), f"unknown section{nearest(name, ['damage'])}; a file of states has [[damage]] tables alone")
        for name in raw
        if name != "damage"
    ]
    tables = raw.get("damage")
    if not isinstance(tables, list) or not tables or not all(isinstance(table, Mapping) for table in tables):
        advice = 'write [[damage]] with name = "slight" and drift = "0.5 %" below it'
        raise SceneError(source, [*sentences(faults, raw, lines, ()), f"damage: has no tables; {advice}"])
    sections = []
    for index, table in enumerate(tables):
        section, section_faults = read_section(DamageState, ("damage", index), table, DamageState.keys(), unknown_key)
        sections.append(section)
        faults += section_faults
    faults += damage_checks(sections, buildings)
    if faults:
        raise SceneError(source, sentences(faults, raw, lines, ()))
    return tuple(DamageState.from_values(section.values) for section in sections)


def _tables(states: Any) -> Any:
    """States of Python as a file has them."""
    if not isinstance(states, Sequence) or isinstance(states, str):
        return states
    return [
        state.written()
        if isinstance(state, Table)
        else in_text(DamageState.keys(), state)
        if isinstance(state, Mapping)
        else state
        for state in states
    ]
