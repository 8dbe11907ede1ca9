"""Demands of the motions on buildings and interfaces, with contact and without, over the threshold of a damage state.

Read from one case of a dataset of `scan`: a gap, contact model and yield force. What a building would do without
contact is in the dataset for every motion, from the run in which nothing touches; a force of contact is then 0.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.words import nearest
from pounding_risk.assessment.demands import by_motion
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.units import shown

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]

POINT = "contact_point_"
ROUNDED = 1e-12  # of a threshold: some bits of a double


class Demands(NamedTuple):
    """Demands of the motions over the threshold of a state, (motions, levels); NaN where a run failed."""

    with_contact: Array
    without: Array
    jumps: bool = False  # of contact, which begins with a touch, or of storeys that yield: capped at a strength


def demands_of(case: xr.Dataset, state: Any) -> Demands:
    """The demands on which a state of damage depends, each over its threshold.

    Parameters
    ----------
    case : xarray.Dataset
        A dataset of `scan` at one gap, contact model and yield force.
    state : DamageState
        The state.

    Returns
    -------
    Demands
        The largest of the buildings and storeys, or interfaces and contact points, that the state is of.

    Raises
    ------
    PoundingError
        For a building, interface or contact point that is not in the dataset, and a demand that it has not.
    """
    of_place = _of_interfaces if state.demand.interfaces else _of_buildings
    both = [of_place(case, state, without) for without in (False, True)]
    jumps = bool(state.demand.interfaces) or (state.demand.key == "storey_shear" and "storey_ductility" in case)
    ratios = [np.where(np.isfinite(values), values, np.nan) / state.threshold for values in both]
    if jumps:  # a demand that is capped at the threshold may be less than it by rounding
        ratios = [np.where(np.isclose(values, 1.0, rtol=0.0, atol=ROUNDED), 1.0, values) for values in ratios]
    return Demands(ratios[0], ratios[1], jumps)


def _of_buildings(case: xr.Dataset, state: Any, without: bool) -> Array:
    """The largest demand of the chosen buildings and storeys by motion and level."""
    demand, ending = state.demand, "_free" if without else ""
    chosen = _chosen_buildings(case, state)
    # The displacement of a mass is the drift of a building without storeys alone, and each dataset has either.
    name = demand.storeys if "storey_displacement_free" in case else demand.mass
    if not name or not (demand.mass or f"{name}_free" in case):
        raise _lacking(state, demand.absent)
    values = case[f"{name}{ending}"].isel(building=chosen)
    values = values if "storey" in values.dims else values.expand_dims(storey=[1], axis=-1)
    if state.storey > values.sizes["storey"]:
        raise _lacking(state, f"storey {state.storey} is asked for, and the highest is {values.sizes['storey']}")
    kept = slice(state.storey - 1, state.storey) if state.storey else slice(None)
    found = _by_motion(values, ["building", "storey"])[..., kept]
    if demand.per_height:
        found = found / _heights(case, state, chosen)[:, kept]
    largest = np.fmax.reduce(found, axis=(-2, -1))
    if not np.isfinite(largest).any() and without:
        repair = f"it has no storey {state.storey}" if state.storey else demand.absent or "every run failed"
        raise _lacking(state, repair)
    return np.asarray(largest)


def _chosen_buildings(case: xr.Dataset, state: Any) -> list[int]:
    """Places of the buildings that a state is of; all that are not rigid where it names none."""
    names = list(map(str, case["building"].values))
    rigid = np.isnan(case["building_period"].values)
    if not state.building:
        return [int(place) for place in np.flatnonzero(~rigid)]
    if state.building not in names:
        raise _absent(state, "building", names)
    place = names.index(state.building)
    if rigid[place]:
        raise _lacking(state, f"{state.building} is rigid and moves with the ground; name another building")
    return [place]


def _heights(case: xr.Dataset, state: Any, chosen: list[int]) -> Array:
    """Heights of the storeys of the chosen buildings [m], NaN where there is no storey."""
    levels = case["floor_level"].transpose("building", "storey").values[chosen]
    heights = np.diff(levels, axis=1, prepend=0.0)
    unknown = [
        str(case["building"].values[place]) for place, row in zip(chosen, heights, strict=True) if np.isnan(row[0])
    ]
    if unknown:
        raise _lacking(state, f"of {unknown[0]} {state.demand.absent}")
    return np.asarray(heights)


def _of_interfaces(case: xr.Dataset, state: Any, without: bool) -> Array:
    """The largest demand of the chosen interfaces or contact points by motion and level; 0 without contact."""
    demand = state.demand
    names = list(map(str, case["interface"].values))
    if state.interface and state.interface not in names:
        raise _absent(state, "interface", names)
    points = list(map(str, case["contact_point"].values))
    if state.contact_point and state.contact_point not in points:
        raise _absent(state, "contact_point", points)
    kept = np.ones(len(points), dtype=bool)
    if state.interface:
        kept &= case["contact_point_interface"].values == names.index(state.interface)
    if demand.points:
        kept &= case["contact_point_kind"].values.astype(str) == demand.points
    if state.contact_point:
        kept &= np.array([point == state.contact_point for point in points])
    if not kept.any():
        raise _lacking(state, demand.absent or f"{state.contact_point} is no contact point of {state.interface}")
    name, place = f"{POINT}{demand.interfaces}", "contact_point"
    if name not in case:  # two single masses: their one contact point is their interface
        name, place = demand.interfaces, "interface"
    values = _by_motion(case[name].isel({place: np.flatnonzero(kept)}), [place])
    return np.zeros(values.shape[:2]) if without else np.asarray(values.max(axis=-1))


def _by_motion(values: xr.DataArray, places: list[str]) -> Array:
    """Values as (motions, levels, places), whether or not there is an axis of amplitudes."""
    levels = [axis for axis in (PGA_AXIS, LEVEL_AXIS) if axis in values.dims]
    found = by_motion(values, [*levels, *places])
    return found if levels else found[:, None]


def _lacking(state: Any, why: str) -> PoundingError:
    return PoundingError(f"damage.{state.name}: {state.demand.key}: {why}")


def _absent(state: Any, place: str, known: list[str]) -> PoundingError:
    asked = getattr(state, place)
    return PoundingError(
        f"damage.{state.name}: {place.replace('_', ' ')} {shown(asked)} is not in the dataset{nearest(asked, known)}, "
        f"which has {', '.join(known)}"
    )
