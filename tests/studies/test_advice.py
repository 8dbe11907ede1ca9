"""Advice on a contact: the range of stiffness in closed form, what depends on what, and what does not apply."""

from itertools import pairwise
from math import nan, pi, sqrt
from pathlib import Path

import commands
import numpy as np
import pytest
from figure_words import words_of
from scenes import FRAME, rigid, scene_text, single, storeyed
from scipy.integrate import quad
from sentences import refusal

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.models.contact.laws import LAWS, stiffness_quantity
from pounding_risk.render.sheet import amount
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies import demo
from pounding_risk.studies.advice import (
    DEPENDS,
    FACTORS,
    FORCE,
    LAW,
    MOST_MOTIONS,
    MULTIPLES,
    NOT,
    PROPOSED,
    RESTITUTION,
    SOMEWHAT,
    STIFFNESS,
    Influence,
)
from pounding_risk.studies.advice_stiffness import ABOVE, BELOW, WITHIN, floor_at, ms, stiffness_for
from pounding_risk.units import parse

SHIPPED = Path(pr.__file__).parent / "scene" / "shipped"
TOO_SOFT = ['interface.stiffness="2.75e9 N/m^1.5"']  # too soft for buildings
PAGE = Path(__file__).parents[2] / "docs" / "choosing.md"
HERTZ_DIGITS = 2e-5  # of 3.2181, by which the duration of a Hertz contact is computed
SOFT = scene_text(
    single("office", "500 t", "1.2 s", floor_length="24 m"),
    single("tower", "900 t", "2 s", floor_length="30 m"),
    name="Soft pair",
    gap="40 mm",
    records={"names": ["RSN6-180", "RSN77-164", "RSN753-000", "RSN1690-090", "CCC-HN1", "NAPA-HNE"], "pga": "0.4 g"},
)
WALL = scene_text(
    single("frame", "300 t", "0.6 s"),
    rigid(),
    name="Frame beside a wall",
    law="linear",
    gap="15 mm",
    stiffness="5e8 N/m",
    records={"pga": "0.3 g", "window": ["0 s", "12 s"]},
)


@pytest.fixture(scope="module")
def paper():
    return pr.advise(demo.scene("paper"))


@pytest.fixture(scope="module")
def soft():
    return pr.advise(parse_scene(SOFT))


@pytest.fixture(scope="module")
def row():
    return pr.advise(pr.read_scene(SHIPPED / "row.toml", TOO_SOFT))


@pytest.fixture(scope="module")
def wall():
    return pr.advise(parse_scene(WALL))


def verdicts(advice, factor):
    """The verdict on each output at each place that a factor has."""
    return {(one.output, one.place): one.verdict for one in advice.influences if one.factor == factor}


def words_in(advice):
    """The finding, each proposed line with its reason, each range without a line, and what is left out."""
    ranges = [f"{one.interface}: {one.why}" for one in advice.ranges if not one.line]
    return [advice.finding, *(f"{line.line or '-'}: {line.why}" for line in advice.lines), *ranges, *advice.left_out]


# ------------------------------------------------------------------------------------------------ the range


@pytest.mark.parametrize("duration", [2e-3, 30e-3])
@pytest.mark.parametrize("speed", [0.1, 0.8])
def test_the_stiffness_of_a_duration_makes_an_isolated_contact_last_so_long(duration, speed):
    for unit, law in (("N/m", pr.laws.Linear), ("N/m^1.5", pr.laws.Hertz)):
        stiffness = stiffness_for(duration, unit, 3e4, speed)
        assert pr.impact(law(stiffness), speed, 3e4).duration == pytest.approx(duration, rel=HERTZ_DIGITS)


def test_the_stiffness_of_a_duration_satisfies_the_integral_of_energy():
    """t = 2 ∫ dδ / sqrt(v² − 2 W(δ) / m) up to the deepest point, by quadrature in δ = δ_max (1 − x²)."""
    mass, speed, duration = 8e4, 0.4, 0.012
    for unit, power in (("N/m", 1.0), ("N/m^1.5", 1.5)):
        stiffness = stiffness_for(duration, unit, mass, speed)
        deepest = ((power + 1.0) * mass * speed**2 / (2.0 * stiffness)) ** (1.0 / (power + 1.0))

        def rate(x, deepest=deepest, power=power):
            return 2.0 * x / sqrt(1.0 - (1.0 - x * x) ** (power + 1.0)) * deepest / speed if x else 0.0

        assert 2.0 * quad(rate, 0.0, 1.0, limit=200)[0] == pytest.approx(duration, rel=1e-4)


