"""Section on the response: peaks of the buildings with contact beside those without, over the motions that bring it."""

from __future__ import annotations

from itertools import product

import numpy as np

from pounding_risk.assessment.sensitivity import force_words
from pounding_risk.questions.adequacy import response
from pounding_risk.render import sheet
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.results.attributes import isolated_of, of_isolators, of_storeys, of_structure

TITLE = "What contact does to the buildings"
ORDER = 60

# Outputs of each building, stored with a twin without contact: what they are called, their unit, and of what they are.
OUTPUTS = (
    ("peak_displacement", "peak displacement", "m", of_structure),
    ("peak_drift", "peak storey drift", "m", of_structure),
    ("storey_drift", "largest displacement of the isolators", "m", of_isolators),
    ("storey_ductility", "largest storey ductility", "1", of_storeys),
    ("storey_residual_drift", "largest residual storey drift", "m", of_storeys),
    ("peak_storey_shear", "peak storey shear", "N", of_structure),
    ("peak_floor_acceleration", "peak floor acceleration", "m/s2", of_structure),
)
OF_SOME = {of_isolators, of_storeys}  # of buildings with isolators, or with storeys that may yield


def write(data: ReportData) -> list[sheet.Block]:
    """Two tables for each interface, at its gap, under the scene's contact model."""
    return [block for pair in data.pairs for block in (*_buildings(data, pair), *response(pair.assessed))]


def _buildings(data: ReportData, pair: Pair) -> list[sheet.Block]:
    case = {"gap": pair.grid_gap, "yield_force": pair.assessed.own_force, "contact_model": data.law}
    part = pair.results.sel(case)
    touching = (part["impact_count"] > 0).transpose("record", "polarity").values
    columns_yield = any(share.yield_force == np.inf for share in pair.assessed.yielding)
    law = f"{sheet.name_of(data.law)}, {force_words(pair.assessed.own_force, columns_yield)}"
    place = f"at a gap of {sheet.amount(pair.grid_gap, 'm')['text']}{pair.at}, under {law}"
    if not touching.any():
        return [
            sheet.paragraph(f"{pair.name}: no motion brings contact {place}; the buildings move as without contact.")
        ]
    rows: list[sheet.Row] = []
    isolated = isolated_of(part)
    for building, (output, words, unit, read) in product(map(str, pair.results["building"].values), OUTPUTS):
        if output not in part:
            continue
        if building in isolated and (output == "peak_drift" or read is of_storeys):
            words += " above the isolators"
        both = (read(pair.results, f"{output}_free"), read(part, output))
        free, struck = (one.sel(building=building).transpose("record", "polarity").values[touching] for one in both)
        is_known = np.isfinite(free) & np.isfinite(struck)
        free, struck = free[is_known], struck[is_known]
        if not free.size and read in OF_SOME:
            continue
        if not free.size:
            rows.append([building, words, *[sheet.number(np.nan)] * 4, sheet.MISSING])
            continue
        ratio = np.divide(struck, free, out=np.full(free.shape, np.nan), where=free > 0.0)
        all_values = ((free, unit), (struck, unit), (ratio, "1"))
        spreads = [sheet.middle(sheet.percentiles(values), size) for values, size in all_values]
        raised = sheet.count((struck > free).sum())
        rows.append([building, sheet.head(words, unit), *spreads, raised, sheet.count(free.size)])
    heads = ["building", "output", "without contact: median (16 to 84 %)", "with contact: median (16 to 84 %)"]
    heads += ["with over without: median (16 to 84 %)", "raised in", "motions"]
    return [sheet.table(f"{pair.name}: peaks of the buildings in the motions with contact, {place}.", heads, rows)]
