"""A row of buildings under a ground motion: laid out once, run with and without contact.

The buildings are chains of masses (`mdof.Chain`), the contact points places on them. Between contacts
the motion is exact for a_g linear between samples; in contact it is integrated to a tolerance and lands on every event.
Each building may have a ground motion of its own, at a time of its own (`ground`): a_g is then (buildings, n).
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk._jit.calls import numbers_of
from pounding_risk._jit.compile import lowered
from pounding_risk._jit.lent import lent
from pounding_risk._jit.records import column, set_column
from pounding_risk.models.ground import Arrivals, arrivals_of, arriving, divided
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import TALLIED
from pounding_risk.solver.pair.laws import verbs_of
from pounding_risk.solver.row.free_motion import march_free
from pounding_risk.solver.row.ground import (
    PULL,
    SPREAD,
    ArrivingRow,
    ArrivingRowGround,
    UniformRow,
    UniformRowGround,
    row_ground,
)
from pounding_risk.solver.row.run import WATCHED, march
from pounding_risk.solver.row.workspace import (
    ACCELERATION,
    BAND,
    BENDS,
    BLOCK_MAP,
    BOTTOM,
    BRANCH,
    DISPLACEMENT,
    DRIFT,
    FIRST,
    GIVE,
    INVERSE,
    LIMIT,
    MAP,
    MASS,
    MOVED,
    PLASTIC,
    QUICK,
    ROOT,
    SHEAR,
    SOFT,
    SPRING,
    START,
    STATIC,
    STOREY_FORCE,
    SWAY,
    VERBS,
    FreeMotion,
    FreeWork,
    Row,
    Run,
    log_of,
    new_run,
)
from pounding_risk.solver.row.workspace import NODE as AT_END
from pounding_risk.solver.workspace import MAX_TERMS

if TYPE_CHECKING:
    from pounding_risk.models.structures.mdof import Chain

POINT_COLUMNS = TALLIED + 2
GREW_STATUS = WATCHED
HIGHEST, LOWEST = TALLIED, TALLIED + 1  # u_left − u_right at a point
BLOCK = 16  # nodes passed over at a time, or as many more as make whole steps
LINES = 4096  # of a log to begin with; a run that needs more is made again with the room it asked for


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
    rest: np.ndarray  # (D, 2) drift at the end, plastic drift then
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


class Laid(NamedTuple):
    """Arrays of a row for the kernels, for a motion sampled every ``dt`` [s]."""

    row: Row
    dt: float
    parts: int  # node intervals a sample
    terms: int  # of the Taylor series over one of them
    block_maps: np.ndarray  # as in `FreeMotion`
    initial: np.ndarray  # (2, masses) u [m] and v [m/s] when the motion begins
    arrivals: Arrivals | None = None  # of a_g at each building, in `step`; None where all stand on one ground

    @property
    def step(self) -> float:
        """Time from node to node [s]; with `arrivals` others stand between them."""
        return self.dt / self.parts

    @property
    def phases(self) -> int:
        """Nodes a `step`."""
        return 1 if self.arrivals is None else self.arrivals.offsets.size

    @property
    def block(self) -> int:
        """Nodes that are passed over at a time."""
        return block_steps(self.phases) * self.phases

    @property
    def masses(self) -> np.ndarray:
        """The dofs that are masses: with `arrivals` the last of each building is its ground's."""
        dofs = np.arange(self.row.floors.shape[1])
        return dofs if self.arrivals is None else np.delete(dofs, self.row.frame[FIRST, 1:] - 1)


