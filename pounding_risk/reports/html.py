"""A report as one HTML file: no script, no network, figures inline, tables that repeat their heads in print."""

from __future__ import annotations

import re
from functools import lru_cache
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from jinja2 import Template
    from markupsafe import Markup

    from pounding_risk.reports.document import Document

LONGEST_WORD = 26  # letters; a longer one may be broken anywhere
SHORTEST_BROKEN = 12  # letters; a shorter text is never broken
_CODE, _FORCE = re.compile(r"`([^`]*)`"), re.compile(r"\bF_E\b")
# Where an SVG names or points at one of its own parts. A colour such as #0072b2 is none of these.
_NAMES = re.compile(r"""(\bid="|\bhref="#|url\(#)""")


def page(model: Document) -> str:
    """The HTML of a report's model."""
    return _template().render(report=model, own_parts=own_parts, words=words, fit=fit)


def words(text: str) -> Markup:
    """Text as HTML: what stands in backquotes is code, F_E has its index; everything else is escaped."""
    from markupsafe import Markup, escape

    plain = str(escape(text))
    return Markup(_FORCE.sub("F<sub>E</sub>", _CODE.sub(r"<code>\1</code>", plain)))


def fit(text: str) -> str:
    """The class of a cell that is never broken, such as a date, or anywhere, such as a checksum."""
    if len(text) <= SHORTEST_BROKEN:
        return " short"
    return " long" if max(map(len, text.split())) > LONGEST_WORD else ""


def own_parts(svg: str, name: str) -> str:
    """An SVG whose parts are named after the figure: several stand in one page, where a name may stand once."""
    return _NAMES.sub(rf"\1{name}-", svg)


@lru_cache(maxsize=1)
def _template() -> Template:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment: Any = Environment(
        loader=PackageLoader("pounding_risk.reports", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template("report.html.j2")
