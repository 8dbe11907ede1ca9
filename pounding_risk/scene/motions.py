"""The ground motions of a scene, flagged where they do not suit its buildings."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from copy import copy
from typing import Any

from pounding_risk._common.counted import counted
from pounding_risk.errors import SceneError
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.ensemble import MotionEnsemble, read_ensemble
from pounding_risk.motions.levels import FACTOR, PEAK
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.own_grounds import followed_by, read_own, set_beside
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.quality import OF_BUILDINGS, failed, quality
from pounding_risk.motions.record import AFTERSHOCK, BESIDE, OWN_STEP, STILL, is_vertical, lowest_usable
from pounding_risk.motions.request import INTENSITY, RecordRequest, conflicts
from pounding_risk.scene.known_motions import with_histories
from pounding_risk.scene.scene import Scene
from pounding_risk.units import shown


def motions_of(study: Scene) -> tuple[Motion, ...]:
    """The ground motions of a scene, one per record; see `gathered`."""
    return gathered(study).motions


def gathered(study: Scene) -> MotionEnsemble:
    """The scene's ground motions, one per record, before polarity and the grid's amplitudes, and what was left out.

    Beside each stand the records of buildings that have their own. They last until the building that is reached last
    has had all of them.

    Raises as `read_ensemble`, and SceneError where the grid sets the amplitude that the records have already, where no
    file is a record, where a building's own records are not as many as those of the scene, and where a record ends
    before it has reached all buildings.
    """
    grid, is_factor = study.grid, study.grid.measure.name == FACTOR
    stated_keys = (*study.records.given(), *([INTENSITY] if grid.measure != PEAK else []))
    has_pga = grid.measure == PEAK and grid.amplitudes != (None,)
    faults = conflicts(stated_keys, grid_pga=has_pga and study.records.pga is None, is_factor=is_factor)
    if sentences := [f"records.{key}: {sentence}" for key, sentence in faults]:
        raise SceneError(study.source, sentences)
    ensemble = read_ensemble(request_of(study), study.folder, scaled=grid.amplitudes == (None,) or is_factor)
    motions = _with_aftershocks(study, _with_own_records(study, ensemble.motions))
    motions = with_histories(study, for_buildings(motions, study))
    ensemble = ensemble._replace(motions=motions)
    if not ensemble.motions:
        files = ", ".join(study.records.files)
        left_out_text = f"; excluded: {', '.join(ensemble.left_out)}" if ensemble.left_out else ""
        raise SceneError(study.source, [f"records.files: {files} matches no record{left_out_text}; check the folder"])
    check_arrivals(study, motions)
    return ensemble._replace(motions=tuple(motion.reaching(study.lag) for motion in motions))


def request_of(study: Scene) -> RecordRequest:
    """The scene's request of records, with both components where a building moves across the row too."""
    storeyed = [building for building in study.buildings if isinstance(building, Storeys)]
    return study.records._replace(both=any(plan.moves_across for building in storeyed for plan in building.plans))


def check_arrivals(study: Scene, motions: Iterable[Motion]) -> None:
    """Raise SceneError where a record ends before it has reached all buildings."""
    lag = study.lag
    for motion in (each_motion.reaching(0.0) for each_motion in motions):
        if lag >= motion.duration:
            is_wave = "wave_passage" in dict(study.effects)
            key, subject = ("effects.wave_passage", "the wave") if is_wave else ("building.ground_delay", "the motion")
            sentence = f"{subject} needs {lag:g} s between the buildings, and {motion.name} lasts {motion.duration:g} s"
            repair = "check velocity and distance" if is_wave else "write a shorter delay, or a tail in [records]"
            raise SceneError(study.source, [f"{key}: {sentence}; {repair}"])


def _with_own_records(study: Scene, motions: tuple[Motion, ...]) -> tuple[Motion, ...]:
    """The motions with the records of buildings that have their own."""
    columns: list[Sequence[Motion | None]] = []
    for building in study.buildings:
        names, key = building.support.records, f"building {building.name}, ground_record"
        columns.append(
            _one_for_each(study, motions, names, study.records, key, " of the scene") or [None] * len(motions)
        )
    if not any(building.support.records for building in study.buildings):
        return motions
    return tuple(set_beside(motion, row) for motion, row in zip(motions, zip(*columns, strict=True), strict=True))


