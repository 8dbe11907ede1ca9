"""Figures of a row: in elevation, in plan, and by storey with and without contact, over the motions."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import (
    BuildingShape,
    RowCase,
    any_of_building,
    force_text,
    share_of_building,
    yield_force_words,
)
from pounding_risk.errors import PoundingError
from pounding_risk.figures import style
from pounding_risk.motions.levels import PEAK
from pounding_risk.results.attributes import bumper_lengths, bumper_words, finite, isolated_of, of_structure
from pounding_risk.results.opened import Results
from pounding_risk.units import MISSING, STANDARD_GRAVITY, say_in

Array = NDArray[np.float64]

# In elevation.
WIDTH = 9.0  # m, of every building as drawn
WIDEST_GAP = 1.5  # m, as drawn
ROUND = (1, 2, 5, 10, 20, 50, 100, 200, 500, 1000)  # by which gaps are drawn larger than they are
ON_A_LINE = 8  # buildings; a longer row is drawn in several lines
CROWDED = 8  # contact points of an interface; of more, only some have their numbers written
MARKERS = {"floor": "o", "column": "D"}
RAISED = style.STYLES[1][0]
# In plan.
Rings = tuple[Array, ...]  # of one building, corners (n, 2) [m]
Key = tuple[int, str]  # the row's number and the building's name
NO_ROW = -1
MANY = 12  # buildings; of more, the figure is wider
LETTERS, LEAST_LETTERS = 7.5, 4.0  # points, in a footprint; where smaller ones had to be written, there is no name
LINE, LETTER = 1.35, 0.62  # height of a line and width of a letter, of their size
LABELLED = 150  # buildings; of more, as in a city, each is coloured and none has hatches, a name or a number
DEPTH, ALLEY = 12.0, 6.0  # m, of a building and between rows, where no footprints are given
PANELS = (("impact_count", "touches a neighbour"), ("yield_exceedance", "a contact of it reaches $F_E$"))
# Shares up to these are hatched so, that the map is read in grey as well.
HATCHES = ((0.0, ""), (0.16, "."), (0.5, "//"), (0.84, "xx"), (1.0, "xxxx"))
ALONE = "#e6e6e6"
DARK = 0.55  # from which share on the letters are white
# By storey.
MOST_BUILDINGS = 6  # of one figure
BAND = (16.0, 84.0)
WITHOUT, WITH = style.STYLES[0], style.STYLES[1]


# Numbers of a contact point stand on the floor's line, over which they would not be read.
ON_FLOOR: dict[str, Any] = {"va": "bottom"}


class Quantity(NamedTuple):
    """Words of a quantity's axis, factor from SI to the unit there, and whether it is of storeys or of floors."""

    words: str
    factor: float
    of_storey: bool


QUANTITIES = {
    "storey_drift": Quantity("drift [% of the storey's height]", 100.0, True),
    "storey_shear": Quantity("storey shear [MN]", 1e-6, True),
    "storey_acceleration": Quantity("floor acceleration [g]", 1.0 / STANDARD_GRAVITY, False),
    "storey_ductility": Quantity("storey ductility [1]", 1.0, True),  # of storeys that may yield
}


class Profile(NamedTuple):
    """One quantity of one building by storey: (16 %, 50 %, 84 %) rows in the axis's unit."""

    free: Array
    struck: Array
    motions: int  # those in which the building touches a neighbour; 0: none does, and all are shown


class _Line(NamedTuple):
    """One line of the figure: buildings ``first`` to ``last``, and their left walls [m]."""

    first: int
    last: int
    walls: tuple[float, ...]
    gap_scale: float


