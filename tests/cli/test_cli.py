"""The command line: what it prints, what it refuses and in which words, and that it can be stopped."""

import ast
import importlib.util
import inspect
import io
import json
import pkgutil
import re
import sys
import time
from importlib import import_module
from math import pi, sqrt
from pathlib import Path
from types import SimpleNamespace

import pytest
from commands import SCENE, done, refused, rows, run
from processes import ended

import pounding_risk
from pounding_risk import cli
from pounding_risk.cli._common import progress
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.questions import declared_questions

MODULES = {
    name: import_module(f"pounding_risk.cli.{name}")
    for _, name, _ in pkgutil.iter_modules(cli.__path__)
    if not name.startswith("_")
}
GROUPS = [name for name, module in MODULES.items() if hasattr(module, "__path__")]
ORDERS = {name: module.ORDER for name, module in MODULES.items()}
ORDERS |= {name: question.order for name, question in declared_questions().items()}
COMMANDS = sorted(ORDERS, key=lambda name: (name in GROUPS, ORDERS[name]))
LAWS = ", ".join(CONTACT_MODELS)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch) -> Path:
    """A folder of its own, with a scene and a faulty one."""
    monkeypatch.chdir(tmp_path)
    Path("scene.toml").write_text(SCENE, encoding="utf-8")
    faulty = SCENE.replace('"44.36 t"', '"44.36 m"').replace('"hertz"', '"hertzian"').replace("[grid]", "[grit]")
    Path("bad.toml").write_text(faulty, encoding="utf-8")
    return tmp_path


def test_help_lists_the_commands():
    for words in ([], ["--help"]):
        result = run(*words).output
        assert re.findall(r"^  (\w+)  +[A-Z]", result.partition("Commands:")[2], re.MULTILINE) == COMMANDS
        assert "..." not in result.partition("Commands:")[2]  # no summary is cut


@pytest.mark.parametrize("name", COMMANDS)
def test_every_command_explains_its_options(name):
    assert done(name, "--help").output.startswith(f"Usage: pounding-risk {name} [OPTIONS]")
    if name in MODULES:
        kind = "group of commands" if name in GROUPS else "command"
        assert (MODULES[name].__doc__ or "").startswith(f"The {kind} `{name}`")


def test_models_lists_what_there_is():
    """Every model and effect by itself, with the unit of its stiffness and its source; a user's own law too."""
    result = run("models")
    models = {line[0]: line[1:] for line in rows(result.stdout) if line[0] in {**CONTACT_MODELS, **EFFECTS}}
    assert list(models) == [*CONTACT_MODELS, *EFFECTS]
    assert models["linear"][0] == "N/m" and models["jankowski"][:3] == ["N/m^1.5", "exact", "–"]
    assert models["distributed_mass"][0] == "floor lengths" and models["van_mier"][1:3] == ["–", "yields"]
    for name, kind in {**CONTACT_MODELS, **EFFECTS}.items():
        assert models[name][-1].endswith(kind.reference), name
    kinds = {line[0]: line[1:] for line in rows(result.stdout) if line[0] in TYPOLOGIES}
    assert list(kinds) == list(TYPOLOGIES) and kinds["masonry_ec8"][:2] == ["0.05 h^0.75 up to 40 m", "z / h"]
    assert kinds["concrete_walls"][2:4] == ["0.2 to 3 storeys, 0.167 to 7 storeys, 0.127 above", "yes"]


def test_version():
    assert run("--version").output == f"pounding-risk {pounding_risk.__version__}\n"


def test_an_unknown_command_is_answered_with_the_nearest():
    told = refused("scna", "scene.toml")
    assert "No such command 'scna'." in told and "'scan'" in told


def test_each_module_states_its_own_place_in_the_help():
    assert len({module.ORDER for module in MODULES.values()}) == len(MODULES)


def test_commands_are_public_calls_of_the_same_name():
    # `models` prints the classes of pounding_risk.models, `separations` the rules that `code_table` applies.
    names = set(COMMANDS) - {"models", "separations", *GROUPS}
    assert names <= set(pounding_risk.__all__)
    # A submodule of that name would take the function's place as soon as somebody imports it.
    assert [name for name in names if importlib.util.find_spec(f"pounding_risk.{name}")] == []


def test_commands_draw_figures_that_exist():
    """Commands name figures by text, so that nothing of a figure is imported where none is drawn."""
    names = set()
    for file in Path(cli.__file__).parent.rglob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if (
                isinstance(node, ast.Call)
                and isinstance(node.func, ast.Name)
                and node.func.id == "draw"
                and isinstance(node.args[1], ast.Constant)
            ):
                names.add(ast.literal_eval(node.args[1]))
    for question in declared_questions().values():
        drawn = [name for name in getattr(question.module(), "FIGURES", {}).values() if isinstance(name, str)]
        names.update(drawn)
    assert {"of_results.results_figure", "modes.modes_figure"} <= names
    for module, function in (name.split(".") for name in names):
        assert callable(getattr(import_module(f"pounding_risk.figures.{module}"), function))


