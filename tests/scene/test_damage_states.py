"""The [[damage]] tables of a scene: what is read and written, what is refused, and that no run depends on them."""

import tomllib

import pytest
from scenes import PAIR, damage_text, scene_text
from sentences import refusal

import pounding_risk as pr
from pounding_risk.ensemble.identity import difference, identity
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.scene.damage import DEMANDS, read_states
from pounding_risk.scene.reader import parse_scene
from pounding_risk.units import STANDARD_GRAVITY

STATES = damage_text(
    {
        "slight": {"building": "left", "drift": "0.5 %"},
        "falling ceiling": {"acceleration": "0.9 g"},
        "struck": {"interface": "left | right", "contact_force": "2 MN"},
    }
)
SCENE = scene_text(*PAIR)
NAMES = ["left", "right"]


def test_states_are_read_in_si_and_said_in_words(says):
    study = parse_scene(SCENE + STATES)
    assert [state.name for state in study.damage] == ["slight", "falling ceiling", "struck"]
    assert [state.threshold for state in study.damage] == [0.005, 0.9 * STANDARD_GRAVITY, 2e6]
    first = read_states([{"name": "x", "building": "left", "storey": 2, "ductility": 3}], NAMES)[0]
    says([state.words for state in (*study.damage, first)])


def test_a_scene_keeps_its_states():
    study = parse_scene(SCENE + STATES)
    again = parse_scene(study.to_toml())
    assert again.damage == study.damage and again == study
    assert study.replace(gap="30 mm").damage == study.damage
    changed = parse_scene(SCENE + STATES, overrides=['damage.slight.drift="1 %"'])
    assert [state.threshold for state in changed.damage[:2]] == [0.01, study.damage[1].threshold]
    assert 'drift="1 %"' in changed.to_toml(as_written=True).replace(" = ", "=")


def test_a_scene_in_python_has_the_same_states(says):
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
    says(refusal(pr.DamageState, "slight", drift=0.5))


def test_no_run_depends_on_a_state():
    """A scan goes on, and its file is replaced, under other states."""
    first, second = (ScanInput(parse_scene(text), (), True, 0.0) for text in (SCENE, SCENE + STATES))
    assert difference(identity(first), identity(second)) == []
    assert first.study == second.study


def test_states_of_a_file_or_a_text_are_those_of_a_scene(tmp_path, says):
    file = tmp_path / "states.toml"
    file.write_text(STATES, encoding="utf-8")
    expected = parse_scene(SCENE + STATES).damage
    assert (
        read_states(file, NAMES) == read_states(STATES, NAMES) == read_states(tomllib.loads(STATES), NAMES) == expected
    )
    file.write_text(STATES.replace('"left"', '"lefty"', 1) + "[damages]\n", encoding="utf-8")
    says(refusal(read_states, str(file), NAMES))


REFUSED = {
    "an unknown building": 'building = "lft"\ndrift = "1 %"',
    "an unknown interface": 'interface = "left"\ncontact_force = "1 N"',
    "two thresholds": 'drift = "1 %"\nductility = 2',
    "no threshold": "",
    "a drift of an interface": 'drift = "1 %"\ninterface = "left | right"',
    "a contact force of a storey": 'contact_force = "1 MN"\nstorey = 1',
    "a drift out of range": "drift = 0.5",
    "a displacement in percent": 'displacement = "3 %"',
    "an acceleration in m": 'acceleration = "3 m"',
    "an unknown key": 'drif = "1 %"',
    "a force on a column": 'column_force = "400 kN"',
    "storey 0": 'storey = 0\ndrift = "1 %"',
    "two of one name": 'drift = "1 %"\n[[damage]]\nname = "x"\ndrift = "2 %"',
}


@pytest.mark.parametrize("case", REFUSED)
def test_what_is_no_state_is_refused_with_its_repair(case, says):
    text = f'[[damage]]\nname = "x"\n{REFUSED[case]}\n'
    says(refusal(parse_scene, SCENE + text), refusal(read_states, text, NAMES))


def test_tables_are_needed_and_a_threshold_is_no_axis(says):
    says([refusal(read_states, nothing, NAMES) for nothing in ({}, [], "x = 1\n", {"damage": 3})])
    says(refusal(parse_scene, SCENE + '[grid]\n"damage.slight.drift" = ["1 %", "2 %"]\n' + STATES))


def test_every_demand_is_a_key_with_its_unit():
    keys = pr.DamageState.keys()
    for demand in DEMANDS:
        assert keys[demand.key].schema["x-unit"] == demand.quantity.unit
        assert [bool(demand.interfaces), bool(demand.storeys), bool(demand.links)].count(True) == 1
