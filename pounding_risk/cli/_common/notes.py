"""Notes below the tables of a command."""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

FEW_RECORDS = 3  # that share a doubt and are named


FASTER = "faster than the range of the restitution relation, which is held at its end there"


def print_notes(notes: Iterable[str]) -> None:
    """On unusual numbers, a line each."""
    for note in notes:
        print(f"note: {note}")


def print_flags(flags: Mapping[str, Sequence[str]]) -> None:
    """A line for each doubt; one that many records share is told once."""
    sharing: dict[str, list[str]] = {}
    for record, sentences in flags.items():
        for sentence in sentences:
            sharing.setdefault(sentence, []).append(record)
    for sentence, records in sharing.items():
        who = ", ".join(records) if len(records) <= FEW_RECORDS else f"{records[0]} and {len(records) - 1} others"
        print(f"note: {who}: {sentence}")


def print_unused(dataset: Any) -> None:
    """A line for each key of the scene that changes nothing in it."""
    for sentence in json.loads(dataset.attrs.get("unused_keys", "[]")):
        print(f"note: {sentence}")
