"""Runs of pairs and rows have one shape; every kind of scene is read back, screened, and run as it is scanned."""

from math import inf
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scenes import BOTH, FRAME, TWO_AND_A_WALL, rigid, scene_text, single, storeyed
from sweeps import sweep

import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.row_grid import model_of
from pounding_risk.figures.simulate import parting
from pounding_risk.questions.simulate import sheet
from pounding_risk.render.terminal import print_sheet
from pounding_risk.results.run_labels import CONTACTS, HISTORIES
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import COMPLETE
from pounding_risk.studies.row_trace import closing_at, grounds_at

G = 9.80665
PAIR = scene_text(
    FRAME,
    single("hall", "82.60 t", "0.4 s", height="6 m"),
    name="Two single masses",
    gap="2 mm",
    records={"window": ["1 s", "3 s"]},
    grid={"gap": ["2 mm", "5 mm"], "yield_force": ["300 kN", "inf"], "contact_model": ["viscous_elastoplastic"]},
)
WAVE = {"wave_passage": {"velocity": "500 m/s", "distance": "9 m"}}
WALL = scene_text(FRAME, rigid(), law="linear", gap="2 mm", records={"window": ["1 s", "3 s"]}, effects=WAVE)
CHOICES = {
    "pair": (PAIR, {"gap": 0.005, "yield_force": 3e5, "law": "viscous_elastoplastic"}),
    "wall under a wave": (WALL, {}),
    "row": (TWO_AND_A_WALL, {"gap": 0.009, "pga": 0.3 * G}),
}


@pytest.fixture(scope="module", params=sweep(CHOICES, "pair", "row"))
def scene_and_run(request):
    text, choice = CHOICES[request.param]
    study = parse_scene(text)
    return study, pr.simulate(study, **choice)


@pytest.fixture(scope="module")
def pair():
    return pr.simulate(parse_scene(PAIR), gap=0.005, yield_force=3e5, law="viscous_elastoplastic")


def test_every_run_has_the_same_names_and_dimensions(scene_and_run):
    study, run = scene_and_run
    for name in ("displacement", "velocity", "relative_displacement", "contact_force", "contact_impulse_so_far"):
        assert run[name].dims == HISTORIES[name][0], name
    for name, (dims, unit, words) in HISTORIES.items():
        if name in run:
            assert (run[name].dims, run[name].units, run[name].long_name) == (dims, unit, words)
    assert [name for name in CONTACTS if f"contact_{name}" not in run] == (
        [] if "energy_ground" in run else [name for name in CONTACTS if name not in FACTS_OF_ROWS]
    )
    assert run.attrs["dataset_version"] == 2
    assert run["interface"].values.tolist() == list(study.interface_names)
    assert run["contact_point_interface"].values.tolist() == [point.interface for point in study.points]
    assert run["contact_point_yield_force"].dims == ("contact_point",) and run["interface_gap"].dims == ("interface",)
    assert set(run["contact_place"].values) <= set(run["contact_point"].values)
    still = [building.is_rigid for building in study.buildings]
    np.testing.assert_array_equal(np.isnan(run["displacement"].isel(time=-1)).all("storey"), still)
    np.testing.assert_array_equal(run["building_storeys"] == 0, still)


FACTS_OF_ROWS = ("start", "end", "approach_speed", "peak_force", "impulse")


def test_attributes_are_alike():
    runs = [pr.simulate(parse_scene(text), **choice) for text, choice in CHOICES.values()]
    keys = [set(run.attrs) - {"unused_keys"} for run in runs]
    assert keys[0] == keys[1] == keys[2]
    assert (runs[0].attrs["gap"], runs[0].attrs["yield_force"]) == (0.005, 3e5)
    # The gap of the interface that the grid varies, and the yield force of the first one.
    assert (runs[2].attrs["gap"], runs[2].attrs["yield_force"]) == (0.009, 9e5)
    assert runs[2]["interface_gap"].values.tolist() == [0.009, 0.003]


