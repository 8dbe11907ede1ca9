"""One run of a row: what shakes it, how its roofs move, what its contact points transmit, and the row in elevation."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import force_told, standing
from pounding_risk.figures.elevation import MARKERS, RAISED, WIDTH, between, gap_scale, outline
from pounding_risk.figures.style import (
    QUIET,
    STANDARD_GRAVITY,
    blank,
    law_words,
    motion_words,
    plain,
    styles,
    title,
)

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

NAMED = 6  # lines of a panel with a colour and a name of their own; the others are grey
OTHERS = "#c4c4c4"
FORCE = "peak_contact_force"
APART = 0.018  # of the tallest height: levels closer than this leave room for one number


def row_run_figure(run: xr.Dataset, note: str = "") -> Figure:
    """One run of a row from `simulate`: ground motion, roofs, contact forces, and all peaks on the row in elevation."""
    tallest = max(building.height for building in standing(run))
    wide = min(max(9.0, 1.7 * run.sizes["building"]), 30.0)
    size = (wide, 8.6 + min(max(0.12 * tallest, 1.6), 5.0))
    figure, axes = blank(4, 1, size, height_ratios=(1.0, 2.0, 2.0, size[1] - 5.4))
    ground, roofs, forces, row = axes[:, 0]
    time = run["time"].values
    ground.plot(time, run["ground_acceleration"] / STANDARD_GRAVITY, color=QUIET, linewidth=0.9)
    ground.set_ylabel("ground\nacceleration [g]")
    moved = roofs_of(run)
    _lines(roofs, time, 1e3 * moved, list(map(str, run["building"].values)))
    roofs.set_ylabel("displacement of\nthe roof [mm]")
    pushed = run["contact_force"].transpose("time", "contact_point").values
    touched = np.flatnonzero(pushed.max(axis=0) > 0.0)
    _lines(forces, time, 1e-3 * pushed[:, touched], [str(run["contact_point"].values[at]) for at in touched])
    forces.set(ylabel="contact\nforce [kN]", xlabel="time [s]")
    for axis in (ground, roofs, forces):
        axis.set_xlim(time[0], time[-1])
    _elevation(row, run, tallest)
    title(figure, *map(plain, (row_run_finding(run), _where(run), note)))
    return figure


def roofs_of(run: xr.Dataset) -> np.ndarray:
    """Displacement of the roof of each building [m], (time, building); zero for a rigid one."""
    moved = run["displacement"].transpose("time", "building", "storey").values
    storeys = run["building_storeys"].values.astype(int)
    found = np.zeros(moved.shape[:2])
    for at, count in enumerate(storeys):
        if count:
            found[:, at] = moved[:, at, count - 1]
    return found


def _peaks_of_roofs(run: xr.Dataset) -> np.ndarray:
    """Largest displacement of each roof [m], between the samples of its history too; zero for a rigid building."""
    peaks = run["storey_displacement"].transpose("building", "storey").values
    storeys = run["building_storeys"].values.astype(int)
    return np.array([peak[count - 1] if count else 0.0 for peak, count in zip(peaks, storeys, strict=True)])


def row_run_finding(run: xr.Dataset) -> str:
    """How many contacts, where the strongest is and when, and which roof moves most."""
    counts = run["contact_point_impact_count"].values
    roofs = _peaks_of_roofs(run)
    at = int(roofs.argmax())
    most = f"the roof of {run['building'].values[at]} moves most, {1e3 * roofs[at]:.3g} mm"
    if run.attrs["status"] != "complete":
        return f"The run is not complete: {run.attrs['status']}"
    if not (counts > 0).any():
        return f"No contact; {most}"
    strongest = run.isel(contact=int(run["contact_peak_force"].values.argmax()))
    where = list(run["contact_point"].values).index(str(strongest["contact_place"].values))
    pair = between(str(run["interface"].values[int(run["contact_point_interface"].values[where])]))
    touched = f"{(counts > 0).sum()} of {counts.size} contact points"
    return (
        f"{counted(counts.sum(), 'contact')} at {touched}, up to "
        f"{force_told(float(strongest['contact_peak_force']))} between "
        f"{pair} at {float(strongest['contact_start']):.2f} s; {most}"
    )


def _where(run: xr.Dataset) -> str:
    gaps = 1e3 * run["interface_gap"].values
    told = f"gap {gaps.min():.3g}" + (f" to {gaps.max():.3g} mm" if np.ptp(gaps) > 0.0 else " mm")
    effects = f", with {run.attrs['effects']}" if run.attrs.get("effects") else ""
    words = f"{law_words(run.attrs['contact_model'])}, {told}, {motion_words(run.attrs)}{effects}"
    return f"{run.attrs['title']}: {words}"


def _lines(axis: Any, time: np.ndarray, values: np.ndarray, names: list[str]) -> None:
    """The columns with the largest values in colour and with their names, what is left in grey behind them."""
    order = np.argsort(-np.nanmax(np.abs(values), axis=0, initial=0.0), kind="stable")
    for place, at in enumerate(order[NAMED:]):
        label = None if place else f"{len(names) - NAMED} others"
        axis.plot(time, values[:, at], color=OTHERS, linewidth=0.6, zorder=1.5, label=label)
    for (colour, dash), at in zip(styles(NAMED), order, strict=False):
        axis.plot(time, values[:, at], color=colour, linestyle=dash, linewidth=1.0, label=plain(names[at]))
    if names:
        axis.legend(fontsize=7.5, loc="upper right", ncols=2 if len(names) > 3 else 1, framealpha=0.9)
    else:
        axis.annotate("nothing touches", (0.5, 0.5), xycoords="axes fraction", ha="center", color=QUIET)


def _elevation(axis: Any, run: xr.Dataset, tallest: float) -> None:
    """Buildings with the peak of their roofs, contact points with their largest force and number of contacts."""
    gaps = run["interface_gap"].values
    scale = gap_scale(gaps.tolist())
    walls = np.concatenate([[0.0], np.cumsum(WIDTH + scale * gaps)])
    roofs = 1e3 * _peaks_of_roofs(run)
    buildings = standing(run)
    for wall, building, peak in zip(walls, buildings, roofs, strict=True):
        outline(axis, building, wall)
        if not building.is_rigid:
            look: dict[str, Any] = {"xytext": (0, 3), "textcoords": "offset points", "ha": "center", "va": "bottom"}
            axis.annotate(f"{peak:.3g} mm", (wall + WIDTH / 2, building.height), fontsize=8, **look)
    _points(axis, run, walls[:-1] + WIDTH + 0.5 * scale * gaps, [building.height for building in buildings])
    axis.axhline(0.0, color="black", linewidth=1.4)
    axis.set(xlim=(-1.0, walls[-1] + WIDTH + 1.0), ylim=(-0.01 * tallest, 1.12 * tallest), ylabel="height [m]")
    axis.set_xticks([])
    axis.grid(False)
    axis.set_title(
        "peaks: displacement of each roof; force and number of contacts at each contact point "
        f"(orange edge: reaches $F_E$; white: untouched); gaps drawn × {scale:g}",
        fontsize=8,
    )


def _points(axis: Any, run: xr.Dataset, middles: np.ndarray, heights: list[float]) -> None:
    """Every contact point; of two too close for both numbers, the stronger one's are written."""
    peaks = np.nan_to_num(run[f"contact_point_{FORCE}"].values)
    told: list[tuple[int, float]] = []
    for at in np.argsort(-peaks, kind="stable"):
        one = run.isel(contact_point=at)
        interface, level = int(one["contact_point_interface"]), float(one["contact_point_level"])
        level = level if np.isfinite(level) else min(heights[interface : interface + 2])
        _mark(axis, one, (middles[interface], level), peaks[at] / (peaks.max() or 1.0))
        is_near = any(other == interface and abs(level - there) < APART * max(heights) for other, there in told)
        if peaks[at] > 0.0 and not is_near:
            told.append((interface, level))
            axis.annotate(
                f"{force_told(float(peaks[at]))}, {int(one['contact_point_impact_count'])}×",
                (middles[interface], level), xytext=(7, 0), textcoords="offset points", va="center", fontsize=6.8,
                zorder=6, bbox={"facecolor": "#f1f1f1", "edgecolor": "none", "pad": 0.6, "alpha": 0.85},
            )  # fmt: skip


def _mark(axis: Any, one: xr.Dataset, place: tuple[float, float], share: float) -> None:
    """A contact point in the colour of its share of the largest force; white and small where nothing touches."""
    look: dict[str, Any] = {"c": "white", "s": 22.0, "edgecolors": QUIET, "linewidths": 0.7}
    if share > 0.0:
        yields = int(one["contact_point_yield_exceedance"]) == 1
        look = {"c": [share], "cmap": "cividis_r", "vmin": 0.0, "vmax": 1.0, "s": 46.0}
        look |= {"edgecolors": RAISED, "linewidths": 2.2} if yields else {"edgecolors": "black", "linewidths": 0.9}
    axis.scatter(*place, marker=MARKERS[str(one["contact_point_kind"].values)], zorder=5, **look)
