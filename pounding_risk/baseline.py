"""Baseline correction of the processing chain; see `pounding_risk.processing`."""

from __future__ import annotations

import numpy as np

from pounding_risk.signals import Samples, velocity_displacement
from pounding_risk.steps import DRIFT_OF_PEAK, ORDER, Done, step, whole


@step("baseline", order=ORDER)
def baseline(samples: Samples, dt: float, *, order: float = 6) -> Done:
    """Subtract the second derivative of a polynomial fitted to the displacement.

    The constant and linear coefficients are zero, so the motion still starts from rest (PEER NGA-West2,
    Ancheta et al. 2013, with order 6). Time runs from 0 to 1 in the fit, which keeps it well-conditioned.
    The result is checked on velocity and displacement: what is left of them at the end is flagged.
    """
    degree = whole(order, "a baseline", 2)
    duration = (len(samples) - 1) * dt
    place = np.linspace(0.0, 1.0, len(samples))
    powers = np.arange(2, degree + 1)
    _, displacement = velocity_displacement(samples, dt)
    fit = np.linalg.lstsq(place[:, None] ** powers, displacement, rcond=None)[0]
    bend = (place[:, None] ** (powers - 2)) @ (fit * powers * (powers - 1)) / duration**2
    corrected = samples - bend
    sentence = f"baseline: subtracted the second derivative of an order-{degree} polynomial in displacement"
    words, flags = _ends(corrected, dt)
    return Done(corrected, f"{sentence}; {words}", flags)


def _ends(samples: Samples, dt: float) -> tuple[str, tuple[str, ...]]:
    """Peaks and last values of velocity and displacement in words; flags where they do not come to rest."""
    flags, words = [], []
    for name, trace, unit in zip(
        ("velocity", "displacement"), velocity_displacement(samples, dt), ("cm/s", "cm"), strict=True
    ):
        peak, last = 100.0 * float(np.abs(trace).max()), 100.0 * float(trace[-1])
        words.append(f"peak {name} {peak:.4g} {unit}, at the end {last:.3g}")
        if abs(last) > DRIFT_OF_PEAK * peak:
            share = 100.0 * abs(last) / peak
            flags.append(f"after baseline correction the {name} ends at {share:.0f} % of its peak")
    return ", ".join(words), tuple(flags)
