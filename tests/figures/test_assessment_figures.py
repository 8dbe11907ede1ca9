"""Figures of assessments: along axes every number is that of `assess_along`; of damage; and what colours mean."""

import re
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from axes import PULSE, pair_text, row_text
from figure_words import words_of
from made_scan import made_scan
from matplotlib.colors import to_hex
from scenes import damage_text, scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.along import along_finding
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.separations.rules import VERIFICATIONS
from pounding_risk.assessment.separations.table import Comparison, SeparationRow, code_table
from pounding_risk.figures import damage_figure, ida_figure, results_figure
from pounding_risk.figures.along import along_figure
from pounding_risk.figures.assess import assessment_figure, draw_rates
from pounding_risk.figures.separations import draw_rules, separations_figure
from pounding_risk.figures.style import MEANING, RULE_MARKS, STYLES, contact_styles, panel, strength_styles, styles
from pounding_risk.questions.damage import sheet as damage_sheet
from pounding_risk.reports.data import ReportData, opened
from pounding_risk.reports.document import SECTIONS
from pounding_risk.reports.explorer import page_model
from pounding_risk.results import scene_axes
from pounding_risk.scene.reader import parse_scene

PERIOD, DAMPING, MASS = "building.left.period", "building.right.damping", "building.left.mass"


@pytest.fixture(scope="module")
def whole():
    """Six periods, five damping ratios and two masses, which change no motion without contact."""
    axes = {PERIOD: {"start": "0.3 s", "stop": "1.3 s", "num": 6}, MASS: ["500 t", "600 t"]}
    return pr.scan(
        parse_scene(pair_text(axes | {DAMPING: [0.02, 0.04, 0.06, 0.08, 0.1]}, {"gap": ["10 mm", "140 mm"]})),
        check_fraction=0.0,
    )


@pytest.fixture(scope="module")
def assessed(whole):
    return pr.assess_along(whole, gap="60 mm")


@pytest.mark.complete
def test_along_one_axis_lines_with_their_bounds(whole):
    one = pr.assess_along(whole.isel({DAMPING: [2], MASS: [0]}), gap="60 mm")
    figure = along_figure(one)
    left, right = figure.axes
    in_report = along_figure(one, titled=False)
    assert [axis.get_ylabel() for axis in in_report.axes] == [left.get_ylabel(), right.get_ylabel()]
    assert in_report.get_figwidth() <= 7.5  # inches, drawn over 5.8 of a page: letters of 8 points are of 6 or more
    share, need = left.get_lines()[0], right.get_lines()[0]
    np.testing.assert_allclose(share.get_xdata(), one[PERIOD])
    np.testing.assert_array_equal(share.get_ydata(), one["contact_probability"].isel(interface=0))
    np.testing.assert_allclose(need.get_ydata(), 1e3 * one["required_gap"].isel(interface=0), rtol=1e-15)
    (band,) = right.collections
    heights = band.get_paths()[0].vertices[:, 1]
    assert heights.max() == pytest.approx(1e3 * float(one["required_gap_high"].max()))
    assert left.get_xlabel() == f"{PERIOD} [s]"
    widest = int(one["required_gap"].isel(interface=0).values.argmax())
    words = words_of(figure).replace("\n", " ")
    assert f"(the most where {PERIOD} = {float(one[PERIOD][widest]):.6g} s)" in words
    assert "shaded: bounds of 95 % by recording" in words
    assert ("give no upper bound" in words) is not bool(one["required_gap_bounded"].all())


def test_along_two_axes_maps_and_what_is_not_drawn_is_told(assessed):
    figure = along_figure(assessed)
    maps = [next(one for one in axis.collections if one.get_array() is not None) for axis in figure.axes[:2]]
    part = assessed.isel({MASS: 0, "interface": 0}).transpose(DAMPING, PERIOD)
    np.testing.assert_array_equal(np.asarray(maps[0].get_array()).ravel(), part["contact_probability"].values.ravel())
    np.testing.assert_allclose(np.asarray(maps[1].get_array()).ravel(), 1e3 * part["required_gap"].values.ravel())
    words = words_of(figure).replace("\n", " ")
    assert f"drawn where {MASS} = 500 t" in words and "bounds are not drawn" in words
    assert f"neither P(contact) nor the gap required depends on {MASS}" in words
    assert along_finding(assessed) == along_finding(assessed.isel({MASS: [0]}))


