"""What is left out of a grid: screening against simulation, and laws by address.

Symmetries and limits of whole runs are properties in tests/lab.
"""

from __future__ import annotations

from math import inf

import numpy as np
import pytest
from processes import compiled

from pounding_risk.models.contact.impulsive.rigid import Stereomechanical
from pounding_risk.models.contact.laws import Jankowski, Tabulated, ViscousElastoplastic
from pounding_risk.models.effects.permanent_set import PermanentSet
from pounding_risk.models.effects.unloading_stiffness import UnloadingStiffness
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.sdof import Building
from pounding_risk.motions.read import read_motion
from pounding_risk.solver.counters import COUNT
from pounding_risk.solver.pair.api import free_response, oscillators
from pounding_risk.solver.pair.grid import solve_grid
from pounding_risk.solver.pair.outputs import COLUMNS
from pounding_risk.solver.workspace import make_workspace

LEFT, RIGHT = Building("left", 500e3, 0.5, 0.05), Building("right", 800e3, 1.0, 0.05)


@pytest.fixture(scope="module")
def el_centro():
    return read_motion("RSN6-180")


@pytest.fixture(scope="module")
def short(el_centro):
    """Eight seconds with the strongest shaking."""
    return el_centro.acceleration[:801], el_centro.dt


def grid(law, motion, gaps, forces, screening, own_kernel=False):
    out, how = np.zeros((len(gaps), len(forces), COLUMNS)), np.zeros((len(gaps), len(forces)), dtype=np.int8)
    pair = oscillators(LEFT, RIGHT)
    free = free_response(pair, *motion)
    cases = gaps, forces, constant(0.65)
    solve_grid(pair, free, law, cases, 1e-6, screening, make_workspace(), out, how, own_kernel)
    return out, how


DENTED = UnloadingStiffness(PermanentSet(ViscousElastoplastic(2.75e9)), 1.5)  # remembers two numbers
BUMPER = Tabulated.of([0.0, 0.01, 0.02, 0.03], [0.0, 1e5, 3e5, 6e5], [0.0, 0.0, 0.5e5, 6e5])  # from its points
OWN = [DENTED, Jankowski(2.75e9), Stereomechanical(), BUMPER]


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("law", OWN, ids=lambda law: type(law).__name__)
def test_a_law_by_address_gives_the_bits_of_its_own_kernel(law, short):
    gaps, forces = np.array([0.0, 0.02]), np.array([1e6, 5e6, inf])
    called, _ = grid(law, short, gaps, forces, True)
    own, _ = grid(law, short, gaps, forces, True, own_kernel=True)
    assert called[..., COUNT].min() > 0.0
    assert np.array_equal(called, own, equal_nan=True)


def test_any_chunk_of_gaps_gives_the_same_bits(short):
    gaps, forces = np.linspace(0.0, 0.1, 7), np.array([1e6, inf])
    whole, _ = grid(ViscousElastoplastic(2.75e9), short, gaps, forces, True)
    for place in range(len(gaps)):
        one, _ = grid(ViscousElastoplastic(2.75e9), short, gaps[place : place + 1], forces, True)
        assert np.array_equal(one[0], whole[place], equal_nan=True)


def test_half_of_a_grid_needs_no_run_of_its_own(el_centro):
    """50 gaps up to twice the closing that the free motion reaches, 20 yield forces up to 20 MN, as one would choose
    them before knowing the answers."""
    pair = oscillators(LEFT, RIGHT)
    closing = free_response(pair, el_centro.acceleration, el_centro.dt).high[:, 0].max()
    gaps, forces = np.linspace(0.0, 2.0 * closing, 50), np.append(np.linspace(1e6, 19e6, 19), inf)
    _, how = grid(ViscousElastoplastic(2.75e9), (el_centro.acceleration, el_centro.dt), gaps, forces, True)
    assert how.mean() <= 0.5
