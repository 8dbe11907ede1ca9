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
    """As `nearest` for names of files, of which what stands before the ending has to be alike."""
    stems = {other.rpartition(".")[0] or other: other for other in known}
    near = get_close_matches(name.rpartition(".")[0] or name, stems, 1, 0.75)
    return f' (did you mean "{stems[near[0]]}"?)' if near else ""


def nearest(word: object, known: Iterable[str], cutoff: float = 0.6) -> str:
    """The text ` (did you mean "gap"?)`, or "" where no known word is near, and for what is no text."""
    if not isinstance(word, str):
        return ""
    spelt = {name.lower(): name for name in known}
    near = get_close_matches(word.lower(), spelt, 1, cutoff)
    return f' (did you mean "{spelt[near[0]]}"?)' if near else ""


def meant_by(name: object, subjects: Mapping[str, str]) -> str:
    """What the field's ``name`` is called here, as the end of a sentence; "" where it is none of the subjects."""
    spelt = re.sub(r"[^a-z0-9]+", "_", str(name).lower()).strip("_")
    return next((f"; {words}" for names, words in subjects.items() if spelt in names.split()), "")


def listed(words: Sequence[str], most: int = FIRST) -> str:
    """The first words of a list, so many of them: "a, b and 3 more"."""
    more = f" and {len(words) - most} more" if len(words) > most else ""
    return f"{', '.join(words[:most])}{more}"


def short_list(words: Sequence[str], most: int) -> str:
    """The words where they are no more than so many, otherwise how many they are and the two at the ends.

    >>> short_list(["0 mm", "5 mm"], 3), short_list(["0 mm", "5 mm", "10 mm", "15 mm"], 3)
    ('0 mm, 5 mm', '4 from 0 mm to 15 mm')
    """
    return ", ".join(words) if len(words) <= most else f"{len(words)} from {words[0]} to {words[-1]}"
