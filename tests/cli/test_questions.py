"""Commands of questions: every file that one writes, motions of any source, samples, exports, faulty options."""

import csv
import re
import shlex
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from axes import pair_text
from commands import SCENE, done, run
from golden_commands import prepare
from scenes import BOTH, scene_text, storeyed
from sweeps import sweep
from uncertain import uncertain_text

import pounding_risk as pr
from pounding_risk.questions import declared_questions
from pounding_risk.scene.toml import write_toml

# A command of each question with a figure, on the scenes of the golden files.
WRITTEN = [
    "accuracy one.toml --cases 1 --budget 0.2 --no-scipy -o accuracy.nc --figure accuracy.svg",
    "advise pair.toml --figure advise.svg",
    "amplification pair.toml --num 3 --num-gaps 2 -o amplification.nc --table table.csv --figure amplification.svg",
    "assess levels.nc --hazard hazard.csv -o assess.json --figure assess.svg",
    "compare compare.toml --law jankowski --law linear -o compare.nc --figure compare.svg",
    "damage levels.nc --method ida -o damage.nc --figure damage.svg --ida-figure ida.svg",
    "effects effects.toml -o effects.nc --figure effects.svg",
    "modes row.toml --figure modes.svg",
    "separations pair.nc -o separations.csv --figure separations.svg",
    "simulate one.toml -o simulate.nc --figure simulate.svg --animation simulate.html",
    "spectra pair.toml --num 3 -o spectra.nc --figure spectra.svg",
    "uncertainty uncertain.toml -o uncertainty.nc --figure uncertainty.svg",
    "verify hertz_1881 --figure verify.svg",
]
NUMBERS = {"building.left.period": {"distribution": "lognormal", "dispersion": 0.2}}
PULSES = [{"kind": "ricker", "pga": "0.4 g", "period": f"{period} s"} for period in (0.5, 0.8, 1.2)]
UNCERTAIN = {"law": "linear", "gap": "60 mm", "records": {"generated": PULSES, "polarity": BOTH}}
FEW = ["--num", "3", "--periods", "0.3 s", "0.9 s"]


@pytest.fixture(scope="module")
def folder(tmp_path_factory) -> Path:
    """The scenes of the golden files, one with samples, and results of some."""
    folder = tmp_path_factory.mktemp("questions")
    prepare(folder)
    text = f"{scene_text(**UNCERTAIN)}\n{write_toml({'uncertain': {'samples': 8} | NUMBERS})}"
    (folder / "samples.toml").write_text(text, encoding="utf-8")
    for name in ("pair", "levels", "samples"):
        pr.save(pr.scan(folder / f"{name}.toml", check_fraction=0.0), folder / f"{name}.nc")
    return folder


@pytest.mark.parametrize("line", sweep(WRITTEN, *(line for line in WRITTEN if line.startswith(("spectra", "ampl")))))
def test_every_file_that_is_asked_for_is_written_and_told(folder, line, monkeypatch):
    """A dataset is of its question, and its finding is printed."""
    monkeypatch.chdir(folder)
    name, *words = shlex.split(line)
    told = done(name, *words)
    written = re.findall(r"^written: (.+)$", told.stdout, re.MULTILINE)
    assert {word for option, word in pairwise(words) if option == "-o" or "figure" in option} <= set(written)
    assert all(Path(file).stat().st_size > 500 for file in written)
    for file in written:
        if file.endswith(".nc"):
            dataset = pr.open_results(file)
            assert dataset.pounding.kind == name and dataset.attrs.get("finding", "") in told.stdout


def test_every_question_with_a_figure_has_a_command_here():
    drawn = {name for name, each in declared_questions().items() if getattr(each.module(), "FIGURES", {})}
    assert drawn == {line.split()[0] for line in WRITTEN}


def test_motions_of_spectra_are_named_by_any_word(tmp_path, monkeypatch):
    """Ids, recipes and files, each alone, in both polarities; options treat them as those of a scene would."""
    monkeypatch.chdir(tmp_path)
    options = shlex.split("--window '0 s' '5 s' --pga '0.5 g' --motions -o s.nc --damping '2 %' --damping '7 %'")
    told = done("spectra", "RSN6-180", *FEW, *options)
    assert "2 motions at PGA 0.5 g (1 record in both polarities)" in told.stdout
    assert "damping      2 % beside 7 %" in told.stdout
    records = pr.Records(["RSN6-180"], window=("0 s", "5 s"), pga="0.5 g", polarity=BOTH)
    own = pr.spectra(records, periods=("0.3 s", "0.9 s"), num=3, damping=("2 %", "7 %"), motions=True)
    np.testing.assert_array_equal(pr.open_results("s.nc")["required_gap_of_motion"], own["required_gap_of_motion"])
    done("spectra", "ricker: pga=0.4 g, period=0.8 s", *FEW, "--tail", "2 s")
    Path("mine.csv").write_text("".join(f"{np.sin(0.3 * k):.4f}\n" for k in range(400)))
    done("spectra", "mine.csv", *FEW, "--unit", "m/s^2", "--dt", "0.02 s")