def test_of_several_amplitudes_the_one_of_assess_is_run_and_named():
    """That of [records] where the grid has it, or the largest."""
    text = scene_text(FRAME, rigid(), law="linear", gap="2 mm", grid={"pga": ["0.1 g", "0.2 g", "0.3 g"]})
    short = ['records.window=["1 s", "3 s"]']
    for own, level in (([], 0.3), (['records.pga="0.1 g"'], 0.1)):
        run = pr.simulate(parse_scene(text, overrides=[*short, *own]))
        assert run.attrs["pga"] == pytest.approx(level * G)
        assert f"Of the amplitudes 0.1 g, 0.2 g, 0.3 g, {level} g is run" in run.attrs["notes"]
    assert "is run" not in pr.simulate(parse_scene(text, overrides=short), pga=0.2 * G).attrs["notes"]


PASSING = '[effects]\nwave_passage = {velocity = "500 m/s", distance = "9 m"}\n'


@pytest.mark.parametrize("effects", ["", pytest.param(PASSING, marks=pytest.mark.complete)], ids=["", "a wave"])
def test_either_solver_gives_the_same_histories(effects):
    """Two single masses by the solver of pairs and by that of rows, which integrates in another way."""
    study = parse_scene(PAIR + effects).updated(rtol=1e-10)
    solvers = (study.updated(is_row=is_row) for is_row in (False, True))
    runs = [pr.simulate(scene, law="viscous_elastoplastic", yield_force=3e5) for scene in solvers]
    nodes = np.intersect1d(*(run["time"].values for run in runs))
    assert nodes.size > 150 and runs[0].sizes["contact"] == runs[1].sizes["contact"] >= 3
    one, other = (run.sel(time=nodes) for run in runs)
    grounds = [name for name in one.data_vars if "ground" in name and not name.startswith("energy")]
    assert len(grounds) == (4 if effects else 2) and set(grounds) <= set(other.data_vars)
    moved = ("displacement", "velocity", "relative_displacement", "absolute_displacement")
    for name in (*moved, "contact_impulse_so_far", *grounds):
        assert one[name].dims == other[name].dims
        scale = float(np.abs(one[name]).max())
        np.testing.assert_allclose(other[name], one[name], atol=1e-6 * scale, rtol=0.0, err_msg=name)
    for name in FACTS_OF_ROWS:
        np.testing.assert_allclose(runs[1][f"contact_{name}"], runs[0][f"contact_{name}"], rtol=1e-5, err_msg=name)
    assert set(runs[0].coords) == set(runs[1].coords)


def test_relative_displacement_is_what_closes_the_gap(scene_and_run):
    """It is the peak in the outputs, and a contact is where it is larger than the gap."""
    _, run = scene_and_run
    closing = run["relative_displacement"].values
    point = run["contact_point_interface"].values
    assert (closing.max(axis=0) <= run["peak_closing"].values[point] * (1.0 + 1e-12)).all()
    gaps = run["interface_gap"].values[point]
    assert (run["contact_force"].values[closing < gaps - 1e-12] == 0.0).all()
    assert (run["contact_force"].values > 0.0).sum() > 20
    assert (closing[run["contact_force"].values > 0.0] > 0.0).all()


def test_the_impulse_so_far_is_that_of_the_force(pair):
    """Its end is the output; before, the trapezoidal rule, whose error is some (Δ / T)² of a contact."""
    impulse, force = (pair[name].values[:, 0] for name in ("contact_impulse_so_far", "contact_force"))
    assert impulse[-1] == pytest.approx(float(pair["impulse"][0]), rel=1e-12)
    steps = 0.5 * (force[1:] + force[:-1]) * np.diff(pair["time"].values)
    np.testing.assert_allclose(impulse[1:], np.cumsum(steps), atol=0.02 * impulse[-1])
    assert impulse[-1] == pytest.approx(float(pair["contact_impulse"].sum()), rel=1e-12)


def test_a_run_is_printed_by_what_it_has(scene_and_run, capsys):
    """Of one interface every output with its meaning, of one contact point every contact."""
    study, run = scene_and_run
    print_sheet(sheet(run))
    told = capsys.readouterr().out
    assert all(building.name in told for building in study.buildings)
    if run.sizes["interface"] == 1:
        assert f"{int(run['impact_count'][0])}  contacts, each from touch to parting" in told
        assert f"\n{run.sizes['contact']:7} " in told
    else:
        assert all(str(name) in told for name in run["interface"].values)


