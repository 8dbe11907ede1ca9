"""Hard cases of storeys that yield by laws of their own."""

from __future__ import annotations

from dataclasses import replace
from math import inf

import numpy as np

from pounding_risk.lab.stability.case import ENERGY, FORCES, LEDGER, ONE, Bound, Group
from pounding_risk.lab.stability.trial import SOFT, WALL, Trial, TrialScene
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.solver.counters import COLLAPSED
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.model import RowModel

GROUP = Group("yielding")

YIELDS = [("inelastic_storeys", [("hardening", 0.0)])]
LEANING = [*YIELDS, ("p_delta", [])]
FLAT = Hysteresis("kinematic")
PINCHED = Hysteresis(
    "peak_oriented",
    ((2.0, 1.1), (8.0, 0.2)),
    pinching_drift=0.4,
    pinching_force=0.2,
    unloading=0.5,
    energy_capacity=30.0,
)
FALLING = Hysteresis("peak_oriented", ((2.0, 1.0), (20.0, 0.01)), collapse_drift=0.1)
STATED = Bound(0.0, 0.0, "stated as what it is")


def _frame(law: Hysteresis, strength: float) -> Storeys:
    """Two storeys of some 0.45 s whose yield shears are a share ``strength`` of the weight above them."""
    weights = (9.8e6, 4.9e6)
    strengths = tuple(strength * weight for weight in weights)
    return Storeys("frame", (5e5, 5e5), (2.5e8, 2e8), (3.0, 3.0), strengths=strengths, hysteresis=law)


def _beside_walls(frame: Chain) -> RowModel:
    points = [Point(interface, 2.0, 2.0, FLOOR, 6.0) for interface in range(2)]
    points = [points[0]._replace(left_floor=0.0), points[1]._replace(right_floor=0.0)]
    return RowModel([chain_of(WALL), frame, chain_of(WALL)], points)


@GROUP.case(
    "52a",
    "storeys without stiffness past yield between walls at 2 mm, shaken",
    ENERGY,
    LEDGER,
    FORCES,
    law=FLAT,
    effects=YIELDS,
)
@GROUP.case(
    "52b",
    "pinched storeys that fall and lose strength, under P-delta, between walls at 2 mm, shaken",
    ENERGY,
    LEDGER,
    FORCES,
    law=PINCHED,
    effects=LEANING,
)
def between_walls(trial: Trial, law: Hysteresis, effects: list) -> float:
    """Energy unaccounted for, over the largest; infinite without contact at both walls, or where one pulls."""
    return trial.unsound_row(_beside_walls(chain_of(_frame(law, 0.15), effects)), 0.002)


@GROUP.case(
    "54",
    "a frame by its matrices, masses of 1 : 1e4 that share inertia, a part of it without stiffness past yield, as 52a",
    ENERGY,
    LEDGER,
    FORCES,
)
def by_matrices(trial: Trial) -> float:
    """As `between_walls`, of a roof of 50 kg that a floor of 500 t carries along."""
    frame = _frame(FLAT, 0.15)
    whole = 1.5 * frame.matrices()[2]
    by_matrix = replace(
        frame,
        masses=(5.04e5, 4.05e3),
        mass_matrix=((5e5, 4e3), (4e3, 50.0)),
        stiffness_matrix=tuple(map(tuple, whole.tolist())),
    )
    return trial.unsound_row(_beside_walls(chain_of(by_matrix, YIELDS)), 0.002)


@GROUP.case(
    "52c",
    "a storey on a falling branch under P-delta, struck by a neighbour, until it collapses",
    "the run ends as a collapse, no failure of the solver",
    STATED,
    ONE,
)
def until_collapse(trial: Trial) -> float:
    """0 where the status states the collapse, infinite otherwise."""
    scene = TrialScene()
    frame = chain_of(_frame(FALLING, 0.05), LEANING)
    row = RowModel([chain_of(SOFT), frame], [Point(0, 1.0, 2.0, FLOOR, 6.0)])
    contacts = rows.Contacts(row.gaps(np.array([0.005])), np.full(1, inf), [trial.law(scene)], [scene.restitution])
    run = rows.run_row(row.row(scene.dt), contacts, scene.ground, rtol=trial.rtol)
    trial.steps += run.steps
    return 0.0 if run.status == COLLAPSED and run.points[0, 0] > 0.0 else inf
