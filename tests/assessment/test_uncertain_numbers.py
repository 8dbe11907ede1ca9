"""What uncertain numbers mean: from the motion without contact, from a scan, and with one motion a sample."""

import json
import re

import numpy as np
import pytest
from scenes import BOTH, scene_text, single
from scipy.special import ndtri
from scipy.stats import beta, binom, norm
from sentences import refusal
from uncertain import LEFT, PERIODS, PULSES, RIGHT, uncertain_pulses

import pounding_risk as pr
from pounding_risk.assessment.along import assess_along
from pounding_risk.assessment.options import read_criterion
from pounding_risk.assessment.uncertain_samples import independent_points
from pounding_risk.assessment.uncertain_words import parts_words, words_of_number
from pounding_risk.errors import PoundingError
from pounding_risk.figures.uncertainty import uncertainty_figure
from pounding_risk.questions.uncertainty import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.results.files import open_results, save
from pounding_risk.scene.reader import parse_scene
from pounding_risk.statistics.closings import Clusters, DrawnClosings, analysed_clusters, motion_share
from pounding_risk.studies.uncertainty import AT_ONCE, ONE_BY_ONE, free_motion


@pytest.fixture(scope="module")
def scanned():
    return pr.scan(uncertain_pulses())


@pytest.fixture(scope="module")
def of_scene():
    return pr.uncertainty(uncertain_pulses(), sobol=8)


@pytest.mark.complete
def test_samples_together_are_the_assessments_of_each(scanned):
    together = pr.uncertainty(scanned, target="20 %").isel(interface=0)
    closings, shares = [], []
    for sample in range(scanned.sizes["sample"]):
        (alone,) = pr.assess(scanned.isel(sample=[sample]), target="20 %").interfaces
        closings.append(alone.closing)
        shares.append(alone.contact_at_gap().probability)
    assert float(together["judged_probability"]) == pytest.approx(np.mean(shares))
    np.testing.assert_allclose(together["contact_probability_of_sample"], shares)
    assert float(together["samples_over_target"]) == np.mean(np.array(shares) > 0.2)
    required = together["required_gap"].sel(percentile=80)
    assert float(required) == pytest.approx(np.percentile(closings, 80, method="inverted_cdf"))
    apart = np.percentile(np.percentile(closings, 80, axis=1, method="inverted_cdf"), 50)
    assert float(together["required_gap_of_samples"].sel(percentile=80, sample_percentile=50)) == pytest.approx(apart)
    over = together["contact_probability"].sel(gap=0.05, method="nearest")
    assert float(over) == pytest.approx((np.array(closings) > float(over["gap"])).mean())


def test_in_a_row_what_others_push_counts_as_in_each_assessment():
    """Soft neighbours of a heavy block: contact on one side closes the other gap in some runs."""
    buildings = (single("A", "900 t", "0.9 s"), single("B", "90 t", "0.4 s"), single("C", "600 t", "0.3 s"))
    numbers = {"building.A.period": {"distribution": "uniform", "low": "0.7 s", "high": "1.1 s"}}
    row = pr.scan(uncertain_pulses(numbers, 3, buildings=buildings, gap="45 mm"))
    together = pr.uncertainty(row)
    pushed = 0
    for number, name in enumerate(("A | B", "B | C")):
        alone = [pr.assess(row.isel(sample=[sample])).interfaces[number] for sample in range(3)]
        part = together.sel(interface=name)
        shares = [one.contact_at_gap().probability for one in alone]
        np.testing.assert_allclose(part["contact_probability_of_sample"], shares)
        closings = np.concatenate([one.closing for one in alone])
        required = np.percentile(closings, 84, method="inverted_cdf")
        assert float(part["required_gap"].sel(percentile=84)) == pytest.approx(required)
        free = row["peak_closing_free"].isel(interface=number).transpose("sample", ...).values.ravel()
        pushed += int((np.sort(closings) > np.sort(free)).sum())
    assert pushed, "the row shows something that the motion without contact does not"


def test_a_scene_without_contact_says_what_its_scan_says(scanned, of_scene):
    of_scan = pr.uncertainty(scanned)
    assert of_scene["verdict"].item() == of_scan["verdict"].item()
    for name in ("contact_probability", "contact_probability_high", "required_gap", "dispersion", "dispersion_high"):
        # Both are exact but for rounding and the solver's tolerance.
        np.testing.assert_allclose(of_scene[name], of_scan[name], rtol=1e-4, atol=1e-6, err_msg=name)
    told = json.loads(of_scene.attrs["assumptions"])
    assert any(sentence.startswith("No run of contact") for sentence in told)
    assert not any(sentence.startswith("No run of contact") for sentence in json.loads(of_scan.attrs["assumptions"]))
    assert any("drawn independently" in sentence for sentence in told)


