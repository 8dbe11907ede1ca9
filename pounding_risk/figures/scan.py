"""Figures of whole grids: peak relative displacement over gap and yield force, and how yielding changes it."""

from __future__ import annotations

from collections.abc import Sequence
from textwrap import fill
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import (
    MEANING,
    QUIET,
    Axes,
    Figure,
    blank,
    force_words,
    law_words,
    legend_below,
    plain,
    styles,
    title,
)
from pounding_risk.results.attributes import read_attribute
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import at_one_place
from pounding_risk.units import say_in

MOST_RECORDS = 6  # that have a panel or a line of their own; more are put together as percentiles
MARKS = "osD^vX"  # of their lines: polarities of a record differ by dash and filling
PERCENTILES = (16.0, 50.0, 84.0)
NOTABLE = 0.01  # a peak that changes by less than this share is called unchanged
RATIO_TICKS = (0.25, 0.33, 0.5, 0.67, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 4.0)


def scan_figure(results: xr.Dataset, note: str = "") -> Figure:
    """Peak relative displacement over gap and yield force, or lines against whichever the grid has.

    More than six records are combined: the median of all motions, and the percentiles 16 and 84. Of several contact
    laws and amplitudes the scene's own is shown.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each record and polarity.
    """
    results = at_one_place(results)
    part = _one_law(results)
    peak = part["peak_relative_displacement"] * 1e3
    if min(peak.sizes["gap"], peak.sizes["yield_force"]) < 2:
        return _draw_lines(_condition(results, part), peak, note)
    panel_results, peaks = _combined(part, peak)
    # Failed runs have no number; where all have failed, the maps are empty and the title says so.
    look = {"cmap": "viridis", "vmin": float(peaks.min().fillna(0.0)), "vmax": float(peaks.max().fillna(1.0))}
    figure = _draw_maps(panel_results, peaks, look, "peak relative displacement [mm]")
    title(figure, _largest_words(peak), f"{_condition(results, part)}{_end_words(panel_results)}", note)
    return figure


def ratio_figure(results: xr.Dataset, note: str = "") -> Figure:
    """Peak relative displacement with yielding over that without, over gap and yield force.

    Cells that yielding raises carry a plus, so that the map is read in grey as well.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `scan`; it must hold an infinite yield force, the case without yielding.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        One panel for each record and polarity.

    Raises
    ------
    PoundingError
        For a dataset without an infinite yield force, and for one with no other.
    """
    from matplotlib.colors import LogNorm

    results = at_one_place(results)
    part = _one_law(results)
    peak, is_finite = part["peak_relative_displacement"], np.isfinite(part["yield_force"].values)
    if is_finite.all():
        raise PoundingError('the dataset has no case without yielding; add "inf" to grid.yield_force and scan again')
    if not is_finite.any():
        raise PoundingError("the dataset has no case that may yield; add a force to grid.yield_force and scan again")
    ratio = peak.isel(yield_force=is_finite) / peak.isel(yield_force=int(is_finite.argmin()), drop=True)
    reach = float(np.nanmax([ratio.max(), 1.0 / ratio.min(), 1.0 + NOTABLE]))
    look = {"cmap": "PuOr_r", "norm": LogNorm(1.0 / reach, reach)}
    panel_results, ratios = _combined(part, ratio)
    words = "peak relative displacement,\nwith yielding over without [1]"
    figure = _draw_maps(panel_results, ratios, look, words, marked=ratios > 1.0 + NOTABLE)
    condition = f"{_condition(results, part)}; +: raised by over 1 %{_end_words(panel_results)}"
    title(figure, _change_words(ratio), condition, note)
    return figure


def _largest_words(peak: xr.DataArray) -> str:
    """The largest peak of all motions [mm], with its gap and yield force, in words."""
    if not peak.notnull().any():
        return "No run is complete: no peak is known"
    largest = peak.isel(peak.argmax(...))
    gap, force = say_in(float(largest["gap"]), "mm"), force_words(float(largest["yield_force"]))
    motion = f"{largest['record'].values} {largest['polarity'].values}"
    return f"The peak relative displacement reaches {float(largest):.3g} mm; {motion}, gap {gap}, {force}"


def _change_words(ratio: xr.DataArray) -> str:
    """The smallest and the largest factor by which yielding changes the peak, in words."""
    low, high = float(ratio.min()), float(ratio.max())
    if np.isnan(low):
        return "No run is complete: no change by yielding is known"
    if max(high, 1.0 / low) <= 1.0 + NOTABLE:
        return f"Yielding changes no peak relative displacement by more than {NOTABLE:.0%}".replace("%", " %")
    return f"Yielding multiplies the peak relative displacement by {low:.3g} to {high:.3g}"


