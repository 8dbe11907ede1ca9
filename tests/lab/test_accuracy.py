"""Accuracy against time: errors that are errors, times of the same cases, sentences that follow from the numbers."""

import json
import re

import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from scenes import rigid, scene_text, single, storeyed
from sentences import refusal
from sweeps import sweep

from pounding_risk import accuracy, effects
from pounding_risk.errors import PoundingError
from pounding_risk.lab import accuracy_findings as findings
from pounding_risk.lab.accuracy import FAR, FIXED, GENERAL, OPENSEES, RTOLS, TIGHTEST, Setting, _reference_words
from pounding_risk.lab.accuracy_bench import bench_of, thinned_grid
from pounding_risk.lab.accuracy_findings import COUNT, EVENT, FIRST, FORCE, GAP, LEVELS, OUTPUTS, REACH, YIELDS
from pounding_risk.lab.accuracy_opensees import opensees_outcome, unsaid
from pounding_risk.lab.baselines.solve_ivp import GaveUp
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies import demo

SCENE = scene_text(
    name="accuracy",
    law="viscous_elastoplastic",
    records={"window": ["0 s", "4 s"], "pga": "0.5 g"},
    grid={"gap": ["0 mm", "10 mm", "20 mm", "30 mm", "40 mm"], "yield_force": ["900 kN", "1800 kN", "inf"]},
)


@pytest.fixture(scope="module")
def study():
    return parse_scene(SCENE)


@pytest.fixture(scope="module")
def dataset(study) -> xr.Dataset:
    return accuracy(study, cases=6, budget=1.0, scipy=True)


def rows(*values: float) -> np.ndarray:
    return np.array([values], dtype=float)


def test_errors_are_relative_counts_are_shares_and_flags_are_plain():
    reference = rows(0.1, 1e6, 20, 1, 2.0, 0.05)
    found = findings.errors_of(rows(0.11, 0.9e6, 21, 0, 2.2, 0.05), reference)
    assert found[0] == pytest.approx([0.1, 0.1, 0.05, 1.0, 0.1, 0.0])


def test_a_motion_that_blew_up_is_infinitely_wrong():
    reference = rows(0.1, 1e6, 20, 1, 2.0, 0.05)
    assert np.isinf(findings.errors_of(np.full((1, 6), np.nan), reference.copy())).all()
    # Contact that one sees and the other does not; none in both is right.
    missed = findings.errors_of(rows(0.1, 0.0, 0, 0, np.nan, 0.05), reference.copy())
    assert np.isinf(missed[0, FIRST]) and missed[0, FORCE] == 1.0
    nothing = rows(0.1, 0.0, 0, 0, np.nan, 0.05)
    assert findings.errors_of(nothing.copy(), nothing.copy())[0].tolist() == [0.0] * 6


def test_digits_hold_within_half_a_unit_of_the_last():
    reference = rows(0.12345, 8.543e6, 23, 1, 2.0222, 0.038590)
    for column, unit in ((REACH, 1e-4), (FORCE, 1e3), (FIRST, 1e-3)):
        for share, holds in ((0.49, True), (0.51, False)):
            moved = reference.copy()
            moved[0, column] += share * unit
            assert findings.holds_digits(moved, reference) is holds, (column, share)
    for column in (COUNT, YIELDS):
        moved = reference.copy()
        moved[0, column] -= 1.0
        assert not findings.holds_digits(moved, reference)
    assert not findings.holds_digits(np.full((1, 6), np.nan), reference)


