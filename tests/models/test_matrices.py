"""Buildings by matrices and by modes: put together, condensed and refused, against SciPy and closed forms."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from math import pi

import numpy as np
import pytest
import scipy.linalg
from sentences import refusal

import pounding_risk as pr
from pounding_risk.models.structures.matrices import ModeTable, assembled, condensed, condensed_masses, symmetric
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.storeys import Storeys

MASSES = np.array([200e3, 200e3, 150e3])
# A frame whose columns bend as a whole: no chain of storey springs has its entries beside the tridiagonal band.
BENT = np.array([[320e6, -180e6, 30e6], [-180e6, 230e6, -90e6], [30e6, -90e6, 65e6]])
RECORDS = pr.Records(["RSN6-180"])
SOIL = ("soil_flexibility", (("shear_wave_velocity", 150.0), ("radius", 6.0)))
CHAIN = Storeys("A", tuple(MASSES), (180e6, 150e6, 90e6), (4.0,) * 3)


def known_modes(stiffness: np.ndarray, masses: np.ndarray = MASSES) -> tuple[np.ndarray, np.ndarray]:
    """Periods [s], slowest first, and shapes of any size, by SciPy."""
    squares, shapes = scipy.linalg.eigh(stiffness, np.diag(masses))
    return 2.0 * pi / np.sqrt(squares), shapes


def modes_of(stiffness: np.ndarray, count: int, **more) -> ModeTable:
    periods, shapes = known_modes(stiffness)
    # As printed by a program: scaled to a largest component of 1.
    printed = (shapes / np.abs(shapes).max(axis=0))[:, :count].T
    return ModeTable(tuple(periods[:count]), tuple(map(tuple, printed)), **more)


def hall(**more) -> pr.MatrixBuilding:
    keys = {"stiffness_matrix": BENT.tolist(), "floor_masses": MASSES.tolist(), "storey_heights": "4 m"}
    return pr.MatrixBuilding("hall", **keys | more)


def test_storey_springs_of_a_chain_by_its_matrix_are_its_own():
    """In any mode the shear of a chain's storey is its stiffness times its drift."""
    chain = hall(stiffness_matrix=CHAIN.matrices()[2].tolist()).structure()
    assert chain.storey_springs == pytest.approx(CHAIN.stiffnesses, rel=1e-9)
    assert CHAIN.storey_springs == CHAIN.stiffnesses


def test_all_modes_give_the_matrix_back():
    stiffness, damping = assembled(modes_of(BENT, 3), MASSES, 0.05)
    assert damping is None
    assert stiffness == pytest.approx(BENT, rel=1e-12, abs=1e-12 * BENT.max())


@pytest.mark.parametrize("count", [1, 2])
def test_fewer_modes_keep_their_periods_shapes_and_ratios_and_the_rest_is_stiff(count: int):
    ratios = (0.02, 0.05)[:count]
    table = modes_of(BENT, count, dampings=ratios)
    stiffness, damping = assembled(table, MASSES, 0.05)
    periods, _ = known_modes(stiffness)
    known, forms = known_modes(BENT)
    rest = [min(table.periods) / 3.0] * (3 - count)
    assert sorted(periods) == pytest.approx(sorted([*known[:count], *rest]), rel=1e-9)
    for mode in range(count):
        assert stiffness @ forms[:, mode] == pytest.approx((2 * pi / known[mode]) ** 2 * MASSES * forms[:, mode], 1e-9)
        share = forms[:, mode] @ damping @ forms[:, mode]
        assert share == pytest.approx(2.0 * ratios[mode] * 2.0 * pi / known[mode], rel=1e-9)


def test_shapes_of_four_printed_digits_lose_no_more_than_their_rounding():
    """Löwdin's orthogonal shapes are the nearest: off by the rounding of the shapes, 1e-4 of the largest here."""
    table = modes_of(BENT, 3)
    printed = table._replace(shapes=tuple(tuple(round(one, 4) for one in shape) for shape in table.shapes))
    stiffness, _ = assembled(printed, MASSES, 0.05)
    assert known_modes(stiffness)[0] == pytest.approx(known_modes(BENT)[0], rel=1e-12)  # periods are kept
    assert stiffness == pytest.approx(BENT, abs=1e-3 * BENT.max())


