"""Sentences below the tables of an answer: notes, unused keys, excluded records, flags of records; words of links."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.render.sheet import Block

FASTER = "faster than the range of the restitution relation, which is held at its end there"
FEW_RECORDS = 3  # records that share a note and are all named in it
# Outputs of the links between two neighbours, the largest or the number of them.
OF_LINKS = {
    "peak_link_stretch": ("stretch", "m"),
    "peak_link_shortening": ("shortening", "m"),
    "peak_link_spring_force": ("force of the spring", "N"),
    "peak_link_damper_force": ("force of the damper with link_exponent or on a brace", "N"),
    "broken_links": ("number of links that break", "1"),
}


def notes_of(dataset: xr.Dataset) -> list[Block]:
    """Notes of a dataset, what it excludes, and flags of its records; nothing where it has none."""
    from pounding_risk.render.sheet import listing  # with NumPy, which commands import when they run

    notes, excluded = (json.loads(dataset.attrs.get(name, "[]")) for name in ("notes", "left_out"))
    flags = of_records(json.loads(dataset.attrs.get("flags", "{}")))
    sentences = [*notes, *(f"excluded: {sentence}" for sentence in excluded), *flags]
    return [listing(sentences)] if sentences else []


def of_keys(attrs: Mapping[str, Any]) -> list[str]:
    """The keys that the scene of an answer gives without effect; none where its attributes have no such list."""
    return [str(sentence) for sentence in json.loads(attrs.get("unused_keys", "[]"))]


def of_records(flags: Mapping[str, Sequence[str]]) -> Iterator[str]:
    """The notes on each record; one that several records share is given once, with their names."""
    records: dict[str, list[str]] = {}
    for record, notes in flags.items():
        for note in notes:
            records.setdefault(note, []).append(record)
    for note, names in records.items():
        names_text = ", ".join(names) if len(names) <= FEW_RECORDS else f"{names[0]} and {len(names) - 1} others"
        yield f"{names_text}: {note}"
