"""A law of measured or computed points: force against penetration from a table, with crushing that stays."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from os import PathLike
from typing import Annotated, NamedTuple

from pounding_risk._jit.calls import read_slot
from pounding_risk._jit.compile import small
from pounding_risk.models.contact.law import LINEAR_STIFFNESS, flat, may_pull, never_yields
from pounding_risk.models.contact.table import (
    END,
    HEAD,
    LINE,
    LOADING_PIECES,
    PIECE,
    SHARE,
    UNLOADING_PIECES,
    Table,
    table_of,
)

ORDER = 70
STRAIGHT = table_of((0.0, 1.0), (0.0, 1.0))


@small
def piece_at(table, first, count, x):
    """Where the piece of a curve begins that holds x; the curve has ``count`` of them from place ``first`` on."""
    low, high = 0, count
    while high - low > 1:
        middle = (low + high) >> 1
        if read_slot(table, first + PIECE * middle) <= x:
            low = middle
        else:
            high = middle
    return first + PIECE * low


@small
def curve_value(table, first, count, x):
    """Value at x of the curve of cubics that stands at an address: force over stiffness [m], or a share of it."""
    place = piece_at(table, first, count, x)
    t = x - read_slot(table, place)
    rising = read_slot(table, place + 3) + t * read_slot(table, place + 4)
    return read_slot(table, place + 1) + t * (read_slot(table, place + 2) + t * rising)


@small
def curve_energy(table, first, count, x):
    """The integral of the curve from 0 to x."""
    place = piece_at(table, first, count, x)
    t = x - read_slot(table, place)
    rising = read_slot(table, place + 3) / 3.0 + t * (read_slot(table, place + 4) / 4.0)
    height = read_slot(table, place + 1) + t * (read_slot(table, place + 2) / 2.0 + t * rising)
    return read_slot(table, place + 5) + t * height


@small
def loading(table, delta):
    """Force over stiffness on the way in [m]."""
    return curve_value(table, HEAD, int(read_slot(table, LOADING_PIECES)), delta)


@small
def loading_energy(table, delta):
    """Energy over stiffness that the way in takes [m²]."""
    return curve_energy(table, HEAD, int(read_slot(table, LOADING_PIECES)), delta)


@small
def unloading_pieces(table):
    """(where they begin, how many there are) of the way back; none where the loading is retraced."""
    return HEAD + PIECE * int(read_slot(table, LOADING_PIECES)), int(read_slot(table, UNLOADING_PIECES))


@small
def crushed_to(table, deepest):
    """What is remembered of a return at ``deepest`` [m]: it, the set, force over stiffness there, and what is between.

    Beyond the table's end all further penetration under a tabulated way back stays: its length is that of the table.
    """
    top, line = loading(table, deepest), read_slot(table, LINE)
    reach = top / line if line > 0.0 else read_slot(table, SHARE) * min(deepest, read_slot(table, END))
    return deepest, deepest - reach, top, reach


class Tabulated(NamedTuple):
    """Force against penetration from a table, loading and unloading; what is crushed stays, and widens the gap.

    F = L(δ) up to the deepest penetration so far, δ_m; back from there to the set δ_p and in again along the unloading
    curve. L is the monotone cubic through the table's points, linear beyond the last. Unloading retraces L, or follows
    a stiffness K_u: F = K_u (δ − δ_p), δ_p = δ_m − L(δ_m) / K_u; or a column, U from the set to the last point:
    F = L(δ_m) U(x), x = (δ − δ_p) / (δ_m − δ_p), δ_p / δ_m as in the table. No damper: the loop is the loss. The
    stiffness is the table's force over penetration at the last point; another one scales all forces.

    >>> law = Tabulated.of([0.0, 0.01, 0.02], [0.0, 4e5, 5e5], unloading_stiffness=8e7)
    >>> law.force(law.begin(1.0, 0.5, 1e3), 0.02, 0.0, True)
    500000.0
    """

    stiffness: Annotated[float, LINEAR_STIFFNESS]
    table: Table = STRAIGHT

    reference = "the user's table; monotone cubic of Fritsch and Butland (1984)"
    capped, needs_restitution = False, False

    @classmethod
    def of(
        cls,
        penetration: Sequence[float | str],
        force: Sequence[float | str],
        unloading: Sequence[float | str] | None = None,
        unloading_stiffness: float | str | None = None,
    ) -> Tabulated:
        """The law of these points; parameters and faults as of `models.contact.table.table_of`."""
        table = table_of(penetration, force, unloading, unloading_stiffness)
        return cls._make((table.stiffness, table))

    @classmethod
    def from_file(cls, path: str | PathLike[str], unloading_stiffness: float | str | None = None) -> Tabulated:
        """The law of a CSV file with columns such as ``penetration [mm],force [kN],unloading [kN]``.

        Raises TableError with every fault and its line.
        """
        from pounding_risk.models.contact.table_file import read_table

        table = read_table(path, unloading_stiffness)
        return cls._make((table.stiffness, table))

    # The memory of a contact is what `crushed_to` gives; all zero before any return.

    def begin(self, e, speed, mass):
        return 0.0, 0.0, 0.0, 0.0

    def resume(self, memory, damage):
        return crushed_to(self.table, damage) if damage > 0.0 else memory

    def force(self, memory, delta, rate, approaching):
        _, indentation, top, reach = memory
        if delta < reach:
            first, count = unloading_pieces(self.table)
            return self.stiffness * (top * curve_value(self.table, first, count, delta / reach))
        return self.stiffness * loading(self.table, delta + indentation)

    def crushed(self, memory, delta):
        _, indentation, _, reach = memory
        if unloading_pieces(self.table)[1] == 0 or delta <= reach:
            return memory, -1.0, 0.0
        changed = crushed_to(self.table, delta + indentation)
        return changed, max(changed[1] - indentation, 0.0), 0.0

    def knee(self, memory, approaching):
        return memory[3] if approaching and memory[3] > 0.0 else inf

    def damage(self, memory):
        return memory[0]

    plateau = flat

    def stored(self, delta, strength):
        return self.stiffness * loading_energy(self.table, delta)

    def held(self, memory, delta, strength):
        first, count = unloading_pieces(self.table)
        if count == 0:
            return self.stored(delta, strength)
        _, _, top, reach = memory if delta < memory[3] else crushed_to(self.table, delta + memory[1])
        if reach == 0.0:
            return 0.0
        return self.stiffness * (top * reach * curve_energy(self.table, first, count, min(delta / reach, 1.0)))

    def yielded(self, loss):
        return loss

    def conserves(self):
        return unloading_pieces(self.table)[1] == 0

    ceiling, floor = never_yields, may_pull
