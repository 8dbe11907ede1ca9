"""Results whose fragilities, those of damage states too, are determined."""

from __future__ import annotations

import pytest
from scenes import BOTH, damage_text, scene_text, single

import pounding_risk as pr

DAMAGE = {
    "moderate": {"building": "a frame", "displacement": "103 mm"},
    "slight, cracks": {"building": "a frame", "displacement": "50 mm"},
    "blow": {"contact_force": "3 MN"},
}


@pytest.fixture(scope="session")
def results():
    """A pair whose contact under four motions, at three amplitudes, is not the same."""
    text = scene_text(
        single("a frame", "500 t", "1.0 s", damping=0.05),
        single("wall", "800 t", "0.5 s", damping=0.05),
        records={
            "names": ["RSN6-180", "RSN753-000", "CCC-HN1", "NAPA-HNE"],
            "polarity": BOTH,
            "window": ["0 s", "30 s"],
        },
        grid={"pga": ["0.1 g", "0.2 g", "0.3 g", "0.6 g"], "yield_force": ["2 MN", "4 MN"]},
        law="viscous_elastoplastic",
        gap="60 mm",
        yield_force="4 MN",
    )
    return pr.scan(pr.read_scene(text + damage_text(DAMAGE)))


@pytest.fixture(scope="session")
def damaged(results):
    """The curves of the damage states of the scene."""
    return pr.damage(results, intensity="pga")
