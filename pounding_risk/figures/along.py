"""Figure of contact and required gap along axes of numbers of the scene."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.words import nearest
from pounding_risk.assessment.along import along_finding, idle_words, is_along, value_words
from pounding_risk.assessment.options import percent_words
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import MEANING, blank, contact_styles, plain, share_bar, title
from pounding_risk.units import GAP, SHOWN, say, shown

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_LINES = 4  # values of a second axis that are drawn as lines; more as a map
CONTOURS = 6  # of the gap required


def along_figure(assessed: xr.Dataset, interface: str | None = None, note: str = "", *, titled: bool = True) -> Figure:
    """P(contact) and the gap required along the axes: lines along one, a map along two.

    Of more than two axes those two are drawn along which the gap required changes most; of the others the scene's own
    value holds, or the middle one.

    Parameters
    ----------
    assessed : xarray.Dataset
        As `assess_along` gives it.
    interface : str, optional
        Name of an interface; the one that needs the widest gap by default.
    note : str
        Added to the caption.
    titled : bool
        Whether the finding and its conditions are written.

    Returns
    -------
    matplotlib.figure.Figure
        Two panels.

    Raises
    ------
    PoundingError
        For anything else than what `assess_along` gives, and an interface that it has not.
    """
    if not is_along(assessed):
        raise PoundingError("this is no dataset of `assess_along`; give what it returned")
    part = _of_interface(assessed, interface)
    drawn, others = _drawn_axes(part)
    part = part.isel(others)
    figure, axes = blank(1, 2, (11.5, 4.8))
    if len(drawn) == 2 and not _is_few(part, drawn[1]) and is_number(part, drawn[0]):
        _share_map(figure, axes[0, 0], part, drawn)
        _gap_map(figure, axes[0, 1], part, drawn)
    else:
        _lines(axes[0, 0], axes[0, 1], part, drawn)
    if titled:
        title(figure, plain(along_finding(part.expand_dims("interface"))), plain(along_caption(assessed, part)), note)
    return figure


def along_caption(assessed: xr.Dataset, part: xr.Dataset | None = None) -> str:
    """What the finding holds for: motions, bounds, the interface, values of axes that are not drawn, idle axes."""
    if part is None:
        part = _of_interface(assessed, None)
        part = part.isel(_drawn_axes(part)[1])
    others = [str(dim) for dim in assessed.dims if dim != "interface" and dim not in part.dims]
    held = [value_words(part.expand_dims(others), axis, 0) for axis in others]
    parts = [
        f"{assessed.attrs['title']}, motions {assessed.attrs['motions']}",
        f"the gap required is that of {float(assessed.attrs['percentile']):g} % of the motions",
        f"shaded: bounds of {percent_words(float(assessed.attrs['confidence']))} by recording"
        if len(part.dims) == 1
        else "bounds are not drawn",
        *([f"at {part['interface'].item()}"] if assessed.sizes["interface"] > 1 else []),
        *([f"drawn where {', '.join(held)}"] if held else []),
        *filter(None, [idle_words(assessed)]),
    ]
    return "; ".join(parts)


def _of_interface(assessed: Any, interface: str | None) -> Any:
    """The part of one interface: the one asked for, or the one that needs the widest gap."""
    names = [str(name) for name in assessed["interface"].values]
    if interface is None:
        dims = [dim for dim in assessed.dims if dim != "interface"]
        return assessed.isel(interface=int(assessed["required_gap"].max(dims).values.argmax()))
    if interface not in names:
        raise PoundingError(
            f"interface: {shown(interface)} is none{nearest(interface, names)}; it may be {', '.join(names)}"
        )
    return assessed.isel(interface=names.index(interface))


def _drawn_axes(part: Any) -> tuple[list[str], dict[str, int]]:
    """The axes that are drawn, two at most, the one with most values first; and the place along each of the others."""
    axes = [str(dim) for dim in part.dims]
    own = json.loads(part.attrs["own_places"])
    spans = {axis: float((part["required_gap"].max(axis) - part["required_gap"].min(axis)).max()) for axis in axes}
    chosen = sorted(axes, key=lambda axis: -spans[axis])[:2]
    if len(chosen) == 2 and spans[chosen[1]] == 0.0 and part["contact_probability"].std(chosen[1]).max() == 0.0:
        chosen = chosen[:1]
    drawn = sorted(chosen, key=lambda axis: (not is_number(part, axis), -part.sizes[axis]))
    return drawn, {axis: own.get(axis, part.sizes[axis] // 2) for axis in axes if axis not in drawn}


def is_number(part: Any, axis: str) -> bool:
    """True for an axis whose values are numbers."""
    return part[axis].dtype.kind in "if"


def _is_few(part: Any, axis: str) -> bool:
    """True for an axis whose values are drawn as lines."""
    return part.sizes[axis] <= MOST_LINES or not is_number(part, axis)


def shown_values(part: Any, axis: str) -> tuple[Any, str]:
    """The values of an axis in the unit that readers see, and the axis with this unit; texts by their place."""
    moving = [str(key) for key, one in part.coords.items() if one.dims == (axis,) and key != axis]
    words = f"{axis}, with {', '.join(moving)}" if moving else axis
    if not is_number(part, axis):
        return np.arange(part.sizes[axis]), plain(words)
    unit = str(part[axis].attrs.get("units", "1"))
    name, factor = SHOWN.get(unit, (unit, 1.0))
    return part[axis].values * factor, plain(f"{words} [{name or '1'}]")


def label_side(axis: Any, side: str, part: Any, name: str) -> None:
    """Words of an axis, and the texts along it where its values are no numbers."""
    values, words = shown_values(part, name)
    getattr(axis, f"set_{side}label")(words)
    if not is_number(part, name):
        getattr(axis, f"set_{side}ticks")(values, [plain(str(text)) for text in part[name].values])


def _lines(left: Any, right: Any, part: Any, drawn: list[str]) -> None:
    """Draw both along the first axis: one line with its bounds, or a line for each value of the second."""
    along = drawn[0]
    values, _ = shown_values(part, along)
    places = range(part.sizes[drawn[1]]) if len(drawn) == 2 else [None]
    marker = "" if is_number(part, along) and len(values) > 12 else "o"
    for place, (colour, dash) in zip(places, contact_styles(len(places)), strict=True):
        one = part if place is None else part.isel({drawn[1]: place})
        words = "motions that close it" if place is None else plain(value_words(part, drawn[1], place))
        own = {"color": colour, "linestyle": dash if is_number(part, along) else "", "marker": marker or None}
        share, need = one["contact_probability"], one["required_gap"]
        tone = MEANING["required gap"] if place is None else colour
        if place is None:
            _bounds(left, values, one, "contact_probability", 1.0, colour)
            _bounds(right, values, one, "required_gap", 1e3, tone)
        left.plot(values, share, label=words, markersize=4, **own)
        words = f"gap required by {float(part.attrs['percentile']):g} %" if place is None else words
        right.plot(values, 1e3 * need, label=words, markersize=4, **own | {"color": tone})
    left.axhline(float(part.attrs["target"]), color=MEANING["target"], linestyle=":", linewidth=1.2, label="target")
    gaps = part["assessed_gap"].isel({drawn[1]: 0} if len(drawn) == 2 else {})
    right.plot(values, 1e3 * gaps, color=MEANING["gap"], linewidth=1.2, label="gap assessed")
    for axis, words in ((left, "P(contact) [1]"), (right, "gap [mm]")):
        label_side(axis, "x", part, along)
        axis.set_ylabel(words)
        axis.set_ylim(bottom=0.0)
        axis.legend(fontsize=8)
        if is_number(part, along):
            axis.set_xlim(values.min(), values.max())
    left.set_ylim(0.0, 1.02)


def _bounds(axis: Any, values: Any, part: Any, name: str, factor: float, colour: str) -> None:
    """Shade between the bounds of an output."""
    low, high = (factor * part[f"{name}_{end}"] for end in ("low", "high"))
    axis.fill_between(values, low, high, color=colour, alpha=0.12, linewidth=0.0)


def _over(axis: Any, part: Any, drawn: list[str]) -> tuple[Any, Any]:
    """Set up an axis of both numbers; returns their values."""
    for side, name in zip("xy", drawn, strict=True):
        label_side(axis, side, part, name)
    axis.grid(False)
    return shown_values(part, drawn[0])[0], shown_values(part, drawn[1])[0]


def _share_map(figure: Figure, axis: Any, part: Any, drawn: list[str]) -> None:
    """Draw P(contact) as a map; the line is the target."""
    values = _over(axis, part, drawn)
    share = part["contact_probability"].transpose(*drawn[::-1]).values
    picture = axis.pcolormesh(*values, share, cmap="Blues", vmin=0.0, vmax=1.0, shading="nearest", rasterized=True)
    target = float(part.attrs["target"])
    if share.min() < target < share.max():
        line = axis.contour(*values, share, levels=[target], colors="black", linewidths=1.2)
        axis.clabel(line, fmt=lambda level: f"{100 * level:g} %", fontsize=8)
    gaps = part["assessed_gap"].values
    of = f" of {say(float(gaps.flat[0]), GAP, 6)}" if np.ptp(gaps) == 0.0 else ""
    axis.set_title(f"P(contact){of}; line: the target", fontsize=9.5)
    share_bar(figure, picture, axis, "P(contact)")


def _gap_map(figure: Figure, axis: Any, part: Any, drawn: list[str]) -> None:
    """Draw the gap required as a map with contours; the thick one is the gap assessed."""
    values = _over(axis, part, drawn)
    need = 1e3 * part["required_gap"].transpose(*drawn[::-1]).values
    picture = axis.pcolormesh(*values, need, cmap="Oranges", shading="nearest", rasterized=True)
    if need.max() > need.min():
        lines = axis.contour(*values, need, levels=CONTOURS, colors="black", linewidths=0.7)
        axis.clabel(lines, fmt="%g", fontsize=8)
    over = need - 1e3 * part["assessed_gap"].transpose(*drawn[::-1]).values
    if over.min() < 0.0 < over.max():
        axis.contour(*values, over, levels=[0.0], colors="black", linewidths=2.0)
    percentile = float(part.attrs["percentile"])
    axis.set_title(f"gap that {percentile:g} % of the motions need [mm]; thick: the gap assessed", fontsize=9.5)
    figure.colorbar(picture, ax=axis, pad=0.01, aspect=30, label="gap [mm]")
