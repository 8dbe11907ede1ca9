"""The key `intensity` of [records]: what is read, what is refused, and what a scene file says again."""

import json

import numpy as np
import pytest
from jsonschema import Draft202012Validator
from scenes import rigid, scene_text, single, storeyed
from sentences import refusal, refusals

import pounding_risk as pr
from pounding_risk.motions.intensity import response_spectra
from pounding_risk.motions.levels import Level, Measure, driven
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene

G = 9.80665
SA = {"measure": "sa", "period": "0.5 s", "levels": ["0.1 g", "0.4 g"]}
PGV = {"measure": "pgv", "levels": ["0.1 m/s"]}
AVERAGE = {"measure": "sa_avg", "periods": ["0.2 s", "2 s"], "levels": ["0.1 g"]}
SCALE = {"measure": "scale", "levels": [0.5, 2.0]}


def scene(grid=None, **records):
    return parse_scene(scene_text(records={"window": ["0 s", "4 s"], **records}, grid=grid), "scene.toml")


@pytest.mark.parametrize(
    ("table", "measure", "levels"),
    [
        (SA, Measure("sa", (0.5,)), (0.1 * G, 0.4 * G)),
        (SA | {"damping": "2 %"}, Measure("sa", (0.5,), 0.02), (0.1 * G, 0.4 * G)),
        (PGV | {"levels": ["5 cm/s", "0.4 m/s"]}, Measure("pgv"), (0.05, 0.4)),
        (PGV | {"levels": {"start": "0.1 m/s", "stop": "0.3 m/s", "num": 3}}, Measure("pgv"), (0.1, 0.2, 0.3)),
        (AVERAGE | {"levels": ["1 m/s^2"]}, Measure("sa_avg", (0.2, 2.0)), (1.0,)),
        (SCALE | {"levels": [0.5, 1, 2]}, Measure("scale"), (0.5, 1.0, 2.0)),
    ],
)
def test_levels_of_every_measure_are_read_and_written(table, measure, levels):
    study = scene(intensity=table)
    assert study.grid.measure == measure
    assert study.grid.levels == pytest.approx(levels, rel=1e-15)
    again = parse_scene(study.to_toml(), "scene.toml")
    assert again == study
    assert again.grid.amplitudes == tuple(Level(measure, value) for value in study.grid.levels)


def test_levels_of_pga_are_those_of_the_grid():
    study = scene(intensity={"measure": "pga", "levels": ["0.1 g", "0.3 g"]})
    assert study == scene(grid={"pga": ["0.1 g", "0.3 g"]})
    assert study.resolved()["grid"]["pga"] == [f"{0.1 * G!r} m/s^2", f"{3 * G / 10!r} m/s^2"]


def test_python_takes_numbers_in_si():
    numbers = pr.Records(["RSN6-180"], intensity={"measure": "sa", "period": 0.5, "levels": [1.0, 2.0]})
    texts = pr.Records(["RSN6-180"], intensity={"measure": "sa", "period": "0.5 s", "levels": ["1 m/s^2", "2 m/s^2"]})
    assert numbers == texts
    assert scene().replace(records=numbers) == scene().replace(records=texts)
    assert pr.Records(["RSN6-180"], intensity=numbers.intensity) == numbers


REFUSED = {
    "no table": "0.4 g",
    "no measure": {"levels": ["0.1 g"]},
    "an unknown measure": {"measure": "sav", "levels": ["0.1 g"]},
    "no period": {"measure": "sa", "levels": ["0.1 g"]},
    "no periods": {"measure": "sa_avg", "levels": ["0.1 g"]},
    "no levels": {"measure": "pgv"},
    "periods of sa": SA | {"periods": ["0.2 s", "2 s"]},
    "speeds in g": PGV | {"levels": ["0.1 g"]},
    "levels that fall": PGV | {"levels": ["0.3 m/s", "0.1 m/s"]},
    "factors with a unit": SCALE | {"levels": ["2 g"]},
    "a factor of 0": SCALE | {"levels": [0.0, 1.0]},
    "an empty list": SA | {"levels": []},
    "periods that fall": AVERAGE | {"periods": ["2 s", "0.2 s"]},
    "one period of two": AVERAGE | {"periods": "0.2 s"},
}