def made_up(points: dict[str, list[tuple[float, float, float]]]) -> xr.Dataset:
    """A dataset of one case from (parameter, time, error) of settings by method; all outputs have the same error."""
    settings = [(Setting(method, value), time, error) for method in points for value, time, error in points[method]]
    errors = np.array([[[error] * 6] for _, _, error in settings])
    reference = rows(0.1, 1e6, 100, 1, 2.0, 0.05)
    return xr.Dataset(
        {
            "error": (("setting", "case", "output"), errors),
            "value": (("setting", "case", "output"), reference[np.newaxis] * (1.0 + errors)),
            "reference": (("case", "output"), reference),
            "time": (("setting", "output"), np.array([[time] * 6 for _, time, _ in settings])),
        },
        coords={
            "setting": [setting.words for setting, _, _ in settings],
            "method": ("setting", [setting.method for setting, _, _ in settings]),
            "output": list(OUTPUTS),
        },
    )


def test_the_sentence_names_the_cheapest_setting_that_is_good_enough(says):
    """Ours, another method where that is cheaper, and none; others that do not get there, or were not run."""
    ours = {EVENT: [(1e-3, 1e-4, 1e-2), (1e-5, 2e-4, 1e-6), (1e-7, 3e-4, 1e-9)]}
    for points in (
        ours | {"Runge-Kutta 4": [(1e-3, 5e-5, 1e-2), (1e-5, 2e-2, 1e-5)]},
        ours | {"central difference": [(1e-4, 1e-5, 1e-5)]},
        {EVENT: [(1e-3, 1e-4, 1e-2)]},
        ours | {"Runge-Kutta 4": [(1e-3, 5e-5, 1e-2)]},
        ours,
    ):
        says(findings.finding(made_up(points)))


def test_a_method_that_was_run_in_some_cases_is_judged_by_these():
    """Three cases, SciPy in the first: NaN where it was not run, which is no failure, and infinite where one failed."""
    data = made_up({EVENT: [(1e-7, 3e-4, 1e-9)], "SciPy DOP853": [(1e-9, 1e-2, 2e-8)]})
    data = xr.concat([data] * 3, "case", data_vars="minimal").transpose("setting", "case", ...)
    data["value"].values[1, 1:] = data["error"].values[1, 1:] = np.nan
    told = findings.finding(data)
    assert told.endswith("a run; SciPy DOP853, rtol 1e-09, has them too in the 1 of 3 cases in which it was run.")
    data["error"].values[1, 1:] = np.inf
    assert findings.finding(data).endswith("; no setting of another method gets there.")


def test_the_time_to_reach_a_level_lies_on_straight_lines_in_logarithms():
    data = made_up({EVENT: [(1e-3, 1e-4, 1e-3), (1e-5, 1e-3, 1e-5), (1e-6, 2e-3, 1e-4), (1e-7, 1e-2, 0.0)]})
    reach = dict(zip(LEVELS, findings.times_to_reach(data, EVENT, "peak_contact_force"), strict=True))
    assert reach[1e-2] == 1e-4  # the loosest setting is better than that
    assert reach[1e-3] == pytest.approx(1e-4)
    assert reach[1e-4] == pytest.approx(10**-3.5)  # half way in both logarithms
    assert reach[1e-5] == pytest.approx(1e-3)
    assert reach[1e-6] == reach[1e-9] == 1e-2  # no error at all: that setting's own time
    never = made_up({EVENT: [(1e-3, 1e-4, np.inf), (1e-4, 2e-4, 1e-3)]})
    assert np.isnan(findings.times_to_reach(never, EVENT, "peak_contact_force")[-1])


def test_where_another_method_is_quicker_is_told():
    both = {EVENT: [(1e-3, 4e-4, 1e-9)], "Runge-Kutta 4": [(1e-2, 1e-4, 1e-2), (1e-3, 1e-3, 1e-3)]}
    data = made_up(both)
    names = [EVENT, "Runge-Kutta 4"]
    reach = [[findings.times_to_reach(data, name, output) for output in OUTPUTS] for name in names]
    data["time_to_reach"] = (("solver", "output", "level"), np.array(reach))
    told = findings.beaten_at(data.assign_coords(solver=names))
    assert len(told) == 4  # counts and flags have no levels
    assert told[0] == "peak relative displacement: Runge-Kutta 4 for errors down to 1e-02 (4 times at most)"


