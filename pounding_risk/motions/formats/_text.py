"""What the text formats share: lines, tables of numbers in columns, facts of a header, checks against it, by line.

A reader takes its header apart, and hands samples, factor and facts to `trace_of`. Whatever a header states twice, or
of its samples, is compared: their number (`check_count`), the time step (`check_step`), the length (`check_length`) and
the largest sample (`check_peak`).
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from functools import wraps
from math import isfinite
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from obspy import Trace
from obspy.core import AttribDict

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import LARGEST

SHORTEST_STEP, LONGEST_STEP = 1e-6, 1.0  # s; anything else is a damaged header
LONGEST_NUMBER = 64  # characters; no program writes more, and the search takes the square of them
START = 8192  # bytes from which a format is recognised
NEWLINE = re.compile(r"\r\n|\r|\n")
NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)(?:[EeDd][+-]?\d+)?"
# What `stats.record` of a reader may hold, beside what is particular to its format.
FACTS = {
    *("event", "magnitude", "date", "distance_km", "station", "component", "azimuth", "state", "units"),
    *("low_corner", "high_corner", "header_pga", "header_pgv", "header_pgd", "timed", "sensor", "vertical", "doubt"),
}

_SAMPLE = re.compile(NUMBER, re.ASCII)


def record_facts(*, state: str, units: str, **facts: Any) -> AttribDict:
    """``stats.record`` of a trace: the facts of a header under the names that every reader uses.

    ``state`` is "raw" or "processed"; ``units`` the sentence that says how the samples became m/s². ``azimuth`` is in
    degrees clockwise from north, None for a vertical; corners in Hz; ``header_pga``, ``header_pgv`` and ``header_pgd``
    are the header's own peaks in m/s², m/s and m. ``timed`` is False where ``stats.starttime`` is not when the record
    starts; ``sensor`` distinguishes the sensors of one station; ``vertical`` is True of a component that is known to
    be, whatever its name; ``doubt`` is a sentence of the file about the record. Facts that a header lacks are left out.
    """
    unknown = set(facts) - FACTS
    if unknown:
        raise TypeError(f"no such facts of a record: {', '.join(sorted(unknown))}")
    return AttribDict({"state": state, "units": units, **facts})


def trace_of(
    samples: NDArray[np.float64] | int, factor: float, dt: float, record: AttribDict, start: Any = None, **stats: Any
) -> Trace:
    """A trace in m/s² of samples times a ``factor``, or without samples where only their number is handed over.

    ``dt`` is the time step [s], ``start`` the time of the first sample, None where it is unknown, ``stats`` what else
    ObsPy shall know: network, station, location, channel, and the facts that are particular to a format.
    """
    header = {"delta": dt, "calib": 1.0, "record": record, **stats, **({} if start is None else {"starttime": start})}
    if isinstance(samples, int):
        return Trace(header={**header, "npts": samples})
    return Trace(samples * factor, header=header)


def recogniser(size: int = START) -> Callable[[Callable[[str], bool]], Callable[[Any], bool]]:
    """Turn a test of a file's first ``size`` characters into ``isFormat`` of ObsPy's plugins.

    It takes a path or an open file, whose position is left where it was, and returns False instead of raising.
    """

    def of_file(test: Callable[[str], bool]) -> Callable[[Any], bool]:
        @wraps(test)
        def recognises(file: Any) -> bool:
            try:
                if hasattr(file, "read"):
                    position = file.tell()
                    start = file.read(size)
                    file.seek(position)
                else:
                    with Path(file).open("rb") as opened:
                        start = opened.read(size)
                return test(start.decode("latin-1") if isinstance(start, bytes) else str(start))
            except Exception:
                return False

        return recognises

    return of_file


def text_of(file: Any, name: str, kind: str) -> tuple[str, str]:
    """Name and text of a file, decoded as latin-1, in which every byte has a meaning.

    ``kind`` is the format in words, for messages, such as "PEER AT2". Raises RecordError for a file that cannot be
    read, is too large or is blank.
    """
    if hasattr(file, "read"):
        file_name = getattr(file, "name", None)
        name = name or (str(file_name) if isinstance(file_name, str | Path) else f"{kind} record")
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
        state = "is blank" if text else "is empty (0 bytes)"
        raise RecordError(f"{name}: {state}; a {kind} file has a header and samples: fetch it again")
    return name, text


def number(word: str) -> float | None:
    """A plain finite number, Fortran's D exponents included; None for anything else, "nan" and "1_0" too."""
    if len(word) > LONGEST_NUMBER or not _SAMPLE.fullmatch(word):
        return None
    parsed = float(word.replace("D", "E").replace("d", "e"))
    return parsed if isfinite(parsed) else None


