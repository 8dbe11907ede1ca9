"""Floors that rotate: the plan of a building whose centre of stiffness is not its centre of mass.

Each floor has a displacement u along the row and a rotation θ about its centre of mass; a place y across the row, from
that centre, moves by u − y θ. With the stiffness matrix K of the storeys in translation, their centre of stiffness at
e, Ω the frequency of rotation about it over that of translation, and ρ the radius of gyration (Chopra, Dynamics of
Structures, section 9.6):

    [m      0   ] [ü]   [K       −e K         ] [u]     [m]
    [0    ρ² m  ] [θ̈] + [−e K  (e² + Ω² ρ²) K ] [θ] = −[0] a_g

so that each mode of the storeys becomes two, with ω² times the eigenvalues of [[1, −e/ρ], [−e/ρ, (e/ρ)² + Ω²]].

Where the centre of stiffness is off along the row too, at x = d, floors also move across the row, by w, with Λ the
frequency across over that along, under a second component of the ground motion b_g (section 9.6, a building of one
storey with two-way asymmetry). The matrix of u, ρ θ and w is then that of the spring energy
½ K [(u − e θ)² + Ω² ρ² θ² + Λ² (w + d θ)²]:

    [[1, −e/ρ, 0], [−e/ρ, (e/ρ)² + Ω² + Λ² (d/ρ)², Λ² d/ρ], [0, Λ² d/ρ, Λ²]] K,     load −m (a_g, 0, b_g)
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


class Plan(NamedTuple):
    """The plan of every floor of a building; lengths across the row [m]."""

    face: tuple[float, float]  # both ends of the faces towards the neighbours
    centre: float  # of mass
    eccentricity: float  # of the centre of stiffness from that of mass, e
    gyration: float  # radius of gyration about the centre of mass, ρ
    torsional_ratio: float  # Ω
    eccentricity_along: float | None = None  # the same along the row, d; None where floors do not move across it
    across_ratio: float = 1.0  # Λ

    @property
    def moves_across(self) -> bool:
        """True where floors move across the row too, under the second component of the ground motion."""
        return self.eccentricity_along is not None

    @property
    def motions(self) -> int:
        """How many displacements a floor has: along the row, rotation and, where it moves so, across."""
        return 3 if self.moves_across else 2

    def couplings(self) -> Array:
        """The matrix of all motions of a storey over its stiffness, in the coordinates u, ρ θ and w."""
        off = self.eccentricity / self.gyration
        both = np.array([[1.0, -off], [-off, off * off + self.torsional_ratio**2]])
        if self.eccentricity_along is None:
            return both
        across = np.array([0.0, self.eccentricity_along / self.gyration, 1.0]) * self.across_ratio
        return np.pad(both, (0, 1)) + np.outer(across, across)

    def scaled(self, couplings: Array, matrix: Array) -> Array:
        """The matrix of u, θ and w of all floors, from that of their translation and the couplings."""
        sizes = np.array([1.0, self.gyration, 1.0])[: self.motions]
        return np.asarray(np.kron(couplings * np.outer(sizes, sizes), matrix))

    def stiffness(self, matrix: Array) -> Array:
        """K of u, θ and w of all floors, from that of their translation [N/m]."""
        return self.scaled(self.couplings(), matrix)

    def damping(self, matrix: Array) -> Array:
        """C of u, θ and w of all floors with the same ratio in every mode, from the C of their translation [N s/m]."""
        squares, vectors = np.linalg.eigh(self.couplings())
        return self.scaled((vectors * np.sqrt(squares)) @ vectors.T, matrix)

    @property
    def slowest(self) -> float:
        """The lowest frequency over that of translation alone."""
        return float(np.sqrt(np.linalg.eigvalsh(self.couplings())[0]))
