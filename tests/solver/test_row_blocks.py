"""Blocks of nodes that a run of a row passes over, groups that are solved together, and outputs of interfaces.

A run whose bounds of the free motion are infinite passes over nothing: it goes from node to node, and searches wherever
buildings have been in contact.
"""

from collections import Counter
from itertools import pairwise
from math import inf
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from row_cases import CASES, EL_CENTRO, RIGID, contacts_of, meeting, points_of, single, storeys
from scipy.linalg import expm

from pounding_risk.models.effects.wave_passage import WavePassage
from pounding_risk.models.structures.links import Link
from pounding_risk.results.layout import AXES
from pounding_risk.results.variables import MOTION, VARIABLES
from pounding_risk.solver.counters import APPROACH, COMPLETE, COUNT, PLASTIC, STATUS, TALLIED
from pounding_risk.solver.pair.outputs import BUILDING, COLUMNS, RUN
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row import outputs
from pounding_risk.solver.row.api import HIGHEST, LOWEST, POINT_COLUMNS
from pounding_risk.solver.row.layout import lay_out
from pounding_risk.solver.row.outputs import GATHERED, HIGH, LOW, OF_LINKS, POINT, Variable
from pounding_risk.solver.row.partition import HELD, LEFTWARDS, RIGHTWARDS, Span, gathered, solved_spans, tied
from pounding_risk.solver.row.workspace import GIVE, ROOT, SWAY

ACCELERATION, DT = EL_CENTRO.samples()
CHAINS = (
    single(90e3, 0.2),
    single(200e3, 0.7),
    storeys(2, 100e3, 1e8),
    storeys(3, 70e3, 4e7, damping_rule="stiffness"),
    storeys(2, 100e3, 1e8),
    RIGID,
)
LIMP = storeys(1, 52e3, 8.6e6, ("inelastic_storeys", (("hardening", 0.03),)), strength=4.5e4)


def never_passing(motion: Any) -> Any:
    """The free motion with bounds that leave room for everything."""
    points = np.empty_like(motion.point_bounds)
    points[:, 0], points[:, 1] = inf, -inf
    return motion._replace(floor_bounds=np.full_like(motion.floor_bounds, inf), point_bounds=points)


def same_bits(one: Any, other: Any) -> None:
    """Every number of two runs but their histories."""
    for name in ("points", "floors", "rest", "status", "steps", "energy", "residual", "grew", "first", "reached"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name), err_msg=name)


def laid_row(chains: Any, gaps: Any, lags: Any = None) -> tuple[Any, Any]:
    """Neighbours that meet at the lower building's roof, and what the solver is told of the contacts."""
    meetings = []
    for interface, gap in enumerate(gaps):
        floors = [max(len(chain.mass), 1) for chain in chains[interface : interface + 2]]
        level = float(min(floors)) if all(len(chain.mass) for chain in chains[interface : interface + 2]) else None
        left, right = (level, level) if level else (1.0, 1.0)
        meetings.append(meeting(interface, left, right, gap, stiffness=2e8, law="kelvin_voigt_tension_cut"))
    arrivals = None if lags is None else WavePassage(0.0, lags).arrivals(len(chains))
    return lay_out(chains, points_of(meetings), DT, arrivals), contacts_of(meetings)


def needed(free: Any) -> np.ndarray:
    """The gap that the free motion needs at each point, one centimetre where it needs none."""
    high = free.run.points[:, rows.HIGHEST]
    return np.where(high > 0.0, high, 0.01)


@settings(max_examples=25)
@given(
    kinds=st.lists(st.integers(0, len(CHAINS) - 1), min_size=2, max_size=5),
    shares=st.lists(st.sampled_from([0.0, 0.3, 0.7, 0.95, 1.01, 2.0]), min_size=4, max_size=4),
    quiet=st.integers(0, 40),
    factor=st.sampled_from([1.0, -1.7]),
)
@example(kinds=[0, 1], shares=[0.3] * 4, quiet=0, factor=1.0)  # without a bound on what contacts leave
@example(kinds=[1, 3], shares=[0.3] * 4, quiet=0, factor=1.0)  # these two miss touches and peaks
def test_passing_over_blocks_is_walking_every_node(kinds, shares, quiet, factor):
    """States at the nodes, counters and peaks to the bit; blocks begin anywhere in the shaking."""
    chains = [CHAINS[kind] for kind in kinds]
    laid, contacts = laid_row(chains, [1.0] * (len(chains) - 1))
    ground = factor * np.concatenate([np.zeros(quiet), ACCELERATION, np.zeros(150)])
    free = rows.free_response(laid, ground)
    contacts = contacts._replace(gaps=needed(free) * shares[: len(chains) - 1])
    run = rows.run_row(laid, contacts, ground, free=free.motion)
    same_bits(run, rows.run_row(laid, contacts, ground, free=never_passing(free.motion)))
    whole = rows.run_row(laid, contacts, ground, free=free.motion, histories=True)
    same_bits(run, whole)
    walked = rows.run_row(laid, contacts, ground, free=never_passing(free.motion), histories=True)
    np.testing.assert_array_equal(whole.states, walked.states)
    np.testing.assert_array_equal(whole.log, walked.log)
    assert run.status == COMPLETE


