"""The fixed-step methods: their order against matrix exponentials, contact against an integrator of the tests."""

from __future__ import annotations

from itertools import pairwise
from math import hypot, isnan, pi
from typing import NamedTuple

import numpy as np
import oracle
import pytest
from scipy.linalg import expm

from pounding_risk.lab.baselines import fixed_step as fixed
from pounding_risk.lab.baselines.steppers import CentralDifference, Contact, Newmark, Rk4, contact_force, solve_force
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair.api import Interface, oscillators

DT = 0.01  # s
LEFT, RIGHT = Building("left", 5e4, 0.3, 0.05), Building("right", 9e4, 0.15, 0.05)
GAP, E, STRENGTH = 1e-3, 0.6, 1.5e5
FOLLOWED = [name for name, law in LAWS.items() if not is_path_dependent(law)]  # by δ and δ̇ alone
STIFFNESS = {law: 2.5e8 if law in oracle.LINEAR else 1.05e10 for law in oracle.LAWS}
APART = 1e3  # m, a gap that stays open
QUICK = ("viscous_elastoplastic", "kelvin_voigt_tension_cut")


def ground() -> np.ndarray:
    """Two and a half seconds of noise under a half-sine [m/s²]: thirty contacts or so, some of them yielding."""
    return np.random.default_rng(7).normal(size=250) * np.sin(np.pi * np.arange(250) / 249.0) * 3.0


def smooth_ground() -> np.ndarray:
    """A swelling sine whose corners are at the samples, not zero at the start [m/s²]."""
    time = np.arange(201) * DT
    return 2.0 * (0.3 + time) * np.cos(2.0 * pi * 1.4 * time)


def interface(name: str, yield_force: float = STRENGTH, gap: float = GAP) -> Interface:
    return Interface(gap, LAWS[name](STIFFNESS[name]), constant(E), yield_force)


def run(stepper, there: Interface, motion: fixed.Ground, pair=None) -> np.ndarray:
    """All columns of one run."""
    out = np.zeros(fixed.COLUMNS)
    limits = (float(there.gap), float(there.yield_force), there.restitution)
    fixed.march_fixed(stepper, pair or oscillators(LEFT, RIGHT), there.law, limits, motion, out)
    return out


# --------------------------------------------------------------------------------------------- without contact
def displacements(building: Building, motion: fixed.Ground) -> np.ndarray:
    """u at every step, from the matrix exponential of the state with the ramp appended: exact."""
    omega = 2.0 * pi / building.period
    system = np.zeros((4, 4))
    system[0, 1] = system[2, 3] = 1.0
    system[1] = -(omega**2), -2.0 * building.damping * omega, -1.0, 0.0
    a, dt, parts = motion
    step, y, found = expm(system * dt / parts), np.zeros(4), [0.0]
    for first, last in pairwise(a):
        y[2:] = first, (last - first) / dt
        for _ in range(parts):
            y = step @ y
            found.append(y[0])
    return np.array(found)


def free_error(stepper, parts: int, pair=None) -> float:
    """Relative error of the largest relative displacement at the steps."""
    motion = fixed.Ground(smooth_ground(), DT, parts)
    exact = np.abs(displacements(LEFT, motion) - displacements(RIGHT, motion)).max()
    found = run(stepper, interface("linear", gap=APART), motion, pair)
    assert (found[fixed.COUNT], found[fixed.FORCE], found[fixed.TOUCHING]) == (0.0, 0.0, 0.0)
    assert isnan(found[fixed.FIRST])
    return float(abs(found[fixed.REACH] / exact - 1.0))


def observed_order(stepper, pair=None) -> float:
    """The power of the step with which the error falls, from 8 to 64 steps a sample."""
    return float(np.log2(free_error(stepper, 8, pair) / free_error(stepper, 64, pair)) / 3.0)


@pytest.mark.parametrize("stepper", [Rk4(), Newmark(), CentralDifference(), Newmark(1.0 / 6.0, 0.5)])
def test_each_method_has_its_order_in_free_vibration(stepper):
    """Measured 3.88 and 1.98 to 2.02: one peak's error has terms of two buildings, which may cancel in part."""
    assert observed_order(stepper) == pytest.approx(stepper.order, abs=0.2)
    assert free_error(stepper, 64) < 1e-5


def test_wrong_methods_are_seen_to_be_wrong():
    """With γ = 0.6 Newmark's method has order 1; with half the damping no step is small enough."""
    assert observed_order(Newmark(0.3025, 0.6)) == pytest.approx(1.0, abs=0.2)
    wrong = oscillators(LEFT._replace(damping=0.025), RIGHT._replace(damping=0.025))
    assert abs(observed_order(Rk4(), wrong)) < 0.1
    assert free_error(Rk4(), 64, wrong) > 1e-2


