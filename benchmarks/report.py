"""Time and size of the report of 264,000 cases: ``python benchmarks/report.py``.

44 records × 6 contact models × 50 gaps × 20 yield forces, made and not solved, on disk; each report is
written by a fresh process that reads the netCDF, as the command does.
"""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from time import perf_counter

import numpy as np
from made_scan import made_scan
from shortened import either

from pounding_risk.results.files import save

RECORDS, LAWS, REPEATS = either((44, 6, 3), (2, 2, 1))
GAPS = np.linspace(0.0, 0.15, either(50, 5))
FORCES = (*np.geomspace(1e5, 5e6, either(19, 2)), np.inf)


def seconds(results: Path, out: Path) -> float:
    """What a fresh process takes to write a report, its start included."""
    start = perf_counter()
    command = [sys.executable, "-m", "pounding_risk", "report", str(results), "-o", str(out)]
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    return perf_counter() - start


def main() -> None:
    """Print a line for each format: the middle of the times and the size."""
    with TemporaryDirectory() as name:
        folder = Path(name)
        scan = made_scan(RECORDS, GAPS, FORCES, LAWS, failed=50).isel(polarity=[0])
        results = save(scan, folder / "results.nc")
        print(f"{scan['status'].size} cases, {results.stat().st_size / 1e6:.3g} MB")
        for suffix in ("html", "pdf"):
            out = folder / f"report.{suffix}"
            times = sorted(seconds(results, out) for _ in range(REPEATS))
            middle, size = times[REPEATS // 2], out.stat().st_size / 1e6
            print(f"{suffix}: {middle:.1f} s ({times[0]:.1f} to {times[-1]:.1f}), {size:.2f} MB")


if __name__ == "__main__":
    main()
