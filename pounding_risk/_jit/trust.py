"""Who else can write where compiled code is kept: it is loaded and run, so nobody else may.

Folders and files of the cache belong to this user or to root, and neither their group nor others can write them. The
folders above may be written by others where the sticky bit keeps these from renaming what is not theirs, as in /tmp.
Windows keeps such rights in another form; nothing is checked there.
"""

from __future__ import annotations

import os
import stat
from collections.abc import Iterator
from pathlib import Path

CHECKED = hasattr(os, "geteuid")
# Owner of what root owns outside a user namespace or behind an NFS server, where it cannot be named; of folders above.
NOBODY = 65534
ELSEWHERE = "set NUMBA_CACHE_DIR to a folder that only you can write"


class UntrustedCode(UserWarning):
    """Compiled code is left where it is, because another user can have written it."""


def make_private(folder: Path) -> None:
    """Make a folder and those above it that are not there, for this user alone whatever the umask; raises OSError."""
    for one in (*reversed(folder.parents), folder):
        if not one.is_dir():
            one.mkdir(mode=0o700, exist_ok=True)


def doubt(folder: Path, root: Path) -> str | None:
    """Why code in a folder is not run, with the repair; None where only this user and root can have written it.

    ``root`` is the folder that a user names; what is below it is this package's own.
    """
    if not CHECKED:
        return None
    top, whole = Path(os.path.realpath(root)), Path(os.path.realpath(folder))
    return next(filter(None, (_doubt(one, top) for one in _way(folder, whole))), None)


def file_doubt(path: Path) -> str | None:
    """As `doubt`, of a file alone, whose folder was looked at before."""
    return _doubt(path, path) if CHECKED else None


def _way(path: Path, whole: Path) -> Iterator[Path]:
    """The symbolic links on the way to a path, then every folder above it, and itself."""
    absolute = Path(os.path.abspath(path))
    yield from (one for one in (*reversed(absolute.parents), absolute) if one.is_symlink())
    yield from (*reversed(whole.parents), whole)


def _doubt(path: Path, top: Path) -> str | None:
    try:
        facts = path.lstat()
    except OSError:  # what is not there has been written by nobody
        return None
    is_above = path != top and top not in path.parents
    trusted = {0, os.geteuid()} | ({NOBODY} if is_above else set())
    if facts.st_uid not in trusted:
        return f"{path} belongs to another user (uid {facts.st_uid}), who could put code there; {ELSEWHERE}"
    is_held = stat.S_ISDIR(facts.st_mode) and facts.st_mode & stat.S_ISVTX and (is_above or path == top)
    if stat.S_ISLNK(facts.st_mode) or is_held or not facts.st_mode & (stat.S_IWGRP | stat.S_IWOTH):
        return None
    return (
        f"{path} can be written by other users (mode {stat.S_IMODE(facts.st_mode):04o}), who could put code there; "
        f"chmod go-w {path}, or {ELSEWHERE}"
    )
