"""A wave that passes one building before the other: an independent run, limits, mirror, scenes."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from oracle_grounds import Touch, peaks_of
from sentences import refusal
from sweeps import sweep
from test_grounds import body_of

import pounding_risk as pr
from pounding_risk.lab.stability.trial import shaking
from pounding_risk.models.contact.impulsive import Merged
from pounding_risk.models.contact.laws import ViscousElastoplastic
from pounding_risk.models.effects.wave_passage import WavePassage
from pounding_risk.models.ground import DelayedInterval, Support
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import make_log
from pounding_risk.solver.pair import flight
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run, solve
from pounding_risk.solver.pair.taylor import bend_at, value_at
from pounding_risk.solver.workspace import SIGNAL, make_workspace
from pounding_risk.studies import demo
from pounding_risk.studies.pair_trace import energies, histories, relative_displacement

FRAME, SHED, ROCK = Building("frame", 500e3, 0.5, 0.05), Building("shed", 800e3, 0.31, 0.05), Building.rigid("rock")
LAG, STEP = 0.043, 0.01  # no multiple of the step
GROUND = shaking(4.0)[:400]
# One law, so that one kernel is compiled: with e = 1 and without a cap it is β δ^1.5.
LAW, ELASTIC = ViscousElastoplastic(2.75e9), ViscousElastoplastic(1e9)
WHOLE, HALF = constant(1.0), constant(0.5)


CASES = {
    "hertz": (FRAME, SHED, ELASTIC, 0.004, LAG),
    "hertz from the right": (FRAME, SHED, ELASTIC, 0.004, -LAG),
    "hertz, rock at the right": (FRAME, ROCK, ELASTIC, 0.008, LAG),
    "hertz, rock at the left": (ROCK, SHED, ELASTIC, 0.008, LAG),
    "merged": (FRAME, SHED, Merged(), 0.004, LAG),
    "merged, rock at the right": (FRAME, ROCK, Merged(), 0.008, LAG),
    "merged, rock at the left": (ROCK, SHED, Merged(), 0.008, -LAG),
}


@pytest.mark.parametrize("case", sweep(CASES, "merged, rock at the left"))
def test_an_independent_run(case: str):
    """Peaks, impulse and energies of SciPy's run in absolute displacements, to what its samples between steps miss."""
    left, right, law, gap, lag = CASES[case]
    supports, sides = WavePassage(lag).supports(2), {"left": left, "right": right}
    joins, places = isinstance(law, Merged), [float(not side.is_rigid) for side in sides.values()]
    bodies = [body_of(side, support, GROUND) for side, support in zip(sides.values(), supports, strict=True)]
    known = peaks_of(bodies, [Touch(0, *places, gap, getattr(law, "stiffness", 0.0), 1.5, joins)], STEP)
    found = solve(left, right, Interface(gap, law, WHOLE), GROUND, STEP, supports=supports, rtol=1e-10)
    assert found["status"] == 0 and found["impact_count"] >= 3
    assert known["joints"] == joins * found["impact_count"]
    twins = {name: known[name][0] for name in ("peak_closing", "peak_opening", "peak_contact_force", "impulse")}
    twins |= {f"peak_displacement_{side}": 0.0 for side in sides}
    for at, side in enumerate(side for side, building in sides.items() if not building.is_rigid):
        twins[f"peak_displacement_{side}"] = known["displacement"][at]
        if not joins:  # a jump has no finite acceleration
            twins[f"peak_floor_acceleration_{side}"] = known["acceleration"][at]
    for output, twin in twins.items():
        # A local maximum is a parabola: looked for 40 times a step, its top is missed by some 1e-5 of the force at
        # most.
        assert found[output] == pytest.approx(twin, rel=2e-5, abs=1e-12), output
    assert found["impulse"] == pytest.approx(known["impulse"][0], rel=1e-7)
    pair = oscillators(left, right)
    free, log = free_response(pair, GROUND, STEP, supports), make_log(1000, 20_000, np.zeros(0))
    run(pair, free, Interface(gap, law, WHOLE), 1e-10, log)
    motion = histories(pair, free, log)
    taken = energies(pair, free, motion)["damping"]
    # While the buildings rest on each other the history has a row a sample: (ω h)⁴ / 720 = 2e-6.
    assert taken[-1] == pytest.approx(known["damped"], rel=5e-6)
    assert np.diff(taken).min() > -1e-9 * taken[-1]  # dampers only take
    assert relative_displacement(free, *motion[:2]).max() <= found["peak_closing"] + 1e-15


@pytest.mark.parametrize("law", [LAW, Merged()])
@pytest.mark.parametrize("right", [SHED, ROCK])
def test_no_lag_is_no_wave(law, right):
    """On two grounds that move alike, every output but steps and the ledger's rest: nodes only divide steps."""
    plain, none = (
        solve(FRAME, right, Interface(0.004, law, HALF), GROUND, STEP, supports=supports, rtol=1e-10)
        for supports in ((), (Support(), Support(velocity=1e-300)))
    )
    for name in plain.keys() - {"energy_residual", "steps"}:
        assert none[name] == pytest.approx(plain[name], rel=1e-8, abs=1e-12, nan_ok=True), name


