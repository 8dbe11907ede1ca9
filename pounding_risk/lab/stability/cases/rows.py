"""Hard cases of rows: free masses that touch, interior modes, slabs in their moats, links, storeys that yield."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from math import inf
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.lab.stability.case import FORCES, ONE, Bound, Group
from pounding_risk.lab.stability.trial import SOFT, STIFF, WALL, Trial, TrialScene
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.isolation import Isolators
from pounding_risk.models.structures.links import Link
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.matrix_buildings import MatrixBuilding
from pounding_risk.solver.counters import COLLAPSED
from pounding_risk.solver.row.model import RowModel

CHAINS, CONDENSED, ISOLATED, LINKED, YIELDING = (
    Group(name) for name in ("chains", "condensed", "isolated", "linked", "yielding")
)


def row_of(chains: Sequence[Chain], *meetings: tuple[int, float, float], links: Sequence[Link] = ()) -> RowModel:
    """A row whose buildings meet at these places: interface, left and right floor."""
    return RowModel(chains, [Point(*meeting, FLOOR, np.nan) for meeting in meetings], links=links)


# ------------------------------------------------------------------------------------------------ free masses
# In a row that touch, of which the first strikes the others. Each contact but the first is driven by the one before it
# and begins with next to no speed.
MASS, SPEED, MASSES = 1e5, 1.0, 8  # kg, m/s
# As good as free: in the second of a run the springs of the buildings take 2e-11 of the momentum.
PERIOD, STILL = 1e6, TrialScene(ground=np.zeros(101))  # s
# Velocities after the wave over that of the striker, of equal masses and contacts without loss, whatever their mass,
# stiffness and speed: SciPy's DOP853 at rtol 1e-13, the same at 1e-11 to 1e-9. tests/lab/test_hard_cases.py.
VELOCITIES = {
    "hertz": (
        *(-0.071085017, -0.030273789, -0.015833397, -0.008885695),
        *(-0.005125644, 0.000166548, 0.144773845, 0.986263149),
    ),
    "linear": (
        *(-0.132279487, -0.075412033, -0.054662240, -0.043561061),
        *(-0.034094523, 0.040707355, 0.399633715, 0.899668275),
    ),
}
WAVES = Bound(2e-9, 1.0, "nine digits of the reference; what the waves carry on of each step's 0.05 rtol")
SPRINGS = Bound(1e-10, 10.0, "as for the energy; the springs that hold the masses")


class Wave(NamedTuple):
    """What one run has come to."""

    velocities: NDArray[np.float64]  # of every mass at the end of the run, over that of the striker
    unaccounted: float  # energy, over the largest


def struck(trial: Trial) -> Wave:
    """Masses at rest in a row that touch, the first of which moves: one run under the law of the trial."""
    building = Building("", MASS, PERIOD, 0.0)
    chains = [chain_of(building._replace(initial_velocity=SPEED)), *[chain_of(building)] * (MASSES - 1)]
    run = trial.solve_row(row_of(chains, *((number, 1.0, 1.0) for number in range(MASSES - 1))), STILL)
    return Wave(run.states[-1, 1] / SPEED, abs(run.residual) / run.energy)


@CHAINS.case(
    "49a",
    "eight free masses in a row, touching, the first strikes",
    "the velocities after the wave",
    WAVES,
    tuple(VELOCITIES),
)
def velocities_after_the_wave(trial: Trial) -> float:
    """Largest difference of a velocity from that of the independent integration, over the striker's."""
    return float(np.abs(struck(trial).velocities - VELOCITIES[trial.name]).max())


@CHAINS.case("49b", "the same under every law", "momentum and energy", SPRINGS, FORCES)
def momentum_and_energy(trial: Trial) -> float:
    """Momentum that is lost, over the striker's, or energy unaccounted for, whichever is more."""
    wave = struck(trial)
    return max(abs(float(wave.velocities.sum()) - 1.0), wave.unaccounted)


# ------------------------------------------------------------------------------------------------ interior modes
# Two springs in series, 500 t between them and 50 kg at the end, which is the only floor and is struck.
TIP = MatrixBuilding(
    name="tip",
    stiffness_matrix=((5e8, -2.5e8), (-2.5e8, 2.5e8)),
    mass_matrix=((5e5, 0.0), (0.0, 50.0)),
    floor_rows=(2,),
    along_rows=(1, 2),
    interior_modes=1,
    storey_heights=(4.0,),
)


# ------------------------------------------------------------------------------------------------ isolated buildings
# Against the walls of their moats, which their slab strikes.
ABOVE = Storeys("above the slab", (5e5, 5e5, 4e5), (1e9, 1e9, 8e8), (4.0, 4.0, 4.0))
BEARINGS = Isolators(6e5, 1.5, strength=9e5, stiffness=5e6, yield_displacement=0.01, damping=2e5)
SLIDERS = Isolators(6e5, 1.5, friction=0.05, radius=2.0, yield_displacement=1e-6)  # m, next to a stick


