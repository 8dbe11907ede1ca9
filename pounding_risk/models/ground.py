"""Ground motion under buildings: one motion under all, or one of its own under each.

`Support` says what a building stands on, `accelerations` gives a_g under each. `arriving` has the motions of any number
of buildings as a table; the types that follow are a pair's, those of a row stand in `solver.row.ground`. A wave that
reaches one building before the other is the case of unlike delays.

Unlike grounds widen the gap themselves, by w = x_right − x_left with ẅ = a_right − a_left:

    δ = u_left − u_right − w − gap,    each u relative to the ground under its own building.

In flight each building follows its own ground. In contact the right building is followed from the ground under the
left one, y = u_right + w, where a contact is what it is without a wave, and

    ÿ = −q − 2 ζ ω ẏ − ω² y + F / m,    q = a_left − 2 ζ ω ẇ − ω² w    (of a rigid building q = −ẅ).

Both a_g are linear between their own samples, and nodes stand at the samples of both: each a_g is linear between two
nodes, w is a cubic there, and nothing of the solver's exactness is lost.
Which of the two a kernel has is decided by type when it is compiled: on one ground w is the constant zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor
from typing import NamedTuple, Protocol

import numpy as np

from pounding_risk._jit.compile import speaks, uncounted


class Support(NamedTuple):
    """What a building stands on: a_g(t) = factor × record(t − delay), zero before the delay, and ẋ(0) = velocity.

    Displacements of the ground count from where it is at t = 0. Delays count from the building that is reached first.
    """

    factor: float = 1.0  # −1 reverses the record, 0 is ground that has no acceleration
    delay: float = 0.0  # s
    velocity: float = 0.0  # m/s, of the ground at t = 0
    records: tuple[str, ...] = ()  # its own, one for all records of a scene or one for each; none: the scene's


SHARED = Support()  # the records of the scene, as they are


def has_many(supports: Sequence[Support], own: Sequence[np.ndarray | None] = ()) -> bool:
    """True where buildings have other samples of a_g than their neighbours; ``own`` as in `accelerations`."""
    return len({support.factor for support in supports}) > 1 or any(samples is not None for samples in own)


def accelerations(supports: Sequence[Support], shared: np.ndarray, own: Sequence[np.ndarray | None] = ()) -> np.ndarray:
    """a_g under the buildings without their delays.

    Parameters
    ----------
    supports : sequence of Support
        By building, left to right; none where all stand on ``shared`` as it is.
    shared : numpy.ndarray
        Samples of the motion of the scene (n,) [m/s²].
    own : sequence of numpy.ndarray or None
        Samples of the records that buildings stand on in its place, at the same times; None, or no sequence, where a
        building stands on ``shared``.

    Returns
    -------
    numpy.ndarray
        (n,) where all buildings have the same samples, otherwise (buildings, n) [m/s²].
    """
    if not has_many(supports, own):
        factor = supports[0].factor if supports else 1.0
        return shared if factor == 1.0 else factor * shared
    samples = own or (None,) * len(supports)
    pairs = zip(supports, samples, strict=True)
    return np.array([support.factor * (shared if each is None else each) for support, each in pairs])


def is_apart(supports: Sequence[Support], acceleration: np.ndarray) -> bool:
    """True where the ground moves between buildings, from the samples that `accelerations` gives."""
    return acceleration.ndim == 2 or len({(support.delay, support.velocity) for support in supports}) > 1


def divided(samples: np.ndarray, parts: int) -> np.ndarray:
    """Samples (n,) or (buildings, n) with every interval between two divided into ``parts``, on straight lines.

    What is not finite is NaN, and so is what lies beside it.
    """
    known = np.where(np.isfinite(samples), samples, np.nan)
    if known.ndim == 2:
        return np.array([divided(row, parts) for row in known])
    count = (known.size - 1) * parts + 1
    return np.interp(np.arange(count) / parts, np.arange(known.size), known)


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

    def from_own_ground(self, oscillator, state, x):
        """The inverse of `across`: each building relative to its own ground."""

    def slopes_from_own_ground(self, oscillator, slopes, x, clock):
        """As `from_own_ground`, of d(state)/ds with dt = ``clock`` ds."""


@speaks
class Ground(Protocol):
    """The ground motion of a pair, node by node."""

    def interval(self, ground, step, node, offset):
        """The ground motion after a node, its x counted from ``offset`` after it [s]; ``ground`` is a_g of the left."""

    def widened(self, node):
        """The relative displacement w of the two grounds at a node [m]."""

    def width(self, step, node):
        """Time from a node to the next [s], ``step`` that between two samples."""

    def straight(self, node):
        """How many nodes ahead a_g stays linear; those between have equal widths."""

    def moment(self, step, node):
        """Time of a node, or of an array of nodes [s]."""

    def node_maps(self, maps, node):
        """Maps of both buildings' free vibration over the interval after a node, from those after the first node."""

    def uncounted(self):
        """A copy whose arrays' references are not counted."""


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

    def from_own_ground(self, oscillator, state, x):
        return state

    def slopes_from_own_ground(self, oscillator, slopes, x, clock):
        return slopes


