"""What is asked for and concluded: targets, percentiles, recordings that would settle a verdict, and setbacks."""

import doctest

import numpy as np
import pytest
import xarray as xr
from scenes import BOTH, rigid, scene_text, single, storeyed
from scipy.stats import binom
from sentences import refusal, refusals

import pounding_risk as pr
from pounding_risk.assessment import options as assessment_options
from pounding_risk.assessment.options import NO_LOWER, NO_UPPER, percentile_for, percentile_of, read_criterion
from pounding_risk.assessment.verdict import Basis, conclusion, recordings_to_settle, sample_size
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions import intensity as measures
from pounding_risk.motions.read import read_motion
from pounding_risk.questions.setback import sheet
from pounding_risk.scene.reader import parse_scene
from pounding_risk.statistics.required_gap import RequiredGap, RunGaps, target_left_by

BOUNDED = RequiredGap(90.0, 0.092, 0.076, 0.115, True, 0.09)
UNBOUNDED = RequiredGap(90.0, 0.092, 0.076, 0.1, False, 0.09)


def basis(contacts: int, motions: int, *, target: float = 0.1, **more: object) -> Basis:
    """Motions that are each a recording of their own, unless told otherwise."""
    given = {"recordings": motions, "independent": float(motions), "required": BOUNDED, "still_closing": 1, "lost": 0}
    given |= {"amplitude": "at 0.3 g", "hangs_on_polarity": False, "gap": 0.08} | more
    return Basis(criterion=read_criterion(target), contacts=contacts, motions=motions, **given)


@pytest.mark.parametrize("target", [0.01, 0.1, 0.16, 0.3])
def test_without_contact_the_number_is_that_of_the_power_law(target):
    """The upper bound of none in n is 1 - 0.025^(1/n): the least n by trial, since P(none) = (1 - target)^n."""
    needed = next(n for n in range(1, 1000) if (1.0 - target) ** n <= 0.025)
    assert recordings_to_settle(basis(0, 5, target=target)) == needed


@pytest.mark.parametrize(("contacts", "motions", "target"), [(1, 20, 0.1), (1, 4, 0.1), (3, 10, 0.16), (1, 10, 0.16)])
def test_the_bounds_leave_the_target_where_the_binomial_tails_say(contacts, motions, target):
    """At whole counts, k of n for each multiple of the motions: the bound is past the target where the tail of the
    binomial distribution at the target is no more than 2.5 %."""
    needed = recordings_to_settle(basis(contacts, motions, target=target))
    for factor in range(1, 60):
        count, runs = factor * contacts, factor * motions
        few = binom.cdf(count, runs, target) <= 0.025  # so few would be rare at the target
        many = binom.sf(count - 1, runs, target) < 0.025  # so many would be
        assert bool(few or many) is (runs >= needed), (count, runs)


def test_recordings_count_for_what_they_are_worth():
    """Two motions of a recording that are worth one: twice the motions, the same recordings."""
    alone = recordings_to_settle(basis(1, 20))
    assert recordings_to_settle(basis(2, 40, recordings=20, independent=20.0)) == alone
    assert recordings_to_settle(basis(2, 40, recordings=20, independent=40.0)) == pytest.approx(alone / 2, abs=1)


def test_independent_motions_are_counted_in_recordings_too():
    """At a target of 10 %, of recordings that count for 7/6 of a motion each."""
    assert 0.9**36 <= 0.025 < 0.9**35
    assert "takes at least 36 independent motions." in sample_size(basis(1, 20))
    told = sample_size(basis(1, 24, recordings=12, independent=14.0))
    assert told.endswith("takes at least 36 independent motions, those of 31 such recordings.")  # 30 · 7 / 6 = 35


def test_a_share_at_the_target_is_never_settled():
    assert recordings_to_settle(basis(2, 20)) is None
    assert recordings_to_settle(basis(0, 20, lost=4)) is None  # 4 of 24 may have closed it, or none: both sides
    told = " ".join(conclusion(basis(2, 20), None))
    assert "More recordings do not settle the gap of 80 mm while 10 % of the motions close it" in told


