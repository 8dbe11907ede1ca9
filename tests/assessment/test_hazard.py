"""Annual rates against Cornell's closed form, hazard tables of every form, OpenQuake's, and levels of intensity."""

from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pytest
import xarray as xr
from damaged_tables import survey
from made_hazard import fragility, site_file, written
from scenes import scene_text, single, storeyed
from scipy.integrate import cumulative_trapezoid, quad
from scipy.stats import chi2, kstest, norm
from scipy.stats import t as student
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment import fragility as curves
from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.assessment.hazard import Hazard, HazardSpectrum, rate_of, unusual
from pounding_risk.assessment.hazard_table import read_hazard
from pounding_risk.assessment.intensities import check_intensity
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions.read import read_motion
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene
from pounding_risk.statistics.damage_fits import METHODS, Observed
from pounding_risk.statistics.fragility import fit
from pounding_risk.statistics.hazard import annual_rate, in_years, median_at_rate, missing_share

K0, K = 2e-3, 2.5
G = 9.80665


def power_law(low: float = 1e-3, high: float = 1e3, rows: int = 25) -> Hazard:
    im = np.geomspace(low, high, rows)
    return Hazard("pga", im, K0 * im**-K)


def _density(im: float) -> float:
    return float(norm.cdf(np.log(im / 3.0) / 0.4)) * K0 * K * im ** (-K - 1.0)


@pytest.mark.parametrize("dispersion", [0.05, 0.3, 0.6])
def test_a_power_law_gives_cornells_closed_form(dispersion):
    """k₀ θ^−k exp(k²β²/2) but for what the table cuts off above, λ(1000) / λ(3) = 5e-7 at most, and rounding."""
    known = K0 * 3.0**-K * np.exp(0.5 * (K * dispersion) ** 2)
    assert float(annual_rate(power_law(), 3.0, dispersion)) == pytest.approx(known, rel=1e-6)


def test_a_sharp_fragility_reads_the_hazard_curve():
    """β → 0 leaves λ(θ), between rows too: straight lines in the logarithms, and all stronger motions fail."""
    hazard = Hazard("pga", np.array([1.0, 4.0]), np.array([1e-2, 1e-4]))
    assert float(annual_rate(hazard, 2.0, 1e-4)) == pytest.approx(1e-3, rel=1e-6)  # exp(k²β²/2) = 1 + 6e-8


def test_extreme_numbers_stay_finite():
    """A steep hazard and a wide fragility, whose exp(k²β²/2) is beyond all numbers: at most λ at the start."""
    steep = Hazard("pga", np.array([1.0, 2.0]), np.array([1e-2, 1e-6]))
    rate = annual_rate(steep, np.array([1.5, 1e-3, 1e3]), np.array([6.0, 0.01, 0.01]))
    assert ((rate >= 0.0) & (rate <= 1e-2)).all()
    assert rate[1] == pytest.approx(1e-2)  # all fail
    assert rate[2] == 0.0


def test_fifty_years_are_poisson():
    assert in_years(1.0 / 475.0) == pytest.approx(0.10, abs=1e-4)
    assert in_years(1e-12) == pytest.approx(5e-11)


@pytest.mark.parametrize("ends", [(3.0, 12.0), (1e-3, 3.0), (3.0, 1e3)], ids=["on both sides", "above", "below"])
def test_what_a_table_leaves_out_is_what_its_slopes_continue_to(ends):
    """Stronger motions fail as often as at the last row; of a power law the rest by SciPy's quadrature beyond it."""
    whole, cut = (rate_of(power_law(*each), fragility(), 0.95) for each in ((1e-3, 1e3), ends))
    low, high = ends
    assert cut.below == pytest.approx(norm.cdf(np.log(low / 3.0) / 0.4)) and cut.above == pytest.approx(K0 * high**-K)
    lost = sum(quad(_density, *each, epsabs=1e-16)[0] for each in ((0.1, max(low, 0.1)), (high, np.inf)))
    lost -= cut.above * norm.cdf(np.log(high / 3.0) / 0.4)
    assert whole.annual - cut.annual == pytest.approx(lost, rel=1e-5)  # 1e3 to infinity is 3e-7 of it
    assert cut.missing == pytest.approx(lost / (lost + cut.annual), rel=1e-6) and cut.at_least
    assert whole.missing < 1e-6 and not whole.at_least


def test_steep_and_wide_ends_stay_a_share():
    steep = Hazard("pga", np.array([1.0, 2.0]), np.array([1e-2, 1e-6]))
    for median, dispersion in ((1.5, 6.0), (1e-3, 0.01), (1e3, 0.01), (1e3, 9.0)):
        found = missing_share(steep, median, dispersion)
        assert 0.0 <= found <= 1.0


