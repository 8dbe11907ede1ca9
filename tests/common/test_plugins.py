"""Plug-ins: the example package installed and used, and what is told of those that are broken or clash."""

import os
import re
import signal
import subprocess
import sys
import warnings
from math import log
from pathlib import Path
from types import SimpleNamespace

import pytest
from scipy.optimize import brentq
from typer.testing import CliRunner

import pounding_risk
from pounding_risk._common import plugins
from pounding_risk._common.plugins import PluginWarning, Registry, installed, plugin_of
from pounding_risk.cli import app
from pounding_risk.ensemble import dask
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.contact.register import law_digest

EXAMPLE = "examples/pounding_risk_example"


@pytest.fixture(scope="module")
def site(root, tmp_path_factory) -> Path:
    """A folder of packages in which pip has installed the example package."""
    folder = tmp_path_factory.mktemp("site")
    words = ["install", "-q", "--no-deps", "--no-build-isolation", "--no-index", "--no-compile", "--target"]
    line = [sys.executable, "-m", "pip", *words, str(folder), str(root / EXAMPLE)]
    subprocess.run(line, check=True, capture_output=True, timeout=120)
    return folder


def python(site: Path, *words: str, cwd: Path | None = None) -> str:
    """The output of a fresh interpreter that finds this package and the packages of a folder."""
    package = Path(pounding_risk.__file__).parents[1]
    paths = {"PYTHONPATH": os.pathsep.join((str(site), str(package))), "PYTHONDONTWRITEBYTECODE": "1"}
    run = subprocess.run([sys.executable, *words], env={**os.environ, **paths}, cwd=cwd, capture_output=True, text=True)
    assert run.returncode == 0, run.stdout + run.stderr
    return run.stdout


@pytest.mark.complete
def test_the_example_package_passes_its_own_tests_once_installed(root, site, tmp_path):
    words = ["-m", "pytest", "-q", "-c", os.devnull, "-p", "no:cacheprovider", str(root / EXAMPLE / "tests")]
    assert re.search(r"\d+ passed in", python(site, *words, cwd=tmp_path))


def rebound(damping: float) -> float:
    """Restitution of F = β δ^1.5 (1 + d δ̇ / v0): d - ln(1 + d) = -d e - ln(1 - d e), whatever β and v0."""

    def loss(e: float) -> float:
        return damping - log(1.0 + damping) + damping * e + log(1.0 - damping * e)

    return float(brentq(loss, 1e-6, min(1.0, 1.0 / damping - 1e-12)))


@pytest.mark.complete
def test_an_edited_law_is_compiled_anew(site, tmp_path):
    """No compiled code of a plug-in's law outlives its source."""
    code = (
        "import pounding_risk as pr\n"
        "from pounding_risk.models.contact.laws import LAWS\n"
        "law = LAWS['hunt_crossley'](2.75e9)\n"
        "print(pr.impact(law, speed=0.5, mass=570.0, restitution=0.65).restitution)"
    )
    assert float(python(site, "-c", code, cwd=tmp_path)) == pytest.approx(rebound(1.5 * 0.35), rel=1e-6)
    source = site / "pounding_risk_example" / "laws.py"
    text = source.read_text("utf-8")
    source.write_text(text.replace("return 1.5 * (1.0 - e)", "return 3.0 * (1.0 - e)"), "utf-8")
    try:
        assert float(python(site, "-c", code, cwd=tmp_path)) == pytest.approx(rebound(3.0 * 0.35), rel=1e-6)
    finally:
        source.write_text(text, "utf-8")


@pytest.fixture
def install(tmp_path, monkeypatch):
    """Install a made distribution: its entry points by group, and its one module."""
    monkeypatch.setattr(sys, "path", [str(tmp_path), *sys.path])
    names = []

    def made(name: str, entries: dict[str, str], source: str = "") -> None:
        folder = tmp_path / f"{name}-1.2.dist-info"
        folder.mkdir()
        text = "".join(f"[pounding_risk.{group}]\n{line}\n" for group, line in entries.items())
        (folder / "entry_points.txt").write_text(text, "utf-8")
        (folder / "METADATA").write_text(f"Metadata-Version: 2.4\nName: {name}\nVersion: 1.2\n", "utf-8")
        (tmp_path / f"{name}.py").write_text(source, "utf-8")
        names.append(name)
        forget()

    yield made
    forget()
    for name in names:
        sys.modules.pop(name, None)


def forget() -> None:
    """Look for distributions again, and warn again."""
    installed.cache_clear()
    plugins.tell.cache_clear()


def rules(*ours: str) -> Registry:
    """A registry of names, to which whatever a plug-in names may be added."""
    return Registry("rules", dict.fromkeys(ours, "ours"), lambda name, target: target)


