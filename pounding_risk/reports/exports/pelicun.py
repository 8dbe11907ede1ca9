"""Demands of every building for pelicun, with and without contact, and fragilities: a folder of CSV files.

A row of demands is a motion of the scan, in the same order in both files of a building. Columns have pelicun's names of
demands: ``1-PFA-2-1`` is the peak floor acceleration of floor 2 in direction 1; floor 0 is the ground, whose peak is
PGA. The fragilities are against the intensity of the last column.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator
from io import StringIO
from itertools import product
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.demands import intensities
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports._curves import Known, identifier_of
from pounding_risk.reports.exports._pelicun_fragilities import (
    components_of,
    demand_name,
    fragility_table,
    fragility_words,
)
from pounding_risk.reports.exports._written import Asked, Written, write_folder
from pounding_risk.results.check import kind_of
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.results.opened import one_case

if TYPE_CHECKING:
    import xarray as xr

WORDS = "demands of each building with and without contact, and fragilities, for pelicun"
ENDINGS = ("",)
SOURCE = "results"
OF_DAMAGE = True
TAKES = ("of", "gap", "pga", "intensity_level", "intensity", "method")
Array = NDArray[np.float64]
# Largest acceleration of a floor and drift of a storey, of buildings with storeys and of single masses.
STOREYS = ("storey_acceleration", "storey_drift")
SINGLE_MASS = ("peak_floor_acceleration", "peak_displacement")


class Demand(NamedTuple):
    """A column of a file of demands."""

    name: str  # "1-PFA-2-1"
    unit: str  # of pelicun
    values: Array  # (motions,)


def write(results: xr.Dataset, target: Path, asked: Asked) -> Written:
    """Write the demands at one gap, contact model and F_E, those of the scene, and the fragilities that there are.

    Of a dataset of damage states fragilities alone. Raises PoundingError as `one_case`.
    """
    runs, told = _runs_or_why(results, asked)
    found = components_of(results, asked)
    tables: dict[str, str] = {}
    if runs is not None:
        told = list(_demand_tables(results, runs, found.measure, tables))
    told += found.told
    if found.measure is not None and found.components:
        tables["fragility.csv"] = fragility_table(found.measure, found.components)
        words = fragility_words(found.components, str(results.attrs.get("title", "")))
        tables["fragility.json"] = words
        told.append(
            f"components stand at location 0 in direction 1, where {demand_name(found.measure)} is their demand"
        )
    else:
        told.append("no fragilities are written")
    return Written(write_folder(target, tables.items()), tuple(told))


def _demand_tables(
    results: xr.Dataset, runs: xr.Dataset, measure: Known | None, tables: dict[str, str]
) -> Iterator[str]:
    """Enter the demands of each building in ``tables``, by the file's name, and yield sentences on them."""
    yield _case_words(runs)
    complete = _complete(runs)
    if not complete.all():
        yield f"{counted(int((~complete).sum()), 'run')} failed; their motions are in no file"
    intensity = () if measure is None else (_intensity(results, runs, measure),)
    for place, building in enumerate(map(str, runs["building"].values)):
        one = runs.isel(building=place)
        heights = _storey_heights(one)
        if heights is None:
            yield f"{building}: no storey drift ratios, as the scene gives it no heights"
        for ending, word in (("", "with"), ("_free", "without")):
            columns = [*_demands(one, ending, heights), *intensity]
            name = f"{identifier_of(building)}-{word}-contact.csv"
            tables[name] = table(runs, columns, complete)


def _intensity(results: xr.Dataset, runs: xr.Dataset, measure: Known) -> Demand:
    """The intensity of the motions at the amplitude of the runs."""
    axis = amplitude_axis(results)
    level = int(np.argmin(np.abs(results[axis].values - float(runs[axis])))) if axis in results.dims else 0
    unit = "mps" if measure.imt == "PGV" else "mps2"
    return Demand(demand_name(measure), unit, intensities(results, measure.word)[:, level])


