"""The band-pass filter of the processing chain; see `pounding_risk.processing`."""

from __future__ import annotations

from math import ceil, inf

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.quantities import TIME, Quantity, say
from pounding_risk.signals import Samples, butterworth
from pounding_risk.steps import ORDER, Done, step

CORNER = Quantity("Hz", 0.0, inf, "corner frequency", example="0.1 Hz")
LOW_CORNER = 0.08  # Hz, gmprocess' fallback where the noise says nothing
HIGHEST_CORNER, NYQUIST_SHARE = 40.0, 0.75  # Hz; of the Nyquist frequency
STRIPPED, KEPT = "stripped", "kept"
ENDS_OF_PEAK = 0.02  # |a| at the ends above this part of PGA is flagged


@step("bandpass", low=CORNER, high=CORNER, order=ORDER, pads=(STRIPPED, KEPT))
def bandpass(
    samples: Samples,
    dt: float,
    *,
    low: float = LOW_CORNER,
    high: float | None = None,
    order: float = 5,
    pads: str = STRIPPED,
) -> Done:
    """Acausal Butterworth filter: the amplitude response, -3 dB at each corner [Hz], and no phase.

    |H(f)| = 1/sqrt(1 + (low/f)^2n) · 1/sqrt(1 + (f/high)^2n), once, in the frequency domain. A causal filter
    would move the peaks (+3 to +6 % in the gap that a pair needs), and pads of zeros keep the ends from
    wrapping round: 0.75 n/low seconds at each (Converse and Brady 1992; Boore 2005). ``low`` 0 is a low-pass;
    ``high`` is 40 Hz unless given, and never above 3/4 of the Nyquist frequency by default.

    ``pads`` "stripped" leaves the record's length; the filter's ringing before and after it is cut off, which a
    baseline correction makes good. "kept" leaves the ringing and the pads, so that velocity and displacement
    start and end at rest by themselves (Boore 2005): for models that take absolute ground motion. The motion
    then starts that much earlier.
    """
    upper = _upper(low, high, dt)
    pad = ceil(0.75 * order / (low or upper) / dt)
    padded = np.pad(samples, pad)
    size = 1 << (len(padded) - 1).bit_length()  # more zeros still, and a fast transform
    gain = butterworth(np.fft.rfftfreq(size, dt), low, upper, order)
    filtered = np.fft.irfft(np.fft.rfft(padded, size) * gain, size)[: len(padded)]
    words, flags = _filter_words(low, upper, order, pad * dt), _filter_flags(samples, dt, low)
    if pads == KEPT:
        return Done(filtered, f"{words}, kept", flags, -pad)
    return Done(filtered[pad : pad + len(samples)], words, flags)


def _upper(low: float, high: float | None, dt: float) -> float:
    """The upper corner [Hz]; raises RecordError where the corners do not fit the time step."""
    nyquist = 0.5 / dt
    upper = min(HIGHEST_CORNER, NYQUIST_SHARE * nyquist) if high is None else high
    if not (low < upper and (upper < nyquist or (upper == inf and low > 0.0))):
        raise RecordError(
            f"the corners {low:g} and {upper:g} Hz do not fit a time step of {dt:g} s; they must rise and "
            f"stay below the Nyquist frequency of {nyquist:g} Hz (inf for no upper corner)"
        )
    return upper


def _filter_words(low: float, high: float, order: float, pad: float) -> str:
    corners = f"{low:g} to {high:g} Hz" if low and high < inf else f"above {low:g} Hz" if low else f"below {high:g} Hz"
    pads = f"{pad:.4g} s of zeros at both ends"
    return f"bandpass: acausal Butterworth of order {order:g}, {corners} (-3 dB), {pads}"


def _filter_flags(samples: Samples, dt: float, low: float) -> tuple[str, ...]:
    """Doubts about what went into the filter."""
    flags = []
    peak = float(np.abs(samples).max())
    if max(abs(samples[0]), abs(samples[-1])) > ENDS_OF_PEAK * peak:
        flags.append("the record was filtered with ends above 2 % of its peak: subtract the mean and taper before")
    duration = (len(samples) - 1) * dt
    if 0.0 < low < 1.0 / duration:
        flags.append(f"the lower corner {low:g} Hz is below one cycle in the record of {say(duration, TIME)}")
    return tuple(flags)
