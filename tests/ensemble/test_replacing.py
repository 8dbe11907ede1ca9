"""Finished results are never replaced silently: only the same command of the same study writes over them unasked."""

from functools import partial
from pathlib import Path

import pytest
import xarray as xr
from commands import refused, run
from scenes import two_records
from sentences import refusal

import pounding_risk as pr
from pounding_risk.ensemble.replacing import check_replaceable, read_finished
from pounding_risk.ensemble.scan import scan, scan_shard
from pounding_risk.errors import PoundingError, Stopped
from pounding_risk.results.check import MARKS
from pounding_risk.results.files import open_results, save
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies.convert import convert

SMALL = two_records().replace('["5 mm", "10 mm", "20 mm", "40 mm"]', '["5 mm", "20 mm"]').replace("0.3 g", "0.2 g")
SMALL = SMALL.replace('"RSN6-180", "RSN1690-090"', '"RSN6-180"')
OTHER = SMALL.replace('gap = "20 mm"', 'gap = "25 mm"').replace('period = "0.3 s"', 'period = "0.4 s"')
SUFFIXES = (".nc", pytest.param(".zarr", marks=pytest.mark.complete))


def bytes_of(target: Path) -> dict[str, bytes]:
    """Every file of a dataset."""
    files = sorted(target.rglob("*")) if target.is_dir() else [target]
    return {str(file): file.read_bytes() for file in files if file.is_file()}


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.parametrize("with_study", [True, False])
@pytest.mark.complete
def test_another_study_is_refused_with_the_differences(tmp_path, suffix, with_study, says):
    """Whether or not the folder of the study is still beside it; and nothing is touched."""
    target = tmp_path / f"results{suffix}"
    scan(parse_scene(SMALL), target)
    if not with_study:
        (tmp_path / "results.study").rename(tmp_path / "elsewhere")
    before = bytes_of(target)
    says(refusal(scan, parse_scene(OTHER), target, screening=False))
    assert bytes_of(target) == before
    assert with_study or not (tmp_path / "results.study").exists()
    says(refusal(scan_shard, parse_scene(OTHER), target, "1/2"))
    scan(parse_scene(OTHER), target, new=True)
    assert open_results(target).attrs["scene_resolved"] == parse_scene(OTHER).to_toml()


@pytest.mark.parametrize("suffix", SUFFIXES)
@pytest.mark.complete
def test_the_same_study_is_made_again_and_a_title_does_not_count(tmp_path, suffix):
    target = tmp_path / f"results{suffix}"
    first = scan(parse_scene(SMALL), target)
    xr.testing.assert_identical(scan(parse_scene(SMALL), target), first)
    renamed = scan(parse_scene(f'[scene]\nname = "Another title"\n{SMALL}'), target)
    assert renamed.attrs["title"] == "Another title"


@pytest.mark.complete
def test_a_new_program_a_new_library_and_other_records_are_differences(tmp_path):
    """As the file's own attributes tell them."""
    target = tmp_path / "results.nc"
    study = parse_scene(SMALL)
    scan(study, target)
    sound = open_results(target)
    changes = {
        "kernels_digest": (
            "0123",
            "pounding_risk: its source was changed since, in what numbers depend on (_jit, models, motions, scene, "
            "solver, ensemble, results, units.py)",
        ),
        "versions": (sound.attrs["versions"].replace('"numpy": "', '"numpy": "0.'), 'numpy: was "0.'),
        "motions_sha256": (
            sound.attrs["motions_sha256"].replace(": ", ": x", 0).replace('-180": "', '-180": "0'),
            "RSN6-180",
        ),
        "options": ('{"check_fraction": 0.5, "screening": true}', "check_fraction: was 0.5, is 0.01"),
    }
    for name, (value, words) in changes.items():
        save(sound.assign_attrs({name: value}), target)
        assert words in refusal(scan, study, target), name


def test_what_was_begun_with_leave_goes_on_without_being_asked_again(tmp_path):
    """--new, Ctrl-C after some of it, and the same command without --new."""
    target = tmp_path / "results.nc"
    scan(parse_scene(SMALL), target)

    def stop(done: int, total: int) -> None:
        if done:
            raise KeyboardInterrupt

    with pytest.raises(Stopped):
        scan(parse_scene(OTHER), target, new=True, workers=1, progress=stop)
    assert open_results(target).attrs["scene_resolved"] == parse_scene(SMALL).to_toml()
    scan(parse_scene(OTHER), target)
    assert open_results(target).attrs["scene_resolved"] == parse_scene(OTHER).to_toml()


