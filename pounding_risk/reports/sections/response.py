"""Section on the response: peaks of the buildings with contact beside those without, over the motions that bring it."""

from __future__ import annotations

from typing import Any

import numpy as np

from pounding_risk.assessment.sensitivity import force_words
from pounding_risk.questions.adequacy import response
from pounding_risk.render.sheet import (
    MISSING,
    Block,
    Cell,
    amount,
    count,
    head,
    middle,
    name_of,
    number,
    paragraph,
    percentiles,
    table,
)
from pounding_risk.reports.data import Pair, ReportData

TITLE = "What contact does to the buildings"
ORDER = 60

# Outputs per building, each stored with a twin without contact: what they are called, and their unit.
OUTPUTS = {
    "peak_displacement": ("peak displacement", "m"),
    "peak_drift": ("peak storey drift", "m"),
    "peak_storey_shear": ("peak storey shear", "N"),
    "peak_floor_acceleration": ("peak floor acceleration", "m/s2"),
}


def write(data: ReportData) -> list[Block]:
    """Two tables for each interface, at its gap, under the scene's contact model."""
    blocks: list[Block] = []
    for pair in data.pairs:
        blocks += [*_buildings(data, pair), *response(pair.assessed)]
    return blocks


def _buildings(data: ReportData, pair: Pair) -> list[Block]:
    case = {"gap": pair.grid_gap, "yield_force": data.yield_force, "contact_model": data.law}
    here = pair.results.sel(case)
    touching = (here["impact_count"] > 0).transpose("record", "polarity").values
    columns_yield = any(share.yield_force == np.inf for share in pair.assessed.yielding)
    law = f"{name_of(data.law)}, {force_words(data.yield_force, columns_yield)}"
    where = f"at a gap of {amount(pair.grid_gap, 'm')['text']}{pair.at}, under {law}"
    if not touching.any():
        return [paragraph(f"{pair.name}: no motion brings contact {where}; the buildings move as if alone.")]
    rows = [
        _row(pair, str(building), output, touching, here)
        for building in pair.results["building"].values
        for output in OUTPUTS
        if output in here
    ]
    heads = [("building", "l"), ("output", "l"), ("without contact: median (16 to 84 %)", "r")]
    heads += [("with contact: median (16 to 84 %)", "r"), ("with over without: median (16 to 84 %)", "r")]
    heads += [("raised in", "r"), ("motions", "r")]
    return [table(f"{pair.name}: peaks of the buildings in the motions with contact, {where}.", heads, rows)]


def _row(pair: Pair, building: str, output: str, touching: Any, here: Any) -> list[Cell | str]:
    words, unit = OUTPUTS[output]
    both = [
        values.sel(building=building).transpose("record", "polarity").values[touching]
        for values in (pair.results[f"{output}_free"], here[output])
    ]
    is_known = np.isfinite(both[0]) & np.isfinite(both[1])
    free, with_contact = both[0][is_known], both[1][is_known]
    ratio = np.divide(with_contact, free, out=np.full(free.shape, np.nan), where=free > 0.0)
    raised = count((with_contact > free).sum()) if free.size else number(np.nan)
    spreads = [middle(percentiles(values), unit) for values in (free, with_contact)]
    label = head(words, unit) if free.size else words
    return [
        building,
        label,
        *spreads,
        middle(percentiles(ratio), "1"),
        raised,
        count(free.size) if free.size else MISSING,
    ]
