"""Buildings by matrices and modes: put together, condensed and refused, against SciPy and closed forms."""

from dataclasses import replace
from functools import partial
from math import pi
from typing import Any

import numpy as np
import pytest
import scipy.linalg
from oracle_springs import Linear, segments
from row_cases import Case, Shaking, contacts_of, meeting, points_of, single
from scenes import scene_text, storeyed
from sentences import refusal

import pounding_risk as pr
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.models.structures.condensation import Model, condensed_model, slowest
from pounding_risk.models.structures.matrices import ModeTable, assembled, condensed, condensed_masses, symmetric
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.scene.reader import parse_scene, read_scene
from pounding_risk.solver import counters
from pounding_risk.solver.row.api import free_row, run_row
from pounding_risk.solver.row.layout import lay_out

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


NODES = 12  # of a uniform chain, whose floors are every third
MASS, SPRING = 40e3, 400e6


def chain() -> tuple[np.ndarray, np.ndarray]:
    """M and K of equal masses on equal springs."""
    return MASS * np.eye(NODES), SPRING * (2 * np.eye(NODES) - np.eye(NODES, k=1) - np.eye(NODES, k=-1)) - SPRING * (
        np.diag(np.arange(NODES) == NODES - 1).astype(float)
    )


def bound(size: int = 7) -> tuple[np.ndarray, np.ndarray]:
    """A random pair, all rows along the row: masses that share inertia, springs between any two rows."""
    rng = np.random.default_rng(20)
    masses, springs = (rng.uniform(-1.0, 1.0, (size, size)) for _ in range(2))
    springs = SPRING * (springs @ springs.T / size + 0.2 * np.diag(1.0 + np.arange(size)))
    return MASS * (np.eye(size) + 0.15 * masses @ masses.T), springs


def building(matrices: tuple[np.ndarray, np.ndarray], rows: list[int], **more: Any) -> pr.MatrixBuilding:
    masses, stiffness = matrices
    keys = {"stiffness_matrix": stiffness.tolist(), "mass_matrix": masses.tolist(), "storey_heights": "4 m"}
    keys |= {"floor_rows": rows, "along_rows": list(range(1, 1 + len(masses)))}
    return pr.MatrixBuilding("block", **{key: value for key, value in (keys | more).items() if value is not None})


def beside_a_wall(*buildings: Any, **more: Any) -> pr.Scene:
    contact = pr.Interface("20 mm", "jankowski", "1e10 N/m^1.5", restitution=0.65)
    return pr.Scene([*buildings, pr.RigidWall("rock")], [contact] * len(buildings), pr.Records(["RSN6-180"]), **more)


@pytest.mark.parametrize(("matrices", "rows"), [(chain(), [3, 6, 9, 12]), (bound(), [2, 5])])
def test_frequencies_fall_to_those_of_the_whole_model_as_modes_are_added(matrices, rows):
    """Of nested sets of motions each frequency falls (Courant and Fischer); all modes are the model, but for rounding.

    The chain's are 2 √(k/m) sin((2 j − 1) π / (4 N + 2)).
    """
    known = np.sqrt(scipy.linalg.eigh(matrices[1], matrices[0], eigvals_only=True))
    if len(known) == NODES:
        closed = 2.0 * np.sqrt(SPRING / MASS) * np.sin((2 * np.arange(1, NODES + 1) - 1) * pi / (4 * NODES + 2))
        np.testing.assert_allclose(known, closed, rtol=1e-12)
    before = np.full(len(rows), np.inf)
    for count in range(len(known) - len(rows) + 1):
        found = building(matrices, rows, interior_modes=count).structure().vibration().frequencies
        assert len(found) == len(rows) + count
        assert (found >= known[: len(found)] * (1.0 - 1e-12)).all()
        assert (found[: len(before)] <= before * (1.0 + 1e-12)).all()
        before = found
    np.testing.assert_allclose(before, known, rtol=1e-11)


def test_interior_modes_are_those_of_a_chain_held_at_its_floors():
    """Of two masses between held ones ω² = k/m and 3 k/m, shapes (1, 1) and (1, −1); the top spring holds no mass."""
    masses, stiffness = chain()
    modes = condensed_model(Model(stiffness, masses, np.zeros((0, 0)), (3, 6, 9, 12), tuple(range(1, 13))), 8)
    squares = np.diag(modes.stiffness)[4:] / np.diag(modes.masses)[4:]
    np.testing.assert_allclose(np.sort(squares), SPRING / MASS * np.repeat([1.0, 3.0], 4), rtol=1e-12)
    assert np.abs(modes.motions[:, 4:]).max(axis=0) == pytest.approx(1.0, rel=1e-14)
    assert np.abs(modes.stiffness[:4, 4:]).max() == 0.0
    # All of p is what rigid motion of the held rows drives: pᵀ M⁻¹ p is the mass of all rows.
    assert modes.driven @ np.linalg.solve(modes.masses, modes.driven) == pytest.approx(NODES * MASS, rel=1e-12)


