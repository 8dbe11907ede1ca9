"""Files of tabulated forces: CSV in, a checked table out, with all faults by line at once.

A column is named with its unit, ``force [kN]``, or its cells have theirs, ``450 kN``; a unit is never guessed. Lines
that start with # are left out.
"""

from __future__ import annotations

import csv
import re
from os import PathLike
from pathlib import Path

from pounding_risk._common.inputs import Unfit, read_text
from pounding_risk._common.words import nearest
from pounding_risk.models.contact.table import FORCE, PENETRATION, Table, TableError, table_of
from pounding_risk.units import Quantity, QuantityError, parse, shown

COLUMNS: dict[str, Quantity] = {"penetration": PENETRATION, "force": FORCE, "unloading": FORCE}
HEAD = "write a head such as 'penetration [mm],force [kN],unloading [kN]', the last only where it has its own way back"
MOST_BYTES = 1_000_000
NUMBER = re.compile(r"[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?")

Fault = tuple[int | None, str]
Heads = list[tuple[str, str]]  # name and unit of each column


def read_table(path: str | PathLike[str], unloading_stiffness: float | str | None = None) -> Table:
    """The table of a CSV file.

    Parameters
    ----------
    path : str or path
        The file, with columns penetration, force and, where it has its own way back, unloading.
    unloading_stiffness : float or str, optional
        Slope of the way back [N/m], in place of that column.

    Returns
    -------
    Table

    Raises
    ------
    TableError
        With every fault and its line.
    """
    source = str(path)
    faults: list[Fault] = []
    lines, heads, cells = _cells(source, faults)
    columns: dict[str, list[float]] = {name: [] for name, _ in heads}
    for place, row in enumerate(cells):
        for (name, unit), cell in zip(heads, row, strict=True):
            try:
                columns[name].append(_value(cell, unit, COLUMNS[name]))
            except QuantityError as error:
                faults.append((place, f"{name}: {error}"))
    if faults:
        raise TableError(faults, source, lines)
    try:
        return table_of(columns["penetration"], columns["force"], columns.get("unloading"), unloading_stiffness)
    except TableError as error:
        raise TableError(error.faults, source, lines) from None


def _cells(source: str, faults: list[Fault]) -> tuple[list[int], Heads, list[list[str]]]:
    """Line numbers, heads and cells of the points; empty where the file is no table."""
    text = _text(source, faults)
    rows: list[tuple[int, list[str]]] = []
    reader = csv.reader(
        ("\n" if line.startswith("#") else line for line in text.splitlines(keepends=True)), strict=True
    )
    try:
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        faults.append((None, f"line {reader.line_num} is not CSV ({error}); {HEAD}"))
    if faults or not rows:
        faults += [] if faults else [(None, f"the file is empty; {HEAD}")]
        return [], [], []
    heads = _heads(rows[0][1], f"line {rows[0][0]}", faults)
    points = rows[1:]
    uneven = [
        (None, f"line {line}: has {len(cells)} cells, the head has {len(heads)}; write one a column")
        for line, cells in points
        if len(cells) != len(heads)
    ]
    faults += [] if faults else uneven
    return [line for line, _ in points], heads, [] if faults else [cells for _, cells in points]


def _text(source: str, faults: list[Fault]) -> str:
    path = Path(source)
    try:
        return read_text(path, MOST_BYTES)
    except UnicodeDecodeError as error:
        faults.append((None, f"byte {error.start} is not UTF-8; save the file with that encoding"))
    except Unfit as error:
        faults.append((None, f"{error.strerror}; leave points out where it is a table"))
    except (OSError, ValueError) as error:
        names = [file.name for file in path.parent.iterdir()] if path.parent.is_dir() else []
        reason = getattr(error, "strerror", None) or error
        faults.append((None, f"cannot be read ({reason}){nearest(path.name, names)}; check the name"))
    return ""


def _heads(cells: list[str], where: str, faults: list[Fault]) -> Heads:
    """Name and unit of each column; faults for those that are none, or not there."""
    if len(cells) == 1 and (";" in cells[0] or "\t" in cells[0]):
        faults.append((None, f"{where}: write commas between columns, and decimal points in numbers"))
        return []
    heads: Heads = []
    for cell in cells:
        parted = re.fullmatch(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", cell, re.DOTALL)
        name = " ".join((parted[1] if parted else cell).lower().split())
        if name not in COLUMNS:
            near = nearest(name, COLUMNS)
            faults.append((None, f"{where}: {shown(cell)} is no column{near}; it may be {', '.join(COLUMNS)}"))
        elif name in dict(heads):
            faults.append((None, f"{where}: {name} stands twice; leave one of the two out"))
        heads.append((name, (parted[2] or "").strip() if parted else ""))
    missing = [name for name in ("penetration", "force") if name not in dict(heads)]
    if missing and not faults:
        faults.append((None, f"{where}: no column {' and '.join(missing)}; {HEAD}"))
    return heads


def _value(cell: str, unit: str, quantity: Quantity) -> float:
    text = cell.strip()
    if unit and not NUMBER.fullmatch(text):
        raise QuantityError(f"{shown(text)} is not a plain number, and the column's unit is {unit}; write a number")
    return parse(f"{text} {unit}" if unit else text, quantity)
