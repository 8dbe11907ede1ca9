"""The one model of a report: sections by name, each a function from the material to blocks; pages and PDF print it.

A new section is one function and one entry in `SECTIONS`. A section without blocks is left out. Tables longer than
`LONG` rows keep their telling rows in the text and stand whole in the appendix.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, NamedTuple

from pounding_risk import __version__
from pounding_risk.reports.blocks import LONG, Block, paragraph
from pounding_risk.reports.material import Material
from pounding_risk.reports.sections import adequacy, response, row, scene, summary
from pounding_risk.reports.sections import models as outcomes
from pounding_risk.reports.sections import references as origins

Model = dict[str, Any]
APPENDIX = "Whole tables"


class Section(NamedTuple):
    """One part of a report: its title and what writes it."""

    title: str
    write: Callable[[Material], list[Block]]


SECTIONS: dict[str, Section] = {
    "summary": Section("Summary", summary.summary),
    "scene": Section("Scene and assumptions", scene.scene),
    "records": Section("Records", scene.records),
    "adequacy": Section("Is the gap enough?", adequacy.adequacy),
    "row": Section("The row", row.row),
    "response": Section("What contact does to the buildings", response.response),
    "models": Section("Contact models compared", outcomes.models),
    "accuracy": Section("How exact the numbers are", outcomes.accuracy),
    "effects": Section("Effects", outcomes.effects),
    "references": Section("References", origins.references),
    "provenance": Section("Provenance", origins.provenance),
}


def build(material: Material) -> Model:
    """Title, and sections of blocks; JSON-able."""
    sections: list[dict[str, Any]] = []
    for name, (title, write) in SECTIONS.items():
        blocks = write(material)
        if blocks:
            sections.append({"name": name, "title": title, "blocks": blocks})
    whole = _shortened(sections)
    if whole:
        said = paragraph("Tables of which the text above shows some rows.")
        sections.append({"name": "appendix", "title": APPENDIX, "blocks": [said, *whole]})
    _number(sections)
    return {
        "title": str(material.results.attrs.get("title") or "Pounding of adjacent buildings"),
        "about": "Seismic pounding of adjacent buildings: assessment of the gap",
        "signature": material.signature.lines,
        "author": material.signature.author,
        "program": f"pounding_risk {__version__}",
        "sections": sections,
    }


def _shortened(sections: list[dict[str, Any]]) -> list[Block]:
    """Long tables cut to the rows that are kept, in place; the whole ones, in order, are returned."""
    whole: list[Block] = []
    for section in sections:
        for block in section["blocks"]:
            if block["kind"] != "table" or len(block["rows"]) <= LONG:
                continue
            anchor = f"whole-{len(whole) + 1}"
            whole.append({**block, "anchor": anchor, "whole": True})
            which = f": {block['note']}" if block["note"] else ""
            block["more"] = {
                "anchor": anchor,
                "text": f"{len(block['keep'])} of {len(block['rows'])} rows{which}; all stand in the appendix.",
            }
            block["rows"] = [block["rows"][place] for place in block["keep"]]
    return whole


def _number(sections: list[dict[str, Any]]) -> None:
    """Sections, tables and figures by number, in the order in which they stand."""
    counts = {"table": 0, "figure": 0}
    for place, section in enumerate(sections, start=1):
        section["number"] = place
        for block in section["blocks"]:
            if block["kind"] in counts:
                counts[block["kind"]] += 1
                block["number"] = counts[block["kind"]]
