"""A job of plain numbers for the tests of executors, which other processes can make from its order."""

from __future__ import annotations

import os
import signal
import time
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from scenes import BOTH, scene_text, single

from pounding_risk.errors import PoundingError

WIDTH = 3  # cases in a line


class Order(NamedTuple):
    """Parameters from which another process makes the same job."""

    lines: int = 1000
    laws: int = 2
    run: int = 10  # lines in a row of one law
    seconds: float = 0.0  # of a line
    fault: int = -1  # the line that a user is told to repair
    blunder: int = -1  # the line at which the code itself fails
    deadly: int = -1  # the line that ends its process, as one that takes all memory does


class Numbers:
    """Each line gives what a hash of its number gives."""

    def __init__(self, order: Order):
        self.order = order
        self.lines, self.width, self.bytes_a_line = order.lines, WIDTH, 8 * WIDTH + 8

    def law_at(self, line: int) -> int:
        """As a grid's: some lines of one law, as many of the next."""
        return line // self.order.run % self.order.laws

    def solve(self, lines: range, stop: Callable[[], bool]) -> dict[str, Any] | None:
        """Slow where the order says so, and wrong where it says so."""
        for line in lines:
            if stop():
                return None
            if line == self.order.fault:
                raise PoundingError(f"line {line} cannot be solved; leave it out")
            if line == self.order.blunder:
                raise ZeroDivisionError(f"line {line}")
            if line == self.order.deadly:
                os.kill(os.getpid(), signal.SIGKILL)
            if self.order.seconds:
                time.sleep(self.order.seconds)
        number = np.asarray(lines, dtype=np.uint64)
        mixed = (number * np.uint64(0x9E3779B97F4A7C15)) ^ (number >> np.uint64(3))
        value = np.sin(mixed.astype(float))[:, None] * np.arange(1.0, WIDTH + 1.0)
        return {"value": value, "process": np.full(len(lines), os.getpid())}


class Kept:
    """Sink that records the chunks an executor hands over."""

    def __init__(self, lines: int):
        self.value = np.full((lines, WIDTH), np.nan)
        self.times = np.zeros(lines, dtype=int)
        self.chunks: list[range] = []
        self.processes: set[int] = set()

    def __call__(self, lines: range, part: dict[str, Any], seconds: float) -> None:
        """Record one chunk."""
        assert seconds >= 0.0
        self.value[lines.start : lines.stop] = part["value"]
        self.times[lines.start : lines.stop] += 1
        self.chunks.append(lines)
        self.processes |= set(part["process"].tolist())


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
