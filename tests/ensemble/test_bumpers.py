"""Bumpers in the gap: contact where the rest of the gap has closed, and gaps that count their length."""

import json
from math import asin, pi

import numpy as np
import pytest
import xarray as xr
from axes import equals_the_loop
from scenes import BOTH, rigid, scene_text, single, storeyed
from sentences import refusal
from sweeps import sweep
from uncertain import PULSES, uncertain_pulses

import pounding_risk as pr
from pounding_risk.assessment.demands import is_linear
from pounding_risk.assessment.row import row_case
from pounding_risk.assessment.separations.table import separations_of
from pounding_risk.figures.row import elevation_figure, gap_scale
from pounding_risk.results.contact_notes import _beyond_bumpers
from pounding_risk.results.opened import Results

# Binary fractions of a metre: a gap less its bumpers is then the very float of the gap without them.
SHORT, LONG = "15.625 mm", "31.25 mm"
CLEAR = ["7.8125 mm", "31.25 mm", "250 mm"]
WITH_SHORT = ["23.4375 mm", "46.875 mm", "265.625 mm"]
WITH_LONG = ["39.0625 mm", "62.5 mm", "281.25 mm"]
RECORDS = {"names": ["RSN6-180", "RSN753-000"], "window": ["0 s", "12 s"], "polarity": ["as recorded", "reversed"]}
MASSES = single("frame", "500 t", "1.0 s"), single("wall", "800 t", "0.5 s")
FLOORS = (
    storeyed("frame", ["60 t", "60 t", "50 t"], "30 MN/m", ["3 m"] * 3),
    single("hall", "90 t", "0.3 s", height="7.2 m"),  # its floor faces the columns of storey 3
)


def scanned(*buildings, gaps, records=RECORDS, **interface):
    grid = {"gap": gaps, "yield_force": ["300 kN", "inf"]}
    return pr.scan(scene_text(*buildings, records=records, grid=grid, gap=gaps[1], **interface))


def are_alike(one, other, of_interface, of_point):
    """Every variable to the bit, but for the closings, which count the lengths [m]."""
    for name in other.data_vars:
        more = 0.0
        if "closing" in name:
            more = np.array(of_point if "contact_point" in name else of_interface)
        assert np.array_equal(other[name].values + more, one[name].values, equal_nan=True), name


@pytest.mark.parametrize("floors", sweep([False, True], True))
def test_a_gap_with_bumpers_is_the_gap_less_their_length(floors):
    buildings = FLOORS if floors else MASSES
    plain = scanned(*buildings, gaps=CLEAR, column_yield_force="inf")
    padded = scanned(*buildings, gaps=WITH_LONG, column_yield_force="inf", bumper_length=LONG)
    assert 0 < (plain["impact_count"] > 0).sum() < plain["impact_count"].size
    are_alike(padded, plain, 0.03125, 0.03125)
    assert padded["interface_bumper"].values.tolist() == [0.03125]
    closes = padded["peak_closing"] > padded["gap"]
    assert np.array_equal(padded["impact_count"] > 0, closes.transpose(*padded["impact_count"].dims))


def test_each_interface_of_a_row_has_its_own():
    row = *FLOORS, storeyed("flats", ["80 t", "80 t"], "40 MN/m", ["3.6 m"] * 2)
    contact = {"contact_model": "jankowski", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}

    def scanned_row(gaps, *lengths):
        pairs = zip(gaps, lengths, strict=True)
        interfaces = [contact | {"gap": gap, "bumper_length": length} for gap, length in pairs]
        return pr.scan(scene_text(*row, records=RECORDS, interfaces=interfaces))

    plain = scanned_row((CLEAR[1], CLEAR[0]), None, None)
    padded = scanned_row((WITH_SHORT[1], WITH_LONG[0]), SHORT, LONG)
    assert (plain["impact_count"] > 0).any()
    by_point = np.array([0.015625, 0.03125])[padded["contact_point_interface"].values.astype(int)]
    are_alike(padded, plain, [0.015625, 0.03125], by_point)
    one = scanned_row((WITH_SHORT[1], CLEAR[0]), SHORT, None)
    assert one["interface_bumper"].values.tolist() == [0.015625, 0.0]
    assert np.array_equal(one["impact_count"].values, plain["impact_count"].values)


