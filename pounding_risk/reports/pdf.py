"""Report as PDF by typst: a wheel that needs no program of the system, and the same bytes on any day."""

from __future__ import annotations

import json
import shutil
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING, Any

from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import font_files
from pounding_risk.render.sheet import Block

if TYPE_CHECKING:
    from pounding_risk.reports.document import Document

TEMPLATE, FONTS = "report.typ", "fonts"


def document(model: Document) -> bytes:
    """The PDF of a report's document. Raises PoundingError without typst, and for a letter that no font has."""
    try:
        import typst
    except ImportError:
        raise PoundingError(
            'a report as PDF needs typst: pip install "pounding-risk[pdf]", or write a report that ends in .html'
        ) from None
    with TemporaryDirectory() as folder:
        root = Path(folder)
        (root / "report.json").write_text(json.dumps(_with_files(model, root), ensure_ascii=False), encoding="utf-8")
        template = root / TEMPLATE
        template.write_bytes(resources.files(__package__).joinpath(TEMPLATE).read_bytes())
        (root / FONTS).mkdir()
        for font in font_files():
            shutil.copy(font, root / FONTS)
        return _compiled(typst, template)


def _compiled(typst: Any, template: Path) -> bytes:
    """Compile the PDF with the package's fonts, or with those of the system where these lack a letter.

    As PDF/UA: tagged, with the figures' texts, for those who have it read out. That refuses letters that no font has.
    """
    problem = ""
    for system in (False, True):
        try:
            fonts: dict[str, Any] = {"font_paths": [template.parent / FONTS], "ignore_system_fonts": not system}
            return typst.compile(template, root=template.parent, pdf_standards="ua-1", **fonts)
        except typst.TypstError as error:
            if "could not be displayed" not in str(error):
                raise
            problem = str(error).partition("error: ")[2]
    raise PoundingError(
        f"{problem}, nor with another font here: install a font that has it, such as Noto Sans, or write .html"
    )


def _with_files(model: Document, root: Path) -> Document:
    """The model with its figures as files beside the template."""

    def with_file(block: Block) -> Block:
        if block["kind"] != "figure":
            return block
        file = f"{block['name']}.svg"
        (root / file).write_text(block["svg"], encoding="utf-8")
        return {**{key: content for key, content in block.items() if key != "svg"}, "file": file}

    sections = [{**section, "blocks": list(map(with_file, section["blocks"]))} for section in model["sections"]]
    return {**model, "sections": sections}