def test_bounds_follow_the_fragilitys_errors():
    """No error, no width; an error of ln θ alone moves the rate by exp(−k z σ), of the even draws to 1 %.

    So many recordings that they leave 1e-6 of β open.
    """
    narrow = rate_of(power_law(), fragility(recordings=10**12, se_median=0.0, se_dispersion=0.0), 0.95)
    assert (narrow.low, narrow.high) == pytest.approx((narrow.annual, narrow.annual), rel=1e-5)
    wide = rate_of(power_law(), fragility(recordings=10**12, se_median=0.2, se_dispersion=0.0), 0.95)
    assert wide.high / wide.annual == pytest.approx(np.exp(K * 1.96 * 0.2), rel=0.01)
    assert wide.low / wide.annual == pytest.approx(np.exp(-K * 1.96 * 0.2), rel=0.01)


@pytest.mark.parametrize("count", [5.0, 22.0])
def test_bounds_of_few_motions_are_those_of_a_million_draws(count):
    """To 3 %: a million draws of the pivots, written here, leave 1 % of bounds of 5 motions, the even draws 1 %."""
    hazard, rng = power_law(), np.random.default_rng(1)
    found = rate_of(hazard, replace(fragility(median=3.0, dispersion=0.4), independent=count), 0.95)
    beta = 0.4 * np.sqrt(count / rng.chisquare(count - 1.0, 1_000_000))
    theta = 3.0 * np.exp(beta * rng.standard_normal(beta.size) / np.sqrt(count))
    rates = K0 * theta**-K * np.exp(np.minimum(0.5 * (K * beta) ** 2, 300.0))
    assert (found.low, found.high) == pytest.approx(np.percentile(rates, (2.5, 97.5)), rel=0.03)


def test_the_median_of_a_rate_is_cornells():
    """θ = (k₀ exp(k²β²/2) / ν)^(1/k), and what `annual_rate` then gives, also beside a wide dispersion."""
    dispersions, rate = np.array([0.05, 0.3, 0.6, 40.0]), 1e-4
    found = median_at_rate(power_law(), dispersions, rate)
    known = (K0 * np.exp(0.5 * (K * dispersions[:3]) ** 2) / rate) ** (1.0 / K)
    assert found[:3] == pytest.approx(known, rel=1e-5)  # the table ends at 1000 m/s2
    assert annual_rate(power_law(), found, dispersions) == pytest.approx(rate, rel=1e-9)
    assert "no median" in refusal(median_at_rate, power_law(), 0.3, 1e9, kind=ValueError)


def test_draws_of_scaled_motions_are_those_of_a_normal_sample():
    """With n independent capacities β²(n − 1)/n is unbiased for what is drawn, and ln θ has Student's distribution."""
    sample = replace(fragility(median=3.0, dispersion=0.4), independent=12.0)
    medians, dispersions = sample.draws()
    share = kstest(12.0 * 0.4**2 / dispersions**2, chi2(11.0).cdf).pvalue
    assert share > 0.01
    scaled = np.log(medians / 3.0) / (0.4 * np.sqrt(12.0 / 11.0) / np.sqrt(12.0))
    assert kstest(scaled, student(11.0).cdf).pvalue > 0.01
    assert len(replace(sample, se_median=np.nan, se_median_recordings=np.nan).draws()[0]) == 0


@pytest.mark.parametrize(("recordings", "degrees"), [(100, 8.0), (5, 4.0), (2, 1.0)])
def test_draws_of_other_fits_have_the_degrees_of_freedom_of_their_error_or_recordings(recordings, degrees):
    """An error of β/√(2ν) is that of ν degrees; ln θ then has Student's distribution about its estimate."""
    sample = fragility(dispersion=0.4, recordings=recordings, se_median=0.1, se_dispersion=0.1)
    medians, dispersions = sample.draws()
    wider = dispersions / 0.4
    assert kstest((degrees + 1.0) / wider**2, chi2(degrees).cdf).pvalue > 0.01
    share = np.sqrt((degrees + 1.0) / degrees)
    assert kstest(np.log(medians / 3.0) / (0.1 * share), student(degrees).cdf).pvalue > 0.01


@pytest.mark.complete
@pytest.mark.parametrize(("method", "recordings"), [("ida", 6), ("ida", 10), ("stripes", 10), ("cloud", 10)])
def test_bounds_of_a_rate_hold_the_true_one(method, recordings):
    """Of 300 ensembles of two motions a recording, ρ = 0.8: 2.5 % may miss on a side, and 3 deviations of that count.

    The lower bound, on the safe side, may be missed twice as often: the β of a cloud is not biased low.
    """
    rng, hazard, repeats = np.random.default_rng(20110314), power_law(), 300
    who, median, dispersion = np.repeat(np.arange(recordings), 2), 4.0, 0.5
    truth = float(annual_rate(hazard, median, dispersion))
    held, missed = 0, np.zeros(2)
    while held < repeats:
        common, own = rng.standard_normal(recordings)[who], rng.standard_normal(who.size)
        capacities = median * np.exp(dispersion * (np.sqrt(0.8) * common + np.sqrt(0.2) * own))
        levels = np.array([1.0, 2.0, 4.0, 8.0, 16.0])
        clouds = np.exp(rng.normal(np.log(0.8 * median), 0.5, recordings))[who][:, None]
        ims = clouds if method == "cloud" else np.tile(levels, (who.size, 1))
        fitted = METHODS[method].fit(Observed(ims, ims / capacities[:, None], who))
        if fitted.fault:  # no curve, and no bounds
            continue
        rate = rate_of(hazard, Fragility("contact", 0.02, None, None, "pga", method, **asdict(fitted)), 0.95)
        missed += rate.low > truth, rate.high < truth
        held += 1
    allowed = 0.025 + 3.0 * np.sqrt(0.025 * 0.975 / repeats)
    assert missed[1] / repeats <= allowed
    assert missed[0] / repeats <= allowed + 0.025


