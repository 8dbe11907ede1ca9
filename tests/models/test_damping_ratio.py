"""The damping ratio ξ as input: e comes back to the ξ of the law's published relation."""

from __future__ import annotations

import subprocess
import sys

import pytest
from hypothesis import given
from hypothesis import strategies as st
from scenes import scene_text, single

from pounding_risk.ensemble.plan.scene_text import scene_words
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.models.contact.laws import RESTITUTION_OF_RATIO
from pounding_risk.models.contact.relation import restitution_of_ratio
from pounding_risk.results.labels import attributes
from pounding_risk.scene.reader import parse_scene


def scene(restitution):
    return parse_scene(scene_text(single("A", "40 t", "0.5 s"), single("B", "60 t", "0.3 s"), restitution=restitution))


@pytest.mark.parametrize("name", RESTITUTION_OF_RATIO)
@given(ratio=st.floats(0.0, 0.95))
def test_the_law_damps_with_the_ratio_that_was_given(name, ratio):
    """With unit stiffness and mass a published law's damping is 2 ξ, computed by the law itself from e."""
    law = CONTACT_MODELS[name](1.0)
    # Both directions are a handful of operations: 1e-12 leaves room for e near 1, where ξ is a difference from 1.
    assert law.begin(restitution_of_ratio(ratio, name), 1.0, 1.0) / 2.0 == pytest.approx(ratio, rel=1e-12, abs=1e-15)


def test_a_scene_takes_a_ratio_and_states_e():
    study = scene("xi 0.35 of jankowski")
    assert study.restitution.c0 == restitution_of_ratio(0.35, "jankowski")
    said = f"{study.restitution.c0:.6g}, from ξ = 0.35 of jankowski"
    assert ("restitution", said) in scene_words(study, 1)
    assert attributes(study, (), ((study.law(),),), "pair")["restitution"] == said


def test_a_ratio_is_written_back_as_it_was_given():
    study = scene(" ξ = 0.35 of  jankowski")
    assert study == scene("xi 0.35 of jankowski") != scene(study.restitution.c0)
    assert parse_scene(study.to_toml()) == study
    assert 'restitution = "xi 0.35 of jankowski"' in study.to_toml()


@pytest.mark.parametrize(
    ("written", "sentence"),
    [
        ("xi 0.35", "does not say the damping ratio of which law"),
        ("xi 0.35 of hertz", "hertz has no damping ratio"),
        ("xi 1.2 of kelvin_voigt", "out of range"),
        ("xi -0.1 of jankowski", "out of range"),
        ("xi a of jankowski", "not a number"),
        ({"value": "xi 0.35 of jankowski", "relation": "exact"}, "that of the published relation"),
    ],
)
def test_what_is_no_ratio_is_refused(written, sentence):
    with pytest.raises(SceneError, match=sentence):
        scene(written)


def test_a_collision_takes_a_ratio():
    line = [sys.executable, "-m", "pounding_risk", "impact", "--restitution", "xi 0.35 of jankowski"]
    run = subprocess.run(line, capture_output=True, text=True, check=True)
    assert f"{restitution_of_ratio(0.35, 'jankowski'):.4f}" in run.stdout
    with pytest.raises(PoundingError, match="leaves no rebound"):
        restitution_of_ratio(1.0 - 1e-16, "kelvin_voigt")
