"""The ground motions of a scene, flagged where they do not suit its buildings."""

from __future__ import annotations

from collections.abc import Iterable
from copy import copy

from pounding_risk.errors import SceneError
from pounding_risk.models.effects import wave_of
from pounding_risk.motions.ensemble import MotionEnsemble, read_ensemble
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.quality import OF_BUILDINGS, failed, quality
from pounding_risk.motions.record import STILL
from pounding_risk.motions.request import conflicts
from pounding_risk.motions.source import lowest_usable
from pounding_risk.scene.scene import Scene


def motions_of(study: Scene) -> tuple[Motion, ...]:
    """The ground motions of a scene, one per record; see `gathered`."""
    return gathered(study).motions


def gathered(study: Scene) -> MotionEnsemble:
    """The scene's ground motions, one per record, before polarity and the grid's amplitudes, and what was left out.

    Raises as `read_ensemble`, and SceneError where the grid sets the amplitude that the records have already, where no
    file is a record and where a record ends before a passing wave has reached both buildings.
    """
    faults = conflicts(study.records.given(), grid_pga=study.grid.pgas != (None,) and study.records.pga is None)
    if sentences := [f"records.{key}: {sentence}" for key, sentence in faults]:
        raise SceneError(study.source, sentences)
    ensemble = read_ensemble(study.records, study.folder, scaled=study.grid.pgas == (None,))
    ensemble = ensemble._replace(motions=for_buildings(ensemble.motions, study))
    if not ensemble.motions:
        asked = ", ".join(study.records.files)
        left = f"; left out: {', '.join(ensemble.left_out)}" if ensemble.left_out else ""
        raise SceneError(study.source, [f"records.files: {asked} matches no record{left}; check the folder"])
    check_wave(study, ensemble.motions)
    return ensemble


def check_wave(study: Scene, motions: Iterable[Motion]) -> None:
    """Raise SceneError where a record ends before a passing wave has reached both buildings."""
    wave = wave_of(study.effects)
    lag = 0.0 if wave is None else float(wave.arrivals(len(study.buildings)).max())
    for motion in motions:
        if lag >= motion.duration:
            sentence = f"the wave needs {lag:g} s between the buildings, and {motion.name} lasts {motion.duration:g} s"
            raise SceneError(study.source, [f"effects.wave_passage: {sentence}; check velocity and distance"])


def for_buildings(motions: Iterable[Motion], study: Scene) -> tuple[Motion, ...]:
    """The motions, flagged where they are too coarse or were filtered too narrowly for the buildings of a scene."""
    return tuple(_flagged(motion, (*motion.flags, *_doubts(motion, study))) for motion in motions)


def as_before(motions: Iterable[Motion], study: Scene) -> tuple[Motion, ...]:
    """The motions without the flags that `for_buildings` has added for a scene."""
    return tuple(
        _flagged(motion, motion.flags[: len(motion.flags) - len(_doubts(motion, study))]) for motion in motions
    )


def _flagged(motion: Motion, flags: tuple[str, ...]) -> Motion:
    """The motion with these flags, and its own samples: a scan along axes has such a motion for each of its scenes."""
    made = copy(motion)
    object.__setattr__(made, "flags", flags)
    return made


def _doubts(motion: Motion, study: Scene) -> tuple[str, ...]:
    """Flags of a motion that follow from the buildings."""
    periods = [building.period for building in study.buildings if not building.is_rigid]
    if not periods or motion.record.get(STILL):
        return ()
    # Straight lines that are close to a known motion excite a stiff building no more than they are from it.
    known = "interpolation_error" in motion.record
    findings = quality(
        motion.acceleration,
        motion.dt,
        shortest_period=min(periods),
        longest_period=max(periods),
        usable=lowest_usable(motion.record),
        checks=OF_BUILDINGS[known:],
    )
    return tuple(failed(findings))