def between_walls(building: Chain, floor: float) -> RowModel:
    """A building between walls that this floor of it strikes."""
    return row_of([chain_of(WALL), building, chain_of(WALL)], (0, 0.0, floor), (1, floor, 0.0))


CONDENSED.energy_of_row(
    "55",
    "a floor of 50 kg before 500 t that stand in an interior mode, between walls at 2 mm, shaken",
    between_walls(chain_of(TIP.structure()), 1.0),
    0.002,
)
for number, words, isolators, gap in (
    ("50a", "lead-rubber bearings between walls without a gap, shaken", BEARINGS, 0.0),
    ("50b", "friction pendulums beside walls at 10 mm, shaken", SLIDERS, 0.01),
):
    ISOLATED.energy_of_row(number, words, between_walls(chain_of(ABOVE.isolated(isolators)), 1.0), gap)

# ------------------------------------------------------------------------------------------------ linked buildings
# Joined by springs and dampers.
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
TIED = row_of([chain_of(one) for one in (SOFT, LIGHT, STIFF)], (1, 1.0, 1.0), links=[TIE])
LINKED.energy_of_row("51a", "50 kg tied to 500 t by a link 1e4 times as stiff, struck by a neighbour", TIED, 0.005)
for number, words, link, gap in (
    ("51b", "a damper of 50 times the critical over a gap of nothing", DAMPER, 0.0),
    (
        "53a",
        "a friction damper on a brace 1e4 times as stiff as the buildings, which hardly slips, over 2 mm",
        STICK,
        0.002,
    ),
    ("53b", "a hook without slack, 1e4 times as stiff as the buildings, over 2 mm", HOOK, 0.002),
    ("53c", "a damper of the power 0.1 of its speed and half a building's weight, over 2 mm", POWER, 0.002),
    (
        "53d",
        "a link 1e4 times as stiff as the buildings, which breaks at a tenth of its weight, over 2 mm",
        BRITTLE,
        0.002,
    ),
    ("53e", "the damper of case 53c on a brace 1e3 times as stiff as the buildings, over 2 mm", BRACED, 0.002),
):
    LINKED.energy_of_row(number, words, row_of([chain_of(SOFT), chain_of(STIFF)], (0, 1.0, 1.0), links=[link]), gap)

# ------------------------------------------------------------------------------------------------ storeys that yield
YIELDS = [("inelastic_storeys", [("hardening", 0.0)])]
LEANING = [*YIELDS, ("p_delta", [])]
FLAT = Hysteresis("kinematic")
PINCHING = {"pinching_drift": 0.4, "pinching_force": 0.2}
PINCHED = Hysteresis("peak_oriented", ((2.0, 1.1), (8.0, 0.2)), **PINCHING, unloading=0.5, energy_capacity=30.0)
FALLING = Hysteresis("peak_oriented", ((2.0, 1.0), (20.0, 0.01)), collapse_drift=0.1)
STATED = Bound(0.0, 0.0, "stated as what it is")


def frame(law: Hysteresis, strength: float) -> Storeys:
    """Two storeys of some 0.45 s whose yield shears are a share ``strength`` of the weight above them."""
    strengths = (strength * 9.8e6, strength * 4.9e6)
    return Storeys("frame", (5e5, 5e5), (2.5e8, 2e8), (3.0, 3.0), strengths=strengths, hysteresis=law)


def by_matrices(building: Storeys) -> Storeys:
    """The frame with a roof of 50 kg that a floor of 500 t carries along, and a stiffness half as large again."""
    stiffness = tuple(map(tuple, (1.5 * building.matrices()[2]).tolist()))
    masses: dict[str, Any] = {"masses": (5.04e5, 4.05e3), "mass_matrix": ((5e5, 4e3), (4e3, 50.0))}
    return replace(building, stiffness_matrix=stiffness, **masses)


for number, words, building, effects in (
    ("52a", "storeys without stiffness past yield between walls at 2 mm, shaken", frame(FLAT, 0.15), YIELDS),
    (
        "52b",
        "pinched storeys that fall and lose strength, under P-delta, between walls at 2 mm, shaken",
        frame(PINCHED, 0.15),
        LEANING,
    ),
    (
        "54",
        "a frame by its matrices, masses of 1 : 1e4 that share inertia, a part of it without stiffness past yield, "
        "as 52a",
        by_matrices(frame(FLAT, 0.15)),
        YIELDS,
    ),
):
    YIELDING.energy_of_row(number, words, between_walls(chain_of(building, effects), 2.0), 0.002)


@YIELDING.case(
    "52c",
    "a storey on a falling branch under P-delta, struck by a neighbour, until it collapses",
    "the run ends as a collapse, no failure of the solver",
    STATED,
    ONE,
)
def until_collapse(trial: Trial) -> float:
    """0 where the status states the collapse, infinite otherwise."""
    row = row_of([chain_of(SOFT), chain_of(frame(FALLING, 0.05), LEANING)], (0, 1.0, 2.0))
    run = trial.solve_row(row, TrialScene(gap=0.005), COLLAPSED)
    return 0.0 if run.status == COLLAPSED and run.points[0, 0] > 0.0 else inf
