"""A kind of generated motion, `kind = "half_sine"` in `[[records.generated]]`; a processing step, `step = "gain"`."""

import numpy as np

from pounding_risk.motions.generated import Option, Wave, motion_kind
from pounding_risk.motions.processing import Done, step
from pounding_risk.units import PERIOD, PGA, SCALE


@motion_kind(
    "half_sine",
    amplitude=("pga",),
    named_by=("length",),
    pga=Option("Largest acceleration.", PGA),
    length=Option("Duration of the arch.", PERIOD),
)
def half_sine(*, pga, length):
    """One arch of a sine, as tests of shock have it."""
    return Wave(lambda times: pga * np.sin(np.pi * times / length), length, 2.0 * length)


@step("gain", factor=SCALE)
def gain(samples, dt, *, factor=1.0):
    """Multiply by a correction factor of the instrument's gain."""
    return Done(samples * factor, f"gain: multiplied by {factor:g}")
