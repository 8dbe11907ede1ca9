"""Registration of a user's own contact law: its checks, and the digest of its code that identifies it."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Iterator
from math import isfinite
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.law import (
    DEFAULTS,
    HERTZ_STIFFNESS,
    LINEAR_STIFFNESS,
    ContactLaw,
    complete,
    snake_case,
    stiffness_quantity,
)
from pounding_risk.models.contact.laws import LAWS, SHIPPED

Law = TypeVar("Law", bound=type)

METHODS = {name: method for name, method in vars(ContactLaw).items() if not name.startswith("_")}
FACTS = {"capped": "True where ceiling returns yield_force", "needs_restitution": "True where begin uses e"}


def contact_law(law: Law) -> Law:
    """Register a class as a contact law under its name in snake_case; for use as a decorator.

    Scenes that are read afterwards in this process may name the law, and ``impact`` takes its instances. A class
    defined again under the same name replaces the one before. A method is compiled at its first use: a number that it
    takes from outside the class is frozen then, so make it a field.

    Parameters
    ----------
    law : type
        A NamedTuple, or a class derived from a law of ``pounding_risk.models.contact.laws``. Its first field is
        ``stiffness``, annotated with LINEAR_STIFFNESS [N/m] or HERTZ_STIFFNESS [N/m^1.5]; further fields have defaults.
        It has the methods of `ContactLaw`, the facts ``capped`` and ``needs_restitution``, and may have ``reference``,
        its source, which is stored with every result.

    Returns
    -------
    type
        The class.

    Raises
    ------
    PoundingError
        Names every method, field or fact that is missing or does not fit; also for the name of a law of the package.
    """
    faults = list(_faults(law))
    if faults:
        name = getattr(law, "__name__", repr(law))
        raise PoundingError("\n".join([f"contact law {name}:", *(f"  - {fault}" for fault in faults)]))
    source = next((kind for kind in law.__mro__ if "reference" in vars(kind)), None)
    if source is None or source in [LAWS[name] for name in SHIPPED]:  # none, or that of the law it derives from
        law.reference = f"{law.__name__}, a law of the user's own"  # type: ignore[attr-defined]
    LAWS.enter(snake_case(law.__name__), complete(law), law.__module__)
    return law


def _faults(law: Any) -> Iterator[str]:
    if not (inspect.isclass(law) and issubclass(law, tuple) and hasattr(law, "_fields")):
        yield "is not a NamedTuple class; write class Name(NamedTuple): with its parameters as fields"
        return
    name = snake_case(law.__name__)
    if name in (*SHIPPED, *INSTANT_LAWS):
        yield f"{name} is a law of the package; give the class another name"
    elif taken := LAWS.taken(name, law.__module__):
        yield f"{name}: {taken}"
    yield from [*_fields(law), *_facts(law), *_methods(law)] or _first_use(law)


def _fields(law: Any) -> Iterator[str]:
    if law._fields[:1] != ("stiffness",):
        yield "its first field is not stiffness; write stiffness: Annotated[float, contact.LINEAR_STIFFNESS] first"
    else:
        try:
            quantity = stiffness_quantity(law)
        except (AttributeError, KeyError, NameError):
            quantity = None
        if quantity not in (LINEAR_STIFFNESS, HERTZ_STIFFNESS):
            yield (
                "the unit of stiffness is not stated; write stiffness: Annotated[float, contact.LINEAR_STIFFNESS] "
                "for N/m, or contact.HERTZ_STIFFNESS for N/m^1.5"
            )
    for field in law._fields[1:]:
        if field in DEFAULTS:
            yield f"field {field} has the name of a verb of laws, which kernels would call; give it another name"
        value = law._field_defaults.get(field)
        if isinstance(value, bool) or not isinstance(value, int | float):
            yield f"field {field} has no number as default, and a scene gives none; write {field}: float = 0.5, say"


def _facts(law: Any) -> Iterator[str]:
    for fact, meaning in FACTS.items():
        if not isinstance(getattr(law, fact, None), bool):
            yield f"{fact} is not given; write {fact} = True or {fact} = False in the class ({meaning})"


def _methods(law: Any) -> Iterator[str]:
    for name, method in METHODS.items():
        required, implemented = _arguments(method), getattr(law, name, None)
        if not inspect.isfunction(implemented):
            yield f"verb {name} is missing; write def {name}{required}: {inspect.getdoc(method)}"
        elif _arguments(implemented) != required:
            yield f"verb {name} takes {_arguments(implemented)}; kernels call {name}{required}"


def _arguments(function: Any) -> str:
    return f"({', '.join(inspect.signature(function).parameters)})"


def _first_use(law: Any) -> Iterator[str]:
    """Call each method once, interpreted, so that what fails in it fails here and not deep in a compiler."""
    instance = law(1e8)
    arguments: dict[str, tuple[float, ...]] = {
        "begin": (0.65, 0.5, 570.0),
        "force": (0.0, 1e-3, 0.1, True),
        "plateau": (1e-3, 1e5),
        "stored": (1e-3, 1e5),
        "ceiling": (1e5,),
        "floor": (),
    }
    for name, values in arguments.items():
        try:
            value = float(getattr(instance, name)(*values))
        except Exception as error:  # whatever a user's line may raise
            yield f"verb {name} fails: {type(error).__name__}: {error}"
            continue
        if name in ("begin", "force", "plateau", "stored") and not isfinite(value):
            yield f"verb {name}{values} returns {value:g}, which is no finite number"
        if name == "ceiling" and (value == 1e5) != law.capped:
            yield f"capped is {law.capped}, but ceiling(1e5) returns {value:g}; a capped law returns yield_force"


OF_EVERY_TUPLE = frozenset((*dir(tuple), "_make", "_replace", "_asdict", "_fields", "_field_defaults"))


def is_own(kind: Any) -> bool:
    """True for a class or function that is not the package's, whose source is digested with the package."""
    return (kind.__module__ or "").partition(".")[0] != __name__.partition(".")[0]


