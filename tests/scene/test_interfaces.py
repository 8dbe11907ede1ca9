"""Scenes of rows: the shipped one by hand, what makes a scene a row, every fault in words, and the round trip."""

import re
from importlib import resources
from itertools import pairwise
from math import inf

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scene_cases import cases
from scenes import scene_text, single, storeyed
from sentences import refusal
from test_reader import is_a_scene_or_sentences

from pounding_risk import read_scene
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.plan.scene_text import scene_words
from pounding_risk.errors import SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.models.structures.contact_points import COLUMN, FLOOR, Point, floor_number, floor_words
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys, generated
from pounding_risk.models.structures.typologies import ELSEWHERE, TYPOLOGIES
from pounding_risk.scene import sections as scenario
from pounding_risk.scene.building_tables import OF_STOREYS
from pounding_risk.scene.not_modelled import LAWS_ELSEWHERE, RULES_ELSEWHERE
from pounding_risk.scene.notes import level_notes
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of

ROW = (resources.files("pounding_risk.scene") / "shipped" / "row.toml").read_text("utf-8")
PAIR = scene_text(single("frame", "44 t", "0.2 s"), single("masonry", "82 t", "0.1 s"), law="hertz", gap="25 mm")


# ------------------------------------------------------------------------------------------------ reading


def test_the_shipped_row():
    found = read_scene(str(resources.files("pounding_risk.scene") / "shipped" / "row.toml"))
    assert found.is_row
    assert found.interface_names == ("offices | flats", "flats | shop")
    offices, flats, shop = found.buildings
    assert isinstance(offices, Storeys)
    assert isinstance(flats, Storeys)
    assert offices.masses == (2.1e5,) * 5
    assert offices.stiffnesses == (2.6e8, 2.3e8, 2e8, 1.7e8, 1.4e8)
    assert offices.levels == pytest.approx((4.2, 7.8, 11.4, 15.0, 18.6), rel=1e-12)
    assert (flats.stiffnesses, flats.heights, flats.damping_rule) == ((4e8,) * 4, (3.0,) * 4, "modal")
    assert shop == Building("shop", 1.5e5, 0.25, 0.05, height=6.0)
    first, second = found.interfaces
    # The flats' floors at 3, 6, 9 and 12 m, those of the offices at 4.2, 7.8 and 11.4 m: each meets a column.
    assert [point.level for point in first.points] == pytest.approx([3.0, 4.2, 6.0, 7.8, 9.0, 11.4, 12.0])
    assert [point.left_floor for point in first.points] == pytest.approx([3 / 4.2, 1, 1.5, 2, 7 / 3, 3, 3 + 0.6 / 3.6])
    assert [point.right_floor for point in first.points] == pytest.approx([1, 1.4, 2, 2.6, 3, 3.8, 4])
    assert {point.kind for point in first.points} == {COLUMN}
    assert second.points == (Point(1, 2.0, 1.0, FLOOR, 6.0),)
    assert (first.gap, first.yield_force, first.column_yield_force) == (0.03, 1.5e6, 4e5)
    assert (second.gap, second.yield_force, second.column_yield_force) == (0.02, inf, inf)
    assert found.points == (*first.points, *second.points)
    assert found.point_yield_forces() == (*[4e5] * 7, inf)
    assert found.point_yield_forces(1e6) == (*[4e5] * 7, 1e6)


def test_a_mass_that_is_met_part_way_up_is_told_its_column():
    """A roof of 6 m against a building of 9 m that is one mass: no storeys, and yet a column is hit."""
    sides = single("low", "44 t", "0.3 s", height="6 m"), single("high", "44 t", "0.3 s", height="9 m")
    told = str(validate(parse_scene(scene_text(*sides, yield_force="1 MN", column_yield_force="300 kN"))))
    assert "floor to column, yield force 300 kN: storey 1 of low, column 1 of high at 6 m" in told