def test_fragilities_are_those_of_scaled_motions(scanned, of_scene):
    part = of_scene.isel(interface=0)
    closing = scanned["peak_closing_free"].squeeze("interface").transpose("sample", "record", "polarity").values
    logs = np.log(0.4 * 9.80665 * 0.08 / closing.reshape(len(closing), -1))
    np.testing.assert_allclose(part["fragility_median"], np.exp(logs.mean()), rtol=1e-4)
    # Both polarities of a pulse are one recording: pairs of motions of different ones tell the variance of samples.
    middle = closing.shape[1]
    of_records = logs.reshape(len(logs), middle, 2).mean(axis=2)
    rest = of_records - of_records.mean(0) - of_records.mean(1)[:, None] + of_records.mean()
    between = of_records.mean(1).var(ddof=1) - (rest**2).sum() / (len(logs) - 1) / (middle - 1) / middle
    total = float(part["fragility_dispersion"].sel(curve="total")) ** 2
    alone = float(part["fragility_dispersion"].sel(curve="motions alone")) ** 2
    assert total - alone == pytest.approx(between, rel=1e-3)
    assert total == pytest.approx(float(part["dispersion"].sel(component="total")) ** 2, rel=1e-3)
    assert part["fragility_fault"].item() == ""
    assert pr.uncertainty(scanned, gap="0 mm")["fragility_fault"].item().startswith("a closed gap")


def test_a_linear_scene_has_the_variance_that_is_known():
    """Two masses let go from apart: they close X - Y, beside which the pulses are nothing."""
    numbers = {
        "building.left.initial_displacement": {"distribution": "uniform", "low": "60 mm", "high": "120 mm"},
        "building.right.initial_displacement": {"distribution": "uniform", "low": "-60 mm", "high": "-40 mm"},
    }
    still = [{"kind": "ricker", "pga": "0.0001 g", "period": f"{period} s"} for period in (0.05, 0.06)]
    records, pair = (
        {"generated": still, "polarity": BOTH},
        (single("left", "500 t", "0.5 s"), single("right", "800 t", "1 s")),
    )
    study = uncertain_pulses(numbers, 128, records=records, buildings=pair, gap="200 mm")
    part = pr.uncertainty(study, output="required_gap", gap="140 mm").isel(interface=0)
    variances = np.array([60.0, 20.0]) ** 2 * 1e-6 / 12.0
    indices = part["first_order"].sel(output="required_gap")
    # The bounds' half width at 128 samples.
    np.testing.assert_allclose(indices, variances / variances.sum(), atol=0.1)
    assert float(part["output_deviation"].sel(output="required_gap")) == pytest.approx(variances.sum() ** 0.5, rel=0.02)
    np.testing.assert_allclose(part["required_gap_moved"], [[0.116, 0.14, 0.164], [0.148, 0.14, 0.132]], rtol=1e-3)
    assert float(part["judged_probability"]) == pytest.approx(0.5, abs=0.02)
    assert part["narrowing"].item().startswith("Knowing building.left.initial_displacement exactly would narrow")
    # The motions add nothing: all of the variance is that of the samples.
    np.testing.assert_allclose(part["variance_share"], (1.0, 0.0, 0.0, 1.0), atol=1e-3)


@pytest.mark.complete
def test_links_between_single_masses_are_in_the_samples_of_a_scene():
    study = uncertain_pulses({LEFT: PERIODS[LEFT]}, 4, link_damping="2 MN s/m")
    alone, scanned = pr.uncertainty(study), pr.uncertainty(pr.scan(study))
    np.testing.assert_allclose(alone["required_gap"], scanned["required_gap"], rtol=1e-12)
    assert float(alone["judged_probability"][0]) == float(scanned["judged_probability"][0])


