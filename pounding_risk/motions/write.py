"""A motion as a file that other programs read, and this package too: plain columns in m/s², or PEER AT2 in g."""

from __future__ import annotations

import os
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from pounding_risk._common.files import check_target
from pounding_risk.errors import PoundingError
from pounding_risk.units import STANDARD_GRAVITY

if TYPE_CHECKING:
    from pounding_risk.motions.motion import Motion

SUFFIXES = (".csv", ".at2")
A_LINE = 5  # samples of an AT2 file


def write_motion(motion: Motion, path: str | Path) -> Path:
    """Write a motion under a temporary name and move it into place; the suffix says as what.

    ``.csv``: time [s] and acceleration [m/s²] with every digit, below the facts and the steps, so that the very
    samples are read again (`formats.columns`). ``.at2``: acceleration in g with eight digits, as PEER writes it;
    whoever reads it again takes it for a processed record. Raises PoundingError for another suffix, and for a place
    that cannot be written.
    """
    target = check_target(path, SUFFIXES)
    if target.suffix.lower() == ".csv":
        from pounding_risk.motions.formats.columns import write_columns

        return write_columns(motion, target)
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        partial.write_text("\n".join([*_at2(motion), ""]), encoding="latin-1", errors="replace")
        os.replace(partial, target)
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    finally:
        partial.unlink(missing_ok=True)
    return target


def _at2(motion: Motion) -> Iterator[str]:
    record = motion.record
    parts = (record.get("event"), _american(record.get("date")), record.get("station"), record.get("component"))
    yield "PEER AT2 RECORD, WRITTEN BY POUNDING_RISK"
    yield ", ".join(_line(part or "") for part in parts)
    yield "ACCELERATION TIME SERIES IN UNITS OF G"
    yield f"NPTS= {len(motion.acceleration)}, DT= {motion.dt!r} SEC"
    values = motion.acceleration / STANDARD_GRAVITY
    for start in range(0, len(values), A_LINE):
        yield "".join(f"{value:15.7E}" for value in values[start : start + A_LINE])


def _american(day: object) -> str:
    """Month/day/year, as PEER writes a date; what is none is left as it is."""
    try:
        day_found = date.fromisoformat(str(day))
    except ValueError:
        return str(day or "")
    return f"{day_found.month}/{day_found.day}/{day_found.year}"


def _line(words: object) -> str:
    """Words on one line."""
    return " ".join(str(words).split())
