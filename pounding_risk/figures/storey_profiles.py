"""Figure of storey profiles with and without contact: drift, shear, acceleration and ductility against height."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import RowCase, any_of_building
from pounding_risk.errors import PoundingError
from pounding_risk.figures.elevation import heading
from pounding_risk.figures.style import QUIET, STYLES, blank, legend_below, plain
from pounding_risk.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
MOST_BUILDINGS = 6  # of one figure
BAND = (16.0, 84.0)
WITHOUT, WITH = STYLES[0], STYLES[1]


class Quantity(NamedTuple):
    """Words of a quantity's axis, factor from SI to the unit there, and whether it is of storeys or of floors."""

    words: str
    factor: float
    of_storey: bool


QUANTITIES = {
    "storey_drift": Quantity("drift [% of the storey's height]", 100.0, True),
    "storey_shear": Quantity("storey shear [MN]", 1e-6, True),
    "storey_acceleration": Quantity("floor acceleration [g]", 1.0 / STANDARD_GRAVITY, False),
    "storey_ductility": Quantity("storey ductility [1]", 1.0, True),  # of storeys that may yield
}


class Profile(NamedTuple):
    """One quantity of one building by storey: (16 %, 50 %, 84 %) rows in the axis's unit."""

    free: Array
    struck: Array
    motions: int  # those in which the building touches a neighbour; 0: none does, and all are shown


def profiles_figure(case: RowCase, buildings: Sequence[str] = (), note: str = "", *, titled: bool = True) -> Figure:
    """Storey profiles with and without contact: median and middle 68 % of the motions in which a building touches.

    Levels of contact are marked on the side where the neighbour stands.

    Parameters
    ----------
    case : RowCase
        One cell of a row's grid, from `row_case`.
    buildings : sequence of str
        Names of buildings; without any, those whose drift contact raises most, `MOST_BUILDINGS` at most.
    note : str
        Added to the caption.
    titled : bool
        Whether the finding and its conditions are written.

    Returns
    -------
    matplotlib.figure.Figure
        A column for each building, a row for each quantity.

    Raises
    ------
    PoundingError
        For a name that the row has not, and for a row without storeys.
    """
    rows = [name for name in QUANTITIES if name in case.results]
    chosen = _chosen(case, buildings) if rows else []
    if not chosen:
        raise PoundingError("no building has storeys; profiles need floor_masses, or a height and storeys")
    figure, axes = blank(len(rows), len(chosen), (1.6 + 2.3 * max(len(chosen), 3), 1.8 + 2.9 * len(rows)), sharey="row")
    for row, name in enumerate(rows):
        for column, at in enumerate(chosen):
            _panel(axes[row, column], case, at, name)
            axes[row, column].set_xlabel(QUANTITIES[name].words, fontsize=9)
        axes[row, 0].set(ylabel="height [m]", ylim=(0.0, 1.04 * max(case.buildings[at].height for at in chosen)))
    for column, at in enumerate(chosen):
        shown = profile(case, at, rows[0])
        motions = f"{shown.motions} of {counted(case.motions, 'motion')}" if shown.motions else "no contact"
        building = case.buildings[at]
        axes[0, column].set_title(plain(f"{building.name} ({building.position})\n{motions}"), fontsize=9.5)
    if titled:
        heading(figure, profiles_finding(case), [case], note)
    _legend(figure)
    return figure


def profiles_finding(case: RowCase) -> str:
    """Sentence on how contact changes the largest storey drift, at the ends of the row and inside it."""
    parts = []
    ends = " at the row's ends" if len(case.buildings) > 2 else ""
    for position, where in (("end", ends), ("interior", " inside the row")):
        ratios = [
            amplification(case, at)
            for at, shape in enumerate(case.buildings)
            if shape.position == position and _storeys(case, at)
        ]
        finite_ratios = [ratio for ratio in ratios if np.isfinite(ratio)]
        if finite_ratios:
            parts.append(f"{np.median(finite_ratios):.2f} times{where}")
    if not parts:
        return f"No building with storeys touches a neighbour in {counted(case.motions, 'motion')}"
    return f"With contact the largest storey drift is {' and '.join(parts)} what it is without, in the median"


def amplification(case: RowCase, building: int, name: str = "peak_drift") -> float:
    """Median over the motions with contact of a building's largest response with contact over that without.

    Parameters
    ----------
    case : RowCase
        One cell of a row's grid.
    building : int
        Number of the building, from 0 at the left.
    name : str
        Variable of the dataset that has a twin without contact.

    Returns
    -------
    float
        The ratio; NaN where no motion brings contact.
    """
    touched = any_of_building(case, "impact_count", building) == 1.0
    both = [
        case.results[output].isel(building=building).transpose("record", "polarity").values.ravel()[touched]
        for output in (name, f"{name}_free")
    ]
    ratio = np.divide(both[0], both[1], out=np.full(both[0].shape, np.nan), where=both[1] > 0.0)
    finite_ratios = ratio[np.isfinite(ratio)]
    return float(np.median(finite_ratios)) if finite_ratios.size else float("nan")


