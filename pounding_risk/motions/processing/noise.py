"""The band-pass filter of the processing chain, and its corners by the signal-to-noise ratio of a record.

The quiet before the earthquake shows the noise. Its Fourier amplitudes, grown to the length of the earthquake, are set
beside the earthquake's; the band in which the earthquake stands out is worth keeping. Baseline shifts come with the
shaking and not before it, so that noise is seen otherwise: by the drift that it leaves in the displacement.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import floor, inf, pi, sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import ORDER, Done, signals, step
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import TIME, Quantity, say

CORNER = Quantity("Hz", 0.0, inf, "corner frequency", example="0.1 Hz")
NOISE, DEFAULT = "noise", "default"
STRIPPED, KEPT = "stripped", "kept"
ENDS_OF_PEAK = 0.02  # |a| at the ends above this part of PGA is flagged
FEWEST_CYCLES = 0.02  # of the lowest corner in the record: the pads are hundreds of records long then
LONGEST_LEAD = 1.0  # s, or half of the quiet: what a taper at the start has made smaller is no noise
SHORTEST_NOISE = 2.0  # s after that: two cycles of the frequency around which the band is looked for
CENTRE = 1.0  # Hz, within every band worth having
LEAST_RATIO = 2.0  # of amplitudes, gmprocess' (U.S. Geological Survey)
BAND = (0.3, 5.0)  # Hz: what buildings respond to; a lower ratio anywhere in it is flagged
LOW_CORNER = 0.08  # Hz, gmprocess' fallback where the noise says nothing
HIGHEST_CORNER, NYQUIST_SHARE = 40.0, 0.75  # Hz; of the Nyquist frequency
BANDWIDTH = 20.0  # b of Konno and Ohmachi (1998)
PER_DECADE = 40  # frequencies of the smoothed spectra
TAPERED = 0.05  # of a window, at each end
ENERGY, AFTER = 0.95, 5.0  # the earthquake ends this many seconds after this part of its energy has come
DRIFT, DRIFT_ORDER = 0.02, 6  # of PGD; of the polynomial that is the drift
SLOW, DRIFT_STEP = 2.0, 0.05  # Hz and s: displacement has little above, and a tenth of the samples are enough
HIGHEST_LOW, TRIES_PER_DECADE = 0.5, 20  # Hz, from which the lower corner goes down as long as nothing drifts
FILTER_ORDER = 5.0


class NoiseSpectra(NamedTuple):
    """Smoothed Fourier amplitudes of acceleration [m/s] at ``frequency`` [Hz], both for the earthquake's length."""

    frequency: Samples
    signal: Samples
    noise: Samples

    @property
    def ratio(self) -> Samples:
        """The spectrum of the signal, noise included, over that of the noise; inf where the noise is zero."""
        return np.divide(self.signal, self.noise, out=np.full(len(self.frequency), np.inf), where=self.noise > 0.0)


class Corners(NamedTuple):
    """The corners of a band-pass [Hz], the reason for them in words, and flags."""

    low: float
    high: float
    words: str
    flags: tuple[str, ...] = ()


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
    passed, pad = signals.filtered(samples, dt, (low, high), order)
    flags = list(chosen.flags)
    if max(abs(samples[0]), abs(samples[-1])) > ENDS_OF_PEAK * float(np.abs(samples).max()):
        flags.append(
            "the record was filtered with ends above 2 % of its peak: subtract the mean and taper before; ends that "
            "stay are of a record that starts or ends in motion: take a longer one"
        )
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


