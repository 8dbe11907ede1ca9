"""The command `amplification`: how pounding raises both buildings' peaks over the ratio of periods and the gap."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw, write_text
from pounding_risk.cli._common.options import (
    NONE,
    Dataset,
    Figure,
    New,
    Overrides,
    Workers,
    file_option,
    option,
    read_option,
)
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli._common.subjects import SOURCE, read_subject
from pounding_risk.cli.records import _options as options
from pounding_risk.render.terminal import print_sheet

ORDER = 126


def amplification(
    source: Annotated[list[str], typer.Argument(metavar="SOURCE...", help=SOURCE)],
    out: Dataset = None,
    overrides: Overrides = NONE,
    ratios: Annotated[tuple[float, float], option("Of the periods, varied over fixed.", metavar="FROM TO")] = (
        0.2,
        5.0,
    ),
    num: Annotated[int, option("Ratios.")] = 31,
    spacing: Annotated[str, option("Of the ratios: log or linear.")] = "log",
    fixed: Annotated[str, option("The building that stays: left, right or its name.")] = "right",
    period: Annotated[
        list[str], option("Period of that building; repeat for several.", "the scene's, or 0.5 s")
    ] = NONE,
    gaps: Annotated[tuple[str, str] | None, option("Gaps.", "by shares", metavar="FROM TO")] = None,
    gap_shares: Annotated[
        tuple[float, float] | None, option("Gaps over --share-of.", "0.1 1.3", metavar="FROM TO")
    ] = None,
    num_gaps: Annotated[int, option("Gaps.")] = 13,
    share_of: Annotated[str, option("A rule without heights, such as srss or cqc; or required.")] = "srss",
    share_percentile: Annotated[str, option("Share of the motions that --share-of is for.")] = "84 %",
    damping: Annotated[
        list[str], option("Damping ratio of both; or twice: left, then right.", "the scene's, or 5 %")
    ] = NONE,
    mass_ratio: Annotated[float | None, option("Mass of left over right; of records alone.", "1")] = None,
    percentile: Annotated[list[str], option("Share of the motions; repeat for several.", "16 %, 50 %, 84 %")] = NONE,
    motions: Annotated[bool, typer.Option("--motions", help="Keep the amplification in each motion.")] = False,
    pga: options.Pga = None,
    scale: options.Scale = None,
    sa: options.SpectralAcceleration = None,
    processing: options.Processing = None,
    window: options.Window = None,
    direction: options.Direction = None,
    tail: Annotated[str | None, option("Free vibration after each record, at least.", "none")] = None,
    unit: options.Unit = None,
    dt: options.Step = None,
    workers: Workers = None,
    new: New = False,
    table: Annotated[Path | None, file_option("Write the whole table", (".csv",))] = None,
    figure: Figure = None,
) -> None:
    """What pounding adds, over period ratio and gap."""
    from pounding_risk.assessment.amplification import PERCENTILES, amplification_table
    from pounding_risk.assessment.amplification import amplification as run
    from pounding_risk.assessment.spectra import read_percentiles
    from pounding_risk.questions.amplification import sheet
    from pounding_risk.units import GAP, PERIOD

    treatment = {
        "pga": pga, "scale": scale, "sa": sa, "processing": processing, "window": window, "direction": direction,
        "tail": tail, "unit": unit, "dt": dt,
    }  # fmt: skip
    asked: dict[str, Any] = {
        "periods": [read_option("--period", text, PERIOD) for text in period] or None,
        "gaps": None if gaps is None else [read_option("--gaps", text, GAP) for text in gaps],
        "percentiles": read_percentiles(percentile or PERCENTILES, "--percentile"),
        "share_percentile": share_percentile,
    }
    subject = read_subject(source, overrides, treatment)
    with ProgressDisplay("amplification", "runs") as progress:
        dataset = run(
            subject, out, **asked, ratios=ratios, num=num, spacing=spacing, fixed=fixed, gap_shares=gap_shares,
            num_gaps=num_gaps, share_of=share_of, damping=damping or None, mass_ratio=mass_ratio, motions=motions,
            workers=workers, new=new, progress=progress,
        )  # fmt: skip
    print_sheet(sheet(dataset))
    announce(out)
    if table is not None:
        write_text(table, amplification_table(dataset).to_csv(index=False))
    draw(figure, "amplification_chart.amplification_figure", dataset)
