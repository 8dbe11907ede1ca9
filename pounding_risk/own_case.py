"""The case of a grid that is the scene's own: its gap, yield force, contact model and amplitude."""

from __future__ import annotations

import tomllib
from math import isinf
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessed_data import scene_place
from pounding_risk.quantities import GAP, PGA, YIELD_FORCE, Quantity, parse

if TYPE_CHECKING:
    import xarray as xr

SAME = 1e-9  # relative difference of two amplitudes that are one; files keep all digits


def own_amplitude(results: xr.Dataset) -> float | None:
    """The scene's own peak ground acceleration [m/s²] where the grid has it; None where it has not."""
    own = _tables(results).get("records", {}).get("pga")
    if own is None or "pga" not in results.coords:
        return None
    wanted = parse(own, PGA)
    amplitudes = np.atleast_1d(results["pga"].values)
    return next((float(each) for each in amplitudes if abs(each - wanted) <= SAME * wanted), None)


def own_case(results: xr.Dataset) -> dict[str, int]:
    """Index along each axis of the scene's own case; the nearest value where the grid has not the very same.

    Amplitudes are at their largest where the scene has none of its own. Without the scene's text there is no such case
    and no index.
    """
    tables = _tables(results)
    interface = (tables.get("interface") or [{}])[0]
    place: dict[str, int] = {}
    if "gap" in results.dims and "gap" in interface:
        is_row = "interface" in results.dims
        place["gap"] = scene_place(results) if is_row else _nearest(results, "gap", interface["gap"], GAP)
    if "yield_force" in results.dims and tables:
        place["yield_force"] = _nearest(results, "yield_force", interface.get("yield_force", "inf"), YIELD_FORCE)
    names = list(map(str, results["contact_model"].values)) if "contact_model" in results.dims else []
    if interface.get("contact_model") in names:
        place["contact_model"] = names.index(interface["contact_model"])
    if "pga" in results.dims and tables:
        own = own_amplitude(results)
        amplitudes = results["pga"].values
        place["pga"] = int(np.argmax(amplitudes) if own is None else np.argmin(np.abs(amplitudes - own)))
    return place


def _tables(results: xr.Dataset) -> dict[str, Any]:
    return tomllib.loads(str(results.attrs.get("scene_resolved", "")))


def _nearest(results: xr.Dataset, axis: str, text: str, quantity: Quantity) -> int:
    """Index of the nearest value; of an infinite one, that of the largest."""
    values, wanted = results[axis].values, parse(text, quantity)
    return int(np.argmax(values)) if isinf(wanted) else int(np.argmin(np.abs(values - wanted)))
