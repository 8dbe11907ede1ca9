"""Modes of each building of a scene on its own: periods, shapes, participation factors and damping ratios."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys, effective_shares, vibration
from pounding_risk.scene.reader import as_scene
from pounding_risk.scene.scene import Scene

Array = NDArray[np.float64]


class Modes(NamedTuple):
    """Modes of one building, slowest first; a rigid building has none.

    Parameters
    ----------
    name : str
        Name of the building.
    levels : ndarray, shape (levels,)
        Heights above the ground of what moves [m]; NaN where unknown, 0 of a foundation.
    periods : ndarray, shape (modes,)
        Periods [s].
    shapes : ndarray, shape (levels, modes)
        Mode shapes, 1 where a mode moves most and positive at the roof.
    participations : ndarray, shape (modes,)
        Γ = φᵀ M 1 / φᵀ M φ of these shapes, so that all Γ φ add up to 1 at every level.
    shares : ndarray, shape (modes,)
        Effective modal masses over the mass of the building with its foundation; they add up to 1.
    dampings : ndarray, shape (modes,)
        ζ = φᵀ C φ / (2 ω φᵀ M φ) of a mode alone, where a dashpot on soil couples the modes.
    """

    name: str
    levels: Array
    periods: Array
    shapes: Array
    participations: Array
    shares: Array
    dampings: Array


def modes(scene: Scene | str | Path) -> tuple[Modes, ...]:
    """Periods, participation and damping of each building.

    Parameters
    ----------
    scene : Scene or path
        A scene, or the path of its TOML file.

    Returns
    -------
    tuple of Modes
        One for each building, left to right.

    Raises
    ------
    PoundingError
        If the scene cannot be read, or a building cannot take an effect.
    """
    study = as_scene(scene)
    return tuple(building_modes(building, study.effects) for building in study.buildings)


def building_modes(
    building: Building | Storeys, effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]] = ()
) -> Modes:
    """Modes of one building under effects given as (name, options); raises PoundingError as `chain_of` does."""
    chain = chain_of(building, effects)
    inertia = chain.inertia if chain.inertia.size else chain.mass
    frequencies, normal = vibration(inertia, chain.spring, chain.stiffness() if chain.coupling.size else None)
    driven = chain.mass * chain.felt()
    shares = effective_shares(driven, normal, are_lumped=not chain.inertia.size)
    modal_damping = np.einsum("ij,ik,kj->j", normal, chain.damping, normal)
    normal = normal * np.where(normal[chain.foundations + chain.floors - 1 :][:1] < 0.0, -1.0, 1.0)
    displacements = normal[: chain.foundations + chain.floors]  # of floors that rotate their displacements alone
    largest = np.abs(displacements).max(axis=0, initial=0.0)
    largest[largest == 0.0] = 1.0  # a rotation alone
    heights = building.levels if isinstance(building, Storeys) else building.heights or (np.nan,) * chain.mass.size
    levels = np.array([0.0] * chain.foundations + list(heights)) if chain.mass.size else np.empty(0)
    periods, dampings = 2.0 * np.pi / frequencies, modal_damping / (2.0 * frequencies)
    return Modes(building.name, levels, periods, displacements / largest, (driven @ normal) * largest, shares, dampings)
