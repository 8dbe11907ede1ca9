"""What is built carries what is needed: records in the wheel, tests in the source archive, one version, one licence."""

import importlib.util
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from importlib.machinery import SourceFileLoader
from pathlib import Path, PureWindowsPath

import obspy
import pytest
from processes import output

import pounding_risk
from pounding_risk.motions import catalogue


@pytest.fixture(scope="module")
def project(root) -> dict:
    """The ``[project]`` table."""
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def built(root, tmp_path_factory) -> dict[str, Path]:
    """Wheel and source archive, made by the project's own build backend."""
    folder = tmp_path_factory.mktemp("dist")
    for target in ("wheel", "sdist"):
        code = f"from hatchling.build import build_{target} as build\nbuild({str(folder)!r})"
        output("-c", code, cwd=root)
    return {"wheel": next(folder.glob("*.whl")), "sdist": next(folder.glob("*.tar.gz"))}


@pytest.fixture(scope="module")
def version(built) -> str:
    """The version that the wheel states."""
    return built["wheel"].name.split("-")[1]


def tracked(root: Path, *folders: str) -> set[str]:
    """Files of these folders that belong to the project."""
    return {
        file.relative_to(root).as_posix()
        for folder in folders
        for file in (root / folder).rglob("*")
        if file.is_file() and not {"__pycache__", ".ipynb_checkpoints", ".hypothesis"} & set(file.parts)
    }


@pytest.mark.complete
def test_the_wheel_is_the_package_and_its_records(root, built, version):
    names = set(zipfile.ZipFile(built["wheel"]).namelist())
    assert tracked(root, "pounding_risk") <= names
    assert {f"pounding_risk/motions/{name}" for name in tracked(root, "records")} <= names
    tops = {name.partition("/")[0] for name in names}
    assert tops == {"pounding_risk", f"pounding_risk-{version}.dist-info"}
    licences = {f"pounding_risk-{version}.dist-info/licenses/{name}" for name in ("LICENSE", "records/README.md")}
    assert licences <= names and not [name for name in names if "/tests/" in name]
    assert not [name for name in names if name.endswith((".pyc", ".nbi", ".nbc"))]


@pytest.mark.complete
def test_the_wheel_finds_its_records_far_from_the_checkout(built, tmp_path):
    zipfile.ZipFile(built["wheel"]).extractall(tmp_path / "site")
    code = (
        "from pounding_risk.motions import catalogue\n"
        "print(catalogue.records_folder())\n"
        "for found in catalogue.entries():\n"
        "    assert found.package or catalogue.read_bytes(found.id), found.id\n"
    )
    environment = {**os.environ, "PYTHONPATH": str(tmp_path / "site")}
    done = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=tmp_path, capture_output=True, text=True, timeout=120
    )
    assert done.returncode == 0, done.stderr
    assert Path(done.stdout.strip()) == (tmp_path / "site" / "pounding_risk" / "motions" / "records").resolve()


@pytest.mark.complete
def test_the_source_archive_can_be_tested(root, built, version):
    top = f"pounding_risk-{version}/"
    with tarfile.open(built["sdist"]) as archive:
        names = {name.removeprefix(top) for name in archive.getnames()}
    assert tracked(root, "pounding_risk", "tests", "records", "notebooks", "benchmarks", "examples") <= names
    assert {"pyproject.toml", "README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md", ".ci/run", ".ci/release"} <= names


@pytest.mark.complete
def test_registries_of_packages_take_what_is_built(built):
    """Metadata, description and names, as twine checks them before an upload."""
    assert output("-m", "twine", "check", "--strict", *built.values()).count("PASSED") == 2


@pytest.mark.complete
def test_every_file_can_stand_on_windows_and_macos(root, built):
    """No name that Windows keeps for itself or refuses, and no two that differ by the size of letters alone."""
    with tarfile.open(built["sdist"]) as archive:
        names = [member.partition("/")[2] for member in archive.getnames()]
    refused = [
        name
        for name in names
        if PureWindowsPath(name).is_reserved() or re.search(r'[<>:"|?*\\\x00-\x1f]|[. ](/|$)', name) or len(name) > 150
    ]
    assert len(names) > 900 and refused == []
    assert len({name.casefold() for name in names}) == len(names)


