"""What long work is asked to call on its way."""

from __future__ import annotations

from collections.abc import Callable

Progress = Callable[[int, int], None]  # how many are done, and how many there are: cases, records, trials
