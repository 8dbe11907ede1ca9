"""Section on damage: fragilities of the scene's damage states with pounding and without."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from pounding_risk.assessment.damage_words import POUNDING, case_words, finding
from pounding_risk.errors import PoundingError
from pounding_risk.figures.damage import damage_figure
from pounding_risk.figures.style import svg_text
from pounding_risk.render.sheet import Block, Cell, between, count, figure, head, listing, number, paragraph, table
from pounding_risk.reports.data import ReportData
from pounding_risk.results.amplitudes import intensity_unit, intensity_words

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Damage"
ORDER = 65


def write(data: ReportData) -> list[Block]:
    """Curves, ratios and what is told of each state; none where the scene has no states."""
    if "damage" not in data.scene:
        return []
    from pounding_risk.assessment.damage import (
        damage,  # with the reader of states, which a report without them needs not
    )

    try:
        dataset = damage(data.results, intensity=data.assessment.intensity, confidence=data.assessment.confidence)
    except PoundingError as error:
        return [paragraph(f"The damage states of the scene have no fragilities: {error}.")]
    caption = f"Fragility of each damage state with pounding and without, and the ratio; {case_words(dataset)}"
    return [
        paragraph(f"{finding(dataset)}."),
        figure("damage", svg_text(damage_figure(dataset)), f"{caption}.", f"{finding(dataset)}."),
        _curves(dataset),
        _ratios(dataset),
        listing(json.loads(dataset.attrs["told"])),
    ]


def _curves(dataset: xr.Dataset) -> Block:
    intensity = str(dataset.attrs["intensity"])
    unit = intensity_unit(intensity)
    heads = [("state", "l"), ("reached at", "l"), ("pounding", "l"), ("runs that reach it", "r"), ("of", "r")]
    heads += [(head(f"median {intensity_words(intensity)}", unit), "r"), ("dispersion", "r")]
    heads += [("s.e. of ln median", "r"), ("s.e. of dispersion", "r")]
    rows: list[list[Cell | str]] = []
    for state in dataset["state"].values:
        for side in POUNDING:
            one = dataset.sel(state=state, pounding=side)
            row: list[Cell | str] = [str(state), str(one["state_words"].item()), side]
            row += [count(one["reached"].sum()), count(one["runs"].sum()), number(one["median"], unit, 3)]
            row += [number(one[name], digits=3) for name in ("dispersion", "median_error", "dispersion_error")]
            rows.append(row)
    return table("Fragilities of the damage states.", heads, rows)


def _ratios(dataset: xr.Dataset) -> Block:
    unit = intensity_unit(str(dataset.attrs["intensity"]))
    heads = [("state", "l"), ("median, with over without", "r"), ("bounds", "r"), (head("at", unit), "r")]
    heads += [("P without", "r"), ("P with", "r"), ("ratio of P", "r"), ("bounds", "r")]
    rows: list[list[Cell | str]] = []
    for state in dataset["state"].values:
        one = dataset.sel(state=state)
        row: list[Cell | str] = [str(state), number(one["median_ratio"], digits=3), _bounds(one, "median_ratio")]
        row.append(number(one["at_intensity"], unit, 3))
        row += [number(one["probability_at"].sel(pounding=side), digits=3) for side in ("without", "with")]
        row += [number(one["probability_ratio_at"], digits=3), _bounds(one, "probability_ratio_at")]
        rows.append(row)
    return table("What pounding changes: medians, and probabilities at the median without pounding.", heads, rows)


def _bounds(one: xr.Dataset, name: str) -> Cell:
    return between(float(one[f"{name}_low"]), float(one[f"{name}_high"]), "1", 3)
