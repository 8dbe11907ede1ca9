"""Figures of published cases: published points over our curves, and how far every value is from ours."""

from __future__ import annotations

from math import isfinite
from typing import Any

from pounding_risk.figures.style import QUIET, STYLES, Figure, blank, legend_below, plain, title, wrapped
from pounding_risk.units import SHOWN

MOST_PANELS = 10
FEWEST_POINTS = 2  # of a curve that is drawn
MARKERS = {"closed form": "o", "another program": "s", "printed": "D", "read off a figure": "^", "experiment": "*"}
WORDS = {
    "exact": ("#0072B2", "o", "#0072B2"),
    "acceptable": ("#D55E00", "s", "none"),
    "unacceptable": ("#000000", "X", "k"),
}
POINT_MARKS = ("o", "s", "^", "D")
FURTHER_DASHES = ((0, (5, 1, 1, 1, 1, 1)), (0, (1, 1)), (0, (8, 2)), (0, (3, 1, 1, 1)), (0, (2, 2, 6, 2)))
SMALLEST = 1e-12  # a difference below it is drawn there
ROW = 0.165  # inches


def verification_figure(outcome: Any) -> Figure:
    """Published points over our curves, a panel for each curve with several points.

    Parameters
    ----------
    outcome : Verification
        As `verify` gives it.

    Returns
    -------
    matplotlib.figure.Figure
        At most ten panels.

    Raises
    ------
    ValueError
        If no case has a curve with several published points.
    """
    from matplotlib.lines import Line2D

    curves = [curve for curve in outcome.curves if len(curve.points) >= FEWEST_POINTS]
    if not curves:
        raise ValueError("no case has a history or a curve of force with several published points")
    drawn_curves = curves[:MOST_PANELS]
    figure, axes = wrapped(len(drawn_curves), 2, (9.6, 1.2), (0.0, 2.9))
    for axis, curve in zip(axes.flat, drawn_curves, strict=False):
        _panel(axis, curve)
    kinds = dict.fromkeys(point.kind for curve in drawn_curves for point in curve.points)
    handles: list[Any] = [Line2D([], [], color=STYLES[0][0], label="ours")]
    handles += [
        Line2D([], [], linestyle="", marker=MARKERS[kind], color=STYLES[1][0], markerfacecolor="none", label=kind)
        for kind in kinds
    ]
    more_text = f"; {len(drawn_curves)} of {len(curves)} curves" if len(curves) > len(drawn_curves) else ""
    condition = f"Bars: uncertainty of the published values{more_text}"
    title(figure, outcome.finding(), condition)
    legend_below(figure, handles, len(handles))
    return figure


def _panel(axis: Any, curve: Any) -> None:
    (_, x_size), (_, y_size) = (SHOWN.get(unit, (unit, 1.0)) for unit in curve.units)
    axis.plot(curve.x * x_size, curve.y * y_size, color=STYLES[0][0], linewidth=1.6)
    for point in curve.points:
        look = {"color": STYLES[1][0], "markerfacecolor": "none", "marker": MARKERS[point.kind], "markersize": 7.0}
        spread = point.uncertainty * y_size or None
        axis.errorbar(point.x * x_size, point.y * y_size, yerr=spread, linestyle="", capsize=3.0, zorder=3, **look)
    axis.set(xlabel=_axis_words(curve, 0), ylabel=_axis_words(curve, 1))
    axis.set_title(plain(curve.source), fontsize=9.5)


def _axis_words(curve: Any, index: int) -> str:
    unit, _ = SHOWN.get(curve.units[index], (curve.units[index], 1.0))
    return plain(f"{curve.axes[index]} [{unit}]")


