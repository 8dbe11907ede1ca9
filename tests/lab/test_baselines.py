"""Rival methods: fixed steps against matrix exponentials, contacts of all against the integrators of the tests."""

import ast
from functools import cache
from itertools import pairwise
from math import hypot, inf, isnan, pi
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import oracle
import pytest
from oracle_rows import Answer, Row, integrate
from row_cases import CASES, CUT, SOIL, Shaking, jankowski, meeting, points_of, single, storeys
from scipy.linalg import expm

import pounding_risk.lab.baselines
from pounding_risk.lab.baselines import fixed_step as fixed
from pounding_risk.lab.baselines.matrices import row_matrices
from pounding_risk.lab.baselines.row_fixed_step import METHODS, solve_fixed_row
from pounding_risk.lab.baselines.solve_ivp import SOLVERS, Contacts, solve_general
from pounding_risk.lab.baselines.steppers import CentralDifference, Contact, Newmark, Rk4, contact_force, solve_force
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair.api import Interface, oscillators

pytestmark = pytest.mark.complete

# ------------------------------------------------------------------------------------------------ a pair
DT = 0.01  # s
LEFT, RIGHT = Building("left", 5e4, 0.3, 0.05), Building("right", 9e4, 0.15, 0.05)
GAP, E, STRENGTH = 1e-3, 0.6, 1.5e5
FOLLOWED = [name for name, law in LAWS.items() if not is_path_dependent(law)]  # by δ and δ̇ alone
STIFFNESS = {law: 2.5e8 if law in oracle.LINEAR else 1.05e10 for law in oracle.LAWS}
OPEN = 1e3  # m, a gap that stays open
QUICK = ("viscous_elastoplastic", "kelvin_voigt_tension_cut")


def ground(count: int = 250) -> np.ndarray:
    """Noise under a half-sine [m/s²]: in two and a half seconds thirty contacts or so, some of them yielding."""
    return np.random.default_rng(7).normal(size=count) * np.sin(np.pi * np.arange(count) / (count - 1)) * 3.0


@cache
def truth_of(name: str, count: int = 250, gap: float = GAP) -> dict[str, float]:
    """The tests' own integrator."""
    sides = oracle.Oscillator(LEFT.mass, LEFT.period), oracle.Oscillator(RIGHT.mass, RIGHT.period)
    scene = oracle.Scene(*sides, name, STIFFNESS[name], gap, E, STRENGTH if LAWS[name].capped else inf)
    return oracle.integrate(scene, ground(count), DT, rtol=1e-11)


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
    found = run(stepper, interface("linear", gap=OPEN), motion, pair)
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
        far = interface("linear", gap=1e300)
        rows = {name: run(stepper, far, motion, pair) for name, stepper in fixed.STEPPERS.items()}
        assert {name for name, row in rows.items() if row[fixed.UNSTABLE] or row[fixed.REACH] > 10.0} == unstable


# ------------------------------------------------------------------------------------------------- in contact
@pytest.mark.parametrize("method", fixed.STEPPERS)
@pytest.mark.parametrize("name", FOLLOWED)  # a kernel compiles for each
def test_contacts_of_fixed_steps_converge(name, method):
    """First order, as touches fall inside steps: measured errors are at most 40 h for h in seconds, over all laws."""
    truth = truth_of(name)
    assert truth["impact_count"] >= 5
    for h, error in ((1e-4, 1e-2), (1e-5, 1e-3), (1e-6, 1e-4)):
        motion = fixed.divided(ground(), DT, h)
        found = run(fixed.STEPPERS[method], interface(name), motion)
        peaks = [truth[f"peak_{what}"] for what in ("relative_displacement", "contact_force", "closing")]
        assert found[[fixed.REACH, fixed.FORCE, fixed.CLOSING]] == pytest.approx(peaks, rel=error), h
    assert found[fixed.COUNT] == truth["impact_count"]
    # Second order: contacts have not begun by then, and the line between two steps finds the crossing.
    assert found[fixed.FIRST] == pytest.approx(truth["first_impact_time"], rel=1e-9)
    # A step more or less at either end of each contact.
    ends = 2e-6 * truth["impact_count"]
    assert found[fixed.TOUCHING] * 1e-6 == pytest.approx(truth["contact_time"], abs=ends, rel=1e-3)
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


def test_the_implicit_force_of_linear_laws_is_a_fraction():
    """k (δ − c_δ F) + c (δ̇ − c_v F) = F: to rounding, whatever the guess."""
    k, c = 1e9, 3e6
    # δ and δ̇ at the end of a step without any force, and c_δ and c_v, what a force takes from them.
    for reach in ((1e-3, 0.5, 1e-9, 1e-6), (1e-6, 2.0, 1e-14, 1e-8), (1e-2, -0.5, 1e-10, 1e-7)):
        delta, rate, give, slow = reach
        for guess in (0.0, 1e3, 1e9):
            spring = solve_force(LAWS["linear"](k), Contact(0.0, np.inf, -np.inf, 0.0), reach, guess)
            assert spring == pytest.approx(k * delta / (1.0 + k * give), rel=1e-13)
            damped = solve_force(LAWS["kelvin_voigt"](k), Contact(0.0, np.inf, -np.inf, c), reach, guess)
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


