"""Atomic writing of files and folders: write aside, fsync, rename.

A file that was moved into place survives a kill and a power failure; until then there is nothing under its name. A Zarr
store is a folder, which cannot replace another one in one step: the older store is first renamed to
``.NAME.HOST.PID.old``, and removed when the new one is in place. A crash between the two renames leaves the older
store, complete, under that name.
"""

from __future__ import annotations

import errno
import hashlib
import os
import platform
import re
import shutil
from collections.abc import Callable, Iterable, Iterator
from contextlib import suppress
from math import inf
from pathlib import Path
from typing import BinaryIO

from pounding_risk.errors import PoundingError

AGAIN = "free space or choose another place"
PIECE = 1 << 20  # bytes read at a time
# Errors of a full disk, a quota, and a limit on the size of files.
FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
NO_PLACE = {errno.ENOENT, errno.EACCES, errno.EPERM, errno.EROFS, errno.ENOTDIR, errno.EISDIR}
# For files aside and in a checkpoint: where a symbolic link has the name, its target is not opened.
OWN_FILE = getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_CLOEXEC", 0)
NOT_SYNCED = {errno.EINVAL, getattr(errno, "ENOTSUP", errno.EINVAL)}  # file systems that sync no folders
STORE = ".zarr"  # suffix of a dataset that is a folder
CHECKPOINT = ".study"  # suffix of the folder from which a scan that was stopped goes on
PARTIAL, OLD = "partial", "old"  # endings of the names aside of a target


def host() -> str:
    """The name of this machine, in characters that any file system accepts."""
    return re.sub(r"[^\w-]+", "-", platform.node(), flags=re.ASCII) or "unknown"


def partial_of(target: Path) -> Path:
    """The path at which this process, of all machines, writes a target until it is complete."""
    return _aside(target, PARTIAL)


def is_aside(name: str, pattern: str, ending: str = PARTIAL) -> bool:
    """True for the name by `partial_of` of a target whose name fits a regular expression, or with another ending."""
    return re.fullmatch(rf"\.(?:{pattern})\.[\w-]+\.\d+\.{ending}", name) is not None