@pytest.mark.parametrize("name", ["validate", "impact", "scan"])
def test_options_are_the_arguments_of_the_call(name):
    # Files, the scene and the law are made into objects; --strict is the command's own, for its exit status.
    shared = {"scene", "out", "figure", "animation", "overrides", "stiffness", "strict"}
    shared |= {"floor_length", "other_floor_length", "wave_speed", "table", "unloading_stiffness"}  # of the law
    shared |= {"absolute"}  # of the figure
    shared |= {"samples"}  # a key of the scene, as `overrides` are
    shared |= {"plan", "shard", "scheduler"}  # calls of their own, and an executor
    options = set(inspect.signature(getattr(MODULES[name], name)).parameters) - shared
    assert options <= set(inspect.signature(getattr(pounding_risk, name)).parameters)


def test_a_faulty_scene_is_told_whole_and_nothing_is_written(folder, says):
    before = sorted(path.name for path in folder.iterdir())
    commands = (["validate"], ["scan", "-o", "r.nc"], ["simulate", "-o", "h.nc", "--figure", "f.png"])
    results = [run(words[0], "bad.toml", *words[1:]) for words in commands]
    assert {(result.exit_code, result.stdout) for result in results} == {(2, "")}
    (told,) = {result.stderr for result in results}
    says(told.replace(LAWS, "LAWS"))
    assert sorted(path.name for path in folder.iterdir()) == before


def test_impact_compares_laws():
    result = done(
        "impact", "--law", "linear", "--law", "hertz", "--stiffness", "1e8 N/m", "--stiffness", "2.75e9 N/m^1.5"
    )
    # k δ: F = v sqrt(k m), δ = v sqrt(m / k), half a period π sqrt(m / k) of contact.
    force, depth, lasts = 0.5 * sqrt(570e8), 0.5 * sqrt(570 / 1e8), pi * sqrt(570 / 1e8)
    # β δ^1.5: the energy 0.4 β δ^2.5 is m v² / 2.
    hertz = (570 * 0.25 / (0.8 * 2.75e9)) ** 0.4
    heads, linear, other = rows(result.stdout)
    assert heads == ["law", "e requested", "e achieved", "peak force", "penetration", "duration", "energy lost"]
    assert linear[1:4] == ["–", "1.0000", f"{force / 1e3:.1f} kN"]
    assert linear[4:6] == [f"{depth * 1e3:.3f} mm", f"{lasts * 1e3:.4g} ms"]
    assert other[2:5] == ["1.0000", f"{2.75e6 * hertz**1.5:.1f} kN", f"{hertz * 1e3:.3f} mm"]
    assert linear[-1].endswith("(0 %)")


def test_impact_gives_the_other_kind_of_law_an_equal_peak_force():
    result = done("impact", "--law", "hertz", "--law", "linear")
    _, hertz, linear, note = rows(result.stdout)
    assert hertz[3] == linear[3]
    assert re.fullmatch(r"linear: k = \S+ MN/m, which gives the peak force of hertz without yielding", note[0])


def test_an_approach_past_the_range_of_a_relation_is_noted():
    """Equation (4) is a fit up to 5 m/s."""
    note = "faster than the range of the restitution relation, which is held at its end there"
    for speed, noted in (("5 m/s", []), ("6 m/s", [f"note: the approach is {note}"])):
        assert done("impact", "--restitution", "concrete", "--speed", speed).stdout.splitlines()[2:] == noted
    law = ["--set", "interface.contact_model=jankowski", "--set", "interface.restitution=concrete"]
    result = run("simulate", "scene.toml", *law, "--pga", "30 g")
    assert re.search(rf"^note: \d+ contacts are {note}$", result.stdout, re.MULTILINE), result.output
    result = run("scan", "scene.toml", *law, "--set", "records.pga=30 g", "--set", "grid.gap=['0 mm']")
    assert result.stdout.splitlines()[-1] == f"note: 2 cases have contacts {note}", result.output


@pytest.mark.complete
def test_impact_draws_what_it_printed(folder):
    result = done("impact", "--law", "hertz", "--figure", "f.svg")
    assert "<svg" in Path("f.svg").read_text(encoding="utf-8")
    drawn = Path("f.svg").read_bytes()
    assert not [path for path in folder.iterdir() if "partial" in path.name]
    assert result.stdout.splitlines()[-1] == "written: f.svg"
    done("impact", "--law", "hertz", "--speed", "2 m/s", "--figure", "f.svg")
    assert Path("f.svg").read_bytes() != drawn


