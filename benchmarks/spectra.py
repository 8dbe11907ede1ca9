"""Response spectra of 100 periods beside eqsig and pyrotd: ``python benchmarks/spectra.py``.

El Centro 1940 (RSN6-180 and -270, the first 5,000 samples), T from 0.02 to 10 s evenly in the logarithm, damping 5 %.
The methods take turns; median (least to largest). pyrotd runs in one process and gets as many zeros after the record
as it needs for the longest period not to wrap around; the differences are from this package's PSA.
"""

from __future__ import annotations

from collections.abc import Callable
from importlib import import_module
from time import perf_counter
from typing import Any

import numpy as np
from shortened import either

from pounding_risk.motions.intensity import response_spectra, rotated_spectra
from pounding_risk.motions.read import read_motion

SAMPLES, DT, DAMPING, REPEATS = 5000, 0.01, 0.05, either(9, 1)
PERIODS = np.geomspace(0.02, 10.0, 100)
ZEROS = 16384 - SAMPLES  # ζ ω t = 3.6 at the longest period after these
SHORT = 0.1  # s


def found(name: str) -> Any:
    """The package, or None with a sentence."""
    try:
        return import_module(name)
    except ImportError as error:
        print(f"{name} is left out: {error}; pip install {name} (pyrotd also needs setuptools below 81)")
        return None


def methods(first: np.ndarray, second: np.ndarray) -> dict[str, Callable[[], np.ndarray]]:
    """Each way to PSA or to RotD100 by what it is called."""
    table: dict[str, Callable[[], np.ndarray]] = {
        "this package, Sd, Sv, Sa": lambda: response_spectra(first, DT, PERIODS, DAMPING).pseudo_acceleration
    }
    if eqsig := found("eqsig"):
        table["eqsig, `pseudo_response_spectra`"] = lambda: eqsig.sdof.pseudo_response_spectra(
            first, DT, PERIODS, DAMPING
        )[2]
    table["this package, RotD100, 180 directions"] = lambda: rotated_spectra(
        (first, second), DT, PERIODS, DAMPING
    ).rotd(100)
    if pyrotd := found("pyrotd"):
        pyrotd.processes = 1
        one, two = np.append(first, np.zeros(ZEROS)), np.append(second, np.zeros(ZEROS))
        table["pyrotd, `calc_spec_accels`"] = lambda: psa(pyrotd, one)
        table["the same without zeros, wrapped around"] = lambda: psa(pyrotd, first)
        table["pyrotd, `calc_rotated_spec_accels`"] = lambda: (
            pyrotd.calc_rotated_spec_accels(DT, one, two, 1.0 / PERIODS, DAMPING, percentiles=[100]).spec_accel
        )
    return table


def psa(pyrotd: Any, ground: np.ndarray) -> np.ndarray:
    """PSA by pyrotd."""
    return pyrotd.calc_spec_accels(DT, ground, 1.0 / PERIODS, DAMPING).spec_accel


def main() -> int:
    """Print the table."""
    first, second = (read_motion(id).acceleration[:SAMPLES].copy() for id in ("RSN6-180", "RSN6-270"))
    table = methods(first, second)
    answers = {name: call() for name, call in table.items()}
    times: dict[str, list[float]] = {name: [] for name in table}
    for _ in range(REPEATS):
        for name, call in table.items():
            start = perf_counter()
            call()
            times[name].append(1e3 * (perf_counter() - start))
    alone, rotated = (name for name in table if name.startswith("this"))
    print("| method | time | over this package's | largest difference, T >= 0.1 s | any T |")
    print("| --- | ---: | ---: | ---: | ---: |")
    for name, spent in times.items():
        ours = rotated if "otated" in name or "RotD" in name else alone
        apart = np.abs(answers[name] / answers[ours] - 1.0)
        ratio = np.median(spent) / np.median(times[ours])
        print(
            f"| {name} | {np.median(spent):.2f} ms ({min(spent):.2f} to {max(spent):.2f}) | {ratio:.3g} | "
            f"{100 * apart[PERIODS >= SHORT].max():.2g} % | {100 * apart.max():.2g} % |"
        )
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
