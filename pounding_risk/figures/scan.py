"""Figures of whole grids: over the yield force, and over gap and yield force."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import QUIET, blank, law_words, styles, title
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import settled

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

MOST_RECORDS = 6  # that have a panel or a line of their own; more are put together as percentiles
PERCENTILES = (16.0, 50.0, 84.0)
NOTABLE = 0.01  # a peak that changes by less than this share is called unchanged
RATIO_TICKS = (0.25, 0.33, 0.5, 0.67, 0.8, 0.9, 1.0, 1.1, 1.25, 1.5, 2.0, 3.0, 4.0)


def window_figure(searched: xr.Dataset, window: tuple[float, float], note: str = "") -> Figure:
    """Peak relative displacement and time of first yield against F_E, in every polarity of the scan.

    Parameters
    ----------
    searched : xarray.Dataset
        A dataset of `scan` over yield forces; it must hold an infinite one, the case without yielding.
    window : pair of float
        The range of yield forces [N] that is marked.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels.

    Raises
    ------
    PoundingError
        For a dataset without an infinite yield force.
    """
    searched = settled(searched)
    without = _without_yielding(searched)
    figure, axes = blank(2, 1, (9.0, 7.2), sharex=True)
    lines = searched.squeeze()
    if "polarity" not in lines.dims:
        lines = lines.expand_dims("polarity")
    forces = lines["yield_force"].values
    finite = np.isfinite(forces)
    for (colour, dash), name in zip(styles(lines.sizes["polarity"]), lines["polarity"].values, strict=True):
        line = lines.sel(polarity=name)
        peak = line["peak_relative_displacement"].values * 1e3
        axes[0, 0].plot(forces[finite] / 1e3, peak[finite], color=colour, linestyle=dash, label=str(name))
        axes[0, 0].axhline(peak[without], color=colour, linestyle=dash, linewidth=0.7)
        first = line["first_yield_time"].values
        axes[1, 0].plot(forces[finite] / 1e3, first[finite], color=colour, linestyle=dash)
    for axis in axes[:, 0]:
        axis.axvspan(window[0] / 1e3, window[1] / 1e3, color="#F0E442", alpha=0.4, linewidth=0.0)
    low, high = axes[0, 0].get_ylim()
    axes[0, 0].set_ylim(low, high + 0.1 * (high - low))
    axes[0, 0].annotate(
        "as published", (np.mean(window) / 1e3, 0.97), xycoords=("data", "axes fraction"), ha="center", va="top",
        fontsize=9,
    )  # fmt: skip
    axes[0, 0].set_ylabel("peak relative displacement [mm]\n(thin: without yielding)")
    axes[0, 0].legend(title="record's polarity", fontsize=8.5, title_fontsize=8.5, loc="upper right", handlelength=3.0)
    axes[1, 0].axhline(2.4, color=QUIET, linestyle=":", linewidth=1.0)
    axes[1, 0].annotate(
        "2.4 s, as published", (forces[0] / 1e3, 2.4), xytext=(2, 3), textcoords="offset points", fontsize=8.5
    )
    span = (forces[finite].min() / 1e3, forces[finite].max() / 1e3)
    axes[1, 0].set(xlabel="yield force $F_E$ [kN]", ylabel="first yield [s]", xlim=span)
    finding = (
        f"First yield near 2.4 s, then a smaller peak: $F_E$ from {window[0] / 1e3:.0f} to {window[1] / 1e3:.0f} kN"
    )
    title(figure, finding, _within(lines, window), "; ".join(filter(None, (searched.attrs["title"], note))))
    return figure


def _within(lines: xr.Dataset, window: tuple[float, float]) -> str:
    """Sentence on how yielding changes the peak inside a window of F_E, polarity by polarity."""
    forces = lines["yield_force"].values
    inside = (forces >= window[0]) & (forces <= window[1])
    changes = []
    for name in lines["polarity"].values:
        peak = lines["peak_relative_displacement"].sel(polarity=name).values
        change = peak[inside] / peak[np.isinf(forces)][0] - 1.0
        changes.append(f"{100.0 * change[np.abs(change).argmax()]:+.0f} % ({name})".replace("-", "−"))
    return f"In this window yielding changes the peak by up to {', '.join(changes)}"


def _without_yielding(results: xr.Dataset) -> int:
    """Index of the infinite yield force."""
    endless = np.isinf(results["yield_force"].values)
    if not endless.any():
        raise PoundingError('the dataset has no case without yielding; add "inf" to grid.yield_force and scan again')
    return int(endless.argmax())


def _one_law(results: xr.Dataset) -> xr.Dataset:
    """Dataset at the scene's own contact law and amplitude; gaps and yield forces in rising order.

    Of several interfaces the one whose gap alone the grid varies, or the largest of all.
    """
    case = Results(results).scene_case
    chosen = results.isel(
        {axis: case.get(axis, -1) for axis in (amplitude_axis(results), "contact_model") if axis in results.dims}
    )
    outputs = chosen[["peak_relative_displacement", "impact_count", "yield_exceedance"]]
    if "interface" in outputs.dims:
        at = _varied(results)
        outputs = outputs.max("interface", keep_attrs=True) if at is None else outputs.isel(interface=at)
    return outputs.assign_attrs(results.attrs).sortby(["gap", "yield_force"])


def _varied(results: xr.Dataset) -> int | None:
    """Index of the interface whose gap alone the grid varies; None where it varies several or none."""
    varied = np.flatnonzero(np.ptp(Results(results).gaps.values, axis=0) > 0.0)
    return int(varied[0]) if varied.size == 1 else None


def _whose(results: xr.Dataset, shown: xr.Dataset) -> str:
    """Title of a dataset, with the law where only one of several is shown, and the amplitude of its motions."""
    parts = [str(results.attrs["title"])]
    if results.sizes.get("contact_model", 1) > 1:
        parts.append(law_words(str(shown["contact_model"].values)))
    if (count := results.sizes.get("interface", 1)) > 1:
        at = _varied(results)
        interface = results["interface"].values[at or 0]
        parts.append(f"the largest of {count} interfaces" if at is None else f"{interface}, whose gap varies")
    parts.append(f"motions {Results(shown).amplitude_words()}")
    return ", ".join(parts)


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
    results = settled(results)
    shown = _one_law(results)
    peak = shown["peak_relative_displacement"] * 1e3
    if min(peak.sizes["gap"], peak.sizes["yield_force"]) < 2:
        return _scan_lines(_whose(results, shown), peak, note)
    finding = f"{_gap_needed(shown)}; peak relative displacement up to {float(peak.max()):.1f} mm"
    drawn, peaks = _together(shown, peak)
    look = {"cmap": "viridis", "vmin": float(peaks.min()), "vmax": float(peaks.max())}
    figure = _maps(drawn, peaks, look, "peak relative displacement [mm]")
    title(figure, finding, f"{_whose(results, shown)}{_end_words(drawn)}", note)
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
        For a dataset without an infinite yield force.
    """
    from matplotlib.colors import LogNorm

    results = settled(results)
    shown = _one_law(results)
    forces = shown["yield_force"].values
    peak = shown["peak_relative_displacement"]
    without = peak.isel(yield_force=_without_yielding(shown), drop=True)
    ratio = peak.isel(yield_force=np.isfinite(forces)) / without
    reach = max(float(ratio.max()), 1.0 / float(ratio.min()), 1.0 + NOTABLE)
    look = {"cmap": "PuOr_r", "norm": LogNorm(1.0 / reach, reach)}
    words = "peak relative displacement,\nwith yielding over without [1]"
    drawn, ratios = _together(shown, ratio)
    figure = _maps(drawn, ratios, look, words, marked=ratios > 1.0 + NOTABLE)
    yields = shown["yield_exceedance"].isel(yield_force=np.isfinite(forces)) == 1
    where = f"{_whose(results, shown)}; +: raised by over 1 %{_end_words(drawn)}"
    title(figure, _ratio_finding(ratio.where(yields)), where, note)
    return figure


