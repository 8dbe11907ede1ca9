"""Settings that `accuracy` leaves out since their method is far behind, held to the numbers of those that ran."""

from __future__ import annotations

import json
import re

import numpy as np
import pytest
from scenes import scene_text

from pounding_risk import accuracy
from pounding_risk.lab.accuracy import FAR, TIGHTEST
from pounding_risk.scene.reader import parse_scene

SCENE = scene_text(records={"window": ["0 s", "6 s"], "pga": "0.5 g"}, grid={"gap": ["10 mm", "30 mm"]})


@pytest.fixture(scope="module")
def answer():
    said: list[str] = []
    dataset = accuracy(parse_scene(SCENE), cases=2, say=said.append)
    return dataset, said


@pytest.mark.complete
def test_a_method_is_refined_until_it_is_far_behind(answer):
    dataset, _ = answer
    worst = dataset["error"].max("case")
    time = dataset["time"].sel(output="peak_relative_displacement")
    best = TIGHTEST.words
    sentences = [words for words in json.loads(dataset.attrs["left_out"]) if ": not run: " in words]
    # Steps of 10 µs take some sixty times as long as the tightest tolerance, whatever the machine.
    assert {words.partition(", ")[0] for words in sentences} >= {"Newmark average acceleration", "Runge-Kutta 4"}
    for words in sentences:
        finer, coarser, times = re.fullmatch(
            r"(.*): not run: (.*) takes (\d+) times as long as .*, with no smaller error in any output", words
        ).groups()
        assert finer not in dataset["setting"] and coarser in dataset["setting"]
        assert int(times) >= FAR
        assert time.sel(setting=coarser) > time.sel(setting=best)
        errors = worst.sel(setting=[coarser, best]).values
        assert not (errors[0] < errors[1]).any()


@pytest.mark.complete
def test_what_confirms_the_reference_is_run_to_its_tightest_tolerance(answer):
    dataset, _ = answer
    assert "SciPy DOP853, rtol 1e-12" in dataset["setting"]
    assert np.isfinite(dataset["error"].sel(setting="SciPy DOP853, rtol 1e-12", output="peak_contact_force")).any()


@pytest.mark.complete
def test_the_time_is_stated_before_the_other_methods_run(answer):
    _, said = answer
    assert len(said) == 1
    assert re.match(r"2 cases: [\d.e-]+ s for 10 tolerances of the event-driven solver; at most 20 s for", said[0])
