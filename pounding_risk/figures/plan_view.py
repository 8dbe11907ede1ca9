"""A street in plan, each building coloured by how often it is struck and how often a contact of it reaches F_E."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pounding_risk._common.counted import counted
from pounding_risk.assessment.row import RowCase, share_of_building
from pounding_risk.errors import PoundingError
from pounding_risk.figures.elevation import heading
from pounding_risk.figures.style import QUIET, blank, legend_below, plain, share_bar

if TYPE_CHECKING:
    from matplotlib.figure import Figure

Array = NDArray[np.float64]
Rings = tuple[Array, ...]  # of one building, corners (n, 2) [m]
Key = tuple[int, str]  # the row's number and the building's name
NO_ROW = -1
CROWDED = 12  # buildings; of more, names are written upright
LABELLED = 150  # buildings; of more, as in a city, each is coloured and none has hatches, a name or a number
WIDTH, DEPTH, ALLEY = 9.0, 12.0, 6.0  # m, of a building and between rows, where no footprints are given
PANELS = (("impact_count", "touches a neighbour"), ("yield_exceedance", "a contact of it reaches $F_E$"))
# Shares up to these are hatched so, that the map is read in grey as well.
HATCHES = ((0.0, ""), (0.16, "."), (0.5, "//"), (0.84, "xx"), (1.0, "xxxx"))
ALONE = "#e6e6e6"
DARK = 0.55  # from which share on the letters are white


def plan_figure(
    rows: RowCase | Sequence[RowCase],
    footprints: Mapping[str, ArrayLike | Sequence[ArrayLike]] | None = None,
    note: str = "",
    *,
    titled: bool = True,
) -> Figure:
    """Street plan of rows: shares of the motions in which each building touches a neighbour, and in which one yields.

    Parameters
    ----------
    rows : RowCase or sequence of RowCase
        Cells of the grids of one row or several, from `row_case`.
    footprints : mapping of str to array, optional
        Corners (n, 2) [m] by the building's name, or several such rings; those of buildings in no row are drawn in
        grey. Without footprints rows are drawn one below the other, with nominal widths and depths.
    note : str
        Added to the caption.
    titled : bool
        Whether the finding and its conditions are written.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels, one of contact and one of reaching F_E.

    Raises
    ------
    PoundingError
        Where a building of a row has no footprint, or one that is no polygon.
    """
    cases = [rows] if isinstance(rows, RowCase) else list(rows)
    corners = _of_rows(cases) if footprints is None else _checked(footprints, cases)
    every = np.concatenate([ring for rings in corners.values() for ring in rings])
    span = np.ptp(every, axis=0)
    flat = bool(span[0] > 2.6 * span[1])
    figure, axes = blank(*((2, 1) if flat else (1, 2)), _size(span, flat))
    picture: Any = None
    for axis, (name, words) in zip(axes.flat, PANELS, strict=True):
        picture = _panel(axis, cases, corners, name)
        axis.set_title(words, fontsize=10, loc="left")
    share_bar(figure, picture, axes, "share of the motions")
    if titled:
        heading(figure, plan_finding(cases), cases, note)
    count = sum(len(case.buildings) for case in cases)
    _legend(figure, hatched=count <= LABELLED, alone=len(corners) > count)
    return figure


def plan_finding(cases: Sequence[RowCase]) -> str:
    """Sentence on how many buildings touch in more than half of the motions, and which is struck most."""
    shares = {
        (number, building.name): share_of_building(case, "impact_count", at)
        for number, case in enumerate(cases)
        for at, building in enumerate(case.buildings)
    }
    finite_shares = {name: share for name, share in shares.items() if np.isfinite(share)}
    if not finite_shares:
        return f"No run of {counted(cases[0].motions, 'motion')} is complete"
    if not any(share > 0.0 for share in finite_shares.values()):
        return f"No building touches a neighbour in {counted(cases[0].motions, 'motion')}"
    often = sum(share > 0.5 for share in finite_shares.values())
    highest = max(finite_shares.values())
    most = [name for (_, name), share in finite_shares.items() if share == highest]
    who = most[0] if len(most) == 1 else f"{len(most)} of them"
    return (
        f"{often} of {len(shares)} buildings touch a neighbour in more than half of the motions; "
        f"{who} most often, in {100 * highest:.0f} %"
    )


def _of_rows(cases: Sequence[RowCase]) -> dict[Key, Rings]:
    """Nominal footprints: buildings of a row left to right, rows one above the other from the top down."""
    footprints: dict[Key, Rings] = {}
    for number, case in enumerate(cases):
        low = -number * (DEPTH + ALLEY)
        for at, building in enumerate(case.buildings):
            left = at * WIDTH
            ends = ((left, low), (left + WIDTH, low), (left + WIDTH, low + DEPTH), (left, low + DEPTH))
            footprints[number, building.name] = (np.array(ends),)
    return footprints


def _checked(footprints: Mapping[str, ArrayLike | Sequence[ArrayLike]], cases: Sequence[RowCase]) -> dict[Key, Rings]:
    """Rings of every building by its row, the largest first; buildings in no row by `NO_ROW`."""
    rings = {str(name): _rings(str(name), corners) for name, corners in footprints.items()}
    inside = [(number, building.name) for number, case in enumerate(cases) for building in case.buildings]
    missing = [name for _, name in inside if name not in rings]
    if missing:
        raise PoundingError(f"no footprint of {', '.join(missing)}; give one, or none at all for a plain row")
    alone = set(rings) - {name for _, name in inside}
    return {(number, name): rings[name] for number, name in inside} | {(NO_ROW, name): rings[name] for name in alone}


def _rings(name: str, corners: Any) -> Rings:
    several = isinstance(corners, list | tuple) and np.ndim(corners[0]) == 2
    rings = [np.asarray(ring_corners, dtype=float) for ring_corners in (corners if several else [corners])]
    for ring in rings:
        if ring.ndim != 2 or ring.shape[1:] != (2,) or len(ring) < 3 or not np.isfinite(ring).all():
            raise PoundingError(f"footprint of {name}: is no polygon; give three corners or more, each x and y in m")
    return tuple(sorted(rings, key=lambda ring: -float(np.prod(np.ptp(ring, axis=0)))))


def _size(span: Array, flat: bool) -> tuple[float, float]:
    """Size of the figure: panels of the street's own shape, within a page."""
    ratio = float(np.clip(span[1] / max(span[0], 1e-9), 0.08, 4.0))
    if flat:
        width = float(np.clip(0.09 * span[0], 8.0, 20.0))
        return width, 2.2 + 2.0 * (0.85 * width * ratio + 0.4)
    return 13.0, 2.2 + min(5.6 * ratio, 9.0)