def _ratio_finding(ratio: xr.DataArray) -> str:
    """Sentence on how yielding changes the peak, over the cases that yield: the others are NaN."""
    count = int(ratio.notnull().sum())
    if not count:
        return "No case yields"
    raised, lowered = (100.0 * float(cases.sum()) / count for cases in (ratio > 1.0 + NOTABLE, ratio < 1.0 - NOTABLE))
    return (
        f"Yielding raises the peak in {raised:.0f} % and lowers it in {lowered:.0f} % of the {count} cases that yield: "
        f"{float(ratio.min()):.2f} to {float(ratio.max()):.2f} times"
    )


def _end_words(drawn: xr.Dataset) -> str:
    """Words on the dashed line of a panel, where any panel has one."""
    touching = (drawn["impact_count"] > 0).any("yield_force").all("gap")
    return "" if bool(touching.all()) else "; right of the dashed line there is no contact"


def _together(results: xr.Dataset, values: xr.DataArray) -> tuple[xr.Dataset, xr.DataArray]:
    """Percentiles of many motions instead of records; a dataset of few records as it is.

    The contacts that a panel shows are those of any motion.
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


def _maps(
    results: xr.Dataset, values: xr.DataArray, look: dict[str, Any], words: str, marked: xr.DataArray | None = None
) -> Figure:
    """One heat map for each record (columns) and polarity (rows), with one scale of colours."""
    rows, columns = values.sizes["polarity"], values.sizes["record"]
    figure, axes = blank(rows, columns, (max(7.6, 1.6 + 2.3 * columns), 2.1 + 2.4 * rows), sharex=True, sharey=True)
    headings = _headings(results) if "records" in results.attrs else list(map(str, results["record"].values))
    picture: Any = None
    for cell in np.ndindex(rows, columns):
        here = {"polarity": cell[0], "record": cell[1]}
        picture = _map(axes[cell], results["impact_count"].isel(here), values.isel(here), look)
        if marked is not None:
            _plus(axes[cell], marked.isel(here))
        if cell[0] == 0:
            axes[cell].set_title(headings[cell[1]], fontsize=9)
        if cell[1] == 0:
            axes[cell].set_ylabel(f"{values['polarity'].values[cell[0]]}\n$F_E$ [kN]", fontsize=9.5)
        if cell[0] == rows - 1:
            axes[cell].set_xlabel("gap [mm]", fontsize=9.5)
    bar = figure.colorbar(picture, ax=axes, label=words, aspect=30)
    if "norm" in look:
        ticks = [tick for tick in RATIO_TICKS if picture.norm.vmin <= tick <= picture.norm.vmax]
        bar.set_ticks(ticks, labels=[f"{tick:g}" for tick in ticks])
        bar.minorticks_off()
    return figure


def _headings(results: xr.Dataset) -> list[str]:
    """Each record's name, and below it the earthquake and its year where they are known."""
    facts = {entry.get("name"): entry for entry in json.loads(results.attrs.get("records", "[]"))}
    headings = []
    for name in map(str, results["record"].values):
        fact = facts.get(name, {})
        event = (fact.get("event") or "").partition(",")[0]
        headings.append(f"{name}\n{event} {str(fact.get('date') or '')[:4]}".strip())
    return headings


