"""Axes of numbers in [grid]: how they are read, refused and written, and that `--set` of their key ends them."""

import re

import numpy as np
import pytest
from axes import AXES, pair_text
from scenes import FRAME, PAIR, rigid, scene_text, single
from sentences import refusal

from pounding_risk.scene.buildings import SingleMass
from pounding_risk.scene.interfaces import Interface
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.records import Records
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.scene_axis import SceneAxis, labels_of
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.variants import Variants

UNEQUAL = {"building.left.mass": ["5 t"], "building.left.period": ["1 s", "2 s"]}
UNEQUAL |= {"zip": [[*UNEQUAL]]}
PERIODS = SceneAxis(("building.left.period",), (("0.3 s", "0.5 s", "0.7 s"),))


def refused(axes, **more):
    return refusal(parse_scene, pair_text(axes, **more))


def test_a_range_and_a_list_are_read_into_si():
    study = parse_scene(pair_text(AXES))
    assert PERIODS in study.axes
    assert SceneAxis(("building.left.mass",), (("500000.0 kg", "600000.0 kg"),)) in study.axes
    assert Variants(study).count == 12


def test_dotted_keys_without_quotes_are_the_same_axis():
    text = pair_text({}) + '\nbuilding.left.period = {start = "0.3 s", stop = "0.7 s", num = 3}\n'
    assert parse_scene(text).axes == (PERIODS,)
    assert parse_scene(pair_text({}), overrides=['grid.building.left.period=["0.3 s", "0.5 s", "0.7 s"]']).axes == (
        PERIODS,
    )


def test_a_scene_with_axes_is_written_and_read_back():
    study = parse_scene(pair_text(AXES | {"zip": []}))
    assert parse_scene(study.to_toml()) == study
    together = {"interface.restitution": [0.5, 0.6], "building.left.mass": ["500 t", "600 t"]}
    study = parse_scene(pair_text(together | {"zip": [["building.left.mass", "interface.restitution"]]}))
    assert [axis.keys for axis in study.axes] == [("building.left.mass", "interface.restitution")]
    assert parse_scene(study.to_toml()) == study != parse_scene(pair_text(together))


def test_a_key_that_is_set_is_no_axis_any_more(says):
    """By any spelling of its address; the others stay."""
    for address in ("building.left.period", "building.1.period", "building.period"):
        study = parse_scene(pair_text(AXES), overrides=[f'{address}="0.4 s"'])
        assert [axis.name for axis in study.axes] == ["interface.restitution", "building.left.mass"]
        assert study.buildings[0].period == 0.4
    both = pair_text({"building.period": ["0.3 s", "0.4 s"]})
    assert [one.period for one in Variants(parse_scene(both)).scene(1).buildings] == [0.4, 0.4]
    says(refusal(parse_scene, both, overrides=['building.left.period="0.4 s"']))
    assert parse_scene(pair_text(AXES)).replace('building.left.period="0.4 s"').buildings[0].period == 0.4


def test_python_gives_numbers_in_si_and_arrays():
    buildings = [SingleMass("left", 5e5, 0.5), SingleMass("right", 8e5, 1.0)]
    axes = {
        "building.left.period": np.linspace(0.3, 0.7, 3),
        "interface.restitution": {"start": 0.5, "stop": 0.7, "num": 2},
    }
    between = Interface("10 mm", "jankowski", stiffness="2.75e9 N/m^1.5", restitution=0.65)
    study = Scene(buildings, [between], Records(names=["RSN6-180"]), grid=Grid(gap=[0.01], axes=axes))
    assert study.axes == (PERIODS, SceneAxis(("interface.restitution",), ((0.5, 0.7),)))
    assert study.replace(axes={"building.left.mass": [4e5, 5e5]}).axes[-1].values == (("400000.0 kg", "500000.0 kg"),)
    zipped = study.replace(
        zip=[["building.left.period", "building.right.period"]], axes={"building.right.period": [1.0, 1.5, 2.0]}
    )
    assert zipped.axes[0].keys == ("building.left.period", "building.right.period")


def test_labels_have_units_and_texts_stay():
    assert labels_of(("0.5 m/s^2", "inf")) == ((0.5, np.inf), "m/s2")
    assert labels_of((0.5, 1)) == ((0.5, 1.0), "1")
    assert labels_of(("concrete", "0.5")) == (("concrete", "0.5"), None)


def test_a_faulty_value_is_told_in_the_words_of_set():
    for key, values in (
        ("building.left.period", ["0.3 s", "-1 s"]),
        ("building.left.mass", ["5 t", 3]),
        ("building.left.perod", [1]),
    ):
        shown = values[-1] if not isinstance(values[-1], str) else f'"{values[-1]}"'
        alone = refusal(parse_scene, pair_text({}), overrides=[f"{key}={shown}"])
        told = refused({key: values})
        assert f"grid.{key}.{len(values)}: " in told and told.endswith(alone.partition(f"--set {key}: ")[2]), told


