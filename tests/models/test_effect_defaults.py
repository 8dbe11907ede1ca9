"""Defaults of effects are told wherever an option is: in keys, in `models`, in `validate`, in the resolved scene."""

from __future__ import annotations

import inspect
from math import isnan

import pytest
from scenes import scene_text, single, storeyed
from typer.testing import CliRunner

from pounding_risk.cli import app
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.models import effects
from pounding_risk.models._discovery import modules_in_order
from pounding_risk.models.effects import EFFECTS, default_example, default_words, defaults
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.sections import schema as scene_schema

ROW = scene_text(
    storeyed("A", ["40 t", "40 t"], "60 MN/m", storey_strengths="200 kN"),
    single("B", "60 t", "0.2 s"),
    gap="2 mm",
    records={"window": ["0 s", "2 s"]},
)
OPTIONS = [(name, option) for name, kind in EFFECTS.items() for option in kind.optional]


def test_every_module_of_the_folder_holds_one_effect():
    """In the order in which effects act, that of the modules' ORDER."""
    modules = modules_in_order(effects.__name__)
    assert [EFFECTS[name].__module__ for name in EFFECTS] == [module.__name__ for module in modules]
    assert all(hasattr(module, "ORDER") for module in modules)


@pytest.mark.parametrize(("name", "option"), OPTIONS)
def test_every_option_that_may_be_left_out_has_its_default_told(name, option):
    """The signature of the effect itself is the oracle."""
    default = inspect.signature(EFFECTS[name].on).parameters[option].default
    assert default is not inspect.Parameter.empty
    if isinstance(default, float) and isnan(default):
        assert default_words(name, option) == EFFECTS[name].absent[option]
        assert option not in defaults(name)
    else:
        assert defaults(name)[option] == default
    listed = CliRunner().invoke(app, ["models"]).output
    assert f"= {default_words(name, option)}"[:12] in listed
    keys = scene_schema()["$defs"]["EffectsTable"]["properties"][name]
    assert keys["properties"][option]["x-absent"] == default_example(name, option)
    assert f"{option} left out: {default_example(name, option)}" in keys["x-absent"]


def test_an_empty_table_states_its_hardening():
    study = parse_scene(ROW, "scene.toml", ["effects.inelastic_storeys={}"])
    assert study.resolved()["effects"] == {"inelastic_storeys": {"hardening": 0.03}}
    assert ("effect", "inelastic_storeys: hardening 0.03 (default)") in validate(study).summary()
    # Told or not, the scene is the same one.
    assert study == parse_scene(ROW, "scene.toml", ["effects.inelastic_storeys.hardening=0.03"])


def test_what_the_scene_gives_is_not_marked():
    soil = 'effects.soil_flexibility={shear_wave_velocity="200 m/s", radius="8 m", poisson=0.4}'
    (words,) = [words for what, words in validate(parse_scene(ROW, "scene.toml", [soil])).summary() if what == "effect"]
    assert "poisson 0.4," in words
    assert "density 1800 kg/m^3 (default)" in words
    assert "foundation_mass the mass of the lowest floor (default)" in words