def elevation_figure(case: RowCase, note: str = "", *, titled: bool = True) -> style.Figure:
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
        Whether title and conditions are written; a report has them beside the figure.

    Returns
    -------
    matplotlib.figure.Figure
        A long row stands in several lines.
    """
    lines = _lines(case)
    tallest = max(building.height for building in case.buildings)
    most_buildings = max(line.last - line.first + 1 for line in lines)
    size = (max(8.6, 1.5 + 1.75 * most_buildings), 1.6 + len(lines) * (1.5 + min(max(0.16 * tallest, 2.0), 5.5)))
    figure, axes = style.blank(len(lines), 1, size)
    picture: Any = None
    for axis, line in zip(axes[:, 0], lines, strict=True):
        picture = _draw_line(axis, case, line, tallest)
        axis.set_xlim(-1.0, max(line.walls[-1] for line in lines) + WIDTH + 1.0)
    style.share_bar(figure, picture, axes, "share of the motions with contact", 30.0 * len(lines))
    if titled:
        _write_title(figure, _contact_finding([case]), [case], note)
    _elevation_legend(figure, case)
    return figure


def _write_title(figure: style.Figure, headline: str, cases: Sequence[RowCase], note: str) -> None:
    """Title and caption of a figure of one row or several, with the cell of the grid."""
    joined_case = cases[0]._replace(gaps=tuple(gap for case in cases for gap in case.gaps))
    subject = f"{len(cases)} rows" if len(cases) > 1 else joined_case.results.attrs["title"]
    condition = style.plain(f"{subject}: {where_words(joined_case)}").replace("F_E", "$F_E$")
    style.title(figure, style.plain(headline), condition, style.plain(note))


def _contact_finding(cases: Sequence[RowCase]) -> str:
    """Sentence on the neighbours that touch in most of the motions, and their share."""
    shares = {
        (number, name): touch.contact
        for number, case in enumerate(cases)
        for name, touch in zip(case.interfaces, case.touches, strict=True)
        if touch.runs
    }
    largest = max(shares.values(), default=np.nan)
    if not largest > 0.0:
        return "No neighbours touch in any motion" if shares else "No run is complete: it is not known who touches"
    names = [name for (_, name), share in shares.items() if share == largest]
    neighbours_text = between(names[0]) if len(names) == 1 else f"{len(names)} of {len(shares)} pairs of neighbours"
    others_text = "" if len(names) == len(shares) else ", others in fewer"
    return f"{neighbours_text} touch in {_share_text(largest)} of the motions{others_text}"


def _drift_finding(case: RowCase, buildings: Sequence[int]) -> str:
    """Sentence on the building whose drift contact raises most, and by how much in the median."""
    ratios = {index: ratio for index in buildings if np.isfinite(ratio := amplification(case, index))}
    if not ratios:
        return "No complete run has contact: drifts are those without neighbours"
    index = max(ratios, key=lambda building: ratios[building])
    if not ratios[index] > 1.0:
        return "Contact raises the largest drift of no building, in the median of the motions with contact"
    name = case.buildings[index].name
    name += " above its isolators" * (name in isolated_of(case.results))
    return f"Contact raises drift most in {name}: {ratios[index]:.3g} times, in the median of its motions with contact"


def where_words(case: RowCase) -> str:
    """Gap, yield force, contact model, motions and amplitude of the cell, in words."""
    results = case.results
    gaps = sorted(set(np.round(case.gaps, 9)))
    range_text = " to ".join(f"{1e3 * gap:.4g}" for gap in dict.fromkeys((gaps[0], gaps[-1])))
    motions = counted(case.motions, "motion")
    words = [
        f"gap{'s' * (len(gaps) > 1)} {range_text} mm",
        yield_force_words(results),
        style.law_words(str(results["contact_model"].values)),
        f"{complete} of {motions}"
        if (complete := min(touch.runs for touch in case.touches)) < case.motions
        else motions,
    ]
    amplitudes = Results(results).amplitudes
    if amplitudes.values[0] is not None and np.isfinite(amplitudes.values[0]):
        measure_text = "" if amplitudes.measure == PEAK else f"{amplitudes.measure.words} "
        words.append(measure_text + amplitudes.words(amplitudes.values[0]))
    return ", ".join(words)


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
        steps = [WIDTH + scale * case.gaps[index] for index in range(first, last)]
        walls = np.concatenate([[0.0], np.cumsum(steps)])
        lines.append(_Line(int(first), int(last), tuple(walls.tolist()), scale))
    return lines


def gap_scale(gaps: Sequence[float]) -> float:
    """The largest round factor that keeps the widest gap within `WIDEST_GAP`."""
    widest = max(gaps, default=0.0)
    return float(max((factor for factor in ROUND if factor * widest <= WIDEST_GAP), default=1))


def _draw_line(axis: Any, case: RowCase, line: _Line, tallest: float) -> Any:
    for wall, index in zip(line.walls, range(line.first, line.last + 1), strict=True):
        outline(axis, case.buildings[index], wall)
    points = [point for point in case.meetings if line.first <= point.interface < line.last]
    middle_by_gap = {index: _draw_interface(axis, case, line, index) for index in range(line.first, line.last)}
    middles = [middle_by_gap[point.interface] for point in points]
    shares = np.array([point.touch.contact for point in points])
    picture: Any = None
    for kind, marker in MARKERS.items():
        same_kind = [number for number, point in enumerate(points) if point.kind == kind]
        edges = [RAISED if points[number].touch.yielding > 0.0 else "black" for number in same_kind]
        picture = axis.scatter(
            [middles[number] for number in same_kind], [points[number].level for number in same_kind], 52.0,
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
    label = (
        f"{style.in_lines(building.name, style.NAME_LINE)}\n{'rigid, ' if building.is_rigid else ''}{building.position}"
    )
    style.beside(axis, style.plain(label), (wall + WIDTH / 2, 0.0), (0, -4), 8)


def _draw_interface(axis: Any, case: RowCase, line: _Line, index: int) -> float:
    """Write numbers beside the contact points, and the gap with the interface's share above; returns its middle [m]."""
    half = 0.5 * line.gap_scale * case.gaps[index]
    middle = line.walls[index - line.first] + WIDTH + half
    points = [point for point in case.meetings if point.interface == index]
    # Numbers are written where there is room, at the points with most contact first.
    room = max((point.level for point in points), default=0.0) / CROWDED
    written_levels: list[float] = []
    for point in sorted(points, key=lambda candidate: (-np.nan_to_num(candidate.touch.contact), -candidate.level)):
        if any(abs(point.level - level) < room for level in written_levels):
            continue
        written_levels.append(point.level)
        touch, is_yielding = point.touch, point.touch.yielding > 0.0
        yield_text = f", {_share_text(touch.yielding)} $F_E$" if is_yielding else ""
        right = f"{force_text(touch.force)}{yield_text}" if touch.contact > 0.0 else ""
        for words, sign in ((_share_text(touch.contact), -1.0), (right, 1.0)):
            look = {"color": RAISED if sign > 0 and is_yielding else "black", "zorder": 6} | ON_FLOOR
            style.beside(axis, words, (middle + sign * half, point.level), (4 * sign, 1.5), 7.5, **look)
    top = max(case.buildings[index].height, case.buildings[index + 1].height)
    bumpers = _draw_bumpers(axis, case, line, index, points)
    words = f"{say_in(case.gaps[index], 'mm', 3)}{bumpers}\n{_share_text(case.touches[index].contact)}"
    style.beside(axis, words, (middle, top), (0, 5), 8, fontweight="bold", color=style.QUIET)
    return middle


