"""Whole runs of a pair under El Centro and under random motions: energy, yielding of any law, the clock of a contact.

Symmetries, limits and extremes one by one are the hard cases of tests/lab/test_hard_cases.py.
"""

from math import inf

import numpy as np
import pytest
from bursts import burst
from processes import compiled

from pounding_risk.models.contact.impulsive.rigid import Stereomechanical
from pounding_risk.models.contact.laws import LAWS, Jankowski, Tabulated, ViscousElastoplastic, stiffness_quantity
from pounding_risk.models.effects.permanent_set import PermanentSet
from pounding_risk.models.effects.unloading_stiffness import UnloadingStiffness
from pounding_risk.models.restitution import CONCRETE, constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.read import read_motion
from pounding_risk.solver.counters import COUNT, MAX_STEPS, make_log
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run, solve
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS, run_outputs
from pounding_risk.solver.workspace import make_workspace
from pounding_risk.units import STANDARD_GRAVITY

LEFT, RIGHT = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)
FRAME, MASONRY = Building("frame", 44.36e3, 0.208, 0.05), Building("masonry", 82.6e3, 0.007, 0.05)
PEAKS = (
    "peak_relative_displacement",
    "peak_contact_force",
    "peak_penetration",
    "peak_displacement_left",
    "peak_displacement_right",
)
PULLS = {"kelvin_voigt", "hertz_damp", "hertz_damp_exact"}  # between driven bodies, the last two may as well


def law_of(name: str, hertz: float = 2.75e9, linear: float = 1e9):
    kind = LAWS[name]
    return kind(linear) if stiffness_quantity(kind).unit == "N/m" else kind(hertz)


@pytest.fixture(scope="module")
def el_centro() -> np.ndarray:
    """The paper's input: the first 6 s of component 180, scaled to 0.5 g; every 0.01 s."""
    return read_motion("RSN6-180", window=(0.0, 6.0), pga=0.5 * STANDARD_GRAVITY).acceleration


SCENES = {
    "paper": (FRAME, MASONRY, 0.0, 4.2e10, 4.2e9),
    "towers": (LEFT, RIGHT, 0.02, 2.75e9, 1e9),
    "light beside heavy": (Building("a", 20e3, 1.2, 0.02), Building("b", 900e3, 0.15, 0.05), 0.005, 2e9, 3e8),
}


@pytest.mark.parametrize("scene", SCENES)
@pytest.mark.parametrize("name", LAWS)
def test_energy_closes_and_nothing_pulls(name: str, scene: str, el_centro: np.ndarray):
    """To 1e-6 of the largest mechanical energy at the default tolerance, with the cap and without."""
    left, right, gap, hertz, linear = SCENES[scene]
    for ground, strength in ((el_centro, inf), (el_centro, 4e5), (burst(3, 6.0), inf)):
        found = solve(left, right, Interface(gap, law_of(name, hertz, linear), CONCRETE, strength), ground, 0.01)
        assert found["status"] == 0.0 and found["impact_count"] > 0
        assert found["energy_residual"] < 1e-6
        assert found["energy_viscous"] > -1e-6 * found["peak_contact_force"] * found["peak_penetration"]
        if name not in PULLS:
            # A law at a touch or a parting may be evaluated a rounding beyond it.
            assert found["lowest_contact_force"] >= -1e-15 * found["peak_contact_force"]