def test_without_interior_modes_it_is_guyan_to_the_bit():
    matrices = bound()
    assert building(matrices, [2, 5], interior_modes=0).structure() == building(matrices, [2, 5]).structure()


def test_a_cantilever_with_interior_modes_has_the_modes_of_the_beam():
    """Blevins' roots of cos x cosh x = −1. With all 12 modes the error is that of eight Hermite elements,

    (β h)⁴ / 1440 (Strang and Fix 1973: 1/720 in ω²), 2e-3 in the fourth; the next power of β h takes 10 % of that."""
    rates = wall(interior_modes=12).structure().vibration().frequencies[:4] / np.sqrt(BENDING / (LINE * LENGTH**4))
    roots = np.array([1.87510407, 4.69409113, 7.85475744, 10.99554073]) ** 2
    steps = np.sqrt(roots) / 8.0
    np.testing.assert_allclose(rates / roots - 1.0, steps**4 / 1440.0, rtol=0.1)


def test_rows_without_mass_have_no_modes_and_motions_of_another_direction_are_passed_over():
    """Rotations without mass; and, beside the beam, rows of its motion across, which nothing along the row moves."""
    masses, stiffness = cantilever(8)
    lumped = np.diag(np.where(np.arange(16) % 2 == 0, np.diag(masses), 0.0))
    assert len(slowest(lumped, stiffness)[0]) == 8
    twice = scipy.linalg.block_diag(masses, masses), scipy.linalg.block_diag(stiffness, 0.25 * stiffness)
    along = list(range(1, 16, 2))
    both = building(twice, [3, 7, 11, 15], along_rows=along, storey_heights="8 m", interior_modes=3).structure()
    one = wall(interior_modes=3).structure()
    np.testing.assert_allclose(both.vibration().frequencies, one.vibration().frequencies, rtol=1e-9)
    np.testing.assert_allclose(np.abs(both.interior_masses), np.abs(one.interior_masses), rtol=1e-8)


RULES: dict[str, dict[str, Any]] = {
    "modal": {},
    "rayleigh": {"damping_rule": "rayleigh"},
    "stiffness": {"damping_rule": "stiffness"},
    "matrix": {"damping_matrix": (4e4 * np.eye(7) + 2e-3 * bound()[1]).tolist()},
}


def whole_damping(rule: str) -> np.ndarray:
    """C of all rows by a rule, as the floors' is: 5 % in the modes that the rule names."""
    masses, stiffness = bound()
    squares, shapes = scipy.linalg.eigh(stiffness, masses)
    rates = np.sqrt(squares)
    if rule == "matrix":
        return np.array(RULES[rule]["damping_matrix"])
    if rule == "modal":
        return masses @ shapes @ np.diag(0.1 * rates) @ shapes.T @ masses
    if rule == "stiffness":
        return 0.1 / rates[0] * stiffness
    carried = np.cumsum((masses.sum(axis=0) @ shapes) ** 2) / masses.sum()
    second = rates[max(1, int(np.searchsorted(carried, 0.95)))]
    scale = 0.1 / (rates[0] + second)
    return scale * rates[0] * second * masses + scale * stiffness


@pytest.mark.parametrize("strikes", [False, True])
@pytest.mark.parametrize("rule", RULES)
def test_with_all_interior_modes_it_moves_as_the_whole_model_of_scipy(rule: str, strikes: bool):
    """Floors at the samples, beside a mass, within 1e-9 of the largest: SciPy's DOP853 at 1e-12 on all seven rows.

    The contacts are springs; the solver integrates them at 1e-12.
    """
    masses, stiffness = bound()
    structure = building((masses, stiffness), [2, 5], interior_modes=5, **RULES[rule]).structure()
    gap, spring = (0.002 if strikes else 1.0), 5e8
    shaking = Shaking("RSN6-180", 1.5, 3.0, 0.6)
    case = Case(
        (chain_of(structure), single(300e3, 0.3)),
        (meeting(0, 2.0, 1.0, gap, "linear", stiffness=spring, restitution=1.0),),
        shaking,
    )
    ground, dt = shaking.samples()
    omega = 2.0 * pi / 0.3
    shares = np.zeros((1, 8))
    shares[0, [4, 7]] = 1.0, -1.0
    system = Linear(
        scipy.linalg.block_diag(masses, 300e3), scipy.linalg.block_diag(stiffness, omega**2 * 300e3),
        scipy.linalg.block_diag(whole_damping(rule), 0.1 * omega * 300e3), shares, spring, gap,
    )  # fmt: skip
    known = [path[[1, 4], -1] for ends, path, _, _ in segments(system, ground, dt, 2) if ends]
    layout = lay_out(case.chains, points_of(case.meetings), dt)
    run = run_row(layout, contacts_of(case.meetings), ground, rtol=1e-12, histories=True)
    assert run.status == counters.COMPLETE
    assert (run.points[0, counters.COUNT] > 2) == strikes
    moved = run.states[:: layout.parts, 0, :2][1 : 1 + len(known)]
    np.testing.assert_allclose(moved, known, rtol=0.0, atol=1e-9 * np.abs(known).max())
    if not strikes:
        free = free_row(layout, ground, states=True).states[:: layout.parts, 0, :2][1 : 1 + len(known)]
        np.testing.assert_allclose(free, known, rtol=0.0, atol=1e-9 * np.abs(known).max())


