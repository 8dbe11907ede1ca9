"""Blocks of a sheet: dictionaries in which every number stands once rounded and once in full.

Questions and sections of the report make them; the terminal, the page and the PDF show them, so that all have the same
digits. A figure is drawn where a renderer needs it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from math import isfinite, isinf, isnan, nan
from typing import Any

import numpy as np

from pounding_risk._common.order import evenly
from pounding_risk.units import MISSING, SHOWN, rounded

Block = dict[str, Any]
Cell = dict[str, Any]
Row = list[Cell | str]

LONG = 24  # rows of a table that stands whole in the text
KEPT = 12  # rows of a longer one that stay there; all of them stand in the appendix
NOTE = "note"  # name of the end of a range that is words about it


def number(value: Any, unit: str = "1", digits: int = 4) -> Cell:
    """A value in SI: its text in the unit of `SHOWN`, and the raw value, None where it is not finite."""
    value = float(value)
    return worded(value, rounded(value * SHOWN[unit][1], digits)) | {"unit": unit}


def count(value: Any) -> Cell:
    """A whole number with all its digits."""
    return {"text": str(int(value)), "raw": int(value)}


def out_of(part: Any, total: Any) -> Cell:
    """A count and of how many, "3 of 24"; – where there are none."""
    part, total = int(part), int(total)
    return {"text": f"{part} of {total}" if total else MISSING, "parts": [part, total]}


def amount(value: Any, unit: str, digits: int = 4) -> Cell:
    """A number in the unit of `SHOWN`, followed by that unit; for cells whose column does not name it."""
    cell = number(value, unit, digits)
    return cell if cell["raw"] is None else cell | {"text": f"{cell['text']} {SHOWN[unit][0]}".strip()}


def strength(force: float | None, unit: bool = False) -> Cell:
    """A yield force [N], with its unit where ``unit``; "columns' own" where floors never yield and columns may."""
    if force is None:
        return {"text": MISSING, "raw": None}
    if isinf(force):
        return {"text": "columns' own", "raw": None}
    return amount(force, "N") if unit else number(force, "N")


def percent(value: float) -> str:
    """A percentage as words, "84 %"."""
    return f"{rounded(float(value), 6)} %"


def worded(value: float, text: str) -> Cell:
    """A number with a text of its own; – for NaN."""
    return {"text": MISSING if isnan(value) else text, "raw": value if isfinite(value) else None}


def milliseconds(seconds: float) -> Cell:
    """A short time [s], shown in ms with three digits."""
    return worded(seconds, rounded(seconds * 1e3, 3)) | {"size": 1e3}


def computing_time(seconds: Any) -> Cell:
    """A computing time [s], shown in µs, ms or s with three digits."""
    seconds = float(seconds)
    name, size = next((unit for unit in (("µs", 1e-6), ("ms", 1e-3)) if seconds < 1e3 * unit[1]), ("s", 1.0))
    return {"text": f"{rounded(seconds / size, 3)} {name}", "raw": seconds}


def probability(value: Any) -> Cell:
    """A probability in %, small ones as below 0.01."""
    cell = number(value, "%", 3)
    return cell | {"text": "< 0.01"} if 0.0 < float(value) < 1e-4 else cell


def between(low: Any, high: Any, unit: str, digits: int = 4) -> Cell:
    """Both ends of a range, in the unit of the column's head."""
    return joined(number(low, unit, digits), number(high, unit, digits))


def with_bounds(values: Any, name: str, unit: str = "1", digits: int = 3, bound_digits: int = 2) -> list[Cell]:
    """A number of a dataset and its bounds, whose names end in _low and _high, in the unit of the column's head."""
    low, high = (values[f"{name}_{end}"] for end in ("low", "high"))
    return [number(values[name], unit, digits), between(low, high, unit, bound_digits)]


def joined(*ends: Cell, names: Sequence[str] = ("low", "high")) -> Cell:
    """A range from the cells of its ends, one number where they are equal; in CSV each end has a column of its name."""
    named_ends = dict(zip(names, ends, strict=True))
    if all(end["text"] == MISSING for end in ends):
        return {"text": MISSING, "parts": [None, None], "ends": named_ends}
    texts, parts = [end["text"] for end in ends], [end["raw"] for end in ends]
    is_one = len(set(texts)) == len(set(parts)) == 1
    return {"text": texts[0] if is_one else " to ".join(texts), "parts": parts, "ends": named_ends}


