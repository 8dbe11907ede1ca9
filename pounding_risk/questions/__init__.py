"""One module for each question: its function, the sheet of its answer, and its figures.

A module with ``ORDER``, the place of its command in the help, is a command. The function of the module's name is the
declaration: its first parameter is what the question is of (``results``, a ``study`` or ``scene``, or a ``source``),
the others are the options, described by its docstring. Results come as a dataset or as the path of its file:
`results.files.open_with_axes` takes both. A module without ``sheet(answer)`` is of a function that writes
files and returns them. Beside it the module may hold:

``FUNCTION``
    Module below `pounding_risk` that has the function, where another layer computes the answer.
``PASSED``
    The function below `pounding_risk` that it passes its ``**options`` to.
``FIGURES``
    What ``--figure`` draws: "module.function" of `pounding_risk.figures` by name, "" the first and "ida" of
    ``--ida-figure``, and "-impacts" one that is drawn beside the first, with that behind the name of its file. A
    function that takes the answer may stand for such a name; it gives "" for none.
``OPTIONS``
    An `Option` for each parameter whose name or annotation does not say how it is written, None for one that the
    command lacks; and for each option that only a figure takes.
``SUBJECT``
    What the question is of, an entry of ``cli._common.subjects.SUBJECTS``, where the name of the first parameter does
    not say it.
``FILES``
    A `File` for each option of the command that writes one, such as ``table``; "out" for kinds of ``--out`` beside the
    dataset (.nc), the tables (.csv) and the page (.html) of the answer.
``UNIT``
    What its progress counts, cases if not stated.
``answer``
    What the command runs in place of the function, with parameters of its own; those of the function too where it
    takes ``**options``.
``drawn(answer)``
    What the figures show, where that is not the answer itself.
``check(given)``
    Raises PoundingError for values, by parameter, that do not go together; called before what the question is of is
    opened, and again with it.
``notes(answer)``
    Sentences below the names of the files that are written.
``failed(answer)``, ``status(answer)``
    Whether ``--strict`` ends the command with status 3, and the exit status whatever the options.

The first parameter of ``sheet`` is the answer; the others, which its docstring describes, are options too.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from importlib import import_module
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

_ORDER = re.compile(r"^ORDER\b[^=\n]*= *(\d+)\b", re.MULTILINE)
_FUNCTION = re.compile(r'^FUNCTION = "([\w.]+)"$', re.MULTILINE)


class Declared(NamedTuple):
    """A question that is a command: its name, its place in the help, and its source, read without importing it."""

    name: str
    order: int
    source: str

    def module(self) -> ModuleType:
        """The module of the question."""
        return import_module(f"{__name__}.{self.name}")

    def function(self) -> Callable[..., Any]:
        """The function that answers it, of this module or of where it computes."""
        module = self.module()
        home = getattr(module, "FUNCTION", None)
        return getattr(import_module(f"pounding_risk.{home}") if home else module, self.name)

    def source_of_function(self) -> str:
        """The source of the module that has the function."""
        home = _FUNCTION.search(self.source)
        return source_of(home[1]) if home else self.source

    def summary(self) -> str:
        """First line of the docstring of its function."""
        source = self.source_of_function()
        of_function = source[source.index(f"\ndef {self.name}(") :]
        return of_function.split('"""', 2)[1].partition("\n")[0]


def source_of(home: str) -> str:
    """The source of a module below `pounding_risk`; it is not imported."""
    path = Path(__file__).parents[1].joinpath(*home.split("."))
    file = path.with_suffix(".py") if path.with_suffix(".py").exists() else path / "__init__.py"
    return file.read_text(encoding="utf-8")


def declared_questions() -> dict[str, Declared]:
    """The questions that are commands, by name; none is imported."""
    questions = {}
    for file in sorted(Path(__file__).parent.glob("[a-z]*.py")):
        source = file.read_text(encoding="utf-8")
        if order := _ORDER.search(source):
            questions[file.stem] = Declared(file.stem, int(order[1]), source)
    return questions
