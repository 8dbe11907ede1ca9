"""Discovery of commands: a module of a folder is the command of its name, and a folder in it a group of commands.

The module holds a function of its own name and ``ORDER``, its place in the help: commands are listed in rising order,
groups after them. The package of a group holds ``app``, its typer application, and ``ORDER``. Modules whose names begin
with an underscore are no commands.

A command is imported where it is run or listed, and typer reads its parameters only where it is run: reading those of
all commands takes longer than everything else that ``--help`` does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from inspect import getdoc
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup


class FolderCommands(Mapping[str, Any]):
    """The commands and groups of a package by name, in the order of its help; each is made where it is asked for."""

    def __init__(self, package: str, folders: Iterable[str]):
        self._package = package
        self._names = {name for _, name, _ in iter_modules(folders) if not name.startswith("_")}

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self._names, key=lambda name: self._module(name).ORDER))

    def __len__(self) -> int:
        return len(self._names)

    def __getitem__(self, name: str) -> Any:
        if name not in self._names:
            raise KeyError(name)
        module = self._module(name)
        if hasattr(module, "__path__"):
            app = module.app
        else:
            app = typer.Typer(add_completion=False, rich_markup_mode=None)
            app.command(name)(getattr(module, name))
        command = typer.main.get_command(app)
        command.name = name
        return command

    def listed(self) -> dict[str, TyperCommand]:
        """Commands that have a name and a help text alone, for the list of them."""
        return {name: TyperCommand(name, help=self._help(name)) for name in self}

    def _module(self, name: str) -> ModuleType:
        return import_module(f"{self._package}.{name}")

    def _help(self, name: str) -> str | None:
        module = self._module(name)
        return module.app.info.help if hasattr(module, "__path__") else getdoc(getattr(module, name))


class FolderGroup(TyperGroup):
    """A group whose commands are the modules of a package; `group_of` makes one for a package."""

    package: ClassVar[str]
    folders: ClassVar[Iterable[str]]

    def __init__(self, **settings: Any):
        super().__init__(**settings)
        self.commands: Any = FolderCommands(self.package, self.folders)

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands, in the order of the help."""
        return list(self.commands)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands to the help; their parameters are not read."""
        listed: Any = self.commands.listed()
        TyperGroup(name=self.name, commands=listed, rich_markup_mode=None).format_commands(ctx, formatter)


def group_of(package: str, folders: Iterable[str], base: type[FolderGroup] = FolderGroup) -> type[FolderGroup]:
    """The class of the group of a package, whose ``__path__`` is ``folders``, for ``typer.Typer(cls=...)``."""
    return type(base.__name__, (base,), {"package": package, "folders": folders})