def _draw_bumpers(axis: Any, case: RowCase, line: _Line, index: int, points: Sequence[Any]) -> str:
    """Draw the bumpers in the gap of an interface on its left face, to the scale of gaps; returns their words."""
    from matplotlib.patches import Rectangle

    lengths = bumper_lengths(case.results)
    if not any(lengths[index : index + 1]):
        return ""
    face, thickness = line.walls[index - line.first] + WIDTH, 0.03 * max(building.height for building in case.buildings)
    for point in points:
        corner = face, point.level - 0.5 * thickness
        axis.add_patch(Rectangle(corner, line.gap_scale * lengths[index], thickness, facecolor="#8a8a8a", zorder=2))
    return f", {bumper_words(lengths[index : index + 1])}"


def _share_text(share: float) -> str:
    return MISSING if np.isnan(share) else f"{100 * share:.0f} %"


def _elevation_legend(figure: style.Figure, case: RowCase) -> None:
    from matplotlib.lines import Line2D

    look: dict[str, Any] = {"linestyle": "none", "markerfacecolor": "#dddddd", "markersize": 7}
    handles = [
        Line2D([], [], marker="o", markeredgecolor="black", label="floor to floor", **look),
        Line2D([], [], marker="D", markeredgecolor="black", label="floor to column", **look),
        Line2D([], [], marker="o", markeredgecolor=RAISED, markeredgewidth=2.2, label="reaches $F_E$ in some", **look),
    ]
    caption = (
        "where there is room, left of a point: share with contact; right: median peak force, share that reaches $F_E$"
    )
    caption += f"; gaps drawn × {gap_scale(case.gaps):g}"
    is_known = np.isfinite(case.results["building_height"].values)
    if not is_known.all():
        names = " and ".join(map(str, case.results["building"].values[~is_known]))
        caption += f"\nno height is given of {style.plain(names)}: the one drawn is nominal"
    linked = [name for index, name in enumerate(case.interfaces) if Results(case.results).has_link(index)]
    if linked:
        where = between(linked[0]) if len(linked) == 1 else counted(len(linked), "pair") + " of neighbours"
        caption += f"\nsprings or dampers join {style.plain(where)}; they are not drawn"
    if len(case.meetings) < len(case.points):
        caption += "\nboth ends of the faces of floors that rotate are one point"
    if any(bumper_lengths(case.results)):
        caption += "\nbumpers are drawn on the left face, to the scale of gaps"
    style.legend_below(figure, handles, 3, caption)


