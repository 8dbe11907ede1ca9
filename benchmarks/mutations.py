"""Power of the tests: how many of 200 seeded mutations of the package each line of tests catches.

``python benchmarks/mutations.py map FOLDER`` runs all tests once and keeps which test runs which line, and its
processor seconds. ``python benchmarks/mutations.py run FOLDER`` makes the mutations one after another in a copy of the
tree and runs the tests of the changed line, those of the README's line first, until one fails. ``table FOLDER`` prints
what was caught by room. Compiled functions are not seen by the map: their mutations are tried by the tests of their
room. The processor seconds of the tests of one mutation are bounded by ``--seconds``; a survivor is one of that bound.

``run FOLDER --after OLD`` makes the mutations of earlier results once more, in the tree of today, with the map of then:
of its tests those that are still there, those that failed first, and with them all new tests of the same files.
"""

from __future__ import annotations

import argparse
import ast
import json
import os
import random
import resource
import shutil
import subprocess
import sys
from collections import Counter
from collections.abc import Iterator
from pathlib import Path
from typing import Any, NamedTuple

from pluggy import HookimplMarker

ROOT = Path(__file__).resolve().parents[1]
# Mutations of each part of the package, and the tests that try a change of its compiled functions.
ROOMS = {
    "scene": (35, ("scene", "units.py"), ("scene", "ensemble")),
    "formats": (40, ("motions", "reports/exports", "_common/tables.py"), ("motions", "reports")),
    "statistics": (45, ("statistics", "assessment"), ("statistics", "assessment", "questions")),
    "results": (35, ("results", "ensemble"), ("results", "ensemble")),
    "models": (20, ("models",), ("models", "solver")),
    "solver": (25, ("solver", "_jit"), ("solver", "jit", "models")),  # each compiles kernels anew
}
ARITHMETIC = {ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "/"), ast.Div: ("/", "*"), ast.Pow: ("**", "*")}
NEGATED = {
    ast.Lt: ("<", ">="),
    ast.LtE: ("<=", ">"),
    ast.Gt: (">", "<="),
    ast.GtE: (">=", "<"),
    ast.Eq: ("==", "!="),
    ast.NotEq: ("!=", "=="),
}
BOUNDARY = {ast.Lt: ("<", "<="), ast.LtE: ("<=", "<"), ast.Gt: (">", ">="), ast.GtE: (">=", ">")}
LOGIC = {ast.And: ("and", "or"), ast.Or: ("or", "and")}
# Tests that run the package in other processes, which the map does not see.
ELSEWHERE = ("test_notebooks.py", "test_benchmarks.py", "test_docs.py", "test_packaging.py")
COMPILING = 90  # processor seconds that the kernels of a changed source may take to compile


class Mutation(NamedTuple):
    """One change: the bytes ``start`` to ``end`` of a file of the package become ``text``."""

    room: str
    kind: str
    file: str
    line: int
    start: int
    end: int
    text: str


# ------------------------------------------------------------------------------------------------ where and what


