"""Figures of damage states: fragilities with pounding and without, and demands against intensity."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
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
LEGEND: dict[str, Any] = {"fontsize": 8, "frameon": False}
LEAST = 0.01  # probability without pounding, below which a ratio compares the curves' tails alone
WIDEST = 30.0  # ratio to either side, at the ends of the axis
MOST_PANELS = 3  # demands of a figure of them
MOST_ROWS = 5  # demands of a figure of fragilities with more states than marks: as many as a page of a report holds
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
        Curves above, with the shares of the motions at levels that all have; ratios with their bounds below. Of more
        states than there are marks, a row of two panels for each demand.

    Raises
    ------
    PoundingError
        For a dataset of another call.
    """
    check_kind(results, "damage")
    finding_words, results = finding(results), _with_demands(results)
    groups, _ = _panels_of(results)
    if len(groups) == 1:
        figure, panels = blank(2, 1, (8.5, 8.4) if titled else (7.2, 7.2), sharex=True, height_ratios=[3, 2])
        panels = panels.T
    else:
        size = (9.6, 1.8 + 2.4 * len(groups)) if titled else (7.2, 0.6 + 2.0 * len(groups))
        figure, panels = blank(len(groups), 2, size, sharex=True, sharey="col")
    looks = _state_looks(results, groups)
    for (curves, ratios), group in zip(panels, groups, strict=True):
        group_results = results.sel(state=group)
        _draw_fragilities(curves, group_results, looks)
        _draw_ratios(ratios, group_results, looks)
        handles = _legend(group_results, looks, short=len(groups) > 1)
        if len(groups) == 1:
            curves.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.02), ncols=2, **LEGEND)
        else:
            curves.set_title(plain(_demand_words(group_results)), fontsize=9.5)
            ratios.legend(handles=handles, loc="center left", bbox_to_anchor=(1.0, 0.5), **LEGEND)
    _scale_ratios(panels[:, 1])
    for axis in panels[-1, len(groups) == 1 :]:
        axis.set_xlabel(intensity_label(results.attrs["intensity"]))
    _, factor = intensity_shown(results.attrs["intensity"])
    im = factor * results["im"].values
    for axis in panels.flat:
        axis.update_datalim(np.column_stack([im, im]), updatey=False)  # without any curve too
        if im[-1] > 3.0 * im[0]:
            axis.set_xscale("log")
            logarithmic(axis, "x", *axis.get_xlim())
    if titled:
        title(figure, plain(finding_words), _scene_words(results, damage_caption(results)), note)
    return figure


def _panels_of(results: xr.Dataset) -> tuple[list[list[str]], str]:
    """The states of each panel of fragilities: all in one, or a panel for each demand; words on states left out."""
    states = list(map(str, results["state"].values))
    return ([states], "") if len(states) <= len(MARKS) else _panels_by_demand(results, MOST_ROWS)


def _panels_by_demand(results: xr.Dataset, most: int) -> tuple[list[list[str]], str]:
    """States of one demand for each panel, no more than there are marks; ``most`` panels, words on the others."""
    states_by_demand: dict[str, list[str]] = {}
    for state in map(str, results["state"].values):
        states_by_demand.setdefault(_demand_words(results.sel(state=[state])), []).append(state)
    panels = [
        states[at : at + len(MARKS)] for states in states_by_demand.values() for at in range(0, len(states), len(MARKS))
    ]
    left_out_count = sum(map(len, panels[most:]))
    return panels[:most], f"; {counted(left_out_count, 'more state')} not drawn" if left_out_count else ""


def _demand_words(group: xr.Dataset) -> str:
    """The demand of the first state, in words: "storey drift of A"."""
    return str(group["state_words"].values[0]).partition(" ≥ ")[0]


def _state_looks(results: xr.Dataset, panels: Sequence[Sequence[str]]) -> dict[str, tuple[str, str]]:
    """Colour and mark of each state, unique in the figure, or in its panel where there are fewer marks."""
    states = list(map(str, results["state"].values))
    looks = {}
    for group in [states] if len(states) <= len(MARKS) else panels:
        for state, (colour, _), mark in zip(group, styles(len(group)), MARKS, strict=False):
            looks[state] = colour, mark
    return looks


