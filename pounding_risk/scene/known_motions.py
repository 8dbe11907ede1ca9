"""Known motions of a scene: histories of floor displacements from a model of the user's own.

A building with ``displacement_history`` moves without contact as its files say: one CSV file for each record of the
scene, with the columns time [s], floor 1 [mm], floor 2 [mm] and so on, u relative to the ground, straight between the
samples. Times begin with the record and end where it ends, within a time step; before a first sample later than that
the floors are at rest. A history is that of one record at one amplitude, so that nothing here scales or reverses it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from dataclasses import replace
from functools import lru_cache
from hashlib import sha256
from math import inf
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.inputs import EXPORT, Unfit, cannot_be_read, read_whole, text_of
from pounding_risk._common.tables import csv_rows, split_unit, uneven
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.motions.request import REVERSED
from pounding_risk.scene.building_keys import INITIAL, OF_GROUND
from pounding_risk.scene.keys import Draft
from pounding_risk.scene.resolved_interfaces import OF_LINKS
from pounding_risk.scene.toml import Fault
from pounding_risk.units import Quantity, QuantityError, parse_cell, say

if TYPE_CHECKING:
    from pounding_risk.motions.motion import Motion
    from pounding_risk.scene.values import SceneValues

KEY = "displacement_history"  # of a building, and of the facts of a record that has histories beside it
HEAD = "write a head such as 'time [s],floor 1 [mm],floor 2 [mm]', the floors from the ground up"
TIME = Quantity("s", 0.0, inf, "time", open_high=True, example="0.01 s")
DISPLACEMENT = Quantity("m", -inf, inf, "displacement", open_low=True, open_high=True, example="12 mm")
MOST_FAULTS = 5  # of a file that are named
STEPS = 1.0 + 1e-6  # time steps by which a history may end before or after its record


class History(NamedTuple):
    """Displacements of a building's floors relative to the ground, straight between the samples."""

    times: NDArray[np.float64]  # s, rising, from 0
    floors: NDArray[np.float64]  # m, (times, floors)


class HistoryError(PoundingError):
    """A file that is no history; ``sentences`` has every fault."""

    def __init__(self, sentences: Sequence[str]):
        self.sentences = tuple(sentences)
        super().__init__("; ".join(sentences))


def has_known_motion(study: SceneValues) -> bool:
    """Whether a building of the scene moves as files say."""
    return any(building.displacement_history for building in study.buildings)


def check_computed(study: SceneValues, command: str) -> None:
    """Raise SceneError where a building of the scene moves as files say, in a command that runs contact."""
    for building in study.buildings:
        if building.displacement_history:
            sentence = (
                f"building.{building.name}.{KEY}: {command} needs a building that can be pushed, and the motion of "
                f"{building.name} is known without contact alone: it stays as the file says whatever strikes it; "
                "remove the key, and the building moves as its masses and stiffnesses say. Required gaps, P(contact) "
                "and code separations need no contact: scan, then assess"
            )
            raise SceneError(study.source, [sentence])


# ------------------------------------------------------------------------------------------------ files


def read_history(path: Path, floors: int) -> History:
    """The history of a file; raises HistoryError with its faults, by line.

    Parameters
    ----------
    path : Path
        A CSV file.
    floors : int
        How many floors the building has.
    """
    faults: list[str] = []
    try:
        rows = csv_rows(text_of(path, EXPORT), faults, HEAD)
    except Unfit as error:
        raise HistoryError([str(error.strerror)]) from None
    if rows:
        (line, cells), expected = rows[0], ["time", *(f"floor {floor}" for floor in range(1, floors + 1))]
        heads = [split_unit(cell) for cell in cells]
        columns = [" ".join(name.lower().split()) for name, _ in heads]
        if columns != expected:
            faults.append(f"line {line}: has the columns {', '.join(columns)}, and not {', '.join(expected)}; {HEAD}")
    samples = _samples(rows[1:], [unit for _, unit in heads], faults) if not faults else np.empty((0, 0))
    faults += _time_faults(samples[:, 0], [line for line, _ in rows[1:]]) if not faults else []
    if faults:
        raise HistoryError(faults)
    samples = np.insert(samples, 0, 0.0, axis=0) if samples[0, 0] > 0.0 else samples
    return History(np.ascontiguousarray(samples[:, 0]), np.ascontiguousarray(samples[:, 1:]))


