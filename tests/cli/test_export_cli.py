"""The command `export`: files are written and told; what cannot be is a sentence and status 2."""

from __future__ import annotations

import pytest
from commands import refused, run
from scenes import scene_text


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A scene, and the results of its scan."""
    made = tmp_path_factory.mktemp("export")
    (made / "s.toml").write_text(scene_text(records={"window": ["0 s", "3 s"]}), encoding="utf-8")
    assert run("scan", made / "s.toml", "-o", made / "r.nc").exit_code == 0
    return made


def test_demands_and_a_script_are_written_and_told(folder, tmp_path):
    told = run("export", folder / "r.nc", "--to", "pelicun", "-o", tmp_path / "demands")
    assert told.exit_code == 0, told.output
    assert told.output.count("written: ") == 4 and "note: demands are those at a gap of 10 mm" in told.output
    told = run("export", folder / "s.toml", "--to", "opensees", "-o", tmp_path / "m.py", "--set", "interface.gap=7 mm")
    assert told.exit_code == 0, told.output
    assert "gap 0.007 m" in (tmp_path / "m.py").read_text()


@pytest.mark.parametrize(
    ("source", "words", "sentence"),
    [
        ("r.nc", ["--to", "nrlm", "-o", "f.xml"], '--to: "nrlm" is no format (did you mean "nrml"?)'),
        ("r.nc", ["--to", "nrml", "-o", "f.txt"], "f.txt: nrml is a file that ends in .xml; choose another name"),
        ("r.nc", ["--to", "csv", "-o", "t", "--gap", "5 mm"], "--gap: has no effect on csv"),
        ("r.nc", ["--to", "nrml", "-o", "f.xml", "--set", "interface.gap=7 mm"], "--set: changes a value of a scene"),
        ("s.toml", ["--to", "opensees", "-o", "m.py", "--select", "sample=0"], "--select: is of results"),
        ("s.toml", ["--to", "csv", "-o", "t"], "csv is written from results"),
    ],
)
def test_what_cannot_be_written_is_a_sentence(folder, tmp_path, monkeypatch, source, words, sentence):
    monkeypatch.chdir(tmp_path)
    assert sentence in refused("export", folder / source, *words)
    assert not list(tmp_path.iterdir())
