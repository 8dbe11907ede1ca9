"""The declarations of a scene's keys: every example is read, and what is said of a key left out is true."""

from __future__ import annotations

import json
import tomllib
from typing import Any

import jsonschema
import pytest

from pounding_risk.models.effects import EFFECTS
from pounding_risk.scene.buildings import KINDS as BUILDINGS
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.sections import KINDS
from pounding_risk.scene.sections import schema as scene_schema
from pounding_risk.scene.tables import option_example
from pounding_risk.units import parse

ONCE = [table for section, table in KINDS.items() if section not in ("building", "effects")]
TABLES = [*ONCE, *BUILDINGS, EqualTerms]
ALL = [(table, key) for table in TABLES for key in table.model_fields]


def value_of(text: str) -> Any:
    """A value as a scene file has it."""
    return tomllib.loads(f"x = {text}")["x"]


@pytest.mark.parametrize(("table", "name"), ALL)
def test_every_example_is_read_and_written_back(table, name):
    key = table.keys()[name]
    value = key.read(value_of(key.example), parse)
    assert value is not None and key.words
    written = key.write(value)
    assert key.read(written, parse) == value


@pytest.mark.parametrize(("table", "name"), ALL)
def test_a_value_told_for_a_key_left_out_is_the_one_that_holds(table, name):
    """Where a value is told: `"3500 m/s", concrete` tells one, `the file's name` does not."""
    key, about = table.keys()[name], table.model_fields[name]
    try:
        told = value_of(key.absent.partition(", ")[0])
    except tomllib.TOMLDecodeError:
        return
    if name != "rigid":  # which makes a wall of a building
        assert key.read(told, parse) == about.default


def test_keys_told_as_required_are_required():
    for table, name in ALL:
        if table.keys()[name].absent == "required":
            assert table.model_fields[name].is_required(), name


def test_a_key_that_is_required_says_what_to_write():
    for table, name in ALL:
        if table.model_fields[name].is_required():
            assert table.keys()[name].lacks(name).startswith("missing; write "), name


def test_the_schema_has_the_words_units_and_ranges_and_is_strict_json():
    schema = scene_schema()
    json.dumps(schema, allow_nan=False)
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


@pytest.mark.parametrize("name", ["paper", "row", "compare", "ensemble"])
def test_the_schema_takes_the_scenes_that_come_with_the_package(name, root):
    """By an independent implementation of JSON schema, as an editor has one."""
    jsonschema.Draft202012Validator.check_schema(scene_schema())
    scenes = sorted((root / "pounding_risk" / "scene" / "shipped").glob(f"{name}*.toml"))
    assert scenes
    for scene in scenes:
        jsonschema.validate(tomllib.loads(scene.read_text("utf-8")), scene_schema())


@pytest.mark.parametrize(
    "change",
    [{"building": 3}, {"grids": {}}, {"grid": {"gaps": ["1 mm"]}}, {"solver": {"rtol": True}}, {"effects": {"p": {}}}],
)
def test_the_schema_refuses_what_the_reader_refuses(change, root):
    scene = tomllib.loads((root / "pounding_risk" / "scene" / "shipped" / "row.toml").read_text("utf-8"))
    with pytest.raises(jsonschema.ValidationError):
        jsonschema.validate(scene | change, scene_schema())