def plan_figure(
    rows: RowCase | Sequence[RowCase],
    footprints: Mapping[Any, ArrayLike | Sequence[ArrayLike]] | None = None,
    note: str = "",
    *,
    titled: bool = True,
) -> style.Figure:
    """Street plan of rows: shares of the motions in which each building touches a neighbour, and in which one yields.

    Parameters
    ----------
    rows : RowCase or sequence of RowCase
        Cells of the grids of one row or several, from `row_case`.
    footprints : mapping of str to array, optional
        Corners (n, 2) [m], east and north, by the building's name, or by the number of its row from 0 and the name, or
        several such rings, of which those within another that turn the other way are courts; buildings of
        no row given here are drawn in grey. Without footprints rows are drawn one below the other, with nominal widths
        and depths.
    note : str
        Added to the caption.
    titled : bool
        Whether title and conditions are written.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels, one of contact and one of reaching F_E.

    Raises
    ------
    PoundingError
        Where a building of a row has no footprint, one that is no polygon, or that of another row's building.
    """
    from matplotlib.patches import Patch

    cases = [rows] if isinstance(rows, RowCase) else list(rows)
    corners = _plain_rings(cases) if footprints is None else _checked_rings(footprints, cases)
    all_corners = np.concatenate([ring for rings in corners.values() for ring in rings])
    span, count = np.ptp(all_corners, axis=0), sum(len(case.buildings) for case in cases)
    is_flat = bool(span[0] > 2.6 * span[1])
    figure, axes = style.blank(*((2, 1) if is_flat else (1, 2)), _plan_size(span, is_flat, count))
    picture: Any = None
    labels: dict[Any, list[Any]] = {}
    for axis, (name, words) in zip(axes.flat, PANELS, strict=True):
        picture, labels[axis] = _draw_plan(axis, cases, corners, name)
        axis.set_title(words, fontsize=10, loc="left")
        if footprints is not None:
            _scale_and_north(axis, all_corners.min(axis=0), span)
    style.share_bar(figure, picture, axes, "share of the motions")
    if titled:
        _write_title(figure, _contact_finding(cases), cases, note)
    handles = []
    if count <= LABELLED:
        look: dict[str, Any] = {"facecolor": "white", "edgecolor": style.QUIET}
        names = ["0 %" if most == 0.0 else f"to {100 * most:.0f} %" for most, _ in HATCHES]
        handles = [Patch(hatch=2 * marks, label=name, **look) for (_, marks), name in zip(HATCHES, names, strict=True)]
        if any(
            np.isnan(share_of_building(case, "yield_exceedance", index))
            for case in cases
            for index in range(len(case.buildings))
        ):
            handles.append(Patch(label="–: has no $F_E$, or no run is complete", **look))
    if len(corners) > count:
        handles.append(Patch(facecolor=ALONE, edgecolor="#888888", label="no result given"))
    figure.draw_without_rendering()  # which lays the panels out
    all_written = all([_fit_labels(axis, axis_labels) for axis, axis_labels in labels.items()])
    if handles:
        style.legend_below(figure, handles, len(handles), None if all_written else "no name: no room for letters")
    return figure