def test_cases_are_thinned_to_what_was_asked(study):
    bench = bench_of(study, 6)
    assert bench.size <= 6 and len(bench.labels) == bench.size
    assert bench.gaps[:: len(bench.gaps) - 1] == [0.0, 0.04] and bench.yield_forces[-1] == np.inf
    assert bench_of(study, 1000).size == 15
    one = bench_of(study, 1)
    assert one.size == 1 and one.yield_forces == [np.inf]
    labels = bench_of(study, 1000).labels
    assert labels[4].endswith("gap 10 mm, F_E 1800 kN")
    case = list(bench_of(study, 1000).point_cases())[4]
    assert (case.gaps, case.yield_forces) == (0.01, 1.8e6)


BOTH = pytest.mark.parametrize("name", sweep(["dataset", "of_row"], "dataset"))


@BOTH
def test_the_event_driven_solver_meets_its_tolerance(name, request):
    """Largest error of displacement and force below 100 rtol: the errors of some hundred steps may add up."""
    data = request.getfixturevalue(name)
    for rtol in RTOLS:
        errors = data["error"].sel(setting=Setting(EVENT, rtol).words).values
        assert np.nanmax(errors[:, [REACH, FORCE]]) <= 100.0 * rtol + 1e-11
        assert errors[:, YIELDS].max() == 0.0
    assert float(data["energy_residual"].sel(setting=Setting(EVENT, 1e-9).words)) <= 1e-8


@BOTH
def test_scipy_witnesses_the_reference(name, request):
    """Two integrators that share no code: 1e-8 is what SciPy's event search leaves at its tightest."""
    data = request.getfixturevalue(name)
    errors = data["error"].sel(setting="SciPy DOP853, rtol 1e-12").values
    run = ~np.isnan(errors[:, REACH])
    assert run.sum() == 1 and errors[run][0, [REACH, FORCE, COUNT]].max() <= 1e-8
    assert name == "dataset" or errors[run][0, FIRST] <= 1e-8
    assert "SciPy DOP853, rtol 1e-12 differs from it by" in data.attrs["reference"]


@BOTH
def test_smaller_steps_lead_to_the_same_answer(name, request):
    """First order at every touch: a hundredth of the step leaves less than a tenth of the error."""
    data = request.getfixturevalue(name)
    for method in FIXED:
        mine = data.isel(setting=np.flatnonzero(data["method"].values == method))
        worst = mine["error"].isel(output=[REACH, FORCE]).max(dim=("case", "output")).values
        assert worst[-1] < 0.1 * worst[np.isfinite(worst)][0] and worst[-1] < 1e-2, method


def test_a_wrong_law_does_not_converge(study, dataset):
    """A tenth more stiffness: the errors stay, whatever the step."""
    bench = bench_of(study.updated(stiffness=1.1 * study.stiffness), 6)
    values = bench.fixed("rk4", 1e-5).values
    errors = findings.errors_of(values, dataset["reference"].values.copy())
    assert np.median(errors[..., FORCE]) > 1e-3


def test_the_dataset_is_whole_and_is_written(study, dataset, tmp_path):
    assert dict(dataset.sizes)["case"] == len(dataset["reference"]) and dataset.sizes["output"] == 6
    assert float(dataset["time"].min()) > 0.0
    again = accuracy(study, tmp_path / "a.nc", cases=1, budget=0.01, scipy=False)
    left_out = json.loads(again.attrs["left_out"])
    assert any("more than the budget" in words for words in left_out)
    assert not any("SciPy" in name for name in again["setting"].values)
    with xr.open_dataset(tmp_path / "a.nc") as stored:
        assert np.array_equal(stored["error"], again["error"], equal_nan=True)
        assert stored.attrs["finding"] == again.attrs["finding"]


def test_a_closed_gap_has_no_first_touch(dataset):
    at_rest = ["gap 0 mm" in label for label in dataset["case"].values]
    assert any(at_rest) and np.isnan(dataset["error"].values[:, at_rest, FIRST]).all()


