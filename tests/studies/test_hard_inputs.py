"""Hard cases that are met at the door: what a scene cannot have, in a sentence that says so."""

from __future__ import annotations

import pytest

from pounding_risk.errors import SceneError
from pounding_risk.models.restitution import constant
from pounding_risk.scene.scene import scene_of


def scene() -> dict:
    return {
        "scene": {"name": "hard"},
        "building": [
            {"name": "left", "mass": "500 t", "period": "0.5 s", "damping": 0.05},
            {"name": "right", "mass": "800 t", "period": "1.0 s", "damping": 0.05},
        ],
        "interface": [
            {"gap": "10 mm", "contact_model": "jankowski", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}
        ],
        "records": {"names": ["RSN6-180"]},
        "grid": {"yield_force": ["1 MN", "2 MN", "inf"]},
    }


def refused(change) -> str:
    tables = scene()
    change(tables)
    with pytest.raises(SceneError) as caught:
        scene_of(tables)
    assert len(caught.value.faults) == 1
    return caught.value.faults[0]


def test_the_scene_itself_is_good():
    assert scene_of(scene()).grid.yield_forces == (1e6, 2e6, float("inf"))


def test_a_negative_gap_is_refused():
    told = refused(lambda tables: tables["interface"][0].update(gap="-10 mm"))
    assert "gap" in told and "must be at least 0" in told


@pytest.mark.parametrize("forces", [["2 MN", "1 MN"], ["1 MN", "1 MN"], ["inf", "1 MN"]])
def test_yield_forces_out_of_order_or_twice_are_refused(forces: list[str]):
    told = refused(lambda tables: tables["grid"].update(yield_force=forces))
    assert "grid.yield_force" in told and ("ascending order" in told or "twice" in told)


@pytest.mark.parametrize("force", ["0 kN", "-1 kN", "nan kN"])
def test_no_yield_force_is_refused(force: str):
    assert "yield_force" in refused(lambda tables: tables["grid"].update(yield_force=[force, "1 MN"]))


@pytest.mark.parametrize("e", [0.0, -0.5, 1.0001, float("nan")])
def test_no_restitution_at_all_is_refused(e: float):
    assert "restitution" in refused(lambda tables: tables["interface"][0].update(restitution=e))
    with pytest.raises(ValueError, match=r"^coefficient of restitution .*: it must lie in \(0, 1\]"):
        constant(e)


@pytest.mark.parametrize("damping", [1.0, 2.0, -0.05])
def test_critical_damping_is_refused(damping: float):
    told = refused(lambda tables: tables["building"][0].update(damping=damping))
    assert "damping" in told and "must be at least 0 and less than 1" in told


@pytest.mark.parametrize("change", [{"mass": "0 t"}, {"mass": "-1 t"}, {"period": "0 s"}, {"mass": "inf t"}])
def test_a_building_without_mass_or_period_is_refused(change: dict[str, str]):
    (key,) = change
    assert key in refused(lambda tables: tables["building"][0].update(change))
