"""The command `amplification`: how pounding raises both buildings' peaks over the ratio of periods and the gap."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw, write_text
from pounding_risk.cli._common.notes import print_flags, print_left_out, print_notes
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
from pounding_risk.render.terminal import engineering, print_pairs, print_table

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
    print_amplification(dataset)
    announce(out)
    if table is not None:
        write_text(table, amplification_table(dataset).to_csv(index=False))
    draw(figure, "amplification_chart.amplification_figure", dataset)


def print_amplification(dataset: Any) -> None:
    """Print the amplification of the displacements at a few ratios and gaps, then what it is of and the finding."""
    from pounding_risk.assessment.amplification import ratio_words, reference_name, table_rows, told_words
    from pounding_risk.assessment.spectra import motions_words

    names = [str(name) for name in dataset["building"].values]
    percentiles = [f"{value:g} %" for value in dataset["percentile"].values]
    shares = "gap_share" in dataset.dims
    several = dataset.sizes["fixed_period"] > 1
    heads = (
        *(["beside"] if several else []),
        ratio_words(dataset),
        *([f"gap / {reference_name(dataset)}"] if shares else []),
        "gap",
        "touch in",
        *(f"{name} {percentile}" for name in names for percentile in percentiles),
    )
    rows = [
        (
            *([engineering(row.period, "s", 3)] if several else []),
            f"{row.ratio:.3g}",
            *([f"{row.share:.3g}"] if row.share is not None else []),
            engineering(row.gap, "m", 3),
            f"{100.0 * row.touching:.0f} %",
            *(f"{value:.2f}" for of_building in row.values for value in of_building),
        )
        for row in table_rows(dataset)
    ]
    print("Peak displacement with contact over that without, by share of the motions that have no more\n")
    print_table(heads, rows, "r" * len(heads))
    print()
    ratios = dataset["period_ratio"].values
    failed = int(dataset.attrs["failed_runs"])
    print_pairs(
        [
            ("motions", motions_words(dataset)),
            ("ratios", f"{ratios.size} from {ratios[0]:.4g} to {ratios[-1]:.4g}"),
            ("told", told_words(dataset)),
            *([("failed", f"{failed} runs, left out of the percentiles")] if failed else []),
            ("finding", dataset.attrs["finding"]),
        ]
    )
    print_notes(json.loads(dataset.attrs.get("notes", "[]")))
    print_left_out(json.loads(dataset.attrs.get("left_out", "[]")))
    print_flags(json.loads(dataset.attrs["flags"]))