def test_a_damping_matrix_of_all_rows_is_condensed_by_the_motions_of_the_floors_too():
    """In proportion to the stiffness it is the condensed stiffness, by Guyan as with modes."""
    matrices = bound()
    for count in (0, 2):
        found = building(matrices, [2, 5], interior_modes=count, damping_matrix=(0.003 * matrices[1]).tolist())
        structure = found.structure()
        proportional = 0.003 * np.array(structure.stiffness_matrix)
        np.testing.assert_allclose(structure.damping_matrix, proportional, rtol=1e-9, atol=1e-9 * SPRING)


def test_results_have_the_floors_alone_and_a_written_scene_the_same_building(tmp_path):
    """Levels, drifts and accelerations of two floors; what stands between them is in the numbers of these."""
    scene = beside_a_wall(building(bound(), [2, 5], interior_modes=3))
    written = read_scene(scene.to_toml())
    assert written.buildings == scene.buildings and "interior_masses" in scene.to_toml()
    run, again = (pr.simulate(one, gap="0.2 mm") for one in (scene, written))
    assert run.sizes["storey"] == 2 and run["displacement"].shape[1:] == (2, 2)
    assert int(run["impact_count"].sum()) > 2
    for name in ("storey_displacement", "storey_drift", "storey_acceleration", "peak_closing", "peak_contact_force"):
        np.testing.assert_array_equal(run[name], again[name], err_msg=name)
    modes = pr.modes(scene)[0]
    assert modes.shapes.shape == (2, 5) and modes.shares.sum() == pytest.approx(1.0, rel=1e-12)
    np.testing.assert_allclose(modes.shapes @ modes.participations, 1.0, rtol=0.5)
    assert (modes.shapes[-1] > 0.0).all()


def test_modes_state_the_whole_model_and_validate_notes_what_is_far_off():
    """The beam of eight elements with one floor, its tip: Guyan has the first mode alone."""
    tip = {"floor_rows": [15], "storey_heights": "32 m"}
    study = beside_a_wall(wall(**tip))
    structure = study.buildings[0]
    known = 2.0 * pi / np.sqrt(scipy.linalg.eigh(*cantilever(8)[::-1], eigvals_only=True))
    np.testing.assert_allclose(structure.condensation.periods, known[: len(structure.condensation.periods)], rtol=1e-9)
    assert structure.condensation.here[0] == structure.period and np.isnan(structure.condensation.here[1])
    notes = [note for note in of_input(study, ()) if "condensed" in note]
    assert len(notes) == 1 and "no mode like it" in notes[0] and "interior_modes = 1 or more" in notes[0]
    finer = beside_a_wall(wall(**tip, interior_modes=6))
    assert not [note for note in of_input(finer, ()) if "condensed" in note]
    np.testing.assert_allclose(finer.buildings[0].condensation.here[:3], known[:3], rtol=1e-3)
    scaled = wall(**tip, period="1.5 s").structure().condensation
    assert scaled.here[0] == pytest.approx(1.5, rel=1e-12)
    assert scaled.periods[0] / scaled.here[0] == pytest.approx(known[0] / structure.period, rel=1e-9)


