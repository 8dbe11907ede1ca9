"""No run is lost: fifty kills at random moments of five studies, and the files that come of them."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest
from processes import output

SCRIPT = Path(__file__).parents[1] / "killed_scans.py"


@pytest.mark.complete
def test_a_killed_scan_ends_in_the_file_of_one_that_nobody_disturbed(tmp_path):
    """Bit-identical each time, with one to four threads, and at no moment a partial file under the final name."""
    if not hasattr(os, "fork"):
        pytest.skip("SIGKILL and fork are POSIX")
    told = json.loads(output(SCRIPT, tmp_path, 5, 50, 20110314, timeout=600))
    assert told["wrong"] == []
    assert told["kills"] >= 50 and told["studies"] >= 5
