"""What floors do to columns that they strike part-way up: which, how often, and what the model assumes afterwards.

Read from a dataset of `scan`, at the scene's own contact model and F_E; nothing here runs a case.
"""

from __future__ import annotations

from math import isfinite
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.demands import UNDEFINED
from pounding_risk.results.opened import Results
from pounding_risk.units import GAP, STOREY_HEIGHT, YIELD_FORCE, say

if TYPE_CHECKING:
    import xarray as xr

COLUMN = "column"
POINT = "contact_point_"
PLATEAU = 1.01  # times the strength: above it a force is not held at the strength, whatever rounding does


class StruckColumn(NamedTuple):
    """Contact of a floor with a column over the motions: how often, and up to which force [N]."""

    floor: str
    column: str
    level: float  # m above the ground
    strength: float  # N, inf where none is given
    runs: int  # complete ones
    touched: int
    reached: int  # of these, the runs whose force reaches the strength
    force: float  # N, the largest; 0 without contact


def column_sentences(results: xr.Dataset, level: int, gap: float) -> tuple[str, ...]:
    """Which floor strikes which column of one interface, how often, and what the model assumes; none without columns.

    Parameters
    ----------
    results : xarray.Dataset
        The part of a dataset that belongs to one interface.
    level : int
        Index of the amplitude.
    gap : float
        The assessed gap [m]; the grid's nearest is read.
    """
    struck = struck_columns(results, level, gap)
    if not struck:
        return ()
    worst = max(struck, key=lambda one: (one.reached, one.touched, one.force))
    here = say(float(results["gap"].values[_nearest(results, gap)]), GAP, 3)
    high = f", {say(worst.level, STOREY_HEIGHT, 3)} above the ground," if isfinite(worst.level) else ""
    pair = f"the columns of {worst.column}{high}"
    if not worst.touched:
        return (f"{worst.floor} faces {pair} and strikes them in none of {counted(worst.runs, 'motion')} at {here}.",)
    count = sum(one.touched > 0 for one in struck)
    several = f" (columns are struck at {count} of {len(struck)} levels)" if len(struck) > 1 else ""
    hits = f"{worst.floor} strikes {pair} in {worst.touched} of {counted(worst.runs, 'motion')} at a gap of {here}"
    force, strength = say(worst.force, YIELD_FORCE, 3), say(worst.strength, YIELD_FORCE, 3)
    if not isfinite(worst.strength):
        unknown = (
            f"No strength of these columns is given (column_yield_force): forces up to {force} are taken as borne."
        )
        return f"{hits}{several}.", unknown
    if not worst.reached:
        return (f"{hits}{several}; the largest force, {force}, stays below their strength of {strength}.",)
    first = f"{hits}; their strength of {strength} is reached in {worst.reached} of them{several}."
    if worst.force > PLATEAU * worst.strength:
        return first, (
            f"The model does not hold the force at that strength: it goes up to {force}, which such columns do not "
            "carry, and assumes that they stay whole, which is unsafe."
        )
    return first, (
        "Afterwards the model assumes that they keep this force at any further displacement (perfectly plastic): "
        "unsafe for brittle columns, which lose strength, and may lose the floors above."
    )


def struck_columns(results: xr.Dataset, level: int, gap: float) -> tuple[StruckColumn, ...]:
    """Every contact of a floor with a column of one interface, from the lowest."""
    if "contact_point_kind" not in results.variables or "contact_point" not in results.dims:
        return ()
    opened = Results(results)
    own = opened.scene_case
    case = opened.at_level(level).isel(
        gap=_nearest(results, gap), contact_model=own["contact_model"], yield_force=own["yield_force"]
    )
    kinds = case["contact_point_kind"].values
    return tuple(_struck(case, place) for place in range(kinds.size) if str(kinds[place]) == COLUMN)


def _nearest(results: xr.Dataset, gap: float) -> int:
    return int(np.abs(results["gap"].values - gap).argmin())


def _struck(case: xr.Dataset, place: int) -> StruckColumn:
    point = case.isel(contact_point=place)
    prefix = POINT if f"{POINT}impact_count" in case.variables else ""  # else it is the interface's one point
    counts, yields, forces = (
        point[f"{prefix}{name}"].values.ravel() for name in ("impact_count", "yield_exceedance", "peak_contact_force")
    )
    floors = [float(point[f"{POINT}{side}_floor"]) for side in ("left", "right")]
    column = 0 if floors[0] % 1.0 else 1
    names = list(map(str, case["building"].values))
    storeys = int(case["building_storeys"].values[1 - column])
    floor = (
        f"floor {floors[1 - column]:g} of {names[1 - column]}" if storeys > 1 else f"the floor of {names[1 - column]}"
    )
    touched = counts > 0
    strength = float(point["contact_point_yield_force"]) if "contact_point_yield_force" in case.variables else np.inf
    return StruckColumn(
        floor[0].upper() + floor[1:],
        f"storey {int(floors[column]) + 1} of {names[column]}",
        float(point["contact_point_level"]),
        strength,
        int((counts != UNDEFINED).sum()),
        int(touched.sum()),
        int((touched & (yields > 0)).sum()),
        float(np.nanmax(forces[touched], initial=0.0)),
    )
