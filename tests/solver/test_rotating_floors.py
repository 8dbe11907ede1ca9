"""Floors that rotate: closed forms, the row without rotation, and SciPy in the coordinates of both motions.

Oracle: DOP853 on matrices that are put together here, storey by storey from springs along and across the row at the
centre of stiffness and one of rotation about it; contact points at both ends of a face are springs.
"""

import itertools
import json
from dataclasses import replace

import numpy as np
import pytest
from oracle_springs import Linear, extremes
from scenes import scene_text, storeyed
from scipy.linalg import eigh
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.row import row_case
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.own_grounds import followed_by
from pounding_risk.reports.sections.scene import _of_storeys
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.notes import level_notes
from pounding_risk.scene.reader import parse_scene

PLAN = {"face": ["-6 m", "10 m"], "centre": "1 m", "eccentricity": "1.8 m", "gyration": "5 m", "torsional_ratio": 1.2}
STRAIGHT = PLAN | {"eccentricity": "0 m"}
OTHER = {"face": ["-9 m", "8 m"], "eccentricity": "-1 m", "gyration": "5.5 m", "torsional_ratio": 0.9}
ACROSS = PLAN | {"eccentricity_along": "1.5 m", "across_ratio": 0.8}
OTHER_ACROSS = OTHER | {"eccentricity_along": "-2 m", "across_ratio": 1.3}
# The floor above the first one of `ACROSS`: a tower on one side of it.
TOWER = {
    "face": ["-4 m", "8 m"],
    "centre": "2.5 m",
    "eccentricity": "-0.8 m",
    "gyration": "4 m",
    "torsional_ratio": 0.7,
}
TOWER_ACROSS = TOWER | {"eccentricity_along": "0.5 m", "across_ratio": 1.1, "centre_along": "-2 m"}
LEFT = storeyed("A", ["200 t", "150 t"], ["90 MN/m", "60 MN/m"], ["3 m", "3 m"])
RIGHT = storeyed("B", ["300 t", "200 t"], ["200 MN/m", "150 MN/m"], ["3 m", "3 m"])
RECORD = {"names": ["RSN6-180"], "window": ["1.5 s", "4 s"], "pga": "0.5 g"}
BOTH = RECORD | {"names": ["RSN6-180", "RSN6-270"], "direction": "40 deg"}


def scene(left: dict, right: dict, **more):
    """Both buildings with further keys."""
    keys = {"law": "linear", "gap": "6 mm", "records": RECORD, "solver": {"rtol": 1e-10}}
    return parse_scene(scene_text(LEFT | left, RIGHT | right, **keys | more))


def test_unlike_floors_have_the_frequencies_of_coordinates_at_one_place():
    """All displacements at one vertical axis: a mass matrix with terms beside its diagonal, storey matrices without.

    By rounding. Rayleigh damping over the modes of both motions has 5 % in its two modes.
    """
    study = scene({"plan": [PLAN, TOWER], "damping_rule": "rayleigh"}, {})
    chain = model_of(study).chains[0]
    mass, spring, centre, off = ([200e3, 150e3], [90e6, 60e6], [1.0, 2.5], [1.8, -0.8])
    mass, spring, centre, stiff = map(np.array, (mass, spring, centre, np.add(centre, off)))
    inertia = mass * (np.array([5.0, 4.0]) ** 2 + centre**2)
    masses = np.block([[np.diag(mass), np.diag(-mass * centre)], [np.diag(-mass * centre), np.diag(inertia)]])
    turning = spring * ((np.array([1.2, 0.7]) * np.array([5.0, 4.0])) ** 2 + stiff**2)
    parts = [np.array([[k.sum(), -k[1]], [-k[1], k[1]]]) for k in (spring, -spring * stiff, turning)]
    squares = np.sort(eigh(np.block([[parts[0], parts[1]], [parts[1], parts[2]]]), masses, eigvals_only=True))
    found = np.linalg.eigvals(chain.stiffness() / chain.mass[:, None])
    assert np.sort(found) == pytest.approx(squares, rel=1e-12)
    (tower, _) = pr.modes(study)
    assert np.isclose(tower.dampings, 0.05, rtol=1e-9).tolist() == [True, False, False, True]
    assert (tower.shapes[-1] > 0.0).all()