def test_each_interface_has_its_own_stiffness_gap_and_restitution():
    found = parse_scene(
        ROW,
        overrides=[
            "interface.2.stiffness=1e9 N/m^1.5",
            "interface.2.restitution=0.4",
            'grid.contact_model=["jankowski", "hertz"]',
        ],
    )
    assert [found.at(place).law().stiffness for place in (0, 1)] == [8e10, 1e9]
    assert [found.at(place).law("hertz").stiffness for place in (0, 1)] == [8e10, 1e9]
    assert [interface.restitution.rule.c0 for interface in found.interfaces] == [0.65, 0.4]
    alone = found.at(1)
    assert alone.interface_names == ("flats | shop",)
    assert (alone.gap, alone.stiffness, alone.restitution_words) == (0.02, 1e9, "0.4")
    assert alone.points == (Point(0, 2.0, 1.0, FLOOR, 6.0),)
    # A floor of 180 t against the shop of 150 t.
    assert alone.striking_mass == pytest.approx(1.8e5 * 1.5e5 / 3.3e5, rel=1e-14)
    assert parse_scene(alone.to_toml()) == alone


def test_storeys_may_be_generated_from_height_and_typology():
    shop = 'mass = "150 t"\nperiod = "0.25 s"\nheight = "6 m"'
    lines = 'typology = "masonry"\nheight = "6 m"\nstoreys = 2\nfloor_mass = "80 t"'
    found = parse_scene(ROW.replace(shop, lines))
    made = found.buildings[2]
    assert made == generated("shop", height=6.0, storeys=2, typology="masonry", floor_mass=8e4)
    assert made.period == pytest.approx(0.0488 * 6.0**0.75, rel=1e-12)  # ASCE 7, T = C_t h^x
    assert [point[1:5] for point in found.interfaces[1].points] == [(1.0, 1.0, FLOOR, 3.0), (2.0, 2.0, FLOOR, 6.0)]
    slower = parse_scene(ROW.replace(shop, f'{lines}\nperiod = "0.5 s"')).buildings[2]
    assert slower.period == pytest.approx(0.5, rel=1e-12)
    assert parse_scene(found.to_toml()) == found


def test_one_table_is_that_of_all_neighbours():
    text = ROW[: ROW.index("[[interface]]                    # flats | shop")] + ROW[ROW.index("[records]") :]
    found = parse_scene(text)
    assert [interface.gap for interface in found.interfaces] == [0.03, 0.03]
    assert [interface.yield_force for interface in found.interfaces] == [1.5e6, 1.5e6]
    assert [point.interface for point in found.points] == [0] * 7 + [1]
    assert found.gridded_interface is None
    assert found.interface_gaps(0.1) == (0.1, 0.1)
    assert parse_scene(found.to_toml()) == found


def test_a_grid_of_gaps_may_be_of_one_interface():
    found = parse_scene(ROW, overrides=['grid.gap=["10 mm", "20 mm"]', "grid.interface=flats | shop"])
    assert found.interface_gaps(0.01) == (0.03, 0.01)
    both = parse_scene(ROW, overrides=['grid.gap=["10 mm", "20 mm"]'])
    assert both.interface_gaps(0.01) == (0.01, 0.01)
    # Without a grid every interface keeps its gap, and the label is that of the first.
    own = parse_scene(ROW)
    assert (own.grid.gaps, own.gridded_interface) == ((0.03,), "offices | flats")
    assert own.interface_gaps(own.grid.gaps[0]) == (0.03, 0.02)
    for study in (found, both, own):
        assert parse_scene(study.to_toml()) == study


def test_a_grid_of_one_yield_force_is_that_of_every_floor():
    found = parse_scene(ROW, overrides=['grid.yield_force=["1 MN"]'])
    assert [interface.yield_force for interface in found.interfaces] == [1e6, 1e6]
    assert found.point_yield_forces() == (*[4e5] * 7, 1e6)
    assert parse_scene(found.to_toml()) == found


def test_contact_points_of_the_scene_itself():
    contact = (
        'contact = [{left = "storey 3", right = "column 4 at 0.8"}, {left = "column 2 at 0.5", right = "storey 2"}]'
    )
    text = ROW.replace('yield_force = "1500 kN"', contact)
    found = parse_scene(text)
    assert [point[1:4] for point in found.interfaces[0].points] == [(1.5, 2.0, COLUMN), (3.0, 3.8, COLUMN)]
    assert [point.level for point in found.interfaces[0].points] == pytest.approx([6.0, 11.4])
    assert parse_scene(found.to_toml()) == found


def test_storeys_make_a_scene_a_row_and_a_wall_does_not():
    mass = 'mass = "82 t"\nperiod = "0.1 s"\n'
    one_storey = 'storey_heights = "3 m"\nstorey_stiffnesses = "40 MN/m"\nfloor_masses = ["40 t"]\n'
    assert parse_scene(PAIR.replace(mass, one_storey)).is_row
    assert not parse_scene(PAIR.replace(mass, "rigid = true\n")).is_row


