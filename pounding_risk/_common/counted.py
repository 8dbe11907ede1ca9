"""Numbers with nouns: 1 motion, 2 motions; sizes of files and memory: 12 MB."""

from __future__ import annotations


def counted(number: int | float, noun: str, plural: str = "") -> str:
    """A whole number with its noun, in the singular for 1.

    >>> counted(1, "motion"), counted(0, "motion"), counted(12000, "case")
    ('1 motion', '0 motions', '12,000 cases')
    """
    plural_noun = plural or f"{noun}s"
    digits = f"{number:,.0f}" if number >= 10_000 else f"{number:.0f}"
    return f"{digits} {noun if number == 1 else plural_noun}"


def size_words(size: float) -> str:
    """So many bytes: 1.2 TB, 350 kB."""
    for unit, scale in (("TB", 1e12), ("GB", 1e9), ("MB", 1e6), ("kB", 1e3)):
        if size >= scale:
            return f"{size / scale:.3g} {unit}"
    return f"{size:.0f} bytes"
