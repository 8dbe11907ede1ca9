"""The sources that kernels are made of, and the folder that keeps what is compiled of them.

Numba stamps a compiled function with the text of its own file only, so an edited contact law would go on answering with
its old numbers. The cache folder therefore carries a digest of every source file that kernels are made of,
`KERNEL_SOURCES`: any edit starts a new folder. Where the package is installed does not count, so that machines may
share one. A cache that can only be read is read; where none can be, nothing is kept, nor where another user can write
(`trust`). Of a class from anywhere else, a user's own law, nothing is kept: its source has no digest.
"""

from __future__ import annotations

import hashlib
import os
import tempfile
import warnings
from collections.abc import Iterator
from contextlib import suppress
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from pounding_risk._jit.trust import UntrustedCode, doubt, make_private
from pounding_risk.errors import PoundingError

SETTINGS = ".numba_config.yaml"  # numba looks for it in the working folder
KERNEL_SOURCES = ("_jit", "models", "solver", "lab/baselines", "motions/spectra.py", "units.py")


def _is_switched_off() -> bool:
    """True where numba is set not to compile, by NUMBA_DISABLE_JIT or the file of settings that it looks for."""
    if Path(SETTINGS).exists():
        try:
            from numba import config
        except Exception as error:  # whatever the reader of such files raises
            line = str(error).partition("\n")[0]
            raise PoundingError(
                f"{SETTINGS} in this folder: numba cannot read it ({type(error).__name__}: {line}); repair or remove it"
            ) from None
        return bool(config.DISABLE_JIT)
    with suppress(KeyError, ValueError):
        return bool(int(os.environ["NUMBA_DISABLE_JIT"]))
    return False


INTERPRETED = _is_switched_off()


def source_digest() -> str:
    """Digest of the kernels' sources and of the numba version: the name of the cache folder.

    Kernels import from these files alone; a test holds them to it.
    """
    package = Path(__file__).parents[1]
    digest = hashlib.sha256(_numba_version())
    sources = [package / name for name in KERNEL_SOURCES]
    for file in sorted(file for source in sources for file in ([source] if source.is_file() else source.rglob("*.py"))):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:16]


def _numba_version() -> bytes:
    """The file in which numba states its version: importing it, or asking for the package's metadata, takes longer."""
    numba = find_spec("numba")
    folders = numba.submodule_search_locations if numba is not None else None
    return (Path(folders[0]) / "_version.py").read_bytes() if folders else b""


@cache
def compile_cache() -> str | None:
    """The folder that this process keeps compiled kernels in; None where nothing is kept or compiled.

    Warns of UntrustedCode, once, where another user could write it.
    """
    if INTERPRETED:
        return None
    if why := cache_doubt():
        warnings.warn(f"compiled code is not kept: {why}", UntrustedCode, stacklevel=2)
    return _found()[0]


def cache_folder() -> str | None:
    """A folder for compiled kernels, or None: then nothing is cached.

    ``NUMBA_CACHE_DIR`` wins; otherwise the user's cache folder. One that holds compiled kernels will do if it can be
    read, as on the nodes of a cluster; else it must be one that can be written. A read-only home, or none, falls back
    to a private folder under the system's temporary one. One that another user can write is not used, nor another one
    in its place.
    """
    return _looked_for()[0]


def cache_doubt() -> str | None:
    """Why the folder is not used though it could be: another user can write it, and how to mend that."""
    return _found()[1]


@cache
def _found() -> tuple[str | None, str | None]:
    return _looked_for()


def _looked_for() -> tuple[str | None, str | None]:
    """The folder, or why it is not used."""
    for root in _cache_roots():
        folder = root / "pounding_risk" / source_digest()
        if why := doubt(folder, root):
            return None, why
        try:
            make_private(folder)
            tempfile.TemporaryFile(dir=folder).close()
        except OSError:
            if not _is_filled(folder):
                continue
        why = doubt(folder, root)  # what was not there a moment ago may be another user's now
        return (None, why) if why else (str(folder), None)
    return None, None


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
        yield Path(tempfile.gettempdir()) / f"pounding_risk-{user}"


def is_ours(kind: type) -> bool:
    """True for a class of this package, whose source the digest covers."""
    return kind.__module__.partition(".")[0] == __name__.partition(".")[0]
