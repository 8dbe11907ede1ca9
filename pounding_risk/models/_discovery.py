"""The modules of a folder, found: a contact law or an effect is known because its file is there."""

from __future__ import annotations

from collections.abc import Iterable
from importlib import import_module
from math import inf
from pkgutil import iter_modules
from types import ModuleType


def modules_in_order(package: str, path: Iterable[str]) -> list[ModuleType]:
    """Import every module of a package whose name begins with no underscore, sorted by its ``ORDER``, then by name.

    ``ORDER`` is a number at the top of a module. It decides the order of tables, of grids and, for effects, in which
    they act. A module without one comes last.
    """
    names = (f"{package}.{module.name}" for module in iter_modules(path) if not module.name.startswith("_"))
    return sorted(map(import_module, names), key=lambda module: (getattr(module, "ORDER", inf), module.__name__))


def classes_of(module: ModuleType) -> dict[str, type]:
    """The named tuples that a module defines itself, by name and in the order of its lines."""
    members = vars(module).items()
    return {
        name: member
        for name, member in members
        if isinstance(member, type) and hasattr(member, "_fields") and member.__module__ == module.__name__
    }
