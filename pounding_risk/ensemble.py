"""A scene's whole grid: records × polarities × amplitudes × contact laws × gaps × yield forces → one dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from os import cpu_count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._jit import lowered
from pounding_risk.collision import equal_stiffness
from pounding_risk.core.collide import make_desk
from pounding_risk.core.flight import Free
from pounding_risk.core.sweep import sweep
from pounding_risk.core.tally import COMPLETE, STATUS_SENTENCES
from pounding_risk.gather import gathered
from pounding_risk.models.effects import wave_of, with_effects
from pounding_risk.motions import Motion, driven
from pounding_risk.outputs import COLUMNS
from pounding_risk.pair import free_response, oscillators
from pounding_risk.provenance import provenance
from pounding_risk.recheck import RunGrid, check_runs, check_share, sample
from pounding_risk.relations import check_reach
from pounding_risk.results import as_text, check_target, save
from pounding_risk.scan_dataset import AXES, Scanned, labelled
from pounding_risk.study import Study
from pounding_risk.threads import How, Progress, counter, work_through

CASES_A_CHUNK = 60  # some hundredths of a second, seconds for a stiff pair and a long record: Ctrl-C waits no longer


class Chunk(NamedTuple):
    """A piece of work: some gaps of one law under one motion; places along the dataset's axes."""

    motion: tuple[int, int, int]  # record, polarity, amplitude
    law: int
    gaps: slice


def scan(
    study: Study | str | Path,
    out: str | Path | None = None,
    *,
    screening: bool = True,
    check_fraction: float = 0.01,
    workers: int | None = None,
    progress: Progress | None = None,
    command: str = "",
) -> xr.Dataset:
    """Run every case of a scene's grid and return (and write to ``out``) one labelled dataset.

    Dimensions: record, polarity, pga (of several), contact_model [name], gap [m],
    yield_force [N]; see `outputs` for the variables. A row's are by interface, contact_point, building and storey as
    well; see `row_outputs`. ``screening`` leaves out runs whose answer is known exactly;
    the answers are the same without it. ``check_fraction`` of the runs, a random sample and at least one, are made
    again at a tighter tolerance: the variables ``sensitive`` and ``change_...`` say how far they move (see
    `recheck`). ``command`` is the command line, kept as an attribute. ``progress`` is called with (cases done, cases in
    all). Raises SceneError for a faulty scene, RecordError for a record that cannot be used, PoundingError for an
    ``out`` that cannot be written or a ``check_fraction`` outside 0 to 1; all of them before the first run.
    """
    target = None if out is None else check_target(out)
    check_share(check_fraction)
    study = as_study(study)
    motions, left_out = gathered(study)
    how_much = How(screening, check_fraction, workers or cpu_count() or 1, progress)
    if study.is_row:
        from pounding_risk.row_scan import scan_row  # a pair needs none of it

        dataset = scan_row(study, motions, how_much)
    else:
        dataset = _scan_pair(study, motions, how_much)
    dataset.attrs |= provenance(study, motions, screening, check_fraction)
    if command:
        dataset.attrs["command"] = command
    if left_out:
        dataset.attrs["left_out"] = as_text(list(left_out))
    if target is not None:
        save(dataset, target)
    return dataset


def _scan_pair(study: Study, motions: tuple[Motion, ...], how_much: How) -> xr.Dataset:
    """The dataset of a pair's grid."""
    laws = laws_of(study)
    frees = free_responses(study, motions)
    shape = (*frees.shape, len(laws), len(study.grid.gaps), len(study.grid.yield_forces))
    raw = np.zeros((*shape, COLUMNS))
    how = np.zeros(shape, dtype=np.int8)
    work = _worker(study, frees, laws, (raw, how), how_much.screening)
    work_through(_chunks(shape), work, how_much.workers, counter(how.size, how_much.progress))
    dataset = labelled(study, Scanned(motions, frees, laws, raw, how))
    if how_much.check_fraction > 0.0:
        _add_checks(dataset, study, (frees, laws), (raw, how), (how_much.check_fraction, how_much.workers))
    return dataset


