"""One case of a dataset, selected by its values as a user writes them."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import PEAK
from pounding_risk.results.amplitudes import axis_name, measure_of
from pounding_risk.results.check import check_scene
from pounding_risk.results.grid_values import axis_words, listed_values, place_of, quantity_of
from pounding_risk.results.kinds import kind_of
from pounding_risk.results.layout import axes_of_cases
from pounding_risk.results.own_case import own_values
from pounding_risk.results.scene_axes import settled

if TYPE_CHECKING:
    import xarray as xr

WITH_CASES = ("scan", "compare", "effects", "histories")


def one_case(
    results: xr.Dataset,
    *,
    record: str | None = None,
    polarity: str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
    contact_model: str | None = None,
    gap: float | str | None = None,
    yield_force: float | str | None = None,
) -> xr.Dataset:
    """Select one case of the grid by its values, which must be values of the grid.

    Of what is left out the scene's own value is taken, and of records and polarities the first, as in `simulate`. The
    values stay in the dataset as coordinates.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`, `compare`, `effects` or `histories`.
    record : str, optional
        Name of a record.
    polarity : str, optional
        Name of a polarity.
    pga : float or str, optional
        Amplitude of the grid [m/s2, or text with a unit].
    intensity_level : float or str, optional
        Amplitude of the grid in its own measure [SI, or text with a unit], where that may be another than PGA.
    contact_model : str, optional
        Name of a contact model.
    gap : float or str, optional
        Gap [m, or text with a unit].
    yield_force : float or str, optional
        Yield force F_E [N, or text with a unit].

    Returns
    -------
    xarray.Dataset
        The part of the dataset that belongs to the case, with all its attributes.

    Raises
    ------
    PoundingError
        For a value that the grid has not, with those that it has; for several values along an axis of another number
        of the scene; where several values are left and none is the
        scene's own; and for a dataset without a grid.
    """
    results = settled(results)
    kind = kind_of(results)
    if kind not in WITH_CASES:
        why = "is one case as it is" if kind == "simulate" else "has no grid of cases"
        raise PoundingError(f"the dataset of {kind or 'another program'} {why}; a case is selected from that of a scan")
    if pga is not None and (intensity_level is not None or measure_of(results) != PEAK):
        raise PoundingError(
            f"pga: the amplitude is named by intensity_level, of {measure_of(results).words}; leave pga out"
        )
    check_scene(results)
    given = (record, polarity, intensity_level if pga is None else pga, contact_model, gap, yield_force)
    own = {"record": None, "polarity": None} | own_values(results)
    where = {axis: _place(results, axis, value, own) for axis, value in zip(axes_of_cases(results), given, strict=True)}
    return results.isel({axis: place for axis, place in where.items() if axis in results.dims})


def _place(results: xr.Dataset, axis: str, value: Any, own: dict[str, Any]) -> int:
    """Index along an axis of the value that is asked for, or of the scene's own."""
    name = axis_name(results, axis)
    if axis not in results.coords:
        return 0 if value is None else place_of(name, (None,), value)
    if results[axis].dims not in ((), (axis,)):
        if value is None:
            return 0
        raise PoundingError(f"{axis_words(name)}: of each contact model there is one case; select by contact_model")
    known = values_along(results, axis)
    if value is not None:
        return place_of(name, known, value)
    if len(known) == 1 or own.get(axis, "") is None:
        return 0
    if axis not in own:
        has = listed_values(name, known)
        raise PoundingError(f"{axis}: the scene has none of its own, and the grid has {has}; name one")
    try:
        return place_of(name, known, own[axis])
    except PoundingError as error:
        raise PoundingError(f"{axis}: none is named, and the scene's own is not there: {error}; name one") from None


def values_along(results: xr.Dataset, axis: str) -> tuple[Any, ...]:
    """The values of an axis of cases, one where it was selected: floats of a quantity, else names."""
    kind = str if quantity_of(axis_name(results, axis)) is None else float
    return tuple(map(kind, np.atleast_1d(results[axis].values)))
