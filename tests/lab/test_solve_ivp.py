"""SciPy restarted at every sample and event, for every law, against the other integrator of the tests."""

from __future__ import annotations

import ast
from math import inf, isnan, nan
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import oracle
import pytest

import pounding_risk.lab.baselines
from pounding_risk.lab.baselines.matrices import row_matrices
from pounding_risk.lab.baselines.solve_ivp import SOLVERS, Contacts, solve_general
from pounding_risk.models.contact.law import is_path_dependent
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building

DT = 0.01  # s
LEFT, RIGHT = Building("left", 5e4, 0.3, 0.05), Building("right", 9e4, 0.15, 0.05)
GAP, E, STRENGTH = 1e-3, 0.6, 1.5e5
FOLLOWED = [name for name, law in LAWS.items() if not is_path_dependent(law)]  # by δ and δ̇ alone
STIFFNESS = {law: 2.5e8 if law in oracle.LINEAR else 1.05e10 for law in oracle.LAWS}
ALIKE = ("peak_relative_displacement", "peak_closing", "peak_contact_force", "first_impact_time")


def ground(count: int = 150) -> np.ndarray:
    """A second and a half of noise under a half-sine [m/s²]."""
    return np.random.default_rng(7).normal(size=count) * np.sin(np.pi * np.arange(count) / (count - 1)) * 3.0


def solved(name: str, rtol: float, solver: str = "DOP853", gap: float = GAP) -> SimpleNamespace:
    strength = STRENGTH if LAWS[name].capped else inf
    there = Contacts(np.array([gap]), (LAWS[name](STIFFNESS[name]),), (constant(E),), np.array([strength]))
    row = row_matrices([chain_of(LEFT), chain_of(RIGHT)], [Point(0, 1.0, 1.0, FLOOR, nan)])
    found = solve_general(solver, row, there, (ground(), DT), rtol)._asdict()
    return SimpleNamespace(**{key: np.asarray(value).item() for key, value in found.items()})


def truth(name: str, gap: float = GAP) -> dict[str, float]:
    sides = oracle.Oscillator(LEFT.mass, LEFT.period), oracle.Oscillator(RIGHT.mass, RIGHT.period)
    strength = STRENGTH if LAWS[name].capped else inf
    return oracle.integrate(oracle.Scene(*sides, name, STIFFNESS[name], gap, E, strength), ground(), DT, rtol=1e-11)


@pytest.mark.slow
@pytest.mark.parametrize("name", FOLLOWED)
def test_every_law_agrees(name):
    """At rtol 1e-10; errors add up over a dozen contacts, and the force's crest is that of SciPy's interpolant."""
    found, right = solved(name, 1e-10), truth(name)
    assert right["impact_count"] >= 5 and found.impact_count == right["impact_count"]
    for output in ALIKE:
        assert getattr(found, output) == pytest.approx(right[output], rel=1e-7), output
    if LAWS[name].capped:
        assert right["yield_demand"] > 1.0
        assert (found.uncapped_force >= STRENGTH) == (right["yield_demand"] >= 1.0)
    else:
        assert found.uncapped_force == found.peak_contact_force
    assert found.steps >= found.impact_count


@pytest.mark.parametrize("solver", SOLVERS)
def test_tighter_tolerances_are_closer(solver):
    """From 1e-3 to 1e-7 the errors of both peaks fall at least a hundredfold, and the steps grow."""
    right = truth("jankowski")
    loose, tight = solved("jankowski", 1e-3, solver), solved("jankowski", 1e-7, solver)
    for name in ("peak_relative_displacement", "peak_contact_force"):
        errors = [abs(getattr(found, name) / right[name] - 1.0) for found in (loose, tight)]
        assert errors[1] < 1e-2 * errors[0] or errors[1] < 1e-9, name
        assert errors[1] < 1e-5, name
    assert tight.steps > loose.steps
    assert tight.impact_count == right["impact_count"]


def test_without_contact():
    """A gap that stays open, by its size or by being infinite: the free motion, and nothing of a contact."""
    right = truth("jankowski", gap=1e3)
    for gap in (1e3, inf):
        found = solved("jankowski", 1e-9, gap=gap)
        assert found.peak_relative_displacement == pytest.approx(right["peak_relative_displacement"], rel=1e-8)
        assert found.peak_closing == pytest.approx(right["peak_closing"], rel=1e-8)
        assert (found.impact_count, found.peak_contact_force, found.steps) == (0.0, 0.0, 0.0)
        assert isnan(found.first_impact_time)


# ------------------------------------------------------------------------------------------- where they may stand
PACKAGE = Path(pounding_risk.lab.baselines.__file__).parents[2]


def modules_of(file: Path) -> set[str]:
    """Every module that a file imports from, whole names."""
    found = set()
    for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom):
            found.add(node.module or "")
    return found


@pytest.mark.parametrize("file", sorted((PACKAGE / "lab" / "baselines").glob("*.py")), ids=lambda file: file.stem)
def test_rivals_share_nothing_with_the_solver_but_laws_and_buildings(file):
    """No kernel of the solver, nothing that reads or draws: a rival that borrowed its events would be none."""
    plain = {"__future__", "collections.abc", "math", "typing", "numpy", "numpy.typing", "scipy.integrate"}
    plain |= {"pounding_risk._jit.compile"}
    for module in modules_of(file) - plain:
        assert module.startswith(("pounding_risk.lab.baselines.", "pounding_risk.models.")), module


def test_the_solver_uses_no_rival():
    for folder in ("solver/pair", "solver/row", "models"):
        for file in (PACKAGE / folder).rglob("*.py"):
            assert not any("baselines" in module for module in modules_of(file)), file.name
