"""Scenes written in Python: the same object as one read from a file, with its checks, and changed without a file."""

import pickle
import re
from math import inf
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from sentences import refusal

import pounding_risk as pr
from pounding_risk._common.letters import refused
from pounding_risk.ensemble.identity import digest, identity
from pounding_risk.ensemble.job import ScanInput
from pounding_risk.models.contact.laws import RESTITUTION_OF_RATIO, Jankowski, VanMier
from pounding_risk.models.contact.relation import RELATIONS
from pounding_risk.models.restitution import CONCRETE, Restitution, constant
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.values import OF_EACH_INTERFACE

TEXT = """# A pair.
[[building]]
name = "frame"
mass = "44 t"        # weighed
period = "0.21 s"
[[building]]
name = "masonry"
mass = "83 t"
stiffness = "600 MN/m"
[[interface]]
gap = "10 mm"        # measured
contact_model = "jankowski"
stiffness = "2.75e9 N/m^1.5"
restitution = 0.65
[effects]
wave_passage = {velocity = "500 m/s", distance = "20 m", towards = "left"}
[records]
names = ["RSN6-180"]
window = ["0 s", "3 s"]
pga = "0.5 g"
[grid]
gap = {start = "0 mm", stop = "10 mm", num = 3}
[solver]
rtol = 1e-5
"""
G = 9.80665  # m/s²


def in_python() -> pr.Scene:
    """The scene of `TEXT`, in floats of SI and in text with units."""
    return pr.Scene(
        buildings=[
            pr.SingleMass("frame", mass=44e3, period="210 ms"),
            pr.SingleMass("masonry", mass="83 t", stiffness=6e8),
        ],
        interfaces=[pr.Interface(gap=0.01, law=Jankowski(2.75e9), restitution=0.65)],
        effects={"wave_passage": {"velocity": "500 m/s", "distance": "20 m", "towards": "left"}},
        records=pr.Records(["RSN6-180"], window=(0.0, "3 s"), pga=0.5 * G),
        grid=pr.Grid(np.array([0.0, 0.005, 0.01])),
        solver=pr.Solver(rtol=1e-5),
    )


def a_pair(**given) -> pr.Scene:
    """The buildings of `TEXT`, and what is given."""
    usual = {"interfaces": in_python().interfaces, "records": pr.Records(["RSN6-180"])}
    return pr.Scene(in_python().buildings, **usual | given)


def test_a_scene_of_python_is_that_of_a_file():
    written, read = in_python(), parse_scene(TEXT)
    assert written == read
    assert parse_scene(written.to_toml()) == written
    digests = [digest(identity(ScanInput(scene, motions_of(scene)))) for scene in (written, read)]
    assert digests[0] == digests[1]


def test_rows_of_every_kind_of_building():
    scene = pr.Scene(
        [
            pr.RigidWall("wall", height="9 m"),
            pr.ShearBuilding("flats", ["180 t"] * 3, "400 MN/m", 3.0, damping_rule="rayleigh"),
            pr.TypologyBuilding("shop", height="6 m", storeys=2, typology="masonry", floor_mass=8e4),
            pr.SingleMass("mast", 2e4, "0.5 s", height=12.0, floor_depth="0.3 m"),
        ],
        [pr.Interface("20 mm", "hertz", 2e9, yield_force="1 MN")],
        {"names": ["RSN6-180"]},
        name="four",
    )
    assert scene.is_row and scene.name == "four" and len(scene.interfaces) == 3
    flats = scene.buildings[1]
    assert isinstance(flats, Storeys)
    assert (flats.masses, flats.stiffnesses, flats.heights) == ((1.8e5,) * 3, (4e8,) * 3, (3.0,) * 3)
    assert parse_scene(scene.to_toml()) == scene
    assert [between.yield_force for between in scene.interfaces] == [1e6] * 3


# Every form: e, a named relation, a damping ratio of a law; of each with the relation to damping.
RATIOS = st.builds("xi {!r} of {}".format, st.floats(0.0, 0.95), st.sampled_from(list(RESTITUTION_OF_RATIO)))
NUMBERS = st.floats(0.05, 1.0) | st.just("concrete")
RESTITUTIONS = (
    NUMBERS
    | RATIOS
    | st.builds(lambda e, relation: {"value": e, "relation": relation}, NUMBERS, st.sampled_from(RELATIONS))
    | st.builds(lambda ratio: {"value": ratio, "relation": "published"}, RATIOS)
)


