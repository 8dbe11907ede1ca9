"""Scene files: TOML with quantities in, a `Scene` out, and every fault of a file told at once.

Keys are declared once, in the tables below, and pydantic walks them. `scene.values` reads their values, `scene.checks`
holds the rules on several keys, `scene.toml` reads and writes the text.
"""

from __future__ import annotations

import copy
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from pathlib import Path
from typing import Annotated, Any

from pydantic import (
    BaseModel,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
    create_model,
)
from pydantic_core import CoreSchema, core_schema

from pounding_risk._common.words import nearest
from pounding_risk.errors import SceneError
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import SHIPPED
from pounding_risk.models.contact.laws.bilinear import DESIGN_PENETRATION
from pounding_risk.models.contact.laws.van_mier import EXPONENT
from pounding_risk.models.contact.relation import AS_PUBLISHED
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.restitution import NAMED, Restitution, constant
from pounding_risk.models.structures.contact_points import FLOOR_DEPTH
from pounding_risk.models.structures.sdof import CONCRETE_WAVE_SPEED
from pounding_risk.models.structures.storeys import DAMPING_RULES
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.motions.request import AS_RECORDED, MEDIANS, POLARITIES, RecordRequest, Spectral, StepTable
from pounding_risk.scene import records as scene_records
from pounding_risk.scene import values as scene_keys
from pounding_risk.scene.build import Origin, assembled
from pounding_risk.scene.buildings import BUILDING_MASS, BUILDING_PERIOD, LEAST_FLOOR_MASS
from pounding_risk.scene.checks import LATER, across_keys, later_words
from pounding_risk.scene.interfaces import is_row
from pounding_risk.scene.overrides import ARRAYS, override
from pounding_risk.scene.scene import (
    EQUAL_TERMS,
    NO_RESTITUTION,
    Effect,
    EqualTerms,
    Grid,
    Scene,
)
from pounding_risk.scene.toml import Fault, KeyPath, key_lines, parse_toml, read_text, sentences
from pounding_risk.scene.words import described, facts
from pounding_risk.units import (
    DAMPING,
    DIRECTION,
    FLOOR_LENGTH,
    GAP,
    HEIGHT,
    LEVELS,
    PGA,
    RTOL,
    SCALE,
    SPEED,
    STEP,
    STIFFNESS,
    STOREY_HEIGHT,
    STOREY_STRENGTH,
    TAIL,
    WAVE_SPEED,
    YIELD_FORCE,
    Quantity,
    parse,
    shown,
)

__all__ = [
    "EqualTerms",
    "Grid",
    "RecordRequest",
    "Scene",
    "parse_scene",
    "read_scene",
    "scene_schema",
    "study_from",
    "written_tables",
]


class Reads:
    """A key's reader for pydantic, with the JSON schema that editors get."""

    def __init__(self, read: Callable[[Any], Any], schema: dict[str, Any]):
        self.read, self.schema = read, schema

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> CoreSchema:
        return core_schema.no_info_plain_validator_function(self.read)

    def __get_pydantic_json_schema__(self, schema: CoreSchema, handler: GetJsonSchemaHandler) -> dict[str, Any]:
        return self.schema


def measured(quantity: Quantity) -> Reads:
    """A quantity: text with a unit, or a plain number where it is dimensionless."""
    plain = quantity.unit == "1"
    kind = {"type": ["number", "string"]} if plain else {"type": "string"}
    return Reads(partial(parse, quantity=quantity), {**kind, **facts(quantity)})


def gridded(quantity: Quantity) -> Reads:
    """Reader of a grid key: one value, a list, or a range with start, stop and num."""
    return Reads(scene_keys.axis(quantity), {"type": ["array", "object"], **facts(quantity)})


def storeyed(quantity: Quantity) -> Reads:
    """One value for all storeys, or a list with one for each."""
    return Reads(scene_keys.per_storey(quantity), {"type": ["string", "array"], **facts(quantity)})


_STRINGS = {"type": "array", "items": {"type": "string"}}
_LAW = {"enum": [*SHIPPED, *INSTANT_LAWS]}
_RESTITUTION = {"anyOf": [{"type": ["number", "string", "object"]}, {"enum": list(NAMED)}]}
_POINTS = {"type": "array", "items": {"type": "object", "required": ["left", "right"]}}
_STEPS = {"type": "array", "items": {"type": "object", "required": ["step"]}}


