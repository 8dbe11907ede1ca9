"""A row is assessed interface by interface: own gaps, own contact points, and what neighbours' pounding adds.

The dataset is made, not solved (`made_row`): numbers are held against those of its arrays.
"""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
import xarray as xr
from made_row import COLUMN_FORCE, STREET, made_row

from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.demands import motions_of
from pounding_risk.assessment.intensities import intensities
from pounding_risk.assessment.row import row_case, struck_columns
from pounding_risk.assessment.separations.table import at_contact, code_table
from pounding_risk.questions.assess import columns, sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.results.opened import Results

G = 9.80665
NAMES = [f"{one.name} | {other.name}" for one, other in pairwise(STREET)]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """All gaps vary together."""
    return made_row()


def test_each_interface_is_assessed_by_its_own_motions(results):
    found = assess(results)
    assert [one.name for one in found.interfaces] == NAMES
    for at, one in enumerate(found.interfaces):
        needed = results["peak_closing_free"].isel(interface=at, pga=1).values.ravel()
        np.testing.assert_array_equal(one.closing, np.sort(needed))
        assert one.gap == 0.02
        assert one.contact_at_gap().count == (needed > 0.02).sum()
        yields = results["yield_exceedance"].sel(gap=0.02, yield_force=4e5).isel(interface=at, pga=1).values
        (share,) = [each for each in one.yielding if each.gap == 0.02 and each.yield_force == 4e5]
        assert share.count == yields.sum()
    assert "the same ones" in " ".join(found.interfaces[0].verdict.evidence)


def test_where_one_gap_varies_the_others_keep_theirs():
    results = made_row(gaps=(0.0, 0.02, 0.05), named=1, own_gaps=(0.03, 0.02, 0.04, 0.04, 0.04))
    parts = {name: part.dataset for name, part in Results(results).interfaces}
    assert [list(parts[name]["gap"].values) for name in NAMES] == [[0.03], [0.0, 0.02, 0.05], *[[0.04]] * 3]
    # The others are seen beside the scene's own gap of the varied one, 20 mm, the second of the grid.
    count = results["impact_count"].isel(gap=1, interface=2, drop=True)
    np.testing.assert_array_equal(parts[NAMES[2]]["impact_count"].isel(gap=0, drop=True), count)
    assert set(parts[NAMES[2]]["contact_point_interface"].values) == {2}
    found = assess(results)
    assert [one.gap for one in found.interfaces] == [0.03, 0.02, 0.04, 0.04, 0.04]
    assert [one.yield_gap for one in found.interfaces] == [0.03, 0.02, 0.04, 0.04, 0.04]


def test_what_neighbours_push_across_a_gap_counts_as_contact(results):
    """Kiosk and Vault close nothing by themselves in this motion; a run in which they touch says that they do."""
    at, gap = 4, 1
    needed = results["peak_closing_free"].isel(interface=at)
    record, polarity, pga = (int(place) for place in np.argwhere(needed.values < 0.01)[0])
    pga = 1 if needed.values[record, polarity, 1] < 0.01 else pga
    place = {"record": record, "polarity": polarity, "pga": pga, "gap": gap, "interface": at}
    pushed = results.copy(deep=True)
    pushed["impact_count"][place] = 1
    pushed["peak_closing"][place] = 0.023
    before, after = (assess(each, pga=(0.2, 0.4)[pga] * G).interfaces[at] for each in (results, pushed))
    assert after.contact_at_gap().count == before.contact_at_gap().count + 1
    assert 0.023 in after.closing
    assert any(
        "brings it in 1 more, whose closings with contact the required gaps count" in each
        for each in after.verdict.evidence
    )
    # The motion's closing without contact stays what it is, and so do rules of codes beside it.
    motions = motions_of(Results(pushed).interfaces[at][1])
    assert (motions.closing > motions.alone).sum() == 1
    # Pushing does not grow with the motion: a capacity is then not had by scaling.
    assert {each.method for each in after.fragility if each.what == "contact"} == {"multiple stripes"}


