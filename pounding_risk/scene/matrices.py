"""Keys of buildings that are given by matrices or modes: values written in a scene, or a file beside it."""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.inputs import Unfit, text_of
from pounding_risk._common.tables import Row, read_table, split_unit
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.matrices import ModeTable
from pounding_risk.models.structures.storeys import MOST_STOREYS
from pounding_risk.scene.keys import Key, Number, Several, Unreadable, each, facts, file_name, list_of, options
from pounding_risk.units import DAMPING, FLOOR_MASS, PERIOD, Quantity, QuantityError, exact, parse_cell, shown, si

Matrix = tuple[tuple[float, ...], ...]
MOST_ROWS = 5 * MOST_STOREYS
MOST_BYTES = 50_000_000
# A row of a matrix may have any sign; a diagonal is checked where the matrix is put together.
OF_STIFFNESS = Quantity("N/m", -np.inf, np.inf, "stiffness", example="40 MN/m")
OF_DASHPOTS = Quantity("N s/m", -np.inf, np.inf, "dashpot", example="200 kN s/m")
OF_MASSES = Quantity("kg", -np.inf, np.inf, "mass", example="200 t")
FREQUENCY = Quantity("Hz", 0.0, np.inf, "frequency", open_low=True, open_high=True, example="1.5 Hz")
ORDINATE = Quantity("1", -np.inf, np.inf, "mode shape", example="1.0")
MODES_HEAD = "period [s],floor 1,floor 2,..."
MODES_INLINE = '{period = ["0.60 s", "0.20 s"], shape = [[0.6, 1.0], [1.0, -0.6]]}'


