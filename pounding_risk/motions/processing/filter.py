"""The band-pass filter of the processing chain; see `pounding_risk.motions.processing`."""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import ORDER, Done, step
from pounding_risk.motions.processing.noise import Corners, corners_from_noise, default_corners
from pounding_risk.motions.processing.signals import Samples, filtered
from pounding_risk.units import TIME, Quantity, say

CORNER = Quantity("Hz", 0.0, inf, "corner frequency", example="0.1 Hz")
NOISE, DEFAULT = "noise", "default"
STRIPPED, KEPT = "stripped", "kept"
ENDS_OF_PEAK = 0.02  # |a| at the ends above this part of PGA is flagged
FEWEST_CYCLES = 0.02  # of the lowest corner in the record: the pads are hundreds of records long then


@step("bandpass", low=CORNER, high=CORNER, order=ORDER, corners=(NOISE, DEFAULT), pads=(STRIPPED, KEPT))
def bandpass(
    samples: Samples,
    dt: float,
    *,
    low: float | None = None,
    high: float | None = None,
    order: float = 5,
    corners: str = NOISE,
    pads: str = STRIPPED,
) -> Done:
    """Acausal Butterworth filter: the amplitude response, -3 dB at each corner [Hz], and no phase.

    |H(f)| = 1/sqrt(1 + (low/f)^2n) · 1/sqrt(1 + (f/high)^2n), once, in the frequency domain. A causal filter
    would move the peaks (+3 to +6 % in the gap that a pair needs), and pads of zeros keep the ends from
    wrapping round: 0.75 n/low seconds at each (Converse and Brady 1992; Boore 2005). ``low`` 0 is a low-pass.

    A corner that is not given comes from the noise before the earthquake (`pounding_risk.motions.processing.noise`);
    with ``corners`` "default" they are 0.08 Hz and 40 Hz or 3/4 of the Nyquist frequency, whatever the noise.

    ``pads`` "stripped" leaves the record's length; the filter's ringing before and after it is cut off, which a
    baseline correction makes good. "kept" leaves the ringing and the pads, so that velocity and displacement
    start and end at rest by themselves (Boore 2005): for models that take absolute ground motion. The motion
    then starts that much earlier.
    """
    chosen = _chosen(samples, dt, (low, high), corners)
    _check(chosen, dt, (len(samples) - 1) * dt)
    passed, pad = filtered(samples, dt, (chosen.low, chosen.high), order)
    flags = (*chosen.flags, *_filter_flags(samples, dt, chosen.low))
    words = _filter_words(chosen, order, pad * dt)
    band = (chosen.low, chosen.high)
    if pads == KEPT:
        return Done(passed, f"{words}, kept", flags, -pad, band=band)
    return Done(passed[pad : pad + len(samples)], words, flags, band=band)


def _chosen(samples: Samples, dt: float, corner_pair: tuple[float | None, float | None], corners: str) -> Corners:
    """The corners: as given, and from the noise or by default where one is not given."""
    low, high = corner_pair
    if low is not None and high is not None:
        return Corners(low, high, "")
    usual = default_corners(dt, "by default") if corners == DEFAULT else corners_from_noise(samples, dt)
    if low is not None:
        return Corners(low, usual.high, f"the upper corner: {usual.words}", usual.flags)
    if high is not None:
        return Corners(usual.low, high, f"the lower corner: {usual.words}", usual.flags)
    return usual


def _check(corners: Corners, dt: float, duration: float) -> None:
    """Raise RecordError for corners that do not rise or do not fit the time step or the record."""
    low, high, nyquist = corners.low, corners.high, 0.5 / dt
    if not (low < high and (high < nyquist or (high == inf and low > 0.0))):
        raise RecordError(
            f"the corners {low:g} and {high:g} Hz do not fit a time step of {dt:g} s; they must rise and "
            f"stay below the Nyquist frequency of {nyquist:g} Hz (inf for no upper corner)"
        )
    lowest = low or high
    if lowest < FEWEST_CYCLES / duration:
        raise RecordError(
            f"the corner {lowest:g} Hz is {lowest * duration:.2g} of a cycle in the record of {say(duration, TIME)}; "
            f"write {FEWEST_CYCLES / duration:.2g} Hz or more"
        )


def _filter_words(corners: Corners, order: float, pad: float) -> str:
    low, high = corners.low, corners.high
    band = (
        f"{low:.4g} to {high:.4g} Hz"
        if low and high < inf
        else f"above {low:.4g} Hz"
        if low
        else f"below {high:.4g} Hz"
    )
    why = f"; {corners.words}" if corners.words else ""
    return f"bandpass: acausal Butterworth of order {order:g}, {band} (-3 dB){why}; {pad:.4g} s of zeros at both ends"


def _filter_flags(samples: Samples, dt: float, low: float) -> tuple[str, ...]:
    """Flags for samples that should not be filtered as they are, and for a corner below one cycle."""
    flags = []
    peak = float(np.abs(samples).max())
    if max(abs(samples[0]), abs(samples[-1])) > ENDS_OF_PEAK * peak:
        flags.append("the record was filtered with ends above 2 % of its peak: subtract the mean and taper before")
    duration = (len(samples) - 1) * dt
    if 0.0 < low < 1.0 / duration:
        flags.append(f"the lower corner {low:g} Hz is below one cycle in the record of {say(duration, TIME)}")
    return tuple(flags)
