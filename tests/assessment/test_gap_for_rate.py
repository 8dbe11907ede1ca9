"""The gap that keeps contact to an annual rate against Cornell's closed form, simulated coverage, rates by Poisson."""

import re
from pathlib import Path

import numpy as np
import pytest
from figure_words import words_of
from made_hazard import written
from scipy.integrate import quad
from scipy.optimize import brentq
from scipy.stats import norm, poisson
from sentences import refusal, refusals
from test_assess import in_a_row, lognormal, made_up

from pounding_risk import assess
from pounding_risk.assessment.annual_rates import read_rate, return_period_words
from pounding_risk.assessment.fragility import ContactMotions
from pounding_risk.assessment.hazard import Hazard, rate_of
from pounding_risk.assessment.rates import RateOfGaps
from pounding_risk.figures.assess import assessment_figure
from pounding_risk.questions.assess import sheet
from pounding_risk.render.csv_text import csv_text
from pounding_risk.render.terminal import print_sheet
from pounding_risk.statistics.hazard import annual_rate, in_years, rate_of_probability
from pounding_risk.statistics.required_gap import RunGaps, rounded_up
from pounding_risk.units import QuantityError, say_in

K0, K = 2e-3, 2.5
TARGET = read_rate("2 % in 50 years")


def power_law(low: float = 1e-4, high: float = 1e4, rows: int = 25) -> Hazard:
    im = np.geomspace(low, high, rows)
    return Hazard("pga", im, K0 * im**-K, "power.csv")


def motions_of(capacities: np.ndarray, recordings: np.ndarray | None = None, linear: bool = True) -> ContactMotions:
    """Motions at 1 m/s2 whose capacity at a gap of 1 m is given."""
    who = np.arange(capacities.size) if recordings is None else recordings
    return ContactMotions("pga", "", np.ones((capacities.size, 1)), 1.0 / capacities[:, None], who, linear)


def site(folder: Path, k0: float = K0, k: float = K, head: str = "pga [m/s^2],annual rate") -> Path:
    rows = (f"{x!r},{k0 * x**-k!r}\n" for x in np.geomspace(1e-3, 1e3, 13).tolist())
    return written(folder / "site.csv", f"{head}\n{''.join(rows)}")


def test_the_gap_is_cornells_rate_solved_for_the_gap():
    """θ = g θ₁: g = (k₀ exp(k²β²/2) / ν)^(1/k) / θ₁, θ₁ and β the mean and deviation (1/n) of the logarithms."""
    capacities = np.random.default_rng(5).lognormal(np.log(2.0), 0.4, 30)
    median, spread = np.exp(np.log(capacities).mean()), np.log(capacities).std()
    for text in ("2 % in 50 years", "475 years", "3e-3 a year"):
        target = read_rate(text)
        found = RateOfGaps(power_law(), motions_of(capacities), 0.95).gap(target)
        known = (K0 * np.exp(0.5 * (K * spread) ** 2) / target.rate) ** (1.0 / K) / median
        assert found.gap == pytest.approx(known, rel=1e-6)
        # Root-finding on the integral itself, by SciPy's quadrature.
        root = brentq(lambda gap, rate=target.rate: _quadrature(gap * median, spread) - rate, known / 3.0, known * 3.0)
        assert found.gap == pytest.approx(root, rel=1e-6)
        assert found.low < found.gap < found.high
        assert not found.at_least and found.missing < 1e-6


def _quadrature(median: float, spread: float) -> float:
    def density(log_im: float) -> float:
        return float(norm.cdf((log_im - np.log(median)) / spread)) * K0 * K * np.exp(-K * log_im)

    middle = np.log(median)
    return float(quad(density, middle - 9.0, middle + 9.0, epsabs=0.0, epsrel=1e-10, limit=200)[0])


def test_motions_counted_need_no_lognormal():
    """Of a power law the mean of k₀ (a g)^−k over the capacities is ν: g = (k₀ mean(a^−k) / ν)^(1/k), exactly."""
    capacities = np.r_[np.full(15, 1.0), np.full(5, 3.0)] * np.linspace(0.99, 1.01, 20)  # far from lognormal
    found = RateOfGaps(power_law(), motions_of(capacities), 0.95).gap(TARGET)
    known = (K0 * (capacities**-K).mean() / TARGET.rate) ** (1.0 / K)
    assert found.counted == pytest.approx(known, rel=1e-6)
    assert abs(found.gap / found.counted - 1.0) > 0.01  # the lognormal curve is another
    # A table that ends at half the target's rate has the same answer: what is stronger closes the gap as well.
    last = (K0 / (0.5 * TARGET.rate)) ** (1.0 / K)
    short = RateOfGaps(power_law(high=last), motions_of(capacities), 0.95).gap(TARGET)
    assert short.counted == pytest.approx(known, rel=1e-6)  # as far as capacities are beyond it, λ has the same slope


