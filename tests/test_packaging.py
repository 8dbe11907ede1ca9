"""What is built carries what is needed: records in the wheel, tests in the source archive, one version, one licence."""

from __future__ import annotations

import os
import re
import subprocess
import sys
import tarfile
import tomllib
import zipfile
from importlib import metadata
from pathlib import Path

import obspy
import pytest

import pounding_risk
from pounding_risk.motions import catalogue


@pytest.fixture(scope="module")
def project(root) -> dict:
    """The ``[project]`` table."""
    return tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]


@pytest.fixture(scope="module")
def built(root, tmp_path_factory) -> dict[str, Path]:
    """Wheel and source archive, made by the project's own build backend."""
    pytest.importorskip("hatchling")
    folder = tmp_path_factory.mktemp("dist")
    for target in ("wheel", "sdist"):
        code = f"from hatchling.build import build_{target} as build\nbuild({str(folder)!r})"
        done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True, timeout=120)
        assert done.returncode == 0, done.stderr
    return {"wheel": next(folder.glob("*.whl")), "sdist": next(folder.glob("*.tar.gz"))}


def tracked(root: Path, *folders: str) -> set[str]:
    """Files of these folders that belong to the project."""
    return {
        file.relative_to(root).as_posix()
        for folder in folders
        for file in (root / folder).rglob("*")
        if file.is_file() and not {"__pycache__", ".ipynb_checkpoints"} & set(file.parts)
    }


def test_the_wheel_is_the_package_and_its_records(root, built, project):
    names = set(zipfile.ZipFile(built["wheel"]).namelist())
    assert tracked(root, "pounding_risk") <= names
    assert {f"pounding_risk/motions/{name}" for name in tracked(root, "records")} <= names
    tops = {name.partition("/")[0] for name in names}
    assert tops == {"pounding_risk", f"pounding_risk-{project['version']}.dist-info"}
    assert f"pounding_risk-{project['version']}.dist-info/licenses/LICENSE" in names
    assert not [name for name in names if name.endswith((".pyc", ".nbi", ".nbc"))]


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


def test_the_source_archive_can_be_tested(root, built, project):
    top = f"pounding_risk-{project['version']}/"
    with tarfile.open(built["sdist"]) as archive:
        names = {name.removeprefix(top) for name in archive.getnames()}
    assert tracked(root, "pounding_risk", "tests", "records", "notebooks", "benchmarks") <= names
    assert {"pyproject.toml", "README.md", "LICENSE", "CITATION.cff", "CHANGELOG.md", ".ci/run"} <= names


def test_every_record_of_the_catalogue_is_there(root):
    """Each shipped file is in the catalogue, and each file of the catalogue is shipped or in a pinned package."""
    told = {found.file for found in catalogue.entries() if not found.package}
    shipped = {name.removeprefix("records/") for name in tracked(root, "records")}
    assert told <= shipped
    assert {name for name in shipped if name.endswith(".mseed")} <= told


def test_packages_with_records_are_pinned_as_the_catalogue_says(project):
    pins = {f"{found.package}=={found.version}" for found in catalogue.entries() if found.package}
    assert pins <= set(project["dependencies"])


def test_the_version_is_the_same_everywhere(root, project):
    version = project["version"]
    assert metadata_version() in (None, version)
    assert pounding_risk.__version__ == version
    assert re.search(rf"^version: {re.escape(version)}$", (root / "CITATION.cff").read_text("utf-8"), re.M)
    assert re.search(rf"^## {re.escape(version)}\b", (root / "CHANGELOG.md").read_text("utf-8"), re.M)


def metadata_version() -> str | None:
    """Version of the installed distribution; None where the checkout is used without installing it."""
    try:
        return metadata.version("pounding-risk")
    except metadata.PackageNotFoundError:
        return None


def test_the_licence_is_the_one_named(root, project):
    assert project["license"] == "MIT"
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
    assert test.endswith(" && .venv/bin/python -m pytest -n 2 --dist worksteal")


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
