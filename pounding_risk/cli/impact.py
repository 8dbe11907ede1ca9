"""The command `impact`: one collision of two bodies under each contact model."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import TYPE_CHECKING, Annotated, Any, NamedTuple

from pounding_risk.cli._common.files import draw
from pounding_risk.cli._common.options import Figure, option, read_option, read_optional
from pounding_risk.errors import PoundingError
from pounding_risk.questions.notes import FASTER
from pounding_risk.render.terminal import engineering, print_notes, print_table
from pounding_risk.units import FLOOR_LENGTH, MASS, SPEED, WAVE_SPEED, YIELD_FORCE, QuantityError, parse, say

if TYPE_CHECKING:
    from pounding_risk.solver.pair.isolated import Impact

ORDER = 30
# Of each unit of stiffness: its letter, and a law that takes it.
USUAL_LAW = {"N/m": ("k", "linear"), "N/m^1.5": ("β", "jankowski")}


class Collision(NamedTuple):
    """A collision, from which the stiffness of some laws follows."""

    speed: float  # m/s
    mass: float  # kg, reduced
    restitution: Any
    floor_lengths: tuple[float, float]  # m, of the striker's and of that which is struck; 0 where none is given
    wave_speed: float  # m/s, of both floors
    is_wall: bool  # the body that is struck is fixed
    table: Any = None  # of tabulated forces


def impact(
    law: Annotated[list[str], option("Contact model; repeat to compare.")] = ["jankowski"],  # noqa: B006
    stiffness: Annotated[
        list[str], option("β in N/m^1.5 or k in N/m; one of each where laws of both kinds are compared.")
    ] = ["2.75e9 N/m^1.5"],  # noqa: B006
    mass: Annotated[str, option("Mass of the striker.")] = "570 kg",
    other_mass: Annotated[str, option("Mass that is struck; inf is a fixed wall.")] = "inf",
    speed: Annotated[str, option("Speed of approach.")] = "0.5 m/s",
    restitution: Annotated[str, option("Coefficient e in (0, 1], concrete, or 'xi 0.35 of jankowski'.")] = "0.65",
    relation: Annotated[str, option("Damping from e: published, or exact.")] = "published",
    yield_force: Annotated[str, option("F_E, for laws with a cap; inf never yields.")] = "inf",
    table: Annotated[str | None, option("CSV file of force against penetration, for tabulated.")] = None,
    unloading_stiffness: Annotated[str | None, option("Slope of the way back, for a table without one.")] = None,
    floor_length: Annotated[str | None, option("Length of the striker's floor, for distributed_mass.")] = None,
    other_floor_length: Annotated[str | None, option("Length of the floor that is struck.")] = None,
    wave_speed: Annotated[str, option("Wave speed of both floors.")] = "3500 m/s",
    figure: Figure = None,
) -> None:
    """Let two bodies collide once under each contact model."""
    from pounding_risk.studies.impact import impact as run
    from pounding_risk.studies.impact import restitution_of

    masses = read_option("--mass", mass, MASS), read_option("--other-mass", other_mass, MASS._replace(open_high=False))
    approach = read_option("--speed", speed, SPEED)
    capacity = read_option("--yield-force", yield_force, YIELD_FORCE)
    rule = restitution_of(restitution)
    reduced_mass = 1.0 / (1.0 / masses[0] + 1.0 / masses[1])
    lengths = (("--floor-length", floor_length), ("--other-floor-length", other_floor_length))
    length, other_length = (read_optional(option, text, FLOOR_LENGTH) or 0.0 for option, text in lengths)
    waves, is_wall = read_option("--wave-speed", wave_speed, WAVE_SPEED), masses[1] == inf
    force_table = _table(table, unloading_stiffness)
    collision = Collision(approach, reduced_mass, rule, (length, other_length), waves, is_wall, force_table)
    laws, notes = contact_laws(law, stiffness, collision, relation)
    impacts = [run(contact, approach, *masses, restitution=rule, yield_force=capacity) for contact in laws]
    print_impacts(impacts, laws, 0.5 * reduced_mass * approach**2)
    if rule.beyond(approach):
        notes.append(f"note: the approach is {FASTER}")
    for note in notes:
        print(note)
    print_notes(f"{outcome.law}: {words}" for outcome in impacts if (words := outcome.beyond_table()))
    draw(figure, "simulate.impact_figure", impacts)


def print_impacts(impacts: Sequence[Impact], laws: Sequence[Any], energy: float) -> None:
    """Print a line for each law; ``energy`` is that of the approach [J]."""
    heads = ("law", "e requested", "e achieved", "peak force", "penetration", "duration", "energy lost")
    rows = [
        (
            outcome.law,
            f"{outcome.restitution_asked:.4f}" if law.needs_restitution else "–",
            f"{outcome.restitution:.4f}",
            engineering(outcome.peak_force, "N"),
            engineering(outcome.peak_penetration, "m"),
            f"{outcome.duration * 1e3:.4g} ms",
            _energy_words(outcome.energy_lost, energy),
        )
        for outcome, law in zip(impacts, laws, strict=True)
    ]
    print_table(heads, rows, "lrrrrrr")


def _energy_words(lost_energy: float, approach_energy: float) -> str:
    """The energy lost and its share of that of the approach; a loss within the solver's tolerance is zero."""
    lost_energy = 0.0 if abs(lost_energy) < 1e-6 * approach_energy else lost_energy
    return f"{engineering(lost_energy, 'J')} ({100 * lost_energy / approach_energy:.0f} %)"


