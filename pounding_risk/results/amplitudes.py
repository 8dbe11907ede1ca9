"""How strong the motions of a dataset are, in words, and the intensity that they are scaled to.

The one home of these words: a dataset carries its scene, and its table [records] says how the motions are scaled, the
coordinate ``pga`` to which amplitudes of the grid.
"""

from __future__ import annotations

import tomllib
from math import isclose, isfinite
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.units import DAMPING, PERIOD, PGA, SCALE, QuantityError, parse, say

if TYPE_CHECKING:
    import xarray as xr

DIGITS = 6  # of what a user has asked for, so that 0.125 g stays 0.125 g
USUAL_DAMPING = 0.05  # of a spectral acceleration that names none
SAME = 1e-9  # by which two periods may differ that are one


class Spectral(NamedTuple):
    """Spectral acceleration at a period [s] and a damping ratio, and the value that motions have of it [m/s2]."""

    period: float
    damping: float = USUAL_DAMPING
    value: float | None = None

    @property
    def intensity(self) -> str:
        """As an assessment takes it: "sa(0.62 s)", with another damping than 5 % "sa(0.62 s, 2 %)"."""
        return f"sa({self._at})"

    @property
    def words(self) -> str:
        """As text: "Sa(0.62 s)"."""
        return f"Sa({self._at})"

    @property
    def _at(self) -> str:
        usual = isclose(self.damping, USUAL_DAMPING, rel_tol=SAME)
        return f"{self.period:.{DIGITS}g} s" + ("" if usual else f", {100.0 * self.damping:.{DIGITS}g} %")

    def is_at(self, other: Spectral) -> bool:
        """True where both are at one period and damping."""
        alike = isclose(self.period, other.period, rel_tol=SAME)
        return alike and isclose(self.damping, other.damping, rel_tol=SAME)


def own(value: float, quantity: Any) -> str:
    """What a user has asked for, with the digits that it was asked with."""
    return say(value, quantity, DIGITS)


def amplitude_words(results: xr.Dataset, pga: float | None = None) -> str:
    """How strong the motions are, as it follows "motions": "as recorded", "at Sa(0.62 s) = 0.7 g", "times 1.5".

    Parameters
    ----------
    results : xarray.Dataset
        What `scan` writes.
    pga : float, optional
        The amplitude of the grid that is meant [m/s2], of a dataset that has several; all of them by default.
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
    """What a table [records] scales its motions to; "" where to nothing."""
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
    """The intensity that the motions are scaled by, which fragilities are against unless told otherwise.

    That is Sa at a period where the scene scales to it, or to the ensemble's median of it and the dataset has such a
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
    """The shortest and the longest period [s] at which the dataset has Sa of every record; None where it has none."""
    if "record_spectral_acceleration" not in results:
        return None
    spectra = results["record_spectral_acceleration"].transpose("record", "period").values
    known = results["period"].values[(spectra > 0.0).all(axis=0)]
    return (float(known[0]), float(known[-1])) if known.size else None


def has_spectrum_at(results: xr.Dataset, asked: Spectral) -> bool:
    """True where Sa at a period and damping can be read from the dataset's spectra, which are of 5 % damping."""
    span = spectral_range(results)
    usual = isclose(asked.damping, USUAL_DAMPING, rel_tol=SAME)
    return span is not None and usual and span[0] <= asked.period <= span[1]


def spectral(text: str) -> Spectral | None:
    """What is between the brackets of "sa(0.62 s)" or "sa(0.62 s, 2 %)"; None where it is no period."""
    period, _, damping = text.partition(",")
    try:
        found = Spectral(parse(period.strip(), PERIOD), parse(damping.strip() or USUAL_DAMPING, DAMPING))
    except QuantityError:
        return None
    return found


def intensity_words(intensity: str) -> str:
    """An intensity as text: PGA, Sa(left), Sa(0.62 s)."""
    return "PGA" if intensity == "pga" else f"Sa{intensity.removeprefix('sa')}"


def _records(results: xr.Dataset) -> dict[str, Any]:
    found = tomllib.loads(str(results.attrs.get("scene_resolved", ""))).get("records", {})
    return dict(found)


def _spectral(table: dict[str, Any]) -> Spectral:
    """A table {value, period, damping} of a resolved scene."""
    value = parse(table["value"], PGA) if "value" in table else None
    return Spectral(parse(table["period"], PERIOD), parse(table.get("damping", USUAL_DAMPING), DAMPING), value)