def test_condensation_is_exact_for_rows_without_mass():
    """A chain of six springs with masses at every second node: two springs in series are one of half the stiffness."""
    springs = [300e6, 300e6, 200e6, 200e6, 100e6, 100e6]
    above = [*springs[1:], 0.0]
    whole = np.diag(np.add(springs, above)) - np.diag(springs[1:], 1) - np.diag(springs[1:], -1)
    halved = Storeys("A", (1e5,) * 3, (150e6, 100e6, 50e6), (3.0,) * 3).matrices()[2]
    assert condensed(symmetric(whole, "K"), (2, 4, 6)) == pytest.approx(halved, rel=1e-12, abs=1e-12 * 3e8)
    building = pr.MatrixBuilding(
        "A", stiffness_matrix=whole.tolist(), floor_masses=[1e5] * 3, storey_heights="3 m", floor_rows=[2, 4, 6]
    )
    known = Storeys("A", (1e5,) * 3, (150e6, 100e6, 50e6), (3.0,) * 3).period
    assert building.structure().period == pytest.approx(known, rel=1e-12)


@pytest.mark.parametrize("period", [0.3, 1.2])
def test_period_scales_stiffness_and_keeps_shapes_and_ratios(period: float):
    table = modes_of(BENT, 2, dampings=(0.02, 0.05))
    by_modes = pr.ModalBuilding(
        "A", modes=table, floor_masses=MASSES.tolist(), storey_heights="4 m", period=period
    ).structure()
    for building, ratios in ((hall(period=period).structure(), (0.05,) * 3), (by_modes, (0.02, 0.05, 0.05))):
        frequencies, forms = building.vibration()
        assert building.period == pytest.approx(period, rel=1e-12)
        damped = np.diag(forms.T @ building.matrices()[1] @ forms) / (2.0 * frequencies)
        assert damped == pytest.approx(np.array(ratios), rel=1e-9)


def test_what_is_no_building_is_refused(says):
    lists = {"floor_masses": MASSES.tolist(), "storey_heights": "4 m"}
    half = np.triu(BENT)
    says(refusal(lambda: hall(stiffness_matrix=half.tolist()).structure()))
    says(refusal(lambda: hall(stiffness_matrix=BENT[:2].tolist()).structure()))
    says(refusal(lambda: hall(stiffness_matrix=(BENT - 60e6 * np.eye(3)).tolist()).structure()))
    says(refusal(lambda: hall(floor_masses=[1e5] * 4, storey_heights=[3.0] * 4).structure()))
    says(refusal(lambda: hall(floor_rows=[1, 2, 5]).structure()))
    says(refusal(lambda: hall(damping_matrix=(-1e6 * np.eye(3)).tolist()).structure()))
    loose = np.zeros((4, 4))
    loose[:3, :3] = BENT
    says(refusal(lambda: hall(stiffness_matrix=loose.tolist(), floor_rows=[1, 2, 3]).structure()))
    table = modes_of(BENT, 2)

    def modal(**more):
        return lambda: pr.ModalBuilding("A", modes=table._replace(**more), **lists).structure()

    says(refusal(modal(shapes=(table.shapes[0], table.shapes[0]))))
    says(refusal(modal(shapes=((0.0,) * 3, table.shapes[1]))))
    says(refusal(modal(shapes=tuple(shape[:2] for shape in table.shapes))))
    says(refusal(modal(effective_masses=(100e3, 100e3))))
    four = table._replace(periods=(1.0,) * 4, shapes=((1.0, 1.0, 1.0),) * 4)
    says(refusal(lambda: pr.ModalBuilding("A", modes=four, **lists).structure()))


# ------------------------------------------------------------------------------------------------ mass matrices
BOUND = 1e3 * np.array([[180.0, 40.0, 5.0], [40.0, 190.0, 35.0], [5.0, 35.0, 120.0]])  # kg
LENGTH, BENDING, LINE = 32.0, 4e10, 9e3  # m, N m², kg/m


def massed(masses: np.ndarray, **more) -> pr.MatrixBuilding:
    """The frame with a mass matrix."""
    keys = {"stiffness_matrix": BENT.tolist(), "mass_matrix": masses.tolist(), "storey_heights": "4 m"}
    return pr.MatrixBuilding("hall", **keys | more)