def test_simulate_without_contact():
    assert run("simulate", "scene.toml", "--gap", "1 m").stdout.splitlines()[-1] == "no contact"


def test_an_option_that_is_a_key_of_the_scene_is_told_to_be_one():
    told = refused("scan", "scene.toml", "--gap", "20 mm")
    assert "No such option: --gap; a key of the scene is changed with --set" in told
    assert "--set" not in run("summary", "results.nc", "--gap", "20 mm").stderr


def test_scan_writes_and_sums_up(capsys):
    result = done("scan", "scene.toml", "--workers", "1")
    dataset = pounding_risk.open_results("scene.nc")
    table = rows(result.stdout)
    simulated = int(dataset["simulated"].sum())
    assert table[:3] == [
        ["cases", "6"],
        ["simulated", str(simulated)],
        ["known without a run of their own", str(6 - simulated)],
    ]
    assert table[3][0] == "recomputed" and table[3][1].startswith("1 of ")
    assert table[4][1].endswith("cases a second with reading and compiling")
    assert ["written", "scene.nc"] in table
    assert table[-1][0].startswith("note: grid.yield_force: no effect on any force: hertz limits none")
    cli.scan.print_scan(dataset, 0.4, Path("scene.nc"), n_earlier=6)
    assert ["time", "0.4 s, every case was done before"] in rows(capsys.readouterr().out)
    every = run("scan", "scene.toml", "--no-screening", "-o", "scene.nc", "--set", "solver.rtol=1e-7", "--new")
    assert rows(every.stdout)[1] == ["simulated", "6"]
    assert json.loads(pounding_risk.open_results("scene.nc").attrs["overrides"]) == ["solver.rtol=1e-7"]


def test_demo_says_what_it_wrote(monkeypatch):
    def demo(folder, say):
        say("one run")
        return {"figure": folder / "paper.png"}

    monkeypatch.setitem(sys.modules, "pounding_risk.reports.demo", SimpleNamespace(demo=demo))
    result = done("demo", "-o", "new/folder")
    assert result.stdout.splitlines()[0] == "one run"
    assert rows(result.stdout)[1] == ["figure", "new/folder/paper.png"]


def test_a_record_is_measured():
    """Numbers of NGA-West2's El Centro as others find them; a raw record is processed before, and says so."""
    measures = {row[0]: row[1:] for row in rows(run("records", "info", "RSN6-180").stdout) if len(row) == 3}
    assert {"PGA", "PGV", "PGD", "Arias", "CAV", "D5-75", "D5-95"} <= set(measures)
    assert (measures["PGA"][0], measures["PGV"][0], measures["D5-95"][0]) == ("0.2808 g", "0.3096 m/s", "24.19 s")
    assert [name for name in measures if name.startswith("Sa")] == ["Sa(0.2 s)", "Sa(0.5 s)", "Sa(1 s)", "Sa(2 s)"]
    raw = {row[0]: row[1:] for row in rows(run("records", "info", "CCC-HN1").stdout) if len(row) == 3}
    assert raw["PGA"] == ["0.4698 g", "peak ground acceleration, processed as for a run"]


class Clock:
    """The time as a test sets it."""

    def __init__(self, monkeypatch):
        self.now = 0.0
        monkeypatch.setattr(progress, "monotonic", lambda: self.now)


# Reports as (time [s], cases done), the first of a resumed study before any work, and the lines that come of them.
REPORTED = {
    "a line now and then": (
        False,
        [(10.0 + done / 10, done) for done in range(0, 1001, 100)],
        [
            "scan: 200 of 1000 cases (20 %), 10 a second, about 80 s left",
            "scan: 500 of 1000 cases (50 %), 10 a second, about 50 s left",
            "scan: 800 of 1000 cases (80 %), 10 a second, about 20 s left",
        ],
    ),
    # What is kept from before took no time now; nor is the first report, which stands for compiling, a speed.
    "from what is kept": (
        True,
        [(0.0, 600), (20.0, 610), (40.0, 650), (80.0, 730)],
        [
            "scan: 600 of 1000 cases are kept from before",
            "scan: 650 of 1000 cases (65 %), 2 a second, about 3 min left",
            "scan: 730 of 1000 cases (73 %), 2 a second, about 2 min left",
        ],
    ),
    "nothing is kept": (True, [(0.0, 0)], []),
}


@pytest.mark.parametrize("name", REPORTED)
def test_progress_without_a_terminal(name, monkeypatch, capsys):
    resumes, reports, lines = REPORTED[name]
    clock = Clock(monkeypatch)
    with progress.ProgressDisplay("scan", resumes=resumes) as display:
        for clock.now, done in reports:
            display(done, 1000)
    assert capsys.readouterr().err.splitlines() == lines