def _plain_rings(cases: Sequence[RowCase]) -> dict[Key, Rings]:
    """Nominal footprints: buildings of a row left to right, rows one above the other from the top down."""
    footprints: dict[Key, Rings] = {}
    for number, case in enumerate(cases):
        low = -number * (DEPTH + ALLEY)
        for index, building in enumerate(case.buildings):
            left = index * WIDTH
            ends = ((left, low), (left + WIDTH, low), (left + WIDTH, low + DEPTH), (left, low + DEPTH))
            footprints[number, building.name] = (np.array(ends),)
    return footprints


def _checked_rings(footprints: Mapping[Any, Any], cases: Sequence[RowCase]) -> dict[Key, Rings]:
    """Rings of every building by its row, the largest first; buildings of none of these rows by `NO_ROW`."""
    rings = {who: _rings(who if isinstance(who, str) else who[1], corners) for who, corners in footprints.items()}
    owners = [(number, building.name) for number, case in enumerate(cases) for building in case.buildings]
    key_of = {who: who if who in rings else who[1] for who in owners}
    missing = [name for (_, name), key in key_of.items() if key not in rings]
    if missing:
        raise PoundingError(f"no footprint of {', '.join(missing)}; give one, or none at all for a plain row")
    if repeats := [str(key) for key, rows in Counter(key_of.values()).items() if rows > 1]:
        raise PoundingError(
            f"{', '.join(repeats)} of several rows would stand in one footprint; draw them in plans apart"
        )
    others = [(NO_ROW, who) for who in rings if who not in set(key_of.values())]
    return {who: rings[key] for who, key in key_of.items()} | {who: rings[who[1]] for who in others}


def _rings(name: str, corners: Any) -> Rings:
    is_list = isinstance(corners, list | tuple) and np.ndim(corners[0]) == 2
    rings = [np.asarray(ring_corners, dtype=float) for ring_corners in (corners if is_list else [corners])]
    for ring in rings:
        if ring.ndim != 2 or ring.shape[1:] != (2,) or len(ring) < 3 or not np.isfinite(ring).all():
            raise PoundingError(f"footprint of {name}: is no polygon; give three corners or more, each x and y in m")
    return tuple(sorted(rings, key=lambda ring: -float(np.prod(np.ptp(ring, axis=0)))))


def _plan_size(span: Array, is_flat: bool, count: int) -> tuple[float, float]:
    """Size of the figure: panels of the street's own shape, within a page."""
    ratio = float(np.clip(span[1] / max(span[0], 1e-9), 0.08, 4.0))
    if is_flat:
        width = float(np.clip(0.09 * span[0], 8.0, 20.0))
        return width, 2.2 + 2.0 * (0.85 * width * ratio + 0.4)
    width = 13.0 if count > MANY else 9.0  # of few buildings small enough for a page, where letters shrink with it
    return width, 2.2 + min(0.43 * width * ratio, 9.0)


def _draw_plan(axis: Any, cases: Sequence[RowCase], corners: Mapping[Key, Rings], name: str) -> tuple[Any, list[Any]]:
    """Draw the buildings of a panel; returns the coloured ones, which are in rows, and the names written on them."""
    from matplotlib.collections import PathCollection

    shares = {
        (number, building.name): share_of_building(case, name, index)
        for number, case in enumerate(cases)
        for index, building in enumerate(case.buildings)
    }
    for owner, rings in corners.items():
        if owner not in shares:
            _fill(axis, rings, facecolor=ALONE, edgecolor="#888888", linewidth=0.8)
    is_labelled = len(shares) <= LABELLED
    look: dict[str, Any] = {"edgecolors": "black", "linewidths": 0.9 if is_labelled else 0.2, "cmap": "cividis_r"}
    collection = PathCollection([_area_path(corners[owner]) for owner in shares], **look)
    collection.set_array(np.ma.masked_invalid(list(shares.values())))
    collection.set_clim(0.0, 1.0)
    axis.add_collection(collection)
    labels = [_label(axis, corners[owner], owner[1], share) for owner, share in (shares.items() if is_labelled else ())]
    axis.set(aspect="equal", xticks=[], yticks=[])
    axis.autoscale_view()
    axis.grid(False)
    for side in axis.spines.values():
        side.set_visible(False)
    return collection, labels


def _area_path(rings: Rings) -> Any:
    """The area within rings as a path; one that turns against the ring around it is left out, as a court is."""
    from matplotlib.path import Path

    return Path.make_compound_path(*(Path(np.vstack([ring, ring[:1]]), closed=True) for ring in rings))


