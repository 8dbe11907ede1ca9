"""Chains: what a building is to the solver of rows, and the effects that act on buildings."""

from dataclasses import replace
from math import pi, sqrt

import numpy as np
import pytest
import scipy.linalg
from sentences import refusal as refusal_of

from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.models.contact.laws import Jankowski, Linear
from pounding_risk.models.effects import acts_on_buildings, acts_on_law, refusal, wave_of, with_effects
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys, stiffness_matrix
from pounding_risk.results.labels import sources_of
from pounding_risk.scene.tables import Effect
from pounding_risk.studies import demo
from pounding_risk.studies.modes import building_modes

G = 9.80665
FRAME = Building("frame", 300e3, 0.5, 0.05)
TOWER = Storeys("tower", (3e5, 2.5e5, 2e5), (2e8, 1.5e8, 1e8), (4.0, 3.5, 3.0), strengths=(2e6, 1.5e6, 1e6))
INELASTIC, P_DELTA = ("inelastic_storeys", ()), ("p_delta", ())


def soil(velocity: float = 200.0, **more):
    return "soil_flexibility", tuple({"shear_wave_velocity": velocity, "radius": 8.0, **more}.items())


# ------------------------------------------------------------------------------------------------ without effects


def test_a_single_mass_is_a_chain_of_one():
    """k = m (2π/T)², c = 2 ζ sqrt(k m)."""
    chain = chain_of(FRAME)
    stiffness = 300e3 * (2.0 * pi / 0.5) ** 2
    assert (chain.mass.tolist(), chain.spring.tolist(), chain.shear.tolist()) == ([300e3], [stiffness], [stiffness])
    assert chain.damping[0, 0] == pytest.approx(2.0 * 0.05 * sqrt(stiffness * 300e3), rel=1e-14)
    assert chain.strength.tolist() == [np.inf] and chain.foundations == 0


def test_a_rigid_building_is_a_chain_of_none():
    for asked in ((), (INELASTIC, P_DELTA, soil())):
        chain = chain_of(Building.rigid("wall"), asked)
        assert chain.mass.shape == chain.spring.shape == (0,) and chain.damping.shape == (0, 0)


def test_storeys_are_their_chain():
    chain = chain_of(TOWER)
    mass, damping, stiffness = TOWER.matrices()
    assert np.array_equal(np.diag(chain.mass), mass) and np.array_equal(chain.damping, damping)
    assert np.array_equal(stiffness_matrix(chain.spring), stiffness) and np.array_equal(chain.spring, chain.shear)
    assert np.isinf(chain.strength).all()  # they yield where inelastic_storeys is asked for


def test_arrays_are_floats_in_order():
    """What the kernel takes: contiguous, and shared with nobody who might write."""
    for building in (FRAME, TOWER, Building.rigid("wall")):
        for asked in ((), (P_DELTA,) if building is TOWER else (soil(),)):
            for part in chain_of(building, asked)[:5]:
                assert part.dtype == np.float64 and part.flags.c_contiguous


# ------------------------------------------------------------------------------------------------ inelastic storeys


def test_storeys_that_yield():
    chain = chain_of(TOWER, (INELASTIC,))
    assert (chain.strength.tolist(), chain.hardening) == ([2e6, 1.5e6, 1e6], 0.03)
    assert chain_of(TOWER, (("inelastic_storeys", (("hardening", 0.1),)),)).hardening == 0.1
    assert np.array_equal(chain.spring, chain_of(TOWER).spring)


@pytest.mark.parametrize("building", [FRAME, replace(TOWER, strengths=())])
def test_what_has_no_strength_stays_elastic(building):
    assert np.isinf(chain_of(building, (INELASTIC,)).strength).all()


# ------------------------------------------------------------------------------------------------ P-delta


def test_geometric_stiffness_is_that_of_leaning_columns():
    """The second derivative of the weights' and springs' potential energy, columns of fixed length that lean.

    By central differences of the exact energy: good to about 1e-6 of the stiffness taken away.
    """
    above = np.cumsum(np.array(TOWER.masses)[::-1])[::-1] * G

    def sunk(moved: np.ndarray) -> float:
        drift = np.diff(moved, prepend=0.0)
        heights = np.array(TOWER.heights)
        # h − sqrt(h² − d²), without the cancellation.
        return float(-above @ (drift**2 / (heights + np.sqrt(heights**2 - drift**2))))

    step = 1e-3
    unit = step * np.eye(3)
    hessian = np.array(
        [[(sunk(a + b) - sunk(a - b) - sunk(b - a) + sunk(-a - b)) / (4.0 * step**2) for b in unit] for a in unit]
    )
    chain = chain_of(TOWER, (P_DELTA,))
    taken = stiffness_matrix(chain.spring - chain.shear)
    assert taken == pytest.approx(hessian, abs=1e-6 * np.abs(hessian).max())
    assert np.array_equal(chain.shear, chain_of(TOWER).shear) and np.array_equal(chain.damping, chain_of(TOWER).damping)


