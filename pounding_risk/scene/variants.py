"""The scenes that stand at the places along the axes of a scene: each made as `--set` with its values makes it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np

from pounding_risk.errors import SceneError
from pounding_risk.scene.axes import unlike
from pounding_risk.scene.known_motions import check_computed
from pounding_risk.scene.scene import Scene, Scenes
from pounding_risk.scene.scene_axis import SceneAxis, alone, count_of, overrides_at
from pounding_risk.scene.toml import parse_toml

NO_SAMPLES = "uncertain.samples=0"  # what `--set` takes for every uncertain number at its stated value
MOST_KEPT = 20_000  # scenes, some kB each


class Variants:
    """The scenes at the places along a scene's axes, by number: the last axis is the fastest.

    ``axes`` are those of the scene, in another order if need be.
    """

    def __init__(self, study: Scene, axes: Sequence[SceneAxis] | None = None):
        self.study, self.axes = study, tuple(study.axes if axes is None else axes)
        self.shape, self.count = tuple(axis.size for axis in self.axes), count_of(self.axes)
        self._made = Scenes(study, parse_toml(study.text, study.source), study.overrides)
        self._scenes: dict[int, Scene] = {}

    def places(self, number: int) -> tuple[int, ...]:
        """The place along each axis of a scene by its number."""
        return tuple(int(place) for place in np.unravel_index(number, self.shape))

    def overrides(self, number: int) -> tuple[str, ...]:
        """What `--set` takes for the scene of this number."""
        return overrides_at(self.axes, self.places(number))

    def scene(self, number: int) -> Scene:
        """The scene of this number; raises SceneError with the values that it has along the axes."""
        if number not in self._scenes:
            variant = self._checked(number)
            if len(self._scenes) >= MOST_KEPT:
                return variant
            # The records, which no axis changes, are kept once.
            self._scenes[number] = variant.updated(records=self.study.records)
        return self._scenes[number]

    def _checked(self, number: int) -> Scene:
        overrides = self.overrides(number)
        try:
            variant = self.made(overrides)
        except SceneError as error:
            values_text = where_words(overrides)
            raise SceneError(error.source, [f"grid, at {values_text}: {fault}" for fault in error.faults]) from None
        for fact, repair in unlike(self.study, variant):
            raise SceneError(variant.source, [f"grid, at {where_words(overrides)}: changes {fact}; {repair}"])
        return variant

    def made(self, overrides: Sequence[str]) -> Scene:
        """The scene with these values set, and no axes; changed as the study says `at_every_place`."""
        variant, change = self._made.made(overrides), self.study.at_every_place
        return variant if change is None else change(variant)

    def alone(self) -> Iterator[Scene]:
        """The scenes at places along each axis, the other keys as the scene has them."""
        return (self.made(overrides) for _, _, overrides in alone(self.axes))


def where_words(overrides: Sequence[str]) -> str:
    """The values at a place along axes in words: "building.left.period = '0.5 s'"."""
    return ", ".join(text.replace("=", " = ", 1) for text in overrides)


def check_one_scene(study: Scene, command: str) -> None:
    """Raise SceneError for a scene with axes in a command that runs one scene, with how to choose one.

    Likewise for a building whose motion is known, in a command that runs contact, as all of these do.
    """
    check_computed(study, command)
    if not study.axes:
        return
    axes_text = "; ".join(
        axis.words() if axis.dimension else f"{', '.join(axis.keys)}: {axis.words()}" for axis in study.axes
    )
    choices = (text for axis in study.axes for text in ((NO_SAMPLES,) if axis.dimension else axis.overrides(0)))
    choice = " ".join(f"--set '{text}'" for text in choices)
    sentence = f"the scene varies along {axes_text}; {command} runs one scene: choose with {choice}"
    sentence += " for the values that the scene states" * (study.uncertain is not None)
    raise SceneError(study.source, [f"grid: {sentence} (in Python with scene.replace), which is then no axis"])
