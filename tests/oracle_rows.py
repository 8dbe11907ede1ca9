"""The reference integrator of rows: chains of masses with contacts between them, sharing no code with the solver.

    m_i ü_i = −(C u̇)_i − V_i + V_{i+1} − m_i a_g − Σ_k B_ki F_k,      δ_k = Σ_i B_ki u_i − gap_k
    V_i = spring_i d_i, d_i = u_i − u_{i−1};  past its strength V_i = (spring_i − shear_i) d_i + H_i(d_i)

u is relative to the ground, a_g linear between samples, δ > 0 penetration, F > 0 compression, B_ki the share of dof i
in the displacement of a point of contact, negative on the right building. H is the bilinear spring with kinematic
hardening: shear_i before its strength, hardening × shear_i after, back along shear_i.

The whole motion, in flight as in contact, is DOP853 at rtol 1e-12, stopped at every record sample and every event
(oracle_rows_motion). Nothing is modal here, and all contacts are one system. Right rather than fast: a few seconds a
scene.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from oracle_laws import WALL, Law, Oscillator, Phase, Scene
from oracle_rows_motion import Motion

POINT_SUMS = ("impact_count", "contact_time", "impulse", "energy_viscous", "yielding_contacts")


class Tower(NamedTuple):
    """A building from its lowest dof up, as numpy arrays; none of them is a rigid building."""

    mass: np.ndarray  # kg
    spring: np.ndarray  # N/m, of the storey below each dof
    shear: np.ndarray  # N/m, without what gravity takes
    damping: np.ndarray  # N s/m, (n, n)
    strength: np.ndarray  # N
    hardening: float = 0.0
    foundations: int = 0  # dofs below the floors


def tower(
    masses: Sequence[float], springs: Sequence[float], damping: np.ndarray | float = 0.0, **more: object
) -> Tower:
    """An elastic one; a number as ``damping`` is the time by which it is in proportion to the stiffness [s]."""
    mass, spring = np.array(masses, dtype=float), np.array(springs, dtype=float)
    if not isinstance(damping, np.ndarray):
        damping = damping * stiffness_matrix(spring)
    return Tower(mass, spring, spring, damping, np.full(mass.size, math.inf))._replace(**more)  # type: ignore[arg-type]


def stiffness_matrix(spring: np.ndarray) -> np.ndarray:
    """Stiffness matrix of a shear building [N/m]."""
    drift = np.eye(spring.size) - np.eye(spring.size, k=-1)
    return drift.T @ np.diag(spring) @ drift


RIGID = tower((), ())


class Meeting(NamedTuple):
    """One point of contact: floor 2.4 is 0.4 up the columns from floor 2 to floor 3; no mass at the ground."""

    interface: int  # between buildings of this number and the next
    left_floor: float
    right_floor: float
    gap: float  # m
    law: str
    stiffness: float
    restitution: float | Sequence[float] = 0.65
    yield_force: float = math.inf
    plastic_exponent: float = 0.0
    fastest: float = 5.0


class Contact:
    """A contact from touch to separation."""

    def __init__(self, meeting: Meeting, mass: float, speed: float) -> None:
        one = Oscillator(mass, 1.0)
        scene = Scene(one, WALL, *meeting[4:6], 0.0, *meeting[6:])
        self.law, self.phase, self.fresh, self.age = Law(scene, speed), Phase(), True, 0.0
        self.yields: list[float] = []


class Answer(NamedTuple):
    """Outputs in SI units: by point of contact under the solver's names, by dof, and where the energy went."""

    points: dict[str, np.ndarray]  # (K,)
    floors: np.ndarray  # (D, 4): largest |u|, |drift|, |storey shear|, |absolute acceleration|
    rest: np.ndarray  # (D, 2): drift at the end; that in the middle of the storey's elastic range then
    open_energy: float  # share of the energy put in that is nowhere
    state: np.ndarray  # u, then v, at the end