def test_every_record_of_the_catalogue_is_there(root):
    """Each shipped file is in the catalogue, and each file of the catalogue is shipped or in a pinned package."""
    told = {found.file for found in catalogue.entries() if not found.package}
    shipped = {name.removeprefix("records/") for name in tracked(root, "records")}
    assert told <= shipped
    assert {name for name in shipped if name.endswith(".mseed")} <= told


def test_packages_with_records_are_pinned_as_the_catalogue_says(project):
    pins = {f"{found.package}=={found.version}" for found in catalogue.entries() if found.package}
    assert pins <= set(project["dependencies"])


@pytest.fixture(scope="module")
def release(root):
    """The checklist of a release, as a module."""
    loader = SourceFileLoader("release", str(root / ".ci" / "release"))
    spec = importlib.util.spec_from_loader("release", loader)
    assert spec is not None
    module = importlib.util.module_from_spec(spec)
    loader.exec_module(module)
    return module


def test_the_newest_release_is_the_same_everywhere(release):
    """In changelog, citation, pyproject.toml and the recipe for conda; the recipe asks for the same packages."""
    stated = release.stated_versions()
    assert len(set(stated.values())) == 1 and len(stated) == 4
    assert list(release.check_recipe()) == []
    assert pounding_risk.__version__ == (metadata_version() or "0+unknown")


def test_the_checklist_of_a_release_names_what_is_wrong(release, tmp_path, monkeypatch):
    names = ("CHANGELOG.md", "CITATION.cff", "pyproject.toml", ".ci/conda/recipe.yaml", ".ci/Containerfile")
    for name in names:
        (tmp_path / name).parent.mkdir(parents=True, exist_ok=True)
        (tmp_path / name).write_text(release.text(name), "utf-8")
    monkeypatch.setattr(release, "ROOT", tmp_path)
    edit(tmp_path / "CHANGELOG.md", r"^## Unreleased$", "## 0.2.0 (2027-01-01)")
    edit(tmp_path / ".ci/conda/recipe.yaml", "- obspy >=1.5", "- obspy >=1.4")
    edit(tmp_path / ".ci/Containerfile", "pdf,view", "pdf,show")
    assert release.stated_versions()["CHANGELOG.md"] == "0.2.0"
    wrong = list(release.check_versions("0.2.0"))
    assert len(wrong) == 3 and all("states 0.1.0, CHANGELOG.md 0.2.0; write 0.2.0 there" in fault for fault in wrong)
    assert sum("obspy >=1." in fault for fault in release.check_recipe()) == 2
    assert any("Containerfile: show is no extra" in fault for fault in release.check_recipe())
    edit(tmp_path / "CHANGELOG.md", r"^## 0\.2\.0.*$", "## Unreleased\n\n- Something.\n\n## 0.1.0")
    assert any("text under '## Unreleased'" in fault for fault in release.check_versions("0.1.0"))


def edit(file: Path, pattern: str, text: str) -> None:
    """Replace the one place of a pattern in a file."""
    changed, count = re.subn(pattern, text, file.read_text("utf-8"), count=1, flags=re.M)
    assert count == 1
    file.write_text(changed, "utf-8")


VERSION = """
from hatchling.metadata.core import ProjectMetadata
from hatchling.plugin.manager import PluginManager
print(ProjectMetadata(".", PluginManager()).version)
"""


@pytest.mark.complete
def test_the_version_comes_from_the_tag_and_is_there_without_one(root, release, tmp_path):
    """Of a plain copy, a repository without tags (or a shallow one), a tagged commit, and the commit after it."""
    newest = release.stated_versions()["CHANGELOG.md"]
    for name in ("pyproject.toml", "README.md", "LICENSE"):
        shutil.copy(root / name, tmp_path)

    def stated() -> str:
        return output("-c", VERSION, cwd=tmp_path).strip()

    def git(*words: str) -> None:
        who = ["-c", "user.name=a", "-c", "user.email=a@b", "-c", "commit.gpgsign=false", "-c", "tag.gpgsign=false"]
        subprocess.run(["git", *who, *words], cwd=tmp_path, check=True, capture_output=True)

    assert stated() == newest
    if shutil.which("git") is None:
        return
    git("init")
    git("add", "-A")
    git("commit", "-m", "one")
    assert re.fullmatch(r"\d+\.\d+\.\d+\.dev1\+g\w+", stated())
    git("tag", "v9.8.7")
    assert stated() == "9.8.7"
    git("commit", "--allow-empty", "-m", "two")
    assert stated().startswith("9.8.8.dev1+g")


