"""Findings of the tolerance check, from a dataset; `ensemble.tolerance_check` makes it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk._common.words import words_of
from pounding_risk.results.layout import streamed
from pounding_risk.units import Quantity, rounded, si

if TYPE_CHECKING:
    import xarray as xr

TIGHTER, TIGHTEST = 100.0, 1e-12  # rtol of a repeated run: so many times smaller, but not below
# Outputs of which relative changes are recorded, and those of which differences are: counts and flags.
RELATIVE, COUNTED = ("peak_relative_displacement", "peak_contact_force"), ("impact_count", "yield_exceedance")
WORDS = words_of(*RELATIVE, *COUNTED)
SHARE = Quantity("1", 0.0, 1.0, "share of the runs", example="0.01")


def check_share(fraction: float | str) -> float:
    """A share of runs as a number; raises PoundingError for anything that is not a number from 0 to 1."""
    return si(fraction, SHARE, "check_fraction")


def tighter(rtol: float) -> float:
    """The relative tolerance of a repeated run."""
    return max(rtol / TIGHTER, TIGHTEST)


def findings(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """Sentences on the runs that were repeated and on those that are sensitive: (what, sentence).

    Read block by block; only the relative changes of the repeated runs are held in memory.
    """
    if "sensitive" not in dataset:
        return
    simulated, checked, sensitive = 0, 0, 0
    changes: dict[str, list[np.ndarray]] = {name: [] for name in RELATIVE}
    change_counts, from_zero = dict.fromkeys(COUNTED, 0), dict.fromkeys(RELATIVE, 0)
    for piece in streamed(dataset, ("sensitive", "simulated", *(f"change_{name}" for name in (*RELATIVE, *COUNTED)))):
        is_checked = piece["sensitive"] >= 0
        simulated += int((piece["simulated"] == 1).sum())
        checked += int(is_checked.sum())
        sensitive += int((piece["sensitive"] == 1).sum())
        for name, finite in changes.items():
            sizes = piece[f"change_{name}"][is_checked]
            finite.append(sizes[np.isfinite(sizes)])
            from_zero[name] += int(np.isposinf(sizes).sum())
        for name in COUNTED:
            change_counts[name] += int((np.nan_to_num(piece[f"change_{name}"]) > 0.0).sum())
    if not checked:
        return
    rtol = float(dataset.attrs["rtol"])
    moves = []
    for name, finite in changes.items():
        if (sizes := np.concatenate(finite)).size:
            median, largest = (rounded(float(change), 1) for change in (np.median(sizes), sizes.max()))
            moves.append(f"{WORDS[name]} moves by {median} (median), {largest} (largest)")
        if from_zero[name]:
            moves.append(f"{WORDS[name]} moves from or to 0 in {from_zero[name]}")
    moves += [f"{WORDS[name]} changes in {count or 'none'}" for name, count in change_counts.items()]
    yield "recomputed", f"{checked} of {counted(simulated, 'run')} at rtol {tighter(rtol):g}: " + "; ".join(moves)
    if sensitive:
        yield (
            "sensitive",
            f"{sensitive} of these {checked}: an answer moves by more than rtol {rtol:g}, or a count changes; see the "
            "variable 'sensitive', and whether a tighter rtol settles them",
        )
