"""The compile cache is never stale, never in the way; compiled numbers are the interpreted ones, in bits."""

import ast
import gc
import importlib
import json
import os
import pkgutil
import shutil
from pathlib import Path

import numpy as np
import pytest
from processes import PACKAGE, bare_environment, compiled, interpreted, output, python
from sweeps import sweep

import pounding_risk
from pounding_risk._jit import sources as _jit
from pounding_risk.models.contact import laws as contact
from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import CONCRETE
from pounding_risk.models.structures.sdof import Building
from pounding_risk.solver.pair.api import Interface, solve
from pounding_risk.solver.pair.run import march

# A kernel that calls, through a law of another file, a helper beside that law: what numba's own stamp misses.
PROBE = """
import json, sys
from pounding_risk._jit import sources as _jit
from pounding_risk.solver.pair import law_verbs as collide
from pounding_risk.models.contact.laws import LAWS
values = [collide.depth_of(LAWS[name](1e9), 1234.5, 1e-6) for name in ("hertz", "linear")]
if _jit.INTERPRETED:
    hits, misses = 0, 0
else:
    stats = collide.depth_of.stats
    hits, misses = sum(stats.cache_hits.values()), sum(stats.cache_misses.values())
declared = "numba.np.linalg" in sys.modules  # numba's declarations of what can be compiled
found = {"file": _jit.__file__, "cache": _jit.compile_cache(), "values": values, "hits": hits, "misses": misses}
found["declared"] = declared
print(json.dumps(found))
"""


def run(code: str, package: Path = PACKAGE, **more: str) -> dict:
    """Run code in a fresh interpreter on a copy of the package; what it prints, as JSON."""
    environment = bare_environment(PYTHONPATH=str(package.parent), **more)
    return json.loads(output("-c", code, env=environment, cwd=package.parent, timeout=300).splitlines()[-1])


@pytest.fixture
def copy(tmp_path) -> Path:
    """A copy of the package that a test may edit."""
    target = tmp_path / "copy" / "pounding_risk"
    shutil.copytree(PACKAGE, target, ignore=shutil.ignore_patterns("__pycache__", "records"))
    return target


@pytest.fixture(scope="module")
def filled(tmp_path_factory) -> tuple[Path, dict]:
    """A cache that one process has filled, and what that process found."""
    folder = tmp_path_factory.mktemp("cache")
    return folder, run(PROBE, NUMBA_CACHE_DIR=str(folder))


@pytest.mark.complete
@compiled
def test_a_second_process_compiles_nothing(filled):
    folder, first = filled
    second = run(PROBE, NUMBA_CACHE_DIR=str(folder))
    assert (first["hits"], first["misses"]) == (0, 2)
    assert (second["hits"], second["misses"]) == (2, 0)
    assert second["values"] == first["values"]
    assert first["declared"] and not second["declared"], "what takes longest to load is only loaded to compile"
    assert Path(first["cache"]).is_relative_to(folder)


@compiled
def test_an_edited_law_is_never_answered_from_the_cache(copy, filled, tmp_path):
    """∫ β x^1.5 dx = 0.4 β δ^2.5; with 0.8 in its place the depth found must be another one."""
    law = copy / "models" / "contact" / "law.py"
    before = run(PROBE, copy, NUMBA_CACHE_DIR=str(tmp_path))
    assert Path(before["file"]).is_relative_to(copy)
    assert before["values"] == filled[1]["values"]
    text = law.read_text(encoding="utf-8")
    assert text.count("return 0.4 * stiffness") == 1
    law.write_text(text.replace("return 0.4 * stiffness", "return 0.8 * stiffness"), encoding="utf-8")
    after = run(PROBE, copy, NUMBA_CACHE_DIR=str(tmp_path))
    assert after["cache"] != before["cache"]
    assert after["hits"] == 0
    assert after["values"][0] != before["values"][0]
    assert after["values"][1] == before["values"][1]
    law.write_text(text, encoding="utf-8")
    again = run(PROBE, copy, NUMBA_CACHE_DIR=str(tmp_path))
    assert (again["cache"], again["values"], again["hits"]) == (before["cache"], before["values"], 2)


