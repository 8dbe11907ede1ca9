"""Notes below the tables of a command, one line each."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from pounding_risk.questions.notes import flag_sentences

FASTER = "faster than the range of the restitution relation, which is held at its end there"


def print_notes(notes: Iterable[str], prefix: str = "") -> None:
    """Print a line for each note, with a prefix such as "left out: "."""
    for note in notes:
        print(f"note: {prefix}{note}")


def print_left_out(sentences: Iterable[str]) -> None:
    """Print a line for each record, file or component that is left out."""
    print_notes(sentences, "left out: ")


def print_unused(dataset: Any) -> None:
    """Print a line for each key of a dataset's scene that changes nothing in it."""
    print_notes(json.loads(dataset.attrs.get("unused_keys", "[]")))


def print_flags(flags: Mapping[str, Sequence[str]]) -> None:
    """Print the notes on each record."""
    print_notes(flag_sentences(flags))
