"""A sheet as CSV: its tables and facts one below the other, numbers unrounded in the units of their heads."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Any

from pounding_risk._common.letters import csv_text as text_of_rows
from pounding_risk.render.sheet import NOTE, Block, Cell
from pounding_risk.units import SHOWN

EMPTY: Cell = {"text": ""}
LEAST = "at least "  # before a number that is only a lower bound


def csv_text(blocks: Iterable[Block]) -> str:
    """The tables and facts of a sheet as CSV text: a row with its caption, if any, its heads, its rows, an empty row.

    A number stands unrounded in the unit of its head, or before its own where the rows of a column have several, after
    "at least" where it is only a lower bound; a range has a column for each end, named low and high behind the head,
    and one for a note on it; other text stands as the terminal shows it; what is not known is empty. Figures and text
    are left to the other renderers.
    """
    lines: list[list[Any]] = []
    for block in blocks:
        if block["kind"] not in ("table", "facts"):
            continue
        if block["caption"]:
            lines.append([block["caption"].rstrip(".")])
        if block["kind"] == "table":
            lines += map(list, zip(*_columns(block), strict=True))
        else:
            ends = [(name, *end) for name, cell in block["rows"] for end in cell.get("ends", {"": cell}).items()]
            lines += [[_head(name, end), _cell_content(cell)] for name, end, cell in ends]
        lines.append([])
    return text_of_rows(lines)


def _columns(block: Block) -> Iterator[list[Any]]:
    """The columns of a table with their heads; a column of ranges becomes one column for each end."""
    for index, head in enumerate(block["heads"]):
        cells = [row[index] for row in block["rows"]]
        ends = [cell.get("ends", {"": cell}) for cell in cells]
        names = max(ends, key=len, default={"": EMPTY})
        for position, name in enumerate(names):
            column = [cell_ends.get(name, cell_ends.get("", EMPTY) if position == 0 else EMPTY) for cell_ends in ends]
            yield [_head(head, name), *(_cell_content(cell) for cell in column)]


def _head(head: str, name: str) -> str:
    """The head of one end of a range: "bounds low [mm]" of "bounds [mm]"; a note has no unit."""
    words, bracket, unit = head.partition(" [")
    full_head = f"{words.removesuffix('; by recording')} {name}".rstrip()  # the names of such ends have these words
    return full_head if name == NOTE else f"{full_head}{bracket}{unit}"


def _cell_content(cell: Cell) -> Any:
    """A number in the unit in which it is shown, with that unit where its text has it; otherwise the text."""
    raw = cell.get("raw")
    unit, size = SHOWN.get(cell.get("unit", "1"), ("", 1.0))
    size = cell.get("size", size)
    has_unit = bool(unit) and cell["text"].endswith(f" {unit}")
    in_words = not has_unit and cell["text"].endswith(tuple("abcdefghijklmnopqrstuvwxyz%²³"))
    if not isinstance(raw, int | float) or in_words:
        return "" if cell["text"] == "–" else cell["text"]
    shown_number = raw if size == 1.0 else float(f"{raw * size:.15g}")  # 83.2, not 83.20000000000002
    if has_unit:
        return f"{shown_number} {unit}"
    return f"{LEAST}{shown_number}" if cell["text"].startswith(LEAST) else shown_number