def _panel(axis: Any, cases: Sequence[RowCase], corners: Mapping[Key, Rings], name: str) -> Any:
    from matplotlib.collections import PolyCollection

    shares = {
        (number, building.name): share_of_building(case, name, at)
        for number, case in enumerate(cases)
        for at, building in enumerate(case.buildings)
    }
    for who, rings in corners.items():
        for ring in rings if who not in shares else ():
            axis.fill(*ring.T, facecolor=ALONE, edgecolor="#888888", linewidth=0.8)
    labelled = len(shares) <= LABELLED
    rings_of_rows = [ring for who in shares for ring in corners[who]]
    look: dict[str, Any] = {"edgecolors": "black", "linewidths": 0.9 if labelled else 0.2, "cmap": "cividis_r"}
    drawn = PolyCollection(rings_of_rows, **look)
    drawn.set_array(np.ma.masked_invalid([share for who, share in shares.items() for _ in corners[who]]))
    drawn.set_clim(0.0, 1.0)
    axis.add_collection(drawn)
    for who, share in shares.items() if labelled else ():
        _label(axis, corners[who], who[1], share, len(shares) > CROWDED)
    axis.set(aspect="equal", xticks=[], yticks=[])
    axis.autoscale_view()
    axis.grid(False)
    for side in axis.spines.values():
        side.set_visible(False)
    return drawn


def _label(axis: Any, rings: Rings, name: str, share: float, crowded: bool) -> None:
    """Hatch a building by its class of shares and write its name and number, upright where the footprint is narrow."""
    is_dark = share > DARK
    for ring in rings if np.isfinite(share) else ():
        hatch = next(hatch for most, hatch in HATCHES if share <= most)
        ink = "#ffffff66" if is_dark else "#00000044"
        axis.fill(*ring.T, facecolor="none", hatch=hatch, edgecolor=ink, linewidth=0)
    wide, deep = np.ptp(rings[0], axis=0)
    words = f"{name}\n{'–' if np.isnan(share) else f'{100 * share:.0f} %'}"
    box = {"facecolor": "#1a2c4e" if is_dark else "#ffffff", "edgecolor": "none", "pad": 1.0, "alpha": 0.75}
    look: dict[str, Any] = {"color": "white" if is_dark else "black", "bbox": box, "ha": "center", "va": "center"}
    turned = 90 if deep > (1.0 if crowded else 1.8) * wide else 0
    axis.annotate(plain(words), rings[0].mean(axis=0), fontsize=7.5, rotation=turned, **look)


def _legend(figure: Figure, hatched: bool, alone: bool) -> None:
    from matplotlib.patches import Patch

    look: dict[str, Any] = {"facecolor": "white", "edgecolor": QUIET}
    handles = [
        Patch(hatch=hatch * 2, label="0 %" if most == 0.0 else f"to {100 * most:.0f} %", **look)
        for most, hatch in HATCHES
        if hatched
    ]
    if alone:
        handles.append(Patch(facecolor=ALONE, edgecolor="#888888", label="in no row"))
    if handles:
        legend_below(figure, handles, len(handles))
