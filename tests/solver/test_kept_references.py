"""The kept answers of the reference integrator are its own, and another question is not answered by one of them."""

import json

import numpy as np
import pytest
from kept_references import KEPT, kept, question, reference, source
from oracle_rows import Row
from oracle_stiff import StiffRow
from row_cases import CASES

NAME = "a yielding storey at a wall"


def asked(name: str = NAME, free: bool = False) -> list:
    """What a comparison with SciPy asks, of a row with its contacts or of its free flight."""
    case = CASES[name]
    return [case.chains, () if free else case.meetings, *case.shaking.samples(), 1e-12, Row.__name__]


def test_the_kept_answers_are_of_these_sources_and_rows():
    found = json.loads(KEPT.read_text(encoding="utf-8"))
    advice = "run python tests/kept_references.py"
    assert found["source"] == source(), f"the integrator has changed: {advice}"
    unkept = {name for name in CASES for free in (False, True) if question(*asked(name, free)) not in kept()}
    assert unkept == set(), f"these rows are integrated anew each time: {advice}"


def test_a_kept_answer_is_what_the_integrator_says():
    """One of them integrated anew; the same bits on the machine that made the file, 1e-8 on any."""
    chains, meetings, ground, dt, rtol, _ = asked()
    assert question(*asked()) in kept()
    one, other = reference(chains, meetings, ground, dt, rtol), Row(chains, meetings, rtol).go(ground, dt)
    assert one.points["impact_count"].sum() >= 3 and one.points.keys() == other.points.keys()
    for name, values in other.points.items():
        np.testing.assert_allclose(one.points[name], values, rtol=1e-8, atol=1e-12, err_msg=name)
    np.testing.assert_allclose(one.floors, other.floors, rtol=1e-8)
    np.testing.assert_allclose(one.rest, other.rest, rtol=1e-8, atol=1e-8 * other.floors[:, 1].max())
    assert len(one.state) == len(other.state)


@pytest.mark.parametrize("place", range(6))
def test_all_that_is_asked_counts(place: int):
    """A millionth of a mass, of a gap, of one sample, of the step, another tolerance, another integrator."""
    chains, meetings, ground, dt, _, _ = asked()
    heavier = chains[1]._replace(mass=chains[1].mass * (1.0 + 1e-6))
    pushed = ground.copy()
    pushed[len(ground) // 2] += 1e-6 * np.abs(ground).max()
    others = [
        (chains[0], heavier),
        (meetings[0]._replace(stiffness=meetings[0].stiffness * (1.0 + 1e-6)),),
        pushed,
        dt * (1.0 + 1e-6),
        1e-11,
        StiffRow.__name__,
    ]
    changed = asked()
    changed[place] = others[place]
    assert question(*changed) != question(*asked())
    assert question(*asked()) == question(*asked())
