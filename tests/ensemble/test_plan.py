"""What a scene asks for: cases counted, records read, nothing run."""

from __future__ import annotations

from math import sqrt

import pytest
from scenes import BOTH, FRAME, rigid, scene_text, single
from sentences import refusal

from pounding_risk.ensemble.plan.plan import Plan, _scatter, validate
from pounding_risk.ensemble.plan.plan import plan as planned_with_times
from pounding_risk.ensemble.scan import scan
from pounding_risk.scene.reader import parse_scene

SCENE = scene_text(
    FRAME,
    rigid(),
    law="viscous_elastoplastic",
    stiffness="4.2e7 kN/m^1.5",
    restitution="concrete",
    yield_force="450 kN",
    equal_terms={"same": "penetration", "speed": "0.5 m/s"},
    records={"names": ["RSN6-180", "CCC-HN1"], "window": ["0 s", "6 s"], "polarity": BOTH, "tail": "2 s"},
    grid={
        "gap": {"start": "0 mm", "stop": "20 mm", "num": 11},
        "yield_force": ["200 kN", "450 kN", "inf"],
        "contact_model": ["viscous_elastoplastic", "linear"],
        "pga": ["0.2 g", "0.5 g"],
    },
)


@pytest.fixture(scope="module")
def plan() -> Plan:
    return validate(parse_scene(SCENE, "pair.toml"))


def test_cases_are_the_product_of_the_dimensions(plan):
    assert plan.shape == {"record": 2, "polarity": 2, "pga": 2, "contact_model": 2, "gap": 11, "yield_force": 3}
    assert plan.cases == 2 * 2 * 2 * 2 * 11 * 3
    # Each record lasts 6 s, its straight line to zero a step, and its tail 2 s.
    assert plan.shaking == pytest.approx(plan.cases * 0.5 * (8.01 + 8.0 + plan.records[1].dt))
    assert plan.batches == plan.cases // 3


def test_records_are_read_as_the_runs_will_see_them(plan):
    centro, ridgecrest = plan.records
    assert (centro.name, centro.state, centro.dt) == ("RSN6-180", "processed", 0.01)
    assert centro.duration == pytest.approx(8.01)
    assert (ridgecrest.name, ridgecrest.state) == ("CCC-HN1", "raw")
    # The strong shaking of that record starts later than the window ends.
    assert any("window leaves the strong shaking out" in flag for flag in ridgecrest.flags)
    assert any(step.startswith("baseline") for step in ridgecrest.processing)


def test_summary_reads_like_the_scene(plan, says):
    says([f"{what}: {words}" for what, words in plan.summary()[:13]])
    lines = str(plan).splitlines()
    says(lines[1], lines[-2])


def test_a_study_may_be_changed_from_outside():
    study = parse_scene(SCENE, "pair.toml")
    changed = validate(study, ['interface.gap="20 mm"', "grid.gap=['1 mm']"]).study
    assert (changed.gap, changed.grid.gaps) == (0.02, (0.001,))
    assert changed.overrides == ('interface.gap="20 mm"', "grid.gap=['1 mm']")
    assert changed.text == SCENE
    assert validate(study).study is study


def test_what_cannot_be_used_is_refused(tmp_path, says):
    says(refusal(validate, tmp_path / "no.toml"))
    (tmp_path / "broken.AT2").write_text("not a record\n")
    scene = tmp_path / "scene.toml"
    scene.write_text(SCENE.replace('names = ["RSN6-180", "CCC-HN1"]', 'files = ["*.AT2"]'))
    says(refusal(validate, str(scene)), refusal(validate, parse_scene(SCENE), ['records.window=["200 s", "206 s"]']))


def test_steps_of_a_scene_reach_the_records():
    steps = 'records.processing=[{step = "mean", of = "whole"}, {step = "bandpass", low = "0.2 Hz", high = "20 Hz"}]'
    ridgecrest = validate(parse_scene(SCENE), [steps]).records[1]
    told = [step.partition(":")[0] for step in ridgecrest.processing]
    assert told[1:4] == ["mean", "bandpass", "window"]
    assert "0.2 to 20 Hz" in ridgecrest.processing[2]


def test_records_unfit_for_the_buildings_are_flagged():
    """Too coarse for the stiffest, filtered too narrowly for the softest; CCC-HN1 is usable to 1/(1.25 · 0.0812 Hz)."""
    stiff = SCENE.replace('period = "0.208 s"', 'period = "0.05 s"')
    pair = stiff.replace("rigid = true", 'mass = "50 t"\nperiod = "12 s"')
    centro, ridgecrest = validate(parse_scene(pair, "pair.toml")).records
    coarse = "time step of the stiffest building: 0.01 s, 5 in a period of 0.05 s; allowed: at most 0.005 s"
    assert centro.flags == (coarse,)
    assert {coarse, "period of the softest building: 12 s; allowed: at most 9.85 s"} <= set(ridgecrest.flags)
    assert validate(parse_scene(SCENE, "pair.toml")).records[0].flags == ()


def test_the_error_of_a_mean_time_is_that_of_a_sample_of_a_finite_population():
    """Cochran (1977), eq. 2.20: s sqrt((1 - n/N) / n); none where all are known, or where one is."""
    assert _scatter([1.0, 2.0, 3.0], 12) == pytest.approx(sqrt((1.0 - 3.0 / 12.0) / 3.0), rel=1e-14)
    assert _scatter([1.0, 2.0, 3.0], 3) == 0.0 and _scatter([1.0], 12) == 0.0


POWER = {"link_exponent": 0.5}


@pytest.mark.parametrize(
    ("buildings", "exponent", "solved"), [(3, {}, 0), (2, POWER, 0), (3, POWER, 2)], ids=["linear", "a pair", "a row"]
)
def test_longer_rows_with_laws_of_links_are_solved_whether_or_not_a_gap_closes(buildings, exponent, solved):
    """What is planned is what the scan does, and the free motion of a pair is that of its whole runs to the bit."""
    records = {"names": ["RSN6-180", "RSN6-270"], "window": ["0 s", "6 s"], "pga": "0.1 g"}
    row = [single(name, "500 t", period) for name, period in (("A", "0.5 s"), ("B", "1 s"), ("C", "0.7 s"))]
    keys = {"gap": "900 mm", "link_damping": "500 kN s/m", **exponent}
    study = parse_scene(scene_text(*row[:buildings], records=records, **keys))
    planned = planned_with_times(study)
    assert planned.batches - (planned.screened or 0) == solved
    known, whole = scan(study, check_fraction=0.0), scan(study, check_fraction=0.0, screening=False)
    assert int(known["simulated"].sum()) == solved
    for name in set(known.data_vars) - {"simulated"}:
        assert known[name].values.tobytes() == whole[name].values.tobytes(), name