def test_no_fragility_no_rate():
    found = rate_of(power_law(), Fragility("yield", 0.0, 1e6, "linear", "pga", "", *[np.nan] * 7, "none", "", ()), 0.95)
    assert np.isnan(found.annual)
    assert found.fault == "none"


def test_a_table_is_read_with_its_unit(tmp_path):
    found = read_hazard(
        site_file(tmp_path, "# a site", "PGA [g], annual rate [1/year]", "0.1, 0.01", "0.2, 0.002", "", "0.4,3e-4")
    )
    assert found.im == pytest.approx(9.80665 * np.array([0.1, 0.2, 0.4]))
    assert found.rate == pytest.approx([0.01, 0.002, 3e-4])
    assert (found.name, found.source) == ("pga", "site.csv")


@pytest.mark.parametrize(
    "text",
    [
        "pga [g],rate\n0.1,0.01\n",
        "pga,rate\n0.1,0.01\n0.2,0.001\n",
        "pga [g],rate\n0.1,0.01\nx,0.001\n",
        "pga [mm],rate\n0.1,0.01\n0.2,0.001\n",
        "pga [g],rate\n0.1,0.01\n0.2\n",
        "pga [g],rate\n0.1,0.01\n0.2,0\n",
        "pga [g],rate\n0.1,0.01\n0.2,0.02\n",
        "pga [g],rate\n0.2,0.01\n\n0.1,0.001\n",
        "pga [g],probability\n0.1,0.5\n0.2,0.1\n",
        "pga [g],probability in 0 years\n0.1,0.5\n0.2,0.1\n",
        "pga [g],foo\n0.1,0.5\n0.2,0.1\n",
        "pga [g],rate [1/50 years]\n0.1,0.5\n0.2,0.1\n",
        "pga [g],return period [years]\n0.1,475\n0.2,95\n",
        "pga [g],return period [years]\n0.1,0\n0.2,95\n",
        "pga [g],return period [years]\n0.1,-5\n0.2,95\n",
        "pga [g],return period [years]\n0.1,10 %\n0.2,95\n",
        "pga [g],probability in 50 years\n0.1,0.1\n0.2,0.5\n",
        "pga [g],probability in 50 years\n0.1,1\n0.2,0.5\n",
        "pga [g],probability in 50 years\n0.1,0.5\n0.2,0\n",
        "pga [g],probability in 50 years\n0.1,50\n0.2,10\n",
        "pga [g],probability in 50 years [%]\n0.1,100\n0.2,10\n",
        "pgd [cm],annual rate\n0.1,0.1\n0.2,0.01\n",
        "pgv [g],annual rate\n0.1,0.1\n0.2,0.01\n",
        "sa_avg [g],annual rate\n0.1,0.1\n0.2,0.01\n",
        "annual rate,sa(1 s) [g],pgv [m/s]\n0.1,0.1,0.2\n0.01,0.2,0.4\n",
        "annual rate,pga\n0.1,0.1\n0.01,0.2\n",
        "annual rate,pga [g],sa [g]\n0.1,0.1,0.2\n0.01,0.2,0.4\n",
        "annual rate,sa(1 s) [g],sa(1 s) [g]\n0.1,0.1,0.2\n0.01,0.2,0.4\n",
        "annual rate,sa(1 s) [g],sa(2 s) [g]\n0.1,0.1,0.2\n0.01,0.2,0.2\n",
        'annual rate,sa(1 s) [g],"sa(2 s, 2 %) [g]"\n0.1,0.1,0.2\n0.01,0.2,0.4\n',
        "sa [g],rate at 1 s,foo\n0.1,0.1,0.2\n0.2,0.01,0.02\n",
        "sa [g],rate at x,rate at 1 s\n0.1,0.1,0.2\n0.2,0.01,0.02\n",
        "sa [g],rate at 1 s,annual probability at 2 s\n0.1,0.1,0.2\n0.2,0.01,0.02\n",
        "sa [g],rate at 1 s,rate at 2 s\n0.1,0.1,0.2\n0.2,0.01,\n",
        "sa [g],rate at 1 s,rate at 2 s\n0.1,0.1,0.2\n0.2,0.01,0.3\n",
        "sa [g],rate at 1 s,rate at 2 s\n0.1,0.1,1e-3\n0.2,0.01,1e-4\n",
        "sa [g],rate at 1 s,rate at 1 s\n0.1,0.1,0.2\n0.2,0.01,0.02\n",
        "sa,rate at 1 s,rate at 2 s\n0.1,0.1,0.2\n0.2,0.01,0.02\n",
        "period [s],475 years [g]\n1,0.1\n2,0.05\n",
        "period [s],475 years,10 years [g]\n1,0.1,0.01\n",
        "period [s],often [g],10 years [g]\n1,0.1,0.01\n",
        "period [s],475 years [g],10 years [g]\n1,0.1,0.2\n",
        "period [s],10 years [g],10 years [g]\n1,0.1,0.2\n",
        "period [s],10 years [g],475 years [g]\nx,0.1,0.2\n",
        "period [s],10 years [g],475 years [g]\n0,0.1,0.2\n",
        "pga [g],rate\n0.1,1_0\n0.2,0.001\n",
        "pga [g],rate\n1_0,0.1\n0.2,0.001\n",
        "pga [g],rate\n0.1,inf\n0.2,0.001\n",
        "pga [g],rate\n0.1,nan\n0.2,0.001\n",
        "pga [g],rate\n0.1,0.01\ninf,0.001\n",
        "pga [g],rate\n0.1,1 %\n0.2,0.001\n",
        pytest.param("pga [g],rate\n0.1," + 131_073 * "1" + "\n0.2,0.001\n", id="a long row"),
        pytest.param(131_073 * "p" + " [g],rate\n0.1,0.1\n0.2,0.001\n", id="a long head"),
    ],
)
def test_a_table_that_is_none_is_refused_by_its_line(tmp_path, text, says):
    told = refusal(read_hazard, written(tmp_path / "site.csv", text))
    says(told)
    assert len(told) < 1000  # what is damaged is shown shortened


