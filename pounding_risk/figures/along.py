"""Figure of contact and required gap along axes of numbers of the scene."""

from __future__ import annotations

from typing import Any

import numpy as np
import xarray as xr

from pounding_risk.assessment.along import along_finding, idle_words, is_along, value_words
from pounding_risk.assessment.options import percent_words
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import MEANING, Figure, blank, contact_styles, plain, share_bar, title
from pounding_risk.results.attributes import read_attribute
from pounding_risk.units import GAP, SHOWN, say, unknown

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
        Whether finding and conditions are written; without them, as in a report, panels stand below each other.

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
    part = _part_at_interface(assessed, interface)
    drawn, other_places = _drawn_axes(part)
    part = part.isel(other_places)
    figure, axes = blank(1, 2, (11.5, 4.8)) if titled else blank(2, 1, (7.2, 6.4))
    left, right = axes.flat
    if len(drawn) == 2 and part.sizes[drawn[1]] > MOST_LINES and all(is_number(part, axis) for axis in drawn):
        _draw_maps(figure, (left, right), part, drawn)
    else:
        _draw_lines(left, right, part, drawn)
    if titled:
        title(figure, plain(along_finding(part.expand_dims("interface"))), plain(along_caption(assessed, part)), note)
    return figure


def along_caption(assessed: xr.Dataset, shown: xr.Dataset | None = None) -> str:
    """The conditions of the finding: motions, bounds, interface, values of axes that are not drawn, idle axes."""
    if shown is None:
        shown = _part_at_interface(assessed, None)
        shown = shown.isel(_drawn_axes(shown)[1])
    others = [str(dim) for dim in assessed.dims if dim != "interface" and dim not in shown.dims]
    held_texts = [value_words(shown.expand_dims(others), axis, 0) for axis in others]
    bounds = f"shaded: bounds of {percent_words(float(assessed.attrs['confidence']))} by recording"
    if not (shown["required_gap_bounded"] > 0.0).all():
        bounds += ", of the gap up to the largest that a motion needs where so few recordings give no upper bound"
    parts = [
        f"{assessed.attrs['title']}, motions {assessed.attrs['motions']}",
        f"the gap required is that of {float(assessed.attrs['percentile']):g} % of the motions",
        bounds if len(shown.dims) == 1 else "bounds are not drawn",
        *([f"at {shown['interface'].item()}"] if assessed.sizes["interface"] > 1 else []),
        *([f"drawn where {', '.join(held_texts)}"] if held_texts else []),
        *filter(None, [idle_words(assessed)]),
    ]
    return "; ".join(parts)


def _part_at_interface(assessed: Any, interface: str | None) -> Any:
    """The dataset at one interface: the one named, or the one that needs the widest gap."""
    names = [str(name) for name in assessed["interface"].values]
    if interface is None:
        dims = [dim for dim in assessed.dims if dim != "interface"]
        return assessed.isel(interface=int(assessed["required_gap"].max(dims).values.argmax()))
    if interface not in names:
        raise PoundingError(f"interface: {unknown(interface, 'none', names)}")
    return assessed.isel(interface=names.index(interface))


