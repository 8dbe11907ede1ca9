"""A hundred records read, processed and measured: ``python benchmarks/records.py``.

The 100 horizontal components of the FEMA P-695 sets are written to a temporary folder as AT2 files, in g with every
digit. Then, with the clock running: read from those files, processed by the steps that a raw record gets (mean, taper,
corners from the noise and band-pass, baseline), measured (PGA to D5-95), and their spectra at 100 periods in one call.
``--repeats`` runs are made after one that compiles, which is told apart.
"""

from __future__ import annotations

import argparse
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter
from typing import Any

import numpy as np
from far_field import at2_text, file_name

from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.motions import record_sets
from pounding_risk.motions.intensity import measure, response_spectra
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.processing import DEFAULT_CHAIN
from pounding_risk.motions.read import read_motion

SETS = ("fema-p695-farfield", "fema-p695-nearfield")
PERIODS = np.geomspace(0.02, 10.0, 100)
STAGES = ("read", "read and processed", "measured", "spectra of 100 periods")


def write(folder: Path) -> list[Path]:
    """The sets as files; a station of two sets has two files of different names."""
    paths = []
    for name in SETS:
        for member in record_sets.members(name):
            path = folder / f"{name}-{file_name(member)}"
            path.write_text(at2_text(member, record_sets.recorded(member), name))
            paths.append(path)
    return paths


def stages(paths: list[Path]) -> dict[str, float]:
    """Seconds of reading, processing and measuring."""
    chain: list[dict[str, Any]] = [{"step": step.name, **step.options} for step in DEFAULT_CHAIN]
    motions: list[Motion] = []

    def read(**choices: Any) -> None:
        motions.clear()
        with ProgressDisplay("records", "records") as progress:
            for number, path in enumerate(paths, start=1):
                motions.append(read_motion(path, **choices))
                progress(number, len(paths))

    calls: tuple[Callable[[], object], ...] = (
        read,
        lambda: read(processing=chain),
        lambda: [measure(motion.acceleration, motion.dt) for motion in motions],
        lambda: response_spectra([each.acceleration for each in motions], [each.dt for each in motions], PERIODS),
    )
    found = {}
    for name, call in zip(STAGES, calls, strict=True):
        start = perf_counter()
        call()
        found[name] = perf_counter() - start
    return found


def main(arguments: list[str] | None = None) -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--repeats", type=int, default=5)
    asked = parser.parse_args(arguments)
    with TemporaryDirectory() as folder:
        paths = write(Path(folder))
        size = sum(path.stat().st_size for path in paths) / 1e6
        first = stages(paths)
        runs = [stages(paths) for _ in range(asked.repeats)]
    print(f"{len(paths)} records, {size:.0f} MB of text\n")
    print("| stage | median (least to largest) [s] | the first time, compiling [s] |\n| --- | ---: | ---: |")
    for name in STAGES:
        times = sorted(run[name] for run in runs)
        print(f"| {name} | {np.median(times):.2f} ({times[0]:.2f} to {times[-1]:.2f}) | {first[name]:.2f} |")
    whole = sorted(sum(run.values()) - run["read"] for run in runs)  # the second stage reads them again
    print(f"| in all | {np.median(whole):.2f} ({whole[0]:.2f} to {whole[-1]:.2f}) | {sum(first.values()):.2f} |")
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