def test_a_gap_that_is_uncertain_moves_what_is_required_by_as_much():
    gaps = {"interface.gap": {"distribution": "normal", "mean": "80 mm", "deviation": "10 mm"}}
    whole = pr.uncertainty(uncertain_pulses(gaps | {LEFT: PERIODS[LEFT] | {"dispersion": 0.001}}, 128))
    part = whole.isel(interface=0)
    one = part.sel(output="required_gap")
    assert float(one["output_deviation"]) == pytest.approx(0.01, rel=0.05)
    # A fit of 11 coefficients to 128 samples has up to 9 % of the variance by chance.
    np.testing.assert_allclose(one["first_order"], (1.0, 0.0), atol=0.09)
    assert "a nominal gap of 80 mm plus its scatter (deviation 10 mm)" in part["sentence"].item()
    z = ndtri(0.9)
    middle = float(part["required_gap_moved"][0, 1])
    np.testing.assert_allclose(part["required_gap_moved"][0], middle + np.array([z, 0.0, -z]) * 0.01, rtol=1e-6)
    assert float(part["judged_gap"]) == pytest.approx(0.08)
    # The variance is that of the closing less the scatter, and is called so.
    captions = str(sheet(whole))
    of_scatter = "the logarithm of the closing without contact less the scatter of the gap"
    assert f"Parts of the variance of {of_scatter}" in captions
    assert parts_words(part).startswith("Of the variance of ln (closing less the scatter of the gap)")


def test_gaps_that_are_not_the_scenes_own_in_the_mean_are_told():
    """Uniform over 60 to 120 mm beside a gap of 80 mm: 10 mm wider, and the required gap as much less."""
    gaps = {"interface.gap": {"distribution": "uniform", "low": "60 mm", "high": "120 mm"}}
    answers = [pr.uncertainty(uncertain_pulses(gaps, 64, gap=gap)) for gap in ("80 mm", "90 mm")]
    told, silent = ([one for one in json.loads(answer.attrs["assumptions"]) if "nominal" in one] for answer in answers)
    assert not silent and len(told) == 1
    gap = float(re.search(r"the samples are ([\d.]+) mm wider in the mean than the scene's own of 80 mm", told[0])[1])
    assert gap == pytest.approx(10.0, abs=1.0)  # 64 points of Sobol
    required = [answer["required_gap"].values for answer in answers]
    np.testing.assert_allclose(required[1] - required[0], 0.01, rtol=1e-9)


@pytest.mark.complete
def test_a_gap_that_is_uncertain_scales_the_intensity_that_closes_it():
    """A motion closes 60 mm at 0.75 times the intensity at which it closes 80 mm."""
    gaps = {"interface.gap": {"distribution": "lognormal", "median": "80 mm", "dispersion": 0.2}}
    known = pr.uncertainty(uncertain_pulses({LEFT: PERIODS[LEFT] | {"dispersion": 0.001}}, 64)).isel(interface=0)
    drawn = pr.uncertainty(uncertain_pulses(gaps | {LEFT: PERIODS[LEFT] | {"dispersion": 0.001}}, 64)).isel(interface=0)
    assert drawn["fragility_fault"].item() == ""
    # The mean of ln gap over balanced points is that of its median, and their deviation 0.2 but for 64 points.
    np.testing.assert_allclose(drawn["fragility_median"], known["fragility_median"], rtol=5e-3)
    squares = [float(one["fragility_dispersion"].sel(curve="total")) ** 2 for one in (known, drawn)]
    assert squares[1] - squares[0] == pytest.approx(0.04, rel=0.05)


def test_it_depends_where_each_polarity_alone_would_answer_otherwise(scanned):
    closing = scanned["peak_closing_free"].squeeze("interface").transpose("polarity", ...).values
    shares = {gap: (closing > gap).reshape(2, -1).mean(axis=1) for gap in np.linspace(0.08, 0.2, 40).tolist()}
    gap, apart = max(shares.items(), key=lambda item: float(np.ptp(item[1])) * bool(max(item[1]) < 0.45))
    assert np.ptp(apart) > 0.02
    part = pr.uncertainty(scanned, gap=gap, target=float(np.mean(apart))).isel(interface=0)
    assert part["verdict"].item() == "depends"
    assert "Each polarity alone would answer otherwise" in part["sentence"].item()
    wide = pr.uncertainty(scanned, gap=0.01, target=0.1).isel(interface=0)
    assert wide["verdict"].item() == "inadequate" and float(wide["judged_probability_low"]) > 0.1