def test_the_figure_has_a_panel_for_what_the_run_has(scene_and_run):
    _, run = scene_and_run
    drawn = figures.simulation_figure(run, note="a note")
    panels = [axis.get_ylabel().split("\n")[0].split(" [")[0] for axis in drawn.axes]
    if run.sizes["contact_point"] == 1:
        assert panels == ["ground", "relative", "contact", "energy"]
        bands = [patch for patch in drawn.axes[1].patches if patch.get_label() in ("", "in contact")]
        assert len(bands) == run.sizes["contact"]
        drawn.draw_without_rendering()
        for axis in drawn.axes[1::2]:
            assert axis.get_legend().get_window_extent().y0 >= axis.get_window_extent().y1, "it covers no line"
    else:
        assert panels == ["ground", "roof relative to", "contact", "height"]
    assert len(drawn.axes[0].lines) == (2 if "ground_widening" in run else 1)
    assert "a note" in drawn.get_supxlabel()
    times = [axis.get_xlim() for axis in drawn.axes if not axis.get_ylabel().startswith("height")]
    assert set(times) == {(run["time"].values[0], run["time"].values[-1])}


def test_two_runs_of_a_row_are_compared_where_the_force_is_largest():
    study = parse_scene(TWO_AND_A_WALL, overrides=["interface.contact_model=viscous_elastoplastic"])
    runs = [pr.simulate(study, pga=0.3 * G, yield_force=force) for force in ("inf", "600 kN")]
    drawn = figures.comparison_figure(runs)
    strongest = int(np.max([run["contact_force"].max("time") for run in runs], axis=0).argmax())
    assert str(runs[0]["contact_point"].values[strongest]) in drawn.get_supxlabel()
    first = float(runs[1]["first_yield_time"].min())
    assert parting(*runs) == pytest.approx(first, abs=0.02)
    peaks = [1e3 * float(np.abs(run["relative_displacement"].isel(contact_point=strongest)).max()) for run in runs]
    assert f"from {peaks[0]:.2f} to {peaks[1]:.2f} mm" in drawn.get_suptitle()


def test_the_ground_closes_and_opens_the_gaps_of_a_row():
    """Each ground is that of its left neighbour later by the lag; what closes a gap counts the widening."""
    row_of_three = scene_text(
        storeyed("a", "70 t", "40 MN/m", storeys=3),
        single("b", "150 t", "0.25 s", height="9 m"),
        rigid("c", height="9 m"),
        effects=WAVE,
        records={"window": ["1 s", "4 s"]},
    )
    study, lag = parse_scene(row_of_three), 9.0 / 500.0
    (motion,) = motions_of(study)
    row = model_of(study).row(motion.dt)
    time = np.linspace(lag, 2.99, 400)
    grounds, before = (grounds_at(row, motion.acceleration, moments) for moments in (time, time - lag))
    sampled = [np.interp(time - late * lag, motion.times, motion.acceleration, left=0.0) for late in range(3)]
    scale = np.abs(motion.acceleration).max()
    np.testing.assert_allclose(grounds["building_ground_acceleration"].T, sampled, atol=1e-12 * scale)
    widening = grounds["ground_widening"]
    np.testing.assert_allclose(widening[:, 1], before["ground_widening"][:, 0], atol=1e-12 * np.abs(widening).max())
    # ẅ is a_right − a_left: its second difference over h is off by some h² of the fourth derivative, and by corners.
    step = time[1] - time[0]
    bend = np.diff(widening[:, 0], 2) / step**2
    assert np.abs(bend - (sampled[1] - sampled[0])[1:-1]).mean() < 0.02 * scale
    moved = np.random.default_rng(1).normal(size=(time.size, 4))
    closing = closing_at(row, moved, grounds)
    np.testing.assert_allclose(closing[:, 0], moved[:, 2] - moved[:, 3] - widening[:, 0], atol=1e-15)
    np.testing.assert_allclose(closing[:, 1], moved[:, 3] - widening[:, 1], atol=1e-15)