@pytest.mark.parametrize("e", [0.5, 0.65, 0.8])
def test_dissipation_changes_the_duration_by_an_eighth_at_most(e):
    """As the page says."""
    names = ("jankowski", "hertz_damp", "hertz_damp_exact", "kelvin_voigt", "modified_kelvin_voigt", "bilinear")
    for name in names:
        law = LAWS[name]
        stiffness = stiffness_for(0.02, stiffness_quantity(law).unit, 3e4, 0.3)
        assert pr.impact(law(stiffness), 0.3, 3e4, restitution=e).duration == pytest.approx(0.02, rel=0.13), name


def test_equal_floors_collide_for_pi_passages_of_a_wave_under_their_axial_stiffness():
    """k = m (c / L)² / 2 and a reduced mass of m / 2 give t = π L / c, whatever the mass."""
    floors = {"floor_length": "18 m"}
    scene = parse_scene(scene_text(single("A", "300 t", "1 s", **floors), single("B", "300 t", "1.3 s", **floors)))
    (one,) = pr.advise(scene, gap="1 m").ranges
    assert one.rules[0].duration == pytest.approx(pi * 18.0 / 3500.0, rel=1e-12)
    assert one.shortest == pytest.approx(18.0 / 3500.0, rel=1e-12)
    assert one.longest == pytest.approx(0.1, rel=1e-12) and one.mass == pytest.approx(150e3, rel=1e-12)


def test_a_column_strikes_with_the_mass_of_the_floors_that_hold_it():
    """1 / (B M⁻¹ Bᵀ), B the interpolation between the floors below and above."""
    scene = parse_scene(scene_text(storeyed("A", ["200 t", "120 t", "90 t"], "9e7 N/m"), rigid()))
    building = scene.buildings[0]
    for floor, weights in ((1.0, [1, 0, 0]), (2.4, [0, 0.6, 0.4]), (0.3, [0.3, 0, 0])):
        matrix = np.array([weights])
        inverse = (matrix @ np.diag(1.0 / np.array(building.masses)) @ matrix.T).item()
        assert floor_at(building, floor, 20.0).mass == pytest.approx(1.0 / inverse, rel=1e-12)


@pytest.mark.complete
def test_published_values_are_converted_from_kip_and_inch(soft):
    published = {rule.name: (rule.published, rule.unit) for rule in soft.ranges[0].rules}
    assert published["50 000 kip/in, floors of buildings"][0] == pytest.approx(8.756e9, rel=1e-3)
    assert published["25 000 kip/in^1.5"][0] == pytest.approx(2.747e10, rel=1e-3)
    office = 500e3 * (2.0 * pi / 1.2) ** 2
    tower = 900e3 * (2.0 * pi / 2.0) ** 2
    assert published["20 × the stiffer building's"][0] == pytest.approx(20.0 * max(office, tower), rel=1e-12)


@pytest.mark.parametrize("advice", ["paper", "soft", "row", "wall"])
def test_the_line_gives_a_contact_within_both_limits(advice, request):
    """By the isolated impact of the undamped law."""
    proposed = [one for one in request.getfixturevalue(advice).ranges if not one.is_column]
    assert proposed and not any(one.is_empty for one in proposed)
    for one in proposed:
        law = pr.laws.Linear if one.unit == "N/m" else pr.laws.Hertz
        value = parse(one.line.split('"')[1], stiffness_quantity(law))
        lasts = pr.impact(law(value), one.speed, one.mass).duration
        assert one.shortest <= lasts * (1.0 + HERTZ_DIGITS) and lasts <= one.longest * (1.0 + HERTZ_DIGITS)
        for edge, limit in ((one.low, one.longest), (one.high, one.shortest)):
            assert pr.impact(law(edge), one.speed, one.mass).duration == pytest.approx(limit, rel=HERTZ_DIGITS)


