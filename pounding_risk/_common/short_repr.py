"""Short representation of results at a prompt and in a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


class ShortRepr:
    """Base class of results that show a few facts; dataclasses derived from it are declared with ``repr=False``."""

    def facts(self) -> Iterable[tuple[str, str]]:
        """The facts to show, one per line: (what, words)."""
        raise TypeError(f"{type(self).__name__} has no facts to show")

    def __repr__(self) -> str:
        pairs = [(what, " ".join(words.split())) for what, words in self.facts()]
        width = max((len(what) for what, _ in pairs), default=0)
        return "\n".join([f"<{type(self).__name__}>", *(f"  {what:<{width}}  {words}" for what, words in pairs)])

    def _repr_html_(self) -> str:
        rows = "".join(
            f'<tr><th style="text-align:left">{escape(what)}</th><td style="text-align:left">{escape(words)}</td></tr>'
            for what, words in self.facts()
        )
        return f"<table><caption>{escape(type(self).__name__)}</caption>{rows}</table>"
