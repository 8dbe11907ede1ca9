"""The command `draw`: pictures of a row from its dataset."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from pounding_risk.cli._common.files import FIGURES, announce
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    IntensityLevel,
    Select,
    argument,
    chosen_results,
    file_option,
    option,
    read_optional,
)
from pounding_risk.errors import PoundingError

ORDER = 200


def draw(
    results: Annotated[list[Path], argument("RESULTS...", "What scan wrote (.nc or .zarr).")],
    elevation: Annotated[Path | None, file_option("The row in elevation", FIGURES)] = None,
    plan: Annotated[Path | None, file_option("The street in plan", FIGURES)] = None,
    profiles: Annotated[Path | None, file_option("Storeys", FIGURES)] = None,
    animation: Annotated[Path | None, file_option("One run with its histories, moving", (".html",))] = None,
    figure: Annotated[list[str], option("Another figure, NAME=FILE; repeat for several.", "none")] = NONE,
    street: Annotated[
        Path | None, option("Footprints for the plan: a map, or buildings.csv of block.", "plain rectangles")
    ] = None,
    building: Annotated[list[str], option("Of the profiles; repeat for several.", "those raised most")] = NONE,
    gap: Annotated[str | None, option("Gap, the grid's nearest.", "the scene's")] = None,
    contact_model: Annotated[str | None, option("Of the grid.", "the scene's")] = None,
    yield_force: Annotated[str | None, option("F_E of the grid.", "the scene's")] = None,
    pga: Amplitude = None,
    intensity_level: IntensityLevel = None,
    select: Select = NONE,
) -> None:
    """Draw a row: elevation, plan, storeys, animation."""
    from pounding_risk.reports.drawings import draw as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    unnamed = [one for one in figure if "=" not in one]
    if unnamed:
        raise PoundingError(f'--figure: "{unnamed[0]}" is not a name and a file; write one such as ratio=ratio.png')
    files = run(
        [chosen_results(one, select, partly=bool(figure)) for one in results],
        elevation=elevation,
        plan=plan,
        profiles=profiles,
        animation=animation,
        figure=dict(one.split("=", 1) for one in figure),
        street=street,
        building=building,
        gap=read_optional("--gap", gap, GAP),
        contact_model=contact_model,
        yield_force=read_optional("--yield-force", yield_force, YIELD_FORCE),
        pga=read_optional("--pga", pga, PGA),
        intensity_level=intensity_level,
    )
    announce(*files)