def test_a_motion_before_its_arrival_is_none():
    """A building that the wave has not reached stands still, and what the record ends with is cut off."""
    free = free_response(oscillators(FRAME, SHED), GROUND, STEP, WavePassage(0.5).supports(2))
    assert not free.states[:101, 1].any() and free.states[:101, 0].any()
    plain = free_response(oscillators(FRAME, SHED), GROUND, STEP)
    # A lag of fifty samples is the same motion fifty samples later; here nodes stand between the samples too.
    np.testing.assert_allclose(free.states[100::2, 1], plain.states[:-50, 1], rtol=0.0, atol=1e-15)
    np.testing.assert_allclose(free.states[::2, 0], plain.states[:, 0], rtol=0.0, atol=1e-15)


UNIT = st.integers(-1000, 1000).map(lambda number: 1e-3 * number)


@given(st.tuples(*[UNIT] * 10), st.sampled_from([1.0, 0.4]))
def test_no_relative_motion_bends_more_than_its_bound(numbers, share: float):
    """The series of the relative displacement is that of both buildings less the cubic, under the bound on |f''|."""
    pair, step = oscillators(FRAME, SHED), 0.02
    state = tuple(0.01 * number for number in numbers[:4])
    a, b, bend, twist, spread, rate = numbers[4:]
    ground = DelayedInterval(5.0 * a, 500.0 * b, 5.0 * bend, 500.0 * twist, 0.1 * spread, rate, (1.0 - share) * step)
    workspace, terms = make_workspace(), 30
    flight.write_series(pair, state, ground, terms, workspace)
    flight.write_signal(0, pair, ground, workspace, terms)
    bound = flight.bend_bounds(pair, state, ground, share * step)[0]
    for x in np.linspace(0.0, share * step, 7):
        u, w, *_ = flight.state_at(pair, workspace, terms, x)
        later = x + ground.offset
        cubic = 0.1 * spread + rate * later + 5.0 * bend * later**2 / 2.0 + 500.0 * twist * later**3 / 6.0
        assert value_at(workspace.search.series, SIGNAL, terms, x) == pytest.approx(u - w - cubic, abs=1e-15)
        assert abs(bend_at(workspace.search.series, SIGNAL, terms, x)) <= bound * (1.0 + 1e-12) + 1e-12


# -------------------------------------------------------------------------------------------------- scenes

WAVE = {"wave_passage": {"velocity": "400 m/s", "distance": "30 m"}}


def scene(**more):
    """The paper's pair on a coarse grid."""
    return {
        **demo.scene("paper").resolved(),
        "effects": WAVE,
        "grid": {"gap": ["10 mm", "25 mm", "1 m"], "contact_model": ["viscous_elastoplastic", "merged"]},
        **more,
    }


def test_a_scene_with_a_wave(tmp_path):
    """Scanned and simulated beside the scene without a wave; the source of the effect is named."""
    study = scene_of(scene())
    found = pr.scan(study, tmp_path / "wave.nc", check_fraction=0.0)
    plain = pr.scan(scene_of(scene(effects={})), check_fraction=0.0)
    touched = {"gap": 0, "contact_model": 0, "record": 0, "polarity": 0, "yield_force": 0}
    assert found.impulse[touched].item() != plain.impulse[touched].item()
    # Without contact the left building knows nothing of the wave, the right one has it later.
    np.testing.assert_allclose(
        found.peak_displacement_free.isel(building=0), plain.peak_displacement_free.isel(building=0), rtol=1e-12
    )
    assert "Der Kiureghian" in found.attrs["references"]
    one = pr.simulate(study)
    assert "Der Kiureghian" in one.attrs["references"]
    assert {"ground_widening", "building_ground_acceleration"} <= set(one)
    floors = one.displacement.isel(storey=0, drop=True)
    closing = floors.isel(building=0) - floors.isel(building=1) - one.ground_widening
    np.testing.assert_allclose(one.relative_displacement, closing, atol=1e-15)
    assert "ground_widening" not in pr.simulate(scene_of(scene(effects={})))


def test_a_wave_that_never_arrives_is_refused(says):
    study = scene_of(scene(effects={"wave_passage": {"velocity": "2 m/s", "distance": "30 m"}}))
    says([refusal(command, study) for command in (pr.validate, pr.simulate, pr.scan)])


def test_which_way_the_wave_goes():
    right, left = (
        scene_of(scene(effects={"wave_passage": {**WAVE["wave_passage"], "towards": side}}))
        for side in ("right", "left")
    )
    assert right != left
    found = [pr.simulate(study).ground_widening.values for study in (right, left)]
    assert found[0].max() > 0.0 and not np.allclose(found[0].max(), found[1].max(), rtol=1e-3)


REFUSED = {
    "nothing": {},
    "no velocity": {"velocity": "0 m/s", "distance": "20 m"},
    "a distance below zero": {"velocity": "500 m/s", "distance": "-1 m"},
    "upwards": {"velocity": "500 m/s", "distance": "20 m", "towards": "up"},
}


@pytest.mark.parametrize("fault", REFUSED)
def test_what_a_scene_refuses(fault, says):
    says(refusal(scene_of, scene(effects={"wave_passage": REFUSED[fault]})))
