"""A sheet as a page of its own (HTML)."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from pounding_risk import __version__
from pounding_risk.render.sheet import Block, paragraph
from pounding_risk.reports.document import number_blocks
from pounding_risk.reports.html import page, write_page


def write_sheet_page(target: Path, title: str, blocks: Iterable[Block]) -> Path:
    """Write the blocks of a sheet, with their figures, as one HTML file.

    Parameters
    ----------
    target : Path
        The file.
    title : str
        Title of the page.
    blocks : iterable of Block
        The sheet.

    Returns
    -------
    Path
        The file.
    """
    parts: list[Block] = []  # a paragraph of several lines is one for each line
    for block in blocks:
        is_text = block["kind"] == "paragraph"
        parts += [paragraph(line) for line in block["text"].split("\n") if line] if is_text else [block]
    sections = [{"name": "answer", "title": "Answer", "blocks": parts}]
    number_blocks(sections)
    return write_page(
        target,
        page(
            {
                "title": title.rstrip("."),
                "about": "Seismic pounding of adjacent buildings",
                "signature": [],
                "author": "",
                "program": f"pounding_risk {__version__}",
                "sections": sections,
            }
        ),
    )