class _Sites(ast.NodeVisitor):
    """Every place of a source that can be mutated, outside annotations, sentences and raised errors."""

    def __init__(self, source: bytes) -> None:
        self.source = source
        self.starts = [0]
        for line in source.splitlines(keepends=True):
            self.starts.append(self.starts[-1] + len(line))
        self.found: list[tuple[str, int, int, int, str]] = []

    def span(self, node: Any) -> tuple[int, int]:
        return self.starts[node.lineno - 1] + node.col_offset, self.starts[node.end_lineno - 1] + node.end_col_offset

    def add(self, kind: str, node: Any, start: int, end: int, text: str) -> None:
        self.found.append((kind, node.lineno, start, end, text))

    def between(self, kind: str, node: Any, left: Any, right: Any, symbols: tuple[str, str]) -> None:
        """The operator between two operands becomes another one."""
        start, end = self.span(left)[1], self.span(right)[0]
        place = self.source.find(symbols[0].encode(), start, end)
        if place >= 0:
            self.add(kind, node, place, place + len(symbols[0]), symbols[1])

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        for part in (*node.args.defaults, *filter(None, node.args.kw_defaults), *node.body):
            self.visit(part)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        pass

    def visit_Raise(self, node: ast.Raise) -> None:
        self.add("raise", node, *self.span(node), "pass")

    def visit_If(self, node: ast.If) -> None:
        if "TYPE_CHECKING" not in ast.unparse(node.test):
            start, end = self.span(node.test)
            self.add("branch", node.test, start, end, f"(not ({self.source[start:end].decode()}))")
            self.generic_visit(node)

    def visit_BinOp(self, node: ast.BinOp) -> None:
        is_text = any(isinstance(side, ast.JoinedStr) for side in (node.left, node.right))
        if type(node.op) in ARITHMETIC and not is_text:
            self.between("arithmetic", node, node.left, node.right, ARITHMETIC[type(node.op)])
        self.generic_visit(node)

    def visit_Compare(self, node: ast.Compare) -> None:
        for left, operator, right in zip((node.left, *node.comparators), node.ops, node.comparators, strict=False):
            if type(operator) in NEGATED:
                self.between("comparison", node, left, right, NEGATED[type(operator)])
            if type(operator) in BOUNDARY:
                self.between("boundary", node, left, right, BOUNDARY[type(operator)])
        self.generic_visit(node)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        self.between("logic", node, node.values[0], node.values[1], LOGIC[type(node.op)])
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        if isinstance(node.value, bool):
            self.add("constant", node, *self.span(node), str(not node.value))
        elif isinstance(node.value, int):
            self.add("constant", node, *self.span(node), str(node.value + 1))
        elif isinstance(node.value, float):
            self.add("constant", node, *self.span(node), repr(node.value * 1.25 or 1.0))


def choose(seed: int) -> list[Mutation]:
    """The mutations: in each room as many of every kind as it has, at places drawn evenly."""
    generator = random.Random(seed)
    chosen = []
    for room, (number, places, _) in ROOMS.items():
        by_kind: dict[str, list[Mutation]] = {}
        for file in _sources(places):
            source = file.read_bytes()
            sites = _Sites(source)
            sites.visit(ast.parse(source))
            name = file.relative_to(ROOT).as_posix()
            for kind, *site in sites.found:
                by_kind.setdefault(kind, []).append(Mutation(room, kind, name, *site))
        for place in range(number):
            kind = sorted(by_kind)[place % len(by_kind)]
            one = generator.choice(by_kind[kind])
            by_kind[kind].remove(one)
            chosen.append(one)
    return chosen


def _sources(places: tuple[str, ...]) -> Iterator[Path]:
    for place in places:
        path = ROOT / "pounding_risk" / place
        yield from sorted(path.rglob("*.py")) if path.is_dir() else [path]


# ------------------------------------------------------------------------------------------------ tests by line


def make_map(folder: Path) -> None:
    """Run all tests under coverage; keep lines by test, and the seconds of each."""
    folder.mkdir(parents=True, exist_ok=True)
    environment = {**os.environ, "MUTATIONS_FOLDER": str(folder), "PYTHONPATH": _path()}
    command = [sys.executable, "-m", "pytest", "-n", "2", "--dist", "worksteal", "-q", "-p", "mutations"]
    command += ["-p", "no:cacheprovider", *(f"--ignore=tests/{name}" for name in ELSEWHERE)]
    subprocess.run(command, cwd=ROOT, env=environment, check=False)
    import coverage

    whole = coverage.Coverage(data_file=str(folder / "coverage"))
    whole.combine([str(file) for file in folder.glob("coverage.*")])
    whole.save()


def _path(tree: Path = ROOT) -> str:
    return os.pathsep.join([str(tree), str(ROOT / "benchmarks")])


