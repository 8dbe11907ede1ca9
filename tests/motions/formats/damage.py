"""Damaged files for every format: how they are made, and what must come of each. Run as a script, it reports in lines.

    python damage.py COUNT [FORMAT ...]

Compiled readers may crash or hang at damaged bytes, so that the many run in a process of their own, with a time limit.
Whole records take up to 20 ms each; these short ones, real headers above few samples, take one or two.
"""

from __future__ import annotations

import faulthandler
import json
import random
import re
import struct
import sys
import tempfile
from collections.abc import Iterator
from io import BytesIO
from pathlib import Path

import numpy as np
import obspy

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.formats import Format, formats, read_components
from pounding_risk.motions.formats._text import LONGEST_STEP, SHORTEST_STEP

OBSPY = Path(obspy.__file__).parent / "io"
KNET = OBSPY / "nied/tests/data/test.knet"
EVTS = tuple(sorted((OBSPY / "kinemetrics/tests/data").glob("B*.evt")))
THROUGH_A_FILE = 10  # every tenth is read from disk, by the format that its content or its name tells
PROMISED = {  # samples, by the header as this module reads it
    "ESM": lambda raw: re.search(rb"\nNDATA\s*:\s*(\d+)", raw)[1],
    "GEONET": lambda raw: 43,
    "PEER_AT2": lambda raw: re.search(rb"NPTS\s*=\s*(\+?\d+)", raw, re.IGNORECASE)[1],
}
# Numbers that a damaged header may hold.
NUMBERS = (b"0", b"-1", b"1", b"2", b"7", b"1e9", b"1e999", b"nan", b"99999999", b"-0.5", b"1e-9", b"0x10", b"1_0", b"")


# --- short files ------------------------------------------------------------------------------------------


def short_files() -> dict[str, list[bytes]]:
    """Short files of each format that are read without complaint, by its name."""
    from test_columns import ONE, TWO
    from test_cosmos import GOOD as COSMOS
    from test_csmip import ONE as UNCORRECTED
    from test_csmip import TWO as CORRECTED
    from test_esm import SMALL as ESM
    from test_geonet import SMALL_CORRECTED, SMALL_RAW
    from test_smc import GOOD as SMC

    at2 = b"\n".join(catalogue.read_bytes("RSN6-180").split(b"\n")[: 4 + 20]).replace(b"5372", b" 100")
    return {
        "COLUMNS": [f"# samples = 3\n# starttime = 2019-07-06\n{text}".encode() for text in (ONE, TWO)],
        "COSMOS": [COSMOS.encode()],
        "CSMIP": [UNCORRECTED.encode(), CORRECTED.encode()],
        "ESM": [ESM],
        "GEONET": [SMALL_CORRECTED, SMALL_RAW],
        "KINEMETRICS_EVT": [short_evt(EVTS[0])],
        "KNET": [short_knet()],
        "MSEED": list(short_mseed()),
        "PEER_AT2": [at2],
        "SAC": [written(whole_numbers(150), "SAC"), written(whole_numbers(150), "SAC", byteorder=">")],
        "SIMCENTER": [short_simcenter(1), short_simcenter(None)],
        "SMC": [SMC.encode()],
    }


def originals(name: str) -> list[bytes]:
    """The short files of a format, and one that is read at a step that the user gives."""
    from test_csmip import TIMES, VALUES, film

    return [*short_files()[name], *([film(TIMES, VALUES).encode()] if name == "CSMIP" else [])]


def short_simcenter(indent: int | None) -> bytes:
    """A motion of 40 samples and two components, with and without line breaks."""
    x, y = ([round(size * np.sin(0.7 * at) * np.exp(-0.05 * at), 6) for at in range(40)] for size in (0.3, -0.2))
    peaks = {"PGA_x": max(x), "PGA_y": max(map(abs, y))}
    return json.dumps({"name": "GM1-7", "dT": 0.02, "data_x": x, "data_y": y, **peaks}, indent=indent).encode()


def short_knet() -> bytes:
    """Two seconds of ObsPy's K-NET file, with the peak that they have."""
    lines = KNET.read_bytes().decode().split("\n")[: 17 + 25]
    counts = np.array(" ".join(lines[17:]).split(), dtype=float)
    peak = np.abs(counts - counts.mean()).max() * 2000 / 8388608
    text = "\n".join(lines).replace("(s)  59", "(s)  2").replace("4.383", f"{peak:.3f}")
    return text.encode()


def short_evt(path: Path, frames: int = 4) -> bytes:
    """The first frames of an EVT file, a tenth of a second at 250 Hz each, with header and checksum to match."""
    raw = bytearray(path.read_bytes())
    at = 16 + 2040
    for _ in range(frames):
        at += 16 + sum(struct.unpack_from(">HH", raw, at + 8))
    struct.pack_into(">L", raw, 16 + 0x22C + 8, frames)
    struct.pack_into(">L", raw, 16 + 0x22C + 20, frames * 25)
    return with_checksums(bytes(raw[:at]))


