"""The plan of a scan: its cases, its ground motions as processed, its size, and the time it takes on this machine."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import hypot, prod, sqrt
from os import cpu_count
from pathlib import Path
from shutil import disk_usage
from statistics import stdev
from typing import NamedTuple

from pounding_risk._common.counted import counted, size_words
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.ensemble.laws import check_reach
from pounding_risk.ensemble.limits import check_dataset, check_memory, check_scenes
from pounding_risk.ensemble.plan.overrides import changes, marked_as_idle
from pounding_risk.ensemble.plan.scene_text import scene_words
from pounding_risk.ensemble.plan.size import is_drawn, memory, shape_of, sizes
from pounding_risk.ensemble.plausibility import notes_along
from pounding_risk.errors import RecordError, SceneError
from pounding_risk.motions.ensemble import MotionEnsemble
from pounding_risk.motions.levels import LEVEL_AXIS
from pounding_risk.motions.motion import Motion
from pounding_risk.results.labels import doubts_of
from pounding_risk.results.layout import AXES
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import parse_scene, read_scene
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.scene_axis import count_of
from pounding_risk.scene.variants import Variants
from pounding_risk.units import PGA, TIME, say

HERE = "`scan --plan`"
FEW_SCENES = 4  # along axes of numbers of the scene, whose batches are timed


class PlannedRecord(NamedTuple):
    """A ground motion as it will be used, before polarity and the grid's amplitudes."""

    name: str
    event: str
    state: str  # "raw" or "processed", as it was found
    duration: float  # s, the tail included
    dt: float  # s
    pga: float  # m/s²
    flags: tuple[str, ...]  # doubts, one sentence each
    processing: tuple[str, ...]  # steps, one sentence each


@dataclass(frozen=True, repr=False)
class Plan(ShortRepr):
    """A scene without faults, its ground motions, and what its scan takes on this machine.

    What takes the compiled solver to know is None of a scene that is only validated.
    """

    study: Scene
    records: tuple[PlannedRecord, ...]
    bytes: int  # of the dataset's variables, before compression
    threads: int
    notes: tuple[str, ...] = ()  # on unusual numbers of the scene and its records
    left_out: tuple[str, ...] = ()  # files that are named and are no record of the scene, and why
    changes: tuple[str, ...] = ()  # values that `--set` changes, one sentence each
    unused: tuple[str, ...] = ()  # keys of the scene that change nothing in it, and why
    memory: int | None = None  # bytes, about, of a scan into a file
    screened: int | None = None  # batches that follow from the motion without contact, which closes no gap
    share: float = 1.0  # of the batches that the following is learnt from, evenly drawn from a large grid
    seconds: float | None = None  # of solving, on so many threads
    error: float | None = None  # standard error of it [s]
    sampled: int = 0  # batches that were solved to learn this

    @property
    def shape(self) -> dict[str, int]:
        """Number of values along each dimension of the dataset, in order; 1 where the scene names no grid."""
        return shape_of(self.study, len(self.records))

    @property
    def cases(self) -> int:
        """Number of cases of the grid, whether simulated or not."""
        return prod(self.shape.values())

    @property
    def batches(self) -> int:
        """Number of batches: all yield forces of one motion, contact model and gap."""
        return self.cases // self.shape["yield_force"]

    @property
    def shaking(self) -> float:
        """Duration of ground motion, summed over all cases [s]."""
        return self.cases / len(self.records) * sum(record.duration for record in self.records)

    def summary(self) -> list[tuple[str, str]]:
        """The scene and its scan in words: (what, words) by line of a table."""
        return [*scene_words(self.study, len(self.records)), *_run_words(self)]

    def facts(self) -> Iterable[tuple[str, str]]:
        """The scene and its scan in words."""
        return self.summary()

    def __str__(self) -> str:
        rows = self.summary()
        width = max(len(label) for label, _ in rows)
        records = (
            f"{record.name}: {say(record.duration, TIME)} at {say(record.dt, TIME)}, PGA {say(record.pga, PGA)}"
            for record in self.records
        )
        return "\n".join([*(f"{label:<{width}}  {words}" for label, words in rows), *records])


