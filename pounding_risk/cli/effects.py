"""The command `effects`: what each effect changes in a scene, and its cost."""

from __future__ import annotations

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.options import NONE, Dataset, Figure, New, Overrides, Scene, Select, chosen_scene
from pounding_risk.cli._common.progress import ProgressDisplay
from pounding_risk.render.terminal import print_sheet

ORDER = 80


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
    from pounding_risk.questions.effects import sheet

    study = chosen_scene(scene, overrides, select)
    with ProgressDisplay("effects", "scans") as progress:
        dataset = run(study, out, new=new, progress=progress)
    print_sheet(sheet(dataset))
    announce(out)
    draw(figure, "effects.effects_figure", dataset)
