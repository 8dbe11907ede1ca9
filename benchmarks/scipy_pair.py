"""SciPy's DOP853, started anew at every sample and event, by one call: `pounding_risk.lab.baselines.solve_ivp`."""

from __future__ import annotations

from typing import Any

from rk4 import OUTPUTS

from pounding_risk.lab.baselines.solve_ivp import solve_general


def solve_scipy(pair: Any, interface: Any, acceleration: Any, dt: float, rtol: float) -> dict[str, float]:
    """One run from rest; `OUTPUTS` in SI units. Raises RuntimeError where SciPy gives up."""
    found = solve_general("DOP853", pair, interface, (acceleration, dt), rtol)._asdict()
    return {name: float(found[name]) for name in OUTPUTS}
