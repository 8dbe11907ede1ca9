"""Levels of intensity: a measure of a motion, and the motion scaled so that its own measure has a value.

An amplitude of a run is one factor on a motion. Its level says in which measure it is stated:

    >>> import numpy as np
    >>> from pounding_risk.motions.levels import Level, Measure
    >>> from pounding_risk.motions.motion import Motion
    >>> motion = Motion("swell", np.sin(np.arange(0.0, 20.0, 0.01)), 0.01, {})
    >>> Level(Measure("pgv"), 0.3).words
    'PGV = 30 cm/s'
    >>> round(Level(Measure("pgv"), 0.3).of(motion).pga, 3)
    0.15
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import isclose
from typing import Any, NamedTuple

import numpy as np

from pounding_risk.motions import scaling
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.request import REVERSED
from pounding_risk.units import DAMPING, PERIOD, PGA, SCALE, Quantity, QuantityError, exact, parse, say

DIGITS = 6  # of values that a user has stated, so that 0.125 g stays 0.125 g
USUAL_DAMPING = 0.05  # of a spectral acceleration without a stated one
SAME = 1e-5  # relative: two periods, one of which was written with `DIGITS`
PGA_AXIS, LEVEL_AXIS = "pga", "intensity"  # dimension of a dataset whose amplitudes are PGA, and of other measures
FACTOR = "scale"  # the measure that is a factor on the records as they are
# Measures with the quantity that their levels are, and its unit as datasets write it.
SPECTRAL = PGA._replace(words="spectral acceleration")
MEASURES: dict[str, tuple[Quantity, str]] = {
    "pga": (PGA, "m/s2"),
    "pgv": (scaling.PGV, "m/s"),
    "sa": (SPECTRAL, "m/s2"),
    "sa_avg": (SPECTRAL._replace(words="mean spectral acceleration"), "m/s2"),
    FACTOR: (SCALE, "1"),
}
PERIODS = {"sa": "period", "sa_avg": "periods"}  # the key of a scene that has the periods of a measure


class Measure(NamedTuple):
    """A measure of the intensity of a motion, one of `MEASURES`."""

    name: str = "pga"
    periods: tuple[float, ...] = ()  # s: that of "sa", both ends of the range of "sa_avg"
    damping: float = USUAL_DAMPING
    shares: tuple[float, ...] = ()  # the periods over the first period of a building, where they are relative to it
    building: str = ""  # the name of that building

    def at_period(self, period: float) -> Measure:
        """The measure with its relative periods at the first period of their building [s]."""
        return self._replace(periods=tuple(share * period for share in self.shares))

    @property
    def relation(self) -> str:
        """What the periods are relative to, "0.2 T to 1.5 T, T the first period of frame"; "" where they are stated."""
        ends = " to ".join(f"{share:.{DIGITS}g} T" for share in self.shares)
        return f"{ends}, T the first period of {self.building}" if ends else ""

    @property
    def period(self) -> float:
        """The period of Sa [s]."""
        return self.periods[0]

    @property
    def quantity(self) -> Quantity:
        """The quantity, with unit and bounds, that its levels are values of."""
        return MEASURES[self.name][0]

    @property
    def unit(self) -> str:
        """Its SI unit as datasets write it."""
        return MEASURES[self.name][1]

    @property
    def axis(self) -> str:
        """The dimension of its levels in a dataset."""
        return PGA_AXIS if self.name == "pga" else LEVEL_AXIS

    @property
    def intensity(self) -> str:
        """The word that an assessment takes: "pga", "sa(0.5 s)", "sa(0.5 s, 2 %)", "sa_avg(0.2-2 s)"."""
        return f"{self.name}({self._at(DIGITS)})" if self.periods else self.name

    @property
    def words(self) -> str:
        """The name in sentences: "PGA", "Sa(0.5 s)", "Sa_avg(0.2-2 s)", "factor".

        Periods that nobody wrote, those of buildings, are rounded: "Sa(0.55 s)" of 0.550208 s.
        """
        if self.periods:
            is_short = all(isclose(float(f"{period:.4g}"), period, rel_tol=1e-9) for period in self.periods)
            return f"{self.name.capitalize()}({self._at(DIGITS if is_short else 3)})"
        return "factor" if self.name == FACTOR else self.name.upper()

    @property
    def long_name(self) -> str:
        """What the levels of a dataset are."""
        at = f", damping {100.0 * self.damping:.{DIGITS}g} %"
        at = f" ({self.relation}){at}" if self.shares else at
        ends = " to ".join(f"{period:.{DIGITS}g} s" for period in self.periods)
        return {
            "pga": "peak ground acceleration",
            "pgv": "peak ground velocity that each motion is scaled to",
            "sa": f"pseudo-spectral acceleration at {ends}{at}, that each motion is scaled to",
            "sa_avg": (
                f"geometric mean of the pseudo-spectral acceleration at {scaling.MEAN_PERIODS} periods from {ends}"
                f"{at}, that each motion is scaled to"
            ),
            FACTOR: "factor on each motion",
        }[self.name]

    def _at(self, digits: int) -> str:
        """Periods, and the damping where it is not the usual one: "0.5 s", "0.5 s, 2 %"."""
        periods = "-".join(f"{period:.{digits}g}" for period in self.periods)
        usual = isclose(self.damping, USUAL_DAMPING, rel_tol=1e-9)
        return f"{periods} s" + ("" if usual else f", {100.0 * self.damping:.{DIGITS}g} %")

    def is_same(self, other: Measure) -> bool:
        """True where both are the same measure at the same periods and damping."""
        if self.name != other.name or len(self.periods) != len(other.periods):
            return False
        numbers = [(*measure.periods, measure.damping) if measure.periods else () for measure in (self, other)]
        return all(isclose(one, another, rel_tol=SAME) for one, another in zip(*numbers, strict=True))

    def of(self, motions: Sequence[Motion]) -> Samples:
        """The value of each motion [SI], in its record and not in a tail of zeros; 1 of the factor."""
        if self.name == "pga":
            return np.array([motion.pga for motion in motions])
        if self.name == FACTOR:
            return np.ones(len(motions))
        records = [motion.without_tail() for motion in motions]
        if self.name == "pgv":
            return scaling.peak_velocities(records)
        if self.name == "sa":
            return scaling.spectral_accelerations(records, list(self.periods), self.damping)[:, 0]
        return scaling.mean_spectral_accelerations(records, self.periods, self.damping)

    def written(self) -> dict[str, Any]:
        """The measure as a table of a scene file has it."""
        table: dict[str, Any] = {"measure": self.name}
        if self.name in PERIODS:
            relative: list[Any] = [f"{share!r} T" for share in self.shares]
            periods = relative or [exact(period, PERIOD) for period in self.periods]
            table[PERIODS[self.name]] = periods[0] if self.name == "sa" else periods
            table |= {"of": self.building} if relative else {}
            table["damping"] = exact(self.damping, DAMPING)
        return table


class Level(NamedTuple):
    """A value of a measure: the amplitude of a run."""

    measure: Measure
    value: float  # SI

    def of(self, motion: Motion) -> Motion:
        """The motion times the factor with which its measure has this value; raises RecordError where none does it."""
        (name, periods, damping, *_), amplitude = self.measure, self.value
        if name == "pga":
            return motion.scaled_to(amplitude)
        if name == FACTOR:
            return scaling.by_factor(motion, amplitude)
        factor, aim = scaling.factor_to(motion.without_tail(), name, amplitude, periods, damping)
        return scaling.by_factor(motion, factor, aim)

    @property
    def words(self) -> str:
        """The level in a sentence: "Sa(0.5 s) = 0.4 g"."""
        return f"{self.measure.words} = {say_level(self.value, self.measure.quantity)}"


PEAK = Measure()


def sa_at(period: float, damping: float = USUAL_DAMPING) -> Measure:
    """The spectral acceleration at a period [s]."""
    return Measure("sa", (period,), damping)


def at_pga(pga: float | None) -> Level | None:
    """The level of a peak ground acceleration [m/s²]; None keeps the amplitude."""
    return None if pga is None else Level(PEAK, pga)


def driven(motion: Motion, polarity: str, level: Level | None) -> Motion:
    """A motion in one polarity, scaled to one level of the grid; ``level`` None keeps the amplitude."""
    turned = motion.reversed() if polarity == REVERSED else motion
    return turned if level is None else level.of(turned)


def say_level(level: float, quantity: Quantity, digits: int = DIGITS) -> str:
    """A level [SI] with its unit as the trade writes it: velocities of the ground in cm/s."""
    return f"{100.0 * level:.{digits}g} cm/s" if quantity == scaling.PGV else say(level, quantity, digits)


def read_measure(text: str) -> Measure | None:
    """The measure of a word, "pga", "pgv", "scale", "sa(0.5 s)" or "sa_avg(0.2-2 s, 2 %)"; None of another word."""
    if text in MEASURES and text not in PERIODS:
        return Measure(text)
    match = re.fullmatch(r"(sa|sa_avg)\(([^,()]+)(?:,([^,()]+))?\)", text)
    if match is None:
        return None
    periods = [match[2]] if match[1] == "sa" else re.split(r"\s+to\s+|(?<![eE])-", match[2])
    try:
        *first, last = (period.strip() for period in periods)
        unit = last.lstrip("0123456789.eE+- ")
        ends = [parse(period if re.search(r"[a-zµ]\s*$", period) else f"{period} {unit}", PERIOD) for period in first]
        ends.append(parse(last, PERIOD))
        damping = parse(match[3].strip(), DAMPING) if match[3] else USUAL_DAMPING
    except QuantityError:
        return None
    if len(ends) != (1 if match[1] == "sa" else 2) or ends != sorted(set(ends)):
        return None
    return Measure(match[1], tuple(ends), damping)


def read_sa(text: str) -> Measure | None:
    """The spectral acceleration of a word such as "sa(0.5 s, 2 %)"; None of another word."""
    measure = read_measure(text)
    return measure if measure is not None and measure.name == "sa" else None
