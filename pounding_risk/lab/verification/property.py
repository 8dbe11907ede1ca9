"""A published relation without a single number to hit, and how far ours keeps it: its readings and its figure."""

from __future__ import annotations

import re
from math import isinf, isnan
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

HOLDS, FAILS = "holds", "fails"
TINY = 1e-4
LINE, POINTS, BAND = "line", "points", "band"


class Reading(NamedTuple):
    """One number of ours beside that of the relation, and the bounds within which it must lie."""

    quantity: str
    expected: float  # NaN where the relation says no more than the bounds
    ours: float  # in the same unit
    low: float
    high: float
    unit: str  # of all four, "" for shares and numbers
    reason: str  # where the bounds come from

    @property
    def holds(self) -> bool:
        """True where ours lies within the bounds."""
        return bool(self.low <= self.ours <= self.high)

    @property
    def word(self) -> str:
        """The same as a word."""
        return HOLDS if self.holds else FAILS


class Series(NamedTuple):
    """What a panel draws: a line, points with their bounds, or a band."""

    label: str
    x: NDArray[np.float64]
    y: NDArray[np.float64]
    look: str = LINE
    low: NDArray[np.float64] | None = None
    high: NDArray[np.float64] | None = None


class Panel(NamedTuple):
    """A panel of a property's figure."""

    axes: tuple[str, str]
    series: tuple[Series, ...]
    title: str = ""


class Property(NamedTuple):
    """A published relation, our readings of it, and what its figure draws."""

    name: str
    title: str
    source: str
    citation: str
    url: str
    basis: str  # one of `case.BASES`
    known: str
    relation: str  # what is published, in words
    readings: tuple[Reading, ...]
    finding: str  # where every reading holds
    condition: str
    panels: tuple[Panel, ...]

    @property
    def holds(self) -> bool:
        """True where every reading lies within its bounds."""
        return all(reading.holds for reading in self.readings)

    @property
    def word(self) -> str:
        """The same as a word."""
        return HOLDS if self.holds else FAILS

    @property
    def headline(self) -> str:
        """The finding where every reading holds; else how many do not."""
        failing, of = sum(not reading.holds for reading in self.readings), len(self.readings)
        return f"{failing} of {of} readings are out of bounds: {self.title}" if failing else self.finding


def near(quantity: str, expected: float, ours: float, reach: float, reason: str, unit: str = "") -> Reading:
    """A reading that must lie within ``reach`` of what the relation gives."""
    return Reading(quantity, expected, float(ours), expected - reach, expected + reach, unit, reason)


def rounded(value: float) -> str:
    """A number with six digits, a tiny one with two; nothing for NaN."""
    if isnan(value):
        return ""
    return f"{value:.6g}" if value == 0.0 or abs(value) >= TINY else f"{value:.1e}"


def bounds(reading: Reading) -> str:
    """The bounds of a reading in words."""
    low, high, expected = reading.low, reading.high, reading.expected
    unit = f" {reading.unit}" if reading.unit else ""
    if low == high:
        return f"exactly {rounded(low)}{unit}"
    if isinf(low) or isinf(high):
        return f"{'at most' if isinf(low) else 'at least'} {rounded(high if isinf(low) else low)}{unit}"
    reach = 0.5 * (high - low)
    if abs(0.5 * (high + low) - expected) < 1e-6 * reach and reach < 1e-3 * abs(expected):
        return f"{rounded(expected)} ± {reach:.1g}{unit}"
    low_words, high_words = (f"{end:.4g}" if abs(end) >= TINY or end == 0.0 else f"{end:.1g}" for end in (low, high))
    return f"{low_words} to {high_words}{unit}"


def plain(text: str) -> str:
    """A finding without the marks of mathematics that figures read."""
    return re.sub(r"\$([^$]*)\$", lambda formula: re.sub(r"[_{}]", "", formula[1]), text)


def series(label: str, x: Any, y: Any, look: str = LINE, bounds: tuple[Any, Any] | None = None) -> Series:
    """A series from sequences; ``bounds`` are the low and the high ends."""
    low, high = (None, None) if bounds is None else (np.asarray(end, dtype=float) for end in bounds)
    return Series(label, np.asarray(x, dtype=float), np.asarray(y, dtype=float), look, low, high)
