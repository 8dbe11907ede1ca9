"""The key `intensity` of [records]: what is read, what is refused, and what a scene file says again."""

from __future__ import annotations

import json

import pytest
from jsonschema import Draft202012Validator
from scenes import scene_text

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import Level, Measure
from pounding_risk.scene.motions import motions_of
from pounding_risk.scene.reader import parse_scene

G = 9.80665
SA = {"measure": "sa", "period": "0.5 s", "levels": ["0.1 g", "0.4 g"]}


def scene(grid=None, **records):
    return parse_scene(scene_text(records={"window": ["0 s", "4 s"], **records}, grid=grid), "scene.toml")


@pytest.mark.parametrize(
    ("table", "measure", "levels"),
    [
        (SA, Measure("sa", (0.5,)), (0.1 * G, 0.4 * G)),
        (SA | {"damping": "2 %"}, Measure("sa", (0.5,), 0.02), (0.1 * G, 0.4 * G)),
        ({"measure": "pgv", "levels": ["5 cm/s", "0.4 m/s"]}, Measure("pgv"), (0.05, 0.4)),
        (
            {"measure": "pgv", "levels": {"start": "0.1 m/s", "stop": "0.3 m/s", "num": 3}},
            Measure("pgv"),
            (0.1, 0.2, 0.3),
        ),
        (
            {"measure": "sa_avg", "periods": ["0.2 s", "2 s"], "levels": ["1 m/s^2"]},
            Measure("sa_avg", (0.2, 2.0)),
            (1.0,),
        ),
        ({"measure": "scale", "levels": [0.5, 1, 2]}, Measure("scale"), (0.5, 1.0, 2.0)),
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


@pytest.mark.parametrize(
    ("table", "sentence"),
    [
        ("0.4 g", '"0.4 g" is not a table; write intensity = {measure = "sa", period = "0.5 s"'),
        ({"levels": ["0.1 g"]}, "measure: missing; it may be pga, pgv, sa, sa_avg, scale"),
        ({"measure": "sav", "levels": ["0.1 g"]}, '"sav" is no measure (did you mean "sa"?); it may be pga'),
        ({"measure": "sa", "levels": ["0.1 g"]}, 'period: missing; write period = "0.5 s"'),
        ({"measure": "sa_avg", "levels": ["0.1 g"]}, 'periods: missing; write periods = ["0.2 s", "2 s"]'),
        ({"measure": "pgv"}, 'levels: missing; write levels = ["0.5 m/s"]'),
        (SA | {"periods": ["0.2 s", "2 s"]}, "periods: unknown key"),
        (SA | {"periods": ["0.2 s", "2 s"]}, "the measure sa takes measure, levels, period, damping"),
        ({"measure": "pgv", "levels": ["0.1 g"]}, '"0.1 g" is a mass, not a speed; write a peak ground velocity'),
        ({"measure": "pgv", "levels": ["0.3 m/s", "0.1 m/s"]}, 'not in ascending order; write ["0.1 m/s", "0.3 m/s"]'),
        ({"measure": "scale", "levels": ["2 g"]}, "has a unit, but a scale factor is a plain number"),
        ({"measure": "scale", "levels": [0.0, 1.0]}, "must be greater than 0 and finite"),
        (SA | {"levels": []}, "the list is empty"),
        ({"measure": "sa_avg", "periods": ["2 s", "0.2 s"], "levels": ["0.1 g"]}, "is empty; write the shorter period"),
        ({"measure": "sa_avg", "periods": "0.2 s", "levels": ["0.1 g"]}, '"0.2 s" is not two periods'),
    ],
)
def test_what_is_no_table_of_levels_is_refused(table, sentence):
    with pytest.raises(PoundingError) as error:
        scene(intensity=table)
    assert sentence in str(error.value)
    assert "records.intensity" in str(error.value)


@pytest.mark.parametrize(
    ("records", "grid", "sentence"),
    [
        ({"pga": "0.5 g"}, None, "records.intensity: pga and intensity are both given, and each sets the amplitude"),
        ({"sa": {"value": "0.4 g", "period": "1 s"}}, None, "records.intensity: sa and intensity are both given"),
        ({"to_median": "pgv"}, None, "records.intensity: to_median and intensity are both given"),
        ({"scale": 2.0}, None, "records.scale: intensity and scale are both given, and each sets the amplitude"),
        ({}, {"pga": ["0.1 g"]}, "records.intensity: the grid has a pga, which sets the amplitude; remove intensity"),
    ],
)
def test_what_sets_the_amplitude_too_is_refused(records, grid, sentence):
    with pytest.raises(PoundingError) as error:
        scene(grid, intensity=SA, **records)
    assert sentence in str(error.value)


def test_factors_may_follow_the_median_as_scale_does():
    """FEMA P-695 normalises its records and scales them together."""
    factors = {"measure": "scale", "levels": [0.5, 2.0]}
    records = {"names": ["RSN6-180", "RSN1690-090"], "to_median": "pgv"}
    study = scene(intensity=factors, **records)
    alone = scene(**records)
    for motion, other in zip(motions_of(study), motions_of(alone), strict=True):
        assert motion.digest == other.digest
    for other, value in (("pga", "0.5 g"), ("sa", {"value": "0.4 g", "period": "1 s"}), ("scale", 2.0)):
        with pytest.raises(PoundingError, match="both given, and each sets the amplitude; remove one"):
            scene(intensity=factors, **{other: value})


def test_records_keep_their_amplitude_before_levels_of_a_measure():
    study = scene(intensity=SA)
    assert motions_of(study)[0].digest == motions_of(scene())[0].digest


def test_an_axis_of_records_scale_names_the_levels():
    with pytest.raises(PoundingError, match=r'intensity = \{measure = "scale", levels = \[0.5, 1.0\]\}'):
        scene(grid={'"records.scale"': [0.5, 1.0]})


def test_the_schema_takes_levels():
    validator = Draft202012Validator(json.loads(json.dumps(pr.schema())))
    tables = parse_scene(scene_text(records={"intensity": SA}), "scene.toml").resolved()
    assert not list(validator.iter_errors(tables))
    tables["records"]["intensity"]["measure"] = "pgd"
    assert [error for error in validator.iter_errors(tables)]