def test_rarer_contact_takes_a_wider_gap_and_its_rate_is_the_target():
    """Monotone, and `annual_rate` of the fragility at the gap is what was asked for, on a curve that is no power."""
    im = np.geomspace(0.01, 100.0, 30)
    hazard = Hazard("pga", im, 0.05 * np.exp(-1.4 * np.log1p(im) ** 1.5), "bent.csv")
    motions = motions_of(lognormal(20, 2.0)[:, 0])
    rates = RateOfGaps(hazard, motions, 0.95)
    found = [rates.gap(read_rate(rate)) for rate in (2e-2, 1e-2, 7e-3, 5e-3, 4e-3)]
    for ends in ("low", "gap", "high", "counted"):
        assert np.all(np.diff([getattr(gap, ends) for gap in found]) > 0.0)
    for gap in found:
        curve = motions.curve(gap.gap)
        assert float(annual_rate(hazard, curve.median, curve.dispersion)) == pytest.approx(gap.rate, rel=1e-9)
        assert gap.rate_low < gap.rate < gap.rate_high


def test_the_bounds_of_a_gap_are_where_those_of_the_rate_pass_the_target():
    """At ``high`` the upper bound of the rate is the target, at ``low`` the lower one: one statement, two ways."""
    motions = motions_of(np.random.default_rng(2).lognormal(0.0, 0.3, 24), np.repeat(np.arange(12), 2))
    found = RateOfGaps(power_law(), motions, 0.9).gap(TARGET)
    for gap, bound in ((found.low, "low"), (found.high, "high")):
        rate = getattr(rate_of(power_law(), motions.curve(gap), 0.9), bound)
        assert rate == pytest.approx(TARGET.rate, rel=0.05)  # "nearest" of 400 draws, and interpolated ones


@pytest.mark.parametrize(("recordings", "each", "likeness"), [(8, 1, 0.0), (12, 4, 0.6)])
@pytest.mark.complete
def test_bounds_hold_the_true_gap_as_often_as_they_say(recordings, each, likeness):
    """150 ensembles of a lognormal population whose gap is known: no side is missed in more than 2.5 % + 3 errors."""
    rng = np.random.default_rng(11)
    spread, draws = 0.5, 150
    known = (K0 * np.exp(0.5 * (K * spread) ** 2) / TARGET.rate) ** (1.0 / K)
    hazard, who = power_law(rows=2), np.repeat(np.arange(recordings), each)
    below = above = 0
    for _ in range(draws):
        shared = np.sqrt(likeness) * rng.standard_normal((recordings, 1))
        own = np.sqrt(1.0 - likeness) * rng.standard_normal((recordings, each))
        # Motions of 1 m/s2 that are scaled by less than four: the gap is near that at which they touch.
        unit = np.exp(spread * (shared + own)).ravel()
        motions = ContactMotions("pga", "", np.full((unit.size, 1), known), known / unit[:, None], who, True)
        found = RateOfGaps(hazard, motions, 0.95).gap(TARGET)
        assert not found.fault
        below, above = below + (known < found.low), above + (known > found.high)
    allowed = 0.025 + 3.0 * np.sqrt(0.025 * 0.975 / draws)
    assert below / draws <= allowed and above / draws <= allowed


