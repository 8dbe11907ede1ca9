"""The attributes ``date_created`` and ``history`` of a dataset.

The environment variable ``SOURCE_DATE_EPOCH``, seconds since 1970 as in reproducible builds, fixes the time, so that a
scan gives the same bytes on any day.
"""

from __future__ import annotations

import os
from datetime import UTC, datetime

from pounding_risk._common.version import __version__
from pounding_risk.errors import PoundingError

FIXED = "SOURCE_DATE_EPOCH"
LAST = 253402300799  # the last second of the year 9999


def now() -> str:
    """The time in UTC to the second, as ISO 8601 writes it; raises PoundingError for a fixed time that is none."""
    fixed = os.environ.get(FIXED)
    if not fixed:
        return datetime.now(UTC).isoformat(timespec="seconds")
    if not (fixed.isascii() and fixed.isdecimal() and int(fixed) <= LAST):
        raise PoundingError(f"{FIXED} is {fixed!r}; it is a number of seconds since 1970, such as 1700000000")
    return datetime.fromtimestamp(int(fixed), UTC).isoformat(timespec="seconds")


def created(by: str, when: str = "") -> dict[str, str]:
    """Attributes of a new dataset.

    Parameters
    ----------
    by
        The command line, or the function that was called.
    when
        The time, where it is not now: of a study that goes on, when it was begun.

    Returns
    -------
    dict
        ``date_created`` and ``history``, whose line is a time, what was run, and the version of this package.
    """
    time = when or now()
    return {"date_created": time, "history": f"{time} {by} (pounding-risk {__version__})"}
