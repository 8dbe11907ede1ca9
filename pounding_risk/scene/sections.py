"""The sections of a scene file: their keys read from tables, all faults of a scene at once, and the JSON schema."""

from __future__ import annotations

import copy
import re
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import MappingProxyType
from typing import Any

from pounding_risk._common.letters import refused_below
from pounding_risk._common.words import nearest
from pounding_risk.models.effects import EFFECTS
from pounding_risk.scene import buildings
from pounding_risk.scene.axes import ADDRESS, INLINE, taken_axes
from pounding_risk.scene.building_tables import plan_checks
from pounding_risk.scene.buildings import building_checks
from pounding_risk.scene.damage import DamageState, damage_checks, unknown_key
from pounding_risk.scene.interfaces import Interface
from pounding_risk.scene.keys import Draft, Key, Section, Several, Table, read_section
from pounding_risk.scene.known_motions import known_motion_checks
from pounding_risk.scene.not_modelled import instead_of, key_meant
from pounding_risk.scene.overrides import ARRAYS, override
from pounding_risk.scene.records import Records, missing_files, record_checks
from pounding_risk.scene.resolved_interfaces import interface_checks
from pounding_risk.scene.scene_axis import UNCERTAIN
from pounding_risk.scene.tables import Grid, Solver, Title, effect_checks, effect_key
from pounding_risk.scene.toml import Fault, KeyPath, sentences
from pounding_risk.scene.uncertain_tables import DISTRIBUTION, Uncertain, taken_numbers, uncertain_checks
from pounding_risk.units import shown

KINDS: Mapping[str, type[Table]] = {
    "scene": Title,
    "building": buildings.AnyBuilding,
    "interface": Interface,
    "effects": Table,
    "records": Records,
    "grid": Grid,
    UNCERTAIN: Uncertain,
    "solver": Solver,
    "damage": DamageState,
}


class _EffectKeys(Mapping[str, Key]):
    """The keys of [effects], made when they are needed: a plug-in that has an effect imports this module itself."""

    def __getitem__(self, name: str) -> Key:
        if name not in EFFECTS:
            raise KeyError(name)
        return effect_key(name)

    def __iter__(self) -> Iterator[str]:
        return iter(EFFECTS)

    def __len__(self) -> int:
        return len(EFFECTS)


# The declaration of every key, by section.
KEYS: Mapping[str, Mapping[str, Key]] = {section: kind.keys() for section, kind in KINDS.items()} | {
    "building": buildings.KEYS,
    "effects": _EffectKeys(),
}
# Words that a scene may use one day, by section: each with what this version offers instead.
LATER: Mapping[str, Mapping[str, str]] = {
    "records": {
        "components": 'written as direction = "30 deg", of the row; name both horizontal components in names or files'
    },
    "grid": {
        "scale": "a grid of scale factors is not in this version; write a grid of pga instead",
        "stiffness": 'written by its address: "interface.stiffness" = [...]',
        "restitution": 'written by its address: "interface.restitution" = [...]',
    },
}
CLOSE = 0.8  # likeness of a misspelt key to the known one; below, all keys are named beside the nearest
MISSPELT = re.compile(r'unknown key \(did you mean "(\w+)"\?\)$')
KNOWN: Mapping[str, Collection[str]] = {
    section: [*keys, *LATER[section]] if section in LATER else keys for section, keys in KEYS.items()
}
NUMBERS_ALONG = {
    "type": ["array", "object"],
    "description": "Values of the key of this address, as --set takes it; a dimension of the dataset.",
    "x-example": '"building.frame.period" = {start = "0.2 s", stop = "2 s", num = 50}',
}
ABSENT = {
    "building": "missing; write two [[building]] tables, left and right, each with name, mass and period",
    "interface": "missing; write one [[interface]] with gap, contact_model and stiffness",
    "records": 'missing; write [records] with names = ["RSN6-180"], files = ["my/*.AT2"], or set = "..."',
}
Same = Mapping[str, Sequence[Section]]
InWords = Callable[[Sequence[Fault], Mapping[KeyPath, int]], list[str]]


