"""The command `stability`: the hard cases, and by how much their invariants hold."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.options import RUN_FAILED, option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_table

if TYPE_CHECKING:
    from pounding_risk.lab.stability import Row

ORDER = 90


def stability(
    rtol: Annotated[float, option("Tolerance of the solver, 1e-12 to 1e-2.")] = 1e-6,
    law: Annotated[list[str] | None, option("Contact model; repeat for several.", "all")] = None,
    case: Annotated[list[str] | None, option("Number of a case; repeat for several.", "all")] = None,
    rows: Annotated[bool, option("Run each also by the solver of rows, beside.")] = False,
) -> None:
    """Run the hard cases and show what holds, and by how much."""
    from pounding_risk.lab.stability import stability as run

    with ProgressDisplay("stability") as progress:
        outcomes = run(rtol, law, case, progress=progress, rows=rows)
    if not print_stability(outcomes):
        raise typer.Exit(RUN_FAILED)


def print_stability(rows: Sequence[Row]) -> bool:
    """Print the worst row of each case, then every row that does not hold; returns True where all hold.

    Where the solver of rows has run them too, its verdict stands beside.
    """
    numbers = list(dict.fromkeys(row.case.number for row in rows))
    in_row = [row.in_row for row in rows if row.in_row is not None]
    lines: list[tuple[str, ...]] = []
    for number in numbers:
        of_case = [row for row in rows if row.case.number == number]
        worst = max(of_case, key=_badness)
        beside = [outcome for outcome in in_row if outcome.case.number == number]
        lines.append(
            (
                number,
                worst.case.group,
                worst.case.scene,
                worst.case.invariant,
                _share_words(of_case),
                _error_words(worst.figure),
                *((_share_words(beside), _error_words(max(beside, key=_badness).figure)) if beside else ("–", "–")),
                _error_words(worst.bound),
                worst.law if worst.figure != 0.0 else "–",
                str(max(row.steps for row in of_case)),
            )
        )
    beside_heads = ("as a row", "worst figure as a row")
    heads = ("case", "group", "scene", "what must hold", "laws", "worst figure", *beside_heads, "bound", "law", "steps")
    if in_row:
        print_table(heads, lines, "lllllrlrrlr")
    else:
        print_table((*heads[:6], *heads[8:]), [(*line[:6], *line[8:]) for line in lines], "lllllrrlr")
    for words, some in (("", rows), (" as a row", in_row)):
        for row in some:
            if not row.holds:
                figure = f"{_error_words(row.figure)} > {_error_words(row.bound)}"
                print(f"case {row.case.number}, {row.law}{words}: {figure}; {row.status}")
    also = f"; {len(in_row)} as a row: {_outcome(in_row)}" if in_row else ""
    print(f"{len(numbers)} hard cases, {len(rows)} with each law: {_outcome(rows)}{also}")
    return all(row.holds for row in (*rows, *in_row))


def _badness(row: Row) -> tuple[bool, float]:
    """Order of outcomes from good to bad."""
    return not row.holds, inf if isnan(row.figure) else row.figure


def _share_words(rows: Sequence[Row]) -> str:
    return f"{sum(row.holds for row in rows)} of {len(rows)}"


def _outcome(rows: Sequence[Row]) -> str:
    """How many hold."""
    failed = sum(not row.holds for row in rows)
    return "all hold" if not failed else f"{len(rows) - failed} hold, {failed} do not"


def _error_words(value: float) -> str:
    if isnan(value):
        return "–"
    return "0" if value == 0.0 else f"{value:.1e}"