def profile(case: RowCase, building: int, name: str) -> Profile:
    """One of `QUANTITIES` of one building, with contact and without, over the motions in which it touches a neighbour.

    Over all motions, where there are none: then both are the same.
    """
    answers = any_of_building(case, "impact_count", building)
    touched = answers == 1.0
    motions = int(touched.sum())
    is_drawn = touched if motions else np.isfinite(answers)
    count = len(case.buildings[building].levels)
    spreads = []
    for suffix in ("_free", ""):
        values = (
            case.results[f"{name}{suffix}"].isel(building=building).transpose("record", "polarity", "storey").values
        )
        spreads.append(_spread(_in_units(case, building, name, values.reshape(-1, values.shape[-1])[is_drawn, :count])))
    return Profile(spreads[0], spreads[1], motions)


def _in_units(case: RowCase, building: int, name: str, values: Array) -> Array:
    if name != "storey_drift":
        return values * QUANTITIES[name].factor
    return values * QUANTITIES[name].factor / np.diff([0.0, *case.buildings[building].levels])


def _spread(values: Array) -> Array:
    """16th, 50th and 84th percentile by storey; NaN where no run is complete."""
    if not len(values):
        return np.full((3, values.shape[1]), np.nan)
    return np.asarray(np.percentile(values, (BAND[0], 50.0, BAND[1]), axis=0))


def _storeys(case: RowCase, building: int) -> int:
    """Number of storeys that a building has numbers of; 0 for a rigid one."""
    return 0 if case.buildings[building].is_rigid else len(case.buildings[building].levels)


def _chosen(case: RowCase, names: Sequence[str]) -> list[int]:
    building_names = [building.name for building in case.buildings]
    for name in names:
        if name not in building_names:
            raise PoundingError(f"building {name!r} is not in the row, which has {', '.join(building_names)}")
    if names:
        return [at for at in map(building_names.index, names) if _storeys(case, at)]
    some = [at for at in range(len(building_names)) if _storeys(case, at)]
    most = sorted(some, key=lambda at: -np.nan_to_num(amplification(case, at)))[:MOST_BUILDINGS]
    return sorted(most)


def _panel(axis: Any, case: RowCase, building: int, name: str) -> None:
    spread, quantity = profile(case, building, name), QUANTITIES[name]
    levels = np.array(case.buildings[building].levels)
    for values, (colour, dash) in ((spread.free, WITHOUT), (spread.struck, WITH)):
        heights, (low, middle, high) = _against_height(levels, values, quantity.of_storey)
        if heights.size == 1:  # one floor: no area between its ends
            axis.plot([low[0], high[0]], [heights[0]] * 2, color=colour, alpha=0.3, linewidth=5.0)
        axis.fill_betweenx(heights, low, high, color=colour, alpha=0.18, linewidth=0.0)
        marker = "" if quantity.of_storey else "."
        axis.plot(middle, heights, color=colour, linestyle=dash, linewidth=1.9, marker=marker, markersize=7)
    axis.set_xlim(0.0, 1.05 * axis.dataLim.x1 if axis.dataLim.x1 > 0.0 else 1.0)  # values near one another too
    _contacts(axis, case, building)


def _against_height(levels: Array, values: Array, of_storey: bool) -> tuple[Array, Array]:
    """Heights and values as they are drawn: one value all along a storey, or points at the floors."""
    if not of_storey:
        return levels, values
    return np.repeat([0.0, *levels], 2)[1:-1], np.repeat(values, 2, axis=1)


def _contacts(axis: Any, case: RowCase, building: int) -> None:
    """Draw a mark on the side of the neighbour at each level of contact; full where a motion touches there."""
    for point in case.points:
        if building not in (point.interface, point.interface + 1):
            continue
        is_right = building == point.interface
        face = "black" if point.touch.contact > 0.0 else "white"
        axis.plot(
            1.0 if is_right else 0.0, point.level, "<" if is_right else ">", transform=axis.get_yaxis_transform(),
            color="black", markerfacecolor=face, markersize=6, clip_on=False, zorder=5,
        )  # fmt: skip
        axis.axhline(point.level, color=QUIET, linestyle=":", linewidth=0.7, zorder=0)


def _legend(figure: Figure) -> None:
    from matplotlib.lines import Line2D

    lines: list[dict[str, Any]] = [
        {"color": colour, "linestyle": dash, "linewidth": 1.9} for colour, dash in (WITHOUT, WITH)
    ]
    mark: dict[str, Any] = {"color": "black", "linestyle": "none", "marker": "<"}
    handles = [
        Line2D([], [], label="without contact", **lines[0]),
        Line2D([], [], label="with contact (bands: 16 to 84 %)", **lines[1]),
        Line2D([], [], label="level of contact", **mark),
        Line2D([], [], label="never touched there", markerfacecolor="white", **mark),
    ]
    legend_below(figure, handles, 4)