def _gap_needed(results: xr.Dataset) -> str:
    """Sentence on the gap from which on there is no contact, over the records and polarities of a scan."""
    others = [name for name in results["impact_count"].dims if name not in ("record", "polarity", "gap")]
    touching = (results["impact_count"] > 0).any(others)
    if bool(touching.isel(gap=-1).any()):
        return f"Contact in {100.0 * float(touching.isel(gap=-1).mean()):.0f} % of the motions at the widest gap"
    first = results["gap"].where(~touching).min("gap") * 1e3
    low, high = float(first.min()), float(first.max())
    return (
        f"No contact from a gap of {low:.3g} mm on"
        if low == high
        else f"No contact from gaps of {low:.3g} to {high:.3g} mm on"
    )


def _map(axes: Axes, counts: xr.DataArray, values: xr.DataArray, look: dict[str, Any]) -> Any:
    """One heat map with yield forces as evenly spaced classes; a line where contact ends, whatever F_E is."""
    values = values.transpose("yield_force", "gap")
    gaps = values["gap"].values * 1e3
    edges = np.concatenate(
        [[gaps[0] - (gaps[1] - gaps[0]) / 2], (gaps[1:] + gaps[:-1]) / 2, [gaps[-1] + (gaps[-1] - gaps[-2]) / 2]]
    )
    axes.grid(False)
    picture = axes.pcolormesh(edges, np.arange(values.sizes["yield_force"] + 1) - 0.5, values.values, **look)
    touching = (counts > 0).any("yield_force").values
    if not touching.all():
        end = edges[np.argmin(touching)]
        # White on black shows on every colour of the map.
        axes.axvline(end, color="black", linewidth=2.6)
        axes.axvline(end, color="white", linestyle=(0, (3, 2)), linewidth=1.4)
    forces = values["yield_force"].values
    axes.set_yticks(
        np.arange(len(forces)), ["∞" if np.isinf(force) else f"{force / 1e3:.0f}" for force in forces], fontsize=8
    )
    axes.tick_params(axis="x", labelsize=8)
    return picture


