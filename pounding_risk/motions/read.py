"""Reading records: an id of the catalogue or of a published set, a file, an ObsPy trace, a generated motion.

`open_source` gives a checked trace in m/s² and the facts that go with it into the results: where it is from, its
checksum, whether it is raw or processed. `processed` makes a motion of it, which passes a treatment in one order:
window, polarity, amplitude, tail of zeros. `read_motion`, the records of a scene and those of a manifest all pass
`treated`; nothing else cuts or scales them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from hashlib import sha256
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue, formats, record_sets, scaling
from pounding_risk.motions.generated import Recipe, is_recipe, recipe, recipe_of
from pounding_risk.motions.motion import Motion, in_si, span_of, unit_doubts
from pounding_risk.motions.processing import DEFAULT_CHAIN, Step, read_steps
from pounding_risk.motions.quality import AT_REST, LASTING, OFFSET_OF_PEAK, failed, quality
from pounding_risk.motions.record import (
    FACTOR_OF_SITE,
    GENERATED,
    PROCESSED,
    RAW,
    STILL,
    Source,
    check_samples,
    check_shaking,
    recording,
    site_of,
)
from pounding_risk.motions.request import AS_RECORDED, REVERSED, RecordRequest, conflicts
from pounding_risk.units import PGA, SCALE, STEP, TAIL, shown

if TYPE_CHECKING:
    from obspy import Stream, Trace

CHANGE_OF_PEAK = 0.02
IN_MEMORY = "ObsPy trace"


def read_motion(
    source: str | Path | Trace | Source | Recipe,
    *,
    window: tuple[float | str, float | str] | None = None,
    pga: float | str | None = None,
    scale: float | str | None = None,
    processing: str | Sequence[Mapping[str, Any] | Step] = "auto",
    polarity: str = AS_RECORDED,
    tail: float | str = 0.0,
    unit: str | None = None,
    dt: float | str | None = None,
) -> Motion:
    """Read the ground motion of a record; process, cut and scale it.

    Parameters
    ----------
    source : str, Path, obspy.Trace or Recipe
        An id of the catalogue ("RSN6-180") or of a published set, a path to a file of a known format (of several
        components one is named after "#": "quake.V2A#N28W"), a trace in m/s², or a generated motion
        ("ricker: pga=0.4 g, period=0.8 s").
    window : (start, end), optional
        Part of the processed record that is kept [s].
    pga : float or str, optional
        Peak ground acceleration to which the motion is scaled [m/s², or text such as "0.5 g"].
    scale : float or str, optional
        Factor of the motion, in place of ``pga``.
    processing : str or sequence of mapping
        "auto" filters and corrects a raw record and leaves a processed one as it is, "none" leaves both; a list of
        tables such as ``[{"step": "mean"}]`` names the steps (`pounding_risk.motions.processing`).
    polarity : str
        "as recorded" or "reversed".
    tail : float or str
        Duration of zeros after the motion [s].
    unit : str, optional
        Unit of the samples, such as "cm/s^2", of a file that does not state it.
    dt : float or str, optional
        Time step [s] of a file that does not state it.

    Returns
    -------
    Motion
        Acceleration in m/s², with the facts of its record, a sentence for each step and one for each doubt.

    Raises
    ------
    RecordError
        For what cannot be read or trusted; the sentence says how to repair it.

    Notes
    -----
    Window, polarity, amplitude and tail follow the processing, in this order. Numbers are in SI, text has its unit
    ("6 s", "0.5 g").
    """
    for _, sentence in conflicts([key for key, given in (("pga", pga), ("scale", scale)) if given is not None]):
        raise RecordError(sentence)
    if polarity not in (AS_RECORDED, REVERSED):
        raise RecordError(f'polarity: {shown(polarity)} is not one; it may be "{AS_RECORDED}" or "{REVERSED}"')
    request = RecordRequest(
        window=None if window is None else span_of(window),
        pga=None if pga is None else in_si("pga", pga, PGA),
        scale=None if scale is None else in_si("scale", scale, SCALE),
        tail=in_si("tail", tail, TAIL),
    )
    return treated([processed(open_source(source, unit=unit, dt=_step(dt)), processing)], request, polarity)[0]


def generate_motion(kind: str, /, **keys: Any) -> Motion:
    """Generate a ground motion that is no record: a pulse, a harmonic, a sweep, noise.

    Parameters
    ----------
    kind : str
        One of `pounding_risk.motions.motion_kinds`, such as "ricker" or "kanai_tajimi".
    **keys
        Keys of the kind, as in ``[[records.generated]]`` of a scene: floats in SI, or text with a unit.

    Returns
    -------
    Motion
        Acceleration in m/s², with sentences on its step, its error between samples and how the ground ends.

    Raises
    ------
    RecordError
        For an unknown kind or key, a value out of range, values that do not go together, and a step that is too long.

    Examples
    --------
    >>> pulse = generate_motion("ricker", pga="0.4 g", period="0.8 s")
    >>> pulse.dt, round(pulse.pga, 3)
    (0.005, 3.923)
    """
    return read_motion(recipe(kind, **keys))


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
        path, component = formats.split_component(source)
        opened = _of_file(path, formats.read_file(path, component, unit=unit, dt=dt))
    else:
        opened = _of_trace(source)
    return _checked(opened, unit, dt)


def components(path: Path, *, unit: str | None = None, dt: float | None = None) -> tuple[Source, ...]:
    """Every component of a file, as `open_source` gives one."""
    readings = formats.read_components(path, unit=unit, dt=dt)
    return tuple(_checked(_of_file(path, file_read), unit, dt) for file_read in readings)


def generated_sources(source: str | Recipe) -> tuple[Source, ...]:
    """Every motion of a recipe or of its text, one for each seed, as `open_source` gives one."""
    recipe = source if isinstance(source, Recipe) else recipe_of(source)
    return tuple(_checked(opened, None, None) for opened in recipe.sources())


def file_name(source: Source) -> str:
    """A short name of a record among others: that of its file with its component, or its id."""
    path, component = formats.split_component(source.name)
    if not path.is_file():
        return str(source.record["id"])
    return f"{path.name}{formats.COMPONENT}{component}" if component else path.name


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
    sentence = None if unit is None else formats.unit_sentence(unit, formats.size_of_unit(unit, "unit"))
    if sentence is not None and not source.units.startswith(sentence):
        stated = source.units.partition(";")[0].removeprefix("units: ")
        repair = "; where its samples are no counts, take that StationXML away" if stated.startswith("counts, ") else ""
        doubts.append(f'the unit "{unit}" that is given changes nothing: the record states its own ({stated}){repair}')
    if dt is not None and dt != stats.delta:
        words = f"changes nothing: the record states its own ({stats.delta:g} s)"
        doubts.append(f"the time step {dt:g} s that is given {words}")
    return source._replace(doubts=(*source.doubts, *doubts))


def _is_id(source: str) -> bool:
    """True for an id of the catalogue, and for a word that looks like one rather than like a path."""
    looks_like_path = Path(source).suffix or "/" in source or "\\" in source or Path(source).exists()
    return catalogue.has(source) or not looks_like_path


def _of_file(path: Path, file_read: formats.FileRead) -> Source:
    component = f"{formats.COMPONENT}{file_read.component}" if file_read.component else ""
    facts, id = _facts(file_read.trace), f"{path.stem}{component}"
    if path.suffix and path.suffix[1:].lower() == str(facts["component"] or "").lower():
        id = path.name  # K-NET names its files by their components
    record = {**facts, "id": id, "state": file_read.state, "format": file_read.format}
    record.update(file=str(path), sha256=file_read.sha256, origin="a file of the user", terms="")
    doubt = str(file_read.trace.stats.record.get("doubt") or "")
    return Source(f"{path}{component}", file_read.trace, record, file_read.units, (doubt,) if doubt else ())


def _of_trace(source: Any) -> Source:
    """A trace in memory: in m/s², and processed unless one of the readers of this package says raw."""
    source = formats.one_trace(source)
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


def processed(source: Source, processing: str | Sequence[Mapping[str, Any] | Step] = "auto") -> Motion:
    """A record after the steps of ``processing``, as in `read_motion`, before window, polarity, amplitude and tail."""
    record = {**source.record, "polarity": AS_RECORDED, "factor": 1.0}
    history = (*source.trace.stats.get("processing", []), source.units)
    motion = Motion(str(record["id"]), source.trace.data, float(source.trace.stats.delta), record, history)
    if not record.get(STILL):
        check_shaking(motion.acceleration, source.name, "its sensitivity and unit, or leave the record out")
    when = "as generated" if record["state"] == GENERATED else "as recorded"
    units = () if record.get(STILL) else unit_doubts(record["pga_recorded"], when)
    motion = motion.doubted((*source.doubts, *units))
    # A window comes after the chain and not before: the offset is seen in the quiet before the earthquake
    # and the drift at its end, and a filter rings where a record is cut in mid-shaking. A cut that is to come
    # earlier, such as one of two earthquakes in a file, is a step of the chain.
    motion = _after_steps(motion, _chain(processing, record["state"]))
    if site := site_of(record):
        motion = replace(motion, processing=(*motion.processing, f"site: {site}"))
        factor = record[FACTOR_OF_SITE]
        motion = motion if factor == 1.0 else scaling.by_factor(motion, factor, f"the factor of {record['site']}")
    return motion


def treated(motions: Sequence[Motion], request: RecordRequest, polarity: str = AS_RECORDED) -> list[Motion]:
    """Cut, turn round and scale motions as a request has it, all at once where their median sets the amplitude.

    The motions are processed, and turned to the row where that is requested; they are the ensemble where there is a
    median to reach. Raises RecordError for a window or tail out of range, a window without shaking, and an amplitude
    out of reach.
    """
    shaking = [_before_scaling(motion, request.window, polarity) for motion in motions]
    if request.pga is not None:
        shaking = [motion.scaled_to(request.pga) for motion in shaking]
    if request.sa is not None:
        if request.sa.value is None:
            raise RecordError("sa: names a period and no value to scale to; give one, such as 0.4 g")
        at_period = (request.sa.value, request.sa.period, request.sa.damping)
        shaking = [scaling.to_spectral_acceleration(motion, *at_period) for motion in shaking]
    if request.to_median is not None:  # of their ensemble; both components of a recording share one factor
        aim = request.to_median
        measure, damping = (aim, 0.05) if isinstance(aim, str) else (f"sa({aim.period!r} s)", aim.damping)
        groups = [recording(motion.record, motion.name) for motion in shaking]
        shaking = list(scaling.to_median(shaking, measure, groups=groups, damping=damping))
    if request.scale is not None:
        shaking = [scaling.by_factor(motion, request.scale) for motion in shaking]
    # Generated ground says itself how it starts, unless it is cut.
    is_checked = [motion.record.get("state") != GENERATED or request.window is not None for motion in shaking]
    shaking = [motion.checked() if check else motion for motion, check in zip(shaking, is_checked, strict=True)]
    return [motion.with_tail(request.tail) if request.tail else motion for motion in shaking]


def _before_scaling(motion: Motion, window: tuple[float, float] | None, polarity: str) -> Motion:
    """The window of a motion, in the polarity that is wanted; raises RecordError where it holds no shaking."""
    where, repair = str(motion.record.get("source") or motion.name), "its processing"
    if window is not None:
        motion = motion.within(*window)
        where, repair = f"{where}, {window[0]:g} to {window[1]:g} s", "its window"
    if not motion.record.get(STILL):
        check_shaking(motion.acceleration, where, repair)
    return motion.reversed() if polarity == REVERSED else motion


def read_trace(
    source: str | Path | Trace, *, unit: str | None = None, dt: float | str | None = None, **choices: Any
) -> Trace:
    """Read a record as `read_motion` does, as an ObsPy trace.

    Parameters
    ----------
    source : str, Path or obspy.Trace
        As for `read_motion`.
    unit : str, optional
        As for `read_motion`.
    dt : float or str, optional
        As for `read_motion`.
    **choices : dict
        The other arguments of `read_motion`.

    Returns
    -------
    obspy.Trace
        Acceleration in m/s²; ``stats.processing`` has the history.
    """
    opened = open_source(source, unit=unit, dt=_step(dt))
    motion = read_motion(opened, **choices)
    trace = opened.trace.copy()  # the one that was handed over stays as it was
    trace.data = np.array(motion.acceleration)
    if trace.stats.delta != motion.dt:
        trace.stats.delta = motion.dt
    trace.stats.starttime += motion.record.get("cut_from_start", 0.0)
    trace.stats.processing = list(motion.processing)
    return trace


def read_stream(source: str | Path | Stream, **choices: Any) -> Stream:
    """Read every component of a file, or of an ObsPy stream, as `read_trace` reads one.

    Parameters
    ----------
    source : str, Path or obspy.Stream
        A file with one or more components, a stream of traces in m/s² without gaps, or what `read_trace` takes.
    **choices : dict
        The arguments of `read_trace`; each component is processed by itself.

    Returns
    -------
    obspy.Stream
        One trace for each component, in m/s².
    """
    from obspy import Stream

    if isinstance(source, Stream):
        return Stream([read_trace(trace, **choices) for trace in source])
    if isinstance(source, str | Path) and Path(source).is_file():
        unit, dt = choices.pop("unit", None), choices.pop("dt", None)
        opened = components(Path(source), unit=unit, dt=_step(dt))
        return Stream([read_trace(component, **choices) for component in opened])
    return Stream([read_trace(source, **choices)])


def _step(dt: float | str | None) -> float | None:
    """A time step [s] from a number or text, where one is given."""
    return None if dt is None else in_si("dt", dt, STEP)


def _after_steps(motion: Motion, chain: Sequence[Step]) -> Motion:
    """Apply every step of the chain; flag a change of PGA of more than 2 %, and an offset that is left."""
    samples = motion.acceleration
    before = float(np.abs(samples - samples.mean() if motion.record["state"] == RAW else samples).max())
    if motion.record["state"] == GENERATED and not chain:
        return motion  # the checks look for faults of instruments
    if "interpolation_error" in motion.record:  # which is that of the formula, before any step
        motion = replace(motion, record={k: v for k, v in motion.record.items() if k != "interpolation_error"})
    motion = motion.doubted(failed(quality(samples, motion.dt, state=motion.record["state"], checks=LASTING)))
    for step in chain:
        motion = motion.after(step.apply(motion.acceleration.copy(), motion.dt))  # a step may write to its samples
    flags: list[str] = []
    # A baseline correction reports how the motion ends, and may leave a permanent displacement in.
    if not any(step.name == "baseline" for step in chain):
        flags += failed(quality(motion.acceleration, motion.dt, checks=AT_REST))
    if chain and before > 0.0 and abs(motion.pga / before - 1.0) > CHANGE_OF_PEAK:
        flags.append(f"processing changed PGA by {100.0 * (motion.pga / before - 1.0):+.1f} %")
    offset = abs(float(motion.acceleration.mean()))
    if offset > OFFSET_OF_PEAK * motion.pga:
        flags.append(f"the mean of the record is {100.0 * offset / motion.pga:.0f} % of its PGA: subtract it")
    return motion.doubted(flags)


def _chain(processing: Any, state: str) -> Sequence[Step]:
    """The steps that the argument ``processing`` stands for."""
    if not isinstance(processing, str) and isinstance(processing, Sequence):
        return read_steps(processing)
    if processing == "auto":
        # Filtering a processed record again is the commonest way to damage one.
        return DEFAULT_CHAIN if state == RAW else ()
    if processing != "none":
        raise RecordError(
            f'processing: {shown(processing)} is not one; it may be "auto", "none" or a list of steps such '
            'as [{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]'
        )
    return ()