def signal_to_noise(samples: Samples, dt: float) -> NoiseSpectra:
    """Fourier amplitudes of the earthquake and of the quiet before it, from one cycle in the record to Nyquist.

    Noise: the quiet, without the first second or half of it, where a taper may have been. Signal: from there to 5 s
    after 95 % of the energy; a long coda would add noise and no signal. Both windows lose their mean, are tapered over
    5 % at each end and smoothed after Konno and Ohmachi (1998), b = 20. A noise's amplitude grows with the root of its
    duration, and is scaled to the signal's. Below one cycle in the quiet it is at least what it is there, as the mean
    taken away hides the rest.

    Raises RecordError where less than 2 s of noise are left.
    """
    quiet = signals.quiet_before(samples, dt)
    length = quiet - min(LONGEST_LEAD, quiet / 2.0)
    if length < SHORTEST_NOISE:
        raise RecordError(
            f"the record is quiet for {quiet:.2g} s before the earthquake arrives; its noise is seen in "
            f"{SHORTEST_NOISE + LONGEST_LEAD:g} s or more"
        )
    first = round(quiet / dt)
    end = round((signals.energy_time(samples, dt, ENERGY) + AFTER) / dt)
    before, shaking = samples[first - round(length / dt) : first], samples[first:end]
    size = 1 << (len(samples) - 1).bit_length()
    lowest, nyquist = 1.0 / (len(samples) * dt), 0.5 / dt
    frequency = np.geomspace(lowest, nyquist, 1 + round(PER_DECADE * np.log10(nyquist / lowest)))
    signal, noise = (_smoothed(_amplitudes(window, dt, size), dt, size, frequency) for window in (shaking, before))
    noise *= sqrt(len(shaking) / len(before))
    unseen = frequency < 1.0 / (len(before) * dt)
    noise[unseen] = np.maximum(noise[unseen], noise[~unseen][0])
    return NoiseSpectra(frequency, signal, noise)


def corners_from_noise(samples: Samples, dt: float) -> Corners:
    """The band in which the earthquake stands out of the noise and leaves no drift.

    Around 1 Hz the ratio of amplitudes is at least 2 (`signal_to_noise`). The lower corner is where that band begins,
    never below one cycle in the record, and raised as long as the displacement drifts: a polynomial of order 6 fitted
    to it reaches more than 2 % of its peak. The upper corner is where the band ends, and at most 40 Hz and 3/4 of the
    Nyquist frequency. Without 3 s of quiet, or without a band, the corners are those of `default_corners`.
    """
    try:
        spectra = signal_to_noise(samples, dt)
    except RecordError as error:
        return default_corners(dt, f"by default, as {error}")
    band = _band(spectra)
    if band is None:
        flag = f"at {CENTRE:g} Hz the earthquake is less than {LEAST_RATIO:g} times the noise: the record says little"
        return default_corners(dt, "by default, as no band stands out of the noise")._replace(flags=(flag,))
    lowest = max(band[0], 1.0 / ((len(samples) - 1) * dt))
    low, drifts = _without_drift(samples, dt, lowest)  # a doubt where every corner drifts
    high = min(band[1], _highest(dt))
    words = f"signal-to-noise is at least {LEAST_RATIO:g} from {band[0]:.3g} to {band[1]:.3g} Hz"
    if low > lowest and not drifts:
        words += f", and the displacement drifts below {low:.3g} Hz"
    return Corners(low, high, words, (*_weak(spectra), *drifts))


def shared_corners(components: Sequence[Samples], dt: float) -> Corners:
    """The stricter corners of components that belong together, such as both horizontals: one filter for all."""
    components_corners = [corners_from_noise(samples, dt) for samples in components]
    low = max(components_corners, key=lambda corners: corners.low)
    high = min(components_corners, key=lambda corners: corners.high)
    words = low.words if low is high or low.words == high.words else f"lower corner: {low.words}; upper: {high.words}"
    flags = dict.fromkeys(flag for corners in components_corners for flag in corners.flags)
    return Corners(low.low, high.high, f"the stricter of {len(components_corners)} components: {words}", tuple(flags))


def default_corners(dt: float, words: str) -> Corners:
    """0.08 Hz, and 40 Hz or 3/4 of the Nyquist frequency, for records whose noise is not seen."""
    return Corners(LOW_CORNER, _highest(dt), f"corners {words}")


def _highest(dt: float) -> float:
    return min(HIGHEST_CORNER, NYQUIST_SHARE * 0.5 / dt)


def _amplitudes(window: Samples, dt: float, size: int) -> Samples:
    """|∫ a e^(-iωt) dt| [m/s] of a window without its mean, tapered."""
    position = np.linspace(0.0, 1.0, len(window))
    weight = signals.cosine_rise(position / TAPERED) * signals.cosine_rise((1.0 - position) / TAPERED)
    return np.asarray(np.abs(np.fft.rfft((window - window.mean()) * weight, size)) * dt)