def test_indices_on_a_design_and_points_at_quantiles(of_scene):
    part = of_scene.isel(interface=0)
    assert list(part["uncertain_number"].values) == [LEFT, RIGHT]
    assert {"total_order", "total_order_low", "first_order_high"} <= set(part.data_vars)
    moved = part["required_gap_moved"]
    assert float(moved[0, 1]) == float(moved[1, 1])
    assert part["closing_at_medians"].size == 2 * len(PULSES)
    nominal = pr.scan(parse_scene(scene_text(records={"generated": PULSES, "polarity": BOTH}, law="linear")))
    closing = np.sort(nominal["peak_closing_free"].values.ravel())
    np.testing.assert_allclose(part["closing_at_medians"], closing, rtol=1e-6)


def test_an_output_of_contact_is_read_from_a_dataset(scanned):
    part = pr.uncertainty(scanned, output="peak_contact_force", gap="20 mm").isel(interface=0)
    one = part.sel(output="peak_contact_force")
    force = scanned["peak_contact_force"].squeeze(("interface", "gap", "yield_force", "contact_model"))
    medians = force.median(("record", "polarity"))
    assert float(one["output_deviation"]) == pytest.approx(float(medians.std()))
    assert one["output_unit"].item() == "N"
    assert part["chosen_output"].item() == "peak_contact_force"
    assert "peak contact force" in part["narrowing"].item()


@pytest.mark.parametrize(
    "options",
    [{"sobol": True}, {"samples": 8}, {"output": "peak_contact_forc"}, {"intensity": "sa(left)"}, {"pga": "0.3 g"}],
    ids=str,
)
def test_what_a_dataset_cannot_give_is_refused(scanned, options, says):
    says(refusal(pr.uncertainty, scanned, **options))


def test_without_samples_nothing_is_uncertain(scanned, says):
    says(
        refusal(pr.uncertainty, parse_scene(scene_text())),
        refusal(pr.uncertainty, scanned.isel(sample=[0])),
        refusal(pr.uncertainty, uncertain_pulses(samples=4), output="peak_contact_force"),
    )
    assert "as by samples = 0" in refusal(pr.uncertainty, uncertain_pulses(samples=0))


def test_correlated_numbers_have_no_sobol_indices():
    tied = PERIODS | {"correlations": [{"between": [LEFT, RIGHT], "value": 0.6}]}
    study = uncertain_pulses(tied, 8)
    with pytest.raises(PoundingError, match=f"sobol: {LEFT} and {RIGHT} are correlated"):
        pr.uncertainty(study, sobol=8)
    told = json.loads(pr.uncertainty(study).attrs["assumptions"])
    assert any("are correlated" in sentence for sentence in told)
    # A tornado moves one alone: the other stays at its median, though both are correlated.
    points = independent_points(np.array([[0.5, 0.5], [0.9, 0.5], [0.5, 0.1]]), study.uncertain)
    left, right = ([float(text.removesuffix(" s")) for text in values] for values in study.uncertain.values_at(points))
    np.testing.assert_allclose(left, 0.5 * np.exp(0.3 * ndtri([0.5, 0.9, 0.5])), rtol=1e-9)
    np.testing.assert_allclose(right, np.exp(0.1 * ndtri([0.5, 0.5, 0.1])), rtol=1e-9)


@pytest.mark.parametrize("options", [{}, {"samples": 1}], ids=str)
def test_one_sample_says_nothing_of_the_numbers(options):
    """Bounds of its motions alone are no bounds over the numbers."""
    says = refusal(pr.uncertainty, uncertain_pulses(samples=1 if not options else 4), **options)
    assert says.startswith("samples: 1 is no whole number from 2") and "does not show what the numbers mean" in says


def test_nothing_stands_out_where_no_number_matters():
    """A restitution changes no motion without contact."""
    numbers = {"interface.restitution": {"distribution": "uniform", "low": 0.4, "high": 0.8}}
    part = pr.uncertainty(uncertain_pulses(numbers, 8, law="jankowski")).isel(interface=0)
    assert part["narrowing"].item().startswith("Over the samples the required gap does not vary")
    np.testing.assert_allclose(part["variance_share"].sel(component="parameters"), 0.0, atol=1e-12)


def test_a_number_is_named_alone_only_where_its_bounds_say_so(of_scene, says):
    """Beside bounds that overlap, shares of nothing, and unknown ones."""
    part, criterion = of_scene.isel(interface=0), read_criterion()
    shape, dims = part["first_order"].shape, part["first_order"].dims
    for given in (
        ((0.75, 0.1), (0.6, 0.0), (0.9, 0.2)),
        ((0.3, 0.4), (0.2, 0.3), (0.4, 0.5)),
        ((0.1, 0.2), (-0.1, -0.05), (0.3, 0.4)),
        ((np.nan, np.nan),) * 3,
    ):
        names = ("first_order", "first_order_low", "first_order_high")
        arrays = {name: (dims, np.broadcast_to(values, shape)) for name, values in zip(names, given, strict=True)}
        says(words_of_number(part.assign(arrays), criterion))


