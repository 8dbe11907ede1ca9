"""The words of a scene's keys: none is missing, every example is read, and what is said of a key left out is true."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import pytest
from pydantic import TypeAdapter

from pounding_risk.models.effects import EFFECTS
from pounding_risk.scene.reader import TABLES, EqualTermsTable, scene_schema
from pounding_risk.scene.words import KEYS, option_example

SECTIONS = {**{name: table for name, table in TABLES.items() if name != "effects"}, "equal_terms": EqualTermsTable}
ALL = [(section, key) for section, table in SECTIONS.items() for key in table.model_fields]


def value_of(text: str) -> Any:
    """A value as a scene file has it."""
    return tomllib.loads(f"x = {text}")["x"]


def read(section: str, key: str, text: str) -> Any:
    """The value of a key, by its own reader."""
    field = SECTIONS[section].model_fields[key]
    readers = [found for found in field.metadata if hasattr(found, "read")]
    return readers[0].read(value_of(text)) if readers else TypeAdapter(field.annotation).validate_python(value_of(text))


def test_every_key_has_words_and_no_other_has():
    assert {(section, key) for section, keys in KEYS.items() for key in keys} == set(ALL)


@pytest.mark.parametrize(("section", "key"), ALL)
def test_every_example_is_read(section, key):
    assert read(section, key, KEYS[section][key].example) is not None


@pytest.mark.parametrize(("section", "key"), ALL)
def test_a_value_told_for_a_key_left_out_is_the_one_that_holds(section, key):
    """Where a value is told: `"3500 m/s", concrete` tells one, `the file's name` does not."""
    told = KEYS[section][key].absent.partition(", ")[0]
    try:
        value_of(told)
    except tomllib.TOMLDecodeError:
        return
    assert read(section, key, told) == SECTIONS[section].model_fields[key].default


def test_keys_told_as_required_are_required():
    for section, key in ALL:
        assert SECTIONS[section].model_fields[key].is_required() == (KEYS[section][key].absent == "required"), key


def test_the_schema_has_the_words_units_and_ranges_and_is_strict_json():
    schema = scene_schema()
    json.dumps(schema, allow_nan=False)  # an infinite default is no JSON
    period = schema["$defs"]["BuildingTable"]["properties"]["period"]
    assert (period["x-unit"], period["x-range"]) == ("s", "at least 0.0001 s and finite")
    assert "stiffness" in period["description"]
    assert "default" not in period


def test_the_schema_has_the_options_of_every_effect():
    effects = scene_schema()["$defs"]["EffectsTable"]["properties"]
    for name, kind in EFFECTS.items():
        assert set(effects[name]["properties"]) == set(kind.options)
        assert set(effects[name]["required"]) == set(kind.options) - set(kind.optional)
    assert effects["wave_passage"]["properties"]["towards"]["enum"] == ["left", "right"]
    assert option_example(EFFECTS["strain_rate"].options["length"]) == '"0.6 m"'
