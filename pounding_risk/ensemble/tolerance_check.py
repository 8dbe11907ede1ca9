"""Error measured, not assumed: some of a scan's runs made again at a tighter tolerance, and how far they move.

A run is sensitive where its peak relative displacement or peak force moves by more than the scan's own rtol, where
its impact count or yield exceedance changes, or where one of the two runs fails. Nearly always that is physics: a
grazing touch, a force that just reaches F_E, the late history of a lossless pair with a closed gap.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.results.layout import CaseVariable
from pounding_risk.results.tolerance_check import COUNTED, RELATIVE, WORDS, tighter
from pounding_risk.solver.counters import COMPLETE, STATUS
from pounding_risk.solver.pair.outputs import run_outputs

SENSITIVE, CHANGE = "sensitive", "change_"
SEED = 20110314  # of the sample: the same cases for the same grid on any day


def draws(batches: range, width: int) -> NDArray[np.float64]:
    """A number from 0 to 1 for each case (batches, width), of its place in the grid alone.

    Whether a case is made again does not depend on which cases are solved with it. The numbers are those of splitmix64
    (Steele, Lea and Flood 2014), whose outputs for neighbouring places are unrelated.
    """
    places = np.arange(batches.start * width, batches.stop * width, dtype=np.uint64)
    mixed = (places + np.uint64(SEED)) * np.uint64(0x9E3779B97F4A7C15)
    mixed = (mixed ^ (mixed >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    mixed = (mixed ^ (mixed >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed ^= mixed >> np.uint64(31)
    return np.multiply(mixed >> np.uint64(11), 2.0**-53, dtype=np.float64).reshape(len(batches), width)


def drawn(batches: range, made: NDArray[np.bool_], fraction: float) -> NDArray[np.bool_]:
    """Which of the runs that were ``made`` (batches, width) are made again."""
    return made & (draws(batches, made.shape[1]) < fraction)


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


def check_variables(rtol: float) -> dict[str, CaseVariable]:
    """Variables of the dataset: ``sensitive``, and a ``change_`` per output. Cases not made again are −1, or NaN."""
    told = {
        "long_name": f"1 where the answer moves by more than rtol when the run is made again at {tighter(rtol):g}",
        "flag_values": np.array([-1, 0, 1], dtype=np.int8),
        "flag_meanings": "not_made_again steady sensitive",
    }
    variables = {SENSITIVE: CaseVariable((), np.dtype(np.int8), told)}
    for name in (*RELATIVE, *COUNTED):
        kind = "relative change" if name in RELATIVE else "change"
        attrs = {"units": "1", "long_name": f"{kind} of the {WORDS[name]}, made again"}
        variables[f"{CHANGE}{name}"] = CaseVariable((), np.dtype(np.float64), attrs)
    return variables


def not_made_again(shape: tuple[int, int]) -> Chunk:
    """The variables of `check_variables` for so many (batches, yield forces), none of them made again."""
    return {
        SENSITIVE: np.full(shape, -1, dtype=np.int8),
        **{f"{CHANGE}{name}": np.full(shape, np.nan) for name in (*RELATIVE, *COUNTED)},
    }


def made_again(places: NDArray[np.bool_], found: Mapping[str, np.ndarray], rtol: float) -> Chunk:
    """The variables of `check_variables` (batches, yield forces), from how far the answers at ``places`` move."""
    part = not_made_again((places.shape[0], places.shape[1]))
    part[SENSITIVE][places] = is_sensitive(found, rtol)
    for name, values in found.items():
        part[f"{CHANGE}{name}"][places] = values
    return part


class AtLeastOne:
    """Watches the cases go by in order, so that of a study with any run at all one at least is made again."""

    def __init__(self) -> None:
        self._none_yet = True
        self._least = inf
        self._next = (0, 0)

    def see(self, batches: range, made: NDArray[np.bool_], sensitive: NDArray[np.int8]) -> None:
        """Some batches: which of their runs were made and complete, and what was found of those made again."""
        self._none_yet = self._none_yet and not (sensitive >= 0).any()
        if self._none_yet and made.any():
            lots = np.where(made, draws(batches, made.shape[1]), inf)
            batch, place = np.unravel_index(lots.argmin(), lots.shape)
            if lots[batch, place] < self._least:
                self._least, self._next = float(lots[batch, place]), (batches.start + int(batch), int(place))

    @property
    def missing(self) -> tuple[int, int] | None:
        """The batch and place of the run to make again where none was; None where there is none to make."""
        return self._next if self._none_yet and self._least < inf else None
