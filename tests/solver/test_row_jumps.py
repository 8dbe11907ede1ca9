"""Rows of single masses whose velocities jump: the pair, SciPy with every set of contacts, laws of mechanics."""

from itertools import product
from math import inf, nan

import numpy as np
import pytest
from hypothesis import strategies as st
from oracle_jumps import Masses, Run, by_enumeration
from row_cases import Shaking, cases_of, limits_of
from sweeps import examples, many, sweep

from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, shaking
from pounding_risk.models.contact.impulsive import Merged, Stereomechanical
from pounding_risk.models.contact.laws import KelvinVoigt
from pounding_risk.models.effects.wave_passage import WavePassage
from pounding_risk.models.restitution import CONCRETE, Restitution
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.pair.api import Interface, solve
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import Contacts
from pounding_risk.solver.row.complementarity import (
    ANSWER,
    COUPLING,
    DIAGONAL,
    GIVEN,
    TABLE_ROWS,
    solve_complementarity,
)
from pounding_risk.solver.row.impulsive.api import run_jumps
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import OF_BUILDINGS, frame_of, outputs
from pounding_risk.solver.row.trace_reader import contacts_of, instants_of

HALF, JUMP = Restitution(0.5), Stereomechanical()
FAR = Building("far", 3e5, 0.4, 0.05)
RECORD = Shaking("RSN6-180", 1.0, 4.0, 0.5)


class Made:
    """A row under a motion, its runs by the solver."""

    def __init__(self, buildings, gaps, ground, dt=0.01, law=JUMP, e=HALF, rtol=1e-6, wave=None):
        points = [Point(place, 1.0, 1.0, FLOOR, nan) for place in range(len(gaps))]
        self.model = RowModel(
            [chain_of(building) for building in buildings], points, wave.supports(len(buildings)) if wave else ()
        )
        self.dt, self.limits = dt, limits_of(self.model, gaps)
        self.cases = cases_of(self.model, law, (np.asarray(ground, dtype=float), dt), e, rtol)
        self.free = self.cases.driven.free

    def run(self):
        return self.cases.in_full(self.limits)

    def outputs(self, run=None):
        run = self.cases.whole(self.limits) if run is None else run
        return outputs(run, self.limits.yield_forces, self.cases.driven.pga, frame_of(self.model))

    def contacts(self, run):
        instants = instants_of(run.log, len(run.states), self.model.row(self.dt).step)
        return contacts_of(run.log, len(self.limits.gaps), instants)


def as_pair(made, interface=0):
    """Outputs of an interface and its two buildings under the names of a pair."""
    values = made.outputs()
    own = {name: float(value[interface]) for name, value in values.items() if name in PAIR}
    for name in OF_BUILDINGS:
        own |= {f"{name}_{side}": float(values[name][interface + at]) for at, side in enumerate(("left", "right"))}
    return own


PAIR = (
    "peak_relative_displacement", "peak_closing", "peak_opening", "peak_penetration", "impact_count",
    "first_impact_time", "contact_time", "peak_approach_speed", "peak_contact_force", "lowest_contact_force", "impulse",
    "yield_exceedance", "yield_demand", "yield_count", "first_yield_time", "energy_viscous", "energy_plastic",
    "permanent_set", "restitution_held",
)  # fmt: skip


def assert_alike(own, pair, rel):
    for name in own.keys() & pair.keys():
        assert own[name] == pytest.approx(pair[name], rel=rel, abs=1e-15, nan_ok=True), name


@pytest.mark.parametrize("law", [Merged(), Stereomechanical()])
@pytest.mark.parametrize(("left", "right"), [(SOFT, STIFF), (SOFT, WALL), (WALL, STIFF)])
@pytest.mark.parametrize("gap", [0.0, 0.003])
def test_two_masses_are_the_pair(law, left, right, gap):
    """All outputs. The pair steps by maps of free vibrations, the row by series: roundings, grown by some ten jumps."""
    ground = shaking(4.0)
    own = as_pair(Made([left, right], [gap], ground, law=law, e=CONCRETE))
    pair = solve(left, right, Interface(gap, law, CONCRETE), ground, 0.01)
    assert own["impact_count"] > 3
    assert_alike(own, pair, 1e-9)


def test_a_third_that_never_touches_leaves_the_pair():
    ground = shaking(4.0)
    made = Made([SOFT, STIFF, FAR], [0.003, 10.0], ground)
    pair = solve(SOFT, STIFF, Interface(0.003, Stereomechanical(), HALF), ground, 0.01)
    assert_alike(as_pair(made), pair, 1e-9)
    # What no contact moves has its motion without contact, to the bit.
    run = made.cases.whole(made.limits)
    np.testing.assert_array_equal(run.floors[2], made.free.floors[2])
    assert run.points[1, 1] == 0.0