def test_a_summary_tells_in_how_many_cases_there_is_contact(whole):
    struck = whole["impact_count"] > 0
    shares = [100.0 * float(struck.isel({PERIOD: place}).mean()) for place in range(6)]
    assert min(shares) < max(shares)
    told = dict(pr.summary(whole).along)[PERIOD]
    periods = "0.3 s, 0.5 s, 0.7 s, 0.9 s, 1.1 s, 1.3 s"
    assert told == f"{periods}; contact in {min(shares):.3g} % to {max(shares):.3g} % of cases"


def test_few_values_of_a_second_axis_are_lines(assessed):
    few = assessed.isel({DAMPING: [0, 4]})
    left, right = along_figure(few).axes
    names = [text.get_text() for text in left.get_legend().get_texts()]
    assert names[:2] == [f"{DAMPING} = 0.02", f"{DAMPING} = 0.1"] and not right.collections
    np.testing.assert_allclose(
        right.get_lines()[1].get_ydata(), 1e3 * few["required_gap"].isel({DAMPING: 1, MASS: 0, "interface": 0})
    )


def test_axes_of_texts_and_of_numbers_that_move_together():
    """Names along an axis stand below their marks; the others of `zip` are named with the first."""
    axes = {PERIOD: ["0.3 s", "0.6 s", "0.9 s"], "building.right.period": ["0.5 s", "0.8 s", "1.1 s"]}
    zipped = pr.scan(parse_scene(pair_text(axes | {"zip": [[PERIOD, "building.right.period"]]})), check_fraction=0.0)
    figure = zipped.pounding.figure(gap="60 mm")
    assert figure.axes[0].get_xlabel() == f"{PERIOD}, with building.right.period [s]"
    assert re.search(rf"{PERIOD} = \S+ s, building.right.period = \S+ s", words_of(figure).replace("\n", " "))
    named = scene_text(records=PULSE, grid={"gap": ["10 mm"], "interface.restitution": ["concrete", 0.4]})
    dataset = pr.scan(parse_scene(named), check_fraction=0.0)
    left = along_figure(pr.assess_along(dataset)).axes[0]
    assert [text.get_text() for text in left.get_xticklabels()] == ["concrete", "0.4"]


def test_the_interface_of_a_row_is_told_and_may_be_chosen(says):
    row = pr.scan(parse_scene(row_text({"building.B.period": ["0.3 s", "0.5 s"]})), check_fraction=0.0)
    assessed = pr.assess_along(row, gap="10 mm")
    needed = assessed["required_gap"].max("building.B.period")
    worst, other = (
        str(assessed["interface"].values[at]) for at in (int(needed.values.argmax()), needed.values.argmin())
    )
    assert f"at {worst}" in words_of(along_figure(assessed)).replace("\n", " ")
    left = along_figure(assessed, other).axes[0]
    np.testing.assert_array_equal(left.get_lines()[0].get_ydata(), assessed["contact_probability"].sel(interface=other))
    page = page_model(row)
    assert page["pickers"][0] == "building.B.period" and page["profiles"] is not None
    assert any("drawings of the row are left out" in fact for fact in page["facts"])
    says(refusal(along_figure, assessed, "A | C"))
    says(refusal(along_figure, row))


def test_an_axis_with_an_assessment_of_its_own_is_not_drawn_or_reported(whole, monkeypatch, tmp_path, says):
    """As of samples of uncertain numbers: which place is meant must be chosen."""
    monkeypatch.setattr(scene_axes, "WITHOUT_PLACES", (DAMPING,))
    few = whole.isel({PERIOD: [0, 2]})
    for call in (few.pounding.figure, lambda: pr.report(few, tmp_path / "r.html")):
        says(refusal(call))


