"""The command `records process`: records processed and scaled as for a run, and written."""

from __future__ import annotations

from collections.abc import Sequence
from math import nan
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from pounding_risk.cli._common.files import check_folder, make_folder, writable
from pounding_risk.cli._common.options import NONE, Figure
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli.records import _options as options
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, one_line, print_left_out, print_table

if TYPE_CHECKING:
    from pounding_risk.motions.motion import Motion
    from pounding_risk.motions.record import Source

ORDER = 30


def process(
    source: options.Sources = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write to a .csv or .at2 file, or a folder.", show_default=False)
    ] = None,
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
    figure: Figure = None,
) -> None:
    """Process records as for a run; show every step, write the motions."""
    from pounding_risk.motions.record import RAW
    from pounding_risk.motions.write import state_of, write_motion

    request = options.record_request(processing, step, window, pga, scale, sa, direction)
    facts = options.stated_facts(unit, dt)
    with ProgressDisplay("process", "records") as progress:
        sources = options.find_sources(source or (), set, facts, in_pairs=direction is not None)
        targets = motion_targets(out, sources.groups)
        motions = options.treat(request, sources.groups, progress)
    if any(targets) and not (out is None or out.suffix):
        make_folder(out)
    for motion, target in zip(motions, targets, strict=True):
        if target is not None:
            write_motion(motion, target)
    print_processed(motions, targets)
    for motion, target in zip(motions, targets, strict=True):
        if target is not None and target.suffix.lower() == ".at2" and state_of(motion) == RAW:
            print(
                f"note: {target}: PEER AT2 does not say that {motion.name} is raw: read again, it counts as processed"
            )
    print_left_out(sources.left_out)
    if figure is not None:
        for group in sources.groups:
            has_several = len(sources.groups) > 1
            file = figure.with_stem(f"{figure.stem}-{plain_name(group)}") if has_several else figure
            options.draw_before_and_after(file, request, group)


def motion_targets(out: Path | None, groups: Sequence[tuple[Source, ...]]) -> list[Path | None]:
    """A file for each record: ``out`` itself for one, in the folder ``out`` for several; None where none is written.

    Raises PoundingError where a file cannot be written or would replace a record that is read, or two have one name.
    """
    from pounding_risk.motions.write import SUFFIXES

    if out is None:
        return [None] * len(groups)
    if out.suffix.lower() in SUFFIXES and not out.is_dir():
        if len(groups) > 1:
            raise PoundingError(f"-o: {out} is one file for {len(groups)} records; name a folder")
        targets = [writable("-o", out, SUFFIXES) or out]
    elif out.suffix and not out.is_dir():
        raise PoundingError(f"-o: {out}: the name must end in {' or '.join(SUFFIXES)}; a folder has no suffix")
    else:
        check_folder(out)
        targets = [out / f"{plain_name(group)}.csv" for group in groups]
    for target in targets:
        if targets.count(target) > 1:
            raise PoundingError(f"-o: several of the records would be {target}; process them into folders of their own")
        files_read = [Path(str(source.record.get("file") or "")) for group in groups for source in group]
        if target.is_file() and any(file.is_file() and target.samefile(file) for file in files_read):
            raise PoundingError(f"-o: {target} is a record that is read; choose another name")
    return list(targets)


def plain_name(group: tuple[Source, ...]) -> str:
    """The ids of a record's components, as a file name."""
    name = "+".join(str(source.record["id"]) for source in group)
    return "".join(letter if letter.isalnum() or letter in "-_.+" else "-" for letter in name)


def print_processed(motions: Sequence[Motion], targets: Sequence[Path | None]) -> None:
    """Print the processing steps and flags of each record, then a table with a line for each."""
    for motion in motions:
        print(motion.name)
        print("\n".join(f"  {one_line(sentence)}" for sentence in motion.processing))
        print("".join(f"  note: {flag}\n" for flag in motion.flags))
    from pounding_risk.motions.intensity import measure

    rows = []
    for motion, target in zip(motions, targets, strict=True):
        measures = measure(motion.acceleration, motion.dt)
        velocity, displacement = motion.velocity_displacement()
        row = [
            motion.name,
            engineering(motion.record.get("pga_recorded", nan), "m/s2"),  # a turned motion was not recorded
            engineering(measures.pga, "m/s2"),
            engineering(measures.pgv, "m/s", 3),
            engineering(measures.pgd, "m", 3),
            engineering(velocity[-1], "m/s", 2),
            engineering(displacement[-1], "m", 2),
            f"{motion.dt:.4g} s",
        ]
        rows.append([*row, str(target)] if any(targets) else row)
    heads = ["record", "PGA as recorded", "PGA", "PGV", "PGD", "velocity at the end", "displacement at the end", "dt"]
    if any(targets):
        print_table([*heads, "written"], rows, "lrrrrrrrl")
    else:
        print_table(heads, rows, "lrrrrrrr")