def test_a_capped_force_measures_no_method(dataset):
    """The plateau of the law is F_E, which coarse steps have as exactly as fine ones."""
    forces = dataset["reference"].values[:, 0, FORCE]
    labels = (label.partition("F_E ")[2] for label in dataset["case"].values)
    strengths = 1e3 * np.array([float(label.removesuffix(" kN") or "inf") for label in labels])
    capped = forces >= strengths * (1.0 - 1e-12)
    assert 0 < capped.sum() < capped.size
    coarse = dataset["value"].sel(setting="Newmark average acceleration, dt 1e-02").values[:, 0, FORCE]
    assert np.array_equal(coarse[capped], strengths[capped])
    own = dataset.isel(setting=dataset["method"].values == EVENT)["error"].values
    assert np.isnan(own[:, capped, FORCE]).all() and not np.isnan(own[:, ~capped, FORCE]).any()
    words = f"peak contact force of {capped.sum()} of {capped.size} cases: the law caps it at F_E"
    assert any(sentence.startswith(words) for sentence in json.loads(dataset.attrs["left_out"]))


def test_an_error_of_scipy_is_said_to_be_one(says):
    """Where a looser tolerance of SciPy's agrees and its tightest does not."""
    names = [f"SciPy DOP853, rtol {rtol}" for rtol in ("1e-09", "1e-12")]
    errors = np.zeros((2, 2, len(OUTPUTS)))
    errors[:, :, REACH] = [[2e-9, 1e-9], [2e-2, 1e-12]]
    data = xr.Dataset({"error": (("setting", "case", "output"), errors)}, coords={"setting": names})
    says(_reference_words(data))
    data["error"][1, 0, COUNT] = 0.1
    says(_reference_words(data), _reference_words(data.isel(setting=[0])))


def test_a_target_that_cannot_be_written_is_refused_first(study, says, tmp_path):
    says(refusal(accuracy, study, tmp_path / "no" / "a.nc"))


@pytest.mark.complete
def test_the_figure_shows_every_output_and_method(dataset):
    from pounding_risk.figures import accuracy_figure

    figure = accuracy_figure(dataset)
    figure.draw_without_rendering()
    assert [axis.get_title() for axis in figure.axes] == list(OUTPUTS.values())
    assert all("[s]" in axis.get_xlabel() and axis.get_ylabel() for axis in figure.axes)
    legend = [text.get_text() for text in figure.legends[0].get_texts()]
    assert legend == [EVENT, *FIXED, *GENERAL]
    # A method has its colour whichever others are there, as in a study without OpenSees.
    lines = figure.legends[0].get_lines()
    fewer = accuracy_figure(dataset.sel(solver=legend[2:])).legends[0].get_lines()
    assert [line.get_color() for line in fewer] == [line.get_color() for line in lines[2:]]
    assert dataset.attrs["finding"].split(":")[0] in figure.get_suptitle().replace("\n", " ")


def test_an_integrator_that_gives_up_is_left_out_and_named(monkeypatch):
    """Which scene makes SciPy give up depends on its version, so its words are put into its mouth."""

    def gives_up(solver, row, contacts, motion, rtol):
        raise GaveUp(f"{solver} at rtol {rtol:g} stopped at 2.5 s: the step is below what numbers resolve")

    monkeypatch.setattr("pounding_risk.lab.accuracy_bench.solve_general", gives_up)
    found = accuracy(demo.scene("paper"), cases=1, budget=0.05)
    told = json.loads(found.attrs["left_out"])
    assert any("SciPy Radau, rtol 1e-03: Radau at rtol 0.001 stopped at 2.5 s" in words for words in told)
    assert "event-driven" in found.attrs["finding"]


