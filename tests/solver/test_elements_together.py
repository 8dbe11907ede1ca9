"""Elements in one row: isolators, a moat, storeys that yield, a hook that breaks, bumpers, a damper on a brace, a slip.

Each is tested alone elsewhere. Here all act on each other, through a shock and its aftershock.
"""

from math import inf, sqrt

import numpy as np
import pytest
from oracle_elements import Elements, Motion, shaken
from scenes import rigid, scene_text, storeyed

import pounding_risk as pr
from pounding_risk.scene.reader import parse_scene

K = 4e8  # N/m, of contact
LINEAR = {"contact_model": "linear", "stiffness": f"{K} N/m"}
AT_TWO = [{"left": "storey 2", "right": "storey 2"}]
ISOLATION = {
    "slab_mass": "200 t", "height": "3 m", "strength": "300 kN", "stiffness": "6 MN/m", "yield_displacement": "10 mm",
    "damping": "100 kN s/m",
}  # fmt: skip
SCENE = scene_text(
    rigid("moat", height="3 m"),
    storeyed("I", ["200 t"], "300 MN/m", ["3 m"], damping=0.02, damping_rule="stiffness", isolation=ISOLATION),
    storeyed("A", ["200 t", "150 t"], ["150 MN/m", "90 MN/m"], ["3 m", "3 m"], damping_rule="stiffness",
             storey_strengths=["1200 kN", "700 kN"]),
    storeyed("B", ["300 t", "250 t"], ["500 MN/m", "400 MN/m"], ["3 m", "3 m"], damping_rule="stiffness",
             storey_strengths=["3500 kN", "2000 kN"]),
    interfaces=[
        {"gap": "60 mm", **LINEAR},
        {"gap": "70 mm", **LINEAR, "bumper_length": "20 mm", "link_stiffness": "50 MN/m", "link_slack": "10 mm",
         "link_breaking_force": "900 kN"},
        {"gap": "20 mm", **LINEAR, "contact": AT_TWO, "link_damping": "600 kN s/m", "link_exponent": 0.5,
         "link_brace_stiffness": "60 MN/m", "link_stiffness": "5 MN/m",
         "link_at": [{"left": "column 2 at 0.5", "right": "storey 1"}]},
    ],
    effects={"inelastic_storeys": {"hardening": 0.05}},
    records={
        "names": None, "generated": [{"kind": "ricker", "pga": "7 m/s^2", "period": "0.6 s", "step": "4 ms"}],
        "tail": "1 s",
        "aftershock": "ricker: pga=7 m/s^2, period=0.9 s, step=4 ms", "aftershock_ratio": 1.1, "pause": "1 s",
    },
    solver={"rtol": 1e-8},
)  # fmt: skip
STEP = 2.5e-4  # s


def storeys(mass: list[float], stiffness: list[float], ratio: float) -> np.ndarray:
    """2 ζ / ω1 K of storeys."""
    drifts = np.eye(len(mass)) - np.eye(len(mass), k=-1)
    matrix = drifts.T @ np.diag(stiffness) @ drifts
    root = np.sqrt(mass)
    return 2.0 * ratio / sqrt(np.linalg.eigvalsh(matrix / np.outer(root, root))[0]) * matrix


def known(ground: np.ndarray, step: float) -> Motion:
    """The scene by central differences: dofs 0 and 1 are I, 2 and 3 A, 4 and 5 B."""
    mass = 1e3 * np.array([200.0, 200.0, 200.0, 150.0, 300.0, 250.0])
    damping = np.zeros((6, 6))
    relative = np.array([[-1.0, 1.0]])
    damping[:2, :2] = relative.T @ storeys([2e5], [3e8], 0.02) @ relative + np.diag([1e5, 0.0])
    damping[2:4, 2:4] = storeys([2e5, 1.5e5], [1.5e8, 9e7], 0.05)
    damping[4:, 4:] = storeys([3e5, 2.5e5], [5e8, 4e8], 0.05)
    stiff = 6e6 + 3e5 / 0.01
    elements = Elements(
        springs=[
            ({0: 1.0}, stiff, 6e6 / stiff, stiff * 0.01), ({1: 1.0, 0: -1.0}, 3e8, 0.0, inf),
            ({2: 1.0}, 1.5e8, 0.05, 1.2e6), ({3: 1.0, 2: -1.0}, 9e7, 0.05, 7e5),
            ({4: 1.0}, 5e8, 0.05, 3.5e6), ({5: 1.0, 4: -1.0}, 4e8, 0.05, 2e6),
            ({4: 1.0, 3: -0.5, 2: -0.5}, 5e6, 0.0, inf),
        ],
        stops=[
            ({0: -1.0}, K, 0.06, inf), ({0: 1.0, 2: -1.0}, K, 0.05, inf), ({1: 1.0, 3: -1.0}, K, 0.05, inf),
            ({3: 1.0, 5: -1.0}, K, 0.02, inf), ({1: -1.0, 3: 1.0}, 5e7, 0.01, 9e5),
        ],
        dampers=[({4: 1.0, 3: -0.5, 2: -0.5}, 6e5, 0.5, 6e7)],
    )  # fmt: skip
    return shaken(mass, damping, elements, ground, step)


def test_all_of_them_at_once_are_an_own_integration():
    run = pr.simulate(parse_scene(SCENE))
    times = np.arange(0.0, run["time"].values[-1], STEP)
    found = known(np.interp(times, run["time"].values, run["ground_acceleration"].values), STEP)
    near = {"rtol": 2e-3}
    moved = run["storey_displacement"].values[1:, :2].ravel()
    np.testing.assert_allclose(moved, found.displacement, **near)
    np.testing.assert_allclose(run["storey_drift"].values[1:, :2].ravel(), found.springs[0, :6], **near)
    residual = run["storey_residual_drift"].values[1:, :2].ravel()
    np.testing.assert_allclose(residual, found.springs[1, :6], atol=2e-3 * moved.max())
    assert (residual[[0, 2, 3]] > 1e-3).all()
    of_interface = [[0], [1, 2], [3]]
    np.testing.assert_allclose(run["peak_contact_force"], [found.stops[1, at].max() for at in of_interface], rtol=5e-3)
    assert run["impact_count"].values.tolist() == [found.stops[2, at].sum() for at in of_interface]
    np.testing.assert_allclose(run["first_impact_time"], [np.nanmin(found.first[at]) for at in of_interface], rtol=1e-3)
    stretched, shortened = run["peak_link_stretch"].values[1:], run["peak_link_shortening"].values[1:]
    np.testing.assert_allclose(stretched[0], found.stops[0, 4], **near)
    np.testing.assert_allclose(max(stretched[1], shortened[1]), found.springs[0, 6], **near)
    assert run["broken_links"].values[1] == found.stops[3, 4] == 1.0
    assert run["peak_link_spring_force"].values[1] == pytest.approx(9e5)
    assert run["peak_link_damper_force"].values[2] == pytest.approx(found.dampers[0, 0], rel=2e-3)
    assert run["link_energy"].values[1:] == pytest.approx([9e5**2 / 1e8, found.dampers[1, 0]], rel=2e-3)
