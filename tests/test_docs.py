"""README and site: every key, output, command and model has its entry, examples run, and Sphinx gives no warning."""

import ast
import json
import os
import pickle
import re
import shlex
import tomllib
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import Any

import closed_forms as forms
import figure_words
import generate
import pytest
import typer
from commands import done
from generation.markdown import docstring, plain
from generation.notebooks import notebook_pages
from processes import output
from sweeps import sweep

import pounding_risk
from pounding_risk._jit.sources import KERNEL_SOURCES
from pounding_risk.assessment.separations.rules import RULES
from pounding_risk.cli import app
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import SHIPPED, Tabulated
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.restitution import NAMED
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.motions import quality
from pounding_risk.motions.formats import formats
from pounding_risk.motions.generated import motion_kinds
from pounding_risk.motions.processing import known_steps
from pounding_risk.reports import exports
from pounding_risk.scene.axes import INLINE
from pounding_risk.scene.notes import unused_keys
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.sections import KEYS
from pounding_risk.solver.pair.outputs import BUILDING, RUN

DOCS = Path(__file__).resolve().parent.parent / "docs"


@pytest.fixture(scope="module")
def pages(shared_once) -> dict[str, Any]:
    """Content of every generated page and picture by its path."""
    return shared_once("pages", generate.pages)


def words_of(page: str) -> set[str]:
    """Texts between backticks, and the words of each."""
    codes = re.findall(r"`([^`\n]+)`", page)
    return {*codes, *(word for code in codes for word in re.split(r"[\s,]+", code))}


def headings_of(page: str) -> set[str]:
    """The headings, without the escapes of Markdown."""
    return {re.sub(r"\\(.)", r"\1", heading) for heading in re.findall(r"^#+ (.+)$", page, re.M)}


@pytest.mark.complete
def test_every_scene_key_is_on_its_page(pages):
    words = words_of(pages["scene.md"])
    assert {key for section, keys in KEYS.items() if section != "effects" for key in keys} <= words
    assert {key for kind in INLINE.values() for key in kind.key_names()} <= words
    assert set(EFFECTS) <= headings_of(pages["scene.md"])
    assert {option for kind in EFFECTS.values() for option in kind.options} <= words
    assert "greater than 0 kg and finite" in pages["scene.md"]


@pytest.mark.complete
def test_every_output_is_on_its_page(pages):
    words = words_of(pages["outputs.md"])
    assert {*RUN, *BUILDING, *(f"{name}_free" for name in BUILDING)} <= words
    dataset = generate.smallest_dataset()
    assert {name for part in dataset.values() for name in part} <= words


@pytest.mark.complete
def test_every_command_and_option_is_on_its_page(pages):
    def walk(command, path):
        for name, inner in getattr(command, "commands", {}).items():
            yield f"{path}{name}", inner
            yield from walk(inner, f"{path}{name} ")

    headings, words = headings_of(pages["commands.md"]), words_of(pages["commands.md"])
    commands = dict(walk(typer.main.get_command(app), ""))
    assert {"scan", "records list"} <= set(commands) <= headings
    assert {flag for each in commands.values() for option in each.params for flag in option.opts if flag[0] == "-"} <= {
        *words,
        "--help",
    }


@pytest.mark.complete
@pytest.mark.parametrize(
    ("page", "names"),
    [
        ("contact_models.md", {*SHIPPED, *INSTANT_LAWS}),
        ("effects.md", set(EFFECTS)),
        ("steps.md", set(known_steps())),
        ("motions.md", set(motion_kinds())),
        ("python.md", {name for name in pounding_risk.__all__ if name[0] != "_"}),
        ("assessment.md", {"Assessment", "Verdict", "Share", "RequiredGap", "Fragility", "Rate", "CodeTable"}),
        ("formats.md", {each.words.partition(" (")[0] for each in formats()}),
    ],
)
def test_everything_of_a_registry_has_a_part_of_its_page(pages, page, names):
    assert names <= headings_of(pages[page])


