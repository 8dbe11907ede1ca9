"""Run code with numba switched off, in another process."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path
from typing import Any

import pounding_risk


def interpreted(code: str) -> Any:
    """What ``code`` prints, read as JSON; it finds this very package and the modules of the tests."""
    tests = Path(__file__).parent
    folders = (folder for folder in tests.iterdir() if folder.is_dir())
    places = [tests, *folders, Path(pounding_risk.__file__).parent.parent]
    made = subprocess.run(
        [sys.executable, "-c", code],
        env={**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(map(str, places))},
        capture_output=True,
        text=True,
        timeout=300,
    )
    assert made.returncode == 0, made.stderr
    return json.loads(made.stdout)
