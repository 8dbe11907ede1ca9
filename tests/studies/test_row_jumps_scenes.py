"""Scenes of single masses in a row whose velocities jump: every command, and the sentences for rows that cannot."""

from copy import deepcopy
from functools import partial

import numpy as np
import pytest
from sentences import refusal

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.ensemble.job_choice import job_kind
from pounding_risk.errors import SceneError
from pounding_risk.models.contact.impulsive import Merged
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.studies.compare import comparable_models, models_left_out

pytestmark = pytest.mark.complete

MASSES = [("left", "500 t", "0.5 s"), ("middle", "300 t", "0.4 s"), ("right", "800 t", "0.31 s")]


def tables(**interface):
    """A row of three, in the shape of a scene file."""
    return {
        "building": [{"name": name, "mass": mass, "period": period} for name, mass, period in MASSES],
        "interface": [{"contact_model": "stereomechanical", "restitution": 0.6, **interface}],
        "records": {"names": ["RSN6-180"], "window": ["0 s", "6 s"], "pga": "0.5 g"},
        "grid": {"gap": ["2 mm", "10 mm", "1 m"]},
    }


def test_scan_simulate_and_figures(tmp_path):
    """Contacts are listed, and the gap is kept; what is not defined says so."""
    given = tables()
    given["grid"]["contact_model"] = ["stereomechanical", "merged"]
    study = scene_of(given)
    found = pr.scan(study, tmp_path / "jumps.nc", check_fraction=0.0)
    assert np.all(found["status"] == COMPLETE)
    assert np.all(found["impact_count"].isel(gap=0) > 0)
    assert np.all(found["yield_exceedance"].isel(gap=0) == -1) and np.all(found["yield_exceedance"].isel(gap=2) == 0)
    assert np.all(np.isnan(found["peak_contact_force"].sel(contact_model="stereomechanical").isel(gap=1)))
    for model in study.grid.contact_models:
        run = pr.simulate(study, law=model, gap="2 mm")
        assert run.sizes["contact"] == found["impact_count"].sel(contact_model=model).isel(gap=0).sum()
        # The histories go through the jumps: what closes never passes the gap, before a jump and after it.
        assert run["relative_displacement"].max() <= 0.002 * (1.0 + 1e-9)
        figures.simulation_figure(run)
    assert pr.assess(found) is not None


def test_the_figure_of_a_run_without_a_lasting_force():
    """Points that touch are not drawn as untouched, and no force is told of them."""
    given = tables()
    given["records"]["window"] = ["0 s", "3 s"]
    run = pr.simulate(scene_of(given), gap="20 mm")
    assert np.all(np.isnan(run["contact_point_peak_contact_force"])) and np.all(run["impact_count"] > 0)
    counts = run["impact_count"].values.astype(int)
    words = {text.get_text().replace("\n", " ") for axis in figures.simulation_figure(run).axes for text in axis.texts}
    assert {f"{count}×" for count in counts} | {"velocities jump at each touch, and no force lasts"} <= words


def test_all_contact_models_are_compared():
    """Those of force take their stiffness from the reference; only colliding floors are left out, with the reason."""
    study = scene_of(tables(contact_model="jankowski", stiffness="2.75e9 N/m^1.5"))
    assert set(comparable_models(study)) > {"stereomechanical", "merged", "jankowski"}
    assert "distributed_mass: only for a pair of single masses: the waves of one touch" in models_left_out({"": study})
    compared = pr.compare(study, laws=["jankowski", "stereomechanical", "merged"])
    assert np.all(compared["status"] == COMPLETE)
    assert compared.sizes["contact_model"] == 3


def test_a_yield_force_plays_no_part():
    given = tables(yield_force="300 kN")
    given["grid"]["yield_force"] = ["300 kN", "3 MN"]
    found = pr.scan(scene_of(given), check_fraction=0.0)
    for name in ("impulse", "impact_count", "peak_displacement"):
        np.testing.assert_array_equal(found[name].isel(yield_force=0), found[name].isel(yield_force=1), err_msg=name)
    assert np.all(found["yield_count"].isel(gap=0) == -1)


@pytest.mark.complete
def test_the_comparison_of_effects_leaves_soil_out():
    """A foundation is a mass of its own, on which velocities do not jump; the command ended in a traceback."""
    compared = pr.effects(scene_of(tables()))
    assert list(compared["effects"].values) == ["none", "wave_passage"]
    assert "soil_flexibility gives each a foundation of its own mass" in compared.attrs["left_out"]


@pytest.mark.complete
def test_effects_of_a_row_with_jumps():
    """A wave changes the answer; P-Δ of single masses with a height, too."""
    given = tables()
    for building in given["building"]:
        building["height"] = "12 m"
    plain = pr.scan(scene_of(given), check_fraction=0.0)
    for effect in ({"wave_passage": {"velocity": "800 m/s", "distance": "20 m"}}, {"p_delta": {}}):
        changed = pr.scan(scene_of(given | {"effects": effect}), check_fraction=0.0)
        assert np.all(changed["status"] == COMPLETE)
        assert not np.array_equal(changed["impulse"], plain["impulse"])


FRAME = {"storeys": 2, "floor_masses": "200 t", "storey_stiffnesses": "300 MN/m", "storey_heights": "3 m"}
SOIL = {"soil_flexibility": {"shear_wave_velocity": "200 m/s", "radius": "6 m"}}


faults = partial(refusal, scene_of, kind=SceneError)


def test_what_cannot_jump_is_refused_with_its_reason(says):
    storeys, tall, mixed = tables(), tables(), tables()
    storeys["building"][0] = {"name": "frame", **FRAME}
    tall["building"][0]["height"], tall["building"][1]["height"] = "9 m", "6 m"
    mixed["interface"] = [
        {"contact_model": "stereomechanical", "restitution": 0.6},
        {"contact_model": "jankowski", "restitution": 0.6, "stiffness": "2.75e9 N/m^1.5"},
    ]
    floors = tables(contact_model="distributed_mass")
    says([faults(scene) for scene in (storeys, tables() | {"effects": SOIL}, tall, floors, mixed)])


def test_masses_between_walls_need_a_gap_and_one_ground():
    walls = tables()
    rigid = {"rigid": True}
    walls["building"] = [{"name": "A", **rigid}, walls["building"][0], {"name": "B", **rigid}]
    assert scene_of(deepcopy(walls)).is_row
    wave = {"wave_passage": {"velocity": "800 m/s", "distance": "20 m"}}
    assert "stereomechanical: A and B move towards each other, and would crush" in faults(walls | {"effects": wave})
    walls["grid"]["gap"] = ["0 mm", "10 mm"]
    assert "without any gap between A and B nothing there can move, and no force is determined" in faults(walls)


def test_the_reason_of_a_grid_is_that_of_the_scene():
    """Python calls that set a model from outside ask the job, not the reader."""
    study = scene_of(tables(contact_model="jankowski", stiffness="2.75e9 N/m^1.5") | {"effects": SOIL})
    assert job_kind(study).unsolved(study, "merged") == (
        "velocities jump, which is computed for single masses that meet mass to mass"
    )
    assert job_kind(study).unsolved(study, "jankowski") == ""
    assert Merged.only_in_pairs == ""
