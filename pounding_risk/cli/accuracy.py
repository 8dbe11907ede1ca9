"""The command `accuracy`: error and time of each setting of each method."""

from __future__ import annotations

import json
from math import isinf, isnan
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import (
    NONE,
    Dataset,
    Figure,
    New,
    Overrides,
    Scene,
    Select,
    chosen_scene,
    option,
)
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_pairs, print_table

ORDER = 70
HEADS = ("displacement", "force", "count", "yields", "first touch", "gap")


def accuracy(
    scene: Scene,
    out: Dataset = None,
    overrides: Overrides = NONE,
    cases: Annotated[int, option("Cases of the grid, at most; thinned evenly.", min=1)] = 24,
    budget: Annotated[float, option("Seconds a setting may take; slower ones are left out.", min=0.0)] = 20.0,
    scipy: Annotated[bool, typer.Option("--scipy/--no-scipy", help="Run SciPy's integrators too.")] = True,
    select: Select = NONE,
    new: New = False,
    figure: Figure = None,
) -> None:
    """What each digit of the answers costs in time, by method."""
    from pounding_risk.lab.accuracy import accuracy as run

    study = chosen_scene(scene, overrides, select)
    with ProgressDisplay("accuracy", "settings") as progress:
        dataset = run(study, out, cases=cases, budget=budget, scipy=scipy, new=new, progress=progress)
    print_accuracy(dataset)
    announce(out)
    draw(figure, "accuracy.accuracy_figure", dataset)


def print_accuracy(dataset: Any) -> None:
    """Print a table of settings, with time, errors, steps and energy residual, then the finding."""
    from pounding_risk.lab.accuracy_findings import OUTPUTS, beaten_at, summed_up, time_words

    steps = dataset["steps_per_contact"].values
    times = dataset["time"].sel(output="peak_relative_displacement").values
    rows = []
    for number, name in enumerate(dataset["setting"].values):
        errors = dataset["error"].values[number]
        residual = float(dataset["energy_residual"].values[number])
        rows.append(
            (
                str(name),
                time_words(times[number]),
                *(_error_words(*summed_up(errors[:, output])) for output in range(len(OUTPUTS))),
                "–" if isnan(steps[number]) else f"{steps[number]:.0f}",
                "–" if isnan(residual) else f"{residual:.0e}",
            )
        )
    heads = ("setting", "time a run", *HEADS, "steps a contact", "energy residual")
    print_table(heads, rows, "l" + "r" * (len(heads) - 1))
    worst = ", each that of its worst interface" if dataset.sizes["interface"] > 1 else ""
    print(
        f"\nErrors against the reference: median / largest over the cases{worst}; ∞: the motion blew up; –: not run.\n"
    )
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


def _error_words(median: float, largest: float) -> str:
    if isnan(median):
        return "–"
    return " / ".join("∞" if isinf(value) else "0" if value == 0.0 else f"{value:.0e}" for value in (median, largest))
