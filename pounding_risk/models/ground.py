"""The ground under a pair: one motion under both buildings, or a wave that passes one of them before the other.

With a wave the ground itself widens the gap, by w = x_right − x_left with ẅ = a_right − a_left:

    δ = u_left − u_right − w − gap,    each u relative to the ground under its own building.

In flight each building follows its own ground. In contact the right building is followed from the ground under the
left one, y = u_right + w, where a contact is what it is without a wave, and

    ÿ = −q − 2 ζ ω ẏ − ω² y + F / m,    q = a_left − 2 ζ ω ẇ − ω² w    (of a rigid building q = −ẅ).

Both a_g are linear between their own samples, and nodes stand at the samples of both: each a_g is linear between two
nodes, w is a cubic there, and nothing of the solver's exactness is lost.
Kernels see by the type which of the two there is: without a wave w is a constant zero that compiles to nothing.
"""

from __future__ import annotations

from math import floor
from typing import NamedTuple, Protocol

import numpy as np

from pounding_risk._jit.compile import borrowed, speaks


@speaks
class Stretch(Protocol):
    """The ground over a part of one node interval, x the time since its beginning.

    A push is what stands in an equation of motion, ü = −push − ..., as the four coefficients of a cubic in x.
    """

    def under_left(self):
        """a_g under the left building: its value at x = 0 [m/s²], its slope [m/s³]."""

    def push_left(self, oscillator):
        """Of the left building."""

    def push_right(self, oscillator):
        """Of the right building, followed from its own ground."""

    def push_across(self, oscillator):
        """Of the right building, followed from the ground under the left one."""

    def left_at(self, x):
        """a_g under the left building [m/s²]."""

    def across_at(self, oscillator, x):
        """The push of the right building at x, followed from the ground under the left one."""

    def widening(self):
        """w as the four coefficients of a cubic in x [m]."""

    def moved(self, x):
        """(w, ẇ, ẅ) at x."""

    def bend(self, length):
        """No |ẅ| up to this length is larger [m/s²]."""

    def taken_along(self, oscillator, force, speed):
        """Power that goes into a rigid right building, which its ground moves: no building of the ledger has it."""

    def across(self, oscillator, state, x):
        """A state with the right building seen from the ground under the left one, from one where it is not."""

    def apart(self, oscillator, state, x):
        """A state with each building seen from its own ground, from one where the right building is not."""

    def apart_slopes(self, oscillator, slopes, x, clock):
        """As `apart`, of d(state)/ds with dt = ``clock`` ds."""


@speaks
class Passage(Protocol):
    """How the ground motion comes to the right building."""

    def stretch(self, ground, step, node, offset):
        """The ground on the interval after a node, its x counted from ``offset`` after the node; a_g is the left's."""

    def widened(self, node):
        """w at a node [m]."""

    def width(self, step, node):
        """Time from a node to the next [s], ``step`` that between two samples."""

    def moment(self, step, node):
        """Time of a node [s]."""

    def node_maps(self, maps, node):
        """The maps of both buildings' free vibration over the interval after a node; ``maps`` those after the first."""

    def lent(self):
        """Itself with its arrays' references not counted."""


class Level(NamedTuple):
    """a_g = ground + slope x under both buildings."""

    ground: float  # m/s²
    slope: float  # m/s³

    def under_left(self):
        return self.ground, self.slope

    def push_left(self, oscillator):
        return oscillator.ground * self.ground, oscillator.ground * self.slope, 0.0, 0.0

    def push_right(self, oscillator):
        return oscillator.ground * self.ground, oscillator.ground * self.slope, 0.0, 0.0

    def push_across(self, oscillator):
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


class Together(NamedTuple):
    """The same motion under both buildings at the same time."""

    unused: float = 0.0  # nothing: compiled code cannot call a method of a tuple without a field

    def stretch(self, ground, step, node, offset):
        slope = (ground[node + 1] - ground[node]) / step
        return Level(ground[node] + slope * offset, slope)

    def widened(self, node):
        return 0.0

    def width(self, step, node):
        return step

    def moment(self, step, node):
        return node * step

    def node_maps(self, maps, node):
        return maps

    def lent(self):
        return self


class Rippled(NamedTuple):
    """a_g under each building and w, from the values at a node and the slopes after it."""

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

    def push_left(self, oscillator):
        return oscillator.ground * self.left_at(0.0), oscillator.ground * self.slope, 0.0, 0.0

    def push_right(self, oscillator):
        ground, slope = self.left_at(0.0) + self.moved(0.0)[2], self.slope + self.bend_slope
        return oscillator.ground * ground, oscillator.ground * slope, 0.0, 0.0

    def push_across(self, oscillator):
        a, b, c, d = self.widening()
        if oscillator.inverse_omega == 0.0:
            return -2.0 * c, -6.0 * d, 0.0, 0.0
        fade, spring = oscillator.fade, oscillator.spring
        return (
            self.left_at(0.0) - fade * b - spring * a,
            self.slope - 2.0 * fade * c - spring * b,
            -3.0 * fade * d - spring * c,
            -spring * d,
        )

    def across_at(self, oscillator, x):
        spread, rate, bend = self.moved(x)
        if oscillator.inverse_omega == 0.0:
            return -bend
        return self.left_at(x) - oscillator.fade * rate - oscillator.spring * spread

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


class Passing(NamedTuple):
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
        return Rippled(self.left[node], self.left_slope[node], bend, twist, self.spread[node], self.rate[node], offset)

    def widened(self, node):
        return self.spread[node]

    def width(self, step, node):
        return step - self.first if node % 2 else self.first

    def moment(self, step, node):
        return (node // 2) * step + (self.first if node % 2 else 0.0)

    def node_maps(self, maps, node):
        return self.maps if node % 2 else maps

    def lent(self):
        return Passing(
            self.first,
            self.maps,
            borrowed(self.left),
            borrowed(self.left_slope),
            borrowed(self.right),
            borrowed(self.right_slope),
            borrowed(self.spread),
            borrowed(self.rate),
        )


def delayed(ground: np.ndarray, step: float, lag: float) -> Passing:
    """Both motions where the right building has a_g later by ``lag`` [s], below zero the left one; ``maps`` are empty.

    ``ground`` holds a_g [m/s²] at samples ``step`` [s] apart. Whatever is later is at rest until then.
    """
    whole = round(abs(lag) / step)
    if abs(abs(lag) - whole * step) > 1e-9 * step:
        whole = floor(abs(lag) / step)
    part = max(abs(lag) - whole * step, 0.0)
    part = part if part > 1e-9 * step else 0.0
    # With a lag of whole samples there is nothing to stand between them; the middle is as good as any place.
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
    return Passing(float(first), still, *left, *right, spread, rate)


def two_a_sample(even: np.ndarray, odd: np.ndarray, last: float) -> np.ndarray:
    """Values at even and odd nodes, and at the last one, in one array."""
    return np.append(np.column_stack([even, odd]).ravel(), last)