FORMS = {
    "annual rate [1/year]": lambda rate: rate,
    "return period [years]": lambda rate: 1.0 / rate,
    "probability in 50 years": lambda rate: 1.0 - np.exp(-50.0 * rate),
    "probability of exceedance in 50 years [%]": lambda rate: 100.0 * (1.0 - np.exp(-50.0 * rate)),
    "PoE in 1 year": lambda rate: 1.0 - np.exp(-rate),
    "annual probability": lambda rate: 1.0 - np.exp(-rate),
}
CURVE = power_law(0.5, 20.0, 9)


@pytest.mark.parametrize("head", FORMS)
@pytest.mark.parametrize("rate_first", [False, True])
def test_one_hazard_in_all_forms_gives_the_same_rates(tmp_path, head, rate_first):
    """The closed forms are written out here; a table may start with either column."""
    rows = [[repr(float(im)), repr(float(FORMS[head](rate)))] for im, rate in zip(CURVE.im, CURVE.rate, strict=True)]
    table = [["pga [m/s^2]", head], *rows]
    text = "\n".join(",".join(row[::-1] if rate_first else row) for row in table)
    found = read_hazard(written(tmp_path / "site.csv", text))
    assert found.im.tolist() == CURVE.im.tolist()
    assert found.rate == pytest.approx(CURVE.rate, rel=1e-11)
    annual, known = (rate_of(hazard, fragility(), 0.95).annual for hazard in (found, CURVE))
    assert annual == pytest.approx(known, rel=1e-11)
    assert ("Poisson" in found.reading) == ("prob" in head.lower() or "poe" in head.lower())


def test_percentages_may_stand_in_the_cells(tmp_path):
    for head in ("probability in 50 years", "probability in 50 years [%]"):
        file = site_file(tmp_path, f"pga [g],{head}", "0.1,50 %", "0.2,10 %")
        assert read_hazard(file).rate == pytest.approx([np.log(2.0) / 50.0, -np.log(0.9) / 50.0])


PERIODS = (0.1, 0.4, 2.0)
UNIFORM = power_law(0.5, 20.0, 5)


def spectra_by_rate() -> str:
    """Sa = a(rate) T^-0.7, by return period: a straight line in the logarithms, so that interpolation is exact."""
    heads = ["return period [years]", "pga [m/s^2]", *(f"sa({period} s) [m/s^2]" for period in PERIODS)]
    rows = [
        [1.0 / rate, 0.4 * im, *(im * period**-0.7 for period in PERIODS)]
        for im, rate in zip(UNIFORM.im, UNIFORM.rate, strict=True)
    ]
    return "\n".join([",".join(heads), *(",".join(repr(float(value)) for value in row) for row in rows)])


def spectra_by_period() -> str:
    """The same, a row for each period; the columns in another order, and one of them a probability."""
    rates = UNIFORM.rate[[2, 0, 1, 3, 4]]
    words = [f"{1.0 / rate!r} years [m/s^2]" for rate in rates.tolist()]
    words[1] = f"{100.0 * (1.0 - np.exp(-50.0 * rates[1])):.15g} % in 50 years [m/s^2]"
    rows = [["0", *(0.4 * UNIFORM.im[[2, 0, 1, 3, 4]]).tolist()]]
    rows += [[period, *(UNIFORM.im[[2, 0, 1, 3, 4]] * period**-0.7).tolist()] for period in PERIODS[::-1]]
    return "\n".join([",".join(["period [s]", *words]), *(",".join(map(str, row)) for row in rows)])


