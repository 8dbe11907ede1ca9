"""The command `records select`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.options import Figure, read_option
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli.records._options import (
    Bounds,
    Options,
    Processing,
    Set,
    Sources,
    Step,
    Unit,
    choices_of,
    find,
    stated,
    target_spectrum,
    treatment,
)
from pounding_risk.cli.records._tables import print_left_out, print_selection

ORDER = 50


def select(
    target: Annotated[str, typer.Option(help="Target spectrum: a file, a code shape, or a record set.")],
    source: Sources = None,
    set: Set = None,
    range: Annotated[
        tuple[str, str], typer.Option(metavar="FROM TO", help="Periods at which spectra are compared.")
    ] = ("0.2 s", "2 s"),
    count: Annotated[int, typer.Option(min=1, help="Records to choose, or pairs.")] = 11,
    spectrum: Annotated[
        str, typer.Option(help="component; or geomean, rotd50, rotd100 of pairs with one factor.")
    ] = "component",
    factor: Annotated[tuple[float, float], typer.Option(metavar="LEAST MOST", help="Limits of the scale factor.")] = (
        0.25,
        4.0,
    ),
    per_event: Annotated[
        int | None, typer.Option(min=1, help="At most so many of one earthquake.", show_default="any number")
    ] = None,
    magnitude: Bounds = None,
    distance: Annotated[
        tuple[str, str] | None, typer.Option(metavar="LEAST MOST", help='Such as "10 km" "50 km".', show_default=False)
    ] = None,
    vs30: Annotated[
        tuple[str, str] | None,
        typer.Option(metavar="LEAST MOST", help='Such as "180 m/s" "360 m/s".', show_default=False),
    ] = None,
    pga: Annotated[
        tuple[str, str] | None,
        typer.Option(metavar="LEAST MOST", help='As recorded, such as "0.1 g" "0.5 g".', show_default=False),
    ] = None,
    damping: Annotated[str, typer.Option(help="Damping ratio of the spectra.")] = "5 %",
    processing: Processing = None,
    unit: Unit = None,
    dt: Step = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write a manifest (.csv).", show_default=False)
    ] = None,
    figure: Figure = None,
) -> None:
    """Choose records whose spectra come closest to a target, each with its factor."""
    out_file, figure_file = writable("-o", out, (".csv",)), writable("--figure", figure, FIGURES)
    from pounding_risk.motions.ensemble import treated
    from pounding_risk.motions.selection import select as run
    from pounding_risk.units import DAMPING

    how = treatment(Options(processing, (), None, None, None, None))
    choices = choices_of(range, distance, vs30, pga)
    choices |= {"count": count, "spectrum": spectrum, "limits": factor, "per_event": per_event, "magnitude": magnitude}
    goal = target_spectrum(target, read_option("--damping", damping, DAMPING))
    with Watch("select", "records") as watch:
        found = find(source or (), set, stated(unit, dt), horizontal=True)
        motions = []
        for group in found.groups:
            motions.append(treated(how, group))
            watch(len(motions), len(found.groups))
    selection = run(motions, goal, **choices)
    print_selection(selection)
    print_left_out(found.left_out)
    if out_file is not None:
        from pounding_risk.motions.manifest import write_manifest

        write_manifest(selection.motions(), out_file)
        typer.echo(f"written: {out_file}")
    if figure_file is not None:
        from pounding_risk.figures import selection_figure

        draw(selection_figure(selection), figure_file)
