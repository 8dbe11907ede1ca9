"""Buildings as rows of them are solved: chains of masses on storey springs, with the effects that act on buildings.

A single mass is a chain of one, a rigid building a chain of none. With V_i the shear of the storey below mass i:

    m_i ü_i = −(C u̇)_i − V_i + V_{i+1} − m_i a_g(t) ± (contact forces),     V_i = spring_i (u_i − u_{i−1}) while elastic

A building that is given by its stiffness matrix has that matrix in place of storey springs: −(K u)_i. One with a mass
matrix has (M ü)_i in place of m_i ü_i, its masses those on which a_g acts.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.law import snake_case
from pounding_risk.models.effects import building_effects
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import (
    NEEDS_WEIGHT,
    Storeys,
    has_lumped_weight,
    on_base,
    stiffness_matrix,
    with_base,
)
from pounding_risk.units import INITIAL_DISPLACEMENT, STIFFNESS, say

Array = NDArray[np.float64]


class Chain(NamedTuple):
    """A building's masses from the bottom up and what joins them; u is measured relative to the ground.

    ``spring`` is each storey's stiffness less the geometric one of P-Δ, ``shear`` the stiffness that makes its shear
    out of its drift d. A storey that yields has V = (spring − shear) d + the force of a bilinear spring with kinematic
    hardening, of stiffness ``shear`` up to ``strength`` and ``hardening`` times that past it.
    """

    mass: Array  # kg
    spring: Array  # N/m
    shear: Array  # N/m
    damping: Array  # N s/m, symmetric, positive semidefinite
    strength: Array  # N; infinite where a storey stays elastic
    hardening: Array | float = 1.0  # stiffness past yield over that before, of all storeys or of each
    foundations: int = 0  # 1 where the first mass is the foundation on its soil
    initial: Array = np.zeros((2, 0))  # u [m] and u̇ [m/s] of each mass when the motion begins; empty at rest
    coupling: Array = np.zeros((0, 0))  # N/m, symmetric, between masses beside the storey springs; empty without
    centres: Array = np.zeros(0)  # m across the row, of mass, of floors that rotate; their moments of inertia follow
    bottoms: tuple[int, ...] = (0,)  # masses whose storey stands on the ground: several of linked buildings
    laws: Array = np.zeros((0, 0))  # `Hysteresis.numbers` of each storey, zero where it has none; empty without
    inertia: Array = np.zeros((0, 0))  # kg, M, symmetric, positive definite; empty where it is diagonal: `mass`
    moves_across: bool = False  # where floors rotate: behind the moments of inertia stand the masses across the row
    interior: int = 0  # masses behind those of the floors that are interior modes, what a_g acts on in each

    @property
    def twists(self) -> bool:
        """True where floors rotate in plan, about a vertical axis."""
        return self.centres.size > 0

    @property
    def floors(self) -> int:
        """Number of floors above the foundation."""
        motions = 3 if self.moves_across else 2 if self.twists else 1
        return (self.mass.size - self.foundations - self.interior) // motions

    def felt(self) -> Array:
        """1 of each mass that the ground's acceleration along the row acts on, 0 of rotations."""
        return (np.arange(self.mass.size) < self.floors).astype(float) if self.twists else np.ones(self.mass.size)

    def felt_across(self) -> Array:
        """1 of each mass that the ground's acceleration across the row acts on, 0 of others."""
        return (self.moves_across & (np.arange(self.mass.size) >= 2 * self.floors)).astype(float)

    def mass_matrix(self) -> Array:
        """M [kg] of its masses."""
        return self.inertia if self.inertia.size else np.diag(self.mass)

    def stiffness(self) -> Array:
        """K [N/m] of the chain while it is elastic."""
        drifts, springs = self.drifts(), stiffness_matrix(self.spring)
        if len(self.bottoms) > 1:
            springs = drifts.T @ np.diag(self.spring) @ drifts
        return springs + self.coupling if self.coupling.size else springs

    def drifts(self) -> Array:
        """The drift of each storey from the displacements of the masses."""
        below = np.eye(self.mass.size, k=-1)
        below[[bottom for bottom in self.bottoms if bottom < self.mass.size]] = 0.0
        return np.eye(self.mass.size) - below

    def drift_limits(self) -> Array:
        """Drift at which each storey yields [m]; infinite where it never does, and where no storey has a spring."""
        return np.divide(self.strength, self.shear, out=np.full(self.mass.size, np.inf), where=self.shear > 0.0)

    def yielding(self, strengths: Sequence[float], hardening: float) -> Chain:
        """The chain whose storeys yield at these shears [N]; those that yield already stay as they are."""
        yields = np.isfinite(self.strength)
        strengths = [*strengths, *[np.inf] * self.interior]
        return self._replace(
            strength=np.where(yields, self.strength, strengths),
            hardening=np.where(yields, self.hardening, hardening) if yields.any() else hardening,
        )

    def by_laws(self, hysteresis: Hysteresis, heights: Sequence[float]) -> Chain:
        """The yielding chain whose storeys, but for isolators, follow laws of their own; ``heights`` [m] of each."""
        isolators, floors = self.floors - len(heights), self.floors
        storeys = zip(self.shear[isolators:floors], self.strength[isolators:floors], heights, strict=True)
        rows = [
            hysteresis.numbers(stiffness, strength, height) if isfinite(strength) else np.zeros(0)
            for stiffness, strength, height in storeys
        ]
        none = np.zeros(0)
        return self._replace(laws=stacked([none] * isolators + rows + [none] * self.interior))

    def softened(self, geometric: Sequence[float]) -> Chain:
        """The chain less these geometric stiffnesses [N/m], one a storey."""
        return self._replace(spring=self.spring - np.pad(np.array(geometric, float), (0, self.interior)))

    def founded(self, mass: float, spring: float, dashpot: float) -> Chain:
        """The chain on a foundation [kg] that sways on a spring [N/m] and a dashpot [N s/m] to the ground.

        The building's own damping acts between its floors and the foundation, not between its floors and the ground.
        """
        if self.interior or not has_lumped_weight(self.inertia, self.mass):
            raise PoundingError(f"soil_flexibility {NEEDS_WEIGHT}")
        return self._replace(
            mass=np.append(mass, self.mass),
            spring=np.append(spring, self.spring),
            shear=np.append(spring, self.shear),
            damping=on_base(self.damping, dashpot),
            strength=np.append(np.inf, self.strength),
            hardening=self.hardening if isinstance(self.hardening, float) else np.append(1.0, self.hardening),
            foundations=1,
            initial=np.insert(self.initial, 0, 0.0, axis=1) if self.initial.size else self.initial,
            coupling=on_base(self.coupling, 0.0) if self.coupling.size else self.coupling,
            laws=stacked([np.zeros(0), *self.laws]) if self.laws.size else self.laws,
            inertia=with_base(self.inertia, mass) if self.inertia.size else self.inertia,
        )


