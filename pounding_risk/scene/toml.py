"""The text side of scene files: read TOML, find the line of a key, set a key from outside, write TOML."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Iterable, Mapping, Sequence
from math import inf
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk._common.inputs import SCENE, cannot_be_read, read_whole
from pounding_risk._common.words import nearest_file
from pounding_risk.errors import SceneError
from pounding_risk.units import shown

MOST_DOTS = 100  # of a key
_DOTTED = re.compile(r"[\s\[]*[^=#\s]*")

KeyPath = tuple[str | int, ...]  # ("building", 0, "mass"): tables of an array by index from 0


class Fault(NamedTuple):
    """One thing that is wrong: where, and a sentence with what was found, what is allowed, and the repair."""

    path: KeyPath
    sentence: str
    absent: bool = False  # a key that should be there


def read_text(path: Path) -> str:
    """The text of a scene file; raises SceneError where it cannot be read, is empty or is not UTF-8."""
    try:
        raw = read_whole(path, SCENE)
    except FileNotFoundError:
        folder = path.parent
        other_files = [file.name for file in folder.glob("*.toml")] if folder.is_dir() else []
        sentence = f"no such file{nearest_file(path.name, other_files)}; check the name and the folder"
        raise SceneError(str(path), [sentence]) from None
    except IsADirectoryError:
        raise SceneError(str(path), ["this is a folder; name a scene file (.toml) in it"]) from None
    except OSError as error:
        raise SceneError(str(path), [cannot_be_read(error, "check its permissions")]) from None
    try:
        text = raw.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        if raw.startswith((b"\x89HDF", b"CDF")):
            raise SceneError(str(path), ["this is a dataset (netCDF), not a scene; name the scene (.toml)"]) from None
        line = raw.count(b"\n", 0, error.start) + 1
        raise SceneError(
            str(path), [f"line {line}: byte 0x{raw[error.start]:02x} is not UTF-8; save the file with that encoding"]
        ) from None
    if not text.strip():
        raise SceneError(str(path), ["the file is empty; a scene needs [[building]], [[interface]] and [records]"])
    return text


def parse_toml(text: str, source: str) -> dict[str, Any]:
    """The tables of a scene; raises SceneError with line and column where the text is not TOML."""
    for number, line in enumerate(text.splitlines(), start=1):
        dots = _DOTTED.match(line)
        if dots and dots[0].count(".") > MOST_DOTS:  # tomllib takes memory that grows with the square of them
            raise SceneError(source, [f"line {number}: a key of {dots[0].count('.') + 1} parts; a scene needs three"])
    try:
        return tomllib.loads(text)
    except RecursionError:
        raise SceneError(source, ["lists or tables are nested too deeply; a scene needs three levels"]) from None
    except ValueError as error:
        raise SceneError(source, [_syntax_sentence(str(error), text)]) from None


def _syntax_sentence(message: str, text: str) -> str:
    """A sentence for what tomllib reports, with the advice that fits the usual slips."""
    match = re.fullmatch(r"(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)", message, re.DOTALL)
    if not match:
        return f"not TOML: {message}"
    note = match[1][:1].lower() + match[1][1:]
    line = int(match[2]) if match[2] else len(text.splitlines())
    place = f"line {line}, column {match[3]}" if match[2] else f"line {line}, end of the file"
    if "overwrite" in note or "twice" in note or "mutate" in note:
        advice = "a key or [table] may stand only once; remove one of the two ([[building]] has double brackets)"
    elif "newline or end of document" in note or "invalid value" in note:
        advice = 'text and quantities stand in quotes, such as gap = "25 mm"'
    elif "unclosed" in note or "unterminated" in note or "illegal character" in note or "expected ']'" in note:
        advice = "close the quote or bracket"
    else:
        advice = 'a line is [table], [[table]] or key = value, such as gap = "25 mm"'
    return f"{place}: not TOML ({note}); {advice}"


def key_lines(text: str) -> dict[KeyPath, int]:
    """The line on which each table and key of a valid TOML text starts, counted from 1.

    tomllib gives no positions, so the text is cut into statements: each is parsed alone and its keys noted.
    """
    lines: dict[KeyPath, int] = {}
    counts: dict[KeyPath, int] = {}  # the newest element of each array of tables
    table: KeyPath = ()
    rows = text.replace("\r\n", "\n").split("\n")
    start = 0
    while start < len(rows):
        statement, length = _statement(rows, start)
        if rows[start].lstrip().startswith("["):
            names = [part for part in max(_key_paths(statement), key=len, default=()) if isinstance(part, str)]
            table = _header_path(names, rows[start].lstrip().startswith("[["), counts)
            for depth in range(len(table)):
                lines.setdefault(table[: depth + 1], start + 1)
        else:
            for path in _key_paths(statement):
                lines.setdefault(table + path, start + 1)
        start += length
    return lines


def _statement(rows: list[str], start: int) -> tuple[dict[str, Any], int]:
    """The statement that starts on a row, and how many rows it takes; nothing where it is not understood."""
    for end in range(start + 1, len(rows) + 1):
        # Only a closing bracket or triple quotes can end a statement of several rows.
        if end > start + 1 and not re.search(r"[]}]|\"\"\"|'''", rows[end - 1]):
            continue
        try:
            return tomllib.loads("\n".join(rows[start:end])), end - start
        except ValueError:
            if end - start > 500:  # not worth the time: only line numbers are lost
                break
    return {}, 1


def _key_paths(value: Any, path: KeyPath = ()) -> Iterable[KeyPath]:
    """The paths of all keys and list elements below a value."""
    children: Iterable[tuple[Any, Any]] = ()
    if isinstance(value, dict):
        children = value.items()
    elif isinstance(value, list):
        children = enumerate(value)
    for key, child in children:
        yield (*path, key)
        yield from _key_paths(child, (*path, key))


def _header_path(names: list[str], array: bool, counts: dict[KeyPath, int]) -> KeyPath:
    """The path that a header's names stand for: the newest element of each array of tables on the way."""
    path: KeyPath = ()
    for depth, name in enumerate(names):
        path = (*path, name)
        if array and depth == len(names) - 1:
            counts[path] = counts.get(path, -1) + 1
        if path in counts:
            path = (*path, counts[path])
    return path