@pytest.mark.parametrize(
    ("overrides", "row"),
    [
        (["building.height=6 m"], False),
        (["building.1.height=6 m", "building.2.height=6.04 m"], False),
        (["building.1.height=6 m", "building.2.height=6.24 m"], False),
        (["building.1.height=6 m", "building.2.height=6.26 m"], True),
        (["building.1.height=6 m", "building.2.height=6.26 m", "building.floor_depth=0.3 m"], True),
        (["interface.column_yield_force=inf"], True),
        (["building.1.height=6 m", "building.2.height=8 m"], True),
        (["interface.tolerance=0.1 m"], True),
        (['interface.contact=[{left = "storey 1", right = "storey 1"}]'], True),
        (["effects.soil_flexibility={shear_wave_velocity = '200 m/s', radius = '8 m'}"], True),
        (["effects.wave_passage={velocity = '1000 m/s', distance = '20 m'}"], False),
    ],
)
def test_two_masses_are_a_pair_unless_something_asks_for_a_row(overrides, row):
    found = parse_scene(PAIR, overrides=overrides)
    assert (found.is_row, len(found.interfaces)) == (row, 1)
    assert parse_scene(found.to_toml()) == found


CLOSE = ["building.offices.storey_heights=3.23 m", "building.flats.storey_heights=3 m"]


@pytest.mark.parametrize(
    ("more", "kinds", "note"),
    [
        # 230, 460, 690 and 920 mm apart: slabs of 250 mm overlap at the first floors only.
        ([], [FLOOR, *[COLUMN] * 5], "taken as floor to floor. Slightly farther apart, floors strike columns"),
        (["interface.1.tolerance=50 mm"], [COLUMN] * 7, "The tolerance of 50 mm stands in place of floors 250 mm deep"),
        (["building.offices.floor_depth=0.4 m"], [FLOOR, *[COLUMN] * 5], "460 mm apart in level, limit 400 mm"),
        (["building.offices.floor_depth=0.15 m"], [COLUMN] * 7, ""),
        (["building.flats.floor_depth=0.15 m"], [FLOOR, *[COLUMN] * 5], "230 mm apart in level, limit 250 mm"),
    ],
)
def test_the_depth_of_floors_decides_what_meets_what_and_is_told(more, kinds, note):
    study = parse_scene(ROW, overrides=[*CLOSE, *more])
    assert [point.kind for point in study.interfaces[0].points] == kinds
    told = [words for what, words in scene_words(study, 1) if what == "note"]
    assert len(told) == bool(note) and all(note in words and words.startswith("offices | flats: ") for words in told)
    assert parse_scene(study.to_toml()) == study
    assert level_notes(parse_scene(study.to_toml())) == level_notes(study)


def test_validate_tells_the_depth_that_holds(says):
    deep = parse_scene(ROW, overrides=["building.flats.floor_depth=0.3 m", "interface.2.tolerance=10 mm"])
    says([words for what, words in scene_words(deep, 1) if what == "levels"])


def test_a_wall_is_met_wherever_it_stands_beside_a_mass():
    wall = PAIR.replace('mass = "82 t"\nperiod = "0.1 s"\n', 'rigid = true\nheight = "12 m"\n')
    assert not parse_scene(wall, overrides=["building.1.height=6 m"]).is_row
    assert parse_scene(wall, overrides=["building.1.height=18 m"]).points == (Point(0, 12 / 18, 1.0, COLUMN, 12.0),)


@pytest.mark.parametrize(
    ("override", "pick", "value"),
    [
        ('building.2.floor_masses=["1 t", "2 t", "3 t", "4 t"]', lambda s: s.buildings[1].masses, (1e3, 2e3, 3e3, 4e3)),
        ("building.offices.floor_masses=100 t", lambda s: s.buildings[0].masses, (1e5,) * 5),
        ("building.offices.storey_stiffnesses.5=1 MN/m", lambda s: s.buildings[0].stiffnesses[3:], (1.7e8, 1e6)),
        ("building.1.storey_heights.1=3.6 m", lambda s: s.buildings[0].heights[:2], (3.6, 3.6)),
        ("building.flats.damping_rule=rayleigh", lambda s: s.buildings[1].damping_rule, "rayleigh"),
        ("building.damping=0.02", lambda s: [building.damping for building in s.buildings], [0.02] * 3),
        ("interface.1.gap=10 mm", lambda s: [each.gap for each in s.interfaces], [0.01, 0.02]),
        ('interface."flats | shop".gap=10 mm', lambda s: [each.gap for each in s.interfaces], [0.03, 0.01]),
        ("interface.gap=10 mm", lambda s: [each.gap for each in s.interfaces], [0.01, 0.01]),
        ("interface.1.column_yield_force=inf", lambda s: s.interfaces[0].column_yield_force, inf),
    ],
)
def test_overrides(override, pick, value):
    assert pick(parse_scene(ROW, overrides=[override])) == value


