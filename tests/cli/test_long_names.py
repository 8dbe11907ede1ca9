"""Every variable says what it is without its neighbours: no pronoun stands for the variable above it."""

import re

import pytest
from scenes import scene_text, single

from pounding_risk.ensemble.scan import scan
from pounding_risk.scene.reader import parse_scene
from pounding_risk.solver.pair.outputs import BUILDING, RUN
from pounding_risk.solver.row.outputs import OF_POINTS, OVER_POINTS
from pounding_risk.studies.compare import compare
from pounding_risk.studies.simulate import simulate

PRONOUNS = re.compile(r"\b(it|its|itself|they|them|their|there|here|ditto|does|the same)\b")
PAIR = scene_text(single("A", "40 t", "0.5 s"), single("B", "60 t", "0.3 s"), records={"window": ["0 s", "3 s"]})
ROW = PAIR.replace(
    'mass = "40 t"\nperiod = "0.5 s"',
    'storeys = 2\nfloor_masses = "20 t"\nstorey_stiffnesses = "15 MN/m"\nstorey_heights = "3 m"',
)


def long_names(dataset):
    return {str(name): values.attrs["long_name"] for name, values in dataset.variables.items() if values.attrs}


def two_laws(study):
    return compare(study, laws=["jankowski", "linear"])


@pytest.mark.parametrize("make", [scan, simulate, two_laws])
def test_a_pair_says_what_each_variable_is(make):
    leaning = {name: words for name, words in long_names(make(parse_scene(PAIR))).items() if PRONOUNS.search(words)}
    assert leaning == {}


@pytest.mark.parametrize("make", [scan, simulate])
def test_a_row_says_what_each_variable_is(make):
    found = long_names(make(parse_scene(ROW)))
    assert {name: words for name, words in found.items() if PRONOUNS.search(words)} == {}
    assert "sum over the contact points" in found["contact_time"]
    assert "without the P d / h of p_delta" in found["peak_storey_shear"]


def test_words_of_outputs_differ():
    words = [output.words for output in RUN.values()] + [words for _, words, _ in BUILDING.values()]
    assert len(set(words)) == len(words)


def test_every_output_of_a_point_says_how_an_interface_gathers_it():
    assert set(OF_POINTS) - set(OVER_POINTS) == {"peak_closing"}  # u_left - u_right at the widest of the points
