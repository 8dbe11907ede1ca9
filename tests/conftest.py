"""Settings of all tests: Matplotlib opens no window, dates are fixed, hypothesis draws the same examples every time."""

from __future__ import annotations

import os
import signal
from pathlib import Path

import pytest
from hypothesis import HealthCheck, settings

os.environ.setdefault("MPLBACKEND", "Agg")
# Datasets tell when they were made: of two of one study every byte is compared, whatever the time.
os.environ["SOURCE_DATE_EPOCH"] = "1700000000"

# A shell starts background jobs with interrupts ignored, which every child would inherit: tests of Ctrl-C need them.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Compiling a kernel takes seconds the first time, so an example has no deadline.
settings.register_profile(
    "project",
    deadline=None,
    derandomize=True,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("project")


@pytest.fixture(scope="session")
def root() -> Path:
    """Root folder of the checkout."""
    return Path(__file__).resolve().parent.parent
