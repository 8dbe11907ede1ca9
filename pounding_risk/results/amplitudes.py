"""Amplitude of the motions of a dataset, in words, and the intensity that they are scaled to.

The scene in the attributes of a dataset says in its table [records] how the motions are scaled. The amplitudes of the
grid are its axis ``pga``, or ``intensity`` for levels of another measure, whose attributes say which.
"""

from __future__ import annotations

from math import isclose, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import (
    DIGITS,
    FACTOR,
    LEVEL_AXIS,
    PEAK,
    PGA_AXIS,
    USUAL_DAMPING,
    Measure,
    at_words,
    read_measure,
    say_level,
)
from pounding_risk.results.attributes import tables_of
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.units import DAMPING, PERIOD, PGA, SCALE, SHOWN, Quantity, QuantityError, parse, say, si

if TYPE_CHECKING:
    import xarray as xr

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


def amplitudes_of(results: xr.Dataset) -> Amplitudes:
    """The amplitudes of a dataset: one that was selected or scanned alone counts too."""
    axis = amplitude_axis(results)
    if axis not in results.coords:
        return Amplitudes(axis, PEAK, (None,))
    values = tuple(float(value) for value in np.atleast_1d(results[axis].values))
    return Amplitudes(axis, measure_of(results), values)


def measure_of(results: xr.Dataset) -> Measure:
    """The measure of the amplitudes of a dataset."""
    if LEVEL_AXIS not in results.variables:
        return PEAK
    about = results[LEVEL_AXIS].attrs
    periods = tuple(float(period) for period in np.atleast_1d(about.get("periods", ())))
    return Measure(str(about["measure"]), periods, float(about.get("damping", USUAL_DAMPING)))


def axis_name(results: xr.Dataset, axis: str) -> str:
    """An axis of cases as sentences and readers of values take it: that of levels by the word of its measure."""
    return measure_of(results).intensity if axis == LEVEL_AXIS else axis


def level_asked(
    results: xr.Dataset, pga: float | str | None = None, intensity_level: float | str | None = None
) -> int | None:
    """Index of the amplitude that a call names by one of its two options; None where it names none.

    ``intensity_level`` is a value of whatever measure the dataset has, PGA too. Raises PoundingError where both are
    given, for ``pga`` of a dataset of another measure, and for a value that the dataset has not.
    """
    amplitudes = amplitudes_of(results)
    if pga is not None and intensity_level is not None:
        raise PoundingError("pga and intensity_level both name the amplitude; give one of them")
    if pga is not None:
        check_pga(amplitudes)
    return amplitudes.place(pga if pga is not None else intensity_level)


def check_pga(amplitudes: Amplitudes) -> None:
    """Raise PoundingError where amplitudes are of another measure than PGA."""
    if amplitudes.axis != PGA_AXIS:
        known = ", ".join(amplitudes.words(value) for value in amplitudes.values if value is not None)
        raise PoundingError(
            f"pga: the motions of the dataset are scaled to {amplitudes.measure.words}; choose one of its levels, "
            f"{known}, by intensity_level (--intensity-level)"
        )


def amplitude_words(results: xr.Dataset, level: float | None = None) -> str:
    """The amplitude in words that follow "motions": "as recorded", "at Sa(0.62 s) = 0.7 g", "times 1.5".

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`.
    level : float, optional
        One amplitude of a grid that has several [SI]; all of them by default.

    Returns
    -------
    str
        The words.
    """
    amplitudes = amplitudes_of(results)
    measure, known = amplitudes.measure, [value for value in amplitudes.values if value is not None]
    values = [value for value in (known if level is None else [level]) if isfinite(value)]
    ends = " to ".join(dict.fromkeys(amplitudes.words(end) for end in (min(values), max(values)))) if values else ""
    if ends and measure.name != FACTOR:
        return f"at PGA {ends}" if measure == PEAK else f"at {measure.words} = {ends}"
    asked = _records(results)
    scale = asked.get("scale")
    factor = "" if scale is None else f"times {parse(scale, SCALE):.{DIGITS}g}"
    factor = f"times {ends}" if ends else factor
    aim = _aim(asked)
    return " ".join(filter(None, (aim, factor))) or "as recorded"


def _aim(asked: dict[str, Any]) -> str:
    """What a table [records] scales the motions to; "" where they are not scaled."""
    if "manifest" in asked:
        return f"with the factors of {asked['manifest']}"
    if "to_median" in asked:
        measure = asked["to_median"]
        return f"at the ensemble's median {_spectral(measure).words if isinstance(measure, dict) else measure.upper()}"
    if "sa" in asked:
        one = _spectral(asked["sa"])
        return f"at {one.words} = {own(one.value or 0.0, PGA)}"
    return f"at PGA {own(parse(asked['pga'], PGA), PGA)}" if "pga" in asked else ""


def scaled_to(results: xr.Dataset) -> Spectral | None:
    """The spectral acceleration that every motion of the dataset has; None where motions are not scaled to one."""
    asked = _records(results)
    if "pga" in results.coords or "sa" not in asked:
        return None
    one = _spectral(asked["sa"])
    return one._replace(value=(one.value or 0.0) * parse(asked.get("scale", 1.0), SCALE))


def usual_intensity(results: xr.Dataset) -> str:
    """The intensity that the motions are scaled to: the default intensity of fragilities.

    It is the measure of the levels where they are no factors; Sa at a period where the scene scales to it, or to the
    ensemble's median of it and the dataset has such a spectrum; PGA elsewhere.
    """
    measured = measure_of(results)
    if measured.name != FACTOR and measured != PEAK:
        return measured.intensity
    one = scaled_to(results)
    if one is not None:
        return one.intensity
    measure = _records(results).get("to_median")
    if not isinstance(measure, dict) or "pga" in results.coords:
        return "pga"
    one = _spectral(measure)
    return one.intensity if has_spectrum_at(results, one) else "pga"


def spectral_range(results: xr.Dataset) -> tuple[float, float] | None:
    """The range of periods [s] in which the dataset has Sa of every record; None where there is none."""
    if "record_spectral_acceleration" not in results:
        return None
    spectra = results["record_spectral_acceleration"].transpose("record", "period").values
    known = results["period"].values[(spectra > 0.0).all(axis=0)]
    return (float(known[0]), float(known[-1])) if known.size else None


def has_spectrum_at(results: xr.Dataset, asked: Spectral) -> bool:
    """True where the spectra of the dataset, which have 5 % damping, include this period and damping."""
    span = spectral_range(results)
    usual = isclose(asked.damping, USUAL_DAMPING, rel_tol=SAME)
    return span is not None and usual and span[0] <= asked.period <= span[1]


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


def _records(results: xr.Dataset) -> dict[str, Any]:
    return dict(tables_of(str(results.attrs.get("scene_resolved", ""))).get("records", {}))


def _spectral(table: dict[str, Any]) -> Spectral:
    """A table {value, period, damping} of a resolved scene."""
    value = parse(table["value"], PGA) if "value" in table else None
    return Spectral(parse(table["period"], PERIOD), parse(table.get("damping", USUAL_DAMPING), DAMPING), value)
