"""Contact laws in a row: every kind of them as a pair has it, side by side, and as they are defined last.

Compiling a law takes longer than all that is shown here, and what is shown does not depend on it: short records,
interpreted. That compiled code has the same bits is shown with a law that remembers four numbers.
"""

import json

import numpy as np
import pytest
from processes import interpreted
from row_cases import EL_CENTRO, PLACES, RIGID, contacts_of, floors, jankowski, meeting, points_of, single, storeys
from scipy.integrate import solve_ivp
from sweeps import sweep

from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver import counters
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

SETUP = """
import json
import numpy as np
from pounding_risk.solver.row import api as rows
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.solver.row import interval
from pounding_risk.solver.row import run as march
from pounding_risk.solver.row.layout import lay_out
from pounding_risk.models.contact.laws import Bilinear, Hertz, Linear, VanMier, ViscousElastoplastic
from pounding_risk.models.effects import PermanentSet, StrainRate, UnloadingStiffness
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from row_cases import EL_CENTRO, floors, meeting, named, points_of, single, storeys

ACCELERATION, DT = EL_CENTRO.samples()
FORCE, GAP, E = 4e5, 0.005, constant(0.65)
BUILDINGS = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)
PAIR = [chain_of(each) for each in BUILDINGS]

def solved(chains, meetings, laws, samples=150):
    row = lay_out(chains, points_of(meetings), DT)
    count = len(meetings)
    gaps, forces = np.array([each.gap for each in meetings]), np.full(count, FORCE)
    return rows.run_row(row, rows.Contacts(gaps, forces, laws, [E] * count), ACCELERATION[:samples], rtol=1e-9)
"""
LAWS = """
from pounding_risk.solver.pair.api import Interface, solve

def hardened(law):
    return StrainRate.on(law, code="mc2010", length=0.6)

laws = [
    Linear(2e8), Bilinear(2.75e9), Bilinear(2.75e9, 0.01), ViscousElastoplastic(2.75e9),
    PermanentSet(ViscousElastoplastic(2.75e9)), PermanentSet(VanMier(2.75e9)),
    hardened(VanMier(2.75e9)), hardened(ViscousElastoplastic(2.75e9)),
    UnloadingStiffness(PermanentSet(ViscousElastoplastic(2.75e9)), 2.0),
]
# All in one run, couple beside couple, and far from each other.
chains, meetings = PAIR * len(laws), []
for place in range(2 * len(laws) - 1):
    meetings.append(meeting(place, 1.0, 1.0, 9.0 if place % 2 else GAP))
between = [each for law in laws for each in (law, Hertz(1e9))][:-1]
run = solved(chains, meetings, between)
found = named(run)
print(json.dumps([run.status, [
    [repr(law), {name: float(found[name][2 * place]) for name in NAMES},
     {name: float(true[name]) for name in NAMES}]
    for place, law in enumerate(laws)
    for true in [solve(*BUILDINGS, Interface(GAP, law, E, FORCE), ACCELERATION[:150], DT, rtol=1e-9)]
]]))
"""
NAMES = ("peak_closing", "peak_penetration", "peak_contact_force", "impulse", "contact_time", "impact_count")
OWN = """
import pounding_risk as pr
from typing import Annotated, NamedTuple
from pounding_risk.models.contact import laws as contact

def spring(factor):
    class Cushion(NamedTuple):
        stiffness: Annotated[float, contact.LINEAR_STIFFNESS]
        capped, needs_restitution = False, False
        begin = contact.undamped
        def force(self, memory, delta, rate, approaching):
            return factor * self.stiffness * delta
        def stored(self, delta, strength):
            return 0.5 * factor * self.stiffness * delta * delta
        def conserves(self):
            return True
        plateau, ceiling, floor = contact.flat, contact.never_yields, contact.may_pull
    return pr.contact_law(Cushion)

touch = [meeting(0, 1.0, 1.0, GAP)]
print(json.dumps([
    [solved(PAIR, touch, [law]).points.tolist() for law in (spring(factor)(1e8), Linear(factor * 1e8))]
    for factor in (1.0, 4.0, 1.0)
]))
"""
GROUPS = """
chains = [single(2e5, 0.45), storeys(2, 80e3, 5e7), storeys(2, 70e3, 4e7), single(1.5e5, 0.25), storeys(1, 9e4, 9e6)]
meetings = [
    meeting(0, 1.0, 1.5, 0.002), *floors(1, 1.0, 2.0, gap=GAP12), meeting(2, 2.0, 1.0, 0.003),
    meeting(3, 1.0, 1.0, 0.004),
]
laws = [ViscousElastoplastic(2.75e9)] * len(meetings)
apart = solved(chains, meetings, laws, 130)
march.any_closed = interval.any_closed = lambda row, run, first, last: True
together = solved(chains, meetings, laws, 130)
print(json.dumps([[run.status, run.points.tolist(), run.floors.tolist()] for run in (apart, together)]))
"""