def test_the_first_touch_is_where_the_rest_of_the_gap_has_closed():
    """Free vibration from v0: u = v0/ω sin ωt meets the bumper at (asin ω (gap − length)/v0)/ω."""
    omega = 2.0 * pi / 0.8
    scene = scene_text(
        single("frame", "100 t", "0.8 s", damping=0.0, initial_velocity="1 m/s"),
        rigid(),
        law="linear",
        gap="90 mm",
        bumper_length="40 mm",
        records={"generated": [{"kind": "ricker", "pga": "1e-6 g", "period": "0.5 s"}]},
    )
    run = pr.simulate(scene)
    # The pulse of 1e-5 m/s² moves the frame by some 1e-7 m of 50 mm.
    np.testing.assert_allclose(run["first_impact_time"].values, asin(omega * 0.05) / omega, rtol=1e-5)
    assert float(run["peak_closing"][0]) == pytest.approx(float(run["peak_penetration"][0]) + 0.09, rel=1e-9)


def test_an_axis_is_a_loop_of_scenes():
    """The key stands elsewhere in a scene that has it."""
    grid = {"gap": WITH_LONG[1:], "interface.bumper_length": ["0 mm", SHORT, LONG]}
    text = scene_text(*FLOORS, records=RECORDS, grid=grid, gap=WITH_LONG[1])
    equals_the_loop(text, ("scene_resolved", "scene_sha256"), check_fraction=0.0)


def test_samples_count_their_lengths():
    """Closings of a scan's samples, and of the study that runs no contact: those without bumpers and each length."""
    lengths = {"interface.bumper_length": {"distribution": "uniform", "low": "5 mm", "high": "30 mm"}}
    study = uncertain_pulses(lengths, 4, bumper_length="10 mm")
    results = pr.scan(study)
    drawn = results["interface.bumper_length"].values
    assert np.array_equal(results["interface_bumper"].values[:, 0], drawn)
    text = scene_text(records={"generated": PULSES, "polarity": BOTH}, law="linear", gap="80 mm")
    closing = pr.scan(text)["peak_closing_free"].values
    found = results["peak_closing_free"].transpose("sample", ...).values
    # The row's solver and the pair's differ by rounding.
    np.testing.assert_allclose(found, closing + drawn.reshape(-1, *[1] * closing.ndim), rtol=1e-10)
    own, of_scan = pr.uncertainty(study), pr.uncertainty(results)
    for name in ("judged_probability", "required_gap", "required_gap_of_samples", "variance_share"):
        np.testing.assert_allclose(own[name], of_scan[name], rtol=1e-12)


def test_what_is_assessed_counts_them():
    plain = scanned(*MASSES, gaps=CLEAR, column_yield_force="inf")
    padded = scanned(*MASSES, gaps=WITH_LONG, column_yield_force="inf", bumper_length=LONG)
    one, other = (pr.assess(results).interfaces[0] for results in (plain, padded))
    assert [share.probability for share in one.contact] == [share.probability for share in other.contact]
    for without, required in zip(one.required, other.required, strict=True):
        assert required.gap == pytest.approx(without.gap + 0.03125, rel=1e-12)
    # Separations of codes are clear of bumpers, and so is the gap they are held against.
    tables = [separations_of(Results(results), 84.0) for results in (plain, padded)]
    np.testing.assert_allclose(tables[0].closing, tables[1].closing, rtol=1e-12)
    assert [rule.exceeded for rule in tables[0].rules] == [rule.exceeded for rule in tables[1].rules]
    assert "clear of the bumpers" in tables[1].rules[0].row.note
    # A part of the closing does not grow with the motion.
    assert is_linear(Results(plain))
    assert not is_linear(Results(padded))


def test_what_is_deeper_than_they_are_long_is_told():
    soft = {"law": "linear", "stiffness": "2 MN/m"}
    deep = scanned(*MASSES, gaps=WITH_SHORT, bumper_length=SHORT, **soft)
    assert float(deep["peak_penetration"].max()) > 0.015625
    assert any("more than the bumpers are long, 15.6 mm" in note for note in Results(deep).notes)
    none = scanned(*MASSES, gaps=WITH_SHORT, bumper_length="0 mm", **soft)
    assert not any("bumpers are long" in note for note in Results(none).notes)