def test_without_eccentricity_the_row_is_that_of_storeys():
    """Elastic contact at equal distances from both centres: both ends of a face together are the floor.

    To 1e-9, ten times the tolerance of the runs.
    """
    middle = OTHER | {"eccentricity": "0 m", "centre": "1 m"}
    plain = pr.scan(scene({}, {}), check_fraction=0.0)
    plans = pr.scan(scene({"plan": STRAIGHT}, {"plan": middle}), check_fraction=0.0)
    assert int(plans["impact_count"].sum()) == 2 * int(plain["impact_count"].sum()) > 4
    moved = ("peak_closing", "storey_displacement", "storey_drift", "storey_acceleration")
    for name in moved:
        np.testing.assert_allclose(plans[name].values, plain[name].values, rtol=1e-9, err_msg=name)
    for name in ("impulse", "peak_contact_force"):  # of a penetration that is a tenth of the closing
        whole = 2.0 if name == "peak_contact_force" else 1.0
        np.testing.assert_allclose(whole * plans[name].values, plain[name].values, rtol=1e-8, err_msg=name)


def components(direction: float) -> tuple[np.ndarray, np.ndarray, float]:
    """a_g along a direction [degrees from north] and to the left of it, of `BOTH`, and the time step.

    By unit vectors on the compass: 180° is south, 270° west.
    """
    south, west = (pr.read_motion(name, window=(1.5, 4.0)) for name in BOTH["names"])
    ground = np.column_stack([-south.acceleration, -west.acceleration])  # north and east
    ahead = np.array([np.cos(np.radians(direction)), np.sin(np.radians(direction))])
    along, across = ground @ ahead, ground @ np.array([ahead[1], -ahead[0]])
    factor = 0.5 * 9.80665 / np.abs(along).max()
    return factor * along, factor * across, south.dt


def numbers(plan: dict) -> dict:
    """The numbers of a plan, lengths in m."""
    texts = {key: value for key, value in plan.items() if key != "face"}
    return {"centre_along": 0.0} | {key: float(str(value).removesuffix(" m")) for key, value in texts.items()}


def matrices(masses, springs, plans):
    """M, K of (u, θ), or (u, θ, w) where plans have an eccentricity along the row, of all floors.

    Springs at the centre of stiffness of each storey, and of rotation about it; ``plans`` of the floors, from the
    ground up. Displacements are those of the centres of mass.
    """
    count, plans = len(masses), [numbers(plan) for plan in plans]
    acts_across = "eccentricity_along" in plans[0]
    motions = 3 if acts_across else 2
    stiffness = np.zeros((motions * count, motions * count))
    for storey, (spring, plan) in enumerate(zip(springs, plans, strict=True)):
        drift = np.zeros((motions, motions * count))  # at the centre of stiffness, of rotation, across
        springs_here = [spring, spring * (plan["torsional_ratio"] * plan["gyration"]) ** 2]
        for floor, sign in ((storey, 1.0), (storey - 1, -1.0)):
            if floor >= 0:
                arm = plan["centre"] + plan["eccentricity"] - plans[floor]["centre"]
                drift[0, floor], drift[0, count + floor] = sign, -sign * arm
                drift[1, count + floor] = sign
                if acts_across:
                    ahead = plan["centre_along"] + plan["eccentricity_along"] - plans[floor]["centre_along"]
                    drift[2, 2 * count + floor], drift[2, count + floor] = sign, sign * ahead
        if acts_across:
            springs_here.append(spring * plan["across_ratio"] ** 2)
        stiffness += drift.T @ np.diag(springs_here) @ drift
    inertias = [plan["gyration"] ** 2 * mass for plan, mass in zip(plans, masses, strict=True)]
    return np.concatenate([masses, inertias, masses][:motions]), stiffness


