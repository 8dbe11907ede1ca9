"""The [[damage]] tables of a scene: what is read and written, what is refused, and that no run depends on them."""

from __future__ import annotations

import tomllib

import pytest
from scenes import PAIR, scene_text

import pounding_risk as pr
from pounding_risk.ensemble.identity import difference, identity
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.errors import SceneError
from pounding_risk.scene.damage import DEMANDS, read_states
from pounding_risk.scene.reader import parse_scene
from pounding_risk.units import STANDARD_GRAVITY

STATES = """
[[damage]]
name = "slight"
building = "left"
drift = "0.5 %"

[[damage]]
name = "falling ceiling"
acceleration = "0.9 g"

[[damage]]
name = "struck"
interface = "left | right"
contact_force = "2 MN"
"""
SCENE = scene_text(*PAIR)
NAMES = ["left", "right"]


def test_states_are_read_in_si_and_said_in_words():
    study = parse_scene(SCENE + STATES)
    assert [state.name for state in study.damage] == ["slight", "falling ceiling", "struck"]
    assert [state.threshold for state in study.damage] == [0.005, 0.9 * STANDARD_GRAVITY, 2e6]
    assert [state.words for state in study.damage] == [
        "storey drift of left ≥ 0.5 %",
        "floor acceleration ≥ 0.9 g",
        "contact force at left | right ≥ 2000 kN",
    ]
    first = read_states([{"name": "x", "building": "left", "storey": 2, "ductility": 3}], NAMES)[0]
    assert first.words == "ductility of storey 2 of left ≥ 3"


def test_a_scene_keeps_its_states():
    study = parse_scene(SCENE + STATES)
    again = parse_scene(study.to_toml())
    assert again.damage == study.damage and again == study
    assert study.replace(gap="30 mm").damage == study.damage
    changed = parse_scene(SCENE + STATES, overrides=['damage.slight.drift="1 %"'])
    assert [state.threshold for state in changed.damage[:2]] == [0.01, study.damage[1].threshold]
    assert 'drift="1 %"' in changed.to_toml(as_written=True).replace(" = ", "=")


def test_a_scene_in_python_has_the_same_states():
    written = parse_scene(SCENE + STATES)
    states = [
        pr.DamageState("slight", building="left", drift=0.005),
        {"name": "falling ceiling", "acceleration": "0.9 g"},
        {"name": "struck", "interface": "left | right", "contact_force": 2e6},
    ]
    made = pr.Scene(written.buildings, written.interfaces, pr.Records(["RSN6-180"]), damage=states)
    assert made.damage == written.damage
    assert written.replace(damage=states[:1]).damage == written.damage[:1]
    assert read_states(states, NAMES) == written.damage
    with pytest.raises(SceneError, match=r"drift: 0.5 is out of range.*less than 0.3"):
        pr.DamageState("slight", drift=0.5)


def test_no_run_depends_on_a_state():
    """A scan goes on, and its file is replaced, under other states."""
    first, second = (ScanInput(parse_scene(text), (), True, 0.0) for text in (SCENE, SCENE + STATES))
    assert difference(identity(first), identity(second)) == []
    assert first.study == second.study


def test_states_of_a_file_or_a_text_are_those_of_a_scene(tmp_path):
    file = tmp_path / "states.toml"
    file.write_text(STATES, encoding="utf-8")
    expected = parse_scene(SCENE + STATES).damage
    assert (
        read_states(file, NAMES) == read_states(STATES, NAMES) == read_states(tomllib.loads(STATES), NAMES) == expected
    )
    file.write_text(STATES.replace('"left"', '"lefty"', 1) + "[damages]\n", encoding="utf-8")
    with pytest.raises(SceneError) as told:
        read_states(str(file), NAMES)
    assert str(told.value).splitlines() == [
        f"{file}: 2 faults",
        '  - line 4, damage.slight.building: "lefty" is no building of the scene (did you mean "left"?); it has left, '
        "right",
        '  - line 15, damages: unknown section (did you mean "damage"?); a file of states has [[damage]] tables alone',
    ]


REFUSED = [
    ('building = "lft"\ndrift = "1 %"', r'building: "lft" is no building of the scene \(did you mean "left"\?\)'),
    ('interface = "left"\ncontact_force = "1 N"', r'interface: "left" is no interface of the scene; it has left \| r'),
    ('drift = "1 %"\nductility = 2', "ductility: drift and ductility are both given, and a state is reached by one"),
    ("", r'damage.x: has no threshold; write drift = "0.5 %", or another of drift, residual_drift'),
    ('drift = "1 %"\ninterface = "left | right"', "interface: drift is no demand on an interface; write building or"),
    ('contact_force = "1 MN"\nstorey = 1', "storey: contact_force is no demand on a storey; write interface or"),
    ("drift = 0.5", "drift: 0.5 is out of range: a storey drift ratio must be greater than 0 and less than 0.3"),
    ('displacement = "3 %"', "displacement: .* is a percentage, not a length"),
    ('acceleration = "3 m"', "acceleration: .* is a length, not an acceleration"),
    ('drif = "1 %"', r'drif: unknown key \(did you mean "drift"\?\); \[\[damage\]\] takes name, building'),
    ('storey = 0\ndrift = "1 %"', "storey: 0 is not the number of a storey; write a whole number from 1, the lowest"),
]


@pytest.mark.parametrize(("keys", "words"), REFUSED)
def test_what_is_no_state_is_refused_with_its_repair(keys, words):
    text = f'[[damage]]\nname = "x"\n{keys}\n'
    with pytest.raises(SceneError, match=words):
        parse_scene(SCENE + text)
    with pytest.raises(SceneError, match=words):
        read_states(text, NAMES)


def test_names_are_told_apart_and_tables_are_needed():
    with pytest.raises(SceneError, match=r'damage.2.name: "x" is the name of state 1 too; give every state a name'):
        parse_scene(SCENE + '[[damage]]\nname = "x"\ndrift = "1 %"\n' * 2)
    for nothing in ({}, [], "x = 1\n", {"damage": 3}):
        with pytest.raises(SceneError, match=r'damage: has no tables; write \[\[damage\]\] with name = "slight"'):
            read_states(nothing, NAMES)


def test_a_threshold_is_no_axis():
    grid = '[grid]\n"damage.slight.drift" = ["1 %", "2 %"]\n'
    with pytest.raises(SceneError, match="an axis is of one of building, interface, effects"):
        parse_scene(SCENE + grid + STATES)


def test_every_demand_is_a_key_with_its_unit():
    keys = pr.DamageState.keys()
    for demand in DEMANDS:
        assert keys[demand.key].schema["x-unit"] == demand.quantity.unit
        assert bool(demand.interfaces) != bool(demand.storeys)