def test_energies_begin_with_that_of_the_initial_state():
    """½ m v² is held at first, nothing is damped; at the end the dampers have all of it that is left nowhere else."""
    scene = scene_text(
        rigid("A"),
        single("B", "468 t", "0.269 s", damping=0.02, initial_velocity="0.23 m/s", initial_displacement="3 mm"),
        gap="21 mm",
        records={"window": ["0 s", "6 s"], "pga": "0.1 g"},
    )
    run = pr.simulate(scene)
    stiffness = 468e3 * (2.0 * np.pi / 0.269) ** 2
    first = 0.5 * 468e3 * 0.23**2 + 0.5 * stiffness * 0.003**2
    assert float(run["energy_held"][0]) == pytest.approx(first, rel=1e-12)
    assert float(run["energy_damping"][0]) == 0.0
    # Dampers take 2 ζ ω m ∫ v² dt: by the trapezoidal rule on samples of a 27th of the period, some per cent.
    speed = run["velocity"].sel(building="B").values[:, 0]
    taken = 2.0 * 0.02 * (2.0 * np.pi / 0.269) * 468e3 * np.trapezoid(speed**2, run["time"].values)
    assert float(run["energy_damping"][-1]) == pytest.approx(taken, rel=0.02)


CAPPED = {"law": "viscous_elastoplastic", "gap": "2 mm", "records": {"window": ["0 s", "5 s"], "scale": 2.0}}
A = storeyed("A", ["40 t", "40 t"], "60 MN/m", ["4 m", "3 m"])
B = storeyed("B", ["60 t", "60 t"], "120 MN/m", ["3 m", "3 m"])


def row(a=None, b=None, **interface):
    """A whose floor 1 strikes B's columns, and B whose floors strike those of A."""
    sides = [side | ({"column_strength": force} if force else {}) for side, force in ((A, a), (B, b))]
    return parse_scene(scene_text(*sides, **CAPPED | interface))


def test_each_contact_is_capped_by_the_columns_that_it_strikes():
    """Oracle: the strengths themselves. The law holds the force at its cap: 1e-9 is rounding alone."""
    study = row("50 kN", "90 kN", column_yield_force="70 kN")
    struck = [study.buildings[study.struck_building(point)].name for point in study.points]
    assert struck == ["A", "B", "A"] and study.point_yield_forces() == (5e4, 9e4, 5e4)
    peaks = pr.scan(study)["contact_point_peak_contact_force"].values.ravel()
    assert peaks == pytest.approx([5e4, 9e4, 5e4], rel=1e-9)
    free = pr.scan(row())["contact_point_peak_contact_force"].values.ravel()
    assert (free > peaks * 1.01).all()


def test_one_run_states_the_yield_forces_of_columns_beside_that_of_floors():
    head = sheet(pr.simulate(row("50 kN", "90 kN")))[0]
    stated = {name: cell if isinstance(cell, str) else cell["text"] for name, cell in head["rows"]}
    assert stated["yield force"] == "∞" and stated["of columns"] == "50 kN, 90 kN"
    shared = sheet(pr.simulate(row()))[0]
    assert "∞" in str(dict(shared["rows"])["of columns"])


def test_equal_strengths_are_the_force_of_the_interface_to_the_bit():
    one, other = pr.scan(row("50 kN", "50 kN")), pr.scan(row(column_yield_force="50 kN"))
    assert all(one[name].values.tobytes() == other[name].values.tobytes() for name in one.data_vars)


def test_where_one_building_has_none_the_interface_counts():
    study = row(a="50 kN", column_yield_force="70 kN")
    assert study.point_yield_forces() == (5e4, 7e4, 5e4) and row(b="90 kN").point_yield_forces() == (inf, 9e4, inf)
    assert study.at(0) == study and parse_scene(study.to_toml()) == study


def test_a_wall_and_a_single_mass_have_the_force_of_the_interface():
    """A wall is met like a floor at any height; a taller mass is struck at its column."""
    mass = parse_scene(scene_text(B, single("C", "90 t", "0.4 s", height="9 m"), **CAPPED, column_yield_force="70 kN"))
    assert [mass.struck_building(point) for point in mass.points] == [1] and mass.point_yield_forces() == (7e4,)
    wall = parse_scene(scene_text(A, {"name": "wall", "rigid": True, "height": "9 m"}, **CAPPED))
    assert {wall.struck_building(point) for point in wall.points} == {None}