# Under a wave rows are compiled once more.
PASSING = pytest.param(WavePassage.on(900.0, 20.0), marks=pytest.mark.complete)


@pytest.mark.complete
@pytest.mark.parametrize("velocity", [900.0, -900.0])
def test_a_wave_along_two_masses_is_the_pair_with_a_wave(velocity):
    """All outputs. The pair parts by 1e-14 of the grounds' relative displacement, 2e-16 m: 5e-10 s of last bounces
    of 4e-7 m/s, 1.5e-8 of the time of contact."""
    ground, gap = shaking(4.0), 0.002
    wave = WavePassage.on(velocity, 20.0)
    own = as_pair(Made([SOFT, STIFF], [gap], ground, wave=wave))
    pair = solve(SOFT, STIFF, Interface(gap, Stereomechanical(), HALF), ground, 0.01, supports=wave.supports(2))
    assert own["impact_count"] > 3
    assert_alike(own, pair, 1e-7)


def in_oracle(buildings, gaps, e, ground, dt, slowest):
    """The same row for the reference."""
    mass = np.array([inf if building.is_rigid else building.mass for building in buildings])
    period = np.array([building.period or 1.0 for building in buildings])
    damping = np.array([building.damping for building in buildings])
    return Run(Masses(mass, period, damping, np.array(gaps), np.array(e)), ground, dt, slowest).solve()


SLIM, HEAVY = Building("slim", 2e5, 0.9, 0.03), Building("heavy", 2e6, 0.45, 0.06)
ROWS = {
    "three": ([SOFT, FAR, STIFF], [0.004, 0.006], (0.5, 0.7)),
    "closed": ([SLIM, SOFT, STIFF], [1e-6, 1e-6], (0.4, 0.6)),
    "wall": ([SOFT, FAR, SLIM, WALL], [0.005, 0.0, 0.01], (0.6, 0.5, 0.3)),
    "plastic": ([SLIM, SOFT, HEAVY, FAR], [0.001, 0.005, 0.002], (1e-9, 1e-9, 1e-9)),
}


