"""What `effects` prints: a line for each combination, with what it changes and what it costs, then the sentence."""

from __future__ import annotations

import json
from typing import Any

from pounding_risk.cli._common.tables import print_pairs, print_table

HEADS = {
    "peak_relative_displacement": "displacement",
    "peak_contact_force": "force",
    "impact_count": "count",
    "impulse": "impulse",
    "peak_storey_shear": "shear",
    "peak_floor_acceleration": "acceleration",
}


def print_effects(dataset: Any) -> None:
    """Combinations by line: time, cases changed, smallest and largest change of each output, largest set."""
    from pounding_risk.studies.accuracy_findings import time_words
    from pounding_risk.studies.effects import NONE, rows, yielding

    lines = []
    for name, changed, time, ratio, spread in rows(dataset):
        widest = float(dataset["permanent_set"].sel(effects=name).max())
        words = ["–"] * len(HEADS) if name == NONE else [_change(spread[output]) for output in HEADS]
        lines.append((name, time_words(time), f"{ratio:.2f}", str(changed), *words, f"{widest * 1e3:.3g} mm"))
    heads = ("effects", "time a run", "ratio", "cases changed", *HEADS.values(), "largest set")
    print_table(heads, lines, "l" + "r" * (len(heads) - 1))
    wide = ", of all cases where the ground or a building is changed" if dataset["acts_on_all"].any() else ""
    print(f"\nChange against the scene without effects: median (smallest to largest) of the cases that yield{wide}.\n")
    options = {
        name: ", ".join(f"{key} {value}" for key, value in given.items()) or "no options"
        for name, given in json.loads(dataset.attrs["effects"]).items()
    }
    cases = str(dataset["status"].sel(effects=NONE).size)
    failed = int((dataset["status"] != 0).sum())
    print_pairs(
        [
            ("cases", f"{cases}, {yielding(dataset)} yield" + (f"; {failed} runs failed" if failed else "")),
            *options.items(),
            *([("left out", dataset.attrs["left_out"])] if dataset.attrs["left_out"] else []),
            ("finding", dataset.attrs["finding"]),
        ]
    )


def _change(spread: tuple[float, float, float]) -> str:
    from pounding_risk.studies.effects import percent

    low, middle, high = spread
    if low == high == 0.0:
        return "none"
    return f"{percent(middle)} ({percent(low)} to {percent(high)})"