# ------------------------------------------------------------------------------------------------ SciPy
ALIKE = ("peak_relative_displacement", "peak_closing", "peak_contact_force", "first_impact_time")


def solved(name: str, rtol: float, solver: str = "DOP853", gap: float = GAP) -> SimpleNamespace:
    strength = STRENGTH if LAWS[name].capped else inf
    there = Contacts(np.array([gap]), (LAWS[name](STIFFNESS[name]),), (constant(E),), np.array([strength]))
    row = row_matrices([chain_of(LEFT), chain_of(RIGHT)], points_of([meeting(0, 1.0, 1.0, 1e-3)]))
    found = solve_general(solver, row, there, (ground(150), DT), rtol)._asdict()
    return SimpleNamespace(**{key: np.asarray(value).item() for key, value in found.items()})


@pytest.mark.parametrize("name", FOLLOWED)
def test_every_law_by_scipy_agrees(name):
    """At rtol 1e-10; errors add up over a dozen contacts, and the force's crest is that of SciPy's interpolant."""
    found, right = solved(name, 1e-10), truth_of(name, 150)
    assert right["impact_count"] >= 5 and found.impact_count == right["impact_count"]
    for output in ALIKE:
        assert getattr(found, output) == pytest.approx(right[output], rel=1e-7), output
    if LAWS[name].capped:
        assert right["yield_demand"] > 1.0
        assert (found.uncapped_force >= STRENGTH) == (right["yield_demand"] >= 1.0)
    else:
        assert found.uncapped_force == found.peak_contact_force
    assert found.steps >= found.impact_count


@pytest.mark.parametrize("solver", SOLVERS)
def test_tighter_tolerances_are_closer(solver):
    """From 1e-3 to 1e-7 the errors of both peaks fall at least a hundredfold, and the steps grow."""
    right = truth_of("jankowski", 150)
    loose, tight = solved("jankowski", 1e-3, solver), solved("jankowski", 1e-7, solver)
    for name in ("peak_relative_displacement", "peak_contact_force"):
        errors = [abs(getattr(found, name) / right[name] - 1.0) for found in (loose, tight)]
        assert errors[1] < 1e-2 * errors[0] or errors[1] < 1e-9, name
        assert errors[1] < 1e-5, name
    assert tight.steps > loose.steps
    assert tight.impact_count == right["impact_count"]


def test_without_contact():
    """A gap that stays open, by its size or by being infinite: the free motion, and nothing of a contact."""
    right = truth_of("jankowski", 150, OPEN)
    for gap in (1e3, inf):
        found = solved("jankowski", 1e-9, gap=gap)
        assert found.peak_relative_displacement == pytest.approx(right["peak_relative_displacement"], rel=1e-8)
        assert found.peak_closing == pytest.approx(right["peak_closing"], rel=1e-8)
        assert (found.impact_count, found.peak_contact_force, found.steps) == (0.0, 0.0, 0.0)
        assert isnan(found.first_impact_time)


# ------------------------------------------------------------------------------------------------ rows
LAW = "kelvin_voigt_tension_cut"
CHAINS = CASES["storeys, single, storeys"].chains
# A column between floors, and two floors of one building that may touch at once.
MEETINGS = (meeting(0, 2.5, 1.0, 0.006, **CUT), meeting(1, 1.0, 2.0, 0.008, **CUT), meeting(1, 1.0, 1.0, 0.004, **CUT))
GAPS = np.array([each.gap for each in MEETINGS])
LAWS_THERE = (LAWS[LAW](2e8),) * len(MEETINGS)
RULES = (constant(E),) * len(MEETINGS)
ROW, THERE = row_matrices(CHAINS, points_of(MEETINGS)), Contacts(GAPS, LAWS_THERE, RULES, np.full(3, inf))


@pytest.fixture(scope="module")
def shaking() -> tuple[np.ndarray, float]:
    return Shaking("CCC-HN1", 24.0, 27.0, 0.5).samples()


@pytest.fixture(scope="module")
def truth(shaking) -> Answer:
    return integrate(CHAINS, MEETINGS, *shaking)


@pytest.mark.parametrize("name", ["5 and 3 storeys, floors against columns", "single, rigid, storeys", "soil"])
def test_matrices_are_those_of_the_tests(name):
    """The integrator of the tests builds its own, from the same masses, springs and floor numbers."""
    case = CASES[name]
    found, expected = row_matrices(case.chains, points_of(case.meetings)), Row(case.chains, case.meetings)
    assert found.mass == pytest.approx(1.0 / expected.inverse_mass, rel=1e-15)
    assert np.array_equal(found.damping, expected.damping)
    assert found.stiffness == pytest.approx(expected.drift.T @ np.diag(expected.spring) @ expected.drift, rel=1e-12)
    assert found.shares == pytest.approx(expected.b, abs=1e-12)
    assert found.striking == pytest.approx(1.0 / (expected.b**2 @ expected.inverse_mass), rel=1e-12)


