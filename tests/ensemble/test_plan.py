"""What a scene asks for, told before anything runs, against the run itself; and what `--set` changes."""

import json
import shutil
from dataclasses import replace
from math import sqrt
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from processes import compiled, output
from scenes import BOTH, FOUR_IN_A_ROW, FRAME, rigid, scene_text, single, storeyed
from sentences import refusal

from pounding_risk.ensemble.pair_job import PairJob
from pounding_risk.ensemble.plan import cost as plan_work
from pounding_risk.ensemble.plan.plan import Plan, _scatter, duration, plan, validate
from pounding_risk.ensemble.scan import scan
from pounding_risk.motions import catalogue
from pounding_risk.motions.read import read_motion
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
def checked() -> Plan:
    return validate(parse_scene(SCENE, "pair.toml"))


def test_a_wall_has_no_columns():
    """A wall of 2 m beside a slab at 1.5 m: the slab meets the wall below its top."""
    isolation = {"slab_mass": "600 t", "height": "1.5 m", "friction": 0.05, "radius": "2 m"}
    hospital = storeyed("hospital", ["500 t", "400 t"], "800 MN/m", "4 m", isolation=isolation)
    (stated,) = (
        words
        for what, words in validate(parse_scene(scene_text(hospital, rigid(height="2 m")))).summary()
        if what.endswith("contact points") and words.startswith("floor to floor")
    )
    assert stated.endswith("storey 1 of hospital, wall at 1.5 m")


def test_cases_are_the_product_of_the_dimensions(checked):
    assert checked.shape == {"record": 2, "polarity": 2, "pga": 2, "contact_model": 2, "gap": 11, "yield_force": 3}
    assert checked.cases == 2 * 2 * 2 * 2 * 11 * 3
    # Each record lasts 6 s, its straight line to zero a step, and its tail 2 s.
    assert checked.shaking == pytest.approx(checked.cases * 0.5 * (8.01 + 8.0 + checked.records[1].dt))
    assert checked.batches == checked.cases // 3


def test_records_are_read_as_the_runs_will_see_them(checked):
    centro, ridgecrest = checked.records
    assert (centro.name, centro.state, centro.dt) == ("RSN6-180", "processed", 0.01)
    assert centro.duration == pytest.approx(8.01)
    assert (ridgecrest.name, ridgecrest.state) == ("CCC-HN1", "raw")
    # The strong shaking of that record starts later than the window ends.
    assert any("window leaves the strong shaking out" in flag for flag in ridgecrest.flags)
    assert any(step.startswith("baseline") for step in ridgecrest.processing)


def test_summary_reads_like_the_scene(checked, says):
    says([f"{what}: {words}" for what, words in checked.summary()[:13]])
    lines = str(checked).splitlines()
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


COARSE = "time step of the stiffest building: 0.02 s, 5 in a period of 0.1 s; allowed: at most 0.01 s"
NARROW = "period of the softest building: 12 s; allowed: at most 9.85 s"  # 1/(1.25 · 0.0812 Hz)
UPRIGHT = "a vertical component, which moves the buildings along the row here; name the horizontal ones"


@pytest.mark.parametrize(
    ("record", "periods", "flags"),
    [
        ("RSN1690-090", ("0.5 s", "0.1 s"), [COARSE]),
        ("RSN1690-090", ("0.1 s", "0.5 s"), []),
        ("CCC-HN1", ("0.5 s", "12 s"), [NARROW]),
        ("CCC-HN1", ("12 s", "0.5 s"), []),
        ("RSN6-UP", ("0.5 s", "0.4 s"), [UPRIGHT]),
    ],
)
def test_each_record_of_a_motion_is_compared_with_the_buildings_on_it(record, periods, flags):
    """Alone, behind another for both buildings, and below the right one; RSN1690 has steps of 0.02 s, RSN6 0.01 s."""

    def told(own: dict[str, str], **records: Any) -> list[str]:
        sides = single("left", "300 t", periods[0]), single("right", "200 t", periods[1], **own)
        (planned,) = validate(parse_scene(scene_text(*sides, records=records))).records
        return [flag for flag in planned.flags if flag.endswith((COARSE, NARROW, UPRIGHT))]

    of_both = told({}, names=[record])
    assert set(flags) <= set(of_both) and of_both
    behind = told({}, names=["RSN6-180"], aftershock=record)
    assert behind == [f"{record}, after it: {flag}" for flag in of_both]
    beside = told({"ground_record": record}, names=["RSN6-180"])
    assert beside == [f"{record}, beside it: {flag}" for flag in flags]


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
    planned = plan(study)
    assert planned.batches - (planned.screened or 0) == solved
    known, whole = scan(study, check_fraction=0.0), scan(study, check_fraction=0.0, screening=False)
    assert int(known["simulated"].sum()) == solved
    for name in set(known.data_vars) - {"simulated"}:
        assert known[name].values.tobytes() == whole[name].values.tobytes(), name


