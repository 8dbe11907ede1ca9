"""What [records] of a scene stands for: names, files, folders and sets, turned, scaled, and what is left out.

A manifest of them comes back as it was, and says what is not as it was.
"""

from __future__ import annotations

import csv
import re
import shutil
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import pytest
from scenes import scene_text, single
from sentences import refusal

from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import RecordError, SceneError
from pounding_risk.motions import catalogue, manifest
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.intensity import measure, response_spectra
from pounding_risk.motions.manifest import check_manifest, read_manifest, write_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import open_source, read_motion
from pounding_risk.motions.record import recording
from pounding_risk.motions.request import RecordRequest, Spectral
from pounding_risk.motions.rotation import rotated
from pounding_risk.motions.scaling import by_factor
from pounding_risk.motions.selection import select
from pounding_risk.motions.target_spectra import read_target
from pounding_risk.scene.motions import gathered
from pounding_risk.scene.reader import parse_scene

G = 9.80665
PLAIN = RecordRequest()
SA = Spectral(1.0, 0.05, 0.4 * G)
PAIR = PLAIN._replace(names=("RSN6-180", "RSN6-270"))
SCENE = scene_text(
    single("left", "10 t", "0.5 s"),
    single("right", "10 t", "0.3 s"),
    law="linear",
    gap="20 mm",
    records={"names": None},
)


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
    found = read_ensemble(PLAIN._replace(files=(".",)), folder)
    assert names(found) == ["NAPA-HNE", "RSN6-180", "RSN6-270"]
    assert found.left_out == (f"{folder / 'notes.md'} is not a record", "NAPA-HNZ is vertical", "RSN6-UP is vertical")
    assert np.array_equal(found.motions[1].acceleration, read_motion("RSN6-180").acceleration)
    assert np.allclose(found.motions[0].acceleration, read_motion("NAPA-HNE").acceleration, rtol=1e-9, atol=1e-12)


@pytest.mark.parametrize(
    ("files", "expected"),
    [
        (("*.AT2",), ["RSN6-180", "RSN6-270"]),
        (("RSN6-UP.AT2",), ["RSN6-UP"]),
        (("RSN6-180.AT2", "*.AT2"), ["RSN6-180", "RSN6-270"]),
        (("*/x.AT2",), ["a/x.AT2", "b/x.AT2"]),
        (("x.*",), ["x.E", "x.N"]),
    ],
)
def test_names_and_patterns_of_files(folder, files, expected):
    """A pattern leaves verticals out and a name does not; a file twice is one; shared names get folder or suffix."""
    for other, component in (("a/x.AT2", "180"), ("b/x.AT2", "270"), ("x.N", "180"), ("x.E", "270")):
        (folder / other).parent.mkdir(exist_ok=True)
        shutil.copy(folder / f"RSN6-{component}.AT2", folder / other)
    assert names(read_ensemble(PLAIN._replace(files=files), folder)) == expected


def test_text_that_is_no_table_is_no_record_of_a_folder(folder):
    """A README.txt lies beside the files of many archives; numbers without a unit are samples, and are asked after."""
    (folder / "README.txt").write_text("Files of the archive:\none for each component\n")
    found = read_ensemble(PLAIN._replace(files=(".",)), folder)
    assert names(found) == ["NAPA-HNE", "RSN6-180", "RSN6-270"]
    assert f"{folder / 'README.txt'} is not a record" in found.left_out
    for text, sentence in (("0.1\n0.2\n", "says neither the unit"), ("", "is empty")):
        (folder / "README.txt").write_text(text)
        with pytest.raises(RecordError, match=sentence):
            read_ensemble(PLAIN._replace(files=(".",)), folder)


def test_a_scene_tells_what_it_leaves_out(folder, capsys):
    study = parse_scene(SCENE + 'files = ["."]\n', str(folder / "scene.toml"))
    plan = validate(study)
    assert plan.left_out == (f"{folder / 'notes.md'} is not a record", "NAPA-HNZ is vertical", "RSN6-UP is vertical")
    assert len(plan.records) == 3
    (folder / "scene.toml").write_text(SCENE + 'files = ["notes.md"]\n')
    with pytest.raises(RecordError, match="is not a known record format"):
        gathered(parse_scene(SCENE + 'files = ["notes.md"]\n', str(folder / "scene.toml")))
    (folder / "empty").mkdir()
    (folder / "empty" / "a.md").write_text("nothing\n")
    with pytest.raises(SceneError, match=r"empty matches no record; excluded: .*a\.md is not a record"):
        gathered(parse_scene(SCENE + 'files = ["empty"]\n', str(folder / "scene.toml")))


