"""What a grid takes of memory and disk, known before any of it is asked for, and what no machine has.

A response without contact has a state at every node: samples, divided where the fastest mode would turn by more than
`TURN` between them (`pair.at_rest`, `rows.lay_out`). Its size follows from the record and the fastest period alone.
"""

from __future__ import annotations

import os
import shutil
from collections.abc import Iterable
from itertools import pairwise
from math import ceil, pi, sqrt
from pathlib import Path

from pounding_risk.errors import SceneError
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.scene import Study

TURN = 2.5  # rad between nodes at most, of the fastest mode
BYTES_A_NODE = 120.0  # of a response while it is made: ground, time, four states, and NumPy's copies of the first two
MOST_BYTES = 1e14  # of a dataset: no disk that a scan is written to holds a hundred terabytes


def fastest_rate(study: Study) -> float:
    """A bound on the fastest circular frequency of the scene's buildings [rad/s]; the exact one of single masses.

    Of a chain no mode is faster than sqrt(max_i 2 (k_i + k_{i+1}) / m_i), Gershgorin's bound on M⁻¹ K.
    """
    rates = [0.0]
    for building in study.buildings:
        if building.is_rigid:
            continue
        if isinstance(building, Building) and not study.is_row:
            rates.append(2.0 * pi / building.period)
            continue
        chain = chain_of(building, study.effects)
        springs = pairwise([*chain.spring.tolist(), 0.0])
        rates += [sqrt(2.0 * (below + above) / mass) for mass, (below, above) in zip(chain.mass, springs, strict=True)]
    return max(rates)


def response_bytes(study: Study, motion: Motion) -> float:
    """Of the memory that one response without contact to a motion takes."""
    parts = max(1, ceil(fastest_rate(study) * motion.dt / TURN))
    return BYTES_A_NODE * parts * motion.acceleration.size


def check_memory(study: Study, motions: Iterable[Motion]) -> None:
    """Refuse a scene of which one response would not fit the memory that is free: raises SceneError."""
    free = free_memory()
    for motion in motions:
        size = response_bytes(study, motion)
        if free and size > free:
            parts = max(1, ceil(fastest_rate(study) * motion.dt / TURN))
            raise SceneError(
                study.source,
                [
                    f"the fastest mode turns by {fastest_rate(study) * motion.dt:.3g} rad within a sample of "
                    f"{motion.name}, so that each is divided into {parts}: one response takes {size / 1e9:.3g} GB, "
                    f"and {free / 1e9:.3g} GB of memory are free; check mass, period and stiffness of the buildings"
                ],
            )


def check_dataset(study: Study, cases: int, size: int) -> None:
    """Refuse a grid whose dataset no disk holds: raises SceneError."""
    if size > MOST_BYTES:
        raise SceneError(
            study.source,
            [
                f"the grid has {cases:.3g} cases, and their dataset {size / 1e12:.3g} TB before compression; no disk "
                "holds that: write fewer values in [grid]"
            ],
        )


def check_disk(study: Study, size: int, folder: Path) -> None:
    """Refuse a dataset larger, before compression, than what is free where it is to be kept: raises SceneError.

    What is solved is kept there uncompressed until the dataset is written.
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


def check_held(study: Study, size: int) -> None:
    """Refuse a dataset that is to stay in memory and is larger than what is free: raises SceneError."""
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
    """Memory that a process may still ask for [bytes]; 0 where the system does not tell."""
    found = [size for size in (_available(), _allowed()) if size > 0.0]
    return min(found, default=0.0)


def _available() -> float:
    """What the machine has left; all that it has, where it tells no more."""
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
    """What a limit on this process's address space leaves; 0 where there is none."""
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
