"""The command `records plot`: one record before and after processing, histories, or response spectra."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import FIGURES, draw
from pounding_risk.cli._common.options import NONE, file_option, option, read_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli.records import _options as options
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import print_left_out
from pounding_risk.units import DAMPING

ORDER = 40


def plot(
    source: options.Sources = None,
    figure: Annotated[Path | None, file_option("The figure", FIGURES)] = None,
    spectra: Annotated[
        bool, typer.Option("--spectra", help="Response spectra, also of a single record.", show_default=False)
    ] = False,
    histories: Annotated[
        bool, typer.Option("--histories", help="Acceleration, velocity, displacement of each.", show_default=False)
    ] = False,
    target: Annotated[str | None, option("Target spectrum: a file, or a code shape.")] = None,
    poe: options.Poe = None,
    damping: options.Damping = "5 %",
    set: options.Set = None,
    processing: options.Processing = None,
    step: options.Steps = NONE,
    window: options.Window = None,
    pga: options.Pga = None,
    scale: options.Scale = None,
    sa: options.SpectralAcceleration = None,
    direction: options.Direction = None,
    unit: options.Unit = None,
    dt: options.Step = None,
) -> None:
    """Draw one record before and after processing, the response spectra of several, or their histories."""
    if figure is None:
        raise PoundingError("--figure: no file is named; write one such as --figure records.png")
    if histories and (spectra or target is not None):
        raise PoundingError("--histories: spectra are asked for too, which are another figure; leave one out")
    ratio = read_option("--damping", damping, DAMPING)
    request = options.record_request(processing, step, window, pga, scale, sa, direction)
    spectrum = None if target is None else options.target_spectrum(target, ratio, poe)
    facts = options.stated_facts(unit, dt)
    with ProgressDisplay("plot", "records") as progress:
        sources = options.find_sources(source or (), set, facts, horizontal=True, in_pairs=direction is not None)
        is_single = len(sources.groups) == 1 and not (spectra or histories) and spectrum is None
        motions = options.treat(request, () if is_single else sources.groups, progress)
    print_left_out(sources.left_out)
    if is_single:
        options.draw_before_and_after(figure, request, sources.groups[0])
    elif histories:
        draw(figure, "motions.histories_figure", motions)
    else:
        draw(figure, "motions.spectra_figure", motions, spectrum, ratio)
