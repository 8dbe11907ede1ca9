"""A building over one node interval, or a free vibration over many, by a map from (u, v) to (u, v)."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.row.ground_dof import end_ground, top_of
from pounding_risk.solver.row.workspace import CAN_YIELD, CONSTANT, FIRST, MAP, SPRING, VELOCITY


@kernel
def map_motion(row, b, ground, dofs, state, out):
    """Building ``b`` over one node interval, exactly, from rows ``state`` to rows ``out``."""
    pull, rise = ground.under(b)
    first, last = row.frame[FIRST, b], top_of(row, b)
    map_start = row.frame[MAP, b] + ground.map_number() * row.frame[MAP, row.frame.shape[1] - 1]
    if row.frame[CAN_YIELD, b]:
        add_plastic_rest(row, b, dofs, state, -1.0)
    loads = row.passage.map_loads(pull, rise)
    apply_map(row.maps, map_start, dofs, (state, out), (first, last), loads, 2 * (last - first) + len(loads))
    if row.frame[CAN_YIELD, b]:
        add_plastic_rest(row, b, dofs, state, 1.0)
        add_plastic_rest(row, b, dofs, out, 1.0)
    end_ground(row, b, ground, dofs, out)


@kernel
def map_vibration(row, b, maps, map_start, dofs, source, target):
    """A free vibration of building ``b`` from rows ``source`` to rows ``target``; ``map_start`` of its map."""
    first, last = row.frame[FIRST, b], top_of(row, b)
    apply_map(maps, map_start, dofs, (source, target), (first, last), (0.0, 0.0), 2 * (last - first))


@kernel
def apply_map(maps, entry, dofs, lines, span, ground, columns):
    """(u, v) of the dofs of a ``span`` at the end of an interval, by the map that begins at ``entry`` of ``maps``.

    ``lines`` = (rows of the state at the start, rows for that at the end), ``ground`` as
    `RowPassage.map_loads`; a single mass moves along the row alone.
    The map's columns, of which there are ``columns``, are added up one after the other, four at a time where there are
    as many; what adds up side by side is done several at a time.
    """
    state, out = lines
    first, count = span[0], span[1] - span[0]
    if count == 1:
        u, v = dofs[state, first], dofs[state + VELOCITY, first]
        moved = (0.0 + maps[entry] * u) + maps[entry + 2] * v
        speed = (0.0 + maps[entry + 1] * u) + maps[entry + 3] * v
        if columns > 2:
            moved = (moved + maps[entry + 4] * ground[0]) + maps[entry + 6] * ground[1]
            speed = (speed + maps[entry + 5] * ground[0]) + maps[entry + 7] * ground[1]
        dofs[out, first], dofs[out + VELOCITY, first] = moved, speed
        return
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
                total = dofs[out + line, first + i] + maps[entry + i] * a
                total = (total + maps[entry + size + i] * b) + maps[entry + 2 * size + i] * c
                dofs[out + line, first + i] = total + maps[entry + 3 * size + i] * d
            entry += count
        entry += 3 * size
    for column in range(columns - columns % 4, columns):
        a = factor(dofs, state, first, count, ground, column)
        for line in range(2):
            for i in range(count):
                dofs[out + line, first + i] += maps[entry + i] * a
            entry += count


@small
def factor(dofs, state, first, count, ground, column):
    """What a column of a map is multiplied with: u, v of each dof in turn, a_g and its slope."""
    if column < count:
        return dofs[state, first + column]
    if column < 2 * count:
        return dofs[state + VELOCITY, first + column - count]
    return ground[column - 2 * count]


@kernel
def add_plastic_rest(row, b, dofs, state, sign):
    """Add ``sign`` times the displacements at which a building rests, with the plastic drifts that it has."""
    displacement = 0.0
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        displacement -= dofs[CONSTANT, i] / row.floors[SPRING, i]
        dofs[state, i] += sign * displacement