def place(path: KeyPath, lines: Mapping[KeyPath, int]) -> int | None:
    """The line of a key, or of the table that it stands in or should stand in."""
    for length in range(len(path), 0, -1):
        if path[:length] in lines:
            return lines[path[:length]]
    return None


def key_name(path: KeyPath, raw: Any) -> str:
    """A path as a user writes it: building.frame.mass, or building.2.mass where the name is no help.

    Elements count from 1, left to right; the only [[interface]] needs no number.
    """
    parts: list[str] = []
    for depth, part in enumerate(path):
        if isinstance(part, str):
            parts.append(toml_key(part))
        elif depth == 1 and isinstance(raw, dict):
            names = element_names(raw.get(path[0]))
            own_name = names[part] if part < len(names) else None
            if own_name and names.count(own_name) == 1:
                parts.append(toml_key(own_name))
            elif len(names) != 1 or own_name is not None or part:
                parts.append(str(part + 1))
        else:
            parts.append(str(part + 1))
        if depth:
            try:
                raw = raw[part]
            except (KeyError, IndexError, TypeError):
                raw = None
    return ".".join(parts)


def element_names(elements: Any) -> list[str | None]:
    """The ``name`` of each table of an array, None where it has none."""
    if not isinstance(elements, list):
        return []
    names = [element.get("name") if isinstance(element, dict) else None for element in elements]
    return [name if isinstance(name, str) and name.strip() else None for name in names]


def sentences(
    faults: Sequence[Fault], raw: Mapping[str, Any], lines: Mapping[KeyPath, int], set_paths: Sequence[KeyPath]
) -> list[str]:
    """One line for each fault, in the order of the file; faults of overrides and those without a line come last."""
    line_of_sentence: dict[str, float] = {}
    for fault in faults:
        name = key_name(fault.path, raw)
        line = place(fault.path, lines)
        if any(fault.path[: len(path)] == path for path in set_paths):
            line_of_sentence.setdefault(f"--set {name}: {fault.sentence}", inf)
        elif line is None:
            line_of_sentence.setdefault(f"{name}: {fault.sentence}", inf)
        else:
            line_of_sentence.setdefault(f"line {line}, {name}: {fault.sentence}", line)
    return sorted(line_of_sentence, key=line_of_sentence.__getitem__)


def write_toml(tables: Mapping[str, Any]) -> str:
    """A dict of the scene file's shape as TOML: one [table] or [[table]] a paragraph."""
    paragraphs = []
    for name, section in tables.items():
        elements = section if isinstance(section, list) else [section]
        header = f"[[{name}]]" if isinstance(section, list) else f"[{name}]"
        for element in elements:
            rows = [f"{toml_key(key)} = {toml_value(setting)}" for key, setting in element.items()]
            paragraphs.append("\n".join([header, *rows]))
    return "\n\n".join(paragraphs) + "\n"


def toml_key(key: str) -> str:
    """A key as it stands in a TOML text."""
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else toml_value(key)


def toml_value(value: Any) -> str:
    """A value as it stands in a TOML text."""
    if isinstance(value, str):  # JSON's escapes are TOML's, but for the delete character
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, dict):
        return "{" + ", ".join(f"{toml_key(key)} = {toml_value(element)}" for key, element in value.items()) + "}"
    if isinstance(value, list | tuple):
        return "[" + ", ".join(toml_value(element) for element in value) + "]"
    if isinstance(value, bool | int | float):
        return str(value).lower()
    raise TypeError(f"{shown(value)} cannot stand in a scene file")


def tables(raw: Mapping[str, Any], section: str) -> list[tuple[int, dict[str, Any]]]:
    """The tables of an array of tables with their indices; nothing where it is not one."""
    elements = raw.get(section)
    if not isinstance(elements, list):
        return []
    return [(index, element) for index, element in enumerate(elements) if isinstance(element, dict)]


def table(raw: Mapping[str, Any], section: str) -> dict[str, Any]:
    """A section's table; empty where it is absent or not a table."""
    value = raw.get(section)
    return value if isinstance(value, dict) else {}


def as_list(value: object) -> list[Any]:
    """A list as it is; empty for anything else."""
    return value if isinstance(value, list) else []
