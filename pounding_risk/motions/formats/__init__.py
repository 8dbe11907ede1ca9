"""Strong-motion files: the formats that are read, how a file's format is recognised, and readers that ObsPy lacks.

A format is a module here that ends with its ``FORMAT``. ``_is_x(file) -> bool`` never raises and is True for its own
files only; ``_read_x(file, headonly=False, **kwargs) -> Stream`` takes a path or an open file and gives m/s² as float64
with ``stats.calib = 1`` and ``stats.record`` (`_text.record_facts`), without samples where ``headonly`` is True, or
raises RecordError.
Two entry points make it known to ObsPy, so that ``obspy.read`` opens such files in any script:

    [project.entry-points."obspy.plugin.waveform"]
    PEER_AT2 = "pounding_risk.motions.formats.peer_at2"
    [project.entry-points."obspy.plugin.waveform.PEER_AT2"]
    isFormat = "pounding_risk.motions.formats.peer_at2:_is_at2"
    readFormat = "pounding_risk.motions.formats.peer_at2:_read_at2"

A format that ObsPy reads by itself is ``native``: its module says what its samples are and how they become m/s².

`read_components` itself never lets ObsPy guess: its detection unpickles a file that looks like one of its own pickles,
which runs whatever code the file holds. Formats are an allow-list, recognised by content.
"""

from __future__ import annotations

import glob
import os
import re
from collections.abc import Callable
from functools import lru_cache
from hashlib import sha256
from importlib import import_module
from io import BytesIO
from pathlib import Path
from pkgutil import iter_modules
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk._common.inputs import cannot_be_read, read_whole
from pounding_risk._common.words import nearest_file
from pounding_risk.errors import RecordError
from pounding_risk.units import PGA, STANDARD_GRAVITY, QuantityError, parse, shown

if TYPE_CHECKING:
    from obspy import Stream, Trace

MOST_ENTRIES = 100_000  # files and folders that a pattern "**" may walk through
LARGEST = 256 * 2**20  # bytes; an hour at 200 Hz has 6 MB
COMPONENT = "#"  # parts the name of a file from that of one of its components
LONGEST_UNIT = 40  # characters; parsing a unit takes the square of them
# How a user says the unit of a file that does not; for messages.
TO_GIVE = 'records.unit = "cm/s^2" in a scene, unit="cm/s^2" in Python, --unit "cm/s^2" on the command line'
# The usual ones, for speed and for the capitals that older programs write.
_USUAL = {"g": STANDARD_GRAVITY, "m/s2": 1.0, "cm/s2": 0.01, "mm/s2": 0.001, "gal": 0.01, "Gal": 0.01, "mps2": 1.0}
_SAME = (("sec", "s"), ("²", "2"), ("**", ""), ("^", ""), ("(", ""), (")", ""), (" ", ""), ("/s/s", "/s2"))


class Format(NamedTuple):
    """A file format: its name, its usual suffixes, how it is recognised and read.

    ``read`` takes an open file and the keywords ``name`` (what messages call the file), ``folder`` (where the file is,
    for what stands beside it), ``unit`` and ``dt`` [s] (what the user says of files that do not say it).
    """

    name: str  # as ObsPy calls it, in capitals
    words: str  # for lists, such as "PEER AT2 (.at2)"
    suffixes: tuple[str, ...]  # in small letters; only for a better message where the content says nothing
    recognises: Callable[[Any], bool]
    read: Callable[..., Stream]
    native: bool = False  # ObsPy reads it by itself, so that it has no entry points of ours
    takes: tuple[str, ...] = ()  # of "unit" and "dt", what its files may leave to the user
    needs: tuple[str, ...] = ()  # of these, what they always do: ObsPy cannot read them by itself, without entry points


class FileRead(NamedTuple):
    """One component of a file: a trace in m/s², whether it is raw or processed, and what was read."""

    trace: Trace
    state: str  # "raw" or "processed"
    format: str
    sha256: str
    units: str  # a sentence: how the samples became m/s²
    component: str  # its name where the file has several, otherwise ""


@lru_cache(maxsize=1)
def formats() -> tuple[Format, ...]:
    """Every format that is read, by name: one a module of this folder."""
    modules = (import_module(f"{__name__}.{module.name}") for module in iter_modules(__path__) if module.name[0] != "_")
    return tuple(sorted(module.FORMAT for module in modules))


def split_component(source: str | Path) -> tuple[Path, str]:
    """File and component of a name such as "quake.V2A#N28W"; a file whose own name has a # is taken as it is."""
    path, _, component = str(source).rpartition(COMPONENT)
    return (Path(path), component) if path and not Path(source).exists() else (Path(source), "")