@pytest.mark.complete
def test_a_report_of_several_places_is_that_of_one_and_a_section_along_them(whole, assessed, tmp_path):
    few = whole.isel({DAMPING: [0, 2], PERIOD: [0, 1, 5]})
    dataset, _, along = opened(few, {"gap": "60 mm"})
    place = along.place.places
    one = few.isel({axis: [at] for axis, at in place.items()})
    assert dataset.attrs["scene_resolved"] == opened(one, {})[0].attrs["scene_resolved"]
    assert dataset.attrs["title"].endswith(f"({along.place.words})")
    text, figure, table = SECTIONS["axes"].write(ReportData(dataset, pr.assess(dataset, gap="60 mm"), {}, along=along))
    assert along.place.why in text["text"] and figure["kind"] == "figure"
    assert len(table["rows"]) == 3 * 2 * 2 and len(table["heads"]) == len(table["rows"][0]) == 8
    needs = along.assessed["required_gap"].values.ravel()
    np.testing.assert_array_equal([row[-2]["raw"] for row in table["rows"]], needs)
    shares = along.assessed["contact_probability"].values.ravel()
    np.testing.assert_array_equal([row[-4]["raw"] for row in table["rows"]], shares)
    assert needs[table["keep"]].min() >= np.delete(needs, table["keep"]).max(initial=0.0)
    page = pr.report(few, tmp_path / "r.html", gap="60 mm").read_text(encoding="utf-8")
    assert "Along the axes of the scene" in page and along.place.words in page
    assert SECTIONS["axes"].write(ReportData(dataset, pr.assess(one, gap="60 mm"), {})) == []


STATES = {"tiles": "20 mm", "cracks": "40 mm", "ruin": "20 m"}
SCENE = damage_text({name: {"displacement": limit} for name, limit in STATES.items()}) + scene_text(
    single("left", "10 t", "0.5 s"),
    single("right", "30 t", "0.8 s", damping=0.03),
    name="Two of $2",
    law="linear",
    gap="10 mm",
    records={"names": ["RSN6-180", "RSN77-164", "NAPA-HNE"], "window": ["0 s", "8 s"]},
    grid={"pga": ["0.05 g", "0.1 g", "0.2 g", "0.4 g"]},
)


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """A folder with a scan."""
    folder = tmp_path_factory.mktemp("damage")
    pr.scan(pr.read_scene(SCENE), folder / "scan.nc", check_fraction=0.0)
    return folder


def test_figures_say_the_finding(folder, says):
    results = pr.damage(folder / "scan.nc", method="ida")
    figure = damage_figure(results, note="of a test")
    above, below = figure.axes
    headline, caption = words_of(figure).split("\n", 1)
    assert headline.startswith("Median PGA with pounding at 10 mm over that without: tiles ")
    assert f"{float(results['median_ratio'][0]):.2f}" in headline
    assert "3 motions at PGA 0.05 g to 0.4 g" in caption.replace("\n", " ") and "of a test" in caption
    solid, dashed = (
        [line for line in above.get_lines() if line.get_linestyle() == dash and len(line.get_xdata()) > 2]
        for dash in ("-", "--")
    )
    assert len(solid) == len(dashed) == 3 and below.get_yscale() == "log"
    assert [line.get_color() for line in solid] == [line.get_color() for line in dashed]
    with_pounding = results["probability"].sel(state="tiles", pounding="with")
    assert solid[0].get_ydata() == pytest.approx(with_pounding.values)
    demands = ida_figure(results)
    assert words_of(demands).splitlines()[0] == headline
    assert [axis.get_title() for axis in demands.axes] == ["with pounding", "without pounding"]
    far = results.assign(demand_ratio=results["demand_ratio"].where(results["pounding"] == "without", 1e5))
    count = far["demand_ratio"].sel(state="tiles", pounding="with").size
    titles = [axis.get_title() for axis in ida_figure(far).axes]
    assert titles == [f"with pounding; {count} of {count} demands beyond the axis, up to 2e+06 mm", "without pounding"]
    limits = [line.get_xdata()[0] for line in demands.axes[0].get_lines() if line.get_linestyle() == ":"]
    assert limits == [20.0, 40.0, 20000.0]  # mm
    assert words_of(results_figure(results)) == words_of(damage_figure(results))
    drawn = next(block for block in damage_sheet(results) if block["kind"] == "figure")
    assert not drawn["svg"]().get_suptitle()  # the sentence above it says the same
    assert "bands: bounds by recording" in drawn["caption"]
    assert words_of(results_figure(results, "ida")) == words_of(demands)
    says(refusal(damage_figure, pr.open_results(folder / "scan.nc")), refusal(ida_figure, results.isel(level=[0])))


