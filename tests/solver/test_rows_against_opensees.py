"""Rows in OpenSees come to the reference integrator's peaks as their steps become smaller; no clock is read here."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from kept_references import reference
from oracle_rows import Answer, Meeting
from sentences import refusal

from pounding_risk.errors import PoundingError

LAWS = {"Jankowski": "jankowski", "HertzDamp": "hertz_damp"}


pytestmark = pytest.mark.usefixtures("benchmarks")


@pytest.fixture
def ops():
    from opensees_pair import load

    try:
        return load()
    except PoundingError as reason:
        pytest.skip(str(reason))


def truth(scene: Any) -> Answer:
    """A scene of the benchmarks by the reference integrator."""
    law, e = LAWS[type(scene.law).__name__], scene.restitution.c0
    meetings = [
        Meeting(interface, left, right, scene.gap, law, scene.law.stiffness, e)
        for interface, left, right in scene.points
    ]
    return reference(scene.chains, meetings, scene.acceleration, scene.dt)


@pytest.mark.complete
@pytest.mark.parametrize("name", ["three_storey_pair", "row_of_four"])
def test_opensees_converges_to_the_reference(ops, name: str):
    """Steps of a tenth: touches fall inside them, so that errors fall by about ten and peaks between steps by more."""
    import row_scenes
    from opensees_row import errors_of, solve_opensees_row

    scene = getattr(row_scenes, name)()
    true = truth(scene)
    assert true.points["impact_count"].min() >= 3
    known = true.floors[:, 0], true.points["peak_contact_force"]
    coarse, fine = (errors_of(solve_opensees_row(ops, scene, h), known) for h in (1e-3, 1e-4))
    assert np.all(np.array(coarse) < 1e-2)
    assert np.all(np.array(fine) < 6e-4)
    assert np.all(np.array(fine) < 0.3 * np.array(coarse)), (coarse, fine)


def test_dashpots_make_up_the_damping_matrix(says):
    """Storeys' dashpots and those to the ground, put together again, are C; modal damping has no such set."""
    from row_scenes import even

    from pounding_risk.lab.accuracy_opensees import dashpots

    for rule in ("stiffness", "rayleigh"):
        chain = even("a", 4, 1e5, 1e8, rule)
        storeys, to_ground = dashpots(chain)
        drift = np.eye(4) - np.eye(4, k=-1)
        # The first storey's dashpot ends at the ground, as those of the floors do: it is told among these.
        assert storeys[0] == 0.0
        np.testing.assert_allclose(
            drift.T @ np.diag(storeys) @ drift + np.diag(to_ground), chain.damping, rtol=1e-12, atol=1e-6
        )
    says(refusal(dashpots, even("a", 4, 1e5, 1e8, "modal")))