def test_the_row_of_the_docs_is_read(root):
    text = (root / "docs" / "rows.md").read_text(encoding="utf-8")
    found = parse_scene(text.partition("```toml\n")[2].partition("```")[0])
    assert found.interface_gaps(0.04) == (0.03, 0.04)
    # Floors of the offices at 4, 8 and 12 m, of the flats at 3, 6, 9 and 12 m.
    assert [point.level for point in found.interfaces[0].points] == pytest.approx([3.0, 4.0, 6.0, 8.0, 9.0, 12.0])
    assert [point[1:4] for point in found.interfaces[1].points] == [(2.0, 1.0, FLOOR)]


# ------------------------------------------------------------------------------------------------ faults


@pytest.mark.parametrize(("text", "overrides", "sentences"), cases("scene_row_faults.txt", ROW))
def test_each_fault(text, overrides, sentences):
    with pytest.raises(SceneError) as error:
        parse_scene(text, overrides=overrides)
    assert error.value.faults == sentences


def test_two_walls_side_by_side_are_refused(says):
    walls = '[[building]]\nname = "wall"\nrigid = true\n[[building]]\nname = "rock"\nrigid = true\n[records]'
    text = ROW[: ROW.index("[[interface]]                    # flats")] + ROW[ROW.index("[records]") :]
    says(refusal(parse_scene, text.replace("[records]", walls)))


# ------------------------------------------------------------------------------------------------ any row

HEIGHTS = st.lists(st.floats(2.0, 6.0), min_size=1, max_size=8)
POSITIVE = st.floats(1e3, 1e9)


@st.composite
def buildings(draw: st.DrawFn, name: str) -> Building | Storeys:
    heights = draw(HEIGHTS)
    kind = draw(st.sampled_from(["storeys", "mass", "wall"]))
    height = draw(st.sampled_from([0.0, sum(heights)]))
    if kind == "wall":
        return Building.rigid(name)._replace(height=height)
    if kind == "mass":
        return Building(name, draw(POSITIVE), draw(st.floats(0.05, 3.0)), draw(st.floats(0.0, 0.3)), height=height)
    many = st.lists(POSITIVE, min_size=len(heights), max_size=len(heights))
    rule = draw(st.sampled_from(["modal", "rayleigh", "stiffness"]))
    return Storeys(name, draw(many), draw(many), heights, draw(st.floats(0.0, 0.3)), rule, draw(many | st.just([])))


def written(rows: list[Building | Storeys], gaps: list[float]) -> dict:
    """The tables of a scene of these buildings, through those of the shipped one."""
    shipped = parse_scene(ROW)
    one = {"interfaces": shipped.interfaces[:1], "is_row": False, "gridded_interface": None}
    tables = shipped.updated(buildings=tuple(rows), **one).resolved()
    tables["interface"] = [{**tables["interface"][0], "gap": f"{gap!r} m"} for gap in gaps]
    del tables["grid"]["gap"], tables["grid"]["yield_force"]
    return tables


@settings(deadline=None, max_examples=40)
@given(data=st.data(), count=st.integers(2, 6))
@pytest.mark.complete
def test_round_trip_of_any_row(data, count):
    """With floors of the usual depth or a given one, below half of the lowest storey, and with a tolerance."""
    rows = [data.draw(buildings(str(place))) for place in range(count)]
    if any(left.is_rigid and right.is_rigid for left, right in pairwise(rows)):
        return
    gaps = [data.draw(st.floats(0.0, 1.0)) for _ in rows[1:]]
    tables = written(rows, gaps)
    depth, tolerance = (data.draw(st.none() | st.floats(0.01, 0.9)) for _ in range(2))
    tables["building"][-1] |= {} if depth is None else {"floor_depth": f"{depth!r} m"}
    tables["interface"][0] |= {} if tolerance is None else {"tolerance": f"{tolerance!r} m"}
    found = scene_of(tables)
    assert not found.is_row or found.interfaces[-1].levels.right_depth == (depth or 0.25)
    if not found.is_row:  # two masses of no height
        assert depth is tolerance is None
        return
    assert found.interfaces[0].levels.tolerance == tolerance
    assert found.buildings == tuple(rows)
    assert found.interface_gaps(found.grid.gaps[0]) == tuple(gaps)
    assert all(interface.points for interface in found.interfaces)
    assert parse_scene(found.to_toml()) == found


