"""Words of sentences: of names, the known word that is nearest to an unknown one, and lists in short."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from difflib import get_close_matches

FIRST = 5  # words of a list that are named


def words_of(*names: str) -> dict[str, str]:
    """Names of variables, each with its words: that of `peak_drift` are "peak drift"."""
    return {name: name.replace("_", " ") for name in names}


def nearest_file(name: str, known: Iterable[str]) -> str:
    """As `nearest` for names of files, compared without their endings."""
    stems = {file_name.rpartition(".")[0] or file_name: file_name for file_name in known}
    matches = get_close_matches(name.rpartition(".")[0] or name, stems, 1, 0.75)
    return f' (did you mean "{stems[matches[0]]}"?)' if matches else ""


def nearest(word: object, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The text ` (did you mean "gap"?)`, or "" where no known word is near, and for what is no text."""
    if not isinstance(word, str):
        return ""
    by_spelling = {name.lower(): name for name in known}
    matches = get_close_matches(word.lower(), by_spelling, 1, cutoff)
    return f' (did you mean "{by_spelling[matches[0]]}"?)' if matches else ""


def meant_by(name: object, subjects: Mapping[str, str]) -> str:
    """The name here of a ``name`` of the literature, as the end of a sentence; "" where it is none of the subjects."""
    spelling = re.sub(r"[^a-z0-9]+", "_", str(name).lower()).strip("_")
    return next((f"; {words}" for names, words in subjects.items() if spelling in names.split()), "")


def listed(words: Sequence[str], most: int = FIRST) -> str:
    """The first words of a list, so many of them: "a, b and 3 more"."""
    more_text = f" and {len(words) - most} more" if len(words) > most else ""
    return f"{', '.join(words[:most])}{more_text}"


def short_list(words: Sequence[str], most: int) -> str:
    """The words where they are no more than so many, otherwise how many they are and the two at the ends.

    >>> short_list(["0 mm", "5 mm"], 3), short_list(["0 mm", "5 mm", "10 mm", "15 mm"], 3)
    ('0 mm, 5 mm', '4 from 0 mm to 15 mm')
    """
    return ", ".join(words) if len(words) <= most else f"{len(words)} from {words[0]} to {words[-1]}"
