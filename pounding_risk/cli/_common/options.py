"""What the commands are given: options with units, files to write, contact laws by name; checked before any work."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.units import Quantity

BAD_INPUT, RUN_FAILED, INTERRUPTED = 2, 3, 130
FIGURES = (".png", ".svg", ".pdf")
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
USUAL_LAW = {"N/m": ("k", "linear"), "N/m^1.5": ("β", "jankowski")}  # the stiffness's letter, and a law that has it


class Floors(NamedTuple):
    """What two floors that collide are like."""

    length: float  # m, of the striker's; 0 where none is given
    other_length: float  # m
    wave_speed: float  # m/s, of both


class Blow(NamedTuple):
    """One collision, from which the stiffness of some laws follows."""

    speed: float  # m/s
    mass: float  # kg, reduced
    restitution: Any
    floors: Floors
    is_wall: bool  # what is struck is fixed


def read_option(option: str, text: str, quantity: Quantity) -> float:
    """The SI value of an option's text; raises PoundingError that names the option."""
    from pounding_risk.units import QuantityError, parse

    try:
        return parse(text, quantity)
    except QuantityError as error:
        raise PoundingError(f"{option}: {error}") from None


def writable(option: str, path: Path | None, suffixes: tuple[str, ...]) -> Path | None:
    """A file that can be written, or none where none is asked for; raises PoundingError that names the option."""
    if path is None:
        return None
    from pounding_risk.results.files import check_target

    if not path.name:
        raise PoundingError(f"{option}: {str(path)!r} is not the name of a file; write one that ends in {suffixes[0]}")
    try:
        return check_target(path, suffixes)
    except PoundingError as error:
        raise PoundingError(f"{option}: {error}") from None


def results_file(scene: Path, out: Path | None, new: bool = False) -> Path:
    """Where a scan goes: ``out``, or the scene's name in this folder, which is never made again unasked."""
    if out is None and Path(f"{scene.stem}.nc").exists() and not new:
        name = f"{scene.stem}.nc"
        raise PoundingError(
            f"{name} exists already; write -o {name} to make the same study again, --new to replace it whatever it "
            "is, or -o and another name"
        )
    return writable("-o", out or Path(f"{scene.stem}.nc"), (".nc", ".zarr")) or Path()


def check_folder(folder: Path) -> None:
    """A folder that is there or can be made; raises PoundingError."""
    existing = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not existing.is_dir():
        raise PoundingError(f"--out: {existing} is a file, not a folder; choose another name")
    if not os.access(existing, os.W_OK | os.X_OK):
        raise PoundingError(f"--out: the folder {existing} cannot be written to; choose another one")


def make_folder(folder: Path) -> None:
    """The folder, with those above it; raises PoundingError where it cannot be made."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise PoundingError(f"--out: {folder} cannot be made ({error.strerror}); choose another one") from None


def floors(length: str | None, other_length: str | None, wave_speed: str) -> Floors:
    """The lengths of both floors, 0 where none is given, and their wave speed; raises PoundingError for the option."""
    from pounding_risk.units import FLOOR_LENGTH, WAVE_SPEED

    texts = (("--floor-length", length), ("--other-floor-length", other_length))
    one, other = (0.0 if text is None else read_option(option, text, FLOOR_LENGTH) for option, text in texts)
    return Floors(one, other, read_option("--wave-speed", wave_speed, WAVE_SPEED))


def _colliding(name: str, kind: Any, given: Floors, is_wall: bool) -> Any:
    """A model of colliding floors; raises PoundingError where a length is missing."""
    for option, length, needed in (
        ("--floor-length", given.length, True),
        ("--other-floor-length", given.other_length, not is_wall),
    ):
        if needed and not length:
            raise PoundingError(f'{name} needs the length of the floors; write {option} "20 m"')
    return kind(given.length, given.other_length, given.wave_speed, given.wave_speed)


def contact_laws(
    names: Sequence[str], stiffnesses: Sequence[str], blow: Blow, relation: str
) -> tuple[list[Any], list[str]]:
    """The laws of these names, and a sentence for each whose stiffness is not one of those given.

    It follows from the peak force of a law that has its stiffness, in the ``blow``.
    Raises PoundingError for an unknown name, for a ``relation`` of restitution and damping that is none or that
    the laws cannot take, for a stiffness that is none, or stands twice, and for floors without a length.
    """
    from pounding_risk.models.contact.impulsive import is_instant, needs_floors
    from pounding_risk.models.contact.laws import stiffness_quantity
    from pounding_risk.models.contact.relation import misfit, related, relation_fault
    from pounding_risk.scene.scene import known_law
    from pounding_risk.solver.pair.isolated import equal_stiffness
    from pounding_risk.units import say

    classes = {name: known_law(name) for name in dict.fromkeys(names)}
    wrong = relation_fault(relation) or misfit(classes.values(), relation)
    if wrong:
        raise PoundingError(f"--relation: {wrong}")
    classes = {name: related(law, relation) for name, law in classes.items()}
    given = _stiffnesses(stiffnesses)
    laws, notes = [], []
    stiff = {name: law for name, law in classes.items() if not is_instant(law)}
    if stiff and not given:
        raise PoundingError(f'{next(iter(stiff))} needs a stiffness; write --stiffness "2.75e9 N/m^1.5"')
    for name, law in classes.items():
        if needs_floors(law):
            laws.append(_colliding(name, law, blow.floors, blow.is_wall))
            notes.append(f"{name}: e is its own, that of waves in the floors; their force has no stiffness")
            continue
        if is_instant(law):
            laws.append(law())
            notes.append(f"{name}: an instant jump, which has no force history and no stiffness")
            continue
        quantity = stiffness_quantity(law)
        if quantity.unit in given:
            laws.append(law(given[quantity.unit]))
            continue
        ((unit, value),) = given.items()
        like = next((other for other in stiff if stiffness_quantity(stiff[other]).unit == unit), USUAL_LAW[unit][1])
        laws.append(law(equal_stiffness(law, related(known_law(like), relation)(value), *blow[:3], "peak force")))
        words = f"{USUAL_LAW[quantity.unit][0]} = {say(laws[-1].stiffness, quantity)}"
        notes.append(f"{name}: {words}, which gives the peak force of {like} without yielding")
    return laws, notes


def _stiffnesses(texts: Sequence[str]) -> dict[str, float]:
    """The value in each unit of stiffness that is given."""
    from pounding_risk.models.contact.laws import HERTZ_STIFFNESS, LINEAR_STIFFNESS
    from pounding_risk.units import QuantityError, parse

    given: dict[str, float] = {}
    for text in texts:
        try:
            unit, value = LINEAR_STIFFNESS.unit, parse(text, LINEAR_STIFFNESS)
        except QuantityError:
            unit, value = HERTZ_STIFFNESS.unit, read_option("--stiffness", text, HERTZ_STIFFNESS)
        if unit in given:
            raise PoundingError(f"--stiffness: two values in {unit}; give one of each unit at most")
        given[unit] = value
    return given
