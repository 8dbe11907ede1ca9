"""Buildings on grounds of their own: closed forms, an independent integrator, mirrors, limits; pairs and rows."""

from math import inf, nan, pi

import numpy as np
import pytest
from oracle_grounds import Body, Touch, follow_grounds
from row_cases import cases_of, contacts_of, limits_of, meeting, points_of
from sweeps import sweep

from pounding_risk.lab.stability.trial import shaking
from pounding_risk.models.contact.impulsive import Merged, Stereomechanical
from pounding_risk.models.contact.laws import Linear, ViscousElastoplastic
from pounding_risk.models.ground import Support, accelerations, arrivals_of, arriving, delayed
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.ground_motion import displaced
from pounding_risk.solver.counters import (
    APPROACH,
    COMPLETE,
    CONTACT_TIME,
    COUNT,
    FIRST_TOUCH,
    IMPULSE,
    PEAK_FORCE,
    STATUS,
    VISCOUS,
    make_log,
)
from pounding_risk.solver.pair.api import Interface, free_response, oscillators, run, solve
from pounding_risk.solver.pair.outputs import HIGH, LOW
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.cases import Cases
from pounding_risk.solver.row.model import RowModel
from pounding_risk.studies.pair_trace import histories

STEP = 0.01
GROUND = shaking(4.0)[:300]
OTHER = 0.8 * shaking(9.0)[40:340]  # a record of its own: it begins in motion
FRAME = Building("frame", 500e3, 0.5, 0.05)
SHED, ROCK = Building("shed", 800e3, 0.31, 0.05), Building.rigid("rock")
BETA, K = 1e9, 2e8
HERTZ, LINEAR, LAW = ViscousElastoplastic(BETA), Linear(K), ViscousElastoplastic(2.75e9)
WHOLE, HALF = constant(1.0), constant(0.5)
# What each of two buildings stands on, and its own samples.
PAIRS = {
    "reversed": ((Support(), Support(-1.0)), ()),
    "scaled": ((Support(0.4), Support(1.3)), ()),
    "still": ((Support(), Support(0.0)), ()),
    "moving": ((Support(velocity=0.02), Support(velocity=-0.05)), ()),
    "the right one later": ((Support(), Support(1.0, 0.043)), ()),
    "the left one later": ((Support(1.0, 0.02), Support()), ()),
    "own record": ((Support(), Support(records=("other",))), (None, OTHER)),
    "reversed, later by part of a step": ((Support(), Support(-1.0, 0.043)), ()),
    "scaled, the left one later": ((Support(0.7, 0.07, 0.01), Support(1.2)), ()),
    "own record, later, moving": ((Support(0.5, 0.0, 0.03), Support(-1.5, 0.0137, -0.02, ("other",))), (None, OTHER)),
}


def body_of(building: Building, support: Support, samples: np.ndarray) -> Body:
    """A single mass, or a wall, for the independent integrator."""
    motion = support.delay, support.velocity
    if building.is_rigid:
        return Body((), (), np.zeros((0, 0)), support.factor * samples, *motion)
    damping = 2.0 * building.damping * 2.0 * pi / building.period * building.mass
    start = (building.initial_displacement,), (building.initial_velocity,)
    return Body(
        (building.mass,), (building.stiffness,), np.array([[damping]]), support.factor * samples, *motion, *start
    )


def known_pair(left, right, supports, own, gap, law) -> tuple[np.ndarray, np.ndarray]:
    """Displacements of both masses and grounds by the independent integrator; those of a wall are its ground's."""
    samples = [GROUND if each is None else each for each in own or (None, None)]
    bodies = [body_of(*each) for each in zip((left, right), supports, samples, strict=True)]
    beta, power = (K, 1.0) if law is LINEAR else (BETA, 1.5)
    sides = [0.0 if building.is_rigid else 1.0 for building in (left, right)]
    masses, grounds = follow_grounds(bodies, [Touch(0, *sides, gap, beta, power)], STEP)
    columns = iter(masses.T)
    places = [next(columns) if side else grounds[:, b] for b, side in enumerate(sides)]
    return np.column_stack(places), grounds


# -------------------------------------------------------------------------------------------------- the motion