PAIR = scene_text(
    FRAME,
    rigid(),
    law="viscous_elastoplastic",
    stiffness="4.2e7 kN/m^1.5",
    restitution="concrete",
    records={"names": ["RSN6-180", "RSN1690-090"], "window": ["0 s", "12 s"], "polarity": BOTH},
    grid={
        "gap": {"start": "0 mm", "stop": "20 mm", "num": 21},
        "yield_force": {"start": "50 kN", "stop": "1000 kN", "num": 20},
        "contact_model": ["viscous_elastoplastic", "jankowski"],
        "pga": ["0.2 g", "0.5 g"],
    },
)
SCENES = {"pair": PAIR, "row": FOUR_IN_A_ROW}


def known(dataset) -> np.ndarray:
    """Lines none of whose cases touches or was run."""
    touches = dataset["impact_count"]
    beside = [dim for dim in touches.dims if dim not in dataset["simulated"].dims]
    still = (touches.sum(beside) if beside else touches) == 0
    return (still & (dataset["simulated"] == 0)).all("yield_force").values


@compiled
@pytest.mark.parametrize("name", SCENES)
def test_a_plan_counts_what_the_run_makes(name):
    study = parse_scene(SCENES[name])
    made = plan(study, workers=2)
    dataset = scan(study, check_fraction=0.02, workers=2)
    assert made.cases == dataset["simulated"].size
    assert (made.batches, made.screened) == (known(dataset).size, known(dataset).sum())
    assert 0 < made.screened < made.batches
    assert made.bytes == sum(variable.nbytes for variable in dataset.data_vars.values())


@compiled
def test_the_time_of_a_plan_is_that_of_the_run(monkeypatch):
    """A clock on which a line takes a hundredth of a second for each of its contacts: the plan's time is that of all.

    Within four standard errors, which are the plan's own: the sample is a random one.
    """
    study = parse_scene(PAIR)
    touches = scan(study, check_fraction=0.0)["impact_count"].sum("yield_force").values.ravel() / 100.0
    now, solve = [0.0], PairJob.solve

    def timed(job, batches, stop):
        now[0] += touches[batches.start : batches.stop].sum()
        return solve(job, batches, stop)

    monkeypatch.setattr(PairJob, "solve", timed)
    monkeypatch.setattr(plan_work, "thread_time", lambda: now[0])
    made = plan(study, workers=2)
    assert made.seconds is not None
    assert made.error is not None
    assert 2 < made.sampled < made.batches, "a second is over before all batches are solved"
    assert abs(2 * made.seconds - touches.sum()) < 4.0 * 2 * made.error
    assert made.error < made.seconds
    now[0] = 0.0
    assert plan(study, workers=4).seconds == pytest.approx(0.5 * made.seconds, rel=1e-12)  # the same sample


@compiled
def test_what_is_validated_is_not_run():
    """Cases, bytes and notes are those of the plan, and nothing of its runs is stated."""
    study = parse_scene(PAIR)
    planned, checked = plan(study), validate(study)
    unknown = {"memory": None, "screened": None, "seconds": None, "error": None, "sampled": 0}
    assert checked == replace(planned, **unknown, share=1.0)
    words = dict(checked.summary())
    assert words["time"] == "not known, since nothing is run; `scan --plan` times a sample, and states the memory"
    assert "memory" not in words