class Section(BaseModel):
    """A table of a scene: no key that is not declared."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class SceneTable(Section):
    name: Annotated[str, Reads(scene_keys.words("Frame beside masonry"), {"type": "string"})] = ""


class BuildingTable(Section):
    name: Annotated[str, Reads(scene_keys.words("frame"), {"type": "string"})]
    mass: Annotated[float, measured(BUILDING_MASS)] = inf
    period: Annotated[float, measured(BUILDING_PERIOD)] = 0.0
    stiffness: Annotated[float, measured(STIFFNESS)] = inf
    rigid: Annotated[bool, Reads(scene_keys.flag("rigid"), {"type": "boolean"})] = False
    damping: Annotated[float, measured(DAMPING)] = 0.05
    floor_length: Annotated[float, measured(FLOOR_LENGTH)] = 0.0
    wave_speed: Annotated[float, measured(WAVE_SPEED)] = CONCRETE_WAVE_SPEED
    height: Annotated[float, measured(HEIGHT)] = 0.0
    floor_depth: Annotated[float | None, measured(FLOOR_DEPTH)] = None
    floor_masses: Annotated[tuple[float, ...] | float, storeyed(LEAST_FLOOR_MASS)] = ()
    storey_stiffnesses: Annotated[tuple[float, ...] | float, storeyed(STIFFNESS)] = ()
    storey_heights: Annotated[tuple[float, ...] | float, storeyed(STOREY_HEIGHT)] = ()
    storey_strengths: Annotated[tuple[float, ...] | float, storeyed(STOREY_STRENGTH)] = ()
    storeys: Annotated[int, Reads(scene_keys.storey_count, {"type": "integer"})] = 0
    typology: Annotated[str, Reads(scene_keys.one_of(list(TYPOLOGIES), "a typology"), {"enum": list(TYPOLOGIES)})] = ""
    floor_mass: Annotated[float, measured(LEAST_FLOOR_MASS)] = 0.0
    damping_rule: Annotated[
        str, Reads(scene_keys.one_of(DAMPING_RULES, "a rule of damping"), {"enum": list(DAMPING_RULES)})
    ] = DAMPING_RULES[0]


class EqualTermsTable(Section):
    same: Annotated[str, Reads(scene_keys.same, {"enum": list(EQUAL_TERMS)})]
    speed: Annotated[float, measured(SPEED)]
    every_law: Annotated[bool, Reads(scene_keys.flag("every_law"), {"type": "boolean"})] = False


class InterfaceTable(Section):
    gap: Annotated[float | None, measured(GAP)] = None
    contact_model: Annotated[str | None, Reads(scene_keys.law_name, _LAW)] = None
    # Its unit depends on the contact model; some models take none.
    stiffness: Annotated[Any, Field(json_schema_extra={"type": "string"})] = None
    restitution: Annotated[
        tuple[Restitution, str, str],
        Reads(scene_keys.restitution, _RESTITUTION),
    ] = (constant(1.0), NO_RESTITUTION, AS_PUBLISHED)
    yield_force: Annotated[float, measured(YIELD_FORCE)] = inf
    column_yield_force: Annotated[float, measured(YIELD_FORCE)] = inf
    contact: Annotated[tuple[tuple[float, float], ...], Reads(scene_keys.contact_points, _POINTS)] = ()
    tolerance: Annotated[float | None, measured(LEVELS)] = None
    plastic_exponent: Annotated[float, measured(EXPONENT)] = 0.0
    design_penetration: Annotated[float, measured(DESIGN_PENETRATION)] = 0.0
    equal_terms: EqualTermsTable | None = None


# One key an effect; those of later versions are listed in `scene.checks`.
_EFFECT_KEYS: dict[str, Any] = {
    name: (Annotated[Effect | None, Reads(scene_keys.effect(name), {"type": "object"})], None) for name in EFFECTS
}
EffectsTable = create_model("EffectsTable", __base__=Section, **_EFFECT_KEYS)


class RecordsTable(Section):
    names: Annotated[tuple[str, ...], Reads(scene_records.record_names, _STRINGS)] = ()
    files: Annotated[tuple[str, ...], Reads(scene_records.record_files, _STRINGS)] = ()
    set: Annotated[str, Reads(scene_records.record_set, {"type": "string"})] = ""
    manifest: Annotated[str, Reads(scene_keys.words("selected.csv"), {"type": "string"})] = ""
    unit: Annotated[str, Reads(scene_records.unit, {"type": "string"})] = ""
    dt: Annotated[float | None, measured(STEP)] = None
    direction: Annotated[float | None, measured(DIRECTION)] = None
    window: Annotated[tuple[float, float] | None, Reads(scene_records.window, _STRINGS)] = None
    pga: Annotated[float | None, measured(PGA)] = None
    sa: Annotated[
        Spectral | None,
        Reads(scene_records.spectral('sa = {value = "0.4 g", period = "1 s"}', with_value=True), {"type": "object"}),
    ] = None
    to_median: Annotated[
        str | Spectral | None,
        Reads(scene_records.to_median, {"anyOf": [{"enum": list(MEDIANS)}, {"type": "object"}]}),
    ] = None
    scale: Annotated[float | None, measured(SCALE)] = None
    polarity: Annotated[
        tuple[str, ...], Reads(scene_records.polarity, {"anyOf": [{"enum": list(POLARITIES)}, _STRINGS]})
    ] = (AS_RECORDED,)
    processing: Annotated[
        str | tuple[StepTable, ...],
        Reads(scene_records.processing, {"anyOf": [{"enum": ["auto", "none"]}, _STEPS]}),
    ] = "auto"
    tail: Annotated[float, measured(TAIL)] = 0.0


class GridTable(Section):
    gap: Annotated[tuple[float, ...], gridded(GAP)] = ()
    interface: Annotated[str, Reads(scene_keys.words("frame | masonry"), {"type": "string"})] = ""
    yield_force: Annotated[tuple[float, ...], gridded(YIELD_FORCE)] = ()
    contact_model: Annotated[tuple[str, ...], Reads(scene_keys.law_names, _STRINGS)] = ()
    pga: Annotated[tuple[float, ...], gridded(PGA)] = ()


class SolverTable(Section):
    rtol: Annotated[float, measured(RTOL)] = 1e-6


class SceneTables(Section):
    scene: SceneTable = SceneTable()
    building: list[BuildingTable]
    interface: list[InterfaceTable]
    effects: EffectsTable = EffectsTable()  # type: ignore[valid-type]
    records: RecordsTable
    grid: GridTable = GridTable()
    solver: SolverTable = SolverTable()


TABLES: Mapping[str, type[Section]] = {
    "scene": SceneTable,
    "building": BuildingTable,
    "interface": InterfaceTable,
    "effects": EffectsTable,
    "records": RecordsTable,
    "grid": GridTable,
    "solver": SolverTable,
}
KNOWN = {section: [*table.model_fields, *LATER.get(section, {})] for section, table in TABLES.items()}
ABSENT = {
    "building": "missing; write two [[building]] tables, left and right, each with name, mass and period",
    "interface": "missing; write one [[interface]] with gap, contact_model and stiffness",
    "records": 'missing; write [records] with names = ["RSN6-180"], files = ["my/*.AT2"], or set = "..."',
    "name": 'missing; write name = "frame"',
    "same": f'missing; write same = "{EQUAL_TERMS[0]}"',
    "speed": 'missing; write speed = "0.5 m/s"',
}


def read_scene(scene: str | Path | Mapping[str, Any], overrides: Sequence[str] = ()) -> Scene:
    """The study of a scene file or its text, with ``--set``-like ``overrides`` ('interface.gap="20 mm"') applied.

    Parameters
    ----------
    scene : str, path or mapping
        A scene file; or the text of one, which has several lines or a "[["; or its tables, with quantities as text. Of
        text and tables record files are relative to the working folder.
    overrides : sequence of str
        Keys set from outside, one `path=value` each.

    Returns
    -------
    Scene
        The scene with every number in SI and every default filled in.

    Raises
    ------
    SceneError
        With every fault: its line, its key and the likely repair.
    """
    if isinstance(scene, Mapping):
        return study_from(scene, overrides=overrides)
    if not isinstance(scene, str | Path):
        raise SceneError(
            "scene", [f"{shown(scene)} is no scene; give the name of a scene file, or its tables (a dict)"]
        )
    if isinstance(scene, str) and ("\n" in scene or "[[" in scene):
        return parse_scene(scene, overrides=overrides)
    path = Path(scene)
    return parse_scene(read_text(path), str(path), overrides)


def parse_scene(text: str, source: str = "scene", overrides: Sequence[str] = ()) -> Scene:
    """The study of a scene's TOML text. As `read_scene`; record files are relative to ``source``'s folder."""
    raw = parse_toml(text, source)
    return _study(raw, Origin(source, text, key_lines(text), _listed(overrides)))


def study_from(tables: Mapping[str, Any], source: str = "scene", overrides: Sequence[str] = ()) -> Scene:
    """The study of a dict with the keys of a scene file. As `read_scene`; faults have no lines then."""
    study = _study(dict(tables), Origin(source, "", {}, _listed(overrides)))
    return replace(study, text=study.to_toml())


def written_tables(study: Scene) -> dict[str, Any]:
    """The tables of a study's text with its overrides, as they were written; its resolved ones where it has no text."""
    if not study.text:
        return study.resolved()
    raw = parse_toml(study.text, study.source)
    for text in study.overrides:
        override(raw, text, KNOWN, study.source)
    return raw


