"""Contacts whose dampers are much quicker than the buildings: bodies pressed together creep, and runs still end.

With e far below 0.1 the damper's time m/c is a millionth of what the buildings need. Held against SciPy's Radau on
equations of its own (`oracle_stiff`), and against the closed form of creep under a constant push.
"""

import math
from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from kept_references import reference
from oracle_rows import Meeting, Row
from oracle_stiff import StiffRow
from row_cases import RIGID, contacts_of, meeting, named, points_of, single, storeys
from sweeps import sweep

from pounding_risk.models import restitution
from pounding_risk.models.contact.laws import Jankowski
from pounding_risk.models.structures.mdof import Chain
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver import counters
from pounding_risk.solver.pair.api import Interface, solve
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

GRAVITY = 9.80665
DT = 0.01
# A stiff and light building, a soft one of two floors, a wall: the first is pressed against the second again and again.
CHAINS = (storeys(1, 400.0, 8e8), storeys(2, 5e3, 1.5e6), RIGID)
CONTACTS: dict[str, Any] = {"gap": 0.002, "law": "jankowski", "stiffness": 1e11}
PEAKS = ("peak_closing", "peak_penetration", "peak_contact_force", "peak_approach_speed", "impulse", "contact_time")


def jolts(duration: float) -> np.ndarray:
    """a_g of 0.25 g that changes its sign every 80 ms [m/s²]."""
    times = np.arange(round(duration / DT) + 1) * DT
    return 0.25 * GRAVITY * np.where(np.floor(times / 0.08) % 2 == 0, 1.0, -1.0)


def meetings_of(e: float) -> list[Meeting]:
    points = (meeting(0, 1.0, 1.0, restitution=e, **CONTACTS), meeting(1, 2.0, 1.0, restitution=e, **CONTACTS))
    return list(points)


def run_of(chains: tuple[Chain, ...], meetings: list[Meeting], ground: np.ndarray, rtol: float = 1e-6) -> rows.RowRun:
    return rows.run_row(lay_out(chains, points_of(meetings), DT), contacts_of(meetings), ground, rtol=rtol)


