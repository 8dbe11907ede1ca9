"""Traps for who adds a key or an output: each declaration reaches what is made of it, or its file is named."""

from __future__ import annotations

import tomllib
from copy import deepcopy
from typing import Annotated, Any

import pytest

from pounding_risk.results.variables import VARIABLES
from pounding_risk.scene.buildings import KINDS, RigidWall, ShearBuilding, SingleMass, TypologyBuilding
from pounding_risk.scene.keys import measured
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.scene.sections import KEYS, schema
from pounding_risk.solver.pair.outputs import BUILDING, RUN
from pounding_risk.units import MASS, parse

SPREAD = {"distribution": "lognormal", "dispersion": 0.2}
OTHER = {"name": "masonry", "mass": "80 t", "period": "0.1 s", "height": "9 m"}
BASE: dict[str, Any] = {
    "scene": {},
    "building": {},
    "interface": {"gap": "20 mm", "contact_model": "van_mier", "stiffness": "2.7e10 N/m^1.5", "restitution": 0.65},
    "effects": {},
    "records": {"names": ["RSN6-180"]},
    "grid": {},
    "solver": {},
    "uncertain": {"building.frame.period": SPREAD},
    "damage": {"name": "slight", "drift": "0.5 %"},
}
BUILDINGS: dict[Any, dict[str, Any]] = {
    SingleMass: {"name": "frame", "mass": "44 t", "period": "0.2 s"},
    RigidWall: {"name": "frame", "rigid": True},
    ShearBuilding: {
        "name": "frame",
        "floor_masses": ["44 t"] * 3,
        "storey_stiffnesses": "40 MN/m",
        "storey_heights": "3 m",
        "storey_strengths": "2 MN",
    },
    TypologyBuilding: {"name": "frame", "height": "12 m", "storeys": 4, "typology": "masonry", "floor_mass": "90 t"},
}
# What a key needs beside it, or in whose place it stands: None removes a key.
BESIDE: dict[str, dict[str, Any]] = {
    "building.stiffness": {"period": None},
    "building.wave_speed": {"floor_length": "20 m"},
    "interface.table": {"contact_model": "tabulated", "stiffness": None},
    "interface.design_penetration": {"contact_model": "bilinear", "restitution": 0.65},
    "effects.unloading_stiffness": {"permanent_set": {}},
    "records.place": {"names": None, "sites": "EventGrid.csv"},
    "grid.interface": {"gap": ["10 mm", "20 mm"]},
    "grid.zip": {"building.frame.mass": ["40 t", "50 t"], "building.frame.period": ["0.2 s", "0.3 s"]},
    "uncertain.correlations": {"building.masonry.period": SPREAD},
    "uncertain.points": {"building.frame.mass": SPREAD},
    "uncertain.numbers": {"building.frame.period": None},
    "damage.interface": {"drift": None, "contact_force": "2 MN"},
    "damage.contact_point": {"drift": None, "contact_force": "2 MN"},
}

BESIDE |= {f"records.{key}": {"names": None} for key in ("files", "set", "manifest", "sites", "generated")}
BESIDE |= {f"damage.{key}": {"drift": None} for key in KEYS["damage"] if "x-unit" in KEYS["damage"][key].schema}
# Values in place of a key's example, which differ from the default or fit this scene.
VALUES: dict[str, Any] = {
    "building.wave_speed": "3000 m/s",
    "building.damping": 0.07,
    "building.storeys": 3,
    "building.initial_displacement": "10 mm",
    "interface.contact": [{"left": "storey 1", "right": "storey 1"}],
    "grid.zip": [["building.frame.mass", "building.frame.period"]],
    "solver.rtol": 1e-7,
}
# Keys that a scene writes in other words: k follows from mass and period, storeys stand in their lists, and numbers of
# [grid] and [uncertain] under their addresses.
OTHERWISE: dict[Any, set[str]] = {
    SingleMass: {"stiffness"},
    ShearBuilding: {"storeys"},
    TypologyBuilding: {"typology", "floor_mass", "height", "period", "storeys"},
    "grid": {"axes"},
    "uncertain": {"numbers"},
}


def declared() -> list[Any]:
    """Every key of every section, of each kind of building."""
    kinds = [(section, section, keys) for section, keys in KEYS.items() if section != "building"]
    kinds += [("building", kind, kind.keys()) for kind in KINDS]
    return [
        pytest.param(section, kind, key, id=f"{getattr(kind, '__name__', kind)}-{key}")
        for section, kind, keys in kinds
        for key in keys
        if key != "rigid" or kind is RigidWall  # by which a table is of this kind
    ]


@pytest.mark.parametrize(("section", "kind", "key"), declared())
def test_every_key_goes_from_a_file_into_the_scene_and_back(section, kind, key, tmp_path):
    """A key that a scene drops is in no `to_toml`: the example of each is read, written and read again."""
    for file in ("my/a.AT2", "my/other_station.AT2", "selected.csv", "EventGrid.csv"):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    (tmp_path / "bumper.csv").write_text("penetration [mm],force [kN]\n0,0\n10,450\n")
    address, tables = f"{section}.{key}", deepcopy(BASE)
    tables["building"] = BUILDINGS[{"building": kind, "effects": ShearBuilding}.get(section, SingleMass)]
    example = VALUES.get(address, tomllib.loads(f"value = {KEYS[section][key].example}")["value"])
    table = tables[section] | BESIDE.get(address, {}) | {key: example}
    tables[section] = {name: value for name, value in table.items() if value is not None}
    tables |= {name: [tables[name]] for name in ("interface", "damage")}
    tables["building"] = [tables["building"], OTHER]
    if section != "uncertain":
        del tables["uncertain"]
    study = scene_of(tables, str(tmp_path / "scene.toml"))
    assert parse_scene(study.to_toml(), study.source) == study
    written = study.resolved()[section]
    back = written[0] if isinstance(written, list) else written
    assert key in back or key in OTHERWISE.get(kind, ()), f"{key}: no to_toml() writes it"
    if section == "building" and key not in OTHERWISE.get(kind, ()):
        read = [KEYS[section][key].read(value, parse) for value in (example, back[key])]
        assert read[1] in (read[0], (read[0],) * len(study.buildings[0].heights)), f"{key}: another value comes back"


class Painted(RigidWall):
    """A building with a key that no structure has a field for."""

    paint: Annotated[float, measured(MASS, "Mass of its paint.", '"1 t"')] = 0.0


def test_a_key_that_a_structure_does_not_hold_is_no_silent_loss():
    with pytest.raises(TypeError, match="paint"):
        Painted.from_values({"name": "A", "paint": 1.0}).structure()


def test_a_key_is_declared_once():
    """From the declaration follow reader, signature, docstring, the schema and the tables of the docs."""
    assert "paint : float or str, optional" in (Painted.__doc__ or "")
    described = schema()["$defs"]
    for section, keys in KEYS.items():
        name = f"{section.title()}Table"
        assert list(described[name]["properties"]) == list(keys), section


def test_every_output_of_a_run_has_its_place_in_a_dataset():
    """One without a row would end in a KeyError where datasets are laid out."""
    for name in {*RUN, *BUILDING}:
        assert name in VARIABLES, f"{name}: declare its dimensions and unit in pounding_risk/results/variables.py"