def test_where_capacities_are_not_known_curves_are_fitted():
    """Stripes of 120 recordings that are not said to be linear: within 3 errors of the gap of the population."""
    amplitudes = np.array([0.5, 1.0, 2.0, 4.0, 8.0])
    closing = lognormal(120, scale=0.01, spread=0.4)[:, :1] * amplitudes
    ims = np.broadcast_to(amplitudes, closing.shape)
    motions = ContactMotions("pga", "multiple stripes", ims, closing, np.arange(120), False)
    target = read_rate(1e-3)
    found = RateOfGaps(power_law(), motions, 0.95).gap(target)
    known = 0.01 * (K0 * np.exp(0.5 * (K * 0.4) ** 2) / target.rate) ** (1.0 / K)
    assert found.low < known < found.high
    assert found.gap == pytest.approx(known, rel=0.15)
    assert found.gap in closing  # the curve changes where one motion less closes the gap
    assert np.isnan(found.counted)
    rare, often = (RateOfGaps(power_law(), motions, 0.95).gap(read_rate(rate)) for rate in (1e-8, 0.5))
    assert "scan stronger motions" in rare.fault and np.isnan(rare.gap)
    assert "scan weaker motions" in often.fault
    # A row that was run at 0.02 m, which motions close that need 0.08 m and more: no stronger motion says more there.
    unrun = RateOfGaps(power_law(), motions._replace(run=RunGaps(0.02)), 0.95).gap(read_rate(1e-8))
    assert "the row was run at gaps of up to 20 mm" in unrun.fault and unrun.fault.endswith("scan such gaps")


def test_what_the_motions_do_not_carry_has_no_gap():
    """A rate that the curve does not reach; one recording; motions that scaling would change too much."""
    capacities = lognormal(20)[:, 0]
    short = power_law(0.1, 10.0)
    found = RateOfGaps(short, motions_of(capacities), 0.95).gap(read_rate(0.99 * 1.0))
    assert "give it rows of weaker motions" in found.fault and np.isnan(found.gap)
    alone = RateOfGaps(power_law(), motions_of(capacities, np.zeros(20, dtype=np.int64)), 0.95).gap(TARGET)
    assert "one recording" in alone.fault or "one intensity" in alone.fault
    far = RateOfGaps(power_law(), motions_of(np.linspace(90.0, 110.0, 20)), 0.95).gap(read_rate(1e-6))
    assert re.match(
        r"the gap would be .* mm, and the median by scaling, .* takes the motions that were tested", far.fault
    )


def test_a_bound_that_no_gap_has_is_none(tmp_path, capsys):
    """Two recordings leave the dispersion open, and the bound of the gap with it: 4e8 km is no bound of a gap."""
    found = RateOfGaps(power_law(), motions_of(np.array([40.0, 45.0])), 0.95).gap(TARGET)
    assert 0.0 < found.low < found.gap < 1.0 and found.high == np.inf
    many = RateOfGaps(power_law(), motions_of(lognormal(40, 40.0)[:, 0]), 0.95).gap(TARGET)
    assert many.gap < many.high < 10.0
    results = made_up(lognormal(4, spread=0.1), pga=4.0)
    assessment = assess(results, hazard=site(tmp_path), target_rate="475 years")
    print_sheet(sheet(assessment))
    printed = capsys.readouterr().out
    assert "e+" not in printed and not re.search(r"\de\d", printed)
    assert " to ∞" in printed


def test_a_curve_that_ends_too_soon_gives_at_least_a_gap():
    """A power law cut at the median of the motions at the gap: stronger ones, which close it, are left out."""
    capacities = np.random.default_rng(5).lognormal(0.0, 0.4, 30)
    whole = RateOfGaps(power_law(), motions_of(capacities), 0.95).gap(read_rate(2e-3))
    cut = RateOfGaps(power_law(0.05, 1.2), motions_of(capacities), 0.95).gap(read_rate(2e-3))
    assert cut.at_least and cut.missing > 0.05
    assert cut.gap < whole.gap and not whole.at_least


def test_the_verdict_says_which_gap_to_provide(tmp_path):
    """Answers by the gap, each with the rate at the gap, and the gap in the conclusion and among the facts."""
    results = made_up(lognormal(40), pga=4.0)
    results.attrs["records"] = "[]"  # every record is a recording of its own
    file = site(tmp_path, 0.01, 2.0)
    words = {}
    for gap in (0.01, 0.02, 0.03):
        (one,) = assess(results, gap=gap, hazard=file, target_rate="1e-3 a year").interfaces
        verdict = one.rate_verdict
        words[gap] = verdict.word
        assert one.verdict.conclusion[-1] == verdict.conclusion[0]
        assert verdict.sentence in verdict.conclusion[0]
        assert verdict.required in one.gaps_for_rates
        here = next(rate for rate in one.rates if (rate.what, rate.gap) == ("contact", gap))
        assert (verdict.annual, verdict.low, verdict.high) == (here.annual, here.low, here.high)
        assert ("gap for 0.001 a year") in dict(one.facts())
    assert list(words.values()) == ["inadequate", "depends", "adequate"]
    curve = next(curve for curve in one.fragility if curve.gap == 0.02)
    known = 0.02 * np.sqrt(0.01 * np.exp(2.0 * curve.dispersion**2) / 1e-3) / curve.median
    assert verdict.required.gap == pytest.approx(known, rel=1e-3)
    near = assess(results, gap=known, hazard=file, target_rate=1e-3).interfaces[0].rate_verdict
    assert near.word == "depends" and "stays open" in near.sentence
    assert "under site.csv" in near.conclusion[0] and "(once in 1000 years)" in near.conclusion[0]
    far = assess(results, gap=0.5, hazard=file, target_rate=1e-3).interfaces[0].rate_verdict
    assert far.word == "depends" and "how often contact comes at a gap of 500 mm is not known" in far.sentence


