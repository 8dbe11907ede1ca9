"""The site: no key, output, command or model is missing from its page, examples run, Sphinx has no complaint."""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from collections.abc import Iterator
from importlib import resources
from pathlib import Path
from types import ModuleType
from typing import Any

import closed_forms as forms
import nbformat
import pytest

import pounding_risk
from pounding_risk.assessment.separations.rules import RULES
from pounding_risk.models.contact.impulsive import INSTANT_LAWS
from pounding_risk.models.contact.laws import SHIPPED
from pounding_risk.models.effects import EFFECTS
from pounding_risk.models.restitution import NAMED
from pounding_risk.models.structures.typologies import TYPOLOGIES
from pounding_risk.motions import quality
from pounding_risk.motions.formats import formats
from pounding_risk.motions.processing.chain import STEPS
from pounding_risk.scene.words import KEYS
from pounding_risk.solver.pair.outputs import BUILDING, RUN

DOCS = Path(__file__).resolve().parent.parent / "docs"


@pytest.fixture(scope="module")
def generate() -> Iterator[ModuleType]:
    """docs/generate.py."""
    kept = list(sys.path)
    sys.path.insert(0, str(DOCS))
    yield importlib.import_module("generate")
    sys.path[:] = kept


@pytest.fixture(scope="module")
def pages(generate) -> dict[str, Any]:
    """Every generated page and picture."""
    return generate.pages()


def words_of(page: str) -> set[str]:
    """What stands between backticks, each as a whole and piece by piece."""
    found = re.findall(r"`([^`\n]+)`", page)
    return {*found, *(piece for each in found for piece in re.split(r"[\s,]+", each))}


def headings_of(page: str) -> set[str]:
    """The headings, as they read."""
    return {re.sub(r"\\(.)", r"\1", found) for found in re.findall(r"^#+ (.+)$", page, re.M)}


def test_every_scene_key_is_on_its_page(pages):
    told = words_of(pages["scene.md"])
    assert {key for keys in KEYS.values() for key in keys} <= told
    assert set(EFFECTS) <= headings_of(pages["scene.md"])
    assert {option for kind in EFFECTS.values() for option in kind.options} <= told
    assert "greater than 0 kg and finite" in pages["scene.md"]


def test_every_output_is_on_its_page(generate, pages):
    told = words_of(pages["outputs.md"])
    assert {*RUN, *BUILDING, *(f"{name}_free" for name in BUILDING)} <= told
    dataset = generate.smallest_dataset()
    assert {name for part in dataset.values() for name in part} <= told


def test_every_command_and_option_is_on_its_page(pages):
    typer = pytest.importorskip("typer")
    from pounding_risk.cli import app

    def walk(command, path):
        for name, inner in getattr(command, "commands", {}).items():
            yield f"{path}{name}", inner
            yield from walk(inner, f"{path}{name} ")

    headings, told = headings_of(pages["commands.md"]), words_of(pages["commands.md"])
    commands = dict(walk(typer.main.get_command(app), ""))
    assert {"scan", "records list"} <= set(commands) <= headings
    assert {flag for each in commands.values() for option in each.params for flag in option.opts if flag[0] == "-"} <= {
        *told,
        "--help",
    }


@pytest.mark.parametrize(
    ("page", "names"),
    [
        ("contact_models.md", {*SHIPPED, *INSTANT_LAWS}),
        ("effects.md", set(EFFECTS)),
        ("steps.md", set(STEPS)),
        ("python.md", {name for name in pounding_risk.__all__ if name[0] != "_"}),
        ("assessment.md", {"Assessment", "Verdict", "Share", "RequiredGap", "Fragility", "Rate", "CodeTable"}),
        ("formats.md", {each.words.partition(" (")[0] for each in formats()}),
    ],
)
def test_everything_of_a_registry_has_a_part_of_its_page(pages, page, names):
    assert names <= headings_of(pages[page])


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


def test_laws_stand_with_their_words_and_sources(pages):
    page = pages["contact_models.md"]
    assert "F = β δ^1.5 + c̄ δ̇ on approach" in page
    assert "Source: Hertz (1881); Goldsmith (2001), Impact." in page
    assert ">>> Jankowski(1e9).force(1e6, 1e-4, 1.0, True)\n101000.0" in page