def cantilever(elements: int) -> tuple[np.ndarray, np.ndarray]:
    """M and K of a clamped beam of Hermite elements, masses consistent: u and θ of each node, from the ground up."""
    h = LENGTH / elements
    stiff = BENDING / h**3 * np.array(
        [[12, 6 * h, -12, 6 * h], [6 * h, 4 * h * h, -6 * h, 2 * h * h],
         [-12, -6 * h, 12, -6 * h], [6 * h, 2 * h * h, -6 * h, 4 * h * h]]
    )  # fmt: skip
    heavy = LINE * h / 420.0 * np.array(
        [[156, 22 * h, 54, -13 * h], [22 * h, 4 * h * h, 13 * h, -3 * h * h],
         [54, 13 * h, 156, -22 * h], [-13 * h, -3 * h * h, -22 * h, 4 * h * h]]
    )  # fmt: skip
    masses, springs = np.zeros((2, 2 * elements + 2, 2 * elements + 2))
    for place in range(elements):
        dofs = slice(2 * place, 2 * place + 4)
        masses[dofs, dofs] += heavy
        springs[dofs, dofs] += stiff
    return masses[2:, 2:], springs[2:, 2:]


def wall(**more) -> pr.MatrixBuilding:
    """The beam of eight elements, its floors every second node."""
    masses, stiffness = cantilever(8)
    keys = {"floor_rows": [3, 7, 11, 15], "along_rows": [1, 3, 5, 7, 9, 11, 13, 15], "storey_heights": "8 m"}
    given = {key: value for key, value in (keys | more).items() if value is not None}
    return pr.MatrixBuilding("wall", stiffness_matrix=stiffness.tolist(), mass_matrix=masses.tolist(), **given)


def test_a_condensed_cantilever_has_the_modes_of_a_beam():
    """Blevins' roots of cos x cosh x = −1; four floors on eight elements are 8e-5 and 3e-3 above.

    Held to 1e-4 and 3e-3: a condensed model is stiffer (Guyan), by more the faster the mode.

    The first mode of a uniform cantilever carries 61.31 % of its mass (Chopra), the second 18.83 %. The nodes without
    a floor make the sum of the driven masses the beam's but for the half element at the ground, 1/16 of it.
    """
    building = wall().structure()
    rates = building.vibration().frequencies[:2] / np.sqrt(BENDING / (LINE * LENGTH**4))
    roots = np.array([1.87510407, 4.69409113]) ** 2
    assert (rates / roots - 1.0 < [1e-4, 3e-3]).all() and (rates > roots).all()
    shapes = building.vibration().shapes
    carried = (np.array(building.masses) @ shapes) ** 2 / (LINE * LENGTH)
    assert carried[:2] == pytest.approx([0.6131, 0.1883], abs=2e-3)
    contact = pr.Interface("50 mm", "jankowski", "1e11 N/m^1.5", restitution=0.65)
    stated = pr.modes(pr.Scene([wall(), pr.RigidWall("rock")], [contact], RECORDS))[0]
    assert stated.periods == pytest.approx(2.0 * pi / building.vibration().frequencies, rel=1e-12)
    assert stated.shares.sum() == pytest.approx(1.0, rel=1e-12)


def test_a_mast_is_condensed_to_its_tip():
    """Under a load there u = (3 x² − x³) / 2: 33/140 of the mass moves with the tip, a_g acts on 3/8.

    Within 3e-4, the half element at the ground of the second.
    """
    building = wall(floor_rows=[15], storey_heights="32 m").structure()
    assert np.array(building.mass_matrix) == pytest.approx(LINE * LENGTH * 33.0 / 140.0, rel=1e-9)
    assert building.masses == pytest.approx((LINE * LENGTH * 3.0 / 8.0,), rel=1e-3)
    given = wall(along_rows=None, floor_masses="60 t").structure()
    assert given.masses == (60e3,) * 4 and given.mass_matrix == wall().structure().mass_matrix


def test_masses_at_floors_alone_condense_to_themselves():
    """With massless rotations Guyan is exact: M stays, and a_g acts on it."""
    lumped = np.diag(np.where(np.arange(8) % 2 == 0, 5e4, 0.0))
    inertia, driven = condensed_masses(lumped, cantilever(4)[1], (1, 3, 5, 7))
    assert np.array_equal(inertia, 5e4 * np.eye(4)) and driven.tolist() == [5e4] * 4


@pytest.mark.parametrize(("kind", "masses"), [(hall, np.diag(MASSES)), (partial(massed, BOUND), BOUND)])
def test_a_matrix_has_the_modes_of_scipy_and_its_damping_in_each(kind, masses):
    building = kind(damping=0.03).structure()
    squares, shapes = scipy.linalg.eigh(BENT, masses)
    frequencies, forms = building.vibration()
    assert frequencies == pytest.approx(np.sqrt(squares), rel=1e-12)
    assert np.abs(forms.T @ masses @ shapes) == pytest.approx(np.eye(3), abs=1e-12)
    mass, damping, _ = building.matrices()
    assert np.diag(forms.T @ damping @ forms) == pytest.approx(2.0 * 0.03 * frequencies, rel=1e-12)
    assert mass.tolist() == masses.tolist() and building.masses == pytest.approx(masses.sum(axis=1), rel=1e-14)
    rayleigh = kind(damping_rule="rayleigh").structure()
    ratios = np.diag(forms.T @ rayleigh.matrices()[1] @ forms) / (2.0 * frequencies)
    assert ratios[[0, rayleigh._second_mode() - 1]] == pytest.approx(0.05, rel=1e-12)


