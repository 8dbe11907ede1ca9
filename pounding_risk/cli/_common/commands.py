"""Discovery of commands: a module of a folder is the command of its name, and a folder in it a group of commands.

The module holds a function of its own name and ``ORDER``, its place in the help: commands are listed in rising order,
groups after them. The package of a group holds ``app``, its typer application, and ``ORDER``. Modules whose names begin
with an underscore are no commands.
"""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from pkgutil import iter_modules

import typer


def add_commands(app: typer.Typer, package: str, folders: Iterable[str]) -> None:
    """Add the commands and groups of a package, whose ``__path__`` is ``folders``, to an application."""
    names = [name for _, name, _ in iter_modules(folders) if not name.startswith("_")]
    modules = {name: import_module(f"{package}.{name}") for name in names}
    for name, module in sorted(modules.items(), key=lambda item: item[1].ORDER):
        if hasattr(module, "__path__"):
            app.add_typer(module.app, name=name)
        else:
            app.command(name)(getattr(module, name))