def test_generated_storeys_have_it_and_validate_tells_each(says):
    tall = {"name": "G", "typology": "masonry", "height": "10 m", "storeys": 3, "floor_mass": "90 t"}
    study = parse_scene(scene_text(tall | {"column_strength": "300 kN"}, B | {"column_strength": "90 kN"}, **CAPPED))
    assert [building.column_strength for building in study.buildings] == [3e5, 9e4]
    says("\n".join(line for line in str(validate(study)).splitlines() if "contact points" in line))


@pytest.mark.complete
def test_advise_varies_the_strengths_of_buildings_as_forces():
    """With 50 kN of the buildings or of the interface every number of the advice is one."""
    one, other = pr.advise(row("50 kN", "50 kN")), pr.advise(row(column_yield_force="50 kN"))
    assert [repr(vars(mine)) for mine in one.influences] == [repr(vars(same)) for same in other.influences]  # NaN too


RECORDS = {"names": ["RSN6-180", "RSN6-270"], "window": ["1 s", "4 s"], "pga": "0.5 g", "polarity": BOTH}
GAPS = {"gap": ["0 mm", "10 mm", "1 m"]}
FORCES = {"yield_force": ["300 kN", "3 MN", "inf"]}
TWO_LAWS = {"contact_model": ["jankowski", "viscous_elastoplastic"]}
NO_FORCE = {"stiffness": None, "yield_force": "300 kN"}
ACROSS = {"wave_passage": {"velocity": "400 m/s", "distance": "30 m"}}
YIELDING = {"permanent_set": {}, "unloading_stiffness": {"ratio": 1.5}}
YIELDING |= {"strain_rate": {"code": "mc2010", "length": "0.6 m"}}
MASSES = (
    single("left", "500 t", "0.5 s", floor_length="15 m"),
    single("right", "800 t", "0.31 s", floor_length="24 m"),
)
THREE = (*MASSES, single("last", "300 t", "0.4 s"))
MODELS = [
    {"gap": "10 mm", "contact_model": model, "stiffness": "2.75e9 N/m^1.5", "restitution": 0.6}
    for model in ("jankowski", "viscous_elastoplastic")
]
SLIPPING = {"link_stiffness": "20 MN/m", "link_strength": "60 kN"}
BUMPER = {"penetration": ["0 mm", "10 mm", "20 mm"], "force": ["0 kN", "100 kN", "600 kN"]}
BUMPER |= {"unloading": ["0 kN", "0 kN", "600 kN"]}
MOVING = {"initial_displacement": "-4 mm", "initial_velocity": "0.1 m/s"}


def kind(*buildings: Any, grid: Any = None, **keys: Any) -> str:
    """A scene of this kind, along gaps at least."""
    return scene_text(*(buildings or MASSES), records=RECORDS, grid=GAPS | (grid or {}), **keys)


# A scene, and the choice of a run that is not the scene's own.
SCENES: dict[str, tuple[str, dict[str, Any]]] = CHOICES | {
    "two laws": (kind(grid=FORCES | TWO_LAWS, restitution="concrete"), {"law": "jankowski"}),
    "no cap": (kind(grid=FORCES, law="linear", stiffness="5e8 N/m"), {"yield_force": 3e5}),
    "jumps": (
        kind(grid={"contact_model": ["merged", "stereomechanical"]}, law="merged", **NO_FORCE),
        {"law": "stereomechanical"},
    ),
    "colliding floors": (kind(law="distributed_mass", **NO_FORCE | {"restitution": None}), {}),
    "effects of yielding": (
        kind(grid=FORCES, law="viscous_elastoplastic", effects=YIELDING | ACROSS),
        {"yield_force": 3e5},
    ),
    "a wave under jumps": (kind(law="merged", effects=ACROSS, **NO_FORCE), {}),
    "several models": (kind(*THREE, interfaces=MODELS, grid=FORCES), {"yield_force": 3e5}),
    "a table": (kind(law="tabulated", table=BUMPER, **NO_FORCE | {"restitution": None}), {}),
    "moving at first": (
        kind(
            MASSES[0] | MOVING,
            MASSES[1] | {"initial_velocity": "-0.05 m/s"},
            grid=FORCES | {"contact_model": ["viscous_elastoplastic", "stereomechanical"]},
        ),
        {"law": "viscous_elastoplastic"},
    ),
    "links that slip": (kind(*THREE, law="linear", **SLIPPING), {}),
    "jumps in a row": (kind(*THREE, law="stereomechanical", **NO_FORCE), {}),
    "a row under a wave": (kind(storeyed("a", "70 t", "40 MN/m", storeys=3), rigid(height="9 m"), effects=ACROSS), {}),
}
EVERY_RUN = {*CHOICES, "links that slip"}  # no case of theirs is known without a run of its own
LONG = ("wall under a wave", "jumps in a row", "a row under a wave")  # of which kernels are compiled


