"""Quality checks of a record: what each finds, what it allows, and where the limit is from.

`quality` runs every check of `CHECKS`. To add one is to write one function under ``@check``.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from pounding_risk._common.plugins import Registry
from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import DRIFT_OF_PEAK
from pounding_risk.motions.processing.basic import SHORTEST_PRE_EVENT
from pounding_risk.motions.processing.noise import BAND, LEAST_RATIO, signal_to_noise
from pounding_risk.motions.processing.signals import Samples, quiet_before, velocity_displacement
from pounding_risk.motions.record import GENERATED, PROCESSED, RAW

LONGEST_STEP = 0.02  # s; longer steps miss peaks
STEPS_A_PERIOD = 10.0  # as for gmprocess' oscillators
SHORTEST_SHAKING = 5.0  # s from the arrival to the end, as in gmprocess
LONGEST_FLAT, SAME = 2, 1e-6  # samples in a row at the extreme, equal to this part of the range
NOISY_FLAT, CLOSE, STEEP = 4, 1e-3, 5.0  # of a plateau with noise: samples, part of the range, its edges in parts
SPIKE_OF_RANGE, GLITCH_OF_RANGE = 0.02, 0.1
SPIKE_OF_OTHERS, NEIGHBOURHOOD = 4.0, 0.25  # sharpest bend within so many s
SHORTEST_HELD, FEWEST_HELD, HELD_ENERGY = 0.1, 10, 0.01  # s, samples, share of the energy before and after
BESIDE_HELD, RESOLVED, HELD_OF_RANGE = 0.5, 50, 0.02  # s, and how far the motion moves there: last digits, range
FIRST_OF_PEAK, OFFSET_OF_PEAK = 0.02, 0.05
FEWEST_CROSSINGS = 0.1  # a second, as in gmprocess
TAIL, TAIL_VELOCITY, TAIL_DISPLACEMENT = 5.0, 0.3, 0.9  # s at the end, and of the peaks, as in gmprocess


class Finding(NamedTuple):
    """The result of a check: what it found and what it allows, both in words, and whether it passed."""

    check: str
    found: str
    allowed: str
    passed: bool

    @property
    def sentence(self) -> str:
        """The finding as one sentence, for a flag."""
        return f"{self.check}: {self.found}; allowed: {self.allowed}"


@dataclass(frozen=True)
class CheckedRecord:
    """A record under the checks, with derived values that several checks share; see `quality` for the fields."""

    samples: Samples
    dt: float
    shortest_period: float | None
    longest_period: float | None
    usable: float | None

    @cached_property
    def centred(self) -> Samples:
        """Samples less their mean [m/s²]."""
        return self.samples - self.samples.mean()

    @cached_property
    def peak(self) -> float:
        """max|a| of the samples less their mean [m/s²]."""
        return float(np.abs(self.centred).max())

    @cached_property
    def quiet(self) -> float:
        """Time before the arrival of the earthquake [s]."""
        return quiet_before(self.samples, self.dt)

    @cached_property
    def integrals(self) -> tuple[Samples, Samples]:
        """Velocity [m/s] and displacement [m] from rest."""
        return velocity_displacement(self.samples, self.dt)


Result = tuple[str, str, bool] | None  # what was found, what is allowed, whether that is met
Check = Callable[[CheckedRecord], Result]
CHECKS = Registry("")  # each with the states of a record to which it applies
# What no processing mends, and what says that a motion has not come to rest: flags of a motion. Others of its doubts
# are flagged by the steps that met them.
LASTING = ("duration", "clipping", "spikes", "held values", "zero crossings")
OF_BUILDINGS = ("time step of the stiffest building", "period of the softest building")
AT_REST = ("velocity at the end", "displacement at the end", "tail")


def check(name: str, states: tuple[str, ...] = (RAW, PROCESSED)) -> Callable[[Check], Check]:
    """Enter a function in the registry: it returns what it found, what is allowed and whether that is met, or None."""

    def enter(function: Check) -> Check:
        CHECKS.enter(name, (function, states), function.__module__)
        return function

    return enter


def quality(
    samples: Samples,
    dt: float,
    *,
    shortest_period: float | None = None,
    longest_period: float | None = None,
    usable: float | None = None,
    state: str = PROCESSED,
    checks: tuple[str, ...] | None = None,
) -> tuple[Finding, ...]:
    """Run the quality checks on a record.

    Parameters
    ----------
    samples : array, shape (n,)
        Acceleration [m/s²].
    dt : float
        Time step [s].
    shortest_period : float, optional
        Period of the stiffest building [s].
    longest_period : float, optional
        Period of the softest building [s].
    usable : float, optional
        The lowest frequency that the record's filter left [Hz].
    state : str
        "raw" also requires quiet before the earthquake, and an earthquake that stands out of the noise, which a
        processed record need not have any more.
    checks : tuple of str, optional
        Names of checks; all of `CHECKS` unless given.

    Returns
    -------
    tuple of Finding
        One for each check that applies.
    """
    record = CheckedRecord(np.asarray(samples, dtype=np.float64), dt, shortest_period, longest_period, usable)
    if record.peak == 0.0:
        return (Finding("motion", "every sample is the same", "a motion", False),)
    names = CHECKS if checks is None else checks
    results = {name: CHECKS[name][0](record) for name in names if state in CHECKS[name][1]}
    return tuple(Finding(name, *finding) for name, finding in results.items() if finding is not None)


def failed(findings: tuple[Finding, ...]) -> tuple[str, ...]:
    """One sentence for each check that did not pass."""
    return tuple(finding.sentence for finding in findings if not finding.passed)


@check("time step")
def _time_step(record: CheckedRecord) -> tuple[str, str, bool]:
    """Peaks of acceleration lie between samples that are too far apart."""
    return f"{record.dt:g} s", f"at most {LONGEST_STEP:g} s", record.dt <= LONGEST_STEP * (1.0 + 1e-9)


@check("time step of the stiffest building")
def _stiffest(record: CheckedRecord) -> Result:
    """dt <= T/10: straight lines between samples keep sinc²(dt/T) of a wave of period T, 97 % then and 87 % at T/5."""
    if record.shortest_period is None:
        return None
    longest = record.shortest_period / STEPS_A_PERIOD
    words = f"{record.dt:g} s, {record.shortest_period / record.dt:.3g} in a period of {record.shortest_period:g} s"
    return words, f"at most {longest:.3g} s", record.dt <= longest * (1.0 + 1e-9)


@check("period of the softest building")
def _softest(record: CheckedRecord) -> Result:
    """The filter of a record takes out the motion that drives a building of a longer period."""
    if record.longest_period is None or not record.usable:
        return None
    return (
        f"{record.longest_period:g} s",
        f"at most {1.0 / record.usable:.3g} s",
        record.longest_period <= 1.0 / record.usable,
    )


@check("duration")
def _duration(record: CheckedRecord) -> tuple[str, str, bool]:
    """Time from the arrival of the earthquake to the end of the record."""
    length = (len(record.samples) - 1) * record.dt - record.quiet
    return f"{length:.3g} s after the arrival", f"{SHORTEST_SHAKING:g} s or more", length >= SHORTEST_SHAKING


@check("quiet before", (RAW,))
def _quiet(record: CheckedRecord) -> tuple[str, str, bool]:
    """Time before the earthquake, in which offset and noise of the instrument are seen."""
    return f"{record.quiet:.3g} s", f"{SHORTEST_PRE_EVENT:g} s or more", record.quiet >= SHORTEST_PRE_EVENT


@check("signal-to-noise", (RAW,))
def _noise(record: CheckedRecord) -> Result:
    """The least ratio of Fourier amplitudes within the frequencies of buildings; needs 3 s before the earthquake."""
    try:
        spectra = signal_to_noise(record.centred, record.dt)
    except RecordError:
        return None
    within = (spectra.frequency >= BAND[0]) & (spectra.frequency <= BAND[1])
    least = int(np.argmin(np.where(within, spectra.ratio, np.inf)))
    ratio = float(spectra.ratio[least])
    words = f"at least {ratio:.3g} within {BAND[0]:g} to {BAND[1]:g} Hz, least at {spectra.frequency[least]:.2g} Hz"
    return words, f"{LEAST_RATIO:g} or more", ratio >= LEAST_RATIO


@check("clipping")
def _clipping(record: CheckedRecord) -> tuple[str, str, bool]:
    """Three samples in a row at the extreme, or four within 0.1 % of the range of it with steps of 0.5 % beside them.

    154 good records have one or two samples at each extreme, and beside four close ones no step above 0.1 % of the
    range. A plateau with more noise than 0.1 % of the range is not seen, nor one below a higher peak.
    """
    samples = record.samples
    span = float(np.ptp(samples))
    longest, noisy = 0, 0
    for upright in (samples - samples.min(), samples.max() - samples):  # zero at the extreme
        starts, ends = _runs(upright <= SAME * span)
        longest = max(longest, int((ends - starts).max()))
        starts, ends = _runs(upright <= CLOSE * span)
        # The first sample and the last one have nothing beside them: the extreme may be the end of a ramp.
        within = (starts > 0) & (ends < len(samples)) & (ends - starts >= NOISY_FLAT)
        starts, ends = starts[within], ends[within]
        steps = np.minimum(upright[starts - 1] - upright[starts], upright[ends % len(samples)] - upright[ends - 1])
        noisy = max(noisy, int((ends - starts)[steps > STEEP * CLOSE * span].max(initial=0)))
    if longest <= LONGEST_FLAT < noisy:
        return f"{noisy} samples in a row within {100 * CLOSE:g} % of the extreme", f"at most {LONGEST_FLAT}", False
    rows = "1 sample" if longest == 1 else f"{longest} samples in a row"
    return f"{rows} at the extreme", f"at most {LONGEST_FLAT}", longest <= LONGEST_FLAT


@check("spikes")
def _spikes(record: CheckedRecord) -> tuple[str, str, bool]:
    """Samples that stick out of both neighbours by four times the sharpest bend near them, and 2 % of the range.

    The first sample and the last one stick out of their one neighbour and of the line through the two beside them. Two
    or three samples in a row stick out by 10 % of the range. 154 good records have no single sample above 4.0 times,
    sharp arrivals near the source included, and no two above 2.8; the test of gmprocess, a jump of a part of the range
    alone, takes records of 50 samples a second for spiked. Longer glitches are not seen.
    """
    for stride, share, words in (
        (1, SPIKE_OF_RANGE, "a single sample sticks out"),
        (2, GLITCH_OF_RANGE, "two or three samples stick out"),
    ):
        at = _sticking_out(record.samples, record.dt, stride, share)
        if at is not None:
            return f"{words} at {at * record.dt:.4g} s", "none", False
    return "none", "none", True


def _sticking_out(samples: Samples, dt: float, stride: int, share: float) -> int | None:
    """The sample that sticks out most of those ``stride`` before and after it; None where none does."""
    if len(samples) < 3 * stride:
        return None
    # Beyond the ends, what continues the line of the samples next to them: a record that starts in motion is smooth.
    first = 2.0 * samples[stride : 2 * stride] - samples[2 * stride : 3 * stride]
    last = 2.0 * samples[-2 * stride : -stride] - samples[-3 * stride : -2 * stride]
    left = samples - np.concatenate([first, samples[:-stride]])
    right = samples - np.concatenate([samples[stride:], last])
    out = np.where(left * right > 0.0, np.minimum(np.abs(left), np.abs(right)), 0.0)
    bends = np.abs(left + right) / 2.0
    bends[:stride] = bends[-stride:] = 0.0
    # The sharpest bend on either side; the bends beside a spike are its own and are left out.
    reach, own = max(5 * stride, round(NEIGHBOURHOOD / dt)), 2 * stride - 1
    around = sliding_window_view(np.pad(bends, reach + own), reach).max(axis=1)
    others = np.maximum(around[: len(samples)], around[reach + 2 * own + 1 :][: len(samples)])
    excess = np.where(out > share * np.ptp(samples), out - SPIKE_OF_OTHERS * others, 0.0)
    index = int(np.argmax(excess))
    return index if excess[index] > 0.0 else None


@check("held values")
def _held(record: CheckedRecord) -> tuple[str, str, bool]:
    """The longest run of equal samples within 1 to 99 % of the energy: a drop-out, or a gap filled with one value.

    It counts from 0.1 s and 10 samples on, and where the motion in the half second before or after it spans 2 % of the
    range and 50 of its least steps, so that neither coarse digits nor the quiet between two earthquakes are taken for
    one; runs at the extreme are those of the clipping. 154 good records have none. A gap that was filled with a line
    or with made-up motion is not seen.
    """
    samples, dt, span = record.samples, record.dt, float(np.ptp(record.samples))
    energy = np.cumsum(record.centred**2)
    low, high = (int(index) for index in np.searchsorted(energy, energy[-1] * np.array([HELD_ENERGY, 1 - HELD_ENERGY])))
    jumps = np.abs(np.diff(samples))
    least = max(RESOLVED * float(jumps[jumps > SAME * span].min(initial=span)), HELD_OF_RANGE * span)
    extreme = np.minimum(samples - samples.min(), samples.max() - samples) <= SAME * span
    starts, ends = _runs((jumps <= SAME * span) & ~extreme[1:])  # of the jumps: the samples of a run are one more
    counts = np.minimum(ends, high) - np.maximum(starts, low) + 1
    beside = max(1, round(BESIDE_HELD / dt))
    for index in np.argsort(-counts, kind="stable"):
        start, end, count = int(starts[index]), int(ends[index]), int(counts[index])
        if count < FEWEST_HELD or count * dt < SHORTEST_HELD * (1.0 - 1e-9):
            break
        around = (samples[max(0, start - beside) : start + 1], samples[end : end + beside + 1])
        if max(float(np.ptp(part)) for part in around) >= least:
            found = f"{count} samples in a row, {count * dt:.3g} s, are equal at {max(start, low) * dt:.4g} s"
            return found, f"less than {SHORTEST_HELD:g} s within the shaking", False
    return "none", f"less than {SHORTEST_HELD:g} s within the shaking", True


def _runs(marks: NDArray[np.bool_]) -> tuple[NDArray[np.intp], NDArray[np.intp]]:
    """Where each run of true marks begins, and the index after its last."""
    edges = np.flatnonzero(np.diff(np.concatenate([[False], marks, [False]]).astype(np.int8)))
    return edges[::2], edges[1::2]


@check("offset")
def _offset(record: CheckedRecord) -> tuple[str, str, bool]:
    """The mean of the samples, which integrates to a ramp of velocity."""
    share = abs(float(record.samples.mean())) / float(np.abs(record.samples).max())
    return f"mean of {_percent(share)} of PGA", f"at most {100 * OFFSET_OF_PEAK:g} %", share <= OFFSET_OF_PEAK


@check("late trigger")
def _first(record: CheckedRecord) -> tuple[str, str, bool]:
    """The first sample: a record that starts in motion lacks what came before."""
    share = abs(float(record.centred[0])) / record.peak
    return f"starts at {_percent(share)} of PGA", f"at most {100 * FIRST_OF_PEAK:g} %", share <= FIRST_OF_PEAK


@check("zero crossings")
def _crossings(record: CheckedRecord) -> tuple[str, str, bool]:
    """The rate of zero crossings, low for an instrument that stuck and for a drift larger than the motion."""
    signs = np.sign(record.centred[record.centred != 0.0])
    rate = float(np.count_nonzero(np.diff(signs))) / ((len(record.samples) - 1) * record.dt)
    return f"{rate:.2g} a second", f"more than {FEWEST_CROSSINGS:g}", rate > FEWEST_CROSSINGS


@check("velocity at the end", (RAW, PROCESSED, GENERATED))
def _velocity(record: CheckedRecord) -> tuple[str, str, bool]:
    """The velocity at the end, where the ground is at rest after an earthquake."""
    return _end(record.integrals[0])


@check("displacement at the end", (RAW, PROCESSED, GENERATED))
def _displacement(record: CheckedRecord) -> tuple[str, str, bool]:
    """The displacement at the end: drift, or a permanent displacement that was left in on purpose."""
    return _end(record.integrals[1])


@check("tail")
def _tail(record: CheckedRecord) -> Result:
    """The motion in the last seconds, large where the record ends before the shaking; None for a shorter record."""
    count = round(TAIL / record.dt)
    if count >= len(record.samples):
        return None
    velocity, displacement = (_share(trace[-count:], trace) for trace in record.integrals)
    words = f"last {TAIL:g} s reach {_percent(velocity)} of PGV and {_percent(displacement)} of PGD"
    allowed = f"at most {100 * TAIL_VELOCITY:g} % and {100 * TAIL_DISPLACEMENT:g} %"
    return words, allowed, velocity <= TAIL_VELOCITY and displacement <= TAIL_DISPLACEMENT


def _end(trace: Samples) -> tuple[str, str, bool]:
    """The last value as a share of the peak."""
    share = _share(trace[-1:], trace)
    return f"{_percent(share)} of its peak", f"at most {100 * DRIFT_OF_PEAK:g} %", share <= DRIFT_OF_PEAK


def _percent(share: float) -> str:
    return f"{100.0 * share:.2g} %" if share < 0.995 else f"{100.0 * share:.0f} %"


def _share(window: Samples, trace: Samples) -> float:
    peak = float(np.abs(trace).max())
    return float(np.abs(window).max()) / peak if peak > 0.0 else 0.0
