"""Demands of every building for pelicun, with and without contact, and fragilities: a folder of CSV files.

A row of demands is a motion of the scan, in the same order in both files of a building. Columns have pelicun's names of
demands: ``1-PFA-2-1`` is the peak floor acceleration of floor 2 in direction 1; floor 0 is the ground, whose peak is
PGA.

Limit states of the fragilities are against the intensity of the ground (``PGA``, ``SA_0.5``, ``PGV``), which is the
last column of the demands, at location 0 in direction 1: components stand there. Directional, since pelicun multiplies
what is not by 1.2 for two directions. The file has the head of its Damage and Loss Model Library, with words beside it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.letters import csv_text
from pounding_risk._common.written import write_folder
from pounding_risk.assessment.intensities import intensities, resolved_intensity
from pounding_risk.assessment.row import yield_force_words
from pounding_risk.errors import PoundingError
from pounding_risk.reports.exports import Options, Written
from pounding_risk.reports.exports import _fragilities as fragilities
from pounding_risk.reports.exports._fragilities import Fragilities, Function, Intensity, identifier_of
from pounding_risk.results.attributes import flags_of, isolated_of, rotating_buildings, rotating_words
from pounding_risk.results.check import kind_of
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.results.opened import Results, one_case
from pounding_risk.results.variables import NOT_RUN, UNPUSHED

WORDS = "demands of each building with and without contact, and fragilities, for pelicun"
ENDINGS = ("",)
SOURCE = "results"
OF_DAMAGE = True
TAKES = ("of", "gap", "pga", "intensity_level", "intensity", "method")
Array = NDArray[np.float64]
# Largest acceleration of a floor and drift of a storey, of buildings with storeys and of single masses.
STOREYS = ("storey_acceleration", "storey_drift")
SINGLE_MASS = ("peak_floor_acceleration", "peak_displacement")
PREFIX = "PND"  # of pounding; the libraries of pelicun have no such components
HEAD = ("ID", "Incomplete", "Demand-Type", "Demand-Unit", "Demand-Offset", "Demand-Directional")
OF_STATE = ("Family", "Theta_0", "Theta_1", "DamageStateWeights")
UNITS = {"g": "g", "cm/s": "cmps"}  # of intensities, in pelicun


class Demand(NamedTuple):
    """A column of a file of demands."""

    name: str  # "1-PFA-2-1"
    unit: str  # of pelicun
    values: Array  # (motions,)


def write(results: xr.Dataset, target: Path, options: Options) -> Written:
    """Write the demands at one gap, contact model and F_E, those of the scene, and the fragilities that there are.

    Of a dataset of damage states fragilities alone. Raises PoundingError as `one_case`.
    """
    runs, notes = _runs_or_why(results, options)
    measure, functions, left_out = _components(results, options)
    tables: dict[str, str] = {}
    if runs is not None:
        notes = list(_demand_tables(results, runs, measure, tables))
    notes += left_out
    if measure is not None and functions:
        tables["fragility.csv"] = _fragility_table(measure, functions)
        tables["fragility.json"] = _fragility_words(functions, str(results.attrs.get("title", "")))
        notes.append(f"components stand at location 0 in direction 1, where {_demand_name(measure)} is their demand")
    else:
        notes.append("no fragilities are written")
    return Written(write_folder(target, tables.items()), tuple(notes))


# ------------------------------------------------------------------------------------------------ demands


def _runs_or_why(results: xr.Dataset, options: Options) -> tuple[xr.Dataset | None, list[str]]:
    """Every record and polarity at one case of the grid, or why none is written.

    Curves of damage states need no amplitude, as in NRML.
    """
    if kind_of(results) == "damage":
        return None, ["demands are of results of scan; these are of damage states"]
    try:
        case = one_case(results, gap=options.gap, pga=options.pga, intensity_level=options.intensity_level)
    except PoundingError as error:
        if options.of != "damage" or options.pga is not None or options.intensity_level is not None:
            raise
        return None, [f"no demands are written, for which one amplitude is needed: {error}"]
    axes = (amplitude_axis(results), "gap", "yield_force", "contact_model")
    return results.sel({axis: case[axis].values.item() for axis in axes if axis in results.dims}), []


def _demand_tables(
    results: xr.Dataset, runs: xr.Dataset, measure: Intensity | None, tables: dict[str, str]
) -> Iterator[str]:
    """Enter the demands of each building in ``tables``, by the file's name, and yield sentences on them."""
    yield f"demands are those at {_case_words(runs)}"
    for building in isolated_of(results):
        yield f"{building}: 1-PFA-1-1 is of the slab on isolators, and 1-PID-1-1 of the isolators over its height"
    yield from map(rotating_words, rotating_buildings(Results(results).scene))
    status = runs["status"]
    (code,) = (code for code, word in flags_of(status).items() if word == "complete")
    complete = _by_motion(status) == code
    is_known = complete | (_by_motion(status) == UNPUSHED)  # whose motion without contact is known
    if not complete.all():
        unpushed = int((status == UNPUSHED).sum())
        if failed := int((~complete).sum()) - unpushed:
            yield f"{counted(failed, 'run')} failed; their motions are in no file"
        if unpushed:
            yield f"{counted(unpushed, 'case')} {NOT_RUN}: no demands with contact are written"
    intensity = []
    if measure is not None:
        axis = amplitude_axis(results)
        level = int(np.argmin(np.abs(results[axis].values - float(runs[axis])))) if axis in results.dims else 0
        unit = "mps" if measure.imt == "PGV" else "mps2"
        intensity.append(Demand(_demand_name(measure), unit, intensities(Results(results), measure.word)[:, level]))
    for place, building in enumerate(map(str, runs["building"].values)):
        part = runs.isel(building=place)
        heights = _storey_heights(part)
        if heights is None:
            yield f"{building}: no storey drift ratios, as the scene gives it no heights"
        for ending, word in (("", "with"), ("_free", "without")):
            if not ending and Results(runs).unpushed:
                continue  # of the motions that do not collide alone
            columns = [*_demands(part, ending, heights), *intensity]
            # Rows are numbered as the motions of the scan are.
            tables[f"{identifier_of(building)}-{word}-contact.csv"] = csv_text(
                [
                    ["", *(column.name for column in columns)],
                    ["Units", *(column.unit for column in columns)],
                    *([k, *(repr(float(each.values[k])) for each in columns)] for k in np.flatnonzero(is_known)),
                ]
            )


