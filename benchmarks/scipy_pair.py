"""The general way: SciPy's ``solve_ivp`` with DOP853, started anew at every record sample and every event.

The viscous elastoplastic law only (with an infinite yield force: Jankowski's). Events are found by SciPy's own root
search: touch, separation, δ̇ = 0, the uncapped force crossing F_E; so are the crests of the relative displacement
and of the force, which are read where they lie. Everything is plain Python, as someone would write it in an afternoon.
"""

from __future__ import annotations

from math import sqrt
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

ABSOLUTE = np.array([1e-14, 1e-14, 1e-13, 1e-13])  # m, m, m/s, m/s


class Phase(NamedTuple):
    """Which piece of the law holds, and what this contact remembers."""

    touching: bool = False
    approaching: bool = True
    yielding: bool = False
    memory: float = 0.0


class ScipyPair:
    """A pair between events; state u_left, u_right, v_left, v_right."""

    def __init__(self, pair: Any, interface: Any) -> None:
        (self.left, self.right), self.interface = pair, interface
        self.mass = 1.0 / (self.left.inverse_mass + self.right.inverse_mass)
        self.ramp = (0.0, 0.0)  # a_g at t = 0 and its slope, over the present sample
        self.phase = Phase()

    def uncapped(self, y: np.ndarray) -> float:
        """β δ^1.5, on approach with the damper."""
        delta = max(y[0] - y[1] - self.interface.gap, 0.0)
        spring = self.interface.law.stiffness * delta * sqrt(delta)
        return spring + self.phase.memory * delta**0.25 * (y[2] - y[3]) if self.phase.approaching else spring

    def force(self, y: np.ndarray) -> float:
        """What the buildings feel."""
        if not self.phase.touching:
            return 0.0
        return self.interface.yield_force if self.phase.yielding else self.uncapped(y)

    def rates(self, t: float, y: np.ndarray) -> list[float]:
        """dy/dt."""
        a_g, force = self.ramp[0] + self.ramp[1] * t, self.force(y)
        left, right = self.left, self.right
        return [
            y[2],
            y[3],
            -left.ground * a_g - left.fade * y[2] - left.spring * y[0] - left.inverse_mass * force,
            -right.ground * a_g - right.fade * y[3] - right.spring * y[1] + right.inverse_mass * force,
        ]

    def force_rate(self, t: float, y: np.ndarray) -> float:
        """dF/dt of the uncapped force, times δ^¾ that it may be finite at the touch."""
        delta, rate = max(y[0] - y[1] - self.interface.gap, 0.0), y[2] - y[3]
        slope = 1.5 * self.interface.law.stiffness * delta**1.25 * rate
        if self.phase.approaching:
            bend = self.rates(t, y)
            slope += self.phase.memory * (0.25 * rate * rate + delta * (bend[2] - bend[3]))
        return slope

    def events(self) -> list[Any]:
        """The events that end this piece, then the crests that do not: functions as ``solve_ivp`` wants them."""
        gap, limit, phase = self.interface.gap, self.interface.yield_force, self.phase

        def event(function: Any, direction: float, terminal: bool) -> Any:
            function.direction, function.terminal = direction, terminal
            return function

        closing = event(lambda t, y: y[0] - y[1] - gap, -1.0 if phase.touching else 1.0, True)
        turn = event(lambda t, y: y[2] - y[3], -1.0 if phase.approaching else 1.0, phase.touching)
        if not phase.touching:
            turn.direction = 0.0
            return [closing, turn]
        found = [closing, turn]
        if limit < np.inf:
            found.append(event(lambda t, y: self.uncapped(y) - limit, -1.0 if phase.yielding else 1.0, True))
        return [*found, event(lambda t, y: self.force_rate(t, y), -1.0, False)]

    def after(self, which: int, y: np.ndarray) -> Phase:
        """The phase past event number ``which``."""
        phase = self.phase
        if which == 0 and not phase.touching:
            speed = max(y[2] - y[3], 0.0)
            memory = self.interface.law.begin(self.interface.restitution.at(speed), speed, self.mass)
            return Phase(True, True, False, memory)
        if which == 0:
            return Phase()
        return phase._replace(approaching=not phase.approaching) if which == 1 else self.yielded()

    def yielded(self) -> Phase:
        """On to the plateau, or off it."""
        return self.phase._replace(yielding=not self.phase.yielding)


def solve_scipy(pair: Any, interface: Any, acceleration: Any, dt: float, rtol: float) -> dict[str, float]:
    """One run from rest; the outputs of ``rk4.OUTPUTS`` in SI units."""
    model = ScipyPair(pair, interface)
    ground = np.asarray(acceleration, dtype=float)
    y, reach, peak, count = np.zeros(4), 0.0, 0.0, 0
    for sample in range(len(ground) - 1):
        slope = (ground[sample + 1] - ground[sample]) / dt
        model.ramp = (float(ground[sample]), float(slope))
        now = 0.0
        while now < dt * (1.0 - 1e-12):
            found = solve_ivp(
                model.rates, (now, dt), y, method="DOP853", rtol=rtol, atol=ABSOLUTE, events=model.events()
            )
            y, ended = found.y[:, -1], found.status == 1
            seen = [*found.y.T, *(crest for crests in found.y_events for crest in crests)]
            reach = max(reach, *(abs(state[0] - state[1]) for state in seen))
            peak = max(peak, *(model.force(state) for state in seen))
            if not ended:
                break
            now = float(found.t[-1])
            # The event that ended the piece is the one found last.
            last = [times[-1] if len(times) else -1.0 for times in found.t_events]
            which = max((i for i in range(len(last)) if model.events()[i].terminal), key=last.__getitem__)
            count += which == 0 and not model.phase.touching
            model.phase = model.after(which, y)
            if which == 0:
                y = y.copy()
                y[0] = y[1] + interface.gap  # the root search leaves rounding in δ
    return {"peak_relative_displacement": reach, "peak_contact_force": peak, "impact_count": float(count)}