def test_contact_in_a_row_is_what_the_run_does_as_in_its_drawings(results):
    """A motion that closes the gap alone, and whose run at it shows no touch, is no contact; the sentence names it."""
    at = 1
    before = assess(results).interfaces[at]
    held = results.copy(deep=True)
    closes = results["peak_closing_free"].isel(interface=at, pga=1).values > before.gap
    record, polarity = (int(place) for place in np.argwhere(closes)[0])
    held["impact_count"][{"record": record, "polarity": polarity, "pga": 1, "interface": at}] = 0
    after = assess(held).interfaces[at]
    (told,) = [each for each in after.verdict.evidence if "; contact elsewhere prevents it in 1" in each]
    assert told.startswith(
        f"The free relative motion, without contact elsewhere in the row, closes the gap in {closes.sum()}"
    )
    assert not any("prevents" in each for each in before.verdict.evidence)
    assert after.contact_at_gap().count == before.contact_at_gap().count - 1
    assert after.required == before.required  # by what the motions close, on the safe side
    for each in (results, held):
        drawn = row_case(each).touches
        judged = [one.contact_at_gap().probability for one in assess(each).interfaces]
        assert judged == [touch.contact for touch in drawn]
    # At a gap that the grid has not nothing is known of runs.
    assert not any("prevents" in each for each in assess(held, gap=0.0123).interfaces[at].verdict.evidence)


@pytest.mark.complete
def test_columns_yield_at_their_own_force_where_floors_never_do(results):
    one = assess(results).interfaces[1]  # floors against columns
    (share,) = [each for each in one.yielding if each.gap == 0.02 and np.isinf(each.yield_force)]
    yields = results["yield_exceedance"].sel(gap=0.02, yield_force=np.inf).isel(interface=1, pga=1).values
    assert share.count == yields.sum() > 0
    floors_only = assess(results).interfaces[0]
    assert {each.yield_force for each in floors_only.yielding} == {4e5}


def test_rules_of_codes_take_displacements_where_buildings_touch(results):
    """Theatre's roof, 9.2 m, meets Tower 7/8 up its third storey."""
    name, part = Results(results).interfaces[2]
    one = part.dataset
    assert name == "Theatre | Tower"
    free = results["storey_displacement_free"]
    tower = free.sel(building="Tower", storey=2) * 0.125 + free.sel(building="Tower", storey=3) * 0.875
    np.testing.assert_allclose(at_contact(one, 1), tower, rtol=1e-12)  # the order of products
    np.testing.assert_array_equal(at_contact(one, 0), free.sel(building="Theatre", storey=2))
    asked = at_contact(one, 0) + at_contact(one, 1)
    table = code_table(one)
    np.testing.assert_allclose(table.asked["abs"], asked.isel(pga=1).values.ravel(), rtol=1e-12)
    # A rigid building does not move, whatever its storeys.
    assert float(at_contact(Results(results).interfaces[4][1].dataset, 1).max()) == 0.0


def test_heights_and_levels_of_the_row_are_the_codes_site(results):
    aligned, column = (code_table(Results(results).interfaces[at][1].dataset) for at in (0, 2))
    rules = [{each.row.rule: each.row for each in table.rules} for table in (aligned, column)]
    needing = [name for name, row in rules[0].items() if row.note.startswith("needs height")]
    assert needing == []
    assert any("floors" in rules[1][name].note and "floors" not in rules[0][name].note for name in rules[0])


def test_sa_of_a_building_with_storeys_is_that_of_the_records(results):
    """A flat spectrum has one Sa at any period, scaled as the record is."""
    flat = results.copy(deep=True)
    flat["record_spectral_acceleration"][:] = 5.0
    one = Results(flat).interfaces[0][1]
    factors = np.repeat(np.array([0.2, 0.4]) * G / flat["record_pga"].values[:, None], 2, axis=0)
    np.testing.assert_allclose(intensities(one, "sa(Corner)"), 5.0 * factors, rtol=1e-12)
    # A single mass has its own, exactly: (2π/T)² times its displacement.
    kiosk = intensities(Results(flat).interfaces[3][1], "sa(Kiosk)")
    peak = flat["peak_displacement_free"].sel(building="Kiosk").values.reshape(12, 2)
    np.testing.assert_allclose(kiosk, peak * (2 * np.pi / 0.20) ** 2, rtol=1e-12)