@pytest.mark.parametrize("name", ["row", "compare"])
@pytest.mark.complete
def test_a_scene_with_the_lines_is_told_to_keep_them(name):
    """The lines are values of a scene file, and advice on the new scene agrees with the first."""
    first = pr.advise(pr.read_scene(SHIPPED / f"{name}.toml", TOO_SOFT))
    assert {one.verdict for one in first.ranges} == {BELOW}
    tables = pr.read_scene(SHIPPED / f"{name}.toml").resolved()
    for table, one in zip(tables["interface"], first.ranges, strict=True):
        assert (one.line == "") == one.is_column
        if one.line:
            table["stiffness"] = one.line.partition('"')[2].rstrip('"')
    second = pr.advise(pr.Scene(tables["building"], tables["interface"], tables["records"], folder=SHIPPED))
    for one in second.ranges:
        if one.is_column:
            continue
        assert one.verdict == WITHIN and one.why.startswith("Keep it")
        assert one.line == 'stiffness = "{text}"'.format(**amount(one.own, one.unit))


def test_a_range_without_any_stiffness_is_told_with_its_limits_and_the_repair(says):
    hut = {"floor_length": "60 m"}
    scene = scene_text(single("A", "90 t", "0.05 s", **hut), single("B", "80 t", "0.06 s", **hut))
    advice = pr.advise(parse_scene(scene), gap="0 mm")
    (one,) = advice.ranges
    assert one.is_empty and one.recommended is None and one.line == "" and one.verdict == ""
    says(one.why)
    assert "nothing (A | B)" in repr(advice)


def test_a_stiffness_beyond_the_range_is_too_stiff():
    advice = pr.advise(parse_scene(SOFT).replace('interface.stiffness="1e14 N/m^1.5"'), gap="1 m")
    assert advice.ranges[0].verdict == ABOVE and advice.ranges[0].why.startswith("Too stiff: with the scene's 1e11 kN")


# ------------------------------------------------------------------------------------------------ the influences


def test_changes_are_those_of_single_runs(wall):
    """One record: the median is that run's own change, as `simulate` gives it."""
    scene = parse_scene(WALL)
    runs = [pr.simulate(scene.replace(f'interface.stiffness="{5e8 * multiple!r} N/m"')) for multiple in MULTIPLES]
    for output, place in (("peak_contact_force", "frame | wall"), ("peak_displacement", "frame")):
        values = [float(run[output].values.ravel()[0]) for run in runs]
        found = wall.influence(STIFFNESS, output, place)
        assert found.medians == pytest.approx([value / values[2] - 1.0 for value in values], abs=1e-9)
        assert wall.now[output, place] == pytest.approx(values[2], rel=1e-12)


def test_what_the_proposed_stiffness_changes_is_told(wall, soft):
    """As `simulate` gives it; nothing is told where the scene's own is kept."""
    proposed = wall.lines[0].line.partition('"')[2].rstrip('"')
    before, after = (
        pr.simulate(parse_scene(WALL).replace(f'interface.stiffness="{value}"'))["peak_contact_force"].item()
        for value in ("5e8 N/m", proposed)
    )
    found = wall.influence(PROPOSED, "peak_contact_force", "frame | wall")
    assert found.medians == pytest.approx((after / before - 1.0,), rel=1e-9)
    change = f"{100.0 * (after / before - 1.0):+.0f} % (frame | wall)"
    told = f"The proposed stiffness changes peak contact force by {change}"
    assert wall.lines[1].line == "" and wall.lines[1].why.startswith(told)
    assert PROPOSED not in {one.factor for one in soft.influences}


def test_medians_of_a_row_are_those_of_its_scan(row):
    """Each interface keeps its own gap, and a building counts where it is touched on either side."""
    dataset = pr.scan(pr.read_scene(SHIPPED / "row.toml", TOO_SOFT), check_fraction=0.0)
    assert row.touched == row.cases == dataset["status"].size and row.gap == "30 mm, 20 mm"
    for (output, place), value in row.now.items():
        of = dataset[output].sel(interface=place) if "|" in place else dataset[output].sel(building=place)
        assert value == pytest.approx(float(of.median()), rel=1e-12), (output, place)


