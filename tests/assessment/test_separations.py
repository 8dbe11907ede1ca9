"""Combinations against Lyapunov's equation and simulated noise, rules against hand sums, and rules beside motions."""

import json
import re
from functools import partial
from itertools import pairwise

import commands
import numpy as np
import pytest
import xarray as xr
from figure_words import words_of
from hypothesis import given
from hypothesis import strategies as st
from scenes import BOTH, rigid, scene_text, single, storeyed
from scipy.linalg import solve_continuous_lyapunov
from scipy.signal import cont2discrete, lfilter
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.separations.rules import COMBINATIONS, ONE_GROUND, RULES, VERIFICATIONS, Case, Site
from pounding_risk.assessment.separations.table import code_table, separations
from pounding_risk.errors import PoundingError
from pounding_risk.figures.separations import separations_figure
from pounding_risk.figures.style import MEANING
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.intensity import response_spectra
from pounding_risk.motions.read import read_motion
from pounding_risk.questions.separations import _footnotes as footnotes
from pounding_risk.questions.separations import _own_note as own_note
from pounding_risk.questions.separations import separations as beside_motions
from pounding_risk.results.labels import place_coordinates
from pounding_risk.statistics.separations import abs_sum, cqc, srss, white_noise_correlation

PERIODS = st.floats(0.05, 5.0)
DAMPINGS = st.floats(0.005, 0.5)
LENGTHS = st.floats(0.0, 2.0)
BUILDINGS = ("frame", "masonry")


def covariance(periods: tuple[float, float], dampings: tuple[float, float]) -> np.ndarray:
    """Of the displacements of two oscillators under white noise of unit intensity, by A P + P Aᵀ + b bᵀ = 0."""
    system = np.zeros((4, 4))
    for place, (period, damping) in enumerate(zip(periods, dampings, strict=True)):
        omega = 2.0 * np.pi / period
        system[2 * place : 2 * place + 2, 2 * place : 2 * place + 2] = [[0.0, 1.0], [-(omega**2), -2 * damping * omega]]
    noise = np.outer([0.0, -1.0, 0.0, -1.0], [0.0, -1.0, 0.0, -1.0])
    return solve_continuous_lyapunov(system, -noise)[::2, ::2]


@given(st.tuples(PERIODS, PERIODS), st.tuples(DAMPINGS, DAMPINGS))
def test_the_correlation_is_that_of_lyapunovs_equation(periods, dampings):
    """In units of the left building's period; what is left is the solver's rounding."""
    found = covariance((1.0, periods[1] / periods[0]), dampings)
    expected = found[0, 1] / np.sqrt(found[0, 0] * found[1, 1])
    assert white_noise_correlation(periods, dampings) == pytest.approx(expected, abs=1e-10)


def test_the_correlation_of_simulated_noise():
    """Unequal damping, where exchanging the two in the formula gives 0.154 for 0.178.

    Noise held over steps of a fiftieth of the shorter period filters by 0.1 %. The error allowed is four of the
    estimate's own, from 60 stretches that are longer than any memory of either oscillator.
    """
    periods, dampings, step = (1.0, 0.8), (0.02, 0.10), 0.016
    noise = np.random.default_rng(20261121).normal(size=(60, 60_000)) / np.sqrt(step)
    moved = []
    for period, damping in zip(periods, dampings, strict=True):
        omega = 2.0 * np.pi / period
        above, below, _ = cont2discrete(([-1.0], [1.0, 2.0 * damping * omega, omega**2]), step)
        moved.append(lfilter(above.ravel(), below, noise, axis=1)[:, 5000:])  # past the start from rest
    variances = [np.mean(each**2) for each in moved]
    products = np.mean(moved[0] * moved[1], axis=1) / np.sqrt(variances[0] * variances[1])
    error = products.std(ddof=1) / np.sqrt(products.size)
    assert error < 0.005, "too short to tell the formula from the one with the two exchanged"
    assert white_noise_correlation(periods, dampings) == pytest.approx(products.mean(), abs=4.0 * error)

    parting = np.mean((moved[0] - moved[1]) ** 2, axis=1)
    error = parting.std(ddof=1) / np.sqrt(parting.size)
    exact = covariance(periods, dampings)
    deviations = (np.sqrt(exact[0, 0]), np.sqrt(exact[1, 1]))
    assert error < 0.02 * parting.mean()
    assert cqc(deviations, periods, dampings) ** 2 == pytest.approx(parting.mean(), abs=4.0 * error)


