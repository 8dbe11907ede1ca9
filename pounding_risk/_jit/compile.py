"""How a function becomes a kernel, and how a model's verbs reach it.

Nothing here imports numba: a function is shown to it when it is first called or when a kernel that calls it is
compiled, and numba's side of it stands in `lowering`. So a command that runs no kernel starts without numba.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import update_wrapper
from threading import Lock, RLock
from types import SimpleNamespace
from typing import Any

from pounding_risk._jit.sources import INTERPRETED, is_ours

_BUILDING = RLock()  # held by whoever makes a function known to numba, so that no thread makes a second form of it
_DECLARED: list[tuple[str, tuple[Any, ...]]] = []  # functions of `lowering.build` to be called once it is loaded
_LOADED: list[SimpleNamespace] = []


def numba_side() -> SimpleNamespace:
    """The modules of `lowering`, with all declared to them that was declared before."""
    with _BUILDING:
        if not _LOADED:
            from pounding_risk._jit.lowering import build, by_address, calls, memory

            for name, arguments in _DECLARED:
                getattr(build, name)(*arguments)
            _LOADED.append(SimpleNamespace(build=build, calls=calls, by_address=by_address, memory=memory))
        return _LOADED[0]


def _declare(name: str, *arguments: Any) -> None:
    """Call a function of `lowering.build` now, or as soon as it is loaded."""
    with _BUILDING:
        if _LOADED:
            getattr(_LOADED[0].build, name)(*arguments)
        else:
            _DECLARED.append((name, arguments))


class InCompiledCode:
    """A function that Python calls as it is written, and that stands for ``make(function)`` in compiled code.

    Attributes that it has not are those of what was made.
    """

    def __init__(self, function, make: Callable[[Any], Any]):
        update_wrapper(self, function)
        self._make = make

    def __call__(self, *arguments):
        return self.__wrapped__(*arguments)

    def __getattr__(self, name):
        if name.startswith("__"):
            raise AttributeError(name)
        if name != "built":
            return getattr(self.built, name)
        with _BUILDING:
            if name not in vars(self):
                vars(self)[name] = self._make(self.__wrapped__)
            return vars(self)[name]

    @property
    def _numba_type_(self):
        return numba_side().build.type_of(self.built)

    def __reduce__(self):
        if "<locals>" in self.__qualname__:
            return type(self), (self.__wrapped__, self._make)
        return self.__qualname__  # that of its module, not another one with the same code


class Kernel(InCompiledCode):
    """A function that runs as compiled code wherever it is called."""

    def __call__(self, *arguments):
        return self.built(*arguments)


def _made_kernel(function):
    return numba_side().build.kernel(function)


def _made_small(function):
    return numba_side().build.small(function)


def kernel(function):
    """Compile ``function``: the one decorator of every jitted function of the package."""
    return function if INTERPRETED else Kernel(function, _made_kernel)


def small(function):
    """As `kernel`, for what is too small to be called: always taken into its caller, and not compiled for Python.

    Left to LLVM, calls of these were a third of a run's time, in handing over arguments.
    """
    return function if INTERPRETED else InCompiledCode(function, _made_small)


def in_kernels(module: str):
    """Decorator of a function for which compiled code has the one of this name in a module of `lowering`."""

    def decorate(function):
        return function if INTERPRETED else InCompiledCode(function, made)

    def made(function):
        return getattr(getattr(numba_side(), module), function.__name__)

    return decorate


@in_kernels("memory")
def uncounted(array):
    """The same array, its references not counted: for the inside of a kernel whose caller holds the array.

    Counting is an atomic operation, and an array is handed over hundreds of times in one contact.
    """
    return array


_APART: dict[type, type] = {}
_NAMING = Lock()  # two threads would give one number twice


def apart(kind: type) -> type:
    """The class under a name that no other class has; a class of this package is its own.

    At a call numba distinguishes named tuples by the *names* of their classes alone: a law that is defined again, as
    in a notebook, would be answered by the kernel of the one before it.
    """
    if is_ours(kind):
        return kind
    with _NAMING:
        if kind not in _APART:
            body = {"__slots__": (), "__module__": kind.__module__}
            renamed = type(f"{kind.__name__}#{len(_APART)}", (kind,), body)
            _APART[kind] = _APART[renamed] = renamed
    return _APART[kind]


def lowered(model):
    """The model with every number a float: 10**8 is another type than 1e8 and would compile everything anew.

    Every model that is handed to a kernel comes from here, with a class that is its own: see `apart`.
    """
    values = (lowered(value) if isinstance(value, tuple) else float(value) for value in model)
    return apart(type(model))(*values)


def speaks(protocol):
    """Let compiled code call the methods of ``protocol`` on any NamedTuple that has them.

    The kernel says ``law.force(...)``; numba picks the method by the type of the tuple at compile time, so a
    law that is not named costs nothing and no number stands for a model.
    """
    if not INTERPRETED:
        _declare("speak", protocol)
    return protocol


def by_verb(verb, number, with_verb, without_verb):
    """One kernel of two by the type of argument ``number``, ``with_verb`` where it has the method ``verb``.

    Both take the same arguments. Compiled code holds the one that is meant, and nothing of the choice.
    """

    def choice(*arguments):
        return (with_verb if hasattr(arguments[number], verb) else without_verb)(*arguments)

    if not INTERPRETED:
        _declare("choose", choice, verb, number, with_verb, without_verb)
    return choice
