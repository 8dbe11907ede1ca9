"""Helpers of tests that start Python: processes with this very package, and an environment that names no cache."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from pounding_risk._jit import sources as _jit

compiled = pytest.mark.skipif(_jit.INTERPRETED, reason="NUMBA_DISABLE_JIT is set: there is nothing compiled")
PACKAGE = Path(_jit.__file__).resolve().parents[1]


def bare_environment(**more: str) -> dict[str, str]:
    """The environment without what steers a cache; ``more`` on top."""
    steering = ("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "XDG_CACHE_HOME", "HOME", "TMPDIR", "TEMP", "TMP")
    kept = {key: value for key, value in os.environ.items() if key not in steering}
    return {**kept, "PYTHONDONTWRITEBYTECODE": "1", **more}


def python(*words: object, **options: Any) -> subprocess.Popen[str]:
    """A process of Python with this package and the helpers of its tests, whose ends are open."""
    folders = os.pathsep.join(map(str, (PACKAGE.parent, Path(__file__).parent)))
    given: dict[str, Any] = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    given |= {"env": {**os.environ, "PYTHONPATH": folders}, "text": True} | options
    return subprocess.Popen([sys.executable, *map(str, words)], **given)


def told(*words: object, timeout: float = 120.0, **options: Any) -> tuple[str, str]:
    """What such a process, which must succeed, prints, and what it writes to standard error."""
    process = python(*words, **options)
    out, errors = process.communicate(timeout=timeout)
    assert process.returncode == 0, errors
    return out, errors


def output(*words: object, **options: Any) -> str:
    """What such a process prints."""
    return told(*words, **options)[0]
