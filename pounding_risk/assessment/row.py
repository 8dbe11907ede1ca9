"""One cell of a grid: buildings and contact points, and contact, force and yielding over the motions at each.

Read from a dataset of `scan`; nothing here runs a case. Lengths in m, forces in N.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS
from pounding_risk.results.files import open_scan
from pounding_risk.results.opened import Results
from pounding_risk.units import GAP, YIELD_FORCE, say_in, si

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
UNDEFINED = -1  # counts and flags of a failed run
POINT = "contact_point_"
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
    """One cell of the grid: the nearest to what is asked, by default the scene's own.

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
    gap = None if gap is None else si(gap, GAP, "gap")
    yield_force = None if yield_force is None else si(yield_force, YIELD_FORCE, "yield_force")
    amplitudes = opened.amplitudes
    if pga is not None and amplitudes.axis == LEVEL_AXIS:
        opened.level(pga)  # refuses it
    asked = pga if intensity_level is None else intensity_level
    level = None if asked is None else si(asked, amplitudes.measure.quantity, "pga" if pga else "intensity_level")
    cell = {
        "gap": opened.scene_place if gap is None else _nearest(results["gap"].values, gap),
        "yield_force": _nearest(
            results["yield_force"].values, opened.scene_force if yield_force is None else yield_force
        ),
        "contact_model": _model(results, contact_model),
    }
    if amplitudes.axis in results.dims:
        cell[amplitudes.axis] = opened.scene_level if level is None else _nearest(np.array(amplitudes.values), level)
    gaps = opened.gaps.isel(gap=cell["gap"]).values
    shown = results.isel(cell)
    return RowCase(shown, building_shapes(shown), tuple(gaps.tolist()), _points(shown), _touches(shown, "interface"))


def _nearest(values: Array, wanted: float) -> int:
    if np.isinf(wanted):
        return int(np.argmax(values))
    return int(np.abs(values - wanted).argmin())


def _model(results: xr.Dataset, asked: str | None) -> int:
    known = list(map(str, results["contact_model"].values))
    asked = Results(results).scene_model if asked is None else asked
    if asked not in known:
        raise PoundingError(f"contact model {asked!r} is not in the dataset, which has {', '.join(known)}")
    return known.index(asked)


def building_shapes(shown: xr.Dataset) -> tuple[BuildingShape, ...]:
    """Every building of a dataset; one without a height is as tall as its taller neighbour."""
    heights = shown["building_height"].values.astype(float)
    levels = shown["floor_level"].transpose("building", "storey").values
    storeys = shown["building_storeys"].values
    shapes = []
    for at, name in enumerate(map(str, shown["building"].values)):
        floors = levels[at][np.isfinite(levels[at])]
        if not floors.size:
            count = max(int(storeys[at]), 1)
            beside = [height for height in heights[max(at - 1, 0) : at + 2] if np.isfinite(height)]
            height = heights[at] if np.isfinite(heights[at]) else max(beside, default=STOREY_HEIGHT * count)
            floors = height * np.arange(1, count + 1) / count
        position = str(shown["building_position"].values[at])
        shapes.append(BuildingShape(name, tuple(floors.tolist()), position, int(storeys[at]) == 0))
    return tuple(shapes)


def _points(shown: xr.Dataset) -> tuple[ContactPoint, ...]:
    buildings = building_shapes(shown)
    columns = [shown[f"contact_point_{name}"].values for name in ("interface", "left_floor", "right_floor", "kind")]
    points, of_interfaces = [], _touches(shown, "interface")
    # What is not told point by point is that of an interface with one point.
    of_points = _touches(shown, "contact_point", POINT) if f"{POINT}impact_count" in shown else ()
    for at, (interface, left, right, kind) in enumerate(zip(*columns, strict=True)):
        level = float(shown["contact_point_level"].values[at])
        if not np.isfinite(level):
            # Two masses of which no height is given touch where the lower is drawn to end.
            level = min(buildings[int(interface) + side].height for side in (0, 1))
        touch = of_points[at] if of_points else of_interfaces[int(interface)]
        points.append(ContactPoint(int(interface), float(left), float(right), str(kind), level, touch))
    return tuple(points)


def _touches(shown: xr.Dataset, dim: str, prefix: str = "") -> tuple[Touch, ...]:
    """The contact at every interface, or with the ``prefix`` `POINT` at every contact point, along ``dim``."""
    names = (f"{prefix}{name}" for name in ("impact_count", "yield_exceedance", "peak_contact_force"))
    columns = [shown.variables[name].transpose(dim, ...).values for name in names]
    return tuple(_touch(*(column[at].ravel() for column in columns)) for at in range(shown.sizes[dim]))


def _touch(count: NDArray[Any], yields: NDArray[Any], force: Array) -> Touch:
    complete, touching, defined = count > UNDEFINED, count > 0, yields > UNDEFINED
    return Touch(
        int(complete.sum()),
        _mean(touching[complete]),
        _mean(yields[defined]),
        _median(count[touching]),
        _median(force[touching]),
    )


def _mean(values: NDArray[Any]) -> float:
    return float(np.mean(values)) if values.size else float("nan")


def _median(values: Array) -> float:
    known = values[np.isfinite(values)]
    return float(np.median(known)) if known.size else float("nan")


def force_text(force: float) -> str:
    """A force in kN or MN with three digits; "no force" where it is not finite."""
    if not np.isfinite(force):
        return "no force"
    return say_in(force, "MN" if force >= 1e6 else "kN", 3)


def any_of_building(case: RowCase, name: str, building: int) -> Array:
    """By motion, 1 where a count or flag ``name`` is above 0 at an interface of this building, 0 elsewhere.

    NaN where the run failed, or where it is not defined at any of them.
    """
    beside = [at for at in (building - 1, building) if 0 <= at < case.results.sizes["interface"]]
    values = case.results.variables[name].isel(interface=beside).transpose("interface", "record", "polarity").values
    flat = values.reshape(len(beside), -1)
    answers = np.where((flat > 0).any(axis=0), 1.0, 0.0)
    return np.where((flat == UNDEFINED).all(axis=0), np.nan, answers)


def share_of_building(case: RowCase, name: str, building: int) -> float:
    """The share of the motions with a known answer in which `any_of_building` is 1; NaN where there is none."""
    answers = any_of_building(case, name, building)
    return _mean(answers[np.isfinite(answers)])
