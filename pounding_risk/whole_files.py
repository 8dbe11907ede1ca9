"""Files that are whole or not there: written aside, synced, moved into place, and the folder synced too.

After that a file outlives a kill and a power cut; before that nobody finds it under its name.
"""

from __future__ import annotations

import errno
import os
import platform
import re
from collections.abc import Callable
from pathlib import Path
from typing import BinaryIO

# No space, no quota, or a file larger than the process may write: free space helps, another try does not.
FULL = {errno.ENOSPC, errno.EFBIG, getattr(errno, "EDQUOT", errno.ENOSPC)}
NOT_SYNCED = {errno.EINVAL, getattr(errno, "ENOTSUP", errno.EINVAL)}  # file systems that sync no folders


def write_whole(path: Path, write: Callable[[BinaryIO], object]) -> None:
    """Let ``write`` fill a file that then appears under its name at once; raises OSError and leaves nothing aside."""
    partial = path.with_name(partial_name(path.name))
    try:
        with open(partial, "wb") as file:
            write(file)
            file.flush()
            os.fsync(file.fileno())
        os.replace(partial, path)
        sync_folder(path.parent)
    finally:
        partial.unlink(missing_ok=True)


def partial_name(name: str) -> str:
    """What this process calls a file while it writes it; no other process has that name, on any machine."""
    return f"{name}.{host()}.{os.getpid()}.partial"


def is_partial_of(name: str, pattern: str) -> bool:
    """True for a name by `partial_name` of a file whose name fits a regular expression."""
    return re.fullmatch(rf"(?:{pattern})\.[\w-]+\.\d+\.partial", name) is not None


def host() -> str:
    """This machine's name, of letters that any file system takes."""
    return re.sub(r"[^\w-]+", "-", platform.node(), flags=re.ASCII) or "unknown"


def sync_folder(folder: Path) -> None:
    """Have a folder's names on disk, where the system can be asked for it."""
    if os.name != "posix":  # Windows opens no folders
        return
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    except OSError as error:
        if error.errno not in NOT_SYNCED:
            raise
    finally:
        os.close(handle)
