"""Every key of a scene: from a file into the scene and back, its faults, its schema, and what is said of it."""

import json
import tomllib
from copy import deepcopy
from dataclasses import fields
from pathlib import Path
from types import SimpleNamespace
from typing import Annotated, Any

import jsonschema
import pytest
import xarray as xr
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.demands import is_linear
from pounding_risk.errors import SceneError
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.structures.hysteresis import RULES, Hysteresis
from pounding_risk.results.attributes import LINEAR_OF_LINKS
from pounding_risk.results.variables import own_dims
from pounding_risk.scene.building_tables import OF_STOREYS, HysteresisTable, Isolation, PlanTable
from pounding_risk.scene.buildings import KINDS as BUILDING_KINDS
from pounding_risk.scene.buildings import (
    MatrixBuilding,
    ModalBuilding,
    RigidWall,
    ShearBuilding,
    SingleMass,
    TypologyBuilding,
    structure_of,
)
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.keys import measured
from pounding_risk.scene.not_modelled import BY_WORD, NAMES_ELSEWHERE, PAGE, SENTENCES
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.scene.sections import KEYS, KINDS
from pounding_risk.scene.sections import schema as scene_schema
from pounding_risk.scene.tables import option_example
from pounding_risk.units import MASS, parse

ONCE = [table for section, table in KINDS.items() if section not in ("building", "effects")]
TABLES = [*ONCE, *BUILDING_KINDS, EqualTerms, HysteresisTable, Isolation, PlanTable]
ALL = [(table, key) for table in TABLES for key in table.model_fields]


def value_of(text: str) -> Any:
    """A value as a scene file has it."""
    return tomllib.loads(f"x = {text}")["x"]


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
    "uncertain": {"samples": 4, "building.frame.period": SPREAD},
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
    TypologyBuilding: {
        "name": "frame",
        "height": "12 m",
        "storeys": 4,
        "typology": "masonry",
        "floor_mass": "90 t",
    },
    MatrixBuilding: {
        "name": "frame",
        "floor_masses": ["210 t", "210 t", "180 t"],
        "storey_heights": "3 m",
        "stiffness_matrix": {"values": [[300, -150, 0], [-150, 240, -90], [0, -90, 90]], "unit": "MN/m"},
    },
    ModalBuilding: {
        "name": "frame",
        "floor_masses": ["210 t"] * 3,
        "storey_heights": "3 m",
        "modes": "modes.csv",
    },
}
# What a key needs beside it, or in whose place it stands: None removes a key.
BESIDE: dict[str, dict[str, Any]] = {
    "building.stiffness": {"period": None},
    "building.wave_speed": {"floor_length": "20 m"},
    "building.storey_stiffnesses": {"storey_strengths": "2 MN"},
    "building.storey_strengths": {"storey_stiffnesses": "40 MN/m"},
    "building.along_rows": {"mass_matrix": {"file": "M.csv", "unit": "t"}, "floor_masses": None},
    "building.interior_modes": {
        "mass_matrix": {"file": "M.csv", "unit": "t"},
        "floor_masses": None,
        "floor_rows": [1, 3],
        "along_rows": [1, 2, 3],
    },
    "building.interior_masses": {"mass_matrix": {"file": "M.csv", "unit": "t"}, "floor_masses": ["210 t"] * 2},
    "interface.table": {"contact_model": "tabulated", "stiffness": None},
    "interface.bumper_length": {"gap": "60 mm"},
    "interface.design_penetration": {"contact_model": "bilinear", "restitution": 0.65},
    "effects.unloading_stiffness": {"permanent_set": {}},
    "records.place": {"names": None, "sites": "EventGrid.csv"},
    "grid.interface": {"gap": ["10 mm", "20 mm"]},
    "grid.zip": {"building.frame.mass": ["40 t", "50 t"], "building.frame.period": ["0.2 s", "0.3 s"]},
    "uncertain.correlations": {"building.masonry.period": SPREAD},
    "uncertain.points": {"samples": None, "building.frame.mass": SPREAD},
    "uncertain.numbers": {"building.frame.period": None},
}
SPRING, DAMPER = {"link_stiffness": "20 MN/m"}, {"link_damping": "2 MN s/m"}
BESIDE |= {f"interface.link_{key}": SPRING for key in ("at", "strength", "slack", "breaking_force")}
BESIDE |= {f"interface.link_{key}": DAMPER for key in ("exponent", "brace_stiffness")}
BESIDE |= {f"records.{key}": {"aftershock": "RSN753-000"} for key in ("pause", "aftershock_ratio")}
BESIDE |= {f"damage.{key}": {"drift": None, "contact_force": "2 MN"} for key in ("interface", "contact_point")}
BESIDE |= {f"records.{key}": {"names": None} for key in ("files", "set", "manifest", "sites", "generated")}
BESIDE |= {f"damage.{key}": {"drift": None} for key in KEYS["damage"] if "x-unit" in KEYS["damage"][key].schema}
# Values in place of a key's example, which differ from the default or fit this scene.
VALUES: dict[str, Any] = {
    "building.wave_speed": "3000 m/s",
    "building.damping": 0.07,
    "building.storeys": 3,
    "building.storey_stiffnesses": "45 MN/m",
    "building.floor_rows": [1, 2, 3],
    "building.along_rows": [1, 2, 3],
    "building.interior_modes": 1,
    "building.interior_masses": ["90 t"],
    "building.initial_displacement": "10 mm",
    "interface.contact": [{"left": "storey 1", "right": "storey 1"}],
    "interface.link_at": [{"left": "storey 1", "right": "storey 1"}],
    "grid.zip": [["building.frame.mass", "building.frame.period"]],
    "solver.rtol": 1e-7,
}
# Keys that a scene writes in other words: k follows from mass and period, storeys stand in their lists, scaled to their
# period, what a file has in place of the file, and numbers of [grid] and [uncertain] under their addresses.
OTHERWISE: dict[Any, set[str]] = {
    SingleMass: {"stiffness"},
    ShearBuilding: {"storeys", "period"},
    TypologyBuilding: {"typology", "floor_mass", "height", "period", "storeys"},
    MatrixBuilding: {
        "floor_rows",
        "along_rows",
        "interior_modes",
        "period",
        "stiffness_matrix",
        "damping_matrix",
        "mass_matrix",
    },
    ModalBuilding: {"modes", "residual_period", "period", "damping"},
    "grid": {"axes"},
    "uncertain": {"numbers"},
}