def _draw_fragilities(axis: Any, group: xr.Dataset, looks: Mapping[str, tuple[str, str]]) -> None:
    """Curves with pounding and without, and the shares of the motions at levels that all have."""
    _, factor = intensity_shown(group.attrs["intensity"])
    for state in map(str, group["state"].values):
        colour, mark = looks[state]
        for side, dash, face in (("with", "-", colour), ("without", "--", "white")):
            curve = group.sel(state=state, pounding=side)
            axis.plot(factor * group["im"].values, curve["probability"], dash, color=colour, linewidth=1.8)
            if _has_levels(group):
                runs = curve["runs"].values
                shares = np.divide(curve["reached"].values, runs, out=np.full(runs.shape, np.nan), where=runs > 0)
                look: dict[str, Any] = {"color": colour, "markerfacecolor": face, "markersize": 5, "alpha": 0.8}
                axis.plot(factor * curve["level"].values, shares, mark, **look)
    axis.set(ylabel="probability of the state [1]", ylim=(-0.02, 1.02))
    if _is_empty(group):
        message(axis, f"No curve: {group['fault'].values.flat[0]}")


def _is_empty(group: xr.Dataset) -> bool:
    """True where no state has a curve, nor shares at levels."""
    return not _has_levels(group) and not bool(np.isfinite(group["probability"]).any())


def _draw_ratios(axis: Any, group: xr.Dataset, looks: Mapping[str, tuple[str, str]]) -> None:
    """The ratio of both probabilities of each state, with its bounds, where P without pounding is `LEAST` or more."""
    _, factor = intensity_shown(group.attrs["intensity"])
    im = factor * group["im"].values
    for state in map(str, group["state"].values):
        state_results, (colour, mark) = group.sel(state=state), looks[state]
        is_drawn = state_results["probability"].sel(pounding="without").values >= LEAST
        low, high = (state_results[f"probability_ratio_{end}"].values[is_drawn] for end in ("low", "high"))
        axis.fill_between(im[is_drawn], low, np.minimum(high, 1e3), color=colour, alpha=0.15, linewidth=0.0)
        look = {"color": colour, "marker": mark, "linewidth": 1.8, "markevery": 8, "markersize": 5}
        axis.plot(im[is_drawn], state_results["probability_ratio"].values[is_drawn], "-", **look)
    axis.set_ylabel("P with over P without [1]")


def _legend(group: xr.Dataset, looks: Mapping[str, tuple[str, str]], *, short: bool) -> list[Any]:
    """The look of each state, and of the curves with pounding and without; nothing where there are none."""
    from matplotlib.lines import Line2D

    if _is_empty(group):
        return []
    handles = []
    for state, words in zip(group["state"].values, group["state_words"].values, strict=True):
        colour, mark = looks[str(state)]
        label = f"{state}\n≥ {str(words).partition(' ≥ ')[2]}" if short else f"{state}: {words}"
        handles.append(Line2D([], [], color=colour, marker=mark, label=plain(label)))
    for label, dash, face in (("with pounding", "-", "black"), ("without", "--", "white")):
        look: dict[str, Any] = {"linestyle": dash, "markerfacecolor": face, "label": label}
        handles.append(Line2D([], [], color="black", marker="o", **look))
    return handles


def _scale_ratios(panels: Sequence[Any]) -> None:
    """One logarithmic scale of all panels of ratios; a panel without ratios has a message."""
    values_by_panel = []
    for axis in panels:
        values = np.concatenate([line.get_ydata() for line in axis.get_lines()])
        values_by_panel.append(values[np.isfinite(values) & (values > 0.0)])
        if values_by_panel[-1].size:
            axis.axhline(1.0, color="black", linewidth=0.9)
        else:
            message(axis, "No ratio: no state has curves both with pounding and without", 30)
    all_values = np.concatenate(values_by_panel)
    for axis in panels:
        if all_values.size:
            widest = float(np.clip(1.3 * max(all_values.max(), 1.0 / all_values.min()), 1.5, WIDEST))
            logarithmic(axis, "y", 1.0 / widest, widest)
        else:
            axis.set_yticks([])


