"""Amplitude of the motions of a dataset, in words, and the intensity that they are scaled to.

The scene in the attributes of a dataset says in its table [records] how the motions are scaled; the coordinate ``pga``
has the amplitudes of the grid.
"""

from __future__ import annotations

from math import isclose, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.results.attributes import tables_of
from pounding_risk.units import DAMPING, PERIOD, PGA, SCALE, QuantityError, parse, say

if TYPE_CHECKING:
    import xarray as xr

DIGITS = 6  # of values that a user has stated, so that 0.125 g stays 0.125 g
USUAL_DAMPING = 0.05  # of a spectral acceleration without a stated one
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
        usual = isclose(self.damping, USUAL_DAMPING, rel_tol=SAME)
        return f"{self.period:.{DIGITS}g} s" + ("" if usual else f", {100.0 * self.damping:.{DIGITS}g} %")

    def is_at(self, other: Spectral) -> bool:
        """True where both have the same period and damping."""
        alike = isclose(self.period, other.period, rel_tol=SAME)
        return alike and isclose(self.damping, other.damping, rel_tol=SAME)


def own(value: float, quantity: Any) -> str:
    """A value that a user has stated, with all its digits."""
    return say(value, quantity, DIGITS)


def amplitude_words(results: xr.Dataset, pga: float | None = None) -> str:
    """The amplitude in words that follow "motions": "as recorded", "at Sa(0.62 s) = 0.7 g", "times 1.5".

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`.
    pga : float, optional
        One amplitude of a grid that has several [m/s2]; all of them by default.

    Returns
    -------
    str
        The words.
    """
    if pga is None and "pga" in results.coords and "pga" not in results.dims:
        pga = float(results["pga"].values)
    if pga is None and "pga" in results.dims:
        ends = [own(float(end), PGA) for end in (results["pga"].values.min(), results["pga"].values.max())]
        return f"at PGA {' to '.join(dict.fromkeys(ends))}"
    if pga is not None and isfinite(pga):
        return f"at PGA {own(pga, PGA)}"
    asked = _records(results)
    scale = asked.get("scale")
    factor = "" if scale is None else f"times {parse(scale, SCALE):.{DIGITS}g}"
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

    It is Sa at a period where the scene scales to it, or to the ensemble's median of it and the dataset has such a
    spectrum; PGA elsewhere.
    """
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
    """An intensity as text: PGA, Sa(left), Sa(0.62 s)."""
    return "PGA" if intensity == "pga" else f"Sa{intensity.removeprefix('sa')}"


def _records(results: xr.Dataset) -> dict[str, Any]:
    return dict(tables_of(str(results.attrs.get("scene_resolved", ""))).get("records", {}))


def _spectral(table: dict[str, Any]) -> Spectral:
    """A table {value, period, damping} of a resolved scene."""
    value = parse(table["value"], PGA) if "value" in table else None
    return Spectral(parse(table["period"], PERIOD), parse(table.get("damping", USUAL_DAMPING), DAMPING), value)