def scene_schema() -> dict[str, Any]:
    """JSON schema of a scene file, for the completion of an editor: keys, kinds, units and ranges, in words.

    ``x-unit``, ``x-range``, ``x-example`` and ``x-absent`` tell what a JSON schema has no keyword for.
    """
    return described(SceneTables.model_json_schema())


def _listed(overrides: Sequence[str]) -> tuple[str, ...]:
    """Overrides as a list; a single text counts as a list of one."""
    return (overrides,) if isinstance(overrides, str) else tuple(overrides)


def _study(raw: dict[str, Any], origin: Origin) -> Scene:
    raw = copy.deepcopy(raw)
    outside = [path for text in origin.overrides for path in override(raw, text, KNOWN, origin.source)]
    written = copy.deepcopy(raw)
    faults = later_words(raw)
    incomplete = {fault.path[:-1] for fault in faults}  # what replaces a later word is told with it
    tables: SceneTables | None = None
    try:
        tables = SceneTables.model_validate(raw)
    except ValidationError as error:
        faults += _faults(error)
    faults += across_keys(raw)
    faults += scene_records.across_keys(raw)
    faults += scene_records.missing_files(raw, Path(origin.source).parent)
    faults = [fault for fault in faults if not (fault.absent and fault.path[:-1] in incomplete)]
    if faults or tables is None:
        raise SceneError(origin.source, sentences(faults, written, origin.lines, outside))
    study, faults = assembled(tables, origin, is_row(raw))
    if faults:
        raise SceneError(origin.source, sentences(faults, written, origin.lines, outside))
    return study


