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
    low, high = chosen.low, chosen.high
    duration, nyquist = (len(samples) - 1) * dt, 0.5 / dt
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
    passed, pad = filtered(samples, dt, (low, high), order)
    flags = list(chosen.flags)
    if max(abs(samples[0]), abs(samples[-1])) > ENDS_OF_PEAK * float(np.abs(samples).max()):
        flags.append("the record was filtered with ends above 2 % of its peak: subtract the mean and taper before")
    if 0.0 < low < 1.0 / duration:
        flags.append(f"the lower corner {low:g} Hz is below one cycle in the record of {say(duration, TIME)}")
    band = f"{low:.4g} to {high:.4g} Hz"
    if not low:
        band = f"below {high:.4g} Hz"
    elif high == inf:
        band = f"above {low:.4g} Hz"
    why = f"; {chosen.words}" if chosen.words else ""
    words = f"bandpass: acausal Butterworth of order {order:g}, {band} (-3 dB){why}; {pad * dt:.4g} s of zeros"
    if pads == KEPT:
        return Done(passed, f"{words} at both ends, kept", tuple(flags), -pad, band=(low, high))
    return Done(passed[pad : pad + len(samples)], f"{words} at both ends", tuple(flags), band=(low, high))


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
