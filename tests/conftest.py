"""Settings of all tests: Matplotlib opens no window, dates are fixed, hypothesis draws the same examples every time."""

from __future__ import annotations

import ctypes
import gc
import os
import pickle
import shutil
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, settings
from sentences import pytest_addoption, pytest_configure, pytest_sessionfinish, says

__all__ = ["pytest_addoption", "pytest_configure", "pytest_sessionfinish", "says"]

os.environ.setdefault("MPLBACKEND", "Agg")
# Datasets tell when they were made: of two of one study every byte is compared, whatever the time.
os.environ["SOURCE_DATE_EPOCH"] = "1700000000"

# Before NumPy is loaded. Its threads wait for each other by counting: beside the other test processes a matrix of forty
# rows then takes four times the processor time, and verification half as much again.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A shell starts background jobs with interrupts ignored, which every child would inherit: tests of Ctrl-C need them.
if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
    signal.signal(signal.SIGINT, signal.default_int_handler)

# Compiling a kernel takes seconds the first time, so an example has no deadline.
settings.register_profile(
    "project",
    deadline=None,
    derandomize=True,
    database=None,
    print_blob=True,
    suppress_health_check=[HealthCheck.too_slow],
)
settings.load_profile("project")

# `pytest -n 2` gives each process one half of the tests to begin with. The first half begins with what compiles the
# kernels of pairs, the second with those of rows; what compiles none follows, until each finds the other's compiled.
OF_PAIRS = (
    "models",
    *(f"solver/test_{name}.py" for name in ("flight", "pair", "against_scipy", "grid", "closings")),
    "lab/test_hard_properties.py",
)
OF_ROWS = (
    "models/test_matrices.py",
    *(
        f"solver/test_{name}.py"
        for name in ("rows_laws", "links", "isolated", "matrix_rows", "rotating_floors", "row_blocks")
    ),
)
# Early as well: what both processes would else wait for at the end, the pages of the site and the notebooks.
AFTER_PAIRS = ("test_docs.py", "test_notebooks.py", "motions/formats", "motions/processing", "test_units.py", "common")
AFTER_ROWS = ("test_architecture.py", "test_docstrings.py", "test_python_calls.py", "streets", "statistics")


@pytest.hookimpl(trylast=True)  # of those that `-m` leaves
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Put first what compiles, each kind of kernel in a half of its own, then what compiles none."""
    here = Path(__file__).parent
    groups: dict[tuple[str, ...], list[pytest.Item]] = {
        names: [] for names in (OF_ROWS, AFTER_ROWS, OF_PAIRS, AFTER_PAIRS, ())
    }
    for item in items:
        place = item.path.relative_to(here).as_posix()
        groups[next(names for names in groups if not names or place.startswith(names))].append(item)
    first, second = groups[OF_PAIRS] + groups[AFTER_PAIRS], groups[OF_ROWS] + groups[AFTER_ROWS]
    others = groups[()]
    room = max(len(items) // 2 - len(first), 0)
    items[:] = first + others[:room] + second + others[room:]


def pytest_runtest_teardown(item: pytest.Item, nextitem: pytest.Item | None) -> None:
    """Let go of figures, which hold themselves in circles, and of memory that is free but kept by the process."""
    is_last = nextitem is None or nextitem.path != item.path
    if {"figures", "reports"} & set(item.path.parts):  # 180 MB of figures by the end of a file
        gc.collect(2 if is_last else 1)  # those of this test alone are found in some milliseconds
    if is_last and sys.platform == "linux" and (trim := getattr(ctypes.CDLL(None), "malloc_trim", None)):
        trim(0)


@pytest.fixture(scope="session")
def root() -> Path:
    """Root folder of the checkout."""
    return Path(__file__).resolve().parent.parent


@pytest.fixture
def ops() -> Any:
    """The module of OpenSees; where it is not installed a test is skipped, with the reason."""
    from pounding_risk.errors import PoundingError
    from pounding_risk.lab.accuracy_opensees import load

    try:
        return load()
    except PoundingError as reason:
        pytest.skip(str(reason))


@pytest.fixture
def small_disk(tmp_path) -> Iterator[Path]:
    """A file system of 300 kB, where this user may mount one."""
    place = tmp_path / "small"
    place.mkdir()
    mount = shutil.which("mount")
    command = [mount or "mount", "-t", "tmpfs", "-o", "size=300k", "tmpfs", str(place)]
    if mount is None or subprocess.run(command, capture_output=True).returncode != 0:
        pytest.skip("no file system can be mounted here; a process with a limit on its files stands in for it")
    yield place
    subprocess.run(["umount", "-l", str(place)], check=True)


@contextmanager
def _locked(path: Path) -> Iterator[None]:
    """Held by one process at a time; a process that ends lets go of it."""
    with path.open("w") as file:
        try:
            import fcntl
        except ImportError:  # not POSIX: two processes may both do the work
            pass
        else:
            fcntl.flock(file, fcntl.LOCK_EX)
        yield


@pytest.fixture(scope="session")
def shared_once(tmp_path_factory: pytest.TempPathFactory) -> Callable[[str, Callable[[], Any]], Any]:
    """``shared_once(name, make)``: what ``make()`` gives, made by the first test process that asks for the name.

    A session's fixtures are made in each process of `pytest -n`. What takes long and can be pickled goes through here;
    each process has a copy of its own.
    """
    base = tmp_path_factory.getbasetemp()
    folder = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base

    def once(name: str, make: Callable[[], Any]) -> Any:
        kept = folder / f"shared-{name}.pickle"
        with _locked(folder / f"shared-{name}.lock"):
            if not kept.exists():
                whole = kept.with_suffix(f".{os.getpid()}")
                whole.write_bytes(pickle.dumps(make()))
                whole.replace(kept)
        return pickle.loads(kept.read_bytes())

    return once
