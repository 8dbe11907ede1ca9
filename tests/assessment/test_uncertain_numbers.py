"""What uncertain numbers of a scene mean: from its motion without contact, and from a dataset of its scan."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scenes import BOTH, scene_text, single
from scipy.special import ndtri
from sentences import refusal
from uncertain import LEFT, PERIODS, PULSES, RIGHT, uncertain_pulses

import pounding_risk as pr
from pounding_risk.assessment.options import read_criterion
from pounding_risk.assessment.uncertain_samples import independent_points
from pounding_risk.assessment.uncertain_words import parts_words, words_of_number
from pounding_risk.errors import PoundingError
from pounding_risk.figures.uncertainty import uncertainty_figure
from pounding_risk.questions.uncertainty import sheet
from pounding_risk.scene.reader import parse_scene


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


def test_one_sample_says_nothing_of_the_numbers():
    part = pr.uncertainty(uncertain_pulses(samples=1)).isel(interface=0)
    assert "One sample does not show whether" in part["narrowing"].item()
    assert "no number changes it" not in part["narrowing"].item()


def test_nothing_stands_out_where_no_number_matters():
    """A restitution changes no motion without contact."""
    numbers = {"interface.restitution": {"distribution": "uniform", "low": 0.4, "high": 0.8}}
    part = pr.uncertainty(uncertain_pulses(numbers, 8, law="jankowski")).isel(interface=0)
    assert part["narrowing"].item().startswith("Over the samples the required gap does not vary")
    np.testing.assert_allclose(part["variance_share"].sel(component="parameters"), 0.0, atol=1e-12)


def test_a_number_is_named_alone_only_where_its_bounds_say_so(of_scene):
    part, criterion = of_scene.isel(interface=0), read_criterion()

    def told(first, low, high):
        shape = part["first_order"].shape
        made = {"first_order": first, "first_order_low": low, "first_order_high": high}
        arrays = {name: (part["first_order"].dims, np.broadcast_to(values, shape)) for name, values in made.items()}
        return words_of_number(part.assign(arrays), criterion)

    alone = told((0.75, 0.1), (0.6, 0.0), (0.9, 0.2))
    deviation = float(part["output_deviation"].sel(output="contact_probability"))
    assert alone.startswith(f"Knowing {LEFT} exactly would narrow P(contact) most: it has 75 % of the variance")
    assert alone.endswith(f"would fall from {deviation:.2g} to {0.5 * deviation:.2g}.")
    assert told((0.3, 0.4), (0.2, 0.3), (0.4, 0.5)).endswith(f"Its bounds overlap those of {LEFT}.")
    assert told((0.1, 0.2), (-0.1, -0.05), (0.3, 0.4)).startswith("No number stands out: the largest share")
    assert told((np.nan, np.nan), (np.nan, np.nan), (np.nan, np.nan)).startswith(
        "On which number P(contact) depends most is not known"
    )


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
    (words,) = (text.get_text().replace("\n", " ") for text in axis.texts)
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
