"""Storeys, isolators and links with laws in OpenSees: its transient analysis comes to these runs as its step falls."""

from collections.abc import Iterable
from math import inf, pi, sqrt
from typing import Any

import numpy as np
import pytest
from sweeps import sweep
from test_hysteresis import IN_OPENSEES, LOSING, SHAKING, TIME, bouc_wen, building, losing

from pounding_risk.lab.accuracy_opensees import link_dashpot
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.isolation import Isolators
from pounding_risk.models.structures.links import Link
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.solver.row.api import free_row
from pounding_risk.solver.row.layout import RowLayout, lay_out
from pounding_risk.solver.row.model import RowModel
from pounding_risk.units import STANDARD_GRAVITY

MASS, STIFFNESS, STRENGTH = 1e5, 5e7, 4e5  # kg, N/m, N: of one storey of `building`
YIELD = STRENGTH / STIFFNESS
GROUND = np.append(0.0, SHAKING[1:])  # OpenSees begins without acceleration
# Each half cycle goes further than all before: after a smaller one materials of OpenSees that lose strength are first
# reloaded to where it turned, and this package, as their `Hysteretic`, at once to the largest drift.
GROWING = 1.5 * TIME * np.sin(2.0 * pi * 1.3 * TIME)
DASHPOT = 2.0 * 0.05 * sqrt(STIFFNESS * MASS)


def scaled(kind: str, *numbers: float) -> tuple[Any, ...]:
    """Points of a loop in m and N that are given in yield drifts and hundredths of the strength."""
    points = [value * (STRENGTH / 100.0 if place % 2 == 0 else YIELD) for place, value in enumerate(numbers[:12])]
    return kind, *points, *numbers[12:]


STOREYS: dict[str, tuple[Hysteresis, float, tuple[Any, ...]]] = {
    **{
        name: (IN_OPENSEES[name][0], 0.0, scaled(*IN_OPENSEES[name][1]))
        for name in ("peak_oriented", "softer unloading")
    },
    **{
        kind: (Hysteresis("peak_oriented", energy_capacity=60.0), 0.0, losing(kind, STIFFNESS, STRENGTH, 60.0, 1.0))
        for kind in LOSING
    },
    "isotropic": (Hysteresis("isotropic"), 0.05, ("Hardening", STIFFNESS, STRENGTH, STIFFNESS * 0.05 / 0.95, 0.0)),
    "kinematic": (Hysteresis("kinematic"), 0.05, ("Steel01", STRENGTH, STIFFNESS, 0.05)),
    "multilinear": (
        Hysteresis("kinematic", ((2.0, 1.3), (6.0, 1.5))),
        0.0,
        ("MultiLinear", YIELD, STRENGTH, 2 * YIELD, 1.3 * STRENGTH, 6 * YIELD, 1.5 * STRENGTH, 9.0, 1.5 * STRENGTH),
    ),
    "bouc_wen": (
        bouc_wen({"exponent": 2.0, "beta": 0.5}),
        0.05,
        ("BoucWen", 0.05, STIFFNESS, 2.0, 0.5 / YIELD**2, 0.5 / YIELD**2, 1.0, 0.0, 0.0, 0.0, 1e-10, 50),
    ),
}


NEWMARK = ("Newmark", 0.5, 0.25)


def analyse_by(ops: Any, kind: str, integrator: tuple[Any, ...], algorithm: str = "Newton") -> None:
    """Make an analysis that iterates to rounding."""
    ops.constraints("Plain")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormDispIncr", 1e-12, 100)
    ops.algorithm(algorithm)
    ops.integrator(*integrator)
    ops.analysis(kind)


def histories(ops: Any, nodes: Iterable[int], step: float) -> np.ndarray:
    """Displacements of nodes along the row at the samples, in steps [s]."""
    found = [[0.0 for _ in nodes]]
    for _ in range(TIME.size - 1):
        assert ops.analyze(round(0.01 / step), step) == 0
        found.append([ops.nodeDisp(node, 1) for node in nodes])
    return np.array(found)