def test_the_stability_limit_of_the_explicit_methods():
    """In free vibration central difference blows up past ωh = 2, Runge-Kutta past 2.83, Newmark never."""
    motion = fixed.Ground(np.tile(smooth_ground(), 10), DT, 1)
    for omega_h, unstable in ((1.9, set()), (2.1, {"central_difference"}), (3.0, {"central_difference", "rk4"})):
        pair = oscillators(LEFT, RIGHT._replace(period=2.0 * pi * DT / omega_h, damping=0.0))
        rows = {
            name: run(stepper, interface("linear", gap=1e300), motion, pair) for name, stepper in fixed.STEPPERS.items()
        }
        assert {name for name, row in rows.items() if row[fixed.UNSTABLE] or row[fixed.REACH] > 10.0} == unstable


# ------------------------------------------------------------------------------------------------- in contact
@pytest.fixture(scope="module")
def truths() -> dict[str, dict[str, float]]:
    """The tests' own integrator, by law; filled when asked."""
    return {}


def truth_of(name: str, kept: dict[str, dict[str, float]]) -> dict[str, float]:
    if name not in kept:
        sides = oracle.Oscillator(LEFT.mass, LEFT.period), oracle.Oscillator(RIGHT.mass, RIGHT.period)
        strength = STRENGTH if LAWS[name].capped else np.inf
        kept[name] = oracle.integrate(
            oracle.Scene(*sides, name, STIFFNESS[name], GAP, E, strength), ground(), DT, rtol=1e-11
        )
    return kept[name]


def slow_but(quick: tuple[str, ...]) -> list:
    """Every law, those past the quick ones marked slow: a kernel compiles for each."""
    return [name if name in quick else pytest.param(name, marks=pytest.mark.slow) for name in FOLLOWED]


@pytest.mark.parametrize("method", fixed.STEPPERS)
@pytest.mark.parametrize("name", slow_but(QUICK))
def test_contacts_converge_to_the_integrator_of_the_tests(name, method, truths):
    """First order, as touches fall inside steps: measured errors are at most 40 h for h in seconds, over all laws."""
    truth = truth_of(name, truths)
    assert truth["impact_count"] >= 5
    for h, error in ((1e-4, 1e-2), (1e-5, 1e-3), (1e-6, 1e-4)):
        motion = fixed.divided(ground(), DT, h)
        found = run(fixed.STEPPERS[method], interface(name), motion)
        reach, force, closing = found[[fixed.REACH, fixed.FORCE, fixed.CLOSING]]
        assert reach == pytest.approx(truth["peak_relative_displacement"], rel=error), h
        assert force == pytest.approx(truth["peak_contact_force"], rel=error), h
        assert closing == pytest.approx(truth["peak_closing"], rel=error), h
    assert found[fixed.COUNT] == truth["impact_count"]
    # Second order: contacts have not begun by then, and the line between two steps finds the crossing.
    assert found[fixed.FIRST] == pytest.approx(truth["first_impact_time"], rel=1e-9)
    # A step more or less at either end of each contact.
    assert found[fixed.TOUCHING] * 1e-6 == pytest.approx(
        truth["contact_time"], abs=2e-6 * truth["impact_count"], rel=1e-3
    )
    if LAWS[name].capped:
        assert found[fixed.DEMAND] / STRENGTH == pytest.approx(truth["yield_demand"], rel=error)
        assert truth["yield_demand"] > 1.0


def plainly(name: str, motion: fixed.Ground) -> tuple[float, float, int]:
    """Runge-Kutta 4 as a textbook has it: the damping constant made at every step apart, whether needed or not."""
    (left, right), there, strength = oscillators(LEFT, RIGHT), interface(name), STRENGTH
    law, (a, dt, parts) = there.law, motion
    contact = Contact(GAP, law.ceiling(strength), law.floor(), 0.0)
    h, y, touching = dt / parts, np.zeros(4), False
    reach, peak, count = 0.0, 0.0, 0

    def slope(a_g: float, y: np.ndarray, contact: Contact) -> np.ndarray:
        force = contact_force(law, contact, y[0] - y[1] - GAP, y[2] - y[3])
        pulls = [-a_g - b.two_zeta_omega * v - b.omega2 * u for b, u, v in ((left, y[0], y[2]), (right, y[1], y[3]))]
        return np.array([y[2], y[3], pulls[0] - left.inverse_mass * force, pulls[1] + right.inverse_mass * force])

    for first, last in pairwise(a):
        for part in range(parts):
            if not touching:
                speed = max(y[2] - y[3], 0.0)
                mass = 1.0 / (left.inverse_mass + right.inverse_mass)
                contact = contact._replace(memory=law.begin(E, speed, mass))
            early, middle, late = (first + (last - first) * (part + x) / parts for x in (0.0, 0.5, 1.0))
            k1 = slope(early, y, contact)
            k2 = slope(middle, y + 0.5 * h * k1, contact)
            k3 = slope(middle, y + 0.5 * h * k2, contact)
            k4 = slope(late, y + h * k3, contact)
            y = y + h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
            delta = y[0] - y[1] - GAP
            reach = max(reach, abs(y[0] - y[1]))
            if delta > 0.0:
                peak = max(peak, contact_force(law, contact, delta, y[2] - y[3]))
            count += delta > 0.0 and not touching
            touching = delta > 0.0
    return reach, peak, count


