"""The tolerance check: a sample of a scan's runs is repeated at a tighter tolerance, and the changes are recorded.

A run is sensitive where its peak relative displacement or peak force changes by more than the scan's rtol, where its
impact count or yield exceedance changes, or where one of the two runs fails. The cause is nearly always physical: a
grazing touch, a force that just reaches F_E, the late history of a lossless pair with a closed gap.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.job import never
from pounding_risk.results.layout import CaseVariable
from pounding_risk.results.tolerance_check import COUNTED, RELATIVE, WORDS, tighter
from pounding_risk.solver.counters import COMPLETE, STATUS
from pounding_risk.solver.pair.outputs import run_outputs

SENSITIVE, CHANGE = "sensitive", "change_"
SEED = 20110314  # of the sample: a grid always has the same


def draws(batches: range, width: int) -> NDArray[np.float64]:
    """A pseudo-random number from 0 to 1 for each case (batches, width), from its place in the grid alone.

    So whether a run is repeated does not depend on the runs that are solved with it. The generator is splitmix64
    (Steele, Lea and Flood 2014), whose outputs for successive places are independent.
    """
    places = np.arange(batches.start * width, batches.stop * width, dtype=np.uint64)
    mixed = (places + np.uint64(SEED)) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed ^= mixed >> np.uint64(31)
    return np.multiply(mixed >> np.uint64(11), 2.0**-53, dtype=np.float64).reshape(len(batches), width)


def drawn(batches: range, is_made: NDArray[np.bool_], fraction: float) -> NDArray[np.bool_]:
    """Which of the runs that were ``made`` (batches, width) are repeated."""
    return is_made & (draws(batches, is_made.shape[1]) < fraction)


def changes(first: np.ndarray, second: np.ndarray, yield_forces: np.ndarray) -> dict[str, np.ndarray]:
    """Change of each output of `WORDS` from the first run to the second; NaN where either failed."""
    before, after = (run_outputs(raw, yield_forces) for raw in (first, second))
    return differences(before, after, (first[:, STATUS] != COMPLETE) | (second[:, STATUS] != COMPLETE))


def differences(
    before: Mapping[str, Any], after: Mapping[str, Any], failed: NDArray[np.bool_]
) -> dict[str, np.ndarray]:
    """The same as `changes`, from the outputs of both runs by name."""
    changes_by_name = {}
    for name in (*RELATIVE, *COUNTED):
        difference = np.abs(after[name] - before[name])
        if name in RELATIVE:
            # From nothing, or to nothing, no change is relative: infinite, which is within no limit.
            is_zero = (before[name] == 0.0) | (after[name] == 0.0)
            relative = difference / np.where(is_zero, 1.0, np.abs(after[name]))
            difference = np.where(is_zero & (difference > 0.0), np.inf, relative)
        # What is not defined in either run, such as the force of an instant jump, has not moved.
        is_undefined = np.isnan(before[name]) & np.isnan(after[name])
        changes_by_name[name] = np.where(failed, np.nan, np.where(is_undefined, 0.0, difference))
    return changes_by_name


def is_sensitive(moves: Mapping[str, np.ndarray], rtol: float) -> NDArray[np.bool_]:
    """True for the runs that are sensitive, see the module docstring, from the changes of their outputs."""
    # Written so that NaN, a failed run, is never within its limit.
    is_within = [moves[name] <= rtol for name in RELATIVE] + [moves[name] <= 0.0 for name in COUNTED]
    return ~np.logical_and.reduce(is_within)


def check_variables(rtol: float) -> dict[str, CaseVariable]:
    """Variables of the dataset: ``sensitive``, and a ``change_`` per output. Cases not repeated are −1, or NaN."""
    attrs = {
        "long_name": f"1 where the answer moves by more than rtol when the run is recomputed at {tighter(rtol):g}",
        "flag_values": np.array([-1, 0, 1], dtype=np.int8),
        "flag_meanings": "not_made_again steady sensitive",
    }
    variables = {SENSITIVE: CaseVariable((), np.dtype(np.int8), attrs)}
    for name in (*RELATIVE, *COUNTED):
        kind = "relative change" if name in RELATIVE else "change"
        attrs = {"units": "1", "long_name": f"{kind} of the {WORDS[name]}, recomputed"}
        variables[f"{CHANGE}{name}"] = CaseVariable((), np.dtype(np.float64), attrs)
    return variables


def not_recomputed(shape: tuple[int, int]) -> Chunk:
    """The variables of `check_variables` for so many (batches, yield forces), none of them repeated."""
    changes = {f"{CHANGE}{name}": np.full(shape, np.nan) for name in (*RELATIVE, *COUNTED)}
    return {SENSITIVE: np.full(shape, -1, dtype=np.int8), **changes}


def recomputed(places: NDArray[np.bool_], moves: Mapping[str, np.ndarray], rtol: float) -> Chunk:
    """The variables of `check_variables` (batches, yield forces), from the changes of the runs at ``places``."""
    chunk = not_recomputed((places.shape[0], places.shape[1]))
    chunk[SENSITIVE][places] = is_sensitive(moves, rtol)
    for name, change in moves.items():
        chunk[f"{CHANGE}{name}"][places] = change
    return chunk


class AtLeastOne:
    """Finds, batch after batch in order, the run to repeat in a scan in which no run was drawn."""

    def __init__(self) -> None:
        self._none_drawn = True
        self._least = inf
        self._next = (0, 0)

    def see(self, batches: range, is_made: NDArray[np.bool_], sensitive: NDArray[np.int8]) -> None:
        """Look at batches: which runs were made and are complete, and which of them were repeated."""
        self._none_drawn = self._none_drawn and not (sensitive >= 0).any()
        if self._none_drawn and is_made.any():
            lots = np.where(is_made, draws(batches, is_made.shape[1]), inf)
            batch, place = np.unravel_index(lots.argmin(), lots.shape)
            if lots[batch, place] < self._least:
                self._least, self._next = float(lots[batch, place]), (batches.start + int(batch), int(place))

    @property
    def missing(self) -> tuple[int, int] | None:
        """Batch and index in it of the run to repeat; None where a run was drawn, or there is none."""
        return self._next if self._none_drawn and self._least < inf else None

    def patches(self, job: Any) -> tuple[tuple[int, Chunk], ...]:
        """The variables of `check_variables` for the batch of that run, which the pair or row ``job`` repeats."""
        if self.missing is None:
            return ()
        batch, place = self.missing
        batches = range(batch, batch + 1)
        chunk = job.solve(batches, never)
        checked = job.checked(batches, chunk or {}, np.arange(job.width)[None, :] == place, never)
        assert checked is not None, "nothing stops it"
        return ((batch, checked),)
