"""The reference integrator: a pair of buildings from the published formulas, sharing no code with the solver.

    m_L ü_L + c_L u̇_L + k_L u_L = −m_L a_g − F
    m_R ü_R + c_R u̇_R + k_R u_R = −m_R a_g + F        δ = u_L − u_R − gap

u is relative to the ground, a_g linear between samples, δ > 0 penetration, F > 0 compression.

Between contacts the motion over one sample is a closed form with a bounded second derivative: touches and
peaks are found with proof (oracle_flight). In contact SciPy's DOP853 runs at rtol 1e-12, stopped at every
record sample and every event, each smooth piece of the law for itself (oracle_contact). Right rather than
fast: a few seconds a scene. Outputs carry the names that the solver gives them.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
from oracle_contact import Contact, Peaks
from oracle_flight import CONFIRMED, Curve, first_touch, floor_acceleration, highest, swing
from oracle_laws import CONCRETE, LAWS, LINEAR, WALL, Law, Oscillator, Scene

__all__ = ["CONCRETE", "LAWS", "LINEAR", "WALL", "Law", "Oscillator", "Scene", "impact", "integrate"]

CREEPING = 1e-7  # m/s: below this a contact starts where the depth is CONFIRMED, its touch time being noise


def impact(scene: Scene, speed: float, rtol: float = 1e-12) -> dict[str, float]:
    """Two free masses meet at a speed [m/s]: periods and gap of the scene are ignored."""
    left, right = (
        Oscillator(b.mass, math.inf if math.isfinite(b.mass) else 0.0, 0.0) for b in (scene.left, scene.right)
    )
    scene = replace(scene, left=left, right=right, gap=0.0)
    peaks = Peaks()
    moving = 1.0 if math.isfinite(scene.left.mass) else 0.0
    start = [0.0, speed, 0.0, moving * speed, 0.0, (moving - 1.0) * speed, 0.0, 0.0]
    contact = Contact(scene, start, peaks, rtol)
    contact.advance((0.0, 0.0), 1e6)
    if not contact.parted:
        raise RuntimeError("the masses never part")
    y = contact.state
    return {
        "restitution": -y[1] / speed,
        "peak_penetration": peaks["depth"],
        "peak_contact_force": peaks["force"],
        "lowest_contact_force": 0.0 - peaks.get("pull", 0.0),
        "peak_uncapped_force": peaks["trial"],
        "duration": contact.age,
        "energy_lost": y[6],
        "impulse": y[7],
        "yield_count": float(len(contact.yields)),
        "velocity_left": y[3],
        "velocity_right": y[5],
    }


class Run:
    """A pair under one record, sample by sample."""

    def __init__(self, scene: Scene, acceleration: np.ndarray, dt: float, rtol: float) -> None:
        self.scene, self.rtol, self.dt = scene, rtol, dt
        self.samples = [float(a) for a in acceleration]
        self.peaks = Peaks()
        self.state = [0.0, 0.0, 0.0, 0.0]  # u_L, v_L, u_R, v_R
        self.contact: Contact | None = None
        self.touches: list[float] = []
        self.speeds: list[float] = []
        self.yields: list[float] = []
        self.contact_time = self.work = self.impulse = 0.0
        self.yielding_contacts = 0

    def go(self) -> dict[str, float]:
        for k in range(len(self.samples) - 1):
            self.sample(k)
        if self.contact is not None:
            left = self.contact.law.recoverable(self.contact.state[0])
            self.close()
            self.work -= left
        return self.outputs()

    def sample(self, k: int) -> None:
        """One sample interval: flights and contacts in turn."""
        slope = (self.samples[k + 1] - self.samples[k]) / self.dt
        done = 0.0
        while done < self.dt * (1.0 - 1e-13):
            ground = (self.samples[k] + slope * done, slope)
            if self.contact is None:
                done += self.fly(ground, self.dt - done, k * self.dt + done)
            else:
                start, began = k * self.dt + done, len(self.contact.yields)
                age = self.contact.age
                done += self.contact.advance(ground, self.dt - done)
                self.yields += [start + y - age for y in self.contact.yields[began:]]
                if self.contact.parted:
                    self.close()

    def fly(self, ground: tuple[float, float], duration: float, now: float) -> float:
        """Free motion for a duration or to the next touch; the time it took."""
        ul, vl, ur, vr = self.state
        left, right = swing(self.scene.left, ul, vl, ground), swing(self.scene.right, ur, vr, ground)
        depth = left.minus(right, self.scene.gap)
        touch = first_touch(depth, duration)
        end = duration if touch is None else touch[1]
        starts_at_once = touch is not None and depth.slope(touch[0]) >= CREEPING
        if touch is not None and starts_at_once:
            end = touch[0]
        self.free_peaks(left, right, ground, end)
        self.state = [left.value(end), left.slope(end), right.value(end), right.slope(end)]
        if touch is not None:
            opened = 0.0 if starts_at_once else CONFIRMED
            speed = depth.slope(end)
            self.contact = Contact(self.scene, [opened, speed, *self.state, 0.0, 0.0], self.peaks, self.rtol)
            self.touches.append(now + touch[0])
            self.contact_time += end - touch[0]  # a creeping contact is followed from a little later on
            self.speeds.append(speed)
            self.yields += [now + end for _ in self.contact.yields]
        return end

    def free_peaks(self, left: Curve, right: Curve, ground: tuple[float, float], end: float) -> None:
        closing = left.minus(right)
        wanted = [("closing", closing), ("opening", closing.negative())]
        for side, motion, building in (("left", left, self.scene.left), ("right", right, self.scene.right)):
            if building.period == 0.0:
                continue
            acceleration = floor_acceleration(motion, ground)
            wanted += [(f"u_{side}", motion), (f"u_{side}", motion.negative())]
            wanted += [(f"a_{side}", acceleration), (f"a_{side}", acceleration.negative())]
        for name, curve in wanted:
            self.peaks[name] = highest(curve, end, self.peaks.get(name, 0.0))

    def close(self) -> None:
        """The contact is over: book it and fly on, the slower building taking up the rounding of δ = 0."""
        contact = self.contact
        assert contact is not None
        _, _, ul, vl, ur, vr, work, impulse = contact.state
        if contact.parted and self.scene.left.period >= self.scene.right.period:
            ul = ur + self.scene.gap
        elif contact.parted:
            ur = ul - self.scene.gap
        self.state = [ul, vl, ur, vr]
        self.work += work
        self.impulse += impulse
        self.contact_time += contact.age
        self.yielding_contacts += bool(contact.yields)
        self.contact = None

    def outputs(self) -> dict[str, float]:
        peak = self.peaks.get
        penetration = peak("depth", 0.0)
        # In contact the closing is gap + δ.
        closing = max(peak("closing", 0.0), penetration + self.scene.gap if penetration else 0.0)
        opening = peak("opening", 0.0)
        cap = self.scene.yield_force
        ground = max(map(abs, self.samples))
        found = {
            "peak_closing": closing,
            "peak_opening": opening,
            "peak_relative_displacement": max(closing, opening),
            "peak_penetration": penetration,
            "peak_contact_force": peak("force", 0.0),
            "lowest_contact_force": 0.0 - peak("pull", 0.0),
            "impact_count": float(len(self.touches)),
            "first_impact_time": self.touches[0] if self.touches else math.nan,
            "contact_time": self.contact_time,
            "impulse": self.impulse,
            "first_yield_time": self.yields[0] if self.yields else math.nan,
            "yield_count": float(len(self.yields)),
            "yielding_contacts": float(self.yielding_contacts),
            "yield_demand": peak("trial", 0.0) / cap,
            "peak_approach_speed": max(self.speeds, default=0.0),
            "energy_viscous": self.work,
        }
        for side, building in (("left", self.scene.left), ("right", self.scene.right)):
            rigid = building.period == 0.0
            found[f"peak_displacement_{side}"] = 0.0 if rigid else peak(f"u_{side}", 0.0)
            found[f"peak_floor_acceleration_{side}"] = ground if rigid else peak(f"a_{side}", 0.0)
        return found


def integrate(
    scene: Scene,
    acceleration: np.ndarray,
    dt: float,
    rtol: float = 1e-12,
    start: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0),
) -> dict[str, float]:
    """A pair under a_g [m/s²] sampled every dt [s]: the solver's outputs by the same names, in SI units.

    It begins with ``start`` = (u, v of the left, u, v of the right building).
    """
    run = Run(scene, np.asarray(acceleration, dtype=float), dt, rtol)
    run.state = list(start)
    return run.go()
