"""The group of commands `records`: each is the module of its name in this folder."""

from __future__ import annotations

import typer

from pounding_risk.cli._common.commands import group_of

ORDER = 230
app = typer.Typer(
    cls=group_of(__name__, __path__),
    help="Strong-motion records: list, process, plot, select.",
    add_completion=False,
    rich_markup_mode=None,
)


@app.callback(invoke_without_command=True)
def records(ctx: typer.Context) -> None:
    """Strong-motion records: list, process, plot, select."""
    if ctx.invoked_subcommand is None:
        from pounding_risk.cli.records.list import list as list_records

        list_records()