def test_a_rate_that_is_only_a_lower_bound_shows_nothing_adequate(tmp_path):
    """A curve that ends at 2 m/s2, before most motions touch: their rate in the table is small, and says little."""
    results = made_up(lognormal(40), pga=4.0)
    file = written(tmp_path / "short.csv", "pga [m/s^2],annual rate\n1,1e-2\n2,2.5e-3\n")
    assessed = assess(results, gap=0.02, hazard=file, target_rate=5e-3)
    found = assessed.interfaces[0].rate_verdict
    assert found.high <= 5e-3
    assert found.word == "depends"
    assert "as the hazard curve ends where contact does not" in found.sentence
    assert f",at least {found.annual!r}," in csv_text(sheet(assessed))


def test_motions_without_a_response_show_nothing_adequate_by_rate(tmp_path):
    """As in the verdict on P(contact): those that failed may all have closed the gap."""
    closing = lognormal(40)
    results = made_up(closing, pga=4.0)
    results.attrs["records"] = "[]"
    asked = {"gap": 0.03, "hazard": site(tmp_path, 0.01, 2.0), "target_rate": 1e-3}
    assert assess(results, **asked).interfaces[0].rate_verdict.word == "adequate"
    results["peak_closing_free"][3, 0] = np.nan
    found = assess(results, **asked).interfaces[0].rate_verdict
    assert found.word == "depends"
    assert found.sentence.endswith("stays open, as 1 motion without a finite response is not in it.")


def with_spectra(count: int = 30):
    """Records whose spectra are a power of the period, and buildings of 0.5 s and 1.2 s."""
    results = made_up(lognormal(count), pga=4.0)
    periods = np.geomspace(0.05, 5.0, 9)
    height = np.exp(0.3 * np.random.default_rng(8).standard_normal(count))
    spectra = height[:, None] * results["record_pga"].values[:, None] * periods**-0.5
    results = results.assign(record_spectral_acceleration=(("record", "period"), spectra), period=periods)
    return results.assign_coords(building_period=("building", [0.5, 1.2]), building_damping=("building", [0.05, 0.02]))


UNIFORM = "return period [years],pga [m/s^2],sa(0.2 s) [m/s^2],sa(2 s) [m/s^2]\n" + "".join(
    f"{0.01**-1 * x**2!r},{x!r},{x * 0.2**-0.5!r},{x * 2.0**-0.5!r}\n" for x in np.geomspace(0.05, 50.0, 9).tolist()
)


@pytest.mark.parametrize(
    ("asked", "period", "words"),
    [
        (None, 1.2, "The curve is that of Sa(1.2 s), at the longest period of the buildings."),
        ("sa(longer)", 1.2, "at the longest period of the buildings."),
        ("sa(shorter)", 0.5, "The curve is that of Sa(0.5 s), at the shortest period of the buildings."),
        ("sa(mean)", np.sqrt(0.6), "that of Sa(0.775 s), at the geometric mean of the buildings' periods."),
        ("sa(0.9 s)", 0.9, "The curve is that of Sa(0.9 s)."),
    ],
)
def test_spectra_are_joined_with_the_fragility_at_one_period(tmp_path, asked, period, words):
    """Sa of hazard and motions are powers of the period: the gap follows from Cornell's form, whatever the period."""
    file = written(tmp_path / "uniform.csv", UNIFORM)
    results = with_spectra()
    found = assess(results, hazard=file, intensity=asked, target_rate=1e-3)
    assert words in found.hazard_reading and "is read between 0.2 s and 2 s" in found.hazard_reading
    (one,) = found.interfaces
    # λ(Sa) = 0.01 (Sa T^0.5)^−2, and each motion's Sa = 4 height T^−0.5: the period cancels.
    height = results["record_spectral_acceleration"].values[:, 0] / results["record_pga"].values * np.sqrt(0.05)
    capacities = 4.0 * np.repeat(height, 2) / results["peak_closing_free"].values.ravel()
    median, spread = np.exp(np.log(capacities).mean()), np.log(capacities).std()
    known = np.sqrt(0.01 * np.exp(2.0 * spread**2) / 1e-3) / median
    assert one.rate_verdict.required.gap == pytest.approx(known, rel=2e-3)  # the table's ends
    curve = next(curve for curve in one.fragility if curve.gap == 0.02)
    assert curve.median == pytest.approx(0.02 * median * period**-0.5, rel=1e-5)