@pytest.mark.parametrize("e", [1e-1, 1e-2, 1e-4, 1e-6])
def test_a_creeping_contact_ends(e: float):
    """Before, the steps grew with 1/e: 3e4 of them at e = 0.01 and 3e8 at 1e-6 for a row like this one."""
    ground = jolts(2.5)
    coarse, fine = (run_of(CHAINS, meetings_of(e), ground, rtol) for rtol in (1e-6, 1e-8))
    assert coarse.status == fine.status == counters.COMPLETE
    assert coarse.points[0, counters.CONTACT_TIME] > 0.1
    assert coarse.steps < 20_000
    # Two tolerances agree by what the coarser one promises.
    for name in ("peak_closing", "peak_contact_force", "peak_approach_speed"):
        np.testing.assert_allclose(named(coarse)[name], named(fine)[name], rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(coarse.floors, fine.floors, rtol=1e-6)
    assert abs(coarse.residual) <= 1e-6 * coarse.energy


@pytest.mark.parametrize(("e", "integrator"), [(1e-2, Row), (1e-4, StiffRow), (1e-6, StiffRow)])
def test_a_row_with_creeping_contacts_agrees_with_scipy(e: float, integrator: type[Row]):
    """Where an explicit reference still can, it is the explicit one."""
    ground, meetings = jolts(0.2), meetings_of(e)
    true = reference(CHAINS, meetings, ground, DT, 1e-11 if integrator is Row else 1e-9, integrator)
    run = run_of(CHAINS, meetings, ground)
    found = named(run)
    assert run.status == counters.COMPLETE and true.points["impact_count"].min() >= 1
    np.testing.assert_array_equal(found["impact_count"], true.points["impact_count"])
    for name in PEAKS:
        np.testing.assert_allclose(found[name], true.points[name], rtol=1e-6, err_msg=name)
    np.testing.assert_allclose(run.floors, true.floors, rtol=1e-6)


def test_a_pair_with_a_creeping_contact_agrees_with_scipy_and_with_the_row():
    """The pair's own steps; e = 1e-5 and one long contact, in which the stiff building sways against the soft one."""
    buildings = Building("left", 2e3, 0.02, 0.05), Building("right", 3e4, 0.9, 0.05)
    chains = tuple(single(each.mass, each.period) for each in buildings)
    point = Meeting(0, 1.0, 1.0, 0.001, "jankowski", 3e10, 1e-5)
    ground = jolts(0.4)
    found = solve(*buildings, Interface(0.001, Jankowski(3e10), restitution.constant(1e-5)), ground, DT)
    true = reference(chains, [point], ground, DT, 1e-9, StiffRow)
    run = run_of(chains, [point], ground)
    assert found["status"] == run.status == counters.COMPLETE
    assert found["impact_count"] == true.points["impact_count"][0] == run.points[0, counters.COUNT] >= 1
    for name in PEAKS:
        assert found[name] == pytest.approx(true.points[name][0], rel=1e-6), name
        assert found[name] == pytest.approx(named(run)[name][0], rel=1e-6), name
    for side, peaks in zip(("left", "right"), true.floors, strict=True):
        assert found[f"peak_displacement_{side}"] == pytest.approx(peaks[0], rel=1e-6)
        assert found[f"peak_floor_acceleration_{side}"] == pytest.approx(peaks[3], rel=1e-6)


def test_creep_under_a_constant_push_has_its_closed_form():
    """c̄ δ^(1/4) δ̇ = G − β δ^1.5 − m δ̈, so that 0.8 c̄ δ^(5/4) = ∫ (G − β δ^1.5) dt − m δ̇, c̄ = 2 ξ sqrt(β m).

    A mass on next to no spring, pushed by a constant a_g across no gap: the spring of the contact holds back less than
    5e-6 of the push, and what the mass still has of momentum m δ̇ is less than 5e-6 of what it was given.
    """
    mass, pull, e, stiffness, time = 1e4, 2.0, 1e-6, 1e6, 1.0
    damper = 2.0 * 4.5 * math.sqrt(5.0) / (16.0 * e) * math.sqrt(stiffness * mass)
    depth = (1.25 * mass * pull * time / damper) ** 0.8
    assert stiffness * depth**1.5 < 5e-6 * mass * pull and mass * depth / time < 5e-6 * mass * pull * time
    ground = np.full(round(time / DT) + 1, -pull)
    run = run_of((single(mass, 5e3), RIGID), [Meeting(0, 1.0, 1.0, 0.0, "jankowski", stiffness, e)], ground)
    assert run.status == counters.COMPLETE and run.points[0, counters.COUNT] == 1
    assert run.points[0, counters.PENETRATION] == pytest.approx(depth, rel=1e-5)
    assert run.points[0, counters.IMPULSE] == pytest.approx(mass * pull * time, rel=1e-5)


RANDOM_ROWS = 24


def random_row(seed: int) -> tuple[tuple[Chain, ...], list[Meeting], np.ndarray]:
    """A legal row: e from 1e-6 to 1, periods from 5 ms to 2 s, stiffnesses over five decades, some gaps closed."""
    random = np.random.default_rng(seed)
    sizes = random.integers(1, 4, random.integers(2, 5))

    def between(low: float, high: float) -> float:
        return float(math.exp(random.uniform(math.log(low), math.log(high))))

    chains = []
    for size in sizes:
        mass, omega = between(300.0, 1e6), 2.0 * math.pi / between(0.005, 2.0)
        stiffness = mass * (omega / (2.0 * math.sin(0.5 * math.pi / (2 * size + 1)))) ** 2
        chains.append(storeys(int(size), mass, stiffness))
    law = str(random.choice(["jankowski", "viscous_elastoplastic", "modified_kelvin_voigt", "hertz_damp_exact"]))
    meetings = []
    for place, (one, other) in enumerate(pairwise(sizes)):
        gap = 0.0 if random.random() < 0.3 else between(1e-4, 0.05)
        stiffness, e, force = between(1e7, 1e12), between(1e-6, 1.0), between(1e4, 1e7)
        meetings += [Meeting(place, f, f, gap, law, stiffness, e, force) for f in np.arange(1.0, min(one, other) + 1)]
    ground = random.standard_normal(201)
    return tuple(chains), meetings, ground * (random.uniform(0.05, 1.0) * GRAVITY / np.abs(ground).max())


@pytest.mark.parametrize("seed", sweep(range(RANDOM_ROWS), 0, 1, 2, 3, 4, 5))
def test_no_legal_row_runs_away(seed: int):
    """The worst of 200 such rows tried 15,000 steps a second simulated."""
    chains, meetings, ground = random_row(seed)
    run = run_of(chains, meetings, ground)
    assert run.status == counters.COMPLETE
    assert run.steps <= 30_000 * (ground.size - 1) * DT


@pytest.mark.parametrize("seed", [11, 23, 118, 136])
def test_a_part_steps_alike_whatever_else_moves(seed: int):
    """Beside two buildings with ten thousand times the energy: a step closes its energy by that of its own group.

    A building between them, which nobody strikes, keeps the two groups apart.
    """
    chains, meetings, ground = random_row(seed)
    heavy = (single(1e9, 0.5), single(1e9, 1.0), single(1e5, 0.7))
    beside = [meeting(0, 1.0, 1.0, 0.0, stiffness=1e13, restitution=0.9), *(meeting(k, 1.0, 1.0, 50.0) for k in (1, 2))]
    alone = run_of(chains, meetings, ground)
    shifted = [one._replace(interface=one.interface + 3) for one in meetings]
    whole = run_of((*heavy, *chains), [*beside, *shifted], ground)
    assert alone.status == whole.status == counters.COMPLETE
    assert whole.points[0, counters.COUNT] >= 2 and whole.points[1:3, counters.COUNT].max() == 0
    assert alone.points[:, counters.COUNT].sum() >= 3 and whole.energy > 1e4 * alone.energy
    np.testing.assert_array_equal(whole.points[3:], alone.points)
    np.testing.assert_array_equal(whole.floors[3:], alone.floors)