def _samples(rows: Sequence[tuple[int, list[str]]], units: Sequence[str], faults: list[str]) -> NDArray[np.float64]:
    """The numbers of the rows [SI], (rows, columns); ``faults`` gets a sentence for each cell that has none."""
    quantities = (TIME, *(DISPLACEMENT,) * (len(units) - 1))
    with suppress(ValueError):  # a faulty file is read once more, cell by cell
        factors = [parse_cell("1", unit, quantity) for unit, quantity in zip(units, quantities, strict=True)]
        numbers = np.array([cells for _, cells in rows], dtype=np.float64).reshape(len(rows), len(units)) * factors
        if np.isfinite(numbers).all() and (numbers[:, 0] >= 0.0).all():
            return numbers
    samples = np.zeros((len(rows), len(units)))
    for row, (line, cells) in enumerate(rows):
        if words := uneven(cells, units):
            faults.append(f"line {line}: {words}")
        for column, (cell, unit, quantity) in enumerate(zip(cells, units, quantities, strict=False)):
            try:
                samples[row, column] = parse_cell(cell, unit, quantity)
            except QuantityError as error:
                faults.append(f"line {line}: {error}")
        if len(faults) >= MOST_FAULTS:
            break
    return samples


def _time_faults(times: NDArray[np.float64], lines: Sequence[int]) -> list[str]:
    """The faults of the times [s] of a history, whose samples stand at these lines."""
    if len(times) < 2:
        return ["has fewer than two samples below its head; export the file again"]
    late_indices = np.flatnonzero(np.diff(times) <= 0.0)
    if late_indices.size:
        line = lines[int(late_indices[0]) + 1]
        return [f"line {line}: the time does not rise; give each instant once, in rising order"]
    if times[0] > np.diff(times).max() * STEPS:
        return [f"the first sample is at {times[0]:g} s; give the motion from the beginning of the record on"]
    return []


@lru_cache(maxsize=64)
def _history_of(path: Path, digest: str, floors: int) -> History:
    """As `read_history`; ``digest`` is the checksum of the file, whose content may change."""
    return read_history(path, floors)


# ------------------------------------------------------------------------------------------------ beside records


def histories_beside(study: SceneValues, motion: Motion) -> dict[int, History]:
    """The history of each building of known motion under a record of the scene, by its place in the row."""
    facts = motion.record.get(KEY, {})
    histories = {}
    for place, building in enumerate(study.buildings):
        if building.displacement_history:
            file_facts = facts[building.name]
            path = study.folder / file_facts["file"]
            if _digest(path) != file_facts["sha256"]:
                raise PoundingError(f"{path}: was changed while it is in use; start again")
            histories[place] = _history_of(path, file_facts["sha256"], len(building.heights) or 1)
    return histories


def with_histories(study: SceneValues, motions: tuple[Motion, ...]) -> tuple[Motion, ...]:
    """The motions, with the files of the histories under each among its facts; as they are where there are none.

    Raises SceneError where a file is no history or not as long as its record, and where there are not as many files as
    records.
    """
    if not has_known_motion(study):
        return motions
    faults: list[str] = []
    all_facts: list[dict[str, Any]] = [{} for _ in motions]
    for building in study.buildings:
        files = building.displacement_history
        if files and len(files) != len(motions):
            names = ", ".join(motion.name for motion in motions)
            faults.append(
                f"building.{building.name}.{KEY}: {counted(len(files), 'file')} for "
                f"{counted(len(motions), 'record')}; write one for each of {names}, in this order"
            )
            continue
        for facts, motion, file in zip(all_facts, motions, files, strict=False):
            path = study.folder / file
            try:
                digest = _digest(path)
                _check_length(_history_of(path, digest, len(building.heights) or 1), motion)
            except HistoryError as error:
                faults += [f"building.{building.name}.{KEY}: {file}: {sentence}" for sentence in error.sentences]
            else:
                facts[building.name] = {"file": file, "sha256": digest}
    if faults:
        raise SceneError(study.source, list(dict.fromkeys(faults)))
    return tuple(
        replace(motion, record={**motion.record, KEY: facts}) for motion, facts in zip(motions, all_facts, strict=True)
    )


