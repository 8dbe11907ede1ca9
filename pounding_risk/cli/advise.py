"""The command `advise`: what to write for the contact of a scene, and which outputs depend on it."""

from __future__ import annotations

from typing import Annotated

from pounding_risk.cli._common.files import draw
from pounding_risk.cli._common.options import NONE, Figure, Overrides, Scene, option
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_sheet

ORDER = 65


def advise(
    scene: Scene,
    overrides: Overrides = NONE,
    gap: Annotated[str | None, option("The gap.", "the scene's")] = None,
    floor_length: Annotated[str, option("Length of the floors of buildings that give none.")] = "20 m",
    figure: Figure = None,
) -> None:
    """What to write for the contact, and what depends on it."""
    from pounding_risk.cli._common.options import read_option, read_optional
    from pounding_risk.questions.advise import sheet
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.advice import advise as run
    from pounding_risk.units import FLOOR_LENGTH, GAP

    length = read_option("--floor-length", floor_length, FLOOR_LENGTH)
    clear = read_optional("--gap", gap, GAP)
    study = read_scene(scene, overrides)
    with ProgressDisplay("advise", "scans") as progress:
        advice = run(study, gap=clear, floor_length=length, progress=progress)
    print_sheet(sheet(advice))
    draw(figure, "advice.advice_figure", advice)
