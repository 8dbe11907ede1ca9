"""SciPy's DOP853, started anew at every sample and event, by one call: `pounding_risk.lab.baselines.solve_ivp`."""

from __future__ import annotations

from typing import Any

import numpy as np
from rk4 import OUTPUTS

from pounding_risk.lab.baselines.matrices import RowMatrices
from pounding_risk.lab.baselines.solve_ivp import Contacts, solve_general


def solve_scipy(pair: Any, interface: Any, acceleration: Any, dt: float, rtol: float) -> dict[str, float]:
    """One run from rest; `OUTPUTS` in SI units. Raises RuntimeError where SciPy gives up."""
    mass, stiffness, damping = np.array([(1.0, side.omega2, side.two_zeta_omega) for side in pair]).T / [
        side.inverse_mass for side in pair
    ]
    row = RowMatrices(np.arange(3), mass, np.diag(stiffness), np.diag(damping), np.array([[1.0, -1.0]]))
    contacts = Contacts(
        np.array([interface.gap]), (interface.law,), (interface.restitution,), np.array([interface.yield_force])
    )
    found = solve_general("DOP853", row, contacts, (acceleration, dt), rtol)._asdict()
    return {name: found[name].item() for name in OUTPUTS}
