"""The log of a study: one JSON object a line, with time, machine and process. No result hangs on it."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator
from contextlib import suppress
from datetime import UTC, datetime
from pathlib import Path
from typing import Any

from pounding_risk._common.files import OWN_FILE, host


def write_line(path: Path, event: str, **facts: Any) -> None:
    """Add a line; where it cannot be written, as on a full disk, there is none."""
    time = datetime.now(UTC).isoformat(timespec="milliseconds")
    line = json.dumps({"time": time, "event": event, "host": host(), "pid": os.getpid(), **facts}, default=str)
    with suppress(OSError):  # what is lost is a line, and not worth a run
        handle = os.open(path, os.O_RDWR | os.O_APPEND | os.O_CREAT | OWN_FILE, 0o666)
        try:
            size = os.fstat(handle).st_size
            # A process that was killed while it wrote has left half a line.
            torn = size > 0 and os.pread(handle, 1, size - 1) != b"\n" if hasattr(os, "pread") else False
            os.write(handle, f"{chr(10) if torn else ''}{line}\n".encode())
        finally:
            os.close(handle)


def read_lines(path: Path) -> Iterator[dict[str, Any]]:
    """Every whole line, in order; half ones are left out. Nothing where there is no log."""
    with suppress(FileNotFoundError), open(path, "rb") as file:
        for line in file:
            with suppress(ValueError):  # half a line
                found = json.loads(line)
                if isinstance(found, dict) and {"time", "event"} <= set(found):
                    yield found
