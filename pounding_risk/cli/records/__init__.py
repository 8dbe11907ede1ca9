"""The `records` commands: list, info, process, plot, select."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from pounding_risk.cli._common.options import FIGURES, Figure, make_folder, read_option, writable
from pounding_risk.cli._common.tables import draw
from pounding_risk.errors import PoundingError

records_app = typer.Typer(help="Strong-motion records: list, process, plot, select.")

NONE: list[str] = []
WORDS = "ids, files, file#component, patterns or folders"
Sources = Annotated[list[str] | None, typer.Argument(metavar="SOURCE", help=f"Records: {WORDS}.", show_default=False)]
Set = Annotated[str | None, typer.Option("--set", help="A record set, such as fema-p695-farfield.", show_default=False)]
Unit = Annotated[
    str | None, typer.Option(help="Unit of files that do not state theirs, such as cm/s^2.", show_default=False)
]
Step = Annotated[
    str | None, typer.Option("--dt", help="Time step of files that do not state theirs.", show_default=False)
]
Processing = Annotated[
    str | None, typer.Option(help="auto processes raw records, none leaves all as they are.", show_default="auto")
]
Steps = Annotated[
    list[str],
    typer.Option(
        "--step", metavar="'NAME OPTION=VALUE'", help="A step, such as 'bandpass low=0.1Hz'; repeat, in order."
    ),
]
Window = Annotated[
    tuple[str, str] | None,
    typer.Option(metavar="START END", help="Keep this part, after processing.", show_default=False),
]
Bounds = Annotated[
    tuple[float, float] | None, typer.Option(metavar="LEAST MOST", help="Such as 6.5 7.5.", show_default=False)
]
Pga = Annotated[str | None, typer.Option(help="Scale to this peak ground acceleration.", show_default=False)]
Scale = Annotated[str | None, typer.Option(help="Scale by this factor.", show_default=False)]
Direction = Annotated[
    str | None,
    typer.Option(help="Turn both horizontals of each recording to this direction, such as 30deg.", show_default=False),
]
SpectralAcceleration = Annotated[
    tuple[str, str] | None,
    typer.Option(metavar="VALUE PERIOD", help="Scale to this Sa at a period, such as 0.5g 1s.", show_default=False),
]


@records_app.callback(invoke_without_command=True)
def records(ctx: typer.Context) -> None:
    """Strong-motion records: list, process, plot, select."""
    if ctx.invoked_subcommand is None:
        list_records()


@records_app.command("list")
def list_records(
    set: Set = None,
    folder: Annotated[Path | None, typer.Option(help="A folder of record files.", show_default=False)] = None,
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """The records of the catalogue, of a set, or of a folder."""
    from pounding_risk.cli.records._tables import print_left_out, print_records, print_sources

    if set is None and folder is None:
        from pounding_risk.motions.catalogue import entries

        print_records(entries())
        return
    from pounding_risk.cli.records._options import find, stated

    if folder is not None and not folder.is_dir():
        raise PoundingError(f"--folder: {folder} is not a folder; check the name")
    found = find([str(folder)] if folder else [], set, stated(unit, dt), lenient=True)
    print_sources([source for group in found.groups for source in group])
    print_left_out(found.left_out)


@records_app.command("info")
def record_info(
    source: Annotated[
        str, typer.Argument(metavar="SOURCE", help="An id, a file, or file#component.", show_default=False)
    ],
    unit: Unit = None,
    dt: Step = None,
) -> None:
    """One record: origin, terms, checksum, where its file is, PGA to Sa."""
    from pounding_risk.cli.records._options import stated
    from pounding_risk.cli.records._tables import print_record, print_source
    from pounding_risk.motions.catalogue import entries, entry
    from pounding_risk.motions.source import open_source

    if any(each.id == source for each in entries()):
        print_record(entry(source))
    else:
        print_source(open_source(source, **stated(unit, dt)._asdict()))


@records_app.command()
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
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.records._options import (
        Options,
        before_and_after,
        find,
        motion_targets,
        plain_name,
        stated,
        treatment,
    )
    from pounding_risk.cli.records._tables import print_left_out, print_processed
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


@records_app.command()
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
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.records._options import Options, before_and_after, find, stated, target_spectrum, treatment
    from pounding_risk.cli.records._tables import print_left_out
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


@records_app.command()
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
    from pounding_risk.cli._common.tables import Watch
    from pounding_risk.cli.records._options import Options, choices_of, find, stated, target_spectrum, treatment
    from pounding_risk.cli.records._tables import print_left_out, print_selection
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
