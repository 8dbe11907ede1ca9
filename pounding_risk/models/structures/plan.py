"""Floors that rotate: plans of a building whose centres of stiffness are not its centres of mass.

Floor i has a displacement u along the row and a rotation θ about its centre of mass; a place y across the row moves by
u − (y − y_i) θ, y_i the place of that centre. Storey j, below floor j, has the stiffness k at its centre of stiffness,
y_j + e, and the stiffness k Ω² ρ² against rotation about it, Ω the frequency of rotation over that of translation and
ρ the radius of gyration (Chopra, Dynamics of Structures, section 9.6). With d the drift of the storey at a place and
φ = θ_j − θ_(j−1), springs hold the energy

    ½ Σ_j k [d(y_j + e)² + Ω² ρ² φ²],     d(y) = u_j − (y − y_j) θ_j − u_(j−1) + (y − y_(j−1)) θ_(j−1)

and the masses of u and θ of floor i are m and ρ² m. Where the plan is the same on all floors each mode of the storeys
becomes two, with ω² times the eigenvalues of [[1, −e/ρ], [−e/ρ, (e/ρ)² + Ω²]].

Where centres of stiffness are off along the row too, at x_j + s, floors also move across the row, by w, with Λ the
frequency across over that along, under a second component of the ground motion (section 9.6, a building of one storey
with two-way asymmetry). Each storey then holds ½ k Λ² c(x_j + s)² more, c(x) the drift across at a place,
w_j + (x − x_j) θ_j − w_(j−1) − (x − x_(j−1)) θ_(j−1).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Plan(NamedTuple):
    """The plan of a floor and of the storey below it; lengths [m], across the row where nothing else is said."""

    face: tuple[float, float]  # both ends of the faces towards the neighbours
    centre: float  # of mass
    eccentricity: float  # of the centre of stiffness from that of mass, e
    gyration: float  # radius of gyration about the centre of mass, ρ
    torsional_ratio: float  # Ω
    eccentricity_along: float | None = None  # the same along the row, s; None where floors do not move across it
    across_ratio: float = 1.0  # Λ
    centre_along: float = 0.0  # of mass along the row, from one vertical axis of the building, x

    @property
    def moves_across(self) -> bool:
        """True where floors move across the row too, under the second component of the ground motion."""
        return self.eccentricity_along is not None


def plan_inertias(plans: Sequence[Plan], masses: Array) -> Array:
    """Masses [kg] of u of all floors, then of θ [kg m²] and, where floors move across the row, of w."""
    inertias = [masses, masses * np.array([plan.gyration for plan in plans]) ** 2, masses]
    return np.concatenate(inertias[: 3 if plans[0].moves_across else 2])


def plan_stiffness(plans: Sequence[Plan], springs: Array) -> Array:
    """K of u, θ and, where floors move across the row, w of all floors, from the springs of the storeys [N/m]."""
    count = len(plans)
    still, drifts = np.zeros((count, count)), np.eye(count) - np.eye(count, k=-1)
    ratio, gyration = (np.array([getattr(plan, key) for plan in plans]) for key in ("torsional_ratio", "gyration"))
    along = np.hstack([drifts, -_arms(plans, "centre", "eccentricity") * drifts])
    rotation = np.hstack([still, ratio[:, None] * gyration[:, None] * drifts])
    strains = np.vstack([along, rotation])
    if plans[0].moves_across:
        across = np.hstack([still, _arms(plans, "centre_along", "eccentricity_along") * drifts, drifts])
        stiffer = np.array([[plan.across_ratio] for plan in plans])
        strains = np.vstack([np.pad(strains, ((0, 0), (0, count))), stiffer * across])
    weighted = np.sqrt(np.tile(springs, len(strains) // count))[:, None] * strains
    return np.asarray(weighted.T @ weighted)


def _arms(plans: Sequence[Plan], centre: str, eccentricity: str) -> Array:
    """Distance of each storey's centre of stiffness (rows) from each floor's centre of mass (columns) [m]."""
    centres = np.array([getattr(plan, centre) for plan in plans])
    return np.asarray(centres[:, None] - centres + np.array([[getattr(plan, eccentricity)] for plan in plans]))
