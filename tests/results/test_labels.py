"""What a scan's dataset says beside its runs: the gap each motion needs, spectra, buildings, the command."""

import json
import re
import sys

import commands
import numpy as np
import pytest
from processes import output
from scenes import two_records
from scipy.integrate import solve_ivp

from pounding_risk.ensemble.scan import scan
from pounding_risk.motions import catalogue, record_sets
from pounding_risk.motions.read import read_motion
from pounding_risk.results.files import open_results
from pounding_risk.results.labels import PERIODS
from pounding_risk.scene.reader import parse_scene

SCENE = two_records().replace('"8 s"', '"5 s"')


@pytest.fixture(scope="module")
def dataset():
    return scan(parse_scene(SCENE), check_fraction=0.0)


def test_contact_is_where_the_gap_is_smaller_than_the_motion_needs(dataset):
    """Both come from one free response, so that they agree in every case, screened or run."""
    needed = dataset["peak_closing_free"]
    assert needed.dims == ("record", "polarity", "pga", "interface")
    touches = dataset["impact_count"].isel(contact_model=0, yield_force=0) > 0
    assert (touches == (dataset["gap"] < needed)).all()
    assert 0 < int(touches.sum()) < touches.size


def test_the_gap_needed_is_that_of_two_oscillators(dataset):
    """Against SciPy, both oscillators in one system, 80 looks a sample: what those miss is 1e-5."""
    motion = read_motion("RSN6-180", window=(0.0, 5.0), pga=0.1 * 9.80665)
    omega, damping = 2.0 * np.pi / np.array([0.5, 0.3]), np.array([0.05, 0.02])

    def slope(time, state):
        ground = np.interp(time, motion.times, motion.acceleration)
        return np.append(state[2:], -ground - 2.0 * damping * omega * state[2:] - omega**2 * state[:2])

    times = np.linspace(0.0, motion.duration, 80 * (len(motion.acceleration) - 1) + 1)
    found = solve_ivp(slope, (0.0, times[-1]), np.zeros(4), "DOP853", times, rtol=1e-8, atol=1e-10, max_step=motion.dt)
    parting = found.y[0] - found.y[1]
    place = {"record": "RSN6-180", "pga": 0.1 * 9.80665}
    needed = dataset["peak_closing_free"].sel(place, method=None).squeeze("interface")
    assert float(needed.sel(polarity="as recorded")) == pytest.approx(parting.max(), rel=1e-5)
    assert float(needed.sel(polarity="reversed")) == pytest.approx(-parting.min(), rel=1e-5)


def test_spectra_and_buildings_are_told(dataset):
    """Sa at a building's period is ω² times what the free run says of its peak; the grid's amplitude scales both."""
    assert dataset["building_period"].values.tolist() == [0.5, 0.3]
    assert dataset["building_damping"].values.tolist() == [0.05, 0.02]
    assert dataset["building_mass"].values.tolist() == [10e3, 20e3]
    period = float(PERIODS[30])
    found = scan(parse_scene(SCENE.replace('"0.5 s"', f'"{period!r} s"')), check_fraction=0.0)
    spectra = found["record_spectral_acceleration"]
    assert spectra.dims == ("record", "period") and np.array_equal(found["period"], PERIODS)
    peak = float(found["peak_displacement_free"].sel(record="RSN6-180", building="left").isel(polarity=0, pga=1))
    factor = float(found["pga"][1] / found["record_pga"].sel(record="RSN6-180"))
    told = factor * float(spectra.sel(record="RSN6-180")[30])
    assert peak * (2.0 * np.pi / period) ** 2 == pytest.approx(told, rel=1e-5)  # spectra find local maxima to 4e-6


