"""Section on contact models: outputs of the scan by model, and the finding of a dataset of `compare`."""

from __future__ import annotations

from functools import partial

import numpy as np

from pounding_risk.assessment.sensitivity import force_words
from pounding_risk.figures.scan import draw_models
from pounding_risk.render import sheet
from pounding_risk.reports.data import Pair, ReportData
from pounding_risk.results.attributes import finite
from pounding_risk.units import SHOWN

TITLE = "Contact models compared"
ORDER = 70
# Outputs by which models are set side by side: what they are called, and their unit.
BY_MODEL = {
    "peak_relative_displacement": ("peak relative displacement", "m"),
    "peak_contact_force": ("peak contact force", "N"),
    "impact_count": ("contacts", "1"),
}


def write(data: ReportData) -> list[sheet.Block]:
    """Every contact model at the scene's gap: shares of contact and yielding, and the spread of three outputs."""
    blocks = [block for pair in data.pairs for block in _by_model(data, pair)]
    if len(data.laws) == 1 and "compare" not in data.others:
        mixed = "interface_contact_model" in data.results
        run = "Each interface has a contact model of its own" if mixed else "One contact model was run"
        blocks.append(sheet.paragraph(f"{run}. Whether another says otherwise: `pounding-risk compare`."))
    if "compare" in data.others:
        from pounding_risk.questions import compare  # with the scene's classes, which a report without needs not

        answer = data.others["compare"]
        source = sheet.paragraph(f"From `pounding-risk compare` of “{answer.attrs['title']}”.")
        blocks += [sheet.heading("On equal terms", "equal-terms"), source, *compare.sheet(answer)]
    return blocks


def _by_model(data: ReportData, pair: Pair) -> list[sheet.Block]:
    part = pair.results.sel(gap=pair.grid_gap, yield_force=pair.assessed.own_force)
    # A count of −1 is none: the run failed.
    touching = part["impact_count"] > 0
    place = f"at a gap of {sheet.amount(pair.grid_gap, 'm')['text']}, {force_words(pair.assessed.own_force)}{pair.at}"
    heads = ["contact model", "cases", "with contact", "reach F_E"]
    heads += [f"{sheet.head(words, unit)}: median (16 to 84 %)" for words, unit in BY_MODEL.values()]
    rows: list[sheet.Row] = []
    spreads: dict[str, list[tuple[float, float, float]]] = {output: [] for output in BY_MODEL}
    for law in data.laws:
        law_part, is_touched = part.sel(contact_model=law), touching.sel(contact_model=law).values
        complete = law_part["impact_count"].values >= 0
        cells: sheet.Row = [sheet.name_of(law), sheet.count(complete.sum()), sheet.count(is_touched.sum())]
        # An instant jump has no force that could reach F_E or not.
        reached = law_part["yield_exceedance"].values
        cells.append(sheet.count((reached == 1).sum()) if (reached >= 0).any() else sheet.number(np.nan))
        for output, (_, unit) in BY_MODEL.items():
            spreads[output].append(sheet.percentiles(finite(law_part, output).values[is_touched]))
            cells.append(sheet.middle(spreads[output][-1], unit))
        rows.append(cells)
    note = f"All motions {place}; the spread is over those with contact."
    blocks = [sheet.table(f"{pair.name}: outputs by contact model. {note}", heads, rows)]
    panels = {
        sheet.head(words, unit): SHOWN[unit][1] * np.array(spreads[output])
        for output, (words, unit) in BY_MODEL.items()
        if np.isfinite(spreads[output]).any()
    }
    if panels and len(rows) > 1:
        caption = f"{pair.name}: median and middle 68 % of {', '.join(panels)} under {len(rows)} contact models"
        drawing = partial(draw_models, list(map(sheet.name_of, data.laws)), panels)
        alt = f"{caption}, {place}; the table above has the numbers."
        blocks.append(sheet.figure(f"{pair.anchor}-models", drawing, f"{caption}, {place}.", alt))
    return blocks
