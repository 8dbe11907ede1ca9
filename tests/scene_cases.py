"""Faulty scenes described in a text file: a change to a scene, and the exact sentences that it must give."""

from __future__ import annotations

from pathlib import Path


def cases(name: str, base: str) -> list[tuple[str, list[str], list[str]]]:
    """The cases of a file beside this one: the changed ``base``, overrides, sentences."""
    found = []
    paragraphs = (Path(__file__).parent / name).read_text(encoding="utf-8").split("\n\n")
    for paragraph in paragraphs[1:]:
        rows: dict[str, list[str]] = {"-": [], "+": [], "&": [], "!": []}
        for row in paragraph.strip().splitlines():
            rows[row[0]].append(row[2:])
        old = "\n".join(rows["-"]) + ("" if rows["+"] or not rows["-"] else "\n")
        assert old in base
        text = base.replace(old, "\n".join(rows["+"]), 1) if old else base
        found.append((text, rows["&"], [row.replace("{here}", str(Path.cwd().resolve())) for row in rows["!"]]))
    return found
