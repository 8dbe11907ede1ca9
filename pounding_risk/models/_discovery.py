"""The modules of a folder, found by their files; parameters of their classes, documented from their quantities."""

from __future__ import annotations

from importlib import import_module
from inspect import cleandoc
from math import inf
from pkgutil import iter_modules
from types import ModuleType
from typing import Any, TypeVar, get_type_hints

from pounding_risk.units import Quantity

Class = TypeVar("Class", bound=type)


def modules_in_order(package: str) -> list[ModuleType]:
    """Import every module of a package whose name begins with no underscore, sorted by its ``ORDER``, then by name.

    ``ORDER`` is a number at the top of a module. It decides the order of tables, of grids and, for effects, in which
    they act. A module without one comes last.
    """
    path = import_module(package).__path__
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


def documented(model: Class) -> Class:
    """Add numpydoc's section of parameters to a named tuple's docstring, from the quantities beside its fields."""
    lines = ["Parameters", "----------"]
    for field, hint in get_type_hints(model, include_extras=True).items():
        quantity: Any = next((fact for fact in getattr(hint, "__metadata__", ()) if isinstance(fact, Quantity)), None)
        unit = "" if quantity is None or quantity.unit == "1" else f" [{quantity.unit}]"
        words = quantity.words if quantity else field.replace("_", " ")
        lines += [f"{field} : {'float' if quantity else hint.__name__}", f"    {words[0].upper()}{words[1:]}{unit}."]
    model.__doc__ = "\n".join([cleandoc(model.__doc__ or ""), "", *lines, ""])
    return model
