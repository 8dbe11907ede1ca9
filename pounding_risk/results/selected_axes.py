"""Restoring the axes of a dataset of `scan` in which one value along an axis was selected.

``dataset.sel(polarity="reversed")`` leaves the polarity as a label without an axis. Functions that read a dataset of
`scan` rely on all axes of its cases, and call `with_axes` first.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from pounding_risk.errors import PoundingError
from pounding_risk.results.layout import AXES
from pounding_risk.units import shown

if TYPE_CHECKING:
    import xarray as xr

MARK = "impact_count"  # a case variable of every dataset of a scan
MAY_LACK = ("pga",)  # a scan of one amplitude has no such axis
OF_COORDINATES = {"interface_gap": ("gap",), "contact_point_yield_force": ("yield_force",)}


def with_axes(dataset: xr.Dataset, source: str = "the dataset") -> xr.Dataset:
    """The dataset with every axis of its cases; unchanged where none is missing, or where it is not of `scan`.

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
        Where the label of an axis is lost (``drop=True``), and where the buildings or interfaces that are left do not
        stand side by side.
    """
    if not hasattr(dataset, "data_vars"):
        raise PoundingError(
            f"{shown(dataset)} is neither a dataset nor a file of one; name what `scan` returned or wrote"
        )
    if MARK not in dataset.data_vars or "contact_model" not in dataset.variables:
        return dataset
    _check_buildings(dataset, source)
    missing = [axis for axis in AXES if axis not in dataset.dims and axis not in MAY_LACK]
    lost = [axis for axis in missing if axis not in dataset.coords]
    if lost:
        raise PoundingError(
            f"{source}: has lost its {' and '.join(lost)}: select with a list, such as {lost[0]}=[...], or without "
            "drop=True, so that it is known what was selected"
        )
    if not missing:
        return dataset
    labels = {axis: dataset[axis].variable for axis in missing}
    bare = dataset.drop_vars(missing)
    changed: dict[Any, Any] = {
        name: _expanded(variable, [axis for axis in missing if axis in axes_of(str(name), name in bare.coords)])
        for name, variable in bare.variables.items()
    }
    coords: dict[Any, Any] = {name: changed[name] for name in bare.coords if name not in bare.dims}
    coords |= {axis: label.set_dims({axis: 1}) for axis, label in labels.items()}
    return bare.assign({name: changed[name] for name in bare.data_vars}).assign_coords(coords)


def axes_of(name: str, is_coordinate: bool) -> tuple[str, ...]:
    """The axes of cases that a variable of this name has."""
    if name.startswith("record_"):
        return AXES[:1]
    if is_coordinate:
        return OF_COORDINATES.get(name, ())
    return AXES[:3] if name.endswith("_free") else AXES


def _expanded(variable: xr.Variable, axes: list[str]) -> xr.Variable:
    """The variable with these axes added, of length 1, and all axes in order."""
    sizes: dict[Any, int] = dict.fromkeys(axes, 1) | dict(variable.sizes)
    first = [axis for axis in AXES if axis in sizes]
    own = [dim for dim in variable.dims if dim not in AXES]
    return variable.set_dims({dim: sizes[dim] for dim in (*first, *own)}) if axes else variable


def _check_buildings(dataset: xr.Dataset, source: str) -> None:
    """Refuse a selection of buildings and interfaces that do not stand side by side."""
    count = dataset.sizes.get("building", 1)
    if count < 2:
        raise PoundingError(
            f"{source}: has one building left, and a gap is between two: select two neighbours, such as "
            "building=slice(0, 2)"
        )
    interfaces = dataset.sizes.get("interface", 1 if "interface" in dataset.coords or count == 2 else count - 1)
    if interfaces != count - 1:
        raise PoundingError(
            f"{source}: has {count} buildings and {interfaces} of the {count - 1} interfaces between them: select the "
            "buildings on both sides of each interface too, such as building=slice(0, 2) with interface=[0]"
        )
