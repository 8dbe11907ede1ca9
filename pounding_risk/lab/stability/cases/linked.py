"""Hard cases of buildings that springs and dampers join."""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk.lab.stability.case import ENERGY, FORCES, LEDGER, Group
from pounding_risk.lab.stability.trial import SOFT, STIFF, Trial
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.links import Link
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.row.model import RowModel

GROUP = Group("linked")

LIGHT = Building("light", 1e-4 * SOFT.mass, SOFT.period, 0.05)
RATE = 2.0 * np.pi / SOFT.period  # rad/s
TIE = Link(0, 1.0, 1.0, 1e4 * SOFT.mass * RATE**2, 0.0)
# The antisymmetric mode of two masses like the left one has a damping ratio of 2 c / (2 m ω).
DAMPER = Link(0, 1.0, 1.0, 0.0, 50.0 * SOFT.mass * RATE)
STICK = Link(0, 1.0, 1.0, 1e4 * SOFT.mass * RATE**2, 0.0, strength=0.1 * 9.8 * SOFT.mass)
HOOK = STICK._replace(strength=inf, slack=0.0)
BRITTLE = STICK._replace(strength=inf, breaking=0.1 * 9.8 * SOFT.mass)
# At rest the damping is 500 times that at 1 m/s.
POWER = Link(0, 1.0, 1.0, 0.0, 0.5 * 9.8 * SOFT.mass, exponent=0.1)
BRACED = POWER._replace(brace=0.1 * STICK.stiffness)


def with_a_link(trial: Trial, buildings: tuple[Building, ...], link: Link, touching: int, gap: float) -> float:
    """Energy unaccounted for, over the largest; infinite without contact at the interface, or where one pulls."""
    points = [Point(touching, 1.0, 1.0, FLOOR, np.nan)]
    return trial.unsound_row(RowModel([chain_of(one) for one in buildings], points, links=[link]), gap)


OVER_2_MM = {"buildings": (SOFT, STIFF), "touching": 0, "gap": 0.002}  # gap in m
for number, words, scene in (
    (
        "51a",
        "50 kg tied to 500 t by a link 1e4 times as stiff, struck by a neighbour",
        {"buildings": (SOFT, LIGHT, STIFF), "link": TIE, "touching": 1, "gap": 0.005},
    ),
    ("51b", "a damper of 50 times the critical over a gap of nothing", OVER_2_MM | {"link": DAMPER, "gap": 0.0}),
    (
        "53a",
        "a friction damper on a brace 1e4 times as stiff as the buildings, which hardly slips, over 2 mm",
        OVER_2_MM | {"link": STICK},
    ),
    ("53b", "a hook without slack, 1e4 times as stiff as the buildings, over 2 mm", OVER_2_MM | {"link": HOOK}),
    (
        "53c",
        "a damper of the power 0.1 of its speed and half a building's weight, over 2 mm",
        OVER_2_MM | {"link": POWER},
    ),
    (
        "53d",
        "a link 1e4 times as stiff as the buildings, which breaks at a tenth of its weight, over 2 mm",
        OVER_2_MM | {"link": BRITTLE},
    ),
    (
        "53e",
        "the damper of case 53c on a brace 1e3 times as stiff as the buildings, over 2 mm",
        OVER_2_MM | {"link": BRACED},
    ),
):
    GROUP.case(number, words, ENERGY, LEDGER, FORCES, **scene)(with_a_link)
