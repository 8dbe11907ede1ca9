"""Figure of the amplification of two buildings by pounding over the ratio of their periods and the gap."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.order import evenly
from pounding_risk.assessment import amplification
from pounding_risk.assessment.spectra import motions_words, usual_percentile
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import Figure, blank, contact_styles, hatch, plain, ratio_axis, title
from pounding_risk.results.check import check_kind

EDGES = (0.5, 0.7, 0.8, 0.9, 0.97, 1.03, 1.1, 1.25, 1.5, 2.0, 3.0)  # of the shades; the middle one is no change
SECTIONS = 4  # gaps along which sections are drawn
HEAD_ROOM = 1.3  # height of their axis over the largest number, for the legend


def amplification_figure(
    results: xr.Dataset,
    output: str = "displacement",
    percentile: float | None = None,
    period: float | None = None,
    note: str = "",
) -> Figure:
    """Amplification of each building over the ratio of the periods and the gap, and sections at some gaps.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `amplification`.
    output : {"displacement", "acceleration"}
        The peak that is compared.
    percentile : float, optional
        One of the dataset's [%]; 84, or its largest, by default.
    period : float, optional
        Period of the building that stays, one of the dataset's [s]; the first by default.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        A map of each building above its sections. White is no change.

    Raises
    ------
    PoundingError
        For a dataset of another call, and an output, a percentile or a period that it has not.
    """
    check_kind(results, "amplification")
    if f"{output}_amplification" not in results:
        outputs = [name for name in amplification.OUTPUTS if f"{name}_amplification" in results]
        raise PoundingError(f"output: {output} is not in the dataset, which has {', '.join(outputs)}; choose one")
    percent = usual_percentile(results) if percentile is None else float(percentile)
    stays_period = float(results["fixed_period"][0]) if period is None else float(period)
    for name, value, unit in (("percentile", percent, "%"), ("fixed_period", stays_period, "s")):
        if value not in results[name].values:
            listed = ", ".join(f"{label:g}" for label in results[name].values)
            quantity = name.removeprefix("fixed_")
            raise PoundingError(f"{quantity}: {value:g} {unit} is not in the dataset, which has {listed}; choose one")
    part = results.sel(fixed_period=[stays_period])
    chart = part.isel(fixed_period=0)
    values = chart[f"{output}_amplification"].sel(percentile=percent)
    figure, axes = blank(2, 2, (11.5, 9.0), sharex=True)
    for column, name in enumerate(map(str, results["building"].values)):
        of_building = values.isel(building=column)
        picture = _draw_map(axes[0, column], chart, of_building)
        axes[0, column].set_title(plain(f"{name}: {output} with contact over that without"), fontsize=9.5)
        _draw_sections(axes[1, column], chart, of_building)
        axes[1, column].set_xlabel(plain(amplification.ratio_words(results)))
    bar = figure.colorbar(picture, ax=axes[0, :], pad=0.01, aspect=30, ticks=EDGES, label="amplification [1]")
    bar.ax.tick_params(labelsize=8)
    place = ("left", "right").index(str(results.attrs["fixed"]))
    fixed_text = plain(f"T({results['building'].values[place]}) = {stays_period:.3g} s")
    condition = (
        f"{motions_words(results)}; {amplification.told_words(results)}; {fixed_text}; dotted area: no motion touches"
    )
    title(figure, plain(amplification.finding(results, output, percent)), condition, note)
    return figure


def _gap_values(results: Any) -> tuple[Any, str]:
    """The values of the axis of gaps, and its words."""
    if amplification.gap_dim(results) == "gap":
        return 1e3 * results["gap"].values, "gap [mm]"
    of = amplification.reference_name(results)
    at = f"at {float(results.attrs['share_percentile']):g} %"
    return results["gap_share"].values, f"gap / {of} {at} [1]" if "times" not in of else f"gap / gap required {at} [1]"


def _draw_map(axis: Any, results: Any, values: Any) -> Any:
    """Draw the amplification of one building as shades; returns the picture for a bar of colours."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap

    below, above = EDGES.index(0.97) + 1, len(EDGES) - EDGES.index(1.03)
    depths = [*np.linspace(0.04, 0.42, below), 0.5, *np.linspace(0.60, 0.98, above)]
    colours = ListedColormap([colormaps["PuOr_r"](depth) for depth in depths])
    norm = BoundaryNorm(EDGES, len(depths), extend="both")
    ratios, (gaps, words) = results["period_ratio"].values, _gap_values(results)
    grid = values.transpose(amplification.gap_dim(results), "period_ratio").values
    picture = axis.pcolormesh(ratios, gaps, grid, shading="nearest", rasterized=True, cmap=colours, norm=norm)
    no_contact = results["contact_share"].transpose(amplification.gap_dim(results), "period_ratio").values == 0.0
    hatch(axis, (ratios, gaps), no_contact.astype(float), 0.5, "...")
    axis.axvline(1.0, color="black", linewidth=0.8, linestyle=":")
    ratio_axis(axis, "x", ratios)
    axis.set_ylim(gaps[0], gaps[-1])
    axis.set_ylabel(words)
    axis.grid(False)
    return picture


def _draw_sections(axis: Any, results: Any, values: Any) -> None:
    """Draw the amplification over the ratios at some gaps, with 1 marked."""
    ratios, (gaps, words) = results["period_ratio"].values, _gap_values(results)
    touching = np.flatnonzero(results["contact_share"].max("period_ratio").values > 0.0)
    widest = touching[-1] if touching.size else gaps.size - 1
    places = evenly(int(widest) + 1, SECTIONS)
    for place, (colour, dash) in zip(places, contact_styles(len(places)), strict=True):
        line = values.isel({amplification.gap_dim(results): place}).values
        axis.plot(ratios, line, linestyle=dash, color=colour, label=f"{gaps[place]:.3g}")
    axis.axhline(1.0, color="black", linewidth=0.9)
    axis.axvline(1.0, color="black", linewidth=0.8, linestyle=":")
    axis.legend(fontsize=8, title=words, title_fontsize=8, loc="upper center", ncols=len(places))
    ratio_axis(axis, "x", ratios)
    axis.set_ylim(0.0, HEAD_ROOM * axis.dataLim.y1)
    axis.set_ylabel("amplification [1]")
