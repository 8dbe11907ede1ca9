"""What must hold of any row: parts that do not touch are alone, and mirror images are alike."""

from itertools import pairwise
from typing import Any

import numpy as np
import pytest
from oracle_rows import integrate
from processes import interpreted
from row_cases import (
    CASES,
    EL_CENTRO,
    PLACES,
    YIELDS,
    Case,
    Shaking,
    by_solver,
    floors,
    jankowski,
    meeting,
    named,
    single,
    storeys,
)

import pounding_risk as pr
from pounding_risk.solver import counters
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

# Two like buildings drawn away from the one between them and let go; a run begins at rest, so what begins it is told.
# Where the contacts' own damping is much quicker than the buildings, their equations are solved from both sides.
MIRRORED = """
import json
import numpy as np
from row_cases import contacts_of, meeting, points_of, storeys
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row import implicit
from pounding_risk.solver.row.layout import lay_out

side, middle = storeys(2, 90e3, 4e7), storeys(2, 60e3, 3e7)
meetings = [meeting(interface, 1.6, 1.6, 0.01, **KEYS) for interface in (0, 1)]
solve, solved = implicit.closing_changes, []

def counted(*arguments):
    changes = solve(*arguments)
    solved.append(changes.tolist())
    return changes

implicit.closing_changes = counted
drawn = [side._replace(initial=np.array([[u, 2.0 * u], [0.0, 0.0]])) for u in (-0.03, 0.03)]
laid = lay_out((drawn[0], middle, drawn[1]), points_of(meetings), 0.01)
run = rows.run_row(laid, contacts_of(meetings), np.zeros(60))
print(json.dumps([run.status, run.points.tolist(), run.floors.tolist(), solved]))
"""


def free(chains: Any, shaking: Any = EL_CENTRO) -> Any:
    """Buildings without contact."""
    acceleration, dt = shaking.samples()
    return rows.free_row(lay_out(chains, (), dt), acceleration)


def test_wide_gaps_are_single_buildings_bit_by_bit():
    """A row that never closes, its free motion, and every building of it in a row of its own."""
    chains = (single(90e3, 0.4), storeys(3, 80e3, 5e7), storeys(2, 100e3, 9e7))
    points = (meeting(0, 1.0, 2.5, 9.0), *floors(1, 1.0, 2.0, gap=9.0))
    run = by_solver(Case(chains, points, EL_CENTRO))
    assert run.points[:, PLACES["impact_count"]].max() == 0
    np.testing.assert_array_equal(run.floors, free(chains).floors)
    np.testing.assert_array_equal(run.floors, np.vstack([free((chain,)).floors for chain in chains]))


def test_parts_that_do_not_touch_are_alone_bit_by_bit():
    """A pair that pounds, beside a street that it does not reach."""
    pair, beside = CASES["jankowski 2008"], storeys(2, 100e3, 9e7)
    points = (*pair.meetings, *floors(1, 1.0, 2.0, gap=9.0))
    run, alone = by_solver(Case((*pair.chains, beside), points, pair.shaking)), by_solver(pair)
    assert alone.points[:, PLACES["impact_count"]].min() >= 1
    np.testing.assert_array_equal(run.points[:3], alone.points)
    np.testing.assert_array_equal(run.floors[:6], alone.floors)
    np.testing.assert_array_equal(run.floors[6:], free((beside,), pair.shaking).floors)


@pytest.mark.parametrize(
    "keys", [{"yield_force": 1e6}, pytest.param({"restitution": 1e-4}, marks=pytest.mark.complete)], ids=str
)
def test_between_mirror_images_a_building_stands_exactly_still(keys: dict[str, float]):
    """Both sides touch, turn and part at the same instants, to the last bit, against columns between two floors."""
    status, points, floors, solved = interpreted(MIRRORED.replace("KEYS", repr(keys)))
    assert status == counters.COMPLETE
    assert bool(solved) == ("restitution" in keys) and all(left == right for left, right in solved)
    assert repr(points[0][: counters.TALLIED]) == repr(points[1][: counters.TALLIED])
    assert points[0][counters.COUNT] == 2 or (solved and points[0][counters.COUNT] >= 1)
    assert floors[2:4] == [[0.0] * 4] * 2
    assert floors[:2] == floors[4:]


