"""Ten contact forces of pairs like that of the study of contact laws, by DOP853 with laws that are written here."""

from __future__ import annotations

from itertools import pairwise
from math import log, pi, sqrt
from typing import Any

import numpy as np
import pytest
from scenes import scene_text, single
from scipy.integrate import solve_ivp

import pounding_risk as pr

pytestmark = pytest.mark.complete

MASSES, PERIODS, GAP, E = np.array([5e5, 8e5]), np.array([0.5, 1.0]), 0.02, 0.65
OMEGA = 2.0 * pi / PERIODS
RECORDS = ("RSN6-180", "RSN77-254", "RSN753-000", "RSN1690-090", "NAPA-HNE")
K, BETA = 9.35e8, 2.75e10
DASHPOT = 2.0 * (-log(E) / sqrt(pi**2 + log(E) ** 2)) * sqrt(K * MASSES.prod() / MASSES.sum())
LAWS = {
    "hertz": lambda depth, rate: BETA * max(depth, 0.0) ** 1.5,
    "kelvin_voigt": lambda depth, rate: K * depth + DASHPOT * rate,
}


def peaks(law: Any, ground: np.ndarray, dt: float) -> tuple[float, int]:
    """The largest contact force [N] and the number of contacts, from sample to sample and event to event."""

    def slope(t: float, y: np.ndarray, start: float, first: float, ramp: float, closed: bool) -> np.ndarray:
        pull = first + ramp * (t - start)
        force = law(y[0] - y[1] - GAP, y[2] - y[3]) if closed else 0.0
        push = np.array([-force, force]) / MASSES
        return np.concatenate([y[2:], -(OMEGA**2) * y[:2] - 0.1 * OMEGA * y[2:] - pull + push])

    def meet(t: float, y: np.ndarray, *motion: Any) -> float:
        return y[0] - y[1] - GAP

    meet.terminal = True  # type: ignore[attr-defined]
    state, closed, force, count = np.zeros(4), False, 0.0, 0
    for place, (first, second) in enumerate(pairwise(ground)):
        here, stop = place * dt, (place + 1) * dt
        while here < stop:
            meet.direction = -1.0 if closed else 1.0  # type: ignore[attr-defined]
            motion = place * dt, first, (second - first) / dt, closed
            part = solve_ivp(
                slope, (here, stop), state, "DOP853", events=meet, args=motion, rtol=1e-9, atol=1e-12, dense_output=True
            )
            if closed:
                depth, rate = (
                    np.diff(part.sol(np.linspace(here, part.t[-1], 60))[k : k + 2], axis=0)[0] for k in (0, 2)
                )
                force = max(force, *(law(-one - GAP, -other) for one, other in zip(depth, rate, strict=True)))
            here, state = part.t[-1], part.y[:, -1]
            if part.status == 1:
                closed = not closed
                count += closed
    return force, count


@pytest.mark.parametrize("name", LAWS)
def test_forces_are_those_of_laws_written_here(name: str):
    """Forces at sixty places of each step of the reference: 1e-3 of a peak."""
    left, right = (
        single(side, f"{mass} kg", f"{period} s") for side, mass, period in zip("AB", MASSES, PERIODS, strict=True)
    )
    stiffness = f"{K} N/m" if name == "kelvin_voigt" else f"{BETA} N/m^1.5"
    records = {"names": list(RECORDS), "window": ["0 s", "6 s"], "pga": "0.3 g"}
    keys: dict[str, Any] = {"restitution": E} if name == "kelvin_voigt" else {}
    found = pr.scan(
        pr.read_scene(scene_text(left, right, records=records, law=name, gap="20 mm", stiffness=stiffness, **keys))
    )
    assert int(found["impact_count"].sum()) > 20
    for record in RECORDS:
        motion = pr.read_motion(record, window=(0.0, 6.0), pga="0.3 g")
        force, count = peaks(LAWS[name], motion.acceleration, motion.dt)
        own = found.sel(record=record)
        assert count == own["impact_count"].item()
        assert force == pytest.approx(own["peak_contact_force"].item(), rel=1e-3)