class Row(Motion):
    """A row under one record: what it is made of, and what happens at its events."""

    def __init__(self, towers: Sequence[Tower], meetings: Sequence[Meeting], rtol: float = 1e-12) -> None:
        self.towers, self.meetings = towers, meetings
        sizes = [len(each.mass) for each in towers]
        self.first = np.concatenate([[0], np.cumsum(sizes)]).astype(int)
        count = int(self.first[-1])

        def joined(name: str) -> np.ndarray:
            return np.concatenate([getattr(each, name) for each in towers])

        mass, spring, shear, strength = map(joined, ("mass", "spring", "shear", "strength"))
        hardening = np.repeat([each.hardening for each in towers], sizes)
        damping, drift = np.zeros((count, count)), np.eye(count)
        for start, end, each in zip(self.first, self.first[1:], towers, strict=False):
            damping[start:end, start:end] = each.damping
            drift[start:end, start:end] -= np.eye(end - start, k=-1)
        super().__init__(mass, damping, drift, self.shares(), np.array([m.gap for m in meetings]), rtol)
        self.spring, self.shear, self.strength, self.hardening = spring, shear, strength, hardening
        self.limit = np.full(count, math.inf)
        yields = np.isfinite(strength)
        self.limit[yields] = (1.0 - hardening[yields]) * strength[yields]
        self.slip = np.zeros(count)  # d at which the yielding part of H carries nothing
        self.side = np.zeros(count)  # ±1 where a storey yields
        self.contacts: list[Contact | None] = [None] * len(meetings)
        self.sums = {name: np.zeros(len(meetings)) for name in POINT_SUMS}
        self.firsts = {name: np.full(len(meetings), np.nan) for name in ("first_impact_time", "first_yield_time")}
        self.approach = np.zeros(len(meetings))
        self.yielded = 0.0  # J, by storeys
        self.make_springs()

    def shares(self) -> np.ndarray:
        """B, of every point of contact and dof."""
        b = np.zeros((len(self.meetings), int(self.first[-1])))
        for row, meeting in zip(b, self.meetings, strict=True):
            for sign, at, floor in ((1.0, 0, meeting.left_floor), (-1.0, 1, meeting.right_floor)):
                building = meeting.interface + at
                if len(self.towers[building].mass) == 0:
                    continue
                dof = floor - 1.0 + self.towers[building].foundations
                below = math.floor(dof)
                for place, share in ((below, 1.0 - (dof - below)), (below + 1, dof - below)):
                    if place >= 0 and share > 0.0:
                        row[self.first[building] + place] += sign * share
        return b

    def make_springs(self) -> None:
        """V = tangent d + offset of every storey on its present branch."""
        loose = (1.0 - self.hardening) * self.shear
        self.loose = np.where(np.isfinite(self.limit), loose, 0.0)
        yields = self.side != 0.0
        self.tangent = self.spring - np.where(yields, self.loose, 0.0)
        self.offset = np.where(yields, self.side * np.where(yields, self.limit, 0.0), -self.loose * self.slip)
        self.make_maps(self.tangent, self.offset, self.shear - self.spring)

    # ---- events
    def storey_turns(self, index: int) -> None:
        """A storey reaches its strength, or turns back from beyond it."""
        d = float((self.drift @ self.u)[index])
        if self.side[index] == 0.0:
            self.side[index] = math.copysign(1.0, d - self.slip[index])
        else:
            slip = d - self.side[index] * self.limit[index] / self.loose[index]
            self.yielded += self.side[index] * self.limit[index] * (slip - self.slip[index])
            self.slip[index], self.side[index] = slip, 0.0
        self.make_springs()

    def touch(self, k: int) -> None:
        speed = float(self.b[k] @ self.v)
        mass = 1.0 / float(self.b[k] ** 2 @ self.inverse_mass)
        contact = self.contacts[k] = Contact(self.meetings[k], mass, speed)
        self.clock = 0.0
        self.sums["impact_count"][k] += 1.0
        self.approach[k] = max(self.approach[k], speed)
        self.first_time("first_impact_time", k)
        if contact.law.trial(max(self.depths(self.u)[k], 0.0), speed, True) >= contact.law.cap:
            self.contact_yields(k)  # a damper may yield at once

    def first_time(self, name: str, k: int) -> None:
        if math.isnan(self.firsts[name][k]):
            self.firsts[name][k] = self.now

    def contact_yields(self, k: int) -> None:
        contact = self.closed(k)
        contact.phase.yielding = not contact.phase.yielding
        if contact.phase.yielding:
            contact.yields.append(self.now)
            self.first_time("first_yield_time", k)

    def contact_turns(self, k: int) -> None:
        contact = self.closed(k)
        contact.phase.approach, contact.fresh = not contact.phase.approach, False

    def contact_cuts(self, k: int) -> None:
        contact = self.closed(k)
        contact.phase.cut = not contact.phase.cut

    def closed(self, k: int) -> Contact:
        contact = self.contacts[k]
        assert contact is not None
        return contact

    def part(self, k: int) -> None:
        """Add an ended contact to the totals of its point."""
        contact = self.closed(k)
        self.sums["contact_time"][k] += contact.age
        self.sums["yielding_contacts"][k] += bool(contact.yields)
        self.contacts[k] = None

    def happens(self, name: str, index: int) -> None:
        """An event of this name, to a point of contact or to a storey."""
        verbs = {
            "storey": self.storey_turns,
            "touch": self.touch,
            "part": self.part,
            "yield": self.contact_yields,
            "turn": self.contact_turns,
            "cut": self.contact_cuts,
        }
        verbs[name](index)

    # ---- a whole record
    def go(self, acceleration: np.ndarray, dt: float) -> Answer:
        """From the present state through a_g [m/s²] sampled every dt [s]."""
        samples = [float(a) for a in acceleration]
        begun = self.mechanical()
        for k in range(len(samples) - 1):
            slope, done = (samples[k + 1] - samples[k]) / dt, 0.0
            while done < dt * (1.0 - 1e-13):
                self.now = k * dt + done
                done += self.piece((samples[k] + slope * done, slope), dt - done)
        return self.answer(begun)

    def answer(self, begun: float) -> Answer:
        """What came of it; a contact that is not over keeps what it would give back."""
        held = np.zeros(len(self.meetings))
        for k, contact in enumerate(self.contacts):
            if contact is not None:
                held[k] = contact.law.recoverable(float(self.depths(self.u)[k]))
                self.part(k)
        work, impulse, (put_in, damped) = self.quadratures()
        drift = self.drift @ self.u
        slip = np.where(self.side == 0.0, self.slip, drift - self.side * self._elastic_limit())
        taken = self.yielded + float(np.sum(np.where(self.side == 0.0, 0.0, self._taken(slip))))
        left = begun + put_in - damped - work.sum() - taken - self.mechanical()
        points = {
            **self.sums, **self.firsts, **self.contact_peaks(),
            "impulse": impulse, "energy_viscous": work - held, "peak_approach_speed": self.approach,
        }  # fmt: skip
        caps = np.array([m.yield_force for m in self.meetings])
        points["yield_demand"] = points["uncapped_force"] / caps
        rest = np.column_stack([drift, slip])
        floors = self.floor_peaks()
        return Answer(points, floors, rest, left / max(abs(put_in), begun), np.concatenate([self.u, self.v]))

    def _elastic_limit(self) -> np.ndarray:
        finite = np.isfinite(self.limit)
        return np.where(finite, np.where(finite, self.limit, 0.0) / np.where(finite, self.loose, 1.0), 0.0)

    def _taken(self, slip: np.ndarray) -> np.ndarray:
        """J that yielding has taken in storeys that still yield."""
        return self.side * np.where(np.isfinite(self.limit), self.limit, 0.0) * (slip - self.slip)

    def mechanical(self) -> float:
        """Kinetic and recoverable energy of the buildings [J]."""
        d = self.drift @ self.u
        loose = np.where(self.side == 0.0, d - self.slip, self.side * self._elastic_limit())
        strain = (self.spring - self.loose) * d**2 + self.loose * loose**2
        return 0.5 * float(self.mass @ self.v**2 + strain.sum())


def integrate(
    towers: Sequence[Tower], meetings: Sequence[Meeting], acceleration: np.ndarray, dt: float, rtol: float = 1e-12
) -> Answer:
    """A row from rest under a_g [m/s²] sampled every dt [s]."""
    return Row(towers, meetings, rtol).go(acceleration, dt)