def test_isolated_impacts_stand_with_their_command_and_figure(pages):
    """e of Kelvin-Voigt is what is asked for, and that of the tension cut its closed form, to the digits printed."""
    text = pages["pieces/isolated-impacts.md"]
    achieved = dict(re.findall(r"^(\w+) +0\.6500 +(0\.\d{4}) ", text, re.M))
    assert len(achieved) == text.count("--law ") == 6
    cut = forms.kelvin_voigt_cut_restitution(forms.kelvin_voigt_ratio(0.65))
    assert (achieved["kelvin_voigt"], achieved["kelvin_voigt_tension_cut"]) == ("0.6500", f"{cut:.4f}")
    assert pages["laws.png"].startswith(b"\x89PNG")


def test_notebooks_are_pages_without_results(generate, pages):
    assert generate.notebooks()
    for path in generate.notebooks():
        page = pages[f"notebooks/{path.stem}.md"]
        assert page.startswith("# ")
        assert "```python\n" in page
        assert path.name in page
        assert f"](generated/notebooks/{path.stem}.md)" in pages["pieces/tutorials.md"]


def test_a_notebook_that_is_run_shows_what_it_prints_and_draws(generate, tmp_path):
    from generation.notebooks import notebook_pages

    drawn = "from matplotlib.figure import Figure\nfigure = Figure()\nfigure.add_subplot().plot([1, 2])\n"
    shown = "from IPython.display import Image, display\nfigure.savefig('a.png')\ndisplay(Image('a.png'))"
    cells = [nbformat.v4.new_markdown_cell("# Title\n\nWords."), *map(nbformat.v4.new_code_cell, [
        "print(6 * 7)", drawn + shown, "'a value'",
    ])]  # fmt: skip
    nbformat.write(nbformat.v4.new_notebook(cells=cells), tmp_path / "some.ipynb")
    found = notebook_pages(tmp_path / "some.ipynb", run=True)
    page = found["notebooks/some.md"]
    assert page.startswith("# Title\n")
    assert "```text\n42\n```" in page
    assert "```text\n'a value'\n```" in page
    assert "](/generated/notebooks/some-1.png)" in page
    assert found["notebooks/some-1.png"].startswith(b"\x89PNG")


def test_pages_are_written_where_they_changed_and_removed_where_they_are_no_more(generate, monkeypatch, tmp_path):
    monkeypatch.setattr(generate, "pages", lambda run: {"a.md": "one\n", "in/b.md": "two\n"})
    generate.write(tmp_path)
    old = (tmp_path / "a.md").stat().st_mtime_ns
    (tmp_path / "gone.md").write_text("three\n")
    (tmp_path / "in" / "b.md").write_text("changed by hand\n")
    generate.write(tmp_path)
    found = {path.relative_to(tmp_path).as_posix(): path.read_text() for path in tmp_path.rglob("*.md")}
    assert found == {"a.md": "one\n", "in/b.md": "two\n"}
    assert (tmp_path / "a.md").stat().st_mtime_ns == old


def test_what_pages_take_in_and_show_is_there(pages):
    """The README's parts by their headings, and pictures: a heading that is renamed fails here, not in the build."""
    files = [path for path in DOCS.rglob("*.md") if "generated" not in path.parts]
    own = {path.relative_to(DOCS).as_posix(): path.read_text("utf-8") for path in files}
    whole = {**own, **{f"generated/{name}": text for name, text in pages.items()}}
    for name, text in ((name, text) for name, text in whole.items() if isinstance(text, str)):
        folder = (DOCS / name).parent
        for target in re.findall(r"^```\{include\} (\S+)$", text, re.M):
            place = os.path.relpath(folder / target, DOCS)
            there = place in whole if place.startswith("generated/") else (DOCS / place).exists()
            assert there, f"{name} takes in {target}, which is not there"
        for picture in re.findall(r"!\[[^\]]+\]\((?!https?:)([^)]+)\)", text):
            place = picture.lstrip("/")
            assert place in whole if place.startswith("generated/") else (DOCS / place).exists(), (
                f"{name} shows {picture}, which is not there"
            )