def many_states(results, demands: int, of_each: int):
    """The first state of a dataset under other names: so many of each demand."""
    places = [(demand, state) for demand in range(demands) for state in range(of_each)]
    many = results.isel(state=[0] * len(places))
    many["state_words"] = "state", [f"drift of D{demand} ≥ {state + 1} %" for demand, state in places]
    return many.assign_coords(state=[f"D{demand} S{state}" for demand, state in places])


@pytest.mark.parametrize(("demands", "of_each", "panels"), [(2, 3, 1), (4, 4, 4), (1, 8, 2), (7, 2, 5)])
def test_every_curve_of_many_states_has_a_look_of_its_own_in_its_panel(folder, demands, of_each, panels):
    """Of six states, as many as there are marks, in one panel; of more in a row of two for each demand, five rows."""
    many = many_states(pr.damage(folder / "scan.nc", method="ida"), demands, of_each)
    figure = damage_figure(many)
    assert len(figure.axes) == 2 * panels
    legends = [text.get_text() for axis in figure.axes if axis.get_legend() for text in axis.get_legend().get_texts()]
    drawn = [state for state in many["state"].values if any(label.startswith(state) for label in legends)]
    for axis in figure.axes[::2]:
        points = [line for line in axis.lines if line.get_linestyle() == "None"]
        for lines in ([line for line in axis.lines if line not in points], points):
            looks = {(line.get_color(), line.get_linestyle(), line.get_marker(), line.get_mfc()) for line in lines}
            assert len(looks) == len(lines)
    left_out = len(many["state"]) - len(drawn)
    assert (f"{left_out} more states not drawn" in words_of(figure)) == (left_out > 0)
    (caption,) = [block["caption"] for block in damage_sheet(many) if block["kind"] == "figure"]
    assert ("more states not drawn" in caption) == (left_out > 0)


@pytest.mark.filterwarnings("error::UserWarning")
def test_states_without_a_curve_are_said_to_have_none_over_the_intensities_of_the_motions(folder):
    """One level of which two motions are known: nothing is drawn, and the axis has a range all the same."""
    results = pr.damage(folder / "scan.nc", method="ida").isel(level=[0])
    why = "2 runs are known: a cloud needs 3 at least"
    bare = results.assign(
        probability=np.nan * results["probability"], fault=results["fault"].copy(data=[[why] * 2] * 3)
    )
    figure = damage_figure(bare)
    upper, lower = figure.axes
    assert " ".join(upper.texts[0].get_text().split()) == f"No curve: {why}" and not upper.get_legend().get_texts()
    low, high = (float(results["im"][end]) / 9.80665 for end in (0, -1))  # g
    for axis in (upper, lower):
        left, right = axis.get_xlim()
        assert 0.5 * low < left <= low < high <= right < 2.0 * high
    unknown = bare.assign(runs=0 * bare["runs"])  # of no state is any run known
    assert "No curve" in damage_figure(unknown).axes[0].texts[0].get_text()


def test_a_report_has_a_section_on_the_states(folder):
    """With the numbers of the command; none for a scene without states."""
    results = pr.open_results(folder / "scan.nc")
    blocks = SECTIONS["damage"].write(ReportData(results, assess(results), {}))
    found = pr.damage(results)
    assert [block["kind"] for block in blocks] == ["paragraph", "figure", "table", "table", "list"]
    assert blocks[0]["text"] == f"{found.attrs['finding']}."
    medians = [row[5]["raw"] for row in blocks[2]["rows"]]
    expected = found["median"].values.ravel()
    assert [np.nan if one is None else one for one in medians] == pytest.approx(expected, nan_ok=True)
    bare = results.assign_attrs(scene_resolved=results.attrs["scene_resolved"].partition("[[damage]]")[0])
    assert SECTIONS["damage"].write(ReportData(bare, assess(results), {})) == []
    other = results.assign_attrs(scene_resolved=results.attrs["scene_resolved"].replace("displacement", "ductility"))
    other.attrs["scene_resolved"] = other.attrs["scene_resolved"].replace('0.02 m"', '2"')
    del other.attrs["scene_sha256"]
    (said,) = SECTIONS["damage"].write(ReportData(other, assess(results), {}))
    assert said["text"].startswith("The damage states of the scene have no fragilities: ")


