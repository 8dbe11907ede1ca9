"""What `accuracy` prints: a line for each setting, then the sentence, and where another method is quicker."""

from __future__ import annotations

import json
from math import isinf, isnan
from typing import Any

from pounding_risk.cli._common.tables import print_pairs, print_table

HEADS = ("displacement", "force", "count", "yields", "first touch", "gap")


def print_accuracy(dataset: Any) -> None:
    """Settings by method with time, median and worst error of each output, steps per contact, energy residual."""
    from pounding_risk.studies.accuracy_findings import OUTPUTS, beaten_at, summed_up, time_words

    times = dataset["time"].sel(output="peak_relative_displacement").values
    rows = []
    for place, name in enumerate(dataset["setting"].values):
        errors = dataset["error"].values[place]
        residual = float(dataset["energy_residual"].values[place])
        rows.append(
            (
                str(name),
                time_words(times[place]),
                *(_error_words(*summed_up(errors[:, output])) for output in range(len(OUTPUTS))),
                f"{float(dataset['steps_per_contact'].values[place]):.0f}",
                "–" if isnan(residual) else f"{residual:.0e}",
            )
        )
    heads = ("setting", "time a run", *HEADS, "steps a contact", "energy residual")
    print_table(heads, rows, "l" + "r" * (len(heads) - 1))
    print("\nErrors against the reference: median / largest over the cases; ∞: the motion blew up; –: not run.\n")
    print_pairs(
        [
            ("cases", str(dataset.sizes["case"])),
            ("reference", dataset.attrs["reference"]),
            ("compiling", f"{dataset.attrs['compile_seconds']:.3g} s, in no time above"),
            *(("left out", words) for words in json.loads(dataset.attrs["left_out"])),
            ("finding", dataset.attrs["finding"]),
            *(("quicker elsewhere", words) for words in beaten_at(dataset)),
        ]
    )


def _error_words(middle: float, worst: float) -> str:
    if isnan(middle):
        return "–"
    return " / ".join("∞" if isinf(value) else "0" if value == 0.0 else f"{value:.0e}" for value in (middle, worst))