TEXTS = st.text(st.characters(codec="utf-8"), min_size=1).filter(str.strip).filter(lambda name: not refused(name))


@settings(deadline=None, max_examples=60)
@given(
    masses=st.lists(st.floats(1e3, 1e7), min_size=2, max_size=4),
    periods=st.lists(st.floats(0.01, 5.0), min_size=4, max_size=4),
    gaps=st.sets(st.floats(0.0, 10.0), min_size=1, max_size=6),
    e=RESTITUTIONS,
    force=st.floats(1.0, 1e9) | st.just(inf),
    more=st.tuples(st.floats(1e-3, 0.999), st.floats(1.0, 1e9), st.floats(1.0, 1e9)),
    name=TEXTS,
    tall=st.booleans(),
)
def test_a_scene_that_is_written_is_read_as_it_was(masses, periods, gaps, e, force, more, name, tall):
    """Text → scene → text → scene: equal, to the last bit of every number."""
    damping, stiffness, tail = more
    scene = pr.Scene(
        [
            pr.SingleMass(letter, mass, period, damping=damping, **({"height": 3.0 + place} if tall else {}))
            for place, (letter, mass, period) in enumerate(zip("ABCD", masses, periods, strict=False))
        ],
        [pr.Interface(law=Jankowski(stiffness), restitution=e, yield_force=force)],
        pr.Records(["RSN6-180"], scale=1.5, tail=tail, window=(tail, 2.0 * tail)),
        grid=pr.Grid(sorted(gaps)),
        name=name,
    )
    again = parse_scene(scene.to_toml())
    assert again == scene
    assert parse_scene(again.to_toml()) == again
    assert [building.mass for building in scene.buildings] == masses


def test_laws_and_relations_are_the_objects_of_models():
    def at(**keys):
        return in_python().replace(interfaces=[pr.Interface(0.01, **keys)]).interfaces[0]

    concrete = at(law=Jankowski(2.75e9), restitution=CONCRETE)
    assert (concrete.contact_model, concrete.stiffness, concrete.restitution.words) == ("jankowski", 2.75e9, "concrete")
    assert at(law=Jankowski("2.75e6 kN/m^1.5"), restitution=constant(0.4)).restitution.rule == Restitution(0.4)
    van_mier = at(law=VanMier(4e10, 0.5), restitution={"value": 0.4, "relation": "published"})
    assert (van_mier.stiffness, van_mier.plastic_exponent) == (4e10, 0.5)


def test_options_of_effects_and_dicts_take_floats_in_si():
    wave = {"velocity": 500.0, "distance": 20.0, "towards": "left"}
    for effects in ({"wave_passage": wave}, [pr.Effect("wave_passage", wave)]):
        assert in_python().replace(effects=effects) == parse_scene(TEXT)
    assert in_python().replace(grid={"gap": [0.0, "5 mm", 0.01]}).grid == parse_scene(TEXT).grid
    same = {"buildings": iter(in_python().buildings), "interfaces": iter(in_python().interfaces)}
    assert in_python().replace(**same) == parse_scene(TEXT)
    interface = {"gap": 0.01, "contact_model": "jankowski", "stiffness": 2.75e9, "restitution": 0.65}
    assert in_python().replace(interfaces=[interface]) == parse_scene(TEXT)


def test_a_scene_that_goes_to_another_process_is_the_same_one():
    """Two masses without a height meet at a level that is not known, which is NaN in both processes."""
    scene = in_python()
    again = pickle.loads(pickle.dumps(scene))
    assert again == scene and hash(again) == hash(scene)
    assert again != scene.replace(gap=0.02) and scene != "a scene"


def test_a_scene_is_changed_with_its_checks():
    scene = in_python()
    changed = scene.replace("building.frame.mass=50 t", gap=["0 mm", 0.02], yield_force="450 kN", rtol=1e-8, name="x")
    assert (changed.grid.gaps, changed.grid.yield_forces, changed.rtol) == ((0.0, 0.02), (450e3,), 1e-8)
    assert (changed.name, changed.buildings[0].mass, scene.buildings[0].mass) == ("x", 50e3, 44e3)
    assert scene.replace(effects=[]).effects == ()
    assert scene.replace(records=pr.Records(["RSN6-270"])).records.names == ("RSN6-270",)