def test_the_digest_follows_every_source_file_of_the_kernels(copy, monkeypatch):
    """And no other: an edit of a figure compiles nothing anew."""
    monkeypatch.setattr(_jit, "__file__", str(copy / "_jit" / "sources.py"))
    seen = {_jit.source_digest()}
    assert seen == {_jit.source_digest()}, "the digest is not reproducible"
    (copy / "figures" / "new.py").write_text("", encoding="utf-8")
    assert seen == {_jit.source_digest()}
    files = [file for folder in ("solver", "models", "_jit", "lab/baselines") for file in (copy / folder).rglob("*.py")]
    files += [copy / "motions" / "spectra.py", copy / "units.py"]
    assert len(files) > 15
    for file in files:
        file.write_text(file.read_text(encoding="utf-8") + "#", encoding="utf-8")
        seen.add(_jit.source_digest())
    (copy / "models" / "new_law.py").write_text("", encoding="utf-8")
    seen.add(_jit.source_digest())
    (copy / "models" / "new_law.py").rename(copy / "models" / "other_law.py")
    seen.add(_jit.source_digest())
    assert len(seen) == len(files) + 3


DAMAGE = {
    "an empty index": ("*.nbi", lambda raw: b""),
    "an index cut short": ("*.nbi", lambda raw: raw[: len(raw) // 2]),
    "an index of something else": ("*.nbi", lambda raw: b"not a pickle at all"),
    "empty code": ("*.nbc", lambda raw: b""),
    "code cut short": ("*.nbc", lambda raw: raw[: len(raw) // 2]),
    "code cut by one byte": ("*.nbc", lambda raw: raw[:-1]),
    "code of something else": ("*.nbc", lambda raw: b"\x80\x04N."),  # a pickle of None
}


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("damage", sweep(DAMAGE, "an index cut short", "code cut by one byte"))
def test_a_damaged_cache_is_mended(damage, filled, tmp_path):
    """A full disk or a power cut leaves such files; the run must not fail, nor the one after it be slow."""
    folder, good = filled
    shutil.copytree(folder, tmp_path / "cache")
    pattern, harm = DAMAGE[damage]
    files = [file for file in (tmp_path / "cache").rglob(pattern) if "depth_of" in file.name]
    assert files
    for file in files:
        file.write_bytes(harm(file.read_bytes()))
    mended = run(PROBE, NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert mended["values"] == good["values"]
    after = run(PROBE, NUMBA_CACHE_DIR=str(tmp_path / "cache"))
    assert (after["values"], after["hits"]) == (good["values"], 2)


@compiled
def test_code_of_another_law_is_not_taken(filled, tmp_path):
    """Two processes that compile a kernel for two laws at once may give both one file (numba issue 4807)."""
    folder, good = filled
    shutil.copytree(folder, tmp_path / "cache")
    files = sorted(file for file in (tmp_path / "cache").rglob("*.nbc") if "depth_of" in file.name)
    assert len(files) == 2
    files[0].write_bytes(files[1].read_bytes())
    assert run(PROBE, NUMBA_CACHE_DIR=str(tmp_path / "cache"))["values"] == good["values"]


@compiled
@pytest.mark.complete
def test_processes_that_start_together_agree(filled, tmp_path):
    environment = bare_environment(PYTHONPATH=str(PACKAGE.parent), NUMBA_CACHE_DIR=str(tmp_path))
    started = [python("-c", PROBE, env=environment) for _ in range(4)]
    found = [json.loads(process.communicate(timeout=300)[0]) for process in started]
    assert all(process.returncode == 0 for process in started)
    assert {tuple(one["values"]) for one in found} == {tuple(filled[1]["values"])}


@pytest.fixture
def blocked(tmp_path) -> str:
    """A path below a file: no folder can be made there, whoever asks."""
    (tmp_path / "file").write_text("", encoding="utf-8")
    return str(tmp_path / "file" / "below")


@compiled
@pytest.mark.complete
def test_without_a_home_the_cache_is_in_the_temporary_folder(blocked, filled, tmp_path):
    (tmp_path / "temporary").mkdir()
    found = run(PROBE, HOME=blocked, TMPDIR=str(tmp_path / "temporary"))
    assert Path(found["cache"]).is_relative_to(tmp_path / "temporary")
    assert found["values"] == filled[1]["values"]
    again = run(PROBE, HOME=blocked, TMPDIR=str(tmp_path / "temporary"))
    assert (again["hits"], again["values"]) == (2, found["values"])


@compiled
@pytest.mark.complete
def test_without_any_place_nothing_is_cached(blocked, filled):
    found = run(PROBE, NUMBA_CACHE_DIR=blocked)
    assert (found["cache"], found["hits"]) == (None, 0)
    assert found["values"] == filled[1]["values"]


@compiled
@pytest.mark.complete
def test_a_cache_is_read_from_wherever_the_package_is_installed(copy, filled):
    """Machines of a cluster may share a cache: it knows kernels by their module and the digest of all of them."""
    folder, first = filled
    found = run(PROBE, copy, NUMBA_CACHE_DIR=str(folder))
    assert Path(found["file"]).is_relative_to(copy)
    assert (found["hits"], found["misses"], found["values"]) == (2, 0, first["values"])


# What a folder that can only be read answers, to root as well.
REFUSING = """
import tempfile
def refuse(*_, **__):
    raise PermissionError(13, "Permission denied")
tempfile.NamedTemporaryFile = tempfile.TemporaryFile = refuse
"""


@compiled
@pytest.mark.complete
def test_a_cache_that_can_only_be_read_is_read(filled, tmp_path):
    """As on a node whose homes are read-only; a folder that is empty as well is of no use."""
    folder, first = filled
    found = run(REFUSING + PROBE, NUMBA_CACHE_DIR=str(folder))
    assert (found["cache"], found["hits"], found["values"]) == (first["cache"], 2, first["values"])
    assert run(REFUSING + PROBE, NUMBA_CACHE_DIR=str(tmp_path))["cache"] is None


@compiled
@pytest.mark.complete
def test_a_cache_that_can_no_longer_be_written_is_left_alone(filled, tmp_path):
    """The disk fills up, or the folder goes, after the first look at it."""
    code = "import shutil\nfrom pounding_risk._jit import sources as _jit\nimport pounding_risk.solver.pair.law_verbs\n"
    code += "shutil.rmtree(_jit.compile_cache())\nopen(_jit.compile_cache(), 'w').close()\n" + PROBE
    assert run(code, NUMBA_CACHE_DIR=str(tmp_path / "cache"))["values"] == filled[1]["values"]


def test_a_user_without_home_or_account_litters_nothing(tmp_path, monkeypatch):
    """expanduser gives "~/.cache" back as it is where nobody knows the user: no folder of that name."""
    for key in ("NUMBA_CACHE_DIR", "XDG_CACHE_HOME"):
        monkeypatch.delenv(key, raising=False)
    monkeypatch.setattr(_jit.os.path, "expanduser", lambda path: path)
    monkeypatch.setattr(_jit.tempfile, "tempdir", str(tmp_path / "temporary"))
    (tmp_path / "temporary").mkdir()
    (tmp_path / "work").mkdir()
    monkeypatch.chdir(tmp_path / "work")
    chosen = _jit.cache_folder()
    assert list((tmp_path / "work").iterdir()) == []
    assert chosen is not None
    assert Path(chosen).is_relative_to(tmp_path / "temporary")


def test_no_temporary_folder_is_no_reason_to_fail(blocked, monkeypatch):
    def none() -> str:
        raise FileNotFoundError("no usable temporary directory found")

    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", blocked)
    monkeypatch.setattr(_jit.tempfile, "gettempdir", none)
    assert _jit.cache_folder() is None


@pytest.mark.skipif(not hasattr(os, "getuid"), reason="owners are a matter of POSIX")
def test_a_strangers_folder_is_not_trusted(tmp_path, blocked, monkeypatch):
    """Cached code is loaded and run: from the shared temporary folder only what this user alone can write."""
    monkeypatch.delenv("NUMBA_CACHE_DIR", raising=False)
    monkeypatch.setenv("XDG_CACHE_HOME", blocked)
    monkeypatch.setattr(_jit.tempfile, "tempdir", str(tmp_path))
    private = tmp_path / f"pounding_risk-{os.getuid()}"
    private.mkdir()
    private.chmod(0o777)
    assert _jit.cache_folder() is None
    private.rmdir()
    chosen = _jit.cache_folder()
    assert chosen is not None
    assert Path(chosen).is_relative_to(private)
    assert private.stat().st_mode & 0o077 == 0


def kernels() -> dict:
    """Every compiled function of the package, by its full name."""
    from pounding_risk._jit.compile import InCompiledCode

    found = {}
    for module in pkgutil.walk_packages(pounding_risk.__path__, "pounding_risk."):
        if module.name.endswith("__main__"):
            continue
        for member in vars(importlib.import_module(module.name)).values():
            if isinstance(member, InCompiledCode) and hasattr(member, "py_func"):
                found[f"{member.py_func.__module__}.{member.py_func.__name__}"] = member
    return found


@compiled
def test_every_kernel_has_the_same_flags():
    """fastmath deletes NaN guards, and flags leak between kernels: one set for all."""
    found = kernels()
    assert {
        "pounding_risk.solver.pair.flight.fly",
        "pounding_risk.solver.pair.contact.integrate_contact",
        "pounding_risk.solver.pair.run.march",
    } <= set(found)
    for name, dispatcher in found.items():
        options = dispatcher.targetoptions
        assert not options.get("fastmath"), name
        assert not options.get("parallel"), name
        assert options["nogil"], name
        assert options["error_model"] == "numpy", name


@pytest.mark.complete
@compiled
def test_kernels_take_names_from_the_files_of_the_digest_alone():
    """A constant or function of another file could change, and its kernels would answer from the cache."""
    covered = tuple(f"pounding_risk.{name.removesuffix('.py').replace('/', '.')}" for name in _jit.KERNEL_SOURCES)

    def is_covered(module: str) -> bool:
        return any(module == each or module.startswith(f"{each}.") for each in covered)

    found = kernels()
    assert len(found) > 100
    for name, member in found.items():
        function = member.py_func
        assert is_covered(function.__module__), name
        tree = ast.parse(Path(function.__code__.co_filename).read_text(encoding="utf-8"))
        imports = [node for node in ast.walk(tree) if isinstance(node, ast.ImportFrom) and node.module]
        for node in imports:
            taken = {alias.asname or alias.name for alias in node.names} & set(function.__code__.co_names)
            is_ours = node.module.startswith("pounding_risk")
            assert not taken or not is_ours or is_covered(node.module), (name, node.module, taken)


# Two buildings out of tune under a burst of 3 s: every law meets several contacts, capped ones yield.
LEFT, RIGHT = Building("frame", 5e5, 0.5, 0.05), Building("masonry", 8e5, 0.2, 0.05)
DT = 0.01  # s


def burst() -> np.ndarray:
    """Ground acceleration [m/s²]."""
    time = DT * np.arange(300)
    return 3.0 * np.sin(8.2 * time) * np.exp(-(((time - 1.2) / 0.8) ** 2)) + 0.7 * np.sin(40.0 * time)


def case(name: str, number: type = float) -> dict[str, float]:
    """One run; ``number`` is the type of the law's stiffness."""
    linear = contact.stiffness_quantity(LAWS[name]).unit == "N/m"
    law = LAWS[name](number(100_000_000 if linear else 2_750_000_000))
    return solve(LEFT, RIGHT, Interface(0.005, law, CONCRETE, 5e5), burst(), DT)


def exact(outputs: dict[str, float]) -> dict[str, str]:
    """Every bit of the outputs; NaN is equal to NaN."""
    return {name: float(value).hex() for name, value in outputs.items()}


INTERPRETED_CASES = """
import json
from test_compile import LAWS, case, exact
from pounding_risk._jit import sources as _jit
assert _jit.INTERPRETED
print(json.dumps({name: [exact(case(name)), exact(case(name, int))] for name in LAWS}))
"""


@pytest.fixture(scope="module")
def uncompiled() -> dict[str, list[dict[str, str]]]:
    """The runs of every law without compilation, with its stiffness as a float and as an int."""
    return interpreted(INTERPRETED_CASES)


# One law of each kind at once; the rest cost a compilation each.
FIRST = ("viscous_elastoplastic", "kelvin_voigt_tension_cut")


@pytest.mark.complete
@compiled
@pytest.mark.parametrize("name", sweep(LAWS, *FIRST))
def test_compiled_and_interpreted_runs_are_the_same_bits(name, uncompiled):
    outputs = case(name)
    assert outputs["status"] == 0.0
    assert outputs["impact_count"] >= 3
    if LAWS[name].capped:
        assert outputs["yield_count"] >= 1
    assert exact(outputs) == uncompiled[name][0]


@compiled
@pytest.mark.parametrize("name", FIRST)
@pytest.mark.complete
def test_whole_numbers_compile_nothing_new(name):
    """A stiffness of 10**8 is another type than 1e8: it must not cost a compilation of its own."""
    outputs = exact(case(name))
    known = len(march.signatures)
    assert exact(case(name, int)) == outputs
    assert len(march.signatures) == known


def test_whole_numbers_are_the_same_law(uncompiled):
    for name, (as_float, as_int) in uncompiled.items():
        assert as_int == as_float, name


@pytest.mark.complete
def test_interpreted_kernels_are_ordinary_functions():
    """For the debugger and for coverage; and nothing is cached then."""
    found = run(PROBE, NUMBA_DISABLE_JIT="1")
    assert found["cache"] is None
    code = "import json, types\nfrom pounding_risk.solver.pair import flight\n"
    code += "print(json.dumps({'plain': isinstance(flight.fly, types.FunctionType)}))"
    assert run(code, NUMBA_DISABLE_JIT="1") == {"plain": True}


@pytest.mark.complete
def test_a_file_of_settings_that_switches_compiling_off_is_followed(copy):
    """Numba reads it in the present folder, where PyYAML is installed."""
    pytest.importorskip("yaml")
    (copy.parent / ".numba_config.yaml").write_text("disable_jit: 1\n", encoding="utf-8")
    assert run(PROBE, copy)["cache"] is None


@compiled
def test_probe_values_are_the_interpreted_ones(filled):
    assert run(PROBE, NUMBA_DISABLE_JIT="1")["values"] == filled[1]["values"]


def test_compiling_leaves_the_garbage_collector_as_it_was():
    """Objects that the process had are frozen while it compiles, unless others froze some, and no longer."""
    from pounding_risk._jit.lowering.fragments import Garbage

    garbage = Garbage()
    with garbage.freed():
        assert not gc.isenabled() and gc.get_freeze_count() > 0
        for _ in range(garbage.EVERY):
            garbage.one_more()
    assert gc.isenabled() and gc.get_freeze_count() == 0
    gc.freeze()
    try:
        frozen = gc.get_freeze_count()
        with garbage.freed():
            garbage.one_more()
            assert gc.isenabled()
        assert gc.get_freeze_count() == frozen
    finally:
        gc.unfreeze()
