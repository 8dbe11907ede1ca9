"""Hard cases of more than two masses: free ones in a row that touch, of which the first strikes the others.

Each contact but the first is driven by the one before it and begins with next to no speed.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.lab.stability.case import FORCES, Bound, Group
from pounding_risk.lab.stability.trial import Trial, TrialScene
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.layout import lay_out

GROUP = Group("chains")

MASS, SPEED, MASSES = 1e5, 1.0, 8  # kg, m/s
# As good as free: in the second of a run the springs of the buildings take 2e-11 of the momentum.
PERIOD, DURATION, DT = 1e6, 1.0, 0.01  # s

# Velocities after the wave over that of the striker, of equal masses and contacts without loss, whatever their mass,
# stiffness and speed: SciPy's DOP853 at rtol 1e-13, the same at 1e-11 to 1e-9. tests/lab/test_hard_cases.py.
VELOCITIES = {
    "hertz": (
        -0.071085017,
        -0.030273789,
        -0.015833397,
        -0.008885695,
        -0.005125644,
        0.000166548,
        0.144773845,
        0.986263149,
    ),
    "linear": (
        -0.132279487,
        -0.075412033,
        -0.054662240,
        -0.043561061,
        -0.034094523,
        0.040707355,
        0.399633715,
        0.899668275,
    ),
}


class Wave(NamedTuple):
    """What one run has come to."""

    velocities: NDArray[np.float64]  # of every mass at the end of the run, over that of the striker
    unaccounted: float  # energy, over the largest


def struck(trial: Trial) -> Wave:
    """Masses at rest in a row that touch, the first of which moves: one run under the law of the trial."""
    scene = TrialScene()
    buildings = [Building("", MASS, PERIOD, 0.0, initial_velocity=SPEED if one == 0 else 0.0) for one in range(MASSES)]
    points = [Point(interface, 1.0, 1.0, FLOOR, np.nan) for interface in range(MASSES - 1)]
    contacts = rows.Contacts(
        np.zeros(len(points)),
        np.full(len(points), np.inf),
        [trial.law(scene) for _ in points],
        [scene.restitution for _ in points],
    )
    layout = lay_out([chain_of(building) for building in buildings], points, DT)
    still = np.zeros(round(DURATION / DT) + 1)
    run = rows.run_row(layout, contacts, still, rtol=trial.rtol, histories=True)
    trial.steps += run.steps
    if run.status != COMPLETE and trial.status == COMPLETE:
        trial.status = run.status
    return Wave(run.states[-1, 1] / SPEED, abs(run.residual) / run.energy)


@GROUP.case(
    "49a",
    "eight free masses in a row, touching, the first strikes",
    "the velocities after the wave",
    Bound(2e-9, 1.0, "nine digits of the reference; what the waves carry on of each step's 0.05 rtol"),
    tuple(VELOCITIES),
)
def velocities_after_the_wave(trial: Trial) -> float:
    """Largest difference of a velocity from that of the independent integration, over the striker's."""
    return float(np.abs(struck(trial).velocities - VELOCITIES[trial.name]).max())


@GROUP.case(
    "49b",
    "the same under every law",
    "momentum and energy",
    Bound(1e-10, 10.0, "as for the energy; the springs that hold the masses"),
    FORCES,
)
def momentum_and_energy(trial: Trial) -> float:
    """Momentum that is lost, over the striker's, or energy unaccounted for, whichever is more."""
    wave = struck(trial)
    return max(abs(float(wave.velocities.sum()) - 1.0), wave.unaccounted)
