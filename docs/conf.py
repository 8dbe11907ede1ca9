"""Sphinx configuration: ``sphinx-build -W -n docs build/docs``. `generate` writes the generated pages at each build."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Any

HERE = Path(__file__).resolve().parent
sys.path[:0] = [str(HERE), str(HERE / "_ext"), str(HERE.parent)]

import generate  # noqa: E402

import pounding_risk  # noqa: E402

project = "pounding_risk"
author = "The pounding_risk developers"
copyright = author
version = release = os.environ.get("DOCS_VERSION", pounding_risk.__version__)  # of a release before it is installed

extensions = ["myst_parser", "mathml"]
myst_enable_extensions = ["dollarmath"]
smartquotes = False
myst_heading_anchors = 3
html_math_renderer = "mathml"
# Files that pages include.
exclude_patterns = ["generated/pieces"]
source_suffix = {".md": "markdown"}
nitpicky = True

html_theme = "furo"
html_title = f"pounding_risk {version}"
html_static_path = ["_static"]
templates_path = ["_templates"]
html_sidebars = {
    "**": [
        *(f"sidebar/{part}.html" for part in ("brand", "search", "scroll-start", "navigation", "scroll-end")),
        "versions.html",
    ]
}
html_css_files = ["tables.css"]
html_show_sphinx = False
html_copy_source = False


def _generate(app: Any) -> None:
    generate.write(HERE / "generated", run=generate.asked())


def setup(app: Any) -> None:
    """Connect the generation of pages to the start of a build."""
    app.connect("builder-inited", _generate)
