"""A module without importing it: names are made where they are asked for, so that a help text needs no calculation."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from typing import Any


class Outline(dict[str, Any]):
    """The names of a module, each made by its own statement, with the names that this one needs, at its first use.

    Functions have their signature and docstring; names that only their bodies or annotations use are never made.
    """

    def __init__(self, source: str):
        super().__init__()
        self._statements = {name: statement for statement in ast.parse(source).body for name in _names(statement)}

    def __missing__(self, name: str) -> Any:
        statement = self._statements[name]
        if isinstance(statement, ast.FunctionDef):
            statement.decorator_list = []
        exec(compile(ast.Module([statement], []), "outline", "exec"), {}, self)  # annotations remain text, as here
        return self[name]

    def __getattr__(self, name: str) -> Any:
        try:
            return self[name]
        except KeyError:
            raise AttributeError(name) from None


def _names(statement: ast.stmt) -> Iterator[str]:
    """The names that a statement gives a value."""
    if isinstance(statement, ast.FunctionDef | ast.ClassDef):
        yield statement.name
    elif isinstance(statement, ast.Import | ast.ImportFrom):
        yield from (alias.asname or alias.name for alias in statement.names)
    elif isinstance(statement, ast.Assign | ast.AnnAssign):
        targets = statement.targets if isinstance(statement, ast.Assign) else [statement.target]
        yield from (node.id for target in targets for node in ast.walk(target) if isinstance(node, ast.Name))