POINTS = [[{"left": "storey 2", "right": "column 1 at 0.5"}], [{"left": "storey 9"}]]
NUMBERS = [None, True, 3, -1.0, "", "3 m", "2 t", "inf", [], ["3 m"], ["3 m", "2 t"], [["3 m"]], {}]
JUNK = st.sampled_from([*POINTS, *NUMBERS, "hertz", "merged", "storey 2", "flats | shop"])


@settings(deadline=None, max_examples=100)
@given(data=st.data())
@pytest.mark.complete
def test_any_row_is_a_study_or_sentences(data):
    tables = parse_scene(ROW).resolved()
    for _ in range(data.draw(st.integers(1, 3))):
        section = data.draw(st.sampled_from(["building", "interface", "grid", "effects"]))
        keys = tables.setdefault(section, {})
        keys = data.draw(st.sampled_from(keys)) if isinstance(keys, list) else keys
        keys[data.draw(st.sampled_from([*scenario.KNOWN[section]]))] = data.draw(JUNK)
    is_a_scene_or_sentences(tables)


@given(below=st.integers(0, 199), part=st.floats(0.001, 0.999) | st.just(0.0))
def test_words_of_a_place_are_read_as_that_place(below, part):
    floor = below + part
    if 0.001 <= floor - below <= 0.999 or (floor == below and below):
        assert floor_number(floor_words(floor)) == floor


def test_validate_tells_the_distances_of_a_wave_and_the_models_of_each_interface():
    wave = "effects.wave_passage={velocity = '800 m/s', distance = ['20 m', '15 m'], towards = 'right'}"
    scene = parse_scene(ROW, overrides=[wave, "interface.2.contact_model=hertz"])
    words = dict(scene_words(scene, 1))
    assert "distance 20 m, 15 m" in words["effect"]
    assert words["contact model"].startswith("jankowski at offices | flats, hertz at flats | shop")
    assert parse_scene(scene.to_toml()) == scene


ELSEWHERE_NAMED = {
    "rule": "takeda, Clough, modified Takeda, bilinear, masing, IMK, ibarra, slip, sdegrading, pivot, Baber-Noori",
    "contact_model": "kelvin, spring-dashpot, Jankowski 2005, hertzdamp, hunt-crossley, Lankarani-Nikravesh, "
    "ImpactMaterial, elastoplastic, gap, stereo-mechanical, rubber",
}


@pytest.mark.parametrize(
    ("key", "name"), [(key, name) for key, of in ELSEWHERE_NAMED.items() for name in of.split(", ")]
)
def test_rules_and_contact_models_under_names_of_the_field_are_answered(key, name, says):
    yielding = {"storey_strengths": "900 kN", "hysteresis": {"rule": name}}
    frame = storeyed("frame", ["60 t", "60 t"], "30 MN/m", **yielding)
    of_rule = scene_text(frame, single("wall", "80 t", "0.3 s"))
    sentence = refusal(parse_scene, of_rule if key == "rule" else scene_text(law=name))
    known, _, answer = sentence.partition("it may be ")[2].partition("; ")
    says(sentence.replace(known, "one of ours"))
    assert answer


def test_what_names_of_the_field_are_answered_with_exists():
    """No name is one of ours, none is of two subjects, and what an answer quotes can be written."""
    here = ((RULES_ELSEWHERE, OF_STOREYS), (LAWS_ELSEWHERE, CONTACT_MODELS), (ELSEWHERE, TYPOLOGIES))
    for subjects, ours in here:
        names = [name for words in subjects for name in words.split()]
        assert len(set(names)) == len(names) and not set(names) & set(ours)
        quoted = {name for words in subjects.values() for name in re.findall(r'"(\w+)"', words)}
        assert quoted <= set(ours)
