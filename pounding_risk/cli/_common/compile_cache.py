"""Trouble with compiled code, plug-ins and letters of figures that does not stop a command: a sentence each."""

from __future__ import annotations

import os
import re
import sys
import warnings
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from pounding_risk._common.letters import plain
from pounding_risk._common.plugins import PluginWarning
from pounding_risk._jit.trust import UntrustedCode

ADVICE = "set NUMBA_CACHE_DIR to a folder that can be written"
TROUBLES = {
    "cannot be read": "was damaged ({why}) and is compiled anew",
    "cannot be trusted": "is not loaded, and compiled anew: {why}",
    "cannot be kept": f"cannot be kept ({{why}}), so that the next start compiles again; free space, or {ADVICE}",
}


@contextmanager
def report_trouble() -> Iterator[None]:
    """Run a command, then print a sentence for each kind of trouble that did not stop it."""
    sentences: dict[str, str] = {}
    with warnings.catch_warnings():
        show_before = warnings.showwarning

        def show(message: Warning | str, *place: Any) -> None:
            if isinstance(message, UntrustedCode):
                return  # `_unusual_folder` has a sentence on it in every command
            trouble = (str(message),) * 2 if isinstance(message, PluginWarning) else _trouble(str(message))
            if trouble is None:
                return show_before(message, *place)
            sentences.setdefault(*trouble)

        warnings.showwarning = show  # type: ignore[assignment]
        try:
            yield
        finally:
            for sentence in (*sentences.values(), *_unusual_folder()):
                print(f"pounding-risk: note: {plain(sentence)}", file=sys.stderr)


def _trouble(warning: str) -> tuple[str, str] | None:
    """The kind of trouble of a warning of the compile cache or of letters, and a sentence; None for any other."""
    if glyph := re.match(r"Glyph (\d+) \(.*\) missing from (?:font\(s\) )?(.+?)\.?$", warning):
        letter, font = chr(int(glyph[1])), glyph[2]
        return "letters", f"figures show boxes for letters such as {letter}, which {font} lacks; write names in others"
    match = re.match(r"(.*): a compiled kernel (cannot be \w+) \((.*)\)", warning, re.DOTALL)
    if match is None or match[2] not in TROUBLES:
        return None
    folder, kind, error = match.groups()
    quoted = re.search(r"'([^']+)'|\"([^\"]+)\"", error)
    reason = (quoted[1] or quoted[2]) if quoted else error
    return kind, f"compiled code in {folder} {TROUBLES[kind].format(why=reason)}"


def _unusual_folder() -> Iterator[str]:
    """A sentence where compiled code is not cached, or in another folder than the user's cache folder."""
    sources = sys.modules.get("pounding_risk._jit.sources")
    if sources is None or sources.INTERPRETED:
        return
    if reason := sources.cache_doubt():
        yield f"compiled code is not kept, so that every start compiles again: {reason}"
        return
    folder = sources.compile_cache()
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    usual = Path(chosen or os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    if folder is None:
        folders = f"NUMBA_CACHE_DIR, {chosen}," if chosen else f"neither {usual} nor the folder for temporary files"
        fault = "is no folder that can be written" if chosen else "can be written"
        yield f"compiled code is not kept, since {folders} {fault}; every start compiles again; {ADVICE}"
    elif not usual.is_absolute() and not chosen:
        yield f"compiled code is kept in {folder}, since no home folder is known; to keep it elsewhere, {ADVICE}"
    elif not Path(folder).is_relative_to(usual):
        yield f"compiled code is kept in {folder}, since {usual} cannot be written; to keep it elsewhere, {ADVICE}"
