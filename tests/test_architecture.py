"""The layers hold, registries are complete, and importing the package costs next to nothing."""

import ast
import doctest
import pkgutil
import re
import tomllib
from importlib import import_module
from pathlib import Path

import grimp
import numpy as np
import pytest
from importlinter.cli import EXIT_STATUS_SUCCESS, lint_imports
from processes import output
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from sweeps import sweep

import pounding_risk
import pounding_risk.models
import pounding_risk.motions.formats
from pounding_risk._jit.sources import INTERPRETED
from pounding_risk.models.contact import laws as contact

PACKAGE = Path(pounding_risk.__file__).resolve().parent
FILES = sorted(PACKAGE.rglob("*.py"))
NAMES = [file.relative_to(PACKAGE).as_posix() for file in FILES]
MOST_AT_TOP = 22  # modules and folders that a newcomer sees first


def tree_of(name: str) -> ast.Module:
    """A module of the package, parsed by each test that looks at it: all of them together take 150 MB."""
    return ast.parse((PACKAGE / name).read_text(encoding="utf-8"))


@pytest.fixture(scope="module")
def graph():
    """Every import of the package, those for type checks too."""
    return grimp.build_graph("pounding_risk", cache_dir=None)


def test_the_contracts_of_the_layers_hold(root, capsys):
    """Layers, and one home for each heavy library: `[tool.importlinter]` of pyproject.toml."""
    status = lint_imports(config_filename=str(root / "pyproject.toml"), no_cache=True)
    assert status == EXIT_STATUS_SUCCESS, capsys.readouterr().out


def test_every_folder_is_a_layer(root):
    contracts = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["tool"]["importlinter"][
        "contracts"
    ]
    floors = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    layers = [layer for floor in floors for layer in floor.split(" | ")]
    top = {found.name for found in pkgutil.iter_modules(pounding_risk.__path__)} - {"__main__"}
    assert {layer.removeprefix("pounding_risk.") for layer in layers} == top
    assert len(top) + 2 <= MOST_AT_TOP  # with __init__ and __main__


def test_no_module_imports_itself_through_others(graph):
    """No circle, whether an import stands at the top, in a function or is for type checks alone."""
    modules = sorted(graph.modules)
    place = {module: number for number, module in enumerate(modules)}
    pairs = [(place[one], place[other]) for one in modules for other in graph.find_modules_directly_imported_by(one)]
    assert len(pairs) > len(modules), "imports are seen"
    rows, columns = np.array(pairs).T
    matrix = coo_array((np.ones(len(pairs)), (rows, columns)), shape=(len(modules), len(modules)))
    count, groups = connected_components(matrix, connection="strong")
    circles = [[modules[member] for member in np.flatnonzero(groups == group)] for group in range(count)]
    assert [circle for circle in circles if len(circle) > 1] == []


def test_commands_import_what_they_need_when_they_run():
    """So that help and completion answer at once: at the top of the module stand typer and what is light."""
    heavy = {"numpy", "scipy", "xarray", "matplotlib", "obspy", "numba", "pydantic", "netCDF4", "rich"}
    for name in NAMES:
        if not name.startswith("cli/") and name not in ("__init__.py", "__main__.py"):
            continue
        for node in tree_of(name).body:
            modules = [alias.name for alias in node.names] if isinstance(node, ast.Import) else []
            modules += [node.module or ""] if isinstance(node, ast.ImportFrom) else []
            assert not {module.partition(".")[0] for module in modules} & heavy, f"{name}, line {node.lineno}"


@pytest.mark.complete
def test_public_functions_have_docstrings():
    silent = []
    for name in NAMES:
        tree = tree_of(name)
        silent += [] if ast.get_docstring(tree) else [name]
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


EXAMPLES = [name for name in NAMES if re.search(r"^ +>>> ", (PACKAGE / name).read_text(encoding="utf-8"), re.M)]


@pytest.mark.parametrize("name", EXAMPLES)
def test_examples_in_docstrings_are_right(name):
    # Compiled functions are found by their text too, so that each example runs once.
    module = ".".join(("pounding_risk", *Path(name).with_suffix("").parts)).removesuffix(".__init__")
    found = doctest.testmod(import_module(module))
    assert found.failed == 0 and found.attempted > 0


