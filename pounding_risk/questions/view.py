"""The command of `view`: a page to explore every case."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

from pounding_risk.questions._declaration import File, Option

ORDER = 140
FUNCTION = "reports.explorer"
SUBJECT = "results in part"
FILES = {"out": File((".html",), "Write the page", usual="{}-view.html")}
OPTIONS = {
    "records": Option("--record"),
    "contact_models": Option("--contact-model"),
    "pgas": Option("--pga"),
    "intensity_levels": Option("--intensity-level"),
}


def notes(page: Path) -> Iterator[str]:
    """Its size, and what it is for."""
    yield f"{page.stat().st_size / 1e6:.1f} MB; open it in a browser"