def _one_law(results: xr.Dataset) -> xr.Dataset:
    """Dataset at the scene's own contact law and amplitude; gaps and yield forces in rising order.

    It has the interface whose gap alone the grid varies, or the largest value of all interfaces.
    """
    case = Results(results).scene_case
    case_results = results.isel(
        {axis: case.get(axis, -1) for axis in (amplitude_axis(results), "contact_model") if axis in results.dims}
    )
    outputs = case_results[["peak_relative_displacement", "impact_count", "yield_exceedance"]]
    if "interface" in outputs.dims:
        index = _varied_interface(results)
        outputs = outputs.max("interface", keep_attrs=True) if index is None else outputs.isel(interface=index)
    return outputs.assign_attrs(results.attrs).sortby(["gap", "yield_force"])


def _varied_interface(results: xr.Dataset) -> int | None:
    """Index of the interface whose gap alone the grid varies; None where it varies several or none."""
    indices = np.flatnonzero(np.ptp(Results(results).gaps.values, axis=0) > 0.0)
    return int(indices[0]) if indices.size == 1 else None


def _condition(results: xr.Dataset, part: xr.Dataset) -> str:
    """Title of a dataset, with the law where only one of several is shown, and the amplitude of its motions."""
    parts = [str(results.attrs["title"])]
    if results.sizes.get("contact_model", 1) > 1:
        parts.append(law_words(str(part["contact_model"].values)))
    if (count := results.sizes.get("interface", 1)) > 1:
        index = _varied_interface(results)
        interface = results["interface"].values[index or 0]
        parts.append(f"the largest of {count} interfaces" if index is None else f"{interface}, whose gap varies")
    parts.append(f"motions {Results(part).amplitude_words()}")
    return ", ".join(parts)


def _end_words(panel: xr.Dataset) -> str:
    """Words on the dashed line of a panel, where any panel has one."""
    touching = (panel["impact_count"] != 0).any("yield_force")  # below 0 of a failed run, which began in contact
    if not touching.any():
        return "; no motion brings contact"
    return "" if bool(touching.all()) else "; right of the dashed line there is no contact"


def _combined(results: xr.Dataset, values: xr.DataArray) -> tuple[xr.Dataset, xr.DataArray]:
    """Percentiles of many motions instead of records; a dataset of few records as it is.

    A panel shows contact where any motion has it.
    """
    if results.sizes["record"] <= MOST_RECORDS:
        return results, values
    motions = ("record", "polarity")
    count = results.sizes["record"] * results.sizes["polarity"]
    titles = ("median" if percentile == 50.0 else f"{percentile:g}th percentile" for percentile in PERCENTILES)
    names = [f"{words}\nof {count} motions" for words in titles]
    axes = {"polarity": ["all motions"], "record": names}
    spread = values.quantile(np.array(PERCENTILES) / 100.0, dim=motions).rename(quantile="record")
    spread = spread.assign_coords(record=names).expand_dims(polarity=axes["polarity"])
    touching = results["impact_count"].max(motions).expand_dims(axes)
    return touching.to_dataset(name="impact_count"), spread


def _draw_maps(
    results: xr.Dataset, values: xr.DataArray, look: dict[str, Any], words: str, marked: xr.DataArray | None = None
) -> Figure:
    """One heat map for each record (columns) and polarity (rows), with one scale of colours."""
    rows, columns = values.sizes["polarity"], values.sizes["record"]
    figure, axes = blank(rows, columns, (max(7.6, 1.6 + 2.3 * columns), 2.1 + 2.4 * rows), sharex=True, sharey=True)
    facts = {entry.get("name"): entry for entry in read_attribute(results, "records", [])}
    picture: Any = None
    for row, column in np.ndindex(rows, columns):
        axis, place = axes[row, column], {"polarity": row, "record": column}
        picture = _draw_map(axis, results["impact_count"].isel(place), values.isel(place), look)
        if marked is not None:
            forces, gaps = np.nonzero(marked.isel(place).transpose("yield_force", "gap").values)
            look_of_marks: dict[str, Any] = {"color": "black", "markersize": 5, "markeredgewidth": 0.8}
            axis.plot(marked["gap"].values[gaps] * 1e3, forces, "+", **look_of_marks)
        if row == 0:
            name = str(values["record"].values[column])
            fact = facts.get(name, {})
            event = (fact.get("event") or "").partition(",")[0]
            axis.set_title(f"{name}\n{event} {str(fact.get('date') or '')[:4]}".strip(), fontsize=9)
        if column == 0:
            axis.set_ylabel(f"{values['polarity'].values[row]}\n$F_E$ [kN]", fontsize=9.5)
        if row == rows - 1:
            axis.set_xlabel("gap [mm]", fontsize=9.5)
    bar = figure.colorbar(picture, ax=axes, label=words, aspect=30)
    if "norm" in look:
        ticks = [tick for tick in RATIO_TICKS if picture.norm.vmin <= tick <= picture.norm.vmax]
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        bar.minorticks_off()
    return figure