@pytest.mark.parametrize("table", REFUSED.values(), ids=REFUSED)
def test_what_is_no_table_of_levels_is_refused(table, says):
    says(refusal(scene, intensity=table))


AMPLITUDES = {
    "pga": ["0.5 g"],
    "sa": [{"value": "0.4 g", "period": "1 s"}],
    "scale": [2.0],
    "grid": [{"pga": ["0.1 g"]}, {'"records.scale"': [0.5, 1.0]}],
}


@pytest.mark.parametrize("table", [SA, SCALE], ids=lambda table: table["measure"])
def test_what_sets_the_amplitude_too_is_refused(table, says):
    """Of factors alone the median of the records may be common."""
    of_median = {"to_median": ["pgv"]} if table is SA else {}
    says(*refusals(scene, intensity=table, wrong=AMPLITUDES | of_median))


def test_factors_may_follow_the_median_as_scale_does():
    """FEMA P-695 normalises its records and scales them together."""
    records = {"names": ["RSN6-180", "RSN1690-090"], "to_median": "pgv"}
    study = scene(intensity=SCALE, **records)
    for motion, other in zip(motions_of(study), motions_of(scene(**records)), strict=True):
        assert motion.digest == other.digest


def test_records_keep_their_amplitude_before_levels_of_a_measure():
    study = scene(intensity=SA)
    assert motions_of(study)[0].digest == motions_of(scene())[0].digest


def test_the_schema_takes_levels():
    validator = Draft202012Validator(json.loads(json.dumps(pr.schema())))
    tables = parse_scene(scene_text(records={"intensity": SA}), "scene.toml").resolved()
    assert not list(validator.iter_errors(tables))
    tables["records"]["intensity"]["measure"] = "pgd"
    assert [error for error in validator.iter_errors(tables)]


# ------------------------------------------------------------------------------------------------ relative periods

RELATIVE = {"measure": "sa_avg", "periods": ["0.2 T", "1.5 T"], "of": "left", "levels": ["0.1 g", "0.3 g"]}
RECORDS = {"window": ["0 s", "6 s"]}


def text(table=None, *buildings, **more):
    given = {key: value for key, value in (table or RELATIVE).items() if value is not None}
    return scene_text(*buildings, records=RECORDS | {"intensity": given}, **more)


def test_the_range_is_that_of_the_building_by_plain_means_of_its_spectrum():
    """At 10 periods evenly in the logarithm from 0.2 T to 1.5 T, the geometric mean of each level's motion is it."""
    study = parse_scene(text())
    assert study.grid.measure.periods == (0.1, 0.75)  # of 0.5 s
    (motion,) = motions_of(study)
    periods = [0.1 * 7.5 ** (place / 9) for place in range(10)]
    for level, wanted in zip(study.grid.amplitudes, (0.980665, 2.941995), strict=True):
        scaled = driven(motion, "as recorded", level)
        sa = response_spectra(scaled.acceleration, scaled.dt, periods).pseudo_acceleration
        assert np.prod(sa) ** 0.1 == pytest.approx(wanted, rel=1e-9)


def test_a_scan_equals_that_of_the_range_in_seconds_and_says_both():
    whole = pr.scan(parse_scene(text()), check_fraction=0.0)
    stated = pr.scan(parse_scene(text(RELATIVE | {"periods": ["0.1 s", "0.75 s"], "of": None})), check_fraction=0.0)
    for name in ("peak_closing_free", "peak_contact_force", "record_pga_felt"):
        assert np.array_equal(whole[name], stated[name])
    about = whole["intensity"].attrs
    assert about["periods"] == [0.1, 0.75]
    assert "from 0.1 s to 0.75 s (0.2 T to 1.5 T, T the first period of left), damping 5 %" in about["long_name"]
    measure = pr.assess(whole, intensity_level="0.3 g").as_dict()
    assert "Sa_avg(0.1-0.75 s)" in json.dumps(measure)