def test_too_few_recordings_are_told():
    few = {"generated": PULSES[:1], "polarity": BOTH}
    dataset = pr.uncertainty(uncertain_pulses(samples=8, records=few))
    assert any(sentence.startswith("Few: ") for sentence in json.loads(dataset.attrs["assumptions"]))
    part = dataset.isel(interface=0)
    assert np.isnan(part["variance_share"].sel(component="motions"))
    assert part["fragility_fault"].item().startswith("one recording")
    assert float(part["judged_probability_high"]) > 0.9
    uncertainty_figure(dataset)


def test_the_figure_draws_the_dataset(of_scene, scanned, says):
    figure = uncertainty_figure(of_scene)
    contact, indices, tornado = figure.axes
    in_report = uncertainty_figure(of_scene, titled=False)
    assert len(in_report.axes) == 3 and in_report.get_figwidth() <= 7.5 and not in_report.get_suptitle()
    total = next(line for line in contact.lines if line.get_label() == "samples and motions")
    np.testing.assert_allclose(total.get_ydata(), of_scene["contact_probability"][0])
    assert [label.get_text().replace("\n", ".") for label in tornado.get_yticklabels()][-1] in (LEFT, RIGHT)
    assert "first-order and total" in indices.get_title()
    assert len(uncertainty_figure(pr.uncertainty(scanned)).axes) == 2
    assert pr.figures.results_figure(of_scene).get_suptitle() == figure.get_suptitle()
    says(refusal(uncertainty_figure, scanned))


@pytest.mark.parametrize(("output", "scale"), [("contact_probability", 0.0), ("required_gap", 1e-6)])
def test_a_tornado_of_nothing_says_so(of_scene, output, scale):
    """Fractions of a micrometre were drawn as bars; so was a probability that no number changes, without one."""
    idle = of_scene.copy(deep=True)
    for name in ("contact_probability", "required_gap"):
        idle[f"{name}_moved"] *= scale if name == output else 1.0
    idle["chosen_output"][:] = output
    axis = uncertainty_figure(idle).axes[-1]
    least = {"contact_probability": "P(contact) at 0 %", "required_gap": "the required gap at less than 0.01 mm"}
    (words,) = (text.get_text().replace("\n", " ").replace("\xa0", " ") for text in axis.texts)
    assert words == f"each number alone leaves {least[output]}" and not axis.patches


def test_results_are_written_and_replaced_by_their_own_kind_alone(of_scene, tmp_path, says):
    study = uncertain_pulses(samples=4)
    file = tmp_path / "u.nc"
    written = pr.uncertainty(study, file)
    read = pr.open_results(file)
    assert read.pounding.kind == "uncertainty" and "uncertainty" in repr(read.pounding)
    np.testing.assert_array_equal(read["contact_probability"], written["contact_probability"])
    for name in read.data_vars:
        assert read[name].attrs["long_name"], name
    pr.uncertainty(study, file, gap="50 mm")
    pr.spectra(study.updated(axes=(), uncertain=None), tmp_path / "s.nc", num=2, periods=("0.3 s", "0.6 s"))
    says(refusal(pr.uncertainty, study, tmp_path / "s.nc"))


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
def scanned_drawn():
    return pr.scan(drawn_scene(), check_fraction=0.0)


@pytest.fixture(scope="module")
def of_drawn():
    return pr.uncertainty(drawn_scene())


@pytest.mark.complete
def test_what_is_said_is_that_of_the_samples_themselves(scanned_drawn):
    """P(contact) is the share of the samples whose run touches; each closing is that of a scan of its own."""
    part = pr.uncertainty(scanned_drawn, target="20 %").isel(interface=0)
    touches = scanned_drawn["impact_count"].values.reshape(56) > 0
    assert float(part["judged_probability"]) == touches.mean()
    alone = scanned_drawn["peak_closing_free"].values.ravel()
    assert np.array_equal(part["closing_of_sample"], alone)
    (of_one,) = pr.assess(scanned_drawn.isel(sample=[5])).interfaces
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
def test_a_scene_of_drawn_motions_says_what_its_scan_says(scanned_drawn, of_drawn):
    of_scan = pr.uncertainty(scanned_drawn)
    for name in ("contact_probability", "contact_probability_high", "required_gap", "dispersion", "first_order"):
        np.testing.assert_allclose(of_drawn[name], of_scan[name], rtol=1e-9, atol=1e-9, equal_nan=True)
    assert of_drawn.attrs["motions"] == of_scan.attrs["motions"]
    np.testing.assert_allclose(of_drawn["fragility_median"], of_scan["fragility_median"], rtol=1e-9)


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


