"""The published cases: every value beside ours, the cases with their sources, the properties, and their figures."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

from generation.markdown import plain, table

SCRIPT = """
import json, sys
import pounding_risk as pr
from pounding_risk import figures
from pounding_risk.questions.verify import property_rows, values
from pounding_risk.lab.verification.case import shipped
from pounding_risk.lab.verification.property import plain
from pounding_risk.lab.verification.unreached import EXPERIMENTS, UNREACHED
outcome = pr.verify()
words = lambda cell: cell["text"] if isinstance(cell, dict) else cell
folder = sys.argv[1]
figures.write(figures.verification_figure(outcome), folder + "/published_points.png")
figures.write(figures.verification_differences_figure(outcome), folder + "/published_differences.png")
text = shipped()["jankowski_2008"].read_text("utf-8")
scene = text[text.index("[[building]]") : text.index("[[published]]")].replace('gap = "1 m"', 'gap = "20 mm"')
run = pr.simulate(pr.read_scene(scene))
figures.write(figures.simulation_figure(run, "parameters known from memory"), folder + "/jankowski_2008.png")
for one in outcome.properties:
    figures.write(figures.property_figure(one), f"{folder}/property_{one.name}.png")
(block,) = values(outcome)
cases = [[case.name, case.about.title, case.about.citation, case.about.where, case.about.url, case.about.basis,
          case.about.known, case.about.note] for case in outcome.cases]
properties = [[one.name, one.title, one.source, one.citation, one.url, one.basis, one.known, one.relation,
               plain(one.headline), plain(one.condition), one.word,
               [list(map(words, row)) for row in property_rows(one)]] for one in outcome.properties]
print(json.dumps({"finding": outcome.finding(), "cases": cases, "properties": properties, "experiments": EXPERIMENTS,
                  "heads": block["heads"], "values": [[cell["text"] for cell in row] for row in block["rows"]],
                  "unreached": UNREACHED}))
"""
PROPERTY_HEADS = ("reading", "published", "ours", "bounds", "bounds by", "")


def verification_pages(interpreted: Callable[..., str]) -> dict[str, str | bytes]:
    """The pieces with values, properties and what is not among them, and the figures; ``interpreted`` runs Python."""
    with TemporaryDirectory() as folder:
        printed = interpreted("-c", SCRIPT, folder, compiled=True)
        pictures = {path.name: path.read_bytes() for path in sorted(Path(folder).glob("*.png"))}
    found = json.loads(printed.splitlines()[-1])
    values = [(f"`{case}`", *map(plain, rest)) for case, *rest in found["values"]]
    cases = [(f"`{name}`", _case(*about)) for name, *about in found["cases"]]
    text = (
        f"{found['finding']}.\n\n{table(tuple(found['heads']), values)}\n"
        "![Published points over our curves](/generated/published_points.png)\n\n"
        "![Differences, and their tolerance effect](/generated/published_differences.png)\n\n"
        f"### The cases and their sources\n\n{table(('case', 'what, source, how it is known'), cases)}"
    )
    unreached = [tuple(map(plain, row)) for row in found["unreached"]]
    return {
        **pictures,
        "pieces/verification.md": text,
        "pieces/verification_properties.md": "\n".join(map(_property, found["properties"])),
        "pieces/verification_unreached.md": f"{found['experiments']}\n\n{table(('what', 'why'), unreached)}",
    }


def _property(row: list) -> str:
    """Heading, relation, figure and readings of a property."""
    name, title, source, citation, url, basis, known, relation, headline, condition, word, readings = row
    link = f" <{url}>" if url else ""
    return (
        f"### {plain(title)}\n\n`{name}`, {plain(source)}: {plain(relation)}. Ours: **{word}**. {plain(headline)}.\n\n"
        f"![{plain(headline)}](/generated/property_{name}.png)\n\n"
        f"{plain(condition)}. Source: {plain(citation)}{link}; {_basis(basis, known)}.\n\n"
        f"{table(PROPERTY_HEADS, [tuple(map(plain, reading)) for reading in readings])}"
    )


def _case(title: str, citation: str, where: str, url: str, basis: str, known: str, note: str) -> str:
    """A case in one cell, which a page of any width shows whole."""
    link = f" <{url}>" if url else ""
    words = f"**{plain(title)}.** {plain(f'{citation}: {where}')}{link}. *{_basis(basis, known)}.*"
    return f"{words} {plain(note)}" if note else words


def _basis(basis: str, known: str) -> str:
    word = "**from memory**" if basis == "from memory" else basis
    return word if known == basis else f"{word}: {plain(known)}"
