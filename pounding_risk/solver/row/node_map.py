"""A building over one node interval, or a free vibration over many, by a map from (u, v) to (u, v)."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.row.ground_dof import end_ground, top_of
from pounding_risk.solver.row.workspace import BENDS, FIRST, MAP, PLASTIC, SOFT, SPRING, VELOCITY


@kernel
def step_over(row, b, ground, dofs, state, out):
    """Building ``b`` over one node interval, exactly, from rows ``state`` to rows ``out``."""
    pull, rise = ground.under(b)
    first, last = row.frame[FIRST, b], top_of(row, b)
    place = row.frame[MAP, b] + ground.map_number() * row.frame[MAP, row.frame.shape[1] - 1]
    if row.frame[BENDS, b]:
        settle_about(row, b, dofs, state, -1.0)
    apply_map(row.maps, place, dofs, state, out, (first, last), (pull, rise), 2 * (last - first) + 2)
    if row.frame[BENDS, b]:
        settle_about(row, b, dofs, state, 1.0)
        settle_about(row, b, dofs, out, 1.0)
    end_ground(row, b, ground, dofs, out)


@kernel
def advance(row, b, maps, place, dofs, source, target):
    """A free vibration of building ``b`` from rows ``source`` to rows ``target``; ``place`` of its map."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    apply_map(maps, place, dofs, source, target, (first, last), (0.0, 0.0), 2 * (last - first))


@kernel
def apply_map(maps, place, dofs, state, out, span, ground, columns):
    """Rows ``out`` of the dofs of a ``span`` from rows ``state`` and ``ground`` = (a_g, its slope), by a map.

    Its columns, of which there are ``columns``, are added up one after the other, four at a time where there are as
    many; what adds up side by side is done several at a time.
    """
    first, count = span[0], span[1] - span[0]
    for i in range(span[0], span[1]):
        dofs[out, i] = dofs[out + VELOCITY, i] = 0.0
    size = 2 * count
    for column in range(0, columns - 3, 4):
        a, b = factor(dofs, state, first, count, ground, column), factor(dofs, state, first, count, ground, column + 1)
        c, d = (
            factor(dofs, state, first, count, ground, column + 2),
            factor(dofs, state, first, count, ground, column + 3),
        )
        for line in range(2):
            for i in range(count):
                total = dofs[out + line, first + i] + maps[place + i] * a
                total = (total + maps[place + size + i] * b) + maps[place + 2 * size + i] * c
                dofs[out + line, first + i] = total + maps[place + 3 * size + i] * d
            place += count
        place += 3 * size
    for column in range(columns - columns % 4, columns):
        a = factor(dofs, state, first, count, ground, column)
        for line in range(2):
            for i in range(count):
                dofs[out + line, first + i] += maps[place + i] * a
            place += count


@small
def factor(dofs, state, first, count, ground, column):
    """What a column of a map is multiplied with: u, v of each dof in turn, a_g and its slope."""
    if column < count:
        return dofs[state, first + column]
    if column < 2 * count:
        return dofs[state + VELOCITY, first + column - count]
    return ground[column - 2 * count]


@kernel
def settle_about(row, b, dofs, state, sign):
    """Add ``sign`` times the displacements at which a building rests, with the plastic drifts that it has."""
    rest = 0.0
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        rest += row.floors[SOFT, i] * dofs[PLASTIC, i] / row.floors[SPRING, i]
        dofs[state, i] += sign * rest