def read_tables(
    tables: Mapping[str, Any], overrides: Sequence[str], source: str, same: Same = MappingProxyType({})
) -> tuple[Draft, list[Fault], InWords]:
    """Every key of the tables of a scene file, the faults of single keys, and the function that words faults.

    ``same`` are sections that were read before without a fault and have the same keys in these tables.
    """
    raw = {name: table if name in same else copy.deepcopy(table) for name, table in tables.items()}
    set_paths = [path for text in overrides for path in override(raw, text, KNOWN, source)]
    written_tables = {name: table if name in same else copy.deepcopy(table) for name, table in raw.items()}
    faults = [Fault(path, words) for path, words in refused_below({key: raw[key] for key in raw if key not in same})]
    faults += _later_word_faults(raw)
    axes, axis_faults = taken_axes(raw, set_paths, KEYS)
    numbers, number_faults = taken_numbers(raw, set_paths, KEYS, axes)
    faults += axis_faults + number_faults
    names = ", ".join(KEYS)
    faults += [
        Fault((name,), f"unknown section; {instead_of(name)}")
        if instead_of(name)
        else Fault((name,), f"unknown section{nearest(name, KEYS)}; sections are {names}")
        for name in raw
        if name not in KEYS
    ]
    faults += [Fault((name,), sentence, absent=True) for name, sentence in ABSENT.items() if name not in raw]
    sections: dict[str, list[Section]] = {}
    for name in KEYS:
        if name in raw and name in same:
            sections[name] = [*same[name]]
            continue
        sections[name] = []
        for path, table in _tables(raw, name):
            if not isinstance(table, dict):
                faults.append(Fault(path, _not_a_table_sentence(path, table)))
                continue
            meant_keys = {key_meant(key, KEYS[name]) or key: value for key, value in table.items()}
            kind = buildings.kind_of(meant_keys) if name == "building" else KINDS[name]
            section, axis_faults = read_section(kind, path, table, KEYS[name], partial(_unknown_key_sentence, path))
            section, number_faults = _with_files(section, Path(source).parent)
            sections[name].append(section)
            faults += axis_faults + number_faults

    def in_words(faults: Sequence[Fault], lines: Mapping[KeyPath, int]) -> list[str]:
        return sentences(without_misspelt(faults), written_tables, lines, set_paths)

    return Draft(raw, sections, axes, numbers), faults, in_words


def overridden(tables: Mapping[str, Any], overrides: Sequence[str], source: str) -> dict[str, Any]:
    """The tables of a scene file with overrides applied, as they were written."""
    raw = copy.deepcopy(dict(tables))
    for text in overrides:
        override(raw, text, KNOWN, source)
    return raw


def _tables(raw: Mapping[str, Any], name: str) -> Iterator[tuple[KeyPath, Any]]:
    """The tables of a section, or the value in their place, with their paths."""
    value = raw.get(name)
    if name in ARRAYS and isinstance(value, list):
        yield from (((name, index), element) for index, element in enumerate(value))
    elif name in raw:
        # One table where an array of them belongs is none.
        yield (name,), [value] if name in ARRAYS and isinstance(value, dict) else value


def _with_files(section: Section, folder: Path) -> tuple[Section, list[Fault]]:
    """A section with the content of its files, such as a table of forces, in their place; and the files' faults."""
    settings, faults = dict(section.values), []
    for key, file_value in section.values.items():
        if not hasattr(file_value, "read"):
            continue
        try:
            settings[key] = file_value.read(folder)
        except Several as error:
            del settings[key]
            faults += [section.fault(key, sentence) for _, sentence in error.faults]
    return replace(section, values=settings), faults


def untouched(draft: Draft, overrides: Iterable[str]) -> Same:
    """The sections of a scene in which these overrides change nothing."""
    touched_sections = {text.partition("=")[0].partition(".")[0].strip(" \"'") for text in overrides}
    return {name: sections for name, sections in draft.sections.items() if name not in touched_sections}


def every_fault(draft: Draft, folder: Path, same: Same = MappingProxyType({})) -> list[Fault]:
    """Faults of more than one key; ``folder`` is that of the scene file, ``same`` as in `read_tables`."""
    return [
        *known_motion_checks(draft),
        *plan_checks(draft),
        *building_checks(draft.tables("building"), draft.count("building", 2)),
        *interface_checks(draft),
        *effect_checks(draft),
        *record_checks(draft),
        *uncertain_checks(draft),
        *damage_checks(draft.tables("damage"), [str(keys.get("name")) for keys in draft.tables("building")]),
        *(() if "records" in same else missing_files(draft.raw, folder)),
    ]