@given(st.tuples(LENGTHS, LENGTHS), st.tuples(PERIODS, PERIODS), st.tuples(DAMPINGS, DAMPINGS))
def test_sum_is_never_below_srss_nor_srss_below_cqc(moved, periods, dampings):
    """And CQC is never below the difference; the slack is rounding."""
    steps = [abs_sum(*moved), srss(*moved), cqc(moved, periods, dampings), abs(moved[0] - moved[1])]
    assert all(above >= below - 1e-12 for above, below in pairwise(steps))
    # Left and right are names.
    assert cqc(moved[::-1], periods[::-1], dampings[::-1]) == pytest.approx(steps[2], rel=1e-9, abs=1e-12)


def test_limits_of_the_correlation():
    assert white_noise_correlation((0.7, 0.7), (0.05, 0.05)) == 1.0
    assert cqc((0.03, 0.04), (0.7, 0.7), (0.05, 0.05)) == pytest.approx(0.01, rel=1e-12)  # they move together
    # Of one period, ρ = 2 √(ζA ζB) / (ζA + ζB).
    assert white_noise_correlation((0.7, 0.7), (0.02, 0.08)) == pytest.approx(2.0 * 0.04 / 0.1, rel=1e-12)
    assert white_noise_correlation((1.0, 1000.0), (0.05, 0.05)) < 1e-5
    assert cqc((0.03, 0.04), (1.0, 1000.0), (0.05, 0.05)) == pytest.approx(0.05, rel=1e-5)
    assert white_noise_correlation((1.0, 1.0), (0.0, 0.0)) == 1.0
    assert white_noise_correlation((1.0, 1.1), (0.0, 0.0)) == white_noise_correlation((1.0, 1.1), (0.0, 0.1)) == 0.0


def test_a_rigid_building_needs_no_period():
    assert cqc((0.03, 0.0), (0.5, np.nan), (0.05, np.nan)) == 0.03
    both = cqc((np.array([0.03, 0.0]), np.array([0.0, 0.02])), (0.5, 0.4), (0.05, 0.05))
    assert both.tolist() == [0.03, 0.02]


def test_what_is_out_of_range_is_refused(says):
    calls = [
        lambda: abs_sum(-0.01, 0.02),
        lambda: srss(np.nan, 0.02),
        lambda: cqc((0.01, 0.02), (np.nan, 1.0), (0.05, 0.05)),
        lambda: white_noise_correlation((1.0, 0.0), (0.05, 0.05)),
        lambda: white_noise_correlation((1.0, 2.0), (0.05, 5.0)),
        lambda: asked(Site(heights=(12.0, -1.0))),
        lambda: asked(Site(factors=(0.0, 1.0))),
        lambda: asked(Site(ground=0.0)),
        lambda: asked(Site(zone="IV")),
        lambda: asked(Site(intensity=5)),
        lambda: separations(BUILDINGS, (0.01, np.inf), (1, 1), (0, 0)),
        lambda: separations(("one",), (0.01, 0.1), (1, 1), (0, 0)),
    ]
    says([refusal(call) for call in calls])


def asked(site: Site) -> dict[str, float | None]:
    """What every rule asks for [mm] of two buildings of 0.9 and 1 s, 5 % damping, that move 30 and 40 mm."""
    rows = separations(BUILDINGS, (0.03, 0.04), (0.9, 1.0), (0.05, 0.05), site)
    return {row.rule: None if row.separation is None else pytest.approx(1e3 * row.separation) for row in rows}


