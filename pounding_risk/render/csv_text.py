"""A sheet as CSV: its tables and facts one below the other, numbers unrounded in the units of their heads."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pounding_risk._common.letters import csv_text as text_of_rows
from pounding_risk.render.sheet import Block, Cell
from pounding_risk.units import SHOWN

LEAST = "at least "  # before a number that is only a lower bound


def csv_text(blocks: Iterable[Block]) -> str:
    """The tables and facts of a sheet as CSV text: a row with the caption of each, its heads, its rows, an empty row.

    A number stands unrounded in the unit of its head, or before its own where the rows of a column have several, after
    "at least" where it is only a lower bound; a range or what is no single number as the terminal shows it; what is not
    known is empty. Figures and text are left to the other renderers.
    """
    lines: list[list[Any]] = []
    for block in blocks:
        if block["kind"] not in ("table", "facts"):
            continue
        lines.append([block["caption"].rstrip(".")])
        if block["kind"] == "table":
            lines.append(block["heads"])
            lines += [[_written(cell, in_head=True) for cell in row] for row in block["rows"]]
        else:
            lines += [[name, _written(cell, in_head=False)] for name, cell in block["rows"]]
        lines.append([])
    return text_of_rows(lines)


def _written(cell: Cell, in_head: bool) -> Any:
    """A number in the unit in which it is shown, with that unit where its text has it; otherwise the text."""
    raw = cell.get("raw")
    unit, size = SHOWN.get(cell.get("unit", "1"), ("", 1.0))
    has_unit = bool(unit) and cell["text"].endswith(f" {unit}")
    in_words = not has_unit and cell["text"].endswith(tuple("abcdefghijklmnopqrstuvwxyz%²³"))
    if not isinstance(raw, int | float) or not in_head or in_words:
        return "" if cell["text"] == "–" else cell["text"]
    shown = raw if size == 1.0 else float(f"{raw * size:.15g}")  # 83.2, not 83.20000000000002
    if has_unit:
        return f"{shown} {unit}"
    return f"{LEAST}{shown}" if cell["text"].startswith(LEAST) else shown
