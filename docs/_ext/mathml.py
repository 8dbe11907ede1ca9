"""Sphinx extension: equations as MathML, which browsers show without JavaScript or a network."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.errors import ExtensionError


def _mathml(node: Any, display: str) -> str:
    equation = convert(node.astext(), display=display)
    # The converter copies commands that it does not know.
    unknown = re.search(r"\\[A-Za-z]+|&#x0005C;[A-Za-z]*", equation)
    if unknown:
        raise ExtensionError(f"{node.source}: {unknown[0]} of an equation has no MathML: {node.astext()}")
    return equation


def _inline(translator: Any, node: Any) -> None:
    translator.body.append(_mathml(node, "inline"))
    raise nodes.SkipNode


def _block(translator: Any, node: Any) -> None:
    translator.body.append(f'<div class="math">{_mathml(node, "block")}</div>\n')
    raise nodes.SkipNode


def setup(app: Any) -> dict[str, Any]:
    """Register the renderer with Sphinx."""
    app.add_html_math_renderer("mathml", (_inline, None), (_block, None))
    return {"parallel_read_safe": True, "parallel_write_safe": True}