def test_what_they_are_crushed_to_counts_what_stays():
    """With permanent_set a later contact begins in the dent, and its penetration is less than the bumpers are long."""
    keys = {
        "law": "viscous_elastoplastic",
        "stiffness": "5e9 N/m^1.5",
        "yield_force": "400 kN",
        "effects": {"permanent_set": {}},
    }
    records = {"names": ["RSN6-180"], "window": ["0 s", "12 s"], "pga": "0.6 g"}
    text = scene_text(*MASSES, gap="175 mm", bumper_length="160 mm", records=records, **keys)
    run, results = pr.simulate(text), pr.scan(text)
    closing = run["displacement"].isel(building=0) - run["displacement"].isel(building=1)
    crushed = 1e3 * (float(closing.max()) - 0.015)  # less the clear gap
    assert float(run["peak_penetration"].max()) < 0.16
    for notes in (json.loads(run.attrs["notes"]), Results(results).notes):
        (note,) = (each for each in notes if "bumpers are long" in each)
        assert f"penetration of {crushed:.3g} mm is more than the bumpers are long, 160 mm" in note


@pytest.mark.parametrize(
    "keys", [{"gap": "20 mm", "bumper_length": "40 mm"}, {"gap": "20 mm", "bumper_length": "-1 mm"}], ids=str
)
def test_what_does_not_fit_is_refused(keys, says):
    says(refusal(pr.read_scene, scene_text(*MASSES, **keys)))


def test_an_assessed_gap_that_they_do_not_fit_into_is_refused():
    padded = scanned(*MASSES, gaps=WITH_LONG, column_yield_force="inf", bumper_length=LONG)
    assert "bumpers of 31.25 mm do not fit into a gap of 30 mm" in refusal(pr.assess, padded, gap="30 mm")
    assert pr.assess(padded, gap=LONG).interfaces[0].gap == 0.03125


def test_a_start_within_them_is_refused():
    moved = single("frame", "500 t", "1.0 s", initial_displacement="15 mm"), MASSES[1]
    close, wide = (scene_text(*moved, gap="50 mm", bumper_length=length) for length in ("40 mm", "30 mm"))
    assert "10 mm of them clear of bumpers" in refusal(pr.read_scene, close)
    pr.read_scene(wide)


def test_drawings_show_and_name_the_bumpers(tmp_path):
    """In elevation, in the animation and in the explorer; to the scale of gaps, a line of bumpers at each point."""
    results = scanned(*FLOORS, gaps=WITH_LONG, bumper_length=LONG)
    case = row_case(results)
    figure = elevation_figure(case)
    widths = [patch.get_width() for patch in figure.axes[0].patches]
    assert widths.count(pytest.approx(gap_scale(case.gaps) * 0.03125)) == len(case.points) > 0
    assert "62.5 mm, bumpers of 31.25 mm" in " ".join(one.get_text() for one in figure.axes[0].texts)
    run = pr.simulate(scene_text(*FLOORS, records=RECORDS, gap=WITH_LONG[1], bumper_length=LONG))
    page = pr.animate(run, tmp_path / "run.html").read_text("utf-8")
    assert '"bumpers":[0.03125]' in page and "bumpers of 31.25 mm in it, drawn on the left face" in page
    page = pr.view(results, tmp_path / "grid.html").read_text("utf-8")
    assert "Closings and gaps required count the bumpers of 31.25 mm." in page


def test_the_deepest_contact_is_told_beside_the_length_of_its_own_sample():
    """Of two samples the one with the shorter bumpers goes deeper; the longer length is another sample's."""
    soft = {"law": "linear", "stiffness": "2 MN/m"}
    deep = scanned(*MASSES, gaps=WITH_SHORT, bumper_length=SHORT, **soft)
    depth = deep["peak_closing"] - deep["gap"]
    depth = 0.5 * depth / depth.max()
    closings = xr.concat([depth, 0.9 * depth], "sample") + deep["gap"]
    lengths = xr.DataArray([[0.02], [0.3]], dims=("sample", "interface"))
    drawn = deep.assign(peak_closing=closings).assign_coords(interface_bumper=lengths)
    (note,) = _beyond_bumpers(drawn)
    assert "penetration of 500 mm is more than the bumpers are long, 20 mm" in note
