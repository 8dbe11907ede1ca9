"""Checks that a scan fits memory and disk, and of all scenes along its axes, before anything is allocated.

A response without contact has a state at every node, that of a row at every sixteenth. There are nodes at the samples,
and between them where the phase of the fastest mode would advance by more than `TURN` (`pair.at_rest`, `row.lay_out`).
Its size follows from the record, the shortest period and the number of floors. On unlike grounds there is a node at
the samples of every building, and the ground under each has a table of its own.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable
from itertools import pairwise
from math import ceil, sqrt
from pathlib import Path

import numpy as np

from pounding_risk._common.counted import size_words
from pounding_risk.ensemble.laws import check_reach
from pounding_risk.errors import SceneError
from pounding_risk.models.ground import arrivals_of
from pounding_risk.models.structures.hysteresis.power_law import damping_at_rest
from pounding_risk.models.structures.links import Link, stretch
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.storeys import vibration
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.motions import check_arrivals
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.variants import Variants

TURN = 2.5  # rad, largest phase between nodes
QUICKEST = 1e5  # 1/s, of a damper: a hundred times that of one whose force is a building's weight
BYTES_OF_GROUND = 6 * 8.0  # of a node and building on unlike grounds (`models.ground.arriving`)
BYTES_A_NODE = 120.0  # of a response while it is made: ground, time, four states, and NumPy's copies of the first two
BYTES_A_DOF = 7.0  # and node, of a row: states, bounds and peaks by blocks of nodes
BYTES_OF_STATE = 16.0  # of a dof and node, of a run that keeps its states: displacement and velocity
MOST_BYTES = 1e14  # of a dataset: more than any disk that a scan is written to


def fastest_rate(study: Scene) -> float:
    """Upper bound of the circular frequencies of the buildings, and of the decay by links [rad/s].

    Exact for single masses without links.

    For a chain it is sqrt(max_i 2 (k_i + k_{i+1}) / m_i), Gershgorin's bound of M⁻¹ K.
    """
    rates = [0.0]
    for building in study.buildings:
        if building.is_rigid:
            continue
        chain = chain_of(building, study.effects)
        if chain.mass.size == 1 and not chain.inertia.size:
            rates.append(sqrt(chain.spring[0] / chain.mass[0]))
            continue
        if chain.coupling.size:
            inertia = chain.inertia if chain.inertia.size else chain.mass
            rates.append(float(vibration(inertia, chain.spring, chain.stiffness()).frequencies[-1]))
            continue
        springs = pairwise([*chain.spring.tolist(), 0.0])
        rates += [sqrt(2.0 * (below + above) / mass) for mass, (below, above) in zip(chain.mass, springs, strict=True)]
    # A link raises the largest eigenvalue of M⁻¹ K by k sᵀ M⁻¹ s at most, s the shares of its ends, and a rate of decay
    # by c sᵀ M⁻¹ s.
    pliancies = [_pliancy(study, link) for link in study.links]
    # The effect of a brace is at most that beside a rigid damper.
    stiffnesses = [link.stiffness + (link.brace if link.is_braced else 0.0) for link in study.links]
    link_term = sum(k * pliancy for k, pliancy in zip(stiffnesses, pliancies, strict=True))
    decay = sum(link.dashpot * pliancy for link, pliancy in zip(study.links, pliancies, strict=True))
    return sqrt(max(rates) ** 2 + link_term) + decay


def _pliancy(study: Scene, link: Link) -> float:
    """sᵀ M⁻¹ s of a link [1/kg]."""
    chains = [chain_of(building, study.effects) for building in study.buildings]
    firsts = np.cumsum([chain.mass.size for chain in chains])[:-1]
    stretches = zip(chains, np.split(stretch(link, chains), firsts), strict=True)
    return sum(float(side @ np.linalg.solve(chain.mass_matrix(), side)) for chain, side in stretches if side.any())


def check_dampers(study: Scene) -> None:
    """Raise SceneError for a damper of a power law by which a run would be followed in steps without end."""
    for link in study.links:
        if not link.exponent:
            continue
        left, right = (study.buildings[link.interface + side].name for side in range(2))
        # The damping of a power law is largest, or least, at rest.
        dampings = damping_at_rest(link.damping, link.exponent), link.exponent * link.damping
        if link.is_braced and (brace_rate := link.brace / min(dampings)) > QUICKEST:
            raise _refusal(
                study,
                f"the brace of the damper between {left} and {right} is as good as rigid: its force would follow the "
                f"damper's at {brace_rate:.2g} 1/s, and a run follows {QUICKEST:.2g} 1/s at most; remove "
                "link_brace_stiffness, or write a softer brace",
            )
        if link.is_braced or link.exponent == 1.0:
            continue
        if (rate := max(dampings) * _pliancy(study, link)) > QUICKEST:
            raise _refusal(
                study,
                f"the damper between {left} and {right} holds them like a tie: their motion against each other would "
                f"decay at {rate:.2g} 1/s, and a run follows {QUICKEST:.2g} 1/s at most; write a smaller link_damping "
                "or a larger link_exponent, or link_stiffness in its place",
            )


def _refusal(study: Scene, sentence: str) -> SceneError:
    return SceneError(study.source, [sentence])


def response_bytes(study: Scene, motion: Motion) -> float:
    """Memory of one response without contact to a motion, with all its floors [bytes]."""
    return bytes_a_step(study, motion) * motion.acceleration.size


def bytes_a_step(study: Scene, motion: Motion, bytes_a_dof: float = BYTES_A_DOF) -> float:
    """The part of `response_bytes` for each sample of the motion [bytes]; ``bytes_a_dof`` of it for each floor."""
    intervals = max(1, ceil(fastest_rate(study) * motion.dt / TURN))
    supports, count = study.supports, len(study.buildings)
    dofs = sum(chain_of(building, study.effects).mass.size for building in study.buildings)
    if not supports:
        return (BYTES_A_NODE + bytes_a_dof * dofs) * intervals
    arrivals = arrivals_of(np.array([support.delay for support in supports]), motion.dt / intervals)
    nodes = max(2, arrivals.offsets.size)  # in a step: a pair has two in any case
    return (BYTES_A_NODE + bytes_a_dof * (dofs + count) + BYTES_OF_GROUND * count) * nodes * intervals


def check_memory(study: Scene, motions: Iterable[Motion], *, histories: bool = False) -> None:
    """Raise SceneError where one response, with its ``histories`` if they are kept, would not fit the free memory.

    It raises as `check_dampers` too.
    """
    check_dampers(study)
    free = free_memory()
    bytes_a_dof = BYTES_A_DOF + (BYTES_OF_STATE if histories else 0.0)
    by_dt: dict[float, float] = {}
    for motion in motions:
        if motion.dt not in by_dt:
            by_dt[motion.dt] = bytes_a_step(study, motion, bytes_a_dof)
        size = by_dt[motion.dt] * motion.acceleration.size
        if free and size > free:
            turn = fastest_rate(study) * motion.dt
            links_text = ", and stiffness and damping of links" if study.links else ""
            raise _refusal(
                study,
                f"the fastest mode turns by {turn:.3g} rad within a sample of {motion.name}, so that each is divided "
                f"into {max(1, ceil(turn / TURN))}: one response takes {size_words(size)}, and {size_words(free)} of "
                f"memory are free; check mass, period and stiffness of the buildings{links_text}",
            )


def check_scenes(variants: Variants, motions: tuple[Motion, ...], *, every: bool = True) -> None:
    """Raise SceneError for a place along the axes whose scene has faults, or cannot be run under these motions.

    Without ``every`` only the places along each axis alone are checked, for a plan that is wanted soon.
    """
    scenes = map(variants.scene, range(variants.count)) if every else variants.alone()
    checked = set()  # what a response without contact depends on
    for scene in scenes:
        for place in range(len(scene.interfaces)):
            check_reach(scene.at(place), scene.grid.contact_models)
        if (scene.buildings, scene.effects, scene.links) not in checked:
            check_memory(scene, motions)
            check_arrivals(scene, motions)
            checked.add((scene.buildings, scene.effects, scene.links))


def check_dataset(study: Scene, cases: int, size: int) -> None:
    """Raise SceneError for a grid whose dataset fits no disk."""
    if size > MOST_BYTES:
        raise _refusal(
            study,
            f"the grid has {cases:.3g} cases, and their dataset {size_words(size)} before compression; no disk "
            "holds that: write fewer values in [grid]",
        )


def check_disk(study: Scene, size: int, folder: Path) -> None:
    """Raise SceneError where the dataset, before compression, is larger than the free disk space.

    Chunks are kept uncompressed until the dataset is written.
    """
    free = shutil.disk_usage(folder).free
    if size > free:
        raise _refusal(
            study,
            f"the cases take {size_words(size)} before compression, and {size_words(free)} are free in "
            f"{folder.resolve()}; write fewer values in [grid], or name another place with -o",
        )


def check_held(study: Scene, size: int) -> None:
    """Raise SceneError where a dataset that is to stay in memory is larger than the free memory."""
    free = free_memory()
    if free and size > free:
        raise _refusal(
            study,
            f"the cases take {size_words(size)}, and {size_words(free)} of memory are free; scan into a file, or "
            "write fewer values in [grid]",
        )


def free_memory() -> float:
    """Memory that this process can still allocate [bytes]; 0 where the system does not tell."""
    return min((size for size in (_available_memory(), _memory_to_limit()) if size > 0.0), default=0.0)


def _available_memory() -> float:
    """Available memory of the machine, or all of it where the system reports no more."""
    try:
        with open("/proc/meminfo", encoding="ascii") as rows:
            kilobytes = [int(row.split()[1]) for row in rows if row.startswith("MemAvailable:")]
        if kilobytes:
            return 1024.0 * kilobytes[0]
    except OSError:
        pass
    try:
        return float(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    except (AttributeError, ValueError, OSError):
        return 0.0


def _memory_to_limit() -> float:
    """Memory within the limit on the address space of this process; 0 where there is no limit."""
    try:
        import resource
    except ImportError:
        return 0.0
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return 0.0
    try:
        return max(float(limit - own_memory(0)), 1.0)
    except OSError:
        return float(limit)


def own_memory(column: int) -> int:
    """Memory of this process [bytes]: all its addresses (0) or resident (1); OSError where none is reported."""
    with open("/proc/self/statm", encoding="ascii") as counts:
        return int(counts.read().split()[column]) * os.sysconf("SC_PAGE_SIZE")