def validate(scene: Scene | str | Path, overrides: Sequence[str] = ()) -> Plan:
    """Check a scene and its records, and count the cases and bytes of its scan; nothing is compiled or run.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, or the path of a scene file.
    overrides : sequence of str
        Values to change, as after ``--set`` on the command line: 'interface.gap="20 mm"'.

    Returns
    -------
    Plan
        As of `plan`; what takes the compiled solver to know is None.

    Raises
    ------
    SceneError
        With every fault of the scene.
    RecordError
        For a record that cannot be used.
    """
    return _checked(scene, overrides, None)[0]


def plan(scene: Scene | str | Path, overrides: Sequence[str] = (), *, workers: int | None = None) -> Plan:
    """Check a scene and its records, and estimate the size and the time of its scan. No dataset is written.

    What is not compiled yet is compiled.

    Parameters
    ----------
    scene : Scene, str or Path
        A scene, or the path of a scene file.
    overrides : sequence of str
        Values to change, as after ``--set`` on the command line: 'interface.gap="20 mm"'.
    workers : int, optional
        Number of threads that the time is of; one per processor by default.

    Returns
    -------
    Plan
        Cases, bytes, memory; and seconds, from about a second of solving a random sample of batches.

    Raises
    ------
    SceneError
        With every fault of the scene.
    RecordError
        For a record that cannot be used.
    """
    return _timed_plan(*_checked(scene, overrides, workers))


def _checked(scene: Scene | str | Path, overrides: Sequence[str], workers: int | None) -> tuple[Plan, MotionEnsemble]:
    """The plan without the fields that need the compiled solver, and the motions; raises as `plan`."""
    before, study = _read(scene, overrides)
    for place in range(len(study.interface_names)):
        check_reach(study.at(place), study.grid.contact_models)
    ensemble = gathered(study)
    shape = shape_of(study, len(ensemble.motions))
    size = sizes(study).of(shape)
    check_dataset(study, prod(shape.values()), size)
    check_memory(study, ensemble.motions)
    if study.axes:
        check_scenes(Variants(study), ensemble.motions, every=False)
    flags = doubts_of(study, ensemble.motions)
    plan = Plan(
        study,
        tuple(_planned_record(motion, flags[motion.name]) for motion in ensemble.motions),
        size,
        workers or cpu_count() or 1,
        notes_along(study, ensemble.motions),
        ensemble.left_out,
        _changes(before, study, ensemble.motions),
        unused_keys(study),
    )
    return plan, ensemble


def _read(scene: Scene | str | Path, overrides: Sequence[str]) -> tuple[Scene | None, Scene]:
    """The scene without the overrides, None where there are none or it has faults, and the scene with them."""
    if isinstance(scene, Scene):
        if not overrides:
            return None, scene
        # A study's own text may lack what was changed in it since: its resolved form does not.
        changed = parse_scene(scene.to_toml(), scene.source, overrides)
        return scene, changed.updated(text=scene.text, overrides=(*scene.overrides, *overrides))
    study = read_scene(scene, overrides)
    if not overrides:
        return None, study
    try:
        return read_scene(scene), study
    except SceneError:  # the overrides repair it: there is nothing to compare with
        return None, study


def _changes(before: Scene | None, study: Scene, motions: tuple[Motion, ...]) -> tuple[str, ...]:
    """Sentences on the values that overrides change, those without effect on motions, and the number of cases."""
    if before is None:
        return ()
    sentences = changes(before, study)
    try:
        were = motions if before.records == study.records else gathered(before).motions
    except (RecordError, SceneError):  # the overrides repair it
        return sentences
    if before.records != study.records and [motion.digest for motion in were] == [motion.digest for motion in motions]:
        sentences = marked_as_idle(sentences)
    old, new = (prod(shape_of(item, count).values()) for item, count in ((before, len(were)), (study, len(motions))))
    return (*sentences, f"cases: {old} -> {new}") if old != new else sentences


