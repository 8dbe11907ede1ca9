"""Run code with numba switched off, in another process."""

from __future__ import annotations

import json
import os
from pathlib import Path
from typing import Any

from processes import PACKAGE, output


def interpreted(code: str) -> Any:
    """What ``code`` prints, read as JSON; it finds this very package and the modules of the tests."""
    tests = Path(__file__).parent
    folders = (folder for folder in tests.iterdir() if folder.is_dir())
    places = [tests, *folders, PACKAGE.parent]
    environment = {**os.environ, "NUMBA_DISABLE_JIT": "1", "PYTHONPATH": os.pathsep.join(map(str, places))}
    return json.loads(output("-c", code, env=environment, timeout=300))
