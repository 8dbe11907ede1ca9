"""What scenes cannot say: each word of it gets the substitute, and the page of the limits has scenes that run."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.scene.not_modelled import BY_WORD, PAGE, SENTENCES
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.sections import KEYS

ROOT = Path(__file__).resolve().parents[2]
LIMITS = (ROOT / PAGE).read_text("utf-8")
PAIR = scene_text(single("A", "44 t", "0.2 s"), single("B", "80 t", "0.1 s"), gap="2 mm")


def blocks(language: str) -> list[str]:
    """The fenced blocks of a language on the page."""
    return re.findall(rf"^```{language}\n(.*?)^```", LIMITS, re.M | re.S)


def test_no_word_is_a_key_of_a_scene_and_each_stands_once():
    assert not set(BY_WORD) & {key for keys in KEYS.values() for key in keys}
    assert len(BY_WORD) == sum(map(len, SENTENCES))


@pytest.mark.parametrize("word", ["link_force", "time_history", "mass_matrix", "mode_shapes", "Torsion", "isolators"])
@pytest.mark.parametrize("where", ["building.A", "interface", "effects"])
def test_a_key_outside_the_model_gets_its_substitute_and_no_false_friend(where, word):
    told = refusal(parse_scene, PAIR, overrides=[f"{where}.{word}=1.0"])
    assert f"{where}.{word}: unknown key; {BY_WORD[word.lower()]} ({PAGE})" in told
    assert "did you mean" not in told


def test_sections_and_words_of_python_get_it_too(says):
    says(refusal(parse_scene, f"{PAIR}\n[dampers]\ncount = 2\n"))
    says(refusal(pr.SingleMass, "A", "44 t", "0.2 s", link_stiffness=1.0))


def test_the_chain_of_a_model_has_its_first_period():
    """Oracle: the eigenvalues of the matrix itself. Both are of doubles; 1e-9 is far above their rounding."""
    names: dict[str, Any] = {}
    exec(compile(*blocks("python"), PAGE, "exec"), names)
    wall = pr.RigidWall("wall")
    contact = pr.Interface("20 mm", "jankowski", "1e11 N/m^1.5", restitution=0.65)
    scene = pr.Scene([wall, names["hall"]], [contact], pr.Records(["RSN6-180"]))
    chain, own = pr.modes(scene)[1].periods, 2.0 * np.pi / np.sqrt(names["squares"])
    assert chain[0] == pytest.approx(own[0], rel=1e-9)
    assert f"T1 is {own[0]:.3f} s" in LIMITS
    assert f"is {chain[1]:.3f} s" in LIMITS and f"is {own[1]:.3f} s" in LIMITS