@pytest.mark.complete
def test_every_check_rule_and_relation_has_a_row(pages):
    for name in quality.CHECKS:
        assert f"| {name} |" in pages["checks.md"]
    assert "|  |\n" not in pages["checks.md"], "a check says nothing of itself"
    for rule in RULES.values():
        row = rf"^\| `{rule.name}` \|.*\| (derived|clause read|\*\*quoted\*\*|\*\*from memory\*\*) \| (.*?) \|"
        ((text, later),) = re.findall(row, pages["separations.md"], re.M)
        assert (text.strip("*"), later.strip()) == (rule.verification, rule.superseded)
    assert set(NAMED) <= words_of(pages["restitution.md"])
    for kind in TYPOLOGIES.values():
        (row,) = re.findall(rf"^\| `{kind.name}` \|.*\| (yes|\*\*NO\*\*) \|", pages["typologies.md"], re.M)
        assert row == ("yes" if kind.code.verified else "**NO**")


@pytest.mark.complete
def test_laws_stand_with_their_words_and_sources(pages):
    page = pages["contact_models.md"]
    assert "F = β δ^1.5 + c̄ δ̇ on approach" in page
    assert "Source: Hertz (1881); Goldsmith (2001), Impact." in page
    assert ">>> Jankowski(1e9).force(1e6, 1e-4, 1.0, True)\n101000.0" in page


@pytest.mark.complete
def test_isolated_impacts_stand_with_their_command_and_figure(pages):
    """e of Kelvin-Voigt is what is asked for, and that of the tension cut its closed form, to the digits printed."""
    text = pages["pieces/isolated-impacts.md"]
    achieved = dict(re.findall(r"^(\w+) +0\.6500 +(0\.\d{4}) ", text, re.M))
    assert len(achieved) == text.count("--law ") == 6
    cut = forms.kelvin_voigt_cut_restitution(forms.kelvin_voigt_ratio(0.65))
    assert (achieved["kelvin_voigt"], achieved["kelvin_voigt_tension_cut"]) == ("0.6500", f"{cut:.4f}")
    assert pages["laws.png"].startswith(b"\x89PNG")


@pytest.mark.complete
def test_the_bumper_stands_with_its_loop(pages):
    """The loop of the file beside the page: e is that of the law, the spring's is 1."""
    text = pages["pieces/table-impact.md"]
    achieved = dict(re.findall(r"^(\w+) +– +([01]\.\d{4}) ", text, re.M))
    bumper = Tabulated.from_file(DOCS / "examples" / "bumper.csv")
    assert achieved == {"tabulated": f"{pounding_risk.impact(bumper, 1.5, 5e3).restitution:.4f}", "linear": "1.0000"}
    assert "table of 4 points" in text and pages["table.png"].startswith(b"\x89PNG")


@pytest.mark.complete
def test_notebooks_are_pages_without_results(pages):
    assert generate.notebooks()
    for path in generate.notebooks():
        page = pages[f"notebooks/{path.stem}.md"]
        assert page.startswith("# ")
        assert "```python\n" in page
        assert path.name in page
        assert f"](generated/notebooks/{path.stem}.md)" in pages["pieces/tutorials.md"]


@pytest.mark.complete
def test_a_notebook_that_is_run_shows_what_it_prints_and_draws(tmp_path):
    import nbformat

    drawn = "from matplotlib.figure import Figure\nfigure = Figure()\nfigure.add_subplot().plot([1, 2])\n"
    shown = "from IPython.display import Image, display\nfigure.savefig('a.png')\ndisplay(Image('a.png'))"
    cells = [nbformat.v4.new_markdown_cell("# Title\n\nWords."), *map(nbformat.v4.new_code_cell, [
        "print(6 * 7)", drawn + shown, "'a value'",
    ])]  # fmt: skip
    nbformat.write(nbformat.v4.new_notebook(cells=cells), tmp_path / "some.ipynb")
    files = notebook_pages(tmp_path / "some.ipynb", run=True)
    page = files["notebooks/some.md"]
    assert page.startswith("# Title\n")
    assert "```text\n42\n```" in page
    assert "```text\n'a value'\n```" in page
    assert "](/generated/notebooks/some-1.png)" in page
    assert files["notebooks/some-1.png"].startswith(b"\x89PNG")