def test_the_damping_of_a_building_is_that_of_the_first_mode_of_its_damping_matrix():
    """C = 0.5 / s M has ζ = 0.5 / (2 ω); it stands in results, where the double difference takes it."""
    building = hall(damping_matrix=(0.5 * np.diag(MASSES)).tolist()).structure()
    assert building.damping == pytest.approx(0.25 / (2.0 * pi / building.period), rel=1e-12)
    slower = hall(damping_matrix=(0.5 * np.diag(MASSES)).tolist(), period=2.0).structure()
    assert slower.damping == pytest.approx(building.damping, rel=1e-12)  # the same ratios
    with pytest.raises(pr.PoundingError, match=r"a damping of .* check the unit of damping_matrix"):
        hall(damping_matrix=(500.0 * np.diag(MASSES)).tolist()).structure()


def test_modes_with_dampings_are_the_same_building_after_they_are_written():
    periods, shapes = known_modes(BENT)
    keys = {"floor_masses": MASSES.tolist(), "storey_heights": "4 m"}
    table = {"period": [f"{period} s" for period in periods], "shape": shapes.T.tolist(), "damping": [0.03, 0.02, 0.02]}
    wall, contact = pr.RigidWall("wall"), pr.Interface("50 mm", "jankowski", "1e11 N/m^1.5", restitution=0.65)
    scene = pr.Scene([pr.ModalBuilding("hall", **keys, modes=table), wall], [contact], RECORDS)
    assert pr.read_scene(scene.to_toml()) == scene
    assert scene.buildings[0].damping == pytest.approx(0.03, rel=1e-12)


def test_a_diagonal_mass_matrix_is_its_floor_masses():
    lumped = massed(np.diag(MASSES)).structure()
    assert lumped.masses == tuple(MASSES) and not lumped.mass_coupling().size


def test_on_isolators_and_on_soil_it_stands_on_one_mass_more():
    """Against SciPy on the matrices written here: M beside the slab, K of drifts of the floors against it."""
    keys = {"slab_mass": "300 t", "height": "1.5 m", "strength": "900 kN", "stiffness": "5 MN/m"}
    building = massed(BOUND, isolation=keys).structure()
    base = scipy.linalg.block_diag(300e3, BOUND)
    spread = np.hstack([-np.ones((3, 1)), np.eye(3)])
    for spring, periods in ((5e6, building.isolated_period), (building.isolator_law.stiff, building.period)):
        whole = spread.T @ BENT @ spread
        whole[0, 0] += spring
        slowest = scipy.linalg.eigh(whole, base, eigvals_only=True)[0]
        assert periods == pytest.approx(2.0 * pi / np.sqrt(slowest), rel=1e-9)
    soft = chain_of(massed(BOUND).structure(), [SOIL])
    assert soft.mass_matrix()[1:, 1:].tolist() == BOUND.tolist() and soft.mass_matrix()[0, 0] == BOUND[0].sum()


def test_mass_matrices_that_hold_no_building_are_refused(says):
    isolation = {"slab_mass": "300 t", "height": "1 m", "strength": "9 kN", "stiffness": "5 MN/m"}
    says(refusal(wall(along_rows=None).structure))
    says(refusal(wall(along_rows=[1, 3, 5, 7, 9, 11, 13]).structure))
    says(refusal(wall(along_rows=[*range(1, 16, 2), 19]).structure))
    says(refusal(wall(along_rows=[3, 7, 11, 15]).structure))
    says(refusal(wall(isolation=isolation).structure))
    says(refusal(chain_of, wall().structure(), [SOIL]))
    says(refusal(massed(BOUND[:2, :2]).structure))
    says(refusal(massed(BOUND + 200e3 * np.eye(3, k=1) + 200e3 * np.eye(3, k=-1)).structure))
    says(refusal(massed(BOUND - 60e3).structure))
    says(refusal(replace, massed(BOUND).structure(), mass_matrix=tuple(map(tuple, (BOUND - 200e3).tolist()))))
    says(refusal(massed(np.triu(BOUND)).structure))
    says(refusal(massed(BOUND, floor_masses="650 t").structure))
