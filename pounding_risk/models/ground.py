"""Ground motion of a pair: one motion under both buildings, or a wave that reaches one of them before the other.

`arriving` has the motions of any number of buildings; the types that follow are a pair's, those of a row stand in
`solver.row.ground`.

With a wave the ground itself widens the gap, by w = x_right − x_left with ẅ = a_right − a_left:

    δ = u_left − u_right − w − gap,    each u relative to the ground under its own building.

In flight each building follows its own ground. In contact the right building is followed from the ground under the
left one, y = u_right + w, where a contact is what it is without a wave, and

    ÿ = −q − 2 ζ ω ẏ − ω² y + F / m,    q = a_left − 2 ζ ω ẇ − ω² w    (of a rigid building q = −ẅ).

Both a_g are linear between their own samples, and nodes stand at the samples of both: each a_g is linear between two
nodes, w is a cubic there, and nothing of the solver's exactness is lost.
Which of the two a kernel has is decided by type when it is compiled: without a wave w is the constant zero.
"""

from __future__ import annotations

from math import floor
from typing import NamedTuple, Protocol

import numpy as np

from pounding_risk._jit.compile import borrowed, speaks


@speaks
class GroundInterval(Protocol):
    """The ground motion over a part of one node interval; x is the time since the part's beginning.

    A load is the ground's term in an equation of motion, ü = −load − ..., as the four coefficients of a cubic in x.
    """

    def under_left(self):
        """a_g under the left building: its value at x = 0 [m/s²], its slope [m/s³]."""

    def load_left(self, oscillator):
        """Load of the left building."""

    def load_right(self, oscillator):
        """Load of the right building, followed from its own ground."""

    def load_across(self, oscillator):
        """Load of the right building, followed from the ground under the left one."""

    def left_at(self, x):
        """a_g under the left building [m/s²]."""

    def across_at(self, oscillator, x):
        """Load of the right building at x, followed from the ground under the left one."""

    def widening(self):
        """w as the four coefficients of a cubic in x [m]."""

    def moved(self, x):
        """The relative motion of the two grounds at x: (w, ẇ, ẅ) [m, m/s, m/s²]."""

    def bend(self, length):
        """An upper bound of |ẅ| from x = 0 to ``length`` [m/s²]."""

    def taken_along(self, oscillator, force, speed):
        """Power of the contact force on a rigid right building, which moves with its ground; no energy sum has it."""

    def across(self, oscillator, state, x):
        """A state with the right building relative to the left one's ground, from one relative to its own."""

    def apart(self, oscillator, state, x):
        """The inverse of `across`: each building relative to its own ground."""

    def apart_slopes(self, oscillator, slopes, x, clock):
        """As `apart`, of d(state)/ds with dt = ``clock`` ds."""


@speaks
class Ground(Protocol):
    """The ground motion of a pair, node by node."""

    def stretch(self, ground, step, node, offset):
        """The ground motion after a node, its x counted from ``offset`` after it [s]; ``ground`` is a_g of the left."""

    def widened(self, node):
        """The relative displacement w of the two grounds at a node [m]."""

    def width(self, step, node):
        """Time from a node to the next [s], ``step`` that between two samples."""

    def straight(self, node):
        """How many nodes ahead a_g stays linear; those between have equal widths."""

    def moment(self, step, node):
        """Time of a node [s]."""

    def node_maps(self, maps, node):
        """Maps of both buildings' free vibration over the interval after a node, from those after the first node."""

    def lent(self):
        """A copy whose arrays are borrowed: their references are not counted."""


