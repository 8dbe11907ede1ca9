"""Intensities by their names, in words and with their units, and the amplitudes of a grid.

The amplitudes of a grid are its axis ``pga``, or ``intensity`` for levels of another measure (`opened.Results`).
"""

from __future__ import annotations

from typing import Any, NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import DIGITS, PEAK, PGA_AXIS, Measure, read_measure, say_level
from pounding_risk.units import PGA, SHOWN, Quantity, say, si

SAME = 1e-9  # relative difference up to which two values are equal


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
