"""Sheet of `effects`: what each effect changes in a scene, and its cost."""

from __future__ import annotations

import json
from typing import Any

import xarray as xr

from pounding_risk.lab.effects_findings import NONE, rows, yielding
from pounding_risk.questions.notes import of_keys
from pounding_risk.render.sheet import Block, Cell, computing_time, count, facts, head, middle, number, paragraph, table
from pounding_risk.units import MISSING, legible

ORDER = 80
FUNCTION = "lab.effects"
FIGURES = {"": "effects.effects_figure"}
UNIT = "scans"
OPTIONS = {"repeats": None}
HEADS = {
    "peak_relative_displacement": "displacement",
    "peak_contact_force": "force",
    "impact_count": "count",
    "impulse": "impulse",
    "peak_storey_shear": "shear",
    "peak_floor_acceleration": "acceleration",
}


def sheet(dataset: xr.Dataset) -> list[Block]:
    """The finding, time and changes of each combination of effects, and what the numbers are of."""
    status, left_out = dataset["status"], dataset.attrs["left_out"]
    pairs: list[tuple[str, Cell | str]] = [
        ("scene", dataset.attrs["title"]),
        ("cases", count(status.sel(effects=NONE).size)),
        ("of these yield", count(yielding(dataset))),
        ("failed runs", count((status != 0).sum())),
        *((name, options_words(options)) for name, options in json.loads(dataset.attrs["effects"]).items()),
        *([("excluded", left_out)] if left_out else []),
        *(("unused", words) for words in of_keys(dataset.attrs)),
    ]
    return [paragraph(dataset.attrs["finding"]), _changes(dataset), facts("", pairs)]


def options_words(options: dict[str, Any]) -> str:
    """The options of an effect."""
    return ", ".join(f"{key} {legible(option)}" for key, option in options.items()) or "no options"


def _changes(dataset: xr.Dataset) -> Block:
    heads = ["effects", "time a run", "ratio", "cases changed"]
    heads += [head(words, "%") for words in HEADS.values()]
    lines: list[list[Cell | str]] = []
    for name, changed, time, ratio, spread in rows(dataset):
        largest_set = number(dataset["permanent_set"].sel(effects=name).max(), "m", 3)
        changes = [middle(spread[output], "%") if any(spread[output]) else "none" for output in HEADS]
        changes = changes if name != NONE else [MISSING] * len(HEADS)
        lines.append([name, computing_time(time), number(ratio, digits=3), count(changed), *changes, largest_set])
    scope = ", of all cases where the ground or a building is changed" if dataset["acts_on_all"].any() else ""
    caption = (
        "Processor time of a run, and change against the scene without effects: median (smallest to largest) of the "
        f"cases that yield{scope}. ∞: nothing without effects."
    )
    return table(caption, [*heads, head("largest set", "m")], lines)
