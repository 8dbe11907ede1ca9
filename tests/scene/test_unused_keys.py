"""Keys without effect: what is told of a scene is what its runs show.

The oracle is the scan itself: two scenes that differ in a key alone give the same numbers exactly where the key is
listed. Every key and every option of an effect stands in a case here, or among those that a scene cannot do without.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pytest
from scenes import scene_text, single, storeyed
from sentences import refusal

from pounding_risk.assessment.assess import assess
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.scan import scan
from pounding_risk.models.effects import EFFECTS
from pounding_risk.reports import report
from pounding_risk.results.attributes import read_attribute
from pounding_risk.scene.interfaces import EqualTerms
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.scene import scene_of
from pounding_risk.scene.sections import KEYS
from pounding_risk.scene.uncertain_tables import Uncertain
from pounding_risk.studies.simulate import simulate

PAIR = scene_text(
    single("A", "44 t", "0.2 s"),
    single("B", "80 t", "0.1 s"),
    law="viscous_elastoplastic",
    gap="2 mm",
    records={"window": ["0 s", "4 s"], "scale": 1.5},
)
WALL = PAIR.replace('mass = "80 t"\nperiod = "0.1 s"', "rigid = true")
ROW = scene_text(
    storeyed("A", ["40 t", "40 t"], "60 MN/m", ["4 m", "2 m"]),
    storeyed("B", ["60 t", "60 t"], "120 MN/m", ["3 m", "3 m"]),
    law="viscous_elastoplastic",
    gap="2 mm",
    records={"window": ["0 s", "4 s"], "scale": 1.5},
)
LEVEL = ROW.replace('["4 m", "2 m"]', '["3 m", "3 m"]')  # floor to floor throughout
COLUMNS = ROW.replace('["4 m", "2 m"]', '["4 m", "3 m"]')  # floor to column throughout
HERTZ = 'interface.contact_model="hertz"'
JUMP = 'interface.contact_model="stereomechanical"'
FLOORS = 'interface.contact_model="distributed_mass"'


class Case(NamedTuple):
    """A key with two values in one scene; ``on`` is what of the outputs it leaves alone, where it changes another."""

    key: str
    scene: str
    first: list[str]
    second: list[str]
    common: Sequence[str] = ()
    on: str = ""
    without: str = ""  # a key of the interface that the scene must not have
    within: float = 0.0  # relative, where the same motion is found by other operations


def values(key: str, first: str, second: str) -> tuple[list[str], list[str]]:
    return [f"{key}={first}"], [f"{key}={second}"]


def varied(key: str, scene: str, first: str, second: str, common: Sequence[str] = (), **more) -> Case:
    """A case of two values of its key."""
    return Case(key, scene, *values(key, first, second), common, **more)


TERMS = [f'interface.equal_terms={{same="peak force", speed="{speed} m/s"}}' for speed in (0.5, 1.0)]
LAWS = 'grid.contact_model=["viscous_elastoplastic", "linear"]'
FORCES = ['grid.yield_force=["50 kN", "inf"]', 'grid.yield_force=["90 kN", "inf"]']
FORCE = values("interface.yield_force", '"50 kN"', '"90 kN"')
COLUMN = values("interface.column_yield_force", '"50 kN"', '"90 kN"')
STRENGTH = values("building.A.column_strength", '"50 kN"', '"90 kN"')
ISOLATION = '{slab_mass = "50 t", height = "1 m", strength = "%s", stiffness = "1 MN/m"}'
TABLES = values(
    "interface.table",
    '{penetration=["0 mm", "9 mm"], force=["0 kN", "900 kN"]}',
    '{penetration=["0 mm", "9 mm"], force=["0 kN", "700 kN"]}',
)
DAMPER = ['interface.link_stiffness="0 N/m"', 'interface.link_damping="0.1 MN s/m"']
SPRING = ['interface.link_stiffness="1 MN/m"', 'interface.link_damping="0 N s/m"']
IDLE = [
    Case("interface.table", PAIR, *TABLES),
    varied("building.B.mass", WALL, '"50 t"', '"500 t"'),
    varied("building.A.floor_length", PAIR, '"10 m"', '"20 m"'),
    varied("building.A.wave_speed", PAIR, '"3000 m/s"', '"4000 m/s"', ['building.A.floor_length="10 m"']),
    varied("building.A.height", PAIR, '"6 m"', '"9 m"'),
    varied("building.A.storey_strengths", ROW, '"100 kN"', '"200 kN"'),
    Case(
        "building.A.storey_strengths",
        ROW,
        ['building.A.storey_strengths="inf"'],
        ['building.A.storey_strengths=["inf", "inf"]'],
        ["effects.inelastic_storeys={}"],
    ),
    varied("building.A.damping_rule", ROW, '"rayleigh"', '"stiffness"', ["building.A.damping=0.0"]),
    varied("building.A.hysteresis", ROW, '{rule = "isotropic"}', '{rule = "peak_oriented"}'),
    varied("interface.restitution", PAIR, "0.4", "0.9", [HERTZ]),
    varied("interface.restitution", ROW, "0.4", "0.9", [HERTZ]),
    Case("interface.yield_force", PAIR, *FORCE, [HERTZ], on="on any force"),
    Case("interface.yield_force", PAIR, *FORCE, [JUMP], without="stiffness"),
    Case("interface.yield_force", COLUMNS, *FORCE),
    Case("interface.yield_force", LEVEL, *FORCE, ['grid.yield_force=["70 kN"]']),
    Case("interface.column_yield_force", LEVEL, *COLUMN),
    Case("interface.column_yield_force", COLUMNS, *COLUMN, [HERTZ], on="on any force"),
    Case("building.A.column_strength", LEVEL, *STRENGTH),
    Case("building.A.column_strength", COLUMNS, *STRENGTH, [HERTZ], on="on any force"),
    Case("interface.column_yield_force", COLUMNS, *COLUMN, [f'building.{one}.column_strength="70 kN"' for one in "AB"]),
    varied("interface.link_strength", LEVEL, '"10 kN"', '"20 kN"', DAMPER),
    varied("interface.link_slack", LEVEL, '"1 mm"', '"2 mm"', DAMPER),
    varied("interface.link_breaking_force", LEVEL, '"10 kN"', '"20 kN"', ['interface.link_stiffness="0 N/m"']),
    varied("interface.link_exponent", LEVEL, "0.3", "0.5", SPRING),
    varied("interface.link_brace_stiffness", LEVEL, '"10 MN/m"', '"20 MN/m"', SPRING),
    varied("interface.tolerance", PAIR, '"60 mm"', '"90 mm"'),
    varied("building.A.floor_depth", PAIR, '"0.2 m"', '"0.3 m"'),
    varied("building.A.floor_depth", LEVEL, '"0.2 m"', '"0.3 m"', ['interface.tolerance="50 mm"']),
    varied("interface.plastic_exponent", PAIR, "0.3", "0.6", ['interface.contact_model="van_mier"']),
    Case("interface.equal_terms", PAIR, TERMS[:1], TERMS[1:]),
    varied("records.dt", PAIR, '"0.01 s"', '"0.02 s"'),
    varied("records.pga", PAIR, '"0.2 g"', '"0.5 g"', ['grid.pga=["0.4 g"]'], without="scale"),
    varied("records.pga", PAIR, '"0.2 g"', '"0.4 g"', ['grid.pga=["0.2 g", "0.4 g"]'], without="scale",
        on="on the runs of a scan"),
    Case("grid.yield_force", PAIR, FORCES[:1], FORCES[1:], [HERTZ], on="on any force"),
    Case("grid.yield_force", PAIR, FORCES[:1], FORCES[1:], [JUMP], without="stiffness"),
    Case("grid.yield_force", COLUMNS, FORCES[:1], FORCES[1:]),
    varied("effects.strain_rate.strength", PAIR, '"30 MPa"', '"60 MPa"',
        ['effects.strain_rate.code="mc2010"', 'effects.strain_rate.length="0.6 m"', 'interface.yield_force="50 kN"']),
    Case("effects.permanent_set", PAIR, ["effects.permanent_set={}"], []),
    Case("effects.inelastic_storeys", ROW, ["effects.inelastic_storeys={}"], [],
         ['building.A.storey_strengths="inf"']),
    Case("effects.wave_passage", PAIR, ['effects.wave_passage={velocity="500 m/s", distance="0 m"}'], [],
         within=1e-5),  # rtol is 1e-6, and forces at the cap's edge move by some of it
]  # fmt: skip
ACTING = [
    varied("building.A.mass", PAIR, '"44 t"', '"50 t"'),
    varied("building.A.period", PAIR, '"0.2 s"', '"0.21 s"'),
    varied("building.A.damping", PAIR, "0.05", "0.02"),
    varied("building.A.initial_displacement", PAIR, '"-2 mm"', '"1 mm"'),
    varied("building.A.initial_velocity", ROW, '["0 m/s", "0.1 m/s"]', '"-1 m/s"'),
    varied("building.A.ground_factor", PAIR, "-1.0", "0.5"),
    varied("building.A.ground_delay", PAIR, '"20 ms"', '"33 ms"'),
    varied("building.A.ground_velocity", PAIR, '"0.01 m/s"', '"0.05 m/s"'),
    varied("building.A.ground_record", PAIR, '"RSN6-270"', '"RSN1690-090"'),
    varied("building.A.floor_length", PAIR, '"10 m"', '"20 m"',
           [FLOORS, 'building.B.floor_length="15 m"'], without="stiffness"),
    varied("building.A.wave_speed", PAIR, '"3000 m/s"', '"4000 m/s"',
           [FLOORS, 'building.A.floor_length="10 m"', 'building.B.floor_length="15 m"'], without="stiffness"),
    varied("building.A.height", PAIR, '"3 m"', '"2 m"', ["effects.p_delta={}", 'building.B.height="3 m"']),
    varied("building.A.floor_masses", ROW, '"40 t"', '"50 t"'),
    varied("building.A.storey_stiffnesses", ROW, '"60 MN/m"', '"70 MN/m"'),
    varied("building.A.isolation", ROW, ISOLATION % "90 kN", ISOLATION % "60 kN"),
    varied("building.A.storey_heights", ROW, '["4 m", "2 m"]', '["3 m", "3 m"]'),
    varied("building.A.storey_strengths", ROW, '"50 kN"', '"90 kN"', ["effects.inelastic_storeys={}"]),
    varied("building.A.hysteresis", ROW, '{rule = "isotropic"}', '{rule = "peak_oriented"}',
           ["effects.inelastic_storeys={}", 'building.A.storey_strengths="50 kN"']),
    varied("building.A.damping_rule", ROW, '"rayleigh"', '"stiffness"'),
    varied("interface.gap", PAIR, '"2 mm"', '"3 mm"'),
    varied("interface.contact_model", PAIR, '"hertz"', '"jankowski"'),
    varied("interface.stiffness", PAIR, '"2e9 N/m^1.5"', '"3e9 N/m^1.5"'),
    varied("interface.restitution", PAIR, "0.4", "0.9"),
    Case("interface.yield_force", PAIR, *FORCE),
    Case("interface.yield_force", LEVEL, *FORCE),
    Case("interface.column_yield_force", COLUMNS, *COLUMN),
    Case("interface.column_yield_force", COLUMNS, *COLUMN, ['building.B.column_strength="70 kN"']),
    Case("building.A.column_strength", COLUMNS, *STRENGTH),
    varied("interface.plastic_exponent", PAIR, "0.3", "0.6",
           ['interface.contact_model="van_mier"', 'interface.yield_force="50 kN"']),
    varied("interface.design_penetration", PAIR, '"5 mm"', '"9 mm"', ['interface.contact_model="bilinear"']),
    Case("interface.table", PAIR, *TABLES, ['interface.contact_model="tabulated"'], without="stiffness"),
    Case("interface.equal_terms", PAIR, TERMS[:1], TERMS[1:], [LAWS]),
    varied("records.pga", PAIR, '"0.4 g"', '"0.5 g"', without="scale"),
    varied("records.scale", PAIR, "1.5", "1.6"),
    varied("records.window", PAIR, '["0 s", "4 s"]', '["1 s", "4 s"]'),
    varied("records.tail", PAIR, '"0 s"', '"1 s"'),
    Case("grid.yield_force", LEVEL, FORCES[:1], FORCES[1:]),
    varied("solver.rtol", PAIR, "1e-6", "1e-9"),
    varied("effects.strain_rate.strength", PAIR, '"30 MPa"', '"60 MPa"',
        ['effects.strain_rate.code="mc1990"', 'effects.strain_rate.length="0.6 m"', 'interface.yield_force="50 kN"']),
    Case("effects.permanent_set", PAIR, ["effects.permanent_set={}"], [], ['interface.yield_force="50 kN"']),
    Case("effects.inelastic_storeys", ROW, ["effects.inelastic_storeys={}"], [],
         ['building.A.storey_strengths="50 kN"']),
    varied("effects.inelastic_storeys.hardening", ROW, "0.03", "0.1", ['building.A.storey_strengths="50 kN"']),
    Case("effects.wave_passage", PAIR, ['effects.wave_passage={velocity="500 m/s", distance="9 m"}'], []),
]  # fmt: skip
ALWAYS = {  # keys that act in every scene that may have them, by section, with what would show it
    "name the buildings and the study": {"scene": "name", "building": "name"},
    "say what a building is": {"building": "stiffness rigid storeys typology floor_mass"},
    "is the motion itself (test_known_motions)": {"building": "displacement_history"},
    "are the building itself, or the link (test_matrix_files, test_matrices, test_links)": {
        "building": "stiffness_matrix floor_rows damping_matrix mass_matrix along_rows modes residual_period plan "
        "interior_modes interior_masses",
        "interface": "link_stiffness link_damping link_at link_strength link_slack link_exponent link_breaking_force "
        "link_brace_stiffness",
    },
    "say where floors meet (test_scene_row, test_storeys, test_bumpers)": {
        "interface": "contact tolerance bumper_length",
        "building": "floor_depth",
    },
    "are parts of equal_terms, which is told whole": {"equal_terms": "same speed every_law"},
    "say which motions there are, and how large (test_gather, test_scaling)": {
        "records": "names files set manifest generated unit dt sites place direction sa to_median intensity polarity "
        "processing aftershock pause aftershock_ratio"
    },
    "are axes of the dataset (test_sweep, test_row_scan)": {"grid": "gap interface contact_model pga axes zip"},
    "say which samples there are of what nobody knows exactly (test_uncertain)": {
        "uncertain": " ".join(Uncertain.model_fields)
    },
    "are options of effects, which are told whole": {
        "effects.strain_rate": "code length",
        "effects.unloading_stiffness": "ratio",
        "effects.wave_passage": "velocity distance towards",
        "effects.soil_flexibility": " ".join(EFFECTS["soil_flexibility"].options),
    },
    "are states of damage, which no run reads (test_damage_states)": {"damage": " ".join(KEYS["damage"])},
    "change every building that may have them": {"effects": "p_delta soil_flexibility"},
    "act on what permanent_set leaves, which is told": {"effects": "unloading_stiffness strain_rate"},
}


def study_of(case: Case, own: list[str]):
    text = "\n".join(line for line in case.scene.splitlines() if not case.without or not line.startswith(case.without))
    return parse_scene(text, "scene.toml", [*case.common, *own])


def names_of(case: Case) -> str:
    return f"{case.key}{' ' + case.on if case.on else ''}"


@pytest.mark.parametrize("case", IDLE, ids=lambda case: names_of(case))
def test_a_key_that_changes_no_number_is_told(case):
    first, second = study_of(case, case.first), study_of(case, case.second)
    told = [each.partition(f": no effect{' ' * bool(case.on)}{case.on}: ") for each in unused_keys(first)]
    assert any(case.key in keys.split(", ") for keys, found, _ in told if found)
    one, other = (scan(each, check_fraction=0.0) for each in (first, second))
    assert int(one["impact_count"].sum()) > 0  # else nothing could differ
    # The forces stay where only the count of those that reach the yield force may change.
    for name in one.data_vars if not case.on else ("peak_contact_force", "peak_displacement", "impact_count"):
        if not case.within:
            assert one[name].values.tobytes() == other[name].values.tobytes(), name
        elif name != "energy_residual":  # which is nothing but rounding
            np.testing.assert_allclose(one[name].values, other[name].values, rtol=case.within, err_msg=name)


# The kernels of a ground of a building's own take ten seconds to compile.
OWN_GROUND = [pytest.param(case, marks=pytest.mark.complete) if ".ground_" in case.key else case for case in ACTING]


@pytest.mark.parametrize("case", OWN_GROUND, ids=lambda case: names_of(case))
def test_a_key_that_changes_numbers_is_not_told(case):
    first, second = study_of(case, case.first), study_of(case, case.second)
    for study in (first, second):
        assert not any(case.key in each.partition(": ")[0].split(", ") for each in unused_keys(study))
    one, other = (scan(each, check_fraction=0.0) for each in (first, second))
    both = set(one.data_vars) & set(other.data_vars)  # storeys that yield have variables of their own
    changed = [name for name in both if one[name].values.tobytes() != other[name].values.tobytes()]
    assert changed


def test_every_key_and_option_has_a_case():
    keys = {f"{section}.{key}" for section, named in KEYS.items() for key in named}
    keys |= {f"equal_terms.{key}" for key in EqualTerms.model_fields}
    keys |= {f"effects.{name}" for name in EFFECTS}
    keys |= {f"effects.{name}.{option}" for name, kind in EFFECTS.items() for option in kind.options}
    tried = {case.key.replace("building.A.", "building.").replace("building.B.", "building.") for case in IDLE + ACTING}
    always = {f"{section}.{key}" for of in ALWAYS.values() for section, named in of.items() for key in named.split()}
    assert keys == tried | always


@pytest.mark.parametrize(("stated", "assessed"), [("0.2 g", 0.2), ("0.3 g", 0.4)])
def test_a_pga_beside_that_of_the_grid_says_which_is_assessed(stated, assessed):
    """By the answers alone: PGA in the grid is the one that is assessed and simulated, else the largest is."""
    given = ['grid.pga=["0.2 g", "0.4 g"]', f'records.pga="{stated}"']
    study = parse_scene(PAIR.replace("scale = 1.5\n", ""), "scene.toml", given)
    dataset, (sentence,) = scan(study, check_fraction=0.0), unused_keys(study)
    assert assess(dataset).interfaces[0].amplitude == pytest.approx(assessed * 9.80665)
    run = simulate(study)
    at_level = dataset["peak_closing"].isel(gap=0).sel(pga=assessed * 9.80665, method="nearest").squeeze()
    assert run["peak_closing"].item() == at_level.item()
    assert f"{assessed:g} g, is assessed" in sentence if stated == "0.3 g" else "the one that is assessed" in sentence


def test_an_axis_that_does_not_reach_columns_says_so(says):
    """Three cases of one gap that are one case thrice, which the dataset's reader must know."""
    study = parse_scene(COLUMNS, "scene.toml", ['grid.yield_force=["200 kN", "700 kN", "inf"]'])
    (sentence,) = unused_keys(study)
    says(sentence, refusal(simulate, study, yield_force=2e5))
    dataset = scan(study, check_fraction=0.0)
    forces = dataset["peak_contact_force"].values
    assert (forces == forces[..., :1, :]).all()  # along the yield force
    assert read_attribute(dataset, "unused_keys", []) == [sentence]
    assert assess(dataset).unused_keys == (sentence,)


