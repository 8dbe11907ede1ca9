"""The command `records process`."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.files import FIGURES, draw, make_folder, writable
from pounding_risk.cli._common.options import NONE, Figure
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
    motion_targets,
    plain_name,
    stated,
    treatment,
)
from pounding_risk.cli.records._tables import print_left_out, print_processed

ORDER = 30


def process(
    source: Sources = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write to a .csv or .at2 file, or a folder.", show_default=False)
    ] = None,
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
    figure: Figure = None,
) -> None:
    """Process records as for a run; show every step, write the motions."""
    figure_file = writable("--figure", figure, FIGURES)
    from pounding_risk.motions.ensemble import treated
    from pounding_risk.motions.write import write_motion

    how = treatment(Options(processing, step, window, pga, scale, sa, direction))
    with Watch("process", "records") as watch:
        found = find(source or (), set, stated(unit, dt), in_pairs=how.direction is not None)
        targets = motion_targets(out, found.groups)
        motions = []
        for group in found.groups:
            motions.append(treated(how, group))
            watch(len(motions), len(found.groups))
    if any(targets) and not (out is None or out.suffix):
        make_folder(out)
    for motion, target in zip(motions, targets, strict=True):
        if target is not None:
            write_motion(motion, target)
    print_processed(motions, targets)
    print_left_out(found.left_out)
    if figure_file is not None:
        for group in found.groups:
            many = len(motions) > 1
            place = figure_file.with_stem(f"{figure_file.stem}-{plain_name(group)}") if many else figure_file
            draw(before_and_after(how, group), place)
