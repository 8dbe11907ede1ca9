"""A report as PDF, by typst: a wheel that needs no program or font of the system, and the same bytes on any day."""

from __future__ import annotations

import json
from importlib import resources
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.reports.model import Model

TEMPLATE = "report.typ"


def document(model: Model) -> bytes:
    """The PDF of a report's model. Raises PoundingError where typst is not installed."""
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
        template.write_text(
            resources.files(__package__).joinpath(TEMPLATE).read_text(encoding="utf-8"), encoding="utf-8"
        )
        # PDF/UA: tagged, with the figures' texts, for those who have it read out.
        return typst.compile(template, root=root, font_paths=[], ignore_system_fonts=True, pdf_standards="ua-1")


def _with_files(model: Model, root: Path) -> Model:
    """The model with its figures as files beside the template."""
    sections = []
    for section in model["sections"]:
        blocks = []
        for block in section["blocks"]:
            if block["kind"] == "figure":
                file = f"{block['name']}.svg"
                (root / file).write_text(block["svg"], encoding="utf-8")
                block = {**{key: value for key, value in block.items() if key != "svg"}, "file": file}
            blocks.append(block)
        sections.append({**section, "blocks": blocks})
    return {**model, "sections": sections}
