"""Sa at a building's own period, against SciPy's oscillator: nothing else that moves the building is in it."""

import numpy as np
import pytest
from scenes import scene_text, single, storeyed
from scipy.signal import lsim
from sentences import refusal

from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.intensities import intensities
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions.read import read_motion
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene

PERIOD = 0.8
OTHER = single("right", "300 t", "0.3 s", height="4 m")
MASS = single("left", "200 t", "0.8 s", height="4 m")
STIFFNESS = f"{200e3 * (2.0 * np.pi / PERIOD) ** 2:.12g} N/m"
STOREY = storeyed("left", ["200 t"], [STIFFNESS], ["4 m"])
SOIL = {"shear_wave_velocity": "120 m/s", "radius": "4 m", "density": "1800 kg/m^3"}
WAVE = {"velocity": "500 m/s", "distance": "20 m", "towards": "left"}
PLAN = {"face": ["-8 m", "8 m"], "eccentricity": "2 m", "gyration": "5 m", "torsional_ratio": 1.1}
STRENGTH = {"storey_strengths": ["100 kN"]}


def of_oscillator(damping: float, period: float = PERIOD) -> float:
    """Sa of El Centro 1940 [m/s²] by SciPy, exact for a ground acceleration that is linear between its samples."""
    motion = read_motion("RSN6-180")
    time = np.arange(motion.acceleration.size) * motion.dt
    fine = np.arange(0.0, time[-1], motion.dt / 8.0)  # for peaks between samples
    omega = 2.0 * np.pi / period
    system = [[0.0, 1.0], [-(omega**2), -2.0 * damping * omega]], [[0.0], [-1.0]], [[1.0, 0.0]], [[0.0]]
    moved = lsim(system, np.interp(fine, time, motion.acceleration), fine)[1]
    return float(omega**2 * np.abs(moved).max())


def scanned(building, effects=None, **interface) -> Results:
    text = scene_text(building, OTHER, records={"tail": "2 s"}, effects=effects, **interface)
    return Results(scan(parse_scene(text)))


@pytest.mark.parametrize(
    ("building", "effects"),
    [
        (MASS, None),
        (MASS | {"damping": 0.02}, {"permanent_set": {}, "wave_passage": WAVE}),
        (MASS | {"ground_delay": "0.1 s", "ground_velocity": "0.5 m/s"}, None),
        (STOREY | STRENGTH | {"damping_rule": "rayleigh"}, None),
    ],
)
def test_sa_of_a_lone_elastic_mass_is_exact(building, effects):
    """Also where the wave comes later, and of one storey; 1e-5 is what the peaks of SciPy's samples lack."""
    results = scanned(building, effects, law="viscous_elastoplastic")
    exact = of_oscillator(building.get("damping", 0.05))
    assert intensities(results, "sa(left)")[0, 0] == pytest.approx(exact, rel=1e-5)


@pytest.mark.parametrize(
    ("building", "effects", "interface"),
    [
        (STOREY | STRENGTH, {"inelastic_storeys": {}}, {}),
        (MASS, {"p_delta": {}}, {}),
        (MASS, {"soil_flexibility": SOIL}, {}),
        (MASS | {"ground_factor": 0.5}, None, {}),
        (MASS | {"ground_record": "RSN753-000"}, None, {}),
        (MASS | {"initial_displacement": "-300 mm"}, None, {}),
        (STOREY | {"plan": PLAN}, None, {}),
        (MASS, None, {"link_stiffness": "20 MN/m"}),
    ],
)
def test_sa_of_a_building_that_more_than_the_record_moves_is_that_of_the_record(building, effects, interface):
    """What such a building does is no measure of the motion: by it, Sa was 8 to 270 % off. The spectra are read between
    periods, which scatters Sa by 4 %."""
    results = scanned(building, effects, **interface)
    own, period = intensities(results, "sa(left)")[0, 0], float(results.dataset["building_period"][0])
    assert own == pytest.approx(of_oscillator(0.05, period), rel=0.04)
    assert own == pytest.approx(intensities(results, f"sa({period!r} s)")[0, 0], rel=1e-9)


def test_a_dataset_without_spectra_is_refused_sa_of_a_building_that_yields():
    results = scanned(STOREY | STRENGTH, {"inelastic_storeys": {}})
    older = Results(results.dataset.drop_vars("record_spectral_acceleration"))
    told = refusal(intensities, older, "sa(left)")
    assert "no spectra" in told and "`pounding-risk rerun`" in told and "pga" in told


def test_an_intensity_that_not_every_interface_has_is_refused_with_one_that_works():
    """The building of one interface was proposed at the other, and refused there in turn."""
    row = scan(parse_scene(scene_text(STOREY, OTHER, single("far", "100 t", "0.5 s", height="4 m"))))
    for name, why in (("far", "is that of far, which is not at every interface"), ("roof", "is not known")):
        told = refusal(assess, row, intensity=f"sa({name})")
        assert why in told and "by name" not in told and "sa(longer)" in told
    for word in ("pga", "sa(left)", "sa(right)", "sa(longer)", "sa(0.5 s)"):
        assert assess(row, intensity=word).interfaces