def test_two_components_are_turned_to_the_row():
    (turned,) = read_ensemble(PAIR._replace(direction=200.0), None).motions
    first, second = read_motion("RSN6-180"), read_motion("RSN6-270")
    assert np.array_equal(turned.acceleration, rotated(first, second, 200.0).acceleration)
    count = len(turned.acceleration)
    by_hand = first.acceleration[:count] * np.cos(np.deg2rad(20.0)) + second.acceleration[:count] * np.cos(
        np.deg2rad(-70.0)
    )
    assert np.abs(turned.acceleration - by_hand).max() < 1e-14  # rounding of two products
    (along,) = read_ensemble(PAIR._replace(direction=180.0), None).motions
    assert np.allclose(along.acceleration, first.acceleration[:count], rtol=0.0, atol=1e-15)


def test_stationxml_tells_where_the_components_of_a_file_point(folder):
    """Its azimuths are those of the catalogue; the vertical of Napa has one too, and no dip."""
    shutil.copy(catalogue.path("NAPA-HNN"), folder)
    request = PLAIN._replace(files=("NAPA-*.mseed",), direction=30.0, processing="none")
    (turned,) = read_ensemble(request, folder).motions
    (known,) = read_ensemble(
        PAIR._replace(names=("NAPA-HNE", "NAPA-HNN"), direction=30.0, processing="none"), None
    ).motions
    assert np.allclose(turned.acceleration, known.acceleration, rtol=1e-9, atol=1e-12)
    assert not any("azimuths are unknown" in flag for flag in turned.flags)


def test_a_component_without_its_partner_has_no_direction(says):
    says(refusal(read_ensemble, PAIR._replace(names=("RSN6-180",), direction=0.0), None))


@pytest.mark.parametrize("window", [None, (0.0, 6.0)])
def test_every_record_is_scaled_to_one_spectral_acceleration(window):
    """That of what a window leaves of it, and without the tail."""
    found = read_ensemble(PAIR._replace(sa=SA, tail=2.0, window=window), None).motions
    for motion in found:
        kept = motion.without_tail().acceleration
        assert window is None or len(kept) == 601
        spectrum = response_spectra(kept, motion.dt, [1.0])
        assert spectrum.pseudo_acceleration[0] == pytest.approx(0.4 * G, rel=1e-12)


def test_both_components_keep_one_factor_to_the_median_and_then_the_common_one():
    ids = ("RSN6-180", "RSN6-270", "RSN77-164", "RSN77-254", "RSN753-000", "RSN753-090")
    before = [read_motion(name) for name in ids]
    after = read_ensemble(PLAIN._replace(names=ids, to_median="pgv", scale=2.0), None).motions
    factors = [new.pga / old.pga for new, old in zip(after, before, strict=True)]
    assert factors[0::2] == pytest.approx(factors[1::2], rel=1e-12)
    speeds = [measure(motion.acceleration, motion.dt).pgv for motion in before]
    means = np.sqrt(np.array(speeds[0::2]) * np.array(speeds[1::2]))
    assert factors[0::2] == pytest.approx(2.0 * np.median(means) / means, rel=1e-12)


RIVALS = {
    "sa scale": {"sa": SA, "scale": 2.0},
    "pga scale": {"pga": 4.0, "scale": 2.0},
    "pga to_median": {"pga": 4.0, "to_median": "pgv"},
    "sa to_median": {"sa": SA, "to_median": "pgv"},
    "names set": {"set": "fema-p695-farfield"},
    "names manifest": {"manifest": "a.csv"},
    "manifest direction": {"names": (), "manifest": "a.csv", "direction": 20.0},
    "manifest sa": {"names": (), "manifest": "a.csv", "sa": SA},
}


@pytest.mark.parametrize("words", RIVALS)
def test_what_excludes_each_other_is_refused_in_a_call_as_in_a_scene_file(words, tmp_path, says):
    request = PAIR._replace(**RIVALS[words])
    told = refusal(read_ensemble, request, None)
    says(told)
    (tmp_path / "a.csv").touch()
    study = parse_scene(SCENE + 'names = ["RSN6-180"]\n', str(tmp_path / "scene.toml")).updated(records=request)
    for call in (lambda: parse_scene(study.to_toml(), study.source), lambda: gathered(study)):
        assert told in refusal(call)


@pytest.mark.parametrize("changed", [{"scale": 2.0}, {"sa": SA}, {"to_median": "pga"}], ids=lambda key: next(iter(key)))
def test_an_amplitude_beside_that_of_the_grid_is_refused_in_a_call_too(changed, says):
    study = parse_scene(SCENE + 'names = ["RSN6-180"]\n[grid]\npga = ["0.2 g", "0.4 g"]\n')
    says(refusal(gathered, study.updated(records=study.records._replace(**changed))))


