"""What [records] of a scene stands for: names, files, folders and sets, turned, scaled, and what is left out.

A manifest of them comes back as it was, and says what is not as it was.
"""

import csv
import json
import re
import shutil
from dataclasses import replace
from hashlib import sha256
from pathlib import Path

import numpy as np
import obspy
import pytest
from scenes import scene_text, single
from sentences import refusal

from pounding_risk import assess
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue, manifest
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.intensity import measure, response_spectra
from pounding_risk.motions.manifest import check_manifest, read_manifest, write_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import open_source, read_motion
from pounding_risk.motions.record import copies, recording
from pounding_risk.motions.record_sets import load, members
from pounding_risk.motions.request import RecordRequest, Spectral
from pounding_risk.motions.rotation import rotated
from pounding_risk.motions.scaling import by_factor
from pounding_risk.motions.selection import select
from pounding_risk.motions.target_spectra import read_target
from pounding_risk.motions.write import write_motion
from pounding_risk.results.attributes import as_text
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


def test_a_scene_tells_what_it_leaves_out(folder, says):
    def reading(files):
        return parse_scene(f'{SCENE}files = ["{files}"]\n', str(folder / "scene.toml"))

    plan = validate(reading("."))
    assert len(plan.records) == 3
    (folder / "empty").mkdir()
    (folder / "empty" / "a.md").write_text("nothing\n")
    says(plan.left_out, [refusal(gathered, reading(files)) for files in ("notes.md", "empty")])


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


TWO_MASSES = f'{SCENE}files = ["."]\npolarity = ["as recorded", "reversed"]\n'


@pytest.fixture
def twice(tmp_path):
    """El Centro as PEER's file, the same file again, as columns of seven digits, turned round, and cut; and Corralitos.

    Columns without the station's name: nothing but the samples tells what they are of.
    """
    shutil.copy(catalogue.path("RSN6-180"), tmp_path / "a.AT2")
    shutil.copy(catalogue.path("RSN6-180"), tmp_path / "b.AT2")
    motion = read_motion("RSN6-180")
    for name, samples in (
        ("c", motion.acceleration),
        ("d", -motion.acceleration),
        ("e", motion.acceleration[120:4000]),
        ("g", 2.0 * motion.acceleration),
    ):
        np.savetxt(tmp_path / f"{name}.csv", samples, fmt="%.7g", header="unit = m/s^2\ndt = 0.01 s")
    shutil.copy(catalogue.path("RSN753-000"), tmp_path / "f.AT2")
    return tmp_path


def kinds(found):
    return [(copy.place, copy.original, round(copy.factor, 3), copy.same_times) for copy in found]


def test_the_relations_of_two_records_are_told_apart():
    """Known by construction: the same, turned round, scaled, cut at both ends, every second sample, another record."""
    one, other = (read_motion(name).acceleration for name in ("RSN6-180", "RSN753-000"))
    found = copies(
        [
            (one, 0.01),
            (-one, 0.01),
            (3.0 * one, 0.01),
            (one[100:4000], 0.01),
            (one[::2], 0.02),
            (np.append(one, np.zeros(7)), 0.01),
            (other[: len(one)], 0.005),
            (one, 0.012),
        ]
    )
    assert kinds(found) == [
        (1, 0, -1.0, True),
        (2, 0, 3.0, True),
        (3, 0, 1.0, False),
        (4, 0, pytest.approx(1.0, abs=0.01), False),  # every second sample has about half the sum of squares
        (5, 0, 1.0, True),
    ]


def test_no_two_horizontals_of_the_published_sets_are_copies():
    """A hundred records, components of one station and stations of one earthquake among them."""
    every = [member for name in ("fema-p695-farfield", "fema-p695-nearfield") for member in members(name)]
    traces = [load(member).trace for member in every]
    assert copies([(trace.data, trace.stats.delta) for trace in traces]) == ()
    own = [open_source(entry.id).trace for entry in catalogue.entries()]
    assert copies([(trace.data, trace.stats.delta) for trace in own]) == ()