def test_buckling_limit_of_a_single_mass(says):
    """T grows as 1 / sqrt(1 − P / (k h)), and at P = k h there is nothing left."""
    tall = FRAME._replace(height=10.0)
    load = 300e3 * G / 10.0 / tall.stiffness
    assert building_modes(tall, (P_DELTA,)).periods[0] == pytest.approx(0.5 / sqrt(1.0 - load), rel=1e-12)
    critical = 2.0 * pi * sqrt(10.0 / G)  # s: an upright pendulum of this length stands by itself no longer
    assert chain_of(tall._replace(period=0.999 * critical), (P_DELTA,)).spring[0] > 0.0
    says(refusal_of(chain_of, tall._replace(period=1.001 * critical), (P_DELTA,)))


def test_the_storey_that_falls_or_has_no_height_is_named(says):
    soft = replace(TOWER, stiffnesses=(2e8, 1e5, 1e8))
    for building, asked in ((soft, (P_DELTA,)), (soft, (P_DELTA, soil())), (FRAME, (P_DELTA,))):
        says(refusal_of(chain_of, building, asked))


# ------------------------------------------------------------------------------------------------ soil


def test_soil_is_the_cone():
    """K = ρ V_s² A / z0 with the cone's z0 = π (2 − ν) r / 8; C = ρ V_s A."""
    chain = chain_of(FRAME, (soil(150.0, density=1900.0, poisson=0.4, foundation_mass=5e4),))
    area, apex = pi * 64.0, pi * 1.6 * 8.0 / 8.0
    assert chain.spring[0] == chain.shear[0] == pytest.approx(1900.0 * 150.0**2 * area / apex, rel=1e-14)
    assert chain.mass.tolist() == [5e4, 300e3] and chain.foundations == 1 and np.isinf(chain.strength[0])
    # Moving as one, floors and foundation feel the dashpot alone.
    assert chain.damping @ np.ones(2) == pytest.approx([1900.0 * 150.0 * area, 0.0], rel=1e-12, abs=1e-6)


def test_foundations_weigh_as_much_as_the_lowest_floor():
    assert chain_of(TOWER, (soil(),)).mass.tolist() == [3e5, 3e5, 2.5e5, 2e5]


def test_soil_comes_on_top_of_the_building_with_all_its_effects():
    chain = chain_of(TOWER, (soil(), P_DELTA, INELASTIC))  # in any order
    above = chain_of(TOWER, (P_DELTA, INELASTIC))
    assert np.array_equal(chain.spring[1:], above.spring) and np.array_equal(chain.strength[1:], above.strength)
    assert chain.damping[1:, 1:] == pytest.approx(above.damping, rel=1e-14)
    assert np.linalg.eigvalsh(chain.damping)[0] > -1e-6 and np.array_equal(chain.damping, chain.damping.T)


# ------------------------------------------------------------------------------------------------ modes


@pytest.mark.parametrize("asked", [(), (P_DELTA,), (soil(),), (P_DELTA, soil())])
def test_modes_under_effects_are_those_of_scipy(asked):
    chain, modes = chain_of(TOWER, asked), building_modes(TOWER, asked)
    squares, shapes = scipy.linalg.eigh(stiffness_matrix(chain.spring), np.diag(chain.mass))
    assert modes.periods == pytest.approx(2.0 * pi / np.sqrt(squares), rel=1e-10)
    known = shapes * np.sign(shapes[-1]) / np.abs(shapes).max(axis=0)
    assert modes.shapes == pytest.approx(known, rel=1e-8, abs=1e-9)
    gammas = (chain.mass @ modes.shapes) / (chain.mass @ modes.shapes**2)
    assert modes.participations == pytest.approx(gammas, rel=1e-9)
    assert modes.shares == pytest.approx(gammas * (chain.mass @ modes.shapes) / chain.mass.sum(), rel=1e-9)
    assert modes.shapes @ modes.participations == pytest.approx(np.ones(chain.mass.size), rel=1e-9)
    assert modes.shares.sum() == pytest.approx(1.0, rel=1e-9)
    known = np.diag(shapes.T @ chain.damping @ shapes) / (2.0 * np.sqrt(squares))
    assert modes.dampings == pytest.approx(known, rel=1e-8)
    assert modes.levels.tolist() == [0.0] * chain.foundations + [4.0, 7.5, 10.5]


def test_a_rigid_building_has_no_modes():
    modes = building_modes(Building.rigid("wall"), (soil(),))
    assert modes.periods.size == modes.levels.size == 0 and modes.shapes.shape == (0, 0)


# ------------------------------------------------------------------------------------------------ beside the others


def test_laws_and_grounds_pass_over_them():
    asked = (INELASTIC, P_DELTA, soil())
    assert with_effects(Linear(1e8), asked) == Linear(1e8) and wave_of(asked) is None
    assert [acts_on_buildings(name) for name in ("p_delta", "wave_passage", "permanent_set")] == [True, False, False]
    assert [acts_on_law(name) for name in ("p_delta", "wave_passage", "permanent_set")] == [False, False, True]
    assert refusal(Linear, "p_delta") == "" and refusal(Linear, "permanent_set")
    assert not any(refusal(kind, "wave_passage") for kind in CONTACT_MODELS.values())
    assert chain_of(FRAME, (("permanent_set", ()),)).spring == chain_of(FRAME).spring


def test_results_name_where_they_are_from():
    study = demo.scene("paper").updated(effects=(Effect("p_delta"), Effect("soil_flexibility", soil()[1])))
    told = sources_of(study, (Jankowski(1e9),))
    assert any("Wilson and Habibullah" in each for each in told) and any("Wolf (1994)" in each for each in told)
