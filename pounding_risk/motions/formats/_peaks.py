"""Comparison of the peak that a file states with the samples in it."""

from __future__ import annotations

import re
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.errors import RecordError
from pounding_risk.motions.formats._text import number

# Agencies convert with 980, 980.665 or 981 cm/s² in one g, which differ by 1.02e-3; in the 27 real
# components of the tests the two agree within the digits that are printed.
CONVERSION = 1.1e-3
MOST_DECIMALS = 9  # of samples in fixed columns

_DIGITS = re.compile(r"[+-]?\d*\.?(?P<decimals>\d*)(?:[EeDd](?P<exponent>[+-]?\d+))?", re.ASCII)


class StatedPeak(NamedTuple):
    """The largest acceleration that a header states, without its sign, and where it does."""

    value: float  # in the header's unit
    rounding: float  # half of the last digit printed, in that unit
    unit: str
    size: float  # m/s² in one of that unit; 1 where samples are compared in the unit of the file
    place: str  # file and line


def stated_peak(word: str, unit: str, size: float, where: str) -> StatedPeak | None:
    """The peak of a header's number as text; None where it is no number, or zero, which stands for not evaluated."""
    value = number(word.strip())
    return StatedPeak(abs(value), half_digit(word.strip()), unit, size, where) if value else None


def half_digit(word: str) -> float:
    """Half of the last digit that a number is printed with: 0.0005 of -.058."""
    match = _DIGITS.fullmatch(word)
    if match is None:
        raise ValueError(f"{word!r} is not a number")
    return 0.5 * 10.0 ** (int(match["exponent"] or 0) - len(match["decimals"]))


def check_peak(
    samples: NDArray[np.float64], *readings: StatedPeak | None, relative: float = CONVERSION
) -> StatedPeak | None:
    """Raise RecordError where the largest of the samples, or of the samples less their mean, is not the stated one.

    Parameters
    ----------
    samples : array
        Accelerations [m/s²], or in the file's unit where ``StatedPeak.size`` is 1.
    readings : StatedPeak or None
        What the header's number may mean; one must fit. Nothing is checked where one of them is None: not stated.
    relative : float
        How far the two may differ beyond the rounding of header and samples, as a share of the peak.

    Returns
    -------
    StatedPeak or None
        The reading that fits; None where nothing is stated.

    Raises
    ------
    RecordError
        Naming file, line and both peaks.
    """
    if not readings or None in readings:
        return None
    stated = [peak for peak in readings if peak is not None]
    with np.errstate(over="ignore", invalid="ignore"):
        largest = float(np.abs(samples).max())
        less_mean = float(np.abs(samples - samples.mean()).max())
    for peak in stated:
        if any(_agree(samples, peak, peak_found, relative) for peak_found in (largest, less_mean)):
            return peak
    first = stated[0]
    raise RecordError(
        f"{first.place}: the header says that the largest sample is {first.value:.6g} {first.unit}, it is "
        f"{largest / first.size:.6g}; samples or header are damaged: fetch the file again"
    )


def _agree(samples: NDArray[np.float64], peak: StatedPeak, largest: float, relative: float) -> bool:
    """True where the peak found is the stated one, within the rounding of both and a share of it."""
    off = abs(largest - peak.value * peak.size) - peak.rounding * peak.size - relative * peak.value * peak.size
    return bool(off <= 0.0 or off <= _half_digit_of_samples(samples / peak.size) * peak.size)


def _half_digit_of_samples(samples: NDArray[np.float64]) -> float:
    """Half of the last decimal that samples in fixed columns were printed with; 0 where they were not."""
    with np.errstate(over="ignore", invalid="ignore"):
        for decimals in range(MOST_DECIMALS + 1):
            scaled = np.abs(samples) * 10.0**decimals
            # A float has about 16 digits, of which units took some.
            if np.abs(scaled - np.rint(scaled)).max() <= 1e-10 * scaled.max():
                return 0.5 * 10.0**-decimals
    return 0.0