@pytest.mark.complete
def test_a_curve_is_taken_at_its_own_intensity_unless_another_is_asked_for(tmp_path):
    file = site(tmp_path, head="Sa(1.2 s) [m/s^2],annual rate")
    results = with_spectra()
    assert assess(results, hazard=file).intensity == "sa(1.2 s)"
    assert assess(results, hazard=site(tmp_path)).intensity == "pga"
    assert assess(results).intensity == "pga"


def test_a_dataset_without_spectra_says_how_to_get_them(tmp_path, says):
    """Older versions wrote none: the motions have no Sa then."""
    file = written(tmp_path / "uniform.csv", UNIFORM)
    results = with_spectra().drop_vars("record_spectral_acceleration")
    says(refusal(assess, results, hazard=file))
    assert assess(results, hazard=file, intensity="pga").intensity == "pga"


def test_spectra_of_another_damping_are_refused(tmp_path, says):
    """The right building has 2 %, and what is read of the motions at its period is that of 2 % too."""
    hazard = written(tmp_path / "uniform.csv", UNIFORM)
    says(refusal(assess, with_spectra(), hazard=hazard, intensity="sa(right)"))


def test_a_curve_of_another_damping_than_the_buildings_is_refused(tmp_path, says):
    """Sa of a single mass is that of its own damping, 2 % here: a curve of 5 % is another measure."""
    results, file = with_spectra(), site(tmp_path, head="Sa(1.2 s) [m/s^2],annual rate")
    says(refusal(assess, results, hazard=file, intensity="sa(right)"))
    named = site(tmp_path, head='"Sa(1.2 s, 2 %) [m/s^2]",annual rate')
    assert assess(results, hazard=named, intensity="sa(right)").hazard == "site.csv"


def test_a_period_of_rigid_buildings_is_refused(says):
    results = with_spectra().assign_coords(building_period=("building", [np.nan, np.nan]))
    says(refusal(assess, results, intensity="sa(longer)"))


def test_a_row_has_the_verdict_by_rate_of_each_interface(tmp_path, capsys):
    """Two interfaces of the same motions, one of which needs twice the gap: each has its own verdict and gap."""
    results = in_a_row(made_up(lognormal(20), pga=4.0), made_up(lognormal(20, scale=0.04, seed=15), pga=4.0))
    found = assess(results, hazard=site(tmp_path, 0.01, 2.0), target_rate=1e-3)
    print_sheet(sheet(found))
    told = capsys.readouterr().out
    assert "for 0.001 a year  gap for it" in told
    for one in found.interfaces:
        assert one.rate_verdict.conclusion[0] in told
        for gap in one.gaps_for_rates:
            assert gap.fault or f" {1e3 * rounded_up(gap.gap):.4g}" in told, "rounded up to what suffices"
    first, second = (one.rate_verdict.required.gap for one in found.interfaces)
    assert second == pytest.approx(2.0 * first, rel=0.2)  # twice the closings, of other motions


def test_gaps_that_are_not_known_are_told_with_the_reason(tmp_path, capsys):
    """20 mm of motions that close 4 mm: usual rates take them far beyond what was scanned."""
    found = assess(
        made_up(lognormal(20, scale=0.02), pga=0.4), hazard=site(tmp_path, 1.0, 2.0), target_rate="475 years"
    )
    print_sheet(sheet(found))
    told = capsys.readouterr().out
    assert "no gap for" in told and "scan stronger motions" in told
    assert "No gap can be given for contact no more often than once in 475 years" in told


