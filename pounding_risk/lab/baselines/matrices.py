"""A row as the plain methods take it: matrices building by building, and the places that the contact points join."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.structures.links import Link, floor_shares, stretch
from pounding_risk.models.structures.mdof import Chain

Array = NDArray[np.float64]


class RowMatrices(NamedTuple):
    """Elastic buildings in a row: D masses of all of them in turn, K contact points.

    M ü + C u̇ + K u = −M 1 a_g − Bᵀ F, penetrations B u − gap.
    """

    first: NDArray[np.int64]  # of each building's masses, and D
    mass: Array  # (D,) kg
    stiffness: Array  # (D, D) N/m
    damping: Array  # (D, D) N s/m
    shares: Array  # (K, D) B: share of each mass in the displacement that closes a contact point

    @property
    def striking(self) -> Array:
        """The mass with which each contact point strikes, 1 / (B M⁻¹ Bᵀ) [kg]."""
        return np.asarray(1.0 / (self.shares**2 @ (1.0 / self.mass)))


def row_matrices(
    chains: Sequence[Chain], points: Sequence[Any], links: Sequence[Link] = (), *, before_yield: bool = False
) -> RowMatrices:
    """The matrices of buildings, left to right, and of links between them.

    Raises ValueError for mass matrices, and for storeys that yield unless the stiffness ``before_yield`` is asked for.
    A point has ``interface``, ``left_floor`` and ``right_floor``: floor 2.4 is 0.4 of the way up the third storey; of
    floors that rotate also its place ``across`` the row.
    """
    if not before_yield and any(np.isfinite(chain.strength).any() for chain in chains):
        raise ValueError("storeys that yield have no stiffness matrix")
    if any(chain.inertia.size for chain in chains):
        raise ValueError("the plain methods take masses that are lumped at floors")
    first = np.concatenate([[0], np.cumsum([chain.mass.size for chain in chains])]).astype(np.int64)
    count = int(first[-1])
    stiffness, damping, shares = np.zeros((count, count)), np.zeros((count, count)), np.zeros((len(points), count))
    for start, stop, chain in zip(first, first[1:], chains, strict=False):
        stiffness[start:stop, start:stop] = chain.stiffness()
        damping[start:stop, start:stop] = chain.damping
    for link in links:
        ends = stretch(link, chains)
        stiffness += link.stiffness * np.outer(ends, ends)
        damping += link.damping * np.outer(ends, ends)
    for share, point in zip(shares, points, strict=True):
        sides = (1.0, point.interface, point.left_floor), (-1.0, point.interface + 1, point.right_floor)
        for sign, building, floor in sides:
            for mass, portion in floor_shares(chains[building], float(floor), getattr(point, "across", inf)):
                share[first[building] + mass] += sign * portion
    return RowMatrices(first, np.concatenate([chain.mass for chain in chains]), stiffness, damping, shares)
