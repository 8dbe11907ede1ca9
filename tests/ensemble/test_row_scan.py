"""A row's grid: screened against simulated, a named interface's gap, what is known, and the labelled dataset."""

import json

import numpy as np
import pytest
import xarray as xr
from scenes import FOUR_IN_A_ROW

from pounding_risk.assessment.assess import assess
from pounding_risk.ensemble import row_job
from pounding_risk.ensemble import scan as ensemble
from pounding_risk.ensemble.scan import scan
from pounding_risk.results.labels import positions
from pounding_risk.results.summary import counted
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.pair.outputs import RUN

NAMED = FOUR_IN_A_ROW.replace("[grid]", '[grid]\ninterface = "B | C"')


@pytest.fixture(scope="module")
def screened():
    return scan(parse_scene(FOUR_IN_A_ROW), check_fraction=0.02, workers=2)


@pytest.fixture(scope="module")
def simulated():
    return scan(parse_scene(FOUR_IN_A_ROW), screening=False, check_fraction=0.0, workers=1)


def same(one, other):
    """Array-equal in every output but one: energy is closed over the buildings that have been solved together."""
    for name in other.data_vars:
        if name in ("simulated", "energy_residual") or name.startswith(("sensitive", "change_")):
            continue
        assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name


def test_screening_changes_nothing(screened, simulated):
    """Array-equal in every variable: in parts, with what is known copied, against whole rows, every case run."""
    same(screened, simulated)
    counts = counted(screened)
    assert counted(simulated)["simulated"] == counts["cases"] > counts["simulated"] > 0
    assert int((screened["status"] != 0).sum()) == 0
    told = json.loads(screened.attrs["parts"])
    assert told["solved"] > 0 and told["known from a larger yield force"] > 0


def test_the_number_of_threads_changes_nothing(screened):
    again = scan(parse_scene(FOUR_IN_A_ROW), check_fraction=0.02, workers=3)
    assert screened.identical(again)


def test_motions_that_are_let_go_come_back_to_the_same_bits(screened, monkeypatch):
    """Memory holds one motion of the grid, where threads and a template of all of them ask for four."""
    monkeypatch.setattr(row_job, "MOTIONS", 1)
    monkeypatch.setattr(row_job, "CASES", 1)
    jobs = []
    monkeypatch.setattr(ensemble, "job_of", lambda order: jobs.append(row_job.RowJob(order)) or jobs[-1])
    xr.testing.assert_identical(scan(parse_scene(FOUR_IN_A_ROW), check_fraction=0.02, workers=2), screened)
    assert len(jobs[0].caches["driven"]._values) == len(jobs[0].caches["cases"]._values) == 1


def test_contact_is_where_the_gap_is_smaller_than_the_motion_needs_or_pounding_pushes(screened):
    """A first touch is one of the free motion, so that a row is touched at all where some free gap closes."""
    needed = screened["peak_closing_free"]
    assert needed.dims == ("record", "polarity", "interface")
    touched = (screened["impact_count"].isel(contact_model=0, yield_force=-1) > 0).any("interface")
    assert (touched == (screened["gap"] < needed).any("interface")).all()
    assert 0 < int(touched.sum()) < touched.size


@pytest.mark.complete
def test_only_the_named_interface_has_the_gaps_of_the_grid(screened):
    named = scan(parse_scene(NAMED), check_fraction=0.0)
    gaps = named["interface_gap"]
    assert gaps.dims == ("gap", "interface")
    assert gaps.sel(interface="B | C").values.tolist() == named["gap"].values.tolist() == [0.005, 0.04, 0.15]
    assert (gaps.sel(interface=["A | B", "C | wall"]) == 0.02).all()
    assert "interface_gap" not in screened
    same(named, scan(parse_scene(NAMED), screening=False, check_fraction=0.0))


def test_outputs_of_an_interface_are_those_of_its_points(screened):
    """Peaks are the largest, counts and sums add up, first times are the earliest."""
    place = screened["contact_point_interface"]
    for number, name in enumerate(screened["interface"].values):
        here = screened.sel(contact_point=place == number)
        there = screened.sel(interface=name)
        for output in ("impact_count", "impulse", "energy_viscous", "energy_plastic"):
            assert np.allclose(here[f"contact_point_{output}"].sum("contact_point"), there[output], rtol=1e-14), output
        for output in ("peak_contact_force", "peak_penetration", "yield_exceedance", "yield_demand", "peak_closing"):
            assert np.array_equal(here[f"contact_point_{output}"].max("contact_point"), there[output]), output
        first = here["contact_point_first_impact_time"].min("contact_point")
        assert np.array_equal(first, there["first_impact_time"], equal_nan=True)
    assert np.allclose(screened["row_impulse"], screened["impulse"].sum("interface"), rtol=1e-14)
    lost = screened["energy_viscous"] + screened["energy_plastic"]
    assert np.allclose(screened["row_energy_lost"], lost.sum("interface"), rtol=1e-14)


def test_buildings_are_the_largest_of_their_storeys(screened):
    pairs = (("displacement", "displacement"), ("drift", "drift"), ("storey_shear", "shear"))
    for building, storey in (*pairs, ("floor_acceleration", "acceleration")):
        for suffix in ("", "_free"):
            of_storeys = screened[f"storey_{storey}{suffix}"].max("storey")
            found = screened[f"peak_{building}{suffix}"]
            assert np.array_equal(found.sel(building=["A", "B", "C"]), of_storeys.sel(building=["A", "B", "C"]))
    wall = screened.sel(building="wall")
    assert (wall["peak_displacement"] == 0.0).all() and wall["peak_drift"].isnull().all()
    assert np.allclose(wall["peak_floor_acceleration"], screened["pga"], rtol=1e-14)
    assert screened["storey_drift"].sel(building="B", storey=3).isnull().all()
    assert screened["building_storeys"].values.tolist() == [3, 2, 1, 0]