def test_motions_of_amplification_stand_for_masses_at_several_periods_and_gaps():
    words = shlex.split("--num 3 --num-gaps 2 --period '0.4 s' --period '0.8 s' --mass-ratio 2 --gaps '1 cm' '5 cm'")
    told = done("amplification", "ricker: pga=0.4 g, period=0.8 s", *words, "--percentile", "84")
    assert "contact stereomechanical; its jumps have no finite acceleration" in told.stdout
    assert "m(left) / m(right) = 2" in told.stdout and "beside" in told.stdout and "gap / SRSS" not in told.stdout


def test_demands_and_a_script_are_written_and_told(folder, tmp_path):
    told = done("export", folder / "pair.nc", "--to", "pelicun", "-o", tmp_path / "demands")
    assert told.output.count("written: ") == len(list((tmp_path / "demands").iterdir())) >= 4
    assert "note: demands are those at a gap of 20 mm" in told.output
    script = tmp_path / "m.py"
    done("export", folder / "pair.toml", "--to", "opensees", "-o", script, "--set", "interface.gap=7 mm")
    assert "gap 7 mm" in script.read_text()


def test_damage_states_of_a_file_are_those_of_the_table(folder):
    states = folder / "states.toml"
    states.write_text('[[damage]]\nname = "blow"\ncontact_force = "50 kN"\n', encoding="utf-8")
    done("damage", folder / "levels.nc", "--states", states, "-o", folder / "blow.csv")
    rows = csv.DictReader((folder / "blow.csv").read_text(encoding="utf-8").splitlines())
    assert [(row["state"], row["pounding"]) for row in rows] == [("blow", "with"), ("blow", "without")]


def test_samples_are_read_and_assess_says_the_same(folder):
    results = folder / "samples.nc"
    told = done("uncertainty", results, "--output", "peak_penetration", "--target", "20 %")
    assert "in the variance of peak penetration" in told.stdout
    assert "at 90 %" not in told.stdout and "No run of contact" not in told.stdout
    usual = run("uncertainty", results, "--gap", "70 mm")
    assessed = done("assess", results, "--gap", "70 mm", "--figure", folder / "a.svg")
    assert all(line in assessed.stdout for line in usual.stdout.splitlines())
    assert "--select sample=0" in assessed.stdout and (folder / "a.svg").exists()
    assert "left | right" in done("assess", results, "--select", "sample=0").stdout


@pytest.mark.complete
def test_every_interface_of_a_row_has_its_own_part(tmp_path):
    buildings = (storeyed("A", "200 t", "9e7 N/m", storeys=2), storeyed("B", "300 t", "3e7 N/m", storeys=2))
    row = scene_text(*buildings, storeyed("C", "150 t", "3e8 N/m", storeys=2), **UNCERTAIN)
    numbers = {"building.B.damping": {"distribution": "lognormal", "median": 0.05, "dispersion": 0.4}}
    scene = tmp_path / "row.toml"
    scene.write_text(f"{row}\n{write_toml({'uncertain': {'samples': 4} | numbers})}", encoding="utf-8")
    told = done("uncertainty", scene, "--figure", tmp_path / "row.svg")
    assert "\nA | B\n" in told.stdout and "\nB | C\n" in told.stdout
    assert "neighbours further along the row may push" in told.stdout


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
def refusals(tmp_path_factory) -> Path:
    """Scenes, results of two of them, and what stands in the way of files."""
    refusals = tmp_path_factory.mktemp("refusals")
    for name, text in FILES.items():
        (refusals / name).write_text(text, encoding="utf-8")
    for name in ("pair", "samples"):
        pr.save(pr.scan(refusals / f"{name}.toml", check_fraction=0.0), refusals / f"{name}.nc")
    (refusals / "folder.nc").mkdir()
    for name in ("taken.toml", "taken.nc"):
        (refusals / name).write_text(FILES["scene.toml"], encoding="utf-8")
    (refusals / "data.nc").write_bytes(b"\x89HDF\r\n\x1a\n")
    return refusals


@pytest.mark.parametrize("line", REFUSED.strip().splitlines())
def test_faulty_options_are_refused_before_any_work(line, refusals, monkeypatch, says):
    monkeypatch.chdir(refusals)
    before = {path.name: path.stat().st_mtime_ns for path in refusals.iterdir()}
    done = run(*shlex.split(line.format(COMPARED=COMPARED, GIVEN=GIVEN, PERIODS=PERIODS)))
    assert (done.exit_code, done.stdout) == (2, ""), done.output
    assert done.stderr.startswith("pounding-risk: ")
    says(done.stderr.removeprefix("pounding-risk: "))
    assert {path.name: path.stat().st_mtime_ns for path in refusals.iterdir()} == before
