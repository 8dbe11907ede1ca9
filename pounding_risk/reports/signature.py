"""Whose report it is: project, author, revision and date, as the user gives them; what is not given is not there."""

from __future__ import annotations

from typing import NamedTuple

from pounding_risk.errors import PoundingError
from pounding_risk.units import shown

LONGEST = 200  # letters of a line in the head


class Signature(NamedTuple):
    """What the head of a report says of whose it is; "" where nothing is given. The date is never made up."""

    project: str = ""
    author: str = ""
    revision: str = ""
    date: str = ""

    @property
    def lines(self) -> list[list[str]]:
        """Name and words of each that is given."""
        return [[name, words] for name, words in self._asdict().items() if words]


NOTHING = Signature()


def signed(project: str = "", author: str = "", revision: str = "", date: str = "") -> Signature:
    """The signature of a report, in words that stand in one line each.

    Parameters
    ----------
    project, author, revision, date : str
        As they are to stand in the head.

    Raises
    ------
    PoundingError
        For what is no text, is longer than a line, or holds line breaks or other letters that are not printed.
    """
    given = Signature(project, author, revision, date)
    for name, words in given._asdict().items():
        if not isinstance(words, str):
            raise PoundingError(f"{name}: {shown(words)} is no text; write it in quotes")
        if not words.isprintable():
            raise PoundingError(
                f"{name}: {shown(words)} has line breaks or other letters that cannot be printed; omit them"
            )
        if len(words) > LONGEST:
            raise PoundingError(f"{name}: has {len(words)} letters; the head has room for {LONGEST}: shorten it")
    return Signature(*(words.strip() for words in given))