class MatrixFile(NamedTuple):
    """A matrix in a file that has not been read yet."""

    file: str
    scale: float  # from the file's unit to SI

    def read(self, folder: Path) -> Matrix:
        """The matrix in SI; raises Several for a file that has none."""
        path = folder / self.file
        try:
            numbers = _array_of(path) if path.suffix.lower() in (".npy", ".npz") else _numbers_of(path)
        except (Unfit, PoundingError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise Several([((), f"{self.file}: {reason}")]) from None
        with np.errstate(over="ignore"):  # what is no finite number in N/m is refused with its row and column
            return tuple(tuple(row) for row in (self.scale * numbers).tolist())


class ModesFile(NamedTuple):
    """A table of modes in a file that has not been read yet."""

    file: str

    def read(self, folder: Path) -> ModeTable:
        """The modes; raises Several for a file that has none."""
        try:
            return _modes_of(folder / self.file)
        except PoundingError as error:
            raise Several([((), str(error))]) from None


def _numbers_of(path: Path) -> NDArray[np.float64]:
    """A matrix of text: a row a line, numbers between commas or blanks; lines that start with # are comments."""
    rows: list[list[float]] = []
    for number, line in enumerate(text_of(path, MOST_BYTES).splitlines(), start=1):
        if not line.strip() or line.lstrip().startswith("#"):
            continue
        cells = [cell for cell in re.split(r"[,;\s]+", line.strip()) if cell]
        try:
            rows.append([float(cell) for cell in cells])
        except ValueError:
            raise PoundingError(
                f"line {number}: is no row of numbers; write a row of the matrix a line, without a head"
            ) from None
        if len(rows[-1]) != len(rows[0]):
            raise PoundingError(f"line {number}: has {len(rows[-1])} numbers, the first row has {len(rows[0])}")
        if len(rows) > MOST_ROWS:
            raise PoundingError(f"has more than {MOST_ROWS} rows; condense the model to its floors")
    if not rows:
        raise PoundingError("the file has no numbers; write a row of the matrix a line")
    return np.array(rows)


def _array_of(path: Path) -> NDArray[np.float64]:
    """The array of a file of NumPy; of several the only one that is a matrix."""
    try:
        with path.open("rb") as file:
            loaded = np.load(file, allow_pickle=False)
            arrays = [loaded] if isinstance(loaded, np.ndarray) else [loaded[name] for name in loaded.files]
    except FileNotFoundError:
        raise PoundingError("no such file; files are relative to the scene file's folder") from None
    except (OSError, ValueError, EOFError, KeyError) as error:
        raise PoundingError(f"is no file of NumPy ({type(error).__name__}); save the matrix again") from None
    arrays = [array for array in arrays if array.ndim == 2 and array.dtype.kind in "fiu"]
    if len(arrays) != 1 or max(arrays[0].shape) > MOST_ROWS:
        raise PoundingError(f"has {len(arrays)} matrices; save one, of {MOST_ROWS} rows at most")
    return np.asarray(arrays[0], dtype=float)


def _modes_of(path: Path) -> ModeTable:
    """The modes of a CSV file: a row a mode, columns period or frequency, damping, effective mass, floor 1 to N."""
    table = read_table(path, f"write a head such as '{MODES_HEAD}'", error=PoundingError, most=MOST_BYTES)
    columns: dict[str, list[float]] = {}
    for index, head in enumerate(table.head):
        head_name, unit = split_unit(head)
        name = " ".join(head_name.lower().replace("_", " ").split())
        floor = re.fullmatch(r"floor ([0-9]{1,3})", name)
        quantity = ORDINATE if floor else MODE_COLUMNS.get(name)
        if quantity is None or name in columns:
            flaw = "stands twice" if quantity else "is no column of modes"
            raise table.head_row.fault(
                f"{shown(head)} {flaw}; columns are period or frequency, damping, effective mass, floor 1, floor 2 "
                "and so on"
            )
        columns[name] = [_cell(row, row.cells[index], unit, quantity, head) for row in table.rows]
    periods = columns.get("period") or [1.0 / frequency for frequency in columns.get("frequency", ())]
    floors = [f"floor {number}" for number in range(1, 1 + sum(name.startswith("floor ") for name in columns))]
    if not periods or not floors or not set(floors) <= set(columns) or {"period", "frequency"} <= set(columns):
        raise table.head_row.fault(f"needs one of period and frequency, and a column for each floor: '{MODES_HEAD}'")
    return ModeTable(
        tuple(periods),
        tuple(zip(*(columns[name] for name in floors), strict=True)),
        tuple(columns.get("damping", ())),
        tuple(columns.get("effective mass", ())),
    )


def _cell(row: Row, cell: str, unit: str, quantity: Quantity, head: str) -> float:
    try:
        return parse_cell(cell, unit, quantity)
    except QuantityError as error:
        raise row.fault(f"{head}: {error}") from None


def rows_key(words: str, example: str, absent: str) -> Key:
    """Rows of a matrix, counted from 1, each once."""

    def read(value: Any, number: Number) -> tuple[int, ...]:
        rows = tuple(list_of(value, f"rows of the matrix, such as {example}"))
        if not all(type(row) is int and row > 0 for row in rows) or len(set(rows)) < len(rows):
            raise Unreadable(f"{shown(value)} does not name rows; write whole numbers from 1 on, each once")
        return rows

    return Key(words, read, example, absent, write=list, schema={"type": "array", "items": {"type": "integer"}})


def interior_key(words: str, example: str, absent: str) -> Key:
    """Masses of interior modes, of any sign."""

    def read(value: Any, number: Number) -> tuple[float, ...]:
        masses = list_of(value, f"a mass for each interior mode, such as {example}")
        return tuple(each(masses, lambda entry: number(entry, OF_MASSES)))

    def write(masses: tuple[float, ...]) -> list[Any]:
        return [exact(mass, OF_MASSES) for mass in masses]

    return Key(words, read, example, absent, write=write, schema={"type": "array", **facts(OF_MASSES)})


MODE_COLUMNS: dict[str, Quantity] = {
    "period": PERIOD,
    "frequency": FREQUENCY,
    "damping": DAMPING,
    "effective mass": FLOOR_MASS,
}


def matrix_key(name: str, quantity: Quantity, words: str, unit: str, absent: str) -> Key:
    """A symmetric matrix over the floors: rows with their unit, or a file with it."""
    in_file = f'{{file = "{name[0].upper()}.csv", unit = "{unit}"}}'
    inline = f'{{values = [[2, -1], [-1, 1]], unit = "{unit}"}}'

    def read(value: Any, number: Number) -> Matrix | MatrixFile:
        if isinstance(value, list) and number is si:
            value = {"values": value, "unit": quantity.unit}
        if not isinstance(value, Mapping):
            raise Unreadable(f"{shown(value)} is no matrix with its unit; write {in_file}, or {inline}")
        kinds = {"values": _rows, "unit": lambda cell: _scale(cell, quantity)}
        kinds |= {"file": lambda cell: file_name(cell, '"K.csv"')}
        source = "values" if "values" in value else "file"
        table = options(
            value, kinds, (source, "unit"), lambda key: f"missing; write {in_file}", "it takes file or values, and unit"
        )
        if "file" in table and "values" in table:
            raise Unreadable("file and values are both given; remove one of the two")
        if "file" in table:
            return MatrixFile(table["file"], table["unit"])
        return tuple(tuple(table["unit"] * cell for cell in row) for row in table["values"])

    def write(value: Matrix | MatrixFile) -> Any:
        if isinstance(value, MatrixFile):
            return {"file": value.file, "unit": f"{value.scale!r} {quantity.unit}"}
        return {"values": [list(row) for row in value], "unit": quantity.unit}

    return Key(words, read, in_file, absent, write=write, schema={"type": "object"})


def _scale(value: Any, quantity: Quantity) -> float:
    """SI of one of a unit, such as 1000 for kN/m; a number may stand before the unit."""
    if not isinstance(value, str):
        raise Unreadable(f'{shown(value)} is no unit; write such as "kN/m"')
    text = value if re.match(r"\s*[0-9.]", value) else f"1 {value}"
    return si(text, quantity)


def _rows(value: Any) -> list[tuple[float, ...]]:
    rows = list_of(value, "rows such as [[2, -1], [-1, 1]]")
    return each(rows, lambda row: tuple(each(list_of(row, "a row such as [2, -1]"), _number)))


def _number(value: Any) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise Unreadable(f"{shown(value)} is not a number; the unit of all stands in unit")
    return float(value)


def _read_modes(value: Any, number: Number) -> ModeTable | ModesFile:
    if isinstance(value, ModeTable | ModesFile):
        return value
    if isinstance(value, str) and value.strip():
        return ModesFile(value)
    if not isinstance(value, Mapping):
        raise Unreadable(f'{shown(value)} has no modes; write a file, "modes.csv", or {MODES_INLINE}')

    def several(quantity: Quantity) -> Any:
        return lambda cells: tuple(
            each(list_of(cells, f"a list such as [{shown(quantity.example)}]"), lambda cell: number(cell, quantity))
        )

    kinds = {
        "period": several(PERIOD),
        "shape": lambda cells: tuple(_rows(cells)),
        "damping": several(DAMPING),
        "effective_mass": several(FLOOR_MASS),
    }
    takes = "modes take period, shape, damping and effective_mass, each a list with one for each mode"
    modes = options(value, kinds, ("period", "shape"), lambda key: f"missing; write {MODES_INLINE}", takes)
    table = ModeTable(modes["period"], modes["shape"], modes.get("damping", ()), modes.get("effective_mass", ()))
    flaws = [key for key, column in modes.items() if len(column) != len(table.periods)]
    if flaws:
        raise Unreadable(f"{len(modes[flaws[0]])} of {flaws[0]} for {len(table.periods)} periods; {takes}")
    return table


def _write_modes(modes: ModeTable | ModesFile) -> Any:
    if isinstance(modes, ModesFile):
        return modes.file
    written: dict[str, Any] = {
        "period": [f"{period!r} s" for period in modes.periods],
        "shape": [list(shape) for shape in modes.shapes],
        "damping": list(modes.dampings),
        "effective_mass": [f"{mass!r} kg" for mass in modes.effective_masses],
    }
    return {key: column for key, column in written.items() if column}


MODES = Key(
    f"Its modes: a CSV file beside the scene with the head '{MODES_HEAD}', a row a mode, and, where they are known, "
    f"the columns damping and effective mass [t]; or {MODES_INLINE}.",
    _read_modes,
    '"modes.csv"',
    "a single mass",
    write=_write_modes,
    schema={"type": ["string", "object"]},
)
