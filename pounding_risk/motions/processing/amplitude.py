"""Scaling of samples by one factor, and flags for peaks outside the range of earthquakes."""

from __future__ import annotations

from typing import Any

import numpy as np

from pounding_risk.errors import RecordError
from pounding_risk.motions.processing import Done
from pounding_risk.motions.processing.signals import Samples
from pounding_risk.units import STANDARD_GRAVITY, QuantityError, si

USUAL_FACTORS = (0.25, 4.0)
LARGEST_PGA, SMALLEST_PGA = 3.0, 0.001  # g; beyond these a unit is likely wrong


def in_si(key: str, value: Any, quantity: Any) -> float:
    """A number in SI from a number or from text with a unit; raises RecordError that names ``key``."""
    try:
        return si(value, quantity)
    except QuantityError as error:
        raise RecordError(f"{key}: {error}") from None


def scale_samples(samples: Samples, factor: float, aim: str = "") -> Done:
    """Multiply samples by ``factor``; ``aim`` says why, for the sentence."""
    before, scaled = float(np.abs(samples).max()), samples * factor
    pga = float(np.abs(scaled).max())
    flags = list(unit_doubts(pga, "after scaling"))
    if not USUAL_FACTORS[0] <= factor <= USUAL_FACTORS[1]:
        flags.append(f"the scale factor {factor:.4g} is outside {USUAL_FACTORS[0]:g} to {USUAL_FACTORS[1]:g}")
    peaks = f"from PGA {before / STANDARD_GRAVITY:.5g} g to {pga / STANDARD_GRAVITY:.5g} g"
    words = f"scale: times {factor:.10g}{f' to {aim}' if aim else ''}, {peaks}"
    return Done(scaled, words, tuple(flags), factor=factor)


def scale_samples_to(samples: Samples, pga: float, name: str) -> Done:
    """Multiply samples so that max|a| is ``pga`` [m/s²]; raises RecordError where no factor does that."""
    peak = float(np.abs(samples).max())
    if peak == 0.0:
        raise RecordError(f"{name}: every sample is zero, which no factor scales; check record and window")
    done = scale_samples(samples, pga / peak)
    if not abs(float(np.abs(done.samples).max()) - pga) <= 1e-12 * pga:
        raise RecordError(f"{name}: a PGA of {pga:g} m/s² is out of reach for samples of {peak:g} m/s²")
    return done


def unit_doubts(pga: float, when: str) -> tuple[str, ...]:
    """A flag for a peak [m/s²] outside the range of earthquakes, for which a unit is likely wrong."""
    in_g = pga / STANDARD_GRAVITY
    if SMALLEST_PGA <= in_g <= LARGEST_PGA:
        return ()
    side = f"above {LARGEST_PGA:g} g" if in_g > LARGEST_PGA else f"below {SMALLEST_PGA:g} g"
    return (f"PGA {when} is {in_g:.3g} g, {side}: check the unit",)
