"""The command `verify`: published cases, run and compared with the published values."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import Figure, out_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_table

if TYPE_CHECKING:
    from pounding_risk.lab.verification import Property, Verification

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

    with ProgressDisplay("verify") as progress:
        outcome = run(cases, progress=progress)
    print_verification(outcome)
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


def print_verification(outcome: Verification) -> None:
    """Print a line for each published value and property, then each that is unacceptable or fails, and the counts."""
    from pounding_risk.lab.verification.run import said, share

    rows = [
        (
            *(check.case, check.quantity, check.source, check.kind, check.printed, said(check)),
            *(share(check.difference), share(abs(check.change)), check.word),
        )
        for check in outcome.checks
    ]
    heads = ("case", "quantity", "source", "kind", "published", "ours", "difference", "ours changes by", "")
    if rows:
        print_table(heads, rows, "llllrrrrl")
    if outcome.properties:
        print_properties(outcome.properties)
    for check in outcome.unacceptable:
        why = "; ours has converged" if check.is_converged else ""
        print(
            f"{check.case}, {check.quantity}: {share(check.difference)} from {check.printed} of {check.source}, more "
            f"than {100.0 * check.limit:.0f} %{why}"
        )
    print(outcome.finding())


def print_properties(properties: Sequence[Property]) -> None:
    """Print a line for each published relation, then every reading that is out of its bounds."""
    from pounding_risk.lab.verification.property import bounds, plain, rounded

    rows = [
        (
            one.name,
            one.source,
            plain(one.headline),
            f"{sum(r.holds for r in one.readings)} of {len(one.readings)}",
            one.word,
        )
        for one in properties
    ]
    print_table(("property", "source", "ours", "readings in bounds", ""), rows, "lllrl")
    for one in properties:
        for reading in one.readings:
            if not reading.holds:
                print(
                    f"{one.name}, {reading.quantity}: {rounded(reading.ours)}, bounds {bounds(reading)}: "
                    f"{reading.reason}"
                )
