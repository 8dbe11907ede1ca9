"""A row of buildings under a ground motion: run with and without contact.

Between contacts the motion is exact for a_g linear between samples; in contact it is integrated to a tolerance and
lands on every event. Each building may have a ground motion of its own, at a time of its own (`ground`): a_g is then
(buildings, n). Of a motion along and across the row it is complex.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, inf
from typing import Any, NamedTuple

import numpy as np

from pounding_risk._jit.calls import numbers_of
from pounding_risk._jit.compile import lowered
from pounding_risk._jit.memory import by_address, column, set_column
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.hysteresis import _numbers as laws
from pounding_risk.solver.counters import APPROACH as SPEED
from pounding_risk.solver.counters import COLLAPSED, TALLIED
from pounding_risk.solver.counters import PLASTIC as PLASTIC_ENERGY
from pounding_risk.solver.pair.laws import verbs_of
from pounding_risk.solver.row.free_motion import march_free
from pounding_risk.solver.row.ground import ArrivingRowGround, PlaneRowGround, UniformRowGround, row_ground
from pounding_risk.solver.row.layout import RowLayout, nodes_of
from pounding_risk.solver.row.run import WATCHED, march
from pounding_risk.solver.row.workspace import (
    ACCELERATION,
    BOTTOM,
    BRANCH,
    DISPLACEMENT,
    DRIFT,
    FIRST,
    LIMIT,
    LINE_STATES,
    PLASTIC,
    SHEAR,
    SOFT,
    START,
    STOREY_FORCE,
    VERBS,
    FreeMotion,
    FreeWork,
    Row,
    Run,
    log_of,
    new_run,
)
from pounding_risk.solver.row.workspace import NODE as AT_END

POINT_COLUMNS = TALLIED + 2
GREW_STATUS = WATCHED
HIGHEST, LOWEST = TALLIED, TALLIED + 1  # u_left − u_right at a point
COLLAPSE_TIME = 4  # column of `RowRun.rest`
LINES = 4096  # of a log to begin with; a run that needs more is repeated with the room it asked for


class Contacts(NamedTuple):
    """Gaps, yield forces, laws and restitutions at the K contact points of a row."""

    gaps: np.ndarray  # m
    yield_forces: np.ndarray  # N, inf never yields
    laws: Sequence[Any]  # of any class each
    restitutions: Sequence[Restitution]
    watched: np.ndarray | None = None  # where a touch ends the run; None is nowhere


class RowRun(NamedTuple):
    """Result of a run of a row; K contact points, D dofs of all buildings in turn."""

    points: np.ndarray  # (K, POINT_COLUMNS) the counters, then highest and lowest u_left − u_right
    floors: np.ndarray  # (D, 4) largest |u|, |drift|, |storey shear|, |absolute acceleration|
    # (D, 2) drift at the end, plastic drift then; of a row with laws of storeys (D, 5): with the energy that a storey
    # has dissipated [J], the share of its strength that is left, and when it collapsed [s], NaN where it has not
    rest: np.ndarray
    status: int
    steps: int
    energy: float  # largest at a touch or parting [J]
    residual: float  # what the contacts leave unaccounted for [J]
    grew: int  # a watched point that was touched, −1 where none was
    fastest: np.ndarray  # (K,) peak closing or parting speed at nodes, of a run without contact [m/s]
    first: np.ndarray  # (K, L) when a force first reaches a level
    reached: np.ndarray  # (K, L) contacts in which it does
    states: np.ndarray  # (N, 2, D) u and v at the nodes, where asked for; NaN after a failure
    log: np.ndarray  # (lines, ...) as `trace` writes it, where asked for


class FreeResponse(NamedTuple):
    """What a row does without any contact: its peaks, and the motion from which its runs begin."""

    run: RowRun
    motion: FreeMotion


def free_row(layout: RowLayout, acceleration: np.ndarray, *, states: bool = False) -> RowRun:
    """The row without any contact under a_g [m/s²]; ``states`` keeps u and v at every node."""
    return _respond(layout, acceleration, states=states).run


def free_response(layout: RowLayout, acceleration: np.ndarray) -> FreeResponse:
    """The row without any contact under a_g [m/s²], with all that runs of it have in common.

    After a collapse, which a neighbour may prevent, runs need the motion of the buildings that never yield: that of the
    row whose storeys stay elastic.
    """
    response = _respond(layout, acceleration, states=False)
    if response.run.status != COLLAPSED:
        return response
    row, floors = layout.row, layout.row.floors.copy()
    floors[LIMIT], floors[SOFT] = inf, 0.0
    elastic = layout._replace(row=row._replace(floors=floors, storeys=np.zeros_like(row.storeys)))
    return response._replace(motion=_respond(elastic, acceleration, states=False).motion)


def _respond(layout: RowLayout, acceleration: np.ndarray, *, states: bool) -> FreeResponse:
    row, run, motion, work, at_nodes = unmoved(layout, acceleration)
    if states:
        at_nodes = _empty_states(motion.ground.node_count(), row)
    march_free(by_address(row), by_address(run), by_address(motion), by_address(work), at_nodes)
    motion.fastest[:] = column(run.contacts, "fastest")
    return FreeResponse(_results_of(layout, run, at_nodes), motion)


def unmoved(layout: RowLayout, acceleration: np.ndarray) -> tuple[Any, ...]:
    """Arguments of `march_free` for `free_response`: the arrays of the row, of its run and of its motion, at rest."""
    row, points, dofs = layout.row, layout.row.ends.shape[0], layout.row.floors.shape[1]
    run = new_run(row, np.zeros((points, 0)), np.zeros(0))
    set_column(run.contacts, "given_gap", np.full(points, inf))
    ground = _ground(layout, acceleration)
    blocks = ceil((ground.node_count() - 1) / layout.block)
    motion = FreeMotion(
        ground,
        layout.step,
        layout.terms,
        np.zeros((blocks + 1, 2, dofs)),
        np.zeros((blocks, 3, dofs)),
        np.zeros((blocks + 1, 3, dofs)),
        np.zeros((blocks, 2, points)),
        np.zeros((blocks + 1, 2, points)),
        np.zeros(points),
        layout.block_maps,
        layout.block,
    )
    motion.states[0][:, layout.masses] = layout.initial
    if layout.arrivals is not None:
        motion.states[0][1, row.frame[FIRST, 2:] - 1] = np.diff(layout.arrivals.velocities)
    buildings, nodes = row.frame.shape[1] - 1, layout.block + 1
    most_points = max([0, *np.diff(row.frame[START]).tolist()])  # points of an interface
    work = FreeWork(
        np.zeros((3, dofs, nodes)),
        np.zeros((2, buildings, nodes - 1)),
        np.zeros((3 if row.passage.components() == 1 else 5, nodes)),
        np.zeros((3, most_points, nodes)),
        np.zeros((most_points, nodes - 1)),
    )
    return row, run, motion, work, np.zeros((0, 2, dofs))


def motion_of_part(layout: RowLayout, motion: FreeMotion, acceleration: np.ndarray, dof: int, point: int) -> FreeMotion:
    """The free motion of a whole row for a part of it, ``dof`` and ``point`` the whole's first ones in the part."""
    ground = motion.ground if layout.arrivals is None else _ground(layout, acceleration)
    return motion._replace(ground=ground, first_dof=dof, first_point=point)


