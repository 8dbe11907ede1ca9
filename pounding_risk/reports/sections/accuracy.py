"""Section on accuracy: tolerance, recomputed runs, energy left over, failed runs, and a dataset of `accuracy`."""

from __future__ import annotations

import numpy as np
import xarray as xr

from pounding_risk.questions.accuracy import sheet
from pounding_risk.render.sheet import Block, Cell, count, facts, heading, number, paragraph
from pounding_risk.reports.data import ReportData
from pounding_risk.results.summary import failures
from pounding_risk.results.tolerance_check import COUNTED, RELATIVE, WORDS
from pounding_risk.results.variables import NOT_RUN, UNPUSHED

TITLE = "How exact the numbers are"
ORDER = 80


def write(data: ReportData) -> list[Block]:
    """The tolerance, the recomputed runs and how far they moved, energy left over, and runs that failed."""
    results = data.results
    simulated = int((results["simulated"] == 1).sum())
    total, unpushed = results["status"].size, int((results["status"] == UNPUSHED).sum())
    rows: list[tuple[str, Cell | str]] = [
        ("relative tolerance of the solver", number(results.attrs["rtol"])),
        ("cases", count(total)),
        ("with a run of their own", count(simulated)),
        ("known exactly without one", count(total - simulated - unpushed)),
        *([(NOT_RUN, count(unpushed))] if unpushed else []),
        *_recomputed(results),
    ]
    # Energy that contacts leave unaccounted for, over the runs of their own that touched.
    if "energy_residual" in results:
        has_contact = ((results["simulated"] == 1) & (results["impact_count"] > 0)).values
        residuals = results["energy_residual"].values[has_contact]
        if (residuals := residuals[np.isfinite(residuals)]).size:
            words = "energy that a run's contacts leave unaccounted for, over the largest energy, median"
            rows.append((words, number(np.median(residuals), digits=2)))
            rows.append(("the same, largest", number(residuals.max(), digits=2)))
    failed = [(f"failed: {why}", count(times)) for why, times in failures(results).items()]
    blocks = [
        facts("Tolerance, recomputed runs, energy and failures.", [*rows, *(failed or [("failed", count(0))])]),
        paragraph(
            "Between contacts the motion is exact for a ground acceleration that is linear between samples; in contact "
            "the integration keeps the tolerance and lands on every event. A case without a run of its own has exactly "
            "the answer of another, such as the motion without contact."
        ),
    ]
    if "accuracy" in data.others:
        blocks += [heading("What accuracy costs", "accuracy-cost"), *sheet(data.others["accuracy"])]
    return blocks


def _recomputed(results: xr.Dataset) -> list[tuple[str, Cell | str]]:
    """Numbers of runs recomputed, and how far their results moved."""
    words = "recomputed at a tighter tolerance"
    if "sensitive" not in results or not (results["sensitive"] >= 0).any():
        return [(words, "none")]
    flags = results["sensitive"]
    rows: list[tuple[str, Cell | str]] = [
        (words, count((flags >= 0).sum())),
        ("of these sensitive: an answer moves by more than the tolerance", count((flags == 1).sum())),
    ]
    for name in RELATIVE:
        changes = results[f"change_{name}"].values
        changes = changes[np.isfinite(changes)]
        if changes.size:
            rows.append((f"{WORDS[name]} moved by, median", number(np.median(changes), digits=2)))
            rows.append((f"{WORDS[name]} moved by, largest", number(changes.max(), digits=2)))
    rows += [(f"runs whose {WORDS[name]} changed", count((results[f"change_{name}"] > 0).sum())) for name in COUNTED]
    return rows
