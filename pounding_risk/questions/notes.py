"""Notes on records as sentences."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence

FEW_RECORDS = 3  # records that share a note and are all named in it


def of_records(flags: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """The notes on each record; one that several records share is given once, with their names."""
    records: dict[str, list[str]] = {}
    for record, notes in flags.items():
        for note in notes:
            records.setdefault(note, []).append(record)
    for note, names in records.items():
        who = ", ".join(names) if len(names) <= FEW_RECORDS else f"{names[0]} and {len(names) - 1} others"
        yield f"{who}: {note}"
