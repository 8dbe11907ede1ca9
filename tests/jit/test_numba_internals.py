"""What the package uses of numba beyond its public interface: read this when numba's upper bound is raised.

Numba promises nothing about these. Raise the bound in pyproject.toml, run this module, then `tests/jit` and
`tests/results/test_shipped_numbers.py`. What fails here says which part of numba has changed, and what of ours rests on
it; what passes may still have changed its meaning, which the other two show.
"""

import ast
import importlib
import inspect
from pathlib import Path

import numba
import numpy as np
import pytest
from processes import compiled, output

from pounding_risk import _jit
from pounding_risk._jit import compile as compiling
from pounding_risk._jit.lowering.cache import ForgivingCache, Shelf
from pounding_risk._jit.memory import new_record, record_type
from pounding_risk._jit.sources import compile_cache
from pounding_risk.models.contact.laws import LAWS

JIT = Path(_jit.__path__[0])

# Private names with the parameters that we pass, and what rests on them; methods with theirs.
NAMES, METHODS = (
    [line for line in part.splitlines() if line and not line.startswith("#")]
    for part in (Path(__file__).parent / "numba_internals.txt").read_text("utf-8").split("\n\n")
)
PRIVATE = {line.partition(":")[0].partition("(")[0]: line for line in NAMES}


def parameters(call: str) -> list[str]:
    """Of a call as it is written."""
    return [name for name in call.partition("(")[2].partition(")")[0].split(", ") if name]


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
    line, used = PRIVATE[name], found(name)
    if line.startswith(f"{name}("):
        # As the first ones: numba may add others with a default.
        passed = parameters(line)
        assert list(inspect.signature(used).parameters)[: len(passed)] == passed, line


@pytest.mark.parametrize("method", METHODS)
def test_a_private_class_has_the_methods_we_override_or_call(method):
    owner, _, name = method.partition("(")[0].rpartition(".")
    assert list(inspect.signature(getattr(found(owner), name)).parameters) == parameters(method)


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


@pytest.mark.complete
def test_functions_for_arrays_have_the_names_that_numba_gives_them():
    """`cache._add_array_functions` names them for machine code that is read back; in a process where it did not."""
    assert output("-c", NAMED_BY_NUMBA).strip() == "[]"


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

    if compile_cache() is not None:
        assert isinstance(both._cache, ForgivingCache)
        both._cache.flush()  # of what an earlier run of the tests kept
    assert both(np.array([1.0, 2.0])) == 3.0
    assert row_of.signatures == [] and len(both.signatures) == 1, "what only kernels call has no machine code"
    assert len(both._compiler.fragments.signatures) == len(row_of._compiler.fragments.signatures) == 1


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
