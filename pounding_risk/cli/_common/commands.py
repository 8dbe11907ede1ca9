"""Discovery of commands: a module of a folder is the command of its name, and a folder in it a group of commands.

The module holds a function of its own name and ``ORDER``, its place in the help: commands are listed in rising order,
groups after them. The package of a group holds ``app``, its typer application, and ``ORDER``. Modules whose names begin
with an underscore are no commands. Questions are commands too, made from their declarations (`cli._common.declared`). A
plug-in's command is a function, or a typer application, and is listed last.

A command is imported where it is run or listed, a plug-in's only where it is run, and typer reads its parameters only
where it is run: reading those of all commands takes longer than everything else that ``--help`` does.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from inspect import getdoc, isfunction
from math import inf
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, ClassVar

import typer
from typer.core import TyperCommand, TyperGroup

from pounding_risk._common.plugins import Registry
from pounding_risk.errors import PoundingError

NONE: Mapping[str, Any] = {}


class FolderCommands(Mapping[str, Any]):
    """The commands and groups of a package by name, in the order of its help; each is made where it is asked for."""

    def __init__(self, package: str, folders: Iterable[str], plugins: str = "", questions: Mapping[str, Any] = NONE):
        self._package, self._questions = package, questions
        names = [name for _, name, _ in iter_modules(folders) if not name.startswith("_")]
        self.registry = Registry(plugins, dict.fromkeys([*names, *questions]), _plugin_command)

    def __iter__(self) -> Iterator[str]:
        return iter(sorted(self.registry, key=self._order))

    def _order(self, name: str) -> float:
        return self._questions[name].order if name in self._questions else getattr(self._module(name), "ORDER", inf)

    def __len__(self) -> int:
        return len(self.registry)

    def __getitem__(self, name: str) -> Any:
        target = self._target(name)
        if isinstance(target, typer.Typer):
            app = target
        else:
            app = typer.Typer(add_completion=False, rich_markup_mode=None)
            app.command(name)(target)
        command = typer.main.get_command(app)
        command.name = name
        return command

    def listed(self) -> dict[str, TyperCommand]:
        """Commands that have a name and a help text alone, for the list of them."""
        return {name: TyperCommand(name, help=self._help(name)) for name in self}

    def _module(self, name: str) -> ModuleType | None:
        """The module of a command of this program; None of a plug-in's."""
        return import_module(f"{self._package}.{name}") if self.registry.is_ours(name) else None

    def _target(self, name: str) -> Any:
        """The function of a command, or the typer application of a group."""
        member = self.registry[name]  # None of this program's, with a warning where a plug-in has the name too
        if name in self._questions:
            from pounding_risk.cli._common.declared import command_of

            return command_of(self._questions[name])
        module = self._module(name)
        if module is None:
            return member
        return module.app if hasattr(module, "__path__") else getattr(module, name)

    def _help(self, name: str) -> str | None:
        if plugin := self.registry.plugin(name):  # not imported for a list
            return f"Command of {plugin.origin}."
        if name in self._questions:
            return str(self._questions[name].summary())
        target = self._target(name)
        return target.info.help if isinstance(target, typer.Typer) else getdoc(target)


def _plugin_command(name: str, target: Any) -> Any:
    """The command that a plug-in names; raises PoundingError for what is none."""
    if not (isfunction(target) or isinstance(target, typer.Typer)):
        raise PoundingError(f"{target!r} is neither a function nor a typer application")
    return target


class FolderGroup(TyperGroup):
    """A group whose commands are the modules of a package; `group_of` makes one for a package."""

    package: ClassVar[str]
    folders: ClassVar[Iterable[str]]
    plugins: ClassVar[str] = ""  # group of plug-ins that add commands
    questions: ClassVar[Mapping[str, Any]] = NONE  # that are commands, by name

    def __init__(self, **settings: Any):
        super().__init__(**settings)
        self.commands: Any = FolderCommands(self.package, self.folders, self.plugins, self.questions)

    def list_commands(self, ctx: Any) -> list[str]:
        """Names of the commands, in the order of the help."""
        return list(self.commands)

    def format_commands(self, ctx: Any, formatter: Any) -> None:
        """Write the list of commands to the help; their parameters are not read."""
        commands: Any = self.commands.listed()
        TyperGroup(name=self.name, commands=commands, rich_markup_mode=None).format_commands(ctx, formatter)


def group_of(package: str, folders: Iterable[str], base: type[FolderGroup] = FolderGroup) -> type[FolderGroup]:
    """The class of the group of a package, whose ``__path__`` is ``folders``, for ``typer.Typer(cls=...)``."""
    return type(base.__name__, (base,), {"package": package, "folders": folders})