def declared() -> list[Any]:
    """Every key of every section, of each kind of building."""
    kinds = [(section, section, keys) for section, keys in KEYS.items() if section != "building"]
    kinds += [("building", kind, kind.keys()) for kind in BUILDING_KINDS]
    return [
        pytest.param(section, kind, key, id=f"{getattr(kind, '__name__', kind)}-{key}")
        for section, kind, keys in kinds
        for key in keys
        if key != "rigid" or kind is RigidWall  # by which a table is of this kind
    ]


@pytest.fixture
def folder(tmp_path) -> Path:
    """With the files that examples name."""
    histories = ("my/frame_RSN6.csv", "my/frame_RSN753.csv")
    for file in ("my/a.AT2", "my/other_station.AT2", "selected.csv", "EventGrid.csv", *histories):
        (tmp_path / file).parent.mkdir(exist_ok=True)
        (tmp_path / file).touch()
    (tmp_path / "K.csv").write_text("300,-150,0\n-150,240,-90\n0,-90,90\n")
    (tmp_path / "M.csv").write_text("190,20,0\n20,170,20\n0,20,160\n")
    (tmp_path / "C.csv").write_text("3,-1,0\n-1,3,-1\n0,-1,2\n")
    (tmp_path / "modes.csv").write_text("period [s],floor 1,floor 2,floor 3\n0.5,0.3,0.7,1\n")
    (tmp_path / "bumper.csv").write_text("penetration [mm],force [kN]\n0,0\n10,450\n")
    return tmp_path


def example(section: str, key: str) -> Any:
    """The value of a key in its scene."""
    return VALUES.get(f"{section}.{key}", value_of(KEYS[section][key].example))


def tables_with(section: str, kind: Any, key: str, value: Any) -> dict[str, Any]:
    """The tables of a scene that has a key with this value."""
    tables = deepcopy(BASE)
    tables["building"] = BUILDINGS[{"building": kind, "effects": ShearBuilding}.get(section, SingleMass)]
    table = tables[section] | BESIDE.get(f"{section}.{key}", {}) | {key: value}
    tables[section] = {name: value for name, value in table.items() if value is not None}
    tables |= {name: [tables[name]] for name in ("interface", "damage")}
    tables["building"] = [tables["building"], OTHER]
    if section != "uncertain":
        del tables["uncertain"]
    return tables


