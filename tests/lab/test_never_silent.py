"""A run that cannot be made ends with a named status and leaves no number behind, in a single run and in a scan."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from processes import interpreted
from scenes import rigid, scene_text, storeyed

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.lab.stability.cases.rest import bouncing
from pounding_risk.lab.stability.trial import Trial, TrialScene, shaking
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver import counters
from pounding_risk.solver.counters import STATUS_SENTENCES
from pounding_risk.solver.pair.outputs import COLUMNS, building_outputs, run_outputs
from pounding_risk.studies import demo

# Limits are constants of compiled code: where they are lowered, the code must be interpreted.
LOWERED = """
import json
from pounding_risk.solver.pair import run, contact
from pounding_risk.lab.stability.trial import TrialScene, Trial, shaking

scene = TrialScene(ground=shaking(4.0, duration=1.0))
found = {}
for module, name, value in json.loads('LIMITS'):
    module = {"run": run, "contact": contact}[module]
    kept = getattr(module, name)
    setattr(module, name, value)
    found[name] = Trial("kelvin_voigt_tension_cut", 1e-6).solve(scene)
    setattr(module, name, kept)
found["none"] = Trial("kelvin_voigt_tension_cut", 1e-6).solve(scene)
print(json.dumps({name: {key: str(value) for key, value in row.items()} for name, row in found.items()}))
"""
LIMITS = [
    ("contact", "MAX_STEPS", 30, counters.EXHAUSTED),
    ("contact", "WORK_AT_LEAST", -1e9, counters.EXHAUSTED),  # less than nothing: what every second adds would be enough
    ("run", "MAX_CONTACTS", 1, counters.TOO_MANY_CONTACTS),
    ("run", "OPEN_SHARE", 1e-9, counters.ENERGY_OPEN),
]


def says_why_not(found: dict[str, float], status: int) -> None:
    """The status asked for, and NaN or −1 in every output."""
    assert found["status"] == status and len(STATUS_SENTENCES[status]) > 20
    for name, value in found.items():
        if name not in ("status", "steps"):
            assert np.isnan(value) or value == -1.0, name


@pytest.fixture(scope="module")
def lowered() -> dict[str, dict[str, float]]:
    """Runs with each of the solver's limits lowered in turn, and with none."""
    code = LOWERED.replace("LIMITS", json.dumps([limit[:3] for limit in LIMITS]))
    # An absolute floor for rounding would hide an open energy: off.
    found = interpreted(code.replace("scene = TrialScene", "run.OPEN_FLOOR = 0.0\nscene = TrialScene"))
    return {name: {key: float(value) for key, value in row.items()} for name, row in found.items()}


@pytest.mark.parametrize(("name", "status"), [limit[1::2] for limit in LIMITS])
def test_a_limit_that_is_met_is_named(lowered: dict[str, dict[str, float]], name: str, status: int):
    assert lowered["none"]["status"] == 0.0 and lowered["none"]["impact_count"] > 1.0
    says_why_not(lowered[name], status)


OVERWORKED_ROW = """
import json
import warnings
import numpy as np
import pounding_risk as pr
from pounding_risk.solver.row import group

warnings.simplefilter("ignore")
folder = FOLDER
group.WORK_AT_LEAST = -1e9
found = pr.scan(folder + "/row.toml")
names = ("status", "row_impulse", "peak_contact_force", "storey_drift", "impact_count")
print(json.dumps({name: np.nan_to_num(found[name].values.squeeze(), nan=-9.0).tolist() for name in names}))
"""
TWO_AND_A_WALL = scene_text(
    storeyed("a", "40 t", "30 MN/m", storeys=1),
    rigid("b", height="4 m"),
    name="two and a wall",
    gap="5 mm",
    records={"files": ["shaking.csv"]},
    grid={"gap": ["5 mm", "1 m"]},
)


