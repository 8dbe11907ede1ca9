"""Floors that rotate: the plan of a building whose centre of stiffness is not its centre of mass.

Each floor has a displacement u along the row and a rotation θ about its centre of mass; a place y across the row, from
that centre, moves by u − y θ. With the stiffness matrix K of the storeys in translation, their centre of stiffness at
e, Ω the frequency of rotation about it over that of translation, and ρ the radius of gyration (Chopra, Dynamics of
Structures, section 9.6):

    [m      0   ] [ü]   [K       −e K         ] [u]     [m]
    [0    ρ² m  ] [θ̈] + [−e K  (e² + Ω² ρ²) K ] [θ] = −[0] a_g

so that each mode of the storeys becomes two, with ω² times the eigenvalues of [[1, −e/ρ], [−e/ρ, (e/ρ)² + Ω²]].
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

    def couplings(self) -> Array:
        """The matrix of both motions of a storey over its stiffness, in the coordinates u and ρ θ."""
        off = self.eccentricity / self.gyration
        return np.array([[1.0, -off], [-off, off * off + self.torsional_ratio**2]])

    def scaled(self, couplings: Array, matrix: Array) -> Array:
        """The matrix of u and θ of all floors, from that of their translation and the couplings in u and ρ θ."""
        sizes = np.array([1.0, self.gyration])
        return np.asarray(np.kron(couplings * np.outer(sizes, sizes), matrix))

    def stiffness(self, matrix: Array) -> Array:
        """K of u and θ of all floors, from that of their translation [N/m]."""
        return self.scaled(self.couplings(), matrix)

    def damping(self, matrix: Array) -> Array:
        """C of u and θ of all floors with the same ratio in every mode, from the C of their translation [N s/m]."""
        squares, vectors = np.linalg.eigh(self.couplings())
        return self.scaled((vectors * np.sqrt(squares)) @ vectors.T, matrix)

    @property
    def slowest(self) -> float:
        """The lowest frequency over that of translation alone."""
        return float(np.sqrt(np.linalg.eigvalsh(self.couplings())[0]))