def test_the_gap_of_one_interface_of_a_row_is_told_the_whole_repair():
    """Which the reader then takes: gap in [grid] alone would vary every gap."""
    row = [single(name, "20 t", "0.5 s") for name in "ABC"]
    text = scene_text(*row, gap="5 mm", grid={"interface.1.gap": ["10 mm", "20 mm"]})
    interface = re.search(r"\[\[interface\]\][^[]*", text)[0]
    told = refusal(parse_scene, text.replace(interface, 2 * interface))
    assert told.endswith('write gap = [...] in [grid] instead, with interface = "A | B" beside it')
    repaired = parse_scene(scene_text(*row, gap="5 mm", grid={"gap": ["10 mm", "20 mm"], "interface": "A | B"}))
    assert [repaired.interface_gaps(gap) for gap in repaired.grid.gaps] == [(0.01, 0.005), (0.02, 0.005)]


def test_an_interface_is_named_by_its_buildings_with_quotes_and_without():
    """As [grid] interface has it; the names have spaces, for which TOML asks quotes within the quotes."""
    table = {"gap": "20 mm", "bumper_length": "5 mm", "contact_model": "linear", "stiffness": "1e5 kN/m"}
    row = scene_text(*PAIR, rigid(), interfaces=[table, table])
    for address in ('"interface.left | right.bumper_length"', "\"interface.'left | right'.bumper_length\""):
        (axis,) = parse_scene(f'{row}[grid]\n{address} = ["2 mm", "8 mm"]\n').axes
        assert axis.name == 'interface."left | right".bumper_length'
        told = refusal(parse_scene, f'{row}[grid]\n{address} = ["2 mm", "30 mm"]\n')
        assert "30 mm do not fit into a gap of 20 mm" in told and "--set" not in told
    study = parse_scene(row, overrides=["interface.left | right.bumper_length=3 mm"])
    assert [between.bumper_length for between in study.interfaces] == [0.003, 0.005]
    alone = scene_text(*PAIR, rigid(), bumper_length="5 mm")
    told = refusal(parse_scene, f'{alone}[grid]\n"interface.left | right.bumper_length" = ["2 mm"]\n')
    assert 'the only [[interface]] is that of all neighbours; write one for each, or leave out "left | right"' in told


SAME = {"building.left.mass": ["5 t"]}
REFUSED = {
    "of records": {"records.scale": [1, 2]},
    "of the solver": {"solver.rtol": [1e-6]},
    "of an unknown building": {"building.lef.mass": ["5 t"]},
    "of no section": {"foo.bar": [1]},
    "no list": {"building.left.mass": "5 t"},
    "no value": {"building.left.mass": []},
    "a value twice": {"building.left.mass": ["5 t", "5000 kg"]},
    "lists in a list": {"building.left.mass": [["5 t"]]},
    "of names": {"building.left.name": ["a", "b"]},
    "of contact models": {"interface.contact_model": ["hertz_damp"]},
    "of the gap beside the grid's": {"interface.gap": ["1 mm", "2 mm"]},
    "two of one key": SAME | {"building.1.mass": ["6 t"]},
    "together and none": {"zip": [["building.left.mass", "building.left.period"]]},
    "together and no list": {"zip": 3},
    "one together": SAME | {"zip": [["building.left.mass"]]},
    "of unequal lengths together": UNEQUAL,
    "downward": {"building.left.mass": {"start": "5 t", "stop": "1 t", "num": 3}},
    "of a name with a slash": {'building."a/b".mass': ["5 t"]},
    # They are read once, so that all places would have those of the first.
    "of records of buildings": {"building.left.ground_record": ["RSN6-180", "RSN77-254"]},
}


@pytest.mark.parametrize("axes", REFUSED.values(), ids=REFUSED)
def test_what_is_no_axis_is_refused_with_the_repair(axes, says):
    says(refused(axes))


def test_gaps_of_the_only_interface_and_counts_of_storeys_are_no_axes(says):
    says(refusal(parse_scene, scene_text(grid={"interface.gap": ["1 mm", "2 mm"]})))
    typology = {"name": "left", "typology": "concrete_frame", "storeys": 3, "height": "9 m", "floor_mass": "100 t"}
    says(refusal(parse_scene, scene_text(typology, FRAME | {"height": "3 m"}, grid={"building.left.storeys": [3, 4]})))
    assert parse_scene(scene_text(*PAIR)).axes == ()


def test_values_are_set_in_whatever_section_they_stand():
    """Of a scene without axes too, whose sections were read once: by any address, after what was set before."""
    study = parse_scene(pair_text({}), overrides=['records.tail="1 s"', 'building.left.mass="4 t"'])
    made = Variants(study, axes=(PERIODS,))
    assert made.scene(2).buildings[0].period == 0.7 and made.scene(2).records.tail == 1.0
    for text in ('building.left.period="0.4 s"', "interface.restitution=0.5", 'records.tail="2 s"', "solver.rtol=1e-5"):
        alone = parse_scene(pair_text({}), overrides=[*study.overrides, text])
        assert made.made([text]) == alone != study
