"""Rows in OpenSees come to the reference integrator's peaks as their steps become smaller; no clock is read here."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from kept_references import reference
from oracle_rows import Answer, Meeting
from scenes import scene_text

from pounding_risk.scene.reader import parse_scene

LAWS = {"Jankowski": "jankowski", "HertzDamp": "hertz_damp"}


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


def test_dashpots_make_up_the_damping_matrix():
    """Dashpots between floors and to the ground, put together again, are C."""
    from row_scenes import even

    from pounding_risk.lab.accuracy_opensees import joins

    for rule in ("stiffness", "rayleigh", "modal"):
        chain = even("a", 4, 1e5, 1e8, rule)
        matrix = np.zeros((5, 5))
        for (one, other), dashpot in joins(chain.damping).items():
            ends = np.eye(5)[one] - np.eye(5)[other]
            matrix += dashpot * np.outer(ends, ends)
        np.testing.assert_allclose(matrix[1:, 1:], chain.damping, rtol=1e-12, atol=1e-6)
        assert len(joins(chain.damping)) == {"stiffness": 4, "rayleigh": 7, "modal": 10}[rule]


BENT = [[320, -180, 30], [-180, 230, -90], [30, -90, 65]]  # MN/m
JOINED = {
    "a linked row": {"storey_stiffnesses": ["180 MN/m", "150 MN/m", "90 MN/m"]},
    "a stiffness matrix": {"stiffness_matrix": {"values": BENT, "unit": "MN/m"}},
    "a part of it that yields": {
        "stiffness_matrix": {"values": BENT, "unit": "MN/m"},
        "storey_stiffnesses": ["60 MN/m", "40 MN/m", "15 MN/m"],
        "storey_strengths": ["400 kN", "300 kN", "100 kN"],
    },
}


@pytest.mark.parametrize("name", JOINED)
def test_opensees_converges_to_links_and_matrices(ops, name: str):
    """Without contact Newmark's error is a quarter where the step is halved, beside which a peak is missed by a part.

    Contacts begin inside steps: their force is within 1 % at a millisecond.
    """
    from pounding_risk.lab.accuracy_bench import bench_of
    from pounding_risk.lab.accuracy_findings import FORCE, GAP
    from pounding_risk.lab.accuracy_opensees import opensees_outcome

    hall = {"name": "hall", "floor_masses": ["200 t", "200 t", "150 t"], "storey_heights": "4 m", **JOINED[name]}
    tower = {"name": "tower", "floor_masses": "210 t", "storeys": 4, "storey_stiffnesses": "300 MN/m"}
    link = {"link_stiffness": "20 MN/m", "link_damping": "1 MN s/m"} if name == "a linked row" else {}
    study = parse_scene(
        scene_text(
            hall,
            tower | {"storey_heights": "4 m"},
            gap="4 mm",
            records={"names": ["RSN6-180"], "window": ["1 s", "5 s"], "pga": "0.5 g"},
            contact=[{"left": "storey 3", "right": "storey 3"}],
            effects={"inelastic_storeys": {}} if "storey_strengths" in hall else None,
            **link,
        )
    )
    bench = bench_of(study, 1)
    known = bench.event(1e-12).values[0, 0]
    coarse, fine = (opensees_outcome(bench, step).values[0, 0] for step in (2e-3, 1e-3))
    gaps = [abs(found[GAP] / known[GAP] - 1.0) for found in (coarse, fine)]
    assert gaps[0] < 1e-3 and gaps[1] < 0.4 * gaps[0]
    assert known[FORCE] > 1e5 and fine[FORCE] == pytest.approx(known[FORCE], rel=1e-2)
