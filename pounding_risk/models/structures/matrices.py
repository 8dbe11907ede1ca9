"""Matrices of the floors of a building: checked, condensed to floors, or put together from modes.

A mode φ_j with the angular frequency ω_j and the ratio ζ_j, the shapes M-orthonormal (ΦᵀMΦ = 1), is one column of

    K = M Φ diag(ω²) Φᵀ M + ω_r² (M − M Φ Φᵀ M),     C = M Φ diag(2 ζ ω) Φᵀ M + 2 ζ_r ω_r (M − M Φ Φᵀ M)

The second terms are the motion that the given modes leave out, all of it with one frequency ω_r (Chopra, Dynamics of
Structures, section 12.12: static correction, where ω_r is well above those of the excitation).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pounding_risk.errors import PoundingError

Array = NDArray[np.float64]

ASYMMETRY = 1e-4  # of the largest number of a matrix: programs write some six digits
LEAST_STIFF = 1e-12  # of the largest ω²: below it a mode has no stiffness that rounding leaves
LEAST_HEAVY = 1e-9  # of a mass matrix with a diagonal of 1: below it a motion has no mass that rounding leaves
NOT_ORTHOGONAL = 0.02  # cosine between two shapes: more is no rounding of shapes of two digits
RESIDUAL_SHARE = 1.0 / 3.0  # of the shortest given period, where no residual_period is given: see `assembled`
# Masses that the ground drives, over a mass matrix in all: of a beam condensed to three floors 1.03, to its tip 1.59.
DRIVEN_SHARES = 0.75, 2.0
MASS_SHARE = 0.05  # of the mass, by which an effective mass of a file may differ from that of its shape


class ModeTable(NamedTuple):
    """Modes as a program of structural analysis writes them; in SI."""

    periods: tuple[float, ...]  # s
    shapes: tuple[tuple[float, ...], ...]  # of each mode at the floors, from the ground up; of any size
    dampings: tuple[float, ...] = ()  # ratios; empty where one holds for all
    effective_masses: tuple[float, ...] = ()  # kg, to check the shapes by; empty where not known


def symmetric(matrix: ArrayLike, name: str) -> Array:
    """A square matrix without the differences that rounding leaves across its diagonal.

    Raises
    ------
    PoundingError
        Where it is not square, not finite, or not symmetric by more than 1e-4 of its largest number.
    """
    try:
        numbers = np.asarray(matrix, dtype=float)
    except ValueError:
        words = "has rows of unlike lengths; write every row in full, on both sides of the diagonal"
        raise PoundingError(f"{name} {words}") from None
    if numbers.ndim != 2 or numbers.shape[0] != numbers.shape[1] or not numbers.size:
        sizes = " by ".join(map(str, numbers.shape))
        raise PoundingError(f"{name} has {sizes} numbers; a matrix has as many rows as columns")
    if not np.isfinite(numbers).all():
        row, column = np.argwhere(~np.isfinite(numbers))[0] + 1
        raise PoundingError(f"{name}: row {row}, column {column} is no finite number")
    off = np.abs(numbers - numbers.T)
    if off.max() > ASYMMETRY * np.abs(numbers).max():
        row, column = np.unravel_index(off.argmax(), off.shape)
        raise PoundingError(
            f"{name} is not symmetric: {numbers[row, column]:g} in row {row + 1}, column {column + 1}, and "
            f"{numbers[column, row]:g} across the diagonal; give the whole matrix, not one half of it"
        )
    return np.asarray(0.5 * (numbers + numbers.T))


def condensed(stiffness: Array, rows: Sequence[int]) -> Array:
    """The stiffness of some rows, counted from 1, where no load acts on the others.

    K_ff − K_fr K_rr⁻¹ K_rf (Guyan 1965): exact where the other rows have neither mass nor damping.
    """
    floors = np.array(rows) - 1
    left_out = np.setdiff1d(np.arange(len(stiffness)), floors)
    of_floors = stiffness[np.ix_(floors, floors)]
    if not left_out.size:
        return of_floors
    stiff = of_floors + stiffness[np.ix_(left_out, floors)].T @ followed(stiffness, rows)[left_out]
    return np.asarray(0.5 * (stiff + stiff.T))


def followed(stiffness: Array, rows: Sequence[int]) -> Array:
    """How all rows of a stiffness move with some of them, counted from 1, where no load acts on the others.

    T of (N, floors), with u = T u_f: 1 of the floors themselves, −K_rr⁻¹ K_rf of the others.
    """
    floors = np.array(rows) - 1
    left_out = np.setdiff1d(np.arange(len(stiffness)), floors)
    moved = np.zeros((len(stiffness), floors.size))
    moved[floors] = np.eye(floors.size)
    try:
        moved[left_out] = -np.linalg.solve(stiffness[np.ix_(left_out, left_out)], stiffness[np.ix_(left_out, floors)])
    except np.linalg.LinAlgError:
        raise PoundingError(
            "stiffness_matrix: a row that is no floor moves without any force when the floors are held; leave out "
            "the rows of such a mechanism, or restrain it"
        ) from None
    return moved


def condensed_masses(
    masses: Array, stiffness: Array, rows: Sequence[int], along: Sequence[int] = (), given: Sequence[float] = ()
) -> tuple[Array, Array]:
    """The mass matrix of some rows [kg], and the masses of these by which the ground's acceleration acts [kg].

    Tᵀ M T and Tᵀ M r, T of `followed` and r 1 of displacements along the row (Guyan 1965): of motion so slow that the
    other rows follow as under a steady load.

    Parameters
    ----------
    masses, stiffness : ndarray, shape (N, N)
        Of all rows [kg, N/m].
    rows : sequence of int
        The floors, counted from 1.
    along : sequence of int, optional
        All displacements along the row, counted from 1; without them the floors alone.
    given : sequence of float, optional
        The masses by which the ground's acceleration acts, in place of those that follow from ``along`` [kg].

    Raises
    ------
    PoundingError
        For masses of rows that are no floors, of which is not known whether the ground's acceleration acts on them;
        and for those of no building, such as a floor that a_g would drive the other way.
    """
    moved = followed(stiffness, rows)
    driven = np.zeros(len(masses))
    driven[np.array(along or rows) - 1] = 1.0
    if not along and not given:
        heavy = np.flatnonzero(np.abs(masses).sum(axis=1) * (1.0 - driven) > 0.0)
        if heavy.size:
            raise PoundingError(
                f"mass_matrix has mass in row {heavy[0] + 1}, which is no floor; name the rows that are displacements "
                "along the row, floors and others, in along_rows: the ground's acceleration acts on the masses of these"
            )
    condensed_mass = moved.T @ masses @ moved
    inertia = np.asarray(0.5 * (condensed_mass + condensed_mass.T))
    check_masses(inertia)
    if given:
        return inertia, np.array(given)
    loads = np.asarray(moved.T @ masses @ driven)
    if not loads.min() > 0.0:
        raise PoundingError(
            f"mass_matrix: the ground's acceleration would act on {loads.min():.4g} kg of floor {loads.argmin() + 1}, "
            "the sum of its row over displacements along the row; check its signs and its unit"
        )
    if along and not _is_of_one_building(inertia, loads):
        raise PoundingError(
            f"along_rows: the ground's acceleration would act on {loads.sum() / 1e3:.4g} t, where floors that move as "
            f"one have {inertia.sum() / 1e3:.4g} t; name all rows that are displacements along the row, floors and "
            "others, and no rotations"
        )
    return inertia, loads


def check_driven(masses: Array, driven: Array) -> None:
    """Raises PoundingError where a mass matrix and the masses that the ground drives are not of one building [kg]."""
    if not _is_of_one_building(masses, driven):
        raise PoundingError(
            f"floor_masses are {driven.sum() / 1e3:.4g} t in all and those of mass_matrix {masses.sum() / 1e3:.4g} t; "
            "remove floor_masses, by which the ground's acceleration acts in place of the row sums, or check both units"
        )


def _is_of_one_building(masses: Array, driven: Array) -> bool:
    return bool(DRIVEN_SHARES[0] * masses.sum() <= driven.sum() <= DRIVEN_SHARES[1] * masses.sum())


def check_masses(masses: Array) -> None:
    """Raises PoundingError for a mass matrix [kg] in which a motion has no kinetic energy."""
    root = np.sqrt(np.abs(np.diag(masses))) + (np.diag(masses) == 0.0)
    least = float(np.linalg.eigvalsh(masses / np.outer(root, root))[0])
    if not least > LEAST_HEAVY:
        raise PoundingError(
            f"mass_matrix is not positive definite: its smallest eigenvalue is {least:.3g}, over the roots of its "
            "diagonal; check its signs, and name the rows of floors in floor_rows where others have no mass"
        )


def check_stiff(stiffness: Array, masses: Array) -> None:
    """Raises PoundingError for floors [N/m, kg] of which a mode has no stiffness."""
    root = np.sqrt(masses)
    squares = np.linalg.eigvalsh(stiffness / np.outer(root, root))
    loose = int((squares <= LEAST_STIFF * squares[-1]).sum())
    if loose:
        raise PoundingError(
            f"stiffness_matrix is not positive definite: {loose} of {len(squares)} modes "
            f"{'has' if loose == 1 else 'have'} no stiffness (the smallest ω² is {squares[0]:.3g} 1/s²); check that "
            "it holds the building on its ground, that its rows are in the order of the floors, and its unit"
        )


def check_part(stiffness: Array, storeys: Array) -> None:
    """Raises PoundingError where storeys that yield are no part of the stiffness of all floors [N/m]."""
    least = float(np.linalg.eigvalsh(stiffness - storeys)[0])
    if least < -ASYMMETRY * np.abs(stiffness).max():
        raise PoundingError(
            f"storey_stiffnesses are more than the stiffness_matrix has: without them a motion would have {least:.3g} "
            "N/m; write the part of it that yields"
        )


def assembled(
    table: ModeTable, masses: Array, damping: float, residual_period: float = 0.0
) -> tuple[Array, Array | None]:
    """K [N/m] and C [N s/m] of floors that vibrate in given modes; C is None where one ratio holds for all.

    Parameters
    ----------
    table : ModeTable
        As many modes as floors at most.
    masses : ndarray, shape (floors,)
        Of the floors [kg]. The shapes are made orthogonal over them by the change that is smallest in their sum of
        squares (Löwdin 1950), which removes what the rounding of a printed table has left.
    damping : float
        Ratio of modes where the table has none.
    residual_period : float
        Period of all motion that the modes leave out [s]; without it a third of the shortest period given. The next
        mode of a uniform shear building of many storeys has 3/5 of its second mode's period and more of later ones:
        a third is stiffer than what a building has there, and near static for the ground motion.

    Raises
    ------
    PoundingError
        For shapes that are not orthogonal over these masses, too many modes, effective masses of others, and a
        residual period among those of the modes.
    """
    count, floors = len(table.periods), len(masses)
    if count > floors:
        raise PoundingError(f"modes has {count} modes of {floors} floors; give as many at most, the slowest first")
    lengths = {len(shape) for shape in table.shapes} - {floors}
    if lengths:
        raise PoundingError(f"modes has shapes of {min(lengths)} floors, floor_masses {floors}; write one for each")
    root = np.sqrt(masses)
    scaled = np.array(table.shapes).T * root[:, None]
    sizes = np.linalg.norm(scaled, axis=0)
    if not (sizes > 0.0).all():
        raise PoundingError(f"modes: mode {int(np.argmin(sizes)) + 1} moves no floor")
    scaled /= sizes
    _check_orthogonal(scaled)
    _check_masses(table, scaled, root)
    left, _, right = np.linalg.svd(scaled, full_matrices=False)
    shapes = left @ right
    if residual_period > min(table.periods):
        raise PoundingError(
            f"residual_period: {residual_period:g} s is longer than the shortest period of modes, "
            f"{min(table.periods):g} s, and would come before it; write a shorter one, or remove it"
        )
    rates = 2.0 * np.pi / np.array(table.periods)
    residual = 2.0 * np.pi / (residual_period or RESIDUAL_SHARE * min(table.periods))
    ratios = np.array(table.dampings or (damping,) * count)
    residual_part = np.eye(floors) - shapes @ shapes.T if count < floors else np.zeros((floors, floors))
    weights = np.outer(root, root)
    stiffness = weights * ((shapes * rates**2) @ shapes.T + residual**2 * residual_part)
    dashpots = weights * ((shapes * (2.0 * ratios * rates)) @ shapes.T + 2.0 * ratios[-1] * residual * residual_part)
    return 0.5 * (stiffness + stiffness.T), (0.5 * (dashpots + dashpots.T) if table.dampings else None)


def _check_orthogonal(scaled: Array) -> None:
    cosines = np.abs(scaled.T @ scaled - np.eye(scaled.shape[1]))
    if cosines.max(initial=0.0) > NOT_ORTHOGONAL:
        first, second = sorted(np.unravel_index(cosines.argmax(), cosines.shape))
        raise PoundingError(
            f"modes: the shapes of modes {first + 1} and {second + 1} are not orthogonal over floor_masses (cosine "
            f"{cosines.max():.2f}); give modes of motion along the row alone, at the floors in their order, and the "
            "masses of the same model"
        )


def _check_masses(table: ModeTable, scaled: Array, root: Array) -> None:
    total = float(root @ root)
    for mode, (stated, shape) in enumerate(zip(table.effective_masses, scaled.T, strict=False), start=1):
        computed = float((shape @ root) ** 2)
        if abs(stated - computed) > MASS_SHARE * total:
            raise PoundingError(
                f"modes: mode {mode} has an effective mass of {stated / 1e3:.4g} t, and its shape with floor_masses "
                f"{computed / 1e3:.4g} t, of {total / 1e3:.4g} t in all; check units, the order of the floors, and "
                "that the masses are those of the same model"
            )
