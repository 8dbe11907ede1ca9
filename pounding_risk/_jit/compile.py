"""Every decision about numba: flags, the compile cache, and how a model's verbs reach a kernel.

Flags: no ``fastmath`` (it deletes NaN guards and changes bits), ``error_model="numpy"`` (kernels report by
status, they do not raise), ``nogil`` (a scan is threads over compiled calls), ``no_cfunc_wrapper`` (nothing calls a
kernel by its address, and the wrapper takes its share of compiling).

Cache: numba stamps a compiled function with the text of its own file only, so an edited contact law would go
on answering with its old numbers. The cache folder therefore carries a digest of every source file that kernels
are made of, `KERNEL_SOURCES`: any edit starts a new folder. Where the package is installed does not
count, so that machines may share one. A cache that can only be read is read; where none can be, nothing is kept. Of a
class from anywhere else, a user's own law, nothing is kept: its source has no digest.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import stat
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from threading import Lock

import numba
from numba import config, njit, types
from numba.core import cgutils
from numba.core.caching import CompileResultCacheImpl, FunctionCache
from numba.extending import intrinsic, overload, overload_method
from numba.np.arrayobj import make_array, populate_array

from pounding_risk._jit.lowering.fragments import EntryCompiler, FragmentCompiler, InlinedCompiler

FLAGS = {"nogil": True, "error_model": "numpy", "fastmath": False, "no_cfunc_wrapper": True}
INLINED = {**FLAGS, "pipeline_class": InlinedCompiler}  # of a function that is always taken into its caller
KERNEL_SOURCES = ("_jit", "models", "solver", "motions/spectra.py", "units.py")
INTERPRETED = bool(config.DISABLE_JIT)


def _symbol_name(kind):
    """Name of a named tuple's type in the symbols of compiled functions: its class and a digest of its fields' types.

    Numba writes the fields out. A tuple that holds arrays of records would make symbols of ten thousand characters,
    and these most of the file that a compiled function is kept in.
    """
    name = kind.name.partition("(")[0]
    return name + hashlib.sha256(kind.name.encode()).hexdigest()[:16], ()


types.BaseNamedTuple.mangling_args = property(_symbol_name)


def source_digest() -> str:
    """Digest of the kernels' sources and of the numba version: the name of the cache folder.

    Kernels import from these files alone; a test holds them to it.
    """
    package = Path(__file__).parents[1]
    digest = hashlib.sha256(numba.__version__.encode())
    sources = [package / name for name in KERNEL_SOURCES]
    for file in sorted(file for source in sources for file in ([source] if source.is_file() else source.rglob("*.py"))):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> str | None:
    """A folder for compiled kernels, or None: then nothing is cached.

    ``NUMBA_CACHE_DIR`` wins; otherwise the user's cache folder. One that holds compiled kernels will do if it can be
    read, as on the nodes of a cluster; else it must be one that can be written. A read-only home, or none, falls back
    to a private folder under the system's temporary one.
    """
    for root in _cache_roots():
        folder = root / "pounding_risk" / source_digest()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=folder):
                return str(folder)
        except OSError:
            if _is_filled(folder):
                return str(folder)
    return None


def _is_filled(folder: Path) -> bool:
    """True for a folder in which compiled kernels can be read."""
    with suppress(OSError):
        return os.access(folder, os.R_OK | os.X_OK) and any(folder.rglob("*.nbi"))
    return False


def _cache_roots() -> Iterator[Path]:
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    if chosen:
        yield Path(chosen)
        return
    home = Path(os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache"))
    # Where nobody knows the user, "~" stays as it is and would become a folder in the working one.
    if home.is_absolute():
        yield home
    with suppress(OSError):
        user = str(os.getuid()) if hasattr(os, "getuid") else "user"
        private = Path(tempfile.gettempdir()) / f"pounding_risk-{user}"
        private.mkdir(mode=0o700, exist_ok=True)
        # Cached code is run: in a folder that all share, only from what nobody else can have written.
        if not hasattr(os, "getuid") or _is_mine_alone(private):
            yield private


def _is_mine_alone(folder: Path) -> bool:
    facts = folder.lstat()
    return stat.S_ISDIR(facts.st_mode) and facts.st_uid == os.getuid() and not facts.st_mode & 0o077


class Shelf:
    """Where the compiled forms of one kernel stand: in a folder named after its module, whose place on disk is nothing.

    Numba's own names the folder after that place, stamps it with the file's text, which our folder's name covers, and
    takes none that cannot be written.
    """

    def __init__(self, function, file):
        self._py_file = file
        self._path = os.path.join(CACHE or "", *function.__module__.split(".")[1:-1])
        self._line = function.__code__.co_firstlineno

    @classmethod
    def from_function(cls, function, file):
        """Constructor that numba calls; the folder does not depend on the file."""
        return cls(function, file)

    def get_cache_path(self):
        """Path of the folder with the cache entries."""
        return self._path

    def ensure_cache_path(self):
        """Have the folder; raises OSError where it cannot be written, before anything is."""
        os.makedirs(self._path, exist_ok=True)
        tempfile.TemporaryFile(dir=self._path).close()

    def get_source_stamp(self):
        """What a compiled form was made of: the name of the cache folder says it."""
        return ""

    def get_disambiguator(self):
        """What tells functions of one name apart."""
        return str(self._line)


class OnShelf(CompileResultCacheImpl):
    """Cache entries of one kernel, in the folder that its `Shelf` names."""

    _locator_classes = (Shelf,)


class ForgivingCache(FunctionCache):
    """The compiled forms of one kernel on disk, where nothing that is wrong with a file is an error.

    A file cut short by a full disk or a power cut counts as absent and is written anew. So does code for other
    types than asked: two processes that compile one kernel for two laws at once may give both the same file
    (numba issue 4807), and the other law would answer without a word.
    """

    _impl_class = OnShelf

    def load_overload(self, sig, target_context):
        """The compiled form for these types, or None."""
        if any(map(is_foreign, sig)):
            return None
        try:
            compiled_form = super().load_overload(sig, target_context)
        except Exception as error:  # unpickling a damaged file may raise anything
            warnings.warn(
                f"{self.cache_path}: a compiled kernel cannot be read ({error!r}); compiled anew", stacklevel=2
            )
            self._forget()
            return None
        if compiled_form is None or tuple(compiled_form.signature.args) == tuple(sig):
            return compiled_form
        self._forget()
        return None

    def save_overload(self, sig, data):
        """Keep a compiled form, where it can be kept."""
        # Read back for a class of the same name, it would answer with the numbers of the class as it was.
        if any(map(is_foreign, sig)):
            return
        try:
            super().save_overload(sig, data)
        except Exception as error:  # a damaged index raises anything, a full disk OSError
            warnings.warn(f"{self.cache_path}: a compiled kernel cannot be kept ({error!r})", stacklevel=2)
            self._forget()

    def _forget(self):
        with suppress(OSError):  # a folder that is gone needs no emptying
            self.flush()


CACHE = None if INTERPRETED else cache_folder()


def kernel(function):
    """Compile ``function``: the one decorator of every jitted function of the package."""
    if INTERPRETED:
        return function
    fragments = by_type_alone(njit(pipeline_class=FragmentCompiler, **FLAGS)(function))
    compiled = _entry_of(function, fragments)
    if CACHE is not None:
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
    return compiled


def small(function):
    """As `kernel`, for what is too small to be called: always taken into its caller.

    Left to LLVM, calls of these were a third of a run's time, in handing over arguments.
    """
    if INTERPRETED:
        return function
    compiled = by_type_alone(njit(**INLINED)(function))
    # Of a fragment there is nothing that Python could call: there it is the function that it was written as.
    compiled.add_overload = lambda result: compiled.overloads.update({tuple(result.signature.args): result})
    compiled._compile_for_args = lambda *arguments, **named: function
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


@intrinsic
def _without_reference(typingctx, array):
    def codegen(context, builder, signature, arguments):
        make = make_array(signature.args[0])
        source, view = make(context, builder, arguments[0]), make(context, builder)
        populate_array(
            view,
            data=source.data,
            shape=cgutils.unpack_tuple(builder, source.shape),
            strides=cgutils.unpack_tuple(builder, source.strides),
            itemsize=source.itemsize,
            meminfo=cgutils.get_null_value(source.meminfo.type),
            parent=cgutils.get_null_value(source.parent.type),
        )
        return view._getvalue()

    return array(array), codegen


def borrowed(array):
    """The same array, its references not counted: for the inside of a kernel whose caller holds the array.

    Counting is an atomic operation, and an array is handed over hundreds of times in one contact.
    """
    return array


if not INTERPRETED:
    borrowed = small(lambda array: _without_reference(array))


def is_ours(kind: type) -> bool:
    """True for a class of this package, whose source the digest covers."""
    return kind.__module__.partition(".")[0] == __name__.partition(".")[0]


def is_foreign(kind) -> bool:
    """True for a numba type that is, or holds, a named tuple from outside this package."""
    if isinstance(kind, types.BaseNamedTuple) and not is_ours(kind.instance_class):
        return True
    return isinstance(kind, types.BaseTuple) and any(map(is_foreign, kind.types))


_APART: dict[type, type] = {}
_NAMING = Lock()  # two threads would give one number twice


def apart(kind: type) -> type:
    """The class under a name that no other class has; a class of this package is its own.

    At a call numba tells named tuples apart by the *names* of their classes alone: a law that is defined again, as
    in a notebook, would be answered by the kernel of the one before it.
    """
    if is_ours(kind):
        return kind
    with _NAMING:
        if kind not in _APART:
            body = {"__slots__": (), "__module__": kind.__module__}
            own = type(f"{kind.__name__}#{len(_APART)}", (kind,), body)
            _APART[kind] = _APART[own] = own
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
    for name, method in vars(protocol).items():
        if name.startswith("_") or not inspect.isfunction(method):
            continue

        def resolve(model, *arguments, _name=name):
            return getattr(model.instance_class, _name, None)

        resolve.__signature__ = inspect.signature(method)  # type: ignore[attr-defined]
        overload_method(types.BaseNamedTuple, name, jit_options=INLINED)(resolve)
    return protocol


def by_verb(verb, place, those, others):
    """One kernel of two by the type of argument number ``place``: ``those`` where it has the method, else ``others``.

    Both take the same arguments. Compiled code holds the one that is meant, and nothing of the choice.
    """

    def choice(*arguments):
        return (those if hasattr(arguments[place], verb) else others)(*arguments)

    if INTERPRETED:
        return choice

    def resolve(*arguments):
        chosen = those if hasattr(arguments[place].instance_class, verb) else others
        return lambda *arguments: chosen(*arguments)

    overload(choice, jit_options=INLINED)(resolve)
    return choice
