"""Lock of a checkpoint: one run alone, or several shards. It is a lock of the system and ends with its process.

On platforms and file systems without such locks there is none.
"""

from __future__ import annotations

import errno
import json
import os
import time
from collections.abc import Callable
from datetime import UTC, datetime
from pathlib import Path
from typing import NamedTuple

from pounding_risk._common.files import OWN_FILE, host

PATIENCE = {False: 1.0, True: 5.0}  # s, of a run alone and of a shard: another shard may be starting the scan
PAUSE = 0.02  # s
READ_ONLY = {errno.EACCES, errno.EPERM, errno.EROFS}  # a checkpoint of another user, or a read-only disk
NO_LOCKS = {errno.ENOLCK, errno.ENOSYS, errno.EINVAL, getattr(errno, "ENOTSUP", errno.ENOSYS)}


class Holder(NamedTuple):
    """A process that holds, or held, a lock."""

    host: str
    pid: int
    since: str

    def __str__(self) -> str:
        return f"{self.host} (pid {self.pid})"

    @property
    def is_gone(self) -> bool:
        """True where the process is known to have ended, which needs this machine."""
        if self.host != host() or os.name != "posix":
            return False
        try:
            os.kill(self.pid, 0)
        except OSError as error:  # a process of another user may not be asked
            return isinstance(error, ProcessLookupError)
        return False


class Held(Exception):
    """Raised where another process holds the lock; ``holders`` are the processes, where known."""

    def __init__(self, holders: list[Holder]):
        self.holders = holders
        super().__init__(", ".join(map(str, holders)))


class Lock:
    """An open lock file. Raises OSError where it cannot be made."""

    def __init__(self, path: Path):
        self.path = path
        self._handle = os.open(path, os.O_RDWR | os.O_CREAT | os.O_APPEND | OWN_FILE, 0o666)

    @property
    def is_open(self) -> bool:
        """True until the lock is closed."""
        return self._handle >= 0

    def take(self, shared: bool) -> bool:
        """Take the lock: exclusively if possible (True), otherwise with others if ``shared`` (False).

        Raises Held where another process prevents it.
        """
        return self._patiently(lambda: self._take_now(shared), PATIENCE[shared])

    def share(self) -> None:
        """Turn an exclusive lock into a shared one; raises Held where an exclusive one was quicker."""
        self._patiently(lambda: True if _locked(self._handle, exclusive=False) else None, PATIENCE[True])
        # The system releases the lock in between: another process that was alone then has removed our name.
        if (host(), os.getpid()) not in [(holder.host, holder.pid) for holder in holders(self.path)]:
            self._sign(is_alone=False)

    def _take_now(self, shared: bool) -> bool | None:
        """True where the lock was taken exclusively, False where shared, None where it is not available now."""
        if _locked(self._handle, exclusive=True):
            self._sign(is_alone=True)
            return True
        if shared and _locked(self._handle, exclusive=False):
            self._sign(is_alone=False)
            return False
        return None

    def _patiently(self, ask: Callable[[], bool | None], patience: float) -> bool:
        """Ask until there is an answer: `status` takes the lock for an instant."""
        end = time.monotonic() + patience
        while (answer := ask()) is None:
            if time.monotonic() > end:
                raise Held(holders(self.path))
            time.sleep(PAUSE)
        return answer

    def _sign(self, is_alone: bool) -> None:
        """Write this process to the file as a holder; earlier holders are removed where it is alone."""
        if is_alone:
            os.ftruncate(self._handle, 0)
        own_holder = Holder(host(), os.getpid(), datetime.now(UTC).isoformat(timespec="seconds"))
        os.write(self._handle, f"{json.dumps(own_holder._asdict())}\n".encode())

    def close(self) -> None:
        """Release the lock, so that another process may write to the folder."""
        if self.is_open:
            os.close(self._handle)
            self._handle = -1


def holders(path: Path) -> list[Holder]:
    """Processes in a lock file that are not known to have ended; they need not hold the lock any more."""
    live_holders = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            holder = Holder(**json.loads(line))
        except (ValueError, TypeError):  # a line that another process is writing
            continue
        if isinstance(holder.pid, int) and not holder.is_gone:
            live_holders.append(holder)
    return list(dict.fromkeys(live_holders))


def running(path: Path) -> list[Holder]:
    """The processes that hold a lock now; none where there is no file. Does not wait, nor keep the lock."""
    try:
        handle = os.open(path, os.O_RDWR | OWN_FILE)
    except FileNotFoundError:
        return []
    except OSError as error:
        if error.errno not in READ_ONLY:
            raise
        handle = os.open(path, os.O_RDONLY | OWN_FILE)
    try:
        if _locked(handle, exclusive=True):
            return []
    finally:
        os.close(handle)
    return holders(path) or [Holder("another machine", 0, "")]


def _locked(handle: int, exclusive: bool) -> bool:
    """Ask the system for the lock without waiting."""
    try:
        import fcntl
    except ImportError:
        return True
    try:
        fcntl.flock(handle, (fcntl.LOCK_EX if exclusive else fcntl.LOCK_SH) | fcntl.LOCK_NB)
    except OSError as error:
        if error.errno in (errno.EWOULDBLOCK, errno.EACCES):
            return False
        if error.errno in NO_LOCKS:
            return True
        raise
    return True