@pytest.mark.complete
def test_laws_of_every_kind_side_by_side_are_those_of_a_pair():
    """With and without effects, with memories of none to four numbers; an effect around two laws is two laws.

    The pair's solver shares the laws with the row's, and neither calls nor memory; both run at rtol 1e-9.
    """
    status, laws = interpreted(f"{SETUP}\nNAMES = {NAMES}\n{LAWS}")
    assert status == counters.COMPLETE
    for law, found, true in laws:
        assert found["impact_count"] == true["impact_count"] >= 1, law
        assert found == pytest.approx(true, rel=1e-7), law


def test_a_law_defined_again_answers_with_its_own_numbers_in_a_row():
    """One name, three classes: each is the linear spring of its own stiffness, to the bit."""
    for own, known in interpreted(SETUP + OWN):
        np.testing.assert_array_equal(np.array(own), np.array(known))
        assert own[0][counters.COUNT] >= 1


@pytest.mark.complete
@pytest.mark.parametrize("gap", [0.006, 0.5])
def test_groups_side_by_side_are_one_group(gap: float):
    """Solved apart where they stand apart, against all buildings in one group at all times: 1e-7 at rtol 1e-9."""
    apart, together = interpreted(SETUP + GROUPS.replace("GAP12", repr(gap)))
    assert apart[0] == together[0] == counters.COMPLETE
    points, all_points = np.array(apart[1]), np.array(together[1])
    assert points[:, counters.COUNT].tolist() == all_points[:, counters.COUNT].tolist()
    assert (points[:, counters.COUNT] > 0).sum() >= 3
    same = [PLACES[name] for name in ("peak_closing", "peak_contact_force", "impulse", "peak_penetration")]
    np.testing.assert_allclose(points[:, [*same, rows.LOWEST]], all_points[:, [*same, rows.LOWEST]], rtol=1e-7)
    np.testing.assert_allclose(apart[2], together[2], rtol=1e-7)


def test_a_closed_gap_at_rest_under_a_tapered_record():
    """Nothing presses while a_g is zero; then the contact begins, and flights of no length do not go on for ever."""
    acceleration, dt = EL_CENTRO.samples()
    tapered = acceleration[:200] * np.minimum(np.arange(200) / 50.0, 1.0)
    chains, meetings = (single(2e5, 0.5), storeys(2, 80e3, 5e7)), floors(0, 1.0, gap=0.0)
    for quiet in (0, 7):
        shaken = np.concatenate([np.zeros(quiet), tapered])
        run = rows.run_row(lay_out(chains, points_of(meetings), dt), contacts_of(meetings), shaken)
        assert run.status == counters.COMPLETE
        assert run.points[0, counters.COUNT] >= 1
        assert quiet * dt <= run.points[0, counters.FIRST_TOUCH] < quiet * dt + 1.0


def hertz_chain(masses: np.ndarray, beta: float, speed: float) -> tuple[np.ndarray, np.ndarray]:
    """(ends of contact [s], impulses [N s]) of free touching masses, the first at ``speed``, by SciPy."""

    def forces(delta):
        return beta * np.maximum(delta, 0.0) ** 1.5

    def motion(_, state):
        u, v, _ = np.split(state, [masses.size, 2 * masses.size])
        force = forces(u[:-1] - u[1:])
        push = np.zeros(masses.size)
        push[:-1] -= force
        push[1:] += force
        return np.concatenate([v, push / masses, force])

    count = masses.size - 1
    state = np.zeros(2 * masses.size + count)
    state[masses.size] = speed
    parted = [lambda _, y, k=k: y[k] - y[k + 1] for k in range(count)]
    for event in parted:
        event.direction = -1.0
    run = solve_ivp(motion, (0.0, 0.6), state, method="DOP853", events=parted, rtol=1e-11, atol=1e-15, max_step=1e-3)
    return np.array([times[-1] for times in run.t_events]), run.y[-count:, -1]


