"""Checks that a scan fits memory and disk, made before anything is allocated.

A response without contact has a state at every node: at the samples, and between them where the phase of the fastest
mode would advance by more than `TURN` (`pair.at_rest`, `row.lay_out`). Its size follows from the record, the shortest
period and, of a row, the number of floors.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable
from itertools import pairwise
from math import ceil, sqrt
from pathlib import Path

from pounding_risk.errors import SceneError
from pounding_risk.models.effects import wave_of
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.scene import Scene

TURN = 2.5  # rad, largest phase between nodes
BYTES_A_NODE = 120.0  # of a response while it is made: ground, time, four states, and NumPy's copies of the first two
BYTES_A_DOF = 26.0  # and node, of a row: displacement and velocity, bounds and peaks by blocks of nodes
BYTES_A_GROUND = 48.0  # of each building and node, where a wave passes a row
MOST_BYTES = 1e14  # of a dataset: more than any disk that a scan is written to


def fastest_rate(study: Scene) -> float:
    """Upper bound of the circular frequencies of the buildings [rad/s]; exact for single masses.

    For a chain it is sqrt(max_i 2 (k_i + k_{i+1}) / m_i), Gershgorin's bound of M⁻¹ K.
    """
    rates = [0.0]
    for building in study.buildings:
        if building.is_rigid:
            continue
        chain = chain_of(building, study.effects)
        if chain.mass.size == 1:
            rates.append(sqrt(chain.spring[0] / chain.mass[0]))
            continue
        springs = pairwise([*chain.spring.tolist(), 0.0])
        rates += [sqrt(2.0 * (below + above) / mass) for mass, (below, above) in zip(chain.mass, springs, strict=True)]
    return max(rates)


def response_bytes(study: Scene, motion: Motion) -> float:
    """Memory of one response without contact to a motion [bytes]; that of a row has all its floors."""
    return bytes_a_node(study) * _parts(fastest_rate(study), motion) * motion.acceleration.size


def _parts(rate: float, motion: Motion) -> int:
    """Into how many intervals between two nodes a sample is divided, the fastest mode at ``rate`` [rad/s]."""
    return max(1, ceil(rate * motion.dt / TURN))


def bytes_a_node(study: Scene) -> float:
    """Memory of one response without contact, by node of a motion that arrives everywhere at once [bytes]."""
    if not study.is_row:
        return BYTES_A_NODE
    buildings = len(study.buildings)
    dofs = sum(chain_of(building, study.effects).mass.size for building in study.buildings)
    if wave_of(study.effects) is None:
        return BYTES_A_NODE + BYTES_A_DOF * dofs
    # Nodes stand where a sample arrives at any building, and each building has a dof that is its ground's.
    return buildings * (BYTES_A_NODE + BYTES_A_DOF * (dofs + buildings) + BYTES_A_GROUND * buildings)


def check_memory(study: Scene, motions: Iterable[Motion]) -> None:
    """Raise SceneError where one response would not fit the free memory."""
    free, rate, at_a_node = free_memory(), fastest_rate(study), bytes_a_node(study)
    for motion in motions:
        parts = _parts(rate, motion)
        size = at_a_node * parts * motion.acceleration.size
        if free and size > free:
            raise SceneError(
                study.source,
                [
                    f"the fastest mode turns by {rate * motion.dt:.3g} rad within a sample of "
                    f"{motion.name}, so that each is divided into {parts}: one response takes {size / 1e9:.3g} GB, "
                    f"and {free / 1e9:.3g} GB of memory are free; check mass, period and stiffness of the buildings"
                ],
            )


def check_dataset(study: Scene, cases: int, size: int) -> None:
    """Raise SceneError for a grid whose dataset fits no disk."""
    if size > MOST_BYTES:
        raise SceneError(
            study.source,
            [
                f"the grid has {cases:.3g} cases, and their dataset {size / 1e12:.3g} TB before compression; no disk "
                "holds that: write fewer values in [grid]"
            ],
        )


def check_disk(study: Scene, size: int, folder: Path) -> None:
    """Raise SceneError where the dataset, before compression, is larger than the free disk space.

    Chunks are kept uncompressed until the dataset is written.
    """
    free = shutil.disk_usage(folder).free
    if size > free:
        raise SceneError(
            study.source,
            [
                f"the cases take {size / 1e9:.3g} GB before compression, and {free / 1e9:.3g} GB are free in "
                f"{folder.resolve()}; write fewer values in [grid], or name another place with -o"
            ],
        )


def check_held(study: Scene, size: int) -> None:
    """Raise SceneError where a dataset that is to stay in memory is larger than the free memory."""
    free = free_memory()
    if free and size > free:
        raise SceneError(
            study.source,
            [
                f"the cases take {size / 1e9:.3g} GB, and {free / 1e9:.3g} GB of memory are free; scan into a file, "
                "or write fewer values in [grid]"
            ],
        )


def free_memory() -> float:
    """Memory that this process can still allocate [bytes]; 0 where the system does not tell."""
    return min((size for size in (_available(), _allowed()) if size > 0.0), default=0.0)


def _available() -> float:
    """Available memory of the machine, or all of it where the system tells no more."""
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


def _allowed() -> float:
    """Memory within the limit on the address space of this process; 0 where there is no limit."""
    try:
        import resource
    except ImportError:
        return 0.0
    limit = resource.getrlimit(resource.RLIMIT_AS)[0]
    if limit == resource.RLIM_INFINITY:
        return 0.0
    try:
        with open("/proc/self/statm", encoding="ascii") as counts:
            used = int(counts.read().split()[0]) * os.sysconf("SC_PAGE_SIZE")
    except OSError:
        return float(limit)
    return max(float(limit - used), 1.0)