def test_the_figure_has_the_rate_against_the_gap(tmp_path):
    found = assess(made_up(lognormal(20), pga=4.0), hazard=site(tmp_path, 0.004, 2.0), target_rate="475 years")
    figure = assessment_figure(found)
    assert "for once in 475 years" in words_of(figure).replace("\n", " ")
    axis = figure.axes[2]
    assert (axis.get_xlabel(), axis.get_ylabel(), axis.get_yscale()) == ("gap [mm]", "rate of contact [1/year]", "log")
    (one,) = found.interfaces
    line = next(line for line in axis.lines if line.get_label() == "contact, under site.csv")
    for gap in (*one.gaps_for_rates, one.rate_verdict.required):
        if not gap.fault:
            assert np.interp(1e3 * gap.gap, *line.get_data()) == pytest.approx(gap.rate, rel=1e-9)
    marks = {str(line.get_label()): line.get_data() for line in axis.lines}
    for gap in one.gaps_for_rates:
        least = "at least " if gap.at_least else ""
        assert gap.fault or f"for {gap.words}: {least}{say_in(rounded_up(gap.gap), 'mm', 3)}" in marks
    rates = [line.get_marker() for line in axis.lines if str(line.get_label()).startswith("for ")]
    assert len(rates) > 3 and len(set(rates)) == len(rates)
    assert marks["its bounds"][0] == pytest.approx(
        [1e3 * one.rate_verdict.required.low, 1e3 * one.rate_verdict.required.high]
    )
    assert len(assessment_figure(assess(made_up(lognormal(20), pga=4.0))).axes) == 2


@pytest.mark.parametrize(
    ("text", "period"), [("10 % in 50 years", 475), ("2 % in 50 years", 2475), ("5% in 50yr", 975)]
)
def test_the_return_periods_of_codes(text, period):
    """EN 1998-1, 2.1, and ASCE 7: 475, 2475 and 975 years, rounded there."""
    assert 1.0 / read_rate(text).rate == pytest.approx(period, abs=0.7)


@pytest.mark.parametrize("probability", [1e-12, 0.02, 0.5, 0.999])
def test_a_probability_is_that_of_poissons_law(probability):
    """SciPy's P(N ≥ 1) with the mean rate × years gives the probability back; as does the function's own inverse."""
    rate = rate_of_probability(probability, 30.0)
    assert poisson.sf(0, 30.0 * rate) == pytest.approx(probability, rel=1e-12)
    assert in_years(rate, 30.0) == pytest.approx(probability, rel=1e-12)


@pytest.mark.parametrize(
    ("text", "rate", "words", "years"),
    [
        ("0.01 in 100 years", -np.log(0.99) / 100.0, "1 % in 100 years", 100.0),
        ("Probability of 1 % in 1 year", -np.log(0.99), "1 % in 1 year", 1.0),
        ("2475 years", 1.0 / 2475.0, "once in 2475 years", 50.0),
        ("return period of 475 yr", 1.0 / 475.0, "once in 475 years", 50.0),
        ("once in 1e4 years", 1e-4, "once in 10000 years", 50.0),
        ("4e-4 a year", 4e-4, "0.0004 a year", 50.0),
        ("annual rate 0.002", 0.002, "0.002 a year", 50.0),
        (".002 1/year", 0.002, "0.002 a year", 50.0),
        (0.002, 0.002, "0.002 a year", 50.0),
    ],
)
def test_a_rate_is_read_from_its_forms(text, rate, words, years):
    found = read_rate(text)
    assert found.rate == pytest.approx(rate, rel=1e-14)
    assert (found.words, found.years) == (words, years)
    assert read_rate(found.words).rate == pytest.approx(rate, rel=1e-5)  # the words are read again


NO_RATES = """1 in 2475 years, 10 in 50 years, 100 % in 50 years, 0 % in 50 years, 1 % in 0 years, 0 years, 1e999 years,
2475, 0, -1e-4 a year, rarely, , 1 % in 50, 1e-300 % in 1e300 years"""


def test_what_is_no_rate_is_refused_with_what_to_write(says):
    texts = [text.strip() for text in NO_RATES.split(",")]
    says(*refusals(read_rate, name="target", kind=QuantityError, wrong={"stated": [*texts, float("nan"), None, [1.0]]}))


def test_a_return_period_in_words(says):
    says([return_period_words(1.0 / years) for years in (475.3, 12.34, 3e7)])