def curves_by_period() -> str:
    """Curves of the same spectra over common intensities: λ = k₀ (im T^0.7)^−k, as probabilities in %."""
    im = np.geomspace(0.05, 80.0, 40)
    curves = [K0 * (im * period**0.7) ** -K for period in PERIODS] + [K0 * (im / 0.4) ** -K]
    heads = [f"PoE in 50 years at {name} [%]" for name in (*(f"{period} s" for period in PERIODS), "PGA")]
    chances = 100.0 * -np.expm1(-50.0 * np.array(curves))
    # Probabilities near 1 keep no digits of a rate: such cells are left empty, as are the rarest ones.
    cells = [[repr(float(chance)) if 1e-4 < chance < 90.0 else "" for chance in row] for row in chances.T]
    rows = [[repr(float(x)), *row] for x, row in zip(im, cells, strict=True)]
    return "\n".join([",".join(["sa [m/s^2]", *heads]), *(",".join(row) for row in rows)])


@pytest.mark.parametrize("period", [0.1, 0.25, 0.4, 1.3, 2.0])
def test_curves_at_several_periods_are_spectra_at_their_common_rates(tmp_path, period):
    spectra = read_hazard(written(tmp_path / "curves.csv", curves_by_period()))
    for found, scale in ((spectra.at(f"sa({period} s)"), period**-0.7), (spectra.at("pga"), 0.4)):
        assert found.rate == pytest.approx(K0 * (found.im / scale) ** -K, rel=1e-9)
        assert found.rate.size > 20
        # No curve is continued: the longest period's is the lowest, the shortest one's the highest.
        assert found.rate[0] <= -np.log(0.1) / 50.0 and found.rate[-1] >= 1e-6 / 50.0
    assert "Poisson" in found.reading


def test_a_curve_of_the_table_is_not_cut_by_those_beside_it(tmp_path):
    text = "sa [g],annual rate at PGA,annual rate at 1 s\n0.05,0.1,0.2\n0.2,0.01,0.02\n0.4,,0.004\n1,,0.0005\n"
    spectra = read_hazard(written(tmp_path / "curves.csv", text))
    whole = spectra.at("sa(1 s)")
    assert whole.im == pytest.approx(G * np.array([0.05, 0.2, 0.4, 1.0]))
    assert whole.rate.tolist() == [0.2, 0.02, 0.004, 0.0005]
    assert spectra.at("pga").rate.tolist() == [0.1, 0.01]


@pytest.mark.parametrize("text", [spectra_by_rate(), spectra_by_period()])
@pytest.mark.parametrize("period", [0.1, 0.25, 0.4, 1.3, 2.0])
def test_a_curve_between_the_periods_of_spectra_is_that_of_the_power(tmp_path, text, period):
    spectra = read_hazard(written(tmp_path / "uniform.csv", text))
    assert isinstance(spectra, HazardSpectrum)
    found = spectra.at(f"sa({period} s)")
    assert found.im == pytest.approx(UNIFORM.im * period**-0.7, rel=1e-12)
    assert found.rate == pytest.approx(UNIFORM.rate, rel=1e-9)
    assert found.name == f"sa({period} s)"
    assert ("is read between" in found.reading) == (period not in PERIODS)
    assert spectra.at("pga").im == pytest.approx(0.4 * UNIFORM.im)


def test_one_curve_may_name_its_period_beside_its_rate(tmp_path):
    file = site_file(tmp_path, "sa [g],annual rate at 0.2 s [1/year]", "0.1,0.01", "0.2,0.001")
    assert read_hazard(file).at("sa(0.2 s)").im == pytest.approx(G * np.array([0.1, 0.2]))
    assert read_hazard(site_file(tmp_path, "pga [g],annual rate at the site")).name == "pga"


def test_spectra_between_periods_need_not_be_a_power(tmp_path):
    """At a third of the way, in the logarithms, from 0.2 s to 1.6 s: the intensities there too, at each rate."""
    text = "annual rate,sa(0.2 s) [m/s^2],sa(1.6 s) [m/s^2]\n1e-2,1,8\n1e-3,2,16\n1e-4,27,64\n"
    found = read_hazard(written(tmp_path / "uniform.csv", text)).at("sa(0.4 s)")
    assert found.im == pytest.approx([2.0, 4.0, 36.0])
    assert "between 0.2 s and 1.6 s" in found.reading


@pytest.mark.parametrize("intensity", ["sa(0.05 s)", "sa(2.5 s)", "sa(0.4 s, 2 %)", "pgv"])
def test_spectra_are_not_continued(tmp_path, intensity, says):
    says(refusal(read_hazard(written(tmp_path / "uniform.csv", spectra_by_rate())).at, intensity))


def test_spectra_of_another_damping_say_so(tmp_path, says):
    text = 'annual rate,"sa(0.2 s, 2 %) [g]","sa(1 s, 2 %) [g]"\n1e-2,1,2\n1e-3,2,3\n'
    spectra = read_hazard(written(tmp_path / "uniform.csv", text))
    assert spectra.damping == pytest.approx(0.02)
    assert spectra.at("sa(0.2 s, 2 %)").im == pytest.approx(G * np.array([1.0, 2.0]))
    says(refusal(spectra.at, "sa(0.2 s)"))


