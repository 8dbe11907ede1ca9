"""A record as it was read, before any processing: its facts, whether a run can use it, and of which recording it is.

Records may hold the same shaking: copied, converted, reversed, scaled, cut or resampled. One that stands twice in an
ensemble would count as two independent ones. Two records are copies where, over the time that both cover, the samples
of one are those of the other times a number, to the rounding of the formats that carry them. Components of one station,
and different records of one earthquake, are far from that.

    >>> import numpy as np
    >>> shaking = np.random.default_rng(1).normal(size=800)
    >>> copies([(shaking, 0.01), (np.round(-2.0 * shaking, 5), 0.01)])[0].words()
    'times -2'
"""

from __future__ import annotations

import re
from collections.abc import Hashable, Mapping, Sequence
from functools import cached_property
from itertools import combinations
from math import isfinite, sqrt
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import LEAST_SHAKING, Samples
from pounding_risk.statistics.proportions import joined

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
AFTERSHOCK = "aftershock"  # fact of a sequence: what is known of the record that follows
BESIDE = "beside"  # fact of a motion: what is known of the records of single buildings
OWN_STEP = "own_dt"  # fact of each record in a motion of several: its time step [s] before it was divided
STATED = "recording"  # fact of a record: its recording, where copies were found and its other facts do not say
OF_RECORDING = (STATED, "rsn", "event", "start", "date", "station", "sensor")  # facts that `recording` reads
OF_DIRECTION = ("component", "azimuth", "vertical")  # facts that `is_vertical` reads
OF_BAND = ("low_corner", "lowest_usable_frequency")  # facts that `lowest_usable` reads
OF_ORIGIN = ("state", STILL, "interpolation_error")  # facts of generated ground, of which less is to be doubted
# 1 − r² of two versions of one record, r their correlation: numbers of five significant digits leave 1e-9, whole
# counts of a record that peaks at 1000 counts 1e-6; no two of 100 horizontals of FEMA P-695 come below 0.7.
ROUNDING = 1e-5
COARSE = 0.05  # likewise about the peak alone, before offsets are taken out: what is far from it needs no closer look
ABOUT_PEAK = 128  # samples before and after it
# Files in g are converted with 980, 980.665 and 981 cm/s² a g: they differ by 7e-4.
SAME_SIZE = 1e-3
LEAST_SHARED = 0.5  # of the energy of either, within the time that both cover
SAME_STEP = 1e-6  # relative difference of time steps that are one, written with different digits
FINER = 8  # times a record may be sampled more finely than its copy


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
    return ", ".join(str(fact) for fact in key if fact) if isinstance(key, tuple) else str(key)


def recording_numbers(
    facts: Sequence[Mapping[str, Any]], names: Sequence[str], digests: Sequence[str] = ()
) -> NDArray[np.int64]:
    """Numbers from 0, equal for the records of one recording, in the order in which the recordings come.

    ``facts`` are what is known of each record, ``names`` stand for their recordings where nothing is known. Sequences
    that share a shock close a gap together where it decides: they are of one recording, with all that share another
    shock with one of them, so that no correlation is left between recordings. So are records of equal ``digests``. A
    record below one building joins none: given that record, the motions are independent (`ensemble.plausibility`
    notes it).
    """
    keys: list[tuple[Hashable, ...]] = recordings_within(facts, names)
    if digests:
        keys = [(*of_record, ("motion", digest)) for of_record, digest in zip(keys, digests, strict=True)]
    return joined(keys)


def recordings_within(facts: Sequence[Mapping[str, Any]], names: Sequence[str]) -> list[tuple[Hashable, ...]]:
    """Of each record the key of its recording, and that of the recording of its aftershock, if it has one.

    An aftershock read from the source of a record among these is of that one's recording.
    """
    firsts = [recording(record, name) for record, name in zip(facts, names, strict=True)]
    by_source = {record.get("source"): first for record, first in zip(facts, firsts, strict=True)}

    def behind(shock: Mapping[str, str]) -> Hashable:
        return by_source.get(shock["source"]) or recording(shock, shock["source"] or shock["name"])

    shocks = [record.get(AFTERSHOCK) for record in facts]
    return [(first, behind(shock)) if shock else (first,) for first, shock in zip(firsts, shocks, strict=True)]


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