@pytest.mark.parametrize(
    ("change", "verdict"), [(0.0, NOT), (0.049, NOT), (-0.05, SOMEWHAT), (0.25, SOMEWHAT), (-0.26, DEPENDS), (nan, "")]
)
def test_words_follow_the_stated_limits(change, verdict):
    """A value that does not count has no say."""
    one = Influence(STIFFNESS, "impulse", "A | B", ("× 0.01", "× 0.1"), (5.0, change), 0.1, (False, True))
    assert one.verdict == verdict


def test_the_pair_of_the_paper_is_decided_by_its_yield_force(paper, says):
    """Its contact yields: the peak force is F_E, whatever the stiffness."""
    force = ("peak_contact_force", "frame | masonry")
    assert paper.now[force] == pytest.approx(450e3, rel=1e-6)
    assert verdicts(paper, STIFFNESS)[force] == verdicts(paper, RESTITUTION)[force] == NOT
    assert verdicts(paper, FORCE)[force] == DEPENDS
    halved, doubled, none = paper.influence(FORCE, *force).medians
    assert (halved, doubled) == pytest.approx((-0.5, 1.0), abs=1e-6) and none > doubled
    assert verdicts(paper, LAW)["peak_displacement", "frame"] == NOT
    (one,) = paper.ranges
    assert one.wall == "masonry" and one.mass == pytest.approx(44.36e3) and one.longest == pytest.approx(0.0208)
    says(words_in(paper))
    # An elastic touch would press with β^0.4 (1.25 m v²)^0.6, five times F_E: the plateau is long.
    (longer,) = [words for words in paper.left_out if "yielding makes the contact" in words]
    assert float(longer.split()[-2]) > 2.0 * 1e3 * one.duration


def test_a_soft_pair_may_keep_its_stiffness_and_its_displacements_do_not_depend_on_it(soft, says):
    """Forces grow as those of an isolated Hertz contact, with β to the power 0.4; no floor's length is assumed."""
    stiffness = verdicts(soft, STIFFNESS)
    assert stiffness["peak_displacement", "office"] == stiffness["peak_displacement", "tower"] == NOT
    assert stiffness["peak_contact_force", "office | tower"] == DEPENDS
    assert stiffness["peak_floor_acceleration", "office"] == DEPENDS
    tenfold = soft.influence(STIFFNESS, "peak_contact_force", "office | tower").medians[3]
    assert 1.0 + tenfold == pytest.approx(10.0**0.4, rel=0.1)
    assert set(verdicts(soft, LAW).values()) == {NOT} and len(soft.motions) == MOST_MOTIONS
    says(words_in(soft))


def test_a_row_is_told_the_stiffness_of_each_interface(row, says):
    """Floors strike columns only: nothing is proposed that a later line takes back, and the scene's is kept."""
    column, floors = row.ranges
    assert (column.interface, floors.interface) == ("offices | flats", "flats | shop")
    assert column.is_column and not floors.is_column
    assert floors.mass == pytest.approx(1.0 / (1.0 / 180e3 + 1.0 / 150e3), rel=1e-12)
    assert column.line == "" and column.recommended == column.own
    assert verdicts(row, STIFFNESS)["peak_storey_shear", "offices"] == NOT
    assert ("peak_storey_shear", "shop") not in row.now  # of a single mass it is its displacement
    assert FORCE not in {one.factor for one in row.influences}
    says(words_in(row))  # of floor_length, which is read here and by no run of jankowski, not that it has no effect


def test_the_largest_change_of_a_single_case_is_told_where_it_stands_out():
    one = Influence(LAW, "impact_count", "A | B", ("hertz",), (0.02,), 0.8, (True,))
    assert one.words == "does not depend, 0 to +2 %, one case by 80 %"


# ------------------------------------------------------------------------------------------------ what does not apply


