"""The published cases: every value beside ours, the cases with their sources, and two figures."""

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
from pounding_risk.studies.verification.run import said, share
outcome = pr.verify()
figures.write(figures.verification_figure(outcome), sys.argv[1] + "/published_points.png")
figures.write(figures.verification_differences_figure(outcome), sys.argv[1] + "/published_differences.png")
values = [[check.case, check.source, check.quantity, check.kind, check.printed, said(check), share(check.difference),
           share(abs(check.change)), check.word] for check in outcome.checks]
cases = [[case.name, case.about.title, case.about.citation, case.about.where, case.about.url, case.about.basis,
          case.about.known, case.about.note] for case in outcome.cases]
print(json.dumps({"finding": outcome.finding(), "values": values, "cases": cases}))
"""
SIMILARITY = Path(__file__).resolve().parent / "similarity.py"
HEADS = ("source", "quantity", "kind", "published", "ours", "difference", "ours changes by", "")


def verification_pages(interpreted: Callable[..., str]) -> dict[str, str | bytes]:
    """The piece with both tables, and the figures; ``interpreted`` runs Python."""
    with TemporaryDirectory() as folder:
        interpreted(str(SIMILARITY), folder, compiled=True)
        printed = interpreted("-c", SCRIPT, folder, compiled=True)
        pictures = {path.name: path.read_bytes() for path in sorted(Path(folder).glob("*.png"))}
    found = json.loads(printed.splitlines()[-1])
    values = [(plain(f"{source} (`{case}`)"), *map(plain, rest)) for case, source, *rest in found["values"]]
    cases = [
        (f"`{name}`", plain(title), plain(f"{citation}: {where}") + (f" <{url}>" if url else ""), _basis(basis, known),
         plain(note))
        for name, title, citation, where, url, basis, known, note in found["cases"]
    ]  # fmt: skip
    text = (
        f"{found['finding']}.\n\n{table(HEADS, values)}\n"
        "![Published points over our curves](/generated/published_points.png)\n\n"
        "![Differences, and how far ours changes with the tolerance](/generated/published_differences.png)\n\n"
        f"### The cases and their sources\n\n{table(('case', 'what', 'source', 'known', 'note'), cases)}"
    )
    return {**pictures, "pieces/verification.md": text}


def _basis(basis: str, known: str) -> str:
    word = "**from memory**" if basis == "from memory" else basis
    return word if known == basis else f"{word}: {plain(known)}"