def test_rules_give_what_their_clauses_say():
    """By hand, 30 and 40 mm; where a height counts, 12 m beside 20 m."""
    found = asked(Site(heights=(12.0, 20.0), zone="II", intensity=8, ground=0.25 * 9.80665))
    assert found == {
        "abs": 70.0,
        "srss": 50.0,
        "cqc": np.sqrt(2500.0 - 2.0 * 0.4730276832 * 1200.0),
        "asce7": 50.0,
        "asce7_boundary": 70.0,
        "ubc97": 35.0,
        "ubc97_boundary": 49.0,
        "eurocode8": 50.0,
        "eurocode8_boundary": 70.0,
        "nbcc": 50.0,
        "mexico": (30.0 + 36.0) + (40.0 + 36.0),
        "mexico_simplified": 2.0 * 108.0,
        "china": 100.0,
        "is1893_2002": 70.0,
        "is1893_2016": 70.0,
        "peru": 72.0,
        "iran": 120.0,
        "turkey": 50.0,  # 30 + 2 · 10 mm of height, above half of 50
        "italy": 70.0,
        "asce41": 50.0,
        "asce7_2016": 50.0,
        "asce7_2016_boundary": 70.0,
        "asce7_2022": 50.0,
        "asce7_2022_boundary": 70.0,
        "italy_2018": 70.0,
        "nzs1170": 70.0,
        "taiwan": 0.6 * 70.0,
    }


@pytest.mark.parametrize(
    ("rule", "site", "expected"),
    [
        ("eurocode8", {"aligned": True}, 35.0),
        ("eurocode8_boundary", {"aligned": True}, 49.0),
        ("is1893_2002", {"aligned": True}, 35.0 + 25.0),
        ("asce7", {"factors": (0.8, 0.8)}, 40.0),
        ("mexico", {"heights": (12.0, 20.0), "zone": "I"}, 50.0 + 52.0),  # 30 + 12 is below 50
        ("mexico", {"heights": (12.0, 20.0), "zone": "II", "aligned": True, "alike": True}, 71.0),
        ("mexico", {"heights": (12.0, 20.0), "zone": "II", "alike": True}, 142.0),  # alike, but floors are not level
        ("mexico_simplified", {"heights": (3.0, 20.0), "zone": "III"}, 100.0),  # 36 mm is below 50
        ("china", {"heights": (24.0, 30.0), "intensity": 8}, 160.0),
        ("china", {"heights": (30.0, 24.0), "intensity": 9}, 190.0),
        ("china", {"heights": (24.0, 30.0), "intensity": 9, "structure": "frame and walls"}, 133.0),
        ("china", {"heights": (24.0, 30.0), "intensity": 8, "structure": "walls"}, 100.0),  # 80 is below 100
        ("peru", {"heights": (3.0, 4.0)}, 2.0 / 3.0 * 70.0),
        ("peru", {"heights": (3.0, 4.0), "factors": (0.1, 0.1)}, 30.0),
        ("asce41", {"heights": (1.0, 9.0)}, 40.0),
        ("turkey", {"heights": (3.0, 9.0), "factors": (2.0, 2.0)}, 50.0),
        ("turkey", {"heights": (3.0, 9.0), "factors": (2.0, 2.0), "aligned": True}, 30.0),  # 25 is below 30
        ("italy", {"heights": (12.0, 9.0), "ground": 9.80665}, 180.0),  # 1 g: twice 1 %
        ("italy_2018", {"heights": (12.0, 9.0), "ground": 9.80665}, 90.0),  # 1 g: the factor stays at 1
        ("italy_2018", {"heights": (30.0, 20.0), "ground": 0.4 * 9.80665}, 160.0),  # 200 mm · 0.8
    ],
)
def test_what_a_site_changes(rule, site, expected):
    assert asked(Site(**site))[rule] == expected


KNOWN = Site(heights=(24.0, 30.0), zone="II", intensity=8, aligned=True, alike=True, ground=2.0)
OTHERWISE = Site((12.0, 15.5), (0.5, 0.6), False, False, "III", 9, "frame and walls", 4.0)


