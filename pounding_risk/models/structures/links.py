"""Springs and dashpots between two neighbours of a row, and the bodies that linked buildings are.

A link pulls and pushes with the stretch of the straight line between its ends, e = u_right − u_left:

    F = k e + c ė, positive where it pulls the buildings together.

The buildings that it joins are one body: matrices of both with the link's, whose motion without contact is known in
closed form as that of a building is. A link that slips at its strength, pulls past a slack alone, or breaks, has a law
(`models.structures.hysteresis`) in place of k e, and a damper of a power law one in place of c ė; the body then moves
in closed form from one change of it to the next. A damper on a brace has the force k_b y of it, y the deformation of
the brace and ė − ẏ the speed of the damper: the element of Maxwell, and with the spring beside it that of Zener.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, inf
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.hysteresis._numbers import ALONG_RATE, BRACE, SIZE
from pounding_risk.models.structures.hysteresis.power_law import LEAST
from pounding_risk.models.structures.hysteresis.restrainer import REACH
from pounding_risk.models.structures.mdof import Chain, stacked

Array = NDArray[np.float64]
LINK = "link"  # the kind of a point of a row that is the place of a link
LEAST_SIZE = 1e-3  # m, of a hook without slack, against which rounding is measured
# m, stretch at which a link slips: there the slid distance is 7e-4 off, and below a tenth of it 1 % and more is lost.
LEAST_SLIP = 1e-8


class Link(NamedTuple):
    """A spring and a dashpot side by side, between two neighbours; floor 2.4 is 0.4 of the way up the third storey."""

    interface: int  # between building `interface` and the next one, from 0
    left_floor: float
    right_floor: float
    stiffness: float  # k [N/m]
    damping: float  # c [N s/m]
    strength: float = inf  # at which the spring slips [N]
    slack: float = -inf  # stretch past which the spring pulls, and never pushes [m]; −∞ for one that does both
    breaking: float = inf  # force at which the spring breaks [N]
    exponent: float = 0.0  # α of a damper of c |ė|^α, c then in N (s/m)^α; 0 for the linear dashpot
    brace: float = inf  # stiffness of a brace that the damper acts on, in series [N/m]; its exponent is then above 0

    @property
    def law(self) -> tuple[float, ...]:
        """Numbers of the law of its spring or its damper; none where it is linear."""
        if self.exponent and self.damping:
            law = Hysteresis("power_law", exponent=self.exponent, collapse_drift=inf)
            row = law.numbers(self.damping, self.damping, 1.0)
            row[ALONG_RATE] = 1.0
            row[BRACE] = self.brace if self.is_braced else 0.0
            return tuple(row.tolist())
        if self.stiffness == 0.0:
            return ()
        if self.strength < inf:
            slips = Hysteresis("kinematic", collapse_drift=inf)
            return tuple(slips.numbers(self.stiffness, self.strength, 1.0).tolist())
        if self.slack > -inf or self.breaking < inf:
            row = Hysteresis("restrainer", collapse_drift=inf).numbers(self.stiffness, self.stiffness * self.slack, 1.0)
            row[REACH] = self.breaking / self.stiffness
            row[SIZE] = max(self.slack, min(row[REACH], LEAST_SIZE))
            return tuple(row.tolist())
        return ()

    @property
    def is_braced(self) -> bool:
        """True where its damper acts on a brace that gives."""
        return self.brace < inf and self.damping > 0.0

    @property
    def dashpot(self) -> float:
        """What it adds to the damping of its body [N s/m]; its law has what a power changes of that."""
        return 0.0 if self.is_braced else self.damping

    def damper_force(self, speed: Array) -> Array:
        """Force of a damper of a power law [N] at a speed of its stretch [m/s], linear below `power_law.LEAST`."""
        size = np.abs(speed)
        power = self.damping * np.maximum(size, LEAST) ** self.exponent
        return np.sign(speed) * power * np.minimum(size / LEAST, 1.0) if self.exponent != 1.0 else self.damping * speed

    def peak_force(self, stretch: Array, shortening: Array) -> Array:
        """Largest force of its spring [N], from the largest stretch and shortening [m]."""
        pulled = np.maximum(stretch - self.slack, 0.0) if self.slack > -inf else np.fmax(stretch, shortening)
        return np.minimum(self.stiffness * pulled, self.largest)

    @property
    def largest(self) -> float:
        """Force that its spring never exceeds [N]."""
        return min(self.strength, self.breaking)


class Body(NamedTuple):
    """Buildings of a row that move as one linear system, left to right."""

    chain: Chain
    first: int  # building
    last: int  # building; below ``first`` for the rigid body that ends a row of linked buildings


def floor_shares(chain: Chain, level: float, across: float = inf) -> list[tuple[int, float]]:
    """Masses of a building and their shares in the displacement at a floor number; none at the ground.

    Of a floor that rotates the displacement at a place ``across`` the row [m] is that of its centre of mass less the
    rotation times the distance from it. Raises ValueError for a floor that the building has not.
    """
    floors, above = chain.floors, ceil(level)
    if chain.twists and above == level and 0 < above <= floors:
        return [(above - 1, 1.0), (floors + above - 1, chain.centres[above - 1] - across)]
    if chain.mass.size == 0:
        return []
    if not 0 <= above <= floors:
        raise ValueError(f"floor {level:g} is not one of a building of {floors} floors")
    share = 1.0 if above == floor(level) else level - floor(level)
    places = [(above - 1 + chain.foundations, share), (above - 2 + chain.foundations, 1.0 - share)]
    return [(mass, share) for mass, share in places if mass >= 0 and share > 0.0]


def bodies_of(chains: Sequence[Chain], links: Sequence[Link] = ()) -> tuple[Body, ...]:
    """The bodies of a row: its buildings, those that links join as one.

    Contact points between the buildings of one body stand in the interface on its right, so that a row whose last body
    holds several ends with a rigid body of no mass.
    """
    if not links:
        return tuple(Body(chain, place, place) for place, chain in enumerate(chains))
    linked = {link.interface for link in links if _moves(chains, link.interface) and _moves(chains, link.interface + 1)}
    bodies, first = [], 0
    for last in range(len(chains)):
        if last not in linked:
            bodies.append(Body(_joined(chains[first : last + 1], links, first), first, last))
            first = last + 1
    if bodies[-1].first < bodies[-1].last:
        nothing = np.zeros(0)
        bodies.append(Body(Chain(nothing, nothing, nothing, np.zeros((0, 0)), nothing), len(chains), len(chains) - 1))
    return tuple(bodies)


def _moves(chains: Sequence[Chain], building: int) -> bool:
    return chains[building].mass.size > 0


def stretch(link: Link, chains: Sequence[Chain]) -> Array:
    """Shares of every mass of the row in the stretch of a link, u_right − u_left."""
    firsts = np.concatenate([[0], np.cumsum([chain.mass.size for chain in chains])]).astype(int)
    shares = np.zeros(firsts[-1])
    for sign, building, level in ((-1.0, link.interface, link.left_floor), (1.0, link.interface + 1, link.right_floor)):
        for mass, share in floor_shares(chains[building], level):
            shares[firsts[building] + mass] += sign * share
    return shares


def _on_diagonal(blocks: Sequence[Array]) -> Array:
    """The matrix with these along its diagonal."""
    ends = np.cumsum([len(block) for block in blocks])
    matrix = np.zeros((ends[-1], ends[-1]))
    for block, end in zip(blocks, ends, strict=True):
        matrix[end - len(block) : end, end - len(block) : end] = block
    return matrix


def _joined(chains: Sequence[Chain], links: Sequence[Link], first: int) -> Chain:
    """The chain of buildings side by side with the links at any of them; the first is number ``first`` of the row."""
    here = [link._replace(interface=link.interface - first) for link in links]
    at_ends = [link for link in here if -1 <= link.interface < len(chains)]
    if not at_ends:
        return chains[0]
    # A link to a rigid neighbour is one to the ground: that neighbour, of no mass, stands beside.
    rigid = chains[0]._replace(mass=np.zeros(0), foundations=0)
    row = [rigid, *chains, rigid]
    damping = _on_diagonal([chain.damping for chain in chains])
    coupling = _on_diagonal(
        [chain.coupling if chain.coupling.size else np.zeros_like(chain.damping) for chain in chains]
    )
    for link in at_ends:
        shares = stretch(link._replace(interface=link.interface + 1), row)
        damping += link.dashpot * np.outer(shares, shares)
        coupling += link.stiffness * np.outer(shares, shares)
    none, inertia = np.zeros(0), np.zeros((0, 0))
    if any(chain.inertia.size for chain in chains):
        inertia = _on_diagonal([chain.mass_matrix() for chain in chains])
    starts = np.cumsum([0, *(chain.mass.size for chain in chains)])
    hardening = [np.broadcast_to(chain.hardening, chain.mass.size) for chain in chains]
    rests = [chain.initial if chain.initial.size else np.zeros((2, chain.mass.size)) for chain in chains]
    mass, spring, shear, strength = (
        np.concatenate([getattr(chain, field) for chain in chains]) for field in ("mass", "spring", "shear", "strength")
    )
    return Chain(
        mass,
        spring,
        shear,
        damping,
        strength,
        np.concatenate(hardening),
        initial=np.hstack(rests),
        coupling=coupling,
        laws=stacked([row for chain in chains for row in (chain.laws if chain.laws.size else [none] * chain.mass.size)])
        if any(chain.laws.size for chain in chains)
        else chains[0].laws,
        bottoms=tuple(
            int(start) + bottom
            for start, chain in zip(starts, chains, strict=False)
            for bottom in (chain.bottoms if chain.interior else (0,))
            if chain.mass.size
        ),
        inertia=inertia,
    )
