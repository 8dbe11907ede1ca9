"""The key `isolation`: its faults, what it makes of a building, and what other questions say of such a building."""

import json
import re
from math import inf, pi, sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from axes import equals_the_loop
from scenes import rigid, scene_text, single, storeyed
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.demands import is_linear
from pounding_risk.assessment.hazard import HazardSpectrum
from pounding_risk.assessment.intensities import resolved_intensity, shaking_of
from pounding_risk.assessment.separations.table import code_table
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.motions.levels import read_measure
from pounding_risk.questions.modes import answer, sheet
from pounding_risk.results.opened import Results
from pounding_risk.scene.notes import level_notes
from pounding_risk.scene.reader import parse_scene

G = 9.80665  # m/s²
PAGE = Path(__file__).resolve().parents[2] / "docs/scenes.md"
LEAD = {"slab_mass": "600 t", "height": "1.5 m", "strength": "900 kN", "stiffness": "5 MN/m", "damping": "200 kN s/m"}
SLIDER = {"slab_mass": "600 t", "height": "1.5 m", "friction": 0.05, "radius": "2 m"}
SOIL = {"shear_wave_velocity": "200 m/s", "radius": "8 m"}


def text(isolation: dict[str, Any], building: dict[str, Any] | None = None, **tables: Any) -> str:
    above = storeyed("A", ["500 t", "400 t"], ["800 MN/m", "600 MN/m"], "4 m") if building is None else building
    given = {"gap": "40 mm", "records": {"window": ["0 s", "6 s"], "pga": "0.5 g"}} | tables
    return scene_text(rigid(height="1.5 m"), above | {"isolation": isolation}, **given)


def blocks() -> list[str]:
    """The scene of the page, and the wall that gives in place of its rigid one."""
    return [one for one in re.findall(r"^```toml\n(.*?)^```", PAGE.read_text("utf-8"), re.M | re.S) if "moat" in one]


@pytest.mark.complete
def test_a_wall_that_gives_takes_the_forces_that_the_page_says():
    """Largest forces of contact and accelerations of the slab at a gap of 60 mm, to the digits printed there."""
    block, wall = blocks()
    rigid, rest = block.index("[[building]]"), block.index("[[building]]", block.index('name = "moat"'))
    given, effects = wall.split("[effects.")
    found = []
    for text in (block, f"{block[:rigid]}{given}{block[rest:]}\n[effects.{effects}"):
        run = pr.scan(parse_scene(text, "scene", ['interface.gap="60 mm"']), check_fraction=0.0)
        slab = run["peak_floor_acceleration"].sel(building="hospital")
        found += [round(float(run["peak_contact_force"].max()) / 1e6), round(float(slab.max()))]
    said = re.search(
        r"is then (\d+) MN in place of (\d+) MN.*?acceleration (\d+) m/s² in place of (\d+)",
        PAGE.read_text("utf-8"),
        re.S,
    )
    assert said is not None and [int(said[place]) for place in (2, 4, 1, 3)] == found


@pytest.mark.complete
def test_the_scene_of_the_page_runs_yields_and_strikes_the_wall_with_its_slab_alone():
    block, _ = blocks()
    run = pr.simulate(parse_scene(block), record="RSN6-180")
    assert int(run["contact_point_impact_count"].item()) > 0  # one contact point alone, or item() refuses
    assert run["contact_point_level"].item() == 1.5
    isolators, *frame = run["storey_ductility"].sel(building="hospital").values
    assert isolators > 1.0 and np.isnan(frame).all()  # which never yields