def _with_aftershocks(study: Scene, motions: tuple[Motion, ...]) -> tuple[Motion, ...]:
    """The motions, each with the aftershock of the scene's records behind it."""
    request, names = request_of(study), study.records.aftershock
    if not names:
        return motions
    if any(building.support.records for building in study.buildings):
        words = "records.aftershock: buildings with a ground_record have none; remove one of the two keys"
        raise SceneError(study.source, [words])
    shocks = _one_for_each(study, motions, names, request._replace(window=None, tail=0.0), "records.aftershock")
    settings = request.pause, request.aftershock_ratio, request.tail
    return tuple(followed_by(motion, shock, *settings) for motion, shock in zip(motions, shocks, strict=True))


def _one_for_each(
    study: Scene, motions: Sequence[Motion], names: Sequence[str], request: RecordRequest, key: str, of_text: str = ""
) -> list[Motion]:
    """A motion of ``names`` for each of the scene's: one name for all, or one for each; none without names."""
    if len(names) not in (0, 1, len(motions)):
        names_text = ", ".join(motion.name for motion in motions)
        count = f"{counted(len(names), 'name')} for {counted(len(motions), 'record')}{of_text}"
        words = f"{key}: {count}; write one for all, or one for each of {shown(names_text)}, in this order"
        if request.direction is not None:
            words += '; both components are one name, such as "RSN753-000+RSN753-090" or a pattern of files'
        raise SceneError(study.source, [words])
    by_name = {name: read_own(name, request, study.folder) for name in dict.fromkeys(names)}
    return [by_name[name] for name in (names if len(names) == len(motions) else [*names] * len(motions))]


def for_buildings(motions: Iterable[Motion], study: Scene) -> tuple[Motion, ...]:
    """The motions, flagged where a record in them does not suit the buildings of a scene; see `for_periods`."""
    return tuple(for_periods(motion, periods_of(study)) for motion in motions)


def as_before(motions: Iterable[Motion], study: Scene) -> tuple[Motion, ...]:
    """The motions without the flags that `for_buildings` has added for a scene."""
    periods = periods_of(study)
    return tuple(
        _flagged(motion, motion.flags[: len(motion.flags) - len(_doubt_flags(motion, periods))]) for motion in motions
    )


def _flagged(motion: Motion, flags: tuple[str, ...]) -> Motion:
    """The motion with these flags, and its own samples: a scan along axes has such a motion for each of its scenes."""
    flagged = copy(motion)
    object.__setattr__(flagged, "flags", flags)
    return flagged


def periods_of(study: Scene) -> list[list[float]]:
    """The fundamental period [s] of each building, as a list, which is empty of a rigid one."""
    return [[] if building.is_rigid else [building.period] for building in study.buildings]


def for_periods(motion: Motion, periods: Sequence[Sequence[float]]) -> Motion:
    """The motion, flagged where a record in it is vertical, too coarse or filtered too narrowly for periods [s].

    ``periods`` has a list for each building; a record below one building is compared with the periods of that alone.
    """
    return _flagged(motion, (*motion.flags, *_doubt_flags(motion, periods)))


def _doubt_flags(motion: Motion, periods: Sequence[Sequence[float]]) -> tuple[str, ...]:
    """Flags of a motion that follow from the periods of the buildings [s]."""
    own = {facts["building"]: facts for facts in motion.record.get(BESIDE, ())}
    shared = [period for place, of_one in enumerate(periods) if place not in own for period in of_one]
    doubts = _unsuited({OWN_STEP: motion.dt} | motion.record, motion.acceleration, shared)
    if shock := motion.record.get(AFTERSHOCK):
        doubts += [f"{shock['name']}, after it: {doubt}" for doubt in _unsuited(shock, motion.acceleration, shared)]
    for place, facts in own.items():
        ground = motion.own_grounds[place] if motion.own_grounds else None
        samples = motion.acceleration if ground is None else ground
        doubts += [f"{facts['name']}, beside it: {doubt}" for doubt in _unsuited(facts, samples, periods[place])]
    return tuple(dict.fromkeys(doubts))


def _unsuited(facts: Mapping[str, Any], samples: Samples, periods: Sequence[float]) -> list[str]:
    """Doubts about a record of these facts under buildings of these periods [s]; ``samples`` has its motion."""
    if facts.get(STILL):
        return []
    upright = ["a vertical component, which moves the buildings along the row here; name the horizontal ones"]
    upright *= is_vertical(facts)
    if not len(periods):
        return upright
    # Straight lines close to a known motion excite a stiff building no more than their distance from it.
    is_interpolated = "interpolation_error" in facts
    findings = quality(
        samples,
        facts[OWN_STEP],
        shortest_period=min(periods),
        longest_period=max(periods),
        usable=lowest_usable(facts),
        checks=OF_BUILDINGS[is_interpolated:],
    )
    return [*upright, *failed(findings)]