def test_changed_pages_are_written_and_old_ones_removed(monkeypatch, tmp_path):
    monkeypatch.setattr(generate, "pages", lambda run: {"a.md": "one\n", "in/b.md": "two\n"})
    generate.write(tmp_path)
    old = (tmp_path / "a.md").stat().st_mtime_ns
    (tmp_path / "gone.md").write_text("three\n")
    (tmp_path / "in" / "b.md").write_text("changed by hand\n")
    generate.write(tmp_path)
    written = {path.relative_to(tmp_path).as_posix(): path.read_text() for path in tmp_path.rglob("*.md")}
    assert written == {"a.md": "one\n", "in/b.md": "two\n"}
    assert (tmp_path / "a.md").stat().st_mtime_ns == old


@pytest.mark.complete
def test_included_files_and_pictures_exist(pages):
    """Included files and pictures: one that is renamed fails here, not in the build."""
    files = [path for path in DOCS.rglob("*.md") if "generated" not in path.parts]
    own = {path.relative_to(DOCS).as_posix(): path.read_text("utf-8") for path in files}
    whole = {**own, **{f"generated/{name}": text for name, text in pages.items()}}
    for name, text in ((name, text) for name, text in whole.items() if isinstance(text, str)):
        folder = (DOCS / name).parent
        for target in re.findall(r"^```\{include\} (\S+)$", text, re.M):
            path = os.path.relpath(folder / target, DOCS)
            there = path in whole if path.startswith("generated/") else (DOCS / path).exists()
            assert there, f"{name} includes {target}, which does not exist"
        for picture in re.findall(r"!\[[^\]]+\]\((?!https?:)([^)]+)\)", text):
            path = picture.lstrip("/")
            assert path in whole if path.startswith("generated/") else (DOCS / path).exists(), (
                f"{name} shows {picture}, which does not exist"
            )


def test_every_page_is_in_a_toctree():
    listed = " ".join(path.read_text("utf-8") for path in DOCS.rglob("*.md") if "generated" not in path.parts)
    for path in DOCS.rglob("*.md"):
        if path.stem != "index" and "generated" not in path.parts:
            assert re.search(rf"^(theory/)?{path.stem}$", listed, re.M), path.name


README = DOCS.parent / "README.md"


def blocks(page: str, language: str) -> list[str]:
    """The fenced blocks of a language."""
    return re.findall(rf"^```{language}\n(.*?)^```", page, re.M | re.S)


def python_of(path: Path) -> str:
    """The Python code of a page or a notebook, without the commands of IPython."""
    if path.suffix == ".md":
        return "\n".join(blocks(path.read_text("utf-8"), "python"))
    cells = json.loads(path.read_text("utf-8"))["cells"]
    code = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    return re.sub(r"^%.*$", "", "\n".join(code), flags=re.M)


