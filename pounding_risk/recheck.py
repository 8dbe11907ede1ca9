"""Error measured, not assumed: some of a scan's runs made again at a tighter tolerance, and how far they move.

A run is sensitive where its peak relative displacement or peak force moves by more than the scan's own rtol, where
its impact count or yield exceedance changes, or where one of the two runs fails. Nearly always that is physics: a
grazing touch, a force that just reaches F_E, the late history of a lossless pair with a closed gap.
"""

from __future__ import annotations

from collections.abc import Mapping
from concurrent.futures import ThreadPoolExecutor
from math import ceil
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._jit import lowered
from pounding_risk.core.collide import make_desk
from pounding_risk.core.sweep import SIMULATED, sweep
from pounding_risk.core.tally import COMPLETE, STATUS
from pounding_risk.errors import PoundingError
from pounding_risk.outputs import COLUMNS, run_outputs
from pounding_risk.rechecked import COUNTED, RELATIVE, WORDS, tighter

SEED = 20110314  # of the sample: the same cases for the same scene on any day


class RunGrid(NamedTuple):
    """What a second run needs of the first: by place along the dataset's axes."""

    pair: Any
    frees: np.ndarray  # (record, polarity, pga) of `Free`
    laws: tuple[Any, ...]
    gaps: np.ndarray
    yield_forces: np.ndarray
    restitution: Any
    rtol: float


def check_share(fraction: float) -> None:
    """Raise PoundingError for a share outside 0 to 1."""
    if not 0.0 <= fraction <= 1.0:
        raise PoundingError(f"check_fraction is {fraction:g}; it is a share of the runs, from 0 to 1, such as 0.01")


def sample(raw: np.ndarray, how: np.ndarray, fraction: float) -> NDArray[np.int64]:
    """Places (cases, axes) of a random share of the runs that were made and complete, rounded up.

    The same for the same grid.
    """
    return chosen((how == SIMULATED) & (raw[..., STATUS] == COMPLETE), fraction)


def chosen(made: NDArray[np.bool_], fraction: float) -> NDArray[np.int64]:
    """Places (cases, axes) of a random share of those that are true, rounded up; the same for the same grid."""
    places = np.argwhere(made)
    count = ceil(fraction * len(places))
    return places[np.sort(np.random.default_rng(SEED).choice(len(places), count, replace=False))]


def run_again(grid: RunGrid, places: np.ndarray, workers: int) -> np.ndarray:
    """Raw columns (cases, COLUMNS) of the cases at ``places``, at the tighter tolerance and without screening."""
    raw = np.zeros((len(places), COLUMNS))
    rtol = tighter(grid.rtol)

    def work(number: int) -> None:
        *motion, law, gap, strength = places[number]
        values = grid.gaps[gap : gap + 1], grid.yield_forces[strength : strength + 1], grid.restitution
        out, how = raw[number].reshape(1, 1, -1), np.zeros((1, 1), dtype=np.int8)
        free = grid.frees[tuple(motion)]
        sweep(grid.pair, free, lowered(grid.laws[law]), values, rtol, False, make_desk(rtol), out, how)

    with ThreadPoolExecutor(workers) as pool:
        list(pool.map(work, range(len(places))))
    return raw


def changes(first: np.ndarray, second: np.ndarray, yield_forces: np.ndarray) -> dict[str, np.ndarray]:
    """How far each output of `WORDS` moves from the first run to the second; NaN where either failed."""
    before, after = (run_outputs(raw, yield_forces) for raw in (first, second))
    return differences(before, after, (first[:, STATUS] != COMPLETE) | (second[:, STATUS] != COMPLETE))


def differences(
    before: Mapping[str, Any], after: Mapping[str, Any], failed: NDArray[np.bool_]
) -> dict[str, np.ndarray]:
    """As `changes`, from the outputs of both runs by name."""
    found = {}
    for name in (*RELATIVE, *COUNTED):
        difference = np.abs(after[name] - before[name])
        scale = np.where(after[name] != 0.0, np.abs(after[name]), 1.0) if name in RELATIVE else 1.0
        # What is not defined in either run, such as the force of an instant jump, has not moved.
        undefined = np.isnan(before[name]) & np.isnan(after[name])
        found[name] = np.where(failed, np.nan, np.where(undefined, 0.0, difference / scale))
    return found


def is_sensitive(found: Mapping[str, np.ndarray], rtol: float) -> NDArray[np.bool_]:
    """True for the runs whose answers move by more than the tolerance, or fail once; see the module's head."""
    # Written so that NaN, a failed run, is never within its limit.
    within = [found[name] <= rtol for name in RELATIVE] + [found[name] <= 0.0 for name in COUNTED]
    return ~np.logical_and.reduce(within)


def check_runs(
    grid: RunGrid, arrays: tuple[np.ndarray, np.ndarray], places: np.ndarray, workers: int
) -> dict[str, tuple[np.ndarray, dict[str, Any]]]:
    """Variables of the dataset along its axes, values and attributes: ``sensitive``, and a ``change_`` per output.

    ``arrays`` = (raw columns, how each case was answered) of the scan. Cases that were not run again are −1, or NaN.
    """
    raw, how = arrays
    at = tuple(places.T)
    found = changes(raw[at], run_again(grid, places, workers), grid.yield_forces[places[:, -1]])
    return as_variables(found, places, how.shape, grid.rtol)


def as_variables(
    found: Mapping[str, np.ndarray], places: np.ndarray, shape: tuple[int, ...], rtol: float
) -> dict[str, tuple[np.ndarray, dict[str, Any]]]:
    """As `check_runs`, from how far the answers at ``places`` move."""
    at = tuple(places.T)
    flags = np.full(shape, -1, dtype=np.int8)
    flags[at] = is_sensitive(found, rtol)
    told = {
        "long_name": f"1 where the answer moves by more than rtol when the run is made again at {tighter(rtol):g}",
        "flag_values": np.array([-1, 0, 1], dtype=np.int8),
        "flag_meanings": "not_made_again steady sensitive",
    }
    variables: dict[str, tuple[np.ndarray, dict[str, Any]]] = {"sensitive": (flags, told)}
    for name, values in found.items():
        whole = np.full(shape, np.nan)
        whole[at] = values
        kind = "relative change" if name in RELATIVE else "change"
        variables[f"change_{name}"] = (whole, {"units": "1", "long_name": f"{kind} of the {WORDS[name]}, made again"})
    return variables