def _runs_or_why(results: xr.Dataset, asked: Asked) -> tuple[xr.Dataset | None, list[str]]:
    """The runs whose demands are written, or why none are: curves of damage states need no amplitude, as in NRML."""
    if kind_of(results) == "damage":
        return None, ["demands are of results of scan; these are of damage states"]
    try:
        return _runs(results, asked), []
    except PoundingError as error:
        if asked.of != "damage" or asked.pga is not None or asked.intensity_level is not None:
            raise
        return None, [f"no demands are written, for which one amplitude is needed: {error}"]


def _runs(results: xr.Dataset, asked: Asked) -> xr.Dataset:
    """Every record and polarity at one case of the grid."""
    case = one_case(results, gap=asked.gap, pga=asked.pga, intensity_level=asked.intensity_level)
    axes = (amplitude_axis(results), "gap", "yield_force", "contact_model")
    return results.sel({axis: case[axis].values.item() for axis in axes if axis in results.dims})


def _case_words(runs: xr.Dataset) -> str:
    model, gap, force = str(runs["contact_model"].item()), float(runs["gap"]), float(runs["yield_force"])
    return f"demands are those at a gap of {1e3 * gap:.6g} mm, {model}, F_E {force:.6g} N"


def _complete(runs: xr.Dataset) -> NDArray[np.bool_]:
    """Motions whose run is complete, (motions,)."""
    status = runs["status"]
    meanings = str(status.attrs["flag_meanings"]).split()
    code = np.atleast_1d(status.attrs["flag_values"])[meanings.index("complete")]
    return np.asarray(_by_motion(status) == code)


def _by_motion(values: xr.DataArray) -> Array:
    return np.asarray(values.transpose("record", "polarity", ...).values.reshape(-1, *values.shape[2:]))


def _storey_heights(one: xr.Dataset) -> Array | None:
    """Height of each storey of a building [m]; None where its floors have no levels."""
    if "floor_level" in one.variables:
        levels = one["floor_level"].values
        levels = levels[np.isfinite(levels)]
    else:
        levels = np.atleast_1d(one["building_height"].values) if "building_height" in one.variables else np.empty(0)
    levels = levels[np.isfinite(levels)]
    return np.diff(levels, prepend=0.0) if levels.size else None


def _demands(one: xr.Dataset, ending: str, heights: Array | None) -> Iterator[Demand]:
    """The demands of a building: accelerations of the ground and its floors, drift ratios of its storeys."""
    ground = np.repeat(_ground(one), one.sizes["polarity"])
    yield Demand("1-PFA-0-1", "mps2", ground)
    several = "storey" in one.sizes and f"storey_acceleration{ending}" in one
    accelerations, drifts = (
        _by_motion(one[f"{name}{ending}"]).reshape(ground.size, -1) for name in (STOREYS if several else SINGLE_MASS)
    )
    floors = int(one["building_storeys"])
    for floor in range(floors):
        yield Demand(f"1-PFA-{floor + 1}-1", "mps2", accelerations[:, floor])
    if heights is not None:
        for storey in range(floors):
            yield Demand(f"1-PID-{storey + 1}-1", "rad", drifts[:, storey] / heights[storey])


def _ground(one: xr.Dataset) -> Array:
    """Peak ground acceleration of each record as it acts [m/s2]."""
    for name in ("record_pga_felt", "record_pga"):
        if name in one.variables:
            return np.asarray(one[name].values, dtype=float)
    raise PoundingError("the dataset has no peak ground accelerations of its records; scan the scene again")


def table(runs: xr.Dataset, columns: list[Demand], complete: NDArray[np.bool_]) -> str:
    """The text of a file of demands; rows are numbered as the motions of the scan are, with their names last."""
    out = StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(["", *(column.name for column in columns)])
    writer.writerow(["Units", *(column.unit for column in columns)])
    motions = product(runs["record"].values, runs["polarity"].values)
    for number, _ in enumerate(motions):
        if complete[number]:
            writer.writerow([number, *(repr(float(column.values[number])) for column in columns)])
    return out.getvalue()
