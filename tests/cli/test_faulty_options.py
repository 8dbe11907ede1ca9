"""Faulty options of every command: one sentence, status 2, nothing printed and no file touched before the work."""

from __future__ import annotations

import shlex
from pathlib import Path

import pytest
from axes import pair_text
from commands import SCENE, run
from scenes import scene_text
from uncertain import uncertain_text

import pounding_risk as pr

STATES = '[[damage]]\nname = "tiles"\ndisplacement = "20 mm"\n'
FILES = {
    "scene.toml": SCENE,
    "pair.toml": STATES + scene_text(records={"window": ["0 s", "5 s"], "pga": "0.5 g"}, grid={"gap": ["10 mm"]}),
    "axes.toml": pair_text({"building.left.period": ["0.3 s", "0.5 s"], "interface.restitution": [0.5, 0.8]}),
    "samples.toml": uncertain_text(samples=2),
    "hazard.csv": "pga [g],annual rate\n0.05,0.1\n0.2,0.005\n2,1e-5\n",
    "notes.nc": "a letter",
}
COMPARED = "--law jankowski --law kelvin_voigt"
GIVEN = "--displacement left=45mm --displacement right=30mm"
PERIODS = "--period left=0.4s --period right=700ms"
# Of `records`, `block` and `draw` the modules of their tests have such lines, and of Python calls those of the calls.
REFUSED = """
validate no/scene.toml
validate .
validate scene.toml --set interface.gap=3
scan scene.toml -o no/r.nc
scan scene.toml -o r.csv
scan scene.toml -o /
scan scene.toml -o folder.nc
scan data.nc
scan taken.toml
scan scene.toml -o x.nc --figure map.jpg
scan scene.toml --check-fraction 2
scan scene.toml --shard 1/2 --strict
scan scene.toml --plan --no-screening
scan scene.toml --plan --shard 1/2
scan scene.toml --plan --scheduler tcp://127.0.0.1:1
scan scene.toml --plan --new
scan scene.toml --samples 8
simulate scene.toml -o h.txt
simulate scene.toml --gap 3
simulate scene.toml --yield-force 3t
simulate scene.toml --record RSN6-80
simulate scene.toml --record RSN7
simulate scene.toml --polarity reversed
simulate scene.toml --law hertzian
simulate scene.toml --law jankowski
simulate scene.toml --law linear
impact --law distributed_mass
impact --speed 3
impact --stiffness 3kN
impact --stiffness 3kN/m --stiffness 3N/m
impact --restitution steely
demo --out scene.toml
accuracy scene.toml -o a.txt
advise scene.toml --gap 3
amplification pair.toml --gaps '1 s' '2 s'
amplification pair.toml --period '1 m'
amplification pair.toml --pga '0.3 g'
amplification pair.toml --percentile 100
amplification pair.toml --share-of asce
amplification pair.toml --table a.txt
assess pair.nc --gap '10 kN'
assess pair.nc -o found.txt
assess pair.nc --target 84
assess pair.nc --target '1 % in 50 years'
assess pair.nc --percentile '0.9 %'
assess pair.nc --confidence 2
assess pair.nc --target-rate '2475 years'
assess pair.nc --target-rate 2475 --hazard hazard.csv
assess pair.nc --site 1
assess pair.nc --setback --gap '30 mm'
assess pair.nc --setback --hazard hazard.csv
assess pair.nc --setback --figure f.png
assess pair.nc --setback --percentile '30 %'
assess samples.nc --hazard hazard.csv
assess samples.nc -o a.json
compare pair.toml -o c.nc --speed '0 m/s'
compare pair.toml -o c.nc --speed 0.5
compare axes.toml -o c.nc {COMPARED} --figure c.png
compare axes.toml -o c.nc {COMPARED} --select interface.restitution=0.6
compare axes.toml -o c.nc {COMPARED} --select 'building.right.period=1 s'
compare axes.toml -o c.nc {COMPARED} --select interface.restitution
compare axes.toml -o c.nc {COMPARED} --interface 'left | wall'
damage pair.nc --states none.toml
damage pair.nc --gap '5 mm'
damage pair.nc --method clouds
damage pair.nc --figure d.gif
damage pair.nc -o pair.nc
export pair.nc --to csv -o t --gap '5 mm'
export pair.nc --to nrml -o f.xml --set interface.gap='7 mm'
export pair.toml --to opensees -o m.py --select sample=0
export pair.toml --to csv -o t
histories pair.nc -o pair.nc
histories pair.nc --most 0
histories pair.nc --gap '11 mm'
separations {GIVEN} --displacement left=45mm
separations {GIVEN} --behaviour-factor 0
separations {GIVEN} --behaviour-factor left=3
separations {GIVEN} --factor 3 --factor 3
separations {GIVEN} --damping 0.05
separations {GIVEN} --period left=0.4s
separations {GIVEN} --period left=0.4 --period right=0.7s
separations {GIVEN} --period left=0s --period right=0.7s
separations {GIVEN} {PERIODS} --damping 5
separations {GIVEN} {PERIODS} --damping left=0.02
separations {PERIODS}
separations --behaviour-factor 3
separations --displacement left=45mm
separations --displacement '45 mm'
separations --displacement left=45 --displacement right=30mm
separations --displacement left=-4mm --displacement right=30mm
separations --figure codes.png
separations none.nc
separations pair.nc {GIVEN}
separations pair.nc --behaviour-factor 3
separations pair.nc {PERIODS}
separations pair.nc --height '12 m'
separations pair.nc --height '12 kg' --height '3 m'
separations pair.nc --ground 0.2
separations pair.nc --factor 1
separations pair.nc --percentile 0.3
spectra nothing.toml
spectra nothing.AT2
spectra pair.toml RSN6-180
spectra pair.toml --pga '0.3 g'
spectra pair.toml --num 3 -o notes.nc
spectra RSN6-180 --set records.pga='1 g'
spectra fema-p695-farfield RSN6-180
spectra RSN6-180 'ricker: pga=0.4 g, period=0.8 s'
spectra RSN6-180 --periods '2 m' '1 s'
spectra RSN6-180 --right-periods '0 s' '1 s'
spectra RSN6-180 --damping two
spectra RSN6-180 --percentile 100
spectra RSN6-180 --pga '0.3 g' --scale 2
spectra RSN6-180 --figure s.txt
spectra RSN6-180 --rule italy --rule srss
spectra RSN6-180 --rule srss
spectra RSN6-180 -o scene.toml
uncertainty samples.nc --tornado
uncertainty samples.nc --set interface.gap='1 mm'
uncertainty samples.toml --output peak
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """Scenes, results of two of them, and what stands in the way of files."""
    folder = tmp_path_factory.mktemp("refusals")
    for name, text in FILES.items():
        (folder / name).write_text(text, encoding="utf-8")
    for name in ("pair", "samples"):
        pr.save(pr.scan(folder / f"{name}.toml", check_fraction=0.0), folder / f"{name}.nc")
    (folder / "folder.nc").mkdir()
    for name in ("taken.toml", "taken.nc"):
        (folder / name).write_text(FILES["scene.toml"], encoding="utf-8")
    (folder / "data.nc").write_bytes(b"\x89HDF\r\n\x1a\n")
    return folder


@pytest.mark.parametrize("line", REFUSED.strip().splitlines())
def test_faulty_options_are_refused_before_any_work(line, folder, monkeypatch, says):
    monkeypatch.chdir(folder)
    before = {path.name: path.stat().st_mtime_ns for path in folder.iterdir()}
    done = run(*shlex.split(line.format(COMPARED=COMPARED, GIVEN=GIVEN, PERIODS=PERIODS)))
    assert (done.exit_code, done.stdout) == (2, ""), done.output
    assert done.stderr.startswith("pounding-risk: ")
    says(done.stderr.removeprefix("pounding-risk: "))
    assert {path.name: path.stat().st_mtime_ns for path in folder.iterdir()} == before