def matching(folder: Path, pattern: str) -> list[Path]:
    """The files that a name, a pattern or a folder stands for, sorted.

    A file of that very name wins over a pattern; after the name of a file, "#" names one of its components. A folder
    stands for the files in it whose names do not start with a dot.

    Raises RecordError for a pattern ``**`` below which there are more than `MOST_ENTRIES` files and folders.
    """
    literal = folder / pattern
    if literal.is_file():
        return [literal]
    if literal.is_dir():
        return sorted(path for path in literal.iterdir() if path.is_file() and not path.name.startswith("."))
    if "#" in pattern and (folder / pattern.rpartition("#")[0]).is_file():
        return [literal]
    if "**" in pattern:
        above = re.split(r"[*?\[]", pattern, maxsplit=1)[0].rpartition("/")  # up to the last folder without a wildcard
        base, count = folder / (above[0] + above[1]), 0
        for _, folders, names in os.walk(base):
            count += len(folders) + len(names)
            if count > MOST_ENTRIES:
                raise RecordError(
                    f"{pattern}: {base} has more than {MOST_ENTRIES} files and folders below it; name the folder of "
                    'the records, such as files = ["my/records/**/*.AT2"]'
                )
    files = (folder / name for name in glob.glob(pattern, root_dir=folder, recursive=True))
    return sorted(path for path in files if path.is_file())


def _columns() -> Any:
    return import_module(f"{__name__}.columns")


def readable() -> str:
    """The formats that are read, in words."""
    *most, last = (kind.words for kind in formats())
    return f"{', '.join(most)} and {last}"


def read_file(path: Path, component: str = "", *, unit: str | None = None, dt: float | None = None) -> FileRead:
    """One record of a file, in m/s²: its only component, or the one of that name.

    Raises as `read_components`, and RecordError where a file has several components and none, or another, is named.
    """
    components = read_components(path, unit=unit, dt=dt)
    if not component and len(components) == 1:
        return components[0]
    names = [read.component or read.trace.stats.channel for read in components]
    chosen = [read for read, name in zip(components, names, strict=True) if name.lower() == component.lower()]
    if len(chosen) == 1:
        return chosen[0]
    listed = ", ".join(f'"{name}"' for name in names)
    if component:
        raise RecordError(f'{path}: has no component "{component}"; it has {listed}')
    raise RecordError(
        f"{path}: holds {len(components)} components ({listed}), one is needed; name it after {COMPONENT}, such as "
        f"{path.name}{COMPONENT}{names[0]}"
    )


def read_components(path: Path, *, unit: str | None = None, dt: float | None = None) -> tuple[FileRead, ...]:
    """Every component in a file, in m/s², by a format of the allow-list.

    ``unit`` (such as "cm/s^2") and ``dt`` [s] are for files that do not say what their samples are. A format with a
    unit of its own is believed; plain columns that state another one are refused. A MiniSEED or SAC file holds counts,
    so it needs a StationXML file beside it that says what a count is, named as the file itself with ``.xml`` or
    NETWORK.STATION.xml, or else ``unit``.

    Raises RecordError for a missing, empty, unknown or damaged file, gaps, and an unknown unit.
    """
    raw = _bytes(path)
    kind = _format(path, raw, unit is not None or dt is not None)
    stream = kind.read(BytesIO(raw), name=str(path), folder=path.parent, unit=unit, dt=dt)
    traces = _whole(stream, str(path))
    digest = sha256(raw).hexdigest()
    names = _component_names(traces)
    unused_options = [
        word for word, option in (("unit", unit), ("dt", dt)) if option is not None and word not in kind.takes
    ]
    unused = (
        f"; the file states its own, the {' and '.join(unused_options)} given went unused" if unused_options else ""
    )
    return tuple(
        FileRead(trace, trace.stats.record.state, kind.name, digest, trace.stats.record.units + unused, name)
        for trace, name in zip(traces, names, strict=True)
    )


def is_record(path: Path) -> bool:
    """True for a file that one of the formats recognises, by its content or by its name.

    Names of plain columns are names of any text or table, so that such a file starts as plain columns do, or is empty.
    """
    kinds, suffix = formats(), path.suffix.lower()
    columns = _columns()
    if any(suffix in kind.suffixes for kind in kinds if kind is not columns.FORMAT):
        return True
    with path.open("rb") as opened:
        if any(kind.recognises(opened) for kind in kinds):
            return True
        return suffix in columns.FORMAT.suffixes and (not path.stat().st_size or columns.fits(opened))


def _component_names(traces: list[Trace]) -> list[str]:
    """The name of each trace of a file: empty where it is alone, otherwise its component or its whole id."""
    if len(traces) == 1:
        return [""]
    for names in (
        [str(trace.stats.record.get("component") or trace.stats.channel) for trace in traces],
        [trace.id for trace in traces],
    ):
        if all(names) and len({name.lower() for name in names}) == len(names):
            return names
    return [str(number) for number in range(1, len(traces) + 1)]


def _whole(stream: Stream, name: str) -> list[Trace]:
    """The traces of a stream, each in one piece; raises RecordError for none, and for gaps."""
    by_id: dict[str, list[Trace]] = {}
    numbered = len({trace.id for trace in stream}) < len(stream) and all(
        trace.stats.record.get("component") for trace in stream
    )
    for trace in stream:
        key = f"{trace.id} {trace.stats.record.component}" if numbered else trace.id
        by_id.setdefault(key, []).append(trace)
    if not by_id:
        raise RecordError(f"{name}: holds no samples; check the file")
    return [single_trace(pieces, name) for pieces in by_id.values()]