@pytest.mark.parametrize("name", ["kelvin_voigt_tension_cut", "jankowski"])
def test_yielding_of_a_law_without_a_cap(name: str, el_centro: np.ndarray):
    """It counts where its force reaches F_E; the list of its contacts says the same, and so does the sweep."""
    law, forces = law_of(name), np.array([1e6, 4e6, 8e6, 1e9])
    pair = oscillators(LEFT, RIGHT)
    free = free_response(pair, el_centro, 0.01)
    log = make_log(1000, 0, np.zeros(0))
    run(pair, free, Interface(0.01, law, constant(0.65)), 1e-6, log)
    peaks = log.contacts[: log.used[0], 4]
    out, how = np.zeros((1, 4, COLUMNS)), np.zeros((1, 4), dtype=np.int8)
    solve_grid(pair, free, law, (np.array([0.01]), forces, constant(0.65)), 1e-6, True, make_workspace(), out, how)
    swept = run_outputs(out[0], forces)
    first = []
    for place, force in enumerate(forces):
        found = solve(LEFT, RIGHT, Interface(0.01, law, constant(0.65), force), el_centro, 0.01)
        assert found["yield_count"] == np.count_nonzero(peaks >= force)
        assert found["yield_exceedance"] == float(found["yield_count"] > 0)
        first.append(found["first_yield_time"])
        for key, values in swept.items():
            assert np.array_equal(values[place], found[key], equal_nan=True), key
    assert first[0] < first[1] < first[2] and np.isnan(first[3]) and how.sum() == 1


def test_twins_and_two_rigid_buildings(el_centro: np.ndarray):
    wall = Building.rigid("wall")
    for left, right in ((FRAME, FRAME), (wall, wall), (FRAME, FRAME._replace(mass=1e7))):
        found = solve(left, right, Interface(0.0, Jankowski(4.2e10), CONCRETE), el_centro, 0.01)
        assert found["status"] == 0.0 and found["impact_count"] == 0
        assert found["peak_relative_displacement"] == 0.0


def moderate(seed: int, closed: bool) -> tuple:
    """A pair of ordinary buildings with a damped contact, from a seed."""
    random = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(np.exp(random.uniform(np.log(low), np.log(high))))

    names = [name for name, law in LAWS.items() if law.needs_restitution]
    name = names[random.integers(len(names))]
    left, right = (
        Building(side, between(2e4, 2e6), between(0.1, 2.0), random.uniform(0.03, 0.1)) for side in ("left", "right")
    )
    law = law_of(name, between(3e8, 3e10), between(3e7, 3e9))
    strength = between(1e5, 1e7) if random.random() < 0.5 else inf
    there = Interface(0.0 if closed else between(1e-3, 0.05), law, constant(random.uniform(0.3, 0.8)), strength)
    return left, right, there, burst(seed + 1, between(1.0, 8.0))


def test_two_buildings_pressed_together(recwarn: pytest.WarningsRecorder):
    """A closed gap, a light building carried by a heavy one for 0.67 s: the clock keeps up with the motion.

    The relative speed passes through zero within rounding here, which makes the landing on it hard.
    """
    left, right = (
        Building("left", 434216.4619151266, 1.4153920154205302, 0.0829442955509787),
        Building("right", 7766.80781218424, 1.7971087443605156, 0.05777271600341312),
    )
    law = LAWS["kelvin_voigt_tension_cut"](109061320635.45593)
    scene = left, right, Interface(0.0, law, constant(0.32553804648176254)), burst(2600, 13.690544775634507)
    tight = solve(*scene, 0.01, rtol=1e-9)
    for rtol in (1e-5, 1e-6, 1e-7):
        found = solve(*scene, 0.01, rtol=rtol)
        for key in PEAKS:
            assert found[key] == pytest.approx(tight[key], rel=1e-5), (key, rtol)


def test_the_clock_of_a_contact_keeps_up_with_its_motion():
    """Along every step in contact the displacement changes by the mean speed times the step's duration.

    The energy ledger cannot see a step whose state and time disagree. In 15 scenes with soft buildings, whose
    speed changes little over a step, the two differ by less than the change of speed times the duration.
    """
    for seed in range(15):
        left, right, there, ground = moderate(seed, closed=True)
        left, right = left._replace(period=1.1 + 0.05 * seed), right._replace(period=1.9)
        pair = oscillators(left, right)
        log = make_log(2000, 100_000, np.zeros(0))
        run(pair, free_response(pair, ground, 0.01), there, 1e-6, log)
        steps = log.steps[: log.used[1]]
        change = np.diff(steps, axis=0)
        within = np.ones(len(change), dtype=bool)
        within[log.contacts[: log.used[0], 11].astype(int)[:-1] - 1] = False
        for place, speed in ((1, 3), (2, 4)):
            mean = 0.5 * (steps[1:, speed] + steps[:-1, speed])
            reach = np.abs(change[:, speed]) + 0.05 * np.abs(steps[:, speed]).max()
            missed = np.abs(change[:, place] - mean * change[:, 0])
            assert np.all((missed <= reach * change[:, 0] + 1e-15)[within]), (seed, place)


