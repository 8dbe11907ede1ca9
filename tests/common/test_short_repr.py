"""What a prompt and a notebook show of a result: a few lines with its facts, whatever its size."""

from __future__ import annotations

import xml.etree.ElementTree as ElementTree

import pytest

import pounding_risk as pr
from pounding_risk.models.contact.laws import Jankowski

SCENE = {
    "scene": {"name": "A <pair> & more"},
    "building": [
        {"name": "A", "mass": "40 t", "period": "0.5 s"},
        {"name": "B", "mass": "60 t", "period": "0.3 s"},
    ],
    "interface": [{"gap": "10 mm", "contact_model": "jankowski", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}],
    "records": {"names": ["RSN6-180"], "window": ["0 s", "3 s"]},
    "grid": {"gap": {"start": "0 mm", "stop": "40 mm", "num": 5}},
}


@pytest.fixture(scope="module")
def results() -> dict[str, tuple[object, str]]:
    """A result of each kind, and a fact that must stand in it."""
    scene = pr.read_scene(SCENE)
    assessment = pr.assess(pr.scan(scene))
    return {
        "scene": (scene, "5 from 0 mm to 40 mm"),
        "plan": (pr.validate(scene), "A <pair> & more"),
        "motion": (pr.read_motion("RSN6-180"), "5372 every 0.01 s, 53.71 s"),
        "impact": (pr.impact(Jankowski(2.75e9), 0.5, 570.0, restitution=0.65), "jankowski"),
        "assessment": (assessment, assessment.interfaces[0].verdict.sentence),
        "interface": (assessment.interfaces[0], "gap of 84 % of the motions"),
    }


@pytest.mark.parametrize("kind", ["scene", "plan", "motion", "impact", "assessment", "interface"])
def test_a_result_shows_a_few_facts(results, kind):
    result, fact = results[kind]
    lines = repr(result).split("\n")
    assert len(lines) <= 30 and lines[0] == f"<{type(result).__name__}>"
    assert fact in repr(result)
    table = ElementTree.fromstring(result._repr_html_())  # well-formed, so that names with < and & stay text
    assert fact in "".join(table.itertext())
