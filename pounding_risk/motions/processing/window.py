"""Window, polarity and tail of the samples that a run takes, and flags about them."""

from __future__ import annotations

from math import ceil

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import Done
from pounding_risk.motions.processing.basic import window
from pounding_risk.motions.processing.resample import MOST
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.motions.quality import FIRST_OF_PEAK, LONGEST_STEP

ROUNDING = 1e-6  # steps: 5 s may be 1000 + 1e-13 steps of 0.005 s
WEAK_WINDOW = 0.5  # a window with less than this part of the PGA is flagged


def cut(samples: Samples, dt: float, span: tuple[float, float]) -> Done:
    """The part of a record within ``span`` [s]; flagged where the strongest shaking is outside it."""
    done = window(samples, dt, start=span[0], end=span[1])
    peak, inside = float(np.abs(samples).max()), float(np.abs(done.samples).max())
    if inside >= WEAK_WINDOW * peak:
        return done
    flag = f"the window leaves the strong shaking out: its PGA is {100.0 * inside / peak:.2g} % of the record's"
    return done._replace(flags=(*done.flags, flag))


def reversed_polarity(samples: Samples) -> Done:
    """The samples with the opposite sign."""
    return Done(-samples, "polarity: reversed")


def with_zeros(samples: Samples, dt: float, seconds: float) -> Done:
    """The samples followed by zeros of that duration [s], rounded up to whole time steps.

    Ground acceleration is linear between samples: one that does not end at zero reaches it within one more step.
    """
    count, ramp = ceil(seconds / dt - ROUNDING), bool(samples[-1]) and seconds > 0.0
    if count > MOST:
        raise RecordError(f"a tail of {seconds:g} s makes {count} samples, {MOST} are allowed; write a shorter one")
    straight = f", after a straight line to zero over {dt:g} s" if ramp else ""
    return Done(np.pad(samples, (0, count + ramp)), f"tail: {count * dt:g} s of zeros added{straight}")


def doubts(samples: Samples, dt: float) -> tuple[str, ...]:
    """Flags about the samples that a run takes: a start in motion, and a long time step."""
    flags = []
    peak, first = float(np.abs(samples).max()), abs(float(samples[0]))
    if first > FIRST_OF_PEAK * peak:
        share = f"{100.0 * first / peak:.1f} %"
        flags.append(f"the motion starts at {share} of its PGA: a late trigger, or a cut in motion")
    if dt > LONGEST_STEP:
        flags.append(f"the time step {dt:g} s is longer than {LONGEST_STEP:g} s: peaks may be missed")
    return tuple(flags)