def test_without_contact_nothing_depends_on_it(tmp_path):
    """The largest closing that is told is that of the motion without contact."""
    advice = pr.advise(parse_scene(SOFT), gap="1 m")
    assert advice.touched == 0 and advice.influences == () and advice.now == {}
    assert advice.finding.startswith("No contact at a gap of 1 m in any of 4 cases")
    closing = pr.scan(parse_scene(SOFT), check_fraction=0.0)["peak_closing_free"]
    largest = 1e3 * float(closing.sel(record=list(advice.motions)).max())
    assert f"the largest closing is {largest:.0f} mm" in advice.finding
    assert advice.ranges[0].speed == 0.5 and any("0.5 m/s is assumed" in words for words in advice.left_out)
    assert "No contact at a gap of 1 m" in words_of(figures.advice_figure(advice))


def test_a_rigid_wall_and_a_law_without_damping(wall, says):
    """The wall takes no part; a law that takes no restitution has none to choose."""
    (one,) = wall.ranges
    assert one.mass == pytest.approx(300e3) and one.longest == pytest.approx(0.06) and one.wall == ""
    assert {one.factor for one in wall.influences} == {STIFFNESS, PROPOSED}
    assert {place for _, place in wall.now} == {"frame", "frame | wall"}
    says(words_in(wall))


@pytest.mark.parametrize("law", ["stereomechanical", "merged"])
def test_an_instant_impact_has_no_stiffness(law, says):
    scene = scene_text(law=law, stiffness=None, restitution=0.65 if law == "stereomechanical" else None, gap="5 mm")
    advice = pr.advise(parse_scene(scene))
    assert advice.touched and advice.ranges == ()
    assert {one.factor for one in advice.influences} == ({RESTITUTION} if law == "stereomechanical" else set())
    says(words_in(advice))
    figures.advice_figure(advice)


def test_colliding_floors_have_nothing_to_choose(says):
    floors = {"floor_length": "20 m"}
    pair = (single("A", "100 t", "0.5 s", **floors), single("B", "150 t", "0.3 s", **floors))
    scene = scene_text(*pair, law="distributed_mass", stiffness=None, restitution=None, gap="3 mm")
    advice = pr.advise(parse_scene(scene))
    assert advice.touched and advice.influences == () and advice.ranges == ()
    says(words_in(advice))


def test_interfaces_of_their_own_get_no_common_line(says):
    """Each its own law, in its own unit."""
    masses = [single(name, "100 t", f"{period} s") for name, period in (("a", 0.5), ("b", 0.3), ("c", 0.8))]
    own = [
        {"gap": "5 mm", "contact_model": "kelvin_voigt", "stiffness": "5e8 N/m", "restitution": 0.6},
        {"gap": "8 mm", "contact_model": "jankowski", "stiffness": "2e9 N/m^1.5", "restitution": 0.5},
    ]
    advice = pr.advise(parse_scene(scene_text(*masses, interfaces=own, records={"window": ["0 s", "5 s"]})))
    assert [one.unit for one in advice.ranges] == ["N/m", "N/m^1.5"]
    says(words_in(advice))


def test_progress_counts_every_scan_and_ends_with_all():
    """The base, four multiples, three restitutions, three yield forces and the laws; nothing else is proposed."""
    reported = []
    pr.advise(demo.scene("paper"), progress=lambda done, total: reported.append((done, total)))
    assert reported == [(done, 12) for done in range(1, 13)]


@pytest.mark.complete
def test_a_contact_that_does_not_yield_is_tried_with_shares_of_its_force():
    scene = parse_scene(scene_text(FRAME, rigid(), law="viscous_elastoplastic", gap="2 mm", yield_force="inf"))
    advice = pr.advise(scene)
    one = advice.influence(FORCE, "peak_contact_force", "frame | wall")
    assert one.tried == ("0.5 of the peak", "0.25 of the peak")
    assert one.medians == pytest.approx((-0.5, -0.75), abs=1e-6)
    assert next(line.line for line in advice.lines if "yield_force" in line.line) == 'yield_force = "inf"'


def test_a_gap_of_another_kind_is_refused(says):
    options = ({"gap": "3 t"}, {"gap": -1.0}, {"floor_length": 0.0})
    says([refusal(pr.advise, demo.scene("paper"), **one) for one in options])


# ------------------------------------------------------------------------------------------------ what is shown


