"""A damaged cache, a full disk, no home, a folder that cannot be written: a command runs, and says so in a sentence."""

import os
import shutil
from collections.abc import Iterator
from pathlib import Path

import pytest
from processes import bare_environment, compiled, ended
from scenes import FRAME, rigid, scene_text

from pounding_risk._jit.sources import compile_cache
from pounding_risk.scene.reader import parse_scene
from pounding_risk.studies.simulate import simulate

pytestmark = [compiled, pytest.mark.complete]
SCENE = scene_text(
    FRAME, rigid(), gap="1 mm", stiffness="4.2e7 kN/m^1.5", restitution="concrete", records={"window": ["0 s", "3 s"]}
)
NEEDED = ("free.fill_free_response", "laws.force_verbs", "run.march", "flight.write_series", "flight.state_at")
CHEAP = "flight.write_series"  # compiled anew in a second
ADVICE = "set NUMBA_CACHE_DIR to a folder that can be written"


@pytest.fixture(scope="module")
def warm(tmp_path_factory) -> Path:
    """A cache with all that the scene needs, below a folder of its own."""
    simulate(parse_scene(SCENE))
    folder = compile_cache()
    assert folder is not None
    kept = Path(folder)
    target = tmp_path_factory.mktemp("warm")
    for file in kept.glob("solver/**/*"):
        if file.name.startswith(NEEDED):
            copied = target / "pounding_risk" / file.relative_to(kept.parent)
            copied.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(file, copied)
    return target


@pytest.fixture
def cache(warm, tmp_path) -> Path:
    """A copy of it that a test may harm."""
    return Path(shutil.copytree(warm, tmp_path / "cache"))


@pytest.fixture
def folder(tmp_path) -> Path:
    """A folder with the scene and a file in the way of folders."""
    (tmp_path / "scene.toml").write_text(SCENE, encoding="utf-8")
    (tmp_path / "file").write_text("", encoding="utf-8")
    return tmp_path


def command(folder: Path, *words: str, **more: str) -> tuple[str, list[str]]:
    """What a command in a process of its own prints, and its lines on standard error."""
    return started(folder, "-m", "pounding_risk", *words, **more)


def started(folder: Path, *words: str, **more: str) -> tuple[str, list[str]]:
    """The same of Python."""
    done = ended(*words, env=bare_environment(**more), cwd=folder)
    assert done.returncode == 0, done.stderr
    return done.stdout, done.stderr.splitlines()


@pytest.fixture(scope="module")
def usual(warm, tmp_path_factory) -> str:
    """The output where all is as usual: nothing is said of the cache then."""
    folder = tmp_path_factory.mktemp("usual")
    (folder / "scene.toml").write_text(SCENE, encoding="utf-8")
    output, notes = command(folder, "simulate", "scene.toml", NUMBA_CACHE_DIR=str(warm))
    assert notes == []
    assert "contact" in output
    return output


def harmed(cache: Path, pattern: str) -> Iterator[Path]:
    for file in cache.rglob(f"{CHEAP}*{pattern}"):
        raw = file.read_bytes()
        file.write_bytes(raw[: len(raw) // 2])
        yield file


# That the next start finds it whole again is for test_compile.
@pytest.mark.parametrize("pattern", [".nbc", ".nbi"])
def test_damaged_code_is_told_once(pattern, cache, folder, usual):
    assert list(harmed(cache, pattern))
    output, notes = command(folder, "simulate", "scene.toml", NUMBA_CACHE_DIR=str(cache))
    assert output == usual
    (sentence,) = notes
    assert sentence.startswith(f"pounding-risk: note: compiled code in {cache / 'pounding_risk'}")
    assert sentence.endswith("was damaged (pickle data was truncated) and is compiled anew")


@pytest.mark.skipif(os.name == "nt", reason="limits of a process are a matter of POSIX")
def test_a_full_disk_is_told_once(cache, folder, usual):
    """Files may be opened and not be filled, as on a disk without space: here beyond the first block."""
    for file in list(cache.rglob(f"{CHEAP}*")):
        file.unlink()
    code = (
        "import resource, runpy, signal, sys\n"
        "signal.signal(signal.SIGXFSZ, signal.SIG_IGN)\n"
        "resource.setrlimit(resource.RLIMIT_FSIZE, (100, 100))\n"
        "sys.argv = ['pounding-risk', 'simulate', 'scene.toml']\n"
        "runpy.run_module('pounding_risk', run_name='__main__')\n"
    )
    output, (sentence,) = started(folder, "-c", code, NUMBA_CACHE_DIR=str(cache))
    assert output == usual
    assert (
        f"cannot be kept (File too large), so that the next start compiles again; free space, or {ADVICE}" in sentence
    )


def test_without_a_home_the_place_is_told(warm, folder, usual):
    """What cannot be made by any user, root among them, stands for a home that is missing."""
    (folder / "temporary").mkdir()
    private = folder / "temporary" / f"pounding_risk-{os.getuid() if hasattr(os, 'getuid') else 'user'}"
    shutil.copytree(warm, private)
    private.chmod(0o700)
    home = folder / "file" / "home"
    output, notes = command(folder, "simulate", "scene.toml", HOME=str(home), TMPDIR=str(folder / "temporary"))
    assert output == usual
    (sentence,) = notes
    assert sentence.startswith(f"pounding-risk: note: compiled code is kept in {private / 'pounding_risk'}")
    assert sentence.endswith(f"since {home / '.cache'} cannot be written; to keep it elsewhere, {ADVICE}")


def test_what_is_not_kept_is_told(folder):
    """The folder asked for is a file; `validate` compiles nothing, and tells it too."""
    output, notes = command(folder, "validate", "scene.toml", NUMBA_CACHE_DIR=str(folder / "file"))
    assert "nothing is run" in output
    assert notes == [
        f"pounding-risk: note: compiled code is not kept, since NUMBA_CACHE_DIR, {folder / 'file'}, is no folder that "
        f"can be written; every start compiles again; {ADVICE}"
    ]


def test_a_warning_of_something_else_is_shown_as_it_is(folder):
    code = (
        "import warnings\n"
        "from pounding_risk.cli._common.compile_cache import report_trouble\n"
        "with report_trouble():\n"
        "    warnings.warn('a compiled kernel is a kernel')\n"
    )
    _, lines = started(folder, "-c", code)
    assert any("UserWarning: a compiled kernel is a kernel" in line for line in lines)