def test_one_chain_treats_what_is_named_listed_and_read_alone(tmp_path):
    """Window, factor and tail act in one order, and to the same bits, whoever asks."""
    asked = {"window": (1.0, 9.0), "scale": 1.5, "tail": 2.0}
    alone = read_motion("RSN6-180", **asked)
    (named,) = read_ensemble(PLAIN._replace(names=("RSN6-180",), **asked), None).motions
    write_manifest([read_motion("RSN6-180")], tmp_path / "a.csv")
    (listed,) = read_ensemble(PLAIN._replace(manifest="a.csv", **asked), tmp_path).motions
    whole = read_motion("RSN6-180").acceleration
    by_hand = np.pad(1.5 * whole[100:901], (0, 201))  # 0.01 s apart, both ends of the window included, a step to zero
    for motion in (alone, named, listed):
        assert np.array_equal(motion.acceleration, by_hand)
        assert [sentence.partition(":")[0] for sentence in motion.processing] == ["units", "window", "scale", "tail"]
        assert motion.record["factor"] == 1.5 and motion.record["cut_from_start"] == 1.0
        assert motion.flags == alone.flags


def test_a_set_drives_a_scan():
    scene = parse_scene(SCENE.replace("20 mm", "2 m") + 'set = "fema-p695-nearfield-pulse"\npga = "0.3 g"\n')
    dataset = scan(scene)
    assert dataset.sizes["record"] == 28
    assert (dataset["simulated"] == 0).all()  # a gap of 2 m is never closed


def test_a_choice_of_records_drives_a_scene_with_its_factors(folder, tmp_path):
    candidates = [read_motion(path) for path in sorted(folder.glob("RSN6-[12]*.AT2"))]
    candidates += [read_motion("RSN753-000"), read_motion("CCC-HN1")]
    chosen = select(candidates, read_target("asce7:sds=1.0,sd1=0.6,tl=8"), count=3)
    write_manifest(chosen.motions(), tmp_path / "selected.csv")
    study = parse_scene(SCENE + 'manifest = "selected.csv"\ntail = "1 s"\n', str(tmp_path / "scene.toml"))
    told = dict(validate(study).summary())["records"]
    assert told.endswith(
        ", each times its factor of selected.csv, at least 1 s of free vibration after (whole time steps)"
    )
    assert parse_scene(study.to_toml(), study.source) == study
    found = gathered(study).motions
    assert [motion.name for motion in found] == [motion.name for motion in chosen.motions()]
    for motion, asked in zip(found, chosen.motions(), strict=True):
        count = len(asked.acceleration)
        assert np.array_equal(motion.acceleration[:count], asked.acceleration)
        straight = motion.dt * (asked.acceleration[-1] != 0.0)  # to zero
        assert motion.duration == pytest.approx(asked.duration + straight + 1.0)


def test_a_manifest_whose_files_have_changed_is_refused(folder, says):
    motion = read_motion(folder / "RSN6-180.AT2", pga="0.4 g")
    path = write_manifest([motion], folder / "selected.csv")
    scene = str(folder / "scene.toml")
    study = parse_scene(SCENE + 'manifest = "selected.csv"\n', scene)
    assert gathered(study).motions[0].pga == pytest.approx(0.4 * G, rel=1e-12)
    assert "RSN6-180.AT2," in path.read_text()
    trend = 'manifest = "selected.csv"\nprocessing = [{step = "trend", order = 3}]\n'
    says(refusal(gathered, parse_scene(SCENE + trend, scene)))
    shutil.copy(folder / "RSN6-270.AT2", folder / "RSN6-180.AT2")
    says(refusal(gathered, study))
    for values in ({"factor": ""}, {"name": "", "PGA [m/s2]": ""}, {"factor": "nan"}, {"factor": "-1"}, None):
        write_manifest([motion], path)
        with path.open(encoding="utf-8", newline="") as file:
            head, row = csv.reader(file)
        row = [] if values is None else [{**dict(zip(head, row, strict=True)), **values}[key] for key in head]
        with path.open("w", encoding="utf-8", newline="") as file:
            csv.writer(file).writerows([head, row] if row else [head])
        says(refusal(gathered, study))
    for other in (motion.reversed(), rotated(read_motion("RSN6-180"), read_motion("RSN6-270"), 20.0)):
        write_manifest([other], path)
        says(refusal(gathered, study))


EXCLUDED = {
    "no file": 'manifest = "no.csv"',
    "an amplitude": 'manifest = "a.csv"\npga = "0.5 g"',
    "a direction": 'manifest = "a.csv"\ndirection = "20 deg"',
    "an amplitude of the grid": 'manifest = "a.csv"\n[grid]\npga = ["0.5 g"]',
}