def _smoothed(amplitudes: Samples, dt: float, size: int, centres: Samples) -> Samples:
    """Weighted means by [sin(b log10(f/fc)) / (b log10(f/fc))]^4, within the first zeros of that."""
    frequency = np.fft.rfftfreq(size, dt)
    reach = 10.0 ** (pi / BANDWIDTH)
    smooth = np.empty(len(centres))
    for number, centre in enumerate(centres):
        # At least the two frequencies beside the centre, of which the transform has few at the lowest.
        first = min(int(np.searchsorted(frequency, centre / reach)), int(np.searchsorted(frequency, centre)) - 1)
        last = max(int(np.searchsorted(frequency, centre * reach)), first + 2)
        near = np.maximum(frequency[first:last], 0.5 * frequency[1])
        weight = np.sinc(BANDWIDTH * np.log10(near / centre) / pi) ** 4
        smooth[number] = weight @ amplitudes[first:last] / weight.sum()
    return smooth


def _band(spectra: NoiseSpectra) -> tuple[float, float] | None:
    """The lowest and highest frequency [Hz] of the band around 1 Hz in which the ratio is high enough."""
    fails = np.flatnonzero(spectra.ratio < LEAST_RATIO)
    centre = int(np.argmin(np.abs(np.log(spectra.frequency / CENTRE))))
    if centre in fails:
        return None
    below, above = fails[fails < centre], fails[fails > centre]
    first = int(below[-1]) + 1 if len(below) else 0
    last = int(above[0]) - 1 if len(above) else len(spectra.frequency) - 1
    return float(spectra.frequency[first]), float(spectra.frequency[last])


def _weak(spectra: NoiseSpectra) -> tuple[str, ...]:
    """A flag where the noise reaches into the frequencies of buildings."""
    ratio, frequency = spectra.ratio, spectra.frequency
    within = (frequency >= BAND[0]) & (frequency <= BAND[1])
    if not within.any() or ratio[within].min() >= LEAST_RATIO:
        return ()
    worst = float(frequency[within][np.argmin(ratio[within])])
    return (
        f"signal-to-noise is {ratio[within].min():.2g} at {worst:.2g} Hz, below {LEAST_RATIO:g} within "
        f"{BAND[0]:g} to {BAND[1]:g} Hz: spectra there are noise",
    )


def _without_drift(samples: Samples, dt: float, lowest: float) -> tuple[float, tuple[str, ...]]:
    """The lowest corner [Hz], not below ``lowest``, above which every corner keeps the displacement steady."""
    every = max(1, floor(DRIFT_STEP / dt))
    smooth, pad = signals.filtered(samples, dt, (0.0, SLOW), FILTER_ORDER)
    coarse = smooth[pad : pad + len(samples) : every]
    if lowest >= HIGHEST_LOW or len(coarse) <= DRIFT_ORDER + 1:
        return lowest, ()
    tries = np.geomspace(HIGHEST_LOW, lowest, 1 + round(TRIES_PER_DECADE * np.log10(HIGHEST_LOW / lowest)))
    lowest_steady = None
    for corner in tries:
        if _drift(coarse, every * dt, float(corner)) > DRIFT:
            break
        lowest_steady = float(corner)
    if lowest_steady is None:
        flag = f"no lower corner up to {HIGHEST_LOW:g} Hz keeps the displacement from drifting"
        return max(lowest, LOW_CORNER), (flag,)
    return lowest_steady, ()


def _drift(samples: Samples, dt: float, corner: float) -> float:
    """The peak of a polynomial fitted to the displacement of the filtered motion, over the displacement's own."""
    passed, pad = signals.filtered(samples, dt, (corner, np.inf), FILTER_ORDER)
    displacement = signals.velocity_displacement(passed[pad : pad + len(samples)], dt)[1]
    position = np.linspace(-1.0, 1.0, len(samples))
    fit = np.polynomial.legendre.legval(position, np.polynomial.legendre.legfit(position, displacement, DRIFT_ORDER))
    peak = float(np.abs(displacement).max())
    return float(np.abs(fit).max()) / peak if peak > 0.0 else 0.0
