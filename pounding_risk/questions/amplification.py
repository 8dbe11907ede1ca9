"""Sheet of `amplification`: how pounding raises both buildings' peaks over the ratio of periods and the gap."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.assessment.amplification import (
    amplification_table,
    ratio_words,
    reference_name,
    table_rows,
    told_words,
)
from pounding_risk.assessment.spectra import motions_words
from pounding_risk.questions._declaration import FROM_TO, RANGE, Option, text_file
from pounding_risk.questions.notes import notes_of
from pounding_risk.render.sheet import Block, Cell, facts, head, number, paragraph, percent, table

if TYPE_CHECKING:
    import xarray as xr

ORDER = 126
FUNCTION = "assessment.amplification"
SUBJECT = "records"
UNIT = "runs"
FIGURES = {"": "amplification_chart.amplification_figure"}
FILES = {
    "table": text_file(
        "Write the whole table", ".csv", lambda dataset: amplification_table(dataset).to_csv(index=False)
    )
}
OPTIONS = {
    "ratios": RANGE,
    "periods": Option("--period", list[str]),
    "gaps": FROM_TO,
    "gap_shares": RANGE,
    "damping": Option(kind=list[str]),
    "percentiles": Option("--percentile"),
}
Row = list[Cell | str]


def sheet(dataset: xr.Dataset) -> list[Block]:
    """The finding, amplifications of the displacements at a few ratios and gaps, and what was run.

    Parameters
    ----------
    dataset : xarray.Dataset
        A dataset of `amplification`.

    Returns
    -------
    list of Block
    """
    return [
        paragraph(dataset.attrs["finding"]),
        _amplifications(dataset),
        _facts(dataset),
        *notes_of(dataset),
    ]


def _amplifications(dataset: xr.Dataset) -> Block:
    several, shares = dataset.sizes["fixed_period"] > 1, "gap_share" in dataset.dims
    heads = [head("beside", "s")] if several else []
    heads += [ratio_words(dataset), *([f"gap / {reference_name(dataset)}"] if shares else [])]
    heads += [head("gap", "m"), head("contact in", "%")]
    heads += [f"{name} {percent(at)}" for name in dataset["building"].values for at in dataset["percentile"].values]
    rows: list[Row] = []
    for one in table_rows(dataset):
        row: Row = [number(one["fixed_period"], "s", 3)] if several else []
        row += [number(one["period_ratio"], digits=3), *([number(one["gap_share"], digits=3)] if shares else [])]
        row += [number(one["gap"], "m", 3), number(one["contact_share"], "%", 3)]
        values = one["displacement_amplification"].transpose("building", "percentile").values.ravel()
        rows.append([*row, *(number(value, digits=3) for value in values)])
    caption = "Peak displacement with contact over that without, not exceeded by a share of the motions."
    return table(caption, heads, rows)


def _facts(dataset: xr.Dataset) -> Block:
    ratios, failed = dataset["period_ratio"].values, int(dataset.attrs["failed_runs"])
    rows = [
        ("motions", motions_words(dataset)),
        ("ratios", f"{ratios.size} from {number(ratios[0])['text']} to {number(ratios[-1])['text']}"),
        ("models", told_words(dataset)),
        *([("failed", f"{failed} runs, excluded from the percentiles")] if failed else []),
    ]
    return facts("Motions and buildings.", rows)
