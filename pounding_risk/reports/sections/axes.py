"""Section on the axes of numbers of the scene: contact and the gap required along them, and what the rest is of."""

from __future__ import annotations

from itertools import product
from typing import Any

from pounding_risk.assessment.along import along_finding, idle_words
from pounding_risk.figures.along import along_caption, along_figure
from pounding_risk.figures.style import svg_text
from pounding_risk.render.sheet import KEPT, Block, between, figure, head, number, paragraph, table
from pounding_risk.reports.data import ReportData
from pounding_risk.units import SHOWN

TITLE = "Along the axes of the scene"
ORDER = 5
NAMES = ("contact_probability", "required_gap")


def write(data: ReportData) -> list[Block]:
    """Finding, figure and table; nothing where the dataset has one place along every axis."""
    if data.along is None:
        return []
    assessed, place = data.along
    idle = idle_words(assessed)
    sentences = [
        f"{along_finding(assessed)}.",
        *([f"{idle[0].upper()}{idle[1:]}."] if idle else []),
        f"The other sections are of one place, {place.words}: {place.why}.",
    ]
    return [
        paragraph(" ".join(sentences)),
        figure(
            "along-axes",
            svg_text(along_figure(assessed, titled=False)),
            f"{along_caption(assessed)}.",
            f"P(contact) and the gap required along the axes. {along_finding(assessed)}. The table has the numbers.",
        ),
        _table(assessed),
    ]


def _table(assessed: Any) -> Block:
    """Contact and the gap required at every place; those that need most stay in the text where they are many."""
    axes = [str(dim) for dim in assessed.dims if dim != "interface"]
    keys = [str(key) for key, coordinate in assessed.coords.items() if coordinate.dims[:1] != ("interface",)]
    several = assessed.sizes["interface"] > 1
    units = {key: str(assessed[key].attrs.get("units", "1")) for key in keys}
    heads = [(head(key, units[key]) if units[key] in SHOWN else f"{key} [{units[key]}]", "r") for key in keys]
    heads += [("neighbours", "l")] if several else []
    heads += [(head("gap", "m"), "r"), ("P(contact) [%]", "r"), ("bounds [%]", "r")]
    heads += [(head("gap required", "m"), "r"), (head("bounds", "m"), "r")]
    rows: list[list[Any]] = []
    for places in product(*(range(assessed.sizes[dim]) for dim in (*axes, "interface"))):
        cell = assessed.isel(dict(zip((*axes, "interface"), places, strict=True)))
        share, need = ([float(cell[f"{name}{end}"]) for end in ("", "_low", "_high")] for name in NAMES)
        rows.append(
            [
                *(_value(cell[key].item(), units[key]) for key in keys),
                *([str(cell["interface"].item())] if several else []),
                number(cell["assessed_gap"], "m"),
                number(share[0], "%", 3),
                between(share[1], share[2], "%", 3),
                number(need[0], "m"),
                between(need[1], need[2], "m"),
            ]
        )
    most = sorted(range(len(rows)), key=lambda at: -rows[at][-2]["raw"])[:KEPT]
    return table(
        "Contact and gap required along the axes.", heads, rows, keep=sorted(most), note="those that need most"
    )


def _value(value: Any, unit: str) -> Any:
    """Cell of a value along an axis."""
    return value if isinstance(value, str) else number(value, unit if unit in SHOWN else "1")