def contact_laws(
    names: Sequence[str], stiffnesses: Sequence[str], collision: Collision, relation: str
) -> tuple[list[Any], list[str]]:
    """The laws of these names, and a sentence for each whose stiffness is not one of those given.

    Such a stiffness gives, in the ``collision``, the peak force of a law whose stiffness is given.
    Raises PoundingError for an unknown name, for a ``relation`` of restitution and damping that is unknown or that
    the laws cannot take, for a stiffness that cannot be read or is given twice, and for floors without a length.
    """
    from pounding_risk.models.contact.impulsive import is_instant, needs_floors
    from pounding_risk.models.contact.laws import stiffness_quantity
    from pounding_risk.models.contact.relation import misfit, related, relation_fault
    from pounding_risk.models.contact.table import TABULATED
    from pounding_risk.scene.interfaces import known_law
    from pounding_risk.solver.pair.isolated import equal_stiffness

    classes = {name: known_law(name) for name in dict.fromkeys(names)}
    fault = relation_fault(relation) or misfit(classes.values(), relation)
    if fault:
        raise PoundingError(f"--relation: {fault}")
    classes = {name: related(law, relation) for name, law in classes.items()}
    stiffness_values = _stiffnesses(stiffnesses)
    with_stiffness = {name: law for name, law in classes.items() if not is_instant(law) and name != TABULATED}
    if with_stiffness and not stiffness_values:
        raise PoundingError(f'{next(iter(with_stiffness))} needs a stiffness; write --stiffness "2.75e9 N/m^1.5"')
    laws, notes = [], []
    for name, law in classes.items():
        if needs_floors(law):
            laws.append(_floor_law(name, law, collision))
            notes.append(f"{name}: e is its own, that of waves in the floors; their force has no stiffness")
        elif name == TABULATED:
            if collision.table is None:
                raise PoundingError('tabulated needs its forces; write --table "bumper.csv"')
            laws.append(law(collision.table.stiffness, collision.table))
            notes.append(f"{name}: {collision.table.words()}")
        elif is_instant(law):
            laws.append(law())
            notes.append(f"{name}: an instant jump, which has no force history and no stiffness")
        elif (quantity := stiffness_quantity(law)).unit in stiffness_values:
            laws.append(law(stiffness_values[quantity.unit]))
        else:
            ((unit, stiffness),) = stiffness_values.items()
            alike = (other for other in with_stiffness if stiffness_quantity(with_stiffness[other]).unit == unit)
            reference = next(alike, USUAL_LAW[unit][1])
            reference_law = related(known_law(reference), relation)(stiffness)
            laws.append(law(equal_stiffness(law, reference_law, *collision[:3], "peak force")))
            words = f"{USUAL_LAW[quantity.unit][0]} = {say(laws[-1].stiffness, quantity)}"
            notes.append(f"{name}: {words}, which gives the peak force of {reference} without yielding")
    return laws, notes


def _floor_law(name: str, law: Any, collision: Collision) -> Any:
    """A model of colliding floors; raises PoundingError where a length is missing."""
    length, other_length = collision.floor_lengths
    if not length or not (other_length or collision.is_wall):
        missing = "--other-floor-length" if length else "--floor-length"
        raise PoundingError(f'{name} needs the length of the floors; write {missing} "20 m"')
    return law(length, other_length, collision.wave_speed, collision.wave_speed)


def _table(path: str | None, unloading_stiffness: str | None) -> Any:
    """The table of a file; None without one."""
    from pounding_risk.models.contact.table_file import read_table

    if path is None and unloading_stiffness is not None:
        raise PoundingError('--unloading-stiffness is that of a table; write --table "bumper.csv" too')
    return None if path is None else read_table(path, unloading_stiffness)


def _stiffnesses(texts: Sequence[str]) -> dict[str, float]:
    """The stiffness given in each unit; raises PoundingError where two have one unit."""
    from pounding_risk.models.contact.laws import HERTZ_STIFFNESS, LINEAR_STIFFNESS

    stiffnesses: dict[str, float] = {}
    for text in texts:
        try:
            unit, stiffness = LINEAR_STIFFNESS.unit, parse(text, LINEAR_STIFFNESS)
        except QuantityError:
            unit, stiffness = HERTZ_STIFFNESS.unit, read_option("--stiffness", text, HERTZ_STIFFNESS)
        if unit in stiffnesses:
            raise PoundingError(f"--stiffness: two values in {unit}; give one of each unit at most")
        stiffnesses[unit] = stiffness
    return stiffnesses
