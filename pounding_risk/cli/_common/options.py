"""What the commands are given: options with units, files to write, contact laws by name; checked before any work."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.units import Quantity

NONE: list[Any] = []  # no value of an option that may be repeated
BAD_INPUT, RUN_FAILED, INTERRUPTED = 2, 3, 130
Scene = Annotated[Path, typer.Argument(metavar="SCENE", help="Scene file (TOML).", show_default=False)]
Overrides = Annotated[
    list[str],
    typer.Option("--set", metavar="KEY=VALUE", help="Change a value of the scene, such as interface.gap='20 mm'."),
]
Strict = Annotated[bool, typer.Option("--strict", help="End with status 3 where a run failed.")]
New = Annotated[bool, typer.Option("--new", help="Replace a file that holds other results.")]
Figure = Annotated[Path | None, typer.Option(help="Write a figure (.png, .svg or .pdf).", show_default=False)]
# How a gap is judged: options of `assess` and `report` alike.
JudgedGap = Annotated[str | None, typer.Option(help="The gap to judge.", show_default="the scene's")]
# A share is 84, 0.84 or "84 %" alike.
Percentile = Annotated[
    str | None,
    typer.Option(help='Share of the motions that the required gap is for, "84 %".', show_default="84 %, or by target"),
]
Confidence = Annotated[str, typer.Option(help='Of all bounds, "95 %".')]
Target = Annotated[
    str | None,
    typer.Option(
        help='Probability of contact that is accepted, "10 %".', show_default="16 %, or what the percentile leaves"
    ),
]
Intensity = Annotated[
    str | None,
    typer.Option(
        help='Of fragilities: pga, sa(left), sa(right), sa(NAME) or "sa(0.5 s)".',
        show_default="what the motions are scaled to, or pga",
    ),
]
Amplitude = Annotated[str | None, typer.Option(help="Amplitude of the grid.", show_default="the scene's or largest")]
Hazard = Annotated[
    Path | None, typer.Option(help="Hazard curve (.csv): intensity with unit, annual rate.", show_default=False)
]


def read_option(option: str, text: str, quantity: Quantity) -> float:
    """The SI value of an option's text; raises PoundingError that names the option."""
    from pounding_risk.units import QuantityError, parse

    try:
        return parse(text, quantity)
    except QuantityError as error:
        raise PoundingError(f"{option}: {error}") from None
