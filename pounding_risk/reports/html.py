"""HTML files that stand alone: a report without scripts, and pages of data and scripts that fetch nothing."""

from __future__ import annotations

import base64
import json
import re
import zlib
from collections.abc import Mapping
from functools import lru_cache
from hashlib import sha256
from html import escape
from importlib.resources import files
from typing import TYPE_CHECKING, Any

import numpy as np

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
    """The HTML of a report's document."""
    return _template().render(report=model, own_parts=own_parts, words=words, fit=fit)


def words(text: str) -> Markup:
    """Text as HTML: words in backquotes are code, F_E has its index; everything else is escaped."""
    from markupsafe import Markup, escape

    return Markup(_FORCE.sub("F<sub>E</sub>", _CODE.sub(r"<code>\1</code>", str(escape(text)))))


def fit(text: str) -> str:
    """CSS class of a cell: never broken, such as a date, or broken anywhere, such as a checksum."""
    if len(text) <= SHORTEST_BROKEN:
        return " short"
    return " long" if max(map(len, text.split())) > LONGEST_WORD else ""


def own_parts(svg: str, name: str) -> str:
    """An SVG whose ids carry the figure's name, as an id may stand only once in a page."""
    return _NAMES.sub(rf"\1{name}-", svg)


def script_page(folder: str, model: Mapping[str, Any], library: str = "", **parts: str) -> str:
    """An HTML page that holds a model (JSON), its script and a script library, and may run only these two.

    ``folder`` holds page.html, page.css and page.js; ``parts`` are further texts of page.html's ``{{name}}``.
    """
    source = files("pounding_risk.reports") / folder
    html, style, script = ((source / f"page.{kind}").read_text(encoding="utf-8") for kind in ("html", "css", "js"))
    # In a script element only "<" could end the data.
    data = json.dumps(model, ensure_ascii=False, allow_nan=False, separators=(",", ":")).replace("<", "\\u003c")
    digests = [sha256(text.encode("utf-8")).digest() for text in (library, script) if text]
    hashes = " ".join(f"'sha256-{base64.b64encode(digest).decode('ascii')}'" for digest in digests)
    parts |= {"title": escape(str(model["title"])), "allowed": hashes, "style": style, "data": data, "script": script}
    start, *pieces = html.split("{{")
    return start + "".join(parts[key] + rest for key, _, rest in (piece.partition("}}") for piece in pieces))


def packed(array: np.ndarray, kind: str) -> str:
    """An array as text: little-endian, first bytes of all numbers before their second bytes, deflated, base64.

    Bytes of the same significance are alike, so that the sorted ones take a half to a tenth of the room.
    """
    with np.errstate(over="ignore"):  # a number of a damaged file that is too large is infinite
        flat = np.ascontiguousarray(array, dtype=f"<{kind}").reshape(-1)
    sorted_bytes = flat.view(np.uint8).reshape(-1, flat.itemsize).T.tobytes()
    return base64.b64encode(zlib.compress(sorted_bytes, 9)).decode("ascii")


@lru_cache(maxsize=1)
def _template() -> Template:
    from jinja2 import Environment, PackageLoader, StrictUndefined

    settings: dict[str, Any] = {"autoescape": True, "undefined": StrictUndefined, "trim_blocks": True}
    loader = PackageLoader("pounding_risk.reports", ".")
    return Environment(loader=loader, lstrip_blocks=True, **settings).get_template("report.html.j2")