def _drawn_axes(part: Any) -> tuple[list[str], dict[str, int]]:
    """The axes that are drawn, two at most, the one with most values first; and the place along each of the others."""
    axes = [str(dim) for dim in part.dims]
    own_places = read_attribute(part, "own_places", {})
    spans = {axis: float((part["required_gap"].max(axis) - part["required_gap"].min(axis)).max()) for axis in axes}
    chosen = sorted(axes, key=lambda axis: -spans[axis])[:2]
    if len(chosen) == 2 and spans[chosen[1]] == 0.0 and part["contact_probability"].std(chosen[1]).max() == 0.0:
        chosen = chosen[:1]
    drawn_axes = sorted(chosen, key=lambda axis: (not is_number(part, axis), -part.sizes[axis]))
    return drawn_axes, {axis: own_places.get(axis, part.sizes[axis] // 2) for axis in axes if axis not in drawn_axes}


def is_number(dataset: Any, axis: str) -> bool:
    """True for an axis whose values are numbers."""
    return dataset[axis].dtype.kind in "if"


def shown_values(dataset: Any, axis: str) -> tuple[Any, str]:
    """The values of an axis in the unit that readers see, and the axis with this unit; texts by their place."""
    moving_keys = [str(key) for key, coordinate in dataset.coords.items() if coordinate.dims == (axis,) and key != axis]
    words = f"{axis}, with {', '.join(moving_keys)}" if moving_keys else axis
    if not is_number(dataset, axis):
        return np.arange(dataset.sizes[axis]), plain(words)
    unit = str(dataset[axis].attrs.get("units", "1"))
    name, factor = SHOWN.get(unit, (unit, 1.0))
    return dataset[axis].values * factor, plain(f"{words} [{name or '1'}]")


def label_side(axis: Any, side: str, dataset: Any, name: str) -> None:
    """Words of an axis, and the texts along it where its values are no numbers."""
    values, words = shown_values(dataset, name)
    getattr(axis, f"set_{side}label")(words)
    if not is_number(dataset, name):
        getattr(axis, f"set_{side}ticks")(values, [plain(str(text)) for text in dataset[name].values])


def _draw_lines(left: Any, right: Any, part: Any, drawn: list[str]) -> None:
    """Draw both along the first axis: one line with its bounds, or a line for each value of the second."""
    first_axis = drawn[0]
    values, _ = shown_values(part, first_axis)
    places = range(part.sizes[drawn[1]]) if len(drawn) == 2 else [None]
    marker = "" if is_number(part, first_axis) and len(values) > 12 else "o"
    for place, (colour, dash) in zip(places, contact_styles(len(places)), strict=True):
        line_part = part if place is None else part.isel({drawn[1]: place})
        colours = colour, MEANING["required gap"]
        words = "motions that close it", f"gap required by {float(part.attrs['percentile']):g} %"
        if place is not None:
            colours, words = (colour, colour), (plain(value_words(part, drawn[1], place)),) * 2
        panels = ((left, "contact_probability", 1.0), (right, "required_gap", 1e3))
        for (axis, name, factor), tone, label in zip(panels, colours, words, strict=True):
            if place is None:
                ends = (factor * line_part[f"{name}_{end}"] for end in ("low", "high"))
                axis.fill_between(values, *ends, color=tone, alpha=0.12, linewidth=0.0)
            look = {"color": tone, "linestyle": dash if is_number(part, first_axis) else "", "marker": marker or None}
            axis.plot(values, factor * line_part[name], label=label, markersize=4, **look)
    left.axhline(float(part.attrs["target"]), color=MEANING["target"], linestyle=":", linewidth=1.2, label="target")
    gaps = part["assessed_gap"].isel({drawn[1]: 0} if len(drawn) == 2 else {})
    right.plot(values, 1e3 * gaps, color=MEANING["gap"], linewidth=1.2, label="gap assessed")
    for axis, label in ((left, "P(contact) [1]"), (right, "gap [mm]")):
        label_side(axis, "x", part, first_axis)
        axis.set_ylabel(label)
        axis.set_ylim(bottom=0.0)
        axis.legend(fontsize=8)
        if is_number(part, first_axis):
            axis.set_xlim(values.min(), values.max())
    left.set_ylim(0.0, 1.02)


def _draw_maps(figure: Figure, panels: Any, part: Any, drawn: list[str]) -> None:
    """Draw P(contact) with the target, and the gap required with contours; that of the gap assessed is thick."""
    values = [shown_values(part, axis)[0] for axis in drawn]
    share, need, gaps = (
        part[name].transpose(*drawn[::-1]).values for name in ("contact_probability", "required_gap", "assessed_gap")
    )
    for panel in panels:
        for side, axis in zip("xy", drawn, strict=True):
            label_side(panel, side, part, axis)
        panel.grid(False)
    left, right = panels
    picture = left.pcolormesh(*values, share, cmap="Blues", vmin=0.0, vmax=1.0, shading="nearest", rasterized=True)
    target = float(part.attrs["target"])
    if share.min() < target < share.max():
        line = left.contour(*values, share, levels=[target], colors="black", linewidths=1.2)
        left.clabel(line, fmt=lambda level: f"{100 * level:g} %", fontsize=8)
    of = f" of {say(float(gaps.flat[0]), GAP, 6)}" if np.ptp(gaps) == 0.0 else ""
    left.set_title(f"P(contact){of}; line: the target", fontsize=9.5)
    share_bar(figure, picture, left, "P(contact)")
    picture = right.pcolormesh(*values, 1e3 * need, cmap="Oranges", shading="nearest", rasterized=True)
    if need.max() > need.min():
        lines = right.contour(*values, 1e3 * need, levels=CONTOURS, colors="black", linewidths=0.7)
        right.clabel(lines, fmt="%g", fontsize=8)
    if (need - gaps).min() < 0.0 < (need - gaps).max():
        right.contour(*values, need - gaps, levels=[0.0], colors="black", linewidths=2.0)
    percentile = float(part.attrs["percentile"])
    right.set_title(f"gap required by {percentile:g} % of the motions [mm]; thick: the gap assessed", fontsize=9.5)
    figure.colorbar(picture, ax=right, pad=0.01, aspect=30, label="gap [mm]")
