"""What every figure shares: its frame, its words, its line styles, and files that are the same for the same data.

Colours are those of Okabe and Ito (2008), told apart by the colour-blind; lines differ in dash too, for print.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from textwrap import fill, wrap
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from matplotlib.figure import Figure

STANDARD_GRAVITY = 9.80665
STYLES = (("#0072B2", "-"), ("#D55E00", "--"), ("#009E73", "-."), ("#CC79A7", ":"), ("#56B4E9", "-"), ("#E69F00", "--"))
QUIET = "#555555"
LAW_WORDS = {"jankowski": "nonlinear viscoelastic", "viscous_elastoplastic": "viscous elastoplastic"}
# What a file would tell of the day and the program that wrote it, by suffix.
NAMELESS: dict[str, dict[str, None]] = {
    ".png": {"Software": None},
    ".svg": {"Date": None, "Creator": None},
    ".pdf": {"CreationDate": None, "Creator": None, "Producer": None},
}


def blank(
    rows: int = 1, columns: int = 1, size: tuple[float, float] = (8.0, 4.5), **options: Any
) -> tuple[Figure, Any]:
    """A figure without pyplot's global state, and its axes as an array."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=size, layout="constrained")
    axes = figure.subplots(rows, columns, squeeze=False, **options)
    for each in axes.flat:
        each.grid(True, color="#dddddd", linewidth=0.6)
        each.set_axisbelow(True)
    return figure, axes


def title(figure: Figure, finding: str, condition: str, note: str = "") -> None:
    """The finding, below it what it holds for, and below that what the user adds, such as what is assumed."""
    figure.suptitle("\n".join(filter(None, (finding, condition, note))), fontsize=11, linespacing=1.25)


def in_lines(text: str, most: int) -> str:
    """The text in the fewest lines of at most so many letters, all about as long."""
    lines = len(wrap(text, most))
    fits = (width for width in range(max(1, len(text) // max(lines, 1)), most) if len(wrap(text, width)) <= lines)
    return fill(text, next(fits, most))


def write(figure: Figure, path: str | Path, dpi: float = 120.0) -> Path:
    """Save a figure as PNG, SVG or PDF: the same bytes for the same data, on any day."""
    from matplotlib import rc_context

    target = Path(path)
    # Laid out once: each further layout starts from the last one and moves everything by a hair.
    if figure.get_layout_engine() is not None:
        figure.draw_without_rendering()
        figure.set_layout_engine("none")
    with rc_context({"svg.hashsalt": "pounding_risk"}):
        figure.savefig(target, dpi=dpi, metadata=NAMELESS.get(target.suffix.lower()))
    return target


def styles(count: int) -> list[tuple[str, str]]:
    """So many pairs of colour and dash."""
    return [STYLES[place % len(STYLES)] for place in range(count)]


def law_words(name: str) -> str:
    """A contact law as a reader knows it."""
    return LAW_WORDS.get(name, name.replace("_", " "))


def force_words(force: float) -> str:
    """A yield force in kN."""
    return "without yielding" if np.isinf(force) else f"$F_E$ = {force / 1e3:.0f} kN"


def motion_words(facts: Mapping[Any, Any]) -> str:
    """Record, polarity and amplitude of one run."""
    return f"{facts['record']} {facts['polarity']} at {facts['pga'] / STANDARD_GRAVITY:.4g} g"


def plain(text: str) -> str:
    """A user's words as they are: a dollar sign would start a formula."""
    return text.replace("$", r"\$")


def font_files() -> list[Path]:
    """The fonts of Matplotlib's own letters, DejaVu, which have most alphabets."""
    from matplotlib import get_data_path

    return sorted(Path(get_data_path(), "fonts", "ttf").glob("DejaVuSans*.ttf"))
