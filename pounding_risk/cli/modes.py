"""The command `modes`: the modes of vibration of each building, until they carry nearly all of its mass."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import draw
from pounding_risk.cli._common.notes import print_notes
from pounding_risk.cli._common.options import NONE, Figure, Scene
from pounding_risk.render.terminal import print_table

ORDER = 110
SHOWN_SHARE = 0.99  # of the mass; further modes are left out


def modes(
    scene: Scene,
    overrides: Annotated[
        list[str],
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Change a value of the scene, such as building.1.damping=0.02."
        ),
    ] = NONE,
    figure: Figure = None,
) -> None:
    """How each building vibrates: periods, participation, damping."""
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.scene.uncertain import stated
    from pounding_risk.studies.modes import modes as run

    study = read_scene(scene, overrides)
    buildings = run(study)
    heads = ("building", "mode", "period", "participation", "share of the mass", "of all so far", "damping")
    print_table(heads, [row for building in buildings for row in _rows(building)], "lrrrrrr")
    print(
        f"\nModes until they carry {100 * SHOWN_SHARE:.0f} % of the mass; participation of shapes whose largest "
        "displacement is 1; storeys elastic.\n"
    )
    print_notes(stated(study.uncertain))
    draw(figure, "modes.modes_figure", buildings)


def _rows(building: Any) -> Iterator[tuple[str, ...]]:
    """Cells of each mode of a building that is shown."""
    if not building.periods.size:
        yield building.name, "rigid", *"–––––"
        return
    carried = building.shares.cumsum()
    for number in range(min(int((carried < SHOWN_SHARE).sum()) + 1, carried.size)):
        yield (
            building.name if number == 0 else "",
            str(number + 1),
            f"{building.periods[number]:.4g} s",
            f"{building.participations[number]:.3f}",
            f"{100 * building.shares[number]:.1f} %",
            f"{100 * carried[number]:.1f} %",
            f"{100 * building.dampings[number]:.2f} %",
        )
