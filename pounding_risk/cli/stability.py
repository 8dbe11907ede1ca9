"""The table that `stability` prints: one line a case, the contact law with the worst figure beside it."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.options import RUN_FAILED
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli._common.tables import print_table

if TYPE_CHECKING:
    from pounding_risk.studies.stability import Row

ORDER = 90


def stability(
    rtol: Annotated[float, typer.Option(help="Tolerance of the solver, 1e-12 to 1e-2.")] = 1e-6,
    law: Annotated[
        list[str] | None, typer.Option(help="Contact model; repeat for several.", show_default="all")
    ] = None,
    case: Annotated[
        list[str] | None, typer.Option(help="Number of a case; repeat for several.", show_default="all")
    ] = None,
) -> None:
    """Run the hard cases and show what holds, and by how much."""
    from pounding_risk.studies.stability import stability as run

    with Watch("stability") as watch:
        rows = run(rtol, law, case, progress=watch)
    if not print_stability(rows):
        raise typer.Exit(RUN_FAILED)


def print_stability(rows: Sequence[Row]) -> bool:
    """Print the worst row of each case, then every row that does not hold; returns True where all hold."""
    cases = list(dict.fromkeys(row.case.number for row in rows))
    table = []
    for number in cases:
        of_case = [row for row in rows if row.case.number == number]
        worst = max(of_case, key=_badness)
        holds = sum(row.holds for row in of_case)
        table.append(
            (
                number,
                worst.case.group,
                worst.case.scene,
                worst.case.invariant,
                f"{holds} of {len(of_case)}",
                _figure(worst.figure),
                _figure(worst.bound),
                worst.law if worst.figure != 0.0 else "–",
                str(max(row.steps for row in of_case)),
            )
        )
    heads = ("case", "group", "scene", "what must hold", "laws", "worst figure", "bound", "law", "steps")
    print_table(heads, table, "lllllrrlr")
    failed = [row for row in rows if not row.holds]
    for row in failed:
        print(f"case {row.case.number}, {row.law}: {_figure(row.figure)} > {_figure(row.bound)}; {row.status}")
    kept = "all hold" if not failed else f"{len(rows) - len(failed)} hold, {len(failed)} do not"
    print(f"{len(cases)} hard cases, {len(rows)} with each law: {kept}")
    return not failed


def _badness(row: Row) -> tuple[bool, float]:
    return not row.holds, inf if isnan(row.figure) else row.figure


def _figure(value: float) -> str:
    if isnan(value):
        return "–"
    return "0" if value == 0.0 else f"{value:.1e}"