@pytest.mark.parametrize("rule", RULES.values(), ids=RULES)
def test_each_rule_looks_at_what_it_declares(rule):
    """What it says it needs or assumes changes its number, and nothing else does."""
    declared = {*rule.needs, *rule.assumes}
    if "alike" in declared:
        declared.add("aligned")  # alike includes it

    def of(site: Site) -> float:
        # Small heights matter to a cap of 4 %, so that displacements are large as well as small.
        return sum(float(rule.function(Case((d, 1.3 * d), (0.9, 1.0), (0.05, 0.05), site))) for d in (0.03, 0.9))

    changes = {key for key, value in OTHERWISE._asdict().items() if of(KNOWN._replace(**{key: value})) != of(KNOWN)}
    assert changes == declared


def test_each_rule_has_its_clause_and_says_how_its_text_is_known():
    assert list(RULES)[:3] == list(COMBINATIONS)
    for rule in RULES.values():
        assert rule.title and rule.clause and rule.formula
        assert rule.verification in VERIFICATIONS
        assert (rule.source == "") is (rule.verification == "from memory")
        assert (rule.verification == "derived") is (rule.name in COMBINATIONS)
        assert rule.year is None or str(rule.year)[2:] in rule.clause or rule.name in ("peru", "iran")


def test_only_a_clause_that_was_read_itself_counts_as_read():
    """Engineers' letters, examination answers, forums and a code that takes the clause over are quotations."""
    known = {rule.name: rule.verification for rule in RULES.values()}
    assert {name for name, text in known.items() if text == "clause read"} == {"asce7", "mexico", "mexico_simplified"}
    quoted = {"asce7_boundary", "ubc97", "ubc97_boundary", "nbcc", "china", "turkey", "italy", "asce7_2016_boundary"}
    assert {name for name, text in known.items() if text == "quoted"} == quoted


def test_an_edition_that_is_superseded_names_what_supersedes_it():
    """Two editions of one code stand in the list: the older names the newer."""
    assert RULES["is1893_2002"].superseded in RULES["is1893_2016"].clause
    assert {RULES[name].superseded for name in ("asce7", "asce7_boundary")} == {"ASCE/SEI 7-16 and 7-22"}
    assert RULES["asce7_2016"].superseded in RULES["asce7_2022"].clause and not RULES["asce7_2022"].superseded
    assert RULES["italy"].superseded in RULES["italy_2018"].clause
    for rule in RULES.values():
        later = [int(year) for year in re.findall(r"\b20\d\d\b", rule.superseded)]
        assert all(year > (rule.year or 0) for year in later)
        assert rule.verification != "derived" or not rule.superseded
    row = separations(BUILDINGS, (0.03, 0.04), (0.9, 1.0), (0.05, 0.05))[3]
    assert (row.rule, row.superseded) == ("asce7", "ASCE/SEI 7-16 and 7-22")
    assert "superseded by ASCE/SEI 7-16 and 7-22" in row.note


def test_level_factor_and_what_is_in_force_stand_with_each_rule():
    for rule in RULES.values():
        assert bool(rule.level) is (rule.name not in COMBINATIONS)
        assert bool(rule.factor) is (rule.level != "" and "factors" in rule.assumes)
    assert "2/3 of MCE_R" in RULES["asce7_2016"].level and "ultimate limit state" in RULES["nzs1170"].level
    assert RULES["italy_2018"].level.startswith("SLV") and "475 years" in RULES["taiwan"].level
    assert "IS 1893 (Part 1):2025 was withdrawn on 3 March 2026" in RULES["is1893_2016"].in_force
    assert "as reported" in RULES["is1893_2016"].in_force
    assert "until it is withdrawn on 30 March 2028" in RULES["eurocode8"].in_force


GIVEN = ("--displacement", "left=45mm", "--displacement", "right=30mm")
BOTH_PERIODS = ("--period", "left=0.4s", "--period", "right=700 ms")