# The page on extending adds to the registries of the package, whose modules its examples name.
SCRIPTS = [README, *sorted({*DOCS.rglob("*.md")} - {*(DOCS / "generated").rglob("*"), DOCS / "extending.md"})]
SCRIPTS += sorted((DOCS.parent / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", [path for path in SCRIPTS if python_of(path)], ids=lambda path: path.stem)
def test_examples_import_the_package_alone(path):
    """``import pounding_risk as pr`` and no module below; every name that they take from it or a namespace is one."""
    tree = ast.parse(python_of(path))
    imported = [alias for node in ast.walk(tree) if isinstance(node, ast.Import) for alias in node.names]
    own = [(alias.name, alias.asname) for alias in imported if alias.name.startswith("pounding_risk")]
    assert set(own) == {("pounding_risk", "pr")}
    modules = [node.module for node in ast.walk(tree) if isinstance(node, ast.ImportFrom)]
    assert not [module for module in modules if module and module.startswith("pounding_risk")]
    attributes = [ast.unparse(node) for node in ast.walk(tree) if isinstance(node, ast.Attribute)]
    taken = [words.split(".") for words in attributes if re.fullmatch(r"pr(\.\w+)+", words)]
    assert taken
    for _, name, *below in taken:
        assert name in dir(pounding_risk), name
        if below and isinstance(whole := getattr(pounding_risk, name), ModuleType):
            assert hasattr(whole, below[0]), f"pr.{name}.{below[0]}"


@pytest.mark.complete
def test_the_example_of_results_in_python_runs(monkeypatch, tmp_path, capsys):
    """And prints what a person would look for; its figure is of the gap that it asks for."""
    monkeypatch.chdir(tmp_path)
    names: dict[str, Any] = {}
    exec(compile(python_of(DOCS / "results.md"), "results.md", "exec"), names)
    printed = capsys.readouterr().out
    assert printed.startswith("<results of scan>") and "20 mm, 40 mm, 60 mm" in printed
    assert names["assessment"].interfaces[0].gap == 0.055
    assert "55 mm" in figure_words.words_of(names["figure"])
    assert names["case"].impact_count.item() > 0 and float(names["case"].gap) == 0.02
    assert (tmp_path / "report.html").stat().st_size > 10_000


def test_every_format_of_export_has_a_row_and_a_command():
    text = (DOCS / "exports.md").read_text("utf-8")
    assert set(re.findall(r"(?m)^\| `(\w+)` \|", text)) == set(exports.formats())
    assert set(re.findall(r"--to ([a-z]+)", text)) == set(exports.formats())


@pytest.mark.parametrize(
    "path", sweep([README, *sorted(DOCS.glob("*.md"))], README, DOCS / "start.md"), ids=lambda path: path.stem
)
def test_commands_and_options_on_the_pages_are_real(path):
    text = path.read_text("utf-8")
    lines = [line for block in blocks(text, "sh") for line in re.split(r"(?<!\\)\n", block)]
    lines += [code for code in re.findall(r"`(pounding-risk [^`\n]+)`", text)]
    calls = [re.split(r"[\s\"']+", call) for line in lines for call in re.findall(r"\bpounding-risk ([^|&;#]+)", line)]
    for call in calls:
        command = typer.main.get_command(app)
        assert call[0] in command.commands, call
        for word in call:
            command = getattr(command, "commands", {}).get(word, command)
        known = {flag for option in command.params for flag in option.opts}
        assert {word for word in call if re.match(r"--?[a-z]", word)} <= known, call


def test_the_first_example_of_rows_has_no_key_without_effect():
    text = re.search(r"```toml\n(.*?)```", (DOCS / "rows.md").read_text(encoding="utf-8"), re.S)[1]
    assert unused_keys(parse_scene(text)) == ()


def test_the_scene_of_the_readme_is_answered_as_it_says(monkeypatch, tmp_path):
    """Its commands and its Python block run, and the output contains the quoted one, apart from line breaks."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("COLUMNS", "400")
    text = README.read_text("utf-8")
    (scene,), (code,), (printed,) = (blocks(text, language) for language in ("toml", "python", "text"))
    Path("scene.toml").write_text(scene, "utf-8")
    (commands,) = (block for block in blocks(text, "sh") if block.startswith("pounding-risk scan scene.toml"))
    for command in commands.splitlines():
        told = " ".join(done(*shlex.split(command)[1:]).output.split())
    for part in printed.split("...\n"):
        assert " ".join(part.split()) in told
    exec(compile(code, "README.md", "exec"), {})
    assert Path("report.html").exists()


def test_the_page_of_the_architecture_names_existing_layers_files_and_functions():
    """The layers in their order; each file, function and name on the two ways; the folders to add to."""
    text = (DOCS / "architecture.md").read_text("utf-8")
    parts = dict(zip(["", *re.findall(r"^## (.+)$", text, re.M)], re.split(r"^## .+$", text, flags=re.M), strict=True))
    project = tomllib.loads((DOCS.parent / "pyproject.toml").read_text("utf-8"))
    contract = next(each for each in project["tool"]["importlinter"]["contracts"] if each["type"] == "layers")
    layers = [layer.removeprefix("pounding_risk.") for floor in contract["layers"] for layer in floor.split(" | ")]
    assert re.findall(r"^\| `(\w+)` \|", parts["Layers"], re.M) == layers
    package = Path(pounding_risk.__file__).parent
    for way, most in (("The way of a gap", 28), ("The way of a record", 13)):
        steps = re.findall(r"^\| \d+ \| `(\S+)` \| `(\w+)` \| (.+?) \|", parts[way], re.M)
        assert 0 < len(steps) < most
        for place, name, values in steps:
            path = package / place
            code = "".join(file.read_text("utf-8") for file in ([path] if path.suffix else path.glob("*.py")))
            assert re.search(rf"^(def|class) {name}\b", code, re.M), (place, name)
            for value in re.findall(r"`([^`]+)`", values):
                assert value.rpartition(".")[2] in code, (place, value)
    for places in re.findall(r"^\| a.+? \| (.+?) \|$", parts["Where to add something"], re.M):
        assert all((package / place).exists() for place in re.findall(r"`([a-z_/.]+)`", places) if "toml" not in place)


def test_the_page_of_the_solvers_names_existing_files_and_functions():
    """Every file; the functions of both tables of steps and of the table of compilation; its drawing has a text."""
    text = (DOCS / "solver.md").read_text("utf-8")
    package = Path(pounding_risk.__file__).parent
    roots = (package / "solver", package, DOCS.parent)

    def found(place: str) -> Path:
        return next((root / place for root in roots if (root / place).is_file()), Path(place))

    files = set(re.findall(r"[\w/]+\.py\b", text))
    assert len(files) > 50
    assert all(f"`{source}`" in text for source in KERNEL_SOURCES)
    assert not [place for place in files if not found(place).is_file()]
    steps = re.findall(r"^\| \d+ \| `(\S+)` \| `(\w+)` \|", text, re.M)
    assert len(steps) == len(re.findall(r"^\| \d+ \|", text, re.M)) > 30
    compiled = re.findall(r"^\| (.+?) \| `(_jit/\S+)` \|", text, re.M)
    steps += [(place, name) for names, place in compiled for name in re.findall(r"`(\w+)`", names)]
    for place, name in steps:
        assert re.search(rf"^ *(def|class) {name}\b", found(place).read_text("utf-8"), re.M), (place, name)


EXAMPLES = """
import re, sys
from pathlib import Path

parts = re.split(r"^## (.+)\\n", Path(sys.argv[1]).read_text("utf-8"), flags=re.M)
for heading, body in zip(parts[1::2], parts[2::2], strict=True):
    (block,) = re.findall(r"^```python\\n(.*?)^```", body, re.S | re.M)
    assert "assert " in block, heading
    exec(compile(block, heading, "exec"), {"__name__": "__main__"})
    print(heading)
"""


@pytest.mark.complete
def test_the_examples_of_extending_run(tmp_path):
    """Without compilation, which takes ten seconds for a law; in a process of their own, as they add to registries."""
    (tmp_path / "scene.toml").write_text(
        (resources.files("pounding_risk.scene") / "shipped" / "paper.toml").read_text("utf-8")
    )
    page, env = DOCS / "extending.md", {**os.environ, "NUMBA_DISABLE_JIT": "1"}
    printed = output("-c", EXAMPLES, page, cwd=tmp_path, env=env)
    assert len(printed.splitlines()) == page.read_text("utf-8").count("\n## ")


def test_the_table_of_restitution_is_that_of_the_closed_forms():
    """To the three digits of the table."""
    achieved = {
        "kelvin_voigt": lambda e: e,
        "kelvin_voigt_tension_cut": lambda e: forms.kelvin_voigt_cut_restitution(forms.kelvin_voigt_ratio(e)),
        "modified_kelvin_voigt": lambda e: forms.modified_kelvin_voigt_restitution(
            forms.modified_kelvin_voigt_ratio(e)
        ),
        "hertz_damp": lambda e: forms.hertz_damp_restitution(forms.hertz_damp_factor(e)),
        "hertz_damp_exact": lambda e: e,
        "jankowski": lambda e: forms.jankowski_restitution(forms.jankowski_ratio(e)),
    }
    text = (DOCS / "theory" / "restitution.md").read_text("utf-8")
    rows = re.findall(r"^\| `(\w+)` \| (\S+) \| (\S+) \| (\S+) \|$", text, re.M)
    assert [name for name, *_ in rows] == list(achieved)
    for name, *digits in rows:
        assert digits == [f"{achieved[name](e):.3f}" for e in (0.4, 0.65, 0.9)], name


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("F_E of *this* law", "F\\_E of *this* law"),
        ("``K_e`` and `Law`", "`K_e` and `Law`"),
        ("exp[d] (x) <y> |z| $", "exp\\[d\\] (x) \\<y\\> \\|z\\| \\$"),
        ("two\n    lines", "two lines"),
    ],
)
def test_special_characters_are_escaped(text, shown):
    assert plain(text) == shown


def test_a_docstring_keeps_its_formulas_and_examples_and_its_sections_are_lists(says):
    says(docstring("First.\n\n    a = b\n    c = d_e\n\nThen [m]:\n    e = f\n>>> 1\n1\n"))
    parameters = "a, b : float\n    Masses [kg],\n    both.\nc : {'x', 'y'}, optional\n"
    sections = {"Parameters": parameters, "Returns": "dict\n    By name.\n", "Notes": "As\n\n    a = b\n"}
    says(docstring("First.\n\n" + "\n".join(f"{head}\n{'-' * len(head)}\n{text}" for head, text in sections.items())))


# Sphinx with the generated pages of a file in place of those that `generate` would make once more, in half a minute.
SPHINX = """
import pickle, sys
from pathlib import Path

sys.path.insert(0, sys.argv[1])
import generate
from sphinx.cmd.build import main

made = pickle.loads(Path(sys.argv[2]).read_bytes())
generate.pages = lambda run: made
sys.exit(main(sys.argv[3:]))
"""


@pytest.mark.complete
def test_the_site_builds_without_a_warning(pages, tmp_path):
    """Every cross reference is resolved, and pages load nothing from the network."""
    for needed in ("sphinx", "furo", "myst_parser", "latex2mathml"):
        pytest.importorskip(needed)
    (tmp_path / "pages").write_bytes(pickle.dumps(pages))
    options = ["-W", "-n", "-q", "-d", tmp_path / "trees", DOCS, tmp_path / "site"]
    output("-c", SPHINX, DOCS, tmp_path / "pages", *options, timeout=300)
    site = tmp_path / "site"
    page = (site / "theory" / "contact.html").read_text("utf-8")
    assert "<math " in page
    assert 'src="../../versions.js"' in page and f"Version {pounding_risk.__version__}<" in page
    for page in site.rglob("*.html"):
        text = page.read_text("utf-8")
        # Links may lead to the network; scripts, styles and pictures may not.
        assert not re.search(r"<(script|link|img)[^>]+(src|href)=\"https?:", text), page.name
        assert "$$" not in re.sub(r"<pre.*?</pre>", "", text, flags=re.S), f"{page.name}: an equation was not converted"
