"""Values of a grid, its amplitudes among them, found by what a user writes; intensities in words and with their units.

The amplitudes of a grid are its axis ``pga``, or ``intensity`` for levels of another measure (`opened.Results`). A user
writes a number in SI, text with a unit, or a name.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isclose, isinf
from typing import Any, NamedTuple

from pounding_risk._common.words import nearest, short_list
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import DIGITS, PEAK, PGA_AXIS, Measure, read_measure, say_level
from pounding_risk.units import GAP, PGA, SHOWN, YIELD_FORCE, Quantity, say, si

SAME = 1e-9  # relative difference up to which two values are equal: one may be written down and read again
FEW = 8  # values of a grid that a sentence lists
QUANTITIES = {"pga": PGA, "gap": GAP, "yield_force": YIELD_FORCE}


def own(stated: float, quantity: Any) -> str:
    """A value that a user has stated, with all its digits."""
    return say(stated, quantity, DIGITS)


class Amplitudes(NamedTuple):
    """The amplitudes of a dataset: its axis of them, their measure, and their values."""

    axis: str  # its name, whether or not the dataset has several
    measure: Measure
    values: tuple[float | None, ...]  # SI; None for motions as recorded, or as [records] scales them

    @property
    def name(self) -> str:
        """The axis by the word of its measure: "pga", "sa(0.5 s)"."""
        return self.measure.intensity

    def words(self, amplitude: float) -> str:
        """A value with its unit."""
        return say_level(amplitude, self.measure.quantity)

    def place(self, requested: float | str | None) -> int | None:
        """Index of a value that is asked for [SI, or text with a unit]; None of none.

        Raises PoundingError for a value that is not there.
        """
        if requested is None:
            return None
        name = "pga" if self.measure == PEAK else self.measure.words
        amplitude = si(requested, self.measure.quantity, name)
        for place, value in enumerate(self.values):
            if value is not None and abs(value - amplitude) <= SAME * value:
                return place
        has = ", ".join(map(self.words, filter(None, self.values))) or "none: its motions have no amplitudes of a grid"
        raise PoundingError(f"{name} {self.words(amplitude)} is not in the dataset, which has {has}")


def check_pga(amplitudes: Amplitudes) -> None:
    """Raise PoundingError where amplitudes are of another measure than PGA."""
    if amplitudes.axis != PGA_AXIS:
        levels = ", ".join(amplitudes.words(amplitude) for amplitude in amplitudes.values if amplitude is not None)
        raise PoundingError(
            f"pga: the motions of the dataset are scaled to {amplitudes.measure.words}; choose one of its levels, "
            f"{levels}, by intensity_level (--intensity-level)"
        )


def intensity_words(intensity: str) -> str:
    """An intensity as text: PGA, PGV, Sa(left), Sa(0.62 s), Sa_avg(0.2-2 s)."""
    measure = read_measure(intensity)
    return f"Sa{intensity.removeprefix('sa')}" if measure is None else measure.words


def intensity_quantity(intensity: str) -> Quantity:
    """What the values of an intensity are: accelerations, but of PGV and of factors."""
    return quantity_of(intensity) or PGA


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


def quantity_of(axis: str) -> Quantity | None:
    """What the values of an axis are; None of names.

    The axis of levels of a measure goes by the word of that measure, such as "sa(0.5 s)" (`Results.axis_name`).
    """
    measure = read_measure(axis)
    return QUANTITIES.get(axis) if measure is None else measure.quantity


def place_of(axis: str, labels: tuple[Any, ...], value: Any) -> int:
    """Index of a value among those of an axis of `AXES`; a number in SI, or text with a unit.

    A number stands for the value that is as large, within 1e-9 of it. Raises PoundingError for what is not there.
    """
    quantity = quantity_of(axis)
    if quantity is not None:
        value = si(value, quantity, axis_words(axis))
    if labels == (None,):
        raise PoundingError(
            "the scene scales its records to no PGA, so that there is none to choose; leave it out, or choose records"
        )
    for index, label in enumerate(labels):
        if label == value or (quantity is not None and isclose(label, value, rel_tol=SAME)):
            return index
    raise PoundingError(_absent_words(axis, labels, value))


def _absent_words(axis: str, labels: tuple[Any, ...], value: Any) -> str:
    quantity = quantity_of(axis)
    if quantity is None:
        hint = nearest(str(value), labels)
        return f"{axis_words(axis)} {value!r} is not in the grid{hint}, which has {listed_values(axis, labels)}"
    value_text = say_level(value, quantity, 10)
    nearest_labels = sorted(labels, key=lambda label: abs(label - value) if not isinf(label) else inf)[:2]
    nearest_text = f" (next to it are {listed_values(axis, sorted(nearest_labels))})" if len(labels) > FEW else ""
    return f"{axis_words(axis)} {value_text} is not in the grid, which has {listed_values(axis, labels)}{nearest_text}"


def listed_values(axis: str, labels: Sequence[Any]) -> str:
    """Values of an axis in words: all where they are few, otherwise how many from which to which."""
    quantity = quantity_of(axis)
    words = [str(label) if quantity is None else say_level(label, quantity, 10) for label in labels]
    return short_list(words, FEW)


def axis_words(axis: str) -> str:
    """The name of an axis in a sentence."""
    measure = read_measure(axis)
    return axis.replace("_", " ") if measure is None else measure.words