def write_whole(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Write a file atomically; ``write`` gets a file open for bytes. Raises OSError, and then leaves nothing aside."""
    write_together([(path, write)])


def write_together(files: Iterable[tuple[Path, Callable[[BinaryIO], object]]]) -> None:
    """Write several files aside, each as `write_whole`, and move them into place when all are complete."""
    partials: dict[Path, Path] = {}
    try:
        for path, write in files:
            partials[path] = partial_of(path)
            with open(partials[path], "wb", opener=_open_own) as file:
                write(file)
                file.flush()
                os.fsync(file.fileno())
        for path, partial in partials.items():
            os.replace(partial, path)
        for folder in {path.parent for path in partials}:
            sync(folder)
    finally:
        for partial in partials.values():
            partial.unlink(missing_ok=True)
    for path in partials:
        _remove_orphans(path)


def _open_own(name: str, flags: int) -> int:
    return os.open(name, flags | OWN_FILE, 0o666)


def led_to(target: Path) -> Path:
    """The file that a name stands for: the target of a symbolic link, or the name itself.

    Raises PoundingError for a link that leads to itself, or to a name of another kind.
    """
    if not target.is_symlink():
        return target
    try:
        file = target.resolve()
    except (OSError, RuntimeError):
        raise PoundingError(f"{target}: is a symbolic link that leads in a circle; remove it") from None
    if file.is_symlink():
        raise PoundingError(f"{target}: is a symbolic link that leads in a circle; remove it")
    if file.suffix.lower() != target.suffix.lower():
        raise PoundingError(
            f"{target}: is a symbolic link to {file}, whose name does not end in {target.suffix}; name the file itself"
        )
    return file


def move_into_place(partial: Path, target: Path) -> None:
    """Sync a file or a folder and move it to its final name, replacing an older one. Raises OSError."""
    is_folder = partial.is_dir()
    for path in [*(partial.rglob("*") if is_folder else ()), partial]:
        sync(path)
    if not is_folder:
        os.replace(partial, target)
        sync(target.parent)
        _remove_orphans(target)
        return
    older = _aside(target, OLD)
    try:
        if target.is_dir():
            os.rename(target, older)
        os.rename(partial, target)
    except BaseException:  # Ctrl-C as well
        if older.is_dir() and not target.exists():
            os.rename(older, target)
        raise
    sync(target.parent)
    discard(older)
    _remove_orphans(target)


def moved_away(target: Path) -> Path | None:
    """The older store that a crash between the two renames left, where there is none under the name itself."""
    return None if target.exists() else next(_asides(target, OLD), None)


def discard(path: Path) -> None:
    """Remove a file or a folder, if it exists. The space of a file is freed even where it is still open."""
    if path.is_symlink():
        path.unlink()  # its target belongs to the user
    elif path.is_dir():
        shutil.rmtree(path)
    elif path.exists():
        os.truncate(path, 0)
        path.unlink()


def remove_leftovers(target: Path) -> list[Path]:
    """Remove files that killed runs left beside a target, and return their paths; nobody may be writing the target."""
    leftovers = list(_asides(target, PARTIAL))
    if target.exists():
        leftovers += _asides(target, OLD)
    for path in leftovers:
        discard(path)
    return leftovers


def _remove_orphans(target: Path) -> None:
    """Remove the files that killed processes of this machine left aside of a target, where they can be removed."""
    if os.name != "posix":  # elsewhere a signal to a process ends it
        return
    for path in _asides(target, PARTIAL):
        machine, process = path.name.removeprefix(f".{target.name}.").split(".")[:2]
        if machine != host():
            continue
        try:
            os.kill(int(process), 0)
        except ProcessLookupError:
            with suppress(OSError):
                discard(path)
        except OSError:  # a process of another user
            continue


def not_written(target: Path, error: BaseException, repair: str = AGAIN) -> PoundingError:
    """The error to raise where writing failed.

    A limit on the size of files and a full disk are distinguished where the system does. For errors of netCDF, which
    has many names for both, the sentence has the free space and the limit.
    """
    reason = getattr(error, "strerror", None) or str(error)
    number = getattr(error, "errno", None)
    if number == errno.EFBIG:
        return PoundingError(f"{target}: cannot be written ({reason}{limit_words()}); {raised(repair)}")
    if number in NO_PLACE:
        return PoundingError(f"{target}: cannot be written ({reason}); choose another place")
    if number != errno.ENOSPC:
        free = shutil.disk_usage(target.parent).free
        reason += f", with {free / 1e6:.1f} MB free{limit_words()}"
        repair = raised(repair) if largest_file() < free else repair
    return PoundingError(f"{target}: cannot be written ({reason}); {repair}")


def largest_file() -> float:
    """Size of the largest file that this process may write [bytes]; inf where there is no limit."""
    try:
        import resource
    except ImportError:
        return inf
    limit = resource.getrlimit(resource.RLIMIT_FSIZE)[0]
    return inf if limit == resource.RLIM_INFINITY else float(limit)


def limit_words() -> str:
    """The limit of `largest_file` as a part of a sentence; "" where there is none."""
    limit = largest_file()
    return "" if limit == inf else f"; a file of this process may have {limit / 1e6:.3g} MB at most"


def raised(repair: str) -> str:
    """The repair for a sentence where a limit is too low, instead of space missing."""
    return repair.replace("free space", "raise the limit (ulimit -f)")


def checksum(path: Path) -> str:
    """SHA-256 of a file, or of the names and contents of a folder's files."""
    digest = hashlib.sha256()
    is_folder = path.is_dir()
    for name in sorted(file for file in path.rglob("*") if file.is_file()) if is_folder else [path]:
        if is_folder:
            digest.update(name.relative_to(path).as_posix().encode() + b"\0")
        with open(name, "rb") as file:
            while piece := file.read(PIECE):
                digest.update(piece)
    return digest.hexdigest()


def _aside(target: Path, ending: str) -> Path:
    return target.with_name(f".{target.name}.{host()}.{os.getpid()}.{ending}")


def _asides(target: Path, ending: str) -> Iterator[Path]:
    """Paths beside a target with this ending, of any process on any machine."""
    names = os.listdir(target.parent) if target.parent.is_dir() else []
    names_beside = sorted(name for name in names if name.startswith(f".{target.name}."))  # few of a folder of thousands
    return (target.with_name(name) for name in names_beside if is_aside(name, re.escape(target.name), ending))


def sync(path: Path) -> None:
    """Sync a file to disk, or the names in a folder where the system can do so."""
    is_folder = path.is_dir()
    if is_folder and os.name != "posix":  # Windows opens no folders
        return
    handle = os.open(path, os.O_RDONLY if is_folder else os.O_RDWR)
    try:
        os.fsync(handle)
    except OSError as error:
        if not is_folder or error.errno not in NOT_SYNCED:
            raise
    finally:
        os.close(handle)


def check_target(path: str | Path, suffixes: tuple[str, ...] = (".nc",)) -> Path:
    """The path of a file that can be written; raises PoundingError before any work is done.

    For a symbolic link it is the link's target. Its folder must exist and be writable, its suffix be one of
    ``suffixes``, and it must not be a folder, unless its suffix is ``.zarr``.
    """
    target = Path(path)
    if not target.name:
        raise PoundingError(f"{target}: names no file; write one such as results{suffixes[0]}")
    if target.suffix.lower() not in suffixes:
        allowed = " or ".join(suffixes)
        raise PoundingError(f"{target}: the name must end in {allowed}; write {target.with_suffix(suffixes[0])}")
    target = led_to(target)
    folder = target.parent
    if target.is_dir() and target.suffix.lower() != STORE:
        raise PoundingError(f"{target}: is a folder; name a file in it")
    if not folder.is_dir():
        raise PoundingError(f"{target}: the folder {folder} does not exist; make it first")
    if not os.access(folder, os.W_OK):
        raise PoundingError(f"{target}: the folder {folder} cannot be written to; choose another one")
    try:
        os.fspath(target.absolute()).encode()
    except UnicodeEncodeError:
        name = os.fsencode(target).decode(errors="backslashreplace")
        raise PoundingError(f"{name}: is no text in UTF-8, and the libraries below take no other; rename it") from None
    try:
        os.lstat(partial_of(target))
    except OSError as error:
        if error.errno == errno.ENAMETOOLONG:
            raise PoundingError(f"{target}: {error.strerror}; choose a shorter name") from None
    return target
