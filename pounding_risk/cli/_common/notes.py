"""Notes below the tables of a command, one line each."""

from __future__ import annotations

from collections.abc import Iterable


def print_notes(notes: Iterable[str], prefix: str = "") -> None:
    """Print a line for each note, with a prefix such as "excluded: "."""
    for note in notes:
        print(f"note: {prefix}{note}")


def print_left_out(sentences: Iterable[str]) -> None:
    """Print a line for each record, file or component that is left out."""
    print_notes(sentences, "excluded: ")
