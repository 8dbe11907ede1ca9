"""Shared style of figures: frame, title, caption, colours and dashes; files have the same bytes for the same data.

Colours are those of Okabe and Ito (2008), which the colour-blind distinguish; lines differ in dash too, for print.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from io import StringIO
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.files import write_whole
from pounding_risk.motions.record import AFTERSHOCK
from pounding_risk.units import say_in

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure
else:
    Axes = Figure = Any  # Matplotlib is imported where a figure is made

STYLES = (("#0072B2", "-"), ("#D55E00", "--"), ("#009E73", "-."), ("#CC79A7", ":"), ("#56B4E9", "-"), ("#E69F00", "--"))
QUIET = "#555555"
# What a colour means wherever an assessment is drawn. Series without a meaning of their own take `STYLES`.
MEANING = {
    "motions": "#0072B2",  # what the motions show: P(contact), the gap that each needs
    "gap": "#000000",  # the gap that is judged
    "target": QUIET,  # the probability of contact that is accepted
    "required gap": "#D55E00",
    "rule": "#009E73",  # what code rules require; `RULE_MARKS` shows how the text of a clause is known
}
# How a mark is filled, by how the text of a rule's clause is known.
RULE_MARKS = {"derived": "full", "clause read": "full", "quoted": "left", "from memory": "none"}
RULE_MARKS_WORDS = (
    "square: insufficient for some motion; full: clause read, or derived; half: quoted; open: from memory"
)
LETTERS_AN_INCH = 11.0  # of a title in 11 points; a mean letter of DejaVu Sans is 0.55 of its size wide
CAPTION_SIZE = 8.5  # points
NAME_LINE = 24  # letters of a building's name in one line
# The space between a number and its unit, at which no line ends.
UNIT_OF_NUMBER = re.compile(r"(?<=\d) (?=(?:%|[mck]?m|m?s|[kM]?N|[kM]?J|m/s2?|m/s²|g|kg|t|Hz|years?)(?![\w/]))")
TIE = "\u00a0"
PLACES = 6  # decimals of the places of panels, as shares of a figure: a thousandth of a pixel
ROUND = [digit * 10.0**power for power in range(-14, 10) for digit in (1.0, 2.0, 5.0)]  # ticks and contours
# Metadata of the day and of the program, which are left out, by suffix.
NAMELESS: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def blank(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (8.0, 4.5), **options: Any
) -> tuple[Figure, Any]:
    """An empty figure of constrained layout without the global state of pyplot, and its axes.

    Parameters
    ----------
    rows, columns : int
        Number of panels.
    size : pair of float
        Width and height [inches].
    **options
        Further options of ``matplotlib.figure.Figure.subplots``.

    Returns
    -------
    figure : matplotlib.figure.Figure
        The figure.
    axes : array of matplotlib.axes.Axes, shape (rows, columns)
        Its panels, with a grid.
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for axis in axes.flat:
        _with_grid(axis)
    return figure, axes