def _scene_words(results: xr.Dataset, words: str) -> str:
    return plain(f"{results.attrs['title']}: {words}").replace("F_E", "$F_E$")


def damage_caption(results: xr.Dataset) -> str:
    """The case and the method of the curves, and the meaning of marks and bands."""
    bounds = f"bands: bounds by recording; ratios are drawn where P without is {LEAST:g} or more"
    marks = "marks: shares of the motions; " if _has_levels(results) else ""
    _, left_out = _panels_of(_with_demands(results))
    return f"{case_words(results)}; {METHOD_WORDS[results.attrs['method']]}; {marks}{bounds}{left_out}"


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
    states, results = list(map(str, results["state"].values)), _with_demands(results)
    states_without = [state for state in states if state not in results["state"]]
    groups, left_out = _panels_by_demand(results, MOST_PANELS)
    looks = _state_looks(results, groups)
    figure, axes = blank(len(groups), 2, (10.0, 0.9 + 4.0 * len(groups)), sharey=True)
    _, factor = intensity_shown(results.attrs["intensity"])
    for row, group in enumerate(groups):
        _draw_demands(axes[row], results.sel(state=group), factor, [looks[state][0] for state in group])
        axes[row, 0].set_ylabel(intensity_label(results.attrs["intensity"]))
    left_out += f"; no run has the demand of {', '.join(states_without)}" if states_without else ""
    lines = "thin: single motions; thick: 16, 50 and 84 % of the motions at each level, counted; dotted: thresholds"
    lines += "; lines end before a collapse, which has no demand" if np.isinf(results["demand_ratio"]).any() else ""
    title(figure, plain(finding(results)), _scene_words(results, f"{case_words(results)}; {lines}{left_out}"), note)
    return figure


def _with_demands(results: xr.Dataset) -> xr.Dataset:
    """The states whose demand some run has; all states where none has."""
    indices = np.flatnonzero((results["runs"] > 0).any(["pounding", "level"]))
    return results.isel(state=indices) if indices.size else results


def _draw_demands(panels: Any, group: xr.Dataset, factor: float, colours: Sequence[str]) -> None:
    """Draw one demand with pounding on the left, and without on the right."""
    first = group.isel(state=0)
    threshold, unit = float(first["state_threshold"]), str(first["state_unit"].item())
    name, size = SHOWN[unit]
    demand = _demand_words(group)
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
        for index, (state, colour) in enumerate(zip(group["state"].values, colours, strict=True)):
            limit = size * float(group["state_threshold"].isel(state=index))
            axis.axvline(limit, color=colour, linestyle=":", linewidth=1.8, label=plain(str(state)))
        axis.set_xlabel(plain(f"{demand} [{name}]" if name else f"{demand} [1]"))
    median_demand = float(np.nanmedian(sides["with"])) if np.isfinite(sides["with"]).any() else 0.0
    right = min(1.15 * most, max(BEYOND * widest, min(1.15 * median_demand, FARTHEST * widest)))
    for axis, (side, values) in zip(panels, sides.items(), strict=True):
        beyond, collapses, words = values[(values > right) & np.isfinite(values)], int(np.isinf(values).sum()), ""
        if beyond.size:
            largest = f"{float(f'{beyond.max():.3g}'):.6g}"
            words = f"; {beyond.size} of {values.size} demands beyond the axis, up to {largest} {name}".rstrip()
        if collapses:
            words += (";\n" if words else "; ") + f"{collapses} of {values.size} runs collapse"
        axis.set_title(f"{side} pounding{words}", fontsize=9.5)
        axis.set_xlim(0.0, right)
        axis.set_ylim(bottom=0.0)
    panels[0].legend(fontsize=8, loc="best", handlelength=3.5, facecolor="white", framealpha=0.9, edgecolor=QUIET)
