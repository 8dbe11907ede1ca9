"""The command `stability`: the hard cases, and by how much their invariants hold."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.options import RUN_FAILED, option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli._common.tables import print_table

if TYPE_CHECKING:
    from pounding_risk.studies.stability import Row

ORDER = 90


def stability(
    rtol: Annotated[float, option("Tolerance of the solver, 1e-12 to 1e-2.")] = 1e-6,
    law: Annotated[list[str] | None, option("Contact model; repeat for several.", "all")] = None,
    case: Annotated[list[str] | None, option("Number of a case; repeat for several.", "all")] = None,
) -> None:
    """Run the hard cases and show what holds, and by how much."""
    from pounding_risk.studies.stability import stability as run

    with ProgressDisplay("stability") as progress:
        rows = run(rtol, law, case, progress=progress)
    if not print_stability(rows):
        raise typer.Exit(RUN_FAILED)


def print_stability(rows: Sequence[Row]) -> bool:
    """Print the worst row of each case, then every row that does not hold; returns True where all hold."""
    numbers = list(dict.fromkeys(row.case.number for row in rows))
    lines = []
    for number in numbers:
        of_case = [row for row in rows if row.case.number == number]
        worst = max(of_case, key=lambda row: (not row.holds, inf if isnan(row.figure) else row.figure))
        lines.append(
            (
                number,
                worst.case.group,
                worst.case.scene,
                worst.case.invariant,
                f"{sum(row.holds for row in of_case)} of {len(of_case)}",
                _error_words(worst.figure),
                _error_words(worst.bound),
                worst.law if worst.figure != 0.0 else "–",
                str(max(row.steps for row in of_case)),
            )
        )
    heads = ("case", "group", "scene", "what must hold", "laws", "worst figure", "bound", "law", "steps")
    print_table(heads, lines, "lllllrrlr")
    failed = [row for row in rows if not row.holds]
    for row in failed:
        print(
            f"case {row.case.number}, {row.law}: {_error_words(row.figure)} > {_error_words(row.bound)}; {row.status}"
        )
    outcome = "all hold" if not failed else f"{len(rows) - len(failed)} hold, {len(failed)} do not"
    print(f"{len(numbers)} hard cases, {len(rows)} with each law: {outcome}")
    return not failed


def _error_words(value: float) -> str:
    if isnan(value):
        return "–"
    return "0" if value == 0.0 else f"{value:.1e}"