def test_a_plugin_is_imported_when_its_name_is_asked_for(install):
    install(
        "extra",
        {"rules": "two = extra:RULES.two [all]\n# one = absent\none = extra:ONE"},
        "class RULES: two = 2\nONE = 1",
    )
    registry = rules("zero")
    assert registry["zero"] == "ours" and "extra" not in sys.modules
    assert registry["two"] == 2 and list(registry) == ["zero", "one", "two"] and len(registry) == 3
    assert plugin_of("rules", "one") == ("rules", "one", "extra:ONE", "extra", "1.2")
    assert plugin_of("rules", "zero") is None and registry.problem("zero") == ""


@pytest.mark.parametrize(
    ("source", "why"),
    [
        ("import nowhere_to_be_found", r"ModuleNotFoundError: No module named 'nowhere_to_be_found'"),
        ("", r"AttributeError: module 'extra' has no attribute 'ONE'"),
        ("def f(:", r"SyntaxError: "),
        ("raise SystemExit(3)", r"SystemExit: 3"),
    ],
)
def test_a_plugin_that_cannot_be_loaded_is_told(install, source, why):
    """An error where it is asked for, a warning where all are listed; what else there is goes on."""
    install("extra", {"rules": "one = extra:ONE"}, source)
    registry = rules("zero")
    sentence = (
        r'^separation rule one: the plug-in extra 1\.2 \(entry point "one = extra:ONE" in pounding_risk\.rules\) '
        rf"cannot be loaded: {why}.*; repair it, or uninstall extra$"
    )
    for ask in (lambda: registry["one"], lambda: "one" in registry):
        with pytest.raises(PoundingError, match=sentence):
            ask()
    with pytest.warns(PluginWarning, match=sentence):
        assert list(registry.items()) == [("zero", "ours")]


def test_a_name_of_ours_stays_ours(install):
    """The plug-in is not imported, and a warning names it, once."""
    install("extra", {"rules": "zero = extra:ZERO"}, "raise SystemExit")
    registry = rules("zero")
    with pytest.warns(PluginWarning, match=r"^separation rule zero: extra 1\.2 .* ignored, .* or uninstall extra$"):
        assert registry["zero"] == "ours"
    assert list(registry) == ["zero"] and len(registry) == 1 and dict(registry.items()) == {"zero": "ours"}
    assert "extra" not in sys.modules


def test_a_list_of_names_imports_no_plugin(install):
    install("extra", {"rules": "one = extra:ONE"}, "raise SystemExit")
    registry = rules("zero")
    assert list(registry) == ["zero", "one"] and len(registry) == 2 and "zero" in registry
    assert "extra" not in sys.modules


def test_an_interrupt_of_a_plugins_own_is_an_error_of_it(install):
    install("extra", {"rules": "one = extra:ONE"}, "raise KeyboardInterrupt")
    with pytest.raises(PoundingError, match=r"rule one: .* loaded: .*KeyboardInterrupt, though nobody"):
        rules()["one"]


def test_the_users_interrupt_while_a_plugin_is_imported_stops(install):
    install("extra", {"rules": "one = extra:ONE"}, "import signal\nsignal.raise_signal(signal.SIGINT)")
    before = signal.getsignal(signal.SIGINT)
    with pytest.raises(KeyboardInterrupt):
        rules()["one"]
    assert signal.getsignal(signal.SIGINT) is before


@pytest.mark.parametrize(
    "value", ["", ":", "extra:", ":ONE", "extra:ONE.", "..extra:ONE", "ex tra:1", "extra:ONE:TWO", "\x00"]
)
def test_a_malformed_entry_point_is_one_plugin_less(install, value):
    install("extra", {group: f"one = {value}" for group in plugins.GROUPS}, "ONE = 1")
    for group in plugins.GROUPS:
        registry = Registry(group, {"zero": 0}, lambda name, target: target)
        assert registry["zero"] == 0
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", PluginWarning)
            assert dict(registry.items()).get("zero") == 0


def test_a_name_that_two_plugins_have_is_refused(install):
    install("extra", {"rules": "one = extra:ONE"}, "ONE = 1")
    install("other", {"rules": "one = other:ONE"}, "ONE = 1")
    sentence = r"rule one: extra 1\.2 \(.*\) and other 1\.2 \(.*\) have this name.* uninstall extra or other, or rename"
    with pytest.raises(PoundingError, match=sentence):
        rules()["one"]


def test_a_group_that_is_none_is_told(install):
    install("extra", {"law": "one = extra:ONE"})
    with pytest.warns(
        PluginWarning, match=r'extra 1\.2 .*is left out: no such group \(did you mean "laws"\?\); groups'
    ):
        assert installed()["laws"] == {}


