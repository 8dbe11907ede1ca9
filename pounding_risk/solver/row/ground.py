"""Ground motion of a row: one motion under all buildings, or one of its own under each, at a time of its own.

On grounds of their own every building moves relative to the ground under itself, and has one more dof, the last of its
own: the displacement w of its ground relative to that of its left neighbour. w has no mass, spring or damper; ẅ is
given, linear between two nodes, so that w is a cubic there and known without error. A contact point has a share of −1
of the w of its right building, and what is asked of a point (distance, closing speed, series, polynomial of a step)
then counts the ground's part like that of any floor:

    δ = u_left − u_right − w − gap.

Where floors move across the row as well, one motion with two components acts under all buildings, as the complex number
a_along + i a_across; its imaginary part is read only where `RowPassage.components` is 2.

Which of the three a row has follows from the type, as for a pair (`models.ground`): kernels are compiled for each, and
those of one ground know nothing of w, nor of a second component.
"""

from __future__ import annotations

from typing import NamedTuple, Protocol

import numpy as np

from pounding_risk._jit.compile import small, speaks
from pounding_risk.models.ground import Arrivals, arriving

# Columns of `ArrivingRowGround.table`.
PULL, RISE, BEND, TWIST, SPREAD, RATE = range(6)


@speaks
class RowPassage(Protocol):
    """How a row's dofs and contact points count the ground; a field of `workspace.Row`."""

    def point_ends(self):
        """How many dofs a contact point may lie on: two of either building, and that of the right one's ground."""

    def ground_dofs(self):
        """How many dofs of each building are its ground's: 1 with a passing wave, else 0."""

    def components(self):
        """How many components of ground motion act: 1 along the row, or 2."""

    def map_loads(self, pull, rise):
        """What the last columns of a building's map are multiplied with: a_g [m/s²] and slope of each component."""


@speaks
class RowGround(Protocol):
    """The ground motion of a row, node by node."""

    def node_count(self):
        """Number of nodes of the record, its first and last included; there is one interval less."""

    def node_time(self, step, node):
        """Time of node number ``node`` from the start of the record [s]; ``step`` [s] is that between two samples."""

    def node_width(self, step, node):
        """Time from node number ``node`` to the next [s]; ``step`` [s] is that between two samples."""

    def from_node(self, step, node):
        """The ground motion after a node, its x counted from there."""


@speaks
class RowInterval(Protocol):
    """The ground motion over a part of one node interval; x is the time since the part's beginning."""

    def under(self, b):
        """a_g under building ``b``: its value at x = 0 [m/s²], its slope [m/s³]; complex of two components."""

    def later(self, x):
        """The same motion with its x counted from ``x`` [s] on."""

    def largest_pull(self, first, last):
        """The largest |a_g| under these buildings at x = 0 [m/s²]."""

    def ground_moves(self, b):
        """w of building ``b`` as (w, ẇ, ẅ, slope of ẅ) at x = 0."""

    def ground_ends(self, b):
        """(w, ẇ) of building ``b`` at the end of the node interval."""

    def ground_curves(self, b, length):
        """An upper bound of |ẅ| of building ``b`` from x = 0 to ``length`` [m/s²]."""

    def map_number(self):
        """Which of a building's maps leads over the node interval."""


class UniformRow(NamedTuple):
    """All buildings stand on one ground motion."""

    unused: float = 0.0  # compiled code cannot call a method of a tuple without a field

    def point_ends(self):
        return 4

    def ground_dofs(self):
        return 0

    def components(self):
        return 1

    def map_loads(self, pull, rise):
        return pull, rise


class PlaneRow(NamedTuple):
    """All buildings stand on one ground motion along and across the row."""

    unused: float = 0.0

    def point_ends(self):
        return 4

    def ground_dofs(self):
        return 0

    def components(self):
        return 2

    def map_loads(self, pull, rise):
        return pull.real, rise.real, pull.imag, rise.imag


class ArrivingRow(NamedTuple):
    """Every building has a ground motion of its own."""

    unused: float = 0.0

    def point_ends(self):
        return 5

    def ground_dofs(self):
        return 1

    def components(self):
        return 1

    def map_loads(self, pull, rise):
        return pull, rise


class UniformRowInterval(NamedTuple):
    """a_g = pull + rise x under all buildings."""

    pull: float  # m/s²
    rise: float  # m/s³

    def under(self, b):
        return self.pull, self.rise

    def later(self, x):
        return UniformRowInterval(self.pull + self.rise * x, self.rise)

    def largest_pull(self, first, last):
        return abs(self.pull)

    def ground_moves(self, b):
        return 0.0, 0.0, 0.0, 0.0

    def ground_ends(self, b):
        return 0.0, 0.0

    def ground_curves(self, b, length):
        return 0.0

    def map_number(self):
        return 0


