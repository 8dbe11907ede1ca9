"""The option ``--short`` of every benchmark: numbers so small that it runs in seconds, to see that it still does."""

from __future__ import annotations

import os
import sys
from typing import TypeVar

T = TypeVar("T")
VARIABLE = "POUNDING_SHORT_BENCHMARKS"  # in the environment, since benchmarks start processes of their own

if "--short" in sys.argv[1:]:
    sys.argv.remove("--short")
    os.environ[VARIABLE] = "1"
IS_SHORT = VARIABLE in os.environ


def either(full: T, short: T) -> T:
    """What the benchmark measures, or with ``--short`` the little that shows that it runs."""
    return short if IS_SHORT else full
