"""What scenes cannot say: each word of it gets the substitute."""

from __future__ import annotations

import pytest
from scenes import scene_text, single
from sentences import refusal

import pounding_risk as pr
from pounding_risk.scene.not_modelled import BY_WORD, PAGE, SENTENCES
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.sections import KEYS

PAIR = scene_text(single("A", "44 t", "0.2 s"), single("B", "80 t", "0.1 s"), gap="2 mm")


def test_no_word_is_a_key_of_a_scene_and_each_stands_once():
    of_links = {"link_stiffness", "link_damping", "link_at"}  # of interfaces, which are looked for in buildings
    assert set(BY_WORD) & {key for keys in KEYS.values() for key in keys} == of_links
    assert len(BY_WORD) == sum(len(words.split()) for words in SENTENCES)


@pytest.mark.parametrize(
    "word",
    ["link_force", "time_history", "matrix", "mode_shapes", "Torsion", "isolators", "moat", "restrainer", "rubber"],
)
@pytest.mark.parametrize("where", ["building.A", "interface", "effects"])
def test_a_key_outside_the_model_gets_its_substitute_and_no_false_friend(where, word):
    told = refusal(parse_scene, PAIR, overrides=[f"{where}.{word}=1.0"])
    assert f"{where}.{word}: unknown key; {BY_WORD[word.lower()]} ({PAGE})" in told
    assert "did you mean" not in told


def test_sections_and_words_of_python_get_it_too(says):
    says(refusal(parse_scene, f"{PAIR}\n[dampers]\ncount = 2\n"))
    says(refusal(pr.SingleMass, "A", "44 t", "0.2 s", link_stiffness=1.0, dampers=1.0))