def test_its_numbers_are_those_of_the_law():
    lead = parse_scene(text(LEAD)).buildings[1]
    assert lead.masses == (6e5, 5e5, 4e5) and lead.levels == (1.5, 5.5, 9.5)
    assert lead.stiffnesses[0] == 5e6 + 900e3 / 1e-3 and lead.isolator_law.limit == pytest.approx(905e3, rel=1e-15)
    slider = parse_scene(text(SLIDER)).buildings[1].isolator_law
    assert slider[:2] == (pytest.approx(0.05 * 1.5e6 * G, rel=1e-15), pytest.approx(1.5e6 * G / 2.0, rel=1e-15))
    linear = chain_of(parse_scene(text(LEAD | {"strength": "0 N"})).buildings[1])
    assert linear.shear[0] == 5e6 and np.isinf(linear.strength).all() and np.all(linear.hardening == 1.0)


def test_the_period_while_they_yield_is_that_of_a_rigid_mass_on_them():
    """2π √(R / g) with what stands on the slab 1e4 times as stiff as now: 1e-6 of the period is flexibility."""
    stiff = storeyed("A", ["500 t", "400 t"], "8e12 N/m", "4 m")
    assert parse_scene(text(SLIDER, stiff)).buildings[1].isolated_period == pytest.approx(
        2.0 * pi * sqrt(2.0 / G), rel=1e-6
    )


def test_intensities_take_the_period_while_they_yield():
    """2π √(R / g) of a hazard's curve and of levels at 1 T; a dataset without it is told how to have it."""
    stiff, known = storeyed("A", ["500 t", "400 t"], "8e12 N/m", "4 m"), 2.0 * pi * sqrt(2.0 / G)
    levels = {"measure": "sa", "period": "1 T", "of": "A", "levels": ["0.1 g"]}
    records = {"window": ["0 s", "3 s"], "pga": None, "intensity": levels}
    assert parse_scene(text(SLIDER, stiff, records=records)).grid.measure.period == pytest.approx(known, rel=1e-6)
    results = pr.scan(parse_scene(text(SLIDER, stiff, records=records | {"intensity": None, "pga": "0.3 g"})))
    spectra = HazardSpectrum(np.array([0.2, 4.0]), np.array([0.1, 0.001]), np.array([[1.0, 1.0], [5.0, 5.0]]))
    shaking = shaking_of(Results(results), spectra, None, None)
    assert read_measure(shaking.intensity).period == pytest.approx(known, rel=1e-5)
    assert "at the longest period of the buildings, of A while isolators yield" in shaking.reading
    older = Results(results.drop_vars("building_isolated_period"))
    assert "rerun" in refusal(resolved_intensity, older, "sa(longer)")


def test_a_wall_that_gives_is_no_building_with_floors():
    """What it does stays in the dataset, and in states that name it."""
    states = [{"name": name, "acceleration": "1 g", **of} for name, of in (("A", {"building": "A"}), ("any", {}))]
    states.append({"name": "wall", "acceleration": "1 g", "building": "wall"})
    wall = storeyed("wall", ["40 t"], ["60 MN/m"], ["1.5 m"], damping=0.1)
    above = storeyed("A", ["500 t", "400 t"], ["800 MN/m", "600 MN/m"], "4 m") | {"isolation": LEAD}
    records = {"window": ["0 s", "6 s"], "pga": "0.5 g"}
    results = pr.scan(parse_scene(scene_text(wall, above, records=records)).replace(damage=states))
    peaks = {name: results["peak_floor_acceleration"].sel(building=name).item() for name in ("wall", "A")}
    assert peaks["wall"] > 2.0 * peaks["A"]
    ratios = pr.damage(results)["demand_ratio"].sel(pounding="with").squeeze()
    assert [float(ratio) for ratio in ratios] == pytest.approx([peaks[name] / G for name in ("A", "A", "wall")])
    (told,) = (one for one in pr.assess(results).interfaces[0].response if one.output == "peak_floor_acceleration")
    assert told.median == pytest.approx(peaks["A"]) and told.words == "peak floor acceleration without wall"


