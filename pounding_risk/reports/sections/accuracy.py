"""Section on accuracy: tolerance, runs made again, energy left over, failed runs, and a dataset of `accuracy`."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from pounding_risk.questions.accuracy import sheet
from pounding_risk.render.sheet import Block, Cell, count, facts, heading, number, paragraph
from pounding_risk.reports.data import ReportData

if TYPE_CHECKING:
    import xarray as xr

TITLE = "How exact the numbers are"
ORDER = 80
MOVED = {
    "change_peak_relative_displacement": "peak relative displacement",
    "change_peak_contact_force": "peak contact force",
}
COUNTED = {"change_impact_count": "impact count", "change_yield_exceedance": "yield exceedance"}


def write(data: ReportData) -> list[Block]:
    """The tolerance, the runs made again and how far they moved, energy left over, and runs that failed."""
    results = data.results
    simulated = int((results["simulated"] == 1).sum())
    total = results["status"].size
    rows: list[tuple[str, Cell | str]] = [
        ("relative tolerance of the solver", number(results.attrs["rtol"])),
        ("cases", count(total)),
        ("with a run of their own", count(simulated)),
        ("known exactly without one", count(total - simulated)),
        *_again(results),
        *_residuals(results),
        *_failed(results),
    ]
    blocks = [
        facts("Tolerance, recomputed runs, energy and failures.", rows),
        paragraph(
            "Between contacts the motion is exact for a ground acceleration that is linear between samples; in contact "
            "the integration keeps the tolerance and lands on every event. A case without a run of its own has exactly "
            "the answer of another, such as the motion without contact."
        ),
    ]
    if "accuracy" in data.others:
        blocks += [heading("What accuracy costs", "accuracy-cost"), *sheet(data.others["accuracy"])]
    return blocks


def _again(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """Numbers of runs made again, and how far their results moved."""
    if "sensitive" not in results or not (results["sensitive"] >= 0).any():
        return [("recomputed at a tighter tolerance", "none")]
    flags = results["sensitive"]
    rows: list[tuple[str, Cell | str]] = [
        ("recomputed at a tighter tolerance", count((flags >= 0).sum())),
        ("of these sensitive: an answer moves by more than the tolerance", count((flags == 1).sum())),
    ]
    for name, words in MOVED.items():
        values = results[name].values
        values = values[np.isfinite(values)]
        if values.size:
            rows.append((f"{words} moved by, median", number(np.median(values), digits=2)))
            rows.append((f"{words} moved by, largest", number(values.max(), digits=2)))
    rows += [(f"runs whose {words} changed", count((results[name] > 0).sum())) for name, words in COUNTED.items()]
    return rows


def _residuals(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """Energy that contacts leave unaccounted for, over the runs of their own that touched."""
    if "energy_residual" not in results:
        return []
    has_contact = ((results["simulated"] == 1) & (results["impact_count"] > 0)).values
    values = results["energy_residual"].values[has_contact]
    values = values[np.isfinite(values)]
    if not values.size:
        return []
    words = "energy that a run's contacts leave unaccounted for, over the largest energy"
    return [
        (f"{words}, median", number(np.median(values), digits=2)),
        ("the same, largest", number(values.max(), digits=2)),
    ]


def _failed(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """Runs that did not complete, by what happened to them."""
    status = results["status"]
    codes = np.atleast_1d(status.attrs.get("flag_values", []))
    meanings = str(status.attrs.get("flag_meanings", "")).split()
    counts = [
        (f"failed: {slug.replace('_', ' ')}", int((status.values == code).sum()))
        for code, slug in zip(codes, meanings, strict=True)
        if code != 0
    ]
    failed: list[tuple[str, Cell | str]] = [(words, count(times)) for words, times in counts if times]
    return failed or [("failed", count(0))]