@pytest.mark.parametrize(("section", "kind", "key"), declared())
def test_every_key_goes_from_a_file_into_the_scene_and_back(section, kind, key, folder):
    """A key that a scene drops is in no `to_toml`: the example of each is read, written and read again."""
    value = example(section, key)
    study = scene_of(tables_with(section, kind, key, value), str(folder / "scene.toml"))
    assert parse_scene(study.to_toml(), study.source) == study
    written = study.resolved()[section]
    back = written[0] if isinstance(written, list) else written
    assert key in back or key in OTHERWISE.get(kind, ()), f"{key}: no to_toml() writes it"
    if section == "building" and key not in OTHERWISE.get(kind, ()):
        read = [KEYS[section][key].read(one, parse) for one in (value, back[key])]
        assert read[1] in (read[0], (read[0],) * len(study.buildings[0].heights)), f"{key}: another value comes back"


FAULTY = (True, "7 zorks", [[]], -1e300)
OF_ONE_KIND = list({one.values[::2]: one for one in declared()}.values())


@pytest.mark.parametrize(("section", "kind", "key"), OF_ONE_KIND)
def test_every_key_says_what_is_wrong_with_its_value(section, kind, key, folder, says):
    """A truth, a unit that nobody knows, a list in a list, and a number without a unit or far out of range."""
    told = []
    for value in FAULTY:
        try:
            scene_of(tables_with(section, kind, key, value), str(folder / "scene.toml"))
            told.append(f"{value!r}: taken")
        except SceneError as error:
            told += [fault for fault in error.faults if fault.startswith(f"{section}.") and f"{key}" in fault][:1]
    says(told)


def test_a_rule_of_hysteresis_says_what_it_is_for_and_its_parameters_are_keys():
    """One of another use would be no rule, a parameter without a key could not be given, and nobody told."""
    assert {rule.USE for rule in RULES.values()} == {"storey", "link"}
    common = {"rule", "backbone", "collapse_drift"}
    usual = {field.name: field.default for field in fields(Hysteresis) if field.name not in ("rule", "hardening")}
    assert {key: HysteresisTable.model_fields[key].default for key in usual} == usual
    taken = common.union(*(rule.OPTIONS for rule in OF_STOREYS.values()))
    assert taken == set(HysteresisTable.model_fields) == {"rule", *usual}


class Painted(RigidWall):
    """A building with a key that no structure has a field for."""

    paint: Annotated[float, measured(MASS, "Mass of its paint.", '"1 t"')] = 0.0


def test_a_key_that_a_structure_does_not_hold_is_no_silent_loss():
    assert "paint" in refusal(Painted.from_values({"name": "A", "paint": 1.0}).structure, kind=TypeError)
    with pytest.raises(TypeError, match=r"Painted in .*paint.*models/structures \(sdof.py, storeys.py\)"):
        structure_of(SimpleNamespace(kind=Painted, values={"name": "A", "paint": 1.0}))


class Mistaken(RigidWall):
    """A building whose structure fails for another reason than a key."""

    def structure(self) -> Any:
        return len(1.0)  # type: ignore[arg-type]


def test_another_mistake_in_a_structure_is_not_told_as_a_key_without_a_field():
    with pytest.raises(TypeError, match=r"^object of type 'float' has no len\(\)$"):
        structure_of(SimpleNamespace(kind=Mistaken, values={"name": "A"}))


# Keys under which the motion without contact is proportional to the ground motion, and that of contact alone.
PROPORTIONAL = {
    *("name", "rigid", "mass", "stiffness", "period", "damping", "height", "floor_depth", "floor_length", "wave_speed"),
    *("storeys", "floor_mass", "floor_masses", "storey_stiffnesses", "storey_heights", "damping_rule", "typology"),
    *("stiffness_matrix", "mass_matrix", "damping_matrix", "floor_rows", "along_rows", "modes", "residual_period"),
    *("interior_modes", "interior_masses", "plan", "ground_delay", "ground_factor", "ground_record"),
    *(
        "gap",
        "contact_model",
        "restitution",
        "yield_force",
        "column_yield_force",
        "column_strength",
        "contact",
        "table",
    ),
    *("tolerance", "design_penetration", "equal_terms", "plastic_exponent", *LINEAR_OF_LINKS),
}
BY_AN_EFFECT = {"storey_strengths", "hysteresis"}  # of inelastic_storeys, without which they have no effect


