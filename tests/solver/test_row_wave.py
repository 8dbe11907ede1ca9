"""A wave that passes a row: the pair's solver, an independent run, limits, mirror, parts, scenes."""

from functools import cache
from typing import Any

import numpy as np
import pytest
import row_cases
from oracle_grounds import Body, Touch, peaks_of
from row_cases import CASES, RIGID, by_solver, contacts_of, meeting, named, points_of, single, storeys
from scenes import rigid, scene_text, storeyed
from scenes import single as single_keys
from sentences import refusal
from sweeps import sweep
from test_row_cases import same

import pounding_risk as pr
from pounding_risk.lab.stability.trial import shaking
from pounding_risk.models.contact.laws import Linear, ViscousElastoplastic
from pounding_risk.models.effects.wave_passage import WavePassage
from pounding_risk.models.ground import arrivals_of, arriving, delayed
from pounding_risk.models.restitution import constant
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.counters import COMPLETE, COUNT, PEAK_FORCE
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row import trace_reader
from pounding_risk.solver.row.api import HIGHEST
from pounding_risk.solver.row.ground import PULL, SPREAD
from pounding_risk.solver.row.layout import lay_out, nodes_of
from pounding_risk.solver.row.model import RowModel

LAW, HALF = ViscousElastoplastic(2.75e9), constant(0.5)
STEP, LAG = 0.01, 0.043  # no multiple of the step
GROUND = shaking(4.0)[:400]
BETA = 1e9
ELASTIC: Any = {"stiffness": BETA, "restitution": 1.0}  # without a cap: β δ^1.5


def arrivals(*lags: float) -> np.ndarray:
    """Arrivals at the buildings of a row, from the lags of its interfaces [s]."""
    return WavePassage(0.0, lags).arrivals(len(lags) + 1)


def run_of(chains, meetings, lags, ground=GROUND, rtol: float = 1e-9, **more: Any):
    row = lay_out(chains, points_of(meetings), STEP, arrivals(*lags))
    return rows.run_row(row, contacts_of(meetings), ground, rtol=rtol, **more)


# -------------------------------------------------------------------------------------------------- the motion
@pytest.mark.parametrize("lag", [0.004, LAG, -LAG, 0.0137])
@pytest.mark.complete
def test_the_motions_are_those_of_the_pair(lag: float):
    """Both grounds and w at all nodes, to the bit, from the function that the pair's solver uses."""
    pair, table = delayed(GROUND, STEP, lag), arriving(GROUND, STEP, arrivals_of(arrivals(lag), STEP))
    for b, (pull, rise) in enumerate(((pair.left, pair.left_slope), (pair.right, pair.right_slope))):
        np.testing.assert_array_equal(table[:-1, b, 0], pull[:-1])
        np.testing.assert_array_equal(table[:-1, b, 1], rise[:-1])
    np.testing.assert_array_equal(table[:, 1, 4], pair.spread)
    np.testing.assert_array_equal(table[:, 1, 5], pair.rate)


def test_nodes_stand_at_the_samples_of_every_building():
    """Each a_g is the straight line between its own samples, wherever the others' stand."""
    late = np.array([0.0, 0.043, 0.05, 0.0763, 0.0463])
    given = arrivals_of(late, STEP)
    np.testing.assert_allclose(given.offsets, [0.0, 0.003, 0.0063], rtol=1e-9)
    table = arriving(GROUND, STEP, given)
    times = (np.arange(399)[:, None] * STEP + given.offsets).ravel()
    for b, after in enumerate(late):
        known = np.interp(times - after, np.arange(400) * STEP, GROUND, left=0.0)
        np.testing.assert_allclose(table[:-1, b, 0], known, atol=1e-12 * np.abs(GROUND).max())
    # w is the double integral: its second difference over equal widths is that of the accelerations.
    w = table[:: given.offsets.size, 1:, 4]
    fine = np.arange(0.0, 399 * STEP, STEP / 100)
    for b in range(1, late.size):
        bend = np.interp(fine - late[b], np.arange(400) * STEP, GROUND, left=0.0)
        bend -= np.interp(fine - late[b - 1], np.arange(400) * STEP, GROUND, left=0.0)
        rate = np.append(0.0, np.cumsum(0.5 * (bend[1:] + bend[:-1]) * STEP / 100))
        moved = np.append(0.0, np.cumsum(0.5 * (rate[1:] + rate[:-1]) * STEP / 100))
        assert np.abs(w[:-1, b - 1] - moved[::100]).max() < 1e-4 * np.abs(moved).max()


def test_when_a_wave_arrives(says):
    assert WavePassage.on(500.0, 20.0).arrivals(4) == pytest.approx([0.0, 0.04, 0.08, 0.12])
    assert WavePassage.on(500.0, 20.0, "left").arrivals(3) == pytest.approx([0.08, 0.04, 0.0])
    wave = WavePassage.on(500.0, [20.0, 0.0, 30.0])
    assert wave.lag == pytest.approx(0.06) and wave.arrivals(4) == pytest.approx([0.0, 0.04, 0.04, 0.1])
    says(refusal(wave.arrivals, 3))


