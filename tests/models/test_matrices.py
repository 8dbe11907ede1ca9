"""Buildings by matrices and by modes: put together, condensed and refused, against SciPy and closed forms."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
import scipy.linalg
from sentences import refusal

import pounding_risk as pr
from pounding_risk.models.structures.matrices import ModeTable, assembled, condensed, symmetric
from pounding_risk.models.structures.storeys import Storeys

MASSES = np.array([200e3, 200e3, 150e3])
# A frame whose columns bend as a whole: no chain of storey springs has its entries beside the tridiagonal band.
BENT = np.array([[320e6, -180e6, 30e6], [-180e6, 230e6, -90e6], [30e6, -90e6, 65e6]])
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


def test_a_matrix_has_the_modes_of_scipy_and_its_damping_in_each():
    building = hall(damping=0.03).structure()
    periods, shapes = known_modes(BENT)
    frequencies, forms = building.vibration()
    assert 2.0 * pi / frequencies == pytest.approx(periods, rel=1e-12)  # rounding
    assert np.abs(forms.T @ np.diag(MASSES) @ shapes) == pytest.approx(np.eye(3), abs=1e-12)
    mass, damping, _ = building.matrices()
    assert np.diag(forms.T @ damping @ forms) == pytest.approx(2.0 * 0.03 * frequencies, rel=1e-12)
    assert mass.tolist() == np.diag(MASSES).tolist()


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
