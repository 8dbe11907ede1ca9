"""Condensation of a model to floors and interior modes, and what it leaves of the modes of the whole model.

With the floors f held, the other rows r vibrate in interior modes, K_rr φ = ω² M_rr φ. The slowest of them stand beside
the motion in which the rows follow the floors as under a steady load (`matrices.followed`, T):

    u = T u_f + Φ q,     K_qq = diag(μ ω²),   K_fq = 0,   M_qq = diag(μ),   M_fq = Tᵀ M Φ,   p_q = Φᵀ M r

(Craig and Bampton 1968, AIAA Journal 6(7), 1313). With all interior modes that have mass nothing is left out. Each q is
the displacement along the row where its mode moves most, so that q is in metres and μ, M_fq and p_q are masses.
"""

from __future__ import annotations

from math import inf, isnan
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.models.structures.matrices import condensed, condensed_masses, followed

Array = NDArray[np.float64]

LEAST_MOBILE = 1e-12  # of the largest 1/ω²: below it a mode has no mass that rounding leaves
# Of the mass that moves with a mode: what joins it to floors and ground motion is rounding below, as of modes of
# another direction.
LEAST_JOINED = 1e-10
LEAST_SHARE = 0.01  # of the mass that the ground drives, in modes of the whole model that `Condensation` has
# s, 1 / 33 Hz: spectra are anchored at the peak ground acceleration there (U.S. NRC Regulatory Guide 1.60).
SHORTEST_SHAKEN = 1.0 / 33.0
FAR_OFF = 0.02  # of a period: 4 % of a stiffness, which no model knows better
SAME = 0.5  # share of the kinetic energy by which a mode of the whole model is one of the condensed model


class Condensation(NamedTuple):
    """Modes of a whole model with 1 % and more of its driven mass, beside those of the model condensed from it."""

    rows: int  # of the whole model
    periods: tuple[float, ...] = ()  # s, of the whole model, slowest first
    shares: tuple[float, ...] = ()  # of the driven mass, in each of these modes
    here: tuple[float, ...] = ()  # s, the same mode of the condensed model; NaN where it has none

    def scaled(self, factor: float) -> Condensation:
        """That of a model whose periods are multiplied by a factor."""
        periods, here = (tuple(factor * period for period in many) for many in (self.periods, self.here))
        return self._replace(periods=periods, here=here)

    def words(self) -> str:
        """The periods of the whole model, and how far off they are in the condensed one."""
        listed = [
            f"{period:.4g} s ({f'{100.0 * (here / period - 1.0):+.2g} %' if here > 0.0 else 'none here'})"
            for period, here in zip(self.periods, self.here, strict=True)
        ]
        return (
            f"condensed from {self.rows} rows; modes of the whole model with {100 * LEAST_SHARE:g} % of the mass and "
            f"more, and how far off their periods are here: {', '.join(listed)}"
        )

    def worst(self) -> tuple[float, float] | None:
        """Periods [s] of the whole and the condensed model that differ most, within the band of ground motions.

        None where all are within 2 %; NaN is that of a mode which the condensed model lacks.
        """
        differing = [
            (inf if isnan(here) else abs(here / period - 1.0), period, here)
            for period, here in zip(self.periods, self.here, strict=True)
            if period >= SHORTEST_SHAKEN
        ]
        worst = max(differing, default=(0.0, 0.0, 0.0))
        return worst[1:] if worst[0] > FAR_OFF else None


class Model(NamedTuple):
    """A model of N rows; rows are counted from 1."""

    stiffness: Array  # N/m, (N, N)
    masses: Array  # kg, (N, N); (0, 0) where masses are lumped at floors
    dashpots: Array  # N s/m, (N, N), or of the floors alone; (0, 0) without
    floors: tuple[int, ...]  # rows of them, from the ground up
    along: tuple[int, ...] = ()  # all displacements along the row; empty where the floors are
    given: tuple[float, ...] = ()  # kg, on which a_g acts at floors, in place of what follows from ``along``

    @property
    def measured(self) -> Array:
        """Places of the rows along the row, counted from 0."""
        return np.array(self.along or self.floors) - 1

    @property
    def driven(self) -> Array:
        """r: 1 of the rows that the ground's acceleration acts on, 0 of others."""
        driven = np.zeros(len(self.stiffness))
        driven[self.measured] = 1.0
        return driven


class Condensed(NamedTuple):
    """Matrices over L floors and the interior modes behind them, and what they are of the whole model."""

    stiffness: Array  # N/m
    masses: Array  # kg; (0, 0) where they are lumped at floors
    dashpots: Array  # N s/m; (0, 0) without
    driven: Array  # kg, on which a_g acts, p; empty where masses are lumped
    motions: Array  # (N, L + interior modes), [T, Φ]


def condensed_model(model: Model, count: int = 0) -> Condensed:
    """The model condensed to its floors and to the ``count`` slowest interior modes that they or a_g move.

    Raises
    ------
    PoundingError
        Where there are fewer such modes, and for matrices of no building (`matrices.condensed_masses`).
    """
    if count and model.given:
        raise PoundingError(
            "interior_modes: floor_masses do not say what the ground's acceleration acts on there; write along_rows "
            "in their place"
        )
    floors = len(model.floors)
    stiffness, masses, driven = condensed(model.stiffness, model.floors), model.masses, np.zeros(0)
    moved = followed(model.stiffness, model.floors)
    shapes = _interior_shapes(model, moved, count)
    if masses.size:
        masses, driven = condensed_masses(model.masses, model.stiffness, model.floors, model.along, model.given)
    motions = np.hstack([moved, shapes])
    if count:
        modes = np.diag(np.einsum("ij,ik,kj->j", shapes, model.stiffness, shapes))
        stiffness = _bordered(stiffness, np.zeros((floors, count)), modes)
        modes = np.diag(np.einsum("ij,ik,kj->j", shapes, model.masses, shapes))
        masses = _bordered(masses, moved.T @ model.masses @ shapes, modes)
        driven = np.append(driven, shapes.T @ model.masses @ model.driven)
    dashpots = model.dashpots
    if len(dashpots) != floors or count:
        dashpots = _condensed_dashpots(model, motions)
    return Condensed(stiffness, masses, dashpots, driven, motions)


