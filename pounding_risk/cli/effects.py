"""What `effects` prints: a line for each combination, with what it changes and what it costs, then the sentence."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.options import NONE, Figure, New, Overrides, Scene
from pounding_risk.cli._common.progress import Watch
from pounding_risk.cli._common.tables import print_pairs, print_table

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
    out: Annotated[
        Path | None, typer.Option("--out", "-o", help="Write the dataset (.nc).", show_default=False)
    ] = None,
    overrides: Overrides = NONE,
    new: New = False,
    figure: Figure = None,
) -> None:
    """What each effect changes in a scene, and what it costs."""
    out_file, figure_file = writable("-o", out, (".nc",)), writable("--figure", figure, FIGURES)
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.effects import effects as run

    study = read_scene(scene, overrides)
    with Watch("effects", "scans") as watch:
        dataset = run(study, out_file, new=new, progress=watch)
    print_effects(dataset)
    if out_file is not None:
        typer.echo(f"written: {out_file}")
    if figure_file is not None:
        from pounding_risk.figures import effects_figure

        draw(effects_figure(dataset), figure_file)


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
