"""Checks and notes on all scenes along the axes of one, before any is run."""

from __future__ import annotations

from pounding_risk.ensemble.laws import check_reach
from pounding_risk.ensemble.limits import check_memory
from pounding_risk.ensemble.plausibility import of_input
from pounding_risk.motions.motion import Motion
from pounding_risk.scene.motions import check_arrivals
from pounding_risk.scene.scene import Scene
from pounding_risk.scene.variants import Variants


def check_scenes(variants: Variants, motions: tuple[Motion, ...], *, every: bool = True) -> None:
    """Raise SceneError for a place along the axes whose scene has faults, or cannot be run under these motions.

    Not ``every`` combination is looked at where a plan is to be told soon: then each axis alone.
    """
    scenes = map(variants.scene, range(variants.count)) if every else variants.alone()
    checked = set()  # what a response without contact depends on
    for scene in scenes:
        for place in range(len(scene.interfaces)):
            check_reach(scene.at(place), scene.grid.contact_models)
        if (scene.buildings, scene.effects) not in checked:
            check_memory(scene, motions)
            check_arrivals(scene, motions)
            checked.add((scene.buildings, scene.effects))


def notes_along(study: Scene, motions: tuple[Motion, ...]) -> tuple[str, ...]:
    """A sentence for each unusual number of a scene, of its axes, and of its motions."""
    scenes = Variants(study).alone() if study.axes else iter([study])
    drawn = () if study.uncertain is None else study.uncertain.notes()
    return tuple(dict.fromkeys([*drawn, *(note for scene in scenes for note in of_input(scene, motions))]))