def _faults(error: ValidationError) -> Iterator[Fault]:
    """Errors of pydantic as faults with this package's sentences."""
    for found in error.errors(include_url=False):
        path, kind, value = found["loc"], found["type"], found["input"]
        cause = found.get("ctx", {}).get("error")
        if isinstance(cause, scene_keys.Several):
            yield from (Fault((*path, *below), sentence) for below, sentence in cause.faults)
        elif isinstance(cause, ValueError):
            yield Fault(path, str(cause))
        elif kind == "extra_forbidden":
            yield Fault(path, _unknown(path))
        elif kind == "missing":
            yield Fault(path, ABSENT[str(path[-1])], absent=True)
        else:
            yield Fault(path, _not_a_table(path, value))


def _unknown(path: KeyPath) -> str:
    """An unknown key: the nearest known one, the section that has it, or all that there are."""
    key, parent = str(path[-1]), path[:-1]
    if not parent:
        return f"unknown section{nearest(key, KNOWN)}; sections are {', '.join(KNOWN)}"
    section = str(parent[0])
    inner = parent[-1] == "equal_terms"
    known = list(EqualTermsTable.model_fields) if inner else KNOWN[section]
    homes = [_header(other) for other in TABLES if key in TABLES[other].model_fields]
    if homes and not nearest(key, known, 0.75):
        return f"unknown key; it belongs in {' or '.join(homes)}"
    label = "equal_terms" if inner else _header(section)
    taken = EqualTermsTable.model_fields if inner else TABLES[section].model_fields
    return f"unknown key{nearest(key, known)}; {label} takes {', '.join(taken) or 'no keys in this version'}"


def _header(section: str) -> str:
    return f"[[{section}]]" if section in ARRAYS else f"[{section}]"


def _not_a_table(path: KeyPath, value: Any) -> str:
    """Something else where a table, or an array of tables, stands."""
    section = str(path[0])
    if path[-1] == "equal_terms":
        return f'{shown(value)} is not a table; write {{same = "{EQUAL_TERMS[0]}", speed = "0.5 m/s"}}'
    if section in ARRAYS and isinstance(value, dict):
        return f"one table, where each {section} is a table of a list; write [[{section}]] with double brackets"
    return f"{shown(value)} is not a table; write {_header(section)} and its keys below"


def as_scene(scene: Scene | Mapping[str, Any] | str | Path) -> Scene:
    """A study, or the scene file of that name read, or the tables of one."""
    if isinstance(scene, Scene):
        return scene
    return read_scene(scene)
