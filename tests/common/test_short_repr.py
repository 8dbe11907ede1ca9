"""What a prompt and a notebook show of a result: a few lines with its facts, whatever its size."""

import xml.etree.ElementTree as ElementTree

import pytest
from scenes import scene_text

import pounding_risk as pr
from pounding_risk.models.contact.laws import Jankowski

SCENE = scene_text(
    name="A <pair> & more",
    records={"window": ["0 s", "3 s"]},
    grid={"gap": {"start": "0 mm", "stop": "40 mm", "num": 5}},
)
KINDS = ["scene", "plan", "motion", "impact", "assessment", "interface"]
KINDS += ["dataset", "summary", "rerun", "status", "selection"]
HEADINGS = {"dataset": "results of scan"}  # of others it is the name of the class


@pytest.fixture(scope="module")
def results(tmp_path_factory) -> dict[str, tuple[object, str]]:
    """A result of each kind, and a fact that must stand in it."""
    scene = pr.read_scene(SCENE)
    path = tmp_path_factory.mktemp("short_repr") / "results.nc"
    dataset = pr.scan(scene, path)
    assessment = pr.assess(dataset)
    motions = [pr.read_motion("RSN6-180"), pr.read_motion("RSN1690-090")]
    target = pr.motions.read_target("asce7:sds=1.0,sd1=0.6,tl=8")
    return {
        "dataset": (dataset.pounding, "0 mm, 10 mm, 20 mm, 30 mm, 40 mm"),
        "summary": (pr.summary(path), "peak_relative_displacement"),
        "rerun": (pr.rerun(path), "yes"),
        "status": (pr.status(path), "complete"),
        "selection": (pr.motions.select(motions, target, count=1), "1 of 2 candidates"),
        "scene": (scene, "5 from 0 mm to 40 mm"),
        "plan": (pr.validate(scene), "A <pair> & more"),
        "motion": (pr.read_motion("RSN6-180"), "5372 every 0.01 s, 53.71 s"),
        "impact": (pr.impact(Jankowski(2.75e9), 0.5, 570.0, restitution=0.65), "jankowski"),
        "assessment": (assessment, assessment.interfaces[0].verdict.sentence),
        "interface": (assessment.interfaces[0], "gap of 84 % of the motions"),
    }


@pytest.mark.parametrize("kind", KINDS)
def test_a_result_shows_a_few_facts(results, kind):
    result, fact = results[kind]
    lines = repr(result).split("\n")
    assert len(lines) <= 30 and lines[0] == f"<{HEADINGS.get(kind, type(result).__name__)}>"
    assert fact in repr(result)
    table = ElementTree.fromstring(result._repr_html_())  # well-formed, so that names with < and & stay text
    assert fact in "".join(table.itertext())
