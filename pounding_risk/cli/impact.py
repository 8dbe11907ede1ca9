"""The command `impact`."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.notes import FASTER
from pounding_risk.cli._common.options import Figure, read_option
from pounding_risk.cli._common.tables import engineering, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.solver.pair.isolated import Impact

ORDER = 30
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


def impact(
    law: Annotated[list[str], typer.Option(help="Contact model; repeat to compare.")] = ["jankowski"],  # noqa: B006
    stiffness: Annotated[
        list[str], typer.Option(help="β in N/m^1.5 or k in N/m; one of each where laws of both kinds are compared.")
    ] = ["2.75e9 N/m^1.5"],  # noqa: B006
    mass: Annotated[str, typer.Option(help="Mass of the striker.")] = "570 kg",
    other_mass: Annotated[str, typer.Option(help="Mass that is struck; inf is a fixed wall.")] = "inf",
    speed: Annotated[str, typer.Option(help="Speed of approach.")] = "0.5 m/s",
    restitution: Annotated[
        str, typer.Option(help="Coefficient e in (0, 1], concrete, or 'xi 0.35 of jankowski'.")
    ] = "0.65",
    relation: Annotated[str, typer.Option(help="Damping from e: published, or exact.")] = "published",
    yield_force: Annotated[str, typer.Option(help="F_E, for laws with a cap; inf never yields.")] = "inf",
    floor_length: Annotated[
        str | None, typer.Option(help="Length of the striker's floor, for distributed_mass.", show_default=False)
    ] = None,
    other_floor_length: Annotated[
        str | None, typer.Option(help="Length of the floor that is struck.", show_default=False)
    ] = None,
    wave_speed: Annotated[str, typer.Option(help="Wave speed of both floors.")] = "3500 m/s",
    figure: Figure = None,
) -> None:
    """Let two bodies collide once under each contact model."""
    target = writable("--figure", figure, FIGURES)
    from pounding_risk.studies.impact import impact as run
    from pounding_risk.studies.impact import restitution_of
    from pounding_risk.units import MASS, SPEED, YIELD_FORCE

    striker = read_option("--mass", mass, MASS)
    struck = read_option("--other-mass", other_mass, MASS._replace(open_high=False))
    fast = read_option("--speed", speed, SPEED)
    strength = read_option("--yield-force", yield_force, YIELD_FORCE)
    rule = restitution_of(restitution)
    reduced = 1.0 / (1.0 / striker + 1.0 / struck)
    slabs = floors(floor_length, other_floor_length, wave_speed)
    laws, notes = contact_laws(law, stiffness, Blow(fast, reduced, rule, slabs, struck == inf), relation)
    found = [run(each, fast, striker, struck, restitution=rule, yield_force=strength) for each in laws]
    print_impacts(found, laws, 0.5 * reduced * fast**2)
    if rule.beyond(fast):
        notes.append(f"note: the approach is {FASTER}")
    for note in notes:
        typer.echo(note)
    if target is not None:
        from pounding_risk.figures import impact_figure

        draw(impact_figure(found), target)


def print_impacts(found: Sequence[Impact], laws: Sequence[Any], energy: float) -> None:
    """One line a law; ``energy`` is that of the approach [J]."""
    heads = ("law", "e asked", "e achieved", "peak force", "penetration", "duration", "energy lost")
    rows = [
        (
            each.law,
            f"{each.restitution_asked:.4f}" if law.needs_restitution else "–",
            f"{each.restitution:.4f}",
            engineering(each.peak_force, "N"),
            engineering(each.peak_penetration, "m"),
            f"{each.duration * 1e3:.4g} ms",
            _energy(each.energy_lost, energy),
        )
        for each, law in zip(found, laws, strict=True)
    ]
    print_table(heads, rows, "lrrrrrr")


def _energy(lost: float, approach: float) -> str:
    """Energy and its share; what is within the solver's tolerance of none is none."""
    lost = 0.0 if abs(lost) < 1e-6 * approach else lost
    return f"{engineering(lost, 'J')} ({100 * lost / approach:.0f} %)"


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