def lay_out(
    chains: Sequence[Chain],
    points: Sequence[Any],
    dt: float,
    arrivals: np.ndarray | None = None,
    velocities: np.ndarray | None = None,
    *,
    many: bool = False,
) -> Laid:
    """The row of these buildings, left to right, for a motion sampled every ``dt`` [s].

    A point has ``interface``, ``left_floor`` and ``right_floor``: floor 2.4 is 0.4 of the way up the third storey.
    Points are in the order of their interfaces. Samples are divided where the stiffest building would pass more than
    2.5 rad between them, so that a Taylor series sums to rounding over every interval. ``arrivals`` [s], none below
    zero, are those of the motion at each building, ``velocities`` [m/s] those of the ground at t = 0. Where all are
    equal, as without them, all stand on one ground, unless there are ``many`` motions, one of each building.
    """
    rate = max((_rate(chain) for chain in chains), default=0.0)
    parts = max(1, ceil(rate * dt / 2.5))
    step, terms, size = dt / parts, 4, 1.0
    while size > 1e-19 and terms < MAX_TERMS:
        size *= max(rate * step, 1e-3) / (terms - 3)
        terms += 1
    times, speeds = (np.zeros(len(chains)) if values is None else values for values in (arrivals, velocities))
    is_one = not many and not np.ptp(times) > 0.0 and not np.ptp(speeds) > 0.0
    arrived = None if is_one else arrivals_of(times, step, speeds)
    own = 0 if arrived is None else 1  # dofs of each building's ground
    counts = [chain.mass.size for chain in chains]
    first = np.concatenate([[0], np.cumsum(np.array(counts, dtype=np.int64) + own)]).astype(np.int64)
    floors = np.zeros((12, int(first[-1])))
    floors[LIMIT] = inf
    damping = np.zeros((int(first[-1]), max([1, *counts])))
    for place, chain in zip(first, chains, strict=False):
        here = slice(int(place), int(place) + chain.mass.size)
        _lay_floors(floors[:, here], chain)
        damping[here, : chain.mass.size] = chain.damping
    # From each node to the next: building by building, and interval by interval where these differ.
    widths = [step] if arrived is None else np.diff(np.append(arrived.offsets, step)).tolist()
    maps = [_map(chain, width) for width in widths for chain in chains]
    block_maps = [_block_map(maps[b :: len(chains)], count) for b, count in enumerate(counts)]
    interfaces = [int(point.interface) for point in points]
    if interfaces != sorted(interfaces):
        raise ValueError("contact points are not in the order of their interfaces")
    ends = np.full((len(points), 4 + own), -1, dtype=np.int64)
    shares = np.zeros((len(points), 4 + own))
    for k, point in enumerate(points):
        for side, level in enumerate((point.left_floor, point.right_floor)):
            b = int(point.interface) + side
            for end, (dof, share) in enumerate(_dofs(chains[b], float(level))):
                ends[k, 2 * side + end] = -1 if dof < 0 else int(first[b]) + dof
                shares[k, 2 * side + end] = 0.0 if dof < 0 else share * (1.0 - 2.0 * side)
        ends[k, 4:], shares[k, 4:] = first[int(point.interface) + 2] - 1, -1.0
    frame = np.zeros((6, first.size), dtype=np.int64)
    frame[FIRST] = first
    frame[START, :-1] = np.searchsorted(interfaces, np.arange(len(chains)))
    frame[MAP, 1:] = np.cumsum([each.size for each in maps[: len(counts)]])
    frame[BENDS, :-1] = [bool(np.isfinite(chain.strength).any()) for chain in chains]
    frame[BAND, :-1] = [_band(chain.damping) for chain in chains]
    frame[BLOCK_MAP, 1:] = np.cumsum([each.size for each in block_maps])
    row = Row(
        frame,
        ends,
        shares,
        floors,
        damping,
        np.concatenate([*maps, np.zeros(1)]),
        UniformRow() if arrived is None else ArrivingRow(),
    )
    initial = np.hstack(
        [
            chain.initial if chain.initial.size else np.zeros((2, count))
            for chain, count in zip(chains, counts, strict=True)
        ]
    )
    return Laid(row, float(dt), parts, terms, np.concatenate([*block_maps, np.zeros(1)]), initial, arrived)


def cut_out(laid: Laid, first: int, last: int) -> Laid:
    """The layout of the buildings ``first`` to ``last`` of a row alone, with the contact points between them.

    Its nodes are those of the whole row, so that what moves alone in either moves the same, to the bit.
    """
    row = laid.row
    frame = row.frame[:, first : last + 2].copy()
    dofs, maps = (slice(int(frame[place, 0]), int(frame[place, -1])) for place in (FIRST, MAP))
    points = slice(int(frame[START, 0]), int(frame[START, -2]))
    frame[FIRST] -= dofs.start
    frame[MAP] -= maps.start
    frame[START] -= points.start
    frame[[START, BENDS, BAND], -1] = 0
    ends, by_interval = row.ends[points], row.maps[:-1].reshape(laid.phases, -1)[:, maps]
    moved = (dofs.start <= laid.masses) & (laid.masses < dofs.stop)
    return laid._replace(
        row=Row(
            frame,
            np.where(ends < 0, -1, ends - dofs.start),
            row.shares[points].copy(),
            row.floors[:, dofs].copy(),
            row.damping[dofs].copy(),
            np.append(by_interval, 0.0),
            row.passage,
        ),
        initial=laid.initial[:, moved],
        arrivals=None if laid.arrivals is None else laid.arrivals.of(first, last),
    )


