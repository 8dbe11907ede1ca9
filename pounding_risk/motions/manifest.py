"""The manifest of a study: its records as CSV, one row each, and the check that they are still the same.

>>> import numpy as np
>>> from pounding_risk.motions.manifest import manifest
>>> from pounding_risk.motions.motion import Motion
>>> row = manifest([Motion("r", np.array([0.0, 1.5, -2.0]), 0.01, {"event": "Somewhere", "sha256": "ab"})])[0]
>>> row["PGA [m/s2]"], row["npts"], row["magnitude"]
(2.0, 3, None)
"""

from __future__ import annotations

import csv
import os
from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from io import StringIO
from math import isclose
from pathlib import Path
from typing import Any

from pounding_risk._common.inputs import MANIFEST
from pounding_risk._common.letters import cell, without_mark
from pounding_risk._common.tables import Row, Table, read_table
from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import split_component
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.write import write_text

SEPARATOR = " | "  # between the steps of the processing
AGAIN = "write the manifest again"
SAME = 1e-12  # numbers are written with every digit


def _of_record(key: str) -> Callable[[Motion], Any]:
    return lambda motion: motion.record.get(key)


# What a row holds, and how it is read back.
COLUMNS: dict[str, tuple[Callable[[Motion], Any], type]] = {
    "name": (lambda motion: motion.name, str),
    **{key: (_of_record(key), str) for key in ("source", "file", "sha256", "event", "date")},
    "magnitude": (_of_record("magnitude"), float),
    "distance [km]": (_of_record("distance_km"), float),
    **{key: (_of_record(key), str) for key in ("station", "component")},
    "azimuth [deg]": (_of_record("azimuth"), float),
    "dt [s]": (lambda motion: motion.dt, float),
    "npts": (lambda motion: len(motion.acceleration), int),
    "duration [s]": (lambda motion: motion.duration, float),
    "PGA [m/s2]": (lambda motion: motion.pga, float),
    "factor": (lambda motion: motion.record.get("factor", 1.0), float),
    **{key: (_of_record(key), str) for key in ("state", "origin")},
    "processing": (lambda motion: SEPARATOR.join(motion.processing), str),
}
CHECKED = ("sha256", "dt [s]", "npts", "PGA [m/s2]", "processing")


def manifest(motions: Iterable[Motion]) -> list[dict[str, Any]]:
    """One row for each motion, with the columns of ``COLUMNS``; None where a record does not state a value, or NaN."""
    rows = [{name: value_of(motion) for name, (value_of, _) in COLUMNS.items()} for motion in motions]
    return [{name: None if fact == "" or fact != fact else fact for name, fact in row.items()} for row in rows]


def write_manifest(motions: Iterable[Motion], path: str | Path) -> Path:
    """Write the manifest of motions as CSV in UTF-8, numbers with every digit.

    Parameters
    ----------
    motions : iterable of Motion
        The records, in order.
    path : str or Path
        The file. Sources that are files are written relative to its folder, so that both can move together.

    Returns
    -------
    Path
        The file written; it appears under its name when it is whole.

    Raises
    ------
    RecordError
        Where the file cannot be written.
    """
    target, text = Path(path), StringIO(newline="")
    writer = csv.DictWriter(text, COLUMNS)
    writer.writeheader()
    rows = manifest(motions)
    for row in rows:
        if row["source"] is not None and split_component(row["source"])[0].is_file():  # otherwise an id
            row["source"] = Path(os.path.relpath(row["source"], target.parent)).as_posix()
    writer.writerows({key: cell(fact) for key, fact in row.items()} for row in rows)
    return write_text(target, text.getvalue().encode(), "check the folder")


def source_of(row: Row, cells: Mapping[str, Any]) -> str | Path:
    """The id, or the file with its component, that a row of a manifest names.

    Raises RecordError for a motion that was in memory only, or made of two.
    """
    if cells["source"] is None:
        words = "no source is named, as the motion was in memory or made of two; write it to a file and choose from the"
        raise row.fault(f"{cells['name']}: {words} files")
    file = row.source.parent / cells["source"]
    return file if split_component(file)[0].is_file() else str(cells["source"])


def read_manifest(path: str | Path) -> list[dict[str, Any]]:
    """Read the rows of a file that `write_manifest` wrote.

    Parameters
    ----------
    path : str or Path
        The manifest.

    Returns
    -------
    list of dict
        One row for each record by column: text, numbers in SI, None for an empty cell.

    Raises
    ------
    RecordError
        For a file that cannot be read, other columns, and a value that is no number where one belongs.
    """
    return [cells for _, cells in manifest_rows(Path(path))]


def manifest_rows(path: Path) -> list[tuple[Row, dict[str, Any]]]:
    """Each row of a manifest with its values, as `read_manifest` has them."""
    table = read_table(path, AGAIN, error=RecordError, needed=tuple(COLUMNS), most=MANIFEST, is_ours=True)
    return [(row, {name: _value(table, row, name) for name in COLUMNS}) for row in table.rows]


def _value(table: Table, row: Row, name: str) -> Any:
    """The value of a cell, None of an empty one."""
    text, (_, kind) = row.cells[table.head.index(name)], COLUMNS[name]
    if not text or kind is str:
        return without_mark(text) or None
    return int(table.whole_id(row, name)) if kind is int else table.number(row, name)


def check_manifest(path: str | Path, motions: Iterable[Motion]) -> None:
    """Check that motions are those of a manifest.

    Parameters
    ----------
    path : str or Path
        The manifest.
    motions : iterable of Motion
        The motions; names, checksum of the file, dt, number of samples, PGA and processing are compared.

    Raises
    ------
    RecordError
        Where they differ; the sentence names every difference.
    """
    stated, rows = _by_name(read_manifest(path)), _by_name(manifest(motions))
    faults = [f"{name} is not there" for name in stated if name not in rows]
    faults += [f"{name} is not in the manifest" for name in rows if name not in stated]
    for name in (name for name in stated if name in rows):
        faults += [f"{name}: {words}" for words in _differences(stated[name], rows[name])]
    if faults:
        count = f"{len(faults)} difference{'s' if len(faults) > 1 else ''}"
        raise RecordError(f"{path}: {count} from the records: {'; '.join(faults)}")


def _by_name(rows: Iterable[dict[str, Any]]) -> dict[str, dict[str, Any]]:
    """Rows by the names of their records, numbered where a record is there again, reversed or scaled otherwise."""
    by_name: dict[str, dict[str, Any]] = {}
    times: Counter[str] = Counter()
    for row in rows:
        times[row["name"]] += 1
        again = f" ({times[row['name']]})" if times[row["name"]] > 1 else ""
        by_name[f"{row['name']}{again}"] = row
    return by_name


def _differences(stated: Mapping[str, Any], actual: Mapping[str, Any]) -> list[str]:
    """The differences between two rows, in words."""
    words = []
    for key in CHECKED:
        expected, found_value = stated[key], actual[key]
        numbers = isinstance(expected, float) and isinstance(found_value, float)
        if expected == found_value or (numbers and isclose(expected, found_value, rel_tol=SAME)):
            continue
        if key == "sha256":
            words.append(
                f"the file has sha256 {str(found_value)[:12]}..., the manifest says {str(expected)[:12]}...: "
                "it was changed"
            )
        elif key == "processing":
            words.append("it was processed otherwise")
        else:
            words.append(f"{key} is {found_value}, the manifest says {expected}")
    return words
