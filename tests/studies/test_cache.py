"""The compile cache is filled with what a scan and a simulation call, looked into, and rid of other versions."""

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest
from processes import PACKAGE, bare_environment, compiled
from scenes import BOTH, FOUR_IN_A_ROW, FRAME, rigid, scene_text, single

PAIR = scene_text(
    FRAME,
    rigid(),
    law="viscous_elastoplastic",
    stiffness="4.2e7 kN/m^1.5",
    restitution="concrete",
    equal_terms={"same": "penetration", "speed": "0.5 m/s"},
    records={"names": ["RSN6-180"], "window": ["0 s", "3 s"], "polarity": BOTH, "pga": "0.3 g"},
    grid={"gap": ["0 mm", "5 mm"], "yield_force": ["100 kN", "inf"], "contact_model": ["jankowski", "linear"]},
)
PASSED = scene_text(
    single("A", "44 t", "0.2 s", damping=0.05),
    single("B", "80 t", "0.1 s", damping=0.05),
    records={"names": ["RSN6-180"], "window": ["0 s", "3 s"]},
    effects={"wave_passage": {"velocity": "200 m/s", "distance": "500 m"}},  # 2.5 s: longer than the shaking
)
SCENES = {"pair": PAIR, "row": FOUR_IN_A_ROW, "wave": PASSED}
# Kernels that Python called, with their types: those below them are part of their machine code.
CALLED = """
import gc, json, sys
import pounding_risk as pr
if sys.argv[1] == "cache":
    pr.cache("scene.toml")
else:
    pr.scan("scene.toml", check_fraction=0.5)
    pr.simulate("scene.toml")
kernels = [each for each in gc.get_objects() if type(each).__name__ == "CPUDispatcher"]
print(json.dumps(sorted({f"{each.py_func.__module__}.{each.py_func.__qualname__} {types}"
    for each in kernels for types in each.overloads})))
"""


def python(folder: Path, *words: str, **more: str) -> subprocess.CompletedProcess[str]:
    """What Python does in a folder, in a process of its own that finds this very package."""
    environment = bare_environment(PYTHONPATH=str(PACKAGE.parent), **more)
    command = [sys.executable, *words]
    return subprocess.run(command, env=environment, cwd=folder, capture_output=True, text=True, timeout=600)


def command(folder: Path, *words: str, **more: str) -> subprocess.CompletedProcess[str]:
    return python(folder, "-m", "pounding_risk", "cache", *words, **more)


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("name", SCENES)
def test_a_scan_after_it_calls_nothing_else(name, tmp_path):
    """So that nothing is left to be compiled: every kernel, with every combination of types."""
    (tmp_path / "scene.toml").write_text(SCENES[name], encoding="utf-8")
    # The cache of these tests, or else the user's own: what others have compiled.
    home = {"HOME": str(Path.home())} | {key: os.environ[key] for key in ("NUMBA_CACHE_DIR",) if key in os.environ}
    called = {}
    for words in ("cache", "scan"):
        done = python(tmp_path, "-c", CALLED, words, **home)
        assert done.returncode == 0, done.stderr
        called[words] = set(json.loads(done.stdout))
    assert {kernel.split()[0].split(".")[1] for kernel in called["scan"]} >= {"solver", "motions"}
    assert called["scan"] <= called["cache"]


@pytest.fixture
def folder(tmp_path) -> Path:
    """A cache with two other versions of the package, and with what is none."""
    below = tmp_path / "cache" / "pounding_risk"
    for name in ("0123456789abcdef", "fedcba9876543210", "notes", "0123456789abcdef.old"):
        code = below / name / "solver" / "kernel.nbc"
        code.parent.mkdir(parents=True)
        code.write_bytes(bytes(500_000))
    (below / "aaaaaaaaaaaaaaaa").symlink_to(below / "notes")
    return tmp_path


@compiled
@pytest.mark.complete
def test_it_is_looked_into_and_rid_of_other_versions_only(folder):
    place = {"NUMBA_CACHE_DIR": str(folder / "cache")}
    below = folder / "cache" / "pounding_risk"
    told = command(folder, **place)
    assert (told.returncode, told.stderr) == (0, "")
    lines = dict(line.split(maxsplit=1) for line in told.stdout.splitlines()[:2])
    own = Path(lines["folder"])
    assert own.parent == below
    assert lines["compiled"] == "0 functions, 0.0 MB"
    assert "other versions  2 folders, 1.0 MB\n\n--clear-others removes" in told.stdout
    cleared = command(folder, "--clear-others", **place)
    assert (cleared.returncode, "other versions" in cleared.stdout) == (0, False)
    assert {file.name for file in below.iterdir()} == {own.name, "notes", "0123456789abcdef.old", "aaaaaaaaaaaaaaaa"}
    assert (below / "notes" / "solver" / "kernel.nbc").stat().st_size == 500_000


@pytest.mark.complete
def test_what_cannot_be_is_refused_in_a_sentence(tmp_path):
    (tmp_path / "scene.toml").write_text(PAIR, encoding="utf-8")
    (tmp_path / "file").write_text("")
    sentences = {
        "--all-models: no scene to compile for; name scene files, or --shipped": command(tmp_path, "--all-models"),
        "cache: no folder can be written; set NUMBA_CACHE_DIR to one that can": command(
            tmp_path, "scene.toml", NUMBA_CACHE_DIR=str(tmp_path / "file")
        ),
        "cache: compiled code is switched off by NUMBA_DISABLE_JIT; remove it from the environment": command(
            tmp_path, "scene.toml", NUMBA_DISABLE_JIT="1"
        ),
    }
    for sentence, done in sentences.items():
        assert done.returncode == 2, done.stderr
        assert f"pounding-risk: {sentence}\n" in done.stderr
        assert "Traceback" not in done.stderr