def test_what_the_buildings_felt_stands_along_the_records(dataset):
    """Samples of the file itself, times the factor, reach the PGA that was felt, at every amplitude of the grid."""
    samples = np.abs(catalogue.load("RSN6-180")[0].data[:501])  # 5 s at 0.01 s
    one = dataset.sel(record="RSN6-180")
    assert one["record_scale_factor"].dims == one["record_pga_felt"].dims == ("pga",)
    assert one["record_pga_felt"].values == pytest.approx(dataset["pga"].values, rel=1e-12)
    assert samples.max() * one["record_scale_factor"].values == pytest.approx(dataset["pga"].values, rel=1e-12)
    assert float(one["record_magnitude"]) == 6.95 and np.isnan(float(one["record_vs30"]))
    units = {name: dataset[f"record_{name}"].attrs["units"] for name in ("magnitude", "distance", "vs30", "pga_felt")}
    assert units == {"magnitude": "1", "distance": "km", "vs30": "m/s", "pga_felt": "m/s2"}
    assert dataset["record_recording"].values.tolist() == [0, 1]


def test_the_factor_of_a_scaled_record_is_that_of_the_whole_chain():
    """To a spectral acceleration, whose factor the sentence of the processing tells as well."""
    scaled = 'sa = {value = "0.7 g", period = "0.62 s"}\n[grid]'
    text = SCENE.replace('pga = ["0.1 g", "0.3 g"]', "").replace("[grid]", scaled)
    found = scan(parse_scene(text), check_fraction=0.0)
    assert found["record_scale_factor"].dims == ("record",)
    factors = [float(re.search(r"scale: times (\S+) to Sa", words)[1]) for words in _scalings(found)]
    assert found["record_scale_factor"].values == pytest.approx(factors, rel=1e-9)  # ten digits in the sentence
    peaks = [np.abs(catalogue.load(name)[0].data[:501]).max() for name in ("RSN6-180", "RSN1690-090")]
    assert found["record_pga_felt"].values[0] == pytest.approx(factors[0] * peaks[0], rel=1e-9)
    assert np.array_equal(found["record_pga_felt"], found["record_pga"])


def _scalings(dataset):
    told = json.loads(dataset.attrs["processing"])
    return [words for name in dataset["record"].values for words in told[name] if words.startswith("scale")]


def test_distance_and_vs30_of_a_set_are_those_of_its_tables():
    text = SCENE.replace('names = ["RSN6-180", "RSN1690-090"]', 'set = "fema-p695-nearfield-no-pulse"')
    found = scan(parse_scene(text.replace('"5 mm", "10 mm", "20 mm", "40 mm"', '"2 m"')), check_fraction=0.0)
    every = {member.id: member for member in record_sets.members("fema-p695-nearfield-no-pulse")}
    for name, distance, soil, magnitude in zip(
        *(found[key].values for key in ("record", "record_distance", "record_vs30", "record_magnitude")), strict=True
    ):
        member = every[str(name)]
        assert (distance, soil, magnitude) == (member.distance_km, member.vs30, member.magnitude)
    assert np.unique(found["record_recording"], return_counts=True)[1].tolist() == [2] * 14


def test_a_rigid_building_has_no_period():
    text = SCENE.replace('mass = "20 t"\nperiod = "0.3 s"\ndamping = 0.02', "rigid = true")
    found = scan(parse_scene(text), check_fraction=0.0)
    assert np.isnan(found["building_period"].values).tolist() == [False, True]


def test_the_command_line_stays_with_the_results(tmp_path, monkeypatch):
    (tmp_path / "s.toml").write_text(SCENE)
    words = ["scan", "s.toml", "-o", "r.nc", "--set", "interface.gap=30 mm"]
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "argv", ["/usr/lib/pounding_risk/__main__.py", *words])
    commands.done(*words)
    told = open_results(tmp_path / "r.nc").attrs["command"]
    assert told == "pounding-risk scan s.toml -o r.nc --set 'interface.gap=30 mm'"


PAIR_ALONE = """
import sys
import pounding_risk.ensemble.scan, pounding_risk.ensemble.pair_job
print([name for name in sys.modules if name.startswith("pounding_risk.solver.row")])
"""


@pytest.mark.complete
def test_a_pair_loads_no_solver_of_rows():
    """Its import alone takes as long as the rest of a short scan."""
    assert output("-c", PAIR_ALONE).strip() == "[]"