if "MUTATIONS_FOLDER" in os.environ:  # this file as a plugin of pytest: the map is being made
    import coverage
    import pytest

    _FOLDER = Path(os.environ["MUTATIONS_FOLDER"])
    _WORKER = os.environ.get("PYTEST_XDIST_WORKER")
    if _WORKER:
        _COVERAGE = coverage.Coverage(
            data_file=str(_FOLDER / f"coverage.{_WORKER}"), source=[str(ROOT / "pounding_risk")], config_file=False
        )
        _COVERAGE.start()

        @pytest.hookimpl(wrapper=True)
        def pytest_runtest_protocol(item: pytest.Item) -> Iterator[None]:
            """Lines and processor seconds, own and of children, go to the test."""
            _COVERAGE.switch_context(item.nodeid)
            before = sum(os.times()[:4])
            result = yield
            _COVERAGE.switch_context("")
            with (_FOLDER / f"seconds.{_WORKER}.jsonl").open("a") as file:
                file.write(json.dumps([item.nodeid, round(sum(os.times()[:4]) - before, 3)]) + "\n")
            return result

        def pytest_runtest_logreport(report: pytest.TestReport) -> None:
            """Tests that fail without any mutation try none."""
            if report.failed:
                with (_FOLDER / f"failed.{_WORKER}.jsonl").open("a") as file:
                    file.write(json.dumps(report.nodeid) + "\n")

        def pytest_sessionfinish() -> None:
            """Keep the lines."""
            _COVERAGE.stop()
            _COVERAGE.save()


class Map:
    """Tests by line, and their processor seconds."""

    def __init__(self, folder: Path) -> None:
        import coverage

        self.data = coverage.CoverageData(str(folder / "coverage"))
        self.data.read()
        self.seconds: dict[str, float] = dict(_lines(folder.glob("seconds.*")))
        self.failed = set(_lines(folder.glob("failed.*")))
        self.by_file: dict[str, dict[int, list[str]]] = {}

    def tests(self, mutation: Mutation) -> dict[str, float]:
        """Those that run the line; those of its room where none is seen to."""
        if mutation.file not in self.by_file:
            ours = [name for name in self.data.measured_files() if name.endswith(f"/{mutation.file}")]
            self.by_file[mutation.file] = self.data.contexts_by_lineno(ours[0]) if ours else {}
        names = set(self.by_file[mutation.file].get(mutation.line, ())) & self.seconds.keys()
        if not names:
            rooms = ROOMS[mutation.room][2]
            names = {name for name in self.seconds if name.split("/")[1] in rooms}
        return {name: self.seconds[name] for name in names - self.failed}


class Earlier(NamedTuple):
    """A mutation in the tree of today, where it was when the map was made, and the test that it failed then."""

    mutation: Mutation
    then: Mutation
    test: str = ""


def earlier(results: Path) -> Iterator[Earlier]:
    """The mutations of earlier results whose lines are still there, in their file or in another one."""
    for one in _lines(results.glob("results.*")):
        mutation = Mutation(*one["mutation"])
        lines = one["source"].encode()
        places = [mutation.file, *(file.relative_to(ROOT).as_posix() for file in _sources(("",)))]
        for place in places:
            source = (ROOT / place).read_bytes() if (ROOT / place).exists() else b""
            found = [at for at in range(len(source)) if source.startswith(lines, at)]
            if found and (place == mutation.file or len(found) == 1):
                start = min(found, key=lambda at: abs(at - mutation.start)) + one["column"]
                moved = mutation._replace(
                    file=place,
                    line=source[:start].count(b"\n") + 1,
                    start=start,
                    end=start + mutation.end - mutation.start,
                )
                yield Earlier(moved, mutation, one["test"] if one["caught"] else "")
                break


def _lines(files: Any) -> Iterator[Any]:
    for file in files:
        for line in file.read_text().splitlines():
            yield json.loads(line)


