"""Figure of a row in elevation: buildings to scale, gaps, contact points, and contact at each over the motions."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import BuildingShape, RowCase, Touch, force_text
from pounding_risk.figures.style import (
    QUIET,
    STYLES,
    blank,
    force_words,
    law_words,
    legend_below,
    plain,
    share_bar,
    title,
)
from pounding_risk.motions.levels import PEAK
from pounding_risk.results.opened import Results
from pounding_risk.units import say_in

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

WIDTH = 9.0  # m, of every building as drawn
WIDEST_GAP = 1.5  # m, as drawn
LETTERS_AN_INCH = 11.0  # of a title
ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # by which gaps are drawn larger than they are
ON_A_LINE = 8  # buildings; a longer row is drawn in several lines
CROWDED = 8  # contact points of an interface; of more, only some have their numbers written
MARKERS = {"floor": "o", "column": "D"}
RAISED = STYLES[1][0]


class _Line(NamedTuple):
    """One line of the figure: buildings ``first`` to ``last``, and their left walls [m]."""

    first: int
    last: int
    walls: tuple[float, ...]
    gap_scale: float


def elevation_figure(case: RowCase, note: str = "", *, titled: bool = True) -> Figure:
    """A row in elevation, with the share of the motions that bring contact at each contact point.

    Heights are to scale, widths are nominal and gaps drawn larger by the factor that is stated. At each contact point
    the colour is the share of the motions with contact, and beside it stand this share and the median of the peak
    force where there is contact; below, where the force reaches F_E, the share that does.

    Parameters
    ----------
    case : RowCase
        One cell of a row's grid, from `row_case`.
    note : str
        Added to the caption.
    titled : bool
        Whether the finding and its conditions are written; a report has them beside the figure.

    Returns
    -------
    matplotlib.figure.Figure
        A long row stands in several lines.
    """
    lines = _lines(case)
    tallest = max(building.height for building in case.buildings)
    across = max(line.last - line.first + 1 for line in lines)
    size = (max(8.6, 1.5 + 1.75 * across), 1.6 + len(lines) * (1.5 + min(max(0.16 * tallest, 2.0), 5.5)))
    figure, axes = blank(len(lines), 1, size)
    picture: Any = None
    for axis, line in zip(axes[:, 0], lines, strict=True):
        picture = _draw(axis, case, line, tallest)
        axis.set_xlim(-1.0, max(line.walls[-1] for line in lines) + WIDTH + 1.0)
    share_bar(figure, picture, axes, "share of the motions with contact", 30.0 * len(lines))
    if titled:
        heading(figure, elevation_finding(case), [case], note)
    _legend(figure, case)
    return figure


def heading(figure: Figure, finding: str, cases: Sequence[RowCase], note: str = "") -> None:
    """Title and caption of a figure of one row or several, with the cell of the grid."""
    every = cases[0]._replace(gaps=tuple(gap for case in cases for gap in case.gaps))
    subject = f"{len(cases)} rows" if len(cases) > 1 else every.results.attrs["title"]
    sentences = (finding, f"{subject}: {where_words(every)}", note)
    title(figure, *(plain(words).replace("F_E", "$F_E$") for words in sentences))


def elevation_finding(case: RowCase) -> str:
    """Sentence on where contact is most likely, with which force, and whether it reaches F_E."""
    shares = [touch.contact for touch in case.touches]
    if not any(touch.runs for touch in case.touches):
        return f"No run of {counted(case.motions, 'motion')} is complete"
    if not np.nanmax(shares) > 0.0:
        return f"No contact in {counted(case.motions, 'motion')}"
    # Of several that touch as often, the one that is struck hardest.
    at = max(
        range(len(shares)), key=lambda index: (np.nan_to_num(shares[index]), np.nan_to_num(case.touches[index].force))
    )
    most = case.touches[at]
    touched, several = sum(share > 0.0 for share in shares), len(shares) > 1
    where = f"at {touched} of {len(shares)} interfaces, most often " if several else ""
    motions = f"{round(most.contact * most.runs)} of {counted(most.runs, 'motion')}"
    finding = (
        f"Contact {where}between {between(case.interfaces[at])}: {motions}, {force_text(most.force)} in the median"
    )
    yields = [touch.yielding for touch in case.touches]
    if max(np.nan_to_num(yields)) > 0.0:
        index = int(np.nanargmax(yields))
        share = f"{100 * yields[index]:.0f} %"
        finding += f"; F_E reached in {f'up to {share} ({between(case.interfaces[index])})' if several else share}"
    return finding


def where_words(case: RowCase) -> str:
    """Gap, yield force, contact model, motions and amplitude of the cell, in words."""
    results = case.results
    gaps = sorted(set(np.round(case.gaps, 9)))
    ends = " to ".join(f"{1e3 * gap:.4g}" for gap in dict.fromkeys((gaps[0], gaps[-1])))
    gap_words = f"gap{'s' * (len(gaps) > 1)} {ends} mm"
    force = force_words(float(results["yield_force"])).replace("$F_E$", "F_E")
    words = [
        gap_words,
        f"{force}{_column_words(results)}",
        law_words(str(results["contact_model"].values)),
        f"{case.motions} motion{'s' if case.motions > 1 else ''}",
    ]
    amplitudes = Results(results).amplitudes
    if amplitudes.values[0] is not None and np.isfinite(amplitudes.values[0]):
        measured = "" if amplitudes.measure == PEAK else f"{amplitudes.measure.words} "
        words.append(measured + amplitudes.words(amplitudes.values[0]))
    return ", ".join(words)


def _column_words(results: xr.Dataset) -> str:
    """Words on the F_E of columns, where columns are met and have another than the floors."""
    if "contact_point_yield_force" not in results.variables:
        return ""
    yield_forces = results["contact_point_yield_force"].values[results["contact_point_kind"].values == "column"]
    forces = sorted(
        {
            round(force / 1e3)
            for force in yield_forces[np.isfinite(yield_forces) & (yield_forces != float(results["yield_force"]))]
        }
    )
    if not forces:
        return ""
    return f" (of columns {forces[0]}{f' to {forces[-1]}' if len(forces) > 1 else ''} kN)"


def between(interface: str) -> str:
    """Both buildings of an interface, joined by "and"."""
    return interface.replace(" | ", " and ")


def _lines(case: RowCase) -> list[_Line]:
    """Cut the row into lines; a building at a cut stands at the end of one and at the start of the next."""
    count = len(case.buildings)
    n_lines = max(1, -(-(count - 1) // (ON_A_LINE - 1)))
    cuts = np.round(np.linspace(0, count - 1, n_lines + 1)).astype(int)
    scale = gap_scale(case.gaps)
    lines = []
    for first, last in pairwise(cuts):
        steps = [WIDTH + scale * case.gaps[at] for at in range(first, last)]
        walls = np.concatenate([[0.0], np.cumsum(steps)])
        lines.append(_Line(int(first), int(last), tuple(walls.tolist()), scale))
    return lines


def gap_scale(gaps: Sequence[float]) -> float:
    """The largest round factor that keeps the widest gap within `WIDEST_GAP`."""
    widest = max(gaps, default=0.0)
    return float(max((factor for factor in ROUND if factor * widest <= WIDEST_GAP), default=1))


def _draw(axis: Any, case: RowCase, line: _Line, tallest: float) -> Any:
    for wall, at in zip(line.walls, range(line.first, line.last + 1), strict=True):
        outline(axis, case.buildings[at], wall)
    inside = [point for point in case.points if line.first <= point.interface < line.last]
    middles = [_middle(case, line, point.interface) for point in inside]
    for at in range(line.first, line.last):
        _interface(axis, case, line, at)
    shares = np.array([point.touch.contact for point in inside])
    picture: Any = None
    for kind, marker in MARKERS.items():
        same_kind = [number for number, point in enumerate(inside) if point.kind == kind]
        edges = [RAISED if inside[number].touch.yielding > 0.0 else "black" for number in same_kind]
        picture = axis.scatter(
            [middles[number] for number in same_kind], [inside[number].level for number in same_kind], 52.0,
            c=shares[same_kind], marker=marker, cmap="cividis_r", vmin=0.0, vmax=1.0, zorder=5, edgecolors=edges,
            linewidths=[2.2 if edge == RAISED else 0.9 for edge in edges], plotnonfinite=True,
        )  # fmt: skip
    axis.axhline(0.0, color="black", linewidth=1.4)
    axis.set(ylim=(-0.01 * tallest, 1.16 * tallest), ylabel="height [m]")
    axis.set_yticks([tick for tick in axis.get_yticks() if 0.0 <= tick <= tallest])
    axis.spines["left"].set_bounds(0.0, tallest)
    axis.set_xticks([])
    axis.grid(False)
    for side in ("top", "right", "bottom"):
        axis.spines[side].set_visible(False)
    return picture


def outline(axis: Any, building: BuildingShape, wall: float) -> None:
    """Draw walls, floors and the name of a building; a rigid one is hatched."""
    from matplotlib.patches import Rectangle

    look: dict[str, Any] = {"facecolor": "#f1f1f1", "edgecolor": "#333333", "linewidth": 1.1}
    look |= {"hatch": "///"} if building.is_rigid else {}
    axis.add_patch(Rectangle((wall, 0.0), WIDTH, building.height, **look))
    for level in building.levels[:-1]:
        axis.plot([wall, wall + WIDTH], [level, level], color="#9a9a9a", linewidth=0.9)
    label = f"{building.name}\n{'rigid, ' if building.is_rigid else ''}{building.position}"
    below: dict[str, Any] = {"xytext": (0, -4), "textcoords": "offset points", "ha": "center", "va": "top"}
    axis.annotate(plain(label), (wall + WIDTH / 2, 0.0), fontsize=8, **below)


def _middle(case: RowCase, line: _Line, at: int) -> float:
    """Middle of the gap of an interface on the drawing [m]."""
    return line.walls[at - line.first] + WIDTH + 0.5 * line.gap_scale * case.gaps[at]


def _interface(axis: Any, case: RowCase, line: _Line, at: int) -> None:
    """Write numbers beside the contact points, and the gap with the interface's own share above the lower roof."""
    middle = _middle(case, line, at)
    points = [point for point in case.points if point.interface == at]
    half = 0.5 * line.gap_scale * case.gaps[at]
    for point in _with_numbers(points):
        left, right = _numbers(point.touch)
        for words, sign, side in ((left, -1.0, "right"), (right, 1.0, "left")):
            axis.annotate(
                words, (middle + sign * half, point.level), xytext=(7 * sign, 0), textcoords="offset points", ha=side,
                va="center", fontsize=6.8, zorder=6, color=RAISED if sign > 0 and point.touch.yielding > 0 else "black",
                bbox={"facecolor": "#f1f1f1", "edgecolor": "none", "pad": 0.6},
            )  # fmt: skip
    top = max(case.buildings[at].height, case.buildings[at + 1].height)
    axis.annotate(
        f"{say_in(case.gaps[at], 'mm', 3)}\n{_share(case.touches[at].contact)}", (middle, top), xytext=(0, 5),
        textcoords="offset points", ha="center", va="bottom", fontsize=8, fontweight="bold", color=QUIET,
    )  # fmt: skip