def test_the_figure_is_titled_with_the_finding_and_shades_the_range(soft):
    figure = figures.advice_figure(soft)
    headline = words_of(figure).partition("\n")[0]
    assert headline.startswith(soft.finding.partition(";")[0])
    (axis,) = figure.axes
    (band,) = axis.patches
    (one,) = soft.ranges
    assert axis.get_xlabel() == "contact stiffness [kN/m$^{1.5}$]"
    ends = 1e3 * band.get_x(), 1e3 * (band.get_x() + band.get_width())
    assert ends == pytest.approx((one.low, one.high))
    curves = {line.get_label(): line for line in axis.lines if not line.get_label().startswith("_")}
    force = soft.influence(STIFFNESS, "peak_contact_force", "office | tower")
    assert curves["peak contact force"].get_ydata() == pytest.approx(1.0 + np.array(force.medians))
    assert curves["peak contact force"].get_xdata() == pytest.approx(2.75e6 * np.array(MULTIPLES))
    looks = {(line.get_color(), line.get_linestyle(), line.get_marker()) for line in curves.values()}
    assert len(looks) == len({marker for *_, marker in looks}) == len(curves) == 5
    boxes = sorted((label.get_window_extent() for label in axis.texts), key=lambda box: box.y0)
    assert len(boxes) > 1 and all(one.y1 <= other.y0 + 1.0 for one, other in pairwise(boxes))  # a pixel of rounding


def test_advice_is_short_at_a_prompt(soft):
    assert repr(soft).splitlines()[0] == "<Advice>" and len(repr(soft).splitlines()) == 7
    assert repr(soft.influences[0]).startswith("<Influence>")


@pytest.mark.complete
def test_the_command_prints_the_lines_and_the_page_shows_what_it_prints(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    result = commands.done("advise", SHIPPED / "paper.toml", "--figure", "advice.png")
    assert Path("advice.png").stat().st_size > 10_000
    printed = result.stdout.splitlines()
    block = PAGE.read_text("utf-8").partition("```text\n")[2].partition("```")[0].splitlines()
    assert len(block) > 5
    places = [printed.index(line) for line in block]
    assert places == sorted(places)
    heads = next(line for line in printed if line.startswith("output"))
    assert [factor in heads for factor in FACTORS] == [True] * 4


def test_the_rules_of_the_page_are_those_that_are_printed(soft):
    """Every source of a rule, and each published number, stands on the page."""
    page = PAGE.read_text("utf-8")
    for rule in soft.ranges[0].rules:
        assert rule.source.split(" (")[0].split(",")[0] in page, rule.name
        assert rule.known in page
    for value in ("8.76e9", "9.35e7", "2.75e9", "2.00e9", "2.75e10"):
        assert value in page
        assert any(rule.published == pytest.approx(float(value), rel=2e-3) for rule in soft.ranges[0].rules)


def test_columns_that_are_struck_decide_where_the_floors_that_meet_are_never_struck():
    """Floors 3.2 m and 3 m up meet floor to floor, but only those higher up touch, which strike columns."""
    buildings = storeyed("a", "200 t", "40 MN/m", "3.2 m", storeys=3), storeyed("b", "200 t", "400 MN/m", storeys=3)
    weak = {"column_yield_force": "500 kN", "gap": "80 mm", "stiffness": "2e11 N/m^1.5"}
    scene = parse_scene(scene_text(*buildings, records={"pga": "0.4 g"}, law="viscous_elastoplastic", **weak))
    run = pr.scan(scene, check_fraction=0.0)
    is_floor = run["contact_point_kind"].values == "floor"
    struck = run["contact_point_impact_count"].values.reshape(-1, is_floor.size).any(axis=0)
    assert is_floor.any() and not struck[is_floor].any() and struck[~is_floor].any()
    found = pr.advise(scene)
    (one,) = found.ranges
    assert one.is_column and one.line == "" and "floors strike columns only" in one.why
    lines = [line.line for line in found.lines]
    assert 'column_yield_force = "500 kN"' in lines and not any(line.startswith("yield_force") for line in lines)


def test_a_duration_of_a_second_has_no_exponent():
    assert [ms(seconds) for seconds in (0.0173, 1.044, 12.0)] == ["17.3 ms", "1040 ms", "12000 ms"]