class UniformInterval(NamedTuple):
    """a_g = ground + slope x under both buildings."""

    ground: float  # m/s²
    slope: float  # m/s³

    def under_left(self):
        return self.ground, self.slope

    def load_left(self, oscillator):
        return oscillator.ground * self.ground, oscillator.ground * self.slope, 0.0, 0.0

    def load_right(self, oscillator):
        return oscillator.ground * self.ground, oscillator.ground * self.slope, 0.0, 0.0

    def load_across(self, oscillator):
        return oscillator.ground * self.ground, oscillator.ground * self.slope, 0.0, 0.0

    def left_at(self, x):
        return self.ground + self.slope * x

    def across_at(self, oscillator, x):
        return oscillator.ground * (self.ground + self.slope * x)

    def widening(self):
        return 0.0, 0.0, 0.0, 0.0

    def moved(self, x):
        return 0.0, 0.0, 0.0

    def bend(self, length):
        return 0.0

    def taken_along(self, oscillator, force, speed):
        return 0.0

    def across(self, oscillator, state, x):
        return state

    def apart(self, oscillator, state, x):
        return state

    def apart_slopes(self, oscillator, slopes, x, clock):
        return slopes


class UniformGround(NamedTuple):
    """The same motion under both buildings at the same time."""

    parts: int = 1  # intervals between nodes that a sample interval is divided into

    def stretch(self, ground, step, node, offset):
        slope = (ground[node + 1] - ground[node]) / step
        return UniformInterval(ground[node] + slope * offset, slope)

    def widened(self, node):
        return 0.0

    def width(self, step, node):
        return step

    def straight(self, node):
        return self.parts - node % self.parts

    def moment(self, step, node):
        return node * step

    def node_maps(self, maps, node):
        return maps

    def lent(self):
        return self


class DelayedInterval(NamedTuple):
    """A ground motion of its own under each building: values at a node, and slopes after it."""

    ground: float  # a_left at the node [m/s²]
    slope: float  # m/s³
    bend_now: float  # ẅ = a_right − a_left at the node [m/s²]
    bend_slope: float  # m/s³
    spread: float  # w at the node [m]
    rate: float  # ẇ [m/s]
    offset: float  # of x = 0 after the node [s]

    def under_left(self):
        return self.ground + self.slope * self.offset, self.slope

    def left_at(self, x):
        return self.ground + self.slope * (x + self.offset)

    def widening(self):
        spread, rate, bend = self.moved(0.0)
        return spread, rate, 0.5 * bend, self.bend_slope / 6.0

    def bend(self, length):
        return max(abs(self.moved(0.0)[2]), abs(self.moved(length)[2]))

    def load_left(self, oscillator):
        return oscillator.ground * self.left_at(0.0), oscillator.ground * self.slope, 0.0, 0.0

    def load_right(self, oscillator):
        ground, slope = self.left_at(0.0) + self.moved(0.0)[2], self.slope + self.bend_slope
        return oscillator.ground * ground, oscillator.ground * slope, 0.0, 0.0

    def load_across(self, oscillator):
        a, b, c, d = self.widening()
        if oscillator.inverse_omega == 0.0:
            return -2.0 * c, -6.0 * d, 0.0, 0.0
        two_zeta_omega, omega2 = oscillator.two_zeta_omega, oscillator.omega2
        return (
            self.left_at(0.0) - two_zeta_omega * b - omega2 * a,
            self.slope - 2.0 * two_zeta_omega * c - omega2 * b,
            -3.0 * two_zeta_omega * d - omega2 * c,
            -omega2 * d,
        )

    def across_at(self, oscillator, x):
        spread, rate, bend = self.moved(x)
        if oscillator.inverse_omega == 0.0:
            return -bend
        return self.left_at(x) - oscillator.two_zeta_omega * rate - oscillator.omega2 * spread

    def moved(self, x):
        now = x + self.offset
        bend = self.bend_now + self.bend_slope * now
        rate = self.rate + now * (self.bend_now + 0.5 * now * self.bend_slope)
        spread = self.spread + now * (self.rate + now * (0.5 * self.bend_now + now * self.bend_slope / 6.0))
        return spread, rate, bend

    def taken_along(self, oscillator, force, speed):
        return force * speed if oscillator.inverse_mass == 0.0 else 0.0

    def across(self, oscillator, state, x):
        spread, rate, _ = self.moved(x)
        return state[0], state[1] + spread, state[2], state[3] + rate

    def apart(self, oscillator, state, x):
        if oscillator.inverse_mass == 0.0:
            return state[0], 0.0, state[2], 0.0
        spread, rate, _ = self.moved(x)
        return state[0], state[1] - spread, state[2], state[3] - rate

    def apart_slopes(self, oscillator, slopes, x, clock):
        if oscillator.inverse_mass == 0.0:
            return slopes[0], 0.0, slopes[2], 0.0
        _, rate, bend = self.moved(x)
        return slopes[0], slopes[1] - clock * rate, slopes[2], slopes[3] - clock * bend


