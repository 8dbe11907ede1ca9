"""What `modes` prints: a line for each mode of each building, until the modes carry nearly all of its mass."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.options import NONE, Figure
from pounding_risk.cli._common.tables import print_table

ORDER = 110
SHOWN_SHARE = 0.99  # of the mass: modes past it are left out


def modes(
    scene: Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (TOML).", show_default=False)],
    overrides: Annotated[
        list[str],
        typer.Option(
            "--set", metavar="KEY=VALUE", help="Change a value of the scene, such as building.1.damping=0.02."
        ),
    ] = NONE,
    figure: Figure = None,
) -> None:
    """How each building vibrates: periods, participation, damping."""
    figure_file = writable("--figure", figure, FIGURES)
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.modes import modes as run

    found = run(read_scene(scene, overrides))
    heads = ("building", "mode", "period", "participation", "share of the mass", "of all so far", "damping")
    print_table(heads, [row for building in found for row in _rows(building)], "lrrrrrr")
    print(
        f"\nModes until they carry {100 * SHOWN_SHARE:.0f} % of the mass; participation of shapes whose largest "
        "displacement is 1; storeys elastic.\n"
    )
    if figure_file is not None:
        from pounding_risk.figures.modes import modes_figure

        draw(modes_figure(found), figure_file)


def _rows(building: Any) -> Iterator[tuple[str, ...]]:
    if not building.periods.size:
        yield building.name, "rigid", *"–––––"
        return
    carried = building.shares.cumsum()
    for place in range(min(int((carried < SHOWN_SHARE).sum()) + 1, carried.size)):
        yield (
            building.name if place == 0 else "",
            str(place + 1),
            f"{building.periods[place]:.4g} s",
            f"{building.participations[place]:.3f}",
            f"{100 * building.shares[place]:.1f} %",
            f"{100 * carried[place]:.1f} %",
            f"{100 * building.dampings[place]:.2f} %",
        )
