"""Classical Runge-Kutta of order 4 with a fixed step, by one call: see `pounding_risk.lab.baselines.fixed_step`."""

from __future__ import annotations

from typing import Any

from pounding_risk.lab.baselines.fixed_step import divided, solve_fixed

OUTPUTS = ("peak_relative_displacement", "peak_contact_force", "impact_count")


def solve_rk4(pair: Any, interface: Any, acceleration: Any, dt: float, h: float) -> dict[str, float]:
    """One run with steps of about ``h`` [s], a whole number of them a sample; `OUTPUTS` in SI units."""
    found = solve_fixed("rk4", pair, interface, divided(acceleration, dt, h))
    return {name: found[name] for name in OUTPUTS}