def by_scipy(plans, ground, dt: float, gap: float, stiffness: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Peaks of u of both buildings, the force at each contact point, and all displacements at each sample.

    ``plans`` of the floors of either building; ``ground`` = (a_g along the row,), or with that across it.
    """
    acts_across = len(ground) > 1
    sides = matrices([200e3, 150e3], [90e6, 60e6], plans[0]), matrices([300e3, 200e3], [200e6, 150e6], plans[1])
    masses, size = np.concatenate([side[0] for side in sides]), sides[0][0].size
    whole, damping = np.zeros((2 * size, 2 * size)), np.zeros((2 * size, 2 * size))
    for start, (mass, matrix) in zip((0, size), sides, strict=True):
        dofs = slice(start, start + size)
        whole[dofs, dofs] = matrix
        root = np.sqrt(mass)
        squares, forms = np.linalg.eigh(matrix / np.outer(root, root))
        damping[dofs, dofs] = np.outer(root, root) * ((forms * (0.1 * np.sqrt(squares))) @ forms.T)
    shares = np.zeros((4, 2 * size))
    for row, (floor, end) in enumerate((floor, end) for floor in (0, 1) for end in (0, 1)):
        faces = [[float(place.removesuffix(" m")) for place in side[floor]["face"]] for side in plans]
        across = min(face[1] for face in faces) if end else max(face[0] for face in faces)
        for side, sign in ((0, 1.0), (1, -1.0)):
            arm = across - numbers(plans[side][floor])["centre"]
            shares[row, [side * size + floor, side * size + 2 + floor]] = sign, -sign * arm
    felt = np.zeros((len(ground), 2 * size))
    felt[0, [0, 1, size, size + 1]] = 1.0
    if acts_across:
        felt[1, [4, 5, size + 4, size + 5]] = 1.0
    found = extremes(Linear(masses, whole, damping, shares, stiffness, gap, felt), np.array(ground).T, dt, 400)
    return np.maximum(found.high, -found.low)[[0, 1, size, size + 1]], found.force, found.samples


@pytest.mark.parametrize(
    ("left", "right"),
    [
        pytest.param([PLAN] * 2, [OTHER] * 2, id="along"),
        pytest.param([PLAN, TOWER], [OTHER] * 2, id="along, unlike floors", marks=pytest.mark.complete),
        # Compiles kernels of its own.
        pytest.param([ACROSS] * 2, [OTHER_ACROSS] * 2, id="along and across", marks=pytest.mark.complete),
        pytest.param(
            [ACROSS, TOWER_ACROSS], [OTHER_ACROSS] * 2, id="across, unlike floors", marks=pytest.mark.complete
        ),
    ],
)
def test_rotating_floors_with_contact_at_both_ends_are_those_of_scipy(left, right):
    """The motions at all samples agree to 1e-8, a hundred times the tolerance of the run, after some ten contacts.

    SciPy's peaks are the largest of 400 places an interval of 0.8 rad at most: 0.5 (0.8 / 798)² = 5e-7 too low. A
    penetration is a part of the closing, and its relative error larger by their ratio.
    """
    acts_across = "eccentricity_along" in left[0]
    plans = [{"plan": side if side[0] != side[1] else side[0]} for side in (left, right)]
    if acts_across:
        study = scene(*plans, stiffness="400 MN/m", records=BOTH)
        *ground, dt = components(40.0)
    else:
        study = scene(*plans, stiffness="400 MN/m")
        motion = pr.read_motion("RSN6-180", window=(1.5, 4.0), pga="0.5 g")
        ground, dt = [motion.acceleration], motion.dt
    results = pr.scan(study, check_fraction=0.0)
    full = [[{"centre": "-0.5 m"} | plan for plan in side] for side in (left, right)]  # the middle of `OTHER`'s face
    peaks, forces, samples = by_scipy(full, ground, dt, 0.006, 200e6)
    run = pr.simulate(study)
    places = np.abs(run["time"].values[:, None] - dt * np.arange(len(samples))).argmin(axis=0)
    names = ("displacement", "floor_rotation", "displacement_across")[: samples.shape[1] // 4]
    moved = np.concatenate([run[name].values[places] for name in names], axis=2).reshape(samples.shape)
    np.testing.assert_allclose(moved, samples, rtol=0.0, atol=1e-8 * np.abs(samples).max())
    if acts_across:
        found = run["ground_acceleration_across"].values[places]
        np.testing.assert_allclose(found, ground[1], rtol=0.0, atol=1e-9 * np.abs(ground[1]).max())
    np.testing.assert_allclose(results["storey_displacement"].values.ravel(), peaks, rtol=2e-6)
    found = results["contact_point_peak_contact_force"].values.ravel()
    assert (forces > 0.0).sum() >= 3
    np.testing.assert_allclose(found, forces, rtol=2e-5)
    shared = [(-6, 8), (-6, 8) if left[0] == left[1] else (-4, 8)]
    assert [str(label) for label in results["contact_point"].values] == [
        f"A {floor} | B {floor} at {across} m" for floor, ends in enumerate(shared, 1) for across in ends
    ]


def rotating_in_opensees(ops, buildings, contact, ground, dt, step):
    """(u, θ) of all floors at the samples: rigid links to springs at centres of stiffness and to the ends of faces.

    ``buildings`` are (masses, springs, plans, of floors and storeys), left to right; ``contact`` is K1, K2 and δ_y of
    both ends, with a gap of 6 mm. By Lagrange's multipliers: by ``Transformation`` springs between linked nodes lag
    behind the iterations.
    """
    ops.wipe()
    ops.model("basic", "-ndm", 2, "-ndf", 3)
    tags = itertools.count(1)

    def node(across, floor=None):
        ops.node(tag := next(tags), 0.0, across)
        if floor is not None:
            ops.rigidLink("beam", floor, tag)
        return tag

    def join(one, other, *materials):
        of_materials = [next(tags) for _ in materials]
        for tag, (kind, *values) in zip(of_materials, materials, strict=True):
            ops.uniaxialMaterial(kind, tag, *values)
        directions = (1, 6)[: len(materials)]
        ops.element("zeroLength", next(tags), one, other, "-mat", *of_materials, "-dir", *directions)

    def in_space(across, end):
        """A node with coordinates in space, as the impact element takes alone, that goes with one in the plane."""
        ops.model("basic", "-ndm", 3, "-ndf", 3)
        ops.node(tag := next(tags), 0.0, across, 0.0)
        ops.equalDOF(end, tag, 1, 2, 3)
        ops.model("basic", "-ndm", 2, "-ndf", 3)
        return tag

    floors = []
    for masses, springs, plans in buildings:
        floors.append([])
        for mass, spring, plan in zip(masses, springs, map(numbers, plans), strict=True):
            floor, stiff = node(plan["centre"]), plan["centre"] + plan["eccentricity"]
            ops.fix(floor, 0, 1, 0)
            ops.mass(floor, mass, mass, mass * plan["gyration"] ** 2)
            foot = node(stiff, floors[-1][-1] if floors[-1] else None)
            if not floors[-1]:
                ops.fix(foot, 1, 1, 1)
            rotational = spring * (plan["torsional_ratio"] * plan["gyration"]) ** 2
            join(foot, node(stiff, floor), ("Elastic", spring), ("Elastic", rotational))
            floors[-1].append(floor)
    for pair, plans in zip(
        zip(*floors, strict=True), zip(*(plans for *_, plans in buildings), strict=True), strict=True
    ):
        faces = np.array([[float(end.removesuffix(" m")) for end in plan["face"]] for plan in plans])
        for across in (faces[:, 0].max(), faces[:, 1].min()):
            left, right = (in_space(across, node(across, floor)) for floor in pair)
            # Of its friction, tangential stiffness and cohesion it has none here.
            ops.element("zeroLengthImpact3D", next(tags), right, left, 1, 0.006, 0.0, 0.0, *contact, 0.0)
    ops.timeSeries("Path", 1, "-dt", dt, "-values", *ground)
    ops.pattern("UniformExcitation", 1, 1, "-accel", 1)
    ops.constraints("Lagrange")
    ops.numberer("Plain")
    ops.system("FullGeneral")
    ops.test("NormUnbalance", 1e-5, 50)
    ops.algorithm("Newton")
    ops.integrator("Newmark", 0.5, 0.25)
    ops.analysis("Transient")
    ops.reset()  # sets the past force and penetration of the impact elements, which their constructor leaves open
    samples = [[[[0.0, 0.0]] * len(side) for side in floors]]
    for _ in range(len(ground) - 1):
        assert ops.analyze(round(dt / step), step) == 0
        samples.append([[[ops.nodeDisp(floor, dof) for dof in (1, 3)] for floor in side] for side in floors])
    return np.array(samples)


def bilinear(beta, e, depth):
    """K1, K2 and δ_y after Muthukumar and DesRoches (2006), for a design penetration ``depth`` of a Hertz spring."""
    whole, lost = beta * depth**0.5, 0.4 * beta * depth**2.5 * (1.0 - e * e)
    return whole + lost / (0.1 * depth**2), whole - lost / (0.9 * depth**2), 0.1 * depth


IMPACTS = {
    "linear": ({"stiffness": "400 MN/m"}, (200e6, 200e6, 1.0)),
    "bilinear": (
        {"stiffness": "4 GN/m^1.5", "restitution": 0.65, "design_penetration": "5 mm"},
        bilinear(2e9, 0.65, 0.005),
    ),
}


@pytest.mark.complete
@pytest.mark.parametrize("law", IMPACTS)
def test_opensees_converges_to_rotating_floors_that_strike_at_both_ends(ops, law):
    """Newmark's error falls with the square of the step, by contacts that begin inside steps somewhat less.

    Each end has half of the stiffness. With K1 = K2 the impact element is a spring; its loops take 56 kJ.
    """
    still = {"damping": 0.0}
    keys, contact = IMPACTS[law]
    study = scene({"plan": [PLAN, TOWER]} | still, {"plan": OTHER} | still, law=law, **keys)
    motion = pr.read_motion("RSN6-180", window=(1.5, 4.0), pga="0.5 g")
    run = pr.simulate(study)
    places = np.abs(run["time"].values[:, None] - motion.times).argmin(axis=0)
    known = np.stack([run[name].values[places] for name in ("displacement", "floor_rotation")], axis=-1)
    other = OTHER | {"centre": "-0.5 m"}
    sides = ([200e3, 150e3], [90e6, 60e6], [PLAN, TOWER]), ([300e3, 200e3], [200e6, 150e6], [other, other])
    assert (run["contact_force"].values > 0.0).any(axis=0).sum() >= 3
    assert (run["row_energy_lost"] > 5e4) == (law == "bilinear")
    peaks = np.abs(known).max(axis=(0, 1, 2))
    ground = motion.acceleration.tolist()
    coarse, fine = (
        np.abs(rotating_in_opensees(ops, sides, contact, ground, motion.dt, step) - known).max(axis=(0, 1, 2))
        for step in (1e-3, 2.5e-4)
    )
    assert (coarse < 2e-2 * peaks).all() and (fine < 0.25 * coarse).all(), (coarse / peaks, fine / peaks)


@pytest.mark.complete
def test_with_eccentricity_across_alone_the_second_component_closes_no_gap():
    """Storeys without eccentricity along the row: w is then a motion of its own. To ten times the tolerance."""
    level = {"eccentricity_along": "0 m", "across_ratio": 0.7}
    one = pr.scan(scene({"plan": PLAN}, {"plan": OTHER}, records=BOTH), check_fraction=0.0)
    two = pr.scan(scene({"plan": PLAN | level}, {"plan": OTHER | level}, records=BOTH), check_fraction=0.0)
    assert int(one["impact_count"].sum()) > 4
    for name in ("peak_closing", "storey_displacement", "storey_acceleration", "peak_contact_force", "impulse"):
        np.testing.assert_allclose(two[name].values, one[name].values, rtol=1e-8, err_msg=name)


def test_both_components_are_cut_scaled_and_reversed_alike():
    """Against rotation on the compass; a scaled motion, its reverse and its tail."""
    along, across, _ = components(40.0)
    study = scene({"plan": ACROSS}, {}, records=BOTH | {"tail": "1 s", "window": ["1.5 s", "4 s"]})
    (motion,) = (one.scaled_to("0.5 g") for one in motions_of(study))
    still = np.zeros(motion.acceleration.size - along.size)
    # The rotation's weights are the same numbers; rounding of the factor alone differs.
    np.testing.assert_allclose(motion.drive, np.concatenate([along + 1j * across, still]), rtol=1e-12, atol=1e-14)
    np.testing.assert_array_equal(motion.reversed().drive, -motion.drive)
    np.testing.assert_array_equal(motion.scaled(2.0).across, 2.0 * motion.across)
    assert motion.digest != replace(motion, across=None).digest


def test_an_aftershock_follows_in_both_components():
    first = Motion("a", np.array([1.0, -2.0, 0.0]), 0.01, {"factor": 1.0}, across=np.array([0.5, 3.0, 0.0]))
    after = Motion("b", np.array([0.0, 4.0, 0.0]), 0.01, {"factor": 1.0}, across=np.array([0.0, -1.0, 0.0]))
    both = followed_by(first, after, 0.02, 0.25, 0.0)  # the factor is 0.25 × 2 / 4
    np.testing.assert_array_equal(both.across, [0.5, 3.0, 0.0, 0.0, 0.0, -0.125, 0.0])
    np.testing.assert_array_equal(both.acceleration, [1.0, -2.0, 0.0, 0.0, 0.0, 0.5, 0.0])


def test_a_corner_strikes_with_its_effective_mass():
    """One elastic blow at a distance d: impulse 2 v / (1/m + d²/I), of a stiff spring within a soft building.

    Both contact points stand 2 mm apart, 2.5e-4 of the distance, and the building's own springs take 1e-6.
    """
    corner = {"face": ["8.999 m", "9.001 m"], "eccentricity": "0 m", "gyration": "1e4 m", "torsional_ratio": 1.0}
    tower = storeyed("A", ["100 t"], "1 kN/m", ["3 m"], initial_velocity="1 m/s", damping=0.0, plan=STRAIGHT)
    slab = storeyed("B", ["1e9 t"], "1 kN/m", ["3 m"], damping=0.0, plan=corner)
    records = {"generated": [{"kind": "ricker", "pga": "0.001 g", "period": "0.5 s"}], "names": None}
    study = parse_scene(scene_text(tower, slab, law="linear", gap="1 mm", stiffness="10 GN/m", records=records))
    effective = 1.0 / (1.0 / 100e3 + (9.0 - 1.0) ** 2 / (25.0 * 100e3))
    assert pr.simulate(study)["impulse"].item() == pytest.approx(2.0 * effective, rel=1e-3)


@pytest.mark.parametrize(
    ("plan", "axis"),
    [(PLAN, "plan.eccentricity"), ([PLAN, TOWER], "plan.2.eccentricity")],
    ids=["one", "of each floor"],
)
def test_scenes_with_a_plan_are_written_back_and_their_numbers_are_axes(plan, axis):
    study = scene({"plan": plan}, {}, grid={f'"building.A.{axis}"': ["0 m", "1 m", "2 m"]})
    assert parse_scene(study.to_toml()) == study
    results = pr.scan(study, check_fraction=0.0)
    assert len(set(results["peak_closing_free"].values.ravel().tolist())) == 3
    np.testing.assert_array_equal(results[f"building.A.{axis}"], [0.0, 1.0, 2.0])


def test_floors_whose_faces_share_nothing_do_not_meet(says):
    study = scene({"plan": [PLAN, TOWER | {"face": ["9 m", "10 m"], "centre": "9.5 m"}]}, {"plan": OTHER})
    assert [(point.left_floor, point.across) for point in study.interfaces[0].points] == [(1.0, -6.0), (1.0, 8.0)]
    says(level_notes(study)["A | B"])


def test_in_elevation_both_ends_of_a_face_are_one_point():
    """Contact at either end, with the larger of both forces; by the counts and forces of the dataset."""
    records = RECORD | {"polarity": ["as recorded", "reversed"]}
    case = row_case(pr.scan(scene({"plan": [PLAN, TOWER]}, {}, gap="45 mm", records=records), check_fraction=0.0))
    columns = (case.results[f"contact_point_{name}"] for name in ("impact_count", "peak_contact_force"))
    counts, forces = (column.values.reshape(2, 2, 2) for column in columns)  # polarities, floors, ends
    assert (counts > 0).tolist() == [[[False, False], [True, True]], [[True, False], [True, True]]]
    assert [(one.left_floor, one.touch.contact) for one in case.meetings] == [
        (floor + 1.0, (counts[:, floor] > 0).any(axis=1).mean()) for floor in (0, 1)
    ]
    largest = forces.max(axis=2)
    assert [one.touch.force for one in case.meetings] == [largest[1, 0], np.median(largest[:, 1])]
    assert len(case.points) == 4


def test_a_report_says_which_buildings_rotate_and_move_across(says):
    tables = {"building": [{"name": "A", "plan": ACROSS}, {"name": "B", "plan": [PLAN, TOWER]}, {"name": "C"}]}
    says("\n".join(_of_storeys(tables)))


def test_every_answer_on_a_building_whose_floors_rotate_says_that_it_is_of_the_centres(tmp_path):
    study = scene({"plan": PLAN}, {}).replace(damage=[pr.DamageState("contents", acceleration="1 g")])
    run = pr.scan(study, check_fraction=0.0)
    words = "A: its floors rotate; displacements, drifts and floor accelerations are those of their centres of mass"
    answers = json.loads(pr.simulate(study).attrs["notes"]), pr.assess(run).notes
    answers += json.loads(pr.damage(run).attrs["assumptions"]), pr.export(run, "pelicun", tmp_path / "demands").notes
    assert [sum(note.startswith(words) for note in notes) for notes in answers] == [1, 1, 1, 1]


def test_what_does_not_go_with_rotating_floors_is_refused(says):
    says(refusal(scene, {"plan": PLAN | {"face": ["3 m", "1 m"], "gyration": "0 m"}}, {}))
    says(refusal(scene, {"plan": PLAN | {"centre": "20 m"}}, {}))
    says(refusal(scene, {"plan": PLAN | {"across_ratio": 0.8}}, {}))
    says(refusal(scene, {"plan": ACROSS}, {}))
    says(refusal(scene, {"plan": ACROSS}, {"ground_delay": "0.1 s"}, records=BOTH))
    says(refusal(scene, {"plan": [PLAN] * 3}, {}))
    says(refusal(scene, {"plan": [ACROSS, TOWER]}, {}, records=BOTH))
    listed = scene({"plan": [PLAN, TOWER]}, {}).to_toml()
    says(refusal(parse_scene, listed, "scene", ["building.A.plan.gyration=5 m"]))
    says(refusal(scene, {"plan": [PLAN, TOWER | {"gyration": "-1 m"}]}, {}))
    aside = {"plan": [PLAN, TOWER | {"face": ["9 m", "10 m"], "centre": "9.5 m"}]}
    says(
        refusal(
            scene, aside, {"plan": OTHER}, contact=[{"left": f"storey {n}", "right": f"storey {n}"} for n in (1, 2)]
        )
    )
    strong = {"plan": PLAN, "storey_strengths": "1 MN"}
    says(refusal(scene, strong, {}, effects={"inelastic_storeys": {}}))
    says(refusal(scene, {"plan": PLAN}, {"plan": OTHER | {"face": ["12 m", "20 m"]}}))
    says(refusal(scene, {"plan": PLAN}, {"storey_heights": ["4 m", "4 m"]}))
    says(refusal(scene, {"plan": PLAN}, {}, effects={"p_delta": {}}))
    says(refusal(scene, {"plan": PLAN}, {}, link_damping="1 kN s/m"))
    forces = {"penetration": ["0 mm", "10 mm"], "force": ["0 kN", "450 kN"]}
    study = scene({"plan": PLAN}, {}, law="tabulated", stiffness=None, restitution=None, table=forces)
    says(refusal(pr.scan, study))
