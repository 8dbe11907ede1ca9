"""Sentences that users read, in tests/golden/sentences: a file for each module of tests, a paragraph for each test.

A test says what it got: ``says(refusal(read_scene, path))``. ``pytest --rewrite tests/scene/test_reader.py`` writes the
files of whole modules anew; a change is read before it is committed. Numbers of four digits and more may differ by one
in the last, as in the golden files of commands.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from itertools import count
from pathlib import Path
from typing import Any

import pytest
from golden_commands import differences, masked

from pounding_risk.errors import PoundingError

TESTS = Path(__file__).parent
FILES = TESTS / "golden" / "sentences"
INDENT = "    "
EXACT = 3  # digits of limits, steps and counts, which no library rounds; results have more
_rewritten: dict[Path, dict[str, str]] = {}


def refusal(call: Callable[..., Any], *args: Any, kind: type[Exception] = PoundingError, **options: Any) -> str:
    """The sentence of the error that the call ends with."""
    with pytest.raises(kind) as error:
        call(*args, **options)
    return str(error.value)


def refusals(
    call: Callable[..., Any], *args: Any, wrong: Mapping[str, Iterable[Any]], kind: Any = PoundingError, **options: Any
) -> Iterator[str]:
    """The sentence of the call with each wrong value of each parameter, beside options that are right."""
    for name, values in wrong.items():
        for value in values:
            yield f"{name}={value!r}: {refusal(call, *args, kind=kind, **options | {name: value})}"


def pytest_addoption(parser: pytest.Parser) -> None:
    """``--rewrite``."""
    parser.addoption("--rewrite", action="store_true", help="write the golden files of these tests anew, to be read")


def pytest_configure(config: pytest.Config) -> None:
    """Whole modules in one process are rewritten: what no test of them says is dropped."""
    if config.getoption("--rewrite"):
        parts = [config.option.keyword, config.option.markexpr, *(one for one in config.args if "::" in one)]
        if any(parts) or config.getoption("numprocesses", None):
            raise pytest.UsageError("--rewrite takes whole modules, without -n, -k, -m and ::")


def pytest_sessionfinish(session: pytest.Session) -> None:
    """Write the files of the modules that ran."""
    for file, paragraphs in _rewritten.items():
        file.parent.mkdir(parents=True, exist_ok=True)
        file.write_text("\n".join(f"{name}\n{text}" for name, text in sorted(paragraphs.items())), encoding="utf-8")


@pytest.fixture
def says(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Callable[[Any], None]]:
    """``says(text)``: compares a text, or several, with the paragraph that is kept for this test."""
    file = sentence_file(request.path)
    base, places = str(tmp_path_factory.getbasetemp()), count(1)
    folder = str(request.getfixturevalue("tmp_path")) if "tmp_path" in request.fixturenames else base
    is_rewritten = request.config.getoption("--rewrite")

    def compare(*texts: Any) -> None:
        place = next(places)
        name = request.node.name if place == 1 else f"{request.node.name} ({place})"
        text = masked("\n".join(_lines(texts)).replace(folder, "FOLDER").replace(base, "FOLDER"))
        text = "".join(f"{INDENT}{line}\n" if line else "\n" for line in text.splitlines())
        if is_rewritten:
            _rewritten.setdefault(file, {})[name] = text
            return
        kept = sentences(file)
        assert name in kept, (
            f"{file.relative_to(TESTS)} has no {name}; run pytest --rewrite on this module, and read it"
        )
        found = differences(text, kept[name], exact=EXACT)
        assert not found, "\n".join(found)

    yield compare


def _lines(texts: Iterable[Any]) -> Iterator[str]:
    for text in texts:
        if isinstance(text, list | tuple):
            yield from _lines(text)
        else:
            yield str(text)


def sentence_file(module: Path) -> Path:
    """The file of a module of tests."""
    return FILES / module.relative_to(TESTS).with_suffix(".txt")


def sentences(file: Path) -> dict[str, str]:
    """Paragraphs of a file, by the name of their test."""
    found: dict[str, str] = {}
    name = ""
    for line in file.read_text(encoding="utf-8").splitlines(keepends=True) if file.exists() else []:
        if line.strip() and not line.startswith(INDENT):
            name = line.rstrip("\n")
            found[name] = ""
        else:
            found[name] += line
    # The blank line between two paragraphs is of neither.
    return {name: text.rstrip("\n") + "\n" for name, text in found.items()}
