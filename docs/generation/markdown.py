"""Markdown from Python objects: tables, and docstrings with their numpydoc sections, formulas and examples."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterable, Sequence
from itertools import pairwise
from typing import Any

_SPECIAL = re.compile(r"([_\[\]<>$|#])")
# Sections of a numpydoc docstring whose entries are "name : type" with an indented description.
_ENTRIES = ("Parameters", "Other Parameters", "Attributes", "Returns", "Yields", "Raises", "Warns")


def plain(text: str) -> str:
    """Text with the special characters of Markdown escaped, except `code` between backticks and *emphasis*."""
    pieces = re.split(r"(``.+?``|`[^`]+`)", " ".join(text.split()))
    return "".join(
        f"`{piece.strip('`')}`" if number % 2 else _SPECIAL.sub(r"\\\1", piece) for number, piece in enumerate(pieces)
    )


def table(heads: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table; bars within `code` of a cell are escaped."""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(map(_cell, line))} |" for line in lines) + "\n"


def _cell(text: str) -> str:
    return re.sub(r"`[^`]*`", lambda code: code[0].replace("|", "\\|"), " ".join(text.split()))


def fence(text: str, language: str = "text") -> str:
    """A fenced block."""
    return f"```{language}\n{text.rstrip()}\n```\n"


def docstring(thing: Any) -> str:
    """The docstring of an object, or a docstring itself, as Markdown."""
    return prose(inspect.cleandoc(f"\n{thing}" if isinstance(thing, str) else thing.__doc__ or ""))


def prose(text: str) -> str:
    """A docstring's paragraphs, indented formulas, examples and numpydoc sections as Markdown."""
    lines = text.splitlines()
    heads = [number for number, (line, below) in enumerate(pairwise(lines)) if line and below == "-" * len(line)]
    parts = [_paragraphs(lines[: heads[0] if heads else len(lines)])]
    for head, after in pairwise([*heads, len(lines)]):
        title, content = lines[head], lines[head + 2 : after]
        parts.append(f"**{title}**\n")
        parts.append(_entries(content) if title in _ENTRIES else _paragraphs(content))
    return "\n".join(part for part in parts if part)


def _entries(lines: Sequence[str]) -> str:
    """The entries of a section as a list: `name` (type): description."""
    entries: list[tuple[str, list[str]]] = []
    for line in lines:
        if line and not line.startswith(" "):
            entries.append((line, []))
        elif line.strip():
            entries[-1][1].append(line)
    return "".join(f"- {_entry(head)}: {plain(' '.join(words))}\n".replace(": \n", "\n") for head, words in entries)


def _entry(head: str) -> str:
    names, colon, kind = head.partition(" : ")
    shown = ", ".join(f"`{name}`" for name in names.split(", "))
    return f"{shown} ({plain(kind)})" if colon else shown


def _paragraphs(lines: Sequence[str]) -> str:
    """Paragraphs; indented lines are a block, and so is an example."""
    blocks: list[list[str]] = [[]]
    for line in lines:
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
