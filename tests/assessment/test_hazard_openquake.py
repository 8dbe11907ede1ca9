"""Hazard as OpenQuake exports it: rates of a site against the closed form, sites, several files, damaged files."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from damaged_tables import survey
from sentences import refusal

from pounding_risk.assessment.hazard import Hazard, HazardSpectrum
from pounding_risk.assessment.hazard_table import read_hazard

G = 9.80665
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
