"""The command `records plot`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.options import NONE, read_option
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli.records._options import (
    Direction,
    Options,
    Pga,
    Processing,
    Scale,
    Set,
    Sources,
    SpectralAcceleration,
    Step,
    Steps,
    Unit,
    Window,
    before_and_after,
    find,
    stated,
    target_spectrum,
    treatment,
)
from pounding_risk.cli.records._tables import print_left_out
from pounding_risk.errors import PoundingError

ORDER = 40


def plot(
    source: Sources = None,
    figure: Annotated[Path | None, typer.Option(help="The figure (.png, .svg or .pdf).", show_default=False)] = None,
    spectra: Annotated[
        bool, typer.Option("--spectra", help="Response spectra, also of a single record.", show_default=False)
    ] = False,
    target: Annotated[
        str | None, typer.Option(help="Target spectrum: a file, or a code shape.", show_default=False)
    ] = None,
    damping: Annotated[str, typer.Option(help="Damping ratio of the spectra.")] = "5 %",
    set: Set = None,
    processing: Processing = None,
    step: Steps = NONE,
    window: Window = None,
    pga: Pga = None,
    scale: Scale = None,
    sa: SpectralAcceleration = None,
    direction: Direction = None,
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """Draw one record before and after processing, or the response spectra of several."""
    if figure is None:
        raise PoundingError("--figure: no file is named; write one such as --figure records.png")
    figure_file = writable("--figure", figure, FIGURES) or figure
    from pounding_risk.figures import spectra_figure
    from pounding_risk.motions.ensemble import treated
    from pounding_risk.units import DAMPING

    ratio = read_option("--damping", damping, DAMPING)
    how = treatment(Options(processing, step, window, pga, scale, sa, direction))
    shape = None if target is None else target_spectrum(target, ratio)
    with Watch("plot", "records") as watch:
        found = find(source or (), set, stated(unit, dt), horizontal=True, in_pairs=how.direction is not None)
        alone = len(found.groups) == 1 and not spectra and shape is None
        motions = []
        for group in found.groups if not alone else ():
            motions.append(treated(how, group))
            watch(len(motions), len(found.groups))
    print_left_out(found.left_out)
    draw(before_and_after(how, found.groups[0]) if alone else spectra_figure(motions, shape, ratio), figure_file)
