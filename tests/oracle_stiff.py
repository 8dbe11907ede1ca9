"""The reference of overdamped contacts: the equations of `oracle_rows` by SciPy's Radau, implicit and of order 5.

An explicit reference would need a step for every m/c of the contact. The events, and what is read from the motion, are
those of the other reference; the Jacobian is made of differences of its equations.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from oracle_rows import Row
from scipy.integrate import Radau

NUDGES = 1e-12, 1e-9  # m, m/s: small beside any penetration and speed of a contact, large beside their rounding


class StiffRow(Row):
    """A row under one record, for contacts whose dampers are much quicker than the buildings."""

    def solver(
        self, rhs: Callable[..., np.ndarray], start: float, state: np.ndarray, stop: float, **more: Any
    ) -> Radau:
        """SciPy's, with derivatives by u and v alone: the sums of contacts and energies act on nothing."""

        def jacobian(x: float, y: np.ndarray) -> np.ndarray:
            table, here = np.zeros((y.size, y.size)), rhs(x, y)
            for column in range(2 * self.count):
                moved = y.copy()
                moved[column] += NUDGES[column // self.count]
                table[:, column] = (rhs(x, moved) - here) / (moved[column] - y[column])
            return table

        return Radau(rhs, start, state, stop, rtol=self.rtol, atol=self.absolute, jac=jacobian, **more)