def free_numbers(name: str, lines: Sequence[str], first: int, example: str) -> NDArray[np.float64]:
    """The numbers of lines, parted by blanks; ``first`` is the index of the first of these lines in the file.

    Raises RecordError, naming the line, for a word that is no finite number.
    """
    words = ((at, word) for at, line in enumerate(lines) for word in line.split())
    return numbers(name, words, first, example, "the samples after the header must be")


def fixed_numbers(
    name: str, lines: Sequence[str], first: int, width: int, example: str, what: str = "samples after the header"
) -> NDArray[np.float64]:
    """The numbers of lines in columns of ``width`` characters, as Fortran writes them, which may touch.

    ``what`` says what they are. Raises RecordError, naming the line, for a column that is no finite number.
    """
    lines = [line.rstrip() for line in lines]
    raw = "".join(lines).encode("latin-1", "replace")
    # Full columns are read in one call. NumPy reads a word as Python's float() does; what that takes beside plain
    # numbers needs other characters.
    if raw and not raw.translate(None, b"0123456789+-.eE ") and not any(len(line) % width for line in lines):
        with suppress(ValueError):
            parsed = np.frombuffer(raw, dtype=f"S{width}").astype(np.float64)
            if np.isfinite(parsed).all():
                return parsed
    words = (
        (at, line[column : column + width].strip())
        for at, line in enumerate(lines)
        for column in range(0, len(line), width)
    )
    return numbers(name, words, first, example, f"the {what} must be")


def numbers(name: str, words: Iterable[tuple[int, str]], first: int, example: str, must: str) -> NDArray[np.float64]:
    """The numbers of words, each with the line that it stands in, counted from that of the index ``first``.

    Raises RecordError, naming the line, for one that is no finite number; ``must`` says there what has to be numbers.
    """
    parsed: list[float] = []
    for at, word in words:
        sample = number(word)
        if sample is None:
            raise RecordError(
                f"{name}, line {first + at + 1}: {quoted(word)} is not a finite number; {must} "
                f"plain numbers such as {example}: repair that line, or fetch the file again"
            )
        parsed.append(sample)
    return np.array(parsed, dtype=np.float64)


FEWEST_ALIKE = 10  # numbers before the last one that say how a program writes them


def check_last(name: str, text: str, words: Sequence[str]) -> None:
    """Raise RecordError where a text ends within a line, and its last number as a number that was cut does.

    That one has fewer decimals than every number before it, or a shorter exponent than the ten before it have, or none.
    A zero has no digits to lose, and a text that ends with a line is whole.
    """
    *before, last = (_DIGITS.fullmatch(word) for word in words) if text == text.rstrip() else (None,)
    if last is None or len(before) < FEWEST_ALIKE or None in before or not number(words[-1]):
        return

    def digits(part: str, among: Iterable[Any]) -> int:
        return min(len(match[part] or "") for match in among)

    if digits("decimals", [last]) < digits("decimals", before) or (
        digits("exponent", [last]) < digits("exponent", before[-FEWEST_ALIKE:])
    ):
        raise RecordError(
            f"{name}: ends within a line, with {quoted(words[-1])} after {quoted(words[-2])}: the last number is cut; "
            "fetch the file again, or end its last line if it is whole"
        )


