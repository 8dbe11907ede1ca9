"""Sheet of `spectra`: the gap required over the periods of two buildings, beside what rules require."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from pounding_risk._common.words import nearest
from pounding_risk.assessment.spectra import charted, motions_words, shortfalls, table_rows, usual_percentile
from pounding_risk.errors import PoundingError
from pounding_risk.questions._declaration import FROM_TO, Option
from pounding_risk.questions.notes import notes_of
from pounding_risk.render.sheet import Block, Cell, amount, facts, head, number, paragraph, percent, table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 125
FUNCTION = "assessment.spectra"
SUBJECT = "records"
UNIT = "records"
FIGURES = {"": "spectra.gap_spectra_figure"}
OPTIONS = {
    "periods": FROM_TO,
    "right_periods": FROM_TO,
    "damping": Option(kind=list[str]),
    "percentiles": Option("--percentile"),
    "rules": Option("--rule", list[str], help="Of the figure, a rule of the table; twice. By default srss and cqc."),
}
Row = list[Cell | str]
SIDES = ("left", "right")


def sheet(dataset: xr.Dataset) -> list[Block]:
    """The finding, required gaps at a few pairs of periods, every rule beside them, and what was run.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `spectra`.

    Returns
    -------
    list of Block
    """
    return [
        paragraph(dataset.attrs["finding"]),
        _gaps(dataset),
        _rules(dataset),
        _facts(dataset),
        *notes_of(dataset),
    ]


def check(given: Mapping[str, Any]) -> None:
    """Raise PoundingError for rules of the figure that are not two of those of the table."""
    rules, known = given.get("rules", ()), charted()
    for rule in rules:
        if rule not in known:
            words = f'"{rule}" is none of the table{nearest(rule, known)}, which has {", ".join(known)}'
            raise PoundingError(f"rules: {words}")
    if rules and len(set(rules)) != 2:
        raise PoundingError("rules: the figure shows two rules; name two, such as --rule srss --rule eurocode8")


def _gaps(dataset: xr.Dataset) -> Block:
    of = [percent(value) for value in dataset["percentile"].values]
    heads = [*(head(side, "s") for side in SIDES), *(head(words, "m") for words in (*of, "ABS", "SRSS", "DDC"))]
    rows: list[Row] = [
        [*(number(period, "s", 3) for period in row.periods), *(number(gap, "m", 3) for gap in (*row.gaps, *row.rules))]
        for row in table_rows(dataset)
    ]
    at = percent(usual_percentile(dataset))
    caption = f"Gap required by a share of the motions; ABS, SRSS and DDC of spectral displacements at {at}."
    return table(caption, heads, rows)


def _rules(dataset: xr.Dataset) -> Block:
    heads = ["rule", "text", head("insufficient at", "%"), "median", "largest"]
    heads += [*(head(f"at {side}", "s") for side in SIDES), "definition"]
    rows: list[Row] = []
    for short in shortfalls(dataset):
        rule = dataset.sel(rule=short.rule)
        row: Row = [short.rule, str(rule["rule_verification"].item()), number(short.pairs, "%", 3)]
        row += [*(number(ratio, digits=3) for ratio in (short.median, short.ratio))]
        rows.append([*row, *(number(period, "s", 2) for period in short.periods), str(rule["rule_title"].item())])
    at = percent(usual_percentile(dataset))
    caption = (
        f"Gap that {at} of the motions require over that of each rule, at all pairs of periods: the share of the pairs "
        "at which the rule is insufficient, and the median and the largest ratio, with its periods."
    )
    return table(caption, heads, rows)


def _facts(dataset: xr.Dataset) -> Block:
    ranges = (dataset[f"{side}_period"].values for side in SIDES)
    periods = [f"{one.size} from {amount(one[0], 's')['text']} to {amount(one[-1], 's')['text']}" for one in ranges]
    dampings = [amount(dataset[f"{side}_damping"], "%")["text"] for side in SIDES]
    rows = [
        ("motions", motions_words(dataset)),
        ("periods", " × ".join(periods)),
        ("damping", " beside ".join(dampings)),
        ("models", "single masses on one ground, linear, without contact"),
        ("percentiles", "of the sample, without bounds"),
        ("rules", "with linear displacements (factors 1) and floors at different levels; none that needs heights"),
    ]
    return facts("Motions, buildings and rules.", rows)