# -------------------------------------------------------------------------------------------------- other models
ROWS: dict[str, Any] = {
    "storeys, single, storeys": (
        (storeys(3, 70e3, 4e7), single(150e3, 0.25), storeys(2, 300e3, 1.5e8, damping_rule="rayleigh")),
        (meeting(0, 2.5, 1.0, 0.003, **ELASTIC), meeting(1, 1.0, 2.0, 0.004, **ELASTIC)),
        (0.043, 0.0237),
    ),
    "to the left, past a rigid one": (
        (single(200e3, 0.45), RIGID, storeys(2, 80e3, 5e7), single(90e3, 0.3)),
        (
            meeting(0, 1.0, 1.0, 0.01, **ELASTIC),
            meeting(1, 1.0, 2.0, 0.004, **ELASTIC),
            meeting(2, 1.4, 1.0, 0.002, **ELASTIC),
            meeting(2, 2.0, 1.0, 0.003, **ELASTIC),
        ),
        (-0.02, -0.0333, 0.0),
    ),
}


@pytest.mark.parametrize("name", sweep(ROWS, "to the left, past a rigid one"))
@pytest.mark.complete
def test_an_independent_run(name: str):
    """SciPy in absolute displacements, which knows neither w nor own grounds as something relative."""
    chains, meetings, lags = ROWS[name]
    ground = GROUND[:260]
    late = arrivals(*lags)
    bodies = [Body(c.mass, c.spring, c.damping, ground, delay) for c, delay in zip(chains, late, strict=True)]

    def floor_of(building: int, floor: float) -> float:
        return floor if len(chains[building].mass) else 0.0  # a rigid building is its ground

    touches = [
        Touch(at, floor_of(at, left), floor_of(at + 1, right), gap, BETA, 1.5) for at, left, right, gap, *_ in meetings
    ]
    known = peaks_of(bodies, touches, STEP)
    run = run_of(chains, meetings, lags, ground, rtol=1e-10)
    found = named(run)
    assert run.status == COMPLETE and found["impact_count"].sum() >= 4 and (found["impact_count"] > 0).sum() >= 2
    np.testing.assert_allclose(found["impulse"], known["impulse"], rtol=1e-6, atol=1e-3)
    # A local maximum is a parabola: looked for 40 times an interval, its top is missed by some 1e-5 of the force at
    # most.
    for output in ("peak_closing", "peak_contact_force"):
        np.testing.assert_allclose(found[output], known[output], rtol=2e-5, err_msg=output)
    for column, output in ((0, "displacement"), (1, "drift"), (3, "acceleration")):
        np.testing.assert_allclose(run.floors[:, column], known[output], rtol=2e-5, err_msg=output)
    # What the moving grounds put in is in the ledger.
    assert abs(run.residual) < 1e-8 * run.energy


# -------------------------------------------------------------------------------------------------- limits
@pytest.mark.parametrize("name", CASES)
@pytest.mark.complete
def test_a_wave_in_no_time_is_no_wave(name: str):
    """0.1 ns between neighbours: the ground moves them by some 1e-11 m, and the kernels are those of a wave."""
    case = CASES[name]
    plain, (acceleration, dt) = by_solver(case), case.shaking.samples()
    row = lay_out(case.chains, points_of(case.meetings), dt, 1e-10 * np.arange(len(case.chains)))
    assert row.phases == len(case.chains)
    run = rows.run_row(row, contacts_of(case.meetings), acceleration, rtol=1e-9)
    found, known = named(run), named(plain)
    assert run.status == COMPLETE and run.floors.shape == plain.floors.shape and run.rest.shape == plain.rest.shape
    np.testing.assert_array_equal(found["impact_count"], known["impact_count"])
    np.testing.assert_allclose(run.floors, plain.floors, rtol=1e-5)
    for output in ("peak_closing", "peak_contact_force", "impulse"):
        np.testing.assert_allclose(found[output], known[output], rtol=2e-5, err_msg=output)


@pytest.mark.parametrize("wave", [WavePassage(0.0), WavePassage.on(400.0, [0.0, 0.0])])
@pytest.mark.complete
def test_no_distance_is_no_wave_to_the_bit(wave: WavePassage):
    chains, meetings, _ = ROWS["storeys, single, storeys"]
    models = RowModel(chains, points_of(meetings)), RowModel(chains, points_of(meetings), wave.supports(3))
    one, other = (rows.run_row(model.row(STEP), contacts_of(meetings), GROUND) for model in models)
    assert one.points[:, COUNT].sum() >= 3
    np.testing.assert_array_equal(one.points, other.points)
    np.testing.assert_array_equal(one.floors, other.floors)


