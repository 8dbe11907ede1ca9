"""Compiled kernels on disk: numba's cache, in a folder that our digest names, and forgiving."""

from __future__ import annotations

import os
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import cache
from pathlib import Path
from typing import BinaryIO

from llvmlite import binding as llvm  # type: ignore[import-untyped]
from numba import types
from numba.core.caching import CompileResultCacheImpl, FunctionCache, IndexDataCacheFile
from numba.core.runtime import _nrt_python

from pounding_risk._jit.sources import compile_cache, is_ours
from pounding_risk._jit.trust import doubt, file_doubt, make_private


def is_foreign(kind) -> bool:
    """True for a numba type that is, or holds, a named tuple from outside this package."""
    if isinstance(kind, types.BaseNamedTuple) and not is_ours(kind.instance_class):
        return True
    return isinstance(kind, types.BaseTuple) and any(map(is_foreign, kind.types))


@cache
def _add_array_functions() -> None:
    """Let machine code find the functions that make arrays and count references to them."""
    for name, address in _nrt_python.c_helpers.items():
        llvm.add_symbol(name if name.startswith("_") else f"NRT_{name}", address)


class Shelf:
    """Where the compiled forms of one kernel stand: in a folder named after its module, whose place on disk is nothing.

    Numba's own names the folder after that place, stamps it with the file's text, which our folder's name covers, and
    takes none that cannot be written.
    """

    def __init__(self, function, file):
        self._py_file = file
        self._path = os.path.join(compile_cache() or "", *function.__module__.split(".")[1:-1])
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
        make_private(Path(self._path))
        tempfile.TemporaryFile(dir=self._path).close()

    def get_source_stamp(self):
        """What a compiled form was made of: the name of the cache folder says it."""
        return ""

    def get_disambiguator(self):
        """The line of the source, which distinguishes functions of one name in one module."""
        return str(self._line)


class OnShelf(CompileResultCacheImpl):
    """Cache entries of one kernel, in the folder that its `Shelf` names."""

    _locator_classes = (Shelf,)


@cache
def _folder_doubt(folder: str) -> str | None:
    return doubt(Path(folder), Path(compile_cache() or folder).parents[1])


class OwnFiles(IndexDataCacheFile):
    """Index and data files that this user or root has written; what anyone else could have counts as absent."""

    def _load_index(self):
        return super()._load_index() if self._is_own(self._index_path) else {}

    def _load_data(self, name):
        if not self._is_own(self._data_path(name)):
            raise FileNotFoundError(name)
        return super()._load_data(name)

    def _is_own(self, path: str) -> bool:
        why = _folder_doubt(self._cache_path) or file_doubt(Path(path))
        if why is None:
            return True
        warnings.warn(f"{self._cache_path}: a compiled kernel cannot be trusted ({why})", stacklevel=2)
        return False

    @contextmanager
    def _open_for_write(self, filepath: str) -> Iterator[BinaryIO]:
        """A file aside, that this user alone can read and write whatever the umask, renamed when it is written."""
        handle, aside = tempfile.mkstemp(dir=self._cache_path, suffix=".tmp")
        try:
            with os.fdopen(handle, "wb") as file:
                yield file
            os.replace(aside, filepath)
        except BaseException:
            with suppress(OSError):
                os.unlink(aside)
            raise


class ForgivingCache(FunctionCache):
    """The compiled forms of one kernel on disk, where nothing that is wrong with a file is an error.

    A file cut short by a full disk or a power cut counts as absent and is written anew. So does code for other
    types than asked: two processes that compile one kernel for two laws at once may give both the same file
    (numba issue 4807), and the other law would answer without a word.
    """

    _impl_class = OnShelf

    def __init__(self, function):
        super().__init__(function)
        stamp = self._impl.locator.get_source_stamp()
        self._cache_file = OwnFiles(self.cache_path, self._impl.filename_base, stamp)

    def load_overload(self, sig, target_context):
        """The compiled form for these types, or None."""
        if any(map(is_foreign, sig)):
            return None
        compiled_form = None
        try:
            # Numba's own method would load the declarations of all that can be compiled, which takes longer than all
            # else at a start. Machine code needs numba's functions for arrays from it, and no others.
            _add_array_functions()
            with self._guard_against_spurious_io_errors():
                compiled_form = self._load_overload(sig, target_context)
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