def with_checksums(raw: bytes) -> bytes:
    """An EVT file whose checksums are right, so that damage gets past them."""
    changed, at = bytearray(raw), 0
    while at + 16 <= len(changed):
        length = sum(struct.unpack_from(">HH", changed, at + 8))
        body = changed[at + 16 : at + 16 + length]
        struct.pack_into(">H", changed, at + 14, sum(body) & 0xFFFF)
        at += 16 + length
    return bytes(changed)


def whole_numbers(count: int) -> obspy.Trace:
    """The strong part of a shipped record, in counts."""
    trace = obspy.read(str(catalogue.path("NAPA-HNE")), format="MSEED")[0]
    trace.data = trace.data[5200 : 5200 + count]
    return trace


def written(trace: obspy.Trace, format: str, **options: object) -> bytes:
    """The bytes of a trace that ObsPy writes."""
    target = BytesIO()
    trace.write(target, format=format, **options)
    return target.getvalue()


def short_mseed() -> Iterator[bytes]:
    """MiniSEED in blocks of 512 bytes: the three encodings of counts, and floats; and a shipped file's two blocks."""
    for encoding in ("STEIM1", "STEIM2", "INT32"):
        yield written(whole_numbers(300), "MSEED", reclen=512, encoding=encoding)
    fractions = whole_numbers(300)
    fractions.data = fractions.data * 1e-3
    yield written(fractions, "MSEED", reclen=512, encoding="FLOAT64")
    yield catalogue.path("CCC-HN1").read_bytes()[:8192]


# --- damage -----------------------------------------------------------------------------------------------


def variants(originals: list[bytes], count: int, seed: str) -> Iterator[bytes]:
    """Damaged copies, the same in every run: one to three kinds of damage each."""
    dice = random.Random(seed)
    for at in range(count):
        raw = bytearray(originals[at % len(originals)])
        for _ in range(dice.choice((1, 1, 2, 3))):
            dice.choice((_flipped, _removed, _inserted, _line_moved, _cut, _number_changed, _blanked))(raw, dice)
        yield bytes(raw)


def _flipped(raw: bytearray, dice: random.Random) -> None:
    for _ in range(dice.randint(1, 4)):
        if raw:
            raw[dice.randrange(len(raw))] = dice.choice((dice.randrange(256), dice.choice(b"09-+.eE ,\n")))


def _removed(raw: bytearray, dice: random.Random) -> None:
    at = dice.randint(0, len(raw))
    del raw[at : at + dice.choice((1, 1, 2, 8, 80, 512))]


def _inserted(raw: bytearray, dice: random.Random) -> None:
    at = dice.randint(0, len(raw))
    raw[at:at] = bytes(dice.choices(range(256), k=dice.choice((1, 2, 8, 80)))) if dice.random() < 0.5 else raw[:80]


def _line_moved(raw: bytearray, dice: random.Random) -> None:
    """A line, or 64 bytes where there are none, dropped or doubled."""
    lines = bytes(raw).splitlines(keepends=True)
    if len(lines) < 5:
        lines = [bytes(raw[at : at + 64]) for at in range(0, len(raw), 64)]
    if lines:
        at = dice.randrange(len(lines))
        lines[at : at + 1] = [lines[at]] * dice.choice((0, 2))
    raw[:] = b"".join(lines)


def _cut(raw: bytearray, dice: random.Random) -> None:
    del raw[dice.randint(0, len(raw)) :]


