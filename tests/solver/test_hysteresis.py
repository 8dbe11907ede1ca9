"""Storeys with laws of their own: loops against OpenSees and a formula, motions against integrators and energy."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import inf, pi, sin, sqrt
from typing import Any

import numpy as np
import pytest
from oracle_rows import Meeting
from row_cases import contacts_of, points_of
from scenes import rigid, scene_text, single, storeyed
from scipy.integrate import quad, solve_ivp
from scipy.optimize import brentq
from sweeps import sweep

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.hysteresis import Hysteresis, forces_along
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.results.opened import Results
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.counters import COLLAPSED
from pounding_risk.solver.row.api import COLLAPSE_TIME, RowRun, free_row, run_row
from pounding_risk.solver.row.layout import lay_out

SOFTENING = ((4.0, 1.2), (10.0, 0.4))
PINCHED = Hysteresis("peak_oriented", SOFTENING, pinching_drift=0.5, pinching_force=0.3, unloading=0.4)
STIFFNESS, STRENGTH = 100.0, 100.0  # N/m, N of the loops: they yield at 1 m


# --------------------------------------------------------------------------------------------------- loops


def loop(law: Hysteresis, drifts: Sequence[float]) -> np.ndarray:
    """Shears at drifts that are followed in turn, each straight from the one before."""
    return forces_along(law.numbers(STIFFNESS, STRENGTH, inf), np.asarray(drifts, dtype=float))


def wandering(seed: int, turns: int = 20, reach: float = 8.0, steps: int = 400) -> np.ndarray:
    """Drifts between turns drawn at random, in steps."""
    ends = [0.0, *np.random.default_rng(seed).uniform(-reach, reach, turns)]
    return np.concatenate([np.linspace(start, stop, steps + 1)[1:] for start, stop in pairwise(ends)])


def hysteretic(pinch_drift: float, pinch_force: float, unloading: float) -> tuple[Any, ...]:
    points = (100.0, 1.0, 120.0, 4.0, 40.0, 10.0)
    return ("Hysteretic", *points, *(-number for number in points), pinch_drift, pinch_force, 0.0, 0.0, unloading)


IN_OPENSEES: dict[str, tuple[Hysteresis, tuple[Any, ...]]] = {
    "peak_oriented": (Hysteresis("peak_oriented", SOFTENING), hysteretic(1.0, 1.0, 0.0)),
    "pinched": (replace(PINCHED, unloading=0.0), hysteretic(0.5, 0.3, 0.0)),
    "softer unloading": (PINCHED, hysteretic(0.5, 0.3, 0.4)),
    "isotropic": (Hysteresis("isotropic", hardening=0.05), ("Hardening", 100.0, 100.0, 100.0 * 0.05 / 0.95, 0.0)),
    "kinematic": (
        Hysteresis("kinematic", ((2.0, 1.3), (6.0, 1.5))),
        ("MultiLinear", 1.0, 100.0, 2.0, 130.0, 6.0, 150.0, 1000.0, 150.0),
    ),
}


def forces_in_opensees(ops: Any, material: tuple[Any, ...], drifts: np.ndarray, steps: int = 1) -> np.ndarray:
    """Of a material, its kind and its numbers, at drifts that are followed in turn, each in so many steps."""
    kind, *numbers = material
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    ops.uniaxialMaterial(kind, 1, *numbers)
    ops.testUniaxialMaterial(1)
    found = []
    for before, drift in pairwise([0.0, *drifts.tolist()]):
        for between in np.linspace(before, drift, steps + 1)[1:]:
            ops.setStrain(float(between))
        found.append(ops.getStress())
    return np.array(found)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("name", IN_OPENSEES)
def test_its_loops_are_those_of_opensees(ops: Any, name: str, seed: int):
    """Drift by drift, all straight lines: rounding. A step across zero shear, where it takes one slope, may differ."""
    law, material = IN_OPENSEES[name]
    drifts = wandering(seed)
    off = np.abs(loop(law, drifts) - forces_in_opensees(ops, material, drifts))
    assert (off > 1e-10).sum() <= 2 and off.max() < 0.2


def losing(kind: str, stiffness: float, strength: float, capacity: float, exponent: float) -> tuple[Any, ...]:
    """A flat backbone, reloaded to its peaks, whose yield shear alone falls with the energy; a capacity over V_y d_y.

    ModIMKPeakOriented takes the falling branch away at once where its capacity is 0, which should switch its loss off.
    """
    limit = strength / stiffness
    if kind == "IMKPeakOriented":
        side = (200.0 * limit, 1e4 * limit, 1e5 * limit, strength, 1.0, 0.0)
        return kind, stiffness, *side, *side, capacity * limit, 0, 0, 0, exponent, 1, 1, 1, 1, 1
    ends = (number * limit for number in (200.0, 200.0, 1e4, 1e4))
    capacities = capacity * limit, 1e12 * limit, 0.0, 0.0
    last = 0.0, 0.0, 1e5 * limit, 1e5 * limit, 1.0, 1.0
    return kind, stiffness, 0.0, 0.0, strength, -strength, *capacities, exponent, 1.0, 1.0, 1.0, *ends, *last


LOSING = "IMKPeakOriented", "ModIMKPeakOriented"


@pytest.mark.parametrize("kind", LOSING)
@pytest.mark.parametrize("exponent", [1.0, 1.5])
@pytest.mark.parametrize("capacity", [60.0, 400.0])
def test_its_loss_of_strength_is_that_of_opensees(ops: Any, capacity: float, exponent: float, kind: str):
    """Growing cycles on a flat backbone, where the loss is of the yield shear alone.

    OpenSees takes the energy to the end of the step in which the shear passes zero: some 1e-5 with 400 a branch. In
    that step the older material has a mean slope, once a branch.
    """
    ends = [0.0, *(sign * (1.5 + 0.5 * cycle) for cycle in range(8) for sign in (1.0, -1.0))]
    drifts = np.concatenate([np.linspace(start, stop, 401)[1:] for start, stop in pairwise(ends)])
    known = forces_in_opensees(ops, losing(kind, STIFFNESS, STRENGTH, capacity, exponent), drifts)
    law = Hysteresis("peak_oriented", energy_capacity=capacity, energy_exponent=exponent)
    assert abs(known[-1]) < 99.9
    off = np.abs(loop(law, drifts) - known)
    assert (off > 1e-3).sum() <= len(ends) and off.max() < 0.02


SMOOTH: dict[str, dict[str, float]] = {
    "n = 1": {"exponent": 1.0, "beta": 0.5},
    "n = 5": {"exponent": 5.0, "beta": 0.3},
    "degrading": {"exponent": 2.0, "beta": 0.7, "delta_a": 0.005, "delta_nu": 0.05, "delta_eta": 0.05},
}


def bouc_wen(parameters: dict[str, float]) -> Hysteresis:
    return Hysteresis("bouc_wen", hardening=0.05, **parameters)


@pytest.mark.parametrize("name", SMOOTH)
def test_chords_of_bouc_wen_come_to_the_curve_of_opensees(ops: Any, name: str):
    """Chords are off by 2e-4 of the yield shear at most, OpenSees' implicit steps by as much with 20 a step."""
    given = SMOOTH[name]
    n, beta = given["exponent"], given["beta"]
    losses = [given.get(key, 0.0) / STRENGTH for key in ("delta_a", "delta_nu", "delta_eta")]
    material = ("BoucWen", 0.05, STIFFNESS, n, 1.0 - beta, beta, 1.0, *losses, 1e-12, 50)
    drifts = wandering(1, 10, 5.0)
    known = forces_in_opensees(ops, material, drifts, steps=20)
    np.testing.assert_allclose(loop(bouc_wen(given), drifts), known, rtol=0.0, atol=5e-4 * STRENGTH)


