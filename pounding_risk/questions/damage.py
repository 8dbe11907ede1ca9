"""Sheet of `damage`: fragilities of damage states with pounding and without, and what pounding changes."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

from pounding_risk.assessment.damage_words import POUNDING, case_words, damage_table, finding, measure_words
from pounding_risk.questions._declaration import text_file
from pounding_risk.render.sheet import Block, Cell, between, count, figure, head, listing, number, paragraph, table

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

ORDER = 137
FUNCTION = "assessment.damage"
FIGURES = {"": "damage.damage_figure", "ida": "damage.ida_figure"}
FILES = {"out": text_file("", ".csv", lambda dataset: damage_table(dataset))}
Row = list[Cell | str]


def sheet(dataset: xr.Dataset) -> list[Block]:
    """Curves, ratios, annual rates, probabilities in an event, and notes.

    Parameters
    ----------
    dataset : xarray.Dataset
        An answer of `damage`.

    Returns
    -------
    list of Block
        Without rates where the answer is without a hazard, and without an event where it has no fields.
    """
    case = case_words(dataset)
    caption = f"Fragility of each damage state with pounding and without, and the ratio; {case}"
    return [
        paragraph(f"{finding(dataset)}."),
        figure("damage", lambda: _figure(dataset), f"{caption}.", f"{finding(dataset)}."),
        _curves(dataset, case),
        _ratios(dataset),
        *([_rates(dataset)] if "annual_rate" in dataset else []),
        *([_events(dataset)] if "event_probability" in dataset else []),
        listing(json.loads(dataset.attrs["told"])),
    ]


def _figure(dataset: xr.Dataset) -> Figure:
    from pounding_risk.figures.damage import damage_figure

    return damage_figure(dataset)


def _curves(dataset: xr.Dataset, case: str) -> Block:
    measure, unit = measure_words(dataset)
    heads = ["state", "reached at", "pounding", "reached in", "of", head(f"median {measure}", unit), "dispersion"]
    heads += ["s.e. of ln median", "s.e. of dispersion"]
    rows: list[Row] = []
    for state in dataset["state"].values:
        for side in POUNDING:
            one = dataset.sel(state=state, pounding=side)
            row: Row = [str(state), str(one["state_words"].item()), side]
            row += [count(one["reached"].sum()), count(one["runs"].sum()), number(one["median"], unit, 3)]
            row += [number(one[name], digits=3) for name in ("dispersion", "median_error", "dispersion_error")]
            rows.append(row)
    return table(f"Fragilities of the damage states; {case}.", heads, rows)


def _ratios(dataset: xr.Dataset) -> Block:
    _, unit = measure_words(dataset)
    heads = ["state", "median, with over without", "bounds", head("at", unit), "P without", "P with", "ratio of P"]
    heads += ["bounds"]
    rows: list[Row] = []
    for state in dataset["state"].values:
        one = dataset.sel(state=state)
        row: Row = [str(state), *_bounded(one, "median_ratio"), number(one["at_intensity"], unit, 3)]
        row += [number(one["probability_at"].sel(pounding=side), digits=3) for side in ("without", "with")]
        rows.append([*row, *_bounded(one, "probability_ratio_at")])
    return table("What pounding changes: medians, and probabilities at one intensity.", heads, rows)


def _rates(dataset: xr.Dataset) -> Block:
    heads = ["state", "with", "bounds", "without", "bounds", "ratio", "bounds", head("share beyond the curve", "%")]
    rows: list[Row] = []
    for state in dataset["state"].values:
        one = dataset.sel(state=state)
        sides = [one.sel(pounding=side) for side in ("with", "without")]
        row: Row = [str(state), *(cell for side in sides for cell in _bounded(side, "annual_rate"))]
        missing = max(float(side["annual_rate_missing"]) for side in sides)
        rows.append([*row, *_bounded(one, "annual_rate_ratio"), number(missing, "%", 2)])
    caption = (
        "Annual rates with pounding and without. Share beyond the curve: what part of the rate lies beyond the ends "
        "of the hazard curve, were it continued at the slope of its last rows."
    )
    return table(caption, heads, rows)


def _events(dataset: xr.Dataset) -> Block:
    heads = ["state", "with", "bounds", "without", "bounds"]
    rows: list[Row] = []
    for state in dataset["state"].values:
        sides = [dataset.sel(state=state, pounding=side) for side in ("with", "without")]
        rows.append([str(state), *(cell for side in sides for cell in _bounded(side, "event_probability"))])
    return table("Probability in an event, with pounding and without.", heads, rows)


def _bounded(one: xr.Dataset, name: str) -> list[Cell]:
    """A number and its bounds."""
    low, high = (float(one[f"{name}_{end}"]) for end in ("low", "high"))
    return [number(one[name], digits=3), between(low, high, "1", 2)]
