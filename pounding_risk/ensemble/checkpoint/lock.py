"""Who writes a study's folder: one run, or several shards. The lock is the system's and ends with its process.

A platform without such locks, and a file system that refuses them, has none.
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

PATIENCE = {False: 1.0, True: 5.0}  # s, of a run alone and of a shard: another shard may be beginning the study
PAUSE = 0.02  # s
READ_ONLY = {errno.EACCES, errno.EPERM, errno.EROFS}  # another user's study, or a disk that is only read
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
        """True where it is known to have ended; of another machine nothing is known."""
        if self.host != host() or os.name != "posix":
            return False
        try:
            os.kill(self.pid, 0)
        except ProcessLookupError:
            return True
        except PermissionError:
            return False
        return False


class Held(Exception):
    """Somebody else holds the lock; ``holders`` says who, where that is known."""

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
        """Until `close`."""
        return self._handle >= 0

    def take(self, shared: bool) -> bool:
        """Take the lock: alone where that can be had (True), with others where ``shared`` allows it (False).

        Raises Held where another process stands against it.
        """
        return self._patiently(lambda: self._take_now(shared), PATIENCE[shared])

    def share(self) -> None:
        """Let others in that share too; raises Held where one that does not share was quicker."""
        self._patiently(lambda: True if _locked(self._handle, exclusive=False) else None, PATIENCE[True])
        # The system lets go before it takes anew: one that was alone in between has wiped our name.
        if (host(), os.getpid()) not in [(one.host, one.pid) for one in holders(self.path)]:
            self._sign(alone=False)

    def _take_now(self, shared: bool) -> bool | None:
        """Whether the lock is held alone; None where it cannot be had at this moment."""
        if _locked(self._handle, exclusive=True):
            self._sign(alone=True)
            return True
        if shared and _locked(self._handle, exclusive=False):
            self._sign(alone=False)
            return False
        return None

    def _patiently(self, ask: Callable[[], bool | None], patience: float) -> bool:
        """Ask until there is an answer: who tells a study's state takes the lock for an instant."""
        end = time.monotonic() + patience
        while (answer := ask()) is None:
            if time.monotonic() > end:
                raise Held(holders(self.path))
            time.sleep(PAUSE)
        return answer

    def _sign(self, alone: bool) -> None:
        """Write who holds the lock; those before are gone where it is held alone."""
        if alone:
            os.ftruncate(self._handle, 0)
        me = Holder(host(), os.getpid(), datetime.now(UTC).isoformat(timespec="seconds"))
        os.write(self._handle, f"{json.dumps(me._asdict())}\n".encode())

    def close(self) -> None:
        """Let go."""
        if self.is_open:
            os.close(self._handle)
            self._handle = -1


def holders(path: Path) -> list[Holder]:
    """Who signed a lock file last and is not known to have ended; it says nothing of whether they still hold it."""
    found = []
    for line in path.read_text(encoding="utf-8", errors="replace").splitlines():
        try:
            one = Holder(**json.loads(line))
        except (ValueError, TypeError):  # a line that another process is writing
            continue
        if isinstance(one.pid, int) and not one.is_gone:
            found.append(one)
    return list(dict.fromkeys(found))


def running(path: Path) -> list[Holder]:
    """Who holds the lock of that file now; nobody where there is no file. Never waits, and keeps nothing."""
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
    """Ask the system for the lock, at once or not at all."""
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
