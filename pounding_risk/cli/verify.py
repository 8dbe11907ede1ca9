"""The command `verify`: published cases, run and compared with the published values."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import Figure, out_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_sheet

ORDER = 88
DISAGREES = 1  # exit status where a value is unacceptable


def verify(
    cases: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[CASE | PROPERTY | FILE | FOLDER]",
            help="Cases and properties that ship, case files (.toml) or folders of them.",
            show_default="all that ship",
        ),
    ] = None,
    out: Annotated[Path | None, out_option("Write the page", ".html", ".pdf")] = None,
    figure: Figure = None,
) -> None:
    """Published cases and properties, beside ours.

    Ends with status 1 where a value is unacceptable or a property fails.
    """
    from pounding_risk.lab.verification import verify as run
    from pounding_risk.questions.verify import sheet

    with ProgressDisplay("verify") as progress:
        outcome = run(cases, progress=progress)
    print_sheet(sheet(outcome))
    if out is not None:
        from pounding_risk.reports.verification import verification_page

        announce(verification_page(outcome, out))
    if figure is not None and not outcome.checks:
        draw(figure, "verification.property_figure", outcome.properties[0])
        if len(outcome.properties) > 1:
            print(f"the figure shows {outcome.properties[0].name} alone; -o page.html has those of all")
    else:
        draw(figure, "verification.verification_differences_figure", outcome)
    if outcome.unacceptable or outcome.failing:
        raise typer.Exit(DISAGREES)