@pytest.mark.parametrize(
    "head", ["annual rate [1/year]", "Mean annual frequency of exceedance", "rate [1/yr]", "annual rate [yr^-1]"]
)
def test_an_annual_rate_goes_by_several_names(tmp_path, head):
    assert read_hazard(site_file(tmp_path, f"pga [g],{head}")).rate == pytest.approx([1.0, 1e-6])


def test_a_table_that_is_not_there_is_refused(tmp_path, says):
    says(refusal(read_hazard, tmp_path / "none.csv"))


@pytest.mark.parametrize(
    ("im", "rate", "words"),
    [
        ([0.5, 2.0, 8.0], [0.05, 6e-3, 2e-4], "has 6.01 g once in 2,475 years"),
        ([0.05, 0.2, 0.8], [50.0, 6.0, 0.2], "has 0.05 g or more 50 times a year"),
        ([0.01, 0.2, 3.0], [5.0, 0.01, 1e-6], ""),
        ([0.01, 0.5, 10.0], [0.1, 4e-3, 1e-9], ""),  # a grid of intensities that goes far, as programs write it
    ],
)
def test_an_unusual_curve_is_told(im, rate, words):
    """In g and a year; often at 0.01 g is usual."""
    told = unusual(Hazard("pga", 9.80665 * np.array(im), np.array(rate), "haz.csv"))
    assert len(told) == bool(words) and all(words in sentence and "haz.csv" in sentence for sentence in told)


def test_a_curve_from_which_no_rate_follows_is_told_at_the_top():
    """Buildings that yield, at one PGA: neither several intensities nor motions that may be scaled."""
    sides = (storeyed(name, ["250 t"], ["30 MN/m"], ["3 m"], storey_strengths=["400 kN"]) for name in ("A", "B"))
    records = {"names": ["RSN6-180", "RSN6-270"], "window": ["0 s", "6 s"], "pga": "0.3 g"}
    results = scan(parse_scene(scene_text(*sides, records=records, effects={"inelastic_storeys": {}})))
    curve = Hazard("pga", 9.80665 * np.array([0.05, 0.3, 0.9]), np.array([0.1, 0.01, 1e-3]), "haz.csv")
    (note,) = (one for one in assess(results, hazard=curve).notes if "hazard curve" in one)
    assert note.startswith("hazard curve haz.csv: no annual rate of contact follows: all motions have one intensity")


YEARS = 50.0
HEAD = "#,,,,\"generated_by='OpenQuake engine 3.15.0', checksum=7, kind='mean', investigation_time=50.0, imt='{imt}'\""
OLDER = '# mean, investigation_time=50.0,imt="{imt}"'
LEVELS = (0.05, 0.1, 0.2, 0.4)
SITES = ((23.7, 38.0), (23.8, 38.1))


def poe(level: float, k0: float = 1e-4) -> float:
    """Probability of exceedance in the years of the file, of a rate k0 level^-2."""
    return float(-np.expm1(-YEARS * k0 * level**-2))


def curve_file(folder: Path, imt: str = "PGA", head: str = HEAD, factors: tuple[float, ...] = (1.0, 2.0)) -> Path:
    lines = [head.format(imt=imt), "lon,lat,depth," + ",".join(f"poe-{level:.7f}" for level in LEVELS)]
    for (longitude, latitude), factor in zip(SITES, factors, strict=False):
        poes = ",".join(f"{poe(level, factor * 1e-4):.9E}" for level in LEVELS)
        lines.append(f"{longitude:.5f},{latitude:.5f},0.00000,{poes}")
    path = folder / f"hazard_curve-mean-{imt}_12.csv"
    path.write_text("\n".join(lines) + "\n")
    return path


@pytest.mark.parametrize("head", [HEAD, OLDER])
@pytest.mark.parametrize(
    ("imt", "name", "unit"), [("PGA", "pga", G), ("SA(0.5)", "sa(0.5 s)", G), ("PGV", "pgv", 0.01)]
)
def test_a_curve_has_the_rates_of_its_probabilities(tmp_path, head, imt, name, unit):
    path = curve_file(tmp_path, imt, head)
    hazard = read_hazard(f"{path}#23.79,38.11")
    assert isinstance(hazard, Hazard) and hazard.name == name
    np.testing.assert_allclose(hazard.im, unit * np.array(LEVELS), rtol=1e-12)
    np.testing.assert_allclose(hazard.rate, 2e-4 * np.array(LEVELS) ** -2, rtol=1e-6)
    assert hazard.source == f"{path.name}#23.79,38.11"
    assert "23.8, 38.1, 1.41 km from 23.79, 38.11" in hazard.reading and "-ln(1 - p)/50" in hazard.reading


def test_one_site_needs_no_name_and_several_need_one(tmp_path, says):
    assert "The site is at 23.7, 38." in read_hazard(curve_file(tmp_path, factors=(1.0,))).reading
    says(refusal(read_hazard, curve_file(tmp_path)))


def test_a_site_too_far_is_refused_unless_it_is_allowed(tmp_path, says):
    path = curve_file(tmp_path)
    says(refusal(read_hazard, f"{path}#24.2,38.3"))
    assert read_hazard(f"{path}#24.2,38.3 within 50 km").rate[0] == pytest.approx(2e-4 / 0.05**2, rel=1e-6)
    says(refusal(read_hazard, f"{path}#38.0,123.7"), refusal(read_hazard, f"{path}#Athens"))