def test_rounding_makes_no_other_record_and_a_filter_does():
    """Whole counts of a record that peaks at 3000 of them, and a conversion with 981 cm/s² a g."""
    samples = read_motion("RSN6-180").acceleration
    counts = np.round(3000.0 * samples / np.abs(samples).max())
    (copy,) = copies([(samples, 0.01), (counts * np.abs(samples).max() / 3000.0 * 981.0 / 980.665, 0.01)])
    assert copy.is_same_motion()
    filtered = read_motion("RSN6-180", processing=[{"step": "bandpass", "low": "0.3 Hz", "high": "20 Hz"}]).acceleration
    assert copies([(samples, 0.01), (filtered, 0.01)]) == ()


@pytest.mark.complete
def test_the_same_motion_is_used_once_and_what_differs_shares_a_recording(twice, says):
    found = read_ensemble(PLAIN._replace(files=(".",)), twice)
    assert [motion.name for motion in found.motions] == ["a", "d", "e", "f", "g"]
    says(found.left_out, [f"{motion.name}: {', '.join(motion.flags)}" for motion in found.motions])
    assert len(found.copies) == 5


@pytest.mark.parametrize("aim", [{"pga": 3.0}, {"sa": Spectral(0.5, 0.05, 4.0)}])
def test_copies_of_another_size_are_one_motion_where_all_are_scaled_to_one(twice, aim):
    found = read_ensemble(PLAIN._replace(files=("a.AT2", "g.csv"), **aim), twice)
    assert [motion.name for motion in found.motions] == ["a"]


def test_a_median_counts_a_record_once(twice):
    """Of PGA 2.754 and 6.323 m/s² the median is their mean, with or without a copy of the first."""
    alone = read_ensemble(PLAIN._replace(files=("a.AT2", "f.AT2"), to_median="pga"), twice).motions
    again = read_ensemble(PLAIN._replace(files=("a.AT2", "b.AT2", "c.csv", "f.AT2"), to_median="pga"), twice).motions
    assert [motion.pga for motion in again] == [motion.pga for motion in alone]
    assert alone[0].pga == pytest.approx((2.75366 + 6.32261) / 2.0, rel=1e-5)


def test_components_and_polarities_are_no_copies():
    names = ("RSN6-180", "RSN6-270", "CCC-HN1", "CCC-HN2")
    found = read_ensemble(PLAIN._replace(names=names, polarities=("as recorded", "reversed")), None)
    assert len(found.motions) == 4 and found.copies == () and found.left_out == ()


def test_a_copy_in_a_pair_of_components_is_left_out_before_the_row_turns_them(twice):
    for name in ("RSN6-180", "RSN6-270"):
        shutil.copy(catalogue.path(name), twice / f"{name}.AT2")
    request = PLAIN._replace(files=("RSN6-180.AT2", "b.AT2", "RSN6-270.AT2"), direction=200.0)
    (turned,) = read_ensemble(request, twice).motions
    (known,) = read_ensemble(PLAIN._replace(names=("RSN6-180", "RSN6-270"), direction=200.0), twice).motions
    assert np.array_equal(turned.acceleration, known.acceleration)


def test_a_component_that_is_its_partners_copy_is_named_where_the_partner_is_missed(twice):
    request = PLAIN._replace(files=("a.AT2", "b.AT2"), direction=200.0)
    with pytest.raises(RecordError, match=r"there is a\.AT2; .* excluded: .*b\.AT2 is a copy of the file .*a\.AT2"):
        read_ensemble(request, twice)


@pytest.mark.complete
def test_scan_and_assessment_count_a_record_once(twice, tmp_path):
    """Two recordings, whatever lies beside them in the folder, and the evidence says so."""
    study = parse_scene(TWO_MASSES, str(twice / "scene.toml"))
    plan = validate(study)
    assert len(plan.records) == 5 and len(plan.left_out) == 2
    dataset = scan(study, check_fraction=0.0)
    assert dataset["record_recording"].values.tolist() == [0, 0, 0, 1, 0]
    (interface,) = assess(dataset).interfaces
    assert interface.verdict.recordings == 2
    (told,) = (sentence for sentence in interface.verdict.evidence if sentence.startswith("Records: "))
    assert "b.AT2 is a copy of the file" in told and "and 2 more" in told
    twice = parse_scene(TWO_MASSES.replace('"."', '"a.AT2", "b.AT2", "c.csv"'), str(twice / "scene.toml"))
    (interface,) = assess(scan(twice, check_fraction=0.0)).interfaces
    assert (interface.verdict.motions, interface.verdict.recordings) == (2, 1)