@pytest.mark.parametrize("name", QUICK)
def test_a_damping_constant_is_made_where_it_is_needed(name):
    """Steps of a sample and of a quarter: touches that a step's stages see and its end does not are among them."""
    for parts in (1, 4):
        motion = fixed.Ground(ground(), DT, parts)
        found = run(Rk4(), interface(name), motion)
        reach, peak, count = plainly(name, motion)
        assert found[fixed.COUNT] == count
        # The same arithmetic in another order: rounding, grown over the contacts.
        assert (found[fixed.REACH], found[fixed.FORCE]) == pytest.approx((reach, peak), rel=1e-9)


class Reach(NamedTuple):
    """A state at the end of a step as it would be without any force, and what a force takes from it."""

    delta: float
    rate: float
    give: float
    slow: float


def test_the_implicit_force_of_linear_laws_is_a_fraction():
    """k (δ − c_δ F) + c (δ̇ − c_v F) = F: to rounding, whatever the guess."""
    k, c = 1e9, 3e6
    for reach in (Reach(1e-3, 0.5, 1e-9, 1e-6), Reach(1e-6, 2.0, 1e-14, 1e-8), Reach(1e-2, -0.5, 1e-10, 1e-7)):
        delta, rate, give, slow = reach
        for guess in (0.0, 1e3, 1e9):
            spring = solve_force(LAWS["linear"](k), Contact(0.0, np.inf, -np.inf, 0.0), tuple(reach), guess)
            assert spring == pytest.approx(k * delta / (1.0 + k * give), rel=1e-13)
            damped = solve_force(LAWS["kelvin_voigt"](k), Contact(0.0, np.inf, -np.inf, c), tuple(reach), guess)
            exact = (k * delta + c * rate) / (1.0 + k * give + c * slow)
            assert damped == pytest.approx(exact, rel=1e-12, abs=1e-13 * hypot(k * delta, c * rate))


@pytest.mark.parametrize("name", ["hertz", "jankowski", "viscous_elastoplastic", "hertz_damp", "van_mier"])
def test_the_implicit_force_solves_its_equation(name):
    """The root lies within rounding, 1e-12 of the force that the full penetration would give."""
    law, random = LAWS[name](4.2e10), np.random.default_rng(3)
    solved = 0
    for _ in range(300):
        speed, strength = float(np.exp(random.uniform(-7.0, 1.0))), float(np.exp(random.uniform(8.0, 16.0)))
        contact = Contact(0.0, law.ceiling(strength), -np.inf, law.begin(0.6, speed, 3e4))
        delta, rate = float(np.exp(random.uniform(-18.0, -5.0))), speed * random.uniform(-1.0, 1.0)
        give, slow = np.exp(random.uniform(-28.0, -22.0)), np.exp(random.uniform(-22.0, -14.0))

        def miss(force, reach=(delta, rate, give, slow), contact=contact):
            return force - contact_force(law, contact, reach[0] - reach[2] * force, reach[1] - reach[3] * force)

        full = contact_force(law, contact, delta, rate)
        force = solve_force(law, contact, (delta, rate, give, slow), random.uniform(0.0, 1e6))
        near = 1e-12 * full
        assert miss(force - near) <= 0.0 <= miss(force + near), (delta, rate, give, slow)
        solved += near < force < full - near
    assert solved > 100  # the others are at either end, where the step is short or far too long


# ----------------------------------------------------------------------------------------------------- the grid
def test_the_grid_is_its_runs():
    """Every gap and yield force of a sweep, to the bit."""
    gaps, forces = np.array([0.0, 1e-3, 1e-2]), np.array([1e5, np.inf])
    law, motion = LAWS["viscous_elastoplastic"](STIFFNESS["jankowski"]), fixed.divided(ground(), DT, 1e-3)
    out = np.zeros((3, 2, fixed.COLUMNS))
    fixed.sweep_fixed(Rk4(), oscillators(LEFT, RIGHT), law, (gaps, forces, constant(E)), motion, out)
    for place in np.ndindex(3, 2):
        alone = run(Rk4(), Interface(gaps[place[0]], law, constant(E), forces[place[1]]), motion)
        assert np.array_equal(alone, out[place], equal_nan=True)
    assert np.all(out[:2, :, fixed.COUNT] >= 5.0)


def test_steps_divide_samples():
    """About the step asked for, a whole number of them a sample, never more than a sample."""
    for h, parts in ((1e-2, 1), (1e-3, 10), (3e-3, 3), (1.0, 1), (1e-6, 10_000)):
        assert fixed.divided(ground(), DT, h).parts == parts
    found = fixed.divided([0, 1, 2], DT, 1e-3)
    assert found.acceleration.dtype == np.float64
