"""Figure of the gap required over the periods of two buildings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment import spectra
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import ROUND, STYLES, Figure, blank, hatch, ratio_axis, title
from pounding_risk.results.check import check_kind

RATIOS = (0.5, 0.8, 0.95)  # of the periods, along which sections are drawn
BANDS = (0.6, 0.7, 0.8, 0.9, 1.0, 1.1, 1.2, 1.3, 1.4)  # of a ratio, one shade each
ROUNDING = 1e-9  # share by which periods are no other
SHORT = 1.05  # ratio above which a rule is shown as insufficient: a smaller one is within the scatter of few motions


def gap_spectra_figure(
    results: xr.Dataset, percentile: float | None = None, rules: Sequence[str] = spectra.JUDGED, note: str = ""
) -> Figure:
    """Gap required over the periods of two buildings, and its ratio to what two rules require.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `spectra`.
    percentile : float, optional
        One of the dataset's [%]; 84, or its largest, by default.
    rules : sequence of str
        Two rules of the dataset; SRSS and the double difference by default.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Contours of the gap, of its ratios to both rules, and sections at constant ratios of the periods.

    Raises
    ------
    PoundingError
        For a dataset of another call, and a percentile or a rule that it has not.
    """
    check_kind(results, "spectra")
    percent = spectra.usual_percentile(results) if percentile is None else float(percentile)
    if percent not in results["percentile"].values:
        values_text = ", ".join(f"{value:g}" for value in results["percentile"].values)
        raise PoundingError(f"percentile: {percent:g} % is not in the dataset, which has {values_text}; choose one")
    pair = spectra.check_rules(results, rules)
    if len(pair) != 2:
        raise PoundingError(f"rules: {counted(len(pair), 'rule')}; the figure has two, such as srss and cqc: name two")
    part = results.sel(percentile=[percent])
    figure, axes = blank(2, 2, (11.5, 10.2))
    _draw_gaps(figure, axes[0, 0], part, percent)
    for axis, rule in zip((axes[0, 1], axes[1, 0]), pair, strict=True):
        _draw_ratios(figure, axis, part, rule)
    _draw_sections(axes[1, 1], part, pair)
    dampings = [f"{100.0 * float(results[f'{side}_damping']):.3g} %" for side in ("left", "right")]
    damping = dampings[0] if dampings[0] == dampings[1] else " and ".join(dampings)
    rules_words = " and ".join(map(spectra.rule_words, pair))
    assumed = f"single masses without contact, damping {damping}; {rules_words} of linear displacements (factors 1)"
    title(
        figure,
        spectra.finding(part, pair),
        f"{spectra.motions_words(results)}; {assumed}; white: no gap needed",
        note,
    )
    return figure


def _set_up_periods(axis: Any, results: xr.Dataset) -> tuple[Any, Any]:
    """Set up an axis of both periods; returns the periods."""
    periods = results["left_period"].values, results["right_period"].values
    for side, values, name in zip("xy", periods, ("left", "right"), strict=True):
        ratio_axis(axis, side, values)
        getattr(axis, f"set_{side}label")(f"period of the {name} building [s]")
    axis.grid(False)
    return periods


def _draw_gaps(figure: Figure, axis: Any, results: xr.Dataset, percent: float) -> None:
    """Draw the gap required as a map with labelled contours [mm], the five or six round ones below the largest."""
    left, right = _set_up_periods(axis, results)
    gap = 1e3 * results["required_gap"].isel(percentile=0).values.T
    picture = axis.pcolormesh(left, right, gap, cmap="Blues", shading="gouraud", rasterized=True)
    levels = [step for step in ROUND if step < gap.max()][-6:]
    if levels:
        lines = axis.contour(left, right, gap, levels=levels, colors="black", linewidths=0.8)
        axis.clabel(lines, fmt="%g", fontsize=8)
    figure.colorbar(picture, ax=axis, pad=0.01, aspect=30, label="gap [mm]")
    axis.set_title(f"gap required by {percent:g} % of the motions [mm]", fontsize=9.5)


def _draw_ratios(figure: Figure, axis: Any, results: xr.Dataset, rule: str) -> None:
    """Draw the gap required over what a rule requires, hatched where the rule is clearly insufficient."""
    from matplotlib import colormaps
    from matplotlib.colors import BoundaryNorm

    words = spectra.rule_words(rule)
    left, right = _set_up_periods(axis, results)
    ratio = spectra.ratio_to_rule(results, rule, float(results["percentile"][0])).T
    colours = colormaps["PuOr_r"]
    norm = BoundaryNorm(BANDS, colours.N, extend="both")
    picture = axis.pcolormesh(left, right, ratio, shading="nearest", rasterized=True, cmap=colours, norm=norm)
    hatch(axis, (left, right), ratio, SHORT, "//////")
    if np.nanmin(ratio, initial=SHORT) < SHORT < np.nanmax(ratio, initial=SHORT):
        axis.contour(left, right, ratio, levels=[SHORT], colors="black", linewidths=0.9)
    figure.colorbar(picture, ax=axis, pad=0.01, aspect=30, ticks=BANDS, label=f"gap / {words} [1]")
    most = f"{100.0 * (SHORT - 1.0):.0f} %"
    axis.set_title(f"gap required over {words}\nhatched where it is more than {most} above", fontsize=9.5)


def _draw_sections(axis: Any, results: xr.Dataset, rules: Sequence[str]) -> None:
    """Draw the gap required and both rules along lines of constant T_right / T_left."""
    from scipy.interpolate import RegularGridInterpolator

    left, right = results["left_period"].values, results["right_period"].values
    required = results["separation"].isel(percentile=0)
    curves = [(results["required_gap"].isel(percentile=0).values, "-", 1.9)]
    curves += [(required.sel(rule=rule).values, dash, 1.1) for rule, dash in zip(rules, ("--", ":"), strict=True)]
    ratio_axis(axis, "x", left)
    for ratio, (colour, _) in zip(RATIOS, STYLES, strict=False):
        # Only where a period of the grid lies between both: near equal periods, which need no gap, it is not linear.
        is_between = np.searchsorted(right, left * (1.0 - ROUNDING)) > np.searchsorted(right, ratio * left)
        periods_inside = left[is_between & (ratio * left >= right[0]) & (ratio * left <= right[-1])]
        if periods_inside.size < 2:
            continue
        places = np.column_stack([np.log(periods_inside), np.log(ratio * periods_inside)])
        for values, dash, width in curves:
            # Linear between the logarithms of the periods.
            along = RegularGridInterpolator((np.log(left), np.log(right)), values, bounds_error=False, fill_value=None)
            axis.plot(periods_inside, 1e3 * along(places), dash, color=colour, linewidth=width)
        axis.plot([], [], "-", color=colour, linewidth=1.9, label=f"right = {ratio:g} left")
    for words, dash in zip(("gap required", *map(spectra.rule_words, rules)), ("-", "--", ":"), strict=True):
        axis.plot([], [], dash, color="black", label=words)
    axis.legend(fontsize=8.5, loc="upper left", handlelength=3.0)
    axis.set_xlabel("period of the left building [s]")
    axis.set_ylabel("gap [mm]")
    axis.set_ylim(bottom=0.0)
    axis.set_title("along constant ratios of the periods", fontsize=9.5)
