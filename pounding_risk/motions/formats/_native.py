"""Reading through ObsPy, for formats that it has: by name of the format, without warnings, errors as one sentence."""

from __future__ import annotations

import warnings
from io import BytesIO
from typing import Any

import numpy as np
import obspy
from obspy import Stream

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats._text import check_step, text_of

LONGEST_REASON = 200  # characters of what ObsPy says


def bytes_of(file: Any, name: str, kind: str) -> tuple[str, bytes]:
    """Name and bytes of a path or of an open file; ``kind`` is the format in words."""
    name, text = text_of(file, name, kind)
    return name, text.encode("latin-1")


def unreadable(name: str, kind: str, reason: str) -> RecordError:
    """The error for a damaged file; a reason from ObsPy may quote its bytes."""
    plain = "".join(letter if letter.isprintable() else " " for letter in reason[:LONGEST_REASON])
    return RecordError(f"{name}: cannot be read as {kind} ({' '.join(plain.split())}); fetch the record again")


def read_by_obspy(raw: bytes, name: str, format: str, kind: str, *, refused: type[Warning] | None = None) -> Stream:
    """Every trace that ObsPy finds in the bytes of a file of the ``format`` of that name.

    A warning of the class ``refused`` is an error, as it means damage that ObsPy reads around; others, about header
    fields that nothing here uses, are not shown. Raises RecordError for what ObsPy cannot read, for samples that are no
    finite numbers, fewer than two of them, and a time step out of range.
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        if refused is not None:
            warnings.simplefilter("error", refused)
        try:
            stream = obspy.read(BytesIO(raw), format=format)
        except Exception as error:  # its readers let out whatever happens: ValueError, struct.error, their own
            raise unreadable(name, kind, str(error).strip() or type(error).__name__) from None
    for trace in stream:
        check_step(name, trace.stats.delta, f"{trace.stats.delta:g}", "the time step")
        if trace.data.dtype.kind not in "if" or not np.isfinite(trace.data).all():
            raise unreadable(name, kind, "not every sample is a finite number")
        if len(trace.data) < 2:
            count = "1 sample" if len(trace.data) else "no sample"
            raise RecordError(f"{name}: has {count} in {trace.id}; a record needs at least 2")
    return stream