def test_each_format_has_its_entry_points(root):
    """The folder and the entry points name the same formats, so that ``obspy.read`` misses none."""
    points = tomllib.loads((root / "pyproject.toml").read_text(encoding="utf-8"))["project"]["entry-points"]
    told = points["obspy.plugin.waveform"]
    folder = Path(pounding_risk.motions.formats.__file__).parent
    modules = {f"pounding_risk.motions.formats.{file.stem}" for file in folder.glob("[!_]*.py")}
    found = {name: __import__(name, fromlist=["_"]).FORMAT for name in modules}
    assert {each.name: name for name, each in found.items() if not (each.native or each.needs)} == told
    assert set(pounding_risk.motions.formats.formats()) == set(found.values())
    for name, module in told.items():
        pair = points[f"obspy.plugin.waveform.{name}"]
        assert set(pair) == {"isFormat", "readFormat"}
        for verb in pair.values():
            where, _, function = verb.partition(":")
            assert where == module
            assert callable(getattr(__import__(module, fromlist=["_"]), function))


def test_importing_the_package_imports_nothing_heavy():
    heavy = sorted({"matplotlib", "obspy", "numba", "xarray", "pint", "pydantic", "jinja2"})
    code = f"import sys, pounding_risk; print([name for name in {heavy} if name in sys.modules])"
    assert output("-c", code).strip() == "[]"


# What takes long to import. Only what writes or reads a dataset imports those of DATASETS.
DATASETS = ("xarray", "pandas", "netCDF4", "zarr", "dask", "distributed")
FIGURES = ("matplotlib", "plotly", "jinja2", "typst", "rich")
SCIENCE = ("h5py", "scipy.linalg", "scipy.signal", "scipy.stats", "scipy.integrate", "scipy.optimize")
SLOW = (*DATASETS, *FIGURES, *SCIENCE)
NEEDLESS = {
    "--help": (*SLOW, "numpy", "numba", "obspy", "pint", "pydantic"),
    "rerun --help": (*SLOW, "numpy", "numba", "obspy", "pint"),
    "damage --help": (*SLOW, "numba", "obspy", "pint"),
    "models": (*SLOW, "numba", "obspy", "pint"),
    "validate paper.toml": (*SLOW, "numba", "pint"),
    "validate row.toml": (*SLOW, "numba", "pint"),
    "scan paper.toml": ("dask", "distributed", "pint", *FIGURES, *SCIENCE),
    "assess paper.nc": ("dask", "distributed", "numba", "obspy", "pint", *FIGURES, *SCIENCE),
}


@pytest.mark.parametrize("line", sweep(NEEDLESS, "--help", "validate paper.toml"))
def test_a_command_imports_what_it_needs(line, tmp_path):
    """The times of `benchmarks/startup.py`, held without a clock."""
    words = [str(PACKAGE / "scene" / "shipped" / word) if word.endswith(".toml") else word for word in line.split()]
    code = (
        "import os, sys\n"
        "from pounding_risk.cli import main\n"
        f"os.chdir({str(tmp_path)!r})\n"
        f"sys.argv = ['pounding-risk', *{words!r}]\n"
        "try:\n"
        "    code = main()\n"
        "except SystemExit as end:\n"
        "    code = end.code\n"
        f"print(code or 0, [name for name in {NEEDLESS[line]!r} if sys.modules.get(name)])"
    )
    if words[0] == "scan" and INTERPRETED:
        pytest.skip("NUMBA_DISABLE_JIT is set: there is nothing compiled")
    if words[0] == "scan":  # numba imports SciPy where it compiles: once, before
        (tmp_path / "compiled").mkdir()
        output("-c", code.replace(str(tmp_path), str(tmp_path / "compiled")))
    if words[0] == "assess":
        pounding_risk.scan(PACKAGE / "scene" / "shipped" / "paper.toml", out=tmp_path / words[1])
    printed = output("-c", code)
    assert printed.strip().splitlines()[-1] == "0 []"
    if line == "--help":
        assert all(word in printed for word in ("demo", "validate", "impact", "simulate", "scan"))


def test_results_open_and_figures_draw_without_numba():
    folders = ("assessment", "figures", "reports")
    names = sorted(
        name.removesuffix("/__init__.py").removesuffix(".py").replace("/", ".")
        for name in NAMES
        if name.startswith(folders)
    )
    assert {"figures", "reports", "assessment.assess"} <= set(names)
    names.append("results.files")
    loads = "\n".join(f"import pounding_risk.{name}" for name in names)
    assert output("-c", f"import sys\nsys.modules['numba'] = None\n{loads}\nprint('ok')").strip() == "ok"
