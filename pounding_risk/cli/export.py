"""The command `export`: results and scenes as files of other tools."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce
from pounding_risk.cli._common.options import (
    NONE,
    Amplitude,
    Intensity,
    IntensityLevel,
    JudgedGap,
    Overrides,
    Select,
    argument,
    chosen_results,
    option,
    read_optional,
)
from pounding_risk.errors import PoundingError

ORDER = 185
SCENE = ".toml"


def export(
    source: Annotated[
        list[Path], argument("SOURCE...", "Datasets of scan or damage (.nc or .zarr); a scene (.toml) for opensees.")
    ],
    to: Annotated[
        str,
        typer.Option(
            "--to",
            help="Format: nrml, pelicun, geopackage, geoparquet, taxonomy, csv or opensees.",
            show_default=False,
        ),
    ],
    out: Annotated[Path, typer.Option("--out", "-o", help="The file or folder to write.", show_default=False)],
    of: Annotated[str | None, option("Fragilities of contact, yield or damage.", "contact")] = None,
    gap: JudgedGap = None,
    pga: Amplitude = None,
    intensity_level: IntensityLevel = None,
    intensity: Intensity = None,
    method: Annotated[
        str | None, option("Of damage: stripes, ida or cloud.", "stripes of motions at several levels, else cloud")
    ] = None,
    discrete: Annotated[bool, typer.Option("--discrete", help="Probabilities at intensities, not parameters.")] = False,
    without: Annotated[bool, typer.Option("--without", help="Damage without pounding.")] = False,
    street: Annotated[
        Path | None, option("Footprints for layers: a map, or buildings.csv of block.", "nominal places")
    ] = None,
    inventory: Annotated[Path | None, option("Inventory with GEM strings, for taxonomy.", "the scene's")] = None,
    select: Select = NONE,
    overrides: Overrides = NONE,
) -> None:
    """Write results for other tools."""
    from pounding_risk.reports.exports import export as run
    from pounding_risk.units import GAP, PGA

    written = run(
        [_source(one, select, overrides) for one in source],
        to,
        out,
        of=of,
        gap=read_optional("--gap", gap, GAP),
        pga=read_optional("--pga", pga, PGA),
        intensity_level=intensity_level,
        intensity=intensity,
        discrete=discrete,
        without=without,
        street=street,
        inventory=inventory,
        method=method,
    )
    announce(*written.files)
    for sentence in written.told:
        print(f"note: {sentence}")


def _source(source: Path, select: list[str], overrides: list[str]) -> Any:
    """The scene or the dataset that is named, with the values that were chosen."""
    if source.suffix == SCENE:
        if select:
            raise PoundingError(f"--select: is of results, and {source} is a scene; write --set")
        from pounding_risk.scene.reader import read_scene

        return read_scene(source, overrides)
    if overrides:
        raise PoundingError(f"--set: changes a value of a scene, and {source} holds results; leave it out")
    return chosen_results(source, select)