def noted(span: Cell, mark: str, words: str) -> Cell:
    """A range with a mark behind its text, and the meaning of the mark, in words with a column of their own."""
    return span | {"text": f"{span['text']} {mark}", "ends": span["ends"] | {NOTE: {"text": words}}}


def percentiles(values: Any) -> tuple[float, float, float]:
    """The 16th, 50th and 84th percentile of the finite values; NaN where there are none."""
    finite = np.asarray(values, dtype=float)
    finite = finite[np.isfinite(finite)]
    if not finite.size:
        return nan, nan, nan
    low, median, high = np.percentile(finite, (16.0, 50.0, 84.0)).tolist()
    return low, median, high


def middle(spread: tuple[float, float, float], unit: str) -> Cell:
    """A median, and in brackets the range of the middle 68 %; the raw values in this order."""
    low, median, high = (number(value, unit, 3) for value in spread)
    if median["text"] == MISSING:
        return median
    text = f"{median['text']} ({low['text']} to {high['text']})"
    ends = {"": median, "low": low, "high": high}
    return {"text": text, "parts": [end["raw"] for end in ends.values()], "ends": ends}


def head(words: str, unit: str) -> str:
    """Head of a column of numbers: words, and the unit that they are shown in."""
    unit_name = SHOWN[unit][0]
    return f"{words} [{unit_name}]" if unit_name else words


def paragraph(text: str) -> Block:
    """Block of one paragraph of text, for the page and the PDF."""
    return {"kind": "paragraph", "text": text}


def heading(text: str, anchor: str) -> Block:
    """A heading within a section; ``anchor`` is its id."""
    return {"kind": "heading", "text": text, "anchor": anchor}


def listing(items: Iterable[str], mark: str = "note: ") -> Block:
    """A list of sentences, one below the other; on a terminal each begins with ``mark``."""
    return {"kind": "list", "items": list(items), "mark": mark}


def facts(caption: str, rows: Iterable[tuple[str, Cell | str]]) -> Block:
    """A table of two columns: a name, and a number or words."""
    return {"kind": "facts", "caption": caption, "rows": [[name, _cell(value)] for name, value in rows]}


def table(
    caption: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[Any]],
    *,
    keep: Sequence[int] | None = None,
    note: str = "",
) -> Block:
    """Rows of cells or words under heads; columns of numbers stand at the right.

    Of a long table the rows ``keep`` stay in the text, evenly spread ones by default; ``note`` says which those are.
    The terminal shows all rows of a table without ``note``.
    """
    cells = [[_cell(value) for value in row] for row in rows]
    return {
        "kind": "table",
        "caption": caption,
        "heads": list(heads),
        "sides": "".join(_side([row[index] for row in cells]) for index in range(len(heads))),
        "rows": cells,
        "keep": evenly(len(cells), KEPT) if keep is None else list(keep),
        "note": note,
    }


def figure(name: str, drawing: str | Callable[[], Any], caption: str, alt: str) -> Block:
    """A drawing; ``name`` is unique in a report, ``alt`` describes it to a reader who cannot see it.

    ``drawing`` is the SVG, or a call that gives the Matplotlib figure, made only where a drawing is shown.
    """
    return {"kind": "figure", "name": name, "svg": drawing, "caption": caption, "alt": alt}


def name_of(law: str) -> str:
    """A contact model or an effect as text, which breaks where words do."""
    return law.replace("_", " ")


def source(caption: str, text: str) -> Block:
    """A text set as it stands in a file."""
    return {"kind": "source", "caption": caption, "text": text.strip("\n")}


def _side(column: list[Cell]) -> str:
    """Where the cells of a column stand, "l" or "r"."""
    has_numbers = any(len(cell) > 1 for cell in column)
    return "r" if has_numbers or all(cell["text"] in ("", MISSING) for cell in column) else "l"


def _cell(value: Cell | str) -> Cell:
    return {"text": value} if isinstance(value, str) else value