class Formula:
    """The shear of a peak-oriented storey from drift to drift: the lesser of an elastic step and the path's line."""

    def __init__(self, law: Hysteresis) -> None:
        self.law, self.points = law, ((1.0, 1.0), *law.backbone)
        self.drift = self.shear = 0.0
        self.peak, self.left, self.side = {1: 1.0, -1: 1.0}, {1: 1.0, -1: 1.0}, 0
        self.work = self.spent = self.start = 0.0
        self.target = 1.0

    def backbone(self, drift: float, side: int) -> float:
        drifts, shears = zip((0.0, 0.0), *self.points, strict=True)
        if not self.law.backbone:
            return self.left[side] * (1.0 + self.law.hardening * (drift - 1.0))
        return self.left[side] * float(np.interp(drift, drifts, shears))

    def move(self, drift: float) -> None:
        """Shears and drifts in multiples of those at yield, small steps."""
        side = 1 if drift > self.drift else -1
        if self.side == 0:
            self.side = side
        unloading = self.peak[self.side] ** -self.law.unloading
        elastic = self.shear + unloading * (drift - self.drift)
        before = self.shear
        if side != self.side and elastic * self.side <= 0.0:
            zero = self.drift - self.shear / unloading
            self.work += 0.5 * self.shear * (zero - self.drift)
            self.drift, self.shear, before = zero, 0.0, 0.0
            spent, self.spent = self.work - self.spent, self.work
            self.side, self.start = side, side * zero
            if self.law.energy_capacity < inf:
                lost = min(spent / max(self.law.energy_capacity - self.work, spent), 1.0)
                self.left[side] *= 1.0 - lost**self.law.energy_exponent
            self.target = self.peak[side]
            elastic = self.peak[side] ** -self.law.unloading * (drift - zero)
        self.shear = elastic
        if side == self.side:
            self.shear = side * min(side * elastic, self.path(side * drift, side))
        self.work += 0.5 * (before + self.shear) * (drift - self.drift)
        self.drift = drift

    def path(self, reach: float, side: int) -> float:
        if reach >= self.peak[side] and reach >= self.target:
            self.peak[side] = self.target = reach
            return self.backbone(reach, side)
        top = self.backbone(self.target, side)
        pinch_shear = self.law.pinching_force * top
        elastic = self.target - (top - pinch_shear) / self.peak[side] ** -self.law.unloading
        pinch = self.start + (elastic - self.start) * self.law.pinching_drift
        if reach < pinch:
            return pinch_shear * (reach - self.start) / (pinch - self.start)
        return pinch_shear + (top - pinch_shear) * (reach - pinch) / (self.target - pinch)


