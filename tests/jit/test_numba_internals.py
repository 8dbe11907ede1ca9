"""What the package uses of numba beyond its public interface: read this when numba's upper bound is raised.

Numba promises nothing about these. Raise the bound in pyproject.toml, run this module, then `tests/jit` and
`tests/results/test_shipped_numbers.py`. What fails here says which part of numba has changed, and what of ours rests on
it; what passes may still have changed its meaning, which the other two show.
"""

from __future__ import annotations

import ast
import importlib
import inspect
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

from pounding_risk import _jit
from pounding_risk._jit import compile as compiling
from pounding_risk._jit.lowering.cache import ForgivingCache, Shelf
from pounding_risk._jit.records import new_record, record_type
from pounding_risk._jit.sources import INTERPRETED, compile_cache
from pounding_risk.models.contact.laws import LAWS

JIT = Path(_jit.__path__[0])
compiled = pytest.mark.skipif(INTERPRETED, reason="NUMBA_DISABLE_JIT is set: there is nothing compiled")

# Private name: its parameters as we pass them (None for what is not called), and what rests on it.
PRIVATE = {
    "numba.core.caching.CompileResultCacheImpl": (
        ["py_func"],
        "`OnShelf` sets its `_locator_classes`; the constructor asks each class `from_function(py_func, py_file)`, "
        "catches nothing, and reads `_py_file` when it warns",
    ),
    "numba.core.caching.FunctionCache": (
        ["py_func"],
        "`ForgivingCache` sets its `_impl_class` and overrides `load_overload`, of which it calls what follows the "
        "loading of declarations, and `save_overload`; both must still raise what goes wrong with a file; `flush` "
        "empties the index, `cache_path` names the folder in a warning",
    ),
    "numba.core.caching.IndexDataCacheFile": (
        ["cache_path", "filename_base", "source_stamp"],
        "`OwnFiles` overrides how index and data are read and a file is written, and reads `_cache_path`, "
        "`_index_path` and `_source_stamp`; `load` takes an OSError of `_load_data` for an absent file",
    ),
    "numba.core.codegen.JITCodeLibrary": (
        ["codegen", "name"],
        "`Fragment` and `Entry` override `finalize`, `_optimize_functions` and `_get_module_for_linking`, read "
        "`_linking_libraries` and `_reload_init`, and set `_finalized`; `get_pointer_to_function` may give 0",
    ),
    "numba.core.compiler.Compiler": (
        ["typingctx", "targetctx", "library", "args", "return_type", "flags", "locals"],
        "`FragmentCompiler` hands over a library of its own, sets `no_compile`, so that no machine code is made, and "
        "gives the result of `_compile_core` an entry point by which `insert_user_function` knows it",
    ),
    "numba.core.compiler.Flags": (
        ["copy_from"],
        "`FragmentFlags` compares its `_values`, in place of every option: numba looks overloads up by the flags",
    ),
    "numba.core.dispatcher._FunctionCompiler": (
        ["py_func", "targetdescr", "targetoptions", "locals", "pipeline_class"],
        "`EntryCompiler` is a dispatcher's `_compiler`, and overrides `_compile_core`",
    ),
    "numba.core.registry.cpu_target": (
        None,
        "its `typing_context` gives the type of what stands for a function in compiled code",
    ),
    "numba.core.runtime._nrt_python": (
        None,
        "`c_helpers`, by which machine code from the cache finds the functions that make arrays, with the prefix NRT_",
    ),
    "numba.core.entrypoints.init_all": (
        [],
        "loads numba's extensions; a dispatcher's `_compilation_chain_init_hook`, which does too, is replaced",
    ),
    "numba.core.environment.lookup_environment": (
        ["env_name"],
        "the constants of a function whose code stands in another's library are set when that one is finished",
    ),
    "numba.core.cgutils": (
        None,
        "`unpack_tuple` and `get_null_value`, in `_without_reference` and `calls`: shape and strides of an array, and "
        "the null pointer that says that nobody counts references to it",
    ),
    "numba.np.arrayobj.make_array": (
        ["array_type"],
        "a class whose instances have `data`, `shape`, `strides`, `itemsize`, `meminfo`, `parent` and `_getvalue()`",
    ),
    "numba.np.arrayobj.populate_array": (
        ["array", "data", "shape", "strides", "itemsize", "meminfo", "parent"],
        "`_without_reference` fills a view whose `meminfo` is null: references to it must stay uncounted",
    ),
    "numba.core.datamodel.models": (
        None,
        "`PrimitiveModel` is what a lent tuple is to LLVM, `ArrayModel` what its arrays are",
    ),
    "numba.core.typing.templates.AttributeTemplate": (
        None,
        "`_LentFields` answers `generic_resolve(kind, name)` with a field's type",
    ),
    "numba.core.typing.templates.infer_getattr": (None, "registers `_LentFields`"),
    "numba.core.imputils.impl_ret_new_ref": (
        ["ctx", "builder", "retty", "ret"],
        "`memory.zeros` gives a new array whose reference is the caller's",
    ),
    "numba.np.arrayobj._empty_nd_impl": (
        ["context", "builder", "arrtype", "shapes"],
        "`memory.zeros` allocates as np.empty does",
    ),
    "numba.np.arrayobj.getitem_array_tuple": (
        ["context", "builder", "sig", "args"],
        "what is not a single element of a lent array is left to numba",
    ),
    "numba.np.arrayobj.getitem_arraynd_intp": (
        ["context", "builder", "sig", "args"],
        "as `getitem_array_tuple`, for one index",
    ),
    "numba.np.arrayobj.setitem_array": (
        ["context", "builder", "sig", "args"],
        "as `getitem_array_tuple`, for what is written",
    ),
    "numba.np.arrayobj.load_item": (
        ["context", "builder", "arrayty", "ptr"],
        "reads an element, or the address of a record",
    ),
    "numba.np.arrayobj.store_item": (["context", "builder", "arrayty", "val", "ptr"], "writes an element, or a record"),
}
METHODS = {
    "numba.core.caching.FunctionCache": {
        "load_overload": ["self", "sig", "target_context"],
        "_load_overload": ["self", "sig", "target_context"],
        "_guard_against_spurious_io_errors": ["self"],
        "save_overload": ["self", "sig", "data"],
        "flush": ["self"],
    },
    "numba.core.caching.IndexDataCacheFile": {
        "_load_index": ["self"],
        "_load_data": ["self", "name"],
        "_data_path": ["self", "name"],
        "_open_for_write": ["self", "filepath"],
    },
    # What numba asks of a locator, which `Shelf` answers.
    "numba.core.caching._CacheLocator": {
        "get_cache_path": ["self"],
        "ensure_cache_path": ["self"],
        "get_source_stamp": ["self"],
        "get_disambiguator": ["self"],
        "from_function": ["py_func", "py_file"],
    },
    "numba.core.codegen.JITCodeLibrary": {
        "finalize": ["self"],
        "add_linking_library": ["self", "library"],
        "get_pointer_to_function": ["self", "name"],
        "_optimize_functions": ["self", "ll_module"],
        "_get_module_for_linking": ["self"],
        "_finalize_dynamic_globals": ["self"],
        "serialize_using_object_code": ["self"],
        "_get_compiled_object": ["self"],
    },
    "numba.core.compiler.Compiler": {"_compile_core": ["self"]},
    "numba.core.typing.context.BaseContext": {"resolve_value_type": ["self", "val"]},
    "numba.core.dispatcher._FunctionCompiler": {"_compile_core": ["self", "args", "return_type"]},
    # `by_type_alone` replaces it on every compiled function; `kernel` sets `_cache` beside it.
    "numba.core.dispatcher.Dispatcher": {
        "get_call_template": ["self", "args", "kws"],
        "get_overload": ["self", "sig"],
        "enable_caching": ["self"],
        "_compilation_chain_init_hook": ["self"],
    },
}


