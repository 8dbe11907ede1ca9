"""Buildings that begin displaced or moving: closed forms, the reference integrators, and what scenes refuse."""

from math import pi, sqrt

import numpy as np
import oracle
import oracle_rows
import pytest
from oracle_laws import Oscillator
from row_cases import contacts_of, meeting, named, points_of, storeys
from scenes import scene_text, single
from scipy.linalg import expm
from sentences import refusal, refusals

import pounding_risk as pr
from pounding_risk.assessment.demands import is_linear
from pounding_risk.models.contact.laws import KelvinVoigtTensionCut
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.read import read_motion
from pounding_risk.results.opened import Results
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.pair.api import Interface, free_response, initial_state, oscillators, solve
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

DT = 0.01
QUIET = np.zeros(201)
MOTION = read_motion("RSN6-180", window=(1.0, 5.0), pga=3.0)
MOVED = Building("left", 44.36e3, 0.208, 0.05, initial_displacement=0.004, initial_velocity=0.3)
SLOW = Building("right", 82.6e3, 0.6, 0.05, initial_displacement=-0.02, initial_velocity=-0.1)


def test_free_vibration_is_the_closed_form():
    """u = e^(−ζωt) (u0 cos ω_d t + (v0 + ζω u0)/ω_d sin ω_d t); a pair, and a row of the same masses."""
    pair = free_response(oscillators(MOVED, SLOW), QUIET, DT, (), initial_state(MOVED, SLOW))
    row = rows.free_row(lay_out([chain_of(MOVED), chain_of(SLOW)], (), DT), QUIET, states=True)
    for place, building in enumerate((MOVED, SLOW)):
        omega = 2.0 * pi / building.period
        decay, rate = building.damping * omega, omega * sqrt(1.0 - building.damping**2)
        u0, v0 = building.initial_displacement, building.initial_velocity
        t = DT * np.arange(QUIET.size)
        u = np.exp(-decay * t) * (u0 * np.cos(rate * t) + (v0 + decay * u0) / rate * np.sin(rate * t))
        # Maps over a step are applied 200 times, each to a few ulp.
        np.testing.assert_allclose(pair.states[::, place][:: (len(pair.states) - 1) // 200], u, atol=1e-13)
        np.testing.assert_allclose(row.states[:: (len(row.states) - 1) // 200, 0, place], u, atol=1e-13)


def test_storeys_begin_where_they_are_told():
    """Against the exponential of the matrix: states at nodes, and peaks, of which those at the start are some."""
    building = Storeys("", (90e3,) * 3, (5e7,) * 3, (3.0,) * 3, initial_displacement=(0.01, 0.03, 0.04))
    chain = chain_of(building)
    laid = lay_out([chain], (), DT)
    found = rows.free_row(laid, QUIET, states=True)
    mass, damping, stiffness = building.matrices()
    matrix = np.zeros((6, 6))
    matrix[:3, 3:] = np.eye(3)
    matrix[3:] = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    start = np.array([0.01, 0.03, 0.04, 0.0, 0.0, 0.0])
    for node in (1, 37, 200):
        exact = expm(matrix * laid.step * node) @ start
        np.testing.assert_allclose(found.states[node].ravel(), exact, atol=1e-12)
    assert found.floors[2, 0] == 0.04  # the roof never swings as wide again
    fine, seen = expm(matrix * 1e-4), np.zeros((3, 3))
    state = start
    for _ in range(20_000):
        seen = np.fmax(seen, np.abs([state[:3], np.diff(state[:3], prepend=0.0), (matrix @ state)[3:]]))
        state = fine @ state
    # Between samples 0.1 ms apart a mode of 0.05 s passes its local maximum by (π Δt/T)²/2 = 2e-5 of it.
    np.testing.assert_allclose(found.floors[:, [0, 1, 3]], seen.T, rtol=3e-5)
    assert (found.floors[:, [0, 1, 3]] >= seen.T * (1.0 - 1e-9)).all()


@pytest.mark.parametrize("as_row", [False, True])
def test_a_mass_that_moves_against_a_stop(as_row: bool):
    """Gap 0, v0 = 1 m/s, no loss: F = v0 √m K/√(k + K), for π √(m/(k + K)) (code_aster V5.01.101, SDND101)."""
    mass, k, stiff = 100.0, 1e4, 1e6
    left = Building("mass", mass, 2.0 * pi * sqrt(mass / k), 0.0, initial_velocity=1.0)
    law, rule = KelvinVoigtTensionCut(stiff), constant(1.0)
    shaking = np.zeros(6)  # to 0.05 s, after one contact
    force, duration = sqrt(mass) * stiff / sqrt(k + stiff), pi * sqrt(mass / (k + stiff))
    if as_row:
        meetings = [meeting(0, 1.0, 1.0, 0.0, law="kelvin_voigt_tension_cut", stiffness=stiff, restitution=1.0)]
        laid = lay_out([chain_of(left), chain_of(Building.rigid("stop"))], points_of(meetings), DT)
        run = rows.run_row(laid, contacts_of(meetings), shaking, rtol=1e-11)
        found = {name: values[0] for name, values in named(run).items()}
    else:
        found = solve(left, Building.rigid("stop"), Interface(0.0, law, rule), shaking, DT, rtol=1e-11)
    assert found["impact_count"] == 1
    assert found["first_impact_time"] == 0.0
    assert found["peak_contact_force"] == pytest.approx(force, rel=1e-9)
    assert found["contact_time"] == pytest.approx(duration, rel=1e-9)
    # K/ω² v0 2 of the harmonic motion at ω² = (k + K)/m; what the spring adds meanwhile is in ω.
    assert found["impulse"] == pytest.approx(2.0 * mass * stiff / (k + stiff), rel=1e-9)


def test_a_pair_that_begins_moving_is_the_reference():
    """A real record, both buildings displaced and moving, contact from the first tenth of a second on."""
    left, right = (Oscillator(b.mass, b.period, b.damping) for b in (MOVED, SLOW))
    scene = oracle.Scene(left, right, "kelvin_voigt_tension_cut", 5e7, gap=0.03, restitution=0.6)
    start = MOVED.initial_displacement, MOVED.initial_velocity, SLOW.initial_displacement, SLOW.initial_velocity
    true = oracle.integrate(scene, MOTION.acceleration, MOTION.dt, start=start)
    interface = Interface(0.03, KelvinVoigtTensionCut(5e7), constant(0.6))
    found = solve(MOVED, SLOW, interface, MOTION.acceleration, MOTION.dt, rtol=1e-11)
    assert found["status"] == COMPLETE and true["impact_count"] >= 3
    for name in set(true) & set(found):
        # The tolerance of the run, through as many contacts as there are; a force that is cut off is zero to rounding.
        assert found[name] == pytest.approx(true[name], rel=1e-8, abs=1e-6 if "force" in name else 1e-9, nan_ok=True), (
            name
        )


def test_a_row_that_begins_moving_is_the_reference():
    """Three storeys beside two that may yield; velocities of one and displacements of the other."""
    slender = storeys(3, 90e3, 5e7, initial_velocity=(0.2, 0.3, 0.4))
    limp = storeys(
        2, 60e3, 3e7, ("inelastic_storeys", (("hardening", 0.05),)), strength=2e5, initial_displacement=(-0.002, -0.003)
    )
    meetings = [meeting(0, float(floor), float(floor), 0.01, restitution=0.6) for floor in (1, 2)]
    laid = lay_out([slender, limp], points_of(meetings), MOTION.dt)
    run = rows.run_row(laid, contacts_of(meetings), MOTION.acceleration, rtol=1e-11)
    towers = [oracle_rows.Tower(*chain[:7]) for chain in (slender, limp)]
    start = np.array([0.0, 0.0, 0.0, -0.002, -0.003, 0.2, 0.3, 0.4, 0.0, 0.0])
    reference = oracle_rows.Row(towers, meetings)
    reference.state[: start.size] = start
    true = reference.go(MOTION.acceleration, MOTION.dt)
    assert run.status == COMPLETE and true.points["impact_count"].min() >= 1
    np.testing.assert_allclose(run.floors, true.floors, rtol=1e-7)
    np.testing.assert_allclose(run.rest, true.rest, rtol=1e-6, atol=1e-9)


# ------------------------------------------------------------------------------------------------------- scenes
def scene(**more: object) -> pr.Scene:
    """Two storeys beside a mass; keys of the storeys."""
    storeyed = {"name": "A", "floor_masses": "40 t", "storey_stiffnesses": "30 MN/m", "storey_heights": "3 m"}
    mass = {"name": "B", "mass": "90 t", "period": "0.4 s", "height": "3 m"}
    contact = {"gap": "20 mm", "contact_model": "jankowski", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}
    return pr.Scene([{**storeyed, "storeys": 2, **more}, mass], [contact], {"names": ["RSN6-180"]})


def test_keys_of_a_scene_reach_the_run():
    drawn = scene(initial_displacement=["5 mm", "12 mm"], initial_velocity="0.1 m/s")
    assert drawn.buildings[0].initial_displacement == (0.005, 0.012)
    assert drawn.buildings[0].initial_velocity == (0.1, 0.1)
    again = pr.read_scene(drawn.to_toml())
    assert again == drawn and again != scene()
    words = dict(pr.validate(drawn).summary())["left building"]
    assert words.endswith("begins displaced by 12 mm and moving at 100 mm/s at most")
    histories = pr.simulate(drawn)
    begun = histories["displacement"].isel(time=0).values.ravel()
    np.testing.assert_array_equal(begun[np.isfinite(begun)][:2], [0.005, 0.012])


YIELDED = {"storey_strengths": "200 kN", "initial_displacement": ["-5 mm", "-30 mm"]}


def test_what_cannot_begin_is_told(says):
    """One displacement of two, a force, a way across the gap, a length for a velocity."""
    wrong = {"initial_displacement": [["5 mm"], "5 N", "21 mm"], "initial_velocity": ["20 mm"]}
    says(*refusals(scene, wrong=wrong))


def test_storeys_that_have_yielded_and_walls_begin_at_rest(says):
    says(refusal(pr.read_scene, scene(**YIELDED).to_toml() + "\n[effects.inelastic_storeys]\nhardening = 0.05\n"))
    wall = {"name": "W", "rigid": True, "initial_velocity": "1 m/s"}
    says(refusal(pr.Scene, [scene().buildings[1], wall], ["20 mm"], {"names": ["RSN6-180"]}))


@pytest.mark.parametrize("key", ["initial_displacement", "initial_velocity", "ground_velocity"])
def test_what_follows_from_an_initial_motion_does_not_grow_with_the_record(key):
    """Twice the record is not twice the closing: no curve is scaled from one level."""
    first = {"initial_displacement": "30 mm", "initial_velocity": "0.2 m/s", "ground_velocity": "20 mm/s"}[key]
    pair = single("frame", "500 t", "1.0 s"), single("wall", "800 t", "0.5 s", **{key: first})
    given = {"gap": "60 mm", "law": "linear"}
    once, twice = (
        pr.scan(scene_text(*pair, records={"window": ["0 s", "8 s"], "pga": level}, **given))
        for level in ("0.2 g", "0.4 g")
    )
    assert float((twice["peak_closing_free"] / once["peak_closing_free"]).squeeze()) != pytest.approx(2.0, rel=1e-4)
    assert not is_linear(Results(once))
    still = pr.scan(scene_text(*(one | {key: None} for one in pair), records={"window": ["0 s", "8 s"]}, **given))
    assert is_linear(Results(still))