@pytest.mark.parametrize("lags", [None, pytest.param((0.0437, 0.0163, -0.02), marks=pytest.mark.complete)])
def test_so_it_is_beside_yielding_storeys_and_in_a_wave(lags):
    chains = (CHAINS[3], LIMP, CHAINS[1], CHAINS[2])
    laid, contacts = laid_row(chains, [1.0] * 3, lags)
    free = rows.free_response(laid, ACCELERATION)
    contacts = contacts._replace(gaps=needed(free) * [0.9, 0.6, 0.8])
    run = rows.run_row(laid, contacts, ACCELERATION, free=free.motion)
    assert run.status == COMPLETE and run.points[:, COUNT].min() >= 1
    same_bits(run, rows.run_row(laid, contacts, ACCELERATION, free=never_passing(free.motion)))
    same_bits(run, rows.run_row(laid, contacts, ACCELERATION, free=free.motion, histories=True))


def test_what_is_passed_over_is_not_read():
    """States at blocks of no meaning: a run without contact is the free motion all the same, of every part."""
    laid, contacts = laid_row(CHAINS, [1.0] * 5)
    free = rows.free_response(laid, ACCELERATION)
    states = np.full_like(free.motion.states, np.nan)
    states[-1] = free.motion.states[-1]
    contacts = contacts._replace(gaps=1.001 * needed(free))
    run = rows.run_row(laid, contacts, ACCELERATION, free=free.motion._replace(states=states))
    assert run.status == COMPLETE
    for name in ("floors", "rest", "points"):
        np.testing.assert_array_equal(getattr(run, name), getattr(free.run, name))


