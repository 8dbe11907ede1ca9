"""Opening a record: an id of the catalogue or of a published set, a file, an ObsPy trace, a generated motion.

Each gives a checked trace in m/s² and the facts that go with it into the results: where it is from, its checksum,
whether it is raw or processed.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from hashlib import sha256
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue, record_sets
from pounding_risk.motions.formats import COMPONENT, FileRead, one_trace, read_components, read_file
from pounding_risk.motions.formats._unit import sentence, size_of
from pounding_risk.motions.generated import Recipe, is_recipe, recipe_of
from pounding_risk.motions.processing.signals import LEAST_SHAKING, Samples
from pounding_risk.motions.record import PROCESSED, RAW, Source

IN_MEMORY = "ObsPy trace"
USABLE = 1.25  # lowest usable frequency over the filter's lower corner, of the flatfile of NGA-West2
LARGEST = 1e30  # m/s²: far above any motion, and its square is still a number
VERTICALS = {"UP", "U-D", "DWN", "DOWN", "DN", "UD", "UD1", "UD2", "V", "VER", "VERT", "VERTICAL", "Z"}


def open_source(source: Any, *, unit: str | None = None, dt: float | None = None) -> Source:
    """Open the record that ``source`` names, with its samples checked.

    ``source`` is an id of the catalogue or of a published set, a path, a path with one of its components after "#",
    an ObsPy trace, a generated motion such as "ricker: pga=0.4 g, period=0.8 s", or a Source already. ``unit`` and
    ``dt`` [s] are of files that do not state theirs.
    """
    if isinstance(source, Source):
        opened = source
    elif isinstance(source, Recipe) or (isinstance(source, str) and is_recipe(source)):
        opened = _one(source)
    elif isinstance(source, str) and _is_id(source):
        opened = _of_id(source)
    elif isinstance(source, str | Path):
        path, component = split_component(source)
        opened = _of_file(path, read_file(path, component, unit=unit, dt=dt))
    else:
        opened = _of_trace(source)
    return _checked(opened, unit, dt)


def components(path: Path, *, unit: str | None = None, dt: float | None = None) -> tuple[Source, ...]:
    """Every component of a file, as `open_source` gives one."""
    return tuple(_checked(_of_file(path, file_read), unit, dt) for file_read in read_components(path, unit=unit, dt=dt))


def generated(source: str | Recipe) -> tuple[Source, ...]:
    """Every motion of a recipe or of its text, one for each seed, as `open_source` gives one."""
    recipe = source if isinstance(source, Recipe) else recipe_of(source)
    return tuple(_checked(opened, None, None) for opened in recipe.sources())


def _one(source: str | Recipe) -> Source:
    """The only motion of a recipe; raises RecordError where it asks for several."""
    recipe = source if isinstance(source, Recipe) else recipe_of(source)
    if dict(recipe.options).get("count", 1) > 1:
        raise RecordError(f"{recipe.kind}, count: several motions, where one is asked for; leave count out")
    return recipe.sources()[0]


def split_component(source: str | Path) -> tuple[Path, str]:
    """File and component of a name such as "quake.V2A#N28W"; a file whose own name has a # is taken as it is."""
    path, _, component = str(source).rpartition(COMPONENT)
    return (Path(path), component) if path and not Path(source).exists() else (Path(source), "")


def file_name(source: Source) -> str:
    """A short name of a record among others: that of its file with its component, or its id."""
    path, component = split_component(source.name)
    return f"{path.name}{COMPONENT if component else ''}{component}" if path.is_file() else str(source.record["id"])


def is_vertical(record: Mapping[str, Any]) -> bool:
    """True for a component that is vertical by its name: UP, BOL-UP, U-D, DWN, V, Z, HNZ, BHZ10 and the like."""
    name = str(record.get("component") or "").upper()
    ends = {name, re.split(r"[-_ .]", name)[-1]}
    return record.get("azimuth") is None and bool(VERTICALS & ends or re.fullmatch(r"[A-Z]{2}Z\d{0,2}", name))


def lowest_usable(record: Mapping[str, Any]) -> float | None:
    """The lowest frequency [Hz] that the filter of a record has left; None where it is not known.

    What the record states, or 1.25 times the lower corner of its filter (PEER NGA-West2, Ancheta et al. 2013).
    """
    return record.get("lowest_usable_frequency") or USABLE * float(record.get("low_corner") or 0.0) or None


def _checked(source: Source, unit: str | None, dt: float | None) -> Source:
    """A checked source with its peak among the facts, and a doubt for a ``unit`` or ``dt`` that went unused."""
    check_samples(source.trace.data, source.trace.stats.delta, source.name)
    samples = np.asarray(source.trace.data, dtype=np.float64)
    if source.record["format"] != IN_MEMORY:
        source.record["source"] = source.name
    offset = samples.mean() if source.record["state"] == RAW else 0.0
    source.record["pga_recorded"] = float(np.abs(samples - offset).max())
    return source._replace(doubts=(*source.doubts, *_unused(source, unit, dt)))