def _draw_map(axes: Axes, counts: xr.DataArray, values: xr.DataArray, look: dict[str, Any]) -> Any:
    """One heat map with yield forces as evenly spaced classes; a line where contact ends, whatever F_E is."""
    values = values.transpose("yield_force", "gap")
    gaps, forces = values["gap"].values * 1e3, values["yield_force"].values
    middles = (gaps[1:] + gaps[:-1]) / 2.0
    edges = np.concatenate([[2.0 * gaps[0] - middles[0]], middles, [2.0 * gaps[-1] - middles[-1]]])
    axes.grid(False)
    picture = axes.pcolormesh(edges, np.arange(len(forces) + 1) - 0.5, values.values, **look)
    touching = (counts != 0).any("yield_force").values
    if not touching.all():
        # White on black shows on every colour of the map.
        axes.axvline(edges[np.argmin(touching)], color="black", linewidth=2.6)
        axes.axvline(edges[np.argmin(touching)], color="white", linestyle=(0, (3, 2)), linewidth=1.4)
    names = ["∞" if np.isinf(force) else f"{force / 1e3:.0f}" for force in forces]
    axes.set_yticks(np.arange(len(forces)), names, fontsize=8)
    axes.tick_params(axis="x", labelsize=8)
    return picture


def _draw_lines(condition: str, peak: xr.DataArray, note: str) -> Figure:
    """A line for each motion against gap or F_E; of many records the median, the middle 68 % and the largest."""
    axis = "yield_force" if peak.sizes["yield_force"] > 1 else "gap"
    scale, words = (1e3, "gap [mm]") if axis == "gap" else (1e-3, "yield force $F_E$ [kN]")
    peak = peak.isel({"gap" if axis == "yield_force" else "yield_force": 0})
    labels, motions = peak[axis].values * scale, ("record", "polarity")
    figure, axes = blank(1, 1, (8.5, 5.0))
    panel = axes[0, 0]
    if peak.sizes["record"] > MOST_RECORDS:
        low, middle, high = peak.quantile(np.array(PERCENTILES) / 100.0, dim=motions)
        colour, dash = styles(1)[0]
        count = peak.sizes["record"] * peak.sizes["polarity"]
        panel.fill_between(labels, low, high, color=colour, alpha=0.2, linewidth=0.0, label="percentiles 16 to 84")
        panel.plot(labels, middle, color=colour, linestyle=dash, marker=".", label=f"median of {count} motions")
        panel.plot(labels, peak.max(motions), color=QUIET, linestyle=":", label="largest")
    else:
        for place in np.ndindex(*(peak.sizes[axis] for axis in motions)):
            line, colour = peak.isel(dict(zip(motions, place, strict=True))), styles(MOST_RECORDS)[place[0]][0]
            look: dict[str, Any] = {"color": colour, "marker": MARKS[place[0]], "markersize": 5}
            look |= {"linestyle": ("-", "--")[place[1]], "markerfacecolor": (colour, "white")[place[1]]}
            panel.plot(labels, line, label=f"{line['record'].values}, {line['polarity'].values}", **look)
    panel.set(xlabel=words, ylabel="peak relative displacement [mm]")
    title(figure, _largest_words(peak), condition, note)
    legend_below(figure, panel.get_legend_handles_labels()[0], 3)
    return figure


def draw_models(names: Sequence[str], panels: dict[str, np.ndarray]) -> Figure:
    """A panel for each output: 16th, 50th and 84th percentile (models, 3), in the unit of the panel's words."""
    rows, colour = len(names), MEANING["motions"]
    figure, axes = blank(1, len(panels), (7.2, 1.4 + 0.3 * rows), sharey=True)
    for axis, (words, spreads) in zip(axes[0], panels.items(), strict=True):
        for row, (low, median, high) in enumerate(spreads):
            axis.plot([low, high], [row, row], color=colour, linewidth=5, alpha=0.35, solid_capstyle="butt")
            axis.plot(median, row, "o", color=colour, markersize=6)
        axis.set_xlabel(fill(words, 20), fontsize=9.5)
        axis.set_xlim(left=0.0)
    axes[0, 0].set_yticks(range(rows), list(map(plain, names)), fontsize=9)
    axes[0, 0].set_ylim(rows - 0.5, -0.5)
    axes[0, 0].tick_params(axis="y", colors=QUIET, labelcolor="black")
    return figure