def test_an_axis_that_reaches_some_points_says_which_it_does_not():
    study = parse_scene(ROW, "scene.toml", ['grid.yield_force=["50 kN", "inf"]'])
    (sentence,) = unused_keys(study)
    assert sentence.startswith("grid.yield_force: no effect on the 2 of 3 contact points where a floor meets a column")


def test_one_sentence_names_the_key_of_every_table():
    """A row of thirty buildings would say the same thirty times."""
    study = parse_scene(PAIR, "scene.toml", ['building.A.floor_length="10 m"', 'building.B.floor_length="12 m"'])
    (sentence,) = unused_keys(study)
    assert sentence.startswith("building.A.floor_length, building.B.floor_length: no effect: only contact model ")


def test_the_plan_and_a_single_run_tell_it():
    study = parse_scene(PAIR, "scene.toml", [HERTZ])
    plan = validate(study)
    assert ("unused", "interface.restitution: no effect: hertz takes no restitution") in plan.summary()
    assert read_attribute(simulate(study), "unused_keys", []) == list(plan.unused)


def test_yield_shears_are_not_called_acting_where_they_do_not():
    study = parse_scene(ROW, "scene.toml", ['building.A.storey_strengths="100 kN"'])
    words = dict.fromkeys(words for what, words in validate(study).summary() if what.endswith("building"))
    assert any("elastic (yield shears act under inelastic_storeys)" in each for each in words)
    acting = validate(study, ["effects.inelastic_storeys={}"])
    assert any(words.endswith("with yield shears") for what, words in acting.summary() if what.endswith("building"))


def test_nothing_is_told_of_what_was_not_written():
    """Defaults that the resolved scene states are not keys that someone gave, but for a study without a text."""
    assert unused_keys(parse_scene(PAIR, "scene.toml")) == ()
    assert unused_keys(parse_scene(ROW, "scene.toml")) == ()
    resolved = parse_scene(ROW, "scene.toml").resolved()
    assert unused_keys(scene_of(resolved)) == ()
    scaled = parse_scene(PAIR.replace("scale = 1.5", 'pga = "0.5 g"'), "scene.toml")
    assert unused_keys(scene_of(scaled.resolved())) == ()  # its grid states that PGA too


@pytest.mark.complete
def test_the_report_lists_them_with_the_scene(tmp_path):
    study = parse_scene(PAIR, "scene.toml", [HERTZ])
    page = report(scan(study, check_fraction=0.0), tmp_path / "page.html").read_text(encoding="utf-8")
    assert "Keys of the scene without effect" in page
    assert "interface.restitution: no effect: hertz takes no restitution." in page
    plain = report(scan(parse_scene(PAIR, "scene.toml"), check_fraction=0.0), tmp_path / "other.html")
    assert "without effect" not in plain.read_text(encoding="utf-8")