def test_set_moves_the_range_with_the_period():
    moved = parse_scene(text(), overrides=["building.left.period=0.8 s"])
    assert moved.grid.measure.periods == pytest.approx((0.16, 1.2), rel=1e-15)
    of_right = parse_scene(text(), overrides=['records.intensity.of="building.right"'])
    assert of_right.grid.measure.periods == pytest.approx((0.2, 1.5), rel=1e-15)


def test_of_storeys_it_is_the_first_period_of_the_chain():
    """Of two equal storeys ω² = (3 − √5)/2 k/m."""
    buildings = storeyed("A", "200 t", "9e7 N/m", storeys=2), single("B", "300 t", "0.5 s", height="3 m")
    table = {"measure": "sa", "period": "1 T", "of": "A", "levels": ["0.2 g"]}
    study = parse_scene(text(table, *buildings))
    rate = np.sqrt(0.5 * (3.0 - np.sqrt(5.0)) * 9e7 / 2e5)
    assert study.grid.measure.periods == pytest.approx((2.0 * np.pi / rate,), rel=1e-12)
    assert study.grid.measure.words.startswith("Sa(0.47")


def test_it_is_written_and_read_again():
    study = parse_scene(text())
    assert study.replace(records=pr.Records(["RSN6-180"], window=(0.0, 6.0), intensity=RELATIVE)) == study
    assert study.resolved()["records"]["intensity"]["periods"] == ["0.2 T", "1.5 T"]
    assert parse_scene(study.to_toml()) == study
    slower = study.replace(buildings=[pr.SingleMass("left", "500 t", "1 s"), pr.SingleMass("right", "800 t", "1 s")])
    assert slower.grid.measure.periods == (0.2, 1.5)
    validator = Draft202012Validator(json.loads(json.dumps(pr.schema())))
    assert validator.is_valid(study.resolved())


RELATIVE_REFUSED = {
    "of nothing": {"of": None},
    "of an unknown building": {"of": "lefft"},
    "of a number": {"of": 3},
    "one period in s": {"periods": ["0.2 s", "1.5 T"]},
    "both periods in s": {"periods": ["0.2 s", "1.5 s"]},
    "periods that fall": {"periods": ["1.5 T", "0.2 T"]},
    "a period of 0": {"periods": ["0 T", "1.5 T"]},
    "a period that is no number": {"periods": ["x T", "1.5 T"]},
    "a measure without periods": {"measure": "pgv", "levels": ["0.1 m/s"]},
    "of a wall": {"of": "wall"},
}


@pytest.mark.parametrize("change", RELATIVE_REFUSED.values(), ids=RELATIVE_REFUSED)
def test_what_is_relative_to_nothing_is_refused(change, says):
    buildings = (single("left", "500 t", "0.5 s"), rigid()) if change.get("of") == "wall" else ()
    says(refusal(parse_scene, text(RELATIVE | change, *buildings)))


def test_periods_that_vary_are_refused_with_the_repair(says):
    """Motions are scaled once for all places; other buildings' periods, and what leaves the period, may vary."""
    spread = '[uncertain]\nsamples = 4\n"building.{}.period" = {{distribution = "lognormal", dispersion = 0.2}}\n'
    says(refusal(parse_scene, text(grid={"building.left.period": ["0.4 s", "0.6 s"]})))
    says(refusal(parse_scene, text() + spread.format("left")))
    assert parse_scene(text() + spread.format("right")).uncertain is not None
    says([refusal(call, parse_scene(text())) for call in (pr.spectra, pr.amplification)])


def test_a_hazard_is_of_the_range_as_it_is_resolved(tmp_path, says):
    study = parse_scene(text())
    whole = pr.scan(study, check_fraction=0.0)
    curve = tmp_path / "hazard.csv"
    curve.write_text("sa_avg(0.1-0.75 s) [g],annual rate [1/year]\n0.05,1e-2\n0.3,1e-3\n2.0,1e-5\n")
    assert pr.assess(whole, hazard=curve, intensity_level="0.3 g")
    curve.write_text("sa_avg(0.2-0.75 s) [g],annual rate [1/year]\n0.05,1e-2\n0.3,1e-3\n2.0,1e-5\n")
    asked = {"intensity_level": "0.3 g", "intensity": "sa_avg(0.1-0.75 s)"}
    says(refusal(pr.assess, whole, hazard=curve, **asked))
