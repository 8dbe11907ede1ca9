"""Intensities by their names, in words and with their units, and the amplitudes of a grid.

The amplitudes of a grid are its axis ``pga``, or ``intensity`` for levels of another measure (`opened.Results`).
"""

from __future__ import annotations

from math import isclose
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import (
    DIGITS,
    PEAK,
    PGA_AXIS,
    USUAL_DAMPING,
    Measure,
    at_words,
    read_measure,
    say_level,
)
from pounding_risk.units import DAMPING, PERIOD, PGA, SHOWN, Quantity, QuantityError, parse, say, si

if TYPE_CHECKING:
    pass

SAME = 1e-9  # relative difference up to which two periods are equal


class Spectral(NamedTuple):
    """Spectral acceleration at a period [s] and a damping ratio, and the value that motions have of it [m/s2]."""

    period: float
    damping: float = USUAL_DAMPING
    value: float | None = None

    @property
    def intensity(self) -> str:
        """The name that an assessment takes: "sa(0.62 s)", or "sa(0.62 s, 2 %)" for a damping other than 5 %."""
        return f"sa({self._at})"

    @property
    def words(self) -> str:
        """The name in sentences: "Sa(0.62 s)"."""
        return f"Sa({self._at})"

    @property
    def _at(self) -> str:
        return at_words(f"{self.period:.{DIGITS}g} s", self.damping)

    def is_at(self, other: Spectral) -> bool:
        """True where both have the same period and damping."""
        alike = isclose(self.period, other.period, rel_tol=SAME)
        return alike and isclose(self.damping, other.damping, rel_tol=SAME)


def own(value: float, quantity: Any) -> str:
    """A value that a user has stated, with all its digits."""
    return say(value, quantity, DIGITS)


class Amplitudes(NamedTuple):
    """The amplitudes of a dataset: its axis of them, their measure, and their values."""

    axis: str  # its name, whether or not the dataset has several
    measure: Measure
    values: tuple[float | None, ...]  # SI; None for motions as recorded, or as [records] scales them

    @property
    def name(self) -> str:
        """The axis by the word of its measure: "pga", "sa(0.5 s)"."""
        return self.measure.intensity

    def words(self, value: float) -> str:
        """A value with its unit."""
        return say_level(value, self.measure.quantity)

    def place(self, asked: float | str | None) -> int | None:
        """Index of a value that is asked for [SI, or text with a unit]; None of none.

        Raises PoundingError for a value that is not there.
        """
        if asked is None:
            return None
        name = "pga" if self.measure == PEAK else self.measure.words
        value = si(asked, self.measure.quantity, name)
        for place, known in enumerate(self.values):
            if known is not None and abs(known - value) <= SAME * known:
                return place
        has = ", ".join(map(self.words, filter(None, self.values))) or "none: its motions have no amplitudes of a grid"
        raise PoundingError(f"{name} {self.words(value)} is not in the dataset, which has {has}")


def check_pga(amplitudes: Amplitudes) -> None:
    """Raise PoundingError where amplitudes are of another measure than PGA."""
    if amplitudes.axis != PGA_AXIS:
        known = ", ".join(amplitudes.words(value) for value in amplitudes.values if value is not None)
        raise PoundingError(
            f"pga: the motions of the dataset are scaled to {amplitudes.measure.words}; choose one of its levels, "
            f"{known}, by intensity_level (--intensity-level)"
        )


def spectral(text: str) -> Spectral | None:
    """Read the argument of "sa(0.62 s)" or "sa(0.62 s, 2 %)"; None where it is not a period."""
    period, _, damping = text.partition(",")
    try:
        return Spectral(parse(period.strip(), PERIOD), parse(damping.strip() or USUAL_DAMPING, DAMPING))
    except QuantityError:
        return None


def intensity_words(intensity: str) -> str:
    """An intensity as text: PGA, PGV, Sa(left), Sa(0.62 s), Sa_avg(0.2-2 s)."""
    measure = read_measure(intensity)
    return f"Sa{intensity.removeprefix('sa')}" if measure is None else measure.words


def intensity_quantity(intensity: str) -> Quantity:
    """What the values of an intensity are: accelerations, but of PGV and of factors."""
    measure = read_measure(intensity)
    return PGA if measure is None else measure.quantity


def intensity_unit(intensity: str) -> str:
    """The SI unit of an intensity as datasets write it: "m/s2", of PGV "m/s"."""
    measure = read_measure(intensity)
    return "m/s2" if measure is None else measure.unit


def intensity_shown(intensity: str) -> tuple[str, float]:
    """The unit in which figures show an intensity, "" of a factor, and what its values [SI] are multiplied by."""
    return ("cm/s", 100.0) if intensity_unit(intensity) == "m/s" else SHOWN[intensity_unit(intensity)]


def intensity_label(intensity: str) -> str:
    """An intensity with its unit, as an axis of a figure has it: "Sa(0.5 s) [g]"."""
    unit, _ = intensity_shown(intensity)
    return f"{intensity_words(intensity)} [{unit or '1'}]"


def spectral_of(table: dict[str, Any]) -> Spectral:
    """A table {value, period, damping} of a resolved scene."""
    value = parse(table["value"], PGA) if "value" in table else None
    return Spectral(parse(table["period"], PERIOD), parse(table.get("damping", USUAL_DAMPING), DAMPING), value)
