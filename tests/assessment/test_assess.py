"""Assessments of made-up motions whose answers are known, and of a real scan case by case."""

import json
import re

import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from made_hazard import site_file
from scenes import BOTH, scene_text, single
from scipy.stats import lognorm, norm
from sentences import refusal

from pounding_risk import assess
from pounding_risk.assessment import demands
from pounding_risk.assessment.assess import InterfaceAssessment
from pounding_risk.assessment.demands import motions_of
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.assessment.intensities import intensities
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.figures.assess import assessment_figure
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.sdof import Building
from pounding_risk.questions.assess import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.results.attributes import as_text
from pounding_risk.results.labels import place_coordinates
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene
from pounding_risk.units import rounded

G = 9.80665
SCENE = scene_text(
    single("left", "10 t", "0.5 s"),
    single("right", "20 t", "0.3 s", damping=0.02),
    law="linear",
    gap="20 mm",
    yield_force="300 kN",
    records={"names": ["RSN6-180", "RSN6-270", "RSN1690-090"], "window": ["0 s", "8 s"], "polarity": BOTH},
    grid={
        "gap": ["0 mm", "5 mm", "10 mm", "20 mm", "40 mm"],
        "yield_force": ["100 kN", "300 kN", "inf"],
        "pga": ["0.1 g", "0.3 g"],
    },
)


