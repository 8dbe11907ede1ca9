"""The command `effects`: what each effect changes in a scene, and its cost."""

from __future__ import annotations

import json
from typing import Any

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import NONE, Dataset, Figure, New, Overrides, Scene, Select, chosen_scene
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_pairs, print_table

ORDER = 80
HEADS = {
    "peak_relative_displacement": "displacement",
    "peak_contact_force": "force",
    "impact_count": "count",
    "impulse": "impulse",
    "peak_storey_shear": "shear",
    "peak_floor_acceleration": "acceleration",
}


def effects(
    scene: Scene,
    out: Dataset = None,
    overrides: Overrides = NONE,
    select: Select = NONE,
    new: New = False,
    figure: Figure = None,
) -> None:
    """What each effect changes in a scene, and what it costs."""
    from pounding_risk.lab.effects import effects as run

    study = chosen_scene(scene, overrides, select)
    with ProgressDisplay("effects", "scans") as progress:
        dataset = run(study, out, new=new, progress=progress)
    print_effects(dataset)
    announce(out)
    draw(figure, "effects.effects_figure", dataset)


def print_effects(dataset: Any) -> None:
    """Print a table of combinations of effects, with time, changes of the outputs and largest set, then the finding."""
    from pounding_risk.lab.accuracy_findings import time_words
    from pounding_risk.lab.effects_findings import NONE as NO_EFFECTS
    from pounding_risk.lab.effects_findings import rows, yielding

    lines = []
    for name, changed, time, ratio, spread in rows(dataset):
        largest_set = float(dataset["permanent_set"].sel(effects=name).max())
        changes = ["–"] * len(HEADS) if name == NO_EFFECTS else [_change_words(spread[output]) for output in HEADS]
        lines.append((name, time_words(time), f"{ratio:.2f}", str(changed), *changes, f"{largest_set * 1e3:.3g} mm"))
    heads = ("effects", "time a run", "ratio", "cases changed", *HEADS.values(), "largest set")
    print_table(heads, lines, "l" + "r" * (len(heads) - 1))
    wide = ", of all cases where the ground or a building is changed" if dataset["acts_on_all"].any() else ""
    print(f"\nChange against the scene without effects: median (smallest to largest) of the cases that yield{wide}.\n")
    options = {
        name: ", ".join(f"{key} {value}" for key, value in values.items()) or "no options"
        for name, values in json.loads(dataset.attrs["effects"]).items()
    }
    cases = str(dataset["status"].sel(effects=NO_EFFECTS).size)
    n_failed = int((dataset["status"] != 0).sum())
    print_pairs(
        [
            ("cases", f"{cases}, {yielding(dataset)} yield" + (f"; {n_failed} runs failed" if n_failed else "")),
            *options.items(),
            *([("left out", dataset.attrs["left_out"])] if dataset.attrs["left_out"] else []),
            ("finding", dataset.attrs["finding"]),
        ]
    )


def _change_words(spread: tuple[float, float, float]) -> str:
    from pounding_risk.lab.effects_findings import percent

    low, median, high = spread
    return "none" if low == high == 0.0 else f"{percent(median)} ({percent(low)} to {percent(high)})"