def _rate(chain: Chain) -> float:
    """The largest |eigenvalue| of the motion [1/s]."""
    return 0.0 if chain.mass.size == 0 else float(np.abs(np.linalg.eigvals(_motion(chain)[:-2, :-2])).max())


def _band(matrix: np.ndarray) -> int:
    """How far from its diagonal a matrix reaches."""
    rows, columns = np.nonzero(matrix)
    return int(np.abs(rows - columns).max()) if rows.size else 0


def _stiffness(spring: np.ndarray) -> np.ndarray:
    above = np.append(spring[1:], 0.0)
    return np.diag(spring + above) - np.diag(spring[1:], 1) - np.diag(spring[1:], -1)


def _motion(chain: Chain) -> np.ndarray:
    """d/dt of (u, v, a_g, its slope)."""
    n = chain.mass.size
    a = np.zeros((2 * n + 2, 2 * n + 2))
    a[:n, n : 2 * n] = np.eye(n)
    a[n : 2 * n, :n] = -_stiffness(chain.spring) / chain.mass[:, None]
    a[n : 2 * n, n : 2 * n] = -chain.damping / chain.mass[:, None]
    a[n : 2 * n, 2 * n] = -1.0
    a[2 * n, 2 * n + 1] = 1.0
    return a


def _map(chain: Chain, step: float) -> np.ndarray:
    """(u, v) after a node interval from (u, v, a_g, its slope), column by column."""
    from scipy.linalg import expm  # takes longer to import than a scene takes to be checked

    n = chain.mass.size
    return expm(_motion(chain) * step)[: 2 * n].T.ravel() if n else np.zeros(0)