def test_a_settled_one_needs_no_more():
    assert recordings_to_settle(basis(0, 40)) <= 40
    assert recordings_to_settle(basis(40, 40)) <= 40


def test_the_conclusion_is_the_one_that_can_be_signed(says):
    """Of 3 contacts in 20, and of 1: how many more recordings settle it is counted by other tests."""
    for contacts in (3, 1):
        told = conclusion(basis(contacts, 20), None)
        more = recordings_to_settle(basis(contacts, 20)) - 20
        says([sentence.replace(f"About {more} more", "About so many more") for sentence in told])


def test_a_gap_that_is_enough_in_the_runs_alone_is_not_enough_at_a_confidence():
    """92 mm by the motions, 100 mm in a run, and nothing was run at the upper bound."""
    between = RequiredGap(90.0, 0.092, 0.076, 0.115, False, 0.09, 0.1, True)
    (_, told, *_) = conclusion(basis(3, 20, required=between, run=RunGaps(0.1, (0.05, 0.1)), free=0.0841), None)
    assert told.startswith("Provide 100 mm for") and "without a push by neighbours 84.1 mm would do" in told
    assert "No gap is shown to be enough at 95 % confidence: the row was run at gaps of up to 100 mm" in told


def test_an_answer_asks_for_no_more_recordings(says):
    """Adequate or not, and where nothing is required."""
    nothing = RequiredGap(90.0, 0.0, 0.0, 0.0, True, 0.0)
    says(conclusion(basis(0, 40), True), conclusion(basis(30, 40), False))
    says(conclusion(basis(0, 40, required=nothing), True))


def test_what_has_no_bound_says_so_and_what_it_takes(says):
    """One of three recordings, worth a motion each: (1 - 0.1)^36 is the first below 2.5 %."""
    for required in (UNBOUNDED, RequiredGap(90.0, 0.092, 0.0, 0.1, False, 0.09)):
        (_, provide, *_) = conclusion(basis(1, 3, required=required), None)
        says(provide)


def test_a_verdict_that_hangs_on_the_polarity_is_not_settled_by_more():
    told = conclusion(basis(20, 40, hangs_on_polarity=True), None)
    assert "It depends on the polarity of the records, which more of them need not decide." in told


def test_examples_in_docstrings_are_right():
    assert doctest.testmod(assessment_options).failed == 0


@pytest.mark.parametrize("value", [0.84, 84, "0.84", "84", "84 %", "84%"])
def test_a_percentile_is_the_same_however_it_is_written(value):
    assert read_criterion(percentile=value) == (0.16, 84.0, 0.95)


@pytest.mark.parametrize("value", [0.1, 10, "0.1", "10", "10 %"])
def test_a_target_asks_for_the_percentile_that_leaves_it(value):
    assert read_criterion(target=value) == (0.1, 90.0, 0.95)
    assert read_criterion(target=value).target_percentile == 90.0


@pytest.mark.parametrize("value", [0.9, 90, "90 %"])
def test_a_confidence_is_the_same_however_it_is_written(value):
    assert read_criterion(confidence=value) == (0.16, 84.0, 0.9)


def test_one_percent_less_than_all_is_no_rounding():
    """Each percentile in thousandths leaves a target from which the same percentile follows."""
    for thousandths in range(50_001, 100_000, 7):
        percentile = thousandths / 1000
        target = target_left_by(percentile)
        assert percentile_for(target) == percentile_of(percentile) == percentile
        assert read_criterion(target, percentile).agrees


WRONG = {
    "percentile": ("0.9 %", 10, 50, 100, 1, 16, float("nan")),
    "target": (84, 0.99, 0, -0.1, 1e-12, True, "ten", [0.1]),
    "confidence": (0.3, 1.0),
}


def test_what_cannot_be_meant_is_refused(says):
    """Among them a percentile in the target's place, and a target in the percentile's."""
    says(*refusals(read_criterion, wrong=WRONG))


def test_what_was_read_is_told_and_which_the_verdict_uses(says):
    both = read_criterion("10 %", 84)
    assert not both.agrees and both.target_percentile == 90.0
    says([criterion.words for criterion in (read_criterion(target="10 %"), both, read_criterion(0.16, 84))])