@pytest.mark.parametrize("capacity", [inf, 60.0])
@pytest.mark.parametrize("seed", range(2))
def test_its_loops_are_those_of_a_formula(seed: int, capacity: float):
    """Steps of 0.01 to 0.05 of the yield drift: the formula meets corners within a step, and strength by its energy."""
    law = replace(PINCHED, energy_capacity=capacity)
    drifts = wandering(seed, turns=12, reach=5.0, steps=1000)
    formula, known = Formula(law), []
    for drift in drifts:
        formula.move(float(drift))
        known.append(STRENGTH * formula.shear)
    assert capacity == inf or min(formula.left.values()) < 0.92
    np.testing.assert_allclose(loop(law, drifts), known, atol=0.01 * STRENGTH)


def test_strength_falls_by_the_energy_of_each_half_cycle():
    """Full cycles of ± 2 d_y without hardening: the loop encloses what two lines and the unloading leave, by hand."""
    law = Hysteresis("peak_oriented", ((2.0, 1.0),), energy_capacity=20.0, energy_exponent=2.0)
    shears = loop(law, [2.0, -2.0]) / STRENGTH
    # Until zero shear at d = 1 work is 1/2 + 1 - 1/2 = 1 of V_y d_y: lost is (1 / 19)^2.
    assert shears[1] == pytest.approx(-(1.0 - (1.0 / 19.0) ** 2), rel=1e-14)


def test_without_energy_left_a_storey_has_no_strength():
    law = Hysteresis("peak_oriented", ((2.0, 1.0),), energy_capacity=1.5)
    assert loop(law, [3.0, -3.0, 5.0])[1:].tolist() == [0.0, 0.0]


# ------------------------------------------------------------------------------------------------- motions

TIME = np.arange(0.0, 6.0, 0.01)
SHAKING = 4.0 * np.sin(2.0 * pi * 1.3 * TIME) * np.exp(-0.15 * TIME) + np.random.default_rng(3).normal(size=TIME.size)


def building(law: Hysteresis | None, count: int = 3, damping: float = 0.05, **more: Any) -> Storeys:
    strengths = (4e5, 3e5, 2e5)[:count]
    fields = {"strengths": strengths, "hysteresis": law, "damping": damping} | more
    return Storeys("A", (1e5,) * count, (5e7,) * count, (3.0,) * count, **fields)


def shaken(one: Storeys, hardening: float = 0.03, effects: Sequence[Any] = ()) -> RowRun:
    chain = chain_of(one, [("inelastic_storeys", [("hardening", hardening)]), *effects])
    return free_row(lay_out([chain], [], 0.01), SHAKING, states=True)


def test_a_kinematic_line_is_the_bilinear_storey():
    """Both are exact between events: rounding, some 1e4 operations on."""
    bilinear, law = shaken(building(None)), shaken(building(Hysteresis("kinematic")))
    assert bilinear.floors[:, 1].max() * 5e7 / 4e5 > 5.0
    np.testing.assert_allclose(law.states, bilinear.states, rtol=0.0, atol=1e-10 * np.abs(bilinear.states).max())
    np.testing.assert_allclose(law.floors, bilinear.floors, rtol=1e-10)


@pytest.mark.parametrize("rule", ["kinematic", "isotropic", "peak_oriented"])
def test_a_storey_that_never_yields_has_no_residual_drift_and_takes_no_energy(rule: str):
    """Not the rounding of either: ratios of residual drifts with contact and without would be 1e19."""
    run = shaken(building(Hysteresis(rule, BARRIER if rule != "kinematic" else ()), strengths=(4e9, 2e9, 3e9)))
    assert (run.floors[:, 1] > 1e-3).all()
    assert (run.rest[:, 1:3] == 0.0).all()


def stepped(law: Hysteresis, parts: int) -> np.ndarray:
    """Displacements of one storey at the samples by central differences, in steps of a sample over ``parts``."""
    stiffness, strength, mass = 5e7, 4e5, 1e5
    step, dashpot, formula = 0.01 / parts, 2.0 * 0.05 * sqrt(stiffness * mass), Formula(law)
    ground = np.interp(np.arange(0, (TIME.size - 1) * parts + 1) * step, TIME, SHAKING)
    before = now = 0.0
    found = [0.0]
    for n, pull in enumerate(ground[:-1]):
        formula.move(now * stiffness / strength) if n else None
        rate_share = dashpot / (2.0 * step)
        push = -mass * pull - strength * formula.shear + 2.0 * mass / step**2 * now
        following = (push - (mass / step**2 - rate_share) * before) / (mass / step**2 + rate_share)
        if n == 0:  # at rest: u(h) = ü h² / 2
            following = -0.5 * step**2 * pull
        before, now = now, following
        if (n + 1) % parts == 0:
            found.append(now)
    return np.array(found)


