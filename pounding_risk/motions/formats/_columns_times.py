"""A column of numbers, and the time step that a column of times means."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats._text import check_step, number, quoted

LOOSEST, TIGHTEST = 0.1, 1e-3  # of the time step: how far off a time may be at most, and may always be


def column(name: str, first: int, words: list[str]) -> NDArray[np.float64]:
    """The numbers of a column; ``first`` is the index of the line that its first word stands in.

    Raises RecordError, naming the line, for a word that is no finite number.
    """
    values = [number(word) for word in words]
    for at, value in enumerate(values):
        if value is None:
            raise RecordError(
                f"{name}, line {first + at + 1}: {quoted(words[at])} is not a finite number; every line after the head "
                "must hold plain numbers such as -0.0123: repair that line, or fetch the file again"
            )
    return np.array(values, dtype=np.float64)


def step_of_times(name: str, first: int, words: list[str]) -> tuple[float, float]:
    """The time step [s] of a column of times [s], and how far off the last of them may be [s].

    Times rise in equal steps where each is off its place on the line from the first to the last by no more than one
    unit of the last digit printed (of the most decimals, or of the most significant digits, whichever is coarser) and
    no more than a tenth of the step; a thousandth of it is always allowed. The step is the decimal of fewest digits
    that fits. Raises RecordError, naming the line, where they do not.
    """
    times = column(name, first, words)
    rises = np.diff(times)
    flat = np.flatnonzero(~(rises > 0.0))
    if len(flat):
        at = int(flat[0]) + 1
        raise RecordError(
            f"{name}, line {first + at + 1}: the time {words[at]} is not after the {words[at - 1]} of the line before; "
            "write times that rise, with enough digits to tell them apart"
        )
    steps = len(times) - 1
    step = float(times[-1] - times[0]) / steps
    check_step(f"{name}, line {first + 1}", step, f"{step:g}", "the step of the times")
    off = np.clip(_last_digit(times, words), TIGHTEST * step, LOOSEST * step)
    if (np.abs(times - (times[0] + np.arange(steps + 1) * step)) > off).any():
        usual = float(np.median(rises))
        at = int(np.argmax(np.abs(rises - usual))) + 1
        raise RecordError(
            f"{name}, line {first + at + 1}: the times do not rise in equal steps, by {rises[at - 1]:.6g} s here and "
            f"by {usual:.6g} s elsewhere; restore missing lines, print more digits, or resample to equal steps"
        )
    return _shortest(step, float(off[-1]) / steps), float(off[-1])


def _last_digit(times: NDArray[np.float64], words: list[str]) -> NDArray[np.float64]:
    """One unit of the last digit printed of each time [s]."""
    decimals, digits = 0, 1
    for word in words:
        mantissa, _, exponent = word.lower().replace("d", "e").partition("e")
        whole, _, fraction = mantissa.lstrip("+-").partition(".")
        decimals = max(decimals, len(fraction) - int(exponent or 0))
        digits = max(digits, len((whole + fraction).lstrip("0")))
    leading = np.floor(np.log10(np.maximum(np.abs(times), 1e-12))) + 1.0
    return np.asarray(10.0 ** np.maximum(-min(decimals, 20), leading - digits), dtype=np.float64)


def _shortest(value: float, off: float) -> float:
    """The decimal of fewest digits within ``off`` of ``value``: 0.01 and not 0.010000000000000002."""
    return next((short for digits in range(16) if abs((short := round(value, digits)) - value) <= off), value)
