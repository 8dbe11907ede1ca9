"""Figures of damage states: fragilities with pounding and without, and demands against intensity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.damage_words import METHOD_WORDS, case_words, check_damage, finding, measure_words
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import QUIET, blank, plain, styles, title
from pounding_risk.results.amplitudes import intensity_label, intensity_shown
from pounding_risk.units import SHOWN

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MARKS = ("o", "s", "^", "D", "v", "P")  # of states, beside their colours: told apart in print
LEAST = 0.01  # probability without pounding, below which a ratio is of the curves' tails alone
WIDEST = 30.0  # ratio to either side, at the ends of the axis
MOST_PANELS = 3  # demands of a figure
BEYOND = 6.0  # times the largest threshold: the end of the axis of demands
LINES = 40  # motions that are drawn one by one


def damage_figure(results: xr.Dataset, note: str = "") -> Figure:
    """Fragility of each damage state with pounding and without, and the ratio of both probabilities beneath.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `damage`.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        Curves above, with the shares of the motions at levels that all have; ratios with their bounds below.

    Raises
    ------
    PoundingError
        For a dataset of another call.
    """
    check_damage(results)
    _, factor = intensity_shown(results.attrs["intensity"])
    figure, axes = blank(2, 1, (8.5, 8.4), sharex=True, height_ratios=[3, 2])
    im = factor * results["im"].values
    for place, (state, (colour, _)) in enumerate(
        zip(results["state"].values, styles(results.sizes["state"]), strict=True)
    ):
        one, mark = results.sel(state=state), MARKS[place % len(MARKS)]
        for side, dash, fill in (("with", "-", colour), ("without", "--", "white")):
            part = one.sel(pounding=side)
            axes[0, 0].plot(im, part["probability"], dash, color=colour, linewidth=1.8)
            _shares(axes[0, 0], part, factor, {"color": colour, "marker": mark, "markerfacecolor": fill})
        axes[0, 0].plot([], [], "-", color=colour, marker=mark, label=plain(f"{state}: {one['state_words'].item()}"))
        _ratio(axes[1, 0], one, im, {"color": colour, "marker": mark})
    axes[0, 0].plot([], [], "-", color="black", marker="o", label="with pounding")
    axes[0, 0].plot([], [], "--", color="black", marker="o", markerfacecolor="white", label="without")
    axes[0, 0].set(ylabel="probability of the state [1]", ylim=(-0.02, 1.02))
    axes[0, 0].legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=2, frameon=False)
    axes[1, 0].axhline(1.0, color="black", linewidth=0.9)
    axes[1, 0].set(yscale="log", xlabel=intensity_label(results.attrs["intensity"]), ylabel="P with over P without [1]")
    _ratio_axis(axes[1, 0])
    if im[-1] > 3.0 * im[0]:
        axes[1, 0].set_xscale("log")
        _plain_ticks(axes[1, 0])
    bounds = f"bands: bounds by recording; ratios are drawn where P without is {LEAST:g} or more"
    marks = "marks: shares of the motions; " if _has_levels(results) else ""
    title(
        figure,
        finding(results),
        f"{case_words(results)}; {METHOD_WORDS[results.attrs['method']]}; {marks}{bounds}",
        note,
    )
    return figure


def _has_levels(results: xr.Dataset) -> bool:
    """Whether all motions have the same intensities, at several levels."""
    return results.sizes["level"] > 1 and "demand_percentile" in results


def _shares(axis: Any, part: xr.Dataset, factor: float, look: dict[str, Any]) -> None:
    """Draw the shares of the motions that reach the state, at levels that all of them have."""
    if not _has_levels(part):
        return
    runs = part["runs"].values
    shares = np.divide(part["reached"].values, runs, out=np.full(runs.shape, np.nan), where=runs > 0)
    axis.plot(factor * part["level"].values, shares, linestyle="none", markersize=5, alpha=0.8, **look)


def _ratio(axis: Any, one: xr.Dataset, im: Any, look: dict[str, Any]) -> None:
    """Draw the ratio of both probabilities, with its bounds."""
    shown = one["probability"].sel(pounding="without").values >= LEAST
    if not shown.any():
        return
    low, high = (one[f"probability_ratio_{end}"].values[shown] for end in ("low", "high"))
    axis.fill_between(im[shown], low, np.minimum(high, 1e3), color=look["color"], alpha=0.15, linewidth=0.0)
    axis.plot(im[shown], one["probability_ratio"].values[shown], "-", linewidth=1.8, markevery=8, markersize=5, **look)


def _ratio_axis(axis: Any) -> None:
    """Limits and ticks of the axis of ratios."""
    values = np.concatenate([line.get_ydata() for line in axis.get_lines()])
    values = values[np.isfinite(values) & (values > 0.0)]
    most = float(np.clip(1.3 * max(values.max(), 1.0 / values.min()), 1.5, WIDEST))
    ticks = [tick for tick in (0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0, 10.0, 20.0) if 1.0 / most <= tick <= most]
    axis.set_ylim(1.0 / most, most)
    axis.set_yticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_yticks([], minor=True)


def _plain_ticks(axis: Any) -> None:
    """Numbers in full on a logarithmic axis below."""
    low, high = axis.get_xlim()
    steps = [size * 10.0**power for power in range(-4, 4) for size in (1.0, 2.0, 5.0)]
    ticks = [tick for tick in steps if low <= tick <= high]
    axis.set_xticks(ticks, [f"{tick:g}" for tick in ticks])
    axis.set_xticks([], minor=True)


def ida_figure(results: xr.Dataset, note: str = "") -> Figure:
    """Demands of the motions against their intensity, with pounding and without, percentiles and thresholds.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `damage`, of motions at several levels.
    note : str
        Added to the caption.

    Returns
    -------
    matplotlib.figure.Figure
        One row for each demand of the states, two panels each.

    Raises
    ------
    PoundingError
        For a dataset of another call, and one of motions at one level.
    """
    check_damage(results)
    if results.sizes["level"] < 2:
        raise PoundingError("the motions of the dataset have one level each; curves of demands need several")
    groups = _groups(results)
    drawn = groups[:MOST_PANELS]
    figure, axes = blank(len(drawn), 2, (10.0, 0.9 + 4.0 * len(drawn)), sharey=True)
    _, factor = intensity_shown(results.attrs["intensity"])
    colours = {
        str(state): colour
        for state, (colour, _) in zip(results["state"].values, styles(results.sizes["state"]), strict=True)
    }
    for row, group in enumerate(drawn):
        _demands(axes[row], results.sel(state=group), factor, [colours[state] for state in group])
        axes[row, 0].set_ylabel(intensity_label(results.attrs["intensity"]))
    left_out = f"; {counted(len(groups) - len(drawn), 'more demand')} not drawn" if len(groups) > len(drawn) else ""
    lines = "thin: single motions; thick: 16, 50 and 84 % of the motions at each level, counted; dotted: thresholds"
    title(figure, _medians(results), f"{case_words(results)}; {lines}{left_out}", note)
    return figure


def _groups(results: xr.Dataset) -> list[list[str]]:
    """Names of the states that differ in their threshold alone."""
    groups: dict[str, list[str]] = {}
    for state in map(str, results["state"].values):
        demand = str(results["state_words"].sel(state=state).item()).partition(" ≥ ")[0]
        groups.setdefault(demand, []).append(state)
    return list(groups.values())


def _demands(panels: Any, group: xr.Dataset, factor: float, colours: Sequence[str]) -> None:
    """Draw one demand with pounding on the left, and without on the right."""
    first = group.isel(state=0)
    threshold, unit = float(first["state_threshold"]), str(first["state_unit"].item())
    name, size = SHOWN[unit]
    demand = str(first["state_words"].item()).partition(" ≥ ")[0]
    widest = size * float(group["state_threshold"].max())
    most = widest
    for axis, side in zip(panels, ("with", "without"), strict=True):
        part = first.sel(pounding=side)
        ims = factor * part["motion_intensity"].values.reshape(-1, group.sizes["level"])
        values = size * threshold * part["demand_ratio"].values.reshape(ims.shape)
        for im, value in list(zip(ims, values, strict=True))[:: max(1, len(ims) // LINES)]:
            axis.plot(np.append(0.0, value), np.append(0.0, im), color=QUIET, alpha=0.3, linewidth=0.6)
        if "demand_percentile" in part:
            for percentile, dash in zip(part["percentile"].values, ("--", "-", "-."), strict=True):
                middle = size * threshold * part["demand_percentile"].sel(percentile=percentile).values
                label = f"{percentile:g} %"
                axis.plot(middle, factor * part["level"].values, dash, color="black", linewidth=2.0, label=label)
                most = max(most, float(np.nanmax(middle, initial=0.0)))
        for place, (state, colour) in enumerate(zip(group["state"].values, colours, strict=True)):
            limit = size * float(group["state_threshold"].isel(state=place))
            axis.axvline(limit, color=colour, linestyle=":", linewidth=1.8, label=plain(str(state)))
        axis.set_title(f"{side} pounding", fontsize=9.5)
        axis.set_xlabel(plain(f"{demand} [{name}]" if name else f"{demand} [1]"))
    for axis in panels:
        axis.set_xlim(0.0, min(1.15 * most, BEYOND * widest))
        axis.set_ylim(bottom=0.0)
    panels[0].legend(
        fontsize=8, loc="lower right", handlelength=3.5, facecolor="white", framealpha=0.9, edgecolor=QUIET
    )


def _medians(results: xr.Dataset) -> str:
    """Sentence on the fitted median of each state; the thick lines of the figure are counted, and may differ."""
    measure, _ = measure_words(results)
    name, factor = intensity_shown(results.attrs["intensity"])
    clauses = []
    for state in map(str, results["state"].values):
        medians = factor * results["median"].sel(state=state)
        values = {side: float(medians.sel(pounding=side)) for side in ("with", "without")}
        words = [
            f"{value:.3g} {name} {side}".replace("  ", " ") for side, value in values.items() if np.isfinite(value)
        ]
        if words:
            clauses.append(f"{state} {' and '.join(words)} pounding")
    if not clauses:
        return f"No state has a median {measure} among the levels that were tested"
    method = METHOD_WORDS[str(results.attrs["method"])]
    return f"Fitted median {measure} ({method}): {'; '.join(clauses)}"
