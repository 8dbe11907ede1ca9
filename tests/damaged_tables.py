"""Damaged copies of small files, and what must come of each: a sentence that names the file, or sound numbers."""

from __future__ import annotations

import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from typing import Any

from pounding_risk.errors import PoundingError

COUNT = 2000
PIECES = (
    *(bytes([one]) for one in b'0123456789.,-#~e\n"x([+:;'),
    *(b"\xff", b"\x00", b"nan", b"1e999", b"(((", b"POLYGON EMPTY", b"9" * 5000, "é\u202e".encode()),
)


def survey(
    path: Path, read: Callable[[], Any], check: Callable[[Any], None], count: int = COUNT, longest: int = 900
) -> Counter[str]:
    """How many damaged copies of a file were read and refused; ``check`` asserts that what was read is sound.

    A refusal has so many letters at most; readers that list every fault need more.
    """
    original, dice = path.read_bytes(), random.Random(path.name)
    outcomes: Counter[str] = Counter()
    for _ in range(count):
        raw = bytearray(original)
        for _ in range(dice.choice((1, 1, 2, 3))):
            at = dice.randrange(max(len(raw), 1))
            stretch = slice(at, at + dice.choice((1, 1, 1, 2, 8, 40, len(raw))))
            raw[stretch] = dice.choice((dice.choice(PIECES), b"", raw[stretch] * 2))
        path.write_bytes(bytes(raw))
        try:
            known = read()
        except PoundingError as error:
            said = str(error)
            assert str(path) in said and len(said) < longest, said
            outcomes["refused"] += 1
        else:
            check(known)
            outcomes["read"] += 1
    path.write_bytes(original)
    return outcomes
