"""One cell of a grid: buildings, contact points with contact, force and yielding at each, and columns that are struck.

Read from a dataset of `scan`; nothing here runs a case. Lengths in m, forces in N.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isfinite
from typing import Any, NamedTuple

import numpy as np
import xarray as xr
from numpy.typing import NDArray

from pounding_risk import units
from pounding_risk._common.counted import counted
from pounding_risk.assessment.demands import UNDEFINED
from pounding_risk.errors import PoundingError
from pounding_risk.results.amplitudes import check_pga
from pounding_risk.results.files import open_scan
from pounding_risk.results.opened import Results, yield_forces
from pounding_risk.results.variables import NOT_RUN, UNPUSHED
from pounding_risk.units import GAP, YIELD_FORCE, say, say_in, si

Array = NDArray[np.float64]
POINT, COLUMN = "contact_point_", "column"
PLATEAU = 1.01  # times the strength: above it a force is not held at the strength, whatever rounding does
STOREY_HEIGHT = 3.0  # m, of a building of which no height is known


class BuildingShape(NamedTuple):
    """Name, floor levels and position of a building, as figures draw it."""

    name: str
    levels: tuple[float, ...]  # m above the ground, of each floor; of a rigid building the top alone
    position: str  # "end", "interior" or "alone"
    is_rigid: bool

    @property
    def height(self) -> float:
        """Level of the roof [m]."""
        return self.levels[-1]


class Touch(NamedTuple):
    """Contact over the motions at one contact point or interface; shares are of the runs that are complete."""

    runs: int
    contact: float  # share with contact; NaN where no run is complete
    yielding: float  # share that reaches the yield force; NaN where it is not defined
    impacts: float  # median number of impacts, where there is contact
    force: float  # N, median of the peak force, where there is contact


class ContactPoint(NamedTuple):
    """One contact point of a row: floors, kind and level, and the contact there."""

    name: str  # buildings, floors and, of floors that rotate, the place across the row
    interface: int
    left_floor: float
    right_floor: float
    kind: str  # "floor" or "column"
    level: float  # m above the ground
    touch: Touch


class RowCase(NamedTuple):
    """One gap, contact model, yield force and amplitude of a row, over all records and polarities."""

    results: xr.Dataset  # dimensions record and polarity, and the row's own
    buildings: tuple[BuildingShape, ...]
    gaps: tuple[float, ...]  # m, by interface
    points: tuple[ContactPoint, ...]
    touches: tuple[Touch, ...]  # by interface

    @property
    def meetings(self) -> tuple[ContactPoint, ...]:
        """The contact points as an elevation shows them: both ends of floors that rotate are one."""
        places = [point[1:6] for point in self.points]  # all but the name and the contact
        if len(set(places)) == len(places):
            return self.points
        outputs, meetings = _contact_columns(self.results, "contact_point", POINT), []
        for place in dict.fromkeys(places):
            ends = [index for index, end_place in enumerate(places) if end_place == place]
            count, yields, force = (column[ends] for column in outputs)
            failed = (count == UNDEFINED).any(axis=0)
            merged = np.where(failed, UNDEFINED, count.sum(axis=0)), yields.max(axis=0), np.fmax.reduce(force)
            meetings.append(self.points[ends[0]]._replace(touch=_touch(*map(np.ravel, merged))))
        return tuple(meetings)

    @property
    def motions(self) -> int:
        """Number of motions: records times polarities."""
        return self.results.sizes["record"] * self.results.sizes["polarity"]

    @property
    def interfaces(self) -> tuple[str, ...]:
        """Names of the interfaces, "left | right"."""
        return tuple(map(str, self.results["interface"].values))


def row_case(
    results: xr.Dataset,
    *,
    gap: float | str | None = None,
    contact_model: str | None = None,
    yield_force: float | str | None = None,
    pga: float | str | None = None,
    intensity_level: float | str | None = None,
) -> RowCase:
    """One cell of the grid: the nearest to the requested one, by default the scene's own.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`.
    gap : float or str, optional
        Gap [m, or text with a unit].
    contact_model : str, optional
        Name of a contact model of the grid.
    yield_force : float or str, optional
        Yield force F_E [N, or text with a unit].
    pga : float or str, optional
        Amplitude of the motions [m/s2, or text with a unit].
    intensity_level : float or str, optional
        The same in the measure of the grid [SI, or text with a unit], where that may be another than PGA.

    Returns
    -------
    RowCase
        Buildings, gaps, contact points, and what the motions do at each.

    Raises
    ------
    PoundingError
        For what is no dataset of `scan`, for one of several scenes, and for a contact model that the grid has not.
    """
    opened = open_scan(results)
    results = opened.dataset
    amplitudes, level = opened.amplitudes, pga if intensity_level is None else intensity_level
    if pga is not None:
        check_pga(amplitudes)
    cell = opened.scene_case
    if gap is not None:
        cell["gap"] = _nearest(results["gap"].values, si(gap, GAP, "gap"))
    if yield_force is not None:
        cell["yield_force"] = _nearest(results["yield_force"].values, si(yield_force, YIELD_FORCE, "yield_force"))
    if contact_model is not None:
        models = list(map(str, results["contact_model"].values))
        if contact_model not in models:
            raise PoundingError(f"contact model {contact_model!r} is not in the dataset, which has {', '.join(models)}")
        cell["contact_model"] = models.index(contact_model)
    if level is not None:
        level_value = si(level, amplitudes.measure.quantity, "pga" if intensity_level is None else "intensity_level")
        if amplitudes.axis in results.dims:
            cell[amplitudes.axis] = _nearest(np.array(amplitudes.values), level_value)
    gaps = opened.gaps.isel(gap=cell["gap"]).values
    case = results.isel(cell)
    touches = _touches(case, "interface")
    return RowCase(case, building_shapes(case), tuple(gaps.tolist()), _points(case, touches), touches)


def _nearest(axis_values: Array, value: float) -> int:
    return int(np.argmax(axis_values) if np.isinf(value) else np.abs(axis_values - value).argmin())


def building_shapes(case: xr.Dataset) -> tuple[BuildingShape, ...]:
    """Every building of a dataset; one without a height is as tall as its taller neighbour."""
    heights = case["building_height"].values.astype(float)
    levels = case["floor_level"].transpose("building", "storey").values
    storeys = case["building_storeys"].values
    shapes = []
    for i, name in enumerate(map(str, case["building"].values)):
        floors = levels[i][np.isfinite(levels[i])]
        if not floors.size:
            count = max(int(storeys[i]), 1)
            neighbours = [height for height in heights[max(i - 1, 0) : i + 2] if np.isfinite(height)]
            height = heights[i] if np.isfinite(heights[i]) else max(neighbours, default=STOREY_HEIGHT * count)
            floors = height * np.arange(1, count + 1) / count
        position = str(case["building_position"].values[i])
        shapes.append(BuildingShape(name, tuple(floors.tolist()), position, int(storeys[i]) == 0))
    return tuple(shapes)


def _points(case: xr.Dataset, interface_touches: tuple[Touch, ...]) -> tuple[ContactPoint, ...]:
    buildings = building_shapes(case)
    columns = [case[f"{POINT}{name}"].values for name in ("interface", "left_floor", "right_floor", "kind", "level")]
    # What is not known point by point is that of an interface with one point.
    point_touches = _touches(case, "contact_point", POINT) if f"{POINT}impact_count" in case else ()
    points = []
    for place, (interface, left, right, kind, level) in enumerate(zip(*columns, strict=True)):
        if not np.isfinite(level):
            # Two masses of which no height is given touch where the lower is drawn to end.
            level = min(buildings[int(interface) + side].height for side in (0, 1))
        touch = point_touches[place] if point_touches else interface_touches[int(interface)]
        name = str(case["contact_point"].values[place])
        points.append(ContactPoint(name, int(interface), float(left), float(right), str(kind), float(level), touch))
    return tuple(points)


def _touches(case: xr.Dataset, dim: str, prefix: str = "") -> tuple[Touch, ...]:
    """The contact at every interface, or with the ``prefix`` `POINT` at every contact point, along ``dim``."""
    columns = _contact_columns(case, dim, prefix)
    return tuple(_touch(*(column[place].ravel() for column in columns)) for place in range(case.sizes[dim]))


def _contact_columns(case: xr.Dataset, dim: str, prefix: str) -> list[NDArray[Any]]:
    """Counts of impacts, flags of yielding and peak forces, with ``dim`` first."""
    names = (f"{prefix}{name}" for name in ("impact_count", "yield_exceedance", "peak_contact_force"))
    return [case.variables[name].transpose(dim, ...).values for name in names]


def _touch(count: NDArray[Any], yields: NDArray[Any], force: Array) -> Touch:
    complete, touching, defined = count > UNDEFINED, count > 0, yields > UNDEFINED
    return Touch(
        int(complete.sum()),
        _mean(touching[complete]),
        _mean(yields[defined]),
        _median(count[touching]),
        _median(np.where(defined, force, np.nan)[touching]),  # a jump has no finite force
    )


def _mean(outputs: NDArray[Any]) -> float:
    return float(np.mean(outputs)) if outputs.size else float("nan")


def _median(outputs: Array) -> float:
    return float(np.median(outputs)) if outputs.size else float("nan")


def force_text(force: float) -> str:
    """A force in kN or MN with three digits; "no finite force" where it is not finite."""
    if not np.isfinite(force):
        return "no finite force"
    return say_in(force, "MN" if force >= 1e6 else "kN", 3)


def any_of_building(case: RowCase, name: str, building: int) -> Array:
    """By motion, 1 where a count or flag ``name`` is above 0 at an interface of this building, 0 elsewhere.

    NaN where the run failed, or where it is not defined at any of them, as yielding where no contact of the building
    has a finite F_E.
    """
    sides = [index for index in (building - 1, building) if 0 <= index < case.results.sizes["interface"]]
    if name == "yield_exceedance" and "contact_point_yield_force" in case.results.variables:
        is_beside = np.isin(case.results["contact_point_interface"].values, sides)
        if not np.isfinite(case.results["contact_point_yield_force"].values[is_beside]).any():
            return np.full(case.motions, np.nan)
    outputs = case.results.variables[name].isel(interface=sides).transpose("interface", "record", "polarity").values
    flat = outputs.reshape(len(sides), -1)
    answers = np.where((flat > 0).any(axis=0), 1.0, 0.0)
    return np.where((flat == UNDEFINED).all(axis=0), np.nan, answers)


def share_of_building(case: RowCase, name: str, building: int) -> float:
    """The share of the motions with a known answer in which `any_of_building` is 1; NaN where there is none."""
    answers = any_of_building(case, name, building)
    return _mean(answers[np.isfinite(answers)])


def yield_force_words(case: xr.Dataset) -> str:
    """F_E of the contacts of a case in words: of floors that meet, and of columns where these have another."""
    floors, columns = yield_forces(case)
    column_forces = [force for force in columns if isfinite(force) and force not in floors]
    if min(floors, default=inf) < inf:
        floors_text = f"F_E = {_range_words(floors)}"
        return f"{floors_text} (of columns {_range_words(column_forces)})" if column_forces else floors_text
    if not column_forces:
        return "without yielding"
    return f"F_E = {_range_words(column_forces)} of columns{', floors without yielding' if floors else ''}"


def _range_words(forces: Sequence[float]) -> str:
    ends = dict.fromkeys(f"{force / 1e3:.0f}" for force in (min(forces), max(forces)))
    return f"{' to '.join(ends).replace('inf', '∞')} kN"


# ------------------------------------------------------------------------------------------------ struck columns


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


def column_sentences(results: Results, level: int, gap: float) -> tuple[str, ...]:
    """Which floor strikes which column of one interface, how often, and what the model assumes; none without columns.

    ``level`` is the index of the amplitude; of a gap [m] the grid's nearest is read.
    """
    struck = struck_columns(results, level, gap)
    if not struck:
        return ()
    worst = max(struck, key=lambda column: (column.reached, column.touched, column.force))
    gaps = results.dataset["gap"].values
    width = say(float(gaps[_nearest(gaps, gap)]), GAP, 3)
    level_text = f", {say(worst.level, units.STOREY_HEIGHT, 3)} above the ground," if isfinite(worst.level) else ""
    pair = f"the columns of {worst.column}{level_text}"
    status = _case(results, level, gap)["status"].values
    if unpushed := int((status == UNPUSHED).sum()):
        words = f"{unpushed} of {counted(status.size, 'motion')} at {width} are {NOT_RUN}"
        return (f"{worst.floor} faces {pair.rstrip(',')}, and {words}: how often it strikes them is not known.",)
    if not worst.runs:
        return (f"{worst.floor} faces {pair} and no motion is run at {width}: how often it strikes them is not known.",)
    if not worst.touched:
        return (f"{worst.floor} faces {pair} and strikes them in none of {counted(worst.runs, 'motion')} at {width}.",)
    count = sum(column.touched > 0 for column in struck)
    extent = f" (columns are struck at {count} of {len(struck)} levels)" if len(struck) > 1 else ""
    hits = f"{worst.floor} strikes {pair} in {worst.touched} of {counted(worst.runs, 'motion')} at a gap of {width}"
    force, strength = say(worst.force, YIELD_FORCE, 3), say(worst.strength, YIELD_FORCE, 3)
    if not isfinite(worst.strength):
        note = f"No strength of these columns is given (column_strength): forces up to {force} are taken as borne."
        return f"{hits}{extent}.", note
    if not worst.reached:
        return (f"{hits}{extent}; the largest force, {force}, stays below their strength of {strength}.",)
    first = f"{hits}; their strength of {strength} is reached in {worst.reached} of them{extent}."
    if worst.force > PLATEAU * worst.strength:
        return first, (
            f"The model does not hold the force at that strength: it goes up to {force}, which such columns do not "
            "carry, and assumes that they stay whole, which is unsafe."
        )
    springs = "" if "permanent_set" in results.scene.get("effects", {}) else " and, by most laws, spring back whole"
    return first, (
        f"Beyond that strength the model assumes that struck columns keep it at any displacement{springs}: unsafe for "
        "brittle columns, which lose strength, and may lose the floors above."
    )


def _case(results: Results, level: int, gap: float) -> xr.Dataset:
    """The motions at a level and the nearest gap, with the scene's own contact model and F_E."""
    cell = results.scene_contact | {"gap": _nearest(results.dataset["gap"].values, gap)}
    return results.at_level(level).dataset.isel(cell)


