"""Section on uncertain numbers: what a dataset of `uncertainty` says of them, beside the scan of the stated ones."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.assessment.uncertain_words import OUTPUT_WORDS, gap_scatter, indices_words, parts_words
from pounding_risk.figures.style import svg_text
from pounding_risk.figures.uncertainty import uncertainty_figure
from pounding_risk.render.sheet import Block, between, figure, heading, listing, number, paragraph, table
from pounding_risk.reports.data import ReportData

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Uncertain numbers"
ORDER = 48


def write(data: ReportData) -> list[Block]:
    """What the samples say of every interface; nothing without a dataset of `uncertainty`."""
    if "uncertainty" not in data.others:
        return []
    dataset = data.others["uncertainty"]
    intro = f"Samples: {dataset.attrs['samples']}. Motions: {dataset.attrs['motions']}. {dataset.attrs['asked']}"
    blocks = [paragraph(intro)]
    for place, name in enumerate(dataset["interface"].values.tolist()):
        part = dataset.isel(interface=place)
        if dataset.sizes["interface"] > 1:
            blocks.append(heading(str(name), f"uncertain-{place + 1}"))
        blocks += [paragraph(f"{part['sentence'].item()} {parts_words(part)} {part['narrowing'].item()}")]
        blocks += [_required(part), _parts(part), _indices(part)]
        blocks += [paragraph(shares)] if (shares := indices_words(part)) else []
    words = "P(contact) over samples and motions with its bounds, and what the uncertain numbers contribute"
    blocks.append(figure("uncertainty", svg_text(uncertainty_figure(dataset)), f"{words}.", f"{words}."))
    return [*blocks, listing(json.loads(dataset.attrs["assumptions"]))]


def _required(part: xr.Dataset) -> Block:
    rows = []
    for percentile in part["percentile"].values:
        one = part.sel(percentile=percentile)
        low, high = float(one["required_gap_low"]), float(one["required_gap_high"])
        bounded = "bounds" if int(one["required_gap_bounded"]) else "the upper one is the largest seen"
        rows.append((f"{percentile:g} %", number(float(one["required_gap"]), "m"), between(low, high, "m"), bounded))
    heads = [("share", "l"), ("gap required", "r"), ("bounds", "r"), ("", "l")]
    nominal = "Nominal gap, to which its scatter adds," if gap_scatter(part) > 0.0 else "Gap"
    return table(f"{nominal} that a share of samples and motions together needs", heads, rows)


def _parts(part: xr.Dataset) -> Block:
    unit = str(part["dispersion"].attrs["units"])
    rows: list[tuple[Any, ...]] = []
    for name in part["component"].values:
        one = part.sel(component=name)
        low, high = float(one["dispersion_low"]), float(one["dispersion_high"])
        share = 100.0 * float(one["variance_share"])
        rows.append(
            (str(name), number(share, "1", 2), number(float(one["dispersion"]), unit), between(low, high, unit))
        )
    heads = [("part", "l"), ("share of the variance [%]", "r"), ("deviation", "r"), ("bounds", "r")]
    return table("What the closing without contact differs by (of its logarithm)", heads, rows)


def _indices(part: xr.Dataset) -> Block:
    output = str(part["chosen_output"].item())
    one = part.sel(output=output)
    kinds = [("first_order", "first-order share [%]")]
    kinds += [("total_order", "total share [%]")] if "total_order" in part else []
    rows: list[Any] = []
    for place in np.argsort(-np.nan_to_num(one["first_order"].values, nan=-1.0)).tolist():
        here = one.isel(uncertain_number=place)
        cells: list[Any] = [str(here["uncertain_number"].item())]
        for kind, _ in kinds:
            value, low, high = (100.0 * float(here[f"{kind}{end}"]) for end in ("", "_low", "_high"))
            cells += [number(value, "1", 2), between(low, high, "1", 2)]
        rows.append(cells)
    if "first_order_of_motions" in one:
        value, low, high = (100.0 * float(one[f"first_order_of_motions{end}"]) for end in ("", "_low", "_high"))
        rows.append(("the motion", number(value, "1", 2), between(low, high, "1", 2)))
    heads = [("number", "l"), *((words, "r") for _, head in kinds for words in (head, "bounds"))]
    said = OUTPUT_WORDS.get(output, output.replace("_", " "))
    return table(f"Shares of the numbers in the variance of {said} over the samples", heads, rows)