def made_up(closing: np.ndarray, *, gap: float = 0.02, yields: np.ndarray | None = None, **more: object) -> xr.Dataset:
    """What a scan writes, as far as an assessment reads it.

    ``closing`` is (records, polarities[, amplitudes]); records stand in pairs, the components of one recording.
    ``yields`` is (motions..., models, gaps, forces), by default one that never yields.
    """
    several = closing.ndim == 3
    records = [f"R{number}" for number in range(len(closing))]
    gaps, forces = np.array([0.0, 0.01, 0.02, 0.04]), np.array([1e6, 2e6, np.inf])
    models = ["linear"] if yields is None else [f"law {number}" for number in range(yields.shape[-3])]
    dims = ("record", "polarity", *(("pga",) if several else ()))
    cases = (*dims, "contact_model", "gap", "yield_force")
    shape = (*closing.shape, len(models), gaps.size, forces.size)
    touches = closing[..., None, None, None] > gaps[:, None]
    status = ("status", {"flag_values": np.array([0, 2], dtype=np.int8), "flag_meanings": "complete the_step_fell"})
    facts = [{"name": name, "station": str(place // 2)} for place, name in enumerate(records)]
    displacement = np.stack([closing, 0.0 * closing], axis=-1)  # the right building is rigid
    variables = {
        "peak_closing_free": (dims, closing),
        "peak_displacement_free": ((*dims, "building"), displacement),
        "impact_count": (cases, np.broadcast_to(touches, shape).astype(np.int32)),
        "yield_exceedance": (cases, np.zeros(shape, dtype=np.int32) if yields is None else yields),
        "simulated": (cases, np.ones(shape, dtype=np.int8)),
        status[0]: (cases, np.zeros(shape, dtype=np.int8), status[1]),
    }
    sides = [Building("A", 1e5, 0.5, 0.05), Building.rigid("B")]
    places = place_coordinates(sides, [Point(0, 1.0, 1.0, "floor", np.nan)], forces[:, None])
    del places["interface"]  # which is given back where a dataset of two buildings is opened
    coordinates = {
        "record": records,
        "polarity": ["as recorded", "reversed"][: closing.shape[1]],
        "contact_model": models,
        "gap": gaps,
        "yield_force": forces,
        "building": ["A", "B"],
        "building_period": ("building", [0.5, np.nan]),
        "building_damping": ("building", [0.05, np.nan]),
        **places,
        "record_pga": ("record", np.linspace(2.0, 4.0, len(records))),
        **({"pga": np.array([1.0, 2.0, 4.0, 8.0])[: closing.shape[-1]]} if several else {}),
        **more,
    }
    scene = f'[[interface]]\ngap = "{gap!r} m"\n'
    return xr.Dataset(variables, coordinates, {"title": "made up", "scene_resolved": scene, "records": as_text(facts)})


def lognormal(count: int, scale: float = 0.02, spread: float = 0.5, seed: int = 14) -> np.ndarray:
    return lognorm(spread, scale=scale).rvs((count, 2), random_state=seed)


def contact_at_20_mm(one: InterfaceAssessment) -> Fragility:
    return next(each for each in one.fragility if each.gap == 0.02 and each.what == "contact")


@pytest.fixture(scope="module")
def dataset() -> xr.Dataset:
    return scan(parse_scene(SCENE), check_fraction=0.0)


def test_contact_is_that_of_every_case_of_a_scan(dataset):
    """The share from the motions without contact is the share of the runs with a count above 0, at every gap."""
    for amplitude in dataset["pga"].values:
        (one,) = assess(dataset, pga=float(amplitude)).interfaces
        assert one.amplitude == pytest.approx(amplitude)
        assert [share.gap for share in one.contact] == dataset["gap"].values.tolist()
        for share in one.contact:
            counted = dataset["impact_count"].sel(gap=share.gap, pga=amplitude) > 0
            # No law and no F_E changes whether there is contact.
            assert (counted.sum(["record", "polarity"]) == share.count).all()
            assert share.runs == 6


def test_yielding_is_that_of_every_case_of_a_scan(dataset):
    (one,) = assess(dataset).interfaces
    assert len(one.yielding) == 5 * 2
    for share in one.yielding:
        case = {"gap": share.gap, "yield_force": share.yield_force, "contact_model": share.contact_model}
        assert share.count == int(dataset["yield_exceedance"].isel(pga=-1).sel(case).sum())
    assert 0 < one.yielding[0].count < sum(share.count for share in one.yielding)


def test_a_scan_is_assessed_as_its_numbers_say(dataset):
    """Recordings are told by their facts: two components of one station and one of another."""
    (one,) = assess(dataset).interfaces
    closing = dataset["peak_closing_free"].isel(pga=-1).values.ravel()
    assert (one.name, one.gap, one.yield_gap) == ("left | right", 0.02, 0.02)
    assert [each.gap for each in one.required] == pytest.approx(
        np.percentile(closing, [50.0, 84.0, 95.0], method="inverted_cdf").tolist()
    )
    verdict = one.verdict
    assert (verdict.motions, verdict.recordings, verdict.runs, verdict.failed) == (6, 2, dataset["status"].size, 0)
    assert verdict.margin == pytest.approx(0.02 / np.percentile(closing, 84.0, method="inverted_cdf"))
    assert verdict.governing[0].closing == closing.max()
    assert verdict.governing[0].record == str(dataset["record"].values[closing.argmax() // 2])
    assert one.contact_at_gap().count == int((closing > 0.02).sum())
    assert {each.row.rule for each in one.separations} >= {"abs", "srss", "cqc"}


def test_motions_know_their_recordings(dataset):
    """Both components of one station and both polarities belong together, record by record."""
    ((_, interface),) = Results(dataset).interfaces
    motions = motions_of(interface)
    assert motions.recordings.tolist() == [0, 0, 0, 0, 1, 1]
    assert motions.records[::2] == ("RSN6-180", "RSN6-270", "RSN1690-090")
    assert motions.polarities == ("as recorded", "reversed") * 3
    assert motions.closing[3, 1] == dataset["peak_closing_free"].values[1, 1, 1, 0]


def test_a_gap_between_those_of_the_grid_is_known_exactly(dataset):
    closing = np.sort(dataset["peak_closing_free"].isel(pga=-1).values.ravel())
    between = float(closing[2:4].mean())
    (one,) = assess(dataset, gap=between).interfaces
    assert (one.contact_at_gap().count, one.contact_at_gap().gap) == (3, between)
    (edge,) = assess(dataset, gap=float(closing[2])).interfaces
    assert edge.contact_at_gap().count == 3  # a motion that needs the gap to a hair does not close it


def test_the_fragility_of_scaled_motions_is_that_of_their_capacities():
    """One amplitude only: motion i closes the gap at 4 m/s2 × gap / closing."""
    closing = lognormal(20)
    (one,) = assess(made_up(closing, pga=4.0)).interfaces
    found = contact_at_20_mm(one)
    assert found.method == "scaled motions"
    assert found.median == pytest.approx(4.0 * 0.02 / np.exp(np.log(closing).mean()))
    assert found.dispersion == pytest.approx(np.log(closing).std())
    assert "one intensity" in found.note
    closed = next(each for each in one.fragility if each.gap == 0.0)
    assert "a closed gap" in closed.fault


def test_a_wider_gap_takes_a_stronger_motion(tmp_path):
    """Linear buildings at several amplitudes: medians go with the gap, the dispersion stays, and rates only fall.

    Stripes see few contacts at wide gaps, and their curves cross: of such ensembles some give a wider gap more often.
    """
    file = site_file(tmp_path, "pga [m/s^2],annual rate")
    closing = lognormal(20, scale=0.003)[..., None] * np.array([1.0, 2.0, 4.0, 8.0])
    (one,) = assess(made_up(closing), hazard=file, pga=2.0).interfaces
    curves, rates = zip(
        *((each, rate) for each, rate in zip(one.fragility, one.rates, strict=True) if not each.fault), strict=True
    )
    assert {each.method for each in curves} == {"scaled motions"}
    assert [each.median for each in curves] == pytest.approx([each.gap * curves[0].median / 0.01 for each in curves])
    assert [each.dispersion for each in curves] == pytest.approx([curves[0].dispersion] * len(curves))
    assert np.all(np.diff([rate.annual for rate in rates]) < 0.0)


def test_the_fragility_of_stripes_finds_the_truth():
    """150 records of a closing that grows with the amplitude, lognormal: median 2 m/s2, dispersion 0.5."""
    unit = lognormal(150, scale=0.01)  # at 1 m/s2; 20 mm are reached at 2 m/s2 in the median
    results = made_up(unit[..., None] * np.array([1.0, 2.0, 4.0, 8.0]))
    results.attrs["scene_resolved"] += "[effects]\ninelastic_storeys = {}\n"  # buildings are not linear
    (one,) = assess(results).interfaces
    found = contact_at_20_mm(one)
    assert found.method == "multiple stripes"
    assert abs(np.log(found.median / 2.0)) < 3.0 * found.errors[0]
    assert abs(found.dispersion - 0.5) < 3.0 * found.errors[1]
    assert [stripe.runs for stripe in found.stripes] == [300] * 4
    share = norm.cdf(np.log(2.0 / found.median) / found.dispersion)
    assert found.stripes[1].count / 300.0 == pytest.approx(share, abs=0.05)


def test_intensities_are_those_of_the_motions():
    """As recorded each motion stands at its record's PGA, or at its building's Sa = (2π/T)² u."""
    closing = lognormal(30)
    results = made_up(closing)
    (one,) = assess(results).interfaces
    contact = contact_at_20_mm(one)
    assert [stripe.im for stripe in contact.stripes] == pytest.approx(np.linspace(2.0, 4.0, 30))
    (one,) = assess(results, intensity="sa(A)").interfaces
    contact = contact_at_20_mm(one)
    known = np.sort((2.0 * np.pi / 0.5) ** 2 * closing.ravel())
    assert [stripe.im for stripe in contact.stripes] == pytest.approx(known)
    # The closing is the building's own displacement here: it touches at one Sa, and nothing is left to spread.
    assert "no dispersion" in contact.fault
    with pytest.raises(PoundingError, match=r"sa\(right\).*rigid"):
        assess(results, intensity="sa(right)")
    with pytest.raises(
        PoundingError, match=r"write pga, sa\(left\), sa\(right\), by name sa\(A\), sa\(B\), or a period"
    ):
        assess(results, intensity="sa(C)")


@pytest.mark.parametrize(
    ("closing", "gap", "word", "words"),
    [
        (0.01, 0.02, "adequate", "none of 160 motions as recorded closes a gap of 20 mm: P(contact) 0 % (95 % bounds"),
        (0.01, 0.005, "inadequate", "160 of 160 motions as recorded close a gap of 5 mm: P(contact) 100 %"),
        (0.01, 0.0, "inadequate", "close a gap of 0 mm"),
    ],
)
def test_the_verdict_follows_its_rule(closing, gap, word, words):
    """80 records whose motions have nothing in common, so that the bounds are narrow."""
    values = closing * np.linspace(0.9, 1.1, 160).reshape(2, 80).T[::-1]
    (one,) = assess(made_up(values), gap=gap).interfaces
    assert one.verdict.word == word
    assert one.verdict.sentence.startswith(word.capitalize())
    assert words in one.verdict.sentence


def test_few_motions_leave_it_open_and_say_why():
    """Two recordings in four motions: without any contact the upper bound stays far above 10 %."""
    values = np.array([[0.010, 0.011], [0.012, 0.013]])
    (one,) = assess(made_up(values), target=0.1).interfaces
    assert one.verdict.word == "depends"
    assert "So few motions cannot show that a gap keeps the target of 10 %" in one.verdict.sentence
    assert one.verdict.sentence.endswith("it takes 36 independent ones.")
    assert one.verdict.independent == 1.0  # of one recording
    told = " ".join(one.verdict.evidence)
    assert "4 motions from 1 recording (effective sample size 1)." in told
    # 1 − 0.025, and 36 as in test_proportions
    least = "Even with no contact at all, 1 motion could only show P(contact) < 98 %"
    assert f"{least}; showing 10 % takes at least 36 independent motions." in told
    assert one.verdict.more_recordings == 35  # a recording is worth one motion
    assert any(sentence.startswith("About 35 more recordings") for sentence in one.verdict.conclusion)
    assert not any(each.bounded for each in one.required)


def test_a_target_that_the_motions_can_show_is_named_and_holds():
    """30 recordings of one motion: 1 − 0.025^(1/30) = 11.6 %, rounded up."""
    values = 0.01 * np.linspace(0.9, 1.1, 30)[:, None]
    results = made_up(values)
    results.attrs["records"] = "[]"  # nothing is told of stations: each record is a recording of its own
    (one,) = assess(results, target=0.1).interfaces
    assert (one.verdict.word, one.verdict.independent) == ("depends", 30.0)
    assert one.verdict.sentence.endswith("it takes 36 independent ones, or a target of 12 %.")
    assert assess(results, target=0.12).interfaces[0].verdict.word == "adequate"
    assert assess(results).target == pytest.approx(0.16)  # what the 84th percentile leaves
    assert assess(results, percentile=90.0).target == pytest.approx(0.1)


def test_a_verdict_that_hangs_on_the_polarity_depends():
    """Reversed, all close the gap, and as recorded none: half of them together, surely above 10 %, and yet."""
    values = np.stack([np.linspace(0.009, 0.011, 80), np.linspace(0.03, 0.04, 80)], axis=1)
    (one,) = assess(made_up(values)).interfaces
    assert one.verdict.word == "depends"
    assert "Each polarity alone would answer otherwise" in one.verdict.sentence
    assert "0.00 (as recorded) to 1.00 (reversed)" in one.verdict.sentence


def test_motions_without_a_response_count_against_the_verdict():
    values = 0.01 * np.linspace(0.9, 1.1, 160).reshape(2, 80).T[::-1]
    values[:10] = np.nan
    (one,) = assess(made_up(values)).interfaces
    assert (one.verdict.motions, one.contact_at_gap().runs) == (140, 140)
    assert one.contact_at_gap().high_recordings < 0.1
    assert one.verdict.word == "depends"  # the 20 may all have closed it
    assert "20 failed motions widen" in one.verdict.sentence
    with pytest.raises(PoundingError, match="no motion of the dataset moves the ground and has a finite response"):
        assess(made_up(np.full((2, 2), np.nan)))


def test_doubts_on_records_and_excluded_files_stand_below_the_answer(capsys):
    flags = {name: ["the motion starts late"] for name in ("R0", "R1")}
    doubted = made_up(np.full((3, 2), 0.01)).assign_attrs(flags=as_text(flags), left_out=as_text(["a.AT2: is empty"]))
    print_sheet(sheet(assess(doubted)))
    told = capsys.readouterr().out
    assert told.endswith("note: excluded: a.AT2: is empty\nnote: R0, R1: the motion starts late\n")


def test_failed_runs_are_no_runs_without_yielding():
    """Motions of two models, four gaps, three F_E; the first motion failed under the second model."""
    yields = np.zeros((4, 2, 2, 4, 3), dtype=np.int32)
    yields[:, :, 0, :, 0] = 1
    yields[0, 0, 1] = -1
    results = made_up(lognormal(4), yields=yields)
    results["status"][0, 0, 1] = 2
    found = assess(results)
    (one,) = found.interfaces
    assert (found.failed, one.verdict.failed, found.cases) == (12, 12, 8 * 24)
    shares = {(each.contact_model, each.yield_force): each for each in one.yielding if each.gap == 0.02}
    assert (shares["law 0", 1e6].count, shares["law 0", 1e6].runs, shares["law 0", 1e6].left_out) == (8, 8, 0)
    assert (shares["law 1", 1e6].count, shares["law 1", 1e6].runs, shares["law 1", 1e6].left_out) == (0, 7, 1)
    assert "12 failed" in " ".join(one.verdict.evidence)


def responding(closing: np.ndarray, own: str = "2000000.0 N") -> xr.Dataset:
    """Three laws whose response follows the motion: "plain" never yields, "capped" is "plain" but for its cap, "soft"
    moves the buildings twice as far."""
    yields = np.zeros((*closing.shape, 3, 4, 3), dtype=np.int32)
    yields[..., 0] = 1
    results = made_up(closing, yields=yields).assign_coords(contact_model=["plain", "capped", "soft"])
    factors = {"plain": [1.0, 1.0, 1.0], "capped": [1.6, 1.2, 1.0], "soft": [2.0, 2.0, 2.0]}
    peak = np.stack([np.outer(closing.ravel(), each).reshape(*closing.shape, 3) for each in factors.values()], axis=-2)
    peak = np.broadcast_to(peak[..., :, None, :], results["impact_count"].shape)
    cases = results["impact_count"].dims
    results["peak_relative_displacement"] = (cases, peak.copy())
    results["peak_contact_force"] = (cases, np.minimum(1e8 * peak, results["yield_force"].values))
    sides = np.stack([10.0 * peak, 20.0 * peak], axis=-1)
    results["peak_floor_acceleration"] = ((*cases, "building"), sides)
    results.attrs["scene_resolved"] = (
        f'[[interface]]\ngap = "0.02 m"\nyield_force = "{own}"\ncontact_model = "capped"\n'
    )
    return results


def test_the_response_against_f_e_is_that_of_the_motions_with_contact():
    """Medians over the motions that close 20 mm, of the larger building, at the assessed gap alone."""
    closing = lognormal(12)
    (one,) = assess(responding(closing)).interfaces
    touching = closing[closing > 0.02]
    for factor, force in ((1.6, 1e6), (1.2, 2e6), (1.0, np.inf)):
        found = {
            each.output: each for each in one.response if (each.contact_model, each.yield_force) == ("capped", force)
        }
        assert found["peak_relative_displacement"].median == pytest.approx(factor * np.median(touching))
        assert found["peak_floor_acceleration"].median == pytest.approx(20.0 * factor * np.median(touching))
        assert found["peak_floor_acceleration"].high == pytest.approx(20.0 * factor * np.percentile(touching, 84.0))
        assert {each.motions for each in found.values()} == {touching.size}
        assert {each.gap for each in found.values()} == {0.02}
    assert (one.own_force, one.own_model) == (2e6, "capped")


def test_f_e_is_held_against_the_response_and_not_against_itself():
    (one,) = assess(responding(lognormal(12))).interfaces
    assert not [each for each in one.sensitivity if each.key == "yield_force" and each.what.startswith("P(yield)")]
    by_force = {each.output: each for each in one.sensitivity if each.key == "yield_force" and each.output}
    assert set(by_force) == {"peak_relative_displacement", "peak_contact_force", "peak_floor_acceleration"}
    moved = by_force["peak_relative_displacement"]
    assert [name for name, _ in moved.levels] == ["F_E 1000 kN", "F_E 2000 kN", "no yielding"]
    assert moved.share == pytest.approx(0.6 / 1.6)
    assert moved.words.endswith("mm (F_E 1000 kN)") and "(no yielding) to" in moved.words
    assert by_force["peak_contact_force"].words.endswith("F_E is its upper end under a law that yields")
    assert one.what_matters.startswith("F_E changes the median peak ")


def test_yielding_is_told_at_the_scenes_own_f_e():
    """At 1 MN all yield under every law, at 2 MN none: what the scene has decides which is told."""
    for own, share in (("1000000.0 N", 1.0), ("2000000.0 N", 0.0), ("1990000.0 N", 0.0)):
        (one,) = assess(responding(lognormal(12), own)).interfaces
        (found,) = [each for each in one.sensitivity if each.what.startswith("P(yield)") and each.key == "polarity"]
        assert {value for _, value in found.levels} == {share}
        assert found.what == f"P(yield) at F_E {1000 if share else 2000} kN"
    (never,) = assess(responding(lognormal(12), "inf")).interfaces
    assert never.own_force == np.inf
    assert not [each for each in never.sensitivity if each.what.startswith("P(yield)")]


def test_laws_that_differ_by_the_cap_alone_are_no_influence_of_the_model():
    """Without yielding "capped" is "plain", to the last bit; "soft" is another law and does move the buildings."""
    results = responding(lognormal(12))
    for laws, share in ((["plain", "capped"], 0.0), (["plain", "capped", "soft"], 0.5)):
        (one,) = assess(results.sel(contact_model=laws)).interfaces
        found = {each.output: each for each in one.sensitivity if each.key == "contact_model" and each.output}
        assert found["peak_relative_displacement"].share == pytest.approx(share)
        assert ("the contact model changes the median" in one.what_matters) == bool(share)
        assert ("the contact model changes no median response" in one.what_matters) == (not share)
    # A grid without such a case cannot part the law from its cap, and says so.
    (one,) = assess(results.isel(yield_force=[0, 1])).interfaces
    found = {each.output: each for each in one.sensitivity if each.key == "contact_model" and each.output}
    told = found["peak_relative_displacement"]
    assert np.isnan(told.spread) and told.words.endswith(
        'at F_E 2000 kN, where yielding may be part of it: "inf" in grid.yield_force separates them'
    )
    assert "the contact model changes" not in one.what_matters


def scaled_to_sa(value: float, period: float, closing: np.ndarray, apart: float) -> xr.Dataset:
    """Records scaled to Sa of building A, whose closing is told by its neighbour alone: PGA tells nothing."""
    yields = np.zeros((*closing.shape, 1, 4, 3), dtype=np.int32)
    yields[: len(closing) // 2, ..., 0] = 1
    results = made_up(closing, yields=yields)
    noise = np.random.default_rng(3).normal(size=closing.shape)
    results["peak_displacement_free"][..., 0] = value / (2.0 * np.pi / period) ** 2 * np.exp(apart * noise)
    results.attrs["scene_resolved"] += (
        f'[records]\nsa = {{value = "{value} m/s^2", period = "{period} s", damping = 0.05}}\n'
    )
    return results


@pytest.mark.complete
def test_an_ensemble_scaled_to_sa_has_no_curve_of_yielding_and_no_rate(tmp_path):
    """What a study was told of before: "dispersion 0.000" from intensities 1.5e-9 apart, and a rate from it."""
    file = site_file(tmp_path, "Sa(0.5 s) [m/s^2],annual rate")
    results = scaled_to_sa(6.0, 0.5, lognormal(20), 1.5e-9)
    for intensity in (None, "sa(left)", "sa(A)", "sa(0.5 s)"):
        found = assess(results, intensity=intensity, hazard=file)
        (one,) = found.interfaces
        yields = [(each, rate) for each, rate in zip(one.fragility, one.rates, strict=True) if each.what == "yield"]
        assert yields
        for each, rate in yields:
            assert each.fault.startswith("all motions have one intensity, 0.6118 g")
            assert np.isnan(rate.annual) and rate.fault == each.fault
            assert len(each.stripes) == 1
    assert assess(results).intensity == "sa(0.5 s)"
    contact = contact_at_20_mm(one)
    assert contact.method == "scaled motions" and not contact.fault
    assert contact.median == pytest.approx(6.0 * 0.02 / np.exp(np.log(lognormal(20)).mean()))
    assert contact.factor == pytest.approx(contact.median / 6.0)


def test_a_curve_by_far_scaling_is_refused():
    """Closings of 4 mm for a gap of 20 and of 40 mm: five and ten times the motions that were scanned."""
    (one,) = assess(made_up(lognormal(20, scale=0.004), pga=4.0)).interfaces
    contact = {each.gap: each for each in one.fragility if each.what == "contact"}
    assert not contact[0.01].fault and contact[0.01].factor == pytest.approx(2.5, rel=0.2)
    assert "scan stronger motions" in contact[0.04].fault and np.isnan(contact[0.04].median)


@pytest.mark.parametrize(
    ("records", "words", "intensity"),
    [
        ("", "as recorded", "pga"),
        ("scale = 1.5", "times 1.5", "pga"),
        ('pga = "1.2258312500000001 m/s^2"', "at PGA 0.125 g", "pga"),
        ('sa = {value = "6.864655 m/s^2", period = "0.62 s", damping = 0.05}', "at Sa(0.62 s) = 0.7 g", "sa(0.62 s)"),
        (
            'sa = {value = "6.864655 m/s^2", period = "0.62 s", damping = 0.02}',
            "at Sa(0.62 s, 2 %) = 0.7 g",
            "sa(0.62 s, 2 %)",
        ),
        ('to_median = "pgv"', "at the ensemble's median PGV", "pga"),
        ('to_median = "pgv"\nscale = 2.5', "at the ensemble's median PGV times 2.5", "pga"),
        ('to_median = {period = "1.0 s", damping = 0.05}', "at the ensemble's median Sa(1 s)", "sa(1 s)"),
        (
            'to_median = {period = "7.0 s", damping = 0.05}',
            "at the ensemble's median Sa(7 s)",
            "pga",
        ),  # no such spectrum
        ('manifest = "chosen.csv"', "with the factors of chosen.csv", "pga"),
    ],
)
def test_the_amplitude_is_said_in_the_same_words_everywhere(records, words, intensity):
    results = made_up(lognormal(6))
    results.attrs["scene_resolved"] += f"[records]\n{records}\n"
    periods = np.geomspace(0.05, 5.0, 9)
    results = results.assign(record_spectral_acceleration=(("record", "period"), np.ones((6, 9))), period=periods)
    found = assess(results)
    (one,) = found.interfaces
    assert (one.at, found.intensity) == (words, intensity)
    assert f"12 motions {words} close" in one.verdict.sentence
    assert f"recordings {words}" in words_of(assessment_figure(found)).replace("\n", " ")
    assert code_table(results).at == words


def test_an_amplitude_of_the_grid_keeps_its_digits():
    results = made_up(lognormal(6)[..., None] * np.array([1.0, 2.0])).assign_coords(pga=[0.125 * G, 0.35 * G])
    found = assess(results, pga=0.125 * G, gap=0.0123456)
    assert found.interfaces[0].at == "at PGA 0.125 g"
    told = words_of(assessment_figure(found)).replace("\n", " ")
    assert told.startswith("12.3456 mm is ") and told.endswith("at PGA 0.125 g")


def test_sa_at_any_period_is_read_from_the_spectra():
    """A spectrum that is a power of the period is a straight line in the logarithms: read exactly, and as scaled."""
    results = made_up(lognormal(6)[..., None] * np.array([1.0, 2.0]))
    periods = np.geomspace(0.05, 5.0, 9)
    spectra = np.linspace(1.0, 2.0, 6)[:, None] / periods
    results = results.assign(record_spectral_acceleration=(("record", "period"), spectra), period=periods)
    expected = np.repeat(np.linspace(1.0, 2.0, 6) / 0.7 / results["record_pga"].values, 2)[:, None] * [1.0, 2.0]
    assert intensities(Results(results), "sa(0.7 s)") == pytest.approx(expected, rel=1e-12)
    for asked, words in (
        ("sa(6 s)", "the dataset has spectra of 5 % damping from 0.05 s to 5 s; write a period among them"),
        ("sa(0.7 s, 2 %)", "has spectra of 5 % damping"),
        ("sa(0.7)", "or a period such as"),
        ("sa(-1 s)", "is not known"),
    ):
        with pytest.raises(PoundingError, match=re.escape(words)):
            intensities(Results(results), asked)


def test_rates_come_with_a_hazard_curve(tmp_path):
    file = site_file(tmp_path, "pga [m/s^2],annual rate [1/year]")
    (one,) = assess(made_up(lognormal(20), pga=4.0), hazard=file).interfaces
    assert len(one.rates) == len(one.fragility)
    place = next(place for place, each in enumerate(one.fragility) if each.gap == 0.02)
    curve, rate = one.fragility[place], one.rates[place]
    # λ = 0.01 im^−2: Cornell's closed form; the table's ends lie 3 dispersions or more away.
    assert rate.annual == pytest.approx(0.01 * curve.median**-2.0 * np.exp(2.0 * curve.dispersion**2), rel=1e-2)
    assert rate.low < rate.annual < rate.high


def test_a_hazard_curve_of_the_buildings_period_is_taken_and_kept(tmp_path):
    file = site_file(tmp_path, "Sa(0.5 s) [m/s^2],annual rate")
    found = assess(made_up(lognormal(20)), hazard=file, intensity="sa(A)")
    assert found.hazard_rows == ((0.1, 1.0), (100.0, 1e-6))


def test_the_bound_of_the_required_gap_is_where_the_verdict_turns():
    """A gap at the upper bound is adequate for what the percentile leaves, a hair less is not; below the lower bound
    every gap is inadequate."""
    dataset = made_up(lognormal(120))
    (one,) = assess(dataset).interfaces
    required = next(each for each in one.required if each.percentile == 84.0)
    assert required.bounded
    words = [
        assess(dataset, gap=gap).interfaces[0].verdict.word
        for gap in (required.high, 0.999999 * required.high, 0.999999 * required.low)
    ]
    assert words == ["adequate", "depends", "inadequate"]


def test_one_recording_has_no_fragility():
    """Its components and polarities differ, but say nothing of how recordings do."""
    (one,) = assess(made_up(lognormal(1))).interfaces
    assert all(each.fault for each in one.fragility)
    assert any("one recording" in each.fault for each in one.fragility)


def in_a_row(one: xr.Dataset, other: xr.Dataset) -> xr.Dataset:
    """Three buildings whose interfaces have the motions of two datasets of a pair, and no run that pushes."""
    both = xr.concat([one.drop_vars("peak_displacement_free"), other.drop_vars("peak_displacement_free")], "interface")
    both = both.drop_dims(["building", "contact_point", "storey"])
    both = both.assign_coords(building=["A", "B", "C"], interface=["A | B", "B | C"])
    both = both.assign({name: one[name] for name in ("status", "simulated")})  # of a run, not of an interface
    both["building_period"], both["building_damping"] = ("building", [0.5, 0.6, 0.7]), ("building", [0.05] * 3)
    shape = (one.sizes["record"], one.sizes["polarity"], 3)
    both["peak_displacement_free"] = (("record", "polarity", "building"), np.full(shape, 0.03))
    both = both.set_coords(["building_period", "building_damping"])
    sides = [Building(name, 1e5, 0.5, 0.05) for name in "ABC"]
    points = [Point(at, 1.0, 1.0, "floor", np.nan) for at in (0, 1)]
    both = both.assign_coords(place_coordinates(sides, points, np.tile(both["yield_force"].values[:, None], 2)))
    both["peak_closing"] = both["impact_count"] * 0.0  # no run closes more than the motion without contact
    both.attrs = one.attrs | {"scene_resolved": 2 * one.attrs["scene_resolved"]}
    return both


def test_interfaces_are_taken_one_by_one():
    """A dataset with an axis of interfaces has each pair of neighbours assessed with its own motions."""
    one, other = made_up(lognormal(6)), made_up(lognormal(6, scale=0.1, seed=15))
    both = in_a_row(one, other)
    assert [name for name, _ in Results(both).interfaces] == ["A | B", "B | C"]
    first, second = assess(both).interfaces
    assert first.contact == assess(one).interfaces[0].contact
    assert second.closing == assess(other).interfaces[0].closing
    assert (first.name, second.name) == ("A | B", "B | C")


def test_a_dictionary_of_it_is_json(dataset):
    told = json.loads(json.dumps(assess(dataset).as_dict(), allow_nan=False))
    assert told["interfaces"][0]["verdict"]["word"] in ("adequate", "inadequate", "depends")
    assert told["interfaces"][0]["contact"][0]["gap"] == 0.0


def test_a_gap_or_amplitude_that_cannot_be_is_refused(dataset, says):
    says(refusal(assess, dataset, gap=-0.01), refusal(assess, dataset, pga=2.0))
    says(refusal(assess, made_up(lognormal(4)), pga=2.0))


def test_a_target_beside_another_percentile_is_what_the_verdict_uses():
    """80 recordings of which 12 % close the gap: within 16 %, which the percentile leaves, and above 2 %."""
    closing = np.where(np.arange(80) < 10, 0.03, 0.01)[:, None] * np.linspace(0.99, 1.01, 80)[:, None]
    results = made_up(closing)
    results.attrs["records"] = "[]"
    found = assess(results, target="2 %", percentile=84)
    (one,) = found.interfaces
    assert one.verdict.word == "inadequate"
    assert "the verdict uses the target" in found.asked
    needed = one.required_at(98.0).gap
    assert any(sentence.startswith(f"Provide at least {1e3 * needed:.3g} mm") for sentence in one.verdict.conclusion)
    assert one.verdict.margin == pytest.approx(0.02 / one.required_at(84.0).gap)  # that of the percentile


def test_one_record_is_assessed_with_its_limits_told():
    """One component in one polarity, no grid of gaps to speak of, and no finite F_E."""
    results = made_up(np.array([[0.03]])).isel(gap=[2], yield_force=[2])
    found = assess(results)
    (one,) = found.interfaces
    assert one.verdict.word == "depends"
    assert "1 of 1 motion as recorded closes" in one.verdict.sentence
    assert one.yielding == ()
    assert all(each.fault for each in one.fragility)
    assert assessment_figure(found).axes


def test_the_figure_draws_a_few_yield_forces():
    """Stripes of contact and yielding: the force grows with the closing, so that F_E counts as another gap."""
    closing = lognormal(40, scale=0.01)[..., None] * np.array([1.0, 2.0, 4.0, 8.0])
    yields = np.zeros((*closing.shape, 1, 4, 3), dtype=np.int32)
    for place, least in enumerate((0.03, 0.05)):
        yields[..., place] = (closing > least)[..., None, None]
    found = assess(made_up(closing, yields=yields))
    axis = assessment_figure(found).axes[1]
    assert axis.get_title() == "yielding: law 0"
    told = [text.get_text() for text in axis.get_legend().get_texts()]
    assert [words.partition(":")[0] for words in told if "median" in words] == [
        "contact, gap 20 mm",
        "$F_E$ 1000 kN, gap 20 mm",
        "$F_E$ 2000 kN, gap 20 mm",
    ]
    medians = [each.median for each in found.interfaces[0].fragility if each.what == "yield"]
    assert medians == pytest.approx([3.0, 5.0], rel=0.15)  # three standard errors of ln θ


def test_the_figure_says_what_it_shows(dataset):
    figure = assessment_figure(assess(dataset), "as a test")
    left, right = figure.axes
    assert (left.get_xlabel(), left.get_ylabel()) == ("gap [mm]", "P(contact) [1]")
    assert right.get_xlabel() == "PGA [g]"
    told = words_of(figure).replace("\n", " ")
    assert told.startswith("20 mm is ")
    assert "6 motions of 2 recordings at PGA 0.3 g" in told
    (step,) = left.patches
    closing = 1e3 * np.sort(dataset["peak_closing_free"].isel(pga=-1).values.ravel())
    assert step.get_data().edges[1:-1] == pytest.approx(closing)
    assert step.get_data().values == pytest.approx(np.arange(6, -1, -1) / 6.0)


def test_marks_of_rules_do_not_hide_each_other():
    """SRSS and CQC of unlike periods are alike, and the second mark lay on the first."""
    found = assess(made_up(lognormal(20)))
    axis = assessment_figure(found).axes[0]
    marks = [line for line in axis.lines if str(line.get_label()).split(":")[0] in ("ABS", "SRSS", "CQC")]
    heights = [axis.transData.transform((0.0, line.get_ydata()[0]))[1] for line in marks]
    apart = marks[0].get_markersize() * axis.figure.dpi / 72.0
    assert len(marks) == 3 and min(np.diff(sorted(heights))) >= apart


def drawn_rules(found: object) -> dict[str, tuple[float, str]]:
    """Where each code rule is drawn [mm], by its words, and with which mark."""
    axis = assessment_figure(found).axes[0]
    return {
        str(line.get_label()): (float(line.get_xdata()[0]), str(line.get_marker()))
        for line in axis.lines
        if str(line.get_label()).split(":")[0] in ("ABS", "SRSS", "CQC")
    }


@pytest.mark.complete
def test_what_a_rule_asks_is_drawn_where_it_is_or_as_an_arrow():
    """Buildings that move together: rules ask for more than the motions need, here 1.5 and 10 times."""
    for factor, arrow in ((1.5, False), (10.0, True)):
        results = made_up(lognormal(20))
        results["peak_displacement_free"][..., 0] = factor * results["peak_closing_free"]
        found = assess(results)
        (one,) = found.interfaces
        end = 1e-3 * assessment_figure(found).axes[0].get_xlim()[1]
        assert len(drawn_rules(found)) == 3
        for words, (place, mark) in drawn_rules(found).items():
            assert " of the motions' peaks" in words
            name = words.split(":")[0].lower()
            asked = next(each.upper for each in one.separations if each.row.rule == name)
            assert (mark == ">") == arrow == words.endswith(", beyond the axis")
            assert place == pytest.approx(1e3 * (end if arrow else asked))
            assert arrow == (asked > end)


def many_curves(forces: int = 12) -> xr.Dataset:
    """Two laws and many yield forces, each reached from another closing on."""
    closing = lognormal(40, scale=0.01)[..., None] * np.array([1.0, 2.0, 4.0, 8.0])
    yields = np.zeros((*closing.shape, 2, 4, 3), dtype=np.int32)
    results = made_up(closing, yields=yields).isel(yield_force=[0] * forces)
    results = results.assign_coords(yield_force=1e6 * np.arange(1, forces + 1))
    least = np.linspace(0.02, 0.06, forces)
    reached = (closing[..., None] > least)[..., None, None, :]
    results["yield_exceedance"] = (
        results["yield_exceedance"].dims,
        np.broadcast_to(reached, results["yield_exceedance"].shape).astype(np.int32),
    )
    return results


def test_every_curve_and_rate_of_yielding_is_listed_with_its_model(tmp_path, capsys):
    """Twelve F_E under two laws: 24 curves and as many rates, none of them dropped and none without its law."""
    site = site_file(tmp_path, "pga [m/s^2],annual rate")
    print_sheet(sheet(assess(many_curves(), hazard=site)))
    told = capsys.readouterr().out
    curves, rates = (told.partition(start)[2].partition("\n\n")[2] for start in ("fragility against", "annual rates"))
    tables = curves.partition("\n\n")[0], rates.partition("\n\n")[0]
    for law in ("law 0", "law 1"):
        for table in tables:
            assert len(re.findall(rf"^yielding .* {law} ", table, re.MULTILINE)) == 12


def test_curves_that_are_not_fitted_are_named(capsys):
    """F_E of 1 MN is never reached and that of 2 MN is: both are told, beside each other."""
    results = many_curves(4)
    results["yield_exceedance"][..., 0] = 0
    print_sheet(sheet(assess(results)))
    told = capsys.readouterr().out
    first, second = (f"yielding, gap 20 mm, F_E 1000 kN under {law}" for law in ("law 0", "law 1"))
    assert f"{first}; {second}: none of the 320 runs reach it" in told


def test_a_hazard_curve_that_ends_too_soon_gives_lower_bounds(tmp_path, capsys):
    """0.3 to 0.35 g of a curve that goes on: in text, in the figure and in what is written it is "at least"."""
    site, whole = tmp_path / "short.csv", tmp_path / "whole.csv"
    rates = {pga: 0.01 * (pga * G) ** -2.0 for pga in (0.001, 0.3, 0.35, 50.0)}
    for file, rows in ((site, (0.3, 0.35)), (whole, (0.001, 0.3, 0.35, 50.0))):
        file.write_text("pga [g],annual rate\n" + "".join(f"{pga},{rates[pga]!r}\n" for pga in rows))
    results = made_up(lognormal(20), pga=4.0)
    found, known = (assess(results, hazard=file) for file in (site, whole))
    (cut,), (full,) = (
        [rate for rate in each.interfaces[0].rates if (rate.what, rate.gap) == ("contact", 0.02)]
        for each in (found, known)
    )
    assert cut.at_least and not full.at_least
    # One power of the intensity throughout: what is left out is what the whole curve has more, to its own ends.
    assert cut.missing == pytest.approx(1.0 - cut.annual / full.annual, abs=1e-3)
    print_sheet(sheet(found))
    told = capsys.readouterr().out
    assert f"at least {rounded(cut.annual, 3)}" in told and "the hazard curve ends where failures do not" in told
    labels = [text.get_text() for text in assessment_figure(found).axes[1].get_legend().get_texts()]
    assert any(f"contact in 50 years at least {100 * cut.fifty_years:.2g} %" in each for each in labels)
    print_sheet(sheet(known))
    rates = capsys.readouterr().out.partition("annual rates")[2]
    assert rates and "at least" not in rates
    written = found.as_dict()["interfaces"][0]["rates"]
    assert any(each["at_least"] is True and each["missing"] == cut.missing for each in written)


def test_every_effect_is_known_to_leave_the_free_motion_linear_or_not():
    """One that is neither would count as nonlinear, and a scene with it would lose its scaled fragility."""
    nonlinear = {"inelastic_storeys"}  # twice the motion is not twice the closing
    assert set(EFFECTS) == demands.LINEAR | nonlinear and not demands.LINEAR & nonlinear


def test_a_selected_gap_is_the_one_assessed():
    """One gap left of the grid's is asked about, whatever the scene's own is; of several left the scene's own."""
    text = scene_text(records={"names": ["RSN6-180", "RSN6-270"], "window": ["0 s", "6 s"], "pga": "0.3 g"})
    results = scan(parse_scene(text, "scene", ['grid.gap=["10 mm", "20 mm", "60 mm"]']), check_fraction=0.0)
    own = assess(results).interfaces[0]
    assert own.gap == 0.01
    for part in (results.sel(gap=0.06), results.isel(gap=[2])):
        one = assess(part).interfaces[0]
        assert one.gap == 0.06 and "a gap of 60 mm" in one.verdict.sentence
    assert assess(results.isel(gap=[0, 2])).interfaces[0].gap == 0.01


def test_where_in_place_of_a_selection_is_told(says):
    text = scene_text(records={"names": ["RSN6-180", "RSN753-000"], "window": ["0 s", "6 s"], "pga": "0.3 g"})
    results = scan(parse_scene(text), check_fraction=0.0)
    says(refusal(assess, results.where(results["record_pga"] > 2.8, drop=True)))