# ------------------------------------------------------------------------------------------------ rows
ROW = scene_text(
    single("shop", "200 t", "0.45 s", height="3 m"),
    storeyed("flats", "80 t", "50 MN/m", storeys=2, damping_rule="rayleigh"),
    rigid(),
    name="a shop, flats and a wall",
    gap="6 mm",
    yield_force="800 kN",
    records={"window": ["1 s", "3.5 s"], "pga": "0.5 g"},
    grid={"gap": ["6 mm", "12 mm"]},
)


@pytest.fixture(scope="module")
def of_row() -> xr.Dataset:
    return accuracy(parse_scene(ROW), cases=2, budget=0.3)


def test_an_error_of_a_row_is_that_of_its_worst_interface(of_row):
    assert of_row["value"].dims == ("setting", "case", "interface", "output")
    assert of_row["interface"].values.tolist() == ["shop | flats", "flats | wall"]
    reference = of_row["reference"].values
    assert (reference[..., COUNT] >= 1.0).all()
    number = of_row["setting"].values.tolist().index(Setting("Runge-Kutta 4", 1e-3).words)
    value = of_row["value"].values[number]
    by_hand = np.abs(value / reference - 1.0)[..., [REACH, FORCE]].max(axis=1)
    assert of_row["error"].values[number][:, [REACH, FORCE]] == pytest.approx(by_hand, rel=1e-12)


def test_opensees_stands_beside_a_row_where_it_can(of_row, capsys):
    """Peaks come to the reference's as its steps become smaller; it has neither counts nor a first touch.

    Of the lines that it prints at every impact none is shown, in a notebook neither.
    """
    if OPENSEES not in of_row["method"].values:
        pytest.skip(json.loads(of_row.attrs["left_out"])[0])
    bench, reference = bench_of(parse_scene(ROW), 2), of_row["reference"].values
    outcomes = [opensees_outcome(bench, h) for h in (1e-3, 1e-4)]
    assert capsys.readouterr() == ("", "")
    errors = [findings.errors_of(outcome.values, reference.copy()) for outcome in outcomes]
    peaks = [each[..., [REACH, FORCE]].max() for each in errors]
    assert peaks[1] < 2e-3 and peaks[1] < 0.5 * peaks[0]
    assert errors[1][..., [YIELDS, GAP]].max() < 1e-4 and outcomes[1].outputs == (REACH, FORCE, YIELDS, GAP)
    stored = of_row["error"].sel(setting=Setting(OPENSEES, 1e-3).words).values
    assert np.isnan(stored[:, [COUNT, FIRST]]).all()
    assert stored[:, REACH] == pytest.approx(errors[0][..., REACH].max(axis=1), rel=1e-9)


CHANGES = {
    "as it is": ("", ""),
    "modal damping, which it can say": ('storeys = 2\ndamping_rule = "rayleigh"', "storeys = 3"),
    "an e that falls": ("restitution = 0.65", 'restitution = "concrete"'),
    "part-way up": ('height = "3 m"', 'height = "2 m"'),
    "a law": ('"jankowski"', '"hertz"'),
    "a law with a path": ('"jankowski"', '"bilinear"'),
    "storeys that yield": ("[records]", "[effects]\ninelastic_storeys = {}\n[records]"),
    "a P-delta effect": ("[records]", "[effects]\np_delta = {}\n[records]"),
}


@pytest.mark.parametrize("change", CHANGES)
def test_what_opensees_or_all_but_the_solver_of_rows_cannot_say_is_told(change, says):
    """Damping that is no set of dashpots, and the like; P-delta is in the matrices."""
    assert CHANGES[change][0] in ROW
    text = ROW.replace(*CHANGES[change]).replace('"rayleigh"', '"rayleigh"\nstorey_strengths = "2 MN"')
    bench = bench_of(parse_scene(text), 1)
    says(f"OpenSees: {unsaid(bench.chains, bench.points, next(bench.point_cases()))}", f"others: {bench.event_only}")