@pytest.mark.parametrize("rtol", [1e-3, 1e-6, 1e-8])
def test_a_tolerance_that_rounding_allows_is_met(rtol: float):
    """A light building that leans on a heavy one all the time, with a penetration of a millionth of the motion."""
    left, right = Building("left", 154e3, 1.5, 0.003), Building("right", 1e3, 0.6, 0.14)
    there = Interface(0.0, LAWS["kelvin_voigt"](8e11), constant(0.6))
    found = solve(left, right, there, burst(7, 2.5), 0.01, rtol=rtol)
    assert found["status"] == 0.0 and found["steps"] < MAX_STEPS / 100


@pytest.fixture(scope="module")
def record():
    return read_motion("RSN6-180")


@pytest.fixture(scope="module")
def short(record):
    """Eight seconds with the strongest shaking."""
    return record.acceleration[:801], record.dt


def grid(law, motion, gaps, forces, screening, own_kernel=False):
    out, how = np.zeros((len(gaps), len(forces), COLUMNS)), np.zeros((len(gaps), len(forces)), dtype=np.int8)
    pair = oscillators(LEFT, RIGHT)
    free = free_response(pair, *motion)
    cases = gaps, forces, constant(0.65)
    solve_grid(pair, free, law, cases, 1e-6, screening, make_workspace(), out, how, own_kernel)
    return out, how


DENTED = UnloadingStiffness(PermanentSet(ViscousElastoplastic(2.75e9)), 1.5)  # remembers two numbers
BUMPER = Tabulated.of([0.0, 0.01, 0.02, 0.03], [0.0, 1e5, 3e5, 6e5], [0.0, 0.0, 0.5e5, 6e5])  # from its points
OWN = [DENTED, Jankowski(2.75e9), Stereomechanical(), BUMPER]


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("law", OWN, ids=lambda law: type(law).__name__)
def test_a_law_by_address_gives_the_bits_of_its_own_kernel(law, short):
    gaps, forces = np.array([0.0, 0.02]), np.array([1e6, 5e6, inf])
    called, _ = grid(law, short, gaps, forces, True)
    own, _ = grid(law, short, gaps, forces, True, own_kernel=True)
    assert called[..., COUNT].min() > 0.0
    assert np.array_equal(called, own, equal_nan=True)


def test_any_chunk_of_gaps_gives_the_same_bits(short):
    gaps, forces = np.linspace(0.0, 0.1, 7), np.array([1e6, inf])
    whole, _ = grid(ViscousElastoplastic(2.75e9), short, gaps, forces, True)
    for place in range(len(gaps)):
        one, _ = grid(ViscousElastoplastic(2.75e9), short, gaps[place : place + 1], forces, True)
        assert np.array_equal(one[0], whole[place], equal_nan=True)


def test_half_of_a_grid_needs_no_run_of_its_own(record):
    """50 gaps up to twice the closing that the free motion reaches, 20 yield forces up to 20 MN, as one would choose
    them before knowing the answers."""
    pair = oscillators(LEFT, RIGHT)
    closing = free_response(pair, record.acceleration, record.dt).high[:, 0].max()
    gaps, forces = np.linspace(0.0, 2.0 * closing, 50), np.append(np.linspace(1e6, 19e6, 19), inf)
    _, how = grid(ViscousElastoplastic(2.75e9), (record.acceleration, record.dt), gaps, forces, True)
    assert how.mean() <= 0.5
