"""Sheet of `accuracy`: error and time of each setting of each method."""

from __future__ import annotations

import json

import xarray as xr

from pounding_risk.lab.accuracy_findings import OUTPUTS, beaten_at, summed_up
from pounding_risk.questions.notes import of_keys
from pounding_risk.render.sheet import (
    Block,
    Cell,
    Row,
    amount,
    computing_time,
    count,
    facts,
    joined,
    number,
    paragraph,
    table,
)

ORDER = 70
FUNCTION = "lab.accuracy"
FIGURES = {"": "accuracy.accuracy_figure"}
UNIT = "settings"
HEADS = ("displacement", "force", "count", "yields", "first touch", "gap")


def sheet(dataset: xr.Dataset) -> list[Block]:
    """The finding, time, errors, steps and energy residual of each setting, and what they are of."""
    pairs: list[tuple[str, Cell | str]] = [
        ("scene", dataset.attrs["title"]),
        ("cases", count(dataset.sizes["case"])),
        ("reference", dataset.attrs["reference"]),
        ("compiling", amount(dataset.attrs["compile_seconds"], "s", 3)),
        *(("excluded", words) for words in json.loads(dataset.attrs["left_out"])),
        *(("unused", words) for words in of_keys(dataset.attrs)),
        *(("quicker elsewhere", words) for words in beaten_at(dataset)),
    ]
    return [paragraph(dataset.attrs["finding"]), _settings(dataset), facts("", pairs)]


def _settings(dataset: xr.Dataset) -> Block:
    rows: list[Row] = []
    for setting in dataset["setting"].values:
        row = dataset.sel(setting=setting)
        time = row["time"].sel(output="peak_relative_displacement")
        errors = (summed_up(row["error"].sel(output=output).values) for output in OUTPUTS)
        ends = (joined(*(number(error, digits=2) for error in pair), names=("median", "largest")) for pair in errors)
        steps = number(row["steps_per_contact"], digits=5)
        rows.append([str(setting), computing_time(time), *ends, steps, number(row["energy_residual"], digits=2)])
    worst = ", each that of its worst interface" if dataset.sizes["interface"] > 1 else ""
    caption = (
        f"Time without compiling, and errors against the reference, median to largest over the cases{worst}. "
        "∞: the motion blew up; –: not run."
    )
    return table(caption, ("setting", "time a run", *HEADS, "steps a contact", "energy residual"), rows)
