"""Versions of datasets: an older one is read as if this version had written it.

Version 1, which has no attribute of its version, has no axis ``interface`` in a scan of two single masses, nor the
coordinates of its interface, contact point and storeys. No solver is imported.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Callable
from math import nan
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.contact_points import Point, automatic_points
from pounding_risk.models.structures.sdof import Building
from pounding_risk.results.attributes import tables_of
from pounding_risk.results.places import place_coordinates
from pounding_risk.results.run_upgrade import is_run, upgraded_run
from pounding_risk.results.variables import VARIABLES
from pounding_risk.units import DAMPING, HEIGHT, MASS, PERIOD, Quantity, QuantityError, parse, shown

if TYPE_CHECKING:
    import xarray as xr

VERSION = "dataset_version"  # the attribute
DATASET_VERSION = 2
MARK = "impact_count"  # a case variable of every dataset of a scan
Widen = Callable[["xr.Variable", str], "xr.Variable"]


def widened(variable: xr.Variable, dim: str) -> xr.Variable:
    """The variable with another axis of length 1 behind the others."""
    return variable.drop_encoding().set_dims({**variable.sizes, dim: 1})


def upgrade(dataset: xr.Dataset, whose: str = "the dataset", widen: Widen = widened) -> xr.Dataset:
    """The dataset in the shape of `DATASET_VERSION`; numbers stay as they are.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of any version, or what a selection left of one.
    whose : str
        The name of the dataset in error messages.
    widen : callable
        Gives a variable another axis of length 1, as `widened` does, which reads its values.

    Returns
    -------
    xarray.Dataset
        The same dataset where nothing is to be done.

    Raises
    ------
    PoundingError
        For a dataset of a newer version.
    """
    version = dataset.attrs.get(VERSION, 1)
    if not isinstance(version, int | np.integer) or version < 1:
        raise PoundingError(
            f"{whose}: the attribute {VERSION} is {shown(version)}, not a whole number from 1 on: the file was changed "
            "since it was written; take the one that scan wrote"
        )
    if version > DATASET_VERSION:
        raise PoundingError(
            f"{whose}: is a dataset of version {version}, and this version of pounding-risk reads those up to "
            f"{DATASET_VERSION}; run: pip install --upgrade pounding-risk"
        )
    if version == 1 and is_run(dataset):
        whole = upgraded_run(dataset, _buildings(dataset), widen).assign_attrs({VERSION: DATASET_VERSION})
        whole.set_close(dataset.close)
        return whole
    if MARK not in dataset.data_vars or "contact_model" not in dataset.variables:
        return dataset  # of another command
    whole = _with_interface(dataset, widen) if _lacks_interface(dataset) else dataset
    if whole is dataset and version == DATASET_VERSION:
        return dataset
    version = np.int64(DATASET_VERSION)  # of the type that netCDF gives
    whole = whole.assign_attrs({VERSION: version, **_stiffnesses(dataset)})
    whole.set_close(dataset.close)
    return whole


def _lacks_interface(dataset: xr.Dataset) -> bool:
    """True for two buildings without their interface."""
    is_pair = "building" in dataset.coords and dataset.sizes.get("building") == 2
    return is_pair and "interface" not in {*dataset.dims, *dataset.variables}


def _with_interface(dataset: xr.Dataset, widen: Widen) -> xr.Dataset:
    coords = _places(dataset)
    by_interface = {
        name: widen(variable, "interface")
        for name, variable in dataset.data_vars.variables.items()
        if name in VARIABLES and "interface" in VARIABLES[str(name)].dims
    }
    return dataset.assign(by_interface).assign_coords(
        {name: coordinate for name, coordinate in coords.items() if name not in dataset.variables}
    )


def _places(dataset: xr.Dataset) -> dict[str, Any]:
    """The coordinates of the places of two single masses."""
    left, right = buildings = _buildings(dataset)
    points = [Point(0, *meeting) for meeting in automatic_points(left, right)]
    forces = np.atleast_1d(dataset["yield_force"].values) if "yield_force" in dataset.coords else np.empty(0)
    coords = place_coordinates(buildings, points, forces[:, None])
    if "yield_force" not in dataset.dims:  # one was selected, or its labels are lost
        dims, values, attrs = coords.pop("contact_point_yield_force")
        coords |= {"contact_point_yield_force": (dims[1:], values[0], attrs)} if len(values) else {}
    return coords


def _buildings(dataset: xr.Dataset) -> list[Building]:
    """The buildings of a dataset as single masses, as far as its scene describes them."""
    tables = {str(table.get("name")): table for table in scene_tables(dataset, "building")}
    return [_building(name, tables.get(name, {})) for name in map(str, dataset["building"].values)]


def _building(name: str, table: dict[str, Any]) -> Building:
    """A building of the scene; NaN for a number that was lost or damaged, and no height."""
    height = _number(table, "height", HEIGHT, 0.0)
    if table.get("rigid") is True:
        return Building.rigid(name)._replace(height=height)
    mass, period = (_number(table, key, quantity) for key, quantity in (("mass", MASS), ("period", PERIOD)))
    return Building(name, mass, period, _number(table, "damping", DAMPING), height=height)


def _number(table: dict[str, Any], key: str, quantity: Quantity, otherwise: float = nan) -> float:
    try:
        return parse(table[key], quantity)
    except (KeyError, QuantityError):
        return otherwise


def scene_tables(dataset: xr.Dataset, section: str) -> list[dict[str, Any]]:
    """Tables of the scene of a dataset; none where it was lost or damaged, which `check_scan` tells."""
    try:
        tables = tables_of(dataset.attrs["scene_resolved"])[section]
        return [table for table in tables if isinstance(table, dict)]
    except (KeyError, TypeError, AttributeError, tomllib.TOMLDecodeError, RecursionError):
        return []


def _stiffnesses(dataset: xr.Dataset) -> dict[str, str]:
    """The attribute with the stiffness of each contact model, interface by interface."""
    try:
        by_model = json.loads(dataset.attrs["stiffness"])
        listed = {name: one if isinstance(one, list) else [one] for name, one in by_model.items()}
    except (KeyError, TypeError, AttributeError, ValueError, RecursionError):
        return {}
    return {"stiffness": json.dumps(listed, ensure_ascii=False, sort_keys=True)}
