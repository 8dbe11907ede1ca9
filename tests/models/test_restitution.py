"""Restitution as a function of approach speed: the published cubic, held beyond its range; constants."""

from math import inf, nan

import numpy as np
import pytest
from sentences import refusal

from pounding_risk.models.restitution import CONCRETE, NAMED, Restitution, constant

# e = −0.0070 v³ + 0.0696 v² − 0.2529 v + 0.7929, worked by hand.
BY_HAND = {0.0: 0.7929, 0.5: 0.682975, 1.0: 0.6026, 2.0: 0.5095, 2.5: 0.486275, 4.0: 0.4469, 5.0: 0.3934}


@pytest.mark.parametrize(("speed", "e"), BY_HAND.items())
def test_concrete_is_the_published_cubic(speed, e):
    assert CONCRETE.at(speed) == pytest.approx(e, abs=1e-12)


@pytest.mark.parametrize("speed", [5.0 + 1e-12, 6.0, 7.1, 20.0, 1e9, inf])
def test_concrete_is_held_beyond_its_range(speed):
    """The cubic itself is zero at 7.10 m/s and negative beyond: no e at all."""
    assert CONCRETE.at(speed) == CONCRETE.at(5.0)
    assert CONCRETE.beyond(speed)
    assert np.polyval([-0.0070, 0.0696, -0.2529, 0.7929], 7.2) < 0.0


def test_concrete_within_its_range_falls_and_stays_an_e():
    speeds = np.linspace(0.0, 5.0, 501)
    values = [CONCRETE.at(v) for v in speeds]
    assert all(0.0 < e <= 1.0 for e in values)
    assert np.all(np.diff(values) < 0.0)
    assert not any(CONCRETE.beyond(v) for v in speeds)


@pytest.mark.parametrize("e", [1e-6, 0.05, 0.65, 1.0, 1])
def test_a_constant_is_the_same_at_every_speed(e):
    rule = constant(e)
    assert {rule.at(v) for v in (0.0, 1e-9, 0.5, 5.0, 1e6)} == {float(e)}
    assert not rule.beyond(1e300)
    assert all(isinstance(value, float) for value in rule)


@pytest.mark.parametrize("e", [0.0, -0.1, 1.0000001, 75.0, nan, inf, -inf])
def test_no_constant_outside_its_bounds(e, says):
    says(refusal(constant, e, kind=ValueError))


def test_named_relations():
    assert NAMED["concrete"] is CONCRETE
    assert all(isinstance(rule, Restitution) for rule in NAMED.values())
