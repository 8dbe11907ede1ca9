"""The command `verify`: published cases, run and compared with the published values."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import Figure, out_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli._common.tables import print_table

if TYPE_CHECKING:
    from pounding_risk.studies.verification import Verification

ORDER = 88
DISAGREES = 1  # exit status where a value is unacceptable


def verify(
    cases: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[CASE | FILE | FOLDER]",
            help="Cases that ship, case files (.toml) or folders of them.",
            show_default="all that ship",
        ),
    ] = None,
    out: Annotated[Path | None, out_option("Write the page", ".html", ".pdf")] = None,
    figure: Figure = None,
) -> None:
    """Run published cases and set each published value beside ours.

    Ends with status 1 where a value is unacceptable.
    """
    from pounding_risk.studies.verification import verify as run

    with ProgressDisplay("verify") as progress:
        outcome = run(cases, progress=progress)
    print_verification(outcome)
    if out is not None:
        from pounding_risk.reports.verification import verification_page

        announce(verification_page(outcome, out))
    draw(figure, "verification.verification_differences_figure", outcome)
    if outcome.unacceptable:
        raise typer.Exit(DISAGREES)


def print_verification(outcome: Verification) -> None:
    """Print a line for each published value, then every one that is unacceptable, and the counts."""
    from pounding_risk.studies.verification.run import said, share

    rows = [
        (
            *(check.case, check.quantity, check.source, check.kind, check.printed, said(check)),
            *(share(check.difference), share(abs(check.change)), check.word),
        )
        for check in outcome.checks
    ]
    heads = ("case", "quantity", "source", "kind", "published", "ours", "difference", "ours changes by", "")
    print_table(heads, rows, "llllrrrrl")
    for check in outcome.unacceptable:
        why = "; ours has converged" if check.is_converged else ""
        print(
            f"{check.case}, {check.quantity}: {share(check.difference)} from {check.printed} of {check.source}, more "
            f"than {100.0 * check.limit:.0f} %{why}"
        )
    print(outcome.finding())
