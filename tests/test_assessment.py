"""Assessments of made-up motions whose answers are known, and of a real scan case by case."""

from __future__ import annotations

import json
import subprocess
import sys

import numpy as np
import pytest
import xarray as xr
from scipy.stats import lognorm, norm
from typer.testing import CliRunner

from pounding_risk import assess, cli
from pounding_risk.assessed_data import motions_of
from pounding_risk.assessment import interfaces
from pounding_risk.ensemble import scan
from pounding_risk.errors import PoundingError
from pounding_risk.figures_assess import assessment_figure
from pounding_risk.results import as_text, save
from pounding_risk.scenario import parse_scene

G = 9.80665
SCENE = """
[[building]]
name = "left"
mass = "10 t"
period = "0.5 s"
[[building]]
name = "right"
mass = "20 t"
period = "0.3 s"
damping = 0.02
[[interface]]
gap = "20 mm"
contact_model = "linear"
stiffness = "1e5 kN/m"
yield_force = "300 kN"
[records]
names = ["RSN6-180", "RSN6-270", "RSN1690-090"]
window = ["0 s", "8 s"]
polarity = ["as recorded", "reversed"]
[grid]
gap = ["0 mm", "5 mm", "10 mm", "20 mm", "40 mm"]
yield_force = ["100 kN", "300 kN", "inf"]
pga = ["0.1 g", "0.3 g"]
"""


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
    coordinates = {
        "record": records,
        "polarity": ["as recorded", "reversed"][: closing.shape[1]],
        "contact_model": models,
        "gap": gaps,
        "yield_force": forces,
        "building": ["A", "B"],
        "building_period": ("building", [0.5, np.nan]),
        "building_damping": ("building", [0.05, np.nan]),
        "record_pga": ("record", np.linspace(2.0, 4.0, len(records))),
        **({"pga": np.array([1.0, 2.0, 4.0, 8.0])[: closing.shape[-1]]} if several else {}),
        **more,
    }
    scene = f'[[interface]]\ngap = "{gap!r} m"\n'
    return xr.Dataset(variables, coordinates, {"title": "made up", "scene_resolved": scene, "records": as_text(facts)})