@pytest.mark.parametrize(
    ("name", "mirrored"), sweep(product(ROWS, (False, True)), ("three", False), ("plastic", False))
)
def test_whole_runs_against_scipy(name, mirrored):
    """Every touch, every end of a rest, impulses, energies and the last state, under a real record.

    The reference is good to some 1e-10 a jump, which tens of jumps let grow.
    """
    buildings, gaps, e = ROWS[name]
    ground, dt = RECORD.samples()
    if mirrored:
        buildings, gaps, e, ground = buildings[::-1], gaps[::-1], e[::-1], -ground
    made = Made(buildings, gaps, ground, dt, e=tuple(map(Restitution, e)), rtol=1e-3)
    reference = in_oracle(buildings, gaps, e, ground, dt, 1e-3 * np.full(len(gaps), made.free.fastest.max()))
    run = made.run()
    assert run.status == COMPLETE
    contacts = made.contacts(run)
    for point, touches in enumerate(reference.touches):
        own = [contact for contact in contacts if contact.point == point]
        np.testing.assert_allclose([contact.facts[0] for contact in own], touches, rtol=1e-6)
        ended = [contact.facts[1] for contact in own if contact.facts[1] > contact.facts[0]]
        np.testing.assert_allclose(ended[: len(reference.rests[point])], reference.rests[point], rtol=1e-6)
    values = made.outputs(run)
    assert values["impact_count"].sum() > 8
    assert name != "plastic" or np.all(values["contact_time"] > 0.0)  # rests are there to be compared
    np.testing.assert_allclose(values["impulse"], reference.impulse, rtol=1e-6)
    np.testing.assert_allclose(values["energy_viscous"], reference.lost, rtol=1e-6)
    moving = [place for place, building in enumerate(buildings) if not building.is_rigid]
    state = reference.state.reshape(2, -1)[:, moving]
    np.testing.assert_allclose(run.states[-1], state, rtol=0.0, atol=1e-6 * np.abs(state).max())
    assert np.all(values["peak_closing"] <= np.array(gaps) * (1.0 + 1e-12) + 1e-15)
    np.testing.assert_allclose(values["peak_closing"], reference.largest, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("name", ROWS)
def test_seen_from_behind_to_the_bit(name):
    """Everything but the ledger, whose sums are in the order of time."""
    buildings, gaps, e = ROWS[name]
    ground = shaking(4.0)
    rules = tuple(map(Restitution, e))
    one = Made(buildings, gaps, ground, e=rules).outputs()
    other = Made(buildings[::-1], gaps[::-1], -ground, e=rules[::-1]).outputs()
    for key, value in one.items():
        if key != "energy_residual" and not key.startswith("row_"):
            np.testing.assert_array_equal(value, np.flip(other[key], axis=0) if value.ndim else other[key], err_msg=key)
    assert one["impact_count"].sum() > 8


# ------------------------------------------------------------------------------------------------ mechanics


MASS = st.floats(1e-3, 1e3)


@st.composite
def chains(draw):
    """Compliances of a chain, with or without a wall at its ends, and what is given."""
    count = draw(st.integers(1, 6))
    inverse = np.array(draw(st.lists(MASS, min_size=count + 1, max_size=count + 1)))
    wall = draw(st.sampled_from([None, 0, -1]))
    if wall is not None:
        inverse[wall] = 0.0
    given_values = draw(st.lists(st.floats(-10.0, 10.0), min_size=count, max_size=count))
    return inverse, np.array(given_values)


@examples(75, chains())
def test_impulses_against_every_set_of_contacts(chain):
    """The answer solves the problem, is that of an enumeration, and is mirrored with its chain to the bit."""
    inverse, values = chain
    count = len(values)
    table = np.zeros((TABLE_ROWS, count))
    table[DIAGONAL], table[GIVEN] = inverse[:-1] + inverse[1:], values
    table[COUPLING] = -inverse[1:]
    matrix = np.diag(table[DIAGONAL])
    matrix -= np.diag(inverse[1:-1], 1) + np.diag(inverse[1:-1], -1)
    solve_complementarity(table, 0, count - 1)
    answer = table[ANSWER].copy()
    slack = matrix @ answer + values
    scale = np.abs(matrix) @ answer + np.abs(values) + 1e-300
    assert np.all(answer >= 0.0)
    assert np.all(slack >= -1e-9 * scale)
    assert np.all((answer == 0.0) | (np.abs(slack) <= 1e-9 * scale))
    expected = by_enumeration(matrix, values)
    np.testing.assert_allclose(matrix @ answer, matrix @ expected, atol=1e-7 * scale.max())
    mirror = np.zeros_like(table)
    mirror[DIAGONAL], mirror[GIVEN], mirror[COUPLING] = table[DIAGONAL][::-1], values[::-1], -inverse[::-1][1:]
    solve_complementarity(mirror, 0, count - 1)
    np.testing.assert_array_equal(mirror[ANSWER][::-1], answer)


test_many_impulses_against_every_set_of_contacts = many(test_impulses_against_every_set_of_contacts, 300)


def ball(mass=1e5):
    """A mass whose spring takes 1e-7 of what moves it within some seconds."""
    return Building("ball", mass, 1e4, 0.0)


def thrown(gap, e=1.0):
    """Three equal balls fly at 0.4 m/s towards a wall, in front of which the first meets the others: final speeds."""
    ground = np.zeros(89)
    ground[:41] = 1.0
    made = Made([WALL, ball(), ball(), ball()], [0.2, 0.1, gap], ground, e=Restitution(e))
    # The pull ends with half of an interval: 0.405 m/s.
    return made.run().states[-1, 1] / 0.405


@pytest.mark.parametrize("e", [1.0, 0.6])
def test_balls_that_touch_are_struck_together_and_others_in_turn(e):
    """Seen from the second and third: the first comes at 1 + e of the speed, having rebounded from the wall.

    Struck together, they leave the first with 2/3 of what separates them: s = e c, both at one speed. In turn, each
    jump is a pair's: (1 − e)/2 stays, (1 + e)/2 goes on.
    """
    came = 1.0 + e
    together = came * np.array([(1.0 - 2.0 * e) / 3.0, (1.0 + e) / 3.0, (1.0 + e) / 3.0]) - 1.0
    np.testing.assert_allclose(thrown(0.0, e), together, atol=1e-6)
    passed = came * (1.0 + e) / 2.0
    in_turn = np.array([came * (1.0 - e) / 2.0, passed * (1.0 - e) / 2.0, passed * (1.0 + e) / 2.0]) - 1.0
    if e == 1.0:
        np.testing.assert_allclose(thrown(1e-6, e), in_turn, atol=1e-6)


@pytest.mark.parametrize("law", [JUMP, Merged()])
def test_a_pile_comes_to_rest_against_a_wall(law):
    """Two masses under a constant pull: all bounces end, and momentum, energy and statics tell what is left.

    Wall's impulse = (m1 + m2) a t; the fall takes the work of the pull; the forces are those of the weights.
    """
    one, two, pull_of_ground, time = 1e5, 2e5, 1.0, 6.0
    gaps, ground = [0.02, 0.01], np.full(601, pull_of_ground)
    made = Made([WALL, ball(one), ball(two)], gaps, ground, law=law)
    run = made.run()
    values = made.outputs(run)
    loads = np.array([one + two, two]) * pull_of_ground
    np.testing.assert_allclose(values["impulse"], loads * time, rtol=1e-6)
    work = pull_of_ground * (one * 0.02 + two * 0.03)
    assert values["row_energy_lost"] == pytest.approx(work, rel=1e-6)
    np.testing.assert_allclose(run.states[-1, 1], 0.0, atol=1e-12)
    np.testing.assert_allclose(run.states[-1, 0], [-0.02, -0.03], rtol=1e-12)
    np.testing.assert_allclose([contact.forces[-1] for contact in made.contacts(run)[-2:]], loads[::1], rtol=1e-6)
    assert np.all(values["impact_count"] < 200)


def test_a_jump_alone_is_goldsmiths():
    """P = (1 + e) m c and (1 − e²) m c² / 2 of every contact, none of which coincides with another; momenta add up."""
    buildings, gaps, e = ROWS["three"]
    made = Made(buildings, gaps, shaking(4.0), e=tuple(map(Restitution, e)))
    run = made.run()
    lost, contacts = np.zeros(2), made.contacts(run)
    assert len({contact.facts[0] for contact in contacts}) == len(contacts) > 8
    for contact in contacts:
        place = contact.point
        reduced = 1.0 / (1.0 / buildings[place].mass + 1.0 / buildings[place + 1].mass)
        speed, impulse = contact.facts[2], contact.facts[4]
        assert impulse == pytest.approx((1.0 + e[place]) * reduced * speed, rel=1e-9)
        assert np.isnan(contact.facts[3])
        lost[place] += 0.5 * (1.0 - e[place] ** 2) * reduced * speed**2
    np.testing.assert_allclose(made.outputs(run)["energy_viscous"], lost, rtol=1e-12)


def test_a_stiff_contact_tends_to_the_jumps():
    """Separate impacts of three masses: what differs falls with the duration of a contact, as k^(−1/2)."""
    ground = shaking(4.0)[:160]
    buildings, gaps = [SOFT, FAR, SLIM], [0.004, 0.006]
    jump = Made(buildings, gaps, ground).outputs()
    assert jump["impact_count"].sum() >= 3
    far, near = (Made(buildings, gaps, ground, law=KelvinVoigt(stiffness)).outputs() for stiffness in (1e11, 1e15))
    for name in ("impulse", "peak_opening", "peak_displacement"):
        off = [np.abs(stiff[name] / jump[name] - 1.0).max() for stiff in (far, near)]
        assert off[1] < off[0] / 30.0 < 1e-2, name
    np.testing.assert_array_equal(near["impact_count"], jump["impact_count"])


@pytest.mark.parametrize("wave", [None, PASSING])
@pytest.mark.parametrize("gap", [0.001, 0.008, 0.02])
def test_parts_of_a_row_are_the_row(gap, wave):
    """Solved in parts, with neighbours that look on, every output but the ledger has the bits of the whole row."""
    buildings = [SOFT, STIFF, FAR, SLIM, HEAVY]
    made = Made(buildings, [gap, 0.03, 2.0 * gap, 0.015], shaking(3.0), wave=wave)
    parts, answers = made.cases.in_parts(made.limits)
    assert answers
    whole, own = made.outputs(), made.outputs(parts)
    for name, value in whole.items():
        if name not in ("energy_residual",):
            np.testing.assert_array_equal(own[name], value, err_msg=name)


@pytest.mark.parametrize("wave", [None, PASSING])
@pytest.mark.parametrize("law", [JUMP, Merged()])
@pytest.mark.parametrize("gaps", [[0.0, 0.0, 0.0], [1e-6, 0.0, 0.01], [0.003, 0.003, 0.0]])
def test_no_run_chatters_for_ever(law, gaps, wave):
    """Closed and narrow gaps beside a wall: complete, no gap is passed, and energy closes to rounding."""
    made = Made([SOFT, STIFF, FAR, WALL], gaps, shaking(5.0), law=law, e=CONCRETE, wave=wave)
    run = made.cases.whole(made.limits)
    values = made.outputs(run)
    assert run.status == COMPLETE
    assert 0 < values["impact_count"].sum() < 3000
    assert np.all(values["energy_residual"] < 1e-12)
    assert np.all(values["peak_penetration"] == 0.0)
    assert np.all(values["peak_closing"] <= np.array(gaps) + 1e-15)
    assert np.all(values["yield_count"][values["impact_count"] > 0] == -1)


def test_another_row_is_no_row_of_masses():
    points = [Point(0, 0.5, 1.0, FLOOR, nan)]
    laid = RowModel([chain_of(SOFT), chain_of(STIFF)], points).row(0.01)
    contacts = Contacts(np.zeros(1), np.full(1, inf), [JUMP], [HALF])
    with pytest.raises(ValueError, match="single masses that meet mass to mass"):
        run_jumps(laid, contacts, np.zeros(3), rows.free_row(laid, np.zeros(3)))