def test_storeys_that_yield_have_no_matrix():
    chains = CASES["yielding storeys"].chains
    with pytest.raises(ValueError, match="no stiffness matrix"):
        row_matrices(chains, ())
    assert row_matrices(jankowski(SOIL), ()).mass.size == 8


@pytest.mark.parametrize("method", METHODS)
def test_contacts_of_rows_converge(method, shaking, truth):
    """First order, as touches fall inside steps: three contact points, two of them on the same building."""
    assert truth.points["impact_count"].min() >= 2
    bounds = GAPS, np.full(3, inf)
    for h, error in ((1e-4, 2e-2), (1e-5, 2e-3)):
        found = solve_fixed_row(method, ROW, LAWS_THERE, RULES, bounds, fixed.divided(*shaking, h))
        for column, name in ((fixed.CLOSING, "peak_closing"), (fixed.FORCE, "peak_contact_force")):
            assert found[:, column] == pytest.approx(truth.points[name], rel=error), (h, name)
        assert not found[:, fixed.UNSTABLE].any()
    assert np.array_equal(found[:, fixed.COUNT], truth.points["impact_count"])
    assert found[:, fixed.FIRST] == pytest.approx(truth.points["first_impact_time"], abs=1e-5)
    assert found[:, fixed.TOUCHING] * 1e-5 == pytest.approx(truth.points["contact_time"], rel=2e-3)


@pytest.mark.parametrize("method", METHODS)
def test_one_contact_point_is_that_of_a_pair(method):
    """The same steps as `fixed_step`, with matrices in place of periods: to rounding, grown over the contacts."""
    motion, there = fixed.Ground(ground(150), DT, 20), interface(LAW)
    expected = run(fixed.STEPPERS[method], there, motion)
    row = row_matrices([chain_of(LEFT), chain_of(RIGHT)], points_of([meeting(0, 1.0, 1.0, GAP)]))
    (found,) = solve_fixed_row(method, row, (there.law,), (constant(E),), ([GAP], [STRENGTH]), motion)
    assert expected[fixed.COUNT] >= 5 and found == pytest.approx(expected, rel=1e-9)


def test_a_step_beyond_the_stability_limit_is_unstable(shaking):
    """Central difference past h = 2/ω of a stiff storey; Newmark's method has no limit."""
    stiff = (storeys(2, 50e3, 4e9), single(150e3, 0.25))
    row = row_matrices(stiff, points_of([meeting(0, 1.5, 1.0, 0.006, **CUT)]))
    for method, unstable in (("central_difference", True), ("newmark", False)):
        motion = fixed.divided(*shaking, 1.0)
        found = solve_fixed_row(method, row, LAWS_THERE[:1], RULES[:1], ([1e3], [inf]), motion)
        assert (not np.isfinite(found[0, fixed.REACH]) or found[0, fixed.REACH] > 1.0 or found[0, -1] > 0) == unstable


@pytest.mark.parametrize(("solver", "rtol", "error"), [("DOP853", 1e-10, 1e-7), ("Radau", 1e-6, 1e-4)])
def test_scipy_agrees_with_the_integrator_of_the_tests(solver, rtol, error, shaking, truth):
    """Another search for events: errors add up over the contacts, force crests are those of SciPy's interpolant."""
    found = solve_general(solver, ROW, THERE, shaking, rtol)
    assert np.array_equal(found.impact_count, truth.points["impact_count"])
    for name in ("peak_closing", "peak_contact_force", "first_impact_time"):
        assert getattr(found, name) == pytest.approx(truth.points[name], rel=error), name
    assert found.steps >= found.impact_count.max()


def test_a_ground_motion_that_is_not_finite_is_refused(shaking):
    a = shaking[0].copy()
    a[20] = np.nan
    with pytest.raises(ValueError, match="sample 20 of the ground motion is not finite"):
        solve_general("DOP853", ROW, THERE, (a, shaking[1]), 1e-6)


# ------------------------------------------------------------------------------------------- where they may stand
PACKAGE = Path(pounding_risk.lab.baselines.__file__).parents[2]


def modules_of(file: Path) -> set[str]:
    """Every module that a file imports from, whole names."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module or "")
    return found


@pytest.mark.parametrize("file", sorted((PACKAGE / "lab" / "baselines").glob("*.py")), ids=lambda file: file.stem)
def test_rivals_share_nothing_with_the_solver_but_laws_and_buildings(file):
    """No kernel of the solver, nothing that reads or draws: a rival that borrowed its events would be none."""
    plain = {"__future__", "collections.abc", "math", "typing", "numpy", "numpy.typing", "scipy.integrate"}
    plain |= {"pounding_risk._jit.compile", "pounding_risk._jit.memory", "pounding_risk.lab.baselines"}
    for module in modules_of(file) - plain:
        assert module.startswith(("pounding_risk.lab.baselines.", "pounding_risk.models.")), module


def test_the_solver_uses_no_rival():
    for folder in ("solver/pair", "solver/row", "models"):
        for file in (PACKAGE / folder).rglob("*.py"):
            assert not any("baselines" in module for module in modules_of(file)), file.name