def test_a_foreign_file_and_another_command_s_are_never_replaced_unasked(tmp_path, says):
    study = parse_scene(SMALL)
    target = tmp_path / "results.nc"
    foreign = (b"", b"precious notes", None)
    for content in foreign:
        if content is None:
            xr.Dataset({"impact_count": ("x", [1.0])}).to_netcdf(target)
        else:
            target.write_bytes(content)
        before = target.read_bytes()
        assert "is there already and holds no results of pounding-risk" in refusal(scan, study, target)
        assert target.read_bytes() == before
    scan(study, target, new=True)
    calls = (pr.accuracy, pr.effects, pr.histories, partial(pr.compare, laws=["linear", "hertz"]))
    says([refusal(call, study, target) for call in calls])
    assert read_finished(target).command == "scan"


@pytest.mark.complete
def test_every_command_s_file_is_known(tmp_path):
    """By a dimension or a variable that only its datasets have."""
    # A law that other tests compile too, in fixed steps and under a passing wave.
    law = '"viscous_elastoplastic"\nrestitution = 0.65'
    text = SMALL.replace('"linear"', law).replace("1e5 kN/m", "2.75e9 N/m^1.5")
    study = parse_scene(text)
    files = {name: tmp_path / f"{name}.nc" for name in (*MARKS, "histories", "simulate", "scan")}
    laws = ["linear", "viscous_elastoplastic"]
    scan(study, files["scan"])
    save(pr.simulate(study), files["simulate"])
    pr.histories(study, files["histories"], gaps=[0.005])
    pr.compare(study, files["compare"], laws=laws)
    pr.accuracy(study, files["accuracy"], cases=2, budget=0.2, scipy=False)
    waves = '[effects]\nwave_passage = {velocity = "500 m/s", distance = "9 m"}\n'
    pr.effects(parse_scene(text + waves), files["effects"], repeats=1)
    pr.spectra(study, out=files["spectra"], periods=(0.3, 0.6), num=2)
    pr.amplification(study, out=files["amplification"], num=2, num_gaps=2)
    drawn = '[uncertain]\nsamples = 2\nbuilding.left.period = {distribution = "lognormal", dispersion = 0.2}\n'
    pr.uncertainty(parse_scene(text + drawn), files["uncertainty"])
    save(pr.damage(files["scan"], states=[pr.DamageState("tiles", displacement="9 mm")]), files["damage"])
    assert [read_finished(file).command for file in files.values()] == list(files)
    for name, file in files.items():
        check_replaceable(file, name)
    with pytest.raises(PoundingError, match=r'holds the finished compare of .*\n  - building\[1\].period: was "0.3 s"'):
        pr.compare(parse_scene(study.to_toml().replace("0.3 s", "0.4 s")), files["compare"], laws=laws)


def test_the_commands(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("a.toml").write_text(SMALL)
    Path("b.toml").write_text(OTHER)

    assert run("scan", "a.toml", "-o", "r.nc").exit_code == 0
    before = Path("r.nc").read_bytes()
    assert 'building[1].period: was "0.3 s", is "0.4 s"' in refused("scan", "b.toml", "-o", "r.nc")
    for words in (("simulate", "a.toml", "-o", "r.nc"), ("effects", "a.toml", "-o", "r.nc")):
        assert "holds the results of scan" in refused(*words), words
    assert Path("r.nc").read_bytes() == before
    assert run("scan", "b.toml", "-o", "r.nc", "--new").exit_code == 0
    refused("rerun", "r.nc", "-o", "r.nc")
    assert run("scan", "a.toml").exit_code == 0
    assert "a.nc exists already; write -o a.nc to make the same study again" in refused("scan", "a.toml")
    assert run("scan", "a.toml", "--new").exit_code == 0


@pytest.mark.complete
def test_a_conversion_replaces_nothing_but_the_same_results(tmp_path, says):
    first, other = tmp_path / "a.nc", tmp_path / "b.nc"
    scan(parse_scene(SMALL), first)
    scan(parse_scene(OTHER), other)
    convert(first, tmp_path / "a.zarr")
    convert(first, tmp_path / "a.zarr")
    says(refusal(convert, other, tmp_path / "a.zarr"))
    (tmp_path / "precious.nc").write_text("notes")
    says(refusal(convert, tmp_path / "a.zarr", tmp_path / "precious.nc"))
    assert (tmp_path / "precious.nc").read_text() == "notes"
    xr.testing.assert_identical(open_results(tmp_path / "a.zarr"), open_results(first))