# ------------------------------------------------------------------------------------------------ one mutation


class _UntilOneFails:
    """A plugin of pytest: the chosen tests, those of the README's line and the shortest first; which one ran last."""

    def __init__(self, seconds: dict[str, float], known: set[str], first: str, answer: Path) -> None:
        self.seconds = seconds
        self.known = known
        self.first = first
        self.answer = answer
        self.has_failed = False
        self.tier: dict[str, str] = {}

    @HookimplMarker("pytest")(trylast=True)
    def pytest_collection_modifyitems(self, items: list[Any]) -> None:
        """Choose and sort, after the settings of all tests did."""
        items[:] = [item for item in items if item.nodeid in self.seconds or item.nodeid not in self.known]
        self.tier = {item.nodeid: "complete" if item.get_closest_marker("complete") else "quick" for item in items}
        items.sort(key=self._place)

    def _place(self, item: Any) -> tuple[bool, bool, float]:
        return self.tier[item.nodeid] != "quick", item.nodeid != self.first, self.seconds.get(item.nodeid, 0.1)

    def pytest_runtest_logreport(self, report: Any) -> None:
        """Write what ran last, or failed, which the parent reads."""
        if self.has_failed:
            return
        self.has_failed = report.failed
        self.answer.write_text(json.dumps([self.tier[report.nodeid], report.nodeid, report.outcome]))


def try_one(one: Earlier, tree: Path, known: Map, bound: float, answer: Path) -> dict[str, Any]:
    """Change one place of the tree, run the tests in a child, and put the source back."""
    mutation = one.mutation
    file = tree / mutation.file
    source = file.read_bytes()
    tests = known.tests(one.then)
    chosen = {name: seconds for name, seconds in tests.items() if name == one.test}
    for name, seconds in sorted(tests.items(), key=lambda each: each[1]):
        if sum(chosen.values()) + seconds > bound and chosen:
            break
        chosen[name] = seconds
    begin, end = source.rfind(b"\n", 0, mutation.start) + 1, source.find(b"\n", mutation.end)
    facts = {"mutation": mutation, "source": source[begin:end].decode(), "column": mutation.start - begin}
    answer.unlink(missing_ok=True)
    file.write_bytes(source[: mutation.start] + mutation.text.encode() + source[mutation.end :])
    try:
        child = os.fork()
        if not child:
            _run_tests(tree, chosen, _UntilOneFails(chosen, set(known.seconds), one.test, answer))
        _, status = os.waitpid(child, 0)
    finally:
        file.write_bytes(source)
    tier, test, outcome = json.loads(answer.read_text()) if answer.exists() else ("quick", "collection", "failed")
    if os.WIFSIGNALED(status):
        return {**facts, "caught": tier, "test": f"{test} (signal {os.WTERMSIG(status)})"}
    if os.WEXITSTATUS(status) == 0:
        return {**facts, "caught": "", "test": f"{len(chosen)} of {len(tests)} tests"}
    return {**facts, "caught": tier, "test": test if outcome == "failed" else "collection"}


def _run_tests(tree: Path, chosen: dict[str, float], plugin: _UntilOneFails) -> None:
    """The child: it ends with pytest's status, or by a signal where its processor time is over."""
    os.setpgid(0, 0)
    os.chdir(tree)
    os.environ["PYTHONPATH"] = _path(tree)
    sys.path.insert(0, str(tree))
    limit = int(3 * sum(chosen.values()) + COMPILING)
    resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
    quiet = os.open(os.devnull, os.O_WRONLY)
    os.dup2(quiet, 1)
    os.dup2(quiet, 2)
    import pytest

    files = _files(tree, {name.split("::")[0] for name in chosen}, {name.split("::")[0] for name in plugin.known})
    status = 1
    try:
        options = [
            "-x",
            "-q",
            "-p",
            "no:cacheprovider",
            "-p",
            "no:xdist",
            f"--basetemp={plugin.answer}.tmp",
        ]
        status = int(pytest.main([*options, *files], plugins=[plugin]))
    finally:
        os._exit(status)