def test_long_after_a_contact_blocks_are_passed_over_again():
    """A touch in the first seconds; then weak shaking, whose states are not read once the vibration is small."""
    laid, contacts = laid_row((CHAINS[0], CHAINS[3]), [1.0])
    ground = np.concatenate([ACCELERATION, 1e-3 * np.tile(ACCELERATION, 3)])
    free = rows.free_response(laid, ground)
    contacts = contacts._replace(gaps=0.7 * needed(free))
    run = rows.run_row(laid, contacts, ground, free=free.motion)
    assert run.points[0, COUNT] >= 1
    states = free.motion.states.copy()
    states[2 * ACCELERATION.size // laid.block : -1] = np.nan
    same_bits(run, rows.run_row(laid, contacts, ground, free=free.motion._replace(states=states)))


def motion_matrix(chain: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """d/dt of (u, v), M⁻¹ K and M⁻¹ C of a chain, written out here once more."""
    n = len(chain.mass)
    stiffness = np.diag(chain.spring + np.append(chain.spring[1:], 0.0))
    for i, spring in enumerate(chain.spring[1:]):
        stiffness[i, i + 1] = stiffness[i + 1, i] = -spring
    inner, drag = stiffness / chain.mass[:, None], chain.damping / chain.mass[:, None]
    return np.block([[np.zeros((n, n)), np.eye(n)], [-inner, -drag]]), stiffness, drag


@pytest.mark.parametrize("name", ["jankowski 2008", "soil", "p_delta"])
def test_a_free_vibration_stays_within_its_bounds_and_is_led_over_a_block(name: str):
    """Any start, by the exponential of the matrix at 40 instants: what the energy allows, and where a block ends."""
    chain = CASES[name].chains[0]
    laid = lay_out((chain,), (), DT)
    matrix, stiffness, _ = motion_matrix(chain)
    n, random = len(chain.mass), np.random.default_rng(3)
    np.testing.assert_allclose(laid.row.floors[SWAY] ** 2, np.diag(np.linalg.inv(stiffness)), rtol=1e-12)
    block_map = laid.block_maps[:-1].reshape(2 * n, 2 * n).T
    scale = np.append(np.ones(n), np.full(n, np.sqrt(np.abs(matrix[n:, :n]).max())))
    exact = expm(matrix * laid.step * laid.block)
    assert np.abs((block_map - exact) * scale / scale[:, None]).max() < 1e-12
    for start in random.normal(size=(20, 2 * n)) * scale:
        u, v = start[:n], start[n:]
        rate = matrix @ start
        energy = u @ stiffness @ u + chain.mass @ v**2
        shaking = v @ stiffness @ v + chain.mass @ rate[n:] ** 2
        for instant in np.geomspace(1e-3, 3.0, 40):
            later = expm(matrix * instant) @ start
            assert (np.abs(later[:n]) <= laid.row.floors[SWAY] * np.sqrt(energy)).all()
            assert (np.abs(np.diff(later[:n], prepend=0.0)) <= laid.row.floors[GIVE] * np.sqrt(energy)).all()
            assert (np.abs((matrix @ later)[n:]) <= laid.row.floors[ROOT] * np.sqrt(shaking)).all()


def test_the_free_motion_stays_within_the_bounds_of_its_blocks():
    """Six instants between nodes, by the exponential of the matrix; in the strongest blocks they are nearly reached."""
    laid, _ = laid_row((CHAINS[3], CHAINS[1]), [1.0])
    free = rows.free_response(laid, ACCELERATION)
    motion, masses = free.motion, (slice(0, 3), slice(3, 4))
    states = rows.free_row(laid, ACCELERATION, states=True).states
    blocks = [*range(0, len(states) - 1, laid.block), len(states) - 1]
    np.testing.assert_array_equal(motion.states, states[blocks])
    reached = np.zeros((*motion.floor_bounds.shape, 1))[..., 0]
    across = np.full(motion.point_bounds.shape, -inf)
    for node in range(len(ACCELERATION) - 1):
        block, pull = node // laid.block, ACCELERATION[node]
        rise = (ACCELERATION[node + 1] - pull) / DT
        for x in np.linspace(0.0, DT, 7):
            u = np.zeros(4)
            for chain, own in zip((CHAINS[3], CHAINS[1]), masses, strict=True):
                n = len(chain.mass)
                matrix = np.zeros((2 * n + 2, 2 * n + 2))
                matrix[: 2 * n, : 2 * n] = motion_matrix(chain)[0]
                matrix[n : 2 * n, 2 * n], matrix[2 * n, 2 * n + 1] = -1.0, 1.0
                start = np.concatenate([states[node, 0, own], states[node, 1, own], [pull, rise]])
                later = expm(matrix * x) @ start
                u[own] = later[:n]
                felt = (matrix @ later)[n : 2 * n] + pull + rise * x
                found = np.abs([later[:n], np.diff(later[:n], prepend=0.0), felt])
                reached[block, :, own] = np.maximum(reached[block, :, own], found)
            closing = u[0] - u[3]
            across[block, :, 0] = np.maximum(across[block, :, 0], [closing, -closing])
    assert (reached <= motion.floor_bounds * (1.0 + 1e-9)).all()
    assert (reached.max(axis=0) >= 0.99 * motion.floor_peaks[-1]).all()
    np.testing.assert_array_equal(motion.floor_peaks[-1].T, free.run.floors[:, [0, 1, 3]])
    assert (across[:, 0] <= motion.point_bounds[:, 0] + 1e-12).all()
    assert (-across[:, 1] >= motion.point_bounds[:, 1] - 1e-12).all()
    # Not much wider than the motion in its strongest blocks, or nothing would ever be passed over.
    strongest = motion.floor_bounds[:, 0].argmax(axis=0)
    assert (motion.floor_bounds[strongest, 0, range(4)] <= 1.1 * reached[strongest, 0, range(4)]).all()


def test_every_counter_is_gathered_once():
    """One that is in no group would be zero in every row, without an error."""
    gathered = Counter(column for group, _ in GATHERED for column in group)
    assert set(gathered) == {*range(TALLIED), HIGH, LOW} - {STATUS}
    assert set(gathered.values()) == {1} and max(gathered) < COLUMNS


def test_every_output_has_its_place_and_its_unit_in_a_dataset():
    """One without a place would end in a KeyError; one of another unit would be read as a thousandth, or as a g."""
    own = [value for value in vars(outputs).values() if isinstance(value, dict) and value]
    of_rows = {name: each for table in own for name, each in table.items() if isinstance(each, Variable)}
    of_rows |= {name: Variable(output.unit, "", ("interface",)) for name, output in RUN.items()}
    of_rows |= {f"{POINT}{name}": Variable(RUN[name].unit, "", ("contact_point",)) for name in outputs.OF_POINTS}
    of_rows |= {name: Variable(unit, "", ("building",)) for name, (unit, _, _) in BUILDING.items()}
    for name, output in of_rows.items():
        assert VARIABLES[name].dims == (*AXES, *output.dims) and VARIABLES[name].unit == output.unit, name
    for name in (*outputs.OF_BUILDINGS, *outputs.OF_STOREYS, *outputs.OF_YIELDING, *outputs.OF_LAWS, *OF_LINKS):
        assert VARIABLES[f"{name}_free"] == VARIABLES[name]._replace(dims=(*MOTION, *of_rows[name].dims)), name


def test_every_output_of_links_is_that_of_its_links():
    """A spring that has broken and a damper of a power law between the same two buildings, none between the others."""
    links = [Link(1, 1.0, 1.0, 2e7, 0.0, breaking=1e5), Link(1, 1.0, 1.0, 0.0, 3e5, exponent=1.0)]
    points = np.zeros((2, POINT_COLUMNS))
    points[:, LOWEST], points[:, HIGHEST] = (-0.004, -0.006), (0.001, 0.002)
    points[:, APPROACH], points[:, PLASTIC] = (0.0, 0.2), (250.0, 40.0)
    model = SimpleNamespace(links=links, chains=[0, 1, 2], is_link=np.array([True, True]), interfaces=np.array([1, 1]))
    frame: Any = SimpleNamespace(model=model, of_links=lambda: list(OF_LINKS))
    found = outputs._of_links(SimpleNamespace(points=points, status=0), frame)  # type: ignore[arg-type]
    expected = {
        "peak_link_stretch": 0.006,
        "peak_link_shortening": 0.002,
        "peak_link_spring_force": 8e4,  # k e of the spring's own stretch
        "link_energy": 290.0,
        "peak_link_damper_force": 6e4,  # c v
        "broken_links": 1.0,
    }
    assert list(found) == list(OF_LINKS) == list(expected)
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], [np.nan, value], rtol=1e-15, err_msg=name)
    failed = outputs._of_links(SimpleNamespace(points=points, status=3), frame)  # type: ignore[arg-type]
    assert np.isnan(list(failed.values())).all()