@pytest.mark.parametrize("step", [0.3, 0.1, 0.01])
def test_touching_masses_are_in_contact_from_the_first_touch_on(step):
    """A chain that touches, struck at one end: each contact lasts from that instant to its parting, whatever the step.

    Masses on springs of 5000 s, which take 1e-6 of the impulse in 0.6 s.
    """
    masses, beta = np.array([20e3, 20e3, 18e3, 17e3, 15e3]), 5e7
    chains = [chain_of(Building("", mass, 5000.0, 0.0)) for mass in masses]
    chains[0] = chains[0]._replace(initial=np.array([[0.0], [0.5]]))
    meetings = [meeting(i, 1.0, 1.0, 0.0, law="hertz", stiffness=beta, restitution=1.0) for i in range(4)]
    laid = lay_out(chains, points_of(meetings), step)
    run = rows.run_row(laid, contacts_of(meetings), np.zeros(1 + round(0.6 / step)), rtol=1e-10)
    ends, impulses = hertz_chain(masses, beta, 0.5)
    np.testing.assert_array_equal(run.points[:, counters.FIRST_TOUCH], 0.0)
    np.testing.assert_array_equal(run.points[:, counters.COUNT], 1)
    np.testing.assert_allclose(run.points[:, counters.CONTACT_TIME], ends, rtol=1e-5)
    np.testing.assert_allclose(run.points[:, counters.IMPULSE], impulses, rtol=1e-5)


def test_equal_houses_that_sway_alike_are_all_struck_at_once():
    """Three equal houses side by side, moved by one record, and a wall with a gap: one instant for all contacts."""
    acceleration, dt = EL_CENTRO.samples()
    house = storeys(2, 80e3, 5e7)
    chains = (RIGID, house, house, house)
    meetings = [*floors(0, 1.0, 2.0, gap=0.002), *(point for i in (1, 2) for point in floors(i, 1.0, 2.0, gap=0.0))]
    run = rows.run_row(lay_out(chains, points_of(meetings), dt), contacts_of(meetings), acceleration[:300])
    first = run.points[:, counters.FIRST_TOUCH]
    assert run.status == counters.COMPLETE and first[:2].min() > 0.0
    np.testing.assert_array_equal(first[2:], first[:2].min())


def test_a_row_without_contact_points_is_free():
    acceleration, dt = EL_CENTRO.samples()
    laid = lay_out(jankowski(), [], dt)
    run = rows.run_row(laid, rows.Contacts(np.zeros(0), np.zeros(0), [], []), acceleration[:100])
    assert run.status == counters.COMPLETE
    np.testing.assert_array_equal(run.floors, rows.free_row(laid, acceleration[:100]).floors)


BITS = """
meetings = [meeting(0, 1.0, 1.0, 0.002), *floors(1, 1.0, 2.0, gap=0.0)]
chains = [single(2e5, 0.45), storeys(2, 80e3, 5e7), storeys(2, 70e3, 4e7)]
run = solved(chains, meetings, LAW, 120)
print(json.dumps([run.status, run.steps, run.points.tolist(), run.floors.tolist(), run.rest.tolist()]))
"""


@pytest.mark.parametrize(
    "law", sweep(["Bilinear(2.75e9)", "ViscousElastoplastic(2.75e9)"], "ViscousElastoplastic(2.75e9)")
)
def test_a_row_compiled_is_the_row_interpreted_in_bits(law: str, capsys: pytest.CaptureFixture[str]):
    code = SETUP + BITS.replace("LAW", f"[{law}] * 3")
    status, steps, *values = interpreted(code)
    exec(code, {})
    found_status, found_steps, *found = json.loads(capsys.readouterr().out)
    assert (status, steps) == (found_status, found_steps)
    assert status == counters.COMPLETE
    assert json.dumps(found) == json.dumps(values)


ALIKE = """
# A wall, pressed from the first instant on, and two masses that begin to move towards it alike.
ground = np.full(21, 2.0)
found = []
for mass in np.linspace(7.1e4, 9.3e4, 12):
    chains = [chain_of(Building.rigid("wall")), single(1.3 * mass, 0.31), single(mass, 0.47)]
    row = lay_out(chains, points_of([meeting(0, 1.0, 1.0, 0.0), meeting(1, 1.0, 1.0, 0.0)]), DT)
    contacts = rows.Contacts(np.zeros(2), np.full(2, np.inf), [ViscousElastoplastic(2.75e9)] * 2, [E] * 2)
    found.append(rows.run_row(row, contacts, ground).points[:, 2].tolist())
print(json.dumps(found))
"""


@pytest.mark.complete
def test_neighbours_that_begin_alike_do_not_press_each_other_by_rounding():
    """The wall stands still and is pressed at once; both masses have the ground's acceleration, and touch later."""
    for wall, between in interpreted(SETUP + ALIKE):
        assert wall == 0.0
        assert between > 0.0
