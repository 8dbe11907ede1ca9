"""Helpers of tests that start Python: processes with this very package, and an environment that names no cache."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
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


def python(*words: object, env: Mapping[str, str] = os.environ, **options: Any) -> subprocess.Popen[str]:
    """A process of Python with this package and the modules of its tests, whose ends are open."""
    tests = Path(__file__).parent
    folders = [PACKAGE.parent, tests, *(folder for folder in tests.iterdir() if folder.is_dir())]
    ends = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.PIPE)
    path = os.pathsep.join([*filter(None, [env.get("PYTHONPATH")]), *map(str, folders)])
    command = [sys.executable, *map(str, words)]
    return subprocess.Popen(command, env={**env, "PYTHONPATH": path}, text=True, **(ends | options))


def ended(*words: object, timeout: float = 120.0, **options: Any) -> subprocess.CompletedProcess[str]:
    """Such a process at its end, with what it printed."""
    process = python(*words, **options)
    out, errors = process.communicate(timeout=timeout)
    return subprocess.CompletedProcess(words, process.returncode, out, errors)


def told(*words: object, **options: Any) -> tuple[str, str]:
    """What such a process, which must succeed, prints, and what it writes to standard error."""
    process = ended(*words, **options)
    assert process.returncode == 0, process.stderr
    return process.stdout, process.stderr


def output(*words: object, **options: Any) -> str:
    """What such a process prints."""
    return told(*words, **options)[0]


def interpreted(code: str) -> Any:
    """What code prints with numba switched off, read as JSON."""
    return json.loads(output("-c", code, env={**os.environ, "NUMBA_DISABLE_JIT": "1"}, timeout=300))
