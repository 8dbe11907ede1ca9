"""Opening a record: an id of the catalogue or of a published set, a file, an ObsPy trace, a generated motion.

Each gives a checked trace in m/s² and the facts that go with it into the results: where it is from, its checksum,
whether it is raw or processed.
"""

from __future__ import annotations

from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue, record_sets
from pounding_risk.motions.formats import COMPONENT, FileRead, one_trace, read_components, read_file, split_component
from pounding_risk.motions.formats._unit import sentence, size_of
from pounding_risk.motions.generated import Recipe, is_recipe, recipe_of
from pounding_risk.motions.record import PROCESSED, RAW, Source, check_samples

IN_MEMORY = "ObsPy trace"


def open_source(source: Any, *, unit: str | None = None, dt: float | None = None) -> Source:
    """Open the record that ``source`` names, with its samples checked.

    ``source`` is an id of the catalogue or of a published set, a path, a path with one of its components after "#",
    an ObsPy trace, a generated motion such as "ricker: pga=0.4 g, period=0.8 s", or a Source already. ``unit`` and
    ``dt`` [s] are of files that do not state theirs.
    """
    if isinstance(source, Source):
        opened = source
    elif isinstance(source, Recipe) or (isinstance(source, str) and is_recipe(source)):
        recipe = source if isinstance(source, Recipe) else recipe_of(source)
        if dict(recipe.options).get("count", 1) > 1:
            raise RecordError(f"{recipe.kind}, count: several motions, where one is required; leave count out")
        opened = recipe.sources()[0]
    elif isinstance(source, str) and _is_id(source):
        member = None if catalogue.has(source) else record_sets.find(source)
        opened = record_sets.load(member) if member else catalogue.source(source, record_sets.similar(source))
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


def file_name(source: Source) -> str:
    """A short name of a record among others: that of its file with its component, or its id."""
    path, component = split_component(source.name)
    return f"{path.name}{COMPONENT if component else ''}{component}" if path.is_file() else str(source.record["id"])


def _checked(source: Source, unit: str | None, dt: float | None) -> Source:
    """A checked source with its peak among the facts, and a doubt for a ``unit`` or ``dt`` that it overrides."""
    stats = source.trace.stats
    check_samples(source.trace.data, stats.delta, source.name)
    samples = np.asarray(source.trace.data, dtype=np.float64)
    if source.record["format"] != IN_MEMORY:
        source.record["source"] = source.name
    offset = samples.mean() if source.record["state"] == RAW else 0.0
    source.record["pga_recorded"] = float(np.abs(samples - offset).max())
    doubts = []
    if unit is not None and not source.units.startswith(sentence(unit, size_of(unit, "unit"))):
        stated = source.units.partition(";")[0].removeprefix("units: ")
        doubts.append(f'the unit "{unit}" that is given changes nothing: the record states its own ({stated})')
    if dt is not None and dt != stats.delta:
        words = f"changes nothing: the record states its own ({stats.delta:g} s)"
        doubts.append(f"the time step {dt:g} s that is given {words}")
    return source._replace(doubts=(*source.doubts, *doubts))


def _is_id(source: str) -> bool:
    """True for an id of the catalogue, and for a word that looks like one rather than like a path."""
    looks_like_path = Path(source).suffix or "/" in source or "\\" in source or Path(source).exists()
    return catalogue.has(source) or not looks_like_path


def _of_file(path: Path, file_read: FileRead) -> Source:
    name = f"{path}{COMPONENT}{file_read.component}" if file_read.component else str(path)
    facts = _facts(file_read.trace)
    id = f"{path.stem}{COMPONENT}{file_read.component}" if file_read.component else path.stem
    if path.suffix and path.suffix[1:].lower() == str(facts["component"] or "").lower():
        id = path.name  # K-NET names its files by their components
    record = {**facts, "id": id, "state": file_read.state, "format": file_read.format}
    record.update(file=str(path), sha256=file_read.sha256, origin="a file of the user", terms="")
    doubt = str(file_read.trace.stats.record.get("doubt") or "")
    return Source(name, file_read.trace, record, file_read.units, (doubt,) if doubt else ())


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
    record = {**_facts(source), "id": name, "state": state, "format": IN_MEMORY, "file": ""}
    check_samples(source.data, source.stats.delta, name)
    digest = sha256(np.ascontiguousarray(source.data, dtype="<f8").tobytes()).hexdigest()
    record.update(sha256=digest, origin="an ObsPy trace of the user", terms="")
    return Source(name, source, record, "units: m/s², as given")


def _facts(trace: Any) -> dict[str, Any]:
    """The facts of a recording in the header of a trace."""
    record = dict(trace.stats.get("record", {}))
    timed = record.pop("timed", True) and trace.stats.starttime.timestamp != 0.0  # ObsPy's start where none is stated
    plain = {"event": "", "date": str(trace.stats.starttime.date) if timed else ""}
    plain |= {"station": trace.stats.station, "component": trace.stats.channel}
    start = {"start": trace.stats.starttime.isoformat()} if timed else {}
    for key in ("state", "units", "doubt"):
        record.pop(key, None)
    return {**plain, **record, **start}