class Copy(NamedTuple):
    """A record that is a copy of another one: ``factor`` times it, at the same times or not."""

    place: int  # of the copy
    original: int  # the place of the first version
    factor: float  # below zero where it is turned round
    same_times: bool  # time step, start and end, but for what holds no shaking

    def is_same_motion(self, *, any_size: bool = False) -> bool:
        """True where the copy drives the same runs as its original; ``any_size``: where both are scaled to one PGA."""
        return self.same_times and self.factor > 0.0 and (any_size or abs(self.factor - 1.0) <= SAME_SIZE)

    def words(self) -> str:
        """The difference between the copy and its original, in words."""
        size = [] if abs(abs(self.factor) - 1.0) <= SAME_SIZE else [f"times {self.factor:.4g}"]
        turned = ["with the other sign"] if self.factor < 0.0 and not size else []
        return " and ".join([*size, *turned, *([] if self.same_times else ["cut or sampled otherwise"])])


class _Record:
    """Samples less their mean, with their peak, energy and coarser samplings."""

    def __init__(self, samples: Samples, dt: float):
        self.dt = dt
        self.samples: Samples = np.asarray(samples, dtype=np.float64) - np.mean(samples)
        self._coarser: dict[int, _Record] = {}

    @cached_property
    def peak(self) -> int:
        """Index of the largest sample."""
        return int(np.argmax(np.abs(self.samples)))

    @cached_property
    def energy(self) -> float:
        """Sum of the squared samples."""
        return float(self.samples @ self.samples)

    def every(self, step: int) -> _Record:
        """The record at every ``step``-th sample, the first one included."""
        if step == 1:
            return self
        if step not in self._coarser:
            self._coarser[step] = _Record(self.samples[::step], self.dt * step)
        return self._coarser[step]


def copies(records: Sequence[tuple[Samples, float]]) -> tuple[Copy, ...]:
    """Every record, samples [m/s²] and time step [s], that is a copy of an earlier one.

    ``original`` is the first of its kind.
    """
    prepared = [_Record(samples, dt) for samples, dt in records]
    copy_of: dict[int, Copy] = {}
    for original, number in combinations(range(len(prepared)), 2):
        if number in copy_of or original in copy_of:
            continue
        copy = _copy(prepared[original], prepared[number])
        if copy is not None:
            copy_of[number] = Copy(number, original, *copy)
    return tuple(copy_of[number] for number in sorted(copy_of))


def _copy(first: _Record, second: _Record) -> tuple[float, bool] | None:
    """The factor from one record to the other, and whether both are at the same times; None where it is no copy."""
    finer = first.dt / second.dt
    step = round(max(finer, 1.0 / finer))
    if step > FINER or abs(max(finer, 1.0 / finer) / step - 1.0) > SAME_STEP:
        return None
    first, second = (first, second.every(step)) if finer > 1.0 else (first.every(step), second)
    for lag in dict.fromkeys((0, second.peak - first.peak)):
        factor = _factor(first, second, lag)
        if factor is not None:
            # The longer of two that start together may hold no shaking after the end of the shorter one.
            end = min(len(first.samples), len(second.samples))
            is_quiet = all(np.sum(one.samples[end:] ** 2) <= ROUNDING * one.energy for one in (first, second))
            return factor, step == 1 and lag == 0 and is_quiet
    return None


def _factor(one: _Record, other: _Record, lag: int) -> float | None:
    """The factor from ``one`` to ``other``, which is ``lag`` samples later; None where they are different motions."""
    start = max(0, -lag)
    stop = min(len(one.samples), len(other.samples) - lag)
    about = slice(max(start, one.peak - ABOUT_PEAK), min(stop, one.peak + ABOUT_PEAK))
    if _unlike(one.samples[about], other.samples[about.start + lag : about.stop + lag]) > COARSE:
        return None
    first, second = one.samples[start:stop], other.samples[start + lag : stop + lag]
    if min(float(first @ first) / one.energy, float(second @ second) / other.energy) < LEAST_SHARED:
        return None
    first, second = first - first.mean(), second - second.mean()
    if _unlike(first, second) > ROUNDING:
        return None
    size = sqrt(float(second @ second) / float(first @ first))
    return size if float(first @ second) > 0.0 else -size


def _unlike(first: Samples, second: Samples) -> float:
    """1 − r² of two intervals of equal length, r their correlation; 1 where one is too short or holds no motion."""
    both = float(first @ first) * float(second @ second) if len(first) > 2 else 0.0
    return 1.0 - float(first @ second) ** 2 / both if both > 0.0 else 1.0
