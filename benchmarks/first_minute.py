"""Processor seconds of first and of later commands: ``python benchmarks/first_minute.py [TREE ...]``.

Each command is a process of its own, as a user starts it; *first* ones find an empty compile cache, *later* ones what
the first have left, and their modules as bytecode, as those of an installed package are. With several checkouts they
take turns, so that a busy machine slows all, and the ratio to the first one is printed. Medians of ``--repeats``; first
commands are as many times compiled.
"""

from __future__ import annotations

import argparse
import os
import resource
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path
from statistics import median

from shortened import IS_SHORT, either

HERE = Path(__file__).resolve().parents[1]
PAIR, ROW = "pounding_risk/scene/shipped/paper.toml", "pounding_risk/scene/shipped/row.toml"
ONE_CASE = ("--check-fraction", "0", "--new", "-o", "one.nc")
FIRST = {
    "first scan of a pair": ("scan", PAIR, *ONE_CASE),
    "first scan of a row": ("scan", ROW, *ONE_CASE),
    "first compare, all models": ("compare", PAIR, "-o", "models.nc"),
}
LATER = {
    "--help": ("--help",),
    "models": ("models",),
    "validate, pair": ("validate", PAIR),
    "validate, row": ("validate", ROW),
    "scan of a pair": ("scan", PAIR, *ONE_CASE),
    "scan of a row": ("scan", ROW, *ONE_CASE),
}

SHORT = ["--help", "models", "validate, pair"]  # that compile nothing


def seconds(tree: Path, command: tuple[str, ...], cache: Path, folder: Path) -> float:
    """Processor seconds of one command of a checkout."""
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    words = [str(tree / word) if word.endswith(".toml") else word for word in command]
    environment = {**os.environ, "PYTHONPATH": str(tree), "NUMBA_CACHE_DIR": str(cache)}
    # The bytecode of this tree and of its libraries, kept where the numbers of other checkouts do not depend on it.
    environment["PYTHONPYCACHEPREFIX"] = str(cache.with_name(f"bytecode of {cache.name}"))
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    done = subprocess.run(
        [sys.executable, "-m", "pounding_risk", *words], cwd=folder, env=environment, capture_output=True, text=True
    )
    if done.returncode != 0:
        raise SystemExit(f"{tree}: {' '.join(words)} ended with {done.returncode}\n{done.stdout}{done.stderr}")
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def measure(trees: list[Path], repeats: int, chosen: dict[str, tuple[str, ...]], *, empty: bool) -> None:
    """Print a line for each command, with the median of each checkout."""
    with tempfile.TemporaryDirectory() as made:
        folder = Path(made)
        for name, command in chosen.items():
            taken: dict[Path, list[float]] = {tree: [] for tree in trees}
            for repeat in range(repeats + (0 if empty else 1)):
                for number, tree in enumerate(trees):
                    cache = folder / f"cache {number}"
                    if empty:
                        shutil.rmtree(cache, ignore_errors=True)
                    time = seconds(tree, command, cache, folder)
                    if empty or repeat:  # the first of the later ones fills the cache
                        taken[tree].append(time)
            times = [median(values) for values in taken.values()]
            ratios = [f" ({time / times[0]:.2f})" if number else "" for number, time in enumerate(times)]
            line = ", ".join(f"{time:.2f} s{ratio}" for time, ratio in zip(times, ratios, strict=True))
            print(f"{name:28s} {line}", flush=True)


def main() -> None:
    """Measure this checkout, or those given."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("trees", nargs="*", type=Path, default=[HERE], help="checkouts (default: this one)")
    parser.add_argument("--repeats", type=int, default=either(3, 1))
    parser.add_argument("--later", action="store_true", help="only commands that find a filled cache")
    given = parser.parse_args()
    trees = [tree.resolve() for tree in given.trees]
    if not given.later and not IS_SHORT:
        measure(trees, given.repeats, FIRST, empty=True)
    measure(trees, given.repeats, {name: LATER[name] for name in either(list(LATER), SHORT)}, empty=False)


if __name__ == "__main__":
    main()
