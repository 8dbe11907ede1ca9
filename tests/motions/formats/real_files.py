"""The real files of tests/data/formats, texts that are changed word by word, and what a format makes of either."""

from __future__ import annotations

import gzip
from io import BytesIO
from pathlib import Path

from obspy import Stream

from pounding_risk.motions.formats import formats

G = 9.80665
DATA = Path(__file__).parents[2] / "data" / "formats"


def real(name: str) -> bytes:
    """The bytes of a file, such as cosmos-pomona.v1c."""
    return gzip.decompress((DATA / f"{name}.gz").read_bytes())


def read(data: str | bytes, **choices: object) -> Stream:
    """The traces of a file, by the format that recognises it."""
    raw = data.encode("latin-1") if isinstance(data, str) else data
    (format,) = (format for format in formats() if format.recognises(BytesIO(raw)))
    return format.read(BytesIO(raw), name="x", folder=DATA, **choices)


def changed(base: str, *pairs: tuple[str, str]) -> str:
    """The text with words replaced, each of which is in it."""
    for old, new in pairs:
        assert old in base, old
        base = base.replace(old, new, 1)
    return base