def stacked(rows: Sequence[Array]) -> Array:
    """Rows of numbers as one array, zeros behind the shorter ones."""
    table = np.zeros((len(rows), max(row.size for row in rows)))
    for place, row in enumerate(rows):
        table[place, : row.size] = row
    return table


def chain_of(building: Building | Storeys, effects: Iterable[tuple[str, Iterable[tuple[str, Any]]]] = ()) -> Chain:
    """The chain of masses and springs that a building is under effects.

    A rigid building moves with the ground, whatever the effects. A building's own damping is that without any effect.

    Parameters
    ----------
    building : Building or Storeys
        A single mass, a rigid building, or a building of storeys.
    effects : iterable of (str, mapping or pairs), optional
        Names and options [SI]; those that act on no building are passed over.

    Returns
    -------
    Chain
        Masses, springs, damping and strengths from the bottom up.

    Raises
    ------
    PoundingError
        Where an effect needs a property that the building lacks, or leaves a storey without stiffness, and where one
        would have yielded before the motion begins.
    """
    chain = _bare(building)
    if building.is_rigid:
        return chain
    for effect in building_effects(effects):
        if chain.twists:
            name = snake_case(type(effect).__name__)
            raise PoundingError(
                f"{name}: floors of {building.name} rotate, and the effect is not computed for them; remove it, or plan"
            )
        chain = effect.built(chain, building)
    _check_elastic(chain, building.name)
    gone = np.flatnonzero(chain.spring <= 0.0)
    if chain.coupling.size:
        if np.linalg.eigvalsh(chain.stiffness())[0] <= 0.0:
            raise PoundingError(
                f"p_delta: {building.name} has no stiffness left in one of its modes, its storeys less weight over "
                "height; check masses, stiffness_matrix and heights, or remove p_delta"
            )
    elif gone.size:
        storey = int(gone[0])
        raise PoundingError(
            f"p_delta: storey {storey + 1 - chain.foundations} of {building.name} has no stiffness left: the weight "
            f"above it takes {say((chain.shear - chain.spring)[storey], STIFFNESS)} of its "
            f"{say(chain.shear[storey], STIFFNESS)}; "
            "check masses, stiffnesses and heights, or remove p_delta"
        )
    return chain


