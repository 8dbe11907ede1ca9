"""Sentences below the tables of an answer: notes, records that are left out, and flags of records."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

    from pounding_risk.render.sheet import Block


FEW_RECORDS = 3  # records that share a note and are all named in it


def notes_of(dataset: xr.Dataset) -> list[Block]:
    """Notes of a dataset, what is left out of it, and flags of its records; nothing where it has none."""

    from pounding_risk.render.sheet import listing  # with NumPy, which commands import when they run

    notes, left_out = (json.loads(dataset.attrs.get(name, "[]")) for name in ("notes", "left_out"))
    flags = flag_sentences(json.loads(dataset.attrs.get("flags", "{}")))
    sentences = [*notes, *(f"left out: {sentence}" for sentence in left_out), *flags]
    return [listing(sentences)] if sentences else []


def flag_sentences(flags: Mapping[str, Sequence[str]]) -> list[str]:
    """The notes on each record. A note that several records share stands once, with their names."""
    records: dict[str, list[str]] = {}
    for record, notes in flags.items():
        for note in notes:
            records.setdefault(note, []).append(record)
    who = {
        note: ", ".join(names) if len(names) <= FEW_RECORDS else f"{names[0]} and {len(names) - 1} others"
        for note, names in records.items()
    }
    return [f"{names}: {note}" for note, names in who.items()]
