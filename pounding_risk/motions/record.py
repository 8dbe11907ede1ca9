"""A record as it was read, before any processing, and which components belong to one recording."""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

RAW, PROCESSED, GENERATED = "raw", "processed", "generated"
STILL = "still"  # a fact of generated ground that does not move, which of a record is a fault


class Source(NamedTuple):
    """A record as it was read: a trace in m/s², its facts, and the sentence that says how its samples became m/s²."""

    name: str
    trace: Any  # obspy.Trace, float samples, calib 1
    record: dict[str, Any]
    units: str
    doubts: tuple[str, ...] = ()  # about how it was read, a sentence each


FACTOR_OF_SITE = "site_factor"  # fact of a record: the factor that the table of its site states
STATED = "recording"  # fact of a record: its recording, where copies were found and its other facts do not say


def recording(record: Mapping[str, Any], name: str) -> Hashable:
    """A key that the components of one recording share; the ``name`` itself where the station is unknown.

    Where no event is stated, the minute in which a record starts stands for it, as two earthquakes of one day are two.
    The recording to which `copies` assigned a record goes before all of it.
    """
    if record.get(STATED):
        return str(record[STATED])
    if record.get("rsn"):
        return record["rsn"]
    event = record.get("event") or str(record.get("start") or "")[:16]
    facts = (event, *(record.get(key) or "" for key in ("date", "station", "sensor")))
    return facts if facts[2] else name


def recording_words(key: Hashable) -> str:
    """The key of a recording as text, for the fact `STATED`."""
    return ", ".join(str(part) for part in key if part) if isinstance(key, tuple) else str(key)


def recording_numbers(facts: Sequence[Mapping[str, Any]], names: Sequence[str]) -> NDArray[np.int64]:
    """Numbers from 0, equal for the records of one recording, in the order in which the recordings come.

    Parameters
    ----------
    facts : sequence of mapping
        What is known of each record.
    names : sequence of str
        Its name, which stands for its recording where nothing is known.

    Returns
    -------
    array of int, shape (records,)
    """
    numbers: dict[Hashable, int] = {}
    keys = (recording(record, name) for record, name in zip(facts, names, strict=True))
    return np.array([numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64)
