"""No run is lost: fifty kills at random moments of five studies, and the files that come of them."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

import pounding_risk

SCRIPT = Path(__file__).parents[1] / "killed_scans.py"


@pytest.mark.slow
def test_a_killed_scan_ends_in_the_file_of_one_that_nobody_disturbed(tmp_path):
    """Bit-identical each time, with one to four threads, and at no moment a partial file under the final name."""
    if not hasattr(os, "fork"):
        pytest.skip("SIGKILL and fork are POSIX")
    environment = {**os.environ, "PYTHONPATH": str(Path(pounding_risk.__file__).parent.parent)}
    done = subprocess.run(
        [sys.executable, str(SCRIPT), str(tmp_path), "5", "50", "20110314"],
        env=environment,
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert done.returncode == 0, done.stderr
    told = json.loads(done.stdout)
    assert told["wrong"] == []
    assert told["kills"] >= 50 and told["studies"] >= 5