RECORDS = ["RSN6-180", "CCC-HN1", "NAPA-HNE"]


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Three records in both polarities; no gap so wide is ever closed, so that nothing is simulated."""
    sides = (single(name, "10 t", f"{period} s", damping=0.05) for name, period in (("left", 0.5), ("right", 0.8)))
    records = {"names": RECORDS, "polarity": BOTH}
    return scan(parse_scene(scene_text(*sides, law="linear", gap="9 m", records=records)), check_fraction=0.0)


def peaks_of(period: float) -> np.ndarray:
    """Spectral displacement of each record, from the motions alone."""
    motions = [read_motion(name) for name in RECORDS]
    return np.array(
        [measures.response_spectra([one.acceleration], one.dt, [period]).displacement[0, 0] for one in motions]
    )


def test_a_setback_is_the_buildings_own_peak_displacement(results):
    """Every motion stays within the setback of all: the largest spectral displacement, and polarity changes nothing."""
    left, right = pr.setbacks(results, percentile="99 %")
    for one, period in ((left, 0.5), (right, 0.8)):
        largest = peaks_of(period).max()
        assert one.motions == 6 and one.independent == pytest.approx(3.0)
        # Both find the maximum between samples, each in its own way: 1e-9 apart, and the percentile may interpolate.
        assert one.required[-1].high == pytest.approx(largest, rel=1e-7)
        assert one.distance <= largest * (1.0 + 1e-7) and not one.required[-1].bounded
    assert [one.building for one in (left, right)] == ["left", "right"]


def test_a_rigid_building_needs_no_setback(results):
    still = results.copy()
    still["peak_displacement_free"] = results["peak_displacement_free"] * xr.DataArray([0.0, 1.0], dims="building")
    assert [one.distance > 0.0 for one in pr.setbacks(still)] == [False, True]


def test_marks_are_explained_in_a_paragraph_as_a_list_has_marks_of_its_own(results):
    blocks = sheet(pr.setbacks(results))
    assert [block["kind"] for block in blocks] == ["table", "paragraph", "list"]
    assert blocks[1]["text"].startswith(NO_LOWER) and f" {NO_UPPER} " in blocks[1]["text"]
    assert not any(item.startswith((NO_LOWER, NO_UPPER)) for item in blocks[2]["items"])


def test_a_setback_is_not_the_centres_where_floors_rotate_and_names_links():
    plan = {"face": ["-6 m", "6 m"], "eccentricity": "2 m", "gyration": "4 m", "torsional_ratio": 1.1}
    turning = storeyed("C", "90 t", "80 MN/m", storeys=2, plan=plan)
    law = {"gap": "0.5 m", "contact_model": "linear", "stiffness": "1e5 kN/m"}
    records = {"window": ["0 s", "4 s"]}
    row = (storeyed("A", "90 t", "80 MN/m", storeys=2), storeyed("B", "60 t", "80 MN/m", storeys=2), turning)
    of_row = pr.setbacks(
        pr.scan(scene_text(*row, interfaces=[law | {"link_stiffness": "9 MN/m"}, law], records=records))
    )
    assert [bool(one.required) for one in of_row] == [True, True, False]
    assert "links to B" in of_row[0].note and "links to A" in of_row[1].note and "links" not in of_row[2].note
    assert "rigid = true" in refusal(lambda: of_row[2].distance)
    assert of_row[2].note in str(sheet(of_row))
    # At a wall the ends of the face are known: they move further than the centre.
    at_wall = pr.scan(scene_text(turning, rigid(), interfaces=[law], records=records | {"polarity": BOTH}))
    assert at_wall["peak_closing_free"].max() > 1.1 * at_wall["peak_displacement_free"].max()


def test_a_dataset_that_is_none_is_refused(results, says):
    says(
        refusal(pr.setbacks, results.drop_vars("peak_displacement_free")),
        refusal(pr.setbacks, results.assign(peak_displacement_free=results["peak_displacement_free"] * np.nan)),
    )
