"""Annual rates against Cornell's closed form, and hazard tables that cannot be used."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad
from scipy.stats import norm

from pounding_risk.assessment.fragility import Fragility
from pounding_risk.assessment.hazard import Hazard, annual_rate, in_years, missing_share, rate_of
from pounding_risk.assessment.hazard_table import read_hazard
from pounding_risk.errors import PoundingError

K0, K = 2e-3, 2.5


def power_law(low: float = 1e-3, high: float = 1e3, rows: int = 25) -> Hazard:
    im = np.geomspace(low, high, rows)
    return Hazard("pga", im, K0 * im**-K)


def curve(median: float = 3.0, dispersion: float = 0.4, **more: float) -> Fragility:
    errors = {"se_median": 0.1, "se_dispersion": 0.05} | more
    by_recording = {f"{name}_recordings": value for name, value in errors.items()}
    about = ("contact", 0.02, None, None, "pga", "multiple stripes", median, dispersion)
    return Fragility(*about, **errors, **by_recording, correlation=0.0, fault="", note="", stripes=())


def _density(im: float) -> float:
    return float(norm.cdf(np.log(im / 3.0) / 0.4)) * K0 * K * im ** (-K - 1.0)


@pytest.mark.parametrize("dispersion", [0.05, 0.3, 0.6])
def test_a_power_law_gives_cornells_closed_form(dispersion):
    """k₀ θ^−k exp(k²β²/2) but for what the table cuts off above, λ(1000) / λ(3) = 5e-7, and rounding."""
    known = K0 * 3.0**-K * np.exp(0.5 * (K * dispersion) ** 2)
    assert float(annual_rate(power_law(), 3.0, dispersion)) == pytest.approx(known, rel=1e-6)


def test_a_sharp_fragility_reads_the_hazard_curve():
    """β → 0 leaves λ(θ), between rows too, less what the table cuts off: straight lines in the logarithms."""
    hazard = Hazard("pga", np.array([1.0, 4.0]), np.array([1e-2, 1e-4]))
    assert float(annual_rate(hazard, 2.0, 1e-4)) == pytest.approx(1e-3 - 1e-4, rel=1e-6)  # exp(k²β²/2) = 1 + 6e-8


def test_extreme_numbers_stay_finite():
    """A steep hazard and a wide fragility, whose exp(k²β²/2) is beyond all numbers: at most λ at the start."""
    steep = Hazard("pga", np.array([1.0, 2.0]), np.array([1e-2, 1e-6]))
    rate = annual_rate(steep, np.array([1.5, 1e-3, 1e3]), np.array([6.0, 0.01, 0.01]))
    assert ((rate >= 0.0) & (rate <= 1e-2)).all()
    assert rate[1] == pytest.approx(1e-2 - 1e-6)  # all fail
    assert rate[2] == 0.0


def test_fifty_years_are_poisson():
    assert in_years(1.0 / 475.0) == pytest.approx(0.10, abs=1e-4)
    assert in_years(1e-12) == pytest.approx(5e-11)


def test_what_the_table_cuts_off_is_told():
    """Only intensities of the table count: the rate there, P at its weakest, and what stronger ones add at most."""
    whole, cut = (rate_of(power_law(*ends), curve(), 0.95) for ends in ((1e-3, 1e3), (3.0, 12.0)))
    assert cut.below == pytest.approx(0.5)
    assert cut.above == pytest.approx(K0 * 12.0**-K)
    assert cut.annual < whole.annual
    missing = whole.annual - cut.annual
    # Both by SciPy's quadrature of the same integral beyond the table's ends.
    beyond = sum(quad(_density, *ends, epsabs=1e-14)[0] for ends in ((0.1, 3.0), (12.0, 1e3)))
    assert missing == pytest.approx(beyond, rel=1e-5)  # 1e3 to infinity is 3e-7 of it


def test_the_share_that_a_table_leaves_out_is_what_its_slopes_continue_to():
    """Of a power law nothing is guessed: the share is that of SciPy's quadrature beyond the table's ends."""
    cut = rate_of(power_law(3.0, 12.0), curve(), 0.95)
    beyond = sum(quad(_density, *ends, epsabs=1e-16)[0] for ends in ((0.1, 3.0), (12.0, np.inf)))
    assert cut.missing == pytest.approx(beyond / (beyond + cut.annual), rel=1e-6)
    assert cut.at_least
    whole = rate_of(power_law(), curve(), 0.95)
    assert whole.missing < 1e-6 and not whole.at_least


@pytest.mark.parametrize(("ends", "side"), [((1e-3, 3.0), "above"), ((3.0, 1e3), "below")])
def test_a_curve_that_ends_on_one_side_alone_is_told(ends, side):
    """Rows up to the median, or from it on: the other side is what is left out."""
    cut = rate_of(power_law(*ends), curve(), 0.95)
    limits = (3.0, np.inf) if side == "above" else (0.1, 3.0)
    beyond = quad(_density, *limits, epsabs=1e-16)[0]
    assert cut.missing == pytest.approx(beyond / (beyond + cut.annual), rel=1e-5)
    assert cut.at_least


def test_steep_and_wide_ends_stay_a_share():
    steep = Hazard("pga", np.array([1.0, 2.0]), np.array([1e-2, 1e-6]))
    for median, dispersion in ((1.5, 6.0), (1e-3, 0.01), (1e3, 0.01), (1e3, 9.0)):
        found = missing_share(steep, median, dispersion)
        assert 0.0 <= found <= 1.0


def test_bounds_follow_the_fragilitys_errors():
    """No error, no width; an error of ln θ alone moves the rate by exp(−k z σ), its quantiles by simulation 400."""
    narrow = rate_of(power_law(), curve(se_median=0.0, se_dispersion=0.0), 0.95)
    assert (narrow.low, narrow.high) == pytest.approx((narrow.annual, narrow.annual))
    wide = rate_of(power_law(), curve(se_median=0.2, se_dispersion=0.0), 0.95)
    assert wide.high / wide.annual == pytest.approx(np.exp(K * 1.96 * 0.2), rel=0.2)  # of 400 draws
    assert wide.low / wide.annual == pytest.approx(np.exp(-K * 1.96 * 0.2), rel=0.2)


def test_no_fragility_no_rate():
    found = rate_of(power_law(), Fragility("yield", 0.0, 1e6, "linear", "pga", "", *[np.nan] * 7, "none", "", ()), 0.95)
    assert np.isnan(found.annual)
    assert found.fault == "none"


def test_a_table_is_read_with_its_unit(tmp_path):
    file = tmp_path / "site.csv"
    file.write_text("# a site\nPGA [g], annual rate [1/year]\n0.1, 0.01\n0.2, 0.002\n\n0.4,3e-4\n")
    found = read_hazard(file)
    assert found.im == pytest.approx(9.80665 * np.array([0.1, 0.2, 0.4]))
    assert found.rate == pytest.approx([0.01, 0.002, 3e-4])
    assert (found.name, found.source) == ("pga", "site.csv")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("pga [g],rate\n0.1,0.01\n", "1 rows below its head"),
        ("pga,rate\n0.1,0.01\n0.2,0.001\n", "line 1: 'pga,rate' names no intensity with its unit"),
        ("pga [g],rate\n0.1,0.01\nx,0.001\n", "line 3: 'x,0.001' is no row"),
        ("pga [mm],rate\n0.1,0.01\n0.2,0.001\n", "line 2"),
        ("pga [g],rate\n0.1,0.01\n0.2\n", "line 3"),
        ("pga [g],rate\n0.1,0.01\n0.2,0\n", "an annual rate must be greater than 0 and finite"),
        ("pga [g],rate\n0.1,0.01\n0.2,0.02\n", "line 3: intensities must rise and annual rates fall"),
        ("pga [g],rate\n0.2,0.01\n\n0.1,0.001\n", "line 4: intensities must rise"),
        ("pga [g],probability in 50 years\n0.1,0.5\n0.2,0.1\n", "line 1: the second column is 'probability in 50 y"),
        ("pga [g],return period [years]\n0.1,50\n0.2,475\n", "a return period T one of 1 / T"),
        ("pga [g],rate [1/50 years]\n0.1,0.5\n0.2,0.1\n", "it must be an annual rate or frequency"),
        ("pga [g],rate\n0.1,1_0\n0.2,0.001\n", "line 2: '0.1,1_0' is no row of the table (\"1_0\" has a unit"),
        ("pga [g],rate\n1_0,0.1\n0.2,0.001\n", "line 2: '1_0,0.1' is no row of the table"),
        ("pga [g],rate\n0.1,inf\n0.2,0.001\n", "an annual rate must be greater than 0 and finite"),
        ("pga [g],rate\n0.1,nan\n0.2,0.001\n", '"nan" is not a number'),
        ("pga [g],rate\n0.1,0.01\ninf,0.001\n", "line 3: 'inf,0.001' is no row of the table"),
        ("pga [g],rate\n0.1,1 %\n0.2,0.001\n", "line 2: '0.1,1 %' has a percentage; write a number a year"),
        (
            "pga [g],rate\n0.1," + 131_073 * "1" + "\n0.2,0.001\n",
            "line 2: has 131,077 letters, and a row is two numbers",
        ),
        (131_073 * "p" + " [g],rate\n0.1,0.1\n0.2,0.001\n", "line 1: has 131,082 letters"),
        ("pga [g],rate\n0.1,0.01,0.02\n0.2,0.001,0.002\n", "line 2: '0.1,0.01,0.02' has 3 cells"),
    ],
)
def test_a_table_that_is_none_is_refused_by_its_line(tmp_path, text, words):
    file = tmp_path / "site.csv"
    file.write_text(text)
    with pytest.raises(PoundingError, match=r"site\.csv") as told:
        read_hazard(file)
    assert words in str(told.value)
    assert len(str(told.value)) < 1000  # what is damaged is shown shortened


@pytest.mark.parametrize(
    "head", ["annual rate [1/year]", "Mean annual frequency of exceedance", "rate [1/yr]", "annual rate [yr^-1]"]
)
def test_an_annual_rate_goes_by_several_names(tmp_path, head):
    file = tmp_path / "site.csv"
    file.write_text(f"pga [g],{head}\n0.1,0.01\n0.2,0.001\n")
    assert read_hazard(file).rate == pytest.approx([0.01, 0.001])


def test_a_table_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(PoundingError, match="cannot be read"):
        read_hazard(tmp_path / "none.csv")