class UniformRowGround(NamedTuple):
    """The same motion under all buildings at the same time: a_g at the nodes [m/s²]."""

    acceleration: np.ndarray

    def node_count(self):
        return self.acceleration.size

    def node_time(self, step, node):
        return node * step

    def node_width(self, step, node):
        return step

    def from_node(self, step, node):
        ground = self.acceleration
        return UniformRowInterval(ground[node], (ground[node + 1] - ground[node]) / step)


class PlaneRowInterval(NamedTuple):
    """a_g = pull + rise x under all buildings, along the row and across it."""

    pull: float  # m/s²
    rise: float  # m/s³
    pull_across: float
    rise_across: float

    def under(self, b):
        return complex(self.pull, self.pull_across), complex(self.rise, self.rise_across)

    def later(self, x):
        return PlaneRowInterval(
            self.pull + self.rise * x, self.rise, self.pull_across + self.rise_across * x, self.rise_across
        )

    def largest_pull(self, first, last):
        return max(abs(self.pull), abs(self.pull_across))

    def ground_moves(self, b):
        return 0.0, 0.0, 0.0, 0.0

    def ground_ends(self, b):
        return 0.0, 0.0

    def ground_curves(self, b, length):
        return 0.0

    def map_number(self):
        return 0


class PlaneRowGround(NamedTuple):
    """The same motion along and across the row under all buildings at the same time: a_g at the nodes [m/s²]."""

    acceleration: np.ndarray
    acceleration_across: np.ndarray

    def node_count(self):
        return self.acceleration.size

    def node_time(self, step, node):
        return node * step

    def node_width(self, step, node):
        return step

    def from_node(self, step, node):
        along, across = self.acceleration, self.acceleration_across
        return PlaneRowInterval(
            along[node], (along[node + 1] - along[node]) / step, across[node], (across[node + 1] - across[node]) / step
        )


class ArrivingRowInterval(NamedTuple):
    """A ground motion of its own under each building."""

    table: np.ndarray  # as `models.ground.arriving` makes it
    node: int
    phase: int  # which of the nodes after a sample
    offset: float  # of x = 0 after the node [s]

    def under(self, b):
        rise = self.table[self.node, b, RISE]
        return self.table[self.node, b, PULL] + rise * self.offset, rise

    def later(self, x):
        return ArrivingRowInterval(self.table, self.node, self.phase, self.offset + x)

    def largest_pull(self, first, last):
        largest = 0.0
        for b in range(first, last + 1):
            largest = max(largest, abs(self.table[self.node, b, PULL] + self.table[self.node, b, RISE] * self.offset))
        return largest

    def ground_moves(self, b):
        x, bend, twist = self.offset, self.table[self.node, b, BEND], self.table[self.node, b, TWIST]
        spread, rate = self.table[self.node, b, SPREAD], self.table[self.node, b, RATE]
        return (
            spread + x * (rate + x * (0.5 * bend + x * twist / 6.0)),
            rate + x * (bend + 0.5 * x * twist),
            bend + twist * x,
            twist,
        )

    def ground_ends(self, b):
        return self.table[self.node + 1, b, SPREAD], self.table[self.node + 1, b, RATE]

    def ground_curves(self, b, length):
        bend, twist = self.table[self.node, b, BEND], self.table[self.node, b, TWIST]
        return max(abs(bend + twist * self.offset), abs(bend + twist * (self.offset + length)))

    def map_number(self):
        return self.phase


class ArrivingRowGround(NamedTuple):
    """A motion of its own under each building, as `models.ground.arriving` has it."""

    table: np.ndarray
    offsets: np.ndarray  # of the nodes after each sample [s]

    def node_count(self):
        return self.table.shape[0]

    def node_time(self, step, node):
        return (node // self.offsets.size) * step + self.offsets[node % self.offsets.size]

    def node_width(self, step, node):
        phase = node % self.offsets.size
        return (self.offsets[phase + 1] if phase + 1 < self.offsets.size else step) - self.offsets[phase]

    def from_node(self, step, node):
        return ArrivingRowInterval(self.table, node, node % self.offsets.size, 0.0)


@small
def window_at(ground, step, node):
    """(time of a node, width of the interval after it, ground motion there); ``step`` is that between two samples."""
    return ground.node_time(step, node), ground.node_width(step, node), ground.from_node(step, node)


def row_ground(
    ground: np.ndarray, step: float, arrivals: Arrivals | None
) -> UniformRowGround | PlaneRowGround | ArrivingRowGround:
    """Ground motion of a row from a_g [m/s²] at nodes ``step`` [s] apart; without ``arrivals`` all stand on one."""
    if np.iscomplexobj(ground):
        return PlaneRowGround(ground.real.copy(), ground.imag.copy())
    if arrivals is None:
        return UniformRowGround(ground)
    return ArrivingRowGround(arriving(ground, step, arrivals), arrivals.offsets)