def test_closed_interfaces_tie_buildings():
    assert tied([False, False]) == []
    assert tied([True, True, False, False, True]) == [Span(0, 2), Span(4, 5)]


def test_parts_side_by_side_are_one():
    """With one open interface between them each would watch a neighbour that does not move freely."""
    assert tied([True, False, True]) == [Span(0, 3)]
    assert tied([True, False, False, True]) == [Span(0, 1), Span(3, 4)]


@given(st.lists(st.booleans(), max_size=12))
def test_every_closed_interface_lies_in_one_part(closed):
    """And parts hold nothing that they need not: their outermost interfaces are closed, and none is beside another."""
    parts = tied(closed)
    for place, shut in enumerate(closed):
        inside = [part for part in parts if part.first <= place < part.last]
        assert len(inside) <= 1
        assert inside or not shut
    for part in parts:
        assert closed[part.first] and closed[part.last - 1]
    assert all(after.first - before.last >= 2 for before, after in pairwise(parts))


@given(st.lists(st.booleans(), min_size=1, max_size=10), st.sets(st.integers(0, 9)))
def test_growth_is_the_smallest_that_holds(closed, pressed):
    """Against a plain fixed point: a part that reaches an interface that pounding presses shut takes it in."""
    pressed = {place for place in pressed if place < len(closed)}
    solved = []

    def solve(span):
        solved.append(span)
        if span.first - 1 in pressed:
            return span, LEFTWARDS
        return span, RIGHTWARDS if span.last in pressed else HELD

    expected = list(closed)
    while True:
        parts = tied(expected)
        beside = {place for part in parts for place in (part.first - 1, part.last)} & pressed
        if not beside:
            break
        for place in beside:
            expected[place] = True
    found = solved_spans(tied(closed), solve)
    assert list(found) == parts and all(found[span] == span for span in found)
    assert len(solved) == len(set(solved)), "a part was solved twice"


def test_a_part_that_grows_joins_the_next():
    """Three parts; the first grows into the building between it and the second, which it then stands beside."""
    asked = []

    def solve(span):
        asked.append(span)
        return len(asked), RIGHTWARDS if span == Span(0, 1) else HELD

    assert solved_spans([Span(0, 1), Span(3, 4), Span(7, 8)], solve) == {Span(0, 4): 2, Span(7, 8): 3}
    assert asked == [Span(0, 1), Span(0, 4), Span(7, 8)]


def test_overlapping_spans_are_gathered():
    assert gathered([Span(4, 6), Span(0, 1), Span(1, 2)]) == [Span(0, 2), Span(4, 6)]