def check_count(where: str, promised: int, count: int, count_name: str) -> None:
    """Raise RecordError where a file has another number of samples than ``count_name`` of its header says."""
    if count != promised:
        cut = "the file is cut short: fetch it again"
        repair = cut if count < promised else f"correct {count_name}, or fetch the file again"
        raise RecordError(f"{where}: the header promises {promised} samples, {count} found; {repair}")


def check_step(where: str, dt: float | None, word: str, name: str = "DT") -> float:
    """The time step [s]; raises RecordError where it is no number in range."""
    if dt is None or not SHORTEST_STEP <= dt <= LONGEST_STEP:
        raise RecordError(
            f"{where}: {name} is {quoted(word)}; the time step must be a number of seconds greater than 0, "
            f"from {SHORTEST_STEP:g} to {LONGEST_STEP:g} s: restore that line, or fetch the file again"
        )
    return dt


def whole_count(where: str, word: str, name: str) -> int:
    """The number of samples of a header; raises RecordError where it is no whole number of two or more."""
    if not re.fullmatch(r"[+-]?\d{1,15}", word, re.ASCII):
        raise RecordError(f"{where}: {name} is {quoted(word)}; it must be a whole number of samples")
    if int(word) < 2:
        raise RecordError(f"{where}: {name} is {int(word)}; a record needs at least 2 samples")
    return int(word)


def check_promised(where: str, count: int) -> None:
    """Raise RecordError for fewer than two samples."""
    if count < 2:
        raise RecordError(f"{where}: promises {count} samples; a record needs at least 2: fetch the file again")


def check_length(where: str, count: int, dt: float, stated: float | None, slack: float, by: str) -> None:
    """Raise RecordError where the length [s] that a header states ``by`` some words is not that of its samples.

    It may be n dt or (n - 1) dt; ``slack`` [s] is for the digits it is printed with, and for whatever the agencies do.
    """
    if stated is not None and not (count - 1) * dt - slack <= stated <= count * dt + slack:
        raise RecordError(
            f"{where}: {count} samples every {dt:g} s last {count * dt:g} s, {by} says {stated:g} s; correct the wrong "
            "one, or fetch the file again"
        )


@contextmanager
def time_of_header(sentence: str) -> Iterator[None]:
    """Raise RecordError with the sentence where numbers of a header are no time: a thirteenth month, or the like."""
    try:
        yield
    except (ValueError, TypeError, OverflowError):
        raise RecordError(sentence) from None


def quoted(text: str) -> str:
    """Text of a file for a message: in quotes, shortened and printable."""
    shown = "".join(letter if letter.isprintable() else "?" for letter in text.strip())
    return f'"{shown}"' if len(shown) <= 40 else f'"{shown[:37]}..."'


PADDING = "\0\x1a \r\n"  # fills the last block of a file, of DOS and others
LONGEST_LINE = 2000  # characters; looking for words in a line takes a time that grows with its square
LONGEST_GAP = 0.05  # s between samples at uneven times; a straight line over more is no record
END = re.compile(r"\s*(?:end.of.data|/&)", re.I)  # starts the line that ends a channel
_CHANNELS = re.compile(r"\(\s*(\d{1,3})\s+chns\s+of\b", re.I)
_COLUMNS = re.compile(
    r"\(\s*(\d{1,3})\s*\(?\s*(?:1?P,?)?\s*[IFEDG]\s*(\d{1,2})(?:\.\d{1,2})?(?:E\d?)?\s*\)?\s*\)", re.I
)


class Columns(NamedTuple):
    """The layout of numbers by Fortran: how many on a line, and the characters of each."""

    each: int
    width: int


def columns_of(text: str) -> Columns | None:
    """The columns that a format in parentheses, such as (8F10.5) or (1E15.6), stands for; None for no such format."""
    match = _COLUMNS.search(text)
    columns = Columns(int(match[1]), int(match[2])) if match else None
    return columns if columns and min(columns) > 0 else None