def test_it_begins_yields_leans_and_is_linked_as_a_building_without_interior_modes():
    """A chain whose other rows are nearly massless is the chain of its floors: modes far above add nothing.

    Masses of 1e-4 of a floor's move its floors by some 1e-4: peaks are within 1e-3.
    """
    springs = np.array([200e6, 200e6, 120e6, 120e6])
    stiffness = np.diag(springs + np.append(springs[1:], 0.0)) - np.diag(springs[1:], 1) - np.diag(springs[1:], -1)
    light = np.diag([20.0, 200e3, 20.0, 200e3])
    part = {"storey_stiffnesses": ["60 MN/m", "40 MN/m"], "storey_strengths": ["0.3 MN", "0.2 MN"]}
    keys = part | {"initial_displacement": ["1 mm", "2 mm"]}
    runs = []
    for count in (0, 2):
        block = building((light, stiffness), [2, 4], interior_modes=count, **keys)
        other = pr.SingleMass("shed", "300 t", "0.3 s", height="8 m")
        contact = pr.Interface("10 mm", "jankowski", "1e10 N/m^1.5", restitution=0.65, link_stiffness="3 MN/m")
        records = pr.Records(["RSN6-180"], window=["1.5 s", "6 s"], pga="0.6 g")
        scene = pr.Scene([block, other], [contact], records, effects={"inelastic_storeys": {}, "p_delta": {}})
        runs.append(pr.simulate(scene))
    assert float(runs[0]["storey_ductility"].max()) > 1.5 and int(runs[0]["impact_count"].sum()) > 0
    for name in ("storey_displacement", "storey_drift", "storey_ductility", "peak_closing", "peak_link_stretch"):
        np.testing.assert_allclose(runs[1][name], runs[0][name], rtol=1e-3, err_msg=name)
    assert runs[1]["displacement"].values[0, 0].tolist() == [1e-3, 2e-3]


def test_what_has_no_interior_modes_is_refused(says):
    matrices = bound()
    says(refusal(building(matrices, [2, 5], interior_modes=6).structure))
    says(
        refusal(
            building((np.diag([1.0, 1e4, 1.0, 1.0, 1e4, 1.0, 1.0]), matrices[1]), [2, 5], interior_modes=9).structure
        )
    )
    says(refusal(building(matrices, [2, 5], interior_modes=2, damping_matrix=np.eye(2).tolist()).structure))
    says(refusal(building(matrices, [2, 5], damping_matrix=np.eye(3).tolist()).structure))
    says(refusal(wall(interior_modes=2, isolation={"slab_mass": "300 t", "height": "1 m", "strength": "9 kN",
                                                  "stiffness": "5 MN/m"}).structure))  # fmt: skip
    says(refusal(chain_of, wall(interior_modes=2).structure(), [("soil_flexibility", (("shear_wave_velocity", 150.0),
                                                                                     ("radius", 6.0)))]))  # fmt: skip
    says(refusal(building(matrices, [*range(1, len(matrices[0]) + 1)], interior_modes=1).structure))
    loose = matrices[0].copy()
    loose[0, 0] = -1e5
    says(refusal(building((loose, matrices[1]), [2, 5], interior_modes=2).structure))
    given = replace(building(matrices, [2, 5], interior_modes=2).structure())
    says(refusal(lambda: replace(given, interior_masses=given.interior_masses[:1])))


MODES = {"mass_matrix": "{values = [[40, 4, 2], [4, 30, 3], [2, 3, 20]], unit = 't'}", "interior_masses": "['9 t']"}


def scene_with(**keys: str) -> Any:
    """A block of three rows beside a tower, with these keys as they are written."""
    rows = {"stiffness_matrix": "{values = [[90, -40, 0], [-40, 60, 0], [0, 0, 400]], unit = 'MN/m'}"}
    lines = [f"{key} = {value}" for key, value in (rows | keys).items()]
    text = scene_text(storeyed("A", ["40 t"] * 2, "60 MN/m", ["4 m"] * 2), single_mass(), gap="9 mm")
    head = text.index("floor_masses")
    return parse_scene(text[:head] + "\n".join(lines) + "\n" + text[text.index("storey_heights") :])


def single_mass() -> str:
    return storeyed("B", ["40 t"] * 2, "90 MN/m", ["4 m"] * 2)


def test_keys_of_interior_modes_that_do_not_fit_are_refused(says):
    floors = {"floor_masses": "['40 t', '40 t']"}
    found = scene_with(**floors, **MODES).buildings[0]
    assert found.interior_masses == (9e3,) and len(found.masses) == 2
    says(refusal(scene_with, **floors, **MODES, interior_modes="1"))
    says(refusal(scene_with, **MODES))
    says(refusal(scene_with, **floors, **MODES, floor_rows="[1, 2]"))
    says(refusal(scene_with, **floors, mass_matrix=MODES["mass_matrix"], interior_modes="1", floor_rows="[1, 2]"))
    says(refusal(scene_with, **floors, interior_masses="['9 t']"))
    says(refusal(scene_with, floor_masses="'40 t'", interior_modes="1", floor_rows="[1, 2]"))
    says(refusal(scene_with, **floors, mass_matrix=MODES["mass_matrix"], interior_modes="1"))
    says(refusal(scene_with, **floors, **MODES | {"interior_masses": "['9 t', '9 t', '9 t']"}))
    says(refusal(scene_with, **floors, mass_matrix=MODES["mass_matrix"], interior_modes="-1", floor_rows="[1, 2]"))
