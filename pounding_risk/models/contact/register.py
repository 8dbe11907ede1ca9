"""A contact law of the user's own: checked, registered for every command of this process, and told by a digest."""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Iterator
from math import isfinite
from types import CellType, CodeType, FunctionType, ModuleType
from typing import Any, TypeVar

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.law import (
    HERTZ_STIFFNESS,
    LINEAR_STIFFNESS,
    ContactLaw,
    complete,
    snake_case,
    stiffness_quantity,
)
from pounding_risk.models.contact.laws import LAWS, SHIPPED

Law = TypeVar("Law", bound=type)

VERBS = {name: verb for name, verb in vars(ContactLaw).items() if not name.startswith("_")}
FACTS = {
    "capped": "True where ceiling returns yield_force",
    "needs_restitution": "True where begin uses e",
}


def contact_law(law: Law) -> Law:
    """Make a class known as a contact law, under its name in snake_case; for use as a decorator.

    The class is a NamedTuple, or derives from a law of ``pounding_risk.models.contact.laws``. Its first field is
    ``stiffness``, annotated with LINEAR_STIFFNESS [N/m] or HERTZ_STIFFNESS [N/m^1.5]; further fields have defaults.
    It has the verbs of `ContactLaw` and says ``capped`` and ``needs_restitution``; ``reference``, its source, is
    stored with every result. Scenes read afterwards may name it, in this process; ``impact`` takes its instances.

    Defined again under the same name it replaces the class before, and answers with its own numbers. A verb is
    compiled at its first use: a number that it takes from outside the class is frozen then, so make it a field.

    Raises PoundingError that names every verb, field or fact that is missing or does not fit, and for the name
    of a law of the package.
    """
    faults = list(_faults(law))
    if faults:
        name = getattr(law, "__name__", repr(law))
        raise PoundingError("\n".join([f"contact law {name}:", *(f"  - {fault}" for fault in faults)]))
    if not hasattr(law, "reference") or _inherited_from_shipped(law, "reference"):
        law.reference = f"{law.__name__}, a law of the user's own"  # type: ignore[attr-defined]
    LAWS[snake_case(law.__name__)] = complete(law)
    return law


def _faults(law: Any) -> Iterator[str]:
    if not (inspect.isclass(law) and issubclass(law, tuple) and hasattr(law, "_fields")):
        yield "is not a NamedTuple class; write class Name(NamedTuple): with its parameters as fields"
        return
    name = snake_case(law.__name__)
    if name in SHIPPED:
        yield f"{name} is a law of the package; give the class another name"
    before = [*_fields(law), *_facts(law), *_verbs(law)]
    yield from before or _first_use(law)


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
                "the unit of stiffness is not told; write stiffness: Annotated[float, contact.LINEAR_STIFFNESS] "
                "for N/m, or contact.HERTZ_STIFFNESS for N/m^1.5"
            )
    for field in law._fields[1:]:
        value = law._field_defaults.get(field)
        if isinstance(value, bool) or not isinstance(value, int | float):
            yield f"field {field} has no number as default, and a scene gives none; write {field}: float = 0.5, say"


def _facts(law: Any) -> Iterator[str]:
    for fact, meaning in FACTS.items():
        if not isinstance(getattr(law, fact, None), bool):
            yield f"{fact} is not given; write {fact} = True or {fact} = False in the class ({meaning})"


def _verbs(law: Any) -> Iterator[str]:
    for name, verb in VERBS.items():
        asked = inspect.signature(verb)
        own = getattr(law, name, None)
        if not inspect.isfunction(own):
            yield f"verb {name} is missing; write def {name}{_words(asked)}: {inspect.getdoc(verb)}"
        elif list(inspect.signature(own).parameters) != list(asked.parameters):
            yield f"verb {name} takes {_words(inspect.signature(own))}; kernels call {name}{_words(asked)}"


def _words(signature: inspect.Signature) -> str:
    return f"({', '.join(signature.parameters)})"


def _first_use(law: Any) -> Iterator[str]:
    """Each verb asked once, interpreted, so that what fails in it fails here and not deep in a compiler."""
    one = law(1e8)
    calls = {
        "begin": (0.65, 0.5, 570.0),
        "force": (0.0, 1e-3, 0.1, True),
        "plateau": (1e-3, 1e5),
        "stored": (1e-3, 1e5),
        "ceiling": (1e5,),
        "floor": (),
    }
    for name, given in calls.items():
        try:
            value = float(getattr(one, name)(*given))
        except Exception as error:  # whatever a user's line may raise
            yield f"verb {name} fails: {type(error).__name__}: {error}"
            continue
        if name in ("begin", "force", "plateau", "stored") and not isfinite(value):
            yield f"verb {name}{given} returns {value:g}, which is no finite number"
        if name == "ceiling" and (value == 1e5) != law.capped:
            yield f"capped is {law.capped}, but ceiling(1e5) returns {value:g}; a capped law returns yield_force"


def _inherited_from_shipped(law: type, fact: str) -> bool:
    """True where a class has only the source of the law of the package that it derives from."""
    home = next((each for each in law.__mro__ if fact in vars(each)), law)
    return home in [LAWS[name] for name in SHIPPED]


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