def test_a_pattern_joins_curves_of_several_periods(tmp_path, says):
    for imt in ("PGA", "SA(0.5)", "SA(1.0)"):
        curve_file(tmp_path, imt)
    hazard = read_hazard(f"{tmp_path}/hazard_curve-mean-*.csv#23.7,38")
    assert isinstance(hazard, HazardSpectrum) and hazard.periods.tolist() == [0.5, 1.0]
    half = hazard.at("sa(0.7 s)")  # equal curves at both periods
    level = np.exp(np.interp(np.log(3e-3), np.log(half.rate[::-1]), np.log(half.im[::-1])))
    assert level == pytest.approx(G * (1e-4 / 3e-3) ** 0.5, rel=1e-6)
    curve_file(tmp_path, "SA(2.0)", HEAD.replace("=50.0", "=1.0"))
    says(refusal(read_hazard, f"{tmp_path}/hazard_curve-mean-*.csv#23.7,38"))


def test_probabilities_of_0_and_1_and_repeated_ones_are_left_out_and_told(tmp_path):
    path = tmp_path / "curve.csv"
    columns = "lon,lat,depth," + ",".join(f"poe-{level}" for level in (0.01, 0.02, 0.05, 0.1, 0.2, 0.4))
    path.write_text(f"{OLDER.format(imt='PGA')}\n{columns}\n0,0,0,1.0,0.9,0.5,0.5,0.1,0\n")
    hazard = read_hazard(path)
    np.testing.assert_allclose(hazard.im / G, [0.02, 0.1, 0.2])
    assert "2 levels of pga with a probability of 0 or 1 left out." in hazard.reading
    assert "1 level of pga left out, exceeded as often as the next one." in hazard.reading


def test_uniform_hazard_spectra(tmp_path, says):
    path = tmp_path / "hazard_uhs-mean_3.csv"
    head = "lon,lat,0.1~PGA,0.1~SA(0.2),0.1~SA(1.0),0.02~PGA,0.02~SA(0.2),0.02~SA(1.0)"
    path.write_text(f"# mean, investigation_time=50.0\n{head}\n23.7,38.0,0.1,0.25,0.1,0.2,0.5,0.2\n")
    hazard = read_hazard(path)
    np.testing.assert_allclose(1.0 / hazard.rate, [474.56, 2474.9], rtol=1e-4)
    np.testing.assert_allclose(hazard.at("sa(0.2 s)").im, [0.25 * G, 0.5 * G])
    np.testing.assert_allclose(hazard.at("pga").im, [0.1 * G, 0.2 * G])
    assert "uniform hazard spectra" in hazard.reading
    path.write_text("# mean, investigation_time=50.0\nlon,lat,0.1~PGA,0.02~PGA\n23.7,38.0,0.2,0.2\n")
    says(refusal(read_hazard, path))


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("investigation_time=50.0", "x=1"),
        ("imt='PGA'", "imt='AvgSA'"),
        ("imt='PGA'", "imt='\x1b[31mAvgSA'"),
        ("poe-0.1000000", "poe-0.0100000"),
        ("23.70000", "x"),
        ("poe-", "PGA-"),
    ],
)
def test_a_damaged_file_is_refused(tmp_path, old, new, says):
    path = curve_file(tmp_path)
    path.write_text(path.read_text().replace(old, new))
    says(refusal(read_hazard, f"{path}#23.7,38.0"))


def test_damaged_files_are_read_soundly_or_refused_by_name(tmp_path):
    path = curve_file(tmp_path)

    def check(hazard):
        assert np.isfinite(hazard.rate).all() and (np.diff(hazard.rate) < 0).all() and (np.diff(hazard.im) > 0).all()

    outcomes = survey(path, lambda: read_hazard(f"{path}#23.7,38.0"), check)
    assert min(outcomes["read"], outcomes["refused"]) > 200


GAP = 0.02
RECORDS = ["RSN6-180", "RSN77-164", "RSN753-000", "RSN1690-090", "CCC-HN1", "NAPA-HNE"]
RATES = "pgv [cm/s],annual rate [1/year]\n2,0.2\n10,0.02\n40,0.001\n160,0.00002\n"


def scanned(**records) -> xr.Dataset:
    text = scene_text(
        single("left", "10 t", "0.6 s"),
        single("right", "20 t", "0.3 s"),
        records={"names": RECORDS, "window": ["0 s", "15 s"], **records},
        grid={"gap": ["20 mm"], "yield_force": ["100 kN"]},
        law="linear",
        gap="20 mm",
        yield_force="100 kN",
    )
    return pr.scan(parse_scene(text, "scene.toml"), check_fraction=0.0)


@pytest.fixture(scope="module")
def along_pgv() -> xr.Dataset:
    return scanned(intensity={"measure": "pgv", "levels": ["5 cm/s", "15 cm/s", "30 cm/s"]})


@pytest.fixture(scope="module")
def eightfold() -> xr.Dataset:
    """Strong enough that the gap is closed by motions scaled within the usual factors."""
    return scanned(scale=8.0)