@pytest.mark.parametrize(
    ("effects", "method"),
    [("p_delta = {}", "scaled motions"), ("inelastic_storeys = {hardening = 0.03}", "multiple stripes")],
)
def test_only_linear_buildings_have_capacities_by_scaling(effects, method):
    one = assess(made_row(effects=effects), gap=0.08).interfaces[3]
    assert {each.method for each in one.fragility if each.what == "contact" and not each.fault} == {method}


def test_struck_columns_come_first_with_their_counts(results):
    """Counted on the arrays: the column whose strength is reached most often, of those that are struck most."""
    found, kinds = assess(results), results["contact_point_kind"].values
    force = results["yield_force"].values.tolist().index(Results(results).scene_force)
    case = {"pga": 1, "contact_model": 0, "gap": 1, "yield_force": force}
    for at, one in enumerate(found.interfaces):
        places = np.flatnonzero((results["contact_point_interface"].values == at) & (kinds == "column"))
        assert bool(one.columns) is bool(places.size)
        assert one.verdict.conclusion[: len(one.columns)] == one.columns
        if not places.size:
            continue
        struck = struck_columns(Results(results).interfaces[at][1], 1, 0.02)
        part = results.isel(case)
        touched = (part["contact_point_impact_count"] > 0).isel(contact_point=places)
        reached = touched & (part["contact_point_yield_exceedance"] > 0).isel(contact_point=places)
        axes = ("record", "polarity")
        assert [each.touched for each in struck] == touched.sum(axes).values.tolist()
        assert [each.reached for each in struck] == reached.sum(axes).values.tolist()
        assert {each.strength for each in struck} == {COLUMN_FORCE}
    # Theatre's roof, 9.2 m, meets Tower 7/8 up its third storey.
    (worst, after) = found.interfaces[2].columns
    assert "Floor 2 of Theatre strikes the columns of storey 3 of Tower, 9.2 m above the ground" in worst
    assert "unsafe" in after
    # What holds of several interfaces is said once, behind what is of one each.
    told = columns(found)
    shared = [line for line in told if line.endswith(after)]
    places = [one.name for one in found.interfaces if after in one.columns]
    assert shared == [f"{'; '.join(places)}: {after}"] and len(places) > 1 and told[-len(shared) :] == shared


def test_what_is_assumed_after_the_strength_follows_from_the_forces(results):
    """A force that stays at the strength is a plateau; a larger one is a law without a cap."""
    at = 2
    flat, grown = results.copy(deep=True), results.copy(deep=True)
    columns = {"contact_point": results["contact_point_kind"].values == "column"}
    flat["contact_point_peak_contact_force"][columns] = COLUMN_FORCE
    grown["contact_point_peak_contact_force"][columns] = 3.0 * COLUMN_FORCE
    assert "keep it at any displacement and, by most laws, spring back whole" in assess(flat).interfaces[at].columns[1]
    assert "goes up to 900 kN" in assess(grown).interfaces[at].columns[1]


def test_equal_counts_with_another_verdict_say_why(results):
    found = assess(results)
    one, other = found.interfaces[:2]
    here = one.contact_at_gap()
    alike = replace(other, gap=one.gap, contact=(here,), verdict=replace(other.verdict, word="unlike", independent=3.0))
    (sentence,) = replace(found, interfaces=(one, alike)).unlike_verdicts
    assert (
        f"{here.count} of {here.runs} motions touch at both" in sentence and "effective sample size of 3." in sentence
    )
    assert not replace(found, interfaces=(one, replace(alike, verdict=one.verdict))).unlike_verdicts


@pytest.mark.complete
def test_an_infinite_force_is_not_called_no_yielding_where_columns_yield(results, capsys):
    print_sheet(sheet(assess(results)))
    tables = capsys.readouterr().out.split("response against F_E")[1:]
    assert any("columns' own" in table.partition("Medians over")[0] for table in tables)
    one = assess(results).interfaces[1]  # floors against columns
    assert not any("no yielding" in influence.words for influence in one.sensitivity)
