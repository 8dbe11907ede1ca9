"""Sheet of `assess` along axes of other numbers of the scene: contact and required gap at every place."""

from __future__ import annotations

from itertools import product

import xarray as xr

from pounding_risk.assessment.along import along_finding, idle_words, kept_words, lost_words
from pounding_risk.assessment.options import NO_BOUND, NO_UPPER, PUSHED
from pounding_risk.questions.adequacy import GIVEN, enough, without_upper
from pounding_risk.render.sheet import KEPT, Block, Row, between, count, head, joined, number, paragraph, table
from pounding_risk.units import SHOWN

UNBOUNDED = {0.0: NO_UPPER, -1.0: PUSHED}  # marks by `required_gap_bounded`
NAMES = ("contact_probability", "required_gap")


def sheet(assessed: xr.Dataset) -> list[Block]:
    """Finding and table of what lies along the axes."""
    bounded = assessed["required_gap_bounded"].values
    motions = f"Motions {assessed.attrs['motions']}; `--select` of one value along each axis gives the whole assessment"
    return [
        paragraph("\n".join([assessed.attrs["title"], assessed.attrs["asked"], *findings(assessed)])),
        places(assessed),
        *(paragraph(f"{mark} {NO_BOUND[mark]}.") for code, mark in UNBOUNDED.items() if (bounded == code).any()),
        paragraph(f"{motions}, `-o` writes all places."),
    ]


def findings(assessed: xr.Dataset) -> list[str]:
    """Sentences on how far contact and the required gap change, where the target is kept, and on idle axes."""
    notes = filter(None, (lost_words(assessed), idle_words(assessed)))
    return [
        f"{along_finding(assessed)}.",
        f"{kept_words(assessed)}.",
        *(f"{words[0].upper()}{words[1:]}." for words in notes),
    ]


def places(assessed: xr.Dataset) -> Block:
    """Contact and the gap required at every place; those that need most stay in the text where they are many."""
    axes = [str(dim) for dim in assessed.dims if dim != "interface"]
    keys = [str(key) for key, coordinate in assessed.coords.items() if coordinate.dims[:1] != ("interface",)]
    is_row = assessed.sizes["interface"] > 1
    units = {key: str(assessed[key].attrs.get("units", "1")) for key in keys}
    shown = {key: unit if unit in SHOWN else "1" for key, unit in units.items()}
    heads = [head(key, units[key]) if units[key] in SHOWN else f"{key} [{units[key]}]" for key in keys]
    heads += ["neighbours"] if is_row else []
    heads += [head("gap", "m"), "P(contact) [%]", "bounds [%]", head("gap required", "m"), head("bounds", "m")]
    is_lost = bool(assessed["motions_without_response"].any())
    heads += ["without response"] if is_lost else []
    rows: list[Row] = []
    for place in product(*(range(assessed.sizes[dim]) for dim in (*axes, "interface"))):
        cell = assessed.isel(dict(zip((*axes, "interface"), place, strict=True)))
        share, need = ([float(cell[f"{name}{end}"]) for end in ("", "_low", "_high")] for name in NAMES)
        at = {key: cell[key].item() for key in keys}
        bounds = joined(number(need[1], "m"), enough(need[2]))
        if mark := UNBOUNDED.get(float(cell["required_gap_bounded"])):
            bounds = without_upper(bounds, mark)
        row: Row = [at[key] if isinstance(at[key], str) else number(at[key], shown[key], GIVEN) for key in keys]
        row += [str(cell["interface"].item())] if is_row else []
        row += [number(cell["assessed_gap"], "m", GIVEN), number(share[0], "%", 3), between(share[1], share[2], "%", 3)]
        row += [enough(need[0]), bounds]
        rows.append([*row, *([count(cell["motions_without_response"])] if is_lost else [])])
    needs = assessed["required_gap"].transpose(*axes, "interface").values.ravel()
    kept_rows = sorted(range(len(rows)), key=lambda at: -needs[at])[:KEPT]
    note = "those that need most"
    return table("Contact and gap required along the axes.", heads, rows, keep=sorted(kept_rows), note=note)