def struck_columns(results: Results, level: int, gap: float) -> tuple[StruckColumn, ...]:
    """Every contact of a floor with a column of one interface, from the lowest, at the scene's own model and F_E."""
    dataset = results.dataset
    if f"{POINT}kind" not in dataset.variables or "contact_point" not in dataset.dims:
        return ()
    case = _case(results, level, gap)
    names = list(map(str, case["building"].values))
    prefix = POINT if f"{POINT}impact_count" in case.variables else ""  # else it is the interface's one point
    columns = []
    for place in np.flatnonzero(case[f"{POINT}kind"].values.astype(str) == COLUMN):
        point = case.isel(contact_point=int(place))
        counts, yields, forces = (
            point[f"{prefix}{name}"].values.ravel()
            for name in ("impact_count", "yield_exceedance", "peak_contact_force")
        )
        floors = [float(point[f"{POINT}{side}_floor"]) for side in ("left", "right")]
        column = 0 if floors[0] % 1.0 else 1
        striker, struck_name = names[1 - column], names[column]
        has_storeys = int(case["building_storeys"].values[1 - column]) > 1
        is_touched = counts > 0
        columns.append(
            StruckColumn(
                f"Floor {floors[1 - column]:g} of {striker}" if has_storeys else f"The floor of {striker}",
                f"storey {int(floors[column]) + 1} of {struck_name}",
                float(point[f"{POINT}level"]),
                float(point[f"{POINT}yield_force"]) if f"{POINT}yield_force" in case.variables else np.inf,
                int((counts != UNDEFINED).sum()),
                int(is_touched.sum()),
                int((is_touched & (yields > 0)).sum()),
                float(np.nanmax(forces[is_touched], initial=0.0)),
            )
        )
    return tuple(columns)