def transient(ops: Any, masses: list[float], joins: Any, step: float, algorithm: str, ground: np.ndarray) -> np.ndarray:
    """Displacements of masses at the samples: ``joins`` are two nodes, 0 the ground, a material and a dashpot."""
    ops.wipe()
    ops.model("basic", "-ndm", 1, "-ndf", 1)
    for node, mass in enumerate([0.0, *masses]):
        ops.node(node, 0.0)
        if node:
            ops.mass(node, mass)
    ops.fix(0, 1)
    for tag, (one, other, (kind, *numbers), dashpot) in enumerate(joins, 1):
        ops.uniaxialMaterial(kind, 2 * tag, *numbers)
        ops.uniaxialMaterial("Viscous", 2 * tag + 1, dashpot, 1.0)
        ops.element("zeroLength", 2 * tag, one, other, "-mat", 2 * tag, "-dir", 1)
        ops.element("zeroLength", 2 * tag + 1, one, other, "-mat", 2 * tag + 1, "-dir", 1)
    ops.timeSeries("Path", 1, "-dt", 0.01, "-values", *ground.tolist())
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    analyse_by(ops, "Transient", NEWMARK, algorithm)
    return histories(ops, range(1, len(masses) + 1), step)


def displacements(layout: RowLayout, ground: np.ndarray = GROUND) -> np.ndarray:
    """Of the masses at the samples, by this package; braces of dampers stand behind them."""
    states = free_row(layout, ground, states=True).states
    return states[:: (len(states) - 1) // (TIME.size - 1), 0, : layout.masses.size]


def errors(
    ops: Any, known: np.ndarray, masses: list[float], joins: Any, algorithm: str = "Newton", ground: np.ndarray = GROUND
) -> list[float]:
    """The largest difference over the peak, with steps of 2 ms and of a quarter of that."""
    found = (transient(ops, masses, joins, step, algorithm, ground) for step in (2e-3, 5e-4))
    return [float(np.abs(displaced - known).max() / np.abs(known).max()) for displaced in found]


@pytest.mark.parametrize("name", STOREYS)
def test_a_storey(ops, name: str):
    """Newmark's error falls with the square of the step; by the corners of the law somewhat less."""
    law, hardening, material = STOREYS[name]
    chain = chain_of(building(law, 1), [("inelastic_storeys", [("hardening", hardening)])])
    ground = GROWING if name in LOSING else GROUND
    known = displacements(lay_out([chain], [], 0.01), ground)
    assert np.abs(known).max() > 1.9 * YIELD
    coarse, fine = errors(ops, known, [MASS], [(0, 1, material, DASHPOT)], ground=ground)
    assert coarse < 2e-2 and fine < 0.25 * coarse, (coarse, fine)


def test_an_isolator(ops):
    """A slab with a floor on it, on bilinear isolators: Steel01 below, a spring above."""
    isolators = Isolators(6e4, 1.0, strength=6e4, stiffness=8e5, yield_displacement=0.002, damping=1e4)
    one = Storeys("A", (4e4,), (STIFFNESS,), (3.0,), damping=0.0).isolated(isolators)
    known = displacements(lay_out([chain_of(one)], [], 0.01))
    law = isolators.law(1e5)
    joins = [(0, 1, ("Steel01", law.limit, law.stiff, law.hardening), 1e4), (1, 2, ("Elastic", STIFFNESS), 0.0)]
    coarse, fine = errors(ops, known, [6e4, 4e4], joins)
    assert np.abs(known).max() > 0.01 and coarse < 3e-2 and fine < 0.25 * coarse, (coarse, fine)


def on_a_pendulum(ops: Any, isolators: Isolators, masses: tuple[float, float], step: float, size: float) -> np.ndarray:
    """Displacements of slab and floor at the samples: singleFPBearing under their weight, a spring above."""
    weight, small = sum(masses) * STANDARD_GRAVITY, isolators.yield_displacement
    friction, radius = isolators.friction, isolators.radius
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    for node, level in enumerate((0.0, 0.0, 3.0)):
        ops.node(node, 0.0, level)
        ops.fix(node, int(node == 0), int(node != 1), 1)
    for node, mass in enumerate(masses, 1):
        ops.mass(node, mass, mass, 0.0)
    ops.frictionModel("Coulomb", 1, friction)
    for tag, stiffness in enumerate((1e10, 1e10, STIFFNESS), 1):
        ops.uniaxialMaterial("Elastic", tag, stiffness)
    stiff = friction * weight / small + weight / radius
    upright, iterations = ("-orient", 0, 1, 0, -1, 0, 0), ("-iter", 200, 1e-11)
    ops.element("singleFPBearing", 1, 0, 1, 1, radius, stiff, "-P", 1, "-Mz", 2, *upright, *iterations)
    ops.element("twoNodeLink", 2, 1, 2, "-mat", 3, "-dir", 2)
    ops.timeSeries("Linear", 1)
    ops.pattern("Plain", 1, 1)
    ops.load(1, 0.0, -weight, 0.0)
    ops.timeSeries("Path", 2, "-dt", 0.01, "-values", *(size * GROUND).tolist())
    analyse_by(ops, "Static", ("LoadControl", 1.0))
    assert ops.analyze(1) == 0
    ops.loadConst("-time", 0.0)
    ops.wipeAnalysis()
    ops.pattern("UniformExcitation", 2, 1, "-accel", 2)
    analyse_by(ops, "Transient", NEWMARK)
    return histories(ops, (1, 2), step)


def test_a_friction_pendulum(ops):
    """A slab with a floor on it that slides: the law of OpenSees' element but for (u / R)² / 2, here 3e-6."""
    size, masses = 0.02, (6e4, 4e4)  # so small is the motion, and friction with it
    isolators = Isolators(masses[0], 1.0, friction=0.05 * size, radius=2.0, yield_displacement=0.001 * size)
    one = Storeys("A", (masses[1],), (STIFFNESS,), (3.0,), damping=0.0).isolated(isolators)
    known = displacements(lay_out([chain_of(one)], [], 0.01), size * GROUND)
    peak = np.abs(known).max()
    coarse, fine = (np.abs(on_a_pendulum(ops, isolators, masses, step, size) - known).max() for step in (2e-3, 5e-4))
    assert peak > 100 * isolators.yield_displacement and coarse < 1e-2 * peak and fine < 0.25 * coarse, (coarse, fine)


LINKS: dict[str, tuple[Link, tuple[Any, ...]]] = {
    "friction": (Link(0, 1.0, 1.0, 4e7, 0.0, strength=8e4), ("ElasticPP", 4e7, 8e4 / 4e7)),
    "hook": (Link(0, 1.0, 1.0, 3e7, 0.0, slack=0.004), ("ElasticPPGap", 3e7, 1e12, 0.004)),
}


def two_masses(link: Link, material: tuple[Any, ...]) -> tuple[np.ndarray, list[Any]]:
    """Displacements of two masses that a link joins, and what joins them in OpenSees."""
    periods = 0.4, 0.23
    chains = [chain_of(Building(str(period), MASS, period, 0.05)) for period in periods]
    model = RowModel(chains, [], links=[link])
    known = displacements(model.row(0.01))
    springs = [float(chain.spring[0]) for chain in chains]
    joins = [
        (0, place + 1, ("Elastic", spring), float(chains[place].damping[0, 0])) for place, spring in enumerate(springs)
    ]
    return known, [*joins, (1, 2, material, 0.0)]


@pytest.mark.parametrize("name", LINKS)
def test_a_link(ops, name: str):
    """Newmark's error falls with its step."""
    known, joins = two_masses(*LINKS[name])
    coarse, fine = errors(ops, known, [MASS, MASS], joins)
    assert coarse < 3e-2 and fine < 0.25 * coarse, (coarse, fine)


@pytest.mark.parametrize(
    ("exponent", "brace"),
    sweep([(0.3, inf), (0.5, inf), (1.0, inf), (0.3, 1e7), (1.0, 1e7), (1.7, 1e7)], (1.0, inf), (0.3, 1e7), (1.0, 1e7)),
)
def test_a_damper(ops, exponent: float, brace: float):
    """Chords, and the linear range below 1 mm/s that OpenSees has not, leave 1e-3 at most; of α = 1 nothing."""
    link = Link(0, 1.0, 1.0, 0.0, 2e5, exponent=exponent, brace=brace)
    known, joins = two_masses(link, link_dashpot(link))
    coarse, fine = errors(ops, known, [MASS, MASS], joins, "KrylovNewton")
    linear = two_masses(link._replace(exponent=0.0, brace=inf), ())[0]
    assert np.abs(known - linear).max() > 0.05 * np.abs(known).max() or exponent == 1.0
    assert coarse < 2e-3 and (fine < 1e-3 if exponent != 1.0 else fine < 0.1 * coarse), (coarse, fine)
