"""Helpers of tests that start Python: the package's folder, and an environment that names no cache."""

from __future__ import annotations

import os
from pathlib import Path

import pytest

from pounding_risk._jit import sources as _jit

compiled = pytest.mark.skipif(_jit.INTERPRETED, reason="NUMBA_DISABLE_JIT is set: there is nothing compiled")
PACKAGE = Path(_jit.__file__).resolve().parents[1]


def bare_environment(**more: str) -> dict[str, str]:
    """The environment without what steers a cache; ``more`` on top."""
    steering = ("NUMBA_CACHE_DIR", "NUMBA_DISABLE_JIT", "XDG_CACHE_HOME", "HOME", "TMPDIR", "TEMP", "TMP")
    kept = {key: value for key, value in os.environ.items() if key not in steering}
    return {**kept, "PYTHONDONTWRITEBYTECODE": "1", **more}
