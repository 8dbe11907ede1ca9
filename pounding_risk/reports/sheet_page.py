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
    sections = [{"name": "answer", "title": "Answer", "blocks": [part for block in blocks for part in _by_line(block)]}]
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


def _by_line(block: Block) -> list[Block]:
    """A paragraph of several lines as one for each line; any other block alone."""
    if block["kind"] != "paragraph":
        return [block]
    return [paragraph(line) for line in block["text"].split("\n") if line]