def _unused(source: Source, unit: str | None, dt: float | None) -> tuple[str, ...]:
    """A sentence for a ``unit``, and for a time step ``dt`` [s], that the user gives and the record overrides."""
    sentences = []
    if unit is not None and not source.units.startswith(sentence(unit, size_of(unit, "unit"))):
        stated = source.units.partition(";")[0].removeprefix("units: ")
        sentences.append(f'the unit "{unit}" that is given changes nothing: the record states its own ({stated})')
    if dt is not None and dt != source.trace.stats.delta:
        stated = f"{source.trace.stats.delta:g} s"
        sentences.append(f"the time step {dt:g} s that is given changes nothing: the record states its own ({stated})")
    return tuple(sentences)


def _is_id(source: str) -> bool:
    """True for an id of the catalogue, and for a word that looks like one rather than like a path."""
    if any(entry.id == source for entry in catalogue.entries()):
        return True
    return not (Path(source).suffix or "/" in source or "\\" in source or Path(source).exists())


def _of_id(id: str) -> Source:
    """The record of the catalogue, or else the member of a published set."""
    member = None if any(entry.id == id for entry in catalogue.entries()) else record_sets.find(id)
    return record_sets.load(member) if member else _of_catalogue(id)


def _of_catalogue(id: str) -> Source:
    entry = catalogue.entry(id, record_sets.similar(id))
    trace = catalogue.load(id)[0]
    keys = ("id", "event", "magnitude", "date", "station", "component", "azimuth", "state", "format", "file")
    more = ("package", "version", "sha256", "origin", "terms", "note")
    record = {key: getattr(entry, key) for key in (*keys, *more)}
    units = f"counts, divided by {entry.sensitivity:.10g} counts per m/s²"
    if entry.format == "PEER_AT2":
        units = "g, times 9.80665 m/s²"
    else:
        record["start"] = trace.stats.starttime.isoformat()
    return Source(id, trace, record, f"units: {units}")


def _of_file(path: Path, file_read: FileRead) -> Source:
    name = f"{path}{COMPONENT}{file_read.component}" if file_read.component else str(path)
    facts = _told(file_read.trace)
    id = f"{path.stem}{COMPONENT}{file_read.component}" if file_read.component else path.stem
    if path.suffix and path.suffix[1:].lower() == str(facts["component"] or "").lower():
        id = path.name  # K-NET names its files by their components
    record = {**facts, "id": id, "state": file_read.state, "format": file_read.format}
    record.update(file=str(path), sha256=file_read.sha256, origin="a file of the user", terms="")
    return Source(name, file_read.trace, record, file_read.units)


def _of_trace(source: Any) -> Source:
    """A trace in memory: in m/s², and processed unless one of the readers of this package says raw."""
    source = one_trace(source)
    name = source.id if source.id.strip(".") else "trace"
    if source.stats.calib != 1.0:
        raise RecordError(
            f"{name}: the trace has calib {source.stats.calib:g}, so its samples are no m/s² yet; multiply "
            "them by it and set stats.calib = 1"
        )
    state = source.stats.get("record", {}).get("state", PROCESSED)
    record = {**_told(source), "id": name, "state": state, "format": IN_MEMORY, "file": ""}
    check_samples(source.data, source.stats.delta, name)
    digest = sha256(np.ascontiguousarray(source.data, dtype="<f8").tobytes()).hexdigest()
    record.update(sha256=digest, origin="an ObsPy trace of the user", terms="")
    return Source(name, source, record, "units: m/s², as given")


def _told(trace: Any) -> dict[str, Any]:
    """The facts of a recording in the header of a trace."""
    record = dict(trace.stats.get("record", {}))
    timed = record.pop("timed", True) and trace.stats.starttime.timestamp != 0.0  # ObsPy's start where none is stated
    plain = {"event": "", "date": str(trace.stats.starttime.date) if timed else ""}
    plain |= {"station": trace.stats.station, "component": trace.stats.channel}
    start = {"start": trace.stats.starttime.isoformat()} if timed else {}
    for key in ("state", "units"):
        record.pop(key, None)
    return {**plain, **record, **start}


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
    """Raise RecordError for samples without motion, which would count as a record that causes no contact.

    Parameters
    ----------
    samples : array, shape (n,)
        Acceleration [m/s²], with its offset or without.
    name : str
        File or record that the message names.
    repair : str
        What to check, as the end of "check ...".

    Raises
    ------
    RecordError
        For samples that are all equal, and for a range that no strong-motion instrument resolves.
    """
    half_range = 0.5 * (float(samples.max()) - float(samples.min()))
    if half_range >= LEAST_SHAKING:
        return
    if half_range == 0.0:
        variation = f"every sample is {samples[0]:g} m/s²"
    else:
        variation = f"its samples vary by {half_range:.2g} m/s² about their middle, less than an instrument resolves"
    raise RecordError(f"{name}: {variation}: the record holds no motion; check {repair}")
