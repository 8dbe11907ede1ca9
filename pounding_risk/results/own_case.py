"""The case of a grid that is the scene's own: its gap, yield force, contact model and amplitude."""

from __future__ import annotations

import tomllib
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.units import GAP, PGA, YIELD_FORCE, parse

if TYPE_CHECKING:
    import xarray as xr

SAME = 1e-9  # relative difference of two amplitudes that are one; files keep all digits


def own_gaps(results: xr.Dataset) -> xr.DataArray:
    """The gap [m] of each interface of a row at each gap of the grid, which may vary one interface's alone."""
    if "interface_gap" in results.variables:
        return results["interface_gap"].transpose("gap", "interface")
    return results["gap"].expand_dims(interface=results["interface"].values).transpose("gap", "interface")


def scene_place(results: xr.Dataset) -> int:
    """The place along the grid's gaps that is nearest to the scene's own gap; of a row, where that varies."""
    if "interface" not in results.dims:
        return int(np.abs(results["gap"].values - scene_gap(results, 0)).argmin())
    gaps = own_gaps(results).values
    varied = np.flatnonzero(np.ptp(gaps, axis=0) > 0.0)
    at = int(varied[0]) if varied.size else 0
    return int(np.abs(gaps[:, at] - scene_gap(results, at)).argmin())


def scene_gap(results: xr.Dataset, place: int) -> float:
    """The gap [m] of the scene's interface at this place, as `[[interface]]` states it: one for all, or one each."""
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
    """The scene's own peak ground acceleration [m/s²] where the grid has it; None where it has not."""
    own = _tables(results).get("records", {}).get("pga")
    if own is None or "pga" not in results.coords:
        return None
    wanted = parse(own, PGA)
    amplitudes = np.atleast_1d(results["pga"].values)
    return next((float(each) for each in amplitudes if abs(each - wanted) <= SAME * wanted), None)


def own_level(results: xr.Dataset) -> int:
    """Index of the amplitude that is assessed unless another is asked for: the scene's own, or the grid's largest."""
    if "pga" not in results.coords:
        return 0
    amplitudes, own = np.atleast_1d(results["pga"].values), own_amplitude(results)
    return int(np.argmax(amplitudes) if own is None else np.argmin(np.abs(amplitudes - own)))


def own_case(results: xr.Dataset) -> dict[str, int]:
    """Index along each axis of the scene's own case; the nearest value where the grid has not the very same.

    Without the scene's text there is no such case and no index.
    """
    if not _tables(results).get("interface"):
        return {}
    place: dict[str, int] = {}
    if "gap" in results.dims:
        place["gap"] = scene_place(results)
    if "yield_force" in results.dims:
        place["yield_force"] = int(np.flatnonzero(results["yield_force"].values == scene_force(results))[0])
    if "contact_model" in results.dims:
        place["contact_model"] = list(map(str, results["contact_model"].values)).index(scene_model(results))
    if "pga" in results.dims:
        place["pga"] = own_level(results)
    return place


def _tables(results: xr.Dataset) -> dict[str, Any]:
    return tomllib.loads(str(results.attrs.get("scene_resolved", "")))