def _timed_plan(checked_plan: Plan, ensemble: MotionEnsemble) -> Plan:
    """The plan with the fields that need the motion without contact and a sample of solved batches."""
    from pounding_risk.ensemble.plan.cost import alone, costs, few_batches

    motions, count = ensemble.motions, float(count_of(checked_plan.study.axes))
    scenes = _few_scenes(checked_plan.study)
    touching, size, sampled, seconds, errors = 0, 0, 0, [], []
    for scene in scenes:
        small_study, share = few_batches(scene, len(motions))
        free = alone(small_study, motions)
        touching += round(int((free.closed > 0.0).sum()) * checked_plan.shape["contact_model"] / share)
        size = max(size, free.size)
        samples = costs(small_study, motions, free.closed)
        seconds.append(sum(cost.seconds for cost in samples) / checked_plan.threads / share)
        errors.append(sqrt(sum(cost.error**2 for cost in samples)) / checked_plan.threads / share)
        sampled += sum(cost.sampled for cost in samples)
    if is_drawn(checked_plan.study):
        count = count / (len(motions) * len(checked_plan.study.records.polarities))  # each scene runs under one motion
    scenes_each = count / len(scenes)  # scenes for each of these
    return replace(
        checked_plan,
        memory=memory(checked_plan.study, checked_plan.shape, checked_plan.threads, motions, size),
        screened=checked_plan.batches - round(scenes_each * touching),
        share=share / scenes_each,
        seconds=scenes_each * sum(seconds),
        error=hypot(scenes_each * hypot(*errors), count * _scatter(seconds, count)),
        sampled=sampled,
    )


def _few_scenes(study: Scene) -> list[Scene]:
    """The scene itself, or some of the scenes along its axes, evenly drawn."""
    if not study.axes:
        return [study]
    variants = Variants(study)
    count = min(variants.count, FEW_SCENES)
    return [variants.scene((2 * number + 1) * variants.count // (2 * count)) for number in range(count)]


def _scatter(seconds: Sequence[float], count: float) -> float:
    """Standard error of the mean time of ``count`` scenes, from those of some of them."""
    return stdev(seconds) * sqrt(max(1.0 - len(seconds) / count, 0.0) / len(seconds)) if len(seconds) > 1 else 0.0


def _planned_record(motion: Motion, flags: tuple[str, ...]) -> PlannedRecord:
    event, state = (str(motion.record.get(key, "")) for key in ("event", "state"))
    return PlannedRecord(motion.name, event, state, motion.duration, motion.dt, motion.pga, flags, motion.processing)


def _run_words(plan: Plan) -> Iterator[tuple[str, str]]:
    """Cases, batches, size and time of the scan: (label, words) of each row."""
    names = {axis: f"{axis.replace('_', ' ')}s" for axis in AXES}
    names |= {"polarity": "polarities", LEVEL_AXIS: f"levels of {plan.study.grid.measure.words}"}
    factors = [f"{count} {names.get(name, f'of {name}')}" for name, count in plan.shape.items() if count > 1]
    yield "cases", f"{plan.cases} = {' × '.join(factors)}" if len(factors) > 1 else str(plan.cases)

    width = plan.shape["yield_force"]
    words = f"{plan.batches}, each a motion, a contact model and a gap" + (f" with {width} yield forces" * (width > 1))
    if plan.screened is None:
        words += f"; how many of them touch is not known yet, {HERE} finds it"
    else:
        share = 100.0 * plan.screened / plan.batches
        about_text = "" if plan.share == 1.0 else "about "
        words += (
            f"; {about_text}{plan.screened} ({share:.0f} %) close no gap and are known from the motion without contact"
        )
    yield "batches", words

    folder = plan.study.folder if plan.study.folder.is_dir() else Path()
    free = disk_usage(folder).free
    room_text = "" if plan.bytes <= free else f", more than the {size_words(free)} that are free in {folder.resolve()}"
    yield "dataset", f"{size_words(plan.bytes)} before compression{room_text}"
    if plan.memory is not None:
        yield "memory", f"about {size_words(plan.memory)}"
    if plan.seconds is None:
        yield "time", f"not known, since nothing is run; {HERE} times a sample, and states the memory"
    else:
        yield (
            "time",
            f"about {duration(plan.seconds)} on {counted(plan.threads, 'thread')}, ± {duration(plan.error or 0.0)}: "
            f"from {counted(plan.sampled, 'batch', 'batches')} solved here; without compiling and writing",
        )
    yield from (("changed", sentence) for sentence in plan.changes)
    yield from (("unused", sentence) for sentence in plan.unused)


def duration(seconds: float) -> str:
    """A time in words: 0.8 s, 42 s, 12 min, 3 h 20 min."""
    if seconds < 9.5:
        return f"{max(seconds, 0.1):.1f} s"
    if seconds < 120.0:
        return f"{seconds:.0f} s"
    minutes = round(seconds / 60.0)
    if minutes < 60:
        return f"{minutes} min"
    return f"{minutes // 60} h {minutes % 60} min" if minutes < 6000 else f"{minutes / 1440:.1f} days"
