"""Rows of single masses whose velocities jump at a touch: which rows these are, and their runs."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from pounding_risk._jit.memory import by_address, column, new_record, new_records, set_column
from pounding_risk.models.contact.impulsive import is_instant
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.row.api import HIGHEST, LOWEST, Contacts, RowRun
from pounding_risk.solver.row.complementarity import TABLE_ROWS
from pounding_risk.solver.row.ground import row_ground
from pounding_risk.solver.row.impulsive.run import march_jumps
from pounding_risk.solver.row.impulsive.state import Body, Chain, Link, Totals
from pounding_risk.solver.row.layout import RowLayout, nodes_of
from pounding_risk.solver.row.workspace import FIRST, LINE_POINT_COLUMNS, LINE_STATES, MASS, SHEAR, SPRING

LINES = 1024  # of a log to begin with; a run that needs more is repeated with the room it asked for


def jumps(laws: Sequence[Any]) -> bool:
    """True for the laws of contact points under which all velocities jump; a row has no mixture of both kinds."""
    return bool(laws) and all(map(is_instant, laws))


def run_jumps(
    layout: RowLayout,
    contacts: Contacts,
    acceleration: np.ndarray,
    free: RowRun,
    *,
    rtol: float = 1e-6,
    histories: bool = False,
) -> RowRun:
    """A row of single masses under a_g [m/s²], with laws whose velocities jump, one contact point an interface.

    ``free`` is the run of the same buildings without contact: those that no contact moves have its peaks, to the bit.
    ``histories`` keeps u and v at every node, and the log. Forces that are reached are not noted: a jump has none.
    Raises ValueError for another row, which the checks of scenes leave none of.
    """
    moving = np.flatnonzero(np.diff(layout.row.frame[FIRST]) > (layout.arrivals is not None))
    off_floors = np.isin(np.abs(layout.row.shares), (0.0, 1.0), invert=True).any()
    if len(contacts.laws) != layout.row.frame.shape[1] - 2 or len(moving) != len(layout.masses) or off_floors:
        raise ValueError("velocities jump only in rows of single masses that meet mass to mass")
    ground = row_ground(nodes_of(layout, np.asarray(acceleration, dtype=np.float64)), layout.step, layout.arrivals)
    lines = LINES if histories else 0
    while True:
        chain = _chain_of(layout, contacts, free.fastest, moving, lines)
        states = np.full((ground.node_count() if histories else 0, 2, len(chain.bodies)), np.nan)
        states[:1] = 0.0
        states[:1, :, moving] = layout.initial
        march_jumps(by_address(chain), ground, layout.step, layout.terms, float(rtol), states)
        written = int(chain.totals.lines_written)
        if written <= lines or not histories:
            records = states[:: layout.phases, :, moving], chain.log[:written]
            return _result_of(layout, chain, free, moving, records)
        lines = written


def _chain_of(layout: RowLayout, contacts: Contacts, fastest: np.ndarray, moving: np.ndarray, lines: int) -> Chain:
    """Arrays of a run, filled with what is given; ``moving`` are the buildings with a mass."""
    buildings, points = layout.row.frame.shape[1] - 1, len(contacts.laws)
    chain = Chain(
        new_records(Body, buildings),
        new_records(Link, points),
        np.zeros((TABLE_ROWS, points)),
        new_record(Totals),
        np.zeros((lines, LINE_STATES + 2 * len(moving) + LINE_POINT_COLUMNS * points)),
    )
    mass, spring = layout.row.floors[MASS, layout.masses], layout.row.floors[SPRING, layout.masses]
    damping = layout.row.damping[layout.masses, 0]
    values = {"mass": mass, "inverse": 1.0 / mass, "omega2": spring / mass, "two_zeta_omega": damping / mass}
    values |= {"u": layout.initial[0], "v": layout.initial[1], "dof": np.arange(len(moving))}
    for name, of_masses in values.items():
        of_bodies = np.zeros(buildings)
        of_bodies[moving] = of_masses
        set_column(chain.bodies, name, of_bodies)
    set_column(chain.links, "gap", contacts.gaps)
    set_column(chain.links, "watched", np.zeros(points) if contacts.watched is None else contacts.watched)
    set_column(chain.links, "fastest", fastest)
    rules = [_rule_of(*law_and_rule) for law_and_rule in zip(contacts.laws, contacts.restitutions, strict=True)]
    set_column(chain.links, "rule", np.array(rules).reshape(points, len(Restitution._fields)))
    return chain


def _rule_of(law: Any, rule: Restitution) -> list[float]:
    """The relation of the speeds after and before a touch: e(v), or none that comes back."""
    share = law.strike(1.0, 1.0, 1.0)[0]
    return [*(share * coefficient for coefficient in rule[:-1]), rule.fastest]


def _result_of(
    layout: RowLayout, chain: Chain, free: RowRun, moving: np.ndarray, records: tuple[np.ndarray, np.ndarray]
) -> RowRun:
    """The result of a run, from the arrays that the kernel has filled; ``records`` = (states, log)."""
    counters = column(chain.links, "counters").reshape(len(chain.links), -1)
    points = np.column_stack([counters, column(chain.links, "highest"), column(chain.links, "lowest")])
    reach, displacement = column(chain.bodies, "peak_displacement")[moving], column(chain.bodies, "u")[moving]
    shear = layout.row.floors[SHEAR, layout.masses]
    floors = np.column_stack([reach, reach, shear * reach, column(chain.bodies, "peak_acceleration")[moving]])
    rest = np.column_stack([displacement, np.zeros(len(moving))])
    hit = column(chain.bodies, "has_been_struck") > 0.0
    is_free = ~(hit[:-1] | hit[1:])
    points[is_free, HIGHEST : LOWEST + 1] = free.points[is_free, HIGHEST : LOWEST + 1]
    floors[~hit[moving]], rest[~hit[moving]] = free.floors[~hit[moving]], free.rest[~hit[moving]]
    totals = chain.totals
    return RowRun(
        points,
        floors,
        rest,
        int(totals.status),
        int(totals.steps),
        float(totals.energy),
        float(totals.residual),
        int(totals.watched_point),
        np.zeros(len(points)),
        np.full((len(points), 0), np.nan),
        np.zeros((len(points), 0)),
        *records,
    )
