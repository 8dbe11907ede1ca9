"""Buildings of several storeys: lumped masses on shear springs, from the ground up, with a stated damping.

The storey below floor i has the stiffness k_i and makes the shear V_i = k_i (u_i − u_{i−1}), u_0 = 0 at the ground:

    M ü + C u̇ + K u = −M 1 a_g(t),     M = diag(m_i),     K tridiagonal: k_i + k_{i+1} on the diagonal, −k_i beside it

With S = diag(sqrt k) D M^(−1/2), D the differences of neighbouring floors, K = M^(1/2) SᵀS M^(1/2): the singular values
of S are the angular frequencies. They come out to rounding, the slowest too, however stiff the stiffest storey is.

A building whose floors are joined in another way, such as a frame or a wall in bending, has its stiffness matrix K in
place of storey springs. One whose masses are not lumped at floors has a mass matrix, and p of M ü + C u̇ + K u = −p a_g.
Behind its floors may stand coordinates of interior modes (`condensation`), which no level has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from dataclasses import field as declared
from itertools import accumulate
from math import inf, pi
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk import units
from pounding_risk._common.counted import counted
from pounding_risk.errors import PoundingError
from pounding_risk.models.ground import SHARED, Support
from pounding_risk.models.structures.condensation import Condensation
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.isolation import IsolatorLaw, Isolators
from pounding_risk.models.structures.matrices import check_driven, check_masses, check_part, check_stiff, symmetric
from pounding_risk.models.structures.plan import Plan, plan_inertias, plan_stiffness
from pounding_risk.models.structures.typologies import known_typology
from pounding_risk.units import STANDARD_GRAVITY, Quantity, bounds, shown

Array = NDArray[np.float64]

DAMPING_RULES = ("modal", "rayleigh", "stiffness")
BY_MATRIX = "matrix"  # the rule of a building that has its own damping matrix
MOST_STOREYS = 200  # of a building that a scene describes
RAYLEIGH_SHARE = 0.95  # of the mass: Rayleigh's second mode is the one by which the modes carry so much of it


class Vibration(NamedTuple):
    """Modes of masses on springs, slowest first; shapes are columns with φᵀ M φ = 1, positive at the top."""

    frequencies: Array  # rad/s
    shapes: Array  # kg^(−1/2), (floors, modes)


def vibration(masses: Array, springs: Array, stiffness: Array | None = None) -> Vibration:
    """The modes of masses [kg] on springs [N/m], each spring below its mass; all of them positive.

    Where a ``stiffness`` matrix [N/m] is given it stands in place of the springs; ``masses`` may then be a matrix.
    """
    if masses.ndim > 1 and stiffness is not None:
        inverse = np.linalg.inv(np.linalg.cholesky(masses))
        squares, vectors = np.linalg.eigh(inverse @ stiffness @ inverse.T)
        frequencies, shapes = np.sqrt(squares), inverse.T @ vectors
    elif stiffness is not None:
        root = np.sqrt(masses)
        squares, vectors = np.linalg.eigh(stiffness / np.outer(root, root))
        frequencies, shapes = np.sqrt(squares), vectors / root[:, None]
    else:
        root = np.sqrt(masses)
        drifts = np.eye(root.size) - np.eye(root.size, k=-1)
        _, falling, rows = np.linalg.svd(np.sqrt(springs)[:, None] * drifts / root)
        frequencies, shapes = falling[::-1], rows[::-1].T / root[:, None]
    return Vibration(frequencies, shapes * np.where(shapes[-1:] < 0.0, -1.0, 1.0))


def stiffness_matrix(springs: Array) -> Array:
    """K of a chain of springs [N/m], the first one on the ground."""
    above = springs[1:]
    return np.diag(springs + np.append(above, 0.0)) - np.diag(above, 1) - np.diag(above, -1)


@dataclass(frozen=True)
class Storeys:
    """A lumped-mass shear building, storeys from the ground up.

    ``damping_rule`` "modal": every mode has the ratio ζ, C = M Φ diag(2 ζ ω) Φᵀ M; "rayleigh": C = α M + β K with ζ in
    the first mode and in the one by which the modes carry 95 % of the mass, the second at least; "stiffness": C = β K
    with ζ in the first mode. A ``stiffness_matrix`` stands in place of ``stiffnesses``, and a ``damping_matrix`` is C
    itself, of the rule "matrix"; ``damping`` is then the ratio of the first mode. Beside it a ``mass_matrix`` is M, and
    ``masses`` are those by which the ground's acceleration acts on each floor, its row sums where all mass is at
    floors. Rows of the matrices behind those of the floors are interior modes, ``interior_masses`` those by which it
    acts on them. The matrices are those of the floors above the slab where the building has ``isolators``.
    ``strengths`` are the storeys' yield shears for `inelastic_storeys`; without any the building stays elastic. Beside
    a ``stiffness_matrix`` they are those of ``stiffnesses``, a part of it. Without
    ``initial_displacement`` and ``initial_velocity`` it begins at rest. Files of ``displacement_history`` give u
    without contact in place of the equation. With ``plans`` floors rotate, and matrices and modes are those of all
    their motions. Raises PoundingError for numbers that no building has.

    >>> round(Storeys("A", (25e3,) * 3, (3.46e6,) * 3, (3.0,) * 3).period, 4)
    1.2001
    """

    name: str
    masses: tuple[float, ...]  # kg, of each floor
    stiffnesses: tuple[float, ...]  # N/m, of the storey below each floor
    heights: tuple[float, ...]  # m, of each storey
    damping: float = 0.05
    damping_rule: str = "modal"
    strengths: tuple[float, ...] = ()  # N, yield shear of each storey
    initial_displacement: tuple[float, ...] = ()  # m, of each floor relative to the ground when the motion begins
    initial_velocity: tuple[float, ...] = ()  # m/s
    support: Support = SHARED  # what a_g is under it
    # N/m, of the floors above a slab; empty where storeys are springs
    stiffness_matrix: tuple[tuple[float, ...], ...] = ()
    damping_matrix: tuple[tuple[float, ...], ...] = ()  # N s/m; empty where a rule makes it
    mass_matrix: tuple[tuple[float, ...], ...] = ()  # kg; empty where masses are lumped at floors
    displacement_history: tuple[str, ...] = ()
    isolators: Isolators | None = None  # of its lowest storey, whose floor is their slab
    plans: tuple[Plan, ...] = ()  # of floors that rotate, one of each; empty where none does
    hysteresis: Hysteresis | None = None  # of storeys that yield; None is bilinear, under `inelastic_storeys`
    column_strength: float = inf  # N, at which its columns yield where a floor strikes them; infinite if not given
    interior_masses: tuple[float, ...] = ()  # kg, by which a_g acts on interior modes, rows behind those of floors
    condensation: Condensation | None = declared(default=None, compare=False, repr=False)  # what it was condensed from

    is_rigid = False

    def __post_init__(self) -> None:
        for field, key, quantity in _LISTS:
            object.__setattr__(self, field, tuple(map(float, getattr(self, field))))
            self._check(key, getattr(self, field), quantity)
        if self.stiffness_matrix:
            self._take_matrices()
        if not units.DAMPING.allows(self.damping):
            repair = "check the unit of damping_matrix" if self.damping_matrix else "such as damping = 0.05"
            raise PoundingError(
                f"{self.name}: a damping of {self.damping:g} is out of range; the ratio must be "
                f"{bounds(units.DAMPING)}, {repair}"
            )
        if self.damping_rule not in ((BY_MATRIX,) if self.damping_matrix else DAMPING_RULES):
            raise PoundingError(
                f"{self.name}: {shown(self.damping_rule)} is not a damping_rule; it may be {', '.join(DAMPING_RULES)}"
            )

    def _check(self, key: str, values: tuple[float, ...], quantity: Quantity) -> None:
        """Raises PoundingError where a list has not one value for each floor, or one out of range."""
        floors = len(self.masses)
        if not floors:
            raise PoundingError(f'{self.name}: no floor; write floor_masses = ["44 t", "44 t"], from the ground up')
        needed = key in _NEEDED and not (key == "storey_stiffnesses" and self.stiffness_matrix)
        if len(values) != floors and (values or needed):
            raise PoundingError(
                f"{self.name}: {len(values)} {key} for {floors} floor_masses; write one for each, from the ground up"
            )
        for number, value in enumerate(values, 1):
            if not quantity.allows(value):
                raise PoundingError(
                    f"{self.name}: {value:g} {quantity.unit} is out of range for number {number} of {key}; "
                    f"a {quantity.words} must be {bounds(quantity)}"
                )

    def _take_matrices(self) -> None:
        """Keep the matrices as tuples, symmetric; raises PoundingError where they hold no building of these floors."""
        for field in ("stiffness_matrix", "damping_matrix", "mass_matrix"):
            if not getattr(self, field):
                continue
            try:
                matrix = symmetric(getattr(self, field), field)
                masses = np.array(self.masses[self._slabs :])
                floors = slice(masses.size)
                if len(matrix) != masses.size + len(self.interior_masses):
                    modes = f" and {len(self.interior_masses)} interior_masses" if self.interior_masses else ""
                    raise PoundingError(
                        f"{field} has {counted(len(matrix), 'row')} for {masses.size} floor_masses{modes}; give a row "
                        "for each floor, from the ground up, or name the rows of floors in floor_rows"
                    )
                if field == "stiffness_matrix":
                    check_stiff(matrix[floors, floors], masses)
                    if self.stiffnesses:
                        check_part(matrix[floors, floors], stiffness_matrix(np.array(self.stiffnesses[self._slabs :])))
                elif field == "mass_matrix":
                    check_masses(matrix)
                    check_driven(matrix[floors, floors], masses)
                elif np.linalg.eigvalsh(matrix)[0] < -1e-9 * np.abs(matrix).max():
                    raise PoundingError("damping_matrix adds energy to a motion; check its signs and its rows")
            except PoundingError as error:
                raise PoundingError(f"{self.name}: {error}") from None
            object.__setattr__(self, field, tuple(map(tuple, matrix.tolist())))

    @property
    def _slabs(self) -> int:
        """Number of floors below the building itself: 1 on isolators."""
        return 0 if self.isolators is None else 1

    @property
    def levels(self) -> tuple[float, ...]:
        """Height of each floor above the ground [m]."""
        return tuple(accumulate(self.heights))

    @property
    def height(self) -> float:
        """Height of the roof above the ground [m]."""
        return self.levels[-1]

    @property
    def mass(self) -> float:
        """Mass of all floors together [kg]."""
        return sum(self.masses)

    @property
    def period(self) -> float:
        """Period of the first mode [s], on rigid ground and without P-Δ."""
        return float(2.0 * pi / self.vibration().frequencies[0])

    @property
    def isolator_law(self) -> IsolatorLaw | None:
        """The force of its isolators; None without any."""
        return None if self.isolators is None else self.isolators.law(self.mass)

    @property
    def isolated_period(self) -> float:
        """Period of the first mode while the isolators yield [s], that of their k_2; `period` without isolators."""
        law = self.isolator_law
        if law is None:
            return self.period
        springs = np.array((law.soft, *self.stiffnesses[1:]))
        modes = vibration(self._inertia(), springs, self._matrix(law.soft))
        return float(2.0 * pi / modes.frequencies[0])

    @property
    def storey_springs(self) -> tuple[float, ...]:
        """Stiffness of each storey [N/m]; where a matrix is given, shear over drift in the first mode."""
        if not self.stiffness_matrix:
            return self.stiffnesses
        whole = self.vibration().shapes[:, 0]
        masses, inertia, shape = self.masses, self.mass_coupling(), whole[: len(self.masses)]
        if inertia.size:  # of which each floor carries (M φ)_i
            masses = tuple(((inertia @ whole)[: len(shape)] / np.where(shape == 0.0, inf, shape)).tolist())
        springs = stiffnesses_for(masses, shape.tolist(), self.period)
        return tuple(abs(spring) for spring in springs)

    def isolated(self, isolators: Isolators) -> Storeys:
        """The building on isolators, which are its storey 1, with their slab as floor 1; it begins at rest."""
        if self.interior_masses or not has_lumped_weight(np.array(self.mass_matrix), np.array(self.masses)):
            raise PoundingError(f"{self.name}: isolation {NEEDS_WEIGHT}")
        law = isolators.law(self.mass + isolators.slab_mass)
        return replace(
            self,
            masses=(isolators.slab_mass, *self.masses),
            stiffnesses=(law.stiff, *self.stiffnesses) if self.stiffnesses else (),
            heights=(isolators.height, *self.heights),
            strengths=(inf, *self.strengths) if self.strengths else (),
            initial_displacement=(),
            initial_velocity=(),
            isolators=isolators,
        )

    def superstructure(self) -> Storeys:
        """The building above its slab, on the ground and at rest; the building itself without isolators."""
        if self.isolators is None:
            return self
        above = {field: getattr(self, field)[1:] for field in ("masses", "stiffnesses", "heights", "strengths")}
        return replace(self, **above, initial_displacement=(), initial_velocity=(), isolators=None)

    def with_period(self, period: float) -> Storeys:
        """The building whose stiffnesses have the same ratios and whose first mode has this period [s]."""
        scale = (self.period / period) ** 2
        return replace(self, stiffnesses=tuple(scale * stiffness for stiffness in self.stiffnesses))

    def vibration(self) -> Vibration:
        """The modes, on rigid ground and without P-Δ."""
        law = self.isolator_law
        matrix = self._matrix(0.0 if law is None else law.stiff)
        modes = vibration(self._inertia(), np.array(self.stiffnesses), matrix)
        if not self.interior_masses:
            return modes
        return modes._replace(shapes=modes.shapes * np.where(modes.shapes[len(self.masses) - 1] < 0.0, -1.0, 1.0))

    def mass_coupling(self) -> Array:
        """M [kg] of floors whose masses are not lumped there, with a slab of isolators; empty where all are."""
        matrix = np.array(self.mass_matrix)
        is_lumped = not self.interior_masses and np.array_equal(matrix, np.diag(self.masses[self._slabs :]))
        if not matrix.size or is_lumped:
            return np.zeros((0, 0))
        return matrix if self.isolators is None else with_base(matrix, self.masses[0])

    def _inertia(self) -> Array:
        """Mass of each floor as `inertias` has it, or the mass matrix where there is one [kg]."""
        matrix = self.mass_coupling()
        return matrix if matrix.size else self.inertias()

    def inertias(self) -> Array:
        """Mass of each floor [kg]; of floors that rotate then what `plan_inertias` adds."""
        masses = np.array(self.masses)
        return plan_inertias(self.plans, masses) if self.plans else masses

    def _matrix(self, below: float) -> Array | None:
        """K of one by a matrix or with plans, ``below`` the stiffness [N/m] of isolators; None of storey springs."""
        if self.plans:
            return plan_stiffness(self.plans, np.array(self.stiffnesses))
        if not self.stiffness_matrix:
            return None
        above = np.array(self.stiffness_matrix)
        return above if self.isolators is None else on_base(above, below)

    def coupling(self) -> Array:
        """What joins the floors beside the springs of storeys and isolators [N/m]; empty of storey springs alone."""
        matrix = self._matrix(0.0)
        if matrix is None:
            return np.zeros((0, 0))
        return matrix - self._yielding() if self.stiffness_matrix and self.stiffnesses else matrix

    def _yielding(self) -> Array:
        """The part [N/m] of a stiffness matrix that its storeys are which may yield, above isolators."""
        above = stiffness_matrix(np.array(self.stiffnesses[self._slabs :]))
        above = np.pad(above, (0, len(self.interior_masses)))
        return above if self.isolators is None else on_base(above, 0.0)

    def elastic_stiffness(self) -> Array:
        """K [N/m] while all is elastic."""
        law = self.isolator_law
        matrix = self._matrix(0.0 if law is None else law.stiff)
        return stiffness_matrix(np.array(self.stiffnesses)) if matrix is None else matrix

    def matrices(self) -> tuple[Array, Array, Array]:
        """M [kg], C [N s/m] and K [N/m]."""
        inertia, stiffness = self._inertia(), self.elastic_stiffness()
        return inertia if inertia.ndim > 1 else np.diag(inertia), self._damping(inertia, stiffness), stiffness

    def first_damping(self) -> float:
        """φᵀ C φ / 2 ω of the first mode, φᵀ M φ = 1."""
        frequencies, shapes = self.vibration()
        return float(shapes[:, 0] @ self.matrices()[1] @ shapes[:, 0] / (2.0 * frequencies[0]))

    def _second_mode(self) -> int:
        """Rayleigh's second mode, counted from 1; the first again where there is no other."""
        shapes = self.vibration().shapes
        are_lumped = not self.mass_coupling().size
        driven = np.array(self.masses + self.interior_masses)
        shares = effective_shares(driven, shapes[: driven.size], are_lumped=are_lumped)
        carried = int(np.searchsorted(np.cumsum(shares), RAYLEIGH_SHARE)) + 1
        return min(max(carried, 2), len(shapes))

    def _damping(self, inertia: Array, stiffness: Array) -> Array:
        """C [N s/m] of masses, or a mass matrix, and a stiffness, by the building's rule.

        Of an isolated one by that of what stands on the slab, and the dashpot.
        """
        if self.isolators is not None:
            return on_base(self.superstructure().matrices()[1], self.isolators.damping)
        if self.damping_matrix:
            return np.array(self.damping_matrix)
        frequencies, shapes = self.vibration()
        if self.damping_rule == "modal":
            weighted = inertia @ shapes if inertia.ndim > 1 else inertia[:, None] * shapes
            damping = (weighted * (2.0 * self.damping * frequencies)) @ weighted.T
            return 0.5 * (damping + damping.T)  # without the last bits by which the product is not symmetric
        first = frequencies[0]
        if self.damping_rule == "stiffness":
            return 2.0 * self.damping / first * stiffness
        second = frequencies[self._second_mode() - 1]
        scale = 2.0 * self.damping / (first + second)
        return scale * first * second * (inertia if inertia.ndim > 1 else np.diag(inertia)) + scale * stiffness