def test_the_text_of_a_file_keeps_its_comments_where_values_are_set():
    scene = parse_scene(TEXT, "pair.toml", ['interface.gap="12 mm"', "building.frame.mass=45 t"])
    text = scene.to_toml(as_written=True)
    assert 'gap = "12 mm"        # measured' in text and 'mass = "45 t"        # weighed' in text
    assert text.startswith("# A pair.\n")
    assert parse_scene(text, "pair.toml") == scene
    assert "#" not in scene.to_toml()
    assert in_python().to_toml(as_written=True) == in_python().to_toml()


def test_interfaces_of_a_row_may_have_models_of_their_own(root: Path):
    row = (root / "pounding_risk" / "scene" / "shipped" / "row.toml").read_text("utf-8")
    mixed = pr.read_scene(row, ["interface.2.contact_model=hertz"])
    assert mixed.grid.contact_models == (OF_EACH_INTERFACE,)
    assert mixed.model_names == ("jankowski", "hertz")
    assert [type(mixed.at(place).law()).__name__ for place in (0, 1)] == ["Jankowski", "Hertz"]
    assert parse_scene(mixed.to_toml()) == mixed
    exact = pr.read_scene(row, ['interface.2.restitution={value = 0.5, relation = "exact"}'])
    assert [between.restitution.relation for between in exact.interfaces] == ["published", "exact"]
    gridded = pr.read_scene(row, ["interface.2.contact_model=hertz", 'grid.contact_model=["linear"]', *LINEAR])
    assert [type(gridded.at(place).law("linear")).__name__ for place in (0, 1)] == ["Linear", "Linear"]


LINEAR = ['interface.1.contact_model="linear"', 'interface.2.contact_model="linear"', 'interface.stiffness="1 GN/m"']


def of_one(**keys):
    return a_pair(interfaces=[{"gap": 0.01, "contact_model": "hertz", "stiffness": 1e9} | keys])


REFUSED = {
    "a unit and a key": lambda: pr.SingleMass("frame", mass="44 tt", perod=2),
    "no name": lambda: pr.SingleMass(mass=3.0),
    "a negative height": lambda: pr.RigidWall("a", height=-1.0),
    "more values than keys": lambda: pr.Solver(1e-6, 2),
    "a key twice": lambda: pr.SingleMass("a", 1e4, mass=1e4),
    "a law and a model": lambda: pr.Interface(law=Jankowski(1e9), contact_model="hertz"),
    "no override": lambda: in_python().replace(3),
    "effects that are no tables": lambda: in_python().replace(effects=[3]),
    "a law that is none": lambda: pr.Interface(law=3),
    "a stiffness of no model": lambda: in_python().replace(interfaces=[pr.Interface(0.01, stiffness=1e9)]),
    "a stiffness of a jump": lambda: of_one(contact_model="merged"),
    "a list of models": lambda: of_one(contact_model=["hertz"]),
    "no folder": lambda: a_pair(folder=None),
    "an unknown effect": lambda: in_python().replace(effects={"p_delt": {}}),
    "a name twice": lambda: in_python().replace(buildings=[pr.SingleMass("a", 1e3, 0.1)] * 2),
    "a relation of one's own": lambda: pr.Interface(0.1, "hertz", restitution=Restitution(0.8, -0.1)),
    "numbers in place of tables": lambda: pr.Scene(3, 4, 5),
    "an unknown part": lambda: in_python().replace(gp=1.0),
    "a negative gap": lambda: in_python().replace(gap=-1),
}


@pytest.mark.parametrize("make", REFUSED.values(), ids=REFUSED)
def test_what_no_scene_can_be_made_of_is_told_in_words(make, says):
    says(refusal(make))


def test_the_examples_of_the_page_run(root, monkeypatch, tmp_path, capsys):
    monkeypatch.chdir(tmp_path)
    page = (root / "docs" / "scenes.md").read_text("utf-8")
    first, second = re.findall(r"^```python\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
    names: dict = {}
    exec(compile(first, "scenes.md", "exec"), names)
    assert names["results"].sizes["gap"] == 3 and names["wider"].grid.gaps[-1] == 0.1
    assert parse_scene(capsys.readouterr().out) == names["wider"]
    exec(compile(second, "scenes.md", "exec"), names)
    assert 'gap = "25 mm"           # measured' in capsys.readouterr().out
