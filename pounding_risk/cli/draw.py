"""The command `draw`: pictures of a row from its dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import FIGURES, writable
from pounding_risk.cli._common.options import Amplitude, read_option

ORDER = 200
NO_NAMES: list[str] = []
Picture = ".png, .svg or .pdf"


def draw(
    results: Annotated[
        list[Path], typer.Argument(metavar="RESULTS...", help="What scan wrote (.nc or .zarr).", show_default=False)
    ],
    elevation: Annotated[
        Path | None, typer.Option(help=f"The row in elevation ({Picture}).", show_default=False)
    ] = None,
    plan: Annotated[Path | None, typer.Option(help=f"The street in plan ({Picture}).", show_default=False)] = None,
    profiles: Annotated[Path | None, typer.Option(help=f"Storeys ({Picture}).", show_default=False)] = None,
    animation: Annotated[
        Path | None, typer.Option(help="One run with its histories, moving (.html).", show_default=False)
    ] = None,
    street: Annotated[
        Path | None, typer.Option(help="Footprints for the plan (.geojson).", show_default="plain rectangles")
    ] = None,
    building: Annotated[
        list[str], typer.Option(help="Of the profiles; repeat for several.", show_default="those raised most")
    ] = NO_NAMES,
    gap: Annotated[str | None, typer.Option(help="Gap, the grid's nearest.", show_default="the scene's")] = None,
    contact_model: Annotated[str | None, typer.Option(help="Of the grid.", show_default="the scene's")] = None,
    yield_force: Annotated[str | None, typer.Option(help="F_E of the grid.", show_default="the scene's")] = None,
    pga: Amplitude = None,
) -> None:
    """Draw a row: elevation, plan, storeys, animation."""
    options = {"--elevation": elevation, "--plan": plan, "--profiles": profiles}
    files = [writable(name, path, FIGURES) for name, path in options.items()]
    moving = writable("--animation", animation, (".html",))
    from pounding_risk.reports.drawings import draw as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    written = run(
        results,
        elevation=files[0],
        plan=files[1],
        profiles=files[2],
        animation=moving,
        street=street,
        building=building,
        gap=None if gap is None else read_option("--gap", gap, GAP),
        contact_model=contact_model,
        yield_force=None if yield_force is None else read_option("--yield-force", yield_force, YIELD_FORCE),
        pga=None if pga is None else read_option("--pga", pga, PGA),
    )
    for path in written:
        typer.echo(f"written: {path}")
