"""Numbers with nouns: 1 motion, 2 motions."""

from __future__ import annotations


def counted(number: int | float, noun: str, plural: str = "") -> str:
    """A whole number with its noun, in the singular for 1.

    >>> counted(1, "motion"), counted(0, "motion"), counted(12000, "case")
    ('1 motion', '0 motions', '12,000 cases')
    """
    plural_noun = plural or f"{noun}s"
    digits = f"{number:,.0f}" if number >= 10_000 else f"{number:.0f}"
    return f"{digits} {noun if number == 1 else plural_noun}"