@pytest.mark.parametrize(
    ("factors", "expected"),
    [
        # By hand from the formulas: SRSS of 135 and 90 mm is 45 √13, their sum 225 mm.
        (("3",), dict.fromkeys(("eurocode8", "asce7"), 45.0 * np.sqrt(13.0))),
        (("3",), dict.fromkeys(("asce7_2022_boundary", "nzs1170", "is1893_2016"), 225.0)),
        (("3",), {"ubc97": 0.7 * 45.0 * np.sqrt(13.0), "taiwan": 135.0}),
        (("left=4", "right=2"), {"nzs1170": 240.0, "eurocode8": 60.0 * np.sqrt(10.0)}),  # 180 and 60 mm
        ((), {"abs": 75.0, "asce7": 15.0 * np.sqrt(13.0)}),
    ],
)
def test_given_design_displacements_need_no_dataset(factors, expected):
    words = [word for text in factors for word in ("--behaviour-factor", text)]
    answer = run(*GIVEN, *words)
    cells = {line.split()[0]: re.split(r" {2,}", line) for line in answer.output.split("\n\n")[1].splitlines()}
    for rule, separation in expected.items():
        assert cells[rule][1] == f"{separation:.4g}"
        assert cells[rule][2] == (RULES[rule].factor or "–") and RULES[rule].clause in cells[rule]
    assert cells["cqc"][1] == "–" and "needs periods and dampings" in cells["cqc"][-1]
    assert cells["italy_2018"][1] == "–" and cells["italy_2018"][-1].startswith("needs heights and ground")
    taken = "No --behaviour-factor is given: they are taken to be the design displacements of every rule."
    assert (taken in answer.output) is (not factors)
    assert "linear model" not in answer.output
    later = "a later edition is published; which one is in force is decided by the authority of the site"
    assert later in answer.output


@pytest.mark.parametrize(
    ("words", "dampings", "taken"),
    [
        ((), (0.05, 0.05), True),
        (("--damping", "2 %"), (0.02, 0.02), False),
        (("--damping", "left=0.02", "--damping", "right=0.1"), (0.02, 0.1), False),
    ],
)
def test_given_periods_give_the_double_difference(words, dampings, taken, tmp_path):
    """From the stationary covariance of Lyapunov's equation, to rounding of its solution."""
    told = run(*GIVEN, *BOTH_PERIODS, *words, "-o", str(tmp_path / "rules.csv"))
    (line,) = [line for line in (tmp_path / "rules.csv").read_text().splitlines() if line.startswith("cqc,")]
    noise = covariance((0.4, 0.7), dampings)
    correlation = noise[0, 1] / np.sqrt(noise[0, 0] * noise[1, 1])
    expected = np.sqrt(45.0**2 + 30.0**2 - 2.0 * correlation * 45.0 * 30.0)
    assert float(line.split(",")[1]) == pytest.approx(expected, rel=1e-9)
    assert "periods of 0.4 and 0.7 s" in told.output and f"a correlation of {correlation:.3f}" in told.output
    assert ("0.05 is taken without --damping" in told.output) is taken


def test_given_design_displacements_in_python():
    rows = {row.rule: row for row in pr.separations(("A", "B"), ("45 mm", 0.03), site=pr.Site(factors=(3.0, 3.0)))}
    assert rows["eurocode8"].separation == pytest.approx(0.045 * np.sqrt(13.0), rel=1e-12)
    assert rows["cqc"].separation is None and rows["cqc"].note == "needs periods and dampings"


