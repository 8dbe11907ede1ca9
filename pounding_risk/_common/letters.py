"""Letters that no name may have, and their replacements where foreign text reaches a terminal.

Control characters steer a terminal and end the texts of C libraries, overrides of the direction of writing make a text
read as another one, and separators of lines and halves of letters are refused by XML and by the libraries of pages.
A spreadsheet runs the cells of a CSV file that begin as a formula does.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterable, Iterator, Mapping
from io import StringIO
from typing import Any

_CONTROLS = "\x00-\x1f\x7f-\x9f"
_OTHERS = "\u2028\u2029\u202a-\u202e\u2066-\u2069\ud800-\udfff\ufffe\uffff"
_REFUSED = re.compile(f"[{_CONTROLS}{_OTHERS}]")
_ESCAPED = re.compile(f"(?![\t\n])[{_CONTROLS}{_OTHERS}]")
_FORMULA = re.compile(r"'*[=+\-@\t\r]")
_NUMBER = re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?|[+-]?(inf|nan)")
_KINDS = (
    (re.compile(f"[{_CONTROLS}]"), "a control character"),
    (re.compile("[\u2028\u2029]"), "a separator of lines"),
    (re.compile("[\u202a-\u202e\u2066-\u2069]"), "an override of the direction of writing"),
)


def refused(text: str) -> str:
    """The sentence on the first letter of a text that no name may have; "" where there is none."""
    match = _REFUSED.search(text)
    if match is None:
        return ""
    kind = next((words for letters, words in _KINDS if letters.match(match[0])), "no character")
    quoted = "".join(letter if letter.isprintable() else f"\\u{ord(letter):04x}" for letter in text[:40])
    return f'has U+{ord(match[0]):04X} at place {match.start() + 1} of "{quoted}", {kind}; leave it out'


def refused_below(content: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[tuple[Any, ...], str]]:
    """Path and sentence of each text with such a letter in tables and lists, keys of tables included."""
    if isinstance(content, str):
        if words := refused(content):
            yield path, words
    elif isinstance(content, Mapping):
        for key, element in content.items():
            if words := refused(str(key)):
                yield path, f"a key {words}"
            yield from refused_below(element, (*path, key))
    elif isinstance(content, list | tuple):
        for index, element in enumerate(content):
            yield from refused_below(element, (*path, index))


def plain(text: str) -> str:
    r"""The text with ``\uXXXX``, as JSON and TOML write it, for such letters; tabs and ends of lines stay."""
    return _ESCAPED.sub(lambda match: f"\\u{ord(match[0]):04x}", text)


def cell(content: Any) -> Any:
    """A value for a table in CSV: a text that a spreadsheet would run as a formula gets an apostrophe before it.

    Numbers stay as they are, as text too. `without_mark` is the way back.
    """
    if isinstance(content, str) and _FORMULA.match(content) and not _NUMBER.fullmatch(content):
        return f"'{content}"
    return content


def without_mark(text: str) -> str:
    """The text of a cell without the apostrophe of `cell`."""
    return text[1:] if text.startswith("'") and cell(text[1:]) == text else text


def csv_text(rows: Iterable[Iterable[Any]]) -> str:
    """Rows as the text of a CSV file, every content as `cell` has it."""
    out = StringIO()
    csv.writer(out, lineterminator="\n").writerows(map(cell, row) for row in rows)
    return out.getvalue()
