"""The command `spectra`: the gap required over the periods of two buildings, beside what rules ask for."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import NONE, Dataset, Figure, New, Overrides, Workers, option, read_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli._common.subjects import SOURCE, read_subject
from pounding_risk.cli.records import _options as options
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import print_sheet

ORDER = 125
SIDES = "left, then right"


def spectra(
    source: Annotated[
        list[str],
        typer.Argument(metavar="SOURCE...", help=SOURCE),
    ],
    out: Dataset = None,
    overrides: Overrides = NONE,
    periods: Annotated[tuple[str, str], option("Periods of the left building.", metavar="FROM TO")] = ("0.1 s", "2 s"),
    right_periods: Annotated[
        tuple[str, str] | None, option("Of the right building.", "the same", metavar="FROM TO")
    ] = None,
    num: Annotated[int, option("Periods of each building.")] = 100,
    spacing: Annotated[str, option("Of the periods: log or linear.")] = "log",
    damping: Annotated[list[str], option(f"Damping ratio of both; or twice: {SIDES}.", "the scene's, or 5 %")] = NONE,
    percentile: Annotated[
        list[str], option("Share of the motions that the gap is for; repeat for several.", "50 %, 84 %, 95 %")
    ] = NONE,
    motions: Annotated[bool, typer.Option("--motions", help="Keep the gap that each motion needs.")] = False,
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
    figure: Figure = None,
    rule: Annotated[list[str], option("Of the figure, one of the table; twice.", "srss, cqc")] = NONE,
) -> None:
    """The gap required over the periods of two buildings."""
    from pounding_risk.assessment.spectra import JUDGED, PERCENTILES, charted, read_percentiles
    from pounding_risk.assessment.spectra import spectra as run
    from pounding_risk.questions.spectra import sheet
    from pounding_risk.units import PERIOD

    ranges = {"periods": periods, "right_periods": right_periods}
    asked: dict[str, Any] = {
        name: None if ends is None else [read_option(f"--{name.replace('_', '-')}", text, PERIOD) for text in ends]
        for name, ends in ranges.items()
    }
    shares = read_percentiles(percentile or PERCENTILES, "--percentile")
    _check_rules(rule, charted())
    treatment = {
        "pga": pga, "scale": scale, "sa": sa, "processing": processing, "window": window, "direction": direction,
        "tail": tail, "unit": unit, "dt": dt,
    }  # fmt: skip
    subject = read_subject(source, overrides, treatment)
    with ProgressDisplay("spectra", "records") as progress:
        dataset = run(
            subject, out, **asked, num=num, spacing=spacing, damping=damping or None, percentiles=shares,
            motions=motions, workers=workers, new=new, progress=progress,
        )  # fmt: skip
    print_sheet(sheet(dataset))
    announce(out)
    draw(figure, "spectra.gap_spectra_figure", dataset, rules=rule or JUDGED)


def _check_rules(rules: Sequence[str], known: Sequence[str]) -> None:
    """Raise PoundingError for rules of the figure that are not two of those known."""
    from pounding_risk._common.words import nearest

    for rule in rules:
        if rule not in known:
            raise PoundingError(
                f'--rule: "{rule}" is none of the table{nearest(rule, known)}, which has {", ".join(known)}'
            )
    if rules and len(set(rules)) != 2:
        raise PoundingError("--rule: the figure shows two rules; name two, such as --rule srss --rule eurocode8")