def lognormal(count: int, scale: float = 0.02, spread: float = 0.5, seed: int = 14) -> np.ndarray:
    return lognorm(spread, scale=scale).rvs((count, 2), random_state=seed)


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
    assert [each.gap for each in one.required] == pytest.approx(np.percentile(closing, [50.0, 84.0, 95.0]).tolist())
    verdict = one.verdict
    assert (verdict.motions, verdict.recordings, verdict.runs, verdict.failed) == (6, 2, dataset["status"].size, 0)
    assert verdict.margin == pytest.approx(0.02 / np.percentile(closing, 84.0))
    assert verdict.governing[0].closing == closing.max()
    assert verdict.governing[0].record == str(dataset["record"].values[closing.argmax() // 2])
    assert one.contact_at_gap().count == int((closing > 0.02).sum())
    assert {each.row.rule for each in one.separations} >= {"abs", "srss", "cqc"}


def test_motions_know_their_recordings(dataset):
    """Both components of one station and both polarities belong together, record by record."""
    motions = motions_of(dataset)
    assert motions.recordings.tolist() == [0, 0, 0, 0, 1, 1]
    assert motions.records[::2] == ("RSN6-180", "RSN6-270", "RSN1690-090")
    assert motions.polarities == ("as recorded", "reversed") * 3
    assert motions.closing[3, 1] == dataset["peak_closing_free"].values[1, 1, 1]


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
    found = next(each for each in one.fragility if each.gap == 0.02 and each.what == "contact")
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
    file = tmp_path / "site.csv"
    file.write_text("pga [m/s^2],annual rate\n0.1,1\n100,1e-6\n")
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
    found = next(each for each in one.fragility if each.gap == 0.02 and each.what == "contact")
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
    contact = next(each for each in one.fragility if each.gap == 0.02 and each.what == "contact")
    assert [stripe.im for stripe in contact.stripes] == pytest.approx(np.linspace(2.0, 4.0, 30))
    (one,) = assess(results, intensity="sa(A)").interfaces
    contact = next(each for each in one.fragility if each.gap == 0.02 and each.what == "contact")
    known = np.sort((2.0 * np.pi / 0.5) ** 2 * closing.ravel())
    assert [stripe.im for stripe in contact.stripes] == pytest.approx(known)
    # The closing is the building's own displacement here: it touches at one Sa, and nothing is left to spread.
    assert "no dispersion" in contact.fault
    with pytest.raises(PoundingError, match=r"sa\(right\).*rigid"):
        assess(results, intensity="sa(right)")
    with pytest.raises(PoundingError, match=r"write pga, sa\(left\), sa\(right\), or by name sa\(A\), sa\(B\)"):
        assess(results, intensity="sa(C)")


@pytest.mark.parametrize(
    ("closing", "gap", "word", "words"),
    [
        (0.01, 0.02, "adequate", "none of 160 motions as scanned closes a gap of 20 mm: P(contact) 0 % (95 % bounds"),
        (0.01, 0.005, "inadequate", "160 of 160 motions as scanned close a gap of 5 mm: P(contact) 100 %"),
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
    assert "4 motions of 1 recording, " in told
    assert "below 98 % and no less; a target of 10 % takes 36." in told  # 1 − 0.025, and 36 as in test_proportions
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
    assert "20 of them failed" in one.verdict.sentence
    with pytest.raises(PoundingError, match="no motion of the dataset has a finite response"):
        assess(made_up(np.full((2, 2), np.nan)))


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


def test_what_matters_is_ranked_by_its_spread():
    """The law moves yielding by 1, F_E by a half of that, the polarity by nothing."""
    yields = np.zeros((4, 2, 2, 4, 3), dtype=np.int32)
    yields[:, :, 1, :, :2] = 1
    yields[:2, :, 1, :, 1] = 0
    (one,) = assess(made_up(lognormal(4), yields=yields)).interfaces
    found = {each.key: each for each in one.sensitivity if each.what == "P(yield)"}
    assert [each.key for each in one.sensitivity if each.what == "P(yield)"] == [
        "contact_model",
        "yield_force",
        "polarity",
    ]
    assert found["contact_model"].spread == pytest.approx(0.75)
    assert found["contact_model"].levels == (("law 0", 0.0), ("law 1", 0.75))
    assert found["contact_model"].turns  # on both sides of 10 %
    assert found["yield_force"].spread == pytest.approx(0.25)
    assert found["polarity"].spread == 0.0
    assert one.what_matters.startswith(
        "whether F_E is reached depends most on the contact model (by 0.75), then on F_E (by 0.25);"
    )
    contact = [each for each in one.sensitivity if each.what == "P(contact)" and each.key != "polarity"]
    assert [each.spread for each in contact] == [0.0, 0.0]


def test_rates_come_with_a_hazard_curve(tmp_path):
    file = tmp_path / "site.csv"
    file.write_text("pga [m/s^2],annual rate [1/year]\n0.1,1\n100,1e-6\n")
    (one,) = assess(made_up(lognormal(20), pga=4.0), hazard=file).interfaces
    assert len(one.rates) == len(one.fragility)
    place = next(place for place, each in enumerate(one.fragility) if each.gap == 0.02)
    curve, rate = one.fragility[place], one.rates[place]
    # λ = 0.01 im^−2: Cornell's closed form; the table's ends lie 3 dispersions or more away.
    assert rate.annual == pytest.approx(0.01 * curve.median**-2.0 * np.exp(2.0 * curve.dispersion**2), rel=1e-2)
    assert rate.low < rate.annual < rate.high
    with pytest.raises(PoundingError, match="the hazard curve is one of pga"):
        assess(made_up(lognormal(20)), hazard=file, intensity="sa(A)")


@pytest.mark.parametrize(
    ("curve", "words"),
    [
        ("Sa(1.0 s)", r"one of sa\(1.0 s\), the fragility one against Sa at 0.5 s, the building's own period"),
        ("sabotage", "the hazard curve is one of sabotage"),
        ("pga", "the hazard curve is one of pga"),
    ],
)
def test_a_hazard_curve_of_another_intensity_is_refused(tmp_path, curve, words):
    file = tmp_path / "site.csv"
    file.write_text(f"{curve} [g],annual rate\n0.01,1\n10,1e-6\n")
    with pytest.raises(PoundingError, match=words):
        assess(made_up(lognormal(20)), hazard=file, intensity="sa(A)")


def test_a_hazard_curve_of_the_buildings_period_is_taken_and_kept(tmp_path):
    file = tmp_path / "site.csv"
    file.write_text("Sa(0.5 s) [m/s^2],annual rate\n0.1,1\n100,1e-6\n")
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


def test_a_dataset_without_its_scene_is_refused():
    dataset = made_up(lognormal(4))
    del dataset.attrs["scene_resolved"]
    with pytest.raises(PoundingError, match="has lost its attribute 'scene_resolved'"):
        assess(dataset)


def test_interfaces_are_taken_one_by_one():
    """A dataset with an axis of interfaces has each pair of neighbours assessed with its own motions."""
    one, other = made_up(lognormal(6)), made_up(lognormal(6, scale=0.1, seed=15))
    both = xr.concat([one.drop_vars("peak_displacement_free"), other.drop_vars("peak_displacement_free")], "interface")
    both = both.drop_dims("building").assign_coords(building=["A", "B", "C"])
    both["building_period"], both["building_damping"] = ("building", [0.5, 0.6, 0.7]), ("building", [0.05] * 3)
    both["peak_displacement_free"] = (("record", "polarity", "building"), np.full((6, 2, 3), 0.03))
    both = both.set_coords(["building_period", "building_damping"])
    both.attrs = one.attrs | {"scene_resolved": 2 * one.attrs["scene_resolved"]}
    assert [name for name, _ in interfaces(both)] == ["A | B", "B | C"]
    first, second = assess(both).interfaces
    assert first.contact == assess(one).interfaces[0].contact
    assert second.closing == assess(other).interfaces[0].closing
    assert (first.name, second.name) == ("A | B", "B | C")


def test_a_dictionary_of_it_is_json(dataset):
    told = json.loads(json.dumps(assess(dataset).as_dict(), allow_nan=False))
    assert told["interfaces"][0]["verdict"]["word"] in ("adequate", "inadequate", "depends")
    assert told["interfaces"][0]["contact"][0]["gap"] == 0.0


def test_options_out_of_range_are_refused(dataset):
    for option, words in (
        ({"confidence": 1.0}, "confidence is 1; it lies between 0 and 1"),
        ({"target": 0.0}, "target is 0;"),
        ({"percentile": 100.0}, "percentile is 100; it lies between 0 and 100"),
        ({"gap": -0.01}, "gap: -0.01 is out of range"),
        ({"pga": 2.0}, "which has 0.1 g, 0.3 g"),
    ):
        with pytest.raises(PoundingError, match=words):
            assess(dataset, **option)
    with pytest.raises(PoundingError, match="its motions are as recorded"):
        assess(made_up(lognormal(4)), pga=2.0)


def test_other_datasets_are_refused_by_name(dataset):
    for other, name in (
        (xr.Dataset(coords={"time": [0.0]}), "simulate"),
        (xr.Dataset(coords={"setting": ["x"]}), "accuracy"),
        (xr.Dataset(coords={"effects": ["x"]}), "effects"),
        (dataset.assign_attrs(baseline="linear"), "compare"),
    ):
        with pytest.raises(PoundingError, match=f"a dataset of `{name}`"):
            assess(other)
    with pytest.raises(PoundingError, match="no dataset of pounding-risk"):
        assess(xr.Dataset())
    with pytest.raises(PoundingError, match=r"has no peak_closing_free: an older version wrote it; scan"):
        assess(dataset.drop_vars("peak_closing_free"))


def test_one_record_is_assessed_with_its_limits_told():
    """One component in one polarity, no grid of gaps to speak of, and no finite F_E."""
    results = made_up(np.array([[0.03]])).isel(gap=[2], yield_force=[2])
    found = assess(results)
    (one,) = found.interfaces
    assert one.verdict.word == "depends"
    assert "1 of 1 motions as scanned closes" in one.verdict.sentence
    assert one.yielding == ()
    assert all(each.fault for each in one.fragility)
    assert assessment_figure(found).axes


def test_the_command_prints_writes_and_draws(dataset, tmp_path):
    file, out, figure = tmp_path / "scan.nc", tmp_path / "found.json", tmp_path / "found.png"
    site = tmp_path / "site.csv"
    site.write_text("pga [g],annual rate [1/year]\n0.02,0.1\n0.5,1e-4\n")
    save(dataset, file)
    arguments = [str(file), "--gap", "10 mm", "--percentile", "90", "--hazard", str(site)]
    run = CliRunner().invoke(cli.app, ["assess", *arguments, "-o", str(out), "--figure", str(figure)])
    assert run.exit_code == 0, run.output
    (one,) = assess(dataset, gap=0.01, percentile=90.0, hazard=site).interfaces
    assert one.verdict.sentence in run.output
    assert "90 % of the motions" in run.output
    assert f"{one.contact_at_gap().count} of 6" in run.output
    assert "NO: the clause is not verified" in run.output
    assert json.loads(out.read_text()) == assess(dataset, gap=0.01, percentile=90.0, hazard=site).as_dict()
    assert figure.stat().st_size > 20_000
    for wrong, words in (
        (["--gap", "10 kN"], "--gap"),
        (["-o", str(tmp_path / "found.txt")], "must end in .json"),
        (["--target", "2"], "target is 2"),
    ):
        run = CliRunner().invoke(cli.app, ["assess", str(file), *wrong])
        assert run.exit_code == 2
        assert words in run.output


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
    assert right.get_xlabel() == "pga [g]"
    told = figure.get_suptitle()
    assert told.startswith("20 mm is ")
    assert "6 motions of 2 recordings at 0.3 g" in told
    (step,) = left.patches
    closing = 1e3 * np.sort(dataset["peak_closing_free"].isel(pga=-1).values.ravel())
    assert step.get_data().edges[1:-1] == pytest.approx(closing)
    assert step.get_data().values == pytest.approx(np.arange(6, -1, -1) / 6.0)


def test_an_assessment_needs_no_solver():
    code = (
        "import sys\nfor name in ('numba', 'obspy'): sys.modules[name] = None\n"
        "import pounding_risk.assessment, pounding_risk.figures_assess, pounding_risk.results"
    )
    assert subprocess.run([sys.executable, "-c", code], timeout=60).returncode == 0
