"""Records that are there twice, under whatever name, format, sign, size or length, count once."""

from __future__ import annotations

import json
import shutil

import numpy as np
import obspy
import pytest
from scenes import BOTH, scene_text, single
from sentences import refusal

from pounding_risk import assess
from pounding_risk.ensemble.plan.plan import validate
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import RecordError
from pounding_risk.motions import catalogue
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.read import open_source, read_motion
from pounding_risk.motions.record import copies
from pounding_risk.motions.record_sets import load, members
from pounding_risk.motions.request import RecordRequest, Spectral
from pounding_risk.motions.selection import select
from pounding_risk.motions.target_spectra import read_target
from pounding_risk.motions.write import write_motion
from pounding_risk.results.attributes import as_text
from pounding_risk.scene.reader import parse_scene

PLAIN = RecordRequest()
SCENE = scene_text(
    single("left", "10 t", "0.5 s"),
    single("right", "10 t", "0.3 s"),
    law="linear",
    gap="20 mm",
    records={"files": ["."], "polarity": BOTH},
)


@pytest.fixture
def folder(tmp_path):
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
def test_the_same_motion_is_used_once_and_what_differs_shares_a_recording(folder, says):
    found = read_ensemble(PLAIN._replace(files=(".",)), folder)
    assert [motion.name for motion in found.motions] == ["a", "d", "e", "f", "g"]
    says(found.left_out, [f"{motion.name}: {', '.join(motion.flags)}" for motion in found.motions])
    assert len(found.copies) == 5


@pytest.mark.parametrize("aim", [{"pga": 3.0}, {"sa": Spectral(0.5, 0.05, 4.0)}])
def test_copies_of_another_size_are_one_motion_where_all_are_scaled_to_one(folder, aim):
    found = read_ensemble(PLAIN._replace(files=("a.AT2", "g.csv"), **aim), folder)
    assert [motion.name for motion in found.motions] == ["a"]


def test_a_median_counts_a_record_once(folder):
    """Of PGA 2.754 and 6.323 m/s² the median is their mean, with or without a copy of the first."""
    alone = read_ensemble(PLAIN._replace(files=("a.AT2", "f.AT2"), to_median="pga"), folder).motions
    again = read_ensemble(PLAIN._replace(files=("a.AT2", "b.AT2", "c.csv", "f.AT2"), to_median="pga"), folder).motions
    assert [motion.pga for motion in again] == [motion.pga for motion in alone]
    assert alone[0].pga == pytest.approx((2.75366 + 6.32261) / 2.0, rel=1e-5)


def test_components_and_polarities_are_no_copies():
    names = ("RSN6-180", "RSN6-270", "CCC-HN1", "CCC-HN2")
    found = read_ensemble(PLAIN._replace(names=names, polarities=("as recorded", "reversed")), None)
    assert len(found.motions) == 4 and found.copies == () and found.left_out == ()


def test_a_copy_in_a_pair_of_components_is_left_out_before_the_row_turns_them(folder):
    for name in ("RSN6-180", "RSN6-270"):
        shutil.copy(catalogue.path(name), folder / f"{name}.AT2")
    request = PLAIN._replace(files=("RSN6-180.AT2", "b.AT2", "RSN6-270.AT2"), direction=200.0)
    (turned,) = read_ensemble(request, folder).motions
    (known,) = read_ensemble(PLAIN._replace(names=("RSN6-180", "RSN6-270"), direction=200.0), folder).motions
    assert np.array_equal(turned.acceleration, known.acceleration)


def test_a_component_that_is_its_partners_copy_is_named_where_the_partner_is_missed(folder):
    request = PLAIN._replace(files=("a.AT2", "b.AT2"), direction=200.0)
    with pytest.raises(RecordError, match=r"there is a\.AT2; .* excluded: .*b\.AT2 is a copy of the file .*a\.AT2"):
        read_ensemble(request, folder)


@pytest.mark.complete
def test_scan_and_assessment_count_a_record_once(folder, tmp_path):
    """Two recordings, whatever lies beside them in the folder, and the evidence says so."""
    study = parse_scene(SCENE, str(folder / "scene.toml"))
    plan = validate(study)
    assert len(plan.records) == 5 and len(plan.left_out) == 2
    dataset = scan(study, check_fraction=0.0)
    assert dataset["record_recording"].values.tolist() == [0, 0, 0, 1, 0]
    (interface,) = assess(dataset).interfaces
    assert interface.verdict.recordings == 2
    (told,) = (sentence for sentence in interface.verdict.evidence if sentence.startswith("Records: "))
    assert "b.AT2 is a copy of the file" in told and "and 2 more" in told
    twice = parse_scene(SCENE.replace('"."', '"a.AT2", "b.AT2", "c.csv"'), str(folder / "scene.toml"))
    (interface,) = assess(scan(twice, check_fraction=0.0)).interfaces
    assert (interface.verdict.motions, interface.verdict.recordings) == (2, 1)


@pytest.mark.complete
def test_a_dataset_of_an_older_version_that_holds_a_record_twice_tells_it():
    """Its motions have the same digest; the records' facts do not tell."""
    names = ["RSN6-180", "RSN753-000", "RSN77-164"]
    dataset = scan(parse_scene(SCENE.replace('files = ["."]', f"names = {json.dumps(names)}")), check_fraction=0.0)
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
    assert told in refusal(scan, parse_scene(SCENE, str(tmp_path / "scene.toml")))


def test_counts_over_an_infinite_sensitivity_are_no_motion(tmp_path):
    """What a StationXML with a sensitivity of inf makes of a record: zeros."""
    shutil.copy(catalogue.path("NAPA-HNE"), tmp_path)
    station = (catalogue.records_folder() / "CE.68150.xml").read_text()
    value = station.partition("<InstrumentSensitivity>")[2].partition("<Value>")[2].partition("</Value>")[0]
    (tmp_path / "CE.68150.xml").write_text(station.replace(f"<Value>{value}</Value>", "<Value>inf</Value>"))
    (file,) = tmp_path.glob("NAPA*")
    with pytest.raises(RecordError, match=file.name):
        read_motion(file)


def test_a_window_without_motion_is_refused():
    samples = np.concatenate([np.zeros(1000), np.sin(0.1 * np.arange(1000.0))])
    trace = obspy.Trace(samples, {"delta": 0.01, "station": "S"})
    with pytest.raises(RecordError, match=r"\.S\.\., 0 to 5 s: every sample is 0 m/s²: .* check its window"):
        read_motion(trace, window=(0.0, 5.0))


def test_a_dead_record_of_an_older_dataset_counts_against_the_verdict():
    dataset = scan(
        parse_scene(SCENE.replace('files = ["."]', 'names = ["RSN6-180", "RSN753-000"]')), check_fraction=0.0
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