def _case_words(runs: xr.Dataset) -> str:
    """Gaps of all interfaces, contact model and yield force of one case."""
    gaps = runs["interface_gap" if "interface_gap" in runs.variables else "gap"].values
    span = " to ".join(f"{1e3 * gap:.6g}" for gap in dict.fromkeys((gaps.min(), gaps.max())))
    words = f"{'a gap' if gaps.min() == gaps.max() else 'gaps'} of {span} mm, {runs['contact_model'].item()}"
    return f"{words}, {yield_force_words(runs)}"


def _by_motion(cases: xr.DataArray) -> Array:
    """Values by record and polarity as one axis, (motions, ...)."""
    return np.asarray(cases.transpose("record", "polarity", ...).values.reshape(-1, *cases.shape[2:]))


def _storey_heights(part: xr.Dataset) -> Array | None:
    """Height of each storey of a building [m]; None where its floors have no levels."""
    name = next((name for name in ("floor_level", "building_height") if name in part.variables), None)
    levels = np.empty(0) if name is None else np.atleast_1d(part[name].values)
    levels = levels[np.isfinite(levels)]
    return np.diff(levels, prepend=0.0) if levels.size else None


def _demands(part: xr.Dataset, ending: str, heights: Array | None) -> Iterator[Demand]:
    """The demands of a building: accelerations of the ground and its floors, drift ratios of its storeys."""
    peaks = next((name for name in ("record_pga_felt", "record_pga") if name in part.variables), None)
    if peaks is None:
        raise PoundingError("the dataset has no peak ground accelerations of its records; scan the scene again")
    ground = np.repeat(np.asarray(part[peaks].values, dtype=float), part.sizes["polarity"])
    yield Demand("1-PFA-0-1", "mps2", ground)
    several = "storey" in part.sizes and f"storey_acceleration{ending}" in part
    accelerations, drifts = (
        _by_motion(part[f"{name}{ending}"]).reshape(ground.size, -1) for name in (STOREYS if several else SINGLE_MASS)
    )
    floors = int(part["building_storeys"])
    for floor in range(floors):
        yield Demand(f"1-PFA-{floor + 1}-1", "mps2", accelerations[:, floor])
    if heights is not None:
        for storey in range(floors):
            yield Demand(f"1-PID-{storey + 1}-1", "rad", drifts[:, storey] / heights[storey])


