"""A motion as a file that other programs read, and this package too: CSV in m/s², or PEER AT2 in g."""

from __future__ import annotations

import os
from collections.abc import Iterator
from datetime import date
from pathlib import Path
from typing import TYPE_CHECKING

from pounding_risk.errors import PoundingError
from pounding_risk.processing import STEPS
from pounding_risk.quantities import STANDARD_GRAVITY

if TYPE_CHECKING:
    from pounding_risk.motions import Motion

SUFFIXES = (".csv", ".at2")
TOLD = ("id", "event", "date", "station", "component", "file", "sha256", "origin", "terms")
HARMLESS = "window"  # a step after which a raw record is still raw
A_LINE = 5  # samples of an AT2 file


def write_motion(motion: Motion, path: str | Path) -> Path:
    """Write a motion under a temporary name and move it into place; the suffix says as what.

    ``.csv``: facts and processing steps as comments, then time [s] and acceleration [m/s²], every digit, so that the
    very samples are read again. ``.at2``: acceleration in g with eight digits, as PEER writes it; whoever reads it
    again takes it for a processed record. Raises PoundingError for another suffix, and for a place that cannot be
    written.
    """
    from pounding_risk.results import check_target

    target = check_target(path, SUFFIXES)
    lines, encoding = (_csv(motion), "utf-8") if target.suffix.lower() == ".csv" else (_at2(motion), "latin-1")
    partial = target.with_name(f".{target.name}.{os.getpid()}.partial")
    try:
        partial.write_text("\n".join([*lines, ""]), encoding=encoding, errors="replace")
        os.replace(partial, target)
    except OSError as error:
        raise PoundingError(f"{target}: cannot be written ({error.strerror}); choose another place") from None
    finally:
        partial.unlink(missing_ok=True)
    return target


def state(motion: Motion) -> str:
    """What a motion is once it is a file: raw only where its record is, and no step but a cut was done to it."""
    done = {sentence.partition(":")[0] for sentence in motion.processing}
    return "processed" if done & (set(STEPS) - {HARMLESS}) else str(motion.record.get("state", "processed"))


def _csv(motion: Motion) -> Iterator[str]:
    yield f"# state: {state(motion)}"
    for key in TOLD:
        if motion.record.get(key):
            yield f"# {key}: {_line(motion.record[key])}"
    yield from (f"# step: {_line(sentence)}" for sentence in motion.processing)
    yield f"# dt = {motion.dt!r} s"
    yield "time [s],acceleration [m/s^2]"
    yield from (f"{k * motion.dt:.10g},{float(value)!r}" for k, value in enumerate(motion.acceleration))


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
        found = date.fromisoformat(str(day))
    except ValueError:
        return str(day or "")
    return f"{found.month}/{found.day}/{found.year}"


def _line(words: object) -> str:
    """Words on one line."""
    return " ".join(str(words).split())
