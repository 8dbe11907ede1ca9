"""The table [records] of a scene: its keys from text to SI, and what they exclude or need of each other."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

from pounding_risk._common.words import nearest
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import known_steps, read_steps
from pounding_risk.motions.request import (
    AS_RECORDED,
    MEDIANS,
    POLARITIES,
    SOURCES,
    Spectral,
    StepTable,
    conflicts,
    matching,
)
from pounding_risk.scene.toml import Fault, as_list, table
from pounding_risk.scene.values import Several, Unreadable, each, list_of, words
from pounding_risk.units import DAMPING, PERIOD, PGA, TIME, Quantity, parse, shown

STEPS_EXAMPLE = '[{step = "mean"}, {step = "bandpass", low = "0.1 Hz"}]'


def catalogue_ids() -> list[str]:
    """The ids of the records that come with the project."""
    from pounding_risk.motions.catalogue import entries

    return [entry.id for entry in entries()]


def window(value: Any) -> tuple[float, float]:
    """Start and end of the part of a record that is kept [s]."""
    if not isinstance(value, list) or len(value) != 2:
        raise Unreadable(f'{shown(value)} is not a start and an end; write window = ["0 s", "6 s"]')
    start, end = each(value, lambda item: parse(item, TIME))
    if end <= start:
        what = "is empty" if end == start else "ends before it starts"
        raise Unreadable(f'the window {shown(value)} {what}; write start and end, such as window = ["0 s", "6 s"]')
    return start, end


def polarity(value: Any) -> tuple[str, ...]:
    """ "as recorded", "reversed", or both as a list."""
    asked = value if isinstance(value, list) else [value]
    if not asked:
        raise Unreadable(f'the list is empty; write polarity = ["{AS_RECORDED}"]')

    def read(item: Any) -> str:
        if not isinstance(item, str) or item not in POLARITIES:
            hint = nearest(item, POLARITIES) if isinstance(item, str) else ""
            raise Unreadable(
                f'{shown(item)} is not a polarity{hint}; it may be "as recorded", "reversed", '
                'or ["as recorded", "reversed"]'
            )
        return item

    return tuple(each(asked, read, distinct=True))


def processing(value: Any) -> str | tuple[StepTable, ...]:
    """ "auto", "none", or a list of step tables, whose options are text with a unit."""
    if isinstance(value, list) and value:
        return _steps(value)
    if isinstance(value, dict):
        raise Unreadable(f"{shown(value)} is one table; write the steps as a list, such as {STEPS_EXAMPLE}")
    if value not in ("auto", "none"):
        raise Unreadable(
            f'{shown(value)} is not a processing; it may be "auto" (raw records get the default chain, '
            f'processed ones are left alone), "none", or a list of steps such as {STEPS_EXAMPLE}'
        )
    return str(value)


def _steps(asked: list[Any]) -> tuple[StepTable, ...]:
    """Every step of a list; all its faults are told at once, each with its place."""
    found: list[StepTable] = []
    faults: list[tuple[tuple[str | int, ...], str]] = []
    for index, step in enumerate(asked):
        wrong = _fault(step if not isinstance(step, dict) or "step" not in step else {"step": step["step"]})
        if wrong:
            faults.append(((index,), wrong))
            continue
        name = step["step"]
        options = {key: value for key, value in step.items() if key != "step"}
        wrongs = {key: _fault({"step": name, key: value}, key) for key, value in options.items()}
        faults += [((index, key), wrong) for key, wrong in wrongs.items() if wrong]
        if not any(wrongs.values()):
            (read,) = read_steps([step])
            found.append(StepTable({"step": read.name, **read.options}))
    if faults:
        raise Several(faults)
    return tuple(found)


def _fault(table: Any, key: str = "") -> str:
    """What is wrong with a step's table, or with its option ``key``; "" where nothing is."""
    try:
        kind = known_steps()[table["step"]].options.get(key) if key else None
        if isinstance(kind, Quantity):
            parse(table[key], kind)  # a bare number is SI to a script, but has no unit in a scene
        read_steps([table])
    except RecordError as error:
        return str(error).partition(": ")[2]  # without the number of the step: the key tells it
    except ValueError as error:
        return str(error)
    return ""


def record_names(value: Any) -> tuple[str, ...]:
    """Reader of ids of the catalogue, one or a list; raises Unreadable for an unknown one."""
    asked = list_of(value, 'names = ["RSN6-180"]')
    known = catalogue_ids()

    def read(item: Any) -> str:
        if not isinstance(item, str) or item not in known:
            hint = nearest(item, known, 0.4) or _meant(item) if isinstance(item, str) else ""
            raise Unreadable(
                f"{shown(item)} is not a record of the catalogue{hint}; "
                "`pounding-risk records` lists them, and a file of your own goes into files"
            )
        return item

    return tuple(each(asked, read, distinct=True))


