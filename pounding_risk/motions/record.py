"""A record as it was read, before any processing: its facts, whether a run can use it, and of which recording it is."""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import LEAST_SHAKING, Samples

RAW, PROCESSED, GENERATED = "raw", "processed", "generated"
STILL = "still"  # a fact of generated ground that does not move, which of a record is a fault


class Source(NamedTuple):
    """A record as it was read: a trace in m/s², its facts, and the sentence that says how its samples became m/s²."""

    name: str
    trace: Any  # obspy.Trace, float samples, calib 1
    record: dict[str, Any]
    units: str
    doubts: tuple[str, ...] = ()  # about how it was read, a sentence each


USABLE = 1.25  # lowest usable frequency over the filter's lower corner, of the flatfile of NGA-West2
LARGEST = 1e30  # m/s²: far above any motion, and its square is still a number
VERTICALS = {"UP", "U-D", "DWN", "DOWN", "DN", "UD", "UD1", "UD2", "V", "VER", "VERT", "VERTICAL", "Z"}
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

    ``facts`` are what is known of each record, ``names`` stand for their recordings where nothing is known.
    """
    numbers: dict[Hashable, int] = {}
    keys = (recording(record, name) for record, name in zip(facts, names, strict=True))
    return np.array([numbers.setdefault(key, len(numbers)) for key in keys], dtype=np.int64)


def is_vertical(record: Mapping[str, Any]) -> bool:
    """True for a component that is vertical by its file, or its name: UP, BOL-UP, U-D, DWN, V, Z, HNZ, BHZ10."""
    if record.get("vertical"):
        return True
    name = str(record.get("component") or "").upper()
    ends = {name, re.split(r"[-_ .]", name)[-1]}
    return record.get("azimuth") is None and bool(VERTICALS & ends or re.fullmatch(r"[A-Z]{2}Z\d{0,2}", name))


def lowest_usable(record: Mapping[str, Any]) -> float | None:
    """The lowest frequency [Hz] that the filter of a record has left; None where it is not known.

    What the record states, or 1.25 times the lower corner of its filter (PEER NGA-West2, Ancheta et al. 2013).
    """
    return record.get("lowest_usable_frequency") or USABLE * float(record.get("low_corner") or 0.0) or None


def site_of(record: Mapping[str, Any]) -> str:
    """The site of a record in words, from its facts; "" of a record that is of none."""
    if "site" not in record:
        return ""
    away = f", {record['site_distance_km']:.3g} km from the place of the scene" if "site_distance_km" in record else ""
    return f"{record['site']} at {record['longitude']:.6g}, {record['latitude']:.6g}{away}"


def check_samples(samples: Any, dt: float, name: str) -> None:
    """Raise RecordError for samples and time steps that no run can use: gaps, complex or infinite numbers, too few."""
    if not (isfinite(dt) and dt > 0.0):
        raise RecordError(f"{name}: the time step is {dt:g} s; it must be greater than 0: check the record")
    if np.ma.isMaskedArray(samples) and np.ma.count_masked(samples):
        gaps = int(np.ma.count_masked(samples))
        raise RecordError(f"{name}: has gaps ({gaps} samples are missing); cut or fill them before")
    if np.ndim(samples) != 1 or len(samples) < 2:
        count = np.size(samples)
        raise RecordError(f"{name}: has {count} sample{'s' if count != 1 else ''}; a record needs at least 2")
    if np.iscomplexobj(samples):
        raise RecordError(f"{name}: its samples are complex numbers; hand over the real part of them")
    wrong = np.flatnonzero(~np.isfinite(samples))
    if len(wrong):
        raise RecordError(
            f"{name}: {len(wrong)} sample{'s are' if len(wrong) > 1 else ' is'} not finite, the first at "
            f"index {wrong[0]} (t = {wrong[0] * dt:g} s); repair or replace the record"
        )
    peak = float(np.abs(samples).max())
    if peak > LARGEST:
        raise RecordError(
            f"{name}: a sample of {peak:.3g} m/s² is no motion of the ground; check the unit, or the scaling"
        )


def check_shaking(samples: Samples, name: str, repair: str) -> None:
    """Raise RecordError for samples [m/s²] without motion, which would count as a record that causes no contact.

    Those are samples that are all equal, and a range that no strong-motion instrument resolves. The sentence names the
    file or record ``name``, and ends with what to check, ``repair``.
    """
    half_range = 0.5 * (float(samples.max()) - float(samples.min()))
    if half_range >= LEAST_SHAKING:
        return
    if half_range == 0.0:
        variation = f"every sample is {samples[0]:g} m/s²"
    else:
        variation = f"its samples vary by {half_range:.2g} m/s² about their middle, less than an instrument resolves"
    raise RecordError(f"{name}: {variation}: the record holds no motion; check {repair}")
