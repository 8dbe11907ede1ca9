"""What a scene asks for, before anything runs: its cases, its records read and checked, and what the run takes."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from math import prod, sqrt
from os import cpu_count
from pathlib import Path
from typing import TYPE_CHECKING

from pounding_risk.ensemble.plan.numbers import PlannedRecord, PlanNumbers, shape_of
from pounding_risk.ensemble.plan.text import run_words, scene_words
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.scene import Study
from pounding_risk.scene.unused_keys import unused_keys
from pounding_risk.units import PGA, TIME, say

if TYPE_CHECKING:
    from pounding_risk.motions.ensemble import Gathered


@dataclass(frozen=True, repr=False)
class Plan(PlanNumbers):
    """A scene without a fault, its records, and what its run takes on this machine, in numbers and in words."""

    def summary(self) -> list[tuple[str, str]]:
        """The scene as an engineer reads it, and its run: what, and the words for it; one pair a line."""
        return [*scene_words(self.study, len(self.records)), *run_words(self)]

    def facts(self) -> Iterable[tuple[str, str]]:
        """The scene and its run in words."""
        return self.summary()

    def __str__(self) -> str:
        rows = self.summary()
        width = max(len(what) for what, _ in rows)
        records = (
            f"{record.name}: {say(record.duration, TIME)} at {say(record.dt, TIME)}, PGA {say(record.pga, PGA)}"
            for record in self.records
        )
        return "\n".join([*(f"{what:<{width}}  {words}" for what, words in rows), *records])


def validate(scene: Study | str | Path, overrides: Sequence[str] = ()) -> Plan:
    """Check a scene and its records, and plan its run with what is compiled already; compile nothing, run nothing.

    As `plan`, but quick: what would take compiling stays None.
    """
    return plan(scene, overrides, compiling=False)


def plan(
    scene: Study | str | Path, overrides: Sequence[str] = (), *, workers: int | None = None, compiling: bool = True
) -> Plan:
    """Check a scene and its records, and tell what its run takes: batches, bytes, memory, compiling, time.

    ``overrides`` are as after ``--set`` on the command line ('interface.gap="20 mm"'). The time is that of ``workers``
    threads, one a processor by default, from a second of solving a random few batches of each contact model;
    ``compiling`` False leaves out what is not compiled yet. Nothing is written. Raises SceneError, which tells every
    fault of a scene file at once, and RecordError for a record that cannot be used.
    """
    from pounding_risk.ensemble.laws import check_reach
    from pounding_risk.ensemble.limits import check_dataset, check_memory
    from pounding_risk.ensemble.plan.compilation import kernels_of
    from pounding_risk.ensemble.plan.size import sizes
    from pounding_risk.ensemble.plausibility import of_input
    from pounding_risk.scene.motions import gathered

    before, study = _read(scene, overrides)
    for place in range(len(study.interfaces)):
        check_reach(study.at(place), study.grid.contact_models)
    found = gathered(study)
    shape = shape_of(study, len(found.motions))
    size = sizes(study).of(shape)
    check_dataset(study, prod(shape.values()), size)
    check_memory(study, found.motions)
    made = Plan(
        study,
        tuple(_planned(motion) for motion in found.motions),
        kernels_of(study),
        size,
        0,
        workers or cpu_count() or 1,
        of_input(study, found.motions),
        found.left_out,
        _changes(before, study, found.motions),
        unused_keys(study),
        compiling,
    )
    return _timed(made, found)


def _read(scene: Study | str | Path, overrides: Sequence[str]) -> tuple[Study | None, Study]:
    """The scene as it stands, where it does without the overrides, and with them."""
    from pounding_risk.errors import SceneError
    from pounding_risk.scene.reader import parse_scene, read_scene

    if isinstance(scene, Study):
        if not overrides:
            return None, scene
        # A study's own text may lack what was changed in it since: its resolved template does not.
        changed = parse_scene(scene.to_toml(), scene.source, overrides)
        return scene, replace(changed, text=scene.text, overrides=(*scene.overrides, *overrides))
    study = read_scene(scene, overrides)
    if not overrides:
        return None, study
    try:
        return read_scene(scene), study
    except SceneError:  # the overrides repair it: there is nothing to compare with
        return None, study


def _changes(before: Study | None, study: Study, motions: tuple[Motion, ...]) -> tuple[str, ...]:
    """What the overrides change, what of it changes no motion, and what becomes of the number of cases."""
    from pounding_risk.ensemble.plan.overrides import changes, told_as_idle

    if before is None:
        return ()
    told = changes(before, study)
    were = _motions_before(before, study, motions)
    if were is None:
        return told
    if before.records != study.records and [each.digest for each in were] == [each.digest for each in motions]:
        told = told_as_idle(told)
    old, new = (prod(shape_of(each, count).values()) for each, count in ((before, len(were)), (study, len(motions))))
    return (*told, f"cases: {old} -> {new}") if old != new else told


def _motions_before(before: Study, study: Study, motions: tuple[Motion, ...]) -> tuple[Motion, ...] | None:
    """The motions that the scene has without the overrides; None where they cannot be used."""
    from pounding_risk.errors import RecordError, SceneError
    from pounding_risk.scene.motions import gathered

    if before.records == study.records:
        return motions
    try:
        return gathered(before).motions
    except (RecordError, SceneError):  # the overrides repair it
        return None


def _timed(made: Plan, found: Gathered) -> Plan:
    """The plan with what it takes the motion without contact, and then the solving of some batches, to know."""
    from pounding_risk.ensemble.plan.cost import alone, costs, few_batches
    from pounding_risk.ensemble.plan.size import memory

    kernels, may_compile = made.kernels, made.compiled
    if not may_compile and (kernels.interpreted or not kernels.motion):
        return replace(made, memory=memory(made, found.motions, 0))
    few, share = few_batches(made.study, len(found.motions))
    still = alone(few, found.motions)
    touching = round(int((still.closed > 0.0).sum()) * made.shape["contact_model"] / share)
    made = replace(made, screened=made.batches - touching, share=share, memory=memory(made, found.motions, still.size))
    if not may_compile and not kernels.whole:
        return made
    each = costs(few, found.motions, still.closed)
    return replace(
        made,
        seconds=sum(cost.seconds for cost in each) / made.threads / share,
        error=sqrt(sum(cost.error**2 for cost in each)) / made.threads / share,
        sampled=sum(cost.sampled for cost in each),
    )


def _planned(motion: Motion) -> PlannedRecord:
    return PlannedRecord(
        motion.name,
        str(motion.record.get("event", "")),
        str(motion.record.get("state", "")),
        motion.duration,
        motion.dt,
        motion.pga,
        motion.flags,
        motion.processing,
    )
