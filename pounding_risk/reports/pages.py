"""Documents as files, HTML or PDF by the suffix: of a report, of a sheet alone, and of published cases."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import TYPE_CHECKING

from pounding_risk._common.files import not_written
from pounding_risk._common.written import write_file
from pounding_risk.render.sheet import Block, paragraph
from pounding_risk.reports.document import Document, document_of
from pounding_risk.reports.html import page
from pounding_risk.results.files import check_target

if TYPE_CHECKING:
    from pounding_risk.lab.verification import Verification

SUFFIXES = (".html", ".pdf")


def write_document(model: Document, target: Path) -> Path:
    """Write a document; raises PoundingError where that fails, and for a PDF without the extra ``pdf``."""
    if target.suffix.lower() != ".pdf":
        return write_file(target, page(model))
    from pounding_risk.reports.pdf import document

    try:
        bytes_of_pdf = document(model)
    except OSError as error:  # of figures and fonts in the temporary folder
        raise not_written(target, error) from None
    return write_file(target, bytes_of_pdf)


def write_sheet_page(target: Path, title: str, blocks: Iterable[Block]) -> Path:
    """Write the blocks of a sheet, with their figures, as one HTML file."""
    lines: list[Block] = []  # a paragraph of several lines is one for each line
    for block in blocks:
        is_text = block["kind"] == "paragraph"
        lines += [paragraph(line) for line in block["text"].split("\n") if line] if is_text else [block]
    about = "Seismic pounding of adjacent buildings"
    return write_document(document_of(title.rstrip("."), about, [("answer", "Answer", lines)]), target)


def verification_page(outcome: Verification, out: str | Path) -> Path:
    """Write every published value beside ours, the figures, and each case with its source; raises PoundingError."""
    from pounding_risk.questions.verify import sections_of  # with the laboratory, which a report needs not

    about = "Seismic pounding of adjacent buildings: published values beside ours"
    title, made_from = "Verification of published cases", "from the case files, which it ran"
    target = check_target(out, SUFFIXES)
    return write_document(document_of(title, about, sections_of(outcome), made_from=made_from), target)
