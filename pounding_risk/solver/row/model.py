"""A row as its cases are solved: chains, contact points, and its parts as the kernels take them."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import accumulate
from math import inf, nan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.ground import SHARED, Support, accelerations, has_many
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.links import LINK, Link, bodies_of
from pounding_risk.models.structures.mdof import Chain
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.solver.row.layout import RowLayout, body_numbers, cut_out, lay_out
from pounding_risk.solver.row.partition import LEFTWARDS, RIGHTWARDS, Span
from pounding_risk.solver.row.workspace import FIRST


class Part(NamedTuple):
    """Some bodies of a row with the neighbours beside them, as one row of its own."""

    row: RowLayout
    points: slice  # of the whole row's contact points; those to the neighbours too
    watched: NDArray[np.bool_]  # which of these are to the neighbours
    masses: slice  # of the whole row's, the buildings' own
    own_masses: slice  # these in ``row``
    first_dof: int  # of the whole row's that ``row`` begins with
    to_left: int  # contact points to the left neighbour, which come first
    structure: bytes  # the same for equal buildings with equal contact points, on equal grounds
    buildings: slice  # of the whole row's, those in ``row``

    def side(self, point: int) -> int:
        """On which side the neighbour at this contact point stands."""
        return LEFTWARDS if point < self.to_left else RIGHTWARDS

    def under(self, acceleration: Samples) -> Samples:
        """a_g under its buildings, of that under the whole row (n,) or (buildings, n)."""
        return acceleration if acceleration.ndim == 1 else acceleration[self.buildings]


class RowModel:
    """Buildings left to right with the contact points between them, ordered by interface.

    ``supports`` say what a_g is under each of them, where they do not all stand on the same motion, and where ``links``
    join none. At each link stands a point that never touches, behind the contact points of its interface: its distance
    is what the link is stretched by. ``bumpers`` [m] are what bumpers take up of the gap of each interface.
    """

    def __init__(
        self,
        chains: Sequence[Chain],
        points: Sequence[Point],
        supports: Sequence[Support] = (),
        links: Sequence[Link] = (),
        bumpers: Sequence[float] = (),
    ):
        self.chains, self.links = tuple(chains), tuple(sorted(links))
        watched = [
            Point(link.interface, link.left_floor, link.right_floor, LINK, nan, law=link.law) for link in self.links
        ]
        self.points = tuple(sorted([*points, *watched], key=lambda point: point.interface))
        self.is_link = np.array([point.kind == LINK for point in self.points], dtype=bool)
        self.bodies = bodies_of(self.chains, self.links)
        self.bumpers = np.array(bumpers or (0.0,) * (len(self.chains) - 1))
        self.supports = tuple(supports)
        grounds = self.supports or (SHARED,) * len(self.chains)
        self.arrivals = np.array([support.delay for support in grounds])  # s
        self.velocities = np.array([support.velocity for support in grounds])  # m/s, of the ground at t = 0
        self._grounds = [repr((support.factor, support.records)) for support in grounds]
        self.interfaces = np.array([point.interface for point in self.points], dtype=np.int64)
        self.firsts = (0, *accumulate(chain.mass.size for chain in self.chains))  # of each building's masses
        self.bounds = np.searchsorted(self.interfaces, np.arange(len(self.chains)))  # of each interface's points
        kinds: dict[bytes, int] = {}
        self._kinds = [kinds.setdefault(_content(body.chain), len(kinds)) for body in self.bodies]
        of_body = np.array(body_numbers(self.bodies), dtype=np.int64)
        self._body_interfaces = of_body[self.interfaces]
        # Of each interface between two bodies, that of linked buildings with the points between these.
        self.body_bounds = np.searchsorted(self._body_interfaces, np.arange(len(self.bodies)))
        self._rows: dict[tuple[float, bool], RowLayout] = {}
        self._parts: dict[tuple[Span, float, bool], Part] = {}

    @property
    def everything(self) -> Span:
        """Range of all bodies of the row."""
        return Span(0, len(self.bodies) - 1)

    @property
    def is_always_solved(self) -> bool:
        """True where a link of three buildings or more has a law: all are solved together, even if no gap closes.

        The free motion of two that are so linked is that of their runs to the bit; of more it is but for rounding.
        """
        return len(self.chains) > 2 and any(point.law for point in self.points)

    def at_points(self, of_contacts: NDArray[np.float64]) -> NDArray[np.float64]:
        """Forces of the contact points (..., contacts) at all points, with inf at the links."""
        values = np.full((*of_contacts.shape[:-1], len(self.points)), inf)
        values[..., ~self.is_link] = of_contacts
        return values

    def gaps(self, of_interfaces: NDArray[np.float64]) -> NDArray[np.float64]:
        """Gaps of the interfaces [m] (..., interfaces) less their bumpers at all points, with inf at the links."""
        return np.where(self.is_link, inf, (of_interfaces - self.bumpers)[..., self.interfaces])

    def under(self, shared: Samples, own: Sequence[Samples | None] = ()) -> Samples:
        """a_g under its buildings, (n,) or (buildings, n), as `accelerations` gives it.

        Complex where floors move across the row too; only the real part of ``shared`` acts where none does.
        """
        moves_across = any(chain.moves_across for chain in self.chains)
        return accelerations(self.supports, shared if moves_across else shared.real, own)

    def has_many(self, own: Sequence[Samples | None] = ()) -> bool:
        """True where `under` has a row for each building."""
        return has_many(self.supports, own)

    def row(self, dt: float, many: bool = False) -> RowLayout:
        """The whole row for motions sampled every ``dt`` [s], one of each building where ``many``; kept."""
        if (dt, many) not in self._rows:
            grounds = self.arrivals, self.velocities
            layout = lay_out(self.chains, self.points, dt, *grounds, many=many, bodies=self.bodies)
            self._rows[dt, many] = layout
        return self._rows[dt, many]

    def part(self, span: Span, dt: float, many: bool = False) -> Part:
        """These bodies and, on each side, the neighbour beside them; kept for the next time."""
        key = span, dt, many
        if key not in self._parts:
            self._parts[key] = self._made(span, self.row(dt, many))
        return self._parts[key]

    def _made(self, span: Span, layout: RowLayout) -> Part:
        first, last = max(span.first - 1, 0), min(span.last + 1, len(self.bodies) - 1)
        points = slice(int(self.body_bounds[first]), int(self.body_bounds[last]))
        interfaces = self._body_interfaces[points]
        buildings = slice(self.bodies[first].first, self.bodies[last].last + 1)
        masses = slice(self.firsts[self.bodies[span.first].first], self.firsts[self.bodies[span.last].last + 1])
        mass_before = self.firsts[buildings.start]
        meetings = [
            (point.interface - buildings.start, point.left_floor, point.right_floor, point.across)
            for point in self.points[points]
        ]
        return Part(
            cut_out(layout, first, last),
            points,
            (interfaces < span.first) | (interfaces >= span.last),
            masses,
            slice(masses.start - mass_before, masses.stop - mass_before),
            int(layout.row.frame[FIRST, first]),
            int((interfaces < span.first).sum()),
            repr(
                (
                    self._kinds[first : last + 1],
                    meetings,
                    span.first - first,
                    span.last - first,
                    self._grounds[buildings],
                )
            ).encode()
            + self.arrivals[buildings].tobytes()
            + self.velocities[buildings].tobytes(),
            buildings,
        )


def _content(chain: Chain) -> bytes:
    """Every number of a chain; equal for chains that move equally."""
    return b"|".join(np.asarray(value, dtype=float).tobytes() for value in chain)