def found(name: str):
    module, _, member = name.rpartition(".")
    return getattr(importlib.import_module(module), member)


def test_every_private_import_is_named_here():
    """Of the modules numba.core and numba.np, which are not its interface."""
    used = set()
    for file in JIT.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom) and (node.module or "").startswith(("numba.core", "numba.np")):
                used |= {f"{node.module}.{alias.name}" for alias in node.names}
    assert used == set(PRIVATE)


@pytest.mark.parametrize("name", PRIVATE)
def test_a_private_name_takes_what_we_pass(name):
    parameters, rests_on_it = PRIVATE[name]
    used = found(name)
    if parameters is not None:
        # As the first ones: numba may add others with a default.
        accepted = list(inspect.signature(used).parameters)
        assert accepted[: len(parameters)] == parameters, rests_on_it


@pytest.mark.parametrize("name", METHODS)
def test_a_private_class_has_the_methods_we_override_or_call(name):
    for method, parameters in METHODS[name].items():
        assert list(inspect.signature(getattr(found(name), method)).parameters) == parameters, f"{name}.{method}"


def test_attributes_of_the_cache_are_those_we_set():
    from numba.core import caching

    assert issubclass(caching.FunctionCache._impl_class, caching.CompileResultCacheImpl)
    assert isinstance(caching.CompileResultCacheImpl._locator_classes, list)
    asked = caching._CacheLocator.__abstractmethods__ | {"get_disambiguator", "from_function"}
    assert asked <= set(dir(Shelf)), "numba asks more of a locator than `Shelf` answers"


