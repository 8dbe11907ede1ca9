"""Short representation of results at a prompt and in a notebook."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape

# Neither colour nor background: a notebook's own, light or dark, are those of the table.
CAPTION = "caption-side:top;text-align:left;font-weight:bold;color:inherit"
CELL = "text-align:left;vertical-align:top"


class ShortRepr:
    """Base class of results that show a few facts; dataclasses derived from it are declared with ``repr=False``.

    A named tuple, which has no other base class, takes its methods: ``__repr__ = ShortRepr.__repr__`` and so on.
    """

    def heading(self) -> str:
        """The heading above the facts."""
        return type(self).__name__

    def facts(self) -> Iterable[tuple[str, str]]:
        """The facts to show, one per line: (what, words)."""
        raise TypeError(f"{type(self).__name__} has no facts to show")

    def __repr__(self) -> str:
        pairs = [(name, " ".join(words.split())) for name, words in self.facts()]
        width = max((len(name) for name, _ in pairs), default=0)
        return "\n".join([f"<{self.heading()}>", *(f"  {name:<{width}}  {words}" for name, words in pairs)])

    def _repr_html_(self) -> str:
        rows = "".join(
            f'<tr><th style="{CELL};white-space:nowrap">{escape(name)}</th><td style="{CELL}">{escape(words)}</td></tr>'
            for name, words in self.facts()
        )
        return f'<table><caption style="{CAPTION}">{escape(self.heading())}</caption>{rows}</table>'
