"""Figure of the amplification of two buildings by pounding over the ratio of their periods and the gap."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessment.amplification import (
    OUTPUTS,
    check_amplification,
    gap_dim,
    raised_words,
    ratio_words,
    reference_name,
    rises,
    told_words,
)
from pounding_risk.assessment.spectra import motions_words, usual_percentile
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import QUIET, blank, contact_styles, plain, title

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

EDGES = (0.5, 0.7, 0.8, 0.9, 0.97, 1.03, 1.1, 1.25, 1.5, 2.0, 3.0)  # of the shades; the middle one is no change
SECTIONS = 4  # gaps along which sections are drawn
TICKS = (0.1, 0.2, 0.3, 0.5, 0.7, 1.0, 1.5, 2.0, 3.0, 5.0, 10.0)


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
    check_amplification(results)
    if f"{output}_amplification" not in results:
        known = [known for known in OUTPUTS if f"{known}_amplification" in results]
        raise PoundingError(f"output: {output} is not in the dataset, which has {', '.join(known)}; choose one")
    at = usual_percentile(results) if percentile is None else float(percentile)
    stays = float(results["fixed_period"][0]) if period is None else float(period)
    for name, value, unit in (("percentile", at, "%"), ("fixed_period", stays, "s")):
        if value not in results[name].values:
            listed = ", ".join(f"{one:g}" for one in results[name].values)
            asked = name.removeprefix("fixed_")
            raise PoundingError(f"{asked}: {value:g} {unit} is not in the dataset, which has {listed}; choose one")
    shown = results.sel(fixed_period=[stays])
    one = shown.isel(fixed_period=0)
    values = one[f"{output}_amplification"].sel(percentile=at)
    figure, axes = blank(2, 2, (11.5, 9.0), sharex=True)
    for column, name in enumerate(map(str, results["building"].values)):
        of_building = values.isel(building=column)
        picture = _map(axes[0, column], one, of_building)
        axes[0, column].set_title(plain(f"{name}: {output} with contact over that without"), fontsize=9.5)
        _sections(axes[1, column], one, of_building)
        axes[1, column].set_xlabel(plain(ratio_words(results)))
    bar = figure.colorbar(picture, ax=axes[0, :], pad=0.01, aspect=30, ticks=EDGES, label="amplification [1]")
    bar.ax.tick_params(labelsize=8)
    told = f"{motions_words(results)}; {told_words(results)}; {_staying_words(results, stays)}"
    # The places have room in the caption alone, whatever the buildings are called.
    found = rises(shown, output, at)
    largest = "".join(
        f"{words} at {where}; " for words, (_, where) in zip(("stiffer", "softer"), found, strict=True) if where
    )
    largest = f"largest of the {largest}" if largest else ""
    heading = f"{raised_words(output, at)}: {', '.join(rise for rise, _ in found)}"
    title(figure, heading, f"{largest}{told}; dotted area: no motion touches", note)
    return figure


def _staying_words(results: Any, period: float) -> str:
    """Which building stays, and its period."""
    place = ("left", "right").index(str(results.attrs["fixed"]))
    return plain(f"T({results['building'].values[place]}) = {period:.3g} s")


def _over_ratios(axis: Any, ratios: Any) -> None:
    """Limits and ticks of an axis of ratios; logarithmic where they span more than three times the smallest."""
    if ratios[-1] > 3.0 * ratios[0]:
        axis.set_xscale("log")
        ticks = [tick for tick in TICKS if ratios[0] <= tick <= ratios[-1]]
        axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
        axis.set_xticks([], minor=True)
    axis.set_xlim(ratios[0], ratios[-1])


def _gaps(results: Any) -> tuple[Any, str]:
    """The values of the axis of gaps, and its words."""
    if gap_dim(results) == "gap":
        return 1e3 * results["gap"].values, "gap [mm]"
    of = reference_name(results)
    at = f"at {float(results.attrs['share_percentile']):g} %"
    return results["gap_share"].values, f"gap / {of} {at} [1]" if "times" not in of else f"gap / gap required {at} [1]"


def _map(axis: Any, results: Any, values: Any) -> Any:
    """Draw the amplification of one building as shades; returns what a bar of colours needs."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm, ListedColormap

    below, above = EDGES.index(0.97) + 1, len(EDGES) - EDGES.index(1.03)
    depths = [*np.linspace(0.04, 0.42, below), 0.5, *np.linspace(0.60, 0.98, above)]
    colours = ListedColormap([colormaps["PuOr_r"](depth) for depth in depths])
    norm = BoundaryNorm(EDGES, len(depths), extend="both")
    ratios, (gaps, words) = results["period_ratio"].values, _gaps(results)
    grid = values.transpose(gap_dim(results), "period_ratio").values
    picture = axis.pcolormesh(ratios, gaps, grid, shading="nearest", rasterized=True, cmap=colours, norm=norm)
    none = results["contact_share"].transpose(gap_dim(results), "period_ratio").values == 0.0
    if none.any():
        still = axis.contourf(ratios, gaps, none.astype(float), levels=[0.5, 1.5], colors="none", hatches=["..."])
        still.set_edgecolor(QUIET)
        still.set_linewidth(0.0)
    axis.axvline(1.0, color="black", linewidth=0.8, linestyle=":")
    _over_ratios(axis, ratios)
    axis.set_ylim(gaps[0], gaps[-1])
    axis.set_ylabel(words)
    axis.grid(False)
    return picture


def _sections(axis: Any, results: Any, values: Any) -> None:
    """Draw the amplification over the ratios at some gaps, with 1 marked."""
    ratios, (gaps, words) = results["period_ratio"].values, _gaps(results)
    touching = np.flatnonzero(results["contact_share"].max("period_ratio").values > 0.0)
    widest = touching[-1] if touching.size else gaps.size - 1
    places = sorted({round(place) for place in np.linspace(0, widest, SECTIONS).tolist()})
    for place, (colour, dash) in zip(places, contact_styles(len(places)), strict=True):
        line = values.isel({gap_dim(results): place}).values
        axis.plot(ratios, line, linestyle=dash, color=colour, label=f"{gaps[place]:.3g}")
    axis.axhline(1.0, color="black", linewidth=0.9)
    axis.axvline(1.0, color="black", linewidth=0.8, linestyle=":")
    axis.legend(fontsize=8, title=words, title_fontsize=8)
    _over_ratios(axis, ratios)
    axis.set_ylim(bottom=0.0)
    axis.set_ylabel("amplification [1]")