def _later_word_faults(raw: dict[str, Any]) -> list[Fault]:
    """Take the words of later versions out of the tables; one fault each."""
    faults = []
    for section, words in LATER.items():
        table = raw.get(section)
        if not isinstance(table, dict):
            continue
        for word in [key for key in table if key in words]:
            del table[word]
            faults.append(Fault((section, word), words[word]))
    return faults


def _unknown_key_sentence(table: KeyPath, key: str) -> str:
    """An unknown key of a table: what to write instead, the key that it misspells, its section, or all keys."""
    if advice := instead_of(key):
        return f"unknown key; {advice}"
    section = str(table[0])
    if meant := key_meant(key, KEYS[section]):
        return f'unknown key (did you mean "{meant}"?)'
    if section != "damage" and (hint := nearest(key, KNOWN[section], CLOSE)):
        return f"unknown key{hint}"
    home_sections = [_header(other) for other, keys in KEYS.items() if key in keys]
    if home_sections:
        return f"unknown key; it belongs in {' or '.join(home_sections)}"
    if section == "damage":
        return unknown_key(key)
    keys_text = ", ".join(KEYS[section]) or "no keys in this version"
    return f"unknown key{nearest(key, KNOWN[section])}; {_header(section)} takes {keys_text}"


def without_misspelt(faults: Sequence[Fault]) -> list[Fault]:
    """The faults, without those of a missing key that another fault says is there under a misspelt name."""
    misspelt = ((fault.path, MISSPELT.match(fault.sentence)) for fault in faults)
    meant_paths = {(*path[:-1], match[1]) for path, match in misspelt if match}
    return [fault for fault in faults if not (fault.absent and fault.path in meant_paths)]


def _header(section: str) -> str:
    return f"[[{section}]]" if section in ARRAYS else f"[{section}]"


def _not_a_table_sentence(path: KeyPath, value: Any) -> str:
    """A sentence on a value where a table, or an array of tables, should stand."""
    section = str(path[0])
    if section in ARRAYS and isinstance(value, list):
        return f"one table, where each {section} is a table of a list; write [[{section}]] with double brackets"
    return f"{shown(value)} is not a table; write {_header(section)} and its keys below"


def written_overrides(text: str, overrides: Sequence[str], source: str) -> str:
    """The text of a scene file with the values of overrides in their place, its comments kept."""
    import tomlkit  # only where a scene is written back

    document = tomlkit.parse(text)
    for assignment in overrides:
        override(document, assignment, KNOWN, source)
    return tomlkit.dumps(document)


def schema() -> dict[str, Any]:
    """JSON schema of a scene file, for the completion of an editor: keys, kinds, units and ranges, in words.

    ``x-unit``, ``x-range``, ``x-example`` and ``x-absent`` say what a JSON schema has no keyword for.

    Returns
    -------
    dict
        The schema, as `json.dumps` takes it.
    """
    all_keys = {**KEYS, **{name: kind.keys() for name, kind in INLINE.items()}}
    required = {"building": ["name"], "damage": ["name"], **{name: kind.required() for name, kind in INLINE.items()}}
    tables = {
        _table_name(section): {
            "type": "object",
            "properties": {name: key.described() for name, key in keys.items()},
            "required": required.get(section, []),
            "additionalProperties": False,
        }
        for section, keys in all_keys.items()
    }
    places: dict[str, dict[str, Any]] = {}
    for section in KEYS:
        reference = {"$ref": f"#/$defs/{_table_name(section)}"}
        place = {"type": "array", "items": reference} if section in ARRAYS else reference
        places[section] = {**place, "title": _header(section)}
    patterns = {"GridTable": NUMBERS_ALONG, "UncertainTable": DISTRIBUTION}
    return {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": "Scene of pounding_risk",
        "type": "object",
        "properties": places,
        "required": list(ABSENT),
        "additionalProperties": False,
        "$defs": tables
        | {name: {**tables[name], "patternProperties": {ADDRESS: entry}} for name, entry in patterns.items()},
    }


def _table_name(section: str) -> str:
    return f"{section.title().replace('_', '')}Table"