def test_the_yield_force_of_columns_is_their_own(screened):
    """B's floors meet A's columns; there every case has the column's strength."""
    kind = screened["contact_point_kind"]
    forces = screened["contact_point_yield_force"]
    assert set(kind.values) == {"floor", "column"}
    assert (forces.where(kind == "column", drop=True) == 600e3).all()
    floors = forces.where(kind == "floor", drop=True)
    assert (floors == floors["yield_force"]).all()
    demand = screened["contact_point_yield_demand"]
    yields = screened["contact_point_yield_exceedance"]
    assert ((demand >= 1.0) == (yields == 1)).all() and int(yields.sum()) > 0


def test_every_variable_says_what_it_is(screened):
    for name, variable in screened.variables.items():
        assert variable.attrs.get("long_name"), name
        if variable.dtype.kind == "f":
            assert "units" in variable.attrs, name
    assert set(RUN) <= set(screened.data_vars)
    assert screened.attrs["source"] == "pounding_risk: event-driven row solver"
    assert screened["contact_point"].values[0] == "A 1 | B 0.769"


def test_ends_and_interiors_are_told_apart(screened):
    assert screened["building_position"].values.tolist() == ["end", "interior", "interior", "end"]
    assert positions(1) == ["alone"] and positions(2) == ["end", "end"]


def test_a_share_of_the_runs_is_made_again(screened):
    every = scan(parse_scene(FOUR_IN_A_ROW), check_fraction=1.0)
    assert ((every["sensitive"] >= 0) == (every["simulated"] == 1)).all(), "and of those alone"
    checked = screened["sensitive"] >= 0
    assert 1 <= int(checked.sum()) < int(screened["simulated"].sum())
    moved = screened["change_peak_contact_force"].values[checked.values]
    # The tolerance is 1e-6 of each step; peaks of a row with some ten contacts have been found to move by 1e-5.
    assert (moved < 1e-4).all()


def test_progress_counts_every_case():
    told = []
    study = parse_scene(FOUR_IN_A_ROW)
    one = study.updated(records=study.records._replace(names=study.records.names[:1]))
    scan(one, check_fraction=0.0, progress=lambda done, total: told.append((done, total)))
    assert told[-1] == (18, 18) and [done for done, _ in told] == sorted(done for done, _ in told)


def test_storeys_that_yield_have_ductility_and_residual_drift():
    """Where the ductility passes 1 the storey's shear is its strength and what hardening adds; there drift remains."""
    text = FOUR_IN_A_ROW.replace("storeys = 3\n", 'storeys = 3\nstorey_strengths = "450 kN"\n')
    text += "[effects]\ninelastic_storeys = {hardening = 0.05}\n"
    one = ['grid.gap=["40 mm"]', 'grid.yield_force=["inf"]']
    found = scan(parse_scene(text, overrides=one), check_fraction=0.0)
    found = found.isel(contact_model=0, gap=0, yield_force=0)
    for suffix in ("", "_free"):
        ductility = found[f"storey_ductility{suffix}"]
        assert ductility.sel(building="C").isnull().all(), "a mass without strengths stays elastic"
        yields = ductility.sel(building="A")
        assert float(yields.max()) > 2.0
        drift, shear = (found[f"storey_{name}{suffix}"].sel(building="A") for name in ("drift", "shear"))
        assert np.allclose(yields, drift / (450e3 / 9e7), rtol=1e-12)
        # Both lines on which the storey yields rise by hardening × k, so that the largest drift has the largest shear.
        backbone = np.where(yields > 1.0, 450e3 * (1.0 + 0.05 * (yields - 1.0)), 450e3 * yields)
        assert np.allclose(shear, backbone, rtol=1e-6), "peaks of drift and shear are searched apart, to 1e-7"
        remains = found[f"storey_residual_drift{suffix}"].sel(building="A")
        assert ((remains > 0.0) == (yields > 1.0)).all()


@pytest.mark.complete
def test_levels_that_barely_decide_are_in_the_dataset_and_in_the_evidence():
    """Floors of A and B at 3 and 3.24 m overlap by 10 mm of a slab of 250 mm, the others do not."""
    near = FOUR_IN_A_ROW.replace('"3.9 m"', '"3.24 m"')
    one = ['records.names=["RSN6-180"]', 'grid.gap=["20 mm"]', 'grid.yield_force=["inf"]']
    study = parse_scene(near, overrides=one)
    results = scan(study, check_fraction=0.0, workers=1)
    (name, note), *others = json.loads(results.attrs["level_notes"]).items()
    assert (name, others) == ("A | B", [])
    assert note.startswith("Floors 1 of A and 1 of B are 240 mm apart in level, limit 250 mm: taken as floor to floor.")
    evidence = {one.name: one.verdict.evidence for one in assess(results).interfaces}
    assert evidence["A | B"][-1] == note
    assert not any("apart in level" in sentence for sentence in evidence["B | C"])
    assert results["contact_point_kind"].values.tolist()[:3] == ["floor", "column", "column"]
    thin = parse_scene(near, overrides=["building.B.floor_depth=0.15 m", *one])
    assert "level_notes" not in scan(thin, check_fraction=0.0, workers=1).attrs