def verification_differences_figure(outcome: Any) -> Figure:
    """How far each published value is from ours, beside how far ours changes with the tolerance of the solver.

    Parameters
    ----------
    outcome : Verification
        As `verify` gives it.

    Returns
    -------
    matplotlib.figure.Figure
        One line for each value, with logarithmic shares.
    """
    from matplotlib.lines import Line2D

    checks = list(outcome.checks)
    figure, axes = blank(1, 1, (9.6, 2.2 + ROW * len(checks)))
    axis = axes[0, 0]
    for row, check in enumerate(checks):
        colour, marker, face = WORDS[check.word]
        look: dict[str, Any] = {"marker": marker, "color": colour, "markerfacecolor": face, "markersize": 5.5}
        axis.plot(_shown_share(check.difference), row, zorder=3, **look)
        if isfinite(check.change):
            axis.plot(_shown_share(check.change), row, marker="|", color=QUIET, markersize=7.0)
    axis.axvline(0.05, color=QUIET, linestyle="--", linewidth=1.0)
    axis.set(xscale="log", xlim=(SMALLEST / 2.0, 1.0), ylim=(len(checks) - 0.4, -0.6))
    axis.set_xlabel("share of the published value; what is smaller than 1e-12 is drawn there")
    axis.set_yticks(range(len(checks)), [plain(f"{check.source}: {check.quantity}") for check in checks], fontsize=6.5)
    handles: list[Any] = [
        Line2D([], [], linestyle="", marker=marker, color=colour, markerfacecolor=face, label=f"difference, {word}")
        for word, (colour, marker, face) in WORDS.items()
        if any(check.word == word for check in checks)
    ]
    handles.append(Line2D([], [], linestyle="", marker="|", color=QUIET, label="tolerance effect, rtol 1e-6 to 1e-9"))
    handles.append(Line2D([], [], linestyle="--", color=QUIET, label="5 %"))
    condition = "difference of published values from ours, and change of ours with the tolerance"
    title(figure, outcome.finding(), condition)
    legend_below(figure, handles, 3)
    return figure


def outcome_figure(outcome: Any) -> Figure:
    """The differences of all published values; for an outcome with properties alone its first property.

    Parameters
    ----------
    outcome : Verification
        As `verify` gives it.

    Returns
    -------
    matplotlib.figure.Figure
        As `verification_differences_figure` or `property_figure` draws it.
    """
    return verification_differences_figure(outcome) if outcome.checks else property_figure(outcome.properties[0])


def property_figure(one: Any) -> Figure:
    """A published relation and ours, as its panels say.

    Parameters
    ----------
    one : Property
        One of the properties that `verify` gives.

    Returns
    -------
    matplotlib.figure.Figure
        Its panels, side by side.
    """
    figure, axes = blank(1, len(one.panels), (9.6, 4.4))
    handles: dict[str, Any] = {}
    for axis, panel in zip(axes.flat, one.panels, strict=True):
        for number, series in enumerate(panel.series):
            handles.setdefault(series.label, _draw_series(axis, series, number))
        axis.set(xlabel=panel.axes[0], ylabel=panel.axes[1])
        axis.set_title(panel.title, fontsize=9.5)
    title(figure, one.headline, one.condition)
    legend_below(figure, list(handles.values()), min(len(handles), 4))
    return figure


def _draw_series(axis: Any, series: Any, number: int) -> Any:
    """Draw the series of this number in its panel; returns its entry for the legend."""
    colour = STYLES[number % len(STYLES)][0]
    # Where colours come a second time, a dash that no line has had.
    dash: Any = STYLES[number][1] if number < len(STYLES) else FURTHER_DASHES[number % len(FURTHER_DASHES)]
    if series.look == "points":
        spread = None if series.low is None else [series.y - series.low, series.high - series.y]
        look: dict[str, Any] = {
            "color": colour,
            "marker": POINT_MARKS[number % len(POINT_MARKS)],
            "markerfacecolor": "none",
        }
        look |= {"linestyle": "", "capsize": 3.0, "zorder": 3, "markersize": 6.0}
        return axis.errorbar(series.x, series.y, yerr=spread, label=series.label, **look)
    if series.look == "band":
        axis.fill_between(series.x, series.low, series.high, color=colour, alpha=0.2, linewidth=0.0)
    return axis.plot(series.x, series.y, color=colour, linestyle=dash, linewidth=1.5, label=series.label)[0]


def _shown_share(share: float) -> float:
    return min(max(abs(share), SMALLEST), 1.0)