def contact(dataset: xr.Dataset, **options):
    (interface,) = pr.assess(dataset, **options).interfaces
    return next(curve for curve in interface.fragility if curve.what == "contact" and curve.gap == GAP)


def test_the_median_is_the_mean_capacity_in_m_per_s(along_pgv, eightfold):
    """Linear: each motion closes the gap at its PGV times gap over closing, the PGV integrated here."""
    capacities = []
    for name in RECORDS:
        motion = read_motion(name).cut("0 s", "15 s")
        fast = 8.0 * np.abs(cumulative_trapezoid(motion.acceleration, dx=motion.dt)).max()
        capacities.append(fast * GAP / float(eightfold["peak_closing_free"].sel(record=name).max()))
    logs = np.log(capacities)
    curve = contact(along_pgv)
    assert (curve.intensity, curve.unit, curve.method) == ("pgv", "m/s", curves.SCALED)
    assert curve.median == pytest.approx(np.exp(logs.mean()), rel=1e-3)  # the local maximum lies between samples
    assert curve.dispersion == pytest.approx(logs.std(), rel=1e-2)
    again = contact(eightfold, intensity="pgv")
    assert again.median == pytest.approx(curve.median, rel=1e-9)
    assert again.dispersion == pytest.approx(curve.dispersion, rel=1e-9)


def test_yielding_is_counted_at_the_levels(along_pgv):
    (interface,) = pr.assess(along_pgv).interfaces
    curve = next(curve for curve in interface.fragility if curve.what == "yield")
    assert curve.method == curves.STRIPES
    assert [stripe.im for stripe in curve.stripes] == [0.05, 0.15, 0.3]
    assert [stripe.runs for stripe in curve.stripes] == [6, 6, 6]


def test_sentences_have_the_unit_of_the_measure(along_pgv):
    alone = contact(along_pgv.isel(intensity=0), intensity="pgv")
    assert alone.stripes[0].im == 0.05
    fitted = fit(np.full(4, 0.05), np.array([True, False, True, False]), np.arange(4), curves.shown_as("pgv"))
    assert "all motions have one intensity, 5 cm/s" in fitted.fault


def test_a_hazard_of_pgv_gives_the_rate(along_pgv, tmp_path):
    """∫ P(contact) |dλ| summed over a fine grid of the curve, straight in the logarithms, and what is stronger."""
    table = written(tmp_path / "pgv.csv", RATES)
    hazard = read_hazard(table)
    assert hazard.name == "pgv"
    assert hazard.im == pytest.approx([0.02, 0.1, 0.4, 1.6])
    (interface,) = pr.assess(along_pgv, hazard=table).interfaces
    rate = next(rate for rate in interface.rates if rate.what == "contact")
    curve = contact(along_pgv)
    im = np.geomspace(0.02, 1.6, 20001)
    rates = np.exp(np.interp(np.log(im), np.log(hazard.im), np.log(hazard.rate)))
    middle = np.sqrt(im[1:] * im[:-1])
    expected = (norm.cdf(np.log(middle / curve.median) / curve.dispersion) * -np.diff(rates)).sum()
    expected += norm.cdf(np.log(1.6 / curve.median) / curve.dispersion) * hazard.rate[-1]
    assert rate.annual == pytest.approx(expected, rel=1e-5)


def test_a_hazard_of_mean_sa_is_joined_with_the_same_range(eightfold, tmp_path, says):
    table = written(tmp_path / "avg.csv", "sa_avg(0.2 s-1 s) [g],annual rate [1/year]\n0.02,0.1\n0.2,0.01\n2,0.0001\n")
    assessment = pr.assess(eightfold, hazard=table)
    assert assessment.intensity == "sa_avg(0.2-1 s)"
    assert next(rate for rate in assessment.interfaces[0].rates if rate.what == "contact").annual > 0.0
    says(refusal(pr.assess, eightfold, hazard=table, intensity="sa_avg(0.2-2 s)"))


def test_a_hazard_of_another_measure_is_refused(eightfold, says):
    curves = {"pgv": "pga", "pga": "pgv", "sa(0.5 s)": "sa_avg(0.2-2 s)", "sa_avg(0.2-2 s)": "sa(0.5 s)"}
    pairs = [*curves.items(), *(("sa(left)", curve) for curve in ("sa(1.0 s)", "sabotage", "pga"))]
    says([refusal(check_intensity, Results(eightfold), *pair) for pair in pairs])


def test_the_mean_of_sa_is_that_of_the_spectra(eightfold):
    """Ten periods evenly in the logarithm, each between those of the spectrum by straight lines in the logarithms."""
    spectra = eightfold["record_spectral_acceleration"].values
    logs = np.log(eightfold["period"].values)
    periods = np.log(0.2) + np.log(5.0) * np.arange(10) / 9.0
    expected = [np.exp(np.mean(np.interp(periods, logs, np.log(row)))) for row in spectra]
    values = pr.assess(eightfold, intensity="sa_avg(0.2-1 s)").interfaces[0].fragility[0].stripes
    np.testing.assert_allclose([stripe.im for stripe in values], np.sort(expected), rtol=1e-12)
