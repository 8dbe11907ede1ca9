"""What the runs that were made again tell, from a dataset; see `recheck` for how they are made."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from pounding_risk._common.counted import counted
from pounding_risk.results.layout import streamed
from pounding_risk.units import Quantity, si

if TYPE_CHECKING:
    import xarray as xr

TIGHTER, TIGHTEST = 100.0, 1e-12  # rtol of the second run: so many times smaller, but never below
# Relative changes, and plain differences of counts and flags.
RELATIVE, COUNTED = ("peak_relative_displacement", "peak_contact_force"), ("impact_count", "yield_exceedance")
WORDS = {
    "peak_relative_displacement": "peak relative displacement",
    "peak_contact_force": "peak contact force",
    "impact_count": "impact count",
    "yield_exceedance": "yield exceedance",
}
SHARE = Quantity("1", 0.0, 1.0, "share of the runs", example="0.01")


def check_share(fraction: float | str) -> float:
    """The share as a number; raises PoundingError for what is none from 0 to 1."""
    return si(fraction, SHARE, "check_fraction")


def tighter(rtol: float) -> float:
    """The tolerance of the second run."""
    return max(rtol / TIGHTER, TIGHTEST)


def findings(dataset: xr.Dataset) -> Iterator[tuple[str, str]]:
    """What was made again and what is sensitive, each with a sentence: how many, and how far the answers move.

    Read piece by piece: what memory holds is the relative changes of the runs made again.
    """
    if "sensitive" not in dataset:
        return
    made, checked, sensitive = 0, 0, 0
    changes: dict[str, list[np.ndarray]] = {name: [] for name in RELATIVE}
    moved = dict.fromkeys(COUNTED, 0)
    for piece in streamed(dataset, ("sensitive", "simulated", *(f"change_{name}" for name in (*RELATIVE, *COUNTED)))):
        again = piece["sensitive"] >= 0
        made += int((piece["simulated"] == 1).sum())
        checked += int(again.sum())
        sensitive += int((piece["sensitive"] == 1).sum())
        for name, found in changes.items():
            values = piece[f"change_{name}"][again]
            found.append(values[np.isfinite(values)])
        for name in COUNTED:
            moved[name] += int((np.nan_to_num(piece[f"change_{name}"]) > 0.0).sum())
    if not checked:
        return
    rtol = float(dataset.attrs["rtol"])
    moves = [*_moves(changes), *(f"{WORDS[name]} changes in {count or 'none'}" for name, count in moved.items())]
    yield "made again", f"{checked} of {counted(made, 'run')} at rtol {tighter(rtol):g}: " + "; ".join(moves)
    if sensitive:
        yield (
            "sensitive",
            f"{sensitive} of these {checked}: an answer moves by more than rtol {rtol:g}, or a count changes; see the "
            "variable 'sensitive', and whether a tighter rtol settles them",
        )


def _moves(changes: dict[str, list[np.ndarray]]) -> Iterator[str]:
    for name, found in changes.items():
        values = np.concatenate(found)
        if values.size:
            yield f"{WORDS[name]} moves by {np.median(values):.0e} (median), {values.max():.0e} (largest)"