def _ground(layout: RowLayout, acceleration: np.ndarray) -> UniformRowGround | PlaneRowGround | ArrivingRowGround:
    """a_g [m/s²] at the samples as the ground motion that the kernels take, node by node."""
    samples = np.asarray(acceleration, dtype=np.result_type(acceleration, np.float64))
    return row_ground(nodes_of(layout, samples), layout.step, layout.arrivals)


def run_row(
    layout: RowLayout,
    contacts: Contacts,
    acceleration: np.ndarray,
    *,
    rtol: float = 1e-6,
    levels: np.ndarray | None = None,
    histories: bool = False,
    free: FreeMotion | None = None,
) -> RowRun:
    """The row with its contacts under a_g [m/s²] at the samples of its layout, from its initial state.

    ``levels`` [N, ascending] are forces whose first reaching is timed at every point, and whose contacts are counted: a
    law without a cap answers so for every yield force. ``histories`` keeps u and v at every node, and the log. ``free``
    is the motion without contact; it is found anew where it is not given.
    """
    motion = free_response(layout, acceleration).motion if free is None else free
    times = np.zeros(0) if levels is None else np.asarray(levels, dtype=np.float64)
    return _run(layout, contacts, motion, rtol, times, histories=histories)


def _run(
    layout: RowLayout, contacts: Contacts, motion: FreeMotion, rtol: float, levels: np.ndarray, *, histories: bool
) -> RowRun:
    row, points = layout.row, layout.row.ends.shape[0]
    laws = [lowered(law) for law in contacts.laws]
    numbers = [numbers_of(law) for law in laws]
    verbs = [verbs_of(law) for law in laws]
    law_rows = np.zeros((points, max([0, *(room for room, _ in verbs)])))
    for k, row_numbers in enumerate(numbers):
        law_rows[k, : len(row_numbers)] = row_numbers
    fields = {
        "given_gap": contacts.gaps,
        "yield_force": contacts.yield_forces,
        "watched": np.zeros(points) if contacts.watched is None else contacts.watched,
        "fastest": motion.fastest[motion.first_point : motion.first_point + points],
        "rule": np.array([numbers_of(rule) for rule in contacts.restitutions]).reshape(
            points, len(Restitution._fields)
        ),
        **dict(zip(VERBS, np.array([addresses for _, addresses in verbs]).reshape(points, len(VERBS)).T, strict=True)),
    }
    lines = LINES if histories else 0
    while True:
        run = new_run(row, law_rows.copy(), levels, rtol, lines)
        for name, values in fields.items():
            set_column(run.contacts, name, values)
        states = _empty_states(motion.ground.node_count() if histories else 0, row)
        states[:1] = motion.states[0, :, motion.first_dof : motion.first_dof + row.floors.shape[1]]
        march(by_address(row), by_address(run), by_address(motion), float(rtol), states)
        written = int(run.workspace.lines_written)
        if written <= lines or not histories:
            return _results_of(layout, run, states)
        lines = written