def _number_changed(raw: bytearray, dice: random.Random) -> None:
    """A number as text in the first part becomes another one; in a binary header, two or four bytes do."""
    found = list(re.finditer(rb"-?\d+\.?\d*", bytes(raw[:4096])))
    if found and raw.count(b"\n") > 4:
        number = dice.choice(found)
        new = dice.choice(NUMBERS)
        # Columns of fixed width stay in place in half of the cases.
        raw[number.start() : number.end()] = new.rjust(len(number[0])) if dice.random() < 0.5 else new
    elif len(raw) > 8:
        at = 2 * dice.randrange(min(len(raw), 2100) // 2 - 2)
        value = dice.choice((0, 1, 2, 7, 255, 256, 32767, 65535, 0x7FFFFFFF, 0xFFFFFFFF, 0x7FC00000))
        raw[at : at + 4] = struct.pack(dice.choice("<>") + "L", value)


def _blanked(raw: bytearray, dice: random.Random) -> None:
    at = dice.randint(0, len(raw))
    piece = raw[at : at + dice.choice((1, 4, 16, 200))]
    raw[at : at + len(piece)] = dice.choice((b"\0", b" ", b"\xff")) * len(piece)


# --- what must come of it ---------------------------------------------------------------------------------


def outcome(format: Format, raw: bytes, path: Path, unit: str | None, through_a_file: bool) -> str:
    """ "refused" or "read"; raises AssertionError for anything but a sentence or sound samples.

    A file without a unit is handed over without a name, and called a record of its kind.
    """
    dt, name = None if format.name == "COLUMNS" else 0.005, "" if unit is None else str(path)
    opened = BytesIO(raw)
    claims = [each.name for each in formats() if each.recognises(opened)]
    assert opened.tell() == 0, "a format moved the position"
    assert len(claims) < 2, f"{claims} all recognise it"
    try:
        if through_a_file:
            path.write_bytes(raw)
            traces = [found.trace for found in read_components(path, unit=unit, dt=dt)]
        else:
            traces = list(format.read(BytesIO(raw), name=name, folder=path.parent, unit=unit, dt=dt))
    except RecordError as error:
        said = str(error)
        kind = sys.modules[format.read.__module__].KIND
        called = str(path) if through_a_file else name or f"{kind} record"
        assert said.startswith(called), f"the file is not named: {said}"
        assert len(said) < 1500 and said.isprintable(), f"no plain sentence: {said!r}"
        return "refused"
    assert traces, "no trace and no word"
    for trace in traces:
        samples, step = trace.data, trace.stats.delta
        assert str(trace.stats.starttime)
        assert samples.dtype == np.float64 and np.isfinite(samples).all(), "samples that are no numbers"
        assert 2 <= len(samples) == trace.stats.npts <= 2 * len(raw), f"{len(samples)} samples of {len(raw)} bytes"
        promised = None if through_a_file or format.name not in PROMISED else int(PROMISED[format.name](raw))
        assert promised in (None, len(samples)), f"{len(samples)} samples of {promised}"
        assert SHORTEST_STEP <= step <= LONGEST_STEP, f"a time step of {step}"
        assert trace.stats.calib == 1.0 and trace.stats.record.state in ("raw", "processed"), "no m/s²"
        assert is_the_stated_peak(trace), "samples that contradict the header's peak"
    return "read"


def is_the_stated_peak(trace: obspy.Trace) -> bool:
    """True where the header states no peak, or that of the samples or of the samples less their mean, within 2 %.

    That is what the last digit of a number cut to two digits may be worth; the short files state more. GeoNet prints
    tenths of mm/s², of header and samples: half of one off each, at most.
    """
    stated = trace.stats.record.get("header_pga")
    if "sac" in trace.stats:  # read in g here
        extremes = trace.stats.sac.get("depmin", -12345.0), trace.stats.sac.get("depmax", -12345.0)
        stated = None if -12345.0 in extremes or not np.isfinite(extremes).all() else 9.80665 * np.abs(extremes).max()
    if not stated:
        return True
    with np.errstate(over="ignore"):
        peaks = np.abs(trace.data).max(), np.abs(trace.data - trace.data.mean()).max()
    return min(abs(peak - stated) for peak in peaks) <= max(0.02 * stated, 1.001e-4)


def survey(format: Format, originals: list[bytes], count: int, folder: Path) -> dict[str, object]:
    """How many of the damaged files were refused and read, and what was wrong with others."""
    suffix = format.suffixes[0] if format.suffixes else ""
    path = folder / f"damaged{suffix}"
    found: dict[str, object] = {"refused": 0, "read": 0}
    faults = []
    for at, raw in enumerate(variants(originals, count, format.name)):
        if format.name == "KINEMETRICS_EVT" and at % 2:
            raw = repaired(raw)
        try:
            what = outcome(format, raw, path, unit_of(format, at), at % THROUGH_A_FILE == 0)
            found[what] = int(str(found[what])) + 1
        except Exception as error:
            faults.append(f"variant {at}: {type(error).__name__}: {error}")
    return {**found, "faults": faults}


def unit_of(format: Format, at: int = 1) -> str | None:
    """What the user says a sample is: nothing of columns, which say it, nor of every fifth file of another format."""
    return None if format.name == "COLUMNS" or at % 5 == 0 else "g"


def repaired(raw: bytes) -> bytes:
    """The checksums of an EVT file made right, where its tags can be followed."""
    try:
        return with_checksums(raw)
    except struct.error:
        return raw


def main(count: int, names: list[str]) -> None:
    """Report a line of JSON a format."""
    faulthandler.enable()
    with tempfile.TemporaryDirectory() as folder:
        for format in formats():
            if not names or format.name in names:
                print(json.dumps({"format": format.name, "begun": True}), flush=True)
                result = survey(format, originals(format.name), count, Path(folder))
                print(json.dumps({"format": format.name, **result}), flush=True)


if __name__ == "__main__":
    main(int(sys.argv[1]), sys.argv[2:])