@pytest.mark.complete
def test_histories_are_those_of_the_masses():
    """A recorded run is the same run; its states, log and grounds know the masses, and u − w closes the gap."""
    chains, meetings, lags = ROWS["to the left, past a rigid one"]
    plain, run = run_of(chains, meetings, lags), run_of(chains, meetings, lags, histories=True)
    np.testing.assert_array_equal(run.points, plain.points)
    assert run.states.shape == (400, 2, 4) and run.log.shape[1] == 2 + 2 * 4 + 5 * len(meetings)
    instants = trace_reader.instants_of(run.log, 400, STEP)
    contacts = trace_reader.contacts_of(run.log, len(meetings), instants)
    moved = trace_reader.motion_at(run.log, run.states, instants)[:, 0]
    # A local maximum between two samples is missed by (ω h)² / 8 of it.
    shares = np.abs(moved).max(axis=0) / run.floors[:, 0]
    assert shares.min() > 0.99 and shares.max() <= 1.0 + 1e-12
    for point, peak in enumerate(run.points[:, PEAK_FORCE]):
        assert max(each.facts[3] for each in contacts if each.point == point) == peak > 0.0
    row = lay_out(chains, points_of(meetings), STEP, arrivals(*lags))
    grounds = arriving(nodes_of(row, GROUND), row.step, row.arrivals)[:: row.phases]
    late = np.interp(np.arange(400) * STEP - 0.0333, np.arange(400) * STEP, GROUND, left=0.0)
    np.testing.assert_allclose(grounds[:-1, 1, PULL], late[:-1], atol=1e-12)
    closing = run.states[:, 0, 0] - grounds[:, 1, SPREAD]  # of the first mass and the rigid building
    assert closing.max() == pytest.approx(run.points[0, HIGHEST], rel=1e-2) and closing.max() <= run.points[0, HIGHEST]


@pytest.mark.parametrize("law", [LAW, Linear(2e8)])
@pytest.mark.complete
def test_parts_are_the_whole_row_to_the_bit(law):
    """Five buildings, of which some touch: their arrivals are part of what equal parts have to share."""
    chains = (single(90e3, 0.2), storeys(2, 100e3, 1e8), single(60e3, 0.5), storeys(2, 100e3, 1e8), single(60e3, 0.5))
    floors = [(1.0, 2.0), (2.0, 1.0), (1.0, 2.0), (2.0, 1.0)]
    meetings = [meeting(interface, *both, 0.0) for interface, both in enumerate(floors)]
    model = RowModel(chains, points_of(meetings), WavePassage(0.0237).supports(len(chains)))
    cases = row_cases.cases_of(model, law, (GROUND, STEP), HALF)
    for tight in (0.004, 0.02, 0.3):
        limits = row_cases.limits_of(model, [tight, 0.004, tight, 0.004], 2e6)
        whole, (found, answers) = cases.whole(limits), cases.in_parts(limits)
        assert whole.points[:, COUNT].max() > 0 and len({answer.key for answer in answers}) == len(answers)
        same(found, whole)


# -------------------------------------------------------------------------------------------------- scenes
@cache
def scene(distance: str, towards: str = "right"):
    """A row of three, small enough to be scanned in a test."""
    text = scene_text(
        storeyed("a", "70 t", "40 MN/m", storeys=3),
        single_keys("b", "150 t", "0.25 s", height="9 m"),
        rigid("c", height="9 m"),
        effects={"wave_passage": {"velocity": "400 m/s", "distance": "DISTANCE", "towards": towards}},
        grid={"gap": ["4 mm", "15 mm", "1 m"]},
        records={"window": ["1 s", "4 s"]},
        gap=None,
    )
    return parse_scene(text.replace('"DISTANCE"', distance))


@pytest.mark.complete
def test_a_scene_of_a_row_with_a_wave():
    """One distance, or one for each interface: read, written back and scanned."""
    one, several = scene('"30 m"'), scene('["30 m", "30 m"]')
    assert parse_scene(several.to_toml()) == several and one.is_row
    assert dict(several.effects[0].options)["distance"] == (30.0, 30.0)
    found, same = (pr.scan(study, check_fraction=0.0) for study in (one, several))
    for name in ("peak_contact_force", "impulse", "peak_relative_displacement", "peak_displacement"):
        np.testing.assert_array_equal(found[name], same[name])
    assert float(found.impulse.max()) > 0.0 and "Der Kiureghian" in found.attrs["references"]
    other = pr.scan(scene('["30 m", "10 m"]'), check_fraction=0.0)
    assert not np.array_equal(found.impulse, other.impulse)
    one_run = pr.simulate(one)
    assert np.isfinite(one_run.displacement.isel(building=0)).all() and "Der Kiureghian" in one_run.attrs["references"]


@pytest.mark.parametrize("distance", ['["30 m"]', '["30 m", 12]', '["30 m", "-1 m"]', "[]"])
def test_what_a_scene_refuses(distance: str, says):
    says(refusal(scene, distance))


def test_a_wave_that_never_arrives_is_refused(says):
    """The last building of a row has all lags before it."""
    says(refusal(pr.scan, scene('["700 m", "700 m"]')))
