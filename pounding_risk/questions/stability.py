"""Sheet of `stability`: the hard cases of pounding, and by how much what must hold does."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, isnan
from typing import TYPE_CHECKING

from pounding_risk._common.counted import counted
from pounding_risk.render.sheet import Block, Cell, count, listing, out_of, paragraph, table, worded

if TYPE_CHECKING:
    from pounding_risk.lab.stability import Row

ORDER = 90
FUNCTION = "lab.stability.run"
FAILS = 3  # exit status
HEADS = ("case", "group", "scene", "what must hold", "laws", "worst figure")
BESIDE = ("as a row", "worst figure as a row")


def sheet(rows: Sequence[Row]) -> list[Block]:
    """The worst figure of each case, whatever does not hold, and the counts.

    With the figures of the solver of rows beside, where it was run.
    """
    in_row = [row.in_row for row in rows if row.in_row is not None]
    by_case: dict[str, list[Row]] = {}
    for row in rows:
        by_case.setdefault(row.case.number, []).append(row)
    heads = (*HEADS, *(BESIDE if in_row else ()), "bound", "law", "steps")
    lines = [
        _line(case_rows, [result for result in in_row if result.case.number == number], bool(in_row))
        for number, case_rows in by_case.items()
    ]
    caption = "Hard cases: worst figure over the contact laws, and the bound that it must keep."
    row_text = f"; {len(in_row)} as a row: {_outcome(in_row)}" if in_row else ""
    return [
        table(caption, heads, lines),
        listing([*_failing(rows, ""), *_failing(in_row, " as a row")], mark=""),
        paragraph(f"{counted(len(by_case), 'hard case')}, {len(rows)} with each law: {_outcome(rows)}{row_text}"),
    ]


def status(rows: Sequence[Row]) -> int:
    """Exit status of the command."""
    return 0 if all(row.holds and (row.in_row is None or row.in_row.holds) for row in rows) else FAILS


def _line(case_rows: Sequence[Row], in_row: Sequence[Row], has_rows: bool) -> list[Cell | str]:
    worst = max(case_rows, key=_badness)
    line: list[Cell | str] = [worst.case.number, worst.case.group, worst.case.scene, worst.case.invariant]
    line += [_share(case_rows), _figure(worst.figure)]
    if has_rows:
        line += [_share(in_row), _figure(max(in_row, key=_badness).figure)] if in_row else ["–", "–"]
    law = worst.law if worst.figure != 0.0 else "–"
    return [*line, _figure(worst.bound), law, count(max(row.steps for row in case_rows))]


def _badness(row: Row) -> tuple[bool, float]:
    """Order of outcomes from good to bad."""
    return not row.holds, inf if isnan(row.figure) else row.figure


def _failing(rows: Sequence[Row], words: str) -> list[str]:
    return [
        f"case {row.case.number}, {row.law}{words}: {_figure(row.figure)['text']} > {_figure(row.bound)['text']}; "
        f"{row.status}"
        for row in rows
        if not row.holds
    ]


def _share(rows: Sequence[Row]) -> Cell:
    return out_of(sum(row.holds for row in rows), len(rows))


def _outcome(rows: Sequence[Row]) -> str:
    failed = sum(not row.holds for row in rows)
    return "all hold" if not failed else f"{len(rows) - failed} hold, {failed} do not"


def _figure(measure: float) -> Cell:
    return worded(measure, f"{measure:.1e}" if measure else "0")
