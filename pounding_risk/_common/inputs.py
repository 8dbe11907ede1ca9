"""Files that a user's word names, read whole: regular ones, up to a size that each kind states.

A device has no end, and a named pipe that nobody writes would be waited for without end. Standard input,
``/dev/stdin``, may be a pipe; ``<(...)`` of a shell is another one and is refused.
"""

from __future__ import annotations

import errno
import io
import os
import stat
import sys
from pathlib import Path
from typing import Any

from pounding_risk._common.words import nearest

MB = 1_000_000
# Most bytes of each kind, far above any that is in use.
SCENE = 16 * MB  # a scene, states of damage, a published case: text that somebody wrote
SPECTRUM = 16 * MB
MANIFEST = 64 * MB
EXPORT = 1000 * MB  # hazard, ground-motion fields, tables of buildings and maps, as programs write them
_KINDS = (
    (stat.S_ISFIFO, "a pipe"),
    (stat.S_ISCHR, "a device"),
    (stat.S_ISBLK, "a device"),
    (stat.S_ISSOCK, "a socket"),
)


class Unfit(OSError):
    """A file that is never read, for what it is or for its size; ``strerror`` says so with the repair."""


def read_whole(path: Path, most: int) -> bytes:
    """The bytes of a regular file with ``most`` bytes or fewer.

    Raises OSError, which `cannot_be_read` puts into words.
    """
    facts = os.stat(path)
    if stat.S_ISDIR(facts.st_mode):
        raise IsADirectoryError(21, "Is a directory", str(path))
    if not (stat.S_ISREG(facts.st_mode) or _is_piped_in(facts)):
        kind = next((words for is_one, words in _KINDS if is_one(facts.st_mode)), "no regular file")
        raise Unfit(22, f"is {kind}, and only regular files are read; write what it gives to a file, and name that")
    with open(path, "rb", opener=_open_at_once) as file:
        if stat.S_ISFIFO(facts.st_mode) and hasattr(os, "set_blocking"):
            os.set_blocking(file.fileno(), True)
        raw = b"" if facts.st_size > most else file.read(most + 1)
    if len(raw) > most or facts.st_size > most:
        raise Unfit(27, f"has more than {most / MB:g} MB, the most that is read of such a file; check the name")
    return raw


def read_text(path: Path, most: int, errors: str = "strict") -> str:
    """The text of such a file in UTF-8, with its lines ended by ``\\n``; raises UnicodeDecodeError as well."""
    raw = read_whole(path, most)
    return io.TextIOWrapper(io.BytesIO(raw), encoding="utf-8-sig", errors=errors).read()


def text_of(path: Path, most: int) -> str:
    """As `read_text`; raises Unfit alone, whose ``strerror`` states the fault of the file and the repair."""
    try:
        return read_text(path, most)
    except Unfit:
        raise
    except UnicodeDecodeError as error:
        raise Unfit(22, f"byte {error.start} is not UTF-8; save the file with that encoding") from None
    except (OSError, ValueError) as error:
        names = [file.name for file in path.parent.iterdir()] if path.parent.is_dir() else []
        hint = nearest(path.name, (name for name in names if name != path.name))
        reason = getattr(error, "strerror", None) or error
        raise Unfit(2, f"cannot be read ({reason}){hint}; check the name") from None


def cannot_be_read(error: Any, repair: str) -> str:
    """Words on a file that was not read, after its name; ``repair`` for what the error itself has none."""
    if isinstance(error, Unfit):
        return str(error.strerror)
    if getattr(error, "errno", None) == errno.ENAMETOOLONG:
        repair = "check the name"
    return f"cannot be read ({getattr(error, 'strerror', None) or error}); {repair}"


def _open_at_once(name: str, flags: int) -> int:
    """Open without waiting for a writer, should a pipe have taken the file's place a moment ago."""
    return os.open(name, flags | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_CLOEXEC", 0))


def _is_piped_in(facts: os.stat_result) -> bool:
    """True for a pipe that is this process's standard input."""
    try:
        standard_input = os.fstat(sys.__stdin__.fileno() if sys.__stdin__ else 0)
    except (OSError, ValueError):
        return False
    return stat.S_ISFIFO(facts.st_mode) and os.path.samestat(facts, standard_input)