def test_fragilities_are_of_the_motions_and_numbers_together(scanned_drawn):
    """ln capacity of a sample is ln(gap/closing × PGA of its motion); what motions do alone is not told."""
    part = pr.uncertainty(scanned_drawn, intensity="pga").isel(interface=0)
    capacity = np.log(0.08 / part["closing_of_sample"].values * scanned_drawn["record_pga"].values)
    assert float(part["fragility_median"].sel(curve="total")) == pytest.approx(np.exp(capacity.mean()))
    assert np.isnan(float(part["fragility_dispersion"].sel(curve="motions alone")))
    records = scanned_drawn["record"].values
    labels = [f"{name} {sign}" for name, sign in zip(records, scanned_drawn["polarity"].values, strict=True)]
    motions, recordings = (np.unique(one, return_inverse=True)[1] for one in (labels, records))
    total = analysed_clusters(capacity, motions, recordings).all.total
    assert float(part["fragility_dispersion"].sel(curve="total")) == pytest.approx(np.sqrt(total))


def test_an_output_under_drawn_motions_is_read_from_a_dataset(scanned_drawn):
    part = pr.uncertainty(scanned_drawn, output="peak_displacement").isel(interface=0)
    assert part["output"].values.tolist() == ["contact", "log_closing", "peak_displacement"]
    assert np.isfinite(part["first_order_of_motions"].values).all()
    assert "under the sample's motion" in str(part["output_words"].values[-1])


def test_what_drawn_motions_cannot_tell_is_refused_with_the_repair(scanned_drawn, says):
    says(refusal(pr.uncertainty, drawn_scene(), sobol=8), refusal(pr.uncertainty, scanned_drawn, output="required_gap"))
    for call in (pr.assess, lambda one: pr.report(one, "never.html"), lambda one: pr.view(one, "never.html")):
        assert "--select 'sample=0'" in refusal(call, scanned_drawn)


def test_an_axis_beside_the_samples_is_assessed_one_value_at_a_time(scanned_drawn, says):
    says(refusal(assess_along, scanned_drawn))
    study = drawn_scene(2, grid={"building.right.mass": ["700 t", "800 t"]})
    beside = pr.scan(study, check_fraction=0.0)
    says(refusal(assess_along, beside))
    assert pr.uncertainty(beside.isel({"building.right.mass": [1]})).sizes["sample"] == 2


def test_too_few_samples_to_tell_what_motions_do():
    few = pr.uncertainty(drawn_scene(4)).isel(interface=0)
    assert "draw more samples for the motions' share" in parts_words(few)
    assert uncertainty_figure(few.expand_dims("interface")) is not None


def test_the_figure_has_the_motion_beside_the_numbers(of_drawn):
    figure = uncertainty_figure(of_drawn)
    assert "the motion" in [label.get_text() for label in figure.axes[1].get_yticklabels()]
    assert not any("of samples" in label for label in figure.axes[0].get_legend_handles_labels()[1])


def test_what_is_printed_leaves_out_what_drawn_motions_do_not_tell(of_drawn, capsys):
    print_sheet(sheet(of_drawn))
    printed = capsys.readouterr().out
    assert "the motion " in printed and "\nuncertain numbers, alone and together with the motions  " in printed
    assert "5 % of samples" not in printed and "motions alone" not in printed and "nan" not in printed


def test_histories_of_a_sample_are_those_of_its_motion(scanned_drawn, tmp_path):
    save(scanned_drawn, tmp_path / "r.nc")
    made = open_results(pr.histories(tmp_path / "r.nc", tmp_path / "h.nc", select=["sample=5"]))
    assert made.sizes["record"] == 1 and made["record"].item() == scanned_drawn["record"].values[5]
    assert made["polarity"].values.tolist() == [scanned_drawn["polarity"].values[5]]