LAW = """
from typing import Annotated, NamedTuple
import pounding_risk as pr
from pounding_risk.models.contact import laws as contact
assert "cushion" not in contact.LAWS  # asks while this module is being imported
@pr.contact_law
class Cushion(NamedTuple):
    stiffness: Annotated[float, contact.LINEAR_STIFFNESS]
    capped, needs_restitution = False, False
    begin = contact.undamped
    def force(self, memory, delta, rate, approaching):
        return self.stiffness * delta
    plateau, stored, ceiling, floor = contact.flat, contact.linear_energy, contact.never_yields, contact.may_pull
"""


def script(text: str) -> None:
    """Run a text as a script."""
    exec(compile(text.replace("assert", "#"), "script", "exec", dont_inherit=True), {"__name__": "script"})


@pytest.fixture
def laws(monkeypatch):
    """The registry of laws, put back afterwards."""
    monkeypatch.setattr(LAWS, "members", dict(LAWS.members))
    monkeypatch.setattr(LAWS, "_problems", {})


def test_a_law_under_its_decorator_is_found_whoever_imports_it(install, laws):
    install("extra", {"laws": "cushion = extra:Cushion"}, LAW)
    import extra  # type: ignore[import-not-found]

    assert LAWS["cushion"] is extra.Cushion
    with pytest.raises(PoundingError, match=r"cushion: extra 1\.2 .* has this name; choose another name, or uninstall"):
        script(LAW)


def test_a_law_of_another_name_than_its_entry_point_is_told(install, laws):
    install("extra", {"laws": "pillow = extra:Cushion"}, LAW)
    with pytest.raises(PoundingError, match=r"importing extra makes no contact law of this name known; give the entry"):
        LAWS["pillow"]


def test_a_law_of_a_name_of_ours_is_refused_by_its_decorator(laws):
    with pytest.raises(PoundingError, match=r"merged is a law of the package; give the class another name"):
        script(LAW.replace("Cushion", "Merged"))


def run(*words: str):
    """A command in this process."""
    return CliRunner().invoke(app, words)


def test_a_broken_command_is_told_and_the_others_are_there(install):
    install("extra", {"commands": "screen = extra:SCREEN"}, "SCREEN = 1")
    listed, asked = run("--help"), run("screen")
    assert listed.exit_code == 0 and "simulate" in listed.output
    assert re.search(r"screen +Command of extra 1\.2\.", listed.output) and not listed.stderr
    told = "command screen: the plug-in extra 1.2 (entry point"
    assert asked.exit_code == 2 and asked.stderr.startswith(f"pounding-risk: {told}")
    assert "1 is neither a function nor a typer application" in asked.stderr
    forget()
    listed = run("models")
    assert re.search(r"\ncommand +screen +extra 1\.2 +extra:SCREEN +not used\n", listed.stdout)
    assert f"note: {told}" in listed.stderr


def test_a_command_of_a_name_of_ours_is_ignored(install):
    install("extra", {"commands": "scan = extra:SCAN"}, "raise SystemExit(9)")
    listed, asked = run("--help"), run("scan", "absent.toml")
    assert listed.exit_code == 0 and "simulate" in listed.output
    assert asked.exit_code == 2 and "absent.toml" in asked.stderr
    assert "note: command scan: extra 1.2" in listed.stderr + asked.stderr


def test_the_group_of_records_has_no_commands_of_plugins(install):
    install("extra", {"commands": "list = extra:LIST"})
    assert run("records", "--help").exit_code == 0


def test_a_worker_with_another_law_is_refused(laws, monkeypatch):
    script(LAW)
    study = SimpleNamespace(model_names=("cushion",), effects=())  # what a worker's check reads of a scene
    payload = dask.pickle.dumps(SimpleNamespace(study=study))
    monkeypatch.setattr(dask, "_address", lambda: "tcp://10.0.0.1")
    digest = {"cushion": law_digest(LAWS["cushion"])}
    assert dask._unpickled(payload, dask.JobKey("", None, {}, "", digest)).study.model_names == ("cushion",)
    with pytest.raises(PoundingError, match=r"worker tcp://10\.0\.0\.1 .* code of cushion \w{12} there, 0{12} here"):
        dask._unpickled(payload, dask.JobKey("", None, {}, "", {"cushion": "0" * 64}))
    del LAWS["cushion"]
    with pytest.raises(PoundingError, match=r"does not know cushion: .*is not a contact model.*; install the plug-ins"):
        dask._unpickled(payload, dask.JobKey("", None, {}, "", digest))