@pytest.mark.complete
def test_a_row_that_takes_too_much_work_ends_and_the_scan_goes_on(tmp_path: Path):
    """The case with contacts has its status and no outputs, the other all of them."""
    (tmp_path / "row.toml").write_text(TWO_AND_A_WALL)
    samples = "\n".join(f"{value:.6f}" for value in shaking(4.0, duration=1.0))
    (tmp_path / "shaking.csv").write_text(f"# unit = m/s^2\n# dt = 0.01 s\n{samples}\n")
    found = interpreted(OVERWORKED_ROW.replace("FOLDER", repr(str(tmp_path))))
    assert found["status"] == [counters.EXHAUSTED, 0]
    assert found["row_impulse"] == [-9.0, 0.0]
    assert found["peak_contact_force"] == [-9.0, 0.0]
    assert found["impact_count"] == [-1, 0]
    failed, complete = found["storey_drift"]  # of both buildings; the wall has none
    assert failed == [-9.0, -9.0] and complete[0] > 0.0


@pytest.mark.parametrize("name", LAWS)
def test_what_numbers_do_not_hold(name: str):
    """rtol 1e-300: the first step in contact shrinks to nothing; 1e300 m/s²: energies past the largest number."""
    says_why_not(Trial(name, 1e-300).solve(TrialScene()), counters.UNDERFLOW)
    says_why_not(Trial(name, 1e-6).solve(TrialScene(ground=shaking(1e300))), counters.NOT_FINITE)


def test_a_failed_run_leaves_no_output():
    """Whatever the raw columns hold: every output of every failed run is NaN or −1, none of a complete one."""
    raw = np.full((len(STATUS_SENTENCES), COLUMNS), 2.0)
    raw[:, counters.STATUS] = list(STATUS_SENTENCES)
    scene = TrialScene()
    found = {**run_outputs(raw, 1e6), **building_outputs(raw, (scene.left, scene.right), np.ones(2))}
    for name, values in found.items():
        gone = np.isnan(values) | (values == -1.0)
        assert not gone[0].any() and gone[1:].all(), name


@pytest.mark.parametrize("bad", [np.inf, -np.inf])
def test_an_infinite_sample_has_a_status_and_no_warning(bad: float):
    ground = shaking(4.0).copy()
    ground[250] = bad
    says_why_not(Trial("jankowski", 1e-6).solve(TrialScene(ground=ground)), counters.NOT_FINITE)


@pytest.mark.parametrize(("key", "values"), [("gap", (-0.01, np.nan)), ("yield_force", (0.0, -1.0, np.nan))])
def test_a_number_out_of_range_is_refused_in_python_too(key: str, values: tuple[float, ...]):
    for value in values:
        with pytest.raises(PoundingError):
            pr.simulate(demo.scene("paper"), **{key: value})


@pytest.mark.parametrize("name", ["van_mier", "viscous_elastoplastic"])
@pytest.mark.parametrize("short", [1e-2, 3e-4, 1e-4, 1e-6, 1e-9, 1e-12])
def test_a_yield_force_just_under_the_peak_counts_as_yielding(name: str, short: float):
    """What the demand calls an exceedance is counted and has its time."""
    trial = Trial(name, 1e-6)
    counts = []
    for gap in np.linspace(0.0, 0.01, 11):
        peak = trial.solve(TrialScene(gap=gap))["peak_contact_force"]
        found = trial.solve(TrialScene(gap=gap, yield_force=(1.0 - short) * peak))
        counts.append((found["yield_exceedance"], min(found["yield_count"], 1.0), found["first_yield_time"] >= 0.0))
    assert counts == [(1.0, 1.0, True)] * 11


def test_a_rest_takes_no_more_steps_than_it_has_samples_for():
    """30 s, most of it at rest, 1,505 samples: some two steps each; a few for every bounce before."""
    found = Trial("kelvin_voigt", 1e-7).solve(bouncing(30.0))
    assert found["status"] == 0.0 and found["steps"] < 20_000


@pytest.mark.parametrize("name", ["modified_kelvin_voigt", "jankowski", "viscous_elastoplastic"])
def test_an_overdamped_contact_at_a_loose_tolerance(name: str):
    trial = Trial(name, 1e-2)
    scene = TrialScene(hertz=2.75e9, linear=9.35e7, restitution=Restitution(0.01))
    assert trial.collide(scene, 0.5, 570.0).restitution < 0.05
