"""The motion without contact of samples against scans of the same scenes, and what the dataset says of itself."""

import json

import numpy as np
import pytest
from sentences import refusal

import pounding_risk as pr
from pounding_risk.assessment.demands import motions_of
from pounding_risk.errors import SceneError
from pounding_risk.results.opened import Results
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies import uncertainty
from pounding_risk.studies.uncertainty import AT_ONCE, ONE_BY_ONE, free_along, free_motion

MASS = '[[building]]\nname = "{}"\nmass = "{} t"\nperiod = "{} s"\n'
PAIR = MASS.format("a", 500, 0.5) + MASS.format("b", 800, 1.0)
ROW = PAIR + MASS.format("c", 300, 0.7)
BY_STIFFNESS = PAIR.replace('period = "0.5 s"', 'stiffness = "80 MN/m"')
STOREYS = """[[building]]
name = "s"
floor_masses = ["210 t", "210 t"]
storey_stiffnesses = "350 MN/m"
storey_heights = "3 m"
"""
BETWEEN = '[[interface]]\ngap = "40 mm"\ncontact_model = "kelvin_voigt"\nstiffness = "93.5 kN/mm"\nrestitution = 0.6\n'
RECORDS = '[records]\nnames = ["RSN6-180"]\npolarity = ["as recorded", "reversed"]\nwindow = ["0 s", "4 s"]\n'
TWO_KEYS = '"building.a.period" = ["0.3 s", "0.08 s", "2 s"]\n"building.a.damping" = [0.02, 0.1, 0.3]'
TOLERANCE = 1e-12  # of the largest value: scans have other nodes


def scene(buildings: str = PAIR, axes: str = TWO_KEYS, more: str = "", grid: str = ""):
    """A scene whose axes, one key a line, move together; ``more`` are other sections."""
    keys = [line.partition(" =")[0] for line in axes.splitlines()]
    together = f"zip = [[{', '.join(keys)}]]\n" if len(keys) > 1 else ""
    return parse_scene(f"{buildings}{BETWEEN}{RECORDS}{more}[grid]\n{grid}{axes}\n{together}")


def along(study, **options):
    """`free_along` of the one axis of a scene."""
    (axis,) = study.axes
    return free_along(study, axis, **options)


def assert_that_of_a_scan(dataset, study):
    scanned = pr.scan(study, check_fraction=0.0)
    for name in ("peak_closing_free", "peak_displacement_free"):
        expected = scanned[name].broadcast_like(dataset[name]).transpose(*dataset[name].dims).values
        assert expected.max() > 0.01
        np.testing.assert_allclose(dataset[name].values, expected, rtol=0.0, atol=TOLERANCE * expected.max())
    for name in ("building_period", "building_damping", "building_mass"):
        expected = scanned[name].broadcast_like(dataset[name]).transpose(*dataset[name].dims).values
        np.testing.assert_allclose(dataset[name].values, expected, rtol=1e-14)
    assert set(json.loads(dataset.attrs["flags"])) == set(json.loads(scanned.attrs["flags"]))
    for name in ("records", "motions_sha256", "scene_resolved", "processing"):
        assert dataset.attrs[name] == scanned.attrs[name]


AT_ONCE_SCENES = {
    "a pair": (
        PAIR,
        TWO_KEYS + '\n"building.b.mass" = ["1 t", "20 t", "3 t"]\n"interface.restitution" = [0.3, 0.5, 0.7]',
    ),
    "both buildings by one key": (PAIR, '"building.damping" = [0.02, 0.1]'),
    "a wall": (MASS.format("a", 500, 0.5) + '[[building]]\nname = "w"\nrigid = true\n', TWO_KEYS),
    "a row": (ROW, '"building.c.period" = ["0.3 s", "0.9 s"]\n"building.2.period" = ["0.2 s", "0.4 s"]'),
    "stiffness and mass": (
        BY_STIFFNESS,
        '"building.a.stiffness" = ["60 MN/m", "90 MN/m"]\n"building.a.mass" = ["450 t", "550 t"]',
    ),
    "a mass on a stated stiffness": (BY_STIFFNESS, '"building.a.mass" = ["450 t", "550 t"]'),
    "contact alone": (PAIR, '"interface.restitution" = [0.3, 0.7]'),
}


ONE_BY_ONE_SCENES = {
    "storeys": (PAIR + STOREYS, '"building.s.floor_masses.2" = ["190 t", "230 t"]'),
    "an own ground": (PAIR + 'ground_delay = "0.1 s"\n', TWO_KEYS),
    "a start in motion": (PAIR, '"building.a.initial_velocity" = ["0.1 m/s", "0.2 m/s"]'),
    "an effect on buildings": (PAIR.replace('s"\n', 's"\nheight = "9 m"\n'), TWO_KEYS, "[effects.p_delta]\n"),
}


@pytest.mark.parametrize("name", AT_ONCE_SCENES | ONE_BY_ONE_SCENES)
def test_single_masses_are_solved_at_once_and_other_scenes_one_by_one(name):
    study = scene(*(AT_ONCE_SCENES | ONE_BY_ONE_SCENES)[name])
    dataset = along(study)
    assert dataset.attrs["free_motion"] == (AT_ONCE if name in AT_ONCE_SCENES else ONE_BY_ONE)
    assert_that_of_a_scan(dataset, study)