def single_trace(stream: Stream | list[Trace], name: str) -> Trace:
    """The one trace of a stream; raises RecordError for none, several components, gaps, mixed time steps."""
    traces = list(stream)
    if not traces:
        raise RecordError(f"{name}: holds no samples; check the file")
    components = list(dict.fromkeys(trace.id for trace in traces))
    if len(components) > 1:
        raise RecordError(
            f"{name}: holds {len(components)} components ({', '.join(components)}), one is needed; hand over one trace"
        )
    steps = sorted({trace.stats.delta for trace in traces})
    if len(steps) > 1:
        listed = " and ".join(f"{dt:g}" for dt in steps)
        raise RecordError(f"{name}: has time steps of {listed} s in one record; resample it to one before")
    if len(traces) > 1:
        raise RecordError(
            f"{name}: is in {len(traces)} pieces, with gaps or overlaps between them, the first at "
            f"{traces[0].stats.endtime}; cut the piece you want: zeros or a held value in a gap are no motion"
        )
    return traces[0]


def one_trace(source: Any) -> Trace:
    """The trace of an ObsPy trace or stream in memory; raises RecordError for anything else."""
    from obspy import Stream, Trace

    if isinstance(source, Stream):
        return single_trace(source, "the ObsPy stream")
    if not isinstance(source, Trace):
        raise RecordError(
            f"{shown(source)} is not a record; give an id of the catalogue, a path, or an ObsPy trace in m/s²"
        )
    return source


def _bytes(path: Path) -> bytes:
    """The bytes of a file, at most ``LARGEST``."""
    try:
        raw = read_whole(path, LARGEST)
    except IsADirectoryError:
        raise RecordError(f"{path}: is a folder; name a record file in it") from None
    except (FileNotFoundError, NotADirectoryError):
        others = [other.name for other in path.parent.iterdir()] if path.parent.is_dir() else []
        raise RecordError(
            f"{path}: no such record file{nearest_file(path.name, others)}; check the name and the folder"
        ) from None
    except OSError as error:
        raise RecordError(f"{path}: {cannot_be_read(error, 'check its permissions')}") from None
    if not raw:
        raise RecordError(f"{path}: is empty (0 bytes); fetch the record again")
    return raw


def _format(path: Path, raw: bytes, stated: bool) -> Format:
    """The format by content; by extension only where the content says nothing, for a better message.

    Where the caller ``stated`` what samples are, numbers in columns are such samples, whatever the file's name.
    """
    start = raw[:512].lstrip().lower()
    if start.startswith((b"<!doctype html", b"<html")):
        raise RecordError(f"{path}: is a web page, not a record; the download failed: fetch the record again")
    if raw.startswith(b"\x1f\x8b"):
        raise RecordError(f"{path}: is compressed by gzip; unpack it, and take the file that comes out")
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise RecordError(f"{path}: is text in UTF-16; save it as text in UTF-8, in Excel as the type CSV UTF-8")
    if raw[:1] == b"\x80" or b"obspy.core.stream" in raw[:100]:
        raise RecordError(f"{path}: is a Python pickle, which can run code and is never read; {readable()} are read")
    kind = next((candidate for candidate in formats() if candidate.recognises(BytesIO(raw))), None)
    if kind is None:
        # Its reader says what is missing. Files of plain columns say little of themselves.
        kind = next((candidate for candidate in formats() if path.suffix.lower() in candidate.suffixes), None)
        if (kind is None or stated) and _columns().fits(BytesIO(raw)):
            kind = _columns().FORMAT
    if kind is None:
        raise RecordError(
            f"{path}: is not a known record format; {readable()} are read: convert the record to one of them"
        )
    return kind


def known_unit(unit: str) -> float | None:
    """How many m/s² one of a usual unit of acceleration is, in any usual spelling; None for any other text."""
    spelling = unit.strip()
    spelling = spelling.lower() if spelling.isupper() else spelling
    for written, plain in _SAME:
        spelling = spelling.replace(written, plain)
    return _USUAL.get(spelling)


def size_of_unit(unit: object, where: str) -> float:
    """How many m/s² one ``unit`` is; ``where`` begins the message.

    Raises RecordError for what is no unit of acceleration, "" and counts too.
    """
    size = known_unit(unit) if isinstance(unit, str) else None
    if size is not None:
        return size
    try:
        if len(str(unit)) > LONGEST_UNIT:
            raise QuantityError("no unit is so long")
        return parse(f"1 {unit}", PGA)
    except QuantityError:
        words = "".join(letter if letter.isprintable() else "?" for letter in str(unit)[:40])
        raise RecordError(
            f'{where}: "{words}" is not a unit of acceleration; write one such as "g", "cm/s^2" or "m/s^2"'
        ) from None


def unit_sentence(unit: str, size: float) -> str:
    """The sentence on units in the history of a motion: "units: cm/s^2, times 0.01"."""
    return f"units: {unit.strip()}, times {size:.10g}"
