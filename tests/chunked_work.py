"""A job of plain numbers for the tests of executors, which other processes can make from its input."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scenes import BOTH, scene_text, single

from pounding_risk.errors import PoundingError

WIDTH = 3  # cases in a batch


class ScanInput(NamedTuple):
    """Parameters from which another process makes the same job."""

    batches: int = 1000
    laws: int = 2
    run: int = 10  # batches in a row of one law
    seconds: float = 0.0  # of a batch
    fault: int = -1  # the batch that a user is told to repair
    blunder: int = -1  # the batch at which the code itself fails
    deadly: int = -1  # the batch that ends its process, as one that takes all memory does


class Numbers:
    """Each batch gives what a hash of its number gives."""

    def __init__(self, scan_input: ScanInput):
        self.scan_input = scan_input
        self.batches, self.width, self.bytes_per_batch = scan_input.batches, WIDTH, 8 * WIDTH + 8

    def law_at(self, batch: int) -> int:
        """As a grid's: some batches of one law, as many of the next."""
        return batch // self.scan_input.run % self.scan_input.laws

    def solve(self, batches: range, stop: Callable[[], bool]) -> dict[str, Any] | None:
        """Slow where the input says so, and wrong where it says so."""
        for batch in batches:
            if stop():
                return None
            if batch == self.scan_input.fault:
                raise PoundingError(f"batch {batch} cannot be solved; leave it out")
            if batch == self.scan_input.blunder:
                raise ZeroDivisionError(f"batch {batch}")
            if batch == self.scan_input.deadly:
                os.kill(os.getpid(), signal.SIGKILL)
            if self.scan_input.seconds:
                time.sleep(self.scan_input.seconds)
        number = np.asarray(batches, dtype=np.uint64)
        mixed = (number * np.uint64(0x9E3779B97F4A7C15)) ^ (number >> np.uint64(3))
        value = np.sin(mixed.astype(float))[:, None] * np.arange(1.0, WIDTH + 1.0)
        return {"value": value, "process": np.full(len(batches), os.getpid())}


class Kept:
    """Sink that records the chunks an executor hands over; each batch took longer than ``least`` seconds."""

    def __init__(self, batches: int, least: float = 0.0):
        self.least = least
        self.value = np.full((batches, WIDTH), np.nan)
        self.times = np.zeros(batches, dtype=int)
        self.chunks: list[range] = []
        self.processes: set[int] = set()

    def __call__(self, batches: range, part: dict[str, Any], seconds: float) -> None:
        """Record one chunk."""
        assert seconds > len(batches) * self.least
        self.value[batches.start : batches.stop] = part["value"]
        self.times[batches.start : batches.stop] += 1
        self.chunks.append(batches)
        self.processes |= set(part["process"].tolist())


class Interrupted(Kept):
    """As `Kept`; the third call is Ctrl-C, after ``pause`` seconds in which others go on."""

    def __init__(self, batches: int, least: float = 0.0, *, pause: float):
        super().__init__(batches, least)
        self.pause, self.tries = pause, []

    def __call__(self, batches: range, part: dict[str, Any], seconds: float) -> None:
        """Record one chunk, but for the third."""
        self.tries.append(batches)
        if len(self.tries) == 3:
            time.sleep(self.pause)
            raise KeyboardInterrupt
        super().__call__(batches, part, seconds)


def full_disk(batches: range, part: dict[str, Any], seconds: float) -> None:
    """Sink without space."""
    raise PoundingError("no space")


def pending_of(job: Numbers, batches: list[range] | None = None, **more: Any) -> Any:
    """What is left to do of a job: all of it, or these batches."""
    from pounding_risk.ensemble.threads import Pending

    every = [range(job.batches)] if batches is None else batches
    return Pending(every, job.law_at, bytes_per_batch=job.bytes_per_batch, **more)


SCENE = scene_text(
    single("left", "500 t", "0.5 s", damping=0.05),
    single("right", "800 t", "1.0 s", damping=0.05),
    name="A pair for any executor",
    law="viscous_elastoplastic",
    gap="0 mm",
    records={"window": ["0 s", "6 s"], "polarity": BOTH},
    grid={
        "gap": {"start": "0 mm", "stop": "60 mm", "num": 13},
        "yield_force": ["300 kN", "1 MN", "inf"],
        "contact_model": ["jankowski", "viscous_elastoplastic"],
    },
)


def scanned(**how: Any) -> Any:
    """The dataset of the scene, a quarter of its runs made again."""
    from pounding_risk.ensemble.scan import scan
    from pounding_risk.scene.reader import parse_scene

    return scan(parse_scene(SCENE), check_fraction=0.25, **how)