def test_own_damping_is_that_above_the_slab_and_the_dashpot_that_below():
    """Moving as one, slab and floors feel the dashpot alone; held at the slab, the building has its own damping."""
    isolated, free = parse_scene(text(LEAD)).buildings[1], parse_scene(text(LEAD)).buildings[1].superstructure()
    damping = chain_of(isolated).damping
    assert damping @ np.ones(3) == pytest.approx([2e5, 0.0, 0.0], abs=1e-6)
    assert damping[1:, 1:] == pytest.approx(free.matrices()[1], rel=1e-14)
    assert free == parse_scene(text(LEAD).replace("isolation", "#")).buildings[1]


def test_effects_on_buildings_leave_the_isolators_what_they_are():
    effects = {"p_delta": {}, "soil_flexibility": SOIL, "inelastic_storeys": {"hardening": 0.1}}
    above = storeyed("A", ["500 t", "400 t"], ["800 MN/m", "600 MN/m"], "4 m", storey_strengths=["3 MN", "2 MN"])
    study = parse_scene(text(LEAD, above, effects=effects))
    chain, law = chain_of(study.buildings[1], study.effects), study.buildings[1].isolator_law
    assert chain.strength.tolist() == [inf, law.limit, 3e6, 2e6]
    assert chain.hardening.tolist() == [1.0, law.hardening, 0.1, 0.1]
    taken = (chain.shear - chain.spring)[1:]  # P-Δ of what stands above; isolators are measured with the weight on them
    assert taken == pytest.approx([0.0, 9e5 * G / 4.0, 4e5 * G / 4.0], rel=1e-6)
    # The dashpot joins the slab to the foundation.
    assert chain.damping[0, 1] == pytest.approx(-2e5, rel=1e-9) and pr.simulate(study).attrs["status"] == "complete"


def test_initial_states_have_the_slab_first(says):
    study = parse_scene(text(SLIDER, overridden(initial_velocity=["0.1 m/s", "0.2 m/s", "0.3 m/s"])))
    assert study.buildings[1].initial_velocity == (0.1, 0.2, 0.3) and parse_scene(study.to_toml()) == study
    same = parse_scene(text(SLIDER, overridden(initial_velocity="0.1 m/s"))).buildings[1]
    assert same.initial_velocity == (0.1, 0.1, 0.1)
    says(refusal(parse_scene, text(SLIDER, overridden(initial_velocity=["0.1 m/s", "0.2 m/s"]))))
    says(refusal(parse_scene, text(SLIDER, overridden(initial_displacement="20 mm"))))


def overridden(**keys: Any) -> dict[str, Any]:
    return storeyed("A", ["500 t", "400 t"], ["800 MN/m", "600 MN/m"], "4 m", **keys)


def test_generated_storeys_and_those_of_a_period_stand_on_isolators_too():
    generated = {"name": "A", "typology": "concrete_frame", "height": "9 m", "storeys": 3, "floor_mass": "300 t"}
    scaled = storeyed("A", ["500 t", "400 t"], None, "4 m", period="0.4 s")
    for building, count, period in ((generated | {"period": "0.4 s"}, 3, 0.4), (scaled, 2, 0.4)):
        study = parse_scene(text(SLIDER, building))
        isolated = study.buildings[1]
        assert len(isolated.masses) == count + 1 and isolated.superstructure().period == pytest.approx(
            period, rel=1e-12
        )
        assert parse_scene(study.to_toml()) == study


def test_python_a_file_and_what_they_write_are_one():
    for isolation in (LEAD, SLIDER):
        study = parse_scene(text(isolation))
        given = pr.Isolation(**isolation)
        hall = pr.ShearBuilding("A", ["500 t", "400 t"], ["800 MN/m", "600 MN/m"], "4 m", isolation=given)
        contact = pr.Interface("40 mm", "jankowski", "2.75e9 N/m^1.5", restitution=0.65)
        records = pr.Records(["RSN6-180"], window=["0 s", "6 s"], pga="0.5 g")
        assert pr.Scene([pr.RigidWall("wall", height=1.5), hall], [contact], records) == study.replace(name="scene")
        assert parse_scene(study.to_toml()) == study
        as_dict = pr.ShearBuilding("A", [5e5, 4e5], [8e8, 6e8], 4.0, isolation=dict(isolation))
        assert as_dict.structure() == study.buildings[1]