@pytest.mark.complete
def test_a_dataset_of_an_older_version_that_holds_a_record_twice_tells_it():
    """Its motions have the same digest; the records' facts do not tell."""
    names = ["RSN6-180", "RSN753-000", "RSN77-164"]
    dataset = scan(parse_scene(TWO_MASSES.replace('files = ["."]', f"names = {json.dumps(names)}")), check_fraction=0.0)
    digests = json.loads(dataset.attrs["motions_sha256"])
    digests["RSN753-000"] = digests["RSN6-180"]
    found = assess(dataset.assign_attrs(motions_sha256=as_text(digests))).interfaces[0].verdict
    assert (found.motions, found.recordings) == (6, 2)
    told = "Records: RSN753-000 holds the same motion as RSN6-180: it counts twice in the shares, scan again."
    assert told in found.evidence


def test_a_selection_chooses_a_record_once():
    motions = [read_motion(name) for name in ("RSN6-180", "RSN753-000", "RSN1690-090")]
    again = [*motions, motions[0].reversed(), motions[1].scaled_to("1 g")]
    goal = read_target("asce7:sds=1.0,sd1=0.6,tl=8")
    once, twice = (select(candidates, goal, count=3) for candidates in (motions, again))
    assert [row.name for row in once.rows] == [row.name for row in twice.rows]
    assert twice.left_out == {"being a copy of another candidate": 2}


DEAD = {"zeros": np.zeros(900), "a level": np.full(900, 0.3), "hardly a motion": 1e-7 * np.sin(np.arange(900.0))}


@pytest.mark.parametrize("words", DEAD)
def test_a_record_without_motion_is_no_motion_that_closes_no_gap(tmp_path, says, words):
    np.savetxt(tmp_path / "dead.csv", DEAD[words], fmt="%.9g", header="unit = m/s^2\ndt = 0.01 s")
    told = refusal(read_motion, tmp_path / "dead.csv")
    says(told)
    assert told in refusal(scan, parse_scene(TWO_MASSES, str(tmp_path / "scene.toml")))


def test_counts_over_an_infinite_sensitivity_are_no_motion(tmp_path):
    """The stages of its StationXML make another one."""
    shutil.copy(catalogue.path("NAPA-HNE"), tmp_path)
    station = (catalogue.records_folder() / "CE.68150.xml").read_text()
    value = station.partition("<InstrumentSensitivity>")[2].partition("<Value>")[2].partition("</Value>")[0]
    (tmp_path / "CE.68150.xml").write_text(station.replace(f"<Value>{value}</Value>", "<Value>inf</Value>"))
    (file,) = tmp_path.glob("NAPA*")
    with pytest.raises(RecordError, match=r"CE\.68150\.xml: .* a total sensitivity of inf counts per m/s²"):
        read_motion(file)


def test_a_window_without_motion_is_refused():
    samples = np.concatenate([np.zeros(1000), np.sin(0.1 * np.arange(1000.0))])
    trace = obspy.Trace(samples, {"delta": 0.01, "station": "S"})
    with pytest.raises(RecordError, match=r"\.S\.\., 0 to 5 s: every sample is 0 m/s²: .* check its window"):
        read_motion(trace, window=(0.0, 5.0))


def test_a_dead_record_of_an_older_dataset_counts_against_the_verdict():
    dataset = scan(
        parse_scene(TWO_MASSES.replace('files = ["."]', 'names = ["RSN6-180", "RSN753-000"]')), check_fraction=0.0
    )
    dead = dataset.assign_coords(record_pga=("record", [0.0, 6.3])).copy(deep=True)
    dead["peak_closing_free"][0] = 0.0
    found = assess(dead, gap=1.0).interfaces[0].verdict
    assert found.motions == 2  # those of the other record
    assert "Without a finite response, and counted against the verdict: 2 motions." in found.evidence
    assert any("RSN6-180 holds no motion" in sentence for sentence in found.evidence)


def test_a_file_that_is_written_again_is_a_copy(tmp_path):
    """As `records process` writes it, with the facts of the record."""
    write_motion(read_motion("RSN753-090"), tmp_path / "again.csv")
    shutil.copy(catalogue.path("RSN753-090"), tmp_path / "one.AT2")
    assert len(read_ensemble(PLAIN._replace(files=("*",)), tmp_path).motions) == 1
