"""Notes below the tables of a command, one line each."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pounding_risk.questions.notes import of_records


def print_notes(notes: Iterable[str], prefix: str = "") -> None:
    """Print a line for each note, with a prefix such as "excluded: "."""
    for note in notes:
        print(f"note: {prefix}{note}")


def print_left_out(sentences: Iterable[str]) -> None:
    """Print a line for each record, file or component that is left out."""
    print_notes(sentences, "excluded: ")


def print_unused(dataset: Any) -> None:
    """Print a line for each key of a dataset's scene that changes nothing in it."""
    print_notes(json.loads(dataset.attrs.get("unused_keys", "[]")))


def print_flags(flags: Mapping[str, Sequence[str]]) -> None:
    """Print the notes on each record. A note that several records share is printed once, with their names."""
    print_notes(of_records(flags))