def test_faults_are_told_together(says):
    for isolation in (
        {"height": "1.5 m", "strength": "900 kN", "stiffness": "5 MN/m", "stifness": 1},
        {"slab_mass": "600 t", "height": "1.5 m"},
        {"slab_mass": "600 t", "height": "1.5 m", "strength": "900 kN"},
        {"slab_mass": "600 t", "height": "1.5 m", "friction": 0.05},
        LEAD | {"friction": 0.05},
        SLIDER | {"stiffness": "5 MN/m"},
        LEAD | {"damping": "0.05", "slab_mass": "600 kN"},
        LEAD | {"yield_displacement": "0.000009 mm"},
    ):
        says(refusal(parse_scene, text(isolation)))
    says(refusal(parse_scene, text(LEAD, single("A", "500 t", "0.4 s"))))


@pytest.mark.complete
def test_its_numbers_are_axes_and_uncertain_numbers():
    axis = {'"building.A.isolation.friction"': [0.03, 0.08]}
    whole = equals_the_loop(text(SLIDER, grid=axis), check_fraction=0.0)
    closing = whole["peak_closing_free"].values.ravel()
    assert whole["building.A.isolation.friction"].values.tolist() == [0.03, 0.08] and closing[0] != closing[1]
    numbers = (
        '[uncertain]\nsamples = 4\n"building.A.isolation.radius" = {distribution = "lognormal", dispersion = 0.2}\n'
    )
    sampled = pr.scan(parse_scene(text(SLIDER) + numbers))
    assert np.unique(sampled["building.A.isolation.radius"]).size == 4
    assert np.unique(sampled["peak_closing_free"]).size == 4


def test_what_is_said_of_it(says):
    study = parse_scene(text(LEAD))
    says("\n".join(line for line in str(validate(study)).splitlines() if "isolators" in line))
    says(answer(study).notes)
    assert sheet(answer(study))


def test_a_floor_below_the_slab_strikes_no_column(says):
    low = {"name": "B", "floor_masses": ["90 t"], "storey_stiffnesses": "90 MN/m", "storey_heights": "1 m"}
    study = parse_scene(scene_text(low, overridden(isolation=LEAD), gap="40 mm"))
    says(*level_notes(study).values())
    assert not level_notes(parse_scene(text(LEAD)))


def test_other_questions_take_it_as_what_yields(says, tmp_path):
    """Fragilities need levels, as twice the motion is not twice the closing; OpenSees alone of the others knows it."""
    states = [{"name": "slight", "drift": "0.1 %"}, {"name": "bearings", "storey": 1, "ductility": 10.0}]
    study = parse_scene(text(LEAD, grid={"pga": ["0.2 g", "0.5 g"]}), overrides=[]).replace(damage=states)
    scanned = pr.scan(study)
    assert not is_linear(Results(scanned))
    assert is_linear(Results(pr.scan(parse_scene(text(LEAD).replace("isolation", "#")))))
    demands = pr.damage(scanned)
    drift = scanned["storey_drift_free"].sel(building="A").values[..., 1:] / 4.0
    found = demands["demand_ratio"].sel(state="slight", pounding="without").values
    assert found == pytest.approx(drift.max(axis=-1).reshape(found.shape) / 1e-3, rel=1e-12)
    says([note for note in json.loads(demands.attrs["assumptions"]) if "isolators" in note])
    says(json.loads(pr.accuracy(study.replace(grid=pr.Grid()), budget=1e-9, scipy=False).left_out)[:1])
    (script,) = pr.export(study, "opensees", tmp_path / "scene.py").files
    assert "'Steel01', 905000.0, 905000000.0" in script.read_text("utf-8").replace("\n", " ")
    says([one.row.note for one in code_table(scanned).rules if one.row.rule == "cqc"])


