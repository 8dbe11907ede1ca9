"""The group of commands `records`: each is the module of its name in this folder."""

from __future__ import annotations

import typer

from pounding_risk.cli._common.commands import add_commands

ORDER = 230
app = typer.Typer(help="Strong-motion records: list, process, plot, select.")


@app.callback(invoke_without_command=True)
def records(ctx: typer.Context) -> None:
    """Strong-motion records: list, process, plot, select."""
    if ctx.invoked_subcommand is None:
        from pounding_risk.cli.records.list import list as list_records

        list_records()


add_commands(app, __name__, __path__)