def _fill(axis: Any, rings: Rings, **look: Any) -> None:
    from matplotlib.patches import PathPatch

    axis.add_patch(PathPatch(_area_path(rings), **look))


def _scale_and_north(axis: Any, low: Array, span: Array) -> None:
    """Below footprints from ``low`` on, [m] east and north, a bar of a round length and an arrow to the north."""
    length = max(tick for tick in style.ROUND if tick <= 0.25 * max(span))
    foot = low - (0.0, 0.05 * max(span))
    axis.plot([foot[0], foot[0] + length], 2 * [foot[1]], color="black", linewidth=2.5, solid_capstyle="butt")
    style.beside(axis, f"{length:g} m", (foot[0] + 0.5 * length, foot[1]), (0, -3), 8)
    arrow = {"arrowprops": {"arrowstyle": "-|>", "color": "black"}, "fontsize": 8, "textcoords": "offset points"}
    axis.annotate("N", (foot[0] + 1.3 * length, foot[1]), xytext=(0, -24), ha="center", **arrow)


def _label(axis: Any, rings: Rings, name: str, share: float) -> tuple[Any, Array]:
    """Hatch a building by its class of shares and write its name and number along its walls; the text and its room [m].

    The room is the length along the lines of text, and across them.
    """
    is_dark = share > DARK
    if np.isfinite(share):
        hatch = next(hatch for most, hatch in HATCHES if share <= most)
        ink = "#ffffff66" if is_dark else "#00000044"
        _fill(axis, rings, facecolor="none", hatch=hatch, edgecolor=ink, linewidth=0)
    edges = np.diff([*rings[0], rings[0][0]], axis=0)
    along, up = edges[np.hypot(*edges.T).argmax()]
    # The longest wall, or one square to it, from −45 to 45 degrees.
    turn = float((np.degrees(np.arctan2(up, along)) + 45.0) % 90.0 - 45.0)
    cosine, sine = np.cos(np.radians(turn)), np.sin(np.radians(turn))
    walls = np.array([[cosine, sine], [-sine, cosine]])
    wall_corners = rings[0] @ walls.T
    room = np.ptp(wall_corners, axis=0)
    middle = 0.5 * (wall_corners.min(axis=0) + wall_corners.max(axis=0)) @ walls
    words = f"{style.in_lines(name, style.NAME_LINE)}\n{'–' if np.isnan(share) else f'{100 * share:.0f} %'}"
    box = {"facecolor": "#1a2c4e" if is_dark else "#ffffff", "edgecolor": "none", "pad": 1.0, "alpha": 0.75}
    look: dict[str, Any] = {"color": "white" if is_dark else "black", "bbox": box, "ha": "center", "va": "center"}
    look |= {"rotation": turn, "rotation_mode": "anchor", "fontsize": LETTERS}
    return axis.annotate(style.plain(words), middle, **look), room


def _fit_labels(axis: Any, labels: Sequence[tuple[Any, Array]]) -> bool:
    """Turn texts where that gives them room, else make letters smaller, or hide them; True if all are visible."""
    a_metre = 0.95 * 72.0 / axis.figure.dpi * axis.transData.get_matrix()[0, 0]  # points; a legend takes the rest
    for label, room in labels:
        lines, turn = label.get_text().split("\n"), label.get_rotation()
        box = LETTER * max(map(len, lines)), LINE * len(lines)
        size, turned_size = (a_metre * float(np.min(sides / box)) for sides in (room, room[::-1]))
        if turned_size > size < LETTERS:
            size = turned_size
            label.set_rotation(turn - 90.0 if 0.0 < turn < 180.0 else turn + 90.0)
        label.set(fontsize=min(LETTERS, size), visible=size >= LEAST_LETTERS)
    return all(label.get_visible() for label, _ in labels)


