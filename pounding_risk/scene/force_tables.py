"""The key ``table`` of an interface: a file of tabulated forces, or its points written in the scene."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk.models.contact.table import MOST_POINTS, UNLOADING_STIFFNESS, Points, Table, TableError, table_of
from pounding_risk.models.contact.table_file import COLUMNS, read_table
from pounding_risk.scene.keys import Key, Number, Several, Unreadable, each, file_name, options
from pounding_risk.units import Quantity, exact, shown

EXAMPLE = '"bumper.csv"'
POINTS = '{penetration = ["0 mm", "10 mm"], force = ["0 kN", "450 kN"]}'
STIFFENED = '{file = "bumper.csv", unloading_stiffness = "8e7 N/m"}'


class TableFile(NamedTuple):
    """A table that has not been read yet; its file is relative to the scene's folder."""

    file: str
    unloading_stiffness: float | None = None  # N/m

    def read(self, folder: Path) -> Table:
        """The table; raises Several with a sentence for each fault of the file."""
        try:
            return read_table(folder / self.file, self.unloading_stiffness)
        except TableError as error:
            raise Several([((), f"{self.file}: {sentence}") for sentence in error.sentences]) from None


def _read(value: Any, number: Number) -> Table | TableFile:
    """The name of a file, a table with it, or one with the points."""
    if isinstance(value, Table | TableFile):
        return value
    if isinstance(value, str) and value.strip():
        return TableFile(value)
    if not isinstance(value, Mapping):
        raise Unreadable(f"{shown(value)} is no table of forces; write the file, {EXAMPLE}, {STIFFENED}, or {POINTS}")
    kinds: dict[str, Callable[[Any], Any]] = {
        name: partial(_column, quantity=quantity, number=number) for name, quantity in COLUMNS.items()
    }
    kinds |= {
        "unloading_stiffness": lambda cell: number(cell, UNLOADING_STIFFNESS),
        "file": lambda cell: file_name(cell, EXAMPLE),
    }
    needed = ("file",) if "file" in value else ("penetration", "force")
    takes = "a table takes file, or penetration, force and unloading; and unloading_stiffness"
    columns = options(value, kinds, needed, lambda name: f"missing; write {POINTS}", takes)
    if "file" in columns:
        if repeats := [name for name in COLUMNS if name in columns]:
            raise Several([((name,), "the file has the points; remove one of the two") for name in repeats])
        return TableFile(**columns)
    try:
        return table_of(**columns)
    except TableError as error:
        raise Several([((), sentence) for sentence in error.sentences]) from None


def _column(value: Any, quantity: Quantity, number: Number) -> list[float]:
    if not isinstance(value, list) or len(value) > MOST_POINTS:
        raise Unreadable(f"{shown(value)} is not a list of up to {MOST_POINTS} values; write {POINTS}")
    return each(value, lambda cell: number(cell, quantity))


def _write(table: Table | TableFile | None) -> Any:
    """As a scene file has it; points exactly."""
    if isinstance(table, TableFile):
        stiffness = table.unloading_stiffness
        return table.file if stiffness is None else {"file": table.file, **_stiffness(stiffness)}
    if table is None:
        return table
    points: Points = table.points
    columns = {name: getattr(points, name) for name in COLUMNS}
    cells = {
        name: [exact(number, COLUMNS[name]) for number in numbers]
        for name, numbers in columns.items()
        if numbers is not None
    }
    return cells if points.unloading_stiffness is None else cells | _stiffness(points.unloading_stiffness)


def _stiffness(stiffness: float) -> dict[str, Any]:
    return {"unloading_stiffness": exact(stiffness, UNLOADING_STIFFNESS)}


FORCE_TABLE = Key(
    "Force against penetration, for tabulated: a CSV file beside the scene with the columns penetration [mm], force "
    f"[kN] and, where it has its own way back, unloading [kN]; {STIFFENED}; or the points, {POINTS}.",
    _read,
    EXAMPLE,
    "required by tabulated",
    write=_write,
    schema={"anyOf": [{"type": "string"}, {"type": "object"}]},
)
