"""Cached code is loaded and run: only from where nobody else can have written it."""

import os
import shutil
from itertools import product
from pathlib import Path

import pytest
from processes import PACKAGE, bare_environment, compiled, told
from sweeps import sweep

from pounding_risk._jit import sources, trust

pytestmark = pytest.mark.skipif(not hasattr(os, "geteuid"), reason="owners and modes are a matter of POSIX")
as_root = pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root gives files away")
STRANGER = 65534
PROBE = """
from pounding_risk.solver.pair import law_verbs
from pounding_risk.models.contact.laws import LAWS
law_verbs.depth_of(LAWS["hertz"](1e9), 1234.5, 1e-6)
stats = law_verbs.depth_of.stats
print(sum(stats.cache_hits.values()), sum(stats.cache_misses.values()))
"""


def run(cache: Path, umask: int = 0o022, **more: str) -> tuple[str, str]:
    """What a fresh process says of one kernel, hits and misses, and its standard error."""
    environment = bare_environment(PYTHONPATH=str(PACKAGE.parent), **(more or {"NUMBA_CACHE_DIR": str(cache)}))
    counts, said = told("-c", f"import os; os.umask({umask})\n{PROBE}", env=environment, timeout=300)
    return counts.strip(), said


@pytest.fixture(scope="module")
def made(tmp_path_factory) -> Path:
    """A cache with one kernel, made where the umask keeps nothing from anybody."""
    folder = tmp_path_factory.mktemp("made") / "cache"
    assert run(folder, umask=0)[0] == "0 1"
    return folder


@pytest.fixture
def cache(made, tmp_path) -> Path:
    """A copy of it, modes included, that a test may change."""
    return Path(shutil.copytree(made, tmp_path / "cache"))


def below(cache: Path) -> list[Path]:
    return [cache, *cache.rglob("*")]


@pytest.mark.complete
@compiled
def test_a_cache_is_private_whatever_the_umask(cache):
    modes = {(path.is_dir(), path.stat().st_mode & 0o777) for path in below(cache)}
    assert modes == {(True, 0o700), (False, 0o600)}
    assert run(cache) == ("1 0", "")


@compiled
@pytest.mark.parametrize(("mode", "depth"), sweep(product([0o777, 0o770, 0o702], range(3)), (0o770, 1)))
@pytest.mark.complete
def test_a_folder_that_others_can_write_is_not_used(cache, depth, mode):
    folder = sorted((path for path in below(cache) if path.is_dir()), key=lambda path: len(path.parts))[depth]
    folder.chmod(mode)
    before = below(cache)
    counts, said = run(cache)
    assert counts == "0 1"
    assert said.count(f"chmod go-w {folder}") == 1
    assert f"(mode {mode:04o})" in said
    assert below(cache) == before  # nor is anything written there
    folder.chmod(0o700)
    assert run(cache) == ("1 0", "")


@compiled
@pytest.mark.complete
def test_a_subfolder_that_others_can_write_is_not_read(cache):
    shelf = next(cache.rglob("*.nbi")).parent
    shelf.chmod(0o777)
    counts, said = run(cache)
    assert counts == "0 1" and f"chmod go-w {shelf}" in said


@compiled
@pytest.mark.parametrize("suffix", sweep(["nbi", "nbc"], "nbc"))
@pytest.mark.complete
def test_a_file_that_others_can_write_is_compiled_anew_once(cache, suffix):
    file = next(cache.rglob(f"*.{suffix}"))
    file.chmod(0o666)
    counts, said = run(cache)
    assert counts == "0 1" and str(file) in said and "(mode 0666)" in said
    assert file.stat().st_mode & 0o777 == 0o600
    assert run(cache) == ("1 0", "")


@compiled
@as_root
@pytest.mark.parametrize("what", sweep(["folder", "file"], "file"))
@pytest.mark.complete
def test_what_another_user_owns_is_not_used(cache, what):
    os.chown(cache / "pounding_risk" if what == "folder" else next(cache.rglob("*.nbc")), STRANGER, STRANGER)
    counts, said = run(cache)
    assert counts == "0 1"
    assert f"belongs to another user (uid {STRANGER})" in said


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("key", sweep(["XDG_CACHE_HOME", "HOME"], "HOME"))
def test_the_users_own_cache_is_checked_too(key, tmp_path):
    place = tmp_path / ".cache"
    place.mkdir()
    place.chmod(0o777)
    counts, said = run(tmp_path, **{key: str(place if key == "XDG_CACHE_HOME" else tmp_path), "TMPDIR": str(tmp_path)})
    assert counts == "0 1" and said.count(f"chmod go-w {place}") == 1
    assert list(place.iterdir()) == [], "no other place is taken instead, and nothing is written there"


@pytest.mark.parametrize("mode, trusted", [(0o777, False), (0o775, False), (0o1777, True), (0o755, True)])
def test_folders_above_may_be_shared_where_the_sticky_bit_holds(tmp_path, mode, trusted):
    root = tmp_path / "shared" / "mine"
    root.mkdir(parents=True, mode=0o700)
    root.parent.chmod(mode)
    assert (trust.doubt(root / "pounding_risk", root) is None) == trusted


def test_a_link_leads_to_what_is_checked(tmp_path):
    (tmp_path / "open").mkdir()
    (tmp_path / "open").chmod(0o777)
    (tmp_path / "link").symlink_to("open")
    assert str(tmp_path / "open") in (trust.doubt(tmp_path / "link" / "pounding_risk", tmp_path / "link") or "")


@as_root
def test_a_strangers_link_is_not_followed(tmp_path):
    (tmp_path / "mine").mkdir(mode=0o700)
    (tmp_path / "link").symlink_to("mine")
    os.lchown(tmp_path / "link", 4711, 4711)
    assert "belongs to another user (uid 4711)" in (trust.doubt(tmp_path / "link", tmp_path / "link") or "")


@as_root
@pytest.mark.parametrize("owner, trusted", [(0, True), (trust.NOBODY, True), (4711, False)])
def test_folders_above_are_roots_or_the_users(tmp_path, owner, trusted):
    """In a user namespace and behind an NFS server root's folders appear as those of nobody."""
    (tmp_path / "above" / "mine").mkdir(parents=True, mode=0o700)
    os.chown(tmp_path / "above", owner, owner)
    assert (trust.doubt(tmp_path / "above" / "mine", tmp_path / "above" / "mine") is None) == trusted


def test_without_owners_nothing_is_checked(tmp_path, monkeypatch):
    monkeypatch.setattr(trust, "CHECKED", False)
    tmp_path.chmod(0o777)
    monkeypatch.setenv("NUMBA_CACHE_DIR", str(tmp_path))
    assert sources.cache_folder() is not None


@compiled
@pytest.mark.complete
def test_a_command_says_it_once(tmp_path):
    tmp_path.chmod(0o777)
    environment = bare_environment(PYTHONPATH=str(PACKAGE.parent), NUMBA_CACHE_DIR=str(tmp_path))
    (sentence,) = told("-m", "pounding_risk", "cache", env=environment)[1].splitlines()
    assert sentence.startswith("pounding-risk: note: compiled code is not kept, so that every start compiles again: ")
    assert f"chmod go-w {tmp_path}" in sentence