def profiles_figure(
    case: RowCase, buildings: Sequence[str] = (), note: str = "", *, titled: bool = True
) -> style.Figure:
    """Storey profiles with and without contact: median and middle 68 % of the motions in which a building touches.

    Levels of contact are marked on the side where the neighbour stands.

    Parameters
    ----------
    case : RowCase
        One cell of a row's grid, from `row_case`.
    buildings : sequence of str
        Names of buildings; without any, those whose drift contact raises most, `MOST_BUILDINGS` at most.
    note : str
        Added to the caption.
    titled : bool
        Whether title and conditions are written.

    Returns
    -------
    matplotlib.figure.Figure
        A column for each building, a row for each quantity.

    Raises
    ------
    PoundingError
        For a name that the row has not, and for a row without storeys.
    """
    rows = [name for name in QUANTITIES if name in case.results]
    indices = _chosen_buildings(case, buildings) if rows else []
    if not indices:
        raise PoundingError("no building has storeys; profiles need floor_masses, or a height and storeys")
    figure, axes = style.blank(
        len(rows), len(indices), (1.6 + 2.3 * max(len(indices), 3), 1.8 + 2.9 * len(rows)), sharey="row"
    )
    for row, name in enumerate(rows):
        for column, at in enumerate(indices):
            _draw_profile(axes[row, column], case, at, name)
            axes[row, column].set_xlabel(QUANTITIES[name].words, fontsize=9)
        axes[row, 0].set(ylabel="height [m]", ylim=(0.0, 1.04 * max(case.buildings[at].height for at in indices)))
    for column, at in enumerate(indices):
        drawn = profile(case, at, rows[0])
        motions = f"{drawn.motions} of {counted(case.motions, 'motion')}" if drawn.motions else "no contact"
        building = case.buildings[at]
        motions += "; storey 1: its isolators" * (building.name in isolated_of(case.results))
        axes[0, column].set_title(style.plain(f"{building.name} ({building.position})\n{motions}"), fontsize=9.5)
    if titled:
        left_out = "" if buildings else of_which_buildings(case)
        _write_title(figure, _drift_finding(case, indices), [case], "; ".join(filter(None, (note, left_out))))
    _profiles_legend(figure)
    return figure


def amplification(case: RowCase, building: int, name: str = "peak_drift") -> float:
    """Median over the motions with contact of a building's largest response with contact over that without.

    Parameters
    ----------
    case : RowCase
        One cell of a row's grid.
    building : int
        Number of the building, from 0 at the left.
    name : str
        Variable of the dataset that has a twin without contact.

    Returns
    -------
    float
        The ratio; NaN where no motion brings contact, or velocities jump in one, of which no acceleration is finite.
    """
    is_touched = any_of_building(case, "impact_count", building) == 1.0
    peaks = (of_structure(case.results, output).isel(building=building) for output in (name, f"{name}_free"))
    pair_of_peaks = [values.transpose("record", "polarity").values.ravel()[is_touched] for values in peaks]
    is_moved = pair_of_peaks[1] > 0.0
    return float(np.median(pair_of_peaks[0][is_moved] / pair_of_peaks[1][is_moved])) if is_moved.any() else float("nan")


def profile(case: RowCase, building: int, name: str) -> Profile:
    """One of `QUANTITIES` of one building, with contact and without, over the motions in which it touches a neighbour.

    Over all motions, where there are none: then both are the same.
    """
    touches = any_of_building(case, "impact_count", building)
    motions = int((touches == 1.0).sum())
    is_drawn = touches == 1.0 if motions else np.isfinite(touches)
    levels = case.buildings[building].levels
    heights = np.diff([0.0, *levels]) if name == "storey_drift" else 1.0
    spreads = []
    for suffix in ("_free", ""):
        building_values = finite(case.results, f"{name}{suffix}").isel(building=building)
        values = building_values.transpose("record", "polarity", "storey").values
        values = values.reshape(-1, values.shape[-1])[is_drawn, : len(levels)] * QUANTITIES[name].factor / heights
        # NaN where no run is complete.
        missing = np.full((3, len(levels)), np.nan)
        spreads.append(np.asarray(np.percentile(values, (BAND[0], 50.0, BAND[1]), axis=0)) if len(values) else missing)
    return Profile(spreads[0], spreads[1], motions)


def has_storeys(building: BuildingShape) -> bool:
    """True for a building that has numbers of storeys; a rigid one has none."""
    return not building.is_rigid and bool(building.levels)


def of_which_buildings(case: RowCase) -> str:
    """Words on the buildings with profiles, "6 of 15 buildings: ..."; "" where all with storeys have one."""
    number = sum(map(has_storeys, case.buildings))
    words = f"{MOST_BUILDINGS} of {number} buildings with storeys: those whose drift contact raises most"
    return words if number > MOST_BUILDINGS else ""