@pytest.mark.parametrize("name", ["5 and 3 storeys, floors against columns", "single, rigid, storeys"])
def test_a_row_from_the_other_side_of_the_street(name: str):
    """Left and right swapped and the ground reversed: the same motion, but for the order in which rounding adds up."""
    case = CASES[name]
    last = len(case.chains) - 2
    meetings = [
        each._replace(interface=last - each.interface, left_floor=each.right_floor, right_floor=each.left_floor)
        for each in case.meetings
    ]
    order = sorted(range(len(meetings)), key=lambda k: meetings[k].interface)
    shaking = case.shaking._replace(polarity="reversed")
    found = by_solver(Case(case.chains[::-1], tuple(meetings[k] for k in order), shaking))
    true = by_solver(case)
    mirrored, known = named(found), named(true)
    for output in ("peak_closing", "peak_contact_force", "impulse", "peak_approach_speed"):
        np.testing.assert_allclose(mirrored[output], known[output][order], rtol=1e-7, err_msg=output)
    ends = np.cumsum([0, *(len(chain.mass) for chain in case.chains)])
    parts = [true.floors[start:end] for start, end in pairwise(ends)]
    np.testing.assert_allclose(found.floors, np.vstack(parts[::-1]), rtol=1e-7)


@pytest.mark.complete
def test_a_record_may_end_while_a_storey_yields():
    """The elastic range at the end is where the storey has dragged it by then."""
    chain = jankowski(YIELDS)[0]
    shaking = EL_CENTRO._replace(pga=0.5)
    acceleration, dt = shaking.samples()
    caught = 0
    for stop in range(60, 300, 20):
        cut = acceleration[:stop]
        true = integrate((chain,), (), cut, dt)
        found = rows.free_row(lay_out((chain,), (), dt), cut)
        np.testing.assert_allclose(found.rest, true.rest, rtol=1e-9, atol=1e-12)
        caught += bool(np.any(np.abs(true.rest[:, 0] - true.rest[:, 1]) >= chain.strength / chain.shear * (1 - 1e-9)))
    assert caught >= 1, "no record ends so"


def test_a_storey_and_the_contact_above_it_turn_at_one_instant():
    """Against a wall both have the same speed; which of two events at once comes first is rounding, and ends no run."""
    case = CASES["a yielding storey at a wall"]
    for pga in np.linspace(0.3, 0.8, 40):
        run = by_solver(case._replace(shaking=case.shaking._replace(pga=float(pga))))
        assert run.status == counters.COMPLETE, pga
        assert run.points[0, counters.COUNT] >= 1


def test_a_storey_that_has_just_turned_yields_where_it_comes_back():
    """At 0.54 g a storey turns, and comes back to its limit within one step in contact, at which the model of the step
    was off by more than the storey had left: the event was taken to be at the turn, again and again.
    """
    isolators = {"slab_mass": "224 t", "height": "1 m", "strength": "148384 N", "stiffness": "2300822 N/m"}
    scene = {
        "building": [
            {"name": "A", "period": "0.514 s", "storey_strengths": ["45488 N"] * 4, "storey_heights": ["3.11 m"] * 4}
            | {"floor_masses": ["163.2 t", "230.5 t", "32.8 t", "272.1 t"]},
            {"name": "B", "period": "0.764 s", "floor_masses": ["91.7 t"], "storey_heights": ["3.45 m"]}
            | {"isolation": isolators},
        ],
        "interface": [
            {"gap": "2 mm", "contact_model": "linear", "stiffness": "93500 kN/m", "link_stiffness": "33154390 N/m"}
        ],
        "effects": {"inelastic_storeys": {}},
        "records": {"names": ["RSN753-000"], "window": ["0 s", "10 s"]},
        "grid": {"pga": ["0.5399 g", "0.54 g", "0.5401 g"]},
    }
    found = pr.scan(pr.read_scene(scene), check_fraction=0.0)
    assert (found["status"] == counters.COMPLETE).all() and (found["energy_residual"] < 1e-6).all()
    assert (found["impact_count"].max("interface") > 10).all()


def test_a_soft_touch_after_yielding_closes_its_energy():
    """Storeys that have yielded hold no energy below zero: a ledger is measured by that of the touch at least."""
    mass, strength = 300e3, 370e3
    frames = tuple(
        storeys(1, mass, mass * (2.0 * np.pi / period) ** 2, YIELDS, strength=strength) for period in (0.3, 0.4)
    )
    run = by_solver(Case(frames, floors(0, 1.0, gap=0.02), Shaking("RSN6-180", 0.0, 53.0, 0.3, "reversed")))
    assert run.status == counters.COMPLETE
    assert np.abs(run.rest[:, 1]).min() > 1e-3  # m: both have yielded
    assert run.points[0, PLACES["impact_count"]] == 1
    # The kinetic energy of two bodies is that of their approach, 1/2 (m/2) v², at least.
    assert run.energy >= 0.25 * mass * run.points[0, PLACES["peak_approach_speed"]] ** 2
