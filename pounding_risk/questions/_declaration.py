"""What a question says of its command beyond the signature and docstring of its function.

Read by the command line; nothing heavy is imported here.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

from pounding_risk._common.files import write_whole


class Option(NamedTuple):
    """How a parameter is written on the command line, where its name and annotation do not say it.

    Parameters
    ----------
    flag : str
        Name of the option, or several with blanks between, "" for the parameter's own with hyphens.
    kind : type, optional
        Type of the value; ``list[str]`` of an option that may be repeated, ``tuple[str, str]`` of one with two values.
    metavar : str
        Placeholder of the value in the help.
    is_argument : bool
        Whether it is written without a name.
    help : str
        What it is, of an option that only a figure takes; otherwise the docstring says it.
    """

    flag: str = ""
    kind: Any = None
    metavar: str = ""
    is_argument: bool = False
    help: str = ""


FROM_TO = Option(kind=tuple[str, str], metavar="FROM TO")
RANGE = Option(kind=tuple[float, float], metavar="FROM TO")


class File(NamedTuple):
    """A file that an answer is written to: its kinds, what it holds, and who writes it.

    That is a function of the answer and the path, or its name below `pounding_risk` where a layer above has it; "" the
    function of the question itself. Where no name is given it is ``usual``, with the stem of what the question is of.
    """

    suffixes: tuple[str, ...]
    description: str
    write: Callable[[Any, Path], object] | str = ""
    usual: str = ""


def text_file(description: str, suffix: str, text: Callable[[Any], str]) -> File:
    """A file of text, written whole or not at all."""

    def write(answer: Any, target: Path) -> None:
        content = text(answer).encode()
        write_whole(target, lambda file: file.write(content))

    return File((suffix,), description, write)
