"""The document of a report: sections of blocks, numbered, with an appendix of whole tables.

Sections are the modules of the folder `sections`. Each has ``TITLE``, ``ORDER``, which is its place in the report, and
``write``, which makes blocks from a `ReportData`; those that show one other answer are rows of `sections/answers.py`. A
section without blocks is left out. Tables longer than `LONG` rows keep some rows in the text and stand whole in the
appendix.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from importlib import import_module
from pkgutil import iter_modules
from typing import Any, NamedTuple

from pounding_risk import __version__
from pounding_risk.figures.style import svg_text
from pounding_risk.render.sheet import LONG, Block, paragraph
from pounding_risk.reports import sections as folder
from pounding_risk.reports.data import NOT_SIGNED, ReportData, Signature
from pounding_risk.reports.sections import answers

Document = dict[str, Any]
APPENDIX = "Whole tables"


class Section(NamedTuple):
    """A section of a report: its title, and the function that makes its blocks."""

    title: str
    write: Callable[[ReportData], list[Block]]


def find_sections() -> dict[str, Section]:
    """The sections of the folder by name, in their order."""
    rows = list(answers.ROWS)
    for name in (found.name for found in iter_modules(folder.__path__)):
        module = import_module(f"{folder.__name__}.{name}")
        if module is not answers:
            rows.append((name, module.ORDER, module.TITLE, module.write))
    return {name: Section(title, write) for name, _, title, write in sorted(rows, key=lambda row: row[1])}


SECTIONS = find_sections()


def document_of(
    title: str,
    about: str,
    sections: Iterable[tuple[str, str, list[Block]]],
    signature: Signature = NOT_SIGNED,
    **more: str,
) -> Document:
    """A document as dictionaries that JSON holds, of sections: name, title and blocks of each, numbered.

    Those without blocks are left out.
    """
    filled = [{"name": name, "title": words, "blocks": blocks} for name, words, blocks in sections if blocks]
    number_blocks(filled)
    head = {"title": title, "about": about, "signature": signature.lines, "author": signature.author}
    return {**head, "program": f"pounding_risk {__version__}", "sections": filled, **more}


def build(data: ReportData) -> Document:
    """The document of a report: its sections, and an appendix of whole tables."""
    sections = [(name, title, write(data)) for name, (title, write) in SECTIONS.items()]
    full_tables = _shortened([block for *_, blocks in sections for block in blocks])
    if full_tables:
        explained = paragraph("Tables of which the text above shows some rows.")
        sections.append(("appendix", APPENDIX, [explained, *full_tables]))
    title = str(data.results.attrs.get("title") or "Pounding of adjacent buildings")
    about = "Seismic pounding of adjacent buildings: assessment of the gap"
    return document_of(title, about, sections, data.signature)


def _shortened(blocks: Iterable[Block]) -> list[Block]:
    """Cut long tables to the rows that stay in the text, in place; returns the whole ones in order."""
    full_tables: list[Block] = []
    for block in blocks:
        # A table of which the text would have more than half stands there whole.
        if block["kind"] != "table" or len(block["rows"]) <= max(LONG, 2 * len(block["keep"])):
            continue
        anchor = f"whole-{len(full_tables) + 1}"
        full_tables.append({**block, "anchor": anchor, "whole": True})
        note = f": {block['note']}" if block["note"] else ""
        rows = f"{len(block['keep'])} of {len(block['rows'])} rows{note}; all stand under {APPENDIX}."
        block["more"] = {"anchor": anchor, "text": rows}
        block["rows"] = [block["rows"][index] for index in block["keep"]]
    return full_tables


def number_blocks(sections: list[dict[str, Any]]) -> None:
    """Number sections, tables and figures in the order in which they stand; figures are drawn."""
    counts = {"table": 0, "figure": 0}
    for number, section in enumerate(sections, start=1):
        section["number"] = number
        for block in section["blocks"]:
            if block["kind"] in counts:
                counts[block["kind"]] += 1
                block["number"] = counts[block["kind"]]
            if block["kind"] == "figure" and callable(block["svg"]):
                block["svg"] = svg_text(block["svg"]())
