"""Files of tabulated forces: CSV in, a checked table out, with all faults by line at once.

A column is named with its unit, ``force [kN]``, or its cells have theirs, ``450 kN``; a unit is never guessed. Lines
that start with # are left out.
"""

from __future__ import annotations

from os import PathLike
from pathlib import Path

from pounding_risk._common.inputs import Unfit, text_of
from pounding_risk._common.tables import csv_rows, split_unit, uneven
from pounding_risk._common.words import nearest
from pounding_risk.models.contact.table import FORCE, PENETRATION, Table, TableError, table_of
from pounding_risk.units import Quantity, QuantityError, parse_cell, shown

COLUMNS: dict[str, Quantity] = {"penetration": PENETRATION, "force": FORCE, "unloading": FORCE}
HEAD = "write a head such as 'penetration [mm],force [kN],unloading [kN]', the last only where it has its own way back"
MOST_BYTES = 1_000_000

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
    faults: list[str] = []
    try:
        rows = csv_rows(text_of(Path(source), MOST_BYTES), faults, HEAD)
    except Unfit as error:
        raise TableError([(None, str(error.strerror))], source) from None
    heads = _heads(rows[0][1], f"line {rows[0][0]}", faults) if rows else []
    points = rows[1:]
    if not faults:
        faults += [f"line {line}: {words}" for line, cells in points if (words := uneven(cells, heads))]
    columns: dict[str, list[float]] = {name: [] for name, _ in heads}
    for line, cells in points if not faults else ():
        for (name, unit), cell in zip(heads, cells, strict=True):
            try:
                columns[name].append(parse_cell(cell, unit, COLUMNS[name]))
            except QuantityError as error:
                faults.append(f"line {line}: {name}: {error}")
    if faults:
        raise TableError([(None, fault) for fault in faults], source)
    try:
        return table_of(columns["penetration"], columns["force"], columns.get("unloading"), unloading_stiffness)
    except TableError as error:
        raise TableError(error.faults, source, [line for line, _ in points]) from None


def _heads(cells: list[str], where: str, faults: list[str]) -> Heads:
    """Name and unit of each column; faults for those that are none, or not there."""
    heads: Heads = []
    for cell in cells:
        stated, unit = split_unit(cell)
        name = " ".join(stated.lower().split())
        if name not in COLUMNS:
            near = nearest(name, COLUMNS)
            faults.append(f"{where}: {shown(cell)} is no column{near}; it may be {', '.join(COLUMNS)}")
        elif name in dict(heads):
            faults.append(f"{where}: {name} stands twice; leave one of the two out")
        heads.append((name, unit))
    missing = [name for name in ("penetration", "force") if name not in dict(heads)]
    if missing and not faults:
        faults.append(f"{where}: no column {' and '.join(missing)}; {HEAD}")
    return heads
