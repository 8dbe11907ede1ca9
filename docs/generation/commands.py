"""The pages of the command line and of the Python calls, from typer and from signatures."""

from __future__ import annotations

import inspect
import re
from collections.abc import Iterator
from typing import Any

import typer
import xarray as xr

import pounding_risk
from generation.markdown import docstring, fence, plain, table
from pounding_risk.cli import app
from pounding_risk.results.accessor import Pounding

COMMANDS = """# Commands

Those that compute have a [Python call](python.md) of the same name. Bad input ends with status 2 and a sentence,
`--strict` with status 3 where a run failed, `verify` with status 1 where a published value is not reached.

"""


def commands_page() -> str:
    """Every command with its arguments and options."""
    whole: Any = typer.main.get_command(app)
    return COMMANDS + "".join(_command(name, command) for name, command in walk("pounding-risk", whole))


def walk(name: str, command: Any) -> Iterator[tuple[str, Any]]:
    """Every command below this one, groups before what they hold."""
    for inner, found in getattr(command, "commands", {}).items():
        yield f"{name} {inner}", found
        yield from walk(f"{name} {inner}", found)


def _command(name: str, command: Any) -> str:
    level = "#" * (name.count(" ") + 1)
    text = f"{level} {name.removeprefix('pounding-risk ')}\n\n{docstring(command.help or '')}\n"
    if getattr(command, "commands", None):
        return f"{text}\n"
    places = "".join(f" {each.metavar or each.name.upper()}" for each in command.params if not _is_option(each))
    rows = [_option(each) for each in command.params if each.name != "help"]
    text += fence(f"{name}{places}{' [OPTIONS]' if any(map(_is_option, command.params)) else ''}", "sh") + "\n"
    return f"{text}{table(('', 'what', 'default'), rows)}\n" if rows else text


def _is_option(each: Any) -> bool:
    return each.param_type_name == "option"


def _option(each: Any) -> tuple[str, str, str]:
    if not _is_option(each):
        return f"`{each.metavar or each.name.upper()}`", plain(each.help or ""), ""
    names = ", ".join(f"`{name}`" for name in [*each.opts, *each.secondary_opts])
    value = "" if each.is_flag else f" `{each.metavar}`" if each.metavar else ""
    return names + value, plain(each.help or ""), plain(_default(each))


def _default(each: Any) -> str:
    shown = each.show_default
    if isinstance(shown, str):
        return shown
    if shown is False or each.default in (None, "", [], ()) or (each.is_flag and not each.secondary_opts):
        return ""
    if each.is_flag:
        return (each.opts if each.default else each.secondary_opts)[0]
    return ", ".join(map(str, each.default)) if isinstance(each.default, list | tuple) else str(each.default)


METHODS = ("case", "figure")  # of datasets; the others are calls of their own
PYTHON = """# Python

`import pounding_risk as pr` costs next to nothing: each of these is loaded at its first use. The methods of datasets
stand in [Results in Python](../results.md).

"""


def python_page() -> str:
    """Every public call: its signature and what it says of itself."""
    names = [name for name in pounding_risk.__all__ if not name.startswith("_")]
    calls = [_call(name, f"pr.{name}", getattr(pounding_risk, name)) for name in names]
    empty = Pounding(xr.Dataset())
    calls += [_call(f"pounding.{name}", f"results.pounding.{name}", getattr(empty, name)) for name in METHODS]
    return PYTHON + "".join(calls)


def _call(heading: str, name: str, function: Any) -> str:
    return f"## {plain(heading)}\n\n{fence(f'{name}{signature(function)}', 'python')}\n{docstring(function)}\n"


def signature(function: Any) -> str:
    """The parameters and what is returned; on several lines where they are long. An exception is caught, not made."""
    if isinstance(function, type) and issubclass(function, BaseException):
        return ""
    signature = inspect.signature(function)
    pieces, named = [], False
    for each in signature.parameters.values():
        if each.kind is inspect.Parameter.KEYWORD_ONLY and not named:
            pieces.append("*")
            named = True
        pieces.append(_parameter(each))
    back = "" if signature.return_annotation is signature.empty else f" -> {_type(signature.return_annotation)}"
    line = f"({', '.join(pieces)}){back}"
    return line if len(line) <= 80 else "".join(["(\n", *(f"    {piece},\n" for piece in pieces), f"){back}"])


def _parameter(each: inspect.Parameter) -> str:
    text = each.name if each.annotation is each.empty else f"{each.name}: {_type(each.annotation)}"
    if each.default is each.empty:
        return text
    default = each.default.__name__ if callable(each.default) else repr(each.default)
    return f"{text} = {default}"


def _type(annotation: Any) -> str:
    text = annotation if isinstance(annotation, str) else inspect.formatannotation(annotation)
    return re.sub(r"\b(pounding_risk|pathlib|collections\.abc)(\.\w+)*\.", "", text)