@pytest.mark.parametrize("first", ["0 mm", "6 mm"])
def test_opensees_is_left_out_where_its_hertzdamp_begins_in_touch(first: str):
    """An error of its own, which no step makes smaller, would be shown as what its accuracy costs."""
    text = ROW.replace('"jankowski"', '"hertz_damp"').replace('["6 mm", "12 mm"]', f'["{first}", "12 mm"]')
    bench = bench_of(parse_scene(text), 2)
    reasons = [unsaid(bench.chains, bench.points, case) for case in bench.point_cases()]
    assert ("leave out the gap of zero" in reasons[0]) == (first == "0 mm") and reasons[1] == ""


def test_the_figure_of_a_row_says_whose_error_it_is(of_row):
    from pounding_risk.figures import accuracy_figure

    assert "a case's that of its worst interface" in words_of(accuracy_figure(of_row)).replace("\n", " ")


def test_no_case_no_time_and_no_repetition_are_refused(study):
    for call, name in ((accuracy, "cases"), (accuracy, "budget"), (effects, "repeats")):
        with pytest.raises(PoundingError, match=f"{name}: 0 is out of range: a number of .*; write a number of"):
            call(study, **{name: 0})


def test_one_gap_and_one_yield_force_alone_are_the_scene_s_own_and_not_the_widest():
    """At the ends of a grid, the widest gap and no yielding, there may be no contact to measure anything of."""
    keys = {"gap": ["0 mm", "10 mm", "2 m"], "yield_force": ["900 kN", "1800 kN", "inf"]}
    study = parse_scene(scene_text(law="viscous_elastoplastic", gap="12 mm", yield_force="900 kN", grid=keys))
    assert thinned_grid(study, 1, 1) == ([1], [0])
    assert thinned_grid(study, 4, 1) == ([0, 2], [0, 2])
    assert thinned_grid(study, 9, 1) == ([0, 1, 2], [0, 1, 2])


# ------------------------------------------------------------------------------------------------ effort
# Settings that `accuracy` leaves out since their method is far behind, held to the numbers of those that ran.
TWO_GAPS = scene_text(records={"window": ["0 s", "6 s"], "pga": "0.5 g"}, grid={"gap": ["10 mm", "30 mm"]})


@pytest.mark.complete
def test_a_method_is_refined_until_it_is_far_behind():
    said: list[str] = []
    dataset = accuracy(parse_scene(TWO_GAPS), cases=2, say=said.append)
    worst = dataset["error"].max("case")
    time = dataset["time"].sel(output="peak_relative_displacement")
    best = TIGHTEST.words
    sentences = [words for words in json.loads(dataset.attrs["left_out"]) if ": not run: " in words]
    # Steps of 10 µs take some sixty times as long as the tightest tolerance, whatever the machine.
    assert {words.partition(", ")[0] for words in sentences} >= {"Newmark average acceleration", "Runge-Kutta 4"}
    for words in sentences:
        finer, coarser, times = re.fullmatch(
            r"(.*): not run: (.*) takes (\d+) times as long as .*, with no smaller error in any output", words
        ).groups()
        assert finer not in dataset["setting"] and coarser in dataset["setting"]
        assert int(times) >= FAR
        assert time.sel(setting=coarser) > time.sel(setting=best)
        errors = worst.sel(setting=[coarser, best]).values
        assert not (errors[0] < errors[1]).any()
    # What confirms the reference is run to its tightest tolerance.
    assert "SciPy DOP853, rtol 1e-12" in dataset["setting"]
    assert np.isfinite(dataset["error"].sel(setting="SciPy DOP853, rtol 1e-12", output="peak_contact_force")).any()
    # The time is stated before the other methods run.
    assert len(said) == 1
    words = r"2 cases: [\d.e-]+ s for 10 tolerances of the event-driven solver; at most 20 s for each of (\d+) settings"
    told = re.match(
        words + r" of other methods, ([\d.]+) min of processor time in all, less with a smaller --b", said[0]
    )
    assert told and float(told[2]) == pytest.approx(int(told[1]) * 20.0 / 60.0, rel=0.05)  # of two digits
