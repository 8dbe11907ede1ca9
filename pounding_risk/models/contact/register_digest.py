"""A digest of the code of a contact law of the user's own, which has no file of the package to be told by."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Iterator
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any

from pounding_risk.models.contact.laws import stiffness_quantity

PACKAGE = __name__.partition(".")[0]
OF_EVERY_TUPLE = frozenset((*dir(tuple), "_make", "_replace", "_asdict", "_fields", "_field_defaults"))


def is_own(kind: Any) -> bool:
    """True for a law that is not the package's, whose source is digested with the package."""
    return not _is_ours(kind.__module__)


def law_digest(law: Any) -> str:
    """SHA-256 of what a law computes: its fields, its facts, and the compiled code of its verbs.

    Of what a verb takes from outside the class, numbers count by their value and functions by their code; the package's
    own by their names. Lines, comments and where the class was written do not count.
    """
    text = "\n".join(_law(law))
    return hashlib.sha256(text.encode()).hexdigest()


def _is_ours(module: str | None) -> bool:
    return (module or "").partition(".")[0] == PACKAGE


def _law(law: Any) -> Iterator[str]:
    yield f"stiffness in {stiffness_quantity(law).unit}"
    yield from (f"field {name} = {law._field_defaults.get(name)!r}" for name in law._fields)
    for name in sorted(set(dir(law)) - OF_EVERY_TUPLE - set(law._fields)):
        if not name.startswith("__"):
            yield f"{name}: {_told(inspect.getattr_static(law, name), ())}"


def _told(value: Any, above: tuple[CodeType, ...]) -> str:
    """What a value is, in words that are the same in another process; ``above`` are the functions that lead to it."""
    value = getattr(value, "py_func", value)  # of a compiled function, the one it was compiled from
    if isinstance(value, staticmethod | classmethod):
        value = value.__func__
    if isinstance(value, FunctionType):
        return _function(value, above)
    if isinstance(value, CodeType):
        return _code(value, above)
    if isinstance(value, ModuleType):
        return f"module {value.__name__}"
    if isinstance(value, tuple | list):
        return f"{type(value).__name__}({', '.join(_told(each, above) for each in value)})"
    if isinstance(value, frozenset):
        return f"frozenset({', '.join(sorted(_told(each, above) for each in value))})"
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        return f"{type(value).__name__} {value!r}"
    if hasattr(value, "tobytes"):  # a number or an array of NumPy's
        return f"{value.dtype.str}{value.shape} {value.tobytes().hex()}"
    kind = value if hasattr(value, "__qualname__") else type(value)
    return f"{getattr(kind, '__module__', '')}.{kind.__qualname__}"


def _function(function: FunctionType, above: tuple[CodeType, ...]) -> str:
    if _is_ours(function.__module__):
        return f"{function.__module__}.{function.__qualname__}"
    code = function.__code__
    if code in above:
        return f"{code.co_name} again"
    above = (*above, code)
    outside = {name: function.__globals__[name] for name in _names(code) if name in function.__globals__}
    cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
    outside |= {name: _content(cell) for name, cell in cells.items()}
    told = [f"{name} = {_told(outside[name], above)}" for name in sorted(outside)]
    return f"{_code(code, above)} defaults {_told(function.__defaults__, above)} from outside [{'; '.join(told)}]"


def _names(code: CodeType) -> Iterator[str]:
    """Every name that a function, or a function within it, may look up outside itself."""
    yield from code.co_names
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _names(inner)


def _code(code: CodeType, above: tuple[CodeType, ...]) -> str:
    constants = ", ".join(_told(each, above) for each in code.co_consts)
    return f"code {code.co_code.hex()} names {code.co_names} arguments {code.co_argcount} constants [{constants}]"


def _content(cell: CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # of a name that is not bound yet
        return None
