"""What a figure says: its title in one line, then its caption."""

from __future__ import annotations

from typing import Any


def words_of(figure: Any) -> str:
    """Title, a line break, and the lines of the caption."""
    headline = figure.get_suptitle().replace("\n", " ")
    assert figure.get_suptitle().count("\n") <= 1  # a finding in two lines at most
    return f"{headline}\n{figure.get_supxlabel().lstrip()}"
