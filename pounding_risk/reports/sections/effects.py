"""Section on effects: those that the scene names, and what each changes and costs by a dataset of `effects`."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk.render.sheet import Block, Cell, heading, listing, milliseconds, name_of, number, paragraph, table
from pounding_risk.reports.data import ReportData

if TYPE_CHECKING:
    import xarray as xr

TITLE = "Effects"
ORDER = 90
EFFECTS_FREE = "none"  # the scene without effects, in a dataset of `effects`


def write(data: ReportData) -> list[Block]:
    """The effects that the scene names, and what each changes and costs where a dataset of `effects` tells."""
    named = data.scene.get("effects", {})
    blocks: list[Block]
    if named:
        blocks = [listing(f"{name_of(name)}: {_options(options)}" for name, options in named.items())]
    else:
        blocks = [
            paragraph("The scene names no effects, and none was simulated: no dents, no strain rate, no passing wave.")
        ]
    if "effects" not in data.others:
        blocks.append(paragraph("What each effect would change and cost: `pounding-risk effects`, given with --with."))
        return blocks
    return blocks + _costs(data.others["effects"])


def _options(options: dict[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in options.items()) or "no options"


def _named(effects: str) -> str:
    """The effects of an attribute (JSON) with their options."""
    return "; ".join(f"{name_of(name)} ({_options(options)})" for name, options in json.loads(effects).items())


def _costs(dataset: xr.Dataset) -> list[Block]:
    heads = [
        ("effects", "l"),
        ("time of a run [ms]", "r"),
        ("over that without", "r"),
        ("median change of the peak displacement [%]", "r"),
    ]
    rows: list[list[Cell | str]] = []
    output = "peak_relative_displacement"
    yields = dataset["yield_exceedance"].sel(effects=EFFECTS_FREE).values == 1
    before = dataset[output].sel(effects=EFFECTS_FREE).values
    for name in map(str, dataset["effects"].values):
        of_effects = dataset.sel(effects=name)
        acted = (yields | bool(of_effects["acts_on_all"])) & (before > 0.0)
        change = (of_effects[output].values[acted] - before[acted]) / before[acted]
        change = change[np.isfinite(change)]
        change_words = number(np.median(change), "%", 3) if name != EFFECTS_FREE and change.size else number(np.nan)
        rows.append(
            [
                name_of(name),
                milliseconds(float(of_effects["time"])),
                number(of_effects["time_ratio"], digits=3),
                change_words,
            ]
        )
    return [
        heading("What they change and cost", "effects-cost"),
        paragraph(str(dataset.attrs["finding"])),
        paragraph(f"From `pounding-risk effects` of “{dataset.attrs['title']}”: {_named(dataset.attrs['effects'])}."),
        table("Processor time of a run, and the change in the cases that the effects act on.", heads, rows),
    ]