def _check_elastic(chain: Chain, name: str) -> None:
    """Raises PoundingError where a storey would have yielded before the motion begins."""
    if not chain.initial.size:
        return
    drift, limit = np.abs(np.diff(chain.initial[0], prepend=0.0)), chain.drift_limits()
    past = np.flatnonzero(drift > limit)
    if past.size:
        storey = int(past[0])
        raise PoundingError(
            f"initial_displacement: storey {storey + 1 - chain.foundations} of {name} has a drift of "
            f"{say(drift[storey], INITIAL_DISPLACEMENT)} and yields at {say(limit[storey], INITIAL_DISPLACEMENT)}, "
            "and a run begins with storeys that have not yielded; lower it, or write initial_velocity in its place"
        )


def _bare(building: Building | Storeys) -> Chain:
    """The chain of a building without any effect."""
    if isinstance(building, Storeys):
        mass, damping, stiffness = building.matrices()
        law, coupling, inertia = building.isolator_law, building.coupling(), building.mass_coupling()
        is_split = bool(building.stiffness_matrix and building.stiffnesses)  # into storeys that yield and the rest
        # One mass has one spring, as in any building, but for these.
        has_coupling = coupling.size and (len(mass) > 1 or inertia.size or is_split)
        has_springs = not has_coupling or is_split
        interior, floors = len(building.interior_masses), len(building.masses)
        springs = np.array(building.stiffnesses or stiffness[0]) if has_springs else np.zeros(len(mass) - interior)
        springs = np.pad(springs, (0, interior))
        if has_coupling and law is not None:
            springs[0] = law.stiff
        bare = Chain(
            np.array(building.masses + building.interior_masses) if inertia.size else np.diag(mass).copy(),
            springs,
            springs,
            damping,
            np.full(springs.size, np.inf),
            coupling=coupling if has_coupling else np.zeros((0, 0)),
            bottoms=(0, *range(floors, floors + interior)),
            inertia=inertia,
            interior=interior,
        )
        if building.plans:
            return _rotating(bare, building)
        if law is not None:
            elastic = np.ones(springs.size - 1)
            bare = bare._replace(
                strength=np.append(law.limit, np.inf * elastic), hardening=np.append(law.hardening, elastic)
            )
        return _begun(bare, building.initial_displacement, building.initial_velocity)
    count = 0 if building.is_rigid else 1
    springs = np.full(count, building.stiffness)
    dashpot = building.oscillator().two_zeta_omega * building.mass if count else 0.0
    bare = Chain(
        np.full(count, float(building.mass)), springs, springs, np.full((count, count), dashpot), springs + np.inf
    )
    return _begun(bare, (building.initial_displacement,) * count, (building.initial_velocity,) * count)


def _rotating(bare: Chain, building: Storeys) -> Chain:
    """The chain whose masses are displacements, rotations and, where floors move so, displacements across the row."""
    count = len(building.masses)
    still = (0.0,) * (bare.mass.size - count)  # an initial state is one along the row
    initial = [
        (*state, *still) if state else () for state in (building.initial_displacement, building.initial_velocity)
    ]
    chain = bare._replace(
        centres=np.array([plan.centre for plan in building.plans]),
        bottoms=tuple(range(0, bare.mass.size, count)),
        moves_across=building.plans[0].moves_across,
    )
    return _begun(chain, *initial)


def _begun(chain: Chain, displacement: Sequence[float], velocity: Sequence[float]) -> Chain:
    """The chain with these displacements [m] and velocities [m/s] of its masses to begin with; none is zero."""
    if not any(displacement) and not any(velocity):
        return chain
    still, interior = (0.0,) * (chain.mass.size - chain.interior), (0.0,) * chain.interior
    return chain._replace(initial=np.array([(*(state or still), *interior) for state in (displacement, velocity)]))
