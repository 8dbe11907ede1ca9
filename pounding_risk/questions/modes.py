"""Sheet of `modes`: the modes of vibration of each building, until they carry nearly all of its mass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING, Any, NamedTuple

from pounding_risk.render.sheet import Block, Row, count, listing, number, paragraph, table

if TYPE_CHECKING:
    from pounding_risk.studies.modes import Modes

ORDER = 110
FUNCTION = "studies.modes"
FIGURES = {"": "modes.modes_figure"}
SHOWN_SHARE = 0.99  # of the mass; further modes are left out
HEADS = ("building", "mode", "period [s]", "participation", "effective mass [%]", "cumulative [%]", "damping [%]")


class ModesOfScene(NamedTuple):
    """The modes of all buildings, and notes on what else the scene has."""

    buildings: tuple[Modes, ...]
    notes: tuple[str, ...]


def answer(scene: Any) -> ModesOfScene:
    """The modes of a scene with the notes on its uncertain numbers, axes, isolators, condensation and links."""
    from pounding_risk.scene.uncertain import stated
    from pounding_risk.studies.modes import modes

    isolated = [building for building in scene.buildings if getattr(building, "isolators", None)]
    notes = [
        f"{one.name}: while its isolators yield the first period is {one.isolated_period:.4g} s" for one in isolated
    ]
    notes += [
        f"{building.name}: {building.condensation.words()}"
        for building in scene.buildings
        if getattr(building, "condensation", None) is not None
    ]
    if scene.links:
        notes.append("links between buildings are left out: these are the modes of each without them")
    return ModesOfScene(modes(scene), (*notes, *stated(scene.uncertain, scene.axes)))


def drawn(answered: ModesOfScene) -> tuple[Modes, ...]:
    """The modes of each building, which the figure of modes shows."""
    return answered.buildings


def sheet(answered: ModesOfScene) -> list[Block]:
    """Periods, participation factors, effective masses and damping ratios of the slowest modes."""
    rows = [row for building in answered.buildings for row in _rows(building)]
    explained = (
        f"Modes until they carry {100 * SHOWN_SHARE:.0f} % of the mass; participation of shapes whose largest "
        "displacement is 1; storeys elastic."
    )
    return [table("Modes of each building on its own.", HEADS, rows), paragraph(explained), listing(answered.notes)]


def _rows(building: Modes) -> Iterator[Row]:
    if not building.periods.size:
        yield [building.name, "rigid", *"–––––"]
        return
    carried = building.shares.cumsum()
    for place in range(min(int((carried < SHOWN_SHARE).sum()) + 1, carried.size)):
        row: Row = [building.name if place == 0 else "", count(place + 1), number(building.periods[place], "s")]
        shares = (building.shares[place], carried[place], building.dampings[place])
        yield [*row, number(building.participations[place], digits=3), *(number(one, "%", 3) for one in shares)]
