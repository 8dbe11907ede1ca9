"""How results show themselves at a prompt and in a notebook: a handful of facts, not every number that they hold."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape


class ShortRepr:
    """A result that shows a few facts of itself; dataclasses of it are declared with ``repr=False``."""

    def facts(self) -> Iterable[tuple[str, str]]:
        """What a reader wants to see first: (what, words), one a line."""
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
