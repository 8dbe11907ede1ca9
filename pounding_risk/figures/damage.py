"""Figures of damage states: fragilities with pounding and without, and demands against intensity."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk.assessment.damage_words import METHOD_WORDS, case_words, finding
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import QUIET, Figure, blank, logarithmic, message, plain, styles, title
from pounding_risk.results.amplitudes import intensity_label, intensity_shown
from pounding_risk.results.check import check_kind
from pounding_risk.units import SHOWN

MARKS = ("o", "s", "^", "D", "v", "P")  # of states, beside their colours, for print
LEAST = 0.01  # probability without pounding, below which a ratio is of the curves' tails alone
WIDEST = 30.0  # ratio to either side, at the ends of the axis
MOST_PANELS = 3  # demands of a figure
BEYOND, FARTHEST = 6.0, 50.0  # times the largest threshold: the end of the axis of demands, and where most go beyond
LINES = 40  # motions that are drawn one by one


def damage_figure(results: xr.Dataset, note: str = "", *, titled: bool = True) -> Figure:
    """Fragility of each damage state with pounding and without, and the ratio of both probabilities beneath.

    Parameters
    ----------
    results : xarray.Dataset
        A dataset of `damage`.
    note : str
        Added to the caption.
    titled : bool
        Whether finding and conditions are written.

    Returns
    -------
    matplotlib.figure.Figure
        Curves above, with the shares of the motions at levels that all have; ratios with their bounds below.

    Raises
    ------
    PoundingError
        For a dataset of another call.
    """
    check_kind(results, "damage")
    finding_words, results = finding(results), _known(results)
    _, factor = intensity_shown(results.attrs["intensity"])
    figure, (above, below) = blank(2, 1, (8.5, 8.4) if titled else (7.2, 7.2), sharex=True, height_ratios=[3, 2])
    curves, ratios = above[0], below[0]
    im = factor * results["im"].values
    has_levels = _has_levels(results)
    states = map(str, results["state"].values)
    for place, (state, (colour, _)) in enumerate(zip(states, styles(results.sizes["state"]), strict=True)):
        one, mark = results.sel(state=state), MARKS[place % len(MARKS)]
        for side, dash, fill in (("with", "-", colour), ("without", "--", "white")):
            curve = one.sel(pounding=side)
            curves.plot(im, curve["probability"], dash, color=colour, linewidth=1.8)
            if has_levels:
                runs = curve["runs"].values
                shares = np.divide(curve["reached"].values, runs, out=np.full(runs.shape, np.nan), where=runs > 0)
                look: dict[str, Any] = {"color": colour, "markerfacecolor": fill, "markersize": 5, "alpha": 0.8}
                curves.plot(factor * curve["level"].values, shares, mark, **look)
        curves.plot([], [], "-", color=colour, marker=mark, label=plain(f"{state}: {one['state_words'].item()}"))
        shown = one["probability"].sel(pounding="without").values >= LEAST
        low, high = (one[f"probability_ratio_{end}"].values[shown] for end in ("low", "high"))
        ratios.fill_between(im[shown], low, np.minimum(high, 1e3), color=colour, alpha=0.15, linewidth=0.0)
        look = {"color": colour, "marker": mark, "linewidth": 1.8, "markevery": 8, "markersize": 5}
        ratios.plot(im[shown], one["probability_ratio"].values[shown], "-", **look)
    curves.plot([], [], "-", color="black", marker="o", label="with pounding")
    curves.plot([], [], "--", color="black", marker="o", markerfacecolor="white", label="without")
    curves.set(ylabel="probability of the state [1]", ylim=(-0.02, 1.02))
    curves.legend(fontsize=8, loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=2, frameon=False)
    ratios.set(xlabel=intensity_label(results.attrs["intensity"]), ylabel="P with over P without [1]")
    values = np.concatenate([line.get_ydata() for line in ratios.get_lines()])
    values = values[np.isfinite(values) & (values > 0.0)]
    if values.size:
        ratios.axhline(1.0, color="black", linewidth=0.9)
        most = float(np.clip(1.3 * max(values.max(), 1.0 / values.min()), 1.5, WIDEST))
        logarithmic(ratios, "y", 1.0 / most, most)
    else:
        message(ratios, "No ratio: no state has curves both with pounding and without")
        ratios.set_yticks([])
    if im[-1] > 3.0 * im[0]:
        ratios.set_xscale("log")
        logarithmic(ratios, "x", *ratios.get_xlim())
    if titled:
        title(figure, plain(finding_words), _of_scene(results, damage_caption(results)), note)
    return figure


def _of_scene(results: xr.Dataset, words: str) -> str:
    return plain(f"{results.attrs['title']}: {words}").replace("F_E", "$F_E$")


def damage_caption(results: xr.Dataset) -> str:
    """What the curves are of, and what marks and bands are."""
    bounds = f"bands: bounds by recording; ratios are drawn where P without is {LEAST:g} or more"
    marks = "marks: shares of the motions; " if _has_levels(results) else ""
    return f"{case_words(results)}; {METHOD_WORDS[results.attrs['method']]}; {marks}{bounds}"


def _has_levels(results: xr.Dataset) -> bool:
    """True where all motions have the same intensities, at several levels."""
    return results.sizes["level"] > 1 and "demand_percentile" in results


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
    check_kind(results, "damage")
    if results.sizes["level"] < 2:
        raise PoundingError("the motions of the dataset have one level each; curves of demands need several")
    every, results = list(map(str, results["state"].values)), _known(results)
    lacking = [state for state in every if state not in results["state"]]
    groups: dict[str, list[str]] = {}  # states that differ in their threshold alone
    for state in map(str, results["state"].values):
        demand = str(results["state_words"].sel(state=state).item()).partition(" ≥ ")[0]
        groups.setdefault(demand, []).append(state)
    drawn = list(groups.values())[:MOST_PANELS]
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
    left_out += f"; no run has the demand of {', '.join(lacking)}" if lacking else ""
    lines = "thin: single motions; thick: 16, 50 and 84 % of the motions at each level, counted; dotted: thresholds"
    lines += "; lines end before a collapse, which has no demand" if np.isinf(results["demand_ratio"]).any() else ""
    title(figure, plain(finding(results)), _of_scene(results, f"{case_words(results)}; {lines}{left_out}"), note)
    return figure


def _known(results: xr.Dataset) -> xr.Dataset:
    """The states that any run has the demand of."""
    return results.isel(state=np.flatnonzero((results["runs"] > 0).any(["pounding", "level"])))


def _demands(panels: Any, group: xr.Dataset, factor: float, colours: Sequence[str]) -> None:
    """Draw one demand with pounding on the left, and without on the right."""
    first = group.isel(state=0)
    threshold, unit = float(first["state_threshold"]), str(first["state_unit"].item())
    name, size = SHOWN[unit]
    demand = str(first["state_words"].item()).partition(" ≥ ")[0]
    widest = size * float(group["state_threshold"].max())
    most = widest
    sides: dict[str, np.ndarray] = {}
    for axis, side in zip(panels, ("with", "without"), strict=True):
        of_side = first.sel(pounding=side)
        ims = factor * of_side["motion_intensity"].values.reshape(-1, group.sizes["level"])
        values = sides[side] = size * threshold * of_side["demand_ratio"].values.reshape(ims.shape)
        for im, value in list(zip(ims, values, strict=True))[:: max(1, len(ims) // LINES)]:
            axis.plot(np.append(0.0, value), np.append(0.0, im), color=QUIET, alpha=0.3, linewidth=0.6)
        if "demand_percentile" in of_side:
            for percentile, dash in zip(of_side["percentile"].values, ("--", "-", "-."), strict=True):
                middle = size * threshold * of_side["demand_percentile"].sel(percentile=percentile).values
                label = f"{percentile:g} %"
                axis.plot(middle, factor * of_side["level"].values, dash, color="black", linewidth=2.0, label=label)
                most = max(most, float(np.max(middle, where=np.isfinite(middle), initial=0.0)))
        for place, (state, colour) in enumerate(zip(group["state"].values, colours, strict=True)):
            limit = size * float(group["state_threshold"].isel(state=place))
            axis.axvline(limit, color=colour, linestyle=":", linewidth=1.8, label=plain(str(state)))
        axis.set_xlabel(plain(f"{demand} [{name}]" if name else f"{demand} [1]"))
    usual = float(np.nanmedian(sides["with"])) if np.isfinite(sides["with"]).any() else 0.0
    right = min(1.15 * most, max(BEYOND * widest, min(1.15 * usual, FARTHEST * widest)))
    for axis, (side, values) in zip(panels, sides.items(), strict=True):
        beyond, fell, words = values[(values > right) & np.isfinite(values)], int(np.isinf(values).sum()), ""
        if beyond.size:
            largest = f"{float(f'{beyond.max():.3g}'):.6g}"
            words = f"; {beyond.size} of {values.size} demands beyond the axis, up to {largest} {name}".rstrip()
        if fell:
            words += (";\n" if words else "; ") + f"{fell} of {values.size} runs collapse"
        axis.set_title(f"{side} pounding{words}", fontsize=9.5)
        axis.set_xlim(0.0, right)
        axis.set_ylim(bottom=0.0)
    panels[0].legend(fontsize=8, loc="best", handlelength=3.5, facecolor="white", framealpha=0.9, edgecolor=QUIET)
