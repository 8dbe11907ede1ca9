"""What a command says of compiled code that is not kept as usual: a sentence on standard error, and it goes on.

Where all is as usual nothing is said.
"""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

ADVICE = "set NUMBA_CACHE_DIR to a folder that can be written"
TROUBLES = {
    "cannot be read": "was damaged ({why}) and is compiled anew",
    "cannot be kept": f"cannot be kept ({{why}}), so that the next start compiles again; free space, or {ADVICE}",
}


@contextmanager
def cache_told() -> Iterator[None]:
    """Around a command: warnings about compiled code become one sentence each, after it, with where it is kept."""
    found: dict[str, str] = {}
    with warnings.catch_warnings():
        shown = warnings.showwarning

        def show(message: Warning | str, *where: Any) -> None:
            told = _sentence(str(message))
            if told is None:
                return shown(message, *where)
            found.setdefault(*told)

        warnings.showwarning = show  # type: ignore[assignment]
        try:
            yield
        finally:
            for sentence in (*found.values(), *_unusual()):
                print(f"pounding-risk: note: {sentence}", file=sys.stderr)


def _sentence(warning: str) -> tuple[str, str] | None:
    """What kind of trouble a warning of the compile cache tells, and it in words; None for any other warning."""
    parts = re.match(r"(.*): a compiled kernel (cannot be \w+) \((.*)\)", warning, re.DOTALL)
    if parts is None or parts[2] not in TROUBLES:
        return None
    folder, kind, error = parts.groups()
    quoted = re.search(r"'([^']+)'|\"([^\"]+)\"", error)
    why = (quoted[1] or quoted[2]) if quoted else error
    return kind, f"compiled code in {folder} {TROUBLES[kind].format(why=why)}"


def _unusual() -> Iterator[str]:
    """Where compiled code is kept, if that is not the user's cache folder, or that it is not kept."""
    used = sys.modules.get("pounding_risk._jit.compile")
    if used is None or used.INTERPRETED:
        return
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    usual = Path(chosen or os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    if used.CACHE is None:
        where = f"NUMBA_CACHE_DIR, {chosen}," if chosen else f"neither {usual} nor the folder for temporary files"
        is_none = "is no folder that can be written" if chosen else "can be written"
        yield f"compiled code is not kept, since {where} {is_none}; every start compiles again; {ADVICE}"
    elif not usual.is_absolute() and not chosen:
        yield f"compiled code is kept in {used.CACHE}, since no home folder is known; to keep it elsewhere, {ADVICE}"
    elif not Path(used.CACHE).is_relative_to(usual):
        yield f"compiled code is kept in {used.CACHE}, since {usual} cannot be written; to keep it elsewhere, {ADVICE}"
