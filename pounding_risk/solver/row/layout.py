"""The layout of a row: its buildings and contact points as the arrays that all its runs share.

The buildings are chains of masses (`mdof.Chain`), the contact points places on them.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk.models.ground import Arrivals, arrivals_of, divided
from pounding_risk.models.structures.hysteresis._numbers import (
    ALONG_RATE,
    BRACE,
    BRACE_DOF,
    LONGEST,
    OWNER,
    PACE,
    SHORTENING,
    STIFFNESS,
)
from pounding_risk.models.structures.links import Body, bodies_of, floor_shares
from pounding_risk.models.structures.mdof import stacked
from pounding_risk.solver.row.ground import ArrivingRow, PlaneRow, UniformRow
from pounding_risk.solver.row.workspace import (
    ACROSS,
    BAND,
    BLOCK_MAP,
    BOTTOM,
    BRACES,
    CAN_YIELD,
    COUPLED,
    DRIVEN,
    FELT,
    FIRST,
    GIVE,
    INVERSE,
    LIMIT,
    MAP,
    MASS,
    MOBILITY,
    QUICK,
    ROOT,
    SHEAR,
    SOFT,
    SPRING,
    START,
    STATIC,
    SWAY,
    Row,
)
from pounding_risk.solver.workspace import parts_and_terms

if TYPE_CHECKING:
    from pounding_risk.models.structures.mdof import Chain

BLOCK = 16  # nodes passed over at a time, or as many more as make whole steps


def body_numbers(bodies: Sequence[Body]) -> list[int]:
    """The body of each building."""
    return [place for place, body in enumerate(bodies) for _ in range(body.first, body.last + 1)]


class RowLayout(NamedTuple):
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
        """Number of nodes in each `step`: 1, and more where the motion arrives at each building at its own time."""
        return 1 if self.arrivals is None else self.arrivals.offsets.size

    @property
    def block(self) -> int:
        """Number of node intervals that are passed over at a time; whole steps."""
        return block_steps(self.phases) * self.phases

    @property
    def masses(self) -> np.ndarray:
        """The dofs that are masses: with `arrivals` the last of each building is its ground's."""
        others = self.braces if self.arrivals is None else self.row.frame[FIRST, 1:] - 1
        return np.delete(np.arange(self.row.floors.shape[1]), others)

    @property
    def braces(self) -> np.ndarray:
        """The dofs that are braces of dampers, in the order of their links."""
        links = self.row.links
        return links[links[:, BRACE] > 0.0, BRACE_DOF].astype(int) if links.size else np.zeros(0, dtype=int)


def lay_out(
    chains: Sequence[Chain],
    points: Sequence[Any],
    dt: float,
    arrivals: np.ndarray | None = None,
    velocities: np.ndarray | None = None,
    *,
    many: bool = False,
    bodies: Sequence[Body] = (),
) -> RowLayout:
    """The row of these buildings, left to right, for a motion sampled every ``dt`` [s].

    A point has ``interface``, ``left_floor`` and ``right_floor``: floor 2.4 is 0.4 of the way up the third storey.
    Where floors rotate it has its place ``across`` the row. Points are in the order of their interfaces. Samples
    are divided where the stiffest building would pass more than 2.5 rad between them, so that a Taylor series sums
    to rounding over every interval. ``arrivals`` [s], none below zero, are those of the motion at each building,
    ``velocities`` [m/s] those of the ground at t = 0. Where all are equal, as without them, all stand on one
    ground, unless there are ``many`` motions, one of each building. Linked buildings, which all stand on one
    ground, are given by the ``bodies`` that they make (`links.bodies_of`).
    """
    buildings, bodies = chains, bodies or bodies_of(chains)
    chains, of_body = [body.chain for body in bodies], body_numbers(bodies)
    interfaces = [of_body[int(point.interface)] for point in points]
    if interfaces != sorted(interfaces):
        raise ValueError("contact points are not in the order of their interfaces")
    rate = max((_rate(chain) for chain in chains), default=0.0)
    parts, terms = parts_and_terms(rate, dt)
    step = dt / parts
    times, speeds = (np.zeros(len(chains)) if values is None else values for values in (arrivals, velocities))
    is_one_ground = not many and not np.ptp(times) > 0.0 and not np.ptp(speeds) > 0.0
    arrived = None if is_one_ground else arrivals_of(times, step, speeds)
    ground_dofs = 0 if arrived is None else 1  # dofs of each building's ground
    counts = [chain.mass.size for chain in chains]
    braces = _braces(points, of_body, counts)
    first = _starts(np.array(counts, dtype=np.int64) + ground_dofs + braces)
    # Those before a building, of all bodies to its left.
    before = _starts(braces)[[*of_body, len(chains)]]
    firsts = _starts([chain.mass.size + ground_dofs for chain in buildings]) + before
    is_plane = any(chain.moves_across for chain in chains)
    floors, damping, coupling, storeys, inertia = _matrices(chains, first, is_plane)
    # From each node to the next: building by building, and interval by interval where these differ.
    widths = [step] if arrived is None else np.diff(np.append(arrived.offsets, step)).tolist()
    maps = [_map(chain, width, is_plane) for width in widths for chain in chains]
    block_maps = [_block_map(maps[b :: len(chains)], count) for b, count in enumerate(counts)]
    ends, shares = _ends(points, buildings, firsts, ground_dofs)
    compliances = _compliances(ends, shares, floors, inertia, first)
    laws = _laws_of_links(points, ends, compliances, first, (step, rate), braces)
    row = Row(
        _frame(chains, first, braces, interfaces, (maps, block_maps), laws),
        ends,
        shares,
        floors,
        damping,
        coupling,
        np.concatenate([*maps, np.zeros(1)]),
        PlaneRow() if is_plane else UniformRow() if arrived is None else ArrivingRow(),
        storeys,
        laws,
        inertia,
    )
    begun = zip(chains, counts, strict=True)
    initial = np.hstack([chain.initial if chain.initial.size else np.zeros((2, count)) for chain, count in begun])
    return RowLayout(row, float(dt), parts, terms, np.concatenate([*block_maps, np.zeros(1)]), initial, arrived)


