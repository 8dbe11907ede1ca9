"""Column strength of each building: contacts with its columns yield at it, in place of the interface's force."""

from __future__ import annotations

from math import inf

import pytest
from scenes import scene_text, single, storeyed

import pounding_risk as pr
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.questions.simulate import sheet
from pounding_risk.scene.reader import parse_scene

CAPPED = {"law": "viscous_elastoplastic", "gap": "2 mm", "records": {"window": ["0 s", "5 s"], "scale": 2.0}}
A = storeyed("A", ["40 t", "40 t"], "60 MN/m", ["4 m", "3 m"])
B = storeyed("B", ["60 t", "60 t"], "120 MN/m", ["3 m", "3 m"])


def row(a=None, b=None, **interface):
    """A whose floor 1 strikes B's columns, and B whose floors strike those of A."""
    sides = [side | ({"column_strength": force} if force else {}) for side, force in ((A, a), (B, b))]
    return parse_scene(scene_text(*sides, **CAPPED | interface))


def test_each_contact_is_capped_by_the_columns_that_it_strikes():
    """Oracle: the strengths themselves. The law holds the force at its cap: 1e-9 is rounding alone."""
    study = row("50 kN", "90 kN", column_yield_force="70 kN")
    struck = [study.buildings[study.struck_building(point)].name for point in study.points]
    assert struck == ["A", "B", "A"] and study.point_yield_forces() == (5e4, 9e4, 5e4)
    peaks = pr.scan(study)["contact_point_peak_contact_force"].values.ravel()
    assert peaks == pytest.approx([5e4, 9e4, 5e4], rel=1e-9)
    free = pr.scan(row())["contact_point_peak_contact_force"].values.ravel()
    assert (free > peaks * 1.01).all()


def test_one_run_states_the_yield_forces_of_columns_beside_that_of_floors():
    head = sheet(pr.simulate(row("50 kN", "90 kN")))[0]
    stated = {name: cell if isinstance(cell, str) else cell["text"] for name, cell in head["rows"]}
    assert stated["yield force"] == "∞" and stated["of columns"] == "50 kN, 90 kN"
    shared = sheet(pr.simulate(row()))[0]
    assert "∞" in str(dict(shared["rows"])["of columns"])


def test_equal_strengths_are_the_force_of_the_interface_to_the_bit():
    one, other = pr.scan(row("50 kN", "50 kN")), pr.scan(row(column_yield_force="50 kN"))
    assert all(one[name].values.tobytes() == other[name].values.tobytes() for name in one.data_vars)


def test_where_one_building_has_none_the_interface_counts():
    study = row(a="50 kN", column_yield_force="70 kN")
    assert study.point_yield_forces() == (5e4, 7e4, 5e4) and row(b="90 kN").point_yield_forces() == (inf, 9e4, inf)
    assert study.at(0) == study and parse_scene(study.to_toml()) == study


def test_a_wall_and_a_single_mass_have_the_force_of_the_interface():
    """A wall is met like a floor at any height; a taller mass is struck at its column."""
    mass = parse_scene(scene_text(B, single("C", "90 t", "0.4 s", height="9 m"), **CAPPED, column_yield_force="70 kN"))
    assert [mass.struck_building(point) for point in mass.points] == [1] and mass.point_yield_forces() == (7e4,)
    wall = parse_scene(scene_text(A, {"name": "wall", "rigid": True, "height": "9 m"}, **CAPPED))
    assert {wall.struck_building(point) for point in wall.points} == {None}


def test_generated_storeys_have_it_and_validate_tells_each(says):
    tall = {"name": "G", "typology": "masonry", "height": "10 m", "storeys": 3, "floor_mass": "90 t"}
    study = parse_scene(scene_text(tall | {"column_strength": "300 kN"}, B | {"column_strength": "90 kN"}, **CAPPED))
    assert [building.column_strength for building in study.buildings] == [3e5, 9e4]
    says("\n".join(line for line in str(validate(study)).splitlines() if "contact points" in line))


@pytest.mark.complete
def test_advise_varies_the_strengths_of_buildings_as_forces():
    """With 50 kN of the buildings or of the interface every number of the advice is one."""
    one, other = pr.advise(row("50 kN", "50 kN")), pr.advise(row(column_yield_force="50 kN"))
    assert [repr(vars(mine)) for mine in one.influences] == [repr(vars(same)) for same in other.influences]  # NaN too
