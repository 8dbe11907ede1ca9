"""The form that a kind of generated motion gives for values of its keys: samples at any time step.

A `Wave` is the form of a motion that is a formula: its samples, and the error of straight lines between these.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from math import ceil, floor, inf, log10, sqrt
from typing import NamedTuple

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import STANDARD_GRAVITY

MOST = 2_000_000  # samples of one motion
FADED = 1e-6  # of the peak: what is left at the end of a pulse that fades is zero
LONGEST = 0.01  # s: the longest time step that is chosen
AIM = 5e-4  # of the largest acceleration: the error that the chosen step stays below; 100 samples a period of a sine
MOST_ERROR = 0.05  # of it: a step with a larger error is refused; ten samples a period of a sine
BETWEEN = (0.25, 0.5, 0.75)  # of a step: where the error is measured
SAME = 1e-9  # relative difference of times that are equal


class Unfit(RecordError):
    """A value that does not go with those of other keys: the key, and the sentence."""

    def __init__(self, key: str, sentence: str):
        self.key, self.sentence = key, sentence
        super().__init__(f"{key}: {sentence}")


class Form(ABC):
    """What a kind gives for values of its keys: samples of a motion at any time step.

    A motion starts with the ground at rest.
    """

    duration: float  # s

    @abstractmethod
    def default_step(self) -> float:
        """The time step [s] that is chosen where none is given."""

    @abstractmethod
    def sampled(self, step: float, seed: int) -> Sampled:
        """The motion at a time step [s]; raises Unfit where the step is too long for it."""

    def check(self, step: float) -> None:
        """Raise Unfit for a time step [s] that is too long, or that makes more than `MOST` samples."""
        if self.duration / step > MOST:
            raise Unfit(
                "step",
                f"{step:g} s makes {self.duration / step:.3g} samples of a motion of {self.duration:g} s, "
                f"{MOST} are allowed; write a longer step or a shorter motion",
            )


class Sampled(NamedTuple):
    """Samples [m/s²], sentences about them, doubts, and the largest error of straight lines between them.

    ``error`` is a share of the largest acceleration; None where the motion between samples is not known.
    """

    samples: Samples
    sentences: tuple[str, ...]
    doubts: tuple[str, ...] = ()
    error: float | None = None


def closed(
    samples: Samples, step: float, sentences: tuple[str, ...], *, least: float = FADED, error: float | None = None
) -> Sampled:
    """Samples that end at zero, with a doubt about a jump at either end: above ``least`` of the peak it is one."""
    peak, doubts = float(np.abs(samples).max()), []
    first, last = (f"{end / STANDARD_GRAVITY:.4g} g" for end in (samples[0], samples[-1]))
    if abs(samples[0]) > least * peak:
        doubts.append(f"the acceleration starts with a jump from 0 to {first}, on ground at rest")
    if abs(samples[-1]) > least * peak:
        doubts.append(f"the acceleration falls from {last} to 0 within one step of {step:g} s at its end")
    if abs(samples[-1]) > FADED * peak:
        samples = np.append(samples, 0.0)
    return Sampled(samples, sentences, tuple(doubts), error)


def largest_in_g(samples: Samples) -> float:
    """Largest size of the samples [g], of samples in m/s²."""
    return float(np.abs(samples).max()) / STANDARD_GRAVITY


@dataclass(frozen=True)
class Wave(Form):
    """A motion that is a formula of the time from its start, and zero before and after.

    Parameters
    ----------
    acceleration : callable
        Ground acceleration [m/s²] at an array of times [s] from 0 to ``duration``.
    duration : float
        Its length [s].
    shortest_period : float
        Period of its fastest part [s], from which the step is chosen; inf where it does not vary.
    corners : tuple of float
        Times [s] between 0 and ``duration`` at which the acceleration bends; the chosen step puts samples there.
    """

    acceleration: Callable[[Samples], Samples]
    duration: float
    shortest_period: float
    corners: tuple[float, ...] = ()

    def default_step(self) -> float:
        """The step at which straight lines are within `AIM` of the formula, at most `LONGEST`."""
        step = self._fitting(LONGEST if self.shortest_period == inf else self.shortest_period / 50.0)
        for _ in range(5):  # the error is that of the square of the step, all but exactly
            error = self._error(step)
            if error <= AIM:
                break
            step = self._fitting(0.98 * step * sqrt(AIM / error))
        coarser = self._fitting(min(LONGEST, 0.98 * step * sqrt(AIM / error) if error else inf))
        return coarser if self._error(coarser) <= AIM else step

    def sampled(self, step: float, seed: int = 0) -> Sampled:
        """The samples, with the error of straight lines between them, and how the ground ends."""
        self.check(step)
        error = self._error(step)
        samples = self._at(step * np.arange(self._steps(step) + 1))
        words = (
            f"step {step:g} s: straight lines between samples are within {_percent(error)} of the peak of the formula"
        )
        return closed(samples, step, (words,), error=error)

    def check(self, step: float) -> None:
        """Raise Unfit where straight lines are further than `MOST_ERROR` from the formula."""
        super().check(step)
        error = self._error(step)
        if error <= MOST_ERROR:
            return
        fault = (
            f"straight lines between samples every {step:g} s are up to {_percent(error)} of the peak from the motion"
        )
        fitting = self.default_step()
        if self._error(fitting) > MOST_ERROR:
            raise Unfit("step", f"{fault}, and a finer step makes more than {MOST} samples; write a shorter motion")
        raise Unfit(
            "step", f'{fault}, {_percent(MOST_ERROR)} is allowed; write a step such as "{fitting:g} s", or leave it out'
        )

    def _steps(self, step: float) -> int:
        """The number of steps, the last of which reaches the end."""
        return max(1, ceil(self.duration / step * (1.0 - SAME)))

    def _at(self, times: Samples) -> Samples:
        inside = times <= self.duration * (1.0 + SAME)
        return np.where(inside, self.acceleration(np.minimum(times, self.duration)), 0.0)

    def _error(self, step: float) -> float:
        """The largest distance of straight lines from the formula over its largest value, both seen between samples.

        Of a smooth motion it is h²/8 max|a''|. A step in which the acceleration jumps at the end is left out.
        """
        times = step * np.arange(self._steps(step) + 1)
        ends_in_jump = abs(float(self._at(np.array([self.duration]))[0])) > 0.0
        if ends_in_jump and times[-1] > self.duration * (1.0 + SAME):
            times = times[:-1]
        if len(times) < 2:
            return 1.0
        samples = self._at(times)
        error, peak, rises = 0.0, float(np.abs(samples).max()), np.diff(samples)
        for share in BETWEEN:
            formula = self._at(times[:-1] + share * step)
            peak = max(peak, float(np.abs(formula).max()))
            error = max(error, float(np.abs(samples[:-1] + share * rises - formula).max()))
        if peak == 0.0:
            return 0.0 if self.shortest_period == inf else 1.0  # or all that is seen is where it passes zero
        return error / peak

    def _fitting(self, longest: float) -> float:
        """A step of at most ``longest`` that has a sample at the end and at every corner, round where it can be."""
        longest = max(longest, self.duration / MOST)
        places = [self.duration, *self.corners]
        decade = floor(log10(longest))
        for step in (
            digit * 10.0**power for power in (decade, decade - 1) for digit in (5.0, 4.0, 2.5, 2.0, 1.25, 1.0)
        ):
            step = float(f"{step:.3g}")
            counts = [time / step for time in places]
            is_whole = all(abs(count - round(count)) < SAME * max(1.0, count) for count in counts)
            if step <= longest * (1.0 + SAME) and is_whole:
                return step
        first = min(time for time in places if time > 0.0)
        return first / ceil(first / longest * (1.0 - SAME))


def _percent(share: float) -> str:
    if share >= 0.995:
        return f"{100.0 * share:.0f} %"
    return f"{100.0 * share if share > SAME else 0.0:.2g} %"
