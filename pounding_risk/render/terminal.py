"""Sheets and tables on standard output: aligned columns of words and of numbers in engineering units.

On a terminal nothing is cut at any width; through a pipe every row is one line.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Iterator, Sequence
from itertools import zip_longest
from math import inf, isfinite, isnan
from shutil import get_terminal_size
from typing import TYPE_CHECKING, NamedTuple
from unicodedata import category, east_asian_width

from pounding_risk.units import Quantity, say, say_in

if TYPE_CHECKING:
    from pounding_risk.render.sheet import Block

BETWEEN = 2  # blanks between two columns of a table
NARROWEST_WORDS = 16  # columns of a terminal below which a column of sentences is no longer read with ease
SPEEDS = "m/s"
NO_WIDTH = ("Mn", "Me", "Cf")  # kinds of letters that a terminal draws over the one before, or not at all


class Measure(str):
    """Text of a number that keeps its value and SI unit, so that a column can be printed in one unit."""

    value: float
    unit: str
    digits: int


def engineering(value: float, unit: str, digits: int = 4) -> str:
    """A number in SI ``unit`` in engineering units: 1300 kN, 3.2 mm, 0.5 g, 0.5 m/s; – for NaN."""
    measure = Measure(_measure_text(value, unit, digits))
    measure.value, measure.unit, measure.digits = value, unit, digits
    return measure


def in_one_unit(cells: Sequence[str]) -> list[str]:
    """Cells of a column, their measures in the engineering unit of the measure of median size.

    Cells stay as they are where they measure different quantities, or speeds, or numbers without a unit.
    """
    measures = [cell for cell in cells if isinstance(cell, Measure) and isfinite(cell.value)]
    sizes = sorted((measure for measure in measures if measure.value != 0.0), key=lambda measure: abs(measure.value))
    if not sizes or len({measure.unit for measure in measures}) != 1 or sizes[0].unit in ("1", SPEEDS):
        return list(cells)
    name = sizes[len(sizes) // 2].partition(" ")[2]
    return [
        say_in(cell.value, name, cell.digits) if isinstance(cell, Measure) and isfinite(cell.value) else cell
        for cell in cells
    ]


def _measure_text(value: float, unit: str, digits: int) -> str:
    if isnan(value):
        return "–"
    if unit == "m/s2":
        unit = "m/s^2"  # in g
    elif unit == SPEEDS:
        return f"{value:.{digits}g} m/s"
    return say(value, Quantity(unit, -inf, inf, ""), digits)


def print_table(heads: Sequence[str], rows: Iterable[Sequence[str]], sides: str) -> None:
    """Print columns under their heads, if any is not empty; nothing is cut at any width of the terminal.

    ``sides`` has a letter for each column: "l" for words, flush left, "r" for numbers, flush right and never broken.
    Where the table is wider than the terminal, heads and cells of words are wrapped. Where that does not suffice, each
    row is printed as a block with one line a column. Piped output is never wrapped.
    """
    cells = [list(row) for row in rows]
    columns = []
    for index, (head, side) in enumerate(zip(heads, sides, strict=True)):
        column = [row[index] for row in cells]
        columns.append(Column(head, side, in_one_unit(column) if side == "r" else column))
    widths = [column.widest for column in columns]
    screen = get_terminal_size().columns
    if sys.stdout.isatty():
        widths = _fitted_widths(columns, screen)
    lines = _table_lines(columns, widths) if widths else _block_lines(columns, screen)
    print("\n".join(line.rstrip() for line in lines))


class Column(NamedTuple):
    """A column of a table: its head, its side ("l" words, "r" numbers) and its cells."""

    head: str
    side: str
    cells: list[str]

    @property
    def widest(self) -> int:
        """Width of the widest cell, or of the head [columns of the terminal]."""
        return max(map(_width, [self.head, *self.cells]))

    @property
    def narrowest(self) -> int:
        """Width below which the column cannot be read: whole words, and whole cells of numbers."""
        if self.side == "l":
            words = " ".join([self.head, *self.cells]).split(" ")
            return max(min(self.widest, NARROWEST_WORDS), *map(_width, words))
        return max(map(_width, [*self.head.split(" "), *self.cells]))


def _width(text: str) -> int:
    """Width of a text on a terminal [columns]; a Chinese or Japanese letter takes two, an accent of its own none."""
    if text.isascii():
        return len(text)
    return sum(0 if category(letter) in NO_WIDTH else 1 + (east_asian_width(letter) in "WF") for letter in text)


def _fitted_widths(columns: Sequence[Column], width: int) -> list[int]:
    """Widths at which the columns fit a terminal, narrow columns unwrapped; [] where none do."""
    room = width - BETWEEN * (len(columns) - 1)
    narrowest, widest = [column.narrowest for column in columns], [column.widest for column in columns]
    fitted: list[int] = []
    for limit in range(max(widest) + 1):
        widths = [min(wide, max(narrow, limit)) for narrow, wide in zip(narrowest, widest, strict=True)]
        if sum(widths) > room:
            break
        fitted = widths
    return fitted


def _table_lines(columns: Sequence[Column], widths: Sequence[int]) -> Iterator[str]:
    rows = list(zip(*(column.cells for column in columns), strict=True))
    heads = [column.head for column in columns]
    for row in ([heads] if any(heads) else []) + rows:
        lines_of_cells = [_wrapped(cell, width) for cell, width in zip(row, widths, strict=True)]
        if row is heads:  # heads stand on their columns
            most_lines = max(map(len, lines_of_cells))
            lines_of_cells = [[""] * (most_lines - len(lines)) + lines for lines in lines_of_cells]
        for parts in zip_longest(*lines_of_cells, fillvalue=""):
            yield (" " * BETWEEN).join(
                _padded(part, width, column.side) for part, width, column in zip(parts, widths, columns, strict=True)
            )


def _block_lines(columns: Sequence[Column], width: int) -> Iterator[str]:
    """Lines of the table turned into a block for each row: its first cell, then a line for each other column."""
    first, *other_columns = columns
    label_width = max((_width(column.head) for column in other_columns), default=0)
    for index, title in enumerate(first.cells):
        if index:
            yield ""
        yield from _wrapped(f"{first.head}: {title}" if first.head else title, width)
        for column in other_columns:
            indent = 2 + (label_width + 2 if label_width else 0)
            cell = column.cells[index]
            lines = [cell] if column.side == "r" else _wrapped(cell, max(width - indent, 1))
            head = f"  {_padded(column.head, label_width, 'l')}  " if label_width else "  "
            yield head + lines[0]
            yield from (" " * indent + line for line in lines[1:])


def _wrapped(text: str, width: int) -> list[str]:
    """Lines of whole words; a word longer than the width gets a line of its own."""
    lines: list[str] = []
    for word in text.split(" ") if _width(text) > width else [text]:
        if lines and _width(lines[-1]) + 1 + _width(word) <= width:
            lines[-1] += f" {word}"
        else:
            lines.append(word)
    return lines


def _padded(text: str, width: int, side: str) -> str:
    room = " " * (width - _width(text))
    return text + room if side == "l" else room + text


def print_pairs(pairs: Iterable[tuple[str, str]]) -> None:
    """Print a line for each pair of a label and its words."""
    print_table(("", ""), pairs, "ll")


def print_sheet(blocks: Iterable[Block]) -> None:
    """Print the blocks of a sheet, a blank line between them; figures are left to the files that are asked for."""
    shown = [block for block in blocks if block["kind"] != "figure" and (block["kind"] != "list" or block["items"])]
    for index, block in enumerate(shown):
        if index:
            print()
        _PRINTERS[block["kind"]](block)


def _print_table_block(block: Block) -> None:
    from pounding_risk.render.sheet import LONG

    print(f"{block['caption'].rstrip('.')}\n")
    rows, keep = block["rows"], block["keep"]
    is_cut = bool(block["note"]) and len(rows) > max(LONG, len(keep))
    shown_rows = [rows[index] for index in keep] if is_cut else rows
    print_table(block["heads"], [[cell["text"] for cell in row] for row in shown_rows], block["sides"])
    if is_cut:
        print(f"{len(shown_rows)} of {len(rows)} rows: {block['note']}")


def _print_facts(block: Block) -> None:
    if block["caption"]:
        print(f"{block['caption'].rstrip('.')}\n")
    print_pairs((name, cell["text"]) for name, cell in block["rows"])


def _print_verdict(block: Block) -> None:
    print(f"{block['sentence']}\n")
    print("\n".join(f"  {sentence}" for sentence in block["conclusion"]))


_PRINTERS: dict[str, Callable[[Block], None]] = {
    "paragraph": lambda block: print(block["text"]),
    "heading": lambda block: print(block["text"]),
    "source": lambda block: print(f"{block['caption']}\n\n{block['text']}"),
    "verdict": _print_verdict,
    "list": lambda block: print("\n".join(f"{block['mark']}{item}" for item in block["items"])),
    "table": _print_table_block,
    "facts": _print_facts,
}


def one_line(words: object) -> str:
    """Words without line breaks and repeated blanks."""
    return " ".join(str(words).split())


def print_notes(notes: Iterable[str], prefix: str = "") -> None:
    """Print a line for each note, with a prefix such as "excluded: "."""
    for note in notes:
        print(f"note: {prefix}{note}")


def print_left_out(sentences: Iterable[str]) -> None:
    """Print a line for each record, file or component that is left out."""
    print_notes(sentences, "excluded: ")
