"""What [records] of a scene stands for: names, files, folders and sets, turned, scaled, and what is left out."""

import shutil

import numpy as np
import pytest

from pounding_risk import catalogue
from pounding_risk.ensemble import scan
from pounding_risk.errors import RecordError, SceneError
from pounding_risk.gather import gather, gathered
from pounding_risk.measures import measure, response_spectra
from pounding_risk.motions import read_motion
from pounding_risk.plan import validate
from pounding_risk.record_request import RecordRequest, Spectral
from pounding_risk.rotation import rotated
from pounding_risk.scenario import parse_scene

G = 9.80665
PLAIN = RecordRequest((), (), None, None, None, ("as recorded",), "auto", 0.0)
PAIR = PLAIN._replace(names=("RSN6-180", "RSN6-270"))
SCENE = """
[[building]]
name = "left"
mass = "10 t"
period = "0.5 s"
[[building]]
name = "right"
mass = "10 t"
period = "0.3 s"
[[interface]]
gap = "20 mm"
contact_model = "linear"
stiffness = "1e5 kN/m"
[records]
"""


@pytest.fixture
def folder(tmp_path):
    """Both horizontals and the vertical of El Centro, two raw components with their StationXML, and a note."""
    for name in ("RSN6-180", "RSN6-270", "RSN6-UP"):
        shutil.copy(catalogue.path(name), tmp_path / f"{name}.AT2")
    for name in ("NAPA-HNE", "NAPA-HNZ"):
        shutil.copy(catalogue.path(name), tmp_path)
    shutil.copy(catalogue.records_folder() / "CE.68150.xml", tmp_path)
    (tmp_path / "notes.md").write_text("from the archive\n")
    return tmp_path


def names(found):
    return [motion.name for motion in found.motions]


def test_a_folder_stands_for_its_horizontal_records(folder):
    found = gather(PLAIN._replace(files=(".",)), folder)
    assert names(found) == ["NAPA-HNE", "RSN6-180", "RSN6-270"]
    assert found.left_out == ("NAPA-HNZ: vertical", "RSN6-UP: vertical", "notes.md: not a record")
    assert np.array_equal(found.motions[1].acceleration, read_motion("RSN6-180").acceleration)
    assert np.allclose(found.motions[0].acceleration, read_motion("NAPA-HNE").acceleration, rtol=1e-9, atol=1e-12)


def test_a_pattern_leaves_verticals_out_and_a_name_does_not(folder):
    assert names(gather(PLAIN._replace(files=("*.AT2",)), folder)) == ["RSN6-180", "RSN6-270"]
    assert names(gather(PLAIN._replace(files=("RSN6-UP.AT2",)), folder)) == ["RSN6-UP"]


def test_a_file_named_twice_is_read_once(folder):
    assert names(gather(PLAIN._replace(files=("RSN6-180.AT2", "*.AT2")), folder)) == ["RSN6-180", "RSN6-270"]


def test_records_of_one_name_are_told_apart(folder):
    for part in ("a", "b"):
        (folder / part).mkdir()
        shutil.copy(folder / "RSN6-180.AT2", folder / part / "x.AT2")
    assert names(gather(PLAIN._replace(files=("*/x.AT2",)), folder)) == ["a/x", "b/x"]


def test_a_scene_tells_what_it_leaves_out(folder, capsys):
    study = parse_scene(SCENE + 'files = ["."]\n', str(folder / "scene.toml"))
    plan = validate(study)
    assert plan.left_out == ("NAPA-HNZ: vertical", "RSN6-UP: vertical", "notes.md: not a record")
    assert len(plan.records) == 3
    (folder / "scene.toml").write_text(SCENE + 'files = ["notes.md"]\n')
    with pytest.raises(RecordError, match="is not a known record format"):
        gathered(parse_scene(SCENE + 'files = ["notes.md"]\n', str(folder / "scene.toml")))
    (folder / "empty").mkdir()
    (folder / "empty" / "a.md").write_text("nothing\n")
    with pytest.raises(SceneError, match=r"empty matches no record; left out: a\.md: not a record"):
        gathered(parse_scene(SCENE + 'files = ["empty"]\n', str(folder / "scene.toml")))


def test_two_components_are_turned_to_the_row():
    (turned,) = gather(PAIR._replace(direction=200.0), None).motions
    first, second = read_motion("RSN6-180"), read_motion("RSN6-270")
    assert np.array_equal(turned.acceleration, rotated(first, second, 200.0).acceleration)
    count = len(turned.acceleration)
    by_hand = first.acceleration[:count] * np.cos(np.deg2rad(20.0)) + second.acceleration[:count] * np.cos(
        np.deg2rad(-70.0)
    )
    assert np.abs(turned.acceleration - by_hand).max() < 1e-14  # rounding of two products
    (along,) = gather(PAIR._replace(direction=180.0), None).motions
    assert np.allclose(along.acceleration, first.acceleration[:count], rtol=0.0, atol=1e-15)


def test_a_component_without_its_partner_has_no_direction():
    with pytest.raises(RecordError) as caught:
        gather(PAIR._replace(names=("RSN6-180",), direction=0.0), None)
    assert str(caught.value) == (
        "direction: of Imperial Valley-02, California at El Centro Array #9 the scene names RSN6-180; a row's "
        "direction takes the two horizontal components of each recording: name both, or leave direction out"
    )


def test_every_record_is_scaled_to_one_spectral_acceleration():
    found = gather(PAIR._replace(sa=Spectral(1.0, 0.05, 0.4 * G), tail=2.0), None).motions
    for motion in found:
        kept = motion.acceleration[: -round(2.0 / motion.dt)]
        spectrum = response_spectra(kept, motion.dt, [1.0])
        assert spectrum.pseudo_acceleration[0] == pytest.approx(0.4 * G, rel=1e-12)


def test_both_components_keep_one_factor_to_the_median_and_then_the_common_one():
    ids = ("RSN6-180", "RSN6-270", "RSN77-164", "RSN77-254", "RSN753-000", "RSN753-090")
    before = [read_motion(name) for name in ids]
    after = gather(PLAIN._replace(names=ids, to_median="pgv", scale=2.0), None).motions
    factors = [new.pga / old.pga for new, old in zip(after, before, strict=True)]
    assert factors[0::2] == pytest.approx(factors[1::2], rel=1e-12)
    speeds = [measure(motion.acceleration, motion.dt).pgv for motion in before]
    means = np.sqrt(np.array(speeds[0::2]) * np.array(speeds[1::2]))
    assert factors[0::2] == pytest.approx(2.0 * np.median(means) / means, rel=1e-12)


def test_a_window_comes_before_the_scale():
    (motion,) = gather(
        PLAIN._replace(names=("RSN6-180",), window=(0.0, 6.0), sa=Spectral(0.5, 0.05, 0.5 * G)), None
    ).motions
    assert motion.duration == pytest.approx(6.0)
    assert response_spectra(motion.acceleration, motion.dt, [0.5]).pseudo_acceleration[0] == pytest.approx(0.5 * G)
    assert [sentence.partition(":")[0] for sentence in motion.processing] == ["units", "window", "scale"]


def test_a_set_drives_a_scan():
    scene = parse_scene(SCENE.replace("20 mm", "2 m") + 'set = "fema-p695-nearfield-pulse"\npga = "0.3 g"\n')
    dataset = scan(scene)
    assert dataset.sizes["record"] == 28
    assert (dataset["simulated"] == 0).all()  # a gap of 2 m is never closed
