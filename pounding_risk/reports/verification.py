"""The page of published cases: every value beside ours, the figures, and each case with its source."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from pounding_risk import __version__
from pounding_risk.questions.verify import sections_of
from pounding_risk.reports import SUFFIXES
from pounding_risk.reports.document import Document, number_blocks
from pounding_risk.reports.html import page, write_page
from pounding_risk.results.files import check_target

if TYPE_CHECKING:
    from pounding_risk.lab.verification import Verification


def verification_page(outcome: Verification, out: str | Path) -> Path:
    """Write the page of published cases, as one HTML file or as PDF by the suffix of ``out``.

    Parameters
    ----------
    outcome : Verification
        As `verify` gives it.
    out : str or Path
        The page, .html or .pdf.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    PoundingError
        For a target that cannot be written, and for a PDF without the extra ``pdf``.
    """
    target = check_target(out, SUFFIXES)
    model = build(outcome)
    if target.suffix.lower() == ".pdf":
        from pounding_risk.reports.pdf import document

        return write_page(target, document(model))
    return write_page(target, page(model))


def build(outcome: Verification) -> Document:
    """The document of the page, as dictionaries that JSON holds."""
    parts = sections_of(outcome)
    sections = [{"name": name, "title": title, "blocks": blocks} for name, title, blocks in parts if blocks]
    number_blocks(sections)
    return {
        "title": "Verification of published cases",
        "about": "Seismic pounding of adjacent buildings: published values beside ours",
        "signature": [],
        "author": "",
        "program": f"pounding_risk {__version__}",
        "made_from": "from the case files, which it ran",
        "sections": sections,
    }
