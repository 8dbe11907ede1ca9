"""Functions as numba sees them: flags, and what is made of `kernel`, `small`, `speaks` and `by_verb`.

Flags: no ``fastmath`` (it deletes NaN guards and changes bits), ``error_model="numpy"`` (kernels report by
status, they do not raise), ``nogil`` (a scan is threads over compiled calls), ``no_cfunc_wrapper`` (nothing calls a
kernel by its address, and the wrapper takes its share of compiling).
"""

from __future__ import annotations

import hashlib
import inspect

from numba import njit, types
from numba.core.registry import cpu_target
from numba.extending import overload, overload_method

from pounding_risk._jit.lowering.cache import ForgivingCache
from pounding_risk._jit.lowering.fragments import EntryCompiler, FragmentCompiler, InlinedCompiler
from pounding_risk._jit.sources import compile_cache

FLAGS = {"nogil": True, "error_model": "numpy", "fastmath": False, "no_cfunc_wrapper": True}
INLINED = {**FLAGS, "pipeline_class": InlinedCompiler}  # of a function that is always taken into its caller


def _symbol_name(kind):
    """Name of a named tuple's type in the symbols of compiled functions: its class and a digest of its fields' types.

    Numba writes the fields out. A tuple that holds arrays of records would make symbols of ten thousand characters,
    and these most of the file that a compiled function is kept in.
    """
    name = kind.name.partition("(")[0]
    return name + hashlib.sha256(kind.name.encode()).hexdigest()[:16], ()


types.BaseNamedTuple.mangling_args = property(_symbol_name)


def kernel(function):
    """A function that Python calls, and that compiled code takes in."""
    fragments = by_type_alone(njit(pipeline_class=FragmentCompiler, **FLAGS)(function))
    compiled = _entry_of(function, fragments)
    if compile_cache() is not None:
        compiled._cache = ForgivingCache(function)  # what njit(cache=True) does, with numba's own class
    return compiled


def _entry_of(function, fragments):
    """The function as Python calls it; in compiled code it is one of ``fragments``."""
    compiled = njit(**FLAGS)(function)
    compiler = compiled._compiler
    compiled._compiler = EntryCompiler(
        function, compiler.targetdescr, compiler.targetoptions, compiler.locals, compiler.pipeline_class, fragments
    )
    compiled.get_call_template, compiled.get_overload = fragments.get_call_template, fragments.get_overload
    # Looks for numba's extensions among all installed packages: our compiler does, where the cache has no code.
    compiled._compilation_chain_init_hook = lambda: None
    return compiled


def small(function):
    """A function that is always taken into its caller, and that only compiled code calls."""
    compiled = by_type_alone(njit(**INLINED)(function))
    # Of a fragment there is nothing that Python could call.
    compiled.add_overload = lambda result: compiled.overloads.update({tuple(result.signature.args): result})
    return compiled


def by_type_alone(compiled):
    """Let a call compile for the types of its arguments, not for every number that stands in the source of one.

    Numba takes a constant's value into its type: row 4 of an array and row 5 would be two kernels, of one machine code
    once they are taken into their caller. This is a quarter of the time that compiling takes.
    """
    resolve = compiled.get_call_template

    def resolve_plain(arguments, named):
        plain = {name: types.unliteral(kind) for name, kind in named.items()}
        return resolve(tuple(map(types.unliteral, arguments)), plain)

    compiled.get_call_template = resolve_plain
    return compiled


def type_of(built):
    """Numba's type of a `kernel`, a `small` function or an intrinsic, where compiled code names it."""
    return cpu_target.typing_context.resolve_value_type(built)


def speak(protocol):
    """Let compiled code call the methods of ``protocol`` on any NamedTuple that has them."""
    for name, method in vars(protocol).items():
        if name.startswith("_") or not inspect.isfunction(method):
            continue

        def resolve(model, *arguments, _name=name):
            return getattr(model.instance_class, _name, None)

        resolve.__signature__ = inspect.signature(method)  # type: ignore[attr-defined]
        overload_method(types.BaseNamedTuple, name, jit_options=INLINED)(resolve)


def choose(choice, verb, number, with_verb, without_verb):
    """Compile a call of ``choice`` to one of ``with_verb`` or ``without_verb``: see `compile.by_verb`."""

    def resolve(*arguments):
        chosen = with_verb if hasattr(arguments[number].instance_class, verb) else without_verb
        return lambda *arguments: chosen(*arguments)

    overload(choice, jit_options=INLINED)(resolve)
