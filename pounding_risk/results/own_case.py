"""The case of a grid that the scene itself describes: its gap, yield force, contact model and amplitude."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.results.attributes import tables_of
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.units import GAP, PGA, YIELD_FORCE, parse

if TYPE_CHECKING:
    import xarray as xr

SAME = 1e-9  # relative difference up to which two amplitudes are equal


def own_gaps(results: xr.Dataset) -> xr.DataArray:
    """Gaps (gap, interface) [m] of a row: a grid may vary the gap of one interface only."""
    if "interface_gap" in results.variables:
        return results["interface_gap"].transpose("gap", "interface")
    return results["gap"].expand_dims(interface=results["interface"].values).transpose("gap", "interface")


def scene_place(results: xr.Dataset) -> int:
    """Index of the gap of the grid that is nearest to the scene's own, at the interface whose gap varies."""
    if "interface" not in results.dims:
        return int(np.abs(results["gap"].values - scene_gap(results, 0)).argmin())
    at = _varied_interface(results)
    return int(np.abs(own_gaps(results).values[:, at] - scene_gap(results, at)).argmin())


def _varied_interface(results: xr.Dataset) -> int:
    """The first interface whose gap the grid varies; the first of all where it varies none."""
    if "interface" not in results.dims or "gap" not in results.dims:
        return 0
    return int((np.ptp(own_gaps(results).values, axis=0) > 0.0).argmax())


def scene_gap(results: xr.Dataset, place: int) -> float:
    """The scene's own gap [m] at an interface; `[[interface]]` stands once for all or once for each."""
    tables = _tables(results)["interface"]
    return parse(tables[min(place, len(tables) - 1)]["gap"], GAP)


def scene_force(results: xr.Dataset) -> float:
    """The yield force of the grid that is nearest to the scene's own [N]; inf where that never yields."""
    tables = _tables(results)["interface"]
    forces = results["yield_force"].values
    own = parse(tables[0].get("yield_force", "inf"), YIELD_FORCE)
    if np.isinf(own):
        return float(forces.max())
    return float(forces[np.abs(forces - own).argmin()])


def scene_model(results: xr.Dataset) -> str:
    """The scene's own contact model where the grid has it, or the grid's first."""
    own = str(_tables(results)["interface"][0].get("contact_model", ""))
    known = list(map(str, results["contact_model"].values))
    return own if own in known else known[0]


def own_amplitude(results: xr.Dataset) -> float | None:
    """The scene's own peak ground acceleration [m/s²] where the grid has it; None where it has not.

    So it is where the grid has levels of another measure.
    """
    own = _tables(results).get("records", {}).get("pga")
    if own is None or "pga" not in results.coords:
        return None
    wanted = parse(own, PGA)
    amplitudes = np.atleast_1d(results["pga"].values)
    return next((float(pga) for pga in amplitudes if abs(pga - wanted) <= SAME * wanted), None)


def own_level(results: xr.Dataset) -> int:
    """Index of the amplitude that is assessed unless another is asked for: the scene's own, or the grid's largest."""
    axis = amplitude_axis(results)
    if axis not in results.coords:
        return 0
    amplitudes, own = np.atleast_1d(results[axis].values), own_amplitude(results)
    return int(np.argmax(amplitudes) if own is None else np.argmin(np.abs(amplitudes - own)))


def own_case(results: xr.Dataset) -> dict[str, int]:
    """Index of the scene's own case along each axis, or of the nearest value where the grid does not have it.

    Empty for a dataset without the text of its scene.
    """
    if not _tables(results).get("interface"):
        return {}
    index: dict[str, int] = {}
    if "gap" in results.dims:
        index["gap"] = scene_place(results)
    if "yield_force" in results.dims:
        index["yield_force"] = int(np.flatnonzero(results["yield_force"].values == scene_force(results))[0])
    if "contact_model" in results.dims:
        index["contact_model"] = list(map(str, results["contact_model"].values)).index(scene_model(results))
    if amplitude_axis(results) in results.dims:
        index[amplitude_axis(results)] = own_level(results)
    return index


def at_level(results: xr.Dataset, level: int | None = None) -> xr.Dataset:
    """The dataset at one of its amplitudes, that of `own_level` by default; one without an axis of them as it is."""
    axis = amplitude_axis(results)
    return results.isel({axis: own_level(results) if level is None else level}) if axis in results.dims else results


def _tables(results: xr.Dataset) -> dict[str, Any]:
    return tables_of(str(results.attrs.get("scene_resolved", "")))


def own_values(results: xr.Dataset) -> dict[str, Any]:
    """The scene's own gap [m], yield force [N], contact model and amplitude [m/s²], as far as its text gives them."""
    tables = _tables(results)
    if not tables.get("interface"):
        return {}
    first, pga = tables["interface"][0], tables.get("records", {}).get("pga")
    values = {
        "gap": scene_gap(results, _varied_interface(results)),
        "yield_force": parse(first.get("yield_force", "inf"), YIELD_FORCE),
        "contact_model": first.get("contact_model"),
        "pga": None if pga is None else parse(pga, PGA),
    }
    return {axis: value for axis, value in values.items() if value is not None}