def test_a_building_by_its_matrix_goes_into_the_scene_and_back():
    """``period`` and damping are of what stands on the slab; initial states have one value more, the slab's."""
    matrix = {"values": [[1400, -600], [-600, 600]], "unit": "MN/m"}
    keys = {"name": "A", "floor_masses": ["500 t", "400 t"], "storey_heights": "4 m", "stiffness_matrix": matrix}
    keys |= {"period": "0.4 s", "initial_displacement": ["1 mm", "2 mm", "3 mm"]}
    study = parse_scene(text(LEAD, keys))
    building = study.buildings[1]
    assert building.superstructure().period == pytest.approx(0.4)
    soft = building.isolator_law.soft
    assert building.isolated_period == pytest.approx(2.0 * pi * sqrt(1.5e6 / soft), rel=0.01)  # nearly rigid above
    assert parse_scene(study.to_toml()).buildings[1] == building
    dashpots = {"values": [[4, -2], [-2, 2]], "unit": "MN s/m"}
    damped = parse_scene(text(LEAD, keys | {"damping_matrix": dashpots})).buildings[1]
    ratio = building.superstructure().period / damped.superstructure().period
    assert ratio == pytest.approx(1.0) and damped.matrices()[1].sum() == pytest.approx(damped.isolators.damping)
    assert "2 values for 2 floors of stiffness_matrix and the slab" in refusal(
        parse_scene, text(LEAD, keys | {"initial_displacement": ["1 mm", "2 mm"]})
    )


@pytest.mark.parametrize(
    ("keys", "effects"),
    [
        ({"hysteresis": {"rule": "kinematic"}}, {"inelastic_storeys": {}}),
        ({}, {"inelastic_storeys": {"hardening": 0.01}}),
    ],
    ids=["hysteresis", "p_delta beyond the hardening"],
)
def test_isolators_yield_below_storeys_with_laws_of_their_own(keys, effects):
    """Storeys that never yield are elastic: neither their law nor their hardening changes anything below them."""
    strong = storeyed("A", ["500 t"], ["60 MN/m"], ["4 m"], storey_strengths=["100 MN"])
    beside = {} if keys else {"p_delta": {}}
    plain = pr.simulate(text(LEAD, strong, effects={"inelastic_storeys": {"hardening": 0.2}} | beside))
    found = pr.simulate(text(LEAD, strong | keys, effects=effects | beside))
    assert float(plain["impact_count"].sum()) > 0
    assert float(plain["storey_shear"].sel(building="A")[0]) < 2e6  # elastic isolators would carry ten times as much
    for name in ("storey_displacement", "storey_shear", "peak_contact_force", "impact_count", "storey_residual_drift"):
        # Other branches of other laws: the same motion but for the solver's rounding and tolerance of 1e-6.
        np.testing.assert_allclose(found[name].values, plain[name].values, rtol=1e-5, atol=1e-9)


def test_a_bilinear_storey_yields_beside_a_linked_neighbour_with_a_law():
    """A dashpot of 1 N s/m is none: two linked buildings move as they do without it."""
    law = {"hysteresis": {"rule": "kinematic"}}
    pair = (
        storeyed("A", ["200 t"], ["80 MN/m"], ["3 m"], storey_strengths=["600 kN"], **law),
        storeyed("B", ["150 t"], ["60 MN/m"], ["3 m"], storey_strengths=["300 kN"]),
    )
    given = {
        "gap": "20 mm",
        "records": {"window": ["0 s", "6 s"], "pga": "0.6 g"},
        "effects": {"inelastic_storeys": {}},
    }
    alone, linked = (pr.simulate(scene_text(*pair, **given | link)) for link in ({}, {"link_damping": "1 N s/m"}))
    assert float(alone["storey_ductility"].sel(building="B")[0]) > 2.0
    for name in ("storey_displacement", "storey_shear", "peak_contact_force", "impact_count"):
        # 1 N s/m beside the dashpots of 5 % is 3e-7 of them.
        np.testing.assert_allclose(linked[name].values, alone[name].values, rtol=1e-4)
