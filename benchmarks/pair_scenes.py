"""Scenes on which `side_by_side.py` sets methods beside each other: constant e, no yielding, laws that OpenSees has."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pounding_risk.models.contact.laws import HertzDamp, Jankowski, KelvinVoigt
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.read import read_motion
from pounding_risk.scene.motions import motions_of
from pounding_risk.solver.pair.api import Interface
from pounding_risk.studies.demo import scene as shipped_scene

E = 0.65
RECORD = "RSN6-180"
LEFT, RIGHT = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)
GAPS = (0.01, 0.02, 0.04)  # m
MODERATE_LAWS = (Jankowski(2.75e9), HertzDamp(2.75e9), KelvinVoigt(9.35e7))
PAPER_LAWS = (Jankowski, HertzDamp)
PAPER_LINEAR = KelvinVoigt(1e9)  # N/m: a peak force within 3 % of Jankowski's in that scene


class Scene(NamedTuple):
    """One pair under one motion: everything that any method is told."""

    name: str
    left: Building
    right: Building
    interface: Interface
    acceleration: np.ndarray  # m/s²
    dt: float  # s

    @property
    def law(self) -> str:
        """The class of the contact law."""
        return type(self.interface.law).__name__

    @property
    def group(self) -> str:
        """Which of the pairs it is, whatever the gap."""
        return self.name.partition(",")[0]

    @property
    def duration(self) -> float:
        """From the first sample to the last [s]."""
        return (len(self.acceleration) - 1) * self.dt


def moderate_scenes(samples: int | None = None, gaps: tuple[float, ...] = GAPS) -> list[Scene]:
    """T 0.5 and 1.0 s, 500 and 800 t, ζ 5 % under the full El Centro record, or under its first samples."""
    motion = read_motion(RECORD)
    ground = motion.acceleration[:samples]
    return [
        Scene(f"moderate pair, {1e3 * gap:g} mm", LEFT, RIGHT, Interface(gap, law, constant(E)), ground, motion.dt)
        for gap in gaps
        for law in MODERATE_LAWS
    ]


def paper_scenes() -> list[Scene]:
    """The pair of Khatiwada et al. (2011), gap closed, 6 s of El Centro at 0.5 g; e constant and no yielding."""
    study = shipped_scene("paper")
    motion = motions_of(study)[0]
    laws = (*(law(study.stiffness) for law in PAPER_LAWS), PAPER_LINEAR)
    interfaces = [Interface(study.gap, law, constant(E)) for law in laws]
    ground, dt = motion.acceleration, motion.dt
    return [Scene("the paper's pair", *study.buildings, interface, ground, dt) for interface in interfaces]


def all_scenes() -> list[Scene]:
    """Twelve scenes: 10 to 44 contacts each."""
    return [*moderate_scenes(), *paper_scenes()]
