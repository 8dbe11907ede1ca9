"""A row as its cases are solved: chains, contact points, and its parts as the kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.effects.wave_passage import WavePassage
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.mdof import Chain
from pounding_risk.solver.row.layout import RowLayout, cut_out, lay_out
from pounding_risk.solver.row.partition import LEFTWARDS, RIGHTWARDS, Span
from pounding_risk.solver.row.workspace import FIRST


class Part(NamedTuple):
    """Some buildings of a row with the neighbours beside them, as one row of its own."""

    row: RowLayout
    points: slice  # of the whole row's contact points; those to the neighbours too
    watched: NDArray[np.bool_]  # which of these are to the neighbours
    masses: slice  # of the whole row's, the buildings' own
    own_masses: slice  # these in ``row``
    first_dof: int  # of the whole row's that ``row`` begins with
    to_left: int  # contact points to the left neighbour, which come first
    structure: bytes  # the same for equal buildings with equal contact points, and times at which a wave arrives

    def side(self, point: int) -> int:
        """On which side the neighbour at this contact point stands."""
        return LEFTWARDS if point < self.to_left else RIGHTWARDS


class RowModel:
    """Buildings left to right with the contact points between them, ordered by interface.

    With a ``wave`` each building has the motion at a time of its own.
    """

    def __init__(self, chains: Sequence[Chain], points: Sequence[Point], wave: WavePassage | None = None):
        self.chains, self.points = tuple(chains), tuple(points)
        self.arrivals = np.zeros(len(self.chains)) if wave is None else wave.arrivals(len(self.chains))  # s
        self.interfaces = np.array([point.interface for point in self.points], dtype=np.int64)
        self.firsts = (0, *accumulate(chain.mass.size for chain in self.chains))  # of each building's masses
        self.bounds = np.searchsorted(self.interfaces, np.arange(len(self.chains)))  # of each interface's points
        kinds: dict[bytes, int] = {}
        self._kinds = [kinds.setdefault(_content(chain), len(kinds)) for chain in self.chains]
        self._rows: dict[float, RowLayout] = {}
        self._parts: dict[tuple[Span, float], Part] = {}

    @property
    def everything(self) -> Span:
        """Range of all buildings of the row."""
        return Span(0, len(self.chains) - 1)

    def row(self, dt: float) -> RowLayout:
        """The whole row for motions sampled every ``dt`` [s]; kept for the next time."""
        if dt not in self._rows:
            self._rows[dt] = lay_out(self.chains, self.points, dt, self.arrivals)
        return self._rows[dt]

    def part(self, span: Span, dt: float) -> Part:
        """These buildings and, on each side, the neighbour beside them; kept for the next time."""
        if (span, dt) not in self._parts:
            self._parts[span, dt] = self._made(span, dt)
        return self._parts[span, dt]

    def _made(self, span: Span, dt: float) -> Part:
        first, last = max(span.first - 1, 0), min(span.last + 1, len(self.chains) - 1)
        points = slice(int(self.bounds[first]), int(self.bounds[last]))
        interfaces = self.interfaces[points]
        masses = slice(self.firsts[span.first], self.firsts[span.last + 1])
        mass_before = self.firsts[first]
        meetings = [(point.interface - first, point.left_floor, point.right_floor) for point in self.points[points]]
        return Part(
            cut_out(self.row(dt), first, last),
            points,
            (interfaces < span.first) | (interfaces >= span.last),
            masses,
            slice(masses.start - mass_before, masses.stop - mass_before),
            int(self.row(dt).row.frame[FIRST, first]),
            int((interfaces < span.first).sum()),
            repr((self._kinds[first : last + 1], meetings, span.first - first, span.last - first)).encode()
            + self.arrivals[first : last + 1].tobytes(),
        )


def _content(chain: Chain) -> bytes:
    """Every number of a chain; equal for chains that move equally."""
    return b"|".join(np.asarray(value, dtype=float).tobytes() for value in chain)
