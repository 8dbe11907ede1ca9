"""A scene's whole grid: records × polarities × amplitudes × contact laws × gaps × yield forces → one dataset."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor, as_completed
from os import cpu_count
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._jit import lowered
from pounding_risk.collision import equal_stiffness
from pounding_risk.core.collide import make_desk
from pounding_risk.core.flight import SIGNALS, Free
from pounding_risk.core.sweep import sweep
from pounding_risk.core.tally import COMPLETE, STATUS, STATUS_SENTENCES
from pounding_risk.gather import gathered
from pounding_risk.models.effects import EFFECTS, acts_on_ground, bare, references, wave_of, with_effects
from pounding_risk.models.instant import is_instant
from pounding_risk.motions import Motion
from pounding_risk.outputs import BUILDING, COLUMNS, HIGH, LOW, RUN, building_outputs, run_outputs
from pounding_risk.pair import free_response, oscillators
from pounding_risk.recheck import RunGrid, check_runs, check_share, sample
from pounding_risk.record_request import REVERSED
from pounding_risk.relations import check_reach
from pounding_risk.results import as_text, check_target, save, versions
from pounding_risk.study import Study

AXES = ("record", "polarity", "pga", "contact_model", "gap", "yield_force")
CASES_A_CHUNK = 60  # some hundredths of a second, seconds for a stiff pair and a long record: Ctrl-C waits no longer

Progress = Callable[[int, int], None]


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
) -> xr.Dataset:
    """Run every case of a scene's grid and return (and write to ``out``) one labelled dataset.

    Dimensions: record, polarity, pga (of several), contact_model [name], gap [m],
    yield_force [N]; see `outputs` for the variables. ``screening`` leaves out runs whose answer is known exactly;
    the answers are the same without it. ``check_fraction`` of the runs, a random sample and at least one, are made
    again at a tighter tolerance: the variables ``sensitive`` and ``change_...`` say how far they move (see
    `recheck`). ``progress`` is called with (cases done, cases in all). Raises SceneError for a faulty scene,
    RecordError for a record that cannot be used, PoundingError for an ``out`` that cannot be written or a
    ``check_fraction`` outside 0 to 1; all of them before the first run.
    """
    target = None if out is None else check_target(out)
    check_share(check_fraction)
    study = as_study(study)
    motions, left_out = gathered(study)
    laws = laws_of(study)
    frees = free_responses(study, motions)
    shape = (*frees.shape, len(laws), len(study.grid.gaps), len(study.grid.yield_forces))
    raw = np.zeros((*shape, COLUMNS))
    how = np.zeros(shape, dtype=np.int8)
    workers = workers or cpu_count() or 1
    _run(
        list(_chunks(shape)), _worker(study, frees, laws, (raw, how), screening), workers, _counter(how.size, progress)
    )
    dataset = _dataset(study, motions, frees, (raw, how))
    if left_out:
        dataset.attrs["left_out"] = as_text(list(left_out))
    if check_fraction > 0.0:
        _add_checks(dataset, study, (frees, laws), (raw, how), (check_fraction, workers))
    if target is not None:
        save(dataset, target)
    return dataset


def _add_checks(dataset: xr.Dataset, study: Study, made: Any, arrays: Any, how_much: tuple[float, int]) -> None:
    """Make a share of the runs again and add what `recheck` found; ``made`` = (free responses, laws)."""
    frees, laws = made
    raw, how = arrays
    grid = RunGrid(
        oscillators(*study.buildings),
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
    left, right = (building.oscillator() for building in study.buildings)
    mass = 1.0 / (left.inverse_mass + right.inverse_mass)
    stiffness = equal_stiffness(
        lambda value: study.law(name, value),
        study.law(study.stiff_name),
        terms.speed,
        mass,
        study.restitution,
        terms.same,
    )
    return study.law(name, stiffness)


def driven(motion: Motion, polarity: str, pga: float | None) -> Motion:
    """A motion in one polarity, scaled to one amplitude of the grid."""
    turned = motion.reversed() if polarity == REVERSED else motion
    return turned if pga is None else turned.scaled_to(pga)


def free_responses(study: Study, motions: tuple[Motion, ...]) -> np.ndarray:
    """Responses without contact, by record, polarity and amplitude."""
    shape = (len(motions), len(study.records.polarities), len(study.grid.pgas))
    frees = np.empty(shape, dtype=object)
    pair = oscillators(*study.buildings)
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
    pair = oscillators(*study.buildings)
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


def _run(chunks: list[Chunk], work: Callable[[Chunk], int], workers: int, advance: Callable[[int], None]) -> None:
    """Work through the chunks on threads; the kernels release the interpreter."""
    # The first chunk of each law compiles its kernel: not on two threads at once.
    laws: set[int] = set()
    rest: list[Chunk] = []
    for chunk in chunks:
        if chunk.law in laws:
            rest.append(chunk)
        else:
            laws.add(chunk.law)
            advance(work(chunk))
    pool = ThreadPoolExecutor(workers)
    try:
        for future in as_completed([pool.submit(work, chunk) for chunk in rest]):
            advance(future.result())
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


def _counter(total: int, progress: Progress | None) -> Callable[[int], None]:
    done = 0

    def advance(size: int) -> None:
        nonlocal done
        done += size
        if progress:
            progress(done, total)

    return advance


def _dataset(study: Study, motions: tuple[Motion, ...], frees: np.ndarray, arrays: Any) -> xr.Dataset:
    raw, how = arrays
    dims = AXES
    strengths = np.array(study.grid.yield_forces)
    variables: dict[str, Any] = {
        name: (dims, _stored(values, RUN[name].whole), _described(RUN[name].unit, RUN[name].words))
        for name, values in run_outputs(raw, strengths).items()
    }
    for name, values in _buildings(study, motions, frees, raw).items():
        unit, words, _ = BUILDING[name.removesuffix("_free")]
        without = "; without contact" if name.endswith("_free") else ""
        axes = ("record", "polarity", "pga") if without else dims
        variables[name] = ((*axes, "building"), values, _described(unit, words + without))
    codes = list(STATUS_SENTENCES)
    flags = {
        "flag_values": np.array(codes, dtype=np.int8),
        "flag_meanings": " ".join(map(_slug, STATUS_SENTENCES.values())),
    }
    variables["status"] = (dims, raw[..., STATUS].astype(np.int8), {"long_name": "how the run ended", **flags})
    variables["simulated"] = (
        dims,
        how,
        {"long_name": "1 where a run of its own was made, 0 where another run's answer is exactly this one's"},
    )
    dataset = xr.Dataset(variables, coords=_coordinates(study, motions), attrs=_attributes(study, motions))
    # A study of one amplitude has no axis of amplitudes; the amplitude stays as a label, where there is one.
    return dataset.squeeze("pga", drop=study.grid.pgas == (None,)) if len(study.grid.pgas) == 1 else dataset


def _stored(values: np.ndarray, whole: bool) -> np.ndarray:
    return values.astype(np.int32) if whole else values


def _described(unit: str, words: str) -> dict[str, str]:
    return {"units": unit, "long_name": words}


def _slug(sentence: str) -> str:
    return "_".join("".join(letter if letter.isalnum() else " " for letter in sentence).split())


def _buildings(study: Study, motions: tuple[Motion, ...], frees: np.ndarray, raw: np.ndarray) -> dict[str, np.ndarray]:
    """Outputs per building, and without contact from the extremes of the free responses."""
    found: dict[str, np.ndarray] = {}
    for place in np.ndindex(frees.shape):
        free: Any = frees[place]
        pga = driven(motions[place[0]], study.records.polarities[place[1]], study.grid.pgas[place[2]]).pga
        alone = np.zeros(COLUMNS)
        alone[HIGH : HIGH + SIGNALS] = np.maximum(free.high.max(axis=0), 0.0)
        alone[LOW : LOW + SIGNALS] = np.minimum(free.low.min(axis=0), 0.0)
        for suffix, columns in (("", raw[place]), ("_free", alone)):
            for name, values in building_outputs(columns, study.buildings, pga).items():
                array = found.setdefault(name + suffix, np.zeros((*frees.shape, *values.shape)))
                array[place] = values
    return found


def _coordinates(study: Study, motions: tuple[Motion, ...]) -> dict[str, Any]:
    def about(key: str) -> list[str]:
        return [str(motion.record.get(key, "")) for motion in motions]

    grid = study.grid
    return {
        "record": ("record", [motion.name for motion in motions], {"long_name": "ground motion"}),
        "polarity": ("polarity", list(study.records.polarities), {"long_name": "sign of the ground motion"}),
        "pga": (
            "pga",
            [np.nan if pga is None else pga for pga in grid.pgas],
            _described("m/s2", "peak ground acceleration"),
        ),
        "contact_model": ("contact_model", list(grid.contact_models), {"long_name": "contact law"}),
        "gap": ("gap", list(grid.gaps), _described("m", "clear distance at rest")),
        "yield_force": ("yield_force", list(grid.yield_forces), _described("N", "yield force F_E; inf never yields")),
        "building": (
            "building",
            [building.name for building in study.buildings],
            {"long_name": "building, left to right"},
        ),
        "record_event": ("record", about("event"), {"long_name": "earthquake"}),
        "record_sha256": ("record", about("sha256"), {"long_name": "checksum of the record's file"}),
        "record_pga": (
            "record",
            [motion.pga for motion in motions],
            _described("m/s2", "peak of the processed record"),
        ),
    }


def sources_of(study: Study, laws: Iterable[Any]) -> list[str]:
    """Where these laws and the scene's effects are from."""
    grounds = [EFFECTS[effect.name] for effect in study.effects if acts_on_ground(effect.name)]
    return list(dict.fromkeys([*map(references, laws), *(kind.reference for kind in grounds)]))  # type: ignore[attr-defined]


def _attributes(study: Study, motions: tuple[Motion, ...]) -> dict[str, Any]:
    laws = laws_of(study)
    return {
        "Conventions": "CF-1.11",
        "title": study.name,
        "source": "pounding_risk: event-driven pair solver",
        "references": "; ".join(sources_of(study, laws)),
        "scene": study.text or study.to_toml(),
        "scene_resolved": study.to_toml(),
        "overrides": as_text(list(study.overrides)),
        "stiffness": as_text(
            {
                name: bare(law).stiffness
                for name, law in zip(study.grid.contact_models, laws, strict=True)
                if not is_instant(law)
            }
        ),
        "restitution": study.restitution_words,
        "restitution_relation": study.relation,
        "rtol": study.rtol,
        "records": as_text([{**motion.record, "name": motion.name, "dt": motion.dt} for motion in motions]),
        "processing": as_text({motion.name: list(motion.processing) for motion in motions}),
        "flags": as_text({motion.name: list(motion.flags) for motion in motions if motion.flags}),
        "versions": as_text(versions()),
    }


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
