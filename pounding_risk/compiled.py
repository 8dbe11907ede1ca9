"""Whether a kernel is compiled already, in this process or in the cache: asked without compiling anything."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from pounding_risk._jit import ForgivingCache, is_foreign


def is_compiled(kernel: Any, arguments: Iterable[Any]) -> bool:
    """True where a call of ``kernel`` with these very arguments would compile nothing.

    False of a kernel that is interpreted: calls of it are never fast.
    """
    if not hasattr(kernel, "typeof_pyval"):
        return False
    kinds = tuple(map(kernel.typeof_pyval, arguments))
    return kinds in kernel.overloads or _is_kept(kernel, kinds)


def _is_kept(kernel: Any, kinds: tuple[Any, ...]) -> bool:
    """True where the cache has code for these types that can be read; numba itself asks by compiling."""
    cache = kernel._cache
    if not isinstance(cache, ForgivingCache) or any(map(is_foreign, kinds)):
        return False
    try:
        key = cache._index_key(kinds, kernel.targetctx.codegen())
        return cache._cache_file.load(key) is not None
    except Exception:  # unpickling a damaged file may raise anything: such code is compiled anew
        return False
