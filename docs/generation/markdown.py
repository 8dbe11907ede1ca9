"""Markdown from what code says of itself: tables, and docstrings with their formulas and examples."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from typing import Any

_SPECIAL = re.compile(r"([_\[\]<>$|#])")


def plain(text: str) -> str:
    """Text that Markdown shows as it stands, but for `code` between backticks and *emphasis*."""
    pieces = re.split(r"(``.+?``|`[^`]+`)", " ".join(text.split()))
    return "".join(
        f"`{piece.strip('`')}`" if at % 2 else _SPECIAL.sub(r"\\\1", piece) for at, piece in enumerate(pieces)
    )


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; cells are Markdown in which a bar between backticks is written for the table."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(map(_cell, line))} |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return re.sub(r"`[^`]*`", lambda code: code[0].replace("|", "\\|"), " ".join(text.split()))


def fence(text: str, language: str = "text") -> str:
    """A block as it stands."""
    return f"```{language}\n{text.rstrip()}\n```\n"


def docstring(thing: Any) -> str:
    """A docstring as Markdown: paragraphs, formulas that are set in, examples."""
    return prose(inspect.cleandoc(f"\n{thing}" if isinstance(thing, str) else thing.__doc__ or ""))


def prose(text: str) -> str:
    """Paragraphs of a docstring; lines that are set in are a block, and so is an example."""
    blocks: list[list[str]] = [[]]
    for line in text.splitlines():
        kind = _kind(line)
        if not line.strip():
            blocks.append([])
        elif blocks[-1] and _kind(blocks[-1][0]) not in (kind, "example"):
            blocks.append([line])
        else:
            blocks[-1].append(line)
    return "\n".join(_block(block) for block in blocks if block)


def _kind(line: str) -> str:
    return "example" if line.startswith(">>>") else "formula" if line.startswith("    ") else "words"


def _block(lines: list[str]) -> str:
    kind = _kind(lines[0])
    if kind == "words":
        return plain(" ".join(lines)) + "\n"
    text = inspect.cleandoc("\n" + "\n".join(lines))
    return fence(text, "pycon" if text.startswith(">>>") else "text")