def _empty_states(nodes: int, row: Row) -> np.ndarray:
    """Array for u and v at so many nodes, NaN as yet."""
    return np.full((nodes, 2, row.floors.shape[1]), np.nan)


def _results_of(layout: RowLayout, run: Run, states: np.ndarray) -> RowRun:
    """The result of a run, from the arrays that the kernel has filled; nothing of the dofs that are the ground's."""
    row, masses = layout.row, layout.masses
    floors = np.ascontiguousarray(run.dofs[DISPLACEMENT : ACCELERATION + 1].T)
    # A storey that has never passed its limit has the shear of its drift: flights search for the drift's peak alone.
    elastic = floors[:, DRIFT - DISPLACEMENT] <= row.floors[LIMIT]
    floors[elastic, STOREY_FORCE - DISPLACEMENT] = row.floors[SHEAR, elastic] * floors[elastic, DRIFT - DISPLACEMENT]
    # Floors joined by a matrix have no storey spring.
    floors[row.floors[SHEAR] == 0.0, STOREY_FORCE - DISPLACEMENT] = np.nan
    at_end = run.dofs[AT_END]
    drift = at_end - np.where(row.floors[BOTTOM] > 0.0, 0.0, np.concatenate([[0.0], at_end[:-1]])[: at_end.size])
    # A storey that yields drags its elastic range along, which is written down when it turns.
    plastic, yields = run.dofs[PLASTIC].copy(), run.dofs[BRANCH] != 0.0
    plastic[yields] = drift[yields] - run.dofs[BRANCH, yields] * row.floors[LIMIT, yields]
    rest = np.column_stack([drift, plastic])
    if row.storeys.size:
        rest = _with_laws(rest, row.storeys[:, laws.STIFFNESS] > 0.0, run.storeys, float(run.workspace.collapse_time))
    workspace, contacts = run.workspace, run.contacts
    kept = np.concatenate([masses, layout.braces])  # dofs whose states are, at the steps of the layout
    points = [column(contacts, name) for name in ("counters", "highest", "lowest")]
    if row.links.size:
        counters, links = points[0].reshape(len(contacts), TALLIED), run.links
        slips = np.flatnonzero((links[:, laws.STIFFNESS] > 0.0) & (links[:, laws.ALONG_RATE] == 0.0))
        dampers = np.flatnonzero(links[:, laws.ALONG_RATE] > 0.0)
        counters[dampers, SPEED] = links[dampers, laws.FASTEST]
        counters[dampers, PLASTIC_ENERGY] = links[dampers, laws.TAKEN]
        places = np.array([_place_of_point(row, at_end, int(point)) for point in slips])
        counters[slips, PLASTIC_ENERGY] = _dissipated(links[slips], places)
    return RowRun(
        np.column_stack([points[0].reshape(len(contacts), TALLIED), *points[1:]]),
        floors[masses],
        rest[masses],
        int(workspace.status),
        int(workspace.steps),
        float(workspace.energy),
        float(workspace.residual),
        int(workspace.watched_point),
        column(contacts, "fastest"),
        run.timed[1],
        run.timed[2],
        states[:: layout.phases, :, kept],
        _log_of_masses(run, kept),
    )


