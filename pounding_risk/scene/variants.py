"""The scenes that stand at the places along the axes of a scene: each made as `--set` with its values makes it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from pounding_risk.errors import SceneError
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.scene.axes import VARIED, Placed, SceneAxis, count_of, overrides_at, shape_of_axes, without_label
from pounding_risk.scene.overrides import parts_of
from pounding_risk.scene.scene import Scene, scene_of
from pounding_risk.scene.tables import Grid
from pounding_risk.scene.toml import Fault, parse_toml
from pounding_risk.units import shown

MOST_CHECKED = 200  # places along one axis whose scene is made when the scene is read; `scan` makes all of them
IN_GRID = {
    "the gaps of the grid": "write gap = [...] in [grid] instead",
    "the yield forces of the grid": "write yield_force = [...] in [grid] instead",
    "the contact models of the grid": "write contact_model = [...] in [grid] instead",
}
ONE_SCENE = "run one scene for each"


class Variants:
    """The scenes of a scene with axes, by number: the last axis is the fastest.

    ``axes`` are those of the scene, in another order if need be.
    """

    def __init__(self, study: Scene, axes: Sequence[SceneAxis] | None = None):
        self.study, self.axes = study, tuple(study.axes if axes is None else axes)
        self.shape, self.count = shape_of_axes(self.axes), count_of(self.axes)
        raw = parse_toml(study.text, study.source)
        grid = raw.get("grid", {})
        self._tables = raw | {"grid": {key: grid[key] for key in grid if not is_axis(key, grid[key])}}
        self._asked = tuple(text for text in study.overrides if not _sets_axis(text))

    def places(self, number: int) -> tuple[int, ...]:
        """The place along each axis of a scene by its number."""
        return tuple(int(place) for place in np.unravel_index(number, self.shape))

    def overrides(self, number: int) -> tuple[str, ...]:
        """What `--set` takes for the scene of this number."""
        return overrides_at(self.axes, self.places(number))

    def scene(self, number: int) -> Scene:
        """The scene of this number; raises SceneError with the values that it has along the axes."""
        overrides = self.overrides(number)
        try:
            made = self.made(overrides)
        except SceneError as error:
            where = ", ".join(text.replace("=", " = ", 1) for text in overrides)
            raise SceneError(error.source, [f"grid, at {where}: {fault}" for fault in error.faults]) from None
        for what, repair in unlike(self.study, made):
            where = ", ".join(text.replace("=", " = ", 1) for text in overrides)
            raise SceneError(made.source, [f"grid, at {where}: changes {what}; {repair}"])
        return made

    def made(self, overrides: Sequence[str]) -> Scene:
        """The scene with these values set, and no axes."""
        return scene_of(self._tables, self.study.source, (*self._asked, *overrides), text=self.study.text)

    def alone(self) -> Iterator[tuple[SceneAxis, int, tuple[str, ...]]]:
        """Places along each axis, the other keys as the scene has them: (axis, place, what `--set` takes)."""
        for axis in self.axes:
            for place in np.unique(np.linspace(0, axis.size - 1, min(axis.size, MOST_CHECKED)).round().astype(int)):
                yield axis, int(place), axis.overrides(int(place))


def is_axis(key: str, value: Any) -> bool:
    """True for a key of [grid] that is an axis of numbers, or tells of them."""
    own = Grid.model_fields.keys() - {"axes", "zip"}
    return key not in own or (key in VARIED and isinstance(value, Mapping))


def _sets_axis(override: str) -> bool:
    parts = parts_of(override.partition("=")[0])
    return parts[:1] == ["grid"] and len(parts) > 1 and is_axis(parts[1], {} if len(parts) > 2 else None)


def axis_faults(study: Scene, placed: Sequence[Placed]) -> Iterator[Fault]:
    """A fault for each value along an axis that the scene cannot have, in the words of `--set`."""
    paths = {one.axis.name: one.path for one in placed}
    variants = Variants(study)
    for axis, place, overrides in variants.alone():
        path = (*paths[axis.name], place)
        value = ", ".join(shown(values[place]) for values in axis.values)
        try:
            made = variants.made(overrides)
        except SceneError as error:
            yield from (Fault(path, _told(fault, axis, value)) for fault in error.faults)
            continue
        changes = list(unlike(study, made))
        yield from (Fault(paths[axis.name], f"{value} changes {what}; {repair}") for what, repair in changes)
        if changes:
            return  # the other values change it as well


def _told(fault: str, axis: SceneAxis, value: str) -> str:
    """What `--set` says of a value, which it need not name."""
    sentence = without_label(fault, axis.name)
    return sentence if sentence.startswith(value) else f"{value}: {sentence}"


def unlike(study: Scene, other: Scene) -> Iterator[tuple[str, str]]:
    """What all scenes of one grid must have in common and these have not: what it is, and the repair."""
    for what, (one, another) in _common(study, other).items():
        if one != another:
            yield what, IN_GRID.get(what, ONE_SCENE)


def _common(study: Scene, other: Scene) -> dict[str, tuple[Any, Any]]:
    """What scenes of one grid have in common, of both."""
    facts = {
        "the gaps of the grid": lambda scene: scene.grid.gaps,
        "the yield forces of the grid": lambda scene: scene.grid.yield_forces,
        "the contact models of the grid": lambda scene: (scene.grid.contact_models, scene.model_names),
        "the names of the buildings": lambda scene: [building.name for building in scene.buildings],
        "which buildings are rigid, or have how many storeys": lambda scene: [
            (building.is_rigid, len(getattr(building, "masses", (0,)))) for building in scene.buildings
        ],
        "which floors meet": lambda scene: list(map(_place, scene.points)),
        "the interface whose gap varies": lambda scene: scene.gridded_interface,
        "the effects": lambda scene: [effect.name for effect in scene.effects],
        "the solver": lambda scene: scene.is_row,
    }
    return {what: (fact(study), fact(other)) for what, fact in facts.items()}


def _place(point: Point) -> tuple[Any, ...]:
    return point.interface, point.kind, point.left_floor, point.right_floor