def _meant(word: str) -> str:
    """The records of a station or earthquake that is written in place of an id."""
    from pounding_risk.motions.catalogue import similar

    near = " or ".join(f'"{id}"' for id in similar(word))
    return f" (did you mean {near}?)" if near else ""


def record_files(value: Any) -> tuple[str, ...]:
    """Reader of names or patterns of record files, or of folders."""
    asked = list_of(value, 'files = ["my/*.AT2"]')
    return tuple(each(asked, words("my/*.AT2"), distinct=True))


def record_set(value: Any) -> str:
    """Reader of the name of a published record set; raises Unreadable for an unknown one."""
    from pounding_risk.motions.record_sets import SETS

    if not isinstance(value, str) or value not in SETS:
        hint = nearest(value, SETS, 0.4) if isinstance(value, str) else ""
        raise Unreadable(f"{shown(value)} is not a record set{hint}; it may be {', '.join(SETS)}")
    return value


def unit(value: Any) -> str:
    """Reader of the unit of acceleration samples, such as "cm/s^2"."""
    from pounding_risk.motions.formats._unit import size_of

    try:
        size_of(value, "")
    except RecordError as error:
        raise Unreadable(str(error).removeprefix(": ")) from None
    return str(value).strip()


def spectral(example: str, *, with_value: bool) -> Callable[[Any], Spectral]:
    """A reader of {value, period, damping}: spectral acceleration; ``value`` is needed or not allowed."""
    kinds = {**({"value": PGA} if with_value else {}), "period": PERIOD, "damping": DAMPING}

    def read(asked: Any) -> Spectral:
        if not isinstance(asked, dict):
            raise Unreadable(f"{shown(asked)} is not a table; write {example}")
        faults: list[tuple[tuple[str | int, ...], str]] = []
        found: dict[str, float] = {}
        for key, value in asked.items():
            try:
                if key not in kinds:
                    raise Unreadable(f"unknown key{nearest(key, kinds)}; it takes {', '.join(kinds)}")
                found[key] = parse(value, kinds[key])
            except ValueError as error:
                faults.append(((key,), str(error)))
        needed = [key for key in kinds if key not in asked and key != "damping"]
        faults += [((key,), f"missing; write {example}") for key in needed]
        if faults:
            raise Several(faults)
        return Spectral(**found)

    return read


def to_median(value: Any) -> str | Spectral:
    """ "pga" or "pgv", or a table with the period of Sa."""
    example = '"pgv", or {period = "1 s"}'
    if isinstance(value, dict):
        return spectral(f"to_median = {example}", with_value=False)(value)
    if value not in MEDIANS:
        raise Unreadable(f"{shown(value)} is not a measure of the records; write to_median = {example}")
    return str(value)


def across_keys(raw: Mapping[str, Any]) -> Iterator[Fault]:
    """Keys of [records] that exclude or need each other, or a key of [grid]."""
    if not isinstance(raw.get("records"), dict):
        return
    keys, grid = raw["records"], table(raw, "grid")
    given = [key for key in SOURCES if key in keys]
    if not given:
        example = 'missing; write names = ["RSN6-180"], files = ["my/*.AT2"], or set = "fema-p695-farfield"'
        yield Fault(("records", "names"), example, absent=True)
    for key, sentence in conflicts(keys, grid_pga="pga" in grid):
        yield Fault(("records", key), sentence)


def missing_files(raw: Mapping[str, Any], folder: Path) -> Iterator[Fault]:
    """Names and patterns of ``records.files`` that no file answers to, and a manifest that is not there."""
    named = table(raw, "records").get("manifest")
    if isinstance(named, str) and named.strip() and not (folder / named).is_file():
        sentence = f"no such file in {folder.resolve()}; files are relative to the scene file's folder"
        yield Fault(("records", "manifest"), sentence)
    for index, pattern in enumerate(as_list(table(raw, "records").get("files"))):
        if not isinstance(pattern, str) or not pattern.strip():
            continue
        try:
            if matching(folder, pattern):
                continue
        except RecordError as error:
            yield Fault(("records", "files", index), str(error))
            continue
        beside = (folder / pattern).parent
        others = [entry.name for entry in beside.iterdir()] if beside.is_dir() else []
        hint = nearest(Path(pattern).name, others)
        yield Fault(
            ("records", "files", index),
            f"no file answers to {shown(pattern)} in {folder.resolve()}{hint}; "
            "files are relative to the scene file's folder",
        )
