"""Each extension against its formula. Run with `python -m pytest` where the package is installed."""

import numpy as np
import pytest

import pounding_risk as pr
from pounding_risk.assessment.separations.rules import RULES, Case, Site
from pounding_risk.models.contact import laws as contact
from pounding_risk.models.effects import with_effects


def test_the_law_conserves_energy_at_e_1():
    law = contact.LAWS["hunt_crossley"]
    assert pr.impact(law(2.75e9), speed=0.5, mass=570.0, restitution=1.0).restitution == pytest.approx(1.0)
    assert law(2.75e9).force(0.0, 0.01, 0.3, True) == pytest.approx(2.75e9 * 0.01**1.5)


def test_the_effect_lowers_the_yield_force():
    law = with_effects(contact.ViscousElastoplastic(2.75e9), [("weathered", {"share": 0.8})])
    assert round(pr.impact(law, speed=0.5, mass=570.0, restitution=0.65, yield_force=60e3).peak_force) == 48_000


def test_the_motion_is_half_a_sine_and_the_step_multiplies():
    shock = pr.generate_motion("half_sine", pga="2 g", length="0.1 s")
    times = shock.dt * np.arange(len(shock.acceleration))
    inside = times <= 0.1
    expected = 2.0 * 9.80665 * np.sin(np.pi * times[inside] / 0.1)
    assert np.asarray(shock.acceleration)[inside] == pytest.approx(expected, abs=1e-9)
    plain = pr.read_motion("RSN6-180", processing="none")
    twice = pr.read_motion("RSN6-180", processing=[{"step": "gain", "factor": 2.0}])
    assert np.array_equal(np.asarray(twice.acceleration), 2.0 * np.asarray(plain.acceleration))


def test_the_rule_takes_the_lower_building():
    case = Case((0.01, 0.02), (0.9, 1.0), (0.05, 0.05), Site(heights=(9.0, 12.0)))
    assert RULES["height_ratio"].function(case) == pytest.approx(0.18)
