"""The command `accuracy`: error and time of each setting of each method."""

from __future__ import annotations

from typing import Annotated

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
from pounding_risk.render.terminal import print_sheet

ORDER = 70


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
    from pounding_risk.questions.accuracy import sheet

    study = chosen_scene(scene, overrides, select)
    with ProgressDisplay("accuracy", "settings") as progress:
        dataset = run(study, out, cases=cases, budget=budget, scipy=scipy, new=new, progress=progress)
    print_sheet(sheet(dataset))
    announce(out)
    draw(figure, "accuracy.accuracy_figure", dataset)