def test_amplitudes_of_the_grid_scale_the_motion():
    study = scene(grid='pga = ["0.2 g", "0.5 g"]\n')
    dataset = along(study)
    assert dataset["peak_closing_free"].dims == (study.axes[0].name, "record", "polarity", "pga", "interface")
    assert_that_of_a_scan(dataset, study)


def test_samples_that_move_alike_are_solved_once(monkeypatch):
    study = scene(PAIR, '"building.b.mass" = ["1 t", "20 t", "3 t"]')
    expected = along(study)
    monkeypatch.setattr(uncertainty, "facts_of_masses", lambda *_: None)
    steps = []
    found = along(study, progress=lambda done, total: steps.append((done, total)))
    assert steps == [(1, 1)]
    np.testing.assert_allclose(found["peak_closing_free"], expected["peak_closing_free"], rtol=1e-12)
    np.testing.assert_array_equal(found["building_mass"], expected["building_mass"])


def test_threads_change_no_bit():
    study = scene()
    one, many = along(study, workers=1), along(study, workers=3)
    assert one.equals(many)


def test_the_demands_of_a_sample_are_read_as_those_of_a_scan():
    study = scene()
    (axis,) = study.axes
    dataset = along(study)
    ((name, part),) = Results(dataset.isel({axis.name: 1})).interfaces
    scanned = pr.scan(study, check_fraction=0.0).isel({axis.name: 1})
    ((same, other),) = Results(scanned).interfaces
    found, expected = motions_of(part), motions_of(other)
    assert name == same
    for key in ("records", "polarities", "amplitudes"):
        assert getattr(found, key) == getattr(expected, key)
    np.testing.assert_array_equal(found.recordings, expected.recordings)
    np.testing.assert_allclose(found.closing, expected.closing, rtol=1e-12)


def test_a_row_says_that_neighbours_may_push():
    assert "push a building across a gap" in along(scene(ROW, TWO_KEYS)).attrs["notes"]
    assert "push" not in along(scene()).attrs["notes"]


def test_flags_tell_of_the_stiffest_sample():
    study = scene(axes='"building.a.period" = ["0.5 s", "0.05 s", "0.4 s"]')
    assert "time step" in along(study).attrs["flags"]
    assert "time step" not in along(scene(axes='"building.a.period" = ["0.5 s", "0.4 s"]')).attrs["flags"]


def test_too_many_samples_for_the_memory_are_refused(monkeypatch, says):
    monkeypatch.setattr(uncertainty, "free_memory", lambda: 100.0)
    says(refusal(along, scene(), kind=SceneError))


def test_another_axis_of_the_grid_is_refused(says):
    study = scene(axes='"building.a.period" = ["0.5 s", "0.4 s"]')
    both = scene(axes='"building.a.period" = ["0.5 s", "0.4 s"]', grid='"building.b.damping" = [0.02, 0.05]\n')
    says(refusal(free_along, both, study.axes[0], kind=SceneError))


DRAWN = """[uncertain]
samples = 5
seed = 3
"building.a.period" = {distribution = "lognormal", median = "0.5 s", dispersion = 0.2}
"building.b.damping" = {distribution = "uniform", low = 0.02, high = 0.08}
"interface.gap" = {distribution = "normal", mean = "40 mm", cov = 0.1}
"""


def test_samples_of_uncertain_numbers_are_those_of_a_scan():
    study = parse_scene(PAIR + BETWEEN + RECORDS + DRAWN)
    dataset, scanned = free_motion(study), pr.scan(study, check_fraction=0.0)
    assert dataset["peak_closing_free"].dims == ("sample", "record", "polarity", "interface")
    for name in ("peak_closing_free", "peak_displacement_free"):
        expected = scanned[name].broadcast_like(dataset[name]).transpose(*dataset[name].dims)
        np.testing.assert_allclose(dataset[name], expected, rtol=1e-12)
    np.testing.assert_array_equal(dataset["sample_gap"][:, 0], dataset["interface.gap"])
    for key in study.uncertain.keys:
        np.testing.assert_array_equal(dataset[key], scanned[key])
    np.testing.assert_array_equal(dataset["sample"], np.arange(5))
    assert "no power of two" in dataset.attrs["notes"]


def test_other_points_than_those_of_the_scene(says):
    study = parse_scene(PAIR + BETWEEN + RECORDS + DRAWN)
    own = free_motion(study)
    points = study.uncertain.points()[[4, 1]]
    given = free_motion(study, points)
    np.testing.assert_array_equal(given["peak_closing_free"], own["peak_closing_free"][[4, 1]])
    assert "power of two" not in given.attrs["notes"]
    says(refusal(free_motion, study, points[:, :2]))


def test_a_scene_without_uncertain_numbers_is_refused(says):
    says(refusal(free_motion, parse_scene(PAIR + BETWEEN + RECORDS), kind=SceneError))


def test_a_dataset_is_written_and_read(tmp_path):
    dataset = free_motion(parse_scene(PAIR + BETWEEN + RECORDS + DRAWN))
    pr.save(dataset, tmp_path / "free.nc")
    read = pr.open_results(tmp_path / "free.nc")
    assert read.equals(dataset)
    assert read.attrs["free_motion"] == AT_ONCE