def _chosen_buildings(case: RowCase, names: Sequence[str]) -> list[int]:
    """Numbers of the named buildings that have storeys; without names, of those whose drift contact raises most."""
    row_names = [building.name for building in case.buildings]
    for name in names:
        if name not in row_names:
            raise PoundingError(f"building {name!r} is not in the row, which has {', '.join(row_names)}")
    indices = [row_names.index(name) for name in names] if names else list(range(len(row_names)))
    indices = [index for index in indices if has_storeys(case.buildings[index])]
    if names:
        return indices
    return sorted(sorted(indices, key=lambda index: -np.nan_to_num(amplification(case, index)))[:MOST_BUILDINGS])


def _draw_profile(axis: Any, case: RowCase, building: int, name: str) -> None:
    """Draw one quantity against height, and on the side of the neighbour a mark at each level of contact."""
    spread, quantity = profile(case, building, name), QUANTITIES[name]
    levels = np.array(case.buildings[building].levels)
    if name == "storey_drift" and case.buildings[building].name in isolated_of(case.results):
        spread = _above_isolators(axis, spread, levels[0])
    for values, (colour, dash) in ((spread.free, WITHOUT), (spread.struck, WITH)):
        heights, (low, middle, high) = levels, values
        if quantity.of_storey:  # one value all along a storey
            heights = np.repeat([0.0, *levels], 2)[1:-1]
            low, middle, high = np.repeat(values, 2, axis=1)
        if heights.size == 1:  # one floor: no area between its ends
            axis.plot([low[0], high[0]], [heights[0]] * 2, color=colour, alpha=0.3, linewidth=5.0)
        axis.fill_betweenx(heights, low, high, color=colour, alpha=0.18, linewidth=0.0)
        marker = "" if quantity.of_storey else "."
        axis.plot(middle, heights, color=colour, linestyle=dash, linewidth=1.9, marker=marker, markersize=7)
    if spread.motions and name == "storey_shear" and np.isnan(spread.free).all():
        words = "not known: a stiffness matrix\njoins its floors, or they rotate"
        axis.text(0.5, 0.5, words, transform=axis.transAxes, ha="center", va="center", fontsize=9)
    axis.set_xlim(0.0, 1.05 * axis.dataLim.x1 if axis.dataLim.x1 > 0.0 else 1.0)  # values near one another too
    for point in case.meetings:
        if building in (point.interface, point.interface + 1):
            x, marker = (1.0, "<") if building == point.interface else (0.0, ">")
            face = "black" if point.touch.contact > 0.0 else "white"  # full where a motion touches there
            axis.plot(
                x, point.level, marker, transform=axis.get_yaxis_transform(), color="black", markerfacecolor=face,
                markersize=6, clip_on=False, zorder=5,
            )  # fmt: skip
            axis.axhline(point.level, color=style.QUIET, linestyle=":", linewidth=0.7, zorder=0)


def _above_isolators(axis: Any, spread: Profile, height: float) -> Profile:
    """The drifts of storeys without that of isolators, whose scale would hide them: it is written in mm."""
    free, struck = (f"{10.0 * height * values[1, 0]:.3g} mm" for values in (spread.free, spread.struck))
    words = f"isolators: {free} without contact, {struck} with"
    axis.text(0.98, 0.02, words, transform=axis.transAxes, ha="right", va="bottom", fontsize=8)
    hidden = np.where(np.arange(spread.free.shape[1]) == 0, np.nan, 0.0)
    return spread._replace(free=spread.free + hidden, struck=spread.struck + hidden)


def _profiles_legend(figure: style.Figure) -> None:
    from matplotlib.lines import Line2D

    lines: list[dict[str, Any]] = [
        {"color": colour, "linestyle": dash, "linewidth": 1.9} for colour, dash in (WITHOUT, WITH)
    ]
    mark: dict[str, Any] = {"color": "black", "linestyle": "none", "marker": "<"}
    handles = [
        Line2D([], [], label="without contact", **lines[0]),
        Line2D([], [], label="with contact (bands: 16 to 84 %)", **lines[1]),
        Line2D([], [], label="level of contact", **mark),
        Line2D([], [], label="never touched there", markerfacecolor="white", **mark),
    ]
    style.legend_below(figure, handles, 4)
