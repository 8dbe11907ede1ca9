"""The command `spectra`: the gap required over the periods of two buildings, beside what rules ask for."""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.notes import print_flags, print_left_out
from pounding_risk.cli._common.options import NONE, Dataset, Figure, New, Overrides, Workers, option, read_option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.cli._common.subjects import SOURCE, read_subject
from pounding_risk.cli.records import _options as options
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, print_pairs, print_table

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
    print_spectra(dataset)
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


def print_spectra(dataset: Any) -> None:
    """Print the gap required at a few pairs of periods, how each rule compares with it at all, then the finding."""
    from pounding_risk.assessment.spectra import motions_words, table_rows, usual_percentile

    at = usual_percentile(dataset)
    heads = ("left", "right", *(f"{value:g} %" for value in dataset["percentile"].values), "ABS", "SRSS", "DDC")
    rows = [
        (*(f"{period:.3g} s" for period in row.periods), *(engineering(gap, "m", 3) for gap in (*row.gaps, *row.rules)))
        for row in table_rows(dataset)
    ]
    print(f"Gap required by a share of the motions; ABS, SRSS and DDC of spectral displacements at {at:g} %\n")
    print_table(heads, rows, "r" * len(heads))
    print(f"\nGap that {at:g} % of the motions need, over what a rule asks for, at all pairs of periods\n")
    _print_rules(dataset)
    print()
    ranges = (dataset[f"{side}_period"].values for side in ("left", "right"))
    words = [f"{values.size} from {values[0]:.4g} s to {values[-1]:.4g} s" for values in ranges]
    dampings = [f"{100.0 * float(dataset[f'{side}_damping']):.4g} %" for side in ("left", "right")]
    print_pairs(
        [
            ("motions", motions_words(dataset)),
            ("periods", " × ".join(words)),
            ("damping", " beside ".join(dampings)),
            ("told", "single masses on one ground, linear, without contact; percentiles of the sample, without bounds"),
            ("rules", "take linear displacements (factors 1) and floors at different levels; none that needs heights"),
            ("finding", dataset.attrs["finding"]),
        ]
    )
    print_left_out(json.loads(dataset.attrs.get("left_out", "[]")))
    print_flags(json.loads(dataset.attrs["flags"]))


def _print_rules(dataset: Any) -> None:
    """Print at how many pairs of periods each rule asks for less than the gap, and the largest ratio with its place."""
    from pounding_risk.assessment.spectra import shortfalls

    rows = [
        (
            short.rule,
            str(dataset["rule_verification"].sel(rule=short.rule).item()),
            f"{100.0 * short.pairs:.0f} %",
            f"{short.median:.2f}",
            f"{short.ratio:.2f}",
            " beside ".join(f"{period:.2g} s" for period in short.periods),
            str(dataset["rule_title"].sel(rule=short.rule).item()),
        )
        for short in shortfalls(dataset)
    ]
    print_table(("rule", "text", "falls short at", "median", "largest", "there", "what it is"), rows, "llrrrll")