class Lines:
    """The lines of a file, with the position that the reading has reached.

    ``name`` is what messages call the file, ``at`` how many lines are behind. Raises RecordError for a line that is
    longer than any of these formats has.
    """

    def __init__(self, name: str, text: str):
        self.name = name
        self.at = 0
        self._lines = NEWLINE.split(text.rstrip(PADDING))
        long = next((at for at, line in enumerate(self._lines, start=1) if len(line) > LONGEST_LINE), None)
        if long is not None:
            raise RecordError(
                f"{name}, line {long}: has {len(self._lines[long - 1])} characters, {LONGEST_LINE} at most are read; "
                "restore its line ends, or fetch the file again"
            )

    @property
    def place(self) -> str:
        """File and number of the line last taken."""
        return f"{self.name}, line {self.at}"

    @property
    def ahead(self) -> str:
        """The next line, not taken; empty at the end of the file."""
        return self._lines[self.at] if self.at < len(self._lines) else ""

    def ended(self) -> bool:
        """True where nothing but blank lines is left; blank lines are passed over."""
        while self.at < len(self._lines) and not self._lines[self.at].strip():
            self.at += 1
        return self.at == len(self._lines)

    def take(self, count: int, what: str) -> list[str]:
        """The next ``count`` lines; raises RecordError where the file ends before them."""
        if self.at + count > len(self._lines):
            raise RecordError(
                f"{self.name}: ends at line {len(self._lines)}, where {what} should be; the file is cut short: "
                "fetch it again"
            )
        self.at += count
        return self._lines[self.at - count : self.at]

    def table(self, count: int, columns: Columns, example: str, what: str) -> NDArray[np.float64]:
        """The next ``count`` numbers, in columns, on as many lines as that takes.

        ``what`` says in messages what they are. Raises RecordError where there are fewer or more on these lines, and
        where one is no finite number.
        """
        promise, first = self.place, self.at
        lines = self._lines[first : first + -(-count // columns.each)]
        # What ends a channel ends it before its time where lines are missing.
        end = next((at for at, line in enumerate(lines) if END.match(line)), None)
        lines = lines if end is None else lines[:end]
        wide = columns.each * columns.width
        for at, line in enumerate(lines, start=first + 1):
            if len(line) > wide and line[wide:].strip():
                raise RecordError(
                    f"{self.name}, line {at}: has {quoted(line[wide:])} after its {columns.each} columns of "
                    f"{columns.width} characters; repair that line, or fetch the file again"
                )
        samples = fixed_numbers(self.name, [line[:wide] for line in lines], first, columns.width, example, what)
        if len(samples) != count:
            cut = "the file is cut short: fetch it again"
            repair = cut if len(samples) < count else "correct that number, or fetch the file again"
            raise RecordError(f"{promise}: {count} {what} should follow, {len(samples)} found; {repair}")
        # Fortran writes numbers to the right end of their columns. A line that ends within one lost or gained a
        # character: its numbers may still be numbers, with other digits.
        for at, line in enumerate(lines, start=first + 1):
            if len(line.rstrip()) % columns.width:
                raise RecordError(
                    f"{self.name}, line {at}: ends after {len(line.rstrip())} characters, within a column of "
                    f"{columns.width}, so that some were lost or put in; repair that line, or fetch the file again"
                )
        self.at += len(lines)
        return samples

    def end_channel(self, due: str) -> None:
        """Take the line that ends a channel, which the last one of a file may lack; ``due`` is its text."""
        if not self.ended() and not END.match(self.take(1, "the end of the channel")[0]):
            raise RecordError(
                f"{self.place}: {quoted(self._lines[self.at - 1])} follows the last promised sample, where {due} "
                "should be; correct the number of samples, or fetch the file again"
            )

    def word(self, at: int, columns: Columns, number: int) -> tuple[str, str]:
        """A number of a table as text, counted from 1, with file and line; ``at`` lines of the file are before it."""
        row, column = divmod(number - 1, columns.each)
        start = column * columns.width
        return self._lines[at + row][start : start + columns.width], f"{self.name}, line {at + row + 1}"


def channel_code(dt: float, azimuth: float | None, vertical: bool) -> str:
    """The SEED code of a channel: the band by the time step, N for an accelerometer, the direction."""
    band = "H" if dt <= 1.0 / 80.0 else "B"  # of the FDSN, from 80 Hz on and below
    directions = {0.0: "N", 90.0: "E", 360.0: "N"}
    direction = "Z" if vertical else directions.get(-1.0 if azimuth is None else azimuth, "")
    return f"{band}N{direction}"


def numbered(traces: list[Trace], numbers: list[str]) -> list[Trace]:
    """Give each component of a file a name of its own: shared names are followed by the channel's number.

    ``numbers`` are the channels' own; where they are no different numbers, the channels are counted.
    """
    if len({number for number in numbers if number.isdigit()}) < len(traces):
        numbers = [str(number) for number in range(1, len(traces) + 1)]
    shared = Counter(trace.stats.record.component.lower() for trace in traces)
    for trace, number in zip(traces, numbers, strict=True):
        component = trace.stats.record.component
        if shared[component.lower()] > 1 or not component:
            trace.stats.record.component = f"{component} channel {number}".strip()
    return traces


def note_missing_channels(traces: list[Trace], line: str, channels: int) -> None:
    """Say in the history of each trace where a file has fewer channels than the line "(3 Chns of 12 at Sta)" promises.

    Agencies cut such files into channels too, so that one of three is no damage for certain.
    """
    promised = _CHANNELS.search(line)
    if promised and int(promised[1]) > channels:
        for trace in traces:
            trace.stats.record.units += f"; the header states {int(promised[1])} channels, the file holds {channels}"


class Even(NamedTuple):
    """Samples at even times, their step [s], and what was done for it, in words that follow the unit's."""

    samples: NDArray[np.float64]
    dt: float
    words: str
    digitised: NDArray[np.float64]  # the samples of the file itself, at whatever times


def even_samples(
    where: str, pairs: NDArray[np.float64], dt: float | None, rounding: float | NDArray[np.float64]
) -> Even:
    """Samples at even times, from pairs of time [s] and value as records of film have them.

    Times that are even but for the ``rounding`` [s] of their digits, of each or of all, are taken as even. Others are
    read at every ``dt`` [s] off the straight lines between them; of times that are the same in their digits the last
    counts. Raises RecordError where they are uneven and ``dt`` is not given, and for times that fall, that leave a gap
    longer than ``LONGEST_GAP``, or that are all the same.
    """
    times, samples = pairs[0::2], pairs[1::2]
    steps = np.diff(times)
    worst = int(np.argmin(steps)) if steps.min() < 0.0 else int(np.argmax(steps))
    if steps.min() < 0.0 or not 0.0 < steps[worst] <= LONGEST_GAP:
        raise RecordError(
            f"{where}: after the time {times[worst]:g} s comes {times[worst + 1]:g} s; times must rise, by at most "
            f"{LONGEST_GAP:g} s: take the corrected file of this record, or cut it there and hand it over in columns"
        )
    mean = float(times[-1] - times[0]) / len(steps)
    if np.all(np.abs(times - times[0] - mean * np.arange(len(times))) <= rounding):
        return Even(samples, check_step(where, mean, f"{mean:g}", "the step of the times"), "", samples)
    if dt is None:
        raise RecordError(
            f"{where}: holds pairs of times and accelerations, at steps from {steps.min():.3g} to {steps.max():.3g} s; "
            'give the even step at which to read them: records.dt = "0.005 s" in a scene, dt=0.005 in Python, '
            '--dt "0.005 s" on the command line, or take the corrected file of this record'
        )
    check_step(where, dt, f"{dt:g}", "dt as given")
    count = int((times[-1] - times[0]) / dt * (1.0 + 1e-12)) + 1
    if count < 2:
        raise RecordError(f"{where}: dt as given, {dt:g} s, leaves no two samples of {times[-1] - times[0]:g} s")
    last = np.append(steps > 0.0, True)
    even = np.interp(times[0] + dt * np.arange(count), times[last], samples[last])
    return Even(even, dt, f", uneven times read at every {dt:g} s", samples)


# Agencies convert with 980, 980.665 or 981 cm/s² in one g, which differ by 1.02e-3; in the 27 real
# components of the tests the two agree within the digits that are printed.
CONVERSION = 1.1e-3
MOST_DECIMALS = 9  # of samples in fixed columns

_DIGITS = re.compile(r"[+-]?\d*\.?(?P<decimals>\d*)(?:[EeDd](?P<exponent>[+-]?\d+))?", re.ASCII)


class StatedPeak(NamedTuple):
    """The largest acceleration that a header states, without its sign, and where it does."""

    value: float  # in the header's unit
    rounding: float  # half of the last digit printed, in that unit
    unit: str
    size: float  # m/s² in one of that unit; 1 where samples are compared in the unit of the file
    place: str  # file and line


def stated_peak(word: str, unit: str, size: float, where: str) -> StatedPeak | None:
    """The peak of a header's number as text; None where it is no number, or zero, which stands for not evaluated."""
    peak = number(word.strip())
    return StatedPeak(abs(peak), half_digit(word.strip()), unit, size, where) if peak else None


def half_digit(word: str) -> float:
    """Half of the last digit that a number is printed with: 0.0005 of -.058."""
    match = _DIGITS.fullmatch(word)
    if match is None:
        raise ValueError(f"{word!r} is not a number")
    return 0.5 * 10.0 ** (int(match["exponent"] or 0) - len(match["decimals"]))


def check_peak(
    samples: NDArray[np.float64], *readings: StatedPeak | None, relative: float = CONVERSION
) -> StatedPeak | None:
    """Raise RecordError where the largest of the samples, or of the samples less their mean, is not the stated one.

    Samples are in m/s², or in the file's unit where ``StatedPeak.size`` is 1. ``readings`` are what the header's number
    may mean, of which one must fit and is returned; None, and nothing checked, where one of them is None: not stated.
    ``relative`` is how far the two may differ beyond the rounding of header and samples, as a share of the peak. The
    error names file, line and both peaks.
    """
    if not readings or None in readings:
        return None
    stated = [peak for peak in readings if peak is not None]
    with np.errstate(over="ignore", invalid="ignore"):
        largest = float(np.abs(samples).max())
        less_mean = float(np.abs(samples - samples.mean()).max())
    for peak in stated:
        allowed = (peak.rounding + relative * peak.value) * peak.size
        off = min(abs(one - peak.value * peak.size) for one in (largest, less_mean))
        if off <= allowed or off - allowed <= _half_digit_of_samples(samples / peak.size) * peak.size:
            return peak
    first = stated[0]
    raise RecordError(
        f"{first.place}: the header says that the largest sample is {first.value:.6g} {first.unit}, it is "
        f"{largest / first.size:.6g}; samples or header are damaged: fetch the file again"
    )


def _half_digit_of_samples(samples: NDArray[np.float64]) -> float:
    """Half of the last decimal that samples in fixed columns were printed with; 0 where they were not."""
    with np.errstate(over="ignore", invalid="ignore"):
        for decimals in range(MOST_DECIMALS + 1):
            scaled = np.abs(samples) * 10.0**decimals
            # A float has about 16 digits, of which units took some.
            if np.abs(scaled - np.rint(scaled)).max() <= 1e-10 * scaled.max():
                return 0.5 * 10.0**-decimals
    return 0.0
