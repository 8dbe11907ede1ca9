"""Motions of SimCenter's workflows (EE-UQ, R2D): JSON with the components of one motion, in a unit stated elsewhere.

    {"name": "RSN107", "dT": 0.005, "data_x": [0.001, ...], "data_y": [...], "PGA_x": 0.031, "PGA_y": 0.0129}

``dT`` in s; x and y are horizontal and z, where it is there, vertical; the azimuth of x is not stated. The unit of the
samples is that of ``TH_file`` under ``units`` of the workflow's input.json, "g" or "mps2". PGA may be missing, and is
the largest sample with or without its sign (NHERI-SimCenter/R2DExamples, E10 and E12; SimCenterBackendApplications,
modules/createEVENT/SimCenterEvent).
"""

from __future__ import annotations

import json
from math import isfinite
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from obspy import Stream

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import Format, size_of_unit, unit_sentence
from pounding_risk.motions.formats._text import check_step, quoted, recogniser, record_facts, text_of, trace_of

Samples = NDArray[np.float64]

KIND = "SimCenter JSON"
AXES = ("x", "y", "z")
SAME_PEAK = 0.02  # relative; peaks are written with few digits
AGAIN = "restore it, or write the motion again"
UNIT = (
    'states no unit; write unit = "g" or "m/s^2" under [records] of a scene, unit="g" in Python, --unit g on the '
    "command line: the workflow's input.json has it as TH_file under units"
)


@recogniser()
def _is_simcenter(start: str) -> bool:
    """True for JSON with the samples or the step of a motion as SimCenter names them."""
    text = start.removeprefix("ï»¿").lstrip()  # a byte-order mark, as latin-1
    return text.startswith("{") and any(f'"{key}"' in start for key in ("data_x", "data_y", "dT"))


def _read_simcenter(
    file: Any, headonly: bool = False, *, name: str = "", unit: str | None = None, **_kwargs: Any
) -> Stream:
    """One trace in m/s² for each component of a file, ``stats.channel`` x, y or z.

    Raises RecordError, with the line of a key, for JSON that is damaged, a key that is twice there, a file without step
    or samples, components of unequal length, a sample that is no finite number, a stated peak that is not that of the
    samples, and without a ``unit``.
    """
    name, text = text_of(file, name, KIND)
    facts = _loaded(name, text.removeprefix("ï»¿"))
    dt = facts.get("dT")
    stated_step = float(dt) if dt is not None and _is_number(dt) else None
    step = check_step(_place(name, text, "dT"), stated_step, "nothing" if dt is None else str(dt), "dT")
    columns = {axis: _samples(name, text, f"data_{axis}", facts) for axis in AXES if f"data_{axis}" in facts}
    if not set(columns) & {"x", "y"}:
        raise RecordError(f"{name}: has neither data_x nor data_y; a motion of SimCenter has one or both: {AGAIN}")
    counts = {axis: len(column) for axis, column in columns.items()}
    if len(set(counts.values())) > 1:
        listed = ", ".join(f"{count} in data_{axis}" for axis, count in counts.items())
        raise RecordError(f"{name}: samples are missing, there are {listed}; all have as many: {AGAIN}")
    if unit is None:
        raise RecordError(f"{name}: {UNIT}")
    size = size_of_unit(unit, name)
    station = str(facts["name"]) if isinstance(facts.get("name"), str) and facts["name"] else Path(name).stem
    traces = []
    for axis, column in columns.items():
        key, stated = f"PGA_{axis}", facts.get(f"PGA_{axis}")
        readings = (float(np.abs(column).max()), float(column.max()), float(-column.min()))
        if stated is not None and not (
            _is_number(stated) and any(abs(abs(stated) - one) <= SAME_PEAK * max(abs(stated), one) for one in readings)
        ):
            raise RecordError(
                f"{_place(name, text, key)}: {key} is {quoted(str(stated))}, and the samples go from "
                f"{column.min():.6g} to {column.max():.6g}; samples or peak are damaged: {AGAIN}"
            )
        record = record_facts(
            timed=False, state="processed", units=unit_sentence(unit, size), station=station, component=axis
        )
        samples = column.size if headonly else column
        traces.append(trace_of(samples, size, step, record, station=station[:40], channel=axis))
    return Stream(traces)


def _loaded(name: str, text: str) -> dict[str, Any]:
    """The object of a file; raises RecordError with the line of what is no JSON, and for a key that is twice there."""

    def unique(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
        keys = [key for key, _ in pairs]
        twice = next((key for key in keys if keys.count(key) > 1), None)
        if twice is not None:
            raise RecordError(f"{_place(name, text, twice)}: {quoted(twice)} is there twice; {AGAIN}")
        return dict(pairs)

    try:
        facts = json.loads(text, object_pairs_hook=unique)
    except json.JSONDecodeError as error:
        raise RecordError(
            f"{name}, line {error.lineno}: is no JSON at character {error.colno} ({error.msg}), and the file may be "
            f"cut; {AGAIN}"
        ) from None
    except (ValueError, RecursionError):  # a whole number of thousands of digits, brackets without end
        raise RecordError(f"{name}: holds a number or a nesting that no motion has; {AGAIN}") from None
    if not isinstance(facts, dict):
        raise RecordError(f"{name}: is JSON and no motion; {AGAIN}")
    return facts


def _samples(name: str, text: str, key: str, facts: dict[str, Any]) -> Samples:
    samples = facts[key]
    if not isinstance(samples, list) or len(samples) < 2:
        count = f"{len(samples)} samples" if isinstance(samples, list) else "no list"
        raise RecordError(f"{_place(name, text, key)}: {key} is {count}; a record needs at least 2 samples: {AGAIN}")
    wrong = next((at for at, sample in enumerate(samples) if not _is_number(sample)), None)
    if wrong is not None:
        raise RecordError(
            f"{_place(name, text, key, wrong)}: sample {wrong + 1} of {key} is {quoted(str(samples[wrong]))}; it must "
            f"be a finite number: {AGAIN}"
        )
    return np.array(samples, dtype=np.float64)


def _is_number(value: Any) -> bool:
    try:
        return isinstance(value, int | float) and not isinstance(value, bool) and isfinite(value)
    except OverflowError:
        return False


def _place(name: str, text: str, key: str, sample: int | None = None) -> str:
    """File and line of a key, or of one of its samples."""
    at = text.find(f'"{key}"')
    if at < 0:
        return name
    if sample is not None:
        at = text.find("[", at)
        for _ in range(sample):
            at = text.find(",", at + 1)
        at += len(text[at + 1 :]) - len(text[at + 1 :].lstrip()) + 1
    return f"{name}, line {text.count(chr(10), 0, at) + 1}"


FORMAT = Format(
    "SIMCENTER", "SimCenter JSON (.json)", (".json",), _is_simcenter, _read_simcenter, takes=("unit",), needs=("unit",)
)