def _plus(axes: Axes, marked: xr.DataArray) -> None:
    rows, columns = np.nonzero(marked.transpose("yield_force", "gap").values)
    axes.plot(marked["gap"].values[columns] * 1e3, rows, "+", color="black", markersize=5, markeredgewidth=0.8)


def _scan_lines(whose: str, peak: xr.DataArray, note: str) -> Figure:
    axis = "yield_force" if peak.sizes["yield_force"] > 1 else "gap"
    other = "gap" if axis == "yield_force" else "yield_force"
    scale, words = (1e-3, "yield force $F_E$ [kN]") if axis == "yield_force" else (1e3, "gap [mm]")
    figure, axes = blank(1, 1, (8.5, 5.0))
    draw = _median_lines if peak.sizes["record"] > MOST_RECORDS else _motion_lines
    draw(axes[0, 0], peak.isel({other: 0}), axis, scale)
    axes[0, 0].set(xlabel=words, ylabel="peak relative displacement [mm]")
    axes[0, 0].legend(fontsize=8)
    finding = f"Peak relative displacement {float(peak.min()):.1f} to {float(peak.max()):.1f} mm"
    title(figure, finding, whose, note)
    return figure


def _median_lines(axes: Axes, peak: xr.DataArray, axis: str, scale: float) -> None:
    """The median of all motions in a band of their middle 68 %, and the largest."""
    motions = ("record", "polarity")
    low, middle, high = peak.quantile(np.array(PERCENTILES) / 100.0, dim=motions)
    at = peak[axis].values * scale
    colour, dash = styles(1)[0]
    count = peak.sizes["record"] * peak.sizes["polarity"]
    axes.fill_between(at, low, high, color=colour, alpha=0.2, linewidth=0.0, label="percentiles 16 to 84")
    axes.plot(at, middle, color=colour, linestyle=dash, marker=".", label=f"median of {count} motions")
    axes.plot(at, peak.max(motions), color=QUIET, linestyle=":", label="largest")


def _motion_lines(axes: Axes, peak: xr.DataArray, axis: str, scale: float) -> None:
    """One line for each record and polarity."""
    lines = peak.stack(line=("record", "polarity"))
    for (colour, dash), index in zip(styles(lines.sizes["line"]), range(lines.sizes["line"]), strict=True):
        line = lines.isel(line=index)
        label = f"{line['record'].values}, {line['polarity'].values}"
        axes.plot(line[axis] * scale, line, color=colour, linestyle=dash, marker=".", label=label)
