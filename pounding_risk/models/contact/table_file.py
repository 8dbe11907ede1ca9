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
    (line, head), *points = _rows(source)
    heads = _heads(head, f"line {line}", source)
    _refuse(
        source,
        *(
            f"line {line}: has {len(cells)} cells, the head has {len(heads)}; write one a column"
            for line, cells in points
            if len(cells) != len(heads)
        ),
    )
    lines = [line for line, _ in points]
    faults: list[tuple[int | None, str]] = []
    columns: dict[str, list[float]] = {name: [] for name, _ in heads}
    for place, (_, cells) in enumerate(points):
        for (name, unit), cell in zip(heads, cells, strict=True):
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


def _refuse(source: str, *sentences: str) -> None:
    """Raise TableError with these faults of a file, where there are any."""
    if sentences:
        raise TableError([(None, sentence) for sentence in sentences], source)


def _rows(source: str) -> list[tuple[int, list[str]]]:
    """The head and the points of a file: line numbers and cells; raises TableError where it is no table."""
    path, text = Path(source), ""
    try:
        text = read_text(path, MOST_BYTES)
    except UnicodeDecodeError as error:
        _refuse(source, f"byte {error.start} is not UTF-8; save the file with that encoding")
    except Unfit as error:
        _refuse(source, f"{error.strerror}; leave points out where it is a table")
    except (OSError, ValueError) as error:
        names = [file.name for file in path.parent.iterdir()] if path.parent.is_dir() else []
        reason = getattr(error, "strerror", None) or error
        _refuse(source, f"cannot be read ({reason}){nearest(path.name, names)}; check the name")
    rows: list[tuple[int, list[str]]] = []
    reader = csv.reader(
        ("\n" if line.startswith("#") else line for line in text.splitlines(keepends=True)), strict=True
    )
    try:
        rows = [(reader.line_num, cells) for cells in reader if any(cell.strip() for cell in cells)]
    except csv.Error as error:
        _refuse(source, f"line {reader.line_num} is not CSV ({error}); {HEAD}")
    if not rows:
        _refuse(source, f"the file is empty; {HEAD}")
    return rows


def _heads(cells: list[str], where: str, source: str) -> list[tuple[str, str]]:
    """Name and unit of each column; raises TableError for those that are none, or not there."""
    if len(cells) == 1 and (";" in cells[0] or "\t" in cells[0]):
        _refuse(source, f"{where}: write commas between columns, and decimal points in numbers")
    heads: dict[str, str] = {}
    faults = []
    for cell in cells:
        match = re.fullmatch(r"\s*(.*?)\s*(?:\[(.*)\])?\s*", cell, re.DOTALL)
        name = " ".join((match[1] if match else cell).lower().split())
        if name not in COLUMNS:
            near = nearest(name, COLUMNS)
            faults.append(f"{where}: {shown(cell)} is no column{near}; it may be {', '.join(COLUMNS)}")
        elif name in heads:
            faults.append(f"{where}: {name} stands twice; leave one of the two out")
        heads[name] = (match[2] or "").strip() if match else ""
    missing = [name for name in ("penetration", "force") if name not in heads]
    if missing and not faults:
        faults.append(f"{where}: no column {' and '.join(missing)}; {HEAD}")
    _refuse(source, *faults)
    return list(heads.items())


def _value(cell: str, unit: str, quantity: Quantity) -> float:
    text = cell.strip()
    if unit and not NUMBER.fullmatch(text):
        raise QuantityError(f"{shown(text)} is not a plain number, and the column's unit is {unit}; write a number")
    return parse(f"{text} {unit}" if unit else text, quantity)
