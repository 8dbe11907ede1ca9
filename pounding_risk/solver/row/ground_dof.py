"""The dof of a building's ground under a passing wave, the building's last: its motion is given, not integrated."""

from __future__ import annotations

from pounding_risk._jit.compile import small
from pounding_risk.solver.row.workspace import BRACES, FIRST, VELOCITY


@small
def top_of(row, b):
    """One past the last dof of building ``b`` that is a mass."""
    return row.frame[FIRST, b + 1] - row.frame[BRACES, b] - row.passage.ground_dofs()


@small
def place_ground(row, b, ground, dofs, line):
    """Write w and ẇ of building ``b`` at x = 0 to rows ``line``."""
    if row.passage.ground_dofs() > 0:
        w, rate, _, _ = ground.ground_moves(b)
        dofs[line, top_of(row, b)] = w
        dofs[line + VELOCITY, top_of(row, b)] = rate


@small
def end_ground(row, b, ground, dofs, line):
    """Write w and ẇ of building ``b`` at the end of the node interval to rows ``line``."""
    if row.passage.ground_dofs() > 0:
        w, rate = ground.ground_ends(b)
        dofs[line, top_of(row, b)] = w
        dofs[line + VELOCITY, top_of(row, b)] = rate


@small
def push_ground(row, b, ground, dofs, line):
    """Write ẅ of building ``b`` at x = 0 to row ``line``."""
    if row.passage.ground_dofs() > 0:
        dofs[line, top_of(row, b)] = ground.ground_moves(b)[2]


@small
def write_ground_series(row, b, ground, series, terms):
    """Write the series of w of building ``b`` from x = 0 on."""
    if row.passage.ground_dofs() > 0:
        i = top_of(row, b)
        w, rate, bend, twist = ground.ground_moves(b)
        series[i, 0], series[i, 1], series[i, 2], series[i, 3] = w, rate, 0.5 * bend, twist / 6.0
        for n in range(4, terms):
            series[i, n] = 0.0
