"""Classical Runge-Kutta of order 4 with a fixed step, by one call: see `pounding_risk.lab.baselines.fixed_step`."""

from __future__ import annotations

from math import nan
from typing import Any

import numpy as np

from pounding_risk._jit.compile import lowered
from pounding_risk.lab.baselines import fixed_step as fixed

COLUMNS = {
    "peak_relative_displacement": fixed.REACH,
    "peak_contact_force": fixed.FORCE,
    "impact_count": fixed.COUNT,
}
OUTPUTS = tuple(COLUMNS)


def solve_rk4(pair: Any, interface: Any, acceleration: Any, dt: float, h: float) -> dict[str, float]:
    """One run with steps of about ``h`` [s], a whole number of them a sample; `OUTPUTS` in SI units."""
    out, ground = np.zeros(fixed.COLUMNS), fixed.divided(acceleration, dt, h)
    limits = float(interface.gap), float(interface.yield_force), interface.restitution
    fixed.march_fixed(fixed.STEPPERS["rk4"], pair, lowered(interface.law), limits, ground, out)
    return {name: nan if out[fixed.UNSTABLE] else float(out[column]) for name, column in COLUMNS.items()}