# ------------------------------------------------------------------------------------------------ fragilities


def _components(results: xr.Dataset, options: Options) -> tuple[Intensity | None, dict[str, Function], list[str]]:
    """The components of contact, yielding and damage states, or of the one kind of the options, and what is left out.

    They go by identifier, against one intensity. Raises PoundingError for an intensity that pelicun does not know, and
    where the one kind has none.
    """
    is_damage = kind_of(results) == "damage"
    has_states = is_damage or bool(Results(results).scene.get("damage"))
    kinds: Sequence[str] = fragilities.KINDS if has_states else fragilities.KINDS[:2]
    kinds = (options.of,) if options.of else kinds[2:] if is_damage else kinds
    if options.intensity is not None and not is_damage:
        fragilities.intensity_of(resolved_intensity(Results(results), options.intensity))
    measure, named, notes = None, [], []
    faults: list[PoundingError] = []
    for kind in kinds:
        for side in ("with", "without") if kind == "damage" else ("with",):
            # The amplitude of demands does not matter to curves of damage; a method is of these alone.
            options_of_kind: dict[str, Any] = {"method": None}
            if kind == "damage":
                options_of_kind = {"without": side == "without", "pga": None, "intensity_level": None}
            try:
                fitted = fragilities.fragilities_of(results, options._replace(of=kind, **options_of_kind))
            except PoundingError as error:
                faults.append(error)
                notes.append(f"{kind}{' without pounding' if side == 'without' else ''}: {error}")
                continue
            measure = fitted.measure
            notes += fitted.notes
            named += list(_named(fitted, kind, side))
    if faults and not named and len(kinds) == 1:
        raise faults[0]
    names = fragilities.distinct(name for name, _ in named)
    functions = {name: function for name, (_, function) in zip(names, named, strict=True)}
    return measure, functions, list(dict.fromkeys(notes))


def _named(found: Fragilities, kind: str, side: str) -> Iterator[tuple[str, Function]]:
    """Functions by an identifier without "-", with which pelicun separates the location and direction."""
    for model in found.models:
        for function in model.functions:
            place = (model.identifier, side) if kind == "damage" else (function.identifier,)
            yield ".".join((PREFIX, kind, *place)).replace("-", "_"), function


def _demand_name(measure: Intensity) -> str:
    """The column of a file of demands that the components want, "1-SA_0.5-0-1"."""
    return f"1-{measure.imt.replace('(', '_').rstrip(')')}-0-1"


def _fragility_table(measure: Intensity, functions: dict[str, Function]) -> str:
    """The text of the file of fragilities."""
    demand = {"PGA": "Peak Ground Acceleration", "PGV": "Peak Ground Velocity"}.get(
        measure.imt, f"Spectral Acceleration|{measure.imt[3:-1]}"
    )
    most = max(len(function.curves) for function in functions.values())
    rows = [[*HEAD, *(f"LS{number}-{name}" for number in range(1, most + 1) for name in OF_STATE)]]
    for name, function in functions.items():
        cells: list[Any] = [name, 0, demand, UNITS[measure.unit], 0, 1]
        for curve in function.curves:
            cells += ["lognormal", repr(curve.median), repr(curve.dispersion), ""]
        rows.append(cells + [""] * (len(rows[0]) - len(cells)))
    return csv_text(rows)


def _fragility_words(functions: dict[str, Function], title: str) -> str:
    """The text of the file beside it, which says what each component and its states are, as pelicun's libraries do."""
    words: dict[str, dict[str, Any]] = {
        "_GeneralInformation": {
            "ShortName": "pounding-risk",
            "Description": f"Pounding of adjacent buildings: {title}. Each component has the quantity 1 EA.",
            "Version": "1.0",
        }
    }
    for name, function in functions.items():
        words[name] = {
            "Description": function.curves[0].words,
            "SuggestedComponentBlockSize": "1 EA",
            "RoundUpToIntegerQuantity": "True",
            "LimitStates": {
                f"LS{number}": {f"DS{number}": {"Description": f"{curve.state}: {curve.words}; {curve.runs} runs"}}
                for number, curve in enumerate(function.curves, start=1)
            },
        }
    return f"{json.dumps(words, indent=2, ensure_ascii=False)}\n"