def law_digest(law: Any) -> str:
    """SHA-256 of what a law or an effect computes: its fields, its facts, and the compiled code of its methods.

    Of what a method takes from outside the class, numbers count by their value and functions by their code; those of
    the package by their names. Lines, comments and the place where the class was written do not count.
    """
    return hashlib.sha256("\n".join(_law(law)).encode()).hexdigest()


def _law(law: Any) -> Iterator[str]:
    fields = getattr(law, "_fields", ())  # an effect on buildings may be another kind of class
    if "stiffness" in fields:
        yield f"stiffness in {stiffness_quantity(law).unit}"
    yield from (f"field {name} = {law._field_defaults.get(name)!r}" for name in fields)
    for name in sorted(set(dir(law)) - OF_EVERY_TUPLE - set(fields)):
        if not name.startswith("__"):
            yield f"{name}: {_described(inspect.getattr_static(law, name), ())}"


def _described(value: Any, above: tuple[CodeType, ...]) -> str:
    """A description of a value that is the same in another process; ``above`` are the functions that lead to it."""
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
        return f"{type(value).__name__}({', '.join(_described(part, above) for part in value)})"
    if isinstance(value, frozenset):
        return f"frozenset({', '.join(sorted(_described(part, above) for part in value))})"
    if value is None or isinstance(value, bool | int | float | complex | str | bytes):
        return f"{type(value).__name__} {value!r}"
    if hasattr(value, "tobytes"):  # a number or an array of NumPy's
        return f"{value.dtype.str}{value.shape} {value.tobytes().hex()}"
    kind = value if hasattr(value, "__qualname__") else type(value)
    return f"{getattr(kind, '__module__', '')}.{kind.__qualname__}"


def _function(function: FunctionType, above: tuple[CodeType, ...]) -> str:
    if not is_own(function):
        return f"{function.__module__}.{function.__qualname__}"
    code = function.__code__
    if code in above:
        return f"{code.co_name} again"
    above = (*above, code)
    outside = {name: function.__globals__[name] for name in _names(code) if name in function.__globals__}
    cells = dict(zip(code.co_freevars, function.__closure__ or (), strict=True))
    outside |= {name: _content(cell) for name, cell in cells.items()}
    names = [f"{name} = {_described(outside[name], above)}" for name in sorted(outside)]
    return f"{_code(code, above)} defaults {_described(function.__defaults__, above)} from outside [{'; '.join(names)}]"


def _names(code: CodeType) -> Iterator[str]:
    """Every name that a function, or a function within it, may look up outside itself."""
    yield from code.co_names
    for inner in code.co_consts:
        if isinstance(inner, CodeType):
            yield from _names(inner)


def _code(code: CodeType, above: tuple[CodeType, ...]) -> str:
    constants = ", ".join(_described(constant, above) for constant in code.co_consts)
    return f"code {code.co_code.hex()} names {code.co_names} arguments {code.co_argcount} constants [{constants}]"


def _content(cell: CellType) -> Any:
    try:
        return cell.cell_contents
    except ValueError:  # of a name that is not bound yet
        return None