def test_a_pinched_storey_that_loses_strength_is_an_own_integration_of_the_formula():
    """Central differences fall with the square of their step, from 1e-3 of the peak; the runs are exact."""
    law = replace(PINCHED, energy_capacity=60.0)
    run = shaken(building(law, 1))
    peak = np.abs(run.states[:, 0, 0]).max()
    parts = (run.states.shape[0] - 1) // (TIME.size - 1)
    coarse, fine = (np.abs(stepped(law, n) - run.states[::parts, 0, 0]).max() / peak for n in (20, 80))
    assert run.rest[0, 3] < 0.97 and run.floors[0, 1] > 4.0 * 4e5 / 5e7
    assert coarse < 5e-3 and fine < 0.15 * coarse, (coarse, fine)


@pytest.mark.parametrize("name", sweep(SMOOTH, "degrading"))
def test_a_bouc_wen_storey_is_an_own_integration_of_its_equation(name: str):
    """DOP853 of (u, v, ζ, e): chords of 2e-4 of the yield shear move the peak by a few of that."""
    given, mass, stiffness, strength = SMOOTH[name], 1e5, 5e7, 4e5
    losses = [given.get(key, 0.0) for key in ("delta_a", "delta_nu", "delta_eta")]
    yields, dashpot = strength / stiffness, 2.0 * 0.05 * sqrt(stiffness * mass)

    def slope(t: float, y: np.ndarray) -> list[float]:
        u, v, part, energy = y
        rate = v / yields
        opening = 1.0 - given["beta"] + given["beta"] * np.sign(part * rate)
        loss_a, loss_nu, loss_eta = (share * energy for share in losses)
        grown = (1.0 - loss_a - (1.0 + loss_nu) * abs(part) ** given["exponent"] * opening) / (1.0 + loss_eta)
        shear = 0.05 * stiffness * u + 0.95 * strength * part
        return [v, -(shear + dashpot * v) / mass - np.interp(t, TIME, SHAKING), grown * rate, 0.95 * part * rate]

    ends = TIME[:: TIME.size // 12]
    state, known = np.zeros(4), [0.0]
    for start, stop in pairwise(ends):
        part = solve_ivp(slope, (start, stop), state, "DOP853", rtol=1e-9, atol=1e-12, max_step=0.01)
        state = part.y[:, -1]
        known.append(state[0])
    run = shaken(building(bouc_wen(given), 1), 0.05)
    step = (run.states.shape[0] - 1) // (TIME.size - 1)
    found = run.states[:: step * (TIME.size // 12), 0, 0][: len(known)]
    np.testing.assert_allclose(found, known, rtol=0.0, atol=5e-4 * np.abs(known).max())
    assert run.floors[0, 1] > 2.5 * yields
    state = solve_ivp(slope, (ends[-1], TIME[-1]), state, "DOP853", rtol=1e-9, atol=1e-12, max_step=0.01).y[:, -1]
    left = ((1.0 - losses[0] * state[3]) / (1.0 + losses[1] * state[3])) ** (1.0 / given["exponent"])
    assert run.rest[0, 3] == pytest.approx(left, abs=5e-4)  # of energy, as of drifts
    assert (left < 0.8) == (name == "degrading")


@pytest.mark.parametrize("rule", ["kinematic", "isotropic", "peak_oriented"])
def test_what_a_free_vibration_begins_with_is_left_or_dissipated(rule: str):
    """½ m v² = ½ m v² + V² / 2 k + what the storey has dissipated, without damping, to rounding."""
    law = Hysteresis(rule, ((3.0, 1.2),))
    one = building(law, 1, damping=0.0, initial_velocity=(2.0,))
    chain = chain_of(one, [("inelastic_storeys", [])])
    run = free_row(lay_out([chain], [], 0.01), np.zeros(400), states=True)
    left = 0.5 * 1e5 * run.states[-1, 1, 0] ** 2
    back = 0.5 * 5e7 * (run.rest[0, 0] - run.rest[0, 1]) ** 2  # at its elastic stiffness to zero shear
    assert run.rest[0, 2] > 0.3 * 0.5 * 1e5 * 4.0
    assert left + back + run.rest[0, 2] == pytest.approx(0.5 * 1e5 * 4.0, rel=1e-11)


BARRIER = ((2.0, 1.0), (40.0, 0.02))  # of a storey under P-delta: past its local maximum it falls


def critical_speed() -> float:
    """The speed [m/s] that brings the storey to where its shear is the P d / h that pulls it on, by the work."""
    drifts, shears = np.array([0.0, 0.008, 0.016, 0.32]), np.array([0.0, 4e5, 4e5, 8e3])
    pull = 9.80665 * 1e5 / 3.0  # N/m
    local_maximum = brentq(lambda drift: np.interp(drift, drifts, shears) - pull * drift, 0.016, 0.32)
    corners = np.append(drifts[:3], local_maximum)
    work = np.trapezoid(np.interp(corners, drifts, shears), corners) - 0.5 * pull * local_maximum**2
    return sqrt(2.0 * work / 1e5)


@pytest.mark.parametrize("rule", ["peak_oriented", "isotropic"])
@pytest.mark.parametrize(("share", "status"), [(1.0 - 1e-6, 0), (1.0 + 1e-6, COLLAPSED)])
def test_a_storey_collapses_where_its_speed_brings_it_past_its_crest(rule: str, share: float, status: int):
    """Without damping and ground motion: work decides, to the share that is given."""
    one = building(Hysteresis(rule, BARRIER), 1, damping=0.0, initial_velocity=(share * critical_speed(),))
    chain = chain_of(one, [("inelastic_storeys", []), ("p_delta", [])])
    run = free_row(lay_out([chain], [], 0.01), np.zeros(3000))
    assert run.status == status
    assert status or 0.25 < run.floors[0, 1] < 0.2603


def envelope(drift: float) -> float:
    """The shear [N] of `BARRIER`, first loaded, less the P d / h that pulls the storey on."""
    shear = np.interp(drift, [0.0, 0.008, 0.016, 0.32], [0.0, 4e5, 4e5, 8e3])
    return float(shear) - 9.80665 * 1e5 / 3.0 * drift


@pytest.mark.parametrize("others", [False, True])
def test_the_time_of_a_collapse_follows_from_its_work(others: bool):
    """∫ du / v until the drift is 0.05 of 3 m; quadrature to 1e-10, the run to a margin of 1e-12 of a branch.

    Storeys of another building that change their branches in the same step, many a millisecond, do not change it.
    """
    one = building(Hysteresis("isotropic", BARRIER, collapse_drift=0.05), 1, damping=0.0, initial_velocity=(3.0,))
    effects = [("inelastic_storeys", []), ("p_delta", [])]
    chains = [chain_of(one, effects)]
    if others:
        bends = building(Hysteresis("bouc_wen"), 1, initial_velocity=(1.0,))
        chains += [chain_of(Storeys("B", (2e5,), (1e7,), (3.0,))), chain_of(bends, effects)]
    run = free_row(lay_out(chains, [], 0.01), np.zeros(300))

    def slowness(drift: float) -> float:
        passed = np.array([0.0, *(corner for corner in (0.008, 0.016) if corner < drift), drift])
        work = np.trapezoid([envelope(each) for each in passed], passed)
        return 1.0 / sqrt(9.0 - 2.0 * work / 1e5)

    time = quad(slowness, 0.0, 0.15, points=[0.008, 0.016], epsrel=1e-12)[0]
    assert run.status == COLLAPSED
    assert run.rest[0, COLLAPSE_TIME] == pytest.approx(time, rel=1e-9)


@pytest.mark.parametrize(("stiffness", "touching"), [(5e6, True), (5e8, False)])
def test_the_time_of_a_collapse_by_a_blow_is_an_integrators(stiffness: float, touching: bool):
    """DOP853 in steps of 0.1 ms, which pass a kink with an error of 1e-9 of a displacement; in contact and after it."""
    law = Hysteresis("isotropic", BARRIER, collapse_drift=0.05)
    struck = chain_of(building(law, 1, damping=0.0), [("inelastic_storeys", []), ("p_delta", [])])
    striker = chain_of(Storeys("B", (2e5,), (1e7,), (3.0,), damping=0.0, initial_velocity=(5.0,)))
    meetings = [Meeting(0, 1.0, 1.0, 0.01, "linear", stiffness)]
    laid = lay_out([striker, struck], points_of(meetings), 0.01)
    run = run_row(laid, contacts_of(meetings), np.zeros(100), rtol=1e-11)

    def motion(_: float, state: np.ndarray) -> list[float]:
        force = stiffness * max(0.0, state[0] - state[1] - 0.01)
        return [state[2], state[3], (-1e7 * state[0] - force) / 2e5, (force - envelope(state[1])) / 1e5]

    def falls(_: float, state: np.ndarray) -> float:
        return float(state[1] - 0.15)

    falls.terminal = True  # type: ignore[attr-defined]
    true = solve_ivp(motion, (0.0, 1.0), [0, 0, 5.0, 0], "DOP853", events=falls, rtol=1e-11, atol=1e-13, max_step=1e-4)
    assert np.diff(true.y[1]).min() >= 0.0  # of first loading alone
    assert run.status == COLLAPSED and (true.y[0, -1] - true.y[1, -1] > 0.01) == touching
    assert run.rest[1, COLLAPSE_TIME] == pytest.approx(true.t[-1], rel=1e-7)
    assert np.isnan(run.rest[0, COLLAPSE_TIME])


def held_between_walls(motion: Any) -> np.ndarray:
    """Displacements of the storey below by DOP853 from one change of branch to the next, in steps of at most 0.2 ms.

    The kinks of the walls' springs and of the ground within a step leave 1e-7 of a displacement.
    """
    mass, stiffness, limit, pull = 2e5, 2e7, 5e-3, 9.80665 * 2e5 / 3.0  # kg, N/m, m, P / h [N/m]
    times = motion.dt * np.arange(motion.acceleration.size)
    state, start, side, plastic = np.zeros(2), 0.0, 0.0, 0.0
    moved: list[np.ndarray] = []
    while start < times[-1]:

        def rates(t: float, y: np.ndarray, side: float = side, plastic: float = plastic) -> list[float]:
            shear = stiffness * (limit * side if side else y[0] - plastic)
            pressed = 1e8 * (max(0.0, y[0] - 0.02) - max(0.0, -0.02 - y[0]))
            return [y[1], -np.interp(t, times, motion.acceleration) - (shear - pull * y[0] + pressed) / mass]

        def changes(_: float, y: np.ndarray, side: float = side, plastic: float = plastic) -> float:
            return float(side * y[1] if side else limit - abs(y[0] - plastic))

        changes.terminal, changes.direction = True, -1.0  # type: ignore[attr-defined]
        how: dict[str, Any] = {"method": "DOP853", "rtol": 1e-10, "atol": 1e-12, "max_step": 2e-4}
        part = solve_ivp(rates, (start, times[-1]), state, events=changes, **how)
        moved.append(part.y[0])
        start, state = part.t[-1], part.y[:, -1]
        plastic, side = (state[0] - side * limit, 0.0) if side else (plastic, np.sign(state[0] - plastic))
    return np.concatenate(moved)


@pytest.mark.parametrize("law", [{}, {"hysteresis": {"rule": "bouc_wen"}}])
def test_others_are_followed_past_a_collapse_without_contact(law: dict[str, Any]):
    """A mass 9 m away, which nothing touches, moves as it does in a row without the storey, to rounding.

    A storey that went on past its collapse would pass branches without end: the chords of bouc_wen.
    """
    weak = storeyed("weak", ["200 t"], "20 MN/m", ["3 m"], storey_strengths="100 kN", **law)
    far, walls = (
        single("far", "300 t", "0.7 s", height="3 m"),
        [rigid(name, height="3 m") for name in ("left", "right")],
    )
    effects: dict[str, Any] = {"inelastic_storeys": {"hardening": 0.0}, "p_delta": {}}
    contact = {"contact_model": "linear", "stiffness": "1e5 kN/m"}
    tables = [contact | {"gap": gap} for gap in ("20 mm", "20 mm", "9 m")]
    row = pr.scan(scene_text(walls[0], weak, walls[1], far, interfaces=tables, effects=effects))
    pair = pr.scan(scene_text(walls[1], far, interfaces=tables[2:], effects={"p_delta": {}}))
    assert int(row["status"].squeeze()) == 0 and row["storey_collapse_time_free"].notnull().any()
    for name in ("peak_displacement", "peak_floor_acceleration"):
        values = [float(one[name].sel(building="far").squeeze()) for one in (row, pair)]
        assert values[0] == pytest.approx(values[1], rel=1e-12)


@pytest.mark.complete  # ten seconds of the integrator
def test_neighbours_hold_up_a_storey_that_collapses_alone():
    """Between walls at 20 mm it stays, as an integrator has it; rtol 1e-9, over a dozen blows."""
    weak = storeyed("weak", ["200 t"], "20 MN/m", ["3 m"], damping=0.0, storey_strengths="100 kN")
    between = [rigid("left", height="3 m"), weak, rigid("right", height="3 m")]
    contact = {"law": "linear", "stiffness": "1e5 kN/m", "gap": "20 mm"}
    effects: dict[str, Any] = {"inelastic_storeys": {"hardening": 0.0}, "p_delta": {}}
    records = {"names": ["RSN6-180"], "window": ["0 s", "12 s"]}
    study = parse_scene(scene_text(*between, records=records, effects=effects, solver={"rtol": 1e-9}, **contact))
    results = pr.scan(study)
    dataset = results.squeeze(("record", "polarity", "contact_model", "gap", "yield_force"))
    assert float(dataset["storey_collapse_time_free"].sel(building="weak", storey=1)) < 12.0
    assert int(dataset["status"]) == 0 and np.isnan(dataset["storey_collapse_time"]).all()
    true = held_between_walls(motions_of(study)[0])
    assert float(dataset["peak_displacement"].sel(building="weak")) == pytest.approx(np.abs(true).max(), rel=1e-6)
    forces = 1e8 * np.array([-0.02 - true.min(), true.max() - 0.02])
    np.testing.assert_allclose(dataset["peak_contact_force"], forces, rtol=1e-5)
    run = pr.simulate(study)
    assert run.attrs["status"] == "complete" and int(run["impact_count"].sum()) > 10
    assert float(run["displacement"].sel(building="weak")[-1, 0]) == pytest.approx(true[-1], abs=1e-6)
    with pytest.raises(PoundingError, match="in every motion as recorded a storey collapses"):
        pr.assess(results)
    demands = pr.damage(results, states=[pr.DamageState("severe", building="weak", drift=0.03)])["demand_ratio"]
    with_walls, alone = (float(demands.sel(pounding=side).squeeze()) for side in ("with", "without"))
    assert with_walls == pytest.approx(np.abs(true).max() / 0.09, rel=1e-6) and alone > 1.0


# ------------------------------------------------------------------------------------------------ SDND124A


def hardened(travel: Any) -> Any:
    """The shear [N] of the case at a travel [m] beyond yield."""
    return 200.0 + 400.0 * travel / (1.0 + (400.0 * travel / 250.0) ** 1.5) ** (1.0 / 1.5)


def sdnd124a(points: int) -> Any:
    """The case of code_aster as a scene: isotropic hardening beside a linear spring, a link to a wall on its ground."""
    travel = np.geomspace(1e-3, 9.0, points)
    backbone = [[1.0 + x / 0.5, v / 200.0] for x, v in zip(travel.tolist(), hardened(travel).tolist(), strict=True)]
    law = {"rule": "isotropic", "backbone": backbone, "collapse_drift": 1.0}
    mass = storeyed("mass", ["200 kg"], "400 N/m", ["9 m"], damping=0.0, storey_strengths=["200 N"], hysteresis=law)
    wave = {"kind": "harmonic", "period": "2 s", "cycles": 11, "pga": "6 m/s^2", "step": "2 ms"}
    records = {"names": None, "generated": [wave], "polarity": "reversed"}
    link = {"link_stiffness": "400 N/m"}
    effects: dict[str, Any] = {"inelastic_storeys": {}}
    return parse_scene(scene_text(mass, rigid(height="9 m"), gap="99 m", records=records, effects=effects, **link))


def smooth(times: np.ndarray) -> np.ndarray:
    """Displacements of the smooth law by DOP853 from one change of branch to the next."""
    state, start, side, travel, shear, at = np.zeros(2), 0.0, 0.0, 0.0, 0.0, 0.0
    found: list[float] = []
    while len(found) < times.size:

        def force(u: float, side: float = side, travel: float = travel, shear: float = shear, at: float = at) -> float:
            return side * hardened(travel + side * (u - at)) if side else shear + 400.0 * (u - at)

        def slope(t: float, y: np.ndarray) -> list[float]:
            return [y[1], 6.0 * sin(pi * t) - (400.0 * y[0] + force(y[0])) / 200.0]

        def over(t: float, y: np.ndarray, side: float = side, travel: float = travel) -> float:
            return -side * y[1] - 1e-12 if side else abs(force(y[0])) - hardened(travel) * (1.0 + 1e-13)

        over.terminal, over.direction = True, 1.0  # type: ignore[attr-defined]
        part = solve_ivp(
            slope, (start, times[-1] + 1.0), state, "DOP853", events=over, rtol=1e-11, atol=1e-12, dense_output=True
        )
        known = times[len(found) : np.searchsorted(times, part.t[-1], "right")]
        found += part.sol(known)[0].tolist()
        start, state = part.t[-1], part.y[:, -1]
        shear_now = force(state[0])
        if side:
            side, travel = 0.0, travel + side * (state[0] - at)
        else:
            side = float(np.sign(shear_now))
        shear, at = shear_now, state[0]
    return np.array(found[: times.size])


def test_isotropic_hardening_is_sdnd124a():
    """Chords are off by 1 / n²; the program's Newmark with steps of 25 ms by up to 0.6 %, by its own values."""
    run = pr.simulate(sdnd124a(200))
    times, found = run["time"].values, run["displacement"].values[:, 0, 0]
    first = times <= 5.0
    known = smooth(times[first])
    np.testing.assert_allclose(found[first], known, rtol=0.0, atol=2e-4 * np.abs(known).max())
    assert float(np.interp(1.275, times, found)) == pytest.approx(1.76983, rel=6e-3)
    assert float(np.interp(20.5, times, found)) == pytest.approx(-0.91303, rel=6e-3)


# --------------------------------------------------------------------------------------------------- contact


def striking(law: dict[str, Any] | None, gap: str = "10 mm", **more: Any) -> Any:
    """A frame that yields between a stiffer one and a wall."""
    yields = {"storey_strengths": ["1400 kN", "900 kN"]} | ({"hysteresis": law} if law else {})
    frame = storeyed("frame", ["200 t", "180 t"], ["200 MN/m", "150 MN/m"], "3 m", **yields)
    stiff = storeyed("stiff", ["300 t", "280 t"], "900 MN/m", ["3 m", "3 m"])
    given = {"records": {"window": ["0 s", "8 s"], "pga": "0.8 g"}, "effects": {"inelastic_storeys": {}}} | more
    return parse_scene(scene_text(rigid(height="6 m"), frame, stiff, gap=gap, **given))


OUTPUTS = ("storey_drift", "storey_energy", "peak_contact_force", "impact_count", "storey_residual_drift")


def test_in_contact_a_kinematic_line_is_the_bilinear_storey_too():
    """At rtol 1e-9 both are integrated alike; events are landed on one way or another, to 1e-6."""
    bilinear, law = (pr.simulate(striking(one, solver={"rtol": 1e-9})) for one in (None, {"rule": "kinematic"}))
    assert int(bilinear["impact_count"].sum()) > 2 and float(bilinear["storey_ductility"].max()) > 2.0
    for name in ("storey_drift", "peak_contact_force", "impact_count", "storey_acceleration"):
        np.testing.assert_allclose(law[name].values, bilinear[name].values, rtol=1e-6)


@pytest.mark.parametrize("rule", ["kinematic", "isotropic", "peak_oriented", "bouc_wen"])
def test_results_in_contact_settle_with_the_tolerance(rule: str):
    """1e-7 against 1e-10: what events of storeys within contacts leave is of the size of the tolerance."""
    law: dict[str, Any] = {"rule": rule} | ({} if rule == "bouc_wen" else {"backbone": [[3.0, 1.2]]})
    if rule == "peak_oriented":
        law = {"rule": rule, "backbone": [[3.0, 1.2], [9.0, 0.5]], "pinching_drift": 0.5, "pinching_force": 0.3}
        law |= {"unloading": 0.4, "energy_capacity": 80}
    coarse, fine = (pr.simulate(striking(law, solver={"rtol": rtol})) for rtol in (1e-7, 1e-10))
    assert fine.attrs["status"] == coarse.attrs["status"] == "complete"
    assert int(fine["impact_count"].sum()) > 2 and float(fine["storey_ductility"].max()) > 2.0
    for name in OUTPUTS:
        np.testing.assert_allclose(coarse[name].values, fine[name].values, rtol=1e-4, err_msg=name)


def test_a_collapse_counts_as_damage_of_the_structure():
    """At the highest level nothing is known of the drift but that it is past the state, with contact or without."""
    law = {"rule": "peak_oriented", "backbone": [[2.0, 1.0], [6.0, 0.05]], "collapse_drift": 0.1}
    shaking = {"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "10 s"]}
    levels = {"pga": ["0.05 g", "0.1 g", "1.2 g"]}
    effects: dict[str, Any] = {"inelastic_storeys": {}, "p_delta": {}}
    dataset = pr.scan(striking(law, gap="9 m", records=shaking, grid=levels, effects=effects))
    fell = (dataset["status"] == COLLAPSED).squeeze(drop=True)
    assert fell.sel(pga=dataset["pga"][-1]).all() and not fell.isel(pga=0).any()
    assert "a storey collapsed" in dataset["status"].attrs["sentences"]
    found = pr.damage(dataset, states=[pr.DamageState("severe", building="frame", drift=0.03)])
    ratios = found["demand_ratio"].squeeze(drop=True)
    assert (ratios.isel(level=-1) >= 1.0).all() and (ratios.isel(level=0) < 1.0).all()
    assert ratios.notnull().all() and np.isinf(ratios).any()  # none is left out
    assert Results(dataset).run_counts["failed"] == int(fell.sum())
    assert "count as reached" in " ".join(map(str, found.attrs.values()))


def test_storeys_that_their_weight_pulls_down_collapse_and_no_gap_is_advised():
    """Past yield P / h is more than 3 % of the stiffness: without the law a drift would grow without bound."""
    shaking = {"names": ["RSN6-180", "RSN1690-090", "RSN753-000"], "pga": "0.3 g"}
    effects: dict[str, Any] = {"inelastic_storeys": {}, "p_delta": {}}

    def row(**law: Any) -> Any:
        weak = storeyed("weak", ["200 t", "180 t"], "20 MN/m", ["3 m"] * 2, storey_strengths="100 kN", **law)
        stiff = storeyed("stiff", ["300 t", "280 t"], "900 MN/m", ["3 m", "3 m"])
        return pr.scan(parse_scene(scene_text(weak, stiff, gap="0.9 m", records=shaking, effects=effects)))

    dataset = row()
    assert (dataset["status"] == COLLAPSED).sum() == 2
    told = row(hysteresis={"rule": "kinematic"})
    np.testing.assert_array_equal(dataset["peak_closing_free"], told["peak_closing_free"])
    verdict = pr.assess(dataset).interfaces[0].verdict
    assert verdict.motions == 1 and verdict.failed == 2
    assert any("No gap can be shown to keep 16 %: 2 of 3 motions" in line for line in verdict.conclusion)
    assert any("2 motions; in 2 of them a storey collapses" in line for line in verdict.evidence)


@pytest.mark.parametrize("law", [None, {"rule": "peak_oriented", "backbone": [[3.0, 1.2], [9.0, 0.5]]}])
def test_loops_are_in_the_run_and_drawn(law: dict[str, Any] | None):
    """The largest shear of the histories is that of the run, but for what lies between instants: 1e-3."""
    run = pr.simulate(striking(law))
    peaks = np.abs(run["storey_force"]).max("time")
    frame = {"building": "frame"}
    np.testing.assert_allclose(peaks.sel(frame), run["storey_shear"].sel(frame), rtol=1e-3)
    np.testing.assert_allclose(np.abs(run["drift"]).max("time").sel(frame), run["storey_drift"].sel(frame), rtol=1e-3)
    figure = pr.figures.hysteresis_figure(run)
    assert figure.get_suptitle() == "2 of 2 storeys that may yield do so"
    assert [axis.get_ylabel() for axis in figure.axes] == ["storey shear [kN]"] * 2
    with pytest.raises(PoundingError, match="no storey of the run may yield"):
        pr.figures.hysteresis_figure(pr.simulate(striking(law, effects={})))
