"""The real files of tests/data/formats, and texts that are changed word by word."""

from __future__ import annotations

import gzip
from pathlib import Path

G = 9.80665
DATA = Path(__file__).parents[2] / "data" / "formats"


def real(name: str) -> bytes:
    """The bytes of a file, such as cosmos-pomona.v1c."""
    return gzip.decompress((DATA / f"{name}.gz").read_bytes())


def changed(base: str, *pairs: tuple[str, str]) -> str:
    """The text with words replaced, each of which is in it."""
    for old, new in pairs:
        assert old in base, old
        base = base.replace(old, new, 1)
    return base
