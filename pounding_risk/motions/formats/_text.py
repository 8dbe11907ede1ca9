"""What the readers of text formats share: bytes to lines, numbers that are numbers, and the words of a refusal."""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from obspy.core import AttribDict

from pounding_risk.errors import RecordError

LARGEST = 256 * 2**20  # bytes; the longest records of the databases have some megabytes
SHORTEST_STEP, LONGEST_STEP = 1e-6, 1.0  # s; anything else is a damaged header
LONGEST_NUMBER = 64  # characters; no program writes more, and the search takes the square of them
START = 8192  # bytes that tell a format
NEWLINE = re.compile(r"\r\n|\r|\n")
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"
# What `stats.record` of a reader may hold, beside what is particular to its format.
FACTS = {
    *("event", "magnitude", "date", "distance_km", "station", "component", "azimuth", "state", "units"),
    *("low_corner", "high_corner", "header_pga", "header_pgv", "header_pgd", "timed", "sensor"),
}

_SAMPLE = re.compile(NUMBER, re.ASCII)


def told(*, state: str, units: str, **facts: Any) -> AttribDict:
    """``stats.record`` of a trace: the facts of a header under the names that every reader uses.

    ``state`` is "raw" or "processed"; ``units`` the sentence that says how the samples became m/s². ``azimuth`` is in
    degrees clockwise from north, None for a vertical; corners in Hz; ``header_pga``, ``header_pgv`` and ``header_pgd``
    are the header's own peaks in m/s², m/s and m. ``timed`` is False where ``stats.starttime`` is not when the record
    starts; ``sensor`` tells those of one station apart. What a header does not know is left out.
    """
    unknown = set(facts) - FACTS
    if unknown:
        raise TypeError(f"no such facts of a record: {', '.join(sorted(unknown))}")
    return AttribDict({"state": state, "units": units, **facts})


def start_of(file: Any, size: int = START) -> str:
    """The first characters of a path or of an open file, whose position is left where it was."""
    if hasattr(file, "read"):
        place = file.tell()
        start = file.read(size)
        file.seek(place)
    else:
        with Path(file).open("rb") as opened:
            start = opened.read(size)
    return start.decode("latin-1") if isinstance(start, bytes) else str(start)


def text_of(file: Any, name: str, kind: str) -> tuple[str, str]:
    """Name and text of a file; every byte has a meaning in latin-1, so none stops the reading here.

    ``kind`` is the format in words, for messages, such as "PEER AT2". Raises RecordError for a file that cannot be
    read, is too large or is blank.
    """
    if hasattr(file, "read"):
        given = getattr(file, "name", None)
        name = name or (str(given) if isinstance(given, str | Path) else f"{kind} record")
        raw = file.read(LARGEST + 1)
    else:
        name = name or str(file)
        try:
            with Path(file).open("rb") as opened:
                raw = opened.read(LARGEST + 1)
        except OSError as error:
            raise RecordError(f"{name}: cannot be read ({error.strerror}); check name and folder") from None
    if len(raw) > LARGEST:
        raise RecordError(
            f"{name}: is larger than {LARGEST >> 20} MiB, far more than any {kind} record; check the file"
        )
    text = raw.decode("latin-1") if isinstance(raw, bytes) else str(raw)
    if not text.strip():
        what = "is blank" if text else "is empty (0 bytes)"
        raise RecordError(f"{name}: {what}; a {kind} file has a header and samples: fetch it again")
    return name, text


def number(word: str) -> float | None:
    """A plain finite number, Fortran's D exponents included; None for anything else, "nan" and "1_0" too."""
    if len(word) > LONGEST_NUMBER or not _SAMPLE.fullmatch(word):
        return None
    value = float(word.replace("D", "E").replace("d", "e"))
    return value if isfinite(value) else None


def free_numbers(name: str, lines: Sequence[str], first: int, example: str) -> NDArray[np.float64]:
    """The numbers of lines, parted by blanks; ``first`` is the index of the first of these lines in the file.

    Raises RecordError, naming the line, for a word that is no finite number.
    """
    return _numbers(name, ((at, word) for at, line in enumerate(lines) for word in line.split()), first, example)


def fixed_numbers(
    name: str, lines: Sequence[str], first: int, width: int, example: str, what: str = "samples after the header"
) -> NDArray[np.float64]:
    """The numbers of lines in columns of ``width`` characters, as Fortran writes them, which may touch.

    ``what`` says what they are. Raises RecordError, naming the line, for a column that is no finite number.
    """
    lines = [line.rstrip() for line in lines]
    values = _plain_columns(lines, width)
    if values is None:
        words = (
            (at, line[place : place + width].strip())
            for at, line in enumerate(lines)
            for place in range(0, len(line), width)
        )
        values = _numbers(name, words, first, example, what)
    return values


def _plain_columns(lines: Sequence[str], width: int) -> NDArray[np.float64] | None:
    """The numbers of lines whose columns are all full, in one go; None where a closer look is needed.

    NumPy reads a word as Python's float() does; what that takes beside plain numbers needs other characters.
    """
    if any(len(line) % width for line in lines):
        return None
    raw = "".join(lines).encode("latin-1", "replace")
    if not raw or raw.translate(None, b"0123456789+-.eE "):
        return None
    try:
        values = np.frombuffer(raw, dtype=f"S{width}").astype(np.float64)
    except ValueError:
        return None
    return values if np.isfinite(values).all() else None


def _numbers(
    name: str, words: Iterator[tuple[int, str]], first: int, example: str, what: str = "samples after the header"
) -> NDArray[np.float64]:
    values: list[float] = []
    for at, word in words:
        value = number(word)
        if value is None:
            raise RecordError(
                f"{name}, line {first + at + 1}: {quoted(word)} is not a finite number; the {what} "
                f"must be plain numbers such as {example}: repair that line, or fetch the file again"
            )
        values.append(value)
    return np.array(values, dtype=np.float64)


def check_count(place: str, promised: int, found: int, count_name: str) -> None:
    """Raise RecordError where a file has another number of samples than ``count_name`` of its header says."""
    if found != promised:
        cut = "the file is cut short: fetch it again"
        repair = cut if found < promised else f"correct {count_name}, or fetch the file again"
        raise RecordError(f"{place}: the header promises {promised} samples, {found} found; {repair}")


def check_step(place: str, dt: float | None, word: str, name: str = "DT") -> float:
    """The time step [s]; raises RecordError where it is no number in range."""
    if dt is None or not SHORTEST_STEP <= dt <= LONGEST_STEP:
        raise RecordError(
            f"{place}: {name} is {quoted(word)}; the time step must be a number of seconds greater than 0, "
            f"from {SHORTEST_STEP:g} to {LONGEST_STEP:g} s: restore that line, or fetch the file again"
        )
    return dt


def quoted(text: str) -> str:
    """Text of a file for a message, shortened and printable."""
    shown = "".join(letter if letter.isprintable() else "?" for letter in text.strip())
    return f'"{shown}"' if len(shown) <= 40 else f'"{shown[:37]}..."'