def _add_checks(dataset: xr.Dataset, study: Study, made: Any, arrays: Any, how_much: tuple[float, int]) -> None:
    """Make a share of the runs again and add what `recheck` found; ``made`` = (free responses, laws)."""
    frees, laws = made
    raw, how = arrays
    grid = RunGrid(
        oscillators(*study.pair),
        frees,
        laws,
        np.array(study.grid.gaps),
        np.array(study.grid.yield_forces),
        study.restitution,
        study.rtol,
    )
    fraction, workers = how_much
    dims = tuple(dim for dim in AXES if dim in dataset.dims)
    shape = [dataset.sizes[dim] for dim in dims]
    for name, (values, told) in check_runs(grid, arrays, sample(raw, how, fraction), workers).items():
        dataset[name] = (dims, values.reshape(shape), told)


def as_study(scene: Study | str | Path) -> Study:
    """A study, or the scene file of that name read."""
    if isinstance(scene, Study):
        return scene
    from pounding_risk.scenario import read_scene

    return read_scene(scene)


def laws_of(study: Study) -> tuple[Any, ...]:
    """The grid's contact laws with their stiffness; where a k is no β, the one that equal terms lead to."""
    return tuple(law_of(study, name) for name in study.grid.contact_models)


def law_of(study: Study, name: str) -> Any:
    """One contact law of the scene with its effects; its stiffness by equal terms where the unit differs.

    Raises as `check_reach`.
    """
    check_reach(study, (name,))
    return with_effects(_calibrated(study, name), study.effects)


def _calibrated(study: Study, name: str) -> Any:
    terms = study.equal_terms
    if not study.needs_equal_terms(name) or terms is None:
        return study.law(name)
    stiffness = equal_stiffness(
        lambda value: study.law(name, value),
        study.law(study.stiff_name),
        terms.speed,
        study.striking_mass,
        study.restitution,
        terms.same,
    )
    return study.law(name, stiffness)


def free_responses(study: Study, motions: tuple[Motion, ...]) -> np.ndarray:
    """Responses without contact, by record, polarity and amplitude."""
    shape = (len(motions), len(study.records.polarities), len(study.grid.pgas))
    frees = np.empty(shape, dtype=object)
    pair = oscillators(*study.pair)
    for place in np.ndindex(shape):
        motion = driven(motions[place[0]], study.records.polarities[place[1]], study.grid.pgas[place[2]])
        frees[place] = free_response(pair, motion.acceleration, motion.dt, wave_of(study.effects))
    return frees


def _chunks(shape: tuple[int, ...]) -> Iterator[Chunk]:
    *motions, laws, gaps, strengths = shape
    width = max(1, CASES_A_CHUNK // strengths)
    for motion in np.ndindex(*motions):
        for law in range(laws):
            for first in range(0, gaps, width):
                yield Chunk(motion, law, slice(first, min(first + width, gaps)))


def _worker(
    study: Study, frees: np.ndarray, laws: tuple[Any, ...], arrays: Any, screening: bool
) -> Callable[[Chunk], int]:
    raw, how = arrays
    pair = oscillators(*study.pair)
    gaps, strengths = np.array(study.grid.gaps), np.array(study.grid.yield_forces)

    def work(chunk: Chunk) -> int:
        place = (*chunk.motion, chunk.law, chunk.gaps)
        free: Free = frees[chunk.motion]
        grid = (gaps[chunk.gaps], strengths, study.restitution)
        sweep(
            pair,
            free,
            lowered(laws[chunk.law]),
            grid,
            study.rtol,
            screening,
            make_desk(study.rtol),
            raw[place],
            how[place],
        )
        return int(how[place].size)

    return work


def failures(dataset: xr.Dataset) -> dict[str, int]:
    """How many cases failed, by the sentence that says why."""
    status = dataset["status"].values
    counts = {sentence: int((status == code).sum()) for code, sentence in STATUS_SENTENCES.items() if code != COMPLETE}
    return {sentence: count for sentence, count in counts.items() if count}


def summary(dataset: xr.Dataset) -> dict[str, int]:
    """Cases in all, those simulated, those known without a run, those found sensitive, those failed by sentence."""
    status = dataset["status"].values
    counts = {
        "cases": int(status.size),
        "simulated": int(dataset["simulated"].sum()),
        "known without a run of their own": int((dataset["simulated"] == 0).sum()),
    }
    if "sensitive" in dataset:
        counts["made again"] = int((dataset["sensitive"] >= 0).sum())
        counts["of these sensitive"] = int((dataset["sensitive"] == 1).sum())
    return counts | failures(dataset)
