"""What is wrong with the values along axes of a scene, in the words that `--set` has for them."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import Any

from pounding_risk.errors import SceneError
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.scene.axes import Placed, without_label
from pounding_risk.scene.scene_axis import SceneAxis, alone, has_gap
from pounding_risk.scene.toml import Fault
from pounding_risk.units import shown

RANGE = "the periods that the levels of intensity are of, which are relative to a building's"
IN_GRID = {
    "the gaps of the grid": "write gap = [...] in [grid] instead",
    "the yield forces of the grid": "write yield_force = [...] in [grid] instead",
    "the contact models of the grid": "write contact_model = [...] in [grid] instead",
    RANGE: "motions are scaled once for all cases: write them in s, or run one scene for each",
}
OF_GAPS = ("the gaps of the grid", "the interface whose gap varies")  # which follow where a gap is drawn
ONE_SCENE = "run one scene for each"
OfScene = Any  # a `Scene`, whose module imports this one


def axis_faults(study: OfScene, placed: Sequence[Placed], make: Callable[[Sequence[str]], OfScene]) -> Iterator[Fault]:
    """A fault for each value along an axis that the scene cannot have; ``make`` gives the scene with values set."""
    paths = {one.axis.name: one.path for one in placed}
    for axis, place, overrides in alone([one.axis for one in placed]):
        path = paths[axis.name] if axis.dimension else (*paths[axis.name], place)
        value = ", ".join(shown(values[place]) for values in axis.values)
        try:
            made = make(overrides)
        except SceneError as error:
            told = (f"sample {place} ({_assigned(overrides)}): {fault}" for fault in error.faults)
            told = told if axis.dimension else (_told(fault, axis, value) for fault in error.faults)
            yield from (Fault(path, sentence) for sentence in told)
            if axis.dimension:
                return
            continue
        changes = list(unlike(study, made))
        where = f"sample {place} ({_assigned(overrides)})" if axis.dimension else value
        yield from (Fault(paths[axis.name], f"{where} changes {what}; {repair}") for what, repair in changes)
        idle = [] if changes else list(_without_effect(study, made))
        yield from (Fault(paths[axis.name], f"{_idle_words(what, axis)}; remove one") for what in idle)
        if changes or idle:
            return  # the other values do the same


def _told(fault: str, axis: SceneAxis, value: str) -> str:
    """What `--set` says of a value, which it need not name."""
    sentence = without_label(fault, axis.name)
    return sentence if sentence.startswith(value) else f"{value}: {sentence}"


def _assigned(overrides: Sequence[str]) -> str:
    return ", ".join(text.replace("=", " = ", 1) for text in overrides)


def _idle_words(what: str, axis: SceneAxis) -> str:
    sentence = f"changes no case: [grid] has its own {what}"
    if what == "gap" and axis.dimension:
        return f"the uncertain gap {sentence}, and contact at any gap follows from the closing of each sample"
    return sentence


def unlike(study: OfScene, other: OfScene) -> Iterator[tuple[str, str]]:
    """What all scenes of one grid must have in common and these have not: what it is, and the repair."""
    drawn = study.uncertain is not None and has_gap(study.uncertain.keys)
    for what, (one, another) in _common(study, other).items():
        if one != another and not (drawn and what in OF_GAPS):
            yield what, IN_GRID.get(what, ONE_SCENE)


def _without_effect(study: OfScene, made: OfScene) -> Iterator[str]:
    """What the interfaces have otherwise than in the scene, and the cases of the grid have not."""
    one, other = ([between.gap for between in scene.interfaces] for scene in (study, made))
    gaps = zip(study.grid.gaps, made.grid.gaps, strict=True)
    if one != other and all(study.interface_gaps(gap) == made.interface_gaps(same) for gap, same in gaps):
        yield "gap"
    one, other = ([between.yield_force for between in scene.interfaces] for scene in (study, made))
    if one != other and len(study.grid.yield_forces) > 1:
        yield "yield_force"


def _common(study: OfScene, other: OfScene) -> dict[str, tuple[Any, Any]]:
    """What scenes of one grid have in common, of both."""
    facts = {
        OF_GAPS[0]: lambda scene: scene.grid.gaps,
        "the yield forces of the grid": lambda scene: scene.grid.yield_forces,
        "the contact models of the grid": lambda scene: (scene.grid.contact_models, scene.model_names),
        "the names of the buildings": lambda scene: [building.name for building in scene.buildings],
        "which buildings are rigid, or have how many storeys": lambda scene: [
            (building.is_rigid, len(getattr(building, "masses", (0,)))) for building in scene.buildings
        ],
        # Read once, beside the records of the scene.
        "the records of their own that buildings stand on": lambda scene: [
            building.support.records for building in scene.buildings
        ],
        "which floors meet": lambda scene: list(map(_place, scene.points)),
        OF_GAPS[1]: lambda scene: scene.gridded_interface,
        RANGE: lambda scene: scene.grid.measure,
        "the effects": lambda scene: [effect.name for effect in scene.effects],
        "the solver": lambda scene: scene.is_row,
    }
    return {what: (fact(study), fact(other)) for what, fact in facts.items()}


def _place(point: Point) -> tuple[Any, ...]:
    return point.interface, point.kind, point.left_floor, point.right_floor