def test_every_key_of_a_building_or_interface_is_known_to_be_linear_or_not():
    """A new key is nonlinear until it stands above: fragilities from one amplitude would otherwise be wrong unseen."""
    for section, kinds in (("building", BUILDING_KINDS), ("interface", [KINDS["interface"]])):
        for key in {key for kind in kinds for key in kind.key_names()} - PROPORTIONAL - BY_AN_EFFECT:
            bumper = {"interface_bumper": ("interface", [0.04])} if key == "bumper_length" else {}
            scene = {section: [{"name": "A", key: 1.0}]}
            assert not is_linear(SimpleNamespace(dataset=xr.Dataset(coords=bumper), scene=scene)), key


def test_a_key_is_declared_once():
    """From the declaration follow reader, signature, docstring, the schema and the tables of the docs."""
    assert "paint : float or str, optional" in (Painted.__doc__ or "")
    described = scene_schema()["$defs"]
    for section, keys in KEYS.items():
        name = f"{section.title()}Table"
        assert list(described[name]["properties"]) == list(keys), section


@pytest.mark.parametrize(("table", "name"), ALL)
def test_what_is_said_of_a_key_holds(table, name):
    """Its example is read and written back; a value told for a key left out holds: "the file's name" tells none."""
    key, about = table.keys()[name], table.model_fields[name]
    value = key.read(value_of(key.example), parse)
    assert value is not None and key.words
    assert key.read(key.write(value), parse) == value
    assert about.is_required() or key.absent != "required"
    if about.is_required():
        assert key.lacks(name).startswith("missing; write ")
    try:
        told = value_of(key.absent.partition(", ")[0])
    except tomllib.TOMLDecodeError:
        return
    if name != "rigid":  # which makes a wall of a building
        assert key.read(told, parse) == about.default


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
@pytest.mark.complete
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


def test_an_output_without_a_row_is_refused_by_the_file_that_has_the_rows():
    with pytest.raises(LookupError, match=r"floor_noise: VARIABLES in pounding_risk/results/variables.py has no row"):
        own_dims("floor_noise")


# ------------------------------------------------------------------------------------------------ what is not modelled

PAIR = scene_text(single("A", "44 t", "0.2 s"), single("B", "80 t", "0.1 s"), gap="2 mm")


def test_no_word_is_a_key_of_a_scene_and_each_stands_once():
    of_links = {"link_stiffness", "link_damping", "link_at"}  # of interfaces, which are looked for in buildings
    assert set(BY_WORD) & {key for keys in KEYS.values() for key in keys} == of_links
    assert len(BY_WORD) == sum(len(words.split()) for words in SENTENCES)


def test_each_other_name_of_a_key_means_one_key_and_is_none_of_its_section():
    names = [name for group in NAMES_ELSEWHERE.values() for name in group.split()]
    assert len(names) == len(set(names))
    assert not set(names) & set(BY_WORD)
    for key, group in NAMES_ELSEWHERE.items():
        sections = [keys for keys in KEYS.values() if key in keys]
        assert sections
        assert not any(name in keys for keys in sections for name in group.split())


@pytest.mark.parametrize(
    "word",
    ["link_force", "time_history", "matrix", "mode_shapes", "Torsion", "isolators", "moat", "restrainer", "rubber"],
)
@pytest.mark.parametrize("where", ["building.A", "interface", "effects"])
def test_a_key_outside_the_model_gets_its_substitute_and_no_false_friend(where, word):
    told = refusal(parse_scene, PAIR, overrides=[f"{where}.{word}=1.0"])
    assert f"{where}.{word}: unknown key; {BY_WORD[word.lower()]} ({PAGE})" in told
    assert "did you mean" not in told


def test_sections_and_words_of_python_get_it_too(says):
    says(refusal(parse_scene, f"{PAIR}\n[dampers]\ncount = 2\n"))
    says(refusal(pr.SingleMass, "A", "44 t", "0.2 s", link_stiffness=1.0, dampers=1.0))