def test_symbols_are_named_by_a_property_that_we_replace():
    """`_symbol_name` shortens what a named tuple adds to a symbol: identifier and template parameters."""
    from numba.core import itanium_mangler

    from pounding_risk._jit.lowering import build

    assert build.INLINED, "the module is loaded"
    assert isinstance(numba.types.Type.mangling_args, property)
    kind = numba.typeof(compiling.lowered(LAWS["hertz"](1e9)))
    identifier, parameters = kind.mangling_args
    assert identifier.startswith("Hertz") and len(identifier) < 30 and parameters == ()
    assert identifier in itanium_mangler.mangle("f", [kind])


NAMED_BY_NUMBA = """
from llvmlite import binding as llvm
from numba import njit
from numba.core.registry import cpu_target
from numba.core.runtime import _nrt_python, rtsys
njit(lambda: 0)
rtsys.initialize(cpu_target.target_context)
names = {name: name if name.startswith("_") else f"NRT_{name}" for name in _nrt_python.c_helpers}
print([name for name, symbol in names.items() if llvm.address_of_symbol(symbol) != _nrt_python.c_helpers[name]])
"""


def test_functions_for_arrays_have_the_names_that_numba_gives_them():
    """`cache._add_array_functions` names them for machine code that is read back; in a process where it did not."""
    run = subprocess.run([sys.executable, "-c", NAMED_BY_NUMBA], capture_output=True, text=True, timeout=120)
    assert run.stdout.strip() == "[]", run.stderr


def test_helpers_of_generated_code_take_what_we_pass():
    from numba.core import cgutils

    assert list(inspect.signature(cgutils.unpack_tuple).parameters)[:2] == ["builder", "tup"]
    assert list(inspect.signature(cgutils.get_null_value).parameters) == ["ltype"]


@compiled
def test_a_kernel_has_our_cache_and_compiles_by_type_alone():
    """`kernel` sets the dispatcher's `_cache`; a row number in the source of a call compiles nothing anew."""

    @compiling.kernel
    def row_of(values, row):
        return values[row]

    @compiling.kernel
    def both(values):
        return row_of(values, 0) + row_of(values, 1)

    assert both(np.array([1.0, 2.0])) == 3.0
    assert row_of.signatures == [] and len(both.signatures) == 1, "what only kernels call has no machine code"
    assert len(both._compiler.fragments.signatures) == len(row_of._compiler.fragments.signatures) == 1
    if compile_cache() is not None:
        assert isinstance(both._cache, ForgivingCache)


@compiled
def test_a_record_is_one_pointer_and_shares_its_memory():
    """Documented for plain records; ours are nested, hold arrays, and are passed on from function to function."""
    inner = record_type(values=(2, 3), total=float)
    kind = record_type(left=inner, right=inner, place=(4,))

    @compiling.kernel
    def write(part, row):
        part.values[row, 1] += 2.0
        part.total = part.values.sum()
        return part.total

    @compiling.kernel
    def fill(work):
        return write(work.left, 0) + write(work.right, 1) + write(work.left, 0)

    record = new_record(kind)
    assert fill(record) == 8.0
    assert record.left.total == 4.0 and record.left.values[0, 1] == 4.0 and record.right.values[1, 1] == 2.0
    assert isinstance(numba.typeof(record), numba.types.Record)


def test_the_bound_is_there():
    """Without it an installation takes a numba that none of this has been tried with."""
    import tomllib

    project = tomllib.loads((JIT.parents[1] / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    (numba_bound,) = [entry for entry in project["dependencies"] if entry.startswith("numba")]
    assert "<" in numba_bound


@compiled
def test_numbas_own_code_is_taken_in_after_every_fragment():
    """LLVM takes in only what is called by then: a kernel from the cache would call address 0 for what is missing."""
    from pounding_risk._jit.lowering.fragments import Fragment, gathered

    class Made(Fragment):
        def __init__(self, *below):
            self._linking_libraries = list(below)

    arrays = object()
    inner = Made(arrays)
    outer = Made(arrays, inner)
    assert gathered([outer]) == [outer, inner, arrays]