def test_time_left_grows_where_nothing_comes_any_more(monkeypatch, capsys):
    """The last worker of a cluster died: the speed of better times is no longer told."""
    clock = Clock(monkeypatch)
    monkeypatch.setattr(progress, "EVERY", 1e9)
    with progress.ProgressDisplay("scan") as display:
        for clock.now, done in ((10.0, 0), (20.0, 500)):
            display(done, 1000)
        clock.now = 110.0
        monkeypatch.setattr(progress, "EVERY", 30.0)
        display._print_state()
    assert capsys.readouterr().err == "scan: 500 of 1000 cases (50 %), 5 a second, about 100 s left\n"


def lines_said(capsys, count: int) -> list[str]:
    """So many lines of standard error, however long they take to come; fewer are a failure."""
    text = ""
    for _ in range(2000):
        text += capsys.readouterr().err
        if text.count("\n") >= count:
            return text.splitlines()[:count]
        time.sleep(0.005)
    raise AssertionError(f"only this was said: {text!r}")


def test_progress_is_told_while_nothing_reports(monkeypatch, capsys):
    """A long compile, or a long piece of work: the line comes by itself, from the state last told."""
    monkeypatch.setattr(progress, "EVERY", 0.02)
    with progress.ProgressDisplay("scan") as display:
        assert lines_said(capsys, 2) == ["scan: reading, compiling, 0 s so far"] * 2
        display(100, 1000)
        assert lines_said(capsys, 4)[-2:] == ["scan: 100 of 1000 cases (10 %)"] * 2
    assert not display._clock.is_alive()
    with progress.ProgressDisplay("scan", resumes=True) as display:
        display(0, 6)
        line = "scan: 0 of 6 cases (0 %), compiling or running the next ones, 0 s so far"
        assert line in lines_said(capsys, 3)


def test_progress_on_a_terminal_is_a_bar_with_speed_and_time_left(monkeypatch):
    clock = Clock(monkeypatch)
    monkeypatch.setattr(sys, "stderr", terminal := Terminal())
    monkeypatch.setenv("TERM", "xterm")
    with progress.ProgressDisplay("scan", resumes=True) as display:
        display(600, 1000)
        for clock.now, done in ((20.0, 610), (40.0, 650)):
            display(done, 1000)
        display._bar.refresh()
    text = re.sub(r"\x1b\[[0-9;?]*[A-Za-z]", "", terminal.getvalue())
    assert "scan: 600 of 1000 cases are kept from before" in text
    assert re.search(r"650/1000 [0-9:]+ 2 a second, about 3 min left", text)


class Terminal(io.StringIO):
    """Standard error as a terminal has it."""

    def isatty(self) -> bool:
        """It says so."""
        return True


def test_spans_of_time_are_told_as_one_thinks_of_them():
    spans = (0.4, 80.0, 119.7, 700.0, 7200.0, 12_000.0, 180_000.0, 500_000.0)
    words = ["0 s", "80 s", "2 min", "12 min", "2 h 0 min", "3 h 20 min", "2 d 2 h", "5 d 18 h"]
    assert [progress.span_words(span) for span in spans] == words
    assert progress.pace(0.0, 10) == "" and progress.pace(1234.5, 0) == ", 1234 a second, about 0 s left"


def test_a_real_process_ends_with_status_2_and_no_traceback():
    process = ended("-c", "from pounding_risk.cli import main; main()", "validate", "bad.toml")
    assert (process.returncode, process.stdout) == (2, "")
    assert process.stderr.startswith("pounding-risk: bad.toml: 3 faults\n") and "Traceback" not in process.stderr


@pytest.mark.complete
@pytest.mark.parametrize(
    "command", [("scan", "scene.toml", "-o", "out.nc"), ("simulate", "scene.toml", "-o", "out.nc")]
)
def test_a_failed_run_is_told_and_strict_makes_it_status_3(command):
    """A ground motion beyond what steps resolve: the dataset is written either way, with NaN and a reason."""
    law = ("--set", "interface.contact_model=jankowski", "--set", "interface.restitution=0.65")
    wild = ("--set", "records.pga='1e28 g'", *law)
    sentences = ("the step in contact fell below what the numbers resolve", "the step budget ran out")
    for strict, status in (((), 0), (("--strict",), 3)):
        Path("out.nc").unlink(missing_ok=True)
        result = run(*command, *wild, *strict)
        assert result.exit_code == status, result.output
        assert any(sentence in result.output for sentence in sentences), result.output
        assert Path("out.nc").exists()
    Path("out.nc").unlink()
    done(*command, "--strict")
