"""Figures of isolated impacts and of single runs: the histories of one run, its loops, and two runs compared."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import building_shapes, force_text
from pounding_risk.errors import PoundingError
from pounding_risk.figures import style
from pounding_risk.figures.row import MARKERS, ON_FLOOR, RAISED, WIDTH, gap_scale, outline
from pounding_risk.results.attributes import bumper_lengths, bumper_words, isolated_of
from pounding_risk.units import STANDARD_GRAVITY, say_in

SAME = 1e-9  # of the peak: histories closer than this are the same
NAMED = 6  # lines of a panel with a colour and a name of their own; the others are grey
OTHERS = "#c4c4c4"
FORCE = "peak_contact_force"
ABOVE: dict[str, Any] = {  # a legend between two panels, where it covers nothing
    "loc": "lower right",
    "bbox_to_anchor": (1.0, 1.0),
    "borderaxespad": 0.1,
    "fontsize": 8,
    "frameon": False,
}
LETTERS = 120  # in a line of that size over the narrowest panel; a key takes eight
MOST_STOREYS = 9  # panels of loops: the storeys that yield most
FAR = 4.0  # times the largest motion: a gap wider than that is not drawn
ROOM = 0.04  # of the tallest height: levels closer than this leave room for one number


def impact_figure(impacts: Sequence[Any], note: str = "") -> style.Figure:
    """Force against time and against penetration of isolated impacts.

    Parameters
    ----------
    impacts : sequence of Impact
        As `impact` gives them.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels.
    """
    figure, axes = style.blank(1, 2, (10.0, 4.8), sharey=True)
    labels = [_impact_label(impact, impacts) for impact in impacts]
    # Lines that lie on one another show: the first is the widest.
    widths = np.linspace(3.0, 1.4, len(impacts)) if len(impacts) > 1 else [2.0]
    for (colour, dash), width, impact, label in zip(style.styles(len(impacts)), widths, impacts, labels, strict=True):
        look = {"color": colour, "linestyle": dash, "linewidth": width}
        axes[0, 0].plot(impact.time * 1e3, impact.force / 1e3, label=label, **look)
        axes[0, 1].plot(impact.penetration * 1e3, impact.force / 1e3, **look)
    axes[0, 0].set(xlabel="time since the touch [ms]", ylabel="contact force [kN]")
    axes[0, 1].set(xlabel="penetration [mm]")
    forces = [impact.peak_force for impact in impacts if isfinite(impact.peak_force)]
    reached = f"The contact force reaches {force_text(max(forces))}, in" if forces else "No force, jumps of velocity in"
    style.title(figure, f"{reached} isolated impacts", note)
    style.legend_below(figure, axes[0, 0].get_legend_handles_labels()[0], min(2, len(impacts)))
    return figure


def _impact_label(impact: Any, impacts: Sequence[Any]) -> str:
    """The law, mass or speed by which an impact differs from the others, and its restitution."""
    parts = [impact.law] if len({item.law for item in impacts}) > 1 else []
    if len({item.mass for item in impacts}) > 1 or not parts:
        parts.append(f"{impact.mass:.0f} kg")
    if len({item.approach_speed for item in impacts}) > 1 or len(parts) < 2:
        parts.append(f"{impact.approach_speed:g} m/s")
    required = impact.restitution_asked
    e_words = "e" if np.isnan(required) else f"e required {required:.2f}, achieved"
    return f"{', '.join(parts)}: {e_words} {impact.restitution:.2f}"


def simulation_figure(run: xr.Dataset, note: str = "", absolute: bool = False) -> style.Figure:
    """One run over time: ground motion, motion, contact forces, and energies where the run has them.

    Of two buildings with one floor each the motion is their relative displacement, with the gap and the contacts. Of
    others it is the displacement of the roofs relative to the ground under each, and all peaks stand on an elevation
    below.

    Parameters
    ----------
    run : xarray.Dataset
        A dataset of `simulate`.
    note : str
        Added to the caption.
    absolute : bool
        A panel more has the displacements of roofs and grounds in space.

    Returns
    -------
    matplotlib.figure.Figure
        Panels over time, as many as the run has histories for, and the elevation.

    Raises
    ------
    PoundingError
        For displacements in space that the run, of an earlier version, has not.
    """
    if absolute and "absolute_displacement" not in run:
        raise PoundingError("absolute: the run has no displacements in space; simulate it again with this version")
    is_simple = run.sizes["contact_point"] == run.sizes["storey"] == 1 and "relative_displacement" in run
    panels: list[tuple[Any, float]] = [(_draw_ground, 1.5)]  # what draws a panel, and its height [inches]
    panels.append((_draw_closing, 2.6) if is_simple else (_draw_roofs, 2.3))
    panels += [(_draw_in_space, 2.6)] if absolute else []
    panels += [(_draw_forces, 2.3), *([(_draw_energies, 2.3)] if "energy_ground" in run else [])]
    count, width = len(panels), min(max(9.0, 1.7 * run.sizes["building"]), 30.0)
    if not is_simple:
        tallest = max(building.height for building in building_shapes(run))
        panels.append((_draw_row_peaks, 3.2 + min(max(0.12 * tallest, 1.6), 5.0)))
    heights = [height for _, height in panels]
    figure, axes = style.blank(len(panels), 1, (width, 0.9 + sum(heights)), height_ratios=heights)
    for (draw, _), axis in zip(panels, axes[:, 0], strict=True):
        draw(axis, run)
    for axis in axes[:count, 0]:
        axis.sharex(axes[0, 0])
        axis.tick_params(labelbottom=axis is axes[count - 1, 0])
    axes[0, 0].set_xlim(float(run["time"][0]), float(run["time"][-1]))
    axes[count - 1, 0].set_xlabel("time [s]")
    style.title(figure, _run_finding(run), _run_words(run), style.plain(note))
    return figure


def _run_finding(run: xr.Dataset) -> str:
    """The number of contacts and the largest force; of a run that is not complete, the reason."""
    if (status := str(run.attrs["status"])) != "complete":
        return f"The run is not complete: {status}"
    contacts, forces = int(_at_points(run, "impact_count").sum()), _at_points(run, FORCE)
    if not contacts:
        return "Nothing touches"
    largest = f", the largest force {force_text(float(forces.max()))}" if np.isfinite(forces).all() else ""
    return f"{counted(contacts, 'contact')}{largest}"


def _draw_ground(axis: style.Axes, run: xr.Dataset) -> None:
    """Draw the ground acceleration, under each building where it differs."""
    time = run["time"].values
    if "building_ground_acceleration" in run:
        ground = run["building_ground_acceleration"].transpose("time", "building").values / STANDARD_GRAVITY
        _largest_lines(axis, time, ground, list(map(str, run["building"].values)))
    else:
        acceleration = run["ground_acceleration"] / STANDARD_GRAVITY
        axis.plot(time, acceleration, color=style.QUIET, linewidth=0.9, label="along the row")
    if (second := "ground_acceleration_across") in run:
        axis.plot(time, run[second] / STANDARD_GRAVITY, color=RAISED, linestyle=":", linewidth=0.9, label="across it")
        axis.legend(ncols=2, **ABOVE)
    axis.set_ylabel("ground\nacceleration [g]")


def _draw_closing(axis: style.Axes, run: xr.Dataset) -> None:
    """Draw the relative displacement, the gap as a line and every contact as a grey band."""
    closing = 1e3 * run["relative_displacement"].isel(contact_point=0)
    axis.plot(run["time"], closing, color=style.STYLES[0][0], linewidth=1.1)
    bumper = float(run["interface_bumper"][0]) if "interface_bumper" in run.coords else 0.0
    gap = (float(run["interface_gap"][0]) - bumper) * 1e3
    label = f"gap {gap:.6g} mm{' clear of the bumpers' if bumper else ''}"
    largest = float(np.abs(closing).max())
    if gap > FAR * largest > 0.0:  # the motion would be a line of no height beside it
        axis.set_ylim(-1.1 * largest, 1.1 * largest)
        label += ", beyond the axis"
    axis.axhline(gap, color=style.STYLES[1][0], linestyle="--", linewidth=1.2, label=label)
    spans = zip(run["contact_start"].values, run["contact_end"].values, strict=True)
    for index, (start, end) in enumerate(spans):
        axis.axvspan(start, end, color="#bbbbbb", linewidth=0.0, zorder=0.5, label="" if index else "in contact")
    axis.set_ylabel("relative\ndisplacement [mm]")
    axis.legend(ncols=2, **ABOVE)


def _draw_roofs(axis: style.Axes, run: xr.Dataset) -> None:
    """Draw the displacement of the roof of each building."""
    _largest_lines(axis, run["time"].values, 1e3 * roofs_of(run), list(map(str, run["building"].values)))
    axis.set_ylabel("roof relative to\nits ground [mm]")


def _draw_in_space(axis: style.Axes, run: xr.Dataset) -> None:
    """Draw the displacement in space of each roof, and dotted that of the ground under it; a common ground once.

    Grounds that differ have the colours of the buildings on them.
    """
    time, names = run["time"].values, list(map(str, run["building"].values))
    ground = 1e3 * run["ground_displacement"].transpose("time", "building").values
    roofs = _roof_values(run, run["absolute_displacement"].transpose("time", "building", "storey").values)
    storeys = run["building_storeys"].values.astype(int)
    colours = _largest_lines(axis, time, np.where(storeys > 0, 1e3 * roofs, ground), names)
    if (ground == ground[:, :1]).all():
        axis.plot(time, ground[:, 0], color=style.QUIET, linestyle=":", linewidth=0.9, label="ground")
    else:
        for number, line in enumerate(ground.T):
            axis.plot(time, line, color=colours.get(number, OTHERS), linestyle=":", linewidth=0.9)
        axis.plot([], [], color=style.QUIET, linestyle=":", linewidth=0.9, label="the ground under it")
    _legend_above(axis)
    axis.set_ylabel("displacement\nin space [mm]")


def _draw_forces(axis: style.Axes, run: xr.Dataset) -> None:
    """Draw the force at each contact point that touches."""
    forces = run["contact_force"].transpose("time", "contact_point").values
    touched = np.flatnonzero(np.nan_to_num(forces).max(axis=0) > 0.0)
    names = [str(run["contact_point"].values[index]) if forces.shape[1] > 1 else "" for index in touched]
    jumps = (_at_points(run, "impact_count") > 0).any()
    empty_text = "velocities jump at each touch, and no force lasts" if jumps else "nothing touches"
    _largest_lines(axis, run["time"].values, 1e-3 * forces[:, touched], names, empty_text)
    axis.set_ylabel("contact\nforce [kN]")


def _draw_energies(axis: style.Axes, run: xr.Dataset) -> None:
    """Draw the energy from the ground, and its parts."""
    kinds = ("ground", "damping", "contact", "held")
    words = ("from the ground", "to structural damping", "to contact", "kinetic and strain")
    for (colour, dash), kind, word in zip(style.styles(4), kinds, words, strict=True):
        axis.plot(run["time"], run[f"energy_{kind}"] / 1e3, color=colour, linestyle=dash, linewidth=1.1, label=word)
    axis.set_ylabel("energy [kJ]")
    axis.legend(ncols=4, **ABOVE)


def hysteresis_figure(run: xr.Dataset, note: str = "") -> style.Figure:
    """Shear against drift of each storey that yields, those with the largest ductility first.

    Parameters
    ----------
    run : xarray.Dataset
        A run of `simulate` of a row in which storeys may yield.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        At most nine panels.

    Raises
    ------
    PoundingError
        If no storey of the run may yield.
    """
    if "storey_force" not in run:
        raise PoundingError("hysteresis: no storey of the run may yield; write storey_strengths and inelastic_storeys")
    ductility = run["storey_ductility"].transpose("building", "storey").values
    places = [tuple(place) for place in np.argwhere(np.isfinite(ductility))]
    places.sort(key=lambda place: -ductility[place])
    drawn_places = places[:MOST_STOREYS]
    isolated = isolated_of(run)
    drifts = 1e3 * run["drift"].transpose("time", "building", "storey").values
    shears = 1e-3 * run["storey_force"].transpose("time", "building", "storey").values
    figure, axes = style.wrapped(len(drawn_places), 3, (0.6, 1.2), (3.4, 2.8))
    for axis, (building, storey) in zip(axes.flat, drawn_places, strict=False):
        axis.axhline(0.0, color=style.QUIET, linewidth=0.6)
        axis.axvline(0.0, color=style.QUIET, linewidth=0.6)
        axis.plot(drifts[:, building, storey], shears[:, building, storey], color=style.STYLES[0][0], linewidth=1.0)
        name = str(run["building"].values[building])
        storey_name = f"storey {storey + 1}" if storey or name not in isolated else "isolators"
        axis.set_title(f"{style.plain(name)}, {storey_name}: ductility {ductility[building, storey]:.3g}", fontsize=9)
        axis.set_xlabel("drift [mm]")
        axis.set_ylabel("storey shear [kN]")
    yields = int((ductility[np.isfinite(ductility)] > 1.0).sum())
    left_out = f"; {len(drawn_places)} of {len(places)} are drawn" if len(places) > len(drawn_places) else ""
    headline = f"{yields} of {len(places)} storeys that may yield do so"
    style.title(figure, headline, f"{style.plain(style.motion_words(run.attrs))}{left_out}", style.plain(note))
    return figure


def comparison_figure(runs: Sequence[xr.Dataset], note: str = "") -> style.Figure:
    """Relative displacement and contact force of two runs of one scene, with the time at which they part.

    Of several contact points the one with the largest force is shown.

    Parameters
    ----------
    runs : sequence of two xarray.Dataset
        Datasets of `simulate` under one motion.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels over time, as Figure 8 of Khatiwada et al. (2011).
    """
    forces_of_runs = [np.nan_to_num(run["contact_force"].transpose("time", "contact_point").values) for run in runs]
    point = int(np.max([forces.max(axis=0) for forces in forces_of_runs], axis=0).argmax())
    has_points, time_parted = runs[0].sizes["contact_point"] > 1, parting(*runs)
    runs = [run.isel(contact_point=point) for run in runs]
    first = runs[0]
    figure, axes = style.blank(2, 1, (9.0, 6.4), sharex=True, height_ratios=(2.0, 1.0))
    peaks = []
    for (colour, dash), run in zip(style.styles(2), runs, strict=True):
        index = int(np.abs(run["relative_displacement"].values).argmax())
        time, value = float(run["time"][index]), float(run["relative_displacement"][index])
        peaks.append(abs(value) * 1e3)
        force = style.force_words(float(run["contact_point_yield_force"]))
        label = f"{style.law_words(run.attrs['contact_model'])}, {force}"
        axes[0, 0].plot(run["time"], run["relative_displacement"] * 1e3, color=colour, linestyle=dash, label=label)
        axes[1, 0].plot(run["time"], run["contact_force"] / 1e3, color=colour, linestyle=dash, linewidth=0.9)
        axes[0, 0].plot(time, value * 1e3, marker="o", markersize=6, color=colour, markerfacecolor="white")
        style.beside(axes[0, 0], f"{abs(value) * 1e3:.2f} mm", (time, value * 1e3), (9, 0), 9, color=colour)
    if np.isfinite(time_parted):
        for panel in axes[:, 0]:
            panel.axvline(time_parted, color=style.QUIET, linewidth=0.9, linestyle=":")
        look: dict[str, Any] = {"xycoords": ("data", "axes fraction"), "va": "top", "color": style.QUIET}
        style.beside(axes[0, 0], f"they differ from {time_parted:.2f} s on", (time_parted, 0.97), (-4, 0), 9, **look)
    axes[0, 0].set_ylabel("relative displacement [mm]\n(positive: towards contact)")
    axes[0, 0].legend(fontsize=8.5, loc="lower left", handlelength=3.0)
    axes[1, 0].set(xlabel="time [s]", ylabel="contact force [kN]", xlim=(0.0, float(first["time"].max())))
    point_text = f"; {first['contact_point'].item()}" if has_points else ""
    gap = float(first["interface_gap"][int(first["contact_point_interface"])])
    condition = f"{first.attrs['title']}{point_text}; gap {say_in(gap, 'mm', 6)}; {style.motion_words(first.attrs)}"
    style.title(figure, _comparison_finding(runs, time_parted, peaks), condition, note)
    return figure


def _comparison_finding(runs: Sequence[xr.Dataset], time_parted: float, amounts: list[float]) -> str:
    if np.isnan(time_parted):
        return f"Identical throughout: peak {amounts[0]:.2f} mm"
    yields = np.isfinite(runs[1]["first_yield_time"].values).any()
    cause = "yielding" if yields else style.law_words(runs[1].attrs["contact_model"])
    word = "lowers" if amounts[1] < amounts[0] else "raises"
    return f"Identical until {time_parted:.2f} s; {cause} {word} the peak from {amounts[0]:.2f} to {amounts[1]:.2f} mm"


def parting(first: xr.Dataset, second: xr.Dataset) -> float:
    """Last time up to which two runs have the same relative displacements [s]; NaN where they never part."""
    times, *indices = np.intersect1d(first["time"].values, second["time"].values, return_indices=True)
    one, other = (run["relative_displacement"].transpose("time", "contact_point").values for run in (first, second))
    differences = np.abs(one[indices[0]] - other[indices[1]]).max(axis=1)
    is_different = differences > SAME * max(np.abs(one).max(), np.abs(other).max())
    return float(times[max(int(is_different.argmax()) - 1, 0)]) if is_different.any() else float("nan")


def roofs_of(run: xr.Dataset) -> np.ndarray:
    """Displacement of the roof of each building [m], (time, building); zero for a rigid one."""
    return _roof_values(run, run["displacement"].transpose("time", "building", "storey").values)


def _roof_values(run: xr.Dataset, values: np.ndarray) -> np.ndarray:
    """Values (..., building, storey) of the highest storey of each building; zero for a rigid one."""
    storeys = run["building_storeys"].values.astype(int)
    tops = values[..., np.arange(storeys.size), np.maximum(storeys - 1, 0)]
    return np.where(storeys > 0, tops, 0.0)


def _at_points(run: xr.Dataset, name: str) -> np.ndarray:
    """An output at each contact point; where there is only one, it is that of the interface."""
    return run[f"contact_point_{name}" if f"contact_point_{name}" in run else name].values


def _run_words(run: xr.Dataset) -> str:
    """Title, contact model, yield forces, gaps, motion and effects of the run."""
    forces, gaps = np.unique(run["contact_point_yield_force"].values), np.unique(run["interface_gap"].values)
    force = style.force_words(float(forces[0]))
    if forces.size > 1:
        finite = forces[np.isfinite(forces)]
        ends = " to ".join(f"{number / 1e3:.0f}" for number in dict.fromkeys((finite[0], finite[-1])))
        force = f"$F_E$ = {ends} kN{', or none' * (finite.size < forces.size)}"
    gap = f"gap {' to '.join(f'{1e3 * number:.6g}' for number in dict.fromkeys((gaps[0], gaps[-1])))} mm"
    if bumpers := bumper_words(bumper_lengths(run)):
        gap += f" with {bumpers}"
    effects = f", with {run.attrs['effects']}" if run.attrs.get("effects") else ""
    model, motion = (
        style.plain(style.law_words(run.attrs["contact_model"])),
        style.plain(f"{style.motion_words(run.attrs)}{effects}"),
    )
    return f"{style.plain(run.attrs['title'])}: {model}, {force}, {gap}, {motion}"


def _largest_lines(
    axis: Any, time: np.ndarray, values: np.ndarray, names: list[str], empty_text: str = ""
) -> dict[int, str]:
    """Draw the columns with the largest values in colour with their names, and the other ones in grey behind them.

    Where there is no column, ``empty_text`` stands in the panel. Returns the colours of the columns that have one;
    where there are enough for all, a column has the same colour in every panel.
    """
    order = np.argsort(-np.nanmax(np.abs(values), axis=0, initial=0.0), kind="stable")
    order = order if len(names) > NAMED else np.arange(len(names))
    for index, at in enumerate(order[NAMED:]):
        label = None if index else f"{len(names) - NAMED} others"
        axis.plot(time, values[:, at], color=OTHERS, linewidth=0.6, zorder=1.5, label=label)
    for (colour, dash), at in zip(style.styles(NAMED), order, strict=False):
        axis.plot(time, values[:, at], color=colour, linestyle=dash, linewidth=1.0, label=style.plain(names[at]))
    if any(names):
        _legend_above(axis)
    elif not names:
        style.message(axis, empty_text)
    return {int(at): colour for (colour, _), at in zip(style.styles(NAMED), order, strict=False)}


def _legend_above(axis: Any) -> None:
    """A legend of names of any length in as many columns as stand side by side."""
    longest = max(map(len, axis.get_legend_handles_labels()[1]))
    axis.legend(ncols=min(max(LETTERS // (longest + 8), 1), 4), **ABOVE)


def _draw_row_peaks(axis: Any, run: xr.Dataset) -> None:
    """Draw buildings with the peak of their roofs, contact points with their largest force and number of contacts."""
    gaps = run["interface_gap"].values
    scale = gap_scale(gaps.tolist())
    walls = np.concatenate([[0.0], np.cumsum(WIDTH + scale * gaps)])
    # Peaks between the samples of the histories too.
    roofs = 1e3 * _roof_values(run, run["storey_displacement"].transpose("building", "storey").values)
    buildings = building_shapes(run)
    tallest = max(building.height for building in buildings)
    for wall, building, peak in zip(walls, buildings, roofs, strict=True):
        outline(axis, building, wall)
        if not building.is_rigid:  # above the numbers of a contact at the roof
            style.beside(axis, f"{peak:.3g} mm", (wall + WIDTH / 2, building.height), (0, 12), 8)
    _draw_points(axis, run, (walls[:-1] + WIDTH, walls[1:]), [building.height for building in buildings])
    axis.axhline(0.0, color="black", linewidth=1.4)
    axis.set(xlim=(-1.0, walls[-1] + WIDTH + 1.0), ylim=(-0.01 * tallest, 1.12 * tallest), ylabel="height [m]")
    axis.set_xticks([])
    axis.grid(False)
    axis.set_title(
        "peaks: displacement of each roof; force and number of contacts at each contact point, of two\n"
        f"close by at the stronger (orange edge: reaches $F_E$; white: untouched); gaps drawn × {scale:g}"
        + ("; links are not drawn" if "peak_link_stretch" in run else ""),
        fontsize=8,
    )


def _draw_points(axis: Any, run: xr.Dataset, faces: tuple[np.ndarray, np.ndarray], heights: list[float]) -> None:
    """Draw every contact point; of two points too close for both numbers, the one with more force has its numbers.

    ``faces`` are the walls at the left and at the right of each gap [m].
    """
    middles = 0.5 * (faces[0] + faces[1])
    peaks, counts = np.nan_to_num(_at_points(run, FORCE)), _at_points(run, "impact_count")
    yields = _at_points(run, "yield_exceedance") == 1
    labelled: list[tuple[int, float]] = []
    for index in np.lexsort((-counts, -peaks)):
        point = run.isel(contact_point=index)
        interface, level = int(point["contact_point_interface"]), float(point["contact_point_level"])
        level = level if np.isfinite(level) else min(heights[interface : interface + 2])
        # A point where velocities jump, without a force that lasts, has the colour of the smallest share.
        share = max(peaks[index] / (peaks.max() or 1.0), 1e-9) if counts[index] > 0 else 0.0
        look: dict[str, Any] = {"c": "white", "s": 22.0, "edgecolors": style.QUIET, "linewidths": 0.7}
        if share > 0.0:
            look = {"c": [share], "cmap": "cividis_r", "vmin": 0.0, "vmax": 1.0, "s": 46.0}
            look |= {"edgecolors": RAISED, "linewidths": 2.2} if yields[index] else {"edgecolors": "black"}
        marker = MARKERS[str(point["contact_point_kind"].values)]
        # The point with more force above, where both ends of a face that rotates lie at one place.
        axis.scatter(middles[interface], level, marker=marker, zorder=5.0 + 0.9 * share, **look)
        is_near = any(other == interface and abs(level - height) < ROOM * max(heights) for other, height in labelled)
        if counts[index] > 0 and not is_near:
            labelled.append((interface, level))
            force = f"{force_text(float(peaks[index]))}, " if peaks[index] > 0.0 else ""
            words = f"{force}{int(counts[index])}×"
            style.beside(axis, words, (faces[1][interface], level), (4, 1.5), 7.5, zorder=6, **ON_FLOOR)