def _digest(path: Path) -> str:
    try:
        return sha256(read_whole(path, EXPORT)).hexdigest()
    except OSError as error:
        raise HistoryError([cannot_be_read(error, "check the name")]) from None


def _check_length(history: History, motion: Motion) -> None:
    """Raise HistoryError for a history that ends before its record, or goes on after it, by more than a time step."""
    end, span = float(history.times[-1]), motion.duration
    if abs(end - span) > max(float(np.diff(history.times).max()), motion.dt) * STEPS:
        repair = (
            "give the motion to the end, or cut the record"
            if end < span
            else "cut it there, or write a tail in [records]"
        )
        raise HistoryError([f"ends at {end:g} s, and {motion.name}, as the scene has it, at {span:g} s; {repair}"])


# ------------------------------------------------------------------------------------------------ checks and notes


def known_motion_checks(draft: Draft) -> Iterator[Fault]:
    """The faults of keys that exclude a history: initial states, own grounds, links, reversed or scaled motions."""
    buildings = draft.tables("building")
    known_buildings = [keys for keys in buildings if KEY in keys]
    if not known_buildings:
        return
    name = known_buildings[0].raw.get("name", "a building")
    for keys in known_buildings:
        for key in INITIAL:
            if key in keys:
                yield keys.fault(key, f"the building begins as its {KEY} does; remove it")
    on_records = f"{name} has a {KEY}, which is relative to the ground of the records; remove it"
    for keys in buildings:
        yield from (keys.fault(key, on_records) for key in OF_GROUND if key in keys)
    for keys in draft.tables("interface"):
        for key in sorted(OF_LINKS & set(keys.raw)):
            if keys.get(key):
                yield keys.fault(key, f"{name} has a {KEY}, which no link can change; remove one of the two")
    if "wave_passage" in draft.table("effects").raw:
        yield Fault(("effects", "wave_passage"), on_records)
    records, grid = draft.table("records"), draft.table("grid")
    sentence = f"{name} has a {KEY}, which is its response to each record as it is"
    if REVERSED in records.get("polarity", ()):
        yield records.fault("polarity", f"{sentence}: how it responds to the reverse is not known; remove {REVERSED}")
    for table, key in ((grid, "pga"), (records, "intensity")):
        if len(table.get(key) or ()) > 1:
            yield table.fault(
                key, f"{sentence}, at one amplitude: it is never scaled; write one, or scan once for each"
            )


def known_motion_notes(study: SceneValues, motions: Sequence[Motion]) -> Iterator[str]:
    """What to know of a dataset of a scene with known motions."""
    for place, building in enumerate(study.buildings):
        if building.displacement_history:
            files = ", ".join(f"{motion.name} {motion.record[KEY][building.name]['file']}" for motion in motions)
            error = max(_error_between_samples(histories_beside(study, motion)[place]) for motion in motions)
            yield (
                f"{building.name}: its motion without contact is that of files ({files}), straight between their "
                f"samples, where its peaks may be some {say(error, DISPLACEMENT, 2)} larger (second differences / 8), "
                "and never scaled: it must be its response to these records as the scene scales them. Masses, "
                "stiffnesses, damping and effects take no part in it"
            )
    if has_known_motion(study):
        yield (
            "no contact is run: a known motion cannot be pushed. Required gaps, P(contact) and code separations are "
            "those of the motion without contact, rules with the peaks of the files where others have elastic ones; "
            "forces, impacts and pushes by neighbours are not known. What [[interface]] says of contact has no effect"
        )


def _error_between_samples(history: History) -> float:
    """How far a smooth motion through the samples may exceed the straight lines between them: h² |ü| / 8 [m]."""
    steps = np.diff(history.times)[:, None]
    curvatures = 2.0 * np.diff(np.diff(history.floors, axis=0) / steps, axis=0) / (steps[1:] + steps[:-1])
    longer_steps = np.maximum(steps[1:], steps[:-1])
    return float(np.abs(curvatures * longer_steps**2).max(initial=0.0)) / 8.0