_LISTS = (
    ("masses", "floor_masses", units.FLOOR_MASS),
    ("stiffnesses", "storey_stiffnesses", units.STIFFNESS),
    ("heights", "storey_heights", units.STOREY_HEIGHT),
    ("strengths", "storey_strengths", units.STOREY_STRENGTH),
    ("initial_displacement", "initial_displacement", units.INITIAL_DISPLACEMENT),
    ("initial_velocity", "initial_velocity", units.INITIAL_VELOCITY),
)
NEEDS_WEIGHT = (
    "is not computed with masses of rows that are no floors; lump them at the floors: write floor_masses in place of "
    "mass_matrix"
)
_NEEDED = ("floor_masses", "storey_stiffnesses", "storey_heights")


def on_base(above: Array, below: float) -> Array:
    """C or K of a building on one more mass below it, which a dashpot [N s/m] or spring [N/m] joins to the ground.

    What the building has itself, ``above``, then acts between its floors and that mass.
    """
    relative = np.hstack([np.full((len(above), 1), -1.0), np.eye(len(above))])
    whole = relative.T @ above @ relative
    whole[0, 0] += below
    return np.asarray(0.5 * (whole + whole.T))


def with_base(above: Array, mass: float) -> Array:
    """M of a building on one more mass [kg] below it."""
    whole = np.zeros((len(above) + 1,) * 2)
    whole[0, 0], whole[1:, 1:] = mass, above
    return whole