def test_what_a_rule_takes_for_granted_is_told(says):
    rows = {row.rule: row for row in separations(BUILDINGS, (0.03, 0.04), (0.9, 1.0), (0.05, 0.05))}
    says([f"{row.rule}: {row.note}" for row in rows.values()])
    for row in rows.values():
        assert ("clause from memory, not read" in row.note) is (row.verification == "from memory")
        assert ("clause quoted by others, not read" in row.note) is (row.verification == "quoted")
    known = separations(BUILDINGS, (0.03, 0.04), (0.9, 1.0), (0.05, 0.05), KNOWN._replace(factors=(0.9, 0.9)))
    for row in known:
        later = f"superseded by {row.superseded}" if row.superseded else ""
        assert row.verification not in ("derived", "clause read") or row.note == later
    assert rows["mexico"].separation is None
    assert rows["asce7"].separation == rows["eurocode8"].separation == pytest.approx(0.05)
    assert own_note(rows["eurocode8"]).endswith("; floors not at the same levels")
    assert len(footnotes(list(rows.values()))) == 3
    assert footnotes([row for row in known if row.verification in ("derived", "clause read")]) == []


def made_results(closing: np.ndarray, left: np.ndarray, right: np.ndarray, period: float = 1.0) -> xr.Dataset:
    """Results as `scan` writes them; by record, polarity and amplitude."""
    axes = ("record", "polarity", "pga")
    count = closing.shape
    sides = [Building(name, 1e5, 1.0, 0.05) for name in BUILDINGS]
    places = place_coordinates(sides, [Point(0, 1.0, 1.0, "floor", np.nan)], np.full((1, 1), np.inf))
    del places["contact_point_yield_force"]
    return xr.Dataset(
        {
            "peak_closing_free": ((*axes, "interface"), closing[..., None]),
            "peak_displacement_free": ((*axes, "building"), np.stack([left, right], axis=-1)),
        },
        coords={
            "record": [f"R{number}" for number in range(count[0])],
            "polarity": ["as recorded", "reversed"][: count[1]],
            "pga": [2.0, 4.0, 3.0][: count[2]],
            "building": list(BUILDINGS),
            "building_period": ("building", [0.9, period]),
            "building_damping": ("building", [0.05, 0.05 if np.isfinite(period) else np.nan]),
            **places,
        },
    )


@pytest.fixture(scope="module")
def results() -> xr.Dataset:
    """Twenty records; at the largest amplitude one motion closes no gap and one has no answer."""
    chance = np.random.default_rng(7)
    left, right = chance.lognormal(-3.0, 0.5, (2, 20, 2, 3))
    closing = (left + right) * chance.uniform(0.3, 1.0, left.shape)
    closing[3, 1, 1] = 0.0
    left[5, 0, 1] = np.nan
    return made_results(closing, left, right)


def test_rules_beside_the_motions(results):
    """Every number by its definition, from the arrays themselves."""
    table = code_table(results, 90.0)
    assert (table.amplitude, table.motions, table.without) == (4.0, 38, 1)
    shown = results.sel(pga=4.0)
    left, right = (shown["peak_displacement_free"].values[..., side].ravel() for side in (0, 1))
    needed = shown["peak_closing_free"].values.ravel()
    known = np.isfinite(left)
    assert table.demand == pytest.approx(np.percentile(needed[known], 90.0, method="inverted_cdf"))
    assert table.demand_median == pytest.approx(np.median(needed[known]))
    assert table.displacements == pytest.approx((np.median(left[known]), np.median(right[known])))
    moved = known & (needed > 0.0)
    each = np.hypot(left, right)[moved]
    ratio = each / needed[moved]
    found = {comparison.row.rule: comparison for comparison in table.rules}["asce7"]
    assert found.row.separation == pytest.approx(np.hypot(*table.displacements))
    upper = np.percentile(each, 90.0, method="inverted_cdf")
    assert (found.middle, found.upper) == pytest.approx((np.median(each), upper))
    quantiles = np.percentile(ratio, [16.0, 50.0, 84.0])
    assert (found.ratio_low, found.ratio_median, found.ratio_high) == pytest.approx(tuple(quantiles))
    assert found.exceeded == pytest.approx(np.mean(ratio < 1.0))
    assert 0.0 < found.exceeded < 1.0 and found.safe is False
    assert table.closing == pytest.approx(tuple(needed[moved])) and table.asked["srss"] == pytest.approx(tuple(each))
    assert table.names[:2] == ("R0 as recorded", "R0 reversed") and len(table.names) == 38
    assert json.loads(json.dumps(table.as_dict(), allow_nan=False))["rules"][0]["row"]["rule"] == "abs"