def _with_numbers(points: list[Any]) -> list[Any]:
    """Contact points whose numbers are written: all of a few; of many, those with most contact, apart enough."""
    chosen: list[Any] = []
    apart = max((point.level for point in points), default=0.0) / CROWDED
    for point in sorted(points, key=lambda candidate: (-np.nan_to_num(candidate.touch.contact), -candidate.level)):
        if all(abs(point.level - other.level) >= apart for other in chosen):
            chosen.append(point)
    return chosen


def _numbers(touch: Touch) -> tuple[str, str]:
    """Texts to the left and to the right of a contact point."""
    if not touch.contact > 0.0:
        return _share(touch.contact), ""
    yields = f", {_share(touch.yielding)} $F_E$" if touch.yielding > 0.0 else ""
    return _share(touch.contact), f"{force_text(touch.force)}{yields}"


def _share(share: float) -> str:
    return "–" if np.isnan(share) else f"{100 * share:.0f} %"


def _legend(figure: Figure, case: RowCase) -> None:
    from matplotlib.lines import Line2D

    look: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "#dddddd", "markersize": 7}
    handles = [
        Line2D([], [], marker="o", markeredgecolor="black", label="floor to floor", **look),
        Line2D([], [], marker="D", markeredgecolor="black", label="floor to column", **look),
        Line2D([], [], marker="o", markeredgecolor=RAISED, markeredgewidth=2.2, label="reaches $F_E$ in some", **look),
    ]
    caption = "left of a point: share with contact; right: median peak force, share that reaches $F_E$; "
    caption += f"gaps drawn × {gap_scale(case.gaps):g}"
    legend_below(figure, handles, 3, caption)