def test_a_ramp_and_a_moving_ground():
    """a_g = c t makes c t³ / 6 and v makes v t: exact, whatever the factor, the delay and the step."""
    time = np.arange(200) * STEP
    ramp, late = 3.0 * time, 0.043
    known = [2.0 * 0.5 * time**3 - 0.2 * time, -0.5 * np.maximum(time - late, 0.0) ** 3 + 0.3 * time]
    supports = Support(2.0, 0.0, -0.2), Support(-1.0, late, 0.3)
    under = accelerations(supports, ramp)
    pair = delayed(under, STEP, late, 0.5)
    np.testing.assert_allclose(pair.spread[::2], known[1] - known[0], rtol=1e-12, atol=1e-15)
    arrivals = arrivals_of(np.array([0.0, late, 0.0]), STEP, np.array([-0.2, 0.3, -0.2]))
    table = arriving(accelerations((*supports, supports[0]), ramp), STEP, arrivals)
    np.testing.assert_allclose(table[::2, 1, 4], known[1] - known[0], rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(table[::2, 2, 4], known[0] - known[1], rtol=1e-12, atol=1e-15)
    between = np.linspace(0.0, time[-1], 777)
    values = 0.5 * np.maximum(between - late, 0.0) ** 3 * -1.0 + 0.3 * between
    np.testing.assert_allclose(displaced(under[1], STEP, supports[1], between), values, rtol=1e-12, atol=1e-15)


def test_equal_delays_of_unlike_factors_are_two_grounds():
    under = accelerations((Support(), Support(-1.0)), GROUND)
    np.testing.assert_array_equal(under, [GROUND, -GROUND])
    assert accelerations((Support(2.0), Support(2.0)), GROUND).ndim == 1
    assert accelerations((), GROUND) is GROUND


# -------------------------------------------------------------------------------------------------- pairs


@pytest.mark.parametrize("law", [HERTZ, pytest.param(LINEAR, marks=pytest.mark.complete)], ids=["hertz", "linear"])
@pytest.mark.parametrize("right", [SHED, pytest.param(ROCK, marks=pytest.mark.complete)], ids=["mass", "wall"])
@pytest.mark.parametrize("name", sweep(PAIRS, "own record, later, moving", "reversed, later by part of a step"))
def test_a_pair_by_an_independent_integrator(name: str, right: Building, law):
    """Displacements in space at every sample of the flights, to 1e-9 of the largest."""
    supports, own = PAIRS[name]
    gap = 0.012
    known, grounds = known_pair(FRAME, right, supports, own, gap, law)
    pair = oscillators(FRAME, right)
    free, log = free_response(pair, GROUND, STEP, supports, own=own), make_log(1000, 20_000, np.zeros(0))
    raw = run(pair, free, Interface(gap, law, WHOLE), 1e-12, log)
    assert raw[COUNT] >= 1
    times, states, *_ = histories(pair, free, log)
    samples = np.arange(GROUND.size) * STEP
    places = np.searchsorted(times, samples - 1e-9)
    flown = np.abs(times[np.minimum(places, times.size - 1)] - samples) < 1e-9
    assert flown.sum() > 0.9 * samples.size
    sides = [GROUND if each is None else each for each in own or (None, None)]
    for b, support in enumerate(supports):
        ground = displaced(support.factor * sides[b], STEP, support, samples)
        np.testing.assert_allclose(ground, grounds[:, b], rtol=0.0, atol=1e-11 * max(1.0, np.abs(grounds).max()))
        found = states[places[flown], b] + ground[flown]
        np.testing.assert_allclose(found, known[flown, b], rtol=0.0, atol=1e-9 * np.abs(known).max())


@pytest.mark.parametrize("law", [LAW, LINEAR, Stereomechanical()], ids=["jankowski", "linear", "jump"])
def test_twins_under_opposite_motions_are_one_against_a_wall_in_space(law):
    """Half the gap; a wall has k (2 x) of a linear contact and β (2 x)^1.5 of another, and twice the striking mass."""
    twin = FRAME._replace(initial_displacement=0.004, initial_velocity=0.1)
    other = FRAME._replace(initial_displacement=-0.004, initial_velocity=-0.1)
    stiffer = {LAW: ViscousElastoplastic(2.0**1.5 * 2.75e9), LINEAR: Linear(2.0 * K)}.get(law, law)
    opposite, fixed = (Support(velocity=0.02), Support(-1.0, velocity=-0.02)), (Support(velocity=0.02), Support(0.0))
    both = solve(twin, other, Interface(0.02, law, HALF), GROUND, STEP, supports=opposite, rtol=1e-10)
    wall = solve(twin, ROCK, Interface(0.01, stiffer, HALF), GROUND, STEP, supports=fixed, rtol=1e-10)
    assert min(both["impact_count"], wall["impact_count"]) >= 3
    assert law == Stereomechanical() or both["impact_count"] == wall["impact_count"]  # of jumps the last ones are tiny
    rel = 1e-6 if law == Stereomechanical() else 1e-7  # a last bounce more lasts some 1e-7 s
    for name in ("peak_displacement_left", "impulse", "contact_time", "peak_floor_acceleration_left"):
        assert both[name] == pytest.approx(wall[name], rel=rel, abs=1e-12), name
    assert both["peak_closing"] == pytest.approx(2.0 * wall["peak_closing"], rel=1e-8)
    assert both["peak_displacement_right"] == pytest.approx(both["peak_displacement_left"], rel=1e-8)


@pytest.mark.parametrize("law", [LAW, Merged(), Stereomechanical()], ids=["force", "jump", "bounces"])
@pytest.mark.parametrize("name", PAIRS)
@pytest.mark.parametrize("right", [SHED, ROCK], ids=["mass", "wall"])
def test_seen_from_behind(name: str, right: Building, law):
    """Left and right changed, and the sign of all motions: the same run, to the tolerance of its steps."""
    supports, own = PAIRS[name]
    behind = tuple(each._replace(factor=-each.factor, velocity=-each.velocity) for each in reversed(supports))
    free, found = [], []
    for buildings, under, records in (((FRAME, right), supports, own), ((right, FRAME), behind, own[::-1])):
        pair = oscillators(*buildings)
        free.append(free_response(pair, GROUND, STEP, under, own=records))
        found.append(run(pair, free[-1], Interface(0.012, law, HALF), 1e-10))
    np.testing.assert_allclose(free[0].states[::2, :2], -free[1].states[::2, 1::-1], rtol=0.0, atol=1e-14)
    assert [each[STATUS] for each in found] == [COMPLETE, COMPLETE] and min(each[COUNT] for each in found) >= 1
    assert found[0][COUNT] == found[1][COUNT] or law == Stereomechanical()  # of bounces the last ones are tiny
    columns = [FIRST_TOUCH, APPROACH, PEAK_FORCE, IMPULSE, CONTACT_TIME, VISCOUS, HIGH, LOW]
    rtol = 1e-6 if law == Stereomechanical() else 1e-7  # a last bounce more lasts some 1e-7 s
    np.testing.assert_allclose(found[0][columns], found[1][columns], rtol=rtol, atol=1e-12)


def test_one_factor_of_both_is_the_scaled_record_to_the_bit():
    case = Interface(0.004, LAW, HALF)
    one = solve(FRAME, SHED, case, -1.7 * GROUND, STEP)
    other = solve(FRAME, SHED, case, GROUND, STEP, supports=(Support(-1.7), Support(-1.7)))
    assert str(other) == str(one)
    assert one["impact_count"] >= 3


def test_a_wall_feels_its_own_ground():
    found = solve(FRAME, ROCK, Interface(inf, LAW, HALF), GROUND, STEP, supports=(Support(), Support(-0.25)))
    assert found["peak_floor_acceleration_right"] == 0.25 * np.abs(GROUND).max()


# -------------------------------------------------------------------------------------------------- rows


def model_of(buildings, supports, gaps) -> RowModel:
    points = [Point(place, 1.0, 1.0, FLOOR, nan) for place in range(len(gaps))]
    return RowModel([chain_of(building) for building in buildings], points, supports)


def cases_under(model: RowModel, law, own=(), e=HALF) -> Cases:
    return cases_of(model, law, (model.under(GROUND, own), STEP), e, 1e-10)


@pytest.mark.complete  # on grounds of their own rows are compiled once more
@pytest.mark.parametrize(
    ("law", "e"), [(LAW, HALF), (LAW, constant(0.005)), (Stereomechanical(), HALF)], ids=["force", "implicit", "jump"]
)
@pytest.mark.parametrize("sides", [(FRAME, SHED), (FRAME, ROCK), (ROCK, SHED)], ids=["masses", "right", "left"])
@pytest.mark.parametrize("name", PAIRS)
def test_a_row_of_two_is_the_pair(name: str, sides: tuple[Building, Building], law, e):
    """With an e of 0.005 both take implicit steps."""
    supports, own = PAIRS[name]
    model, pair = model_of(sides, supports, [0.012]), oscillators(*sides)
    found = cases_under(model, law, own, e).whole(limits_of(model, [0.012]))
    raw = run(pair, free_response(pair, GROUND, STEP, supports, own=own), Interface(0.012, law, e), 1e-10)
    assert found.status == COMPLETE and min(found.points[0, COUNT], raw[COUNT]) >= 1
    assert law is not LAW or found.points[0, COUNT] == raw[COUNT]  # of jumps the last ones are tiny
    counters = [FIRST_TOUCH, APPROACH, PEAK_FORCE, IMPULSE, CONTACT_TIME, VISCOUS]
    np.testing.assert_allclose(found.points[0, counters], raw[counters], rtol=1e-7, atol=1e-6)
    np.testing.assert_allclose(found.points[0, -2:], [raw[HIGH], raw[LOW]], rtol=1e-8)
    largest = np.maximum(raw[HIGH:LOW], -raw[LOW:])[1:].reshape(2, 2)  # |u| and |ü + a_g| of both sides
    moving = [side for side, building in enumerate(sides) if not building.is_rigid]
    rtol, springs = 1e-7 if law is LAW else 1e-6, [sides[side].stiffness for side in moving]
    np.testing.assert_allclose(found.floors[:, [0, 3]], largest[:, moving].T, rtol=rtol)
    np.testing.assert_allclose(found.floors[:, 2], springs * largest[0, moving], rtol=rtol)


@pytest.mark.complete
def test_a_row_by_an_independent_integrator():
    """Storeys, a mass and a wall on three grounds; every floor in space at the samples, to 1e-9 of the largest."""
    storeys = Storeys("storeys", (200e3, 150e3), (9e7, 7e7), (3.0, 3.0), 0.05, "rayleigh")
    buildings = storeys, SHED, ROCK
    supports = Support(-1.0, 0.0, 0.02), Support(0.8, 0.0237), Support(0.3, 0.0, -0.01, ("other",))
    own, gaps = (None, None, OTHER), [0.02, 0.015]
    chains = [chain_of(building) for building in buildings]
    met = [meeting(0, 2.0, 1.0, gaps[0], restitution=1.0), meeting(1, 1.0, 1.0, gaps[1], restitution=1.0)]
    model = RowModel(chains, points_of(met), supports)
    under, row = model.under(GROUND, own), model.row(STEP, True)
    contacts = contacts_of(met)._replace(laws=(HERTZ,) * 2)
    found = rows.run_row(row, contacts, under, rtol=1e-12, histories=True)
    bodies = [
        Body(storeys.masses, storeys.stiffnesses, chains[0].damping, under[0], 0.0, 0.02),
        body_of(SHED, supports[1], GROUND),
        body_of(ROCK, supports[2], OTHER),
    ]
    touches = [Touch(0, 2.0, 1.0, gaps[0], BETA, 1.5), Touch(1, 1.0, 0.0, gaps[1], BETA, 1.5)]
    masses, grounds = follow_grounds(bodies, touches, STEP)
    assert found.status == COMPLETE and (found.points[:, COUNT] >= 1).all()
    moved = found.states[:: row.parts, 0] + grounds[:, [0, 0, 1]]
    np.testing.assert_allclose(moved, masses, rtol=0.0, atol=1e-9 * np.abs(masses).max())


@pytest.mark.complete
def test_parts_are_the_whole_row():
    """Equal buildings on unlike grounds are no equal parts, in a row of which some buildings touch."""
    buildings = (FRAME, *(FRAME, SHED, FRAME) * 3)
    supports = tuple(Support(factor) for factor in (0.3, 1.0, -0.5, 0.3, 1.0, -0.5, 0.3, -1.0, 0.5, 0.3))
    gaps = [5.0, 0.004, 5.0, 5.0, 0.004, 5.0, 5.0, 0.004, 5.0]
    model = model_of(buildings, supports, gaps)
    cases, limits = cases_under(model, LAW), limits_of(model, gaps)
    whole, (parts, answers) = cases.whole(limits), cases.in_parts(limits)
    assert (whole.points[:, COUNT] >= 1).sum() == 3 == len(answers)
    assert len({answer.key for answer in answers}) == 2  # of the first two the ground is the same
    columns = [COUNT, FIRST_TOUCH, APPROACH, PEAK_FORCE, IMPULSE]
    np.testing.assert_allclose(parts.points[:, columns], whole.points[:, columns], rtol=1e-8)
    np.testing.assert_allclose(parts.floors[:, :3], whole.floors[:, :3], rtol=1e-8)
    np.testing.assert_array_equal(parts.points[1], parts.points[4])