def test_the_finding_says_what_the_table_says(results):
    table = code_table(results)
    told = {each.row.rule: each for each in table.rules}
    short = round(told["srss"].exceeded * table.motions)
    ratio = {name: each.ratio_median for name, each in told.items()}
    assert f"ABS falls short in none ({ratio['abs']:.2f} times the gap needed in the median)" in table.finding
    assert f"SRSS in {short} ({ratio['srss']:.2f})" in table.finding
    assert told["mexico"].exceeded is None and told["mexico"].row.note.startswith("needs heights and zone; ")


def test_a_rule_that_just_holds_is_not_exceeded():
    """Beside a rigid building every combination is the other's peak, to the last digit or so."""
    peaks = np.full((4, 1, 1), 0.1) * (1.0 + 1e-15 * np.arange(4).reshape(4, 1, 1))
    table = code_table(made_results(peaks * (1.0 + 4e-16), peaks, 0.0 * peaks, period=np.nan))
    assert [each.exceeded for each in table.rules[:3]] == [0.0] * 3
    assert table.correlation is None


def test_motions_that_close_no_gap_ask_for_nothing():
    peaks = np.full((3, 2, 1), 0.1)
    table = code_table(made_results(0.0 * peaks, peaks, peaks))
    assert (table.motions, table.without, table.demand) == (0, 6, 0.0)
    assert table.finding == "No motion closes any gap between these buildings"
    assert table.rules[0].row.separation == pytest.approx(0.2) and table.rules[0].exceeded is None
    assert table.finding in separations_figure(table).get_suptitle()


def test_a_dataset_that_will_not_do_is_refused(results, says):
    says([refusal(code_table, made) for made in (results.drop_vars("peak_closing_free"), results.isel(building=[0]))])
    says([refusal(code_table, results, percentile) for percentile in (120.0, 0.3, 10, 1)])
    assert code_table(results, 0.9) == code_table(results, "90 %") == code_table(results, 90.0)


def test_a_passing_wave_is_in_no_rule_and_told(results):
    """The ground moves apart, so that even the sum of peaks is no bound."""
    passing = results.assign_attrs(scene_resolved='[effects]\nwave_passage = {velocity = "300 m/s"}\n')
    assert all(ONE_GROUND in each.row.note for each in code_table(passing).rules)
    assert not any(ONE_GROUND in each.row.note for each in code_table(results).rules)


def test_without_a_finite_motion_nothing_is_asked_for(results, says):
    says(refusal(code_table, results.assign(peak_closing_free=results["peak_closing_free"] * np.nan)))


def test_a_scan_tells_all_that_is_needed():
    """On real records no sum of peaks is exceeded, which no rounding may break; displacements are spectral ones."""
    records = ["RSN6-180", "CCC-HN1"]
    # No gap so wide is ever closed: nothing is simulated.
    text = scene_text(
        *(single(name, "10 t", f"{period} s", damping=0.05) for name, period in (("left", 0.5), ("right", 0.8))),
        law="linear",
        gap="9 m",
        records={"names": records, "polarity": BOTH},
    )
    table = code_table(pr.scan(text, check_fraction=0.0))
    assert (table.motions, table.amplitude) == (4, None)
    assert table.rules[0].safe and table.rules[0].ratio_low > 1.0
    first = read_motion(records[0])
    peaks = response_spectra([first.acceleration], first.dt, [0.5, 0.8]).displacement[0]
    # Both find local maxima between samples, each in its own way: 1e-9 apart.
    assert table.asked["abs"][:2] == pytest.approx((peaks.sum(), peaks.sum()), rel=1e-7)


run = partial(commands.done, "separations")