class DelayedGround(NamedTuple):
    """A motion of its own under each building. Even nodes stand at samples, odd ones between, ``first`` after them.

    Arrays with a value at every node, of a_g as it is after the node: what is later begins with a jump where the
    record does not begin with zero.
    """

    first: float  # from an even node to the odd one after it [s]
    maps: tuple  # of both buildings' free vibration from an odd node to the even one after it: 2 x 4 numbers
    left: np.ndarray  # a_left [m/s²]
    left_slope: np.ndarray  # after the node [m/s³]
    right: np.ndarray
    right_slope: np.ndarray
    spread: np.ndarray  # w [m]
    rate: np.ndarray  # ẇ [m/s]

    def stretch(self, ground, step, node, offset):
        bend, twist = self.right[node] - self.left[node], self.right_slope[node] - self.left_slope[node]
        return DelayedInterval(
            self.left[node], self.left_slope[node], bend, twist, self.spread[node], self.rate[node], offset
        )

    def widened(self, node):
        return self.spread[node]

    def width(self, step, node):
        return step - self.first if node % 2 else self.first

    def straight(self, node):
        return 1

    def moment(self, step, node):
        return (node // 2) * step + (self.first if node % 2 else 0.0)

    def node_maps(self, maps, node):
        return self.maps if node % 2 else maps

    def lent(self):
        return DelayedGround(
            self.first,
            self.maps,
            borrowed(self.left),
            borrowed(self.left_slope),
            borrowed(self.right),
            borrowed(self.right_slope),
            borrowed(self.spread),
            borrowed(self.rate),
        )


def delayed(ground: np.ndarray, step: float, lag: float) -> DelayedGround:
    """Both motions where the right building has a_g later by ``lag`` [s], below zero the left one; ``maps`` are zero.

    ``ground`` holds a_g [m/s²] at samples ``step`` [s] apart. The later building is at rest until a_g arrives.
    """
    whole = round(abs(lag) / step)
    if abs(abs(lag) - whole * step) > 1e-9 * step:
        whole = floor(abs(lag) / step)
    part = max(abs(lag) - whole * step, 0.0)
    part = part if part > 1e-9 * step else 0.0
    # With a lag of whole samples any place between two samples serves as the odd node: the middle is taken.
    first = part or 0.5 * step
    slopes = np.diff(ground) / step
    count = slopes.size
    prompt = two_a_sample(ground[:-1], ground[:-1] + slopes * first, ground[-1]), two_a_sample(slopes, slopes, 0.0)
    start = np.concatenate([np.zeros(whole + 1), ground[:-1]])
    slope = np.concatenate([np.zeros(whole + 1), slopes])
    after = slice(1, count + 1)  # the sample that has arrived by an odd node, with a part of a sample at that very node
    if part:
        before = slice(0, count)
        halves = start[before] + slope[before] * (step - part), start[after]
        parts = slope[before], slope[after]
    else:
        halves = start[after], start[after] + slope[after] * first
        parts = slope[after], slope[after]
    late = two_a_sample(*halves, halves[1][-1] + parts[1][-1] * (step - first)), two_a_sample(*parts, 0.0)
    left, right = (prompt, late) if lag >= 0.0 else (late, prompt)
    bend, twist = right[0] - left[0], right[1] - left[1]
    width = two_a_sample(np.full(count, first), np.full(count, step - first), 0.0)
    rate = np.append(0.0, np.cumsum(width * (bend + 0.5 * width * twist))[:-1])
    moves = width * (rate + width * (0.5 * bend + width * twist / 6.0))
    spread = np.append(0.0, np.cumsum(moves)[:-1])
    still = ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
    return DelayedGround(float(first), still, *left, *right, spread, rate)


class Arrivals(NamedTuple):
    """When a motion arrives at each of some buildings, in steps between its samples."""

    whole: np.ndarray  # steps
    part: np.ndarray  # which of ``offsets`` is added
    offsets: np.ndarray  # parts of a step, ascending from zero, each there once [s]

    def of(self, first: int, last: int) -> Arrivals:
        """Those at the buildings ``first`` to ``last``, with the offsets of all."""
        return Arrivals(self.whole[first : last + 1], self.part[first : last + 1], self.offsets)


def arrivals_of(times: np.ndarray, step: float) -> Arrivals:
    """Arrivals at these times [s], none below zero, of a motion sampled every ``step`` [s].

    What is less than 1e-9 of a step from a whole one, or from another part of one, is that one.
    """
    whole = np.floor(times / step + 1e-9)
    left = np.maximum(times - whole * step, 0.0)
    offsets = [0.0]
    for part in np.sort(left).tolist():
        if part - offsets[-1] > 1e-9 * step:
            offsets.append(part)
    parts = np.array(offsets)
    return Arrivals(whole.astype(np.int64), np.abs(left[:, None] - parts).argmin(axis=1), parts)


def arriving(ground: np.ndarray, step: float, arrivals: Arrivals) -> np.ndarray:
    """The motion under each of a row's buildings, where it arrives at each at a time of its own.

    Nodes stand at the samples of all buildings: at every offset of ``arrivals`` after each sample, so that each a_g is
    linear between two of them. A building is at rest until the motion arrives.

    Parameters
    ----------
    ground : numpy.ndarray
        a_g [m/s²] at samples ``step`` apart.
    step : float
        Time between two samples [s].
    arrivals : Arrivals
        Of the motion at each building, left to right.

    Returns
    -------
    numpy.ndarray
        (nodes, buildings, 6), by building: a_g after the node [m/s²], its slope [m/s³], and relative to the ground of
        the left neighbour: ẅ after the node, its slope, w [m] and ẇ [m/s] at it; zero for the first building.
    """
    count, offsets = ground.size - 1, arrivals.offsets
    slopes = np.append(np.diff(ground) / step, 0.0)
    nodes = np.arange(count * offsets.size + 1)
    sample, place = nodes // offsets.size, nodes % offsets.size
    table = np.zeros((nodes.size, arrivals.whole.size, 6))
    for b, (late, own) in enumerate(zip(arrivals.whole, arrivals.part, strict=True)):
        newest = sample - late - (place < own)  # sample that has arrived
        since = np.where(place < own, step - (offsets[own] - offsets[place]), offsets[place] - offsets[own])
        here = newest >= 0
        table[here, b, 0] = ground[newest[here]] + slopes[newest[here]] * since[here]
        table[here, b, 1] = slopes[newest[here]]
    width = np.diff(np.append(offsets, step))[place]
    for b in range(1, arrivals.whole.size):
        bend, twist = (table[:, b, value] - table[:, b - 1, value] for value in (0, 1))
        rate = np.append(0.0, np.cumsum(width * (bend + 0.5 * width * twist))[:-1])
        moves = width * (rate + width * (0.5 * bend + width * twist / 6.0))
        table[:, b, 2], table[:, b, 3] = bend, twist
        table[:, b, 4], table[:, b, 5] = np.append(0.0, np.cumsum(moves)[:-1]), rate
    return table


def two_a_sample(even: np.ndarray, odd: np.ndarray, last: float) -> np.ndarray:
    """Values at even and odd nodes, and at the last one, in one array."""
    return np.append(np.column_stack([even, odd]).ravel(), last)