class UniformGround(NamedTuple):
    """The same motion under both buildings at the same time."""

    parts: int = 1  # intervals between nodes that a sample interval is divided into

    def interval(self, ground, step, node, offset):
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

    def uncounted(self):
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

    def from_own_ground(self, oscillator, state, x):
        if oscillator.inverse_mass == 0.0:
            return state[0], 0.0, state[2], 0.0
        spread, rate, _ = self.moved(x)
        return state[0], state[1] - spread, state[2], state[3] - rate

    def slopes_from_own_ground(self, oscillator, slopes, x, clock):
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

    def interval(self, ground, step, node, offset):
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
        return (node // 2) * step + (node % 2) * self.first

    def node_maps(self, maps, node):
        return self.maps if node % 2 else maps

    def uncounted(self):
        return DelayedGround(
            self.first,
            self.maps,
            uncounted(self.left),
            uncounted(self.left_slope),
            uncounted(self.right),
            uncounted(self.right_slope),
            uncounted(self.spread),
            uncounted(self.rate),
        )


def delayed(ground: np.ndarray, step: float, lag: float, rate: float = 0.0) -> DelayedGround:
    """Both motions where the right building has a_g later by ``lag`` [s], below zero the left one; ``maps`` are zero.

    ``ground`` holds a_g [m/s²] at samples ``step`` [s] apart, (n,) of both or (2, n) of each. The ground under the
    later building has no acceleration until a_g arrives. ``rate`` is ẇ at t = 0 [m/s].
    """
    whole = round(abs(lag) / step)
    if abs(abs(lag) - whole * step) > 1e-9 * step:
        whole = floor(abs(lag) / step)
    part = max(abs(lag) - whole * step, 0.0)
    part = part if part > 1e-9 * step else 0.0
    # With a lag of whole samples any place between two samples serves as the odd node: the middle is taken.
    first = part or 0.5 * step
    both = np.broadcast_to(ground, (2, ground.shape[-1]))
    early, later = both if lag >= 0.0 else both[::-1]
    slopes = np.diff(early) / step
    count = slopes.size
    prompt = two_a_sample(early[:-1], early[:-1] + slopes * first, early[-1]), two_a_sample(slopes, slopes, 0.0)
    slopes = np.diff(later) / step
    start = np.concatenate([np.zeros(whole + 1), later[:-1]])
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
    spread, rates = summed(width, bend, twist, rate)
    still = ((0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0))
    return DelayedGround(float(first), still, *left, *right, spread, rates)


def summed(width: np.ndarray, bend: np.ndarray, twist: np.ndarray, rate: float) -> tuple[np.ndarray, np.ndarray]:
    """Displacement and velocity at every node, from zero and ``rate``.

    ``bend`` is the acceleration after a node, ``twist`` its slope, ``width`` the time to the next node.
    """
    rates = np.append(0.0, np.cumsum(width * (bend + 0.5 * width * twist))[:-1])
    rates = rates + rate if rate else rates
    moves = width * (rates + width * (0.5 * bend + width * twist / 6.0))
    return np.append(0.0, np.cumsum(moves)[:-1]), rates


class Arrivals(NamedTuple):
    """When a_g arrives under each of some buildings, in steps between its samples, and how the ground moves before."""

    whole: np.ndarray  # steps
    part: np.ndarray  # which of ``offsets`` is added
    offsets: np.ndarray  # parts of a step, ascending from zero, each there once [s]
    velocities: np.ndarray  # of the ground at t = 0 [m/s]

    def of(self, first: int, last: int) -> Arrivals:
        """Those at the buildings ``first`` to ``last``, with the offsets of all."""
        here = slice(first, last + 1)
        return Arrivals(self.whole[here], self.part[here], self.offsets, self.velocities[here])


def arrivals_of(times: np.ndarray, step: float, velocities: np.ndarray | None = None) -> Arrivals:
    """Arrivals at these times [s], none below zero, of motions sampled every ``step`` [s].

    What is less than 1e-9 of a step from a whole one, or from another part of one, is that one. ``velocities`` [m/s]
    are those of the ground at t = 0, without them zero.
    """
    whole = np.floor(times / step + 1e-9)
    left = np.maximum(times - whole * step, 0.0)
    offsets = [0.0]
    for part in np.sort(left).tolist():
        if part - offsets[-1] > 1e-9 * step:
            offsets.append(part)
    parts = np.array(offsets)
    velocities = np.zeros(times.size) if velocities is None else velocities
    return Arrivals(whole.astype(np.int64), np.abs(left[:, None] - parts).argmin(axis=1), parts, velocities)


def arriving(ground: np.ndarray, step: float, arrivals: Arrivals) -> np.ndarray:
    """The motion under each of a row's buildings, which may arrive at each at a time of its own.

    Nodes stand at the samples of all buildings: at every offset of ``arrivals`` after each sample, so that each a_g is
    linear between two of them. The ground under a building has no acceleration until a_g arrives.

    Parameters
    ----------
    ground : numpy.ndarray
        a_g [m/s²] at samples ``step`` apart, (n,) of all buildings or (buildings, n) of each.
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
    count, offsets = ground.shape[-1] - 1, arrivals.offsets
    grounds = np.broadcast_to(ground, (arrivals.whole.size, count + 1))
    slopes = np.pad(np.diff(grounds, axis=1) / step, ((0, 0), (0, 1)))
    nodes = np.arange(count * offsets.size + 1)
    sample, place = nodes // offsets.size, nodes % offsets.size
    table = np.zeros((nodes.size, arrivals.whole.size, 6))
    for b, (late, own) in enumerate(zip(arrivals.whole, arrivals.part, strict=True)):
        newest = sample - late - (place < own)  # sample that has arrived
        since = np.where(place < own, step - (offsets[own] - offsets[place]), offsets[place] - offsets[own])
        here = newest >= 0
        table[here, b, 0] = grounds[b, newest[here]] + slopes[b, newest[here]] * since[here]
        table[here, b, 1] = slopes[b, newest[here]]
    width = np.diff(np.append(offsets, step))[place]
    for b in range(1, arrivals.whole.size):
        bend, twist = (table[:, b, value] - table[:, b - 1, value] for value in (0, 1))
        rate = float(arrivals.velocities[b] - arrivals.velocities[b - 1])
        table[:, b, 2], table[:, b, 3] = bend, twist
        table[:, b, 4], table[:, b, 5] = summed(width, bend, twist, rate)
    return table


def two_a_sample(even: np.ndarray, odd: np.ndarray, last: float) -> np.ndarray:
    """Values at even and odd nodes, and at the last one, in one array."""
    return np.append(np.column_stack([even, odd]).ravel(), last)