def _condensed_dashpots(model: Model, motions: Array) -> Array:
    """C over floors and interior modes, by the motions of M and K; none where the model has none."""
    if not model.dashpots.size:
        return model.dashpots
    if len(model.dashpots) != len(motions):
        rows = f"{len(motions)} rows of stiffness_matrix"
        if motions.shape[1] == len(model.floors):
            rows = f"{len(model.floors)} floors, or of the {rows}"
        raise PoundingError(
            f"damping_matrix has {counted(len(model.dashpots), 'row')}; give those of the {rows}, in the same order"
        )
    dashpots = motions.T @ model.dashpots @ motions
    return np.asarray(0.5 * (dashpots + dashpots.T))


def _interior_shapes(model: Model, moved: Array, count: int) -> Array:
    """Φ (N, count), zero at floors, 1 where a mode moves most along the row; ``moved`` is T."""
    size = len(model.stiffness)
    if not count:
        return np.zeros((size, 0))
    masses = model.masses if model.masses.size else np.zeros((size, size))
    interior = np.setdiff1d(np.arange(size), np.array(model.floors) - 1)
    if not interior.size:
        raise PoundingError("interior_modes: floor_rows names every row, and no other is left to have modes; remove it")
    _, within = slowest(masses[np.ix_(interior, interior)], model.stiffness[np.ix_(interior, interior)])
    shapes = np.zeros((size, within.shape[1]))
    shapes[interior] = within
    joins = np.column_stack([moved, model.driven])  # what moves with each floor, and with the ground
    heavy = np.einsum("ij,ik,kj->j", joins, masses, joins)
    cosines = (joins.T @ masses @ shapes) ** 2 / np.where(heavy > 0.0, heavy, np.inf)[:, None]
    joined = np.flatnonzero(cosines.max(axis=0) > LEAST_JOINED)
    if count > joined.size:
        raise PoundingError(
            f"interior_modes: {count} of a model whose rows that are no floors have {joined.size} modes with mass that "
            f"floors or the ground motion move; {f'write {joined.size} at most' if joined.size else 'remove it'}"
        )
    shapes = shapes[:, joined[:count]]
    along, most = (_largest(part) for part in (shapes[model.measured], shapes))
    return np.asarray(shapes / np.where(np.abs(along) > 1e-9 * np.abs(most), along, most))


def condensation_of(model: Model, motions: Array, modes: tuple[Array, Array]) -> Condensation:
    """Modes of the whole model beside those of the condensed one, whose ``modes`` are (frequencies [rad/s], shapes).

    A mode of the whole model is the one of the condensed model that has most of its kinetic energy, half at least.
    """
    squares, shapes = slowest(model.masses, model.stiffness)
    driven = motions[:, : len(model.floors)].sum(axis=1) if model.given and not model.along else model.driven
    shares = (shapes.T @ model.masses @ driven) ** 2 / (driven @ model.masses @ driven)
    alike = (shapes.T @ model.masses @ motions @ modes[1]) ** 2
    here = np.where(alike.max(axis=1) > SAME, 2.0 * np.pi / modes[0][alike.argmax(axis=1)], np.nan)
    shown, periods = shares >= LEAST_SHARE, 2.0 * np.pi / np.sqrt(squares)
    return Condensation(len(driven), *(tuple(values[shown].tolist()) for values in (periods, shares, here)))


def slowest(masses: Array, stiffness: Array) -> tuple[Array, Array]:
    """ω² [1/s²] and shapes with φᵀ M φ = 1 of all modes that have mass, slowest first; M may be singular.

    They are those of M φ = ω⁻² K φ, which has ω⁻² = 0 of a motion without mass.
    """
    try:
        inverse = np.linalg.inv(np.linalg.cholesky(stiffness))
    except np.linalg.LinAlgError:
        raise PoundingError(
            "stiffness_matrix is not positive definite in rows that are no floors: a motion of them has no stiffness; "
            "check its signs and that it holds the model on its ground"
        ) from None
    pliancies, vectors = np.linalg.eigh(inverse @ masses @ inverse.T)
    pliancies, shapes = pliancies[::-1], (inverse.T @ vectors)[:, ::-1]
    if pliancies[-1] < -1e-9 * pliancies[0]:
        raise PoundingError(
            "mass_matrix is not positive semidefinite in rows that are no floors; check its signs and its unit"
        )
    heavy = pliancies > LEAST_MOBILE * pliancies[0]
    return 1.0 / pliancies[heavy], shapes[:, heavy] / np.sqrt(pliancies[heavy])


def _largest(columns: Array) -> Array:
    """The number of each column that is farthest from zero."""
    return np.asarray(np.take_along_axis(columns, np.abs(columns).argmax(axis=0)[None], axis=0)[0])


def _bordered(of_floors: Array, beside: Array, of_modes: Array) -> Array:
    return np.block([[of_floors, beside], [beside.T, of_modes]])