@pytest.fixture(scope="module")
def scan():
    """A dataset as a scan writes it, made and not solved."""
    return made_scan(5, np.linspace(0.0, 0.1, 6), (2e5, np.inf), 2)


def colours(axis) -> dict[str, str]:
    """Colour of each line by its label."""
    return {str(line.get_label()): to_hex(line.get_color()) for line in axis.get_lines()}


def named(found: dict[str, str], start: str) -> set[str]:
    return {colour.upper() for label, colour in found.items() if label.startswith(start)}


def test_no_two_meanings_share_a_colour():
    assert len(set(MEANING.values())) == len(MEANING)
    forces = {colour.upper() for count in range(7) for colour, _ in strength_styles(count)}
    assert not forces & {colour.upper() for colour in MEANING.values()}
    assert contact_styles(1)[0][0] == MEANING["motions"]


def test_lines_of_one_colour_differ_in_their_dashes():
    """Fourteen contact models stand in one figure of `compare`."""
    assert len(set(styles(24))) == 24 and styles(6) == list(STYLES)


def test_what_is_drawn_twice_has_one_colour(scan):
    """The gap, the target, the required gap and code rules, in the figures of assess and separations."""
    assessed = colours(assessment_figure(assess(scan)).axes[0])
    beside = colours(separations_figure(code_table(scan)).axes[0])
    assert named(assessed, "the gap") == {MEANING["gap"]} and named(assessed, "target") == {MEANING["target"]}
    assert named(assessed, "required by") == named(beside, "required by") == {MEANING["required gap"]}
    assert named(beside, "gap needed") == {MEANING["motions"]}
    for name in ("ABS", "SRSS", "CQC"):
        assert named(beside, name) == named(assessed, name) == {MEANING["rule"]}


HAZARD = "pga [g],annual rate [1/year]\n0.05,0.04\n0.2,0.0042\n0.8,0.00012\n"


def test_a_rate_at_one_gap_is_seen_and_the_others_are_said_to_lack(scan, tmp_path):
    """Also where that gap is far wider than the one that is assessed."""
    hazard = tmp_path / "hazard.csv"
    hazard.write_text(HAZARD, encoding="utf-8")
    assessed = assess(scan, gap="20 mm", hazard=hazard)
    (one,) = assessed.interfaces
    known = next(rate for rate in one.rates if rate.what == "contact" and rate.annual > 0.0)
    lacking = tuple(replace(gap, gap=np.nan, fault="scan wider gaps") for gap in one.gaps_for_rates)
    for gap in (0.02, 0.2):
        alone = replace(one, rates=(replace(known, gap=gap),), gaps_for_rates=lacking)
        (axis,) = panel(draw_rates, assessed, alone).axes
        assert "For 20 % in 50 years: scan wider gaps" in " ".join(axis.texts[0].get_text().split())
        line = next(line for line in axis.lines if str(line.get_label()).startswith("contact, under"))
        assert line.get_marker() == "o" and axis.get_xlim()[1] > line.get_xdata()[0] == pytest.approx(1e3 * gap)
        low, high = axis.get_ylim()
        assert low < known.low < known.annual < known.high < high


def test_how_a_clause_is_known_is_shown_by_the_mark_alone():
    assert set(RULE_MARKS) == set(VERIFICATIONS)
    rows = [SeparationRow(known, known, "", None, known, "", "", 0.1, "") for known in VERIFICATIONS]
    (axis,) = panel(draw_rules, [Comparison(row, 0.1, 0.1, 0.9, 1.0, 1.1, 0.0) for row in rows], 24).axes
    marks = [line for line in axis.get_lines() if line.get_marker() in ("o", "s")]
    assert [line.get_fillstyle() for line in marks] == ["full", "full", "left", "none"]
    assert {to_hex(line.get_color()).upper() for line in marks} == {MEANING["rule"]}
