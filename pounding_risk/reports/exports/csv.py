"""All numbers of a scan as CSV tables in a folder: one each for cases, interfaces, buildings, storeys and points."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk._common.letters import csv_text
from pounding_risk._common.written import write_folder
from pounding_risk.assessment.demands import UNDEFINED
from pounding_risk.motions.levels import LEVEL_AXIS
from pounding_risk.reports.exports import Options, Written
from pounding_risk.results.attributes import collapsed, flags_of
from pounding_risk.results.layout import AXES
from pounding_risk.results.variables import PLACES

WORDS = "tidy tables with units in their heads"
ENDINGS = ("",)
SOURCE = "results"
TAKES = ()
# Names of the tables by the places that their rows are of, beside the case.
TABLES = {
    (): "cases",
    ("interface",): "interfaces",
    ("contact_point",): "contact_points",
    ("building",): "buildings",
    ("building", "storey"): "storeys",
}
FREE = "_without_contact"  # added to the name of a table whose values are of motions and not of cases


def write(results: xr.Dataset, target: Path, options: Options) -> Written:
    """Write a table for each kind of place of a dataset, with every case."""
    tables = ((f"{name}.csv", table(results, variables)) for name, variables in grouped(results).items())
    fell = int(collapsed(results, without=True).sum()) if "status" in results else 0
    motions = counted(fell, "motion")
    note = f"in {motions} a storey collapses without contact: what these close without contact is that up to there"
    return Written(write_folder(target, tables), (note,) if fell else ())


def grouped(results: xr.Dataset) -> dict[str, list[str]]:
    """Variables of each table; a variable is in one."""
    groups: dict[str, list[str]] = {}
    for name, variable in results.data_vars.items():
        places = tuple(str(dim) for dim in variable.dims if dim in PLACES)
        is_of_cases = any(dim in (*AXES, LEVEL_AXIS) for dim in variable.dims) and "period" not in variable.dims
        if is_of_cases and places in TABLES:
            ending = "" if "gap" in variable.dims else FREE
            groups.setdefault(TABLES[places] + ending, []).append(str(name))
    return groups


def table(results: xr.Dataset, names: list[str]) -> str:
    """The text of a table: labels of each row, what its place has of its own, and the variables with their units."""
    first = results[names[0]]
    dims = [str(dim) for dim in first.dims]
    # The gap of the grid is that of one interface: each row has its own.
    places = [str(name) for name, coordinate in results.coords.items() if _is_of_places(coordinate, dims)]
    units = ((name, str(results[name].attrs.get("units", "1"))) for name in (*dims, *places, *names))
    rows: list[list[Any]] = [[name if unit == "1" else f"{name} [{unit}]" for name, unit in units]]
    labels = [results[dim].values.tolist() for dim in dims]
    columns = [results[name].broadcast_like(first).transpose(*dims).values.reshape(-1) for name in (*places, *names)]
    flags = [flags_of(results[name]) for name in (*places, *names)]
    is_there = _places_there(first, [results[name].transpose(*dims).values for name in names])
    for row, place in enumerate(np.ndindex(*first.shape)):
        if is_there[row]:
            numbers = [_cell(column[row], is_known) for column, is_known in zip(columns, flags, strict=True)]
            rows.append([*(label[k] for label, k in zip(labels, place, strict=True)), *numbers])
    return csv_text(rows)


def _is_of_places(coordinate: xr.DataArray, dims: list[str]) -> bool:
    """True for what the places of a table's rows have of their own, such as the gap of an interface; not for labels."""
    own_dims, places = set(coordinate.dims), set(dims) & set(PLACES)
    return coordinate.name not in dims and bool(places) and places <= own_dims <= set(dims)


def _places_there(array: xr.DataArray, columns: list[Any]) -> Any:
    """By row, whether its place is there: any of the columns has a value at it in some case. A storey may be none."""
    is_known = [np.isfinite(column) if column.dtype.kind == "f" else np.ones(column.shape, bool) for column in columns]
    cases = tuple(k for k, dim in enumerate(array.dims) if dim not in PLACES)
    is_there = np.any(is_known, axis=0).any(axis=cases, keepdims=True)
    return np.broadcast_to(is_there, array.shape).ravel()


def _cell(number: Any, meanings: dict[int, str]) -> str:
    """A value in full; empty where there is none, such as of a run that failed."""
    if meanings:
        return meanings[int(number)]
    if isinstance(number, np.integer) and number == UNDEFINED:
        return ""
    if isinstance(number, np.floating):
        return "" if np.isnan(number) else repr(float(number))
    return str(number)