def wrapped(count: int, most: int, edges: tuple[float, float], panel: tuple[float, float]) -> tuple[Figure, Any]:
    """As `blank`, for so many panels, ``most`` of them beside each other; ``edges`` [inches] are beside the panels."""
    columns = min(most, count)
    rows = -(-count // columns)
    figure, axes = blank(rows, columns, (edges[0] + panel[0] * columns, edges[1] + panel[1] * rows))
    for axis in axes.flat[count:]:
        axis.set_visible(False)
    return figure, axes


def _with_grid(axis: Any) -> Any:
    axis.grid(True, color="#dddddd", linewidth=0.6)
    axis.set_axisbelow(True)
    return axis


def joined(figure: Figure, row: Any) -> Any:
    """One panel in place of those of a row of `blank`."""
    place = row[0].get_subplotspec()
    whole_row = place.get_gridspec()[place.rowspan.start, :]
    for axis in row:
        axis.remove()
    return _with_grid(figure.add_subplot(whole_row))


def title(figure: Figure, headline: str, condition: str, note: str = "") -> None:
    """Title a figure with what it shows or finds, in two lines at most, and caption it below with its conditions.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        With a constrained layout, which leaves room for both.
    headline : str
        Clauses separated by "; "; those that two lines do not hold begin the caption, after "Also: ".
    condition : str
        Conditions that the headline holds for.
    note : str
        Words of the user, such as what is assumed.
    """
    letters = int(figure.get_figwidth() * LETTERS_AN_INCH)
    clauses = UNIT_OF_NUMBER.sub(TIE, headline.removesuffix(".").replace("\n", " ")).split("; ")
    count = 1
    while count < len(clauses) and len(wrap("; ".join(clauses[: count + 1]), letters)) <= 2:
        count += 1
    figure.suptitle(in_lines("; ".join(clauses[:count]), letters), fontsize=11, linespacing=1.25)
    rest_text = f"Also: {'; '.join(clauses[count:])}" if clauses[count:] else ""
    caption = [part for part in (rest_text, condition, note) if part]
    per_line = int(letters * 11.0 / CAPTION_SIZE)
    figure.supxlabel("\n".join(in_lines(part, per_line) for part in caption), fontsize=CAPTION_SIZE, linespacing=1.25)


def in_lines(text: str, most: int) -> str:
    """The text in the fewest lines of at most so many letters, all about as long; numbers stay beside their units."""
    tied = UNIT_OF_NUMBER.sub(TIE, text)
    lines = len(wrap(tied, most))
    fits = (width for width in range(max(1, len(text) // max(lines, 1)), most) if len(wrap(tied, width)) <= lines)
    return fill(tied, next(fits, most)).replace(TIE, " ")


def write(figure: Figure, path: str | Path, dpi: float = 120.0) -> Path:
    """Save a figure, with the same bytes for the same data on any day.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
        The figure; its layout is fixed.
    path : str or Path
        A file whose name ends in .png, .svg or .pdf.
    dpi : float
        Dots per inch of a PNG.

    Returns
    -------
    Path
        The file.
    """
    from matplotlib import rc_context

    target = Path(path)
    _lay_out(figure)
    suffix = target.suffix.lower()
    look: dict[str, Any] = {"dpi": dpi, "metadata": NAMELESS.get(suffix), "format": suffix.removeprefix(".") or None}
    with rc_context({"svg.hashsalt": "pounding_risk"}):
        write_whole(target, lambda file: figure.savefig(file, **look))
    return target


def _lay_out(figure: Figure) -> None:
    """Lay a figure out once and for all, every panel at a round place.

    Each further layout starts from the last one and moves everything by a hair, and so does the layout's solver, whose
    variables have the order of their addresses in memory: coordinates of an SVG, of six decimals, would show it.
    """
    engine = figure.get_layout_engine()
    if engine is None:
        return
    engine.execute(figure)
    figure.set_layout_engine("none")
    for axis in figure.axes:
        place = axis.get_position(original=True)
        axis.set_position(place.from_extents(*np.round(place.extents, PLACES)), which="original")


def svg_text(figure: Figure) -> str:
    """A figure as SVG to stand within a page: letters as outlines, the same bytes for the same data, no prologue."""
    from matplotlib import rc_context

    stream = StringIO()
    _lay_out(figure)
    with rc_context({"svg.hashsalt": "pounding_risk", "svg.fonttype": "path"}):
        figure.savefig(stream, format="svg", metadata=NAMELESS[".svg"])
    text = stream.getvalue()
    # Metadata of the format is for files that stand alone.
    return re.sub(r"\s*<metadata>.*?</metadata>", "", text[text.index("<svg") :], flags=re.DOTALL).strip()


def styles(count: int) -> list[tuple[str, str]]:
    """Pairs of colour and dash for a number of lines.

    Parameters
    ----------
    count : int
        Number of lines.

    Returns
    -------
    list of tuple of str
        Colour and dash of each; after six the colours come again with other dashes, after 24 with the same.
    """
    kinds, dashes = len(STYLES), [dash for _, dash in STYLES[:4]]
    return [(STYLES[at % kinds][0], dashes[(at % kinds + at // kinds) % len(dashes)]) for at in range(count)]


def rule_mark(verification: str) -> dict[str, Any]:
    """Look of a rule's mark, by how the text of its clause is known."""
    colour = MEANING["rule"]
    return {
        "color": colour,
        "markeredgecolor": colour,
        "markerfacecolor": colour,
        "markerfacecoloralt": "white",
        "fillstyle": RULE_MARKS[verification],
        "markersize": 6.5,
    }


def contact_styles(count: int) -> list[tuple[str, str]]:
    """Pairs of colour and dash for curves of contact in rising order: shades of the colour of the motions."""
    return _shades("Blues", count) if count > 1 else [(MEANING["motions"], STYLES[0][1])]


def strength_styles(count: int) -> list[tuple[str, str]]:
    """Pairs of colour and dash for yield forces in rising order: light to dark, in no colour of `MEANING`."""
    return _shades("Purples", count)


def _shades(colours: str, count: int) -> list[tuple[str, str]]:
    from matplotlib import colormaps
    from matplotlib.colors import to_hex

    depths = np.linspace(0.5, 1.0, count) if count != 1 else [0.8]
    return [(to_hex(colormaps[colours](depth)), dash) for depth, (_, dash) in zip(depths, styles(count), strict=True)]


def law_words(name: str) -> str:
    """Name of a contact model as figures write it.

    Parameters
    ----------
    name : str
        Name in the dataset.

    Returns
    -------
    str
        Words.
    """
    return name.replace("_", " ")


def force_words(force: float) -> str:
    """A yield force [N] in kN; "without yielding" where it is infinite."""
    return "without yielding" if np.isinf(force) else f"$F_E$ = {force / 1e3:.0f} kN"


def motion_words(facts: Mapping[Any, Any]) -> str:
    """Record, polarity and amplitude of one run, and its aftershock."""
    behind = f", followed by {facts[AFTERSHOCK]}" if AFTERSHOCK in facts else ""
    return f"{facts['record']} {facts['polarity']} at {say_in(facts['pga'], 'g')}{behind}"


def panel(draw: Callable[..., None], *arguments: Any, height: float = 4.2) -> Figure:
    """A figure of one panel for a report, ``height`` inches high, which a function draws on its axis; with a legend."""
    figure, axes = blank(1, 1, (7.2, height))
    draw(axes[0, 0], *arguments)
    if axes[0, 0].get_legend() is None and axes[0, 0].get_legend_handles_labels()[0]:
        axes[0, 0].legend(fontsize=8)
    return figure


def message(axis: Any, words: str, letters: int = 46) -> None:
    """Words in the middle of a panel that has nothing to draw, in lines of so many letters."""
    look = {"transform": axis.transAxes, "ha": "center", "va": "center", "fontsize": 9.5, "color": QUIET}
    axis.text(0.5, 0.5, fill(UNIT_OF_NUMBER.sub(TIE, words), letters), **look)


def beside(axis: Any, words: str, place: tuple[Any, Any], shift: tuple[float, float], size: float, **look: Any) -> Any:
    """Words ``shift`` points to the right of a place and above it; words straight above or below it are centred."""
    aside, up = shift
    alignment = {"ha": "left" if aside > 0 else "right", "va": "center"}
    if not aside:
        alignment = {"ha": "center", "va": "bottom" if up > 0 else "top"}
    return axis.annotate(words, place, xytext=shift, textcoords="offset points", fontsize=size, **(alignment | look))


def logarithmic(axis: Any, side: str, low: float, high: float, ticks: Sequence[float] = ROUND) -> None:
    """A logarithmic scale between two ends, with the ticks between them in full numbers."""
    ticks_inside = [tick for tick in ticks if low <= tick <= high]
    getattr(axis, f"set_{side}scale")("log")
    getattr(axis, f"set_{side}lim")(low, high)
    getattr(axis, f"set_{side}ticks")(ticks_inside, [f"{tick:g}" for tick in ticks_inside])
    getattr(axis, f"set_{side}ticks")([], minor=True)


def ratio_axis(axis: Any, side: str, values: Any) -> None:
    """The axis of these rising values, such as periods; logarithmic where they span more than three times the first."""
    if 0.0 < 3.0 * values[0] < values[-1]:
        logarithmic(axis, side, values[0], values[-1])
    getattr(axis, f"set_{side}lim")(values[0], values[-1])


def hatch(axis: Any, places: tuple[Any, Any], values: Any, least: float, pattern: str) -> None:
    """Hatch the part of a map over (x, y) places where its values, (y, x), exceed the least."""
    largest = np.nanmax(values, initial=least)
    if largest > least:
        contours = axis.contourf(*places, values, levels=[least, largest + 1.0], colors="none", hatches=[pattern])
        contours.set_edgecolor(QUIET)
        contours.set_linewidth(0.0)


def share_bar(figure: Figure, picture: Any, axes: Any, words: str, aspect: float = 30.0) -> None:
    """A bar of the colours of shares, in per cent."""
    bar = figure.colorbar(picture, ax=axes, aspect=aspect, pad=0.01, label=words)
    bar.ax.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")


def legend_under(axis: Any, columns: int) -> None:
    """A legend below the axis and its label, where it covers nothing."""
    position = {"loc": "upper center", "bbox_to_anchor": (0.5, 0.0), "borderaxespad": 5.2, "ncols": columns}
    axis.legend(fontsize=8, frameon=False, handlelength=2.6, columnspacing=1.2, **position)


def legend_below(figure: Figure, handles: list[Any], columns: int, caption: str | None = None) -> None:
    """A legend below all panels, without a frame; above the caption of a figure that `title` has given one.

    The layout knows the caption alone: empty lines in front of it make the room.
    """
    position: dict[str, Any] = {"loc": "outside lower center", "ncols": columns}
    if caption is not None:
        letters = int(figure.get_figwidth() * LETTERS_AN_INCH * 11.0 / 8.0)
        caption = "\n".join(in_lines(line, letters) for line in caption.split("\n"))
    words = figure.get_supxlabel()
    if words:
        rows = -(-len(handles) // columns) + (0 if caption is None else caption.count("\n") + 1)
        figure.supxlabel("\n" * (rows + 1) + words, fontsize=CAPTION_SIZE, linespacing=1.25)
        lift = (words.count("\n") + 1.7) * 1.25 * CAPTION_SIZE / 72.0 / figure.get_figheight()
        position |= {"loc": "lower center", "bbox_to_anchor": (0.5, lift)}
    legend = figure.legend(handles=handles, fontsize=8, frameon=False, title=caption, **position)
    legend.get_title().set_fontsize(8)


def plain(text: str) -> str:
    """Words of a user, with dollar signs escaped, which would start a formula."""
    return text.replace("$", r"\$")


def font_files() -> list[Path]:
    """The fonts of Matplotlib's own letters, DejaVu, which have most alphabets."""
    from matplotlib import get_data_path

    return sorted(Path(get_data_path(), "fonts", "ttf").glob("DejaVuSans*.ttf"))