def _braces(points: Sequence[Any], of_body: Sequence[int], counts: Sequence[int]) -> np.ndarray:
    """Number of braces of dampers of each body, whose masses are so many."""
    braces = np.zeros(len(counts), dtype=np.int64)
    for point in points:
        # A link to a rigid neighbour is of the body of the other.
        body = of_body[int(point.interface)]
        law = getattr(point, "law", ())
        braces[body if counts[body] else body + 1] += bool(law) and law[ALONG_RATE] > 0.0 and law[BRACE] > 0.0
    return braces


def _starts(sizes: Sequence[int] | np.ndarray) -> np.ndarray:
    """Where parts of these sizes start, one behind the other, and where the last one ends."""
    return np.concatenate([[0], np.cumsum(sizes)]).astype(np.int64)


def _matrices(
    chains: Sequence[Chain], first: np.ndarray, is_plane: bool
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Numbers of the floors, damping, coupling, laws of storeys and mass matrices of all bodies, as in `Row`."""
    dofs_of_row = int(first[-1])
    floors = np.zeros((DRIVEN + 1 + ACROSS * is_plane, dofs_of_row))
    floors[LIMIT] = inf
    damping = np.zeros((dofs_of_row, max(1, *(chain.mass.size for chain in chains))))
    coupling = np.zeros((dofs_of_row, max(chain.coupling.shape[1] for chain in chains)))
    storeys = np.zeros((dofs_of_row, max(chain.laws.shape[1] for chain in chains)))
    inertia = np.zeros((dofs_of_row, 2 * max(chain.inertia.shape[1] for chain in chains)))
    for start, chain in zip(first, chains, strict=False):
        dofs = slice(int(start), int(start) + chain.mass.size)
        _lay_floors(floors[:, dofs], chain)
        damping[dofs, : chain.mass.size] = chain.damping
        if chain.coupling.size:
            coupling[dofs, : chain.mass.size] = chain.coupling
        if chain.inertia.size:
            factor, half = np.linalg.cholesky(chain.inertia), inertia.shape[1] // 2
            inertia[dofs, : len(factor)], inertia[dofs, half : half + len(factor)] = factor, _inverse(chain)
        if chain.laws.size:
            storeys[dofs, : chain.laws.shape[1]] = chain.laws
            # A law has what a bilinear storey reads from these; isolators, or a linked neighbour, may have none.
            has_law = storeys[dofs, STIFFNESS] > 0.0
            floors[SOFT, dofs] *= ~has_law
            # Of floors joined by a matrix P-delta alone is in the spring, below zero.
            storeys[dofs, PACE] = np.sqrt(np.where(has_law, floors[SPRING, dofs] * floors[MOBILITY, dofs], 0.0))
    return floors, damping, coupling, storeys, inertia


def _ends(
    points: Sequence[Any], buildings: Sequence[Chain], firsts: np.ndarray, ground_dofs: int
) -> tuple[np.ndarray, np.ndarray]:
    """The dofs that close each contact point, −1 where there is none, and the share of each."""
    ends = np.full((len(points), 4 + ground_dofs), -1, dtype=np.int64)
    shares = np.zeros((len(points), 4 + ground_dofs))
    for k, point in enumerate(points):
        across = float(getattr(point, "across", inf))  # infinite where that does not matter
        for side, level in enumerate((point.left_floor, point.right_floor)):
            b = int(point.interface) + side
            for end, (mass, share) in enumerate(floor_shares(buildings[b], float(level), across)):
                ends[k, 2 * side + end] = firsts[b] + mass
                shares[k, 2 * side + end] = share * (1.0 - 2.0 * side)
        ends[k, 4:], shares[k, 4:] = firsts[int(point.interface) + 2] - 1, -1.0
    return ends, shares


def _frame(
    chains: Sequence[Chain],
    first: np.ndarray,
    braces: np.ndarray,
    interfaces: Sequence[int],
    maps: tuple[list[np.ndarray], list[np.ndarray]],
    laws: np.ndarray,
) -> np.ndarray:
    """Where the numbers of each body stand in the other arrays, and what it has, as in `Row`.

    ``interfaces`` are the bodies on the left of the contact points, ``maps`` those of nodes and of blocks.
    """
    of_nodes, of_blocks = maps
    frame = np.zeros((8, first.size), dtype=np.int64)
    frame[FIRST] = first
    frame[BRACES, :-1] = braces
    frame[START, :-1] = np.searchsorted(interfaces, np.arange(len(chains)))
    frame[MAP, 1:] = np.cumsum([one_map.size for one_map in of_nodes[: len(chains)]])
    frame[CAN_YIELD, :-1] = [bool(np.isfinite(chain.strength).any()) for chain in chains]
    frame[BAND, :-1] = [_band(chain.damping) for chain in chains]
    frame[COUPLED, :-1] = [(chain.coupling.size > 0) + (chain.inertia.size > 0) for chain in chains]
    frame[BLOCK_MAP, 1:] = np.cumsum([one_map.size for one_map in of_blocks])
    for body in laws[laws[:, STIFFNESS] > 0.0, OWNER].astype(int) if laws.size else ():
        frame[CAN_YIELD, body] = 1
    return frame


def _compliances(
    ends: np.ndarray, shares: np.ndarray, floors: np.ndarray, inertia: np.ndarray, first: np.ndarray
) -> np.ndarray:
    """B M⁻¹ Bᵀ of each point [1/kg]."""
    found = np.zeros(len(ends))
    for k, (dofs, parts) in enumerate(zip(ends, shares, strict=True)):
        found[k] = (parts[dofs >= 0] ** 2 * floors[MOBILITY, dofs[dofs >= 0]]).sum()
        for end in (0, 2) if inertia.size else ():  # both floors of a column
            i, j = dofs[end : end + 2]
            if i >= 0 and j >= 0:
                place = inertia.shape[1] // 2 + j - first[np.searchsorted(first, j, "right") - 1]
                found[k] += 2.0 * parts[end] * parts[end + 1] * inertia[i, place]
    return found


def _laws_of_links(
    points: Sequence[Any],
    ends: np.ndarray,
    compliances: np.ndarray,
    first: np.ndarray,
    pace: tuple[float, float],
    braces: np.ndarray,
) -> np.ndarray:
    """Numbers of the laws of links by point, zero without one; (0, 0) where no point has one.

    ``pace`` = (longest flight [s], rate [1/s] for which the series of such a flight have terms).
    """
    laws = [np.asarray(getattr(point, "law", ()), dtype=float) for point in points]
    if not any(law.size for law in laws):
        return np.zeros((0, 0))
    held = stacked(laws)
    for k in np.flatnonzero(held[:, STIFFNESS] > 0.0):
        mine, compliance = ends[k] >= 0, float(compliances[k])
        held[k, PACE] = np.sqrt(held[k, STIFFNESS] * compliance)
        held[k, LONGEST], held[k, SHORTENING] = pace[0], compliance / pace[1]
        owner = np.searchsorted(first, ends[k, mine].max(), "right") - 1
        held[k, OWNER] = owner
        if held[k, BRACE] > 0.0:
            # The brace as a spring, and its slack by the damper, are rates beside those of the body.
            fastest = pace[1] + np.sqrt(held[k, BRACE] * compliance)
            held[k, LONGEST] *= pace[1] / fastest
            held[k, SHORTENING] = held[k, BRACE] / fastest
            before = (held[:k, BRACE] > 0.0) & (held[:k, OWNER] > owner - 1)
            held[k, BRACE_DOF] = first[owner + 1] - braces[owner] + before.sum()
    return held


def _within(links: np.ndarray, first: int, dof: int) -> np.ndarray:
    """Laws of links for a row that begins with body ``first``, at this dof."""
    links = links.copy()
    if links.size:
        links[:, OWNER] -= first
        links[:, BRACE_DOF] -= dof
    return links


def cut_out(layout: RowLayout, first: int, last: int) -> RowLayout:
    """The layout of the buildings ``first`` to ``last`` of a row alone, with the contact points between them.

    Its nodes are those of the whole row, so that what moves alone in either moves the same, to the bit.
    """
    row = layout.row
    frame = row.frame[:, first : last + 2].copy()
    dofs, maps = (slice(int(frame[line, 0]), int(frame[line, -1])) for line in (FIRST, MAP))
    points = slice(int(frame[START, 0]), int(frame[START, -2]))
    frame[FIRST] -= dofs.start
    frame[MAP] -= maps.start
    frame[START] -= points.start
    frame[[START, CAN_YIELD, BAND, COUPLED, BRACES], -1] = 0
    ends, by_interval = row.ends[points], row.maps[:-1].reshape(layout.phases, -1)[:, maps]
    within = (dofs.start <= layout.masses) & (layout.masses < dofs.stop)
    return layout._replace(
        row=Row(
            frame,
            np.where(ends < 0, -1, ends - dofs.start),
            row.shares[points].copy(),
            row.floors[:, dofs].copy(),
            row.damping[dofs].copy(),
            row.coupling[dofs].copy(),
            np.append(by_interval, 0.0),
            row.passage,
            row.storeys[dofs].copy(),
            _within(row.links[points], first, dofs.start),
            row.inertia[dofs].copy(),
        ),
        initial=layout.initial[:, within],
        arrivals=None if layout.arrivals is None else layout.arrivals.of(first, last),
    )


def _rate(chain: Chain) -> float:
    """The largest |eigenvalue| of the free motion of a building [1/s]; 0 for a rigid one."""
    return 0.0 if chain.mass.size == 0 else float(np.abs(np.linalg.eigvals(_motion(chain, False)[:-2, :-2])).max())


def _band(matrix: np.ndarray) -> int:
    """How far from its diagonal a matrix reaches: 0 for a diagonal one, 1 for a tridiagonal one."""
    rows, columns = np.nonzero(matrix)
    return int(np.abs(rows - columns).max()) if rows.size else 0


def _motion(chain: Chain, is_plane: bool) -> np.ndarray:
    """The matrix of d/dt (u, v, a_g, slope of a_g) of a building in free motion; a_g of one component, or of two."""
    n, loads = chain.mass.size, (chain.felt(), chain.felt_across())[: 1 + is_plane]
    a = np.zeros((2 * (n + len(loads)),) * 2)
    a[:n, n : 2 * n] = np.eye(n)
    if chain.inertia.size:
        inverse = _inverse(chain)
        pushed, a[n : 2 * n, :n] = inverse @ chain.mass, -inverse @ chain.stiffness()
        a[n : 2 * n, n : 2 * n] = -inverse @ chain.damping
    else:
        pushed, a[n : 2 * n, :n] = np.ones(n), -chain.stiffness() / chain.mass[:, None]
        a[n : 2 * n, n : 2 * n] = -chain.damping / chain.mass[:, None]
    for place, felt in enumerate(loads, n):
        a[n : 2 * n, 2 * place] = -felt * pushed
        a[2 * place, 2 * place + 1] = 1.0
    return a


def _map(chain: Chain, step: float, is_plane: bool) -> np.ndarray:
    """(u, v) after a node interval from (u, v, a_g, its slope), column by column, as `RowPassage.map_loads`."""
    from scipy.linalg import expm  # takes longer to import than a scene takes to be checked

    n = chain.mass.size
    return expm(_motion(chain, is_plane) * step)[: 2 * n].T.ravel() if n else np.zeros(0)


def block_steps(phases: int) -> int:
    """Number of steps in a block of nodes, each of which has ``phases`` nodes."""
    return max(1, BLOCK // phases)


def _block_map(maps: list[np.ndarray], n: int) -> np.ndarray:
    """(u, v) of a free vibration after a block, column by column, from those of `_map` over the intervals of a step."""
    step_map = np.eye(2 * n)
    for interval_map in maps if n else []:
        step_map = interval_map.reshape(-1, 2 * n)[: 2 * n].T @ step_map
    return np.linalg.matrix_power(step_map, block_steps(len(maps))).T.ravel()


def _lay_floors(floors: np.ndarray, chain: Chain) -> None:
    """Write the rows of `Row.floors` of one building, its dofs' part of them."""
    if chain.mass.size == 0:
        return
    if not chain.inertia.size:  # what a_g acts on in a mode may be nothing
        floors[MASS], floors[INVERSE] = chain.mass, 1.0 / chain.mass
    floors[SPRING], floors[SHEAR] = chain.spring, chain.shear
    floors[LIMIT] = chain.drift_limits()
    floors[SOFT] = np.where(np.isfinite(chain.strength), (1.0 - chain.hardening) * chain.shear, 0.0)
    floors[FELT], floors[DRIVEN] = chain.felt(), chain.mass * chain.felt()
    floors[STATIC] = np.linalg.solve(chain.stiffness(), floors[DRIVEN])
    if floors.shape[0] > DRIVEN + 1:
        felt = chain.felt_across()
        floors[FELT + ACROSS], floors[DRIVEN + ACROSS] = felt, chain.mass * felt
        floors[STATIC + ACROSS] = np.linalg.solve(chain.stiffness(), chain.mass * felt)
    floors[BOTTOM, list(chain.bottoms)] = 1.0
    floors[MOBILITY] = floors[INVERSE]
    if chain.inertia.size:
        floors[MASS], floors[INVERSE], floors[FELT] = 0.0, 1.0, floors[DRIVEN]
        floors[MOBILITY] = np.diag(_inverse(chain))
    floors[ROOT] = np.sqrt(floors[MOBILITY])
    floors[GIVE], floors[SWAY] = _give_and_sway(chain)
    floors[QUICK] = _quickest(chain)


def _give_and_sway(chain: Chain) -> tuple[np.ndarray, np.ndarray]:
    """Roots of the flexibilities of each drift and of each floor [sqrt(m/N)]: with D the drifts, D K⁻¹ Dᵀ and K⁻¹."""
    if chain.coupling.size:
        drifts, flexibility = chain.drifts(), np.linalg.inv(chain.stiffness())
        return np.sqrt(np.diag(drifts @ flexibility @ drifts.T)), np.sqrt(np.diag(flexibility))
    # Of a chain (K⁻¹)_ii is the sum of the flexibilities of the storeys below floor i.
    return np.sqrt(1.0 / chain.spring), np.sqrt(np.cumsum(1.0 / chain.spring))


def _quickest(chain: Chain) -> float:
    """(ω + c)², ω the fastest mode and c the largest eigenvalue of L⁻¹ C L⁻ᵀ, M = L Lᵀ [1/s²]."""
    matrices = chain.stiffness(), chain.damping
    if chain.inertia.size:
        inverse = np.linalg.inv(np.linalg.cholesky(chain.inertia))
        scaled = [inverse @ matrix @ inverse.T for matrix in matrices]
    else:
        root = np.sqrt(chain.mass)
        scaled = [matrix / root / root[:, None] for matrix in matrices]
    fastest, strongest = (float(np.linalg.eigvalsh(matrix)[-1]) for matrix in scaled)
    return (np.sqrt(fastest) + max(strongest, 0.0)) ** 2


def _inverse(chain: Chain) -> np.ndarray:
    """M⁻¹ of a building with a mass matrix [1/kg], symmetric to the bit."""
    factor = np.linalg.inv(np.linalg.cholesky(chain.inertia))
    return np.asarray(factor.T @ factor)


def nodes_of(layout: RowLayout, acceleration: np.ndarray) -> np.ndarray:
    """a_g at nodes `RowLayout.step` apart, where it arrives first; NaN from the first sample on that is not finite."""
    return divided(acceleration, layout.parts)
