"""Datasets of runs with their histories that version 1 wrote, in the shape of this version.

Version 1 had of a pair neither storeys nor contact point and interface, and its outputs as JSON in attributes. What it
did not write stays absent: the impulse so far of a pair, the relative displacement of a row.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.models.structures.contact_points import FLOOR, Point, automatic_points
from pounding_risk.models.structures.sdof import Building
from pounding_risk.results.attributes import tables_of
from pounding_risk.results.places import building_coordinates, place_coordinates
from pounding_risk.results.run_variables import BUILDING, CONTACT_PLACE, FORCE_OF_RUN, GAP_OF_RUN, HISTORIES
from pounding_risk.results.variables import described, own_dims

if TYPE_CHECKING:
    import xarray as xr

COUNTS = ("impact_count", "yield_exceedance", "yield_count", "restitution_held")
Widen = Callable[["xr.Variable", str], "xr.Variable"]


def is_run(dataset: xr.Dataset) -> bool:
    """True for a dataset of `simulate` or `histories`."""
    return {"displacement", "contact_force"} <= set(dataset.data_vars)


def upgraded_run(run: xr.Dataset, buildings: Sequence[Building], widen: Widen) -> xr.Dataset:
    """A run, or many, of version 1 in the shape of this version, without the attribute of it.

    ``buildings`` are those of a pair, ``widen`` is as in `upgrade`. Displacements are read where a building is rigid.
    """
    # In `histories` the ground acceleration is that of a motion, and stays.
    names = [name for name in HISTORIES if name in run and ("time" in run.dims or name != "ground_acceleration")]
    whole = run.assign({name: _reshaped(run[name].variable, name, widen) for name in names})
    return _of_row(whole) if "contact_point" in run.dims else _of_pair(whole, buildings)


def _of_row(run: xr.Dataset) -> xr.Dataset:
    counts = {name: run[name].astype(np.int32) for name in map(str, run.data_vars) if name.endswith(COUNTS)}
    return run.assign(counts).assign_attrs(_levels(run) if "interface_gap" in run and "time" in run.dims else {})


def _levels(run: xr.Dataset) -> dict[str, float]:
    """Gap and yield force of a run of a row as the grid counts them: at the interface that it varies, of floors."""
    names = run["interface"].values.tolist()
    try:
        varied = names.index(tables_of(run.attrs["scene_resolved"])["grid"]["interface"])
    except (KeyError, TypeError, ValueError, RecursionError):  # it names none, or is lost
        varied = 0
    floors = run["contact_point_yield_force"].values[run["contact_point_kind"].values == FLOOR]
    force = {"yield_force": float(floors[0])} if floors.size else {}
    return {"gap": float(run["interface_gap"].values[varied]), **force}


def _of_pair(run: xr.Dataset, buildings: Sequence[Building]) -> xr.Dataset:
    variables: dict[str, Any] = {}
    if any(building.is_rigid for building in buildings):
        moves = run["building"].variable.copy(data=np.array([not building.is_rigid for building in buildings]))
        variables = {name: run[name].variable.where(moves) for name in ("displacement", "velocity") if name in run}
    if "ground_acceleration_right" in run:
        both = np.column_stack([run[name].values for name in ("ground_acceleration", "ground_acceleration_right")])
        dims, unit, words = HISTORIES["building_ground_acceleration"]
        variables["building_ground_acceleration"] = (dims, both, described(unit, words))
    coords = _places(run, buildings)
    if "contact" in run.dims:
        (point,) = coords["contact_point"][1]
        places = np.array([point] * run.sizes["contact"], dtype=np.str_)
        variables |= _outputs(run.attrs) | {"contact_place": ("contact", places, dict(CONTACT_PLACE))}
        coords["building"] = ("building", run["building"].values, dict(BUILDING))
        coords["contact_point_yield_force"] = ("contact_point", [run.attrs["yield_force"]], described(*FORCE_OF_RUN))
        coords["interface_gap"] = ("interface", [float(run.attrs["gap"])], described(*GAP_OF_RUN))
        run = run.drop_vars(["gap", "ground_acceleration_right"], errors="ignore")
    attrs = {name: value for name, value in run.attrs.items() if name not in ("outputs", "building_outputs")}
    whole = run.assign(variables).assign_coords(coords)
    whole.attrs = attrs
    return whole


def _reshaped(variable: xr.Variable, name: str, widen: Widen) -> xr.Variable:
    """A history with every dimension that it has now; the samples of `histories` stand behind the others."""
    (first, *own), unit, words = HISTORIES[name]
    attrs = {**variable.attrs, **described(unit, words)}
    for dim in own:
        variable = variable if dim in variable.dims else widen(variable, dim)
    order = (first, *own) if first in variable.dims else (..., *own, "sample")
    return variable.transpose(*order)._replace(attrs=attrs)


def _places(run: xr.Dataset, buildings: Sequence[Building]) -> dict[str, Any]:
    """The coordinates of the places of two single masses, with the yield forces of the cases."""
    left, right = buildings
    points = [Point(0, *meeting) for meeting in automatic_points(left, right)]
    coords = building_coordinates(buildings) | place_coordinates(buildings, points, np.empty((0, 1)))
    *_, attrs = coords.pop("contact_point_yield_force")
    if "yield_force" in run.coords:
        forces = run["yield_force"]
        coords["contact_point_yield_force"] = ((*forces.dims, "contact_point"), forces.values[..., None], attrs)
    return coords


def _outputs(attrs: dict[str, Any]) -> dict[str, Any]:
    """The outputs of a run of a pair as variables."""
    from pounding_risk.solver.pair import outputs  # with numba, which reading results does without

    about = {name: (output.unit, output.words) for name, output in outputs.RUN.items()}
    about |= {name: (unit, words) for name, (unit, words, _) in outputs.BUILDING.items()}
    values = {name: [value] for name, value in json.loads(attrs["outputs"]).items()}
    values |= json.loads(attrs["building_outputs"])
    return {
        name: (own_dims(name), np.array(value, np.int32 if name in COUNTS else float), described(*about[name]))
        for name, value in values.items()
    }