@pytest.mark.parametrize("words", EXCLUDED)
def test_what_a_manifest_excludes(tmp_path, says, words):
    (tmp_path / "a.csv").touch()
    says(refusal(parse_scene, f"{SCENE}{EXCLUDED[words]}\n", str(tmp_path / "scene.toml")))


def test_raw_components_of_a_row_pass_one_filter():
    """The stricter corners of both: a rotated motion would otherwise hold a band of which it has only one half."""
    (turned,) = read_ensemble(PLAIN._replace(names=("NAPA-HNE", "NAPA-HNN"), direction=40.0), None).motions
    filters = [sentence.partition("bandpass: ")[2] for sentence in turned.processing if "bandpass" in sentence]
    bands = [re.search(r", (\S+) to (\S+) Hz", words).groups() for words in filters]
    assert len(bands) == 2 and bands[0] == bands[1]
    assert turned.processing[-1].startswith("corners of the band-pass: the stricter of 2 components: ")
    assert turned.record["low_corner"] > 0.0 and turned.record["high_corner"] == 40.0  # by which buildings are judged
    assert turned.record["lowest_usable_frequency"] == pytest.approx(1.25 * turned.record["low_corner"])
    alone = [read_motion(name) for name in ("NAPA-HNE", "NAPA-HNN")]
    own = [re.search(r"bandpass: .*?, (\S+) to (\S+) Hz", " ".join(motion.processing)).groups() for motion in alone]
    assert bands[0] == (max((low for low, _ in own), key=float), min((high for _, high in own), key=float))


def test_two_earthquakes_of_one_day_at_one_station_are_two_recordings():
    """Where no event is told, as of MiniSEED, the minute in which a record starts tells them apart."""
    traces = [catalogue.load(name)[0] for name in ("NAPA-HNE", "NAPA-HNN")]
    facts = [dict(open_source(trace).record) for trace in traces]
    later = {**facts[0], "start": "2014-08-24T11:00:00"}
    assert recording(facts[0], "a") == recording(facts[1], "b") != recording(later, "c")


@pytest.fixture(scope="module")
def motions() -> list[Motion]:
    own = Motion("own, with a comma", np.array([0.1, -1.0 / 3.0, 0.2]), 0.005, {})
    return [read_motion("RSN6-180", pga="0.5 g"), read_motion("CCC-HNZ"), own, own.reversed()]


def test_rows_come_back(motions, tmp_path):
    """Every number with every digit; what is unknown is None again."""
    path = write_manifest(motions, tmp_path / "m.csv")
    check_manifest(path, motions)
    rows = read_manifest(path)
    assert rows == manifest.manifest(motions)
    assert path.read_text(encoding="utf-8").count("\n") == 5  # a header and four records
    first, raw, own, _ = rows
    assert first["sha256"] == sha256(Path(catalogue.path("RSN6-180")).read_bytes()).hexdigest()
    assert (first["magnitude"], first["npts"], first["dt [s]"]) == (6.95, 5372, 0.01)
    assert first["PGA [m/s2]"] == pytest.approx(0.5 * 9.80665, rel=1e-12) and first["azimuth [deg]"] == 180.0
    assert first["processing"].split(" | ") == list(motions[0].processing)
    assert raw["state"] == "raw" and raw["azimuth [deg]"] is None
    assert own["event"] is None and own["duration [s]"] == 0.01 and own["PGA [m/s2]"] == 1.0 / 3.0


def test_every_difference_is_told(motions, tmp_path, says):
    path = write_manifest(motions, tmp_path / "m.csv")
    changed = replace(motions[1], record={**motions[1].record, "sha256": "f" * 64})
    stronger = by_factor(motions[2], 2.0)
    says(refusal(check_manifest, path, [changed, stronger, Motion("new", np.ones(3), 0.01, {})]))


def test_a_damaged_manifest_is_refused(motions, tmp_path, says):
    path = write_manifest(motions, tmp_path / "m.csv")
    text = path.read_text(encoding="utf-8")
    for old, new in (("npts", "n"), ("5372", "many")):
        path.write_text(text.replace(old, new), encoding="utf-8")
        says(refusal(read_manifest, path))
    path.write_text(text.replace("\n", "\n\n", 1).replace("5372", "many"), encoding="utf-8")
    assert refusal(read_manifest, path).startswith(f"{path}, line 3: npts is ")  # a blank line is a line


def test_places_that_cannot_be(motions, tmp_path, says):
    says(refusal(write_manifest, motions, tmp_path / "no" / "m.csv"), refusal(read_manifest, tmp_path / "m.csv"))