def metadata_version() -> str | None:
    """Version of the installed distribution; None where the checkout is used without installing it."""
    try:
        return metadata.version("pounding-risk")
    except metadata.PackageNotFoundError:
        return None


def test_the_licence_is_the_one_named(root, project):
    assert project["license"] == "MIT AND CC0-1.0"  # of the code, and of the records
    assert "(CC0 1.0)" in (root / "records" / "README.md").read_text("utf-8")
    text = (root / "LICENSE").read_text("utf-8")
    assert text.startswith("MIT License")
    assert "The pounding_risk developers" in text


@pytest.mark.skipif(metadata_version() is None, reason="the package is not installed")
def test_installed_obspy_reads_at2():
    """``obspy.read`` by content alone, through the entry points, in m/s²."""
    place = catalogue.path("RSN6-180")
    stream = obspy.read(str(place))
    assert stream[0].stats._format == "PEER_AT2"
    assert abs(stream[0].data).max() == pytest.approx(catalogue.entry("RSN6-180").pga, rel=1e-4)


@pytest.mark.skipif(metadata_version() is None, reason="the package is not installed")
def test_the_command_is_installed():
    points = metadata.entry_points(group="console_scripts", name="pounding-risk")
    assert [point.value for point in points] == ["pounding_risk.cli:main"]
    assert callable(next(iter(points)).load())


def fenced(root: Path, heading: str) -> str:
    """The one fenced line under a heading of the README."""
    section = re.split(r"^## ", (root / "README.md").read_text("utf-8"), flags=re.M)
    found = [part for part in section if part.startswith(f"{heading}\n")]
    assert len(found) == 1, f"README.md: one heading '## {heading}', found {len(found)}"
    block = re.search(r"^```\w*\n(.*?)^```", found[0], re.M | re.S)
    assert block, f"README.md: no fenced line under '## {heading}'"
    assert block[1].count("\n") == 1, f"README.md: more than one line under '## {heading}'"
    return block[1].strip()


def test_the_two_lines_of_the_readme(root):
    """They set up everything by themselves: no activation, no pip of an externally managed Python."""
    run, test = fenced(root, "Run it"), fenced(root, "Test it")
    for line in (run, test):
        assert line.startswith("python3 -m venv ")
    assert run.endswith(" && .venv/bin/pounding-risk demo")
    assert test.endswith(' && .venv/bin/python -m pytest -n 2 --dist worksteal -m "not complete"')


def test_the_continuous_integration_runs_the_readmes_own_line(root):
    """What `.ci/run` takes from the README is the line that the reader sees."""
    script = (root / ".ci" / "run").read_text("utf-8")
    awk = re.search(r"^line=\$\((awk .*)\)$", script, re.M)
    assert awk
    done = subprocess.run(["bash", "-c", awk[1]], cwd=root, capture_output=True, text=True, timeout=30)
    assert done.stdout.strip() == fenced(root, "Test it")
    assert os.access(root / ".ci" / "run", os.X_OK)


def test_the_script_of_the_lowest_versions_names_tests_that_are_there(root):
    """It installs the lower bounds of `pyproject.toml`, and runs the demo and these tests."""
    script = (root / ".ci" / "lowest").read_text("utf-8")
    assert os.access(root / ".ci" / "lowest", os.X_OK)
    assert "--resolution lowest-direct" in script and 'pounding-risk" demo' in script
    named = re.findall(r"tests/[\w/]+\.py", script)
    assert len(named) > 8 and all((root / name).is_file() for name in named)