@pytest.fixture(scope="module", params=sweep(SCENES, *(name for name in SCENES if name not in LONG)))
def scanned(request):
    """The scene and its scan."""
    study = parse_scene(SCENES[request.param][0])
    return study, pr.scan(study, check_fraction=0.0, workers=1)


def test_it_is_read_back(scanned):
    study, _ = scanned
    assert scene_of(study.resolved()) == parse_scene(study.to_toml()) == study == study.updated(rtol=study.rtol)


def test_screening_leaves_no_trace(scanned, request):
    """Energy is closed over the buildings that have been solved together, which are more without."""
    study, found = scanned
    every = pr.scan(study, screening=False, check_fraction=0.0, workers=2)
    assert (found["status"] == COMPLETE).all() and every["simulated"].all()
    assert found["simulated"].all() == (request.node.callspec.params["scanned"] in EVERY_RUN)
    told = ["simulated", "energy_residual"] if study.is_row else ["simulated"]
    one, other = (each.drop_vars(told).assign_attrs(options="", parts="") for each in (found, every))
    xr.testing.assert_identical(one, other)


def test_a_run_is_that_of_the_scan(scanned, request):
    """Each output of the case, to the bit, with its unit, long name and type."""
    study, whole = scanned
    run = pr.simulate(study, **SCENES[request.node.callspec.params["scanned"]][1])
    place = {axis: run.attrs[axis] for axis in ("gap", "yield_force", "pga") if axis in whole.dims}
    case = whole.sel(place, method="nearest").sel(contact_model=run.attrs["contact_model"]).isel(record=0, polarity=0)
    outputs = [name for name in case.data_vars if not name.endswith("_free") and "period" not in case[name].dims]
    outputs = [name for name in outputs if name not in ("status", "simulated")]
    assert set(outputs) <= set(run.data_vars) and len(outputs) > 20
    for name in outputs:
        np.testing.assert_array_equal(run[name].values, case[name].values, err_msg=name)
        assert run[name].dtype == case[name].dtype, name
        assert run[name].attrs == {key: case[name].attrs[key] for key in ("units", "long_name")}, name
    assert run["impact_count"].values.max() > 0


ALIKE = ("peak_closing", "peak_opening", "peak_penetration", "peak_contact_force", "impulse", "contact_time")
ALIKE += ("impact_count", "yield_count", "permanent_set", "energy_plastic", "energy_viscous")
ALIKE += ("peak_displacement", "peak_storey_shear", "peak_floor_acceleration")


@pytest.mark.parametrize("name", ["two laws", "no cap", "jumps", "a table", "moving at first"])
def test_the_solver_of_rows_gives_a_pair_what_its_own_does(name):
    """They share laws and tableau, and neither flight nor events: a thousand times the tolerance of both.

    Corners of a table are stepped over, where an error of a step is of the first order: ten times that of other laws.
    """
    study = parse_scene(SCENES[name][0]).updated(rtol=1e-12)
    pair, row = (pr.scan(study.updated(is_row=is_row), check_fraction=0.0).isel(gap=1) for is_row in (False, True))
    assert pair["impact_count"].min() >= 2 and pair["impact_count"].sum() > 10
    for output in ALIKE:
        np.testing.assert_allclose(row[output], pair[output], rtol=1e-9, atol=1e-12, err_msg=output)
    np.testing.assert_allclose(row["first_impact_time"], pair["first_impact_time"], rtol=0.0, atol=1e-12)
