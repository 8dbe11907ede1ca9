"""Rows on which `opensees_row.py` sets OpenSees beside this package: elastic storeys, constant e, floors meet floors.

OpenSees has no yield force, no e that falls with the speed and, in one dimension, no contact part-way up a column.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from pounding_risk.models.contact.laws import HertzDamp, Jankowski
from pounding_risk.models.restitution import Restitution, constant
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.read import read_motion
from pounding_risk.units import STANDARD_GRAVITY

RECORD = "RSN6-180"
E = constant(0.65)
STIFFNESS = 2.75e9  # N/m^1.5


class RowScene(NamedTuple):
    """One row under one motion: everything that any method is told."""

    name: str
    chains: tuple[Chain, ...]
    points: tuple[tuple[int, int, int], ...]  # interface, floor on its left, floor on its right
    gap: float  # m, of every interface
    law: Jankowski | HertzDamp
    restitution: Restitution
    acceleration: np.ndarray  # m/s²
    dt: float  # s

    @property
    def duration(self) -> float:
        """From the first sample to the last [s]."""
        return (len(self.acceleration) - 1) * self.dt


def even(name: str, floors: int, mass: float, stiffness: float, rule: str) -> Chain:
    """A building of equal storeys of 3 m."""
    return chain_of(Storeys(name, (mass,) * floors, (stiffness,) * floors, (3.0,) * floors, damping_rule=rule))


def ground(duration: float, pga: float) -> tuple[np.ndarray, float]:
    """The beginning of El Centro 1940, scaled [g]."""
    motion = read_motion(RECORD, window=(0.0, duration), pga=pga * STANDARD_GRAVITY)
    return motion.acceleration, motion.dt


def three_storey_pair(duration: float = 6.0) -> RowScene:
    """The buildings of Jankowski (2008), T 1.2 and 0.3 s: three floors of 25 t beside three of 1000 t, gap 20 mm."""
    chains = even("slender", 3, 25e3, 3.46e6, "stiffness"), even("stocky", 3, 1e6, 2.215e9, "stiffness")
    points = tuple((0, floor, floor) for floor in (1, 2, 3))
    return RowScene("3-storey pair", chains, points, 0.02, Jankowski(STIFFNESS), E, *ground(duration, 0.3))


def row_of_four(duration: float = 6.0) -> RowScene:
    """A single mass, three storeys, two and four, 10 mm apart; Rayleigh damping."""
    single = chain_of(Building("shop", 300e3, 0.35, 0.05))
    buildings = [(3, 150e3, 2e8), (2, 400e3, 9e8), (4, 200e3, 1.5e8)]
    chains = single, *(even(f"{n} storeys", n, mass, k, "rayleigh") for n, mass, k in buildings)
    points = (0, 1, 1), (1, 1, 1), (1, 2, 2), (2, 1, 1), (2, 2, 2)
    return RowScene("row of four", chains, points, 0.01, HertzDamp(STIFFNESS), E, *ground(duration, 0.4))


def ten_and_eight(duration: float = 40.0) -> RowScene:
    """Ten storeys beside eight, T 1.0 and 0.6 s, eight floors that meet, 20 mm apart."""
    chains = even("ten", 10, 300e3, 5.3e8, "rayleigh"), even("eight", 8, 400e3, 1.29e9, "rayleigh")
    points = tuple((0, floor, floor) for floor in range(1, 9))
    return RowScene("10 and 8 storeys", chains, points, 0.02, Jankowski(STIFFNESS), E, *ground(duration, 0.3))