def has_lumped_weight(inertia: Array, driven: Array) -> bool:
    """True where what the ground's acceleration acts on is the row sums of M: all mass moves along the row at floors.

    Then M u̇ of floors counts from any base that they stand on; ``inertia`` is empty where masses are lumped.
    """
    return not inertia.size or bool(np.abs(inertia.sum(axis=1) - driven).max() <= 1e-9 * np.abs(driven).max())


def effective_shares(masses: Array, shapes: Array, *, are_lumped: bool = True) -> Array:
    """Each mode's share of the mass that the ground moves: (φᵀ p)² / Σ p, where φᵀ M φ = 1.

    ``masses`` are p, ``shapes`` all modes. Of masses that are not lumped the sum is that over all modes, pᵀ M⁻¹ p.
    """
    carried = (masses @ shapes) ** 2
    return np.asarray(carried / (masses.sum() if are_lumped else carried.sum()))


def stiffnesses_for(masses: Sequence[float], shape: Sequence[float], period: float) -> tuple[float, ...]:
    """Storey stiffnesses [N/m] of the shear building whose first mode has this period [s] and this very shape.

    k_i = ω² Σ_{j≥i} m_j φ_j / (φ_i − φ_{i−1}): each storey carries the inertia above it. The shape grows from storey to
    storey, so that all of them are positive and no mode is slower.
    """
    rate = (2.0 * pi / period) ** 2
    drifts = np.diff(np.asarray(shape, float), prepend=0.0)
    return tuple((rate * _carried(masses, shape) / drifts).tolist())


