"""Every decision about numba: flags, the compile cache, and how a model's verbs reach a kernel.

Flags: no ``fastmath`` (it deletes NaN guards and changes bits), ``error_model="numpy"`` (kernels report by
status, they do not raise), ``nogil`` (a scan is threads over compiled calls).

Cache: numba stamps a compiled function with the text of its own file only, so an edited contact law would go
on answering with its old numbers. The cache folder therefore carries a digest of every source file of the
package: any edit starts a new folder. A cache that cannot be written or read is left unused.
"""

from __future__ import annotations

import hashlib
import inspect
import os
import tempfile
from pathlib import Path

import numba
from numba import config, njit, types
from numba.extending import overload_method

FLAGS = {"nogil": True, "error_model": "numpy", "fastmath": False}
INTERPRETED = bool(config.DISABLE_JIT)


def source_digest() -> str:
    """Digest of the package's sources and of the numba version: the name of the cache folder."""
    package = Path(__file__).parent
    digest = hashlib.sha256(numba.__version__.encode())
    for file in sorted(package.rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def cache_folder() -> str | None:
    """A folder for compiled kernels that can be written, or None: then nothing is cached.

    ``NUMBA_CACHE_DIR`` wins; otherwise the user's cache folder. A read-only home, or none, falls back to a
    private folder under the system's temporary one.
    """
    chosen = os.environ.get("NUMBA_CACHE_DIR")
    roots = [Path(chosen)] if chosen else []
    if not chosen:
        home = os.environ.get("XDG_CACHE_HOME") or os.path.expanduser("~/.cache")
        user = str(os.getuid()) if hasattr(os, "getuid") else "user"
        roots = [Path(home), Path(tempfile.gettempdir()) / f"pounding_risk-{user}"]
    for root in roots:
        folder = root / "pounding_risk" / source_digest()
        try:
            folder.mkdir(parents=True, exist_ok=True)
            with tempfile.NamedTemporaryFile(dir=folder):
                return str(folder)
        except OSError:
            continue
    return None


CACHE = None if INTERPRETED else cache_folder()


def kernel(function):
    """Compile ``function``: the one decorator of every jitted function of the package."""
    if INTERPRETED:
        return function
    kept, config.CACHE_DIR = config.CACHE_DIR, CACHE or ""
    try:
        return njit(cache=CACHE is not None, **FLAGS)(function)
    finally:
        config.CACHE_DIR = kept


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

        resolve.__signature__ = inspect.signature(method)
        overload_method(types.BaseNamedTuple, name, jit_options=FLAGS)(resolve)
    return protocol