@pytest.fixture(scope="module")
def changed() -> Plan:
    overrides = (
        "interface.gap=20 mm",
        "interface.stiffness=4.20001e7 kN/m^1.5",
        "building.frame.mass=50 t",
        'records.polarity=["reversed"]',
        "grid.pga=['0.2 g']",
        "grid.gap={start='1 mm', stop='20 mm', num=9}",
    )
    return validate(parse_scene(PAIR), overrides)


def test_what_set_changes_is_told_value_by_value(changed, says):
    """In its order in the scene; a change in the fifth digit is not told as none; the cases that come of it last."""
    says(changed.changes)
    assert [words for what, words in changed.summary() if what == "changed"] == list(changed.changes)


def test_a_value_set_to_what_it_is_changes_nothing(tmp_path):
    assert validate(parse_scene(PAIR), ["interface.gap=10 mm"]).changes == ()
    assert validate(parse_scene(PAIR)).changes == ()
    # Each interface of a row, by its number; records count for the cases.
    told = validate(parse_scene(FOUR_IN_A_ROW), ["interface.gap=30 mm", 'records.names=["RSN6-180"]']).changes
    assert told[:3] == tuple(f"interface.{number}.gap: 20 mm -> 30 mm" for number in (1, 2, 3))
    assert told[3:] == ("records.names: RSN6-180, RSN1690-090 -> RSN6-180", "cases: 36 -> 18")
    # A scene that only does with the overrides has nothing to compare with.
    scene = tmp_path / "scene.toml"
    scene.write_text(PAIR.replace("44.36 t", "44.36 m"), encoding="utf-8")
    assert validate(scene, ["building.frame.mass=50 t"]).changes == ()


def test_a_unit_that_no_record_takes_is_told_and_no_change(tmp_path, says):
    """A file of PEER states its own unit; columns that state none take the one that is given."""
    before, after = PAIR.split('names = ["RSN6-180", "RSN1690-090"]')
    shutil.copy(catalogue.path("RSN6-180"), tmp_path / "own.AT2")
    study = parse_scene(f'{before}files = ["own.AT2"]{after}', str(tmp_path / "scene.toml"))
    plan = validate(study, ['records.unit="cm/s^2"', 'records.dt="0.02 s"'])
    says(plan.changes, plan.records[0].flags[:2])
    np.savetxt(tmp_path / "own.csv", 100.0 * read_motion("RSN6-180").acceleration)
    stated = 'unit = "cm/s^2"\ndt = "0.01 s"'
    bare = parse_scene(f'{before}files = ["own.csv"]\n{stated}{after}', str(tmp_path / "scene.toml"))
    assert not any("changes nothing" in flag for flag in validate(bare).records[0].flags)
    says(validate(bare, ['records.unit="mm/s^2"']).changes)


def test_what_touches_is_not_known_before_a_plan(changed):
    assert dict(changed.summary())["batches"].endswith(
        "how many of them touch is not known yet, `scan --plan` finds it"
    )


def test_times_are_told_as_one_says_them():
    told = [duration(seconds) for seconds in (0.0, 0.84, 9.6, 42.0, 719.0, 12000.0, 1e6)]
    assert told == ["0.1 s", "0.8 s", "10 s", "42 s", "12 min", "3 h 20 min", "11.6 days"]


MEMORY = """
import json, sys
from pounding_risk.ensemble.scan import scan
from pounding_risk.ensemble.plan.plan import plan
told = plan("scene.toml", workers=2).memory
scan("scene.toml", "results.nc", workers=2)
peak = next(line.split()[1] for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(json.dumps([told, 1024 * int(peak)]))
"""


@compiled
@pytest.mark.complete
@pytest.mark.skipif(not Path("/proc/self/status").exists(), reason="the peak of a process is read as Linux tells it")
def test_the_memory_of_a_plan_is_that_of_the_run(tmp_path):
    """Within a third: of some 300 MB two thirds are libraries, which a system may load in whole or in part."""
    plan(parse_scene(PAIR))  # compiles, where the child finds it
    (tmp_path / "scene.toml").write_text(PAIR, encoding="utf-8")
    told, peak = json.loads(output("-c", MEMORY, cwd=tmp_path))
    assert 0.75 * peak < told < 1.33 * peak