def yield_shears(masses: Sequence[float], shape: Sequence[float], acceleration: float) -> tuple[float, ...]:
    """Yield shears [N] of the storeys that all yield at once in the first mode, at this spectral acceleration [m/s²].

    V_i = Γ A_y Σ_{j≥i} m_j φ_j, Γ = Σ m φ / Σ m φ²: the base shear is A_y times the mass that the first mode moves.
    """
    weight, form = np.asarray(masses, float), np.asarray(shape, float)
    factor = acceleration * (weight @ form) / (weight @ form**2)
    return tuple((factor * _carried(masses, shape)).tolist())


def generated(
    name: str,
    *,
    height: float,
    storeys: int,
    typology: str,
    floor_mass: float,
    period: float | None = None,
    damping: float = 0.05,
    damping_rule: str = "modal",
) -> Storeys:
    """A building of which no more is known than height [m], storeys, kind and mass of a floor [kg].

    Storeys of equal height and floors of equal mass. The first mode has the ``period`` [s], the code's approximate one
    of the typology if not given, and the typology's shape (z / h)^p; the strengths are those of its yield acceleration.
    Raises PoundingError for numbers that no building has, a typology that is not known, and a height that its code is
    not for.
    """
    kind = known_typology(typology)
    if isinstance(storeys, bool) or not isinstance(storeys, int) or not 1 <= storeys <= MOST_STOREYS:
        raise PoundingError(
            f"{name}: {shown(storeys)} is not a number of storeys, a whole one from 1 to {MOST_STOREYS}; "
            "write such as storeys = 5"
        )
    for value, quantity in ((height, units.STOREY_HEIGHT), (floor_mass, units.FLOOR_MASS), (period, units.PERIOD)):
        if value is not None and not quantity.allows(value):
            raise PoundingError(
                f"{name}: {value:g} {quantity.unit} is out of range; a {quantity.words} must be {bounds(quantity)}"
            )
    masses = (float(floor_mass),) * storeys
    shape = (np.arange(1, storeys + 1) / storeys) ** kind.power
    taken = kind.period(height) if period is None else period
    return Storeys(
        name,
        masses,
        stiffnesses_for(masses, shape.tolist(), taken),
        (height / storeys,) * storeys,
        damping,
        damping_rule,
        yield_shears(masses, shape.tolist(), STANDARD_GRAVITY * kind.yield_acceleration(storeys)),
    )


def _carried(masses: Sequence[float], shape: Sequence[float]) -> Array:
    """Σ_{j≥i} m_j φ_j, what each storey carries."""
    return np.cumsum((np.asarray(masses, float) * np.asarray(shape, float))[::-1])[::-1]