def _place_of_point(row: Row, values: np.ndarray, point: int) -> float:
    """u_left − u_right of a point, from displacements of the dofs."""
    mine = row.ends[point] >= 0
    return float(row.shares[point, mine] @ values[row.ends[point, mine]])


def _has_yielded(numbers: np.ndarray) -> np.ndarray:
    """False for laws still on the elastic line, which leaves no drift and takes no energy, but for rounding."""
    values = numbers.T
    is_elastic = np.isclose(values[laws.SLOPE], values[laws.UNLOADING], rtol=1e-12, atol=0.0)
    return np.asarray(~(is_elastic & (values[laws.CONSTANT] == 0.0) & (values[laws.WORK] == 0.0)))


def _dissipated(numbers: np.ndarray, drift: np.ndarray) -> np.ndarray:
    """Energy that laws have dissipated until they stand at these drifts [J]: their work, less what unloading gives."""
    values = numbers.T
    shear = values[laws.SLOPE] * drift + values[laws.CONSTANT]
    work = values[laws.WORK] + 0.5 * (values[laws.SHEAR] + shear) * (drift - values[laws.DRIFT])
    return np.where(_has_yielded(numbers), work - 0.5 * shear**2 / values[laws.UNLOADING], 0.0)


def _with_laws(rest: np.ndarray, has_law: np.ndarray, numbers: np.ndarray, collapse_time: float) -> np.ndarray:
    """``rest`` with the drift without shear of storeys with laws, and columns of `RowRun.rest` that only these have."""
    drift, values = rest[has_law, 0], numbers[has_law].T
    shear = values[laws.SLOPE] * drift + values[laws.CONSTANT]
    whole = np.full((len(rest), COLLAPSE_TIME + 1), np.nan)
    whole[:, :2] = rest
    whole[has_law, 1] = np.where(_has_yielded(numbers[has_law]), drift - shear / values[laws.UNLOADING], 0.0)
    whole[has_law, 2], whole[has_law, 3] = _dissipated(numbers[has_law], drift), values[laws.STRENGTH]
    whole[has_law, COLLAPSE_TIME] = np.where(np.abs(values[laws.DRIFT]) >= values[laws.COLLAPSE], collapse_time, np.nan)
    return whole


def _log_of_masses(run: Run, masses: np.ndarray) -> np.ndarray:
    """The log with the columns of these dofs, without those of others."""
    log, dofs = log_of(run), run.dofs.shape[1]
    columns = [
        np.arange(LINE_STATES),
        LINE_STATES + masses,
        LINE_STATES + dofs + masses,
        np.arange(LINE_STATES + 2 * dofs, log.shape[1]),
    ]
    return log[:, np.concatenate(columns)]
