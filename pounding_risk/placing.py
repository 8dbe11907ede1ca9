"""Results are written aside, under a hidden name beside the target, and moved into place when they are whole.

Whatever ends a run, a file under its final name is a whole one. A Zarr store is a folder, which cannot take the place
of another in one step: the older store is moved away first, to ``.NAME.PID.old``, and removed when the new one is in
place. A crash between the two leaves the older store, whole, under that name, and none under the target's.
"""

from __future__ import annotations

import errno
import hashlib
import os
import re
import shutil
from collections.abc import Iterator
from pathlib import Path

from pounding_risk.errors import PoundingError

AGAIN = "free space or choose another place"
PIECE = 1 << 20  # bytes read at a time


def partial_of(target: Path) -> Path:
    """Where a target is written until it is whole."""
    return target.with_name(f".{target.name}.{os.getpid()}.partial")


def move_into_place(partial: Path, target: Path) -> None:
    """Sync a file or a folder and give it its final name, in place of an older one. Raises OSError."""
    for path in _tree(partial):
        _sync(path)
    if not partial.is_dir():
        os.replace(partial, target)
        _sync(target.parent)
        return
    older = target.with_name(f".{target.name}.{os.getpid()}.old")
    try:
        if target.is_dir():
            os.rename(target, older)
        os.rename(partial, target)
    except BaseException:  # Ctrl-C as well
        if older.is_dir() and not target.exists():
            os.rename(older, target)
        raise
    _sync(target.parent)
    discard(older)


def moved_away(target: Path) -> Path | None:
    """The older store that a crash between two renames left, where there is none under the target's name."""
    if target.exists():
        return None
    return next(_left(target, "old"), None)


def discard(path: Path) -> None:
    """Remove a file or a folder that may be there. What it holds on disk is given back even where it is still open."""
    if path.is_symlink():
        path.unlink()  # where it points to is the user's own
    elif path.is_dir():
        shutil.rmtree(path)
    elif path.exists():
        os.truncate(path, 0)
        path.unlink()


def sweep(target: Path) -> list[Path]:
    """Remove what killed runs left of a target, and say what; the caller makes sure that nobody is writing it."""
    left = list(_left(target, "partial"))
    if target.exists():
        left += _left(target, "old")
    for path in left:
        discard(path)
    return left


def _left(target: Path, what: str) -> Iterator[Path]:
    """What processes have left of a target, and of no other whose name begins as this one's."""
    name = re.compile(rf"\.{re.escape(target.name)}\.\d+\.{what}")
    return iter(sorted(each for each in target.parent.iterdir() if name.fullmatch(each.name)))


def not_written(target: Path, error: BaseException, repair: str = AGAIN) -> PoundingError:
    """What to raise where writing failed. The space that is left is told too: netCDF calls a full disk many names."""
    told = getattr(error, "strerror", None) or str(error)
    if getattr(error, "errno", None) != errno.ENOSPC:
        told += f", with {shutil.disk_usage(target.parent).free / 1e6:.1f} MB free"
    return PoundingError(f"{target}: cannot be written ({told}); {repair}")


def checksum(path: Path) -> str:
    """SHA-256 of a file, or of the names and contents of a folder's files."""
    found = hashlib.sha256()
    for each in sorted(_files(path)):
        if path.is_dir():
            found.update(each.relative_to(path).as_posix().encode() + b"\0")
        with open(each, "rb") as file:
            while piece := file.read(PIECE):
                found.update(piece)
    return found.hexdigest()


def _files(path: Path) -> Iterator[Path]:
    return (each for each in path.rglob("*") if each.is_file()) if path.is_dir() else iter((path,))


def _tree(path: Path) -> Iterator[Path]:
    """A file, or everything in a folder and the folder last."""
    if path.is_dir():
        yield from path.rglob("*")
    yield path


def _sync(path: Path) -> None:
    if path.is_dir() and os.name == "nt":
        return  # Windows syncs no folders
    place = os.open(path, os.O_RDONLY if path.is_dir() else os.O_RDWR)
    try:
        os.fsync(place)
    finally:
        os.close(place)
