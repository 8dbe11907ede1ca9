"""Sheet of `rerun`: what differs between results and a new run of what they carry."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.questions._declaration import Option
from pounding_risk.render.sheet import Block, Cell, count, listing, paragraph, table, worded

if TYPE_CHECKING:
    from pounding_risk.studies.rerun import Difference, Rerun

ORDER = 160
FUNCTION = "studies.rerun"
SUBJECT = "results file"
OPTIONS = {"folder": Option(metavar="FOLDER")}
HELP = "Ends with status 3 where anything differs."
DIFFERS = 3  # exit status
HEADS = ("differs", "in", "of", "largest difference", "unit", "relative", "how")


def sheet(comparison: Rerun) -> list[Block]:
    """What differs, or that nothing does, then other versions and notes.

    Parameters
    ----------
    comparison : Rerun
        An answer of `rerun`.
    """
    names = (("missing", comparison.missing), ("new", comparison.new))
    lines = [f"{heading}: {', '.join(some)}" for heading, some in names if some]
    lines += [f"version: {name} is {now}, was {was}" for name, (was, now) in comparison.versions.items()]
    blocks = [listing(lines, mark=""), listing(comparison.notes)]
    if comparison.same:
        words = f"all {comparison.compared} variables and coordinates are the same to the last bit"
        return [paragraph(words), *(block for block in blocks if block["items"])]
    n_same = comparison.compared - len(comparison.differences) - len(comparison.missing)
    rows = [_row(difference, comparison) for difference in comparison.differences]
    return [
        *([table("Variables that differ.", HEADS, rows)] if rows else []),
        paragraph(f"the other {n_same} variables and coordinates are the same to the last bit"),
        *(block for block in blocks if block["items"]),
    ]


def status(comparison: Rerun) -> int:
    """Exit status of the command."""
    return 0 if comparison.same else DIFFERS


def _row(difference: Difference, comparison: Rerun) -> list[Cell | str]:
    """Cells of a variable that differs."""
    unit = str(comparison.dataset[difference.name].attrs.get("units", ""))
    return [
        difference.name,
        count(difference.cases),
        count(difference.of),
        worded(difference.absolute, f"{difference.absolute:.2g}"),
        unit,
        worded(difference.relative, f"{difference.relative:.1e}"),
        difference.words,
    ]
