"""Equations as MathML: they are read without a network and without JavaScript, by every browser of today."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.errors import ExtensionError


def _mathml(node: Any, display: str) -> str:
    found = convert(node.astext(), display=display)
    # What the converter does not know it prints as it stands.
    unknown = re.search(r"\\[A-Za-z]+|&#x0005C;[A-Za-z]*", found)
    if unknown:
        raise ExtensionError(f"{node.source}: {unknown[0]} of an equation has no MathML: {node.astext()}")
    return found


def _inline(translator: Any, node: Any) -> None:
    translator.body.append(_mathml(node, "inline"))
    raise nodes.SkipNode


def _block(translator: Any, node: Any) -> None:
    translator.body.append(f'<div class="math">{_mathml(node, "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, Any]:
    """Make it known to Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