def test_the_command_lists_every_rule():
    told = run()
    lines = {line.split()[0]: line for line in told.output.split("\n\n")[1].splitlines()[1:]}
    assert list(lines) == list(RULES)
    for rule in RULES.values():
        assert rule.clause in lines[rule.name] and rule.formula in lines[rule.name]
        assert f" {rule.verification} " in lines[rule.name]
        assert rule.source in told.output and f", by {rule.superseded}" in told.output
    assert "Rules from memory were not read anywhere" in told.output
    assert "Quoted rules were read in texts that quote the clause" in told.output
    assert "smaller separations and setbacks are allowed where rational analyses" in told.output


def test_the_figure_shows_every_motion_and_every_rule(results):
    table = code_table(results)
    figure = separations_figure(table, "a note")
    motions, rules = figure.axes
    lines = {line.get_label(): line.get_ydata() for line in motions.get_lines()}
    assert lines["gap needed"] == pytest.approx(1e3 * np.sort(table.closing))
    order = np.argsort(table.closing)
    assert lines["CQC"] == pytest.approx(1e3 * np.array(table.asked["cqc"])[order])
    labels = [label.get_text() for label in rules.get_yticklabels()]
    drawn = [each.row for each in table.rules if each.exceeded is not None]
    assert len(labels) == len(drawn)
    for label, row in zip(labels, drawn, strict=True):
        assert ("quoted" in label) is (row.verification == "quoted")
        assert ("from memory" in label) is (row.verification == "from memory")
        assert ("superseded" in label) is bool(row.superseded)
    marks = [line for line in rules.get_lines() if len(line.get_xdata()) == 1]
    filled = {"derived": "full", "clause read": "full", "quoted": "left", "from memory": "none"}
    assert [mark.get_fillstyle() for mark in marks] == [filled[row.verification] for row in drawn]
    assert {mark.get_color() for mark in marks} == {MEANING["rule"]}
    words = words_of(figure).replace("\n", " ")
    assert table.finding in words and "a note" in words


def test_neighbours_of_nearly_one_period_move_alike():
    """The correlation of periods that hardly differ is 1 but for rounding, which must leave no root of less than 0."""
    periods = np.random.default_rng(1).uniform(0.1, 2.0, 1000)
    pair = periods, periods * (1.0 + 1e-10)
    dampings = np.full(1000, 0.05), np.full(1000, 0.05)
    assert white_noise_correlation(pair, dampings).max() <= 1.0
    moved = np.full(1000, 0.1), np.full(1000, 0.1)
    assert cqc(moved, pair, dampings) == pytest.approx(np.zeros(1000), abs=1e-8)


@pytest.mark.parametrize(
    ("neighbour", "factor"),
    [
        (storeyed("tower", "120 t", "60 MN/m", "3 m", storeys=4), 0.7),
        (single("tower", "300 t", "0.7 s", height="9 m"), 1.0),
        (rigid("tower", height="9 m"), 1.0),
    ],
)
def test_floors_that_nobody_knows_are_not_aligned(neighbour, factor):
    """A mass for a whole building meets the flats once, floor to floor, and a wall wherever their floors are."""
    flats = storeyed("flats", "100 t", "90 MN/m", "3 m", storeys=3)
    dataset = pr.scan(scene_text(flats, neighbour, records={"window": ["0 s", "6 s"]}))
    assert set(dataset["contact_point_kind"].values.tolist()) == {"floor"}
    rules = {each.row.rule: each.row.separation for each in code_table(dataset).rules}
    assert rules["eurocode8"] == pytest.approx(factor * rules["srss"], rel=1e-12)


def test_a_dataset_with_axes_is_refused_by_name_and_not_by_all_that_it_holds():
    keys = {"records": {"window": ["0 s", "3 s"]}, "grid": {"building.left.period": ["0.4 s", "0.6 s"]}}
    with pytest.raises(PoundingError, match=r"^the dataset: has cases along building.left.period"):
        beside_motions(pr.scan(scene_text(**keys), check_fraction=0.0))
