"""Restoring the axes of a dataset of `scan` in which one value along an axis was selected.

``dataset.sel(polarity="reversed")`` leaves the polarity as a label without an axis, and ``dataset.squeeze()`` the
interface of two buildings. Functions that read a dataset of `scan` rely on all axes of its cases and places, and call
`with_axes` first.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.layout import AXES, axes_of_cases
from pounding_risk.results.scene_axes import settled
from pounding_risk.results.upgrade import MARK, scene_tables, upgrade
from pounding_risk.results.variables import COORDINATES, PLACES, VARIABLES
from pounding_risk.units import shown

if TYPE_CHECKING:
    import xarray as xr

MAY_LACK = (PGA_AXIS, LEVEL_AXIS)  # a scan of one amplitude has no such axis


def with_axes(dataset: xr.Dataset, source: str = "the dataset") -> xr.Dataset:
    """The dataset with every axis of its cases and places; unchanged where none is missing, or it is not of `scan`.

    At one value along each axis of another number of the scene it is that of the scene which has these values.

    One of an older version is brought into the shape of this version. Where some interfaces of a row were selected, the
    contact points are those of these alone.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `scan`, or what ``sel`` or ``isel`` left of one.
    source : str
        The name of the dataset in error messages.

    Returns
    -------
    xarray.Dataset
        With axes of length 1 where values were selected.

    Raises
    ------
    PoundingError
        Where the label of an axis is lost (``drop=True``), where there are several values along an axis of another
        number of the scene, and where the buildings or interfaces that are left do not
        stand side by side.
    """
    if not hasattr(dataset, "data_vars"):
        raise PoundingError(
            f"{shown(dataset)} is neither a dataset nor a file of one; name what `scan` returned or wrote"
        )
    if MARK not in dataset.data_vars or "contact_model" not in dataset.variables:
        return dataset
    dataset = settled(dataset, source)
    _check_buildings(dataset, source)
    dataset = upgrade(dataset, source)
    axes = axes_of_cases(dataset)
    lost = [axis for axis in axes if axis not in {*dataset.dims, *dataset.coords} and axis not in MAY_LACK]
    if lost:
        raise PoundingError(
            f"{source}: has lost its {' and '.join(lost)}: select with a list, such as {lost[0]}=[...], or without "
            "drop=True, so that it is known what was selected"
        )
    missing = [dim for dim in (*axes, *PLACES) if dim not in dataset.dims and dim in dataset.coords]
    missing = [dim for dim in missing if dim not in MAY_LACK]
    if not missing:
        return _with_own_points(dataset)
    if apart := [axis for axis in missing if dataset[axis].ndim]:
        raise PoundingError(
            f"{source}: the labels of {', '.join(apart)} lie along another dimension; run the scan again"
        )
    labels = {axis: dataset[axis].variable for axis in missing}
    bare = dataset.drop_vars(missing)
    changed: dict[Any, Any] = {
        name: _expanded(
            variable, [dim for dim in missing if dim in dims_of(str(name), name in bare.coords)], (*axes, *PLACES)
        )
        for name, variable in bare.variables.items()
    }
    coords: dict[Any, Any] = {name: changed[name] for name in bare.coords if name not in bare.dims}
    coords |= {axis: label.set_dims({axis: 1}) for axis, label in labels.items()}
    return _with_own_points(bare.assign({name: changed[name] for name in bare.data_vars}).assign_coords(coords))


def dims_of(name: str, is_coordinate: bool) -> tuple[str, ...]:
    """The dimensions of a variable of this name; those of one that is not declared are axes of cases."""
    declared = (VARIABLES | COORDINATES).get(name)
    if declared is not None:
        return declared.dims
    if is_coordinate:
        return ()
    return AXES[:3] if name.endswith("_free") else AXES


def _expanded(variable: xr.Variable, axes: list[str], order: Sequence[str]) -> xr.Variable:
    """The variable with these axes added, of length 1, and all axes in this order."""
    sizes: dict[Any, int] = dict.fromkeys(axes, 1) | dict(variable.sizes)
    ordered = [dim for dim in order if dim in sizes]
    own = [dim for dim in variable.dims if dim not in ordered]
    return variable.set_dims({dim: sizes[dim] for dim in (*ordered, *own)}) if axes else variable


def _with_own_points(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset without the contact points of other interfaces, where neighbours were selected from a row."""
    names = [str(table.get("name")) for table in scene_tables(dataset, "building")]
    count, first = dataset.sizes.get("interface", 0), str(dataset["building"].values[0])
    if not {"interface", "contact_point"} <= set(dataset.dims) or first not in names or count >= len(names) - 1:
        return dataset
    places, start = dataset["contact_point_interface"], names.index(first)
    if places.values.max(initial=0) < count:  # they were selected
        return dataset
    mine = np.flatnonzero((places.values >= start) & (places.values < start + count))
    return dataset.isel(contact_point=mine).assign_coords(
        contact_point_interface=("contact_point", places.values[mine] - start, places.attrs)
    )


def _check_buildings(dataset: xr.Dataset, source: str) -> None:
    """Refuse a selection of buildings and interfaces that do not stand side by side."""
    count = dataset.sizes.get("building", 1)
    if count < 2:
        raise PoundingError(
            f"{source}: has one building left, and a gap is between two: select two neighbours, such as "
            "building=slice(0, 2)"
        )
    interfaces = dataset.sizes.get("interface", 1 if "interface" in dataset.coords else count - 1)
    if interfaces != count - 1:
        raise PoundingError(
            f"{source}: has {count} buildings and {interfaces} of the {count - 1} interfaces between them: select the "
            "buildings on both sides of each interface too, such as building=slice(0, 2) with interface=[0]"
        )