def _files(tree: Path, wanted: set[str], known: set[str]) -> list[str]:
    """Files of tests; in place of one that is gone, those of its folder that are new."""
    there = {name for name in wanted if (tree / name).exists()}
    folders = {(tree / name).parent for name in wanted - there}
    files = {file.relative_to(tree).as_posix() for folder in folders for file in folder.glob("test_*.py")}
    return sorted(there | {file for file in files - known if Path(file).name not in ELSEWHERE})


def run(folder: Path, maps: Path, mutations: list[Earlier], bound: float, share: tuple[int, int]) -> None:
    """Try the mutations of one share, in a copy of the tree; results go to a file, and are not made twice."""
    index, shares = share
    results = folder / f"results.{index}.jsonl"
    done = {tuple(one["mutation"]) for one in _lines(folder.glob("results.*"))}
    tree = folder / f"tree.{index}"
    shutil.rmtree(tree, ignore_errors=True)
    # The version comes from git: a copy that is not one has that of pyproject.toml, and a test may say so.
    subprocess.run(["git", "worktree", "prune"], cwd=ROOT, check=True)
    subprocess.run(["git", "worktree", "add", "-q", "--detach", "--force", str(tree), "HEAD"], cwd=ROOT, check=True)
    _load_libraries()
    known = Map(maps)
    for one in mutations[index::shares]:
        if tuple(one.mutation) not in done:
            found = try_one(one, tree, known, bound, folder / f"answer.{index}")
            with results.open("a") as file:
                file.write(json.dumps(found) + "\n")


def _load_libraries() -> None:
    """Once for all children, but for the package itself."""
    import hypothesis  # noqa: F401
    import matplotlib.figure  # noqa: F401
    import numba  # noqa: F401
    import obspy  # noqa: F401
    import scipy.optimize
    import scipy.stats  # noqa: F401
    import xarray  # noqa: F401


def table(folder: Path) -> str:
    """Mutations by room: made, caught by all tests, caught by the README's line."""
    made, caught, quick = Counter[str](), Counter[str](), Counter[str]()
    for one in _lines(folder.glob("results.*")):
        for room in (one["mutation"][0], "all"):
            made[room] += 1
            caught[room] += bool(one["caught"])
            quick[room] += one["caught"] == "quick"
    rows = [f"| {room} | {made[room]} | {caught[room]} | {quick[room]} |" for room in (*ROOMS, "all")]
    return "\n".join(["| room | mutations | caught | by the README's line |", "| --- | ---: | ---: | ---: |", *rows])


def main() -> None:
    """The command line."""
    parser = argparse.ArgumentParser(description=__doc__.split("\n", 1)[0])
    parser.add_argument("step", choices=["map", "run", "table", "list"])
    parser.add_argument("folder", type=Path)
    parser.add_argument("--after", type=Path, help="the folder of earlier results, whose mutations are made again")
    parser.add_argument("--seed", type=int, default=33)
    parser.add_argument("--seconds", type=float, default=60, help="processor seconds of tests for each mutation")
    parser.add_argument("--share", default="0/1", help="which of several processes this one is, such as 0/2")
    given = parser.parse_args()
    folder = given.folder.resolve()
    if given.step == "map":
        make_map(folder)
    elif given.step == "run":
        index, shares = map(int, given.share.split("/"))
        mutations = list(earlier(given.after)) if given.after else [Earlier(one, one) for one in choose(given.seed)]
        run(folder, given.after or folder, mutations, given.seconds, (index, shares))
    elif given.step == "list":
        print("\n".join(map(str, choose(given.seed))))
    else:
        print(table(folder))


if __name__ == "__main__":
    main()