def block_steps(phases: int) -> int:
    """Steps that are passed over at a time, of so many nodes each."""
    return max(1, BLOCK // phases)


def _block_map(maps: list[np.ndarray], n: int) -> np.ndarray:
    """(u, v) of a free vibration after a block, column by column, from those of `_map` over the intervals of a step."""
    whole = np.eye(2 * n)
    for interval_map in maps if n else []:
        whole = interval_map.reshape(2 * n + 2, 2 * n)[: 2 * n].T @ whole
    return np.linalg.matrix_power(whole, block_steps(len(maps))).T.ravel()


def _lay_floors(floors: np.ndarray, chain: Chain) -> None:
    """The rows of `Row.floors` of one building."""
    if chain.mass.size == 0:
        return
    floors[MASS], floors[INVERSE] = chain.mass, 1.0 / chain.mass
    floors[SPRING], floors[SHEAR] = chain.spring, chain.shear
    floors[LIMIT] = chain.strength / chain.shear
    floors[SOFT] = np.where(np.isfinite(chain.strength), (1.0 - chain.hardening) * chain.shear, 0.0)
    floors[STATIC] = np.linalg.solve(_stiffness(chain.spring), chain.mass)
    floors[BOTTOM, 0] = 1.0
    floors[ROOT] = np.sqrt(floors[INVERSE])
    # Of a chain (K⁻¹)_ii is the sum of the flexibilities of the storeys below floor i.
    floors[GIVE], floors[SWAY] = np.sqrt(1.0 / chain.spring), np.sqrt(np.cumsum(1.0 / chain.spring))
    floors[QUICK] = _quickest(chain)


def _quickest(chain: Chain) -> float:
    """(ω + c)², ω the fastest mode and c the largest eigenvalue of M^(−1/2) C M^(−1/2) [1/s²]."""
    root = np.sqrt(chain.mass)
    scaled = [matrix / root / root[:, None] for matrix in (_stiffness(chain.spring), chain.damping)]
    fastest, strongest = (float(np.linalg.eigvalsh(matrix)[-1]) for matrix in scaled)
    return (np.sqrt(fastest) + max(strongest, 0.0)) ** 2


def _dofs(chain: Chain, level: float) -> list[tuple[int, float]]:
    """Dofs and their shares of the place at a floor number; dof −1 is the ground."""
    if chain.mass.size == 0:
        return [(-1, 0.0), (-1, 0.0)]
    above = ceil(level)
    share = 1.0 if above == floor(level) else level - floor(level)
    if not 0 <= above <= chain.mass.size - chain.foundations:
        raise ValueError(f"floor {level:g} is not one of a building of {chain.mass.size - chain.foundations} floors")
    upper = above - 1 + chain.foundations
    return [(upper, share), (upper - 1, 1.0 - share)] if share < 1.0 else [(upper, 1.0), (-1, 0.0)]


def nodes_of(laid: Laid, acceleration: np.ndarray) -> np.ndarray:
    """a_g at the nodes `Laid.step` apart, where it arrives first; NaN from the first sample on that is not finite."""
    return divided(acceleration, laid.parts)


def ground_histories(laid: Laid, acceleration: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The ground at the nodes `Laid.step` apart: a_g under each building, and by how much it widens each interface.

    Returns arrays (nodes, buildings) [m/s²] and (nodes, interfaces) [m]; the latter is zero where all buildings have
    the motion at once.
    """
    nodes, buildings = nodes_of(laid, acceleration), laid.row.frame.shape[1] - 1
    if laid.arrivals is None:
        return np.repeat(nodes[:, None], buildings, axis=1), np.zeros((nodes.shape[-1], buildings - 1))
    table = arriving(nodes, laid.step, laid.arrivals)[:: laid.phases]
    return table[..., PULL], table[:, 1:, SPREAD]


class FreeResponse(NamedTuple):
    """What a row does without any contact: its peaks, and the motion from which its runs begin."""

    run: RowRun
    motion: FreeMotion


def free_row(laid: Laid, acceleration: np.ndarray, *, states: bool = False) -> RowRun:
    """The row without any contact under a_g [m/s²]; ``states`` keeps u and v at every node."""
    return _respond(laid, acceleration, states=states).run


def free_response(laid: Laid, acceleration: np.ndarray) -> FreeResponse:
    """The row without any contact under a_g [m/s²], with all that runs of it have in common."""
    return _respond(laid, acceleration, states=False)


def _respond(laid: Laid, acceleration: np.ndarray, *, states: bool) -> FreeResponse:
    row, run, motion, work, step, terms, at_nodes = unmoved(laid, acceleration)
    if states:
        at_nodes = _empty_states(motion.ground.node_count(), row)
    march_free(lent(row), lent(run), lent(motion), lent(work), step, terms, at_nodes)
    motion.fastest[:] = column(run.contacts, "fastest")
    return FreeResponse(_results_of(laid, run, at_nodes), motion)


def unmoved(laid: Laid, acceleration: np.ndarray) -> tuple[Any, ...]:
    """Arguments of `march_free` for `free_response`."""
    row, points, dofs = laid.row, laid.row.ends.shape[0], laid.row.floors.shape[1]
    run = new_run(row, np.zeros((points, 0)), np.zeros(0))
    set_column(run.contacts, "given_gap", np.full(points, inf))
    ground = _ground(laid, acceleration)
    blocks = ceil((ground.node_count() - 1) / laid.block)
    motion = FreeMotion(
        ground,
        np.zeros((blocks + 1, 2, dofs)),
        np.zeros((blocks, 3, dofs)),
        np.zeros((blocks + 1, 3, dofs)),
        np.zeros((blocks, 2, points)),
        np.zeros((blocks + 1, 2, points)),
        np.zeros(points),
        laid.block_maps,
        laid.block,
    )
    motion.states[0][:, laid.masses] = laid.initial
    if laid.arrivals is not None:
        motion.states[0][1, row.frame[FIRST, 2:] - 1] = np.diff(laid.arrivals.velocities)
    buildings, nodes = row.frame.shape[1] - 1, laid.block + 1
    most = max([0, *np.diff(row.frame[START]).tolist()])  # points of an interface
    work = FreeWork(
        np.zeros((3, dofs, nodes)),
        np.zeros((2, buildings, nodes - 1)),
        np.zeros((3, nodes)),
        np.zeros((3, most, nodes)),
        np.zeros((most, nodes - 1)),
    )
    return row, run, motion, work, laid.step, laid.terms, np.zeros((0, 2, dofs))


def motion_of_part(laid: Laid, motion: FreeMotion, acceleration: np.ndarray, dof: int, point: int) -> FreeMotion:
    """The free motion of a whole row for a part of it, ``dof`` and ``point`` the whole's first ones in the part."""
    ground = motion.ground if laid.arrivals is None else _ground(laid, acceleration)
    return motion._replace(ground=ground, first_dof=dof, first_point=point)


def _ground(laid: Laid, acceleration: np.ndarray) -> UniformRowGround | ArrivingRowGround:
    """The ground motion as the kernels take it."""
    return row_ground(nodes_of(laid, np.asarray(acceleration, dtype=np.float64)), laid.step, laid.arrivals)


def run_row(
    laid: Laid,
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
    motion = free_response(laid, acceleration).motion if free is None else free
    times = np.zeros(0) if levels is None else np.asarray(levels, dtype=np.float64)
    return _run(laid, contacts, motion, rtol, times, histories=histories)


def _run(
    laid: Laid, contacts: Contacts, motion: FreeMotion, rtol: float, levels: np.ndarray, *, histories: bool
) -> RowRun:
    row, points = laid.row, laid.row.ends.shape[0]
    laws = [lowered(law) for law in contacts.laws]
    numbers = [numbers_of(law) for law in laws]
    verbs = [verbs_of(law) for law in laws]
    given = np.zeros((points, max([0, *(room for room, _ in verbs)])))
    for place, own in enumerate(numbers):
        given[place, : len(own)] = own
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
        run = new_run(row, given.copy(), levels, rtol, lines)
        for name, values in fields.items():
            set_column(run.contacts, name, values)
        states = _empty_states(motion.ground.node_count() if histories else 0, row)
        states[:1] = motion.states[0, :, motion.first_dof : motion.first_dof + row.floors.shape[1]]
        march(lent(row), lent(run), lent(motion), laid.step, laid.terms, float(rtol), states)
        written = int(run.workspace.lines_written)
        if written <= lines or not histories:
            return _results_of(laid, run, states)
        lines = written


def _empty_states(nodes: int, row: Row) -> np.ndarray:
    """Array for u and v at so many nodes, NaN as yet."""
    return np.full((nodes, 2, row.floors.shape[1]), np.nan)


def _results_of(laid: Laid, run: Run, states: np.ndarray) -> RowRun:
    """The result of a run, from the arrays that the kernel has filled; nothing of the dofs that are the ground's."""
    row, masses = laid.row, laid.masses
    floors = np.ascontiguousarray(run.dofs[DISPLACEMENT : ACCELERATION + 1].T)
    # A storey that has never passed its limit has the shear of its drift: flights search for the drift's peak alone.
    elastic = floors[:, DRIFT - DISPLACEMENT] <= row.floors[LIMIT]
    floors[elastic, STOREY_FORCE - DISPLACEMENT] = row.floors[SHEAR, elastic] * floors[elastic, DRIFT - DISPLACEMENT]
    at_end = run.dofs[AT_END]
    drift = at_end - np.where(row.floors[BOTTOM] > 0.0, 0.0, np.concatenate([[0.0], at_end[:-1]])[: at_end.size])
    # A storey that yields drags its elastic range along, which is written down when it turns.
    plastic, yields = run.dofs[PLASTIC].copy(), run.dofs[BRANCH] != 0.0
    plastic[yields] = drift[yields] - run.dofs[BRANCH, yields] * row.floors[LIMIT, yields]
    workspace, contacts = run.workspace, run.contacts
    points = [column(contacts, name) for name in ("counters", "highest", "lowest")]
    return RowRun(
        np.column_stack([points[0].reshape(len(contacts), TALLIED), *points[1:]]),
        floors[masses],
        np.column_stack([drift, plastic])[masses],
        int(workspace.status),
        int(workspace.steps),
        float(workspace.energy),
        float(workspace.residual),
        int(workspace.watched_point),
        column(contacts, "fastest"),
        run.timed[1],
        run.timed[2],
        _states_of(laid, states),
        _log_of_masses(run, masses),
    )


def _states_of(laid: Laid, states: np.ndarray) -> np.ndarray:
    """Of the states at nodes (nodes, 2, dofs) those of the masses, at the steps of the layout."""
    return states[:: laid.phases, :, laid.masses]


def _log_of_masses(run: Run, masses: np.ndarray) -> np.ndarray:
    """The log with the columns of these dofs, without those of others."""
    log, dofs = log_of(run), run.dofs.shape[1]
    moved = [np.arange(MOVED), MOVED + masses, MOVED + dofs + masses, np.arange(MOVED + 2 * dofs, log.shape[1])]
    return log[:, np.concatenate(moved)]
