"""Samples with one motion each: how many outcomes count, coverage of the bounds, and what such a design can tell."""

from __future__ import annotations

import json

import numpy as np
import pytest
from scipy.stats import beta, binom, norm
from sentences import refusal
from uncertain import PERIODS, uncertain_pulses

import pounding_risk as pr
from pounding_risk.assessment.along import assess_along
from pounding_risk.assessment.uncertain_words import parts_words
from pounding_risk.errors import PoundingError
from pounding_risk.figures.uncertainty import uncertainty_figure
from pounding_risk.questions.uncertainty import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.results.files import open_results, save
from pounding_risk.statistics.closings import Clusters, DrawnClosings, analysed_clusters, motion_share
from pounding_risk.studies.uncertainty import AT_ONCE, ONE_BY_ONE, free_motion

CONFIDENCE = 0.95


def drawn(rng, samples, recordings, deviations, of_one=1):
    """ln closing = a_s + b_m + c_sm of samples with one motion each, b common to the motions of a recording."""
    of_samples, of_motions, rest = deviations
    motions = rng.permutation(np.arange(samples) % (recordings * of_one))
    own = np.sqrt(0.5) if of_one > 1 else 1.0  # of what motions of a recording share, half is their own
    shared = own * rng.normal(size=recordings)[motions // of_one]
    shared += np.sqrt(1.0 - own**2) * rng.normal(size=recordings * of_one)[motions]
    noise = of_samples * rng.normal(size=samples) + rest * rng.normal(size=samples)
    return of_motions * shared + noise, motions, motions // of_one


def drawn_scene(samples=56, numbers=None, **more):
    """Of which each sample has one motion."""
    return uncertain_pulses(numbers, samples, motions="drawn", **more)


def test_components_are_those_of_the_one_way_analysis_of_variance():
    """With as many samples of each motion: between motions (MSB − MSW)/n, and within them MSW."""
    values, motions, _ = drawn(np.random.default_rng(1), 60, 12, (0.5, 1.0, 0.5))
    found = analysed_clusters(values, motions, motions)
    means = np.array([values[motions == one].mean() for one in range(12)])
    within = sum(((values[motions == one] - means[one]) ** 2).sum() for one in range(12)) / 48
    assert found.all.motions == pytest.approx(means.var(ddof=1) - within / 5)
    assert found.all.samples == pytest.approx(within)
    left = motions != 3
    without = analysed_clusters(values[left], np.unique(motions[left], return_inverse=True)[1], motions[left]).all
    assert found.without_recording.motions[3] == pytest.approx(without.motions)


def test_components_have_no_bias_where_motions_share_recordings():
    rng = np.random.default_rng(2)
    found = np.array([
        analysed_clusters(*drawn(rng, 90, 10, (0.6, 0.8, 0.4), of_one=3)).all for _ in range(300)
    ])  # fmt: skip
    error = found.std(axis=0) / np.sqrt(300)
    for at, expected in ((0, 0.36 + 0.16), (1, 0.64)):
        assert abs(found[:, at].mean() - expected) < 4.0 * error[at]
    # Of pairs of one recording 2/3 or so are of two motions, which share half.
    assert 0.32 < found[:, 3].mean() < 0.64


def test_independent_outcomes_are_those_of_a_mean_over_clusters():
    """The variance of a mean over clusters, in closed form; samples alone, and recordings alone, are its limits."""
    alone, apart = Clusters(40, 1.0 / 8.0, 1.0), Clusters(40, 1.0 / 8.0, 0.0)
    assert alone.independent(np.array([0.0])) == pytest.approx(8.0)
    assert apart.independent(np.array([0.0])) == pytest.approx(40.0)
    half = Clusters(40, 1.0 / 8.0, 0.5).independent(np.array([0.0]))
    covariance = np.kron(np.eye(8), np.full((5, 5), 0.5)) + 0.5 * np.eye(40)
    assert half == pytest.approx(1.0 / covariance.mean())
    assert Clusters(40, 1.0 / 8.0, 0.5).times(1, 2).motions == pytest.approx(16.0)
    assert Clusters(40, 1.0 / 8.0, 0.5).times(1, 9).motions == pytest.approx(40.0)


def test_bounds_without_contact_are_those_of_the_recordings():
    values, motions, recordings = drawn(np.random.default_rng(3), 200, 10, (1.0, 0.1, 0.0))
    here = DrawnClosings(np.exp(values), motions, recordings).contact(1e9, CONFIDENCE)
    assert here.value[0] == 0.0 and here.low[0] == 0.0
    assert here.high[0] == pytest.approx(beta.ppf(0.975, 1.0, 10.0))


def test_samples_of_recordings_of_their_own_have_the_binomial_bounds():
    values, motions, recordings = drawn(np.random.default_rng(4), 30, 30, (0.5, 0.5, 0.5))
    closings = DrawnClosings(np.exp(values), motions, recordings)
    count = int((values > 0.3).sum())
    here = closings.contact(np.exp(0.3), CONFIDENCE)
    assert here.low[0] == pytest.approx(beta.ppf(0.025, count, 31 - count))
    assert here.high[0] == pytest.approx(beta.ppf(0.975, count + 1, 30 - count))


@pytest.mark.parametrize(
    ("samples", "recordings", "deviations", "of_one"),
    [
        (64, 22, (0.5, 0.5, 0.2), 1),
        (256, 22, (0.2, 0.6, 0.2), 1),
        (256, 11, (0.6, 0.3, 0.3), 2),
        (512, 20, (0.0, 1.0, 0.0), 2),
    ],
)
def test_bounds_hold_the_true_probability_and_the_true_gap(samples, recordings, deviations, of_one):
    """At 95 %, over 60 draws from the known distribution: no fewer than 95 % less what chance leaves (1 in 1000)."""
    rng, repeats = np.random.default_rng(5), 60
    deviation = float(np.sqrt(np.sum(np.square(deviations))))
    level = norm.ppf(0.8) * deviation
    held = np.zeros(2)
    for _ in range(repeats):
        values, motions, labels = drawn(rng, samples, recordings, deviations, of_one)
        closings = DrawnClosings(np.exp(values), motions, labels)
        here = closings.contact(np.exp(level), CONFIDENCE)
        held[0] += here.low[0] <= 0.2 <= here.high[0]
        (required,) = closings.required((80.0,), CONFIDENCE)
        held[1] += required.low <= np.exp(level) and (not required.bounded or np.exp(level) <= required.high)
    assert held.min() >= binom.ppf(0.001, repeats, CONFIDENCE), held


def test_bounds_that_count_samples_as_independent_would_not_hold():
    rng, held = np.random.default_rng(6), 0
    for _ in range(120):
        values, *_ = drawn(rng, 512, 20, (0.0, 1.0, 0.0), 2)
        count = int((values > norm.ppf(0.8)).sum())
        held += beta.ppf(0.025, count, 513 - count) <= 0.2 <= beta.ppf(0.975, count + 1, 512 - count)
    assert held < binom.ppf(0.001, 120, CONFIDENCE) / 2


def test_the_share_of_the_motions_is_that_of_the_model():
    rng, held, repeats = np.random.default_rng(7), 0, 150
    for _ in range(repeats):
        value, low, high = motion_share(analysed_clusters(*drawn(rng, 200, 25, (0.8, 0.6, 0.0))), CONFIDENCE)
        held += low <= 0.36 <= high
        assert low < value < high
    assert held >= binom.ppf(0.001, repeats, 0.92)  # the jackknife's bounds are symmetric, the estimate is not


@pytest.fixture(scope="module")
def scanned():
    return pr.scan(drawn_scene(), check_fraction=0.0)


@pytest.fixture(scope="module")
def of_scene():
    return pr.uncertainty(drawn_scene())


@pytest.mark.complete
def test_what_is_said_is_that_of_the_samples_themselves(scanned):
    """P(contact) is the share of the samples whose run touches; each closing is that of a scan of its own."""
    part = pr.uncertainty(scanned, target="20 %").isel(interface=0)
    touches = scanned["impact_count"].values.reshape(56) > 0
    assert float(part["judged_probability"]) == touches.mean()
    alone = scanned["peak_closing_free"].values.ravel()
    assert np.array_equal(part["closing_of_sample"], alone)
    (of_one,) = pr.assess(scanned.isel(sample=[5])).interfaces
    assert of_one.closing == (alone[5],)
    assert float(part["required_gap"].sel(percentile=80)) == pytest.approx(
        np.percentile(alone, 80, method="inverted_cdf")
    )
    assert float(part["independent_motions"]) == pytest.approx(7.0, abs=0.1)  # each with 8 of the samples, or about
    assert list(part["component"].values) == ["parameters and interaction", "motions", "total"]
    assert str(part["chosen_output"].item()) == "contact"
    for lacking in ("contact_probability_of_sample", "samples_over_target", "required_gap_of_samples"):
        assert lacking not in part
    assert "one of 14 motions of 7 recordings drawn with each" in str(part["sentence"].item())
    assert any("bounds count recordings" in one for one in json.loads(part.attrs["assumptions"]))


@pytest.mark.complete
def test_a_scene_without_contact_says_what_its_scan_says(scanned, of_scene):
    of_scan = pr.uncertainty(scanned)
    for name in ("contact_probability", "contact_probability_high", "required_gap", "dispersion", "first_order"):
        np.testing.assert_allclose(of_scene[name], of_scan[name], rtol=1e-9, atol=1e-9, equal_nan=True)
    assert of_scene.attrs["motions"] == of_scan.attrs["motions"]
    np.testing.assert_allclose(of_scene["fragility_median"], of_scan["fragility_median"], rtol=1e-9)


@pytest.mark.complete
def test_free_motion_of_a_drawn_motion_is_that_among_all():
    """At the same points, by both ways of solving: that of the sample's motion in a run of every motion."""
    for effects in (None, {"wave_passage": {"velocity": "500 m/s", "distance": "20 m"}}):
        numbers = PERIODS | {"building.left.damping": {"distribution": "uniform", "low": 0.02, "high": 0.1}}
        study = drawn_scene(12, numbers, effects=effects)
        points = study.uncertain.points()
        one, every = (
            free_motion(study),
            free_motion(drawn_scene(12, numbers | {"motions": "all"}, effects=effects), points[:, :-1]),
        )
        motions = study.uncertain.drawn_motions(7, 2)
        both = every["peak_closing_free"].values[np.arange(12), motions.records, motions.polarities]
        assert np.array_equal(one["peak_closing_free"].values, both)
        assert one.attrs["free_motion"] == every.attrs["free_motion"] == (ONE_BY_ONE if effects else AT_ONCE)
        assert one["record"].values.tolist() == [str(every["record"].values[at]) for at in motions.records]


def test_fragilities_are_of_the_motions_and_numbers_together(scanned):
    """ln capacity of a sample is ln(gap/closing × PGA of its motion); what motions do alone is not told."""
    part = pr.uncertainty(scanned, intensity="pga").isel(interface=0)
    capacity = np.log(0.08 / part["closing_of_sample"].values * scanned["record_pga"].values)
    assert float(part["fragility_median"].sel(curve="total")) == pytest.approx(np.exp(capacity.mean()))
    assert np.isnan(float(part["fragility_dispersion"].sel(curve="motions alone")))
    records = scanned["record"].values
    labels = [f"{name} {sign}" for name, sign in zip(records, scanned["polarity"].values, strict=True)]
    motions, recordings = (np.unique(one, return_inverse=True)[1] for one in (labels, records))
    total = analysed_clusters(capacity, motions, recordings).all.total
    assert float(part["fragility_dispersion"].sel(curve="total")) == pytest.approx(np.sqrt(total))


def test_an_output_of_contact_is_read_from_a_dataset(scanned):
    part = pr.uncertainty(scanned, output="peak_displacement").isel(interface=0)
    assert part["output"].values.tolist() == ["contact", "log_closing", "peak_displacement"]
    assert np.isfinite(part["first_order_of_motions"].values).all()
    assert "under the sample's motion" in str(part["output_words"].values[-1])


def test_what_drawn_motions_cannot_tell_is_refused_with_the_repair(scanned, says):
    says(refusal(pr.uncertainty, drawn_scene(), sobol=8), refusal(pr.uncertainty, scanned, output="required_gap"))
    for call in (pr.assess, lambda one: pr.report(one, "never.html"), lambda one: pr.view(one, "never.html")):
        with pytest.raises(PoundingError, match=r"--select 'sample=0'"):
            call(scanned)


def test_an_axis_beside_the_samples_is_assessed_one_value_at_a_time(scanned, says):
    says(refusal(assess_along, scanned))
    study = drawn_scene(2, grid={"building.right.mass": ["700 t", "800 t"]})
    beside = pr.scan(study, check_fraction=0.0)
    says(refusal(assess_along, beside))
    assert pr.uncertainty(beside.isel({"building.right.mass": [1]})).sizes["sample"] == 2


def test_too_few_samples_to_tell_what_motions_do():
    few = pr.uncertainty(drawn_scene(4)).isel(interface=0)
    assert "draw more samples for the motions' share" in parts_words(few)
    assert uncertainty_figure(few.expand_dims("interface")) is not None


def test_the_figure_has_the_motion_beside_the_numbers(of_scene):
    figure = uncertainty_figure(of_scene)
    assert "the motion" in [label.get_text() for label in figure.axes[1].get_yticklabels()]
    assert not any("of samples" in label for label in figure.axes[0].get_legend_handles_labels()[1])


def test_what_is_printed_leaves_out_what_drawn_motions_do_not_tell(of_scene, capsys):
    print_sheet(sheet(of_scene))
    printed = capsys.readouterr().out
    assert "the motion " in printed and "\nuncertain numbers, alone and together with the motions  " in printed
    assert "5 % of samples" not in printed and "motions alone" not in printed and "nan" not in printed


def test_histories_of_a_sample_are_those_of_its_motion(scanned, tmp_path):
    save(scanned, tmp_path / "r.nc")
    made = open_results(pr.histories(tmp_path / "r.nc", tmp_path / "h.nc", select=["sample=5"]))
    assert made.sizes["record"] == 1 and made["record"].item() == scanned["record"].values[5]
    assert made["polarity"].values.tolist() == [scanned["polarity"].values[5]]
