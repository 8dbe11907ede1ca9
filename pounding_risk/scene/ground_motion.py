"""Displacement of the ground under buildings, and between them: exact for a_g linear between samples."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.ground import SHARED, Support, accelerations, is_apart, summed
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]


class Parting(NamedTuple):
    """How the grounds of the neighbours at each interface part, x_right − x_left, under one motion."""

    largest: Array  # by interface, of its size at the samples [m]
    when: Array  # s
    end: Array  # at the end of the motion [m]


def parting(study: Scene, motion: Motion) -> Parting:
    """How the grounds part under a motion as it drives the scene."""
    motion = motion.reaching(study.lag)
    ground = ground_displacements(study, motion, motion.times)
    partings = np.diff(ground, axis=1)
    index = np.abs(partings).argmax(axis=0)
    return Parting(np.abs(partings).max(axis=0), motion.times[index], partings[-1])


def in_space(study: Scene, motion: Motion, time: Array, displacement: Array) -> Mapping[str, Array]:
    """Histories of the ground and of the floors in space [m].

    Parameters
    ----------
    study : Scene
        The scene.
    motion : Motion
        The motion as it drives the scene.
    time : numpy.ndarray
        Instants (n,) [s].
    displacement : numpy.ndarray
        Of every floor relative to the ground under its building (n, buildings, storeys) [m].

    Returns
    -------
    dict
        ``ground_displacement`` (n, buildings) and ``absolute_displacement`` as ``displacement``.
    """
    ground = ground_displacements(study, motion, time)
    return {"ground_displacement": ground, "absolute_displacement": displacement + ground[:, :, None]}


def ground_displacements(study: Scene, motion: Motion, time: Samples) -> Array:
    """Displacement of the ground under each building at these times (n, buildings) [m], zero at 0 s."""
    supports = study.supports or (SHARED,) * len(study.buildings)
    ground = accelerations(supports, motion.acceleration, motion.own_grounds)
    if not is_apart(supports, ground):
        return np.repeat(displaced(ground, motion.dt, supports[0], time)[:, None], len(supports), axis=1)
    samples = np.broadcast_to(ground, (len(supports), ground.shape[-1]))
    columns = [displaced(row, motion.dt, support, time) for row, support in zip(samples, supports, strict=True)]
    return np.column_stack(columns)


def displaced(samples: Samples, dt: float, support: Support, time: Samples) -> Array:
    """Displacement [m] at these times of ground whose acceleration is on straight lines between samples [m/s²].

    ``support`` has the delay of the motion and the velocity of the ground before it.
    """
    slopes = np.append(np.diff(samples) / dt, 0.0)
    shifts, speeds = summed(np.full(samples.size, dt), samples, slopes, 0.0)
    elapsed = np.maximum(time - support.delay, 0.0)
    i = np.minimum((elapsed / dt).astype(np.int64), samples.size - 1)
    step_time = elapsed - i * dt
    shift = shifts[i] + step_time * (speeds[i] + step_time * (0.5 * samples[i] + step_time * slopes[i] / 6.0))
    return np.asarray(support.velocity * time + shift)