def test_what_of_the_readme_no_page_takes_in_stands_at_the_start(generate, pages):
    start = headings_of(pages["pieces/start.md"])
    assert {"Run it", "A scene"} <= start
    assert not {"Hard cases", "Records", "Test it"} & start
    taken = {name for name in generate.readme_sections() if generate.slug(name) in generate.taken()}
    assert taken | start >= set(generate.readme_sections())


def test_no_page_stands_in_no_list_of_pages():
    listed = " ".join(path.read_text("utf-8") for path in DOCS.rglob("*.md") if "generated" not in path.parts)
    for path in DOCS.rglob("*.md"):
        if path.stem != "index" and "generated" not in path.parts:
            assert re.search(rf"^(theory/)?{path.stem}$", listed, re.M), path.name


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


def test_the_examples_of_extending_run(tmp_path):
    """Interpreted, as compiling a law takes ten seconds; in a process of their own, as they add to registries."""
    (tmp_path / "scene.toml").write_text(
        (resources.files("pounding_risk.scene") / "shipped" / "paper.toml").read_text("utf-8")
    )
    environment = {**os.environ, "PYTHONPATH": str(DOCS.parent), "NUMBA_DISABLE_JIT": "1"}
    run = subprocess.run(
        [sys.executable, "-c", EXAMPLES, str(DOCS / "extending.md")],
        cwd=tmp_path,
        env=environment,
        capture_output=True,
        text=True,
        timeout=120,
    )
    assert run.returncode == 0, run.stderr
    assert len(run.stdout.splitlines()) == (DOCS / "extending.md").read_text("utf-8").count("\n## ")


def test_the_table_of_restitution_is_that_of_the_closed_forms():
    """To the three digits that it prints."""
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
    for name, *told in rows:
        assert told == [f"{achieved[name](e):.3f}" for e in (0.4, 0.65, 0.9)], name


@pytest.mark.parametrize(
    ("text", "shown"),
    [
        ("F_E of *this* law", "F\\_E of *this* law"),
        ("``K_e`` and `Law`", "`K_e` and `Law`"),
        ("exp[d] (x) <y> |z| $", "exp\\[d\\] (x) \\<y\\> \\|z\\| \\$"),
        ("two\n    lines", "two lines"),
    ],
)
def test_text_is_shown_as_it_stands(generate, text, shown):
    from generation.markdown import plain

    assert plain(text) == shown


def test_a_docstring_keeps_its_formulas_and_examples(generate):
    from generation.markdown import docstring

    told = docstring("First.\n\n    a = b\n    c = d_e\n\nThen [m]:\n    e = f\n>>> 1\n1\n")
    assert (
        told
        == "First.\n\n```text\na = b\nc = d_e\n```\n\nThen \\[m\\]:\n\n```text\ne = f\n```\n\n```pycon\n>>> 1\n1\n```\n"
    )


@pytest.mark.slow
def test_the_site_builds_without_a_warning(tmp_path):
    """Every cross reference is found, and pages load nothing from elsewhere, equations neither."""
    for needed in ("sphinx", "furo", "myst_parser", "latex2mathml"):
        pytest.importorskip(needed)
    environment = {**os.environ, "PYTHONPATH": str(DOCS.parent)}
    command = [sys.executable, "-m", "sphinx", "-W", "-n", "-q", "-d", tmp_path / "trees", DOCS, tmp_path / "site"]
    run = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, run.stderr
    site = tmp_path / "site"
    assert "<math " in (site / "theory" / "contact.html").read_text("utf-8")
    for page in site.rglob("*.html"):
        text = page.read_text("utf-8")
        # Links may lead elsewhere; what a page loads may not.
        assert not re.search(r"<(script|link|img)[^>]+(src|href)=\"https?:", text), page.name
        assert "$$" not in re.sub(r"<pre.*?</pre>", "", text, flags=re.S), f"{page.name}: an equation was not read"
