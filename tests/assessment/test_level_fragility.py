"""Fragility and rates against levels of intensity: PGV and mean Sa, in their own units and with their own hazard."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from made_hazard import written
from scenes import scene_text, single
from scipy.integrate import cumulative_trapezoid
from scipy.stats import norm
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment import fragility as curves
from pounding_risk.assessment.hazard_table import read_hazard
from pounding_risk.assessment.intensities import check_intensity
from pounding_risk.motions.read import read_motion
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene
from pounding_risk.statistics.fragility import fit

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
