"""One collision alone: two masses without springs, solved by the kernels of a pair."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from itertools import islice
from math import inf, isnan, log10, nan
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import needs_floors
from pounding_risk.models.contact.relation import name_of, out_of_reach
from pounding_risk.models.contact.table import beyond_end
from pounding_risk.models.effects import bare
from pounding_risk.models.ground import UniformGround
from pounding_risk.models.restitution import Restitution
from pounding_risk.models.structures.sdof import free_mass
from pounding_risk.solver.counters import AT_END, CONTACT_COLUMNS, FINISHED, STATUS_SENTENCES, make_log
from pounding_risk.solver.pair.equations import Limits
from pounding_risk.solver.pair.flight import Free
from pounding_risk.solver.pair.laws import by_address
from pounding_risk.solver.pair.run import begin_contact
from pounding_risk.solver.workspace import BEGIN, SIGNALS, make_workspace
from pounding_risk.units import GAP, TIME, YIELD_FORCE, say

NEVER = 1e9  # s; an isolated contact that lasts this long does not part
ROWS = 100_000
SOFTEST, STIFFEST = 1e2, 1e16  # N/m or N/m^1.5, of what equal terms may lead to
RTOL = 1e-12  # of an impact by which a stiffness is found


@dataclass(frozen=True, repr=False)
class Impact(ShortRepr):
    """Result of one collision; arrays have one value per step, from the touch to the parting.

    Of floors that collide as bars they have the corners of the force's steps; the masses' speeds jump at the touch.
    """

    law: str
    mass: float  # kg, of the striker
    time: NDArray[np.float64]  # s
    penetration: NDArray[np.float64]  # m
    rate: NDArray[np.float64]  # m/s
    force: NDArray[np.float64]  # N
    approach_speed: float  # m/s
    rebound_speed: float  # m/s
    restitution_asked: float  # NaN of a law that takes none
    restitution: float  # achieved: rebound speed over approach speed
    peak_force: float  # N; NaN for an instant jump, which has no finite force
    peak_penetration: float  # m
    duration: float  # s
    impulse: float  # N s
    energy_lost: float  # J, of the contact force's work
    momentum_change: float  # kg m/s over the total momentum exchanged; 0 in theory, NaN against a wall
    table_end: float = inf  # m, penetration of the last point of a tabulated law

    def facts(self) -> Iterable[tuple[str, str]]:
        """Speeds, restitution and peaks of the collision."""
        yield "contact model", self.law
        yield "approach", f"{self.approach_speed:.4g} m/s, rebound {self.rebound_speed:.4g} m/s"
        asked_words = "" if isnan(self.restitution_asked) else f", {self.restitution_asked:.4g} asked for"
        yield "restitution", f"{self.restitution:.4g}{asked_words}"
        yield "peak force", "none that is finite" if isnan(self.peak_force) else say(self.peak_force, YIELD_FORCE)
        yield "penetration", say(self.peak_penetration, GAP)
        yield "duration", say(self.duration, TIME)
        if words := self.beyond_table():
            yield "note", words

    def beyond_table(self) -> str:
        """A sentence where the penetration passes the end of the law's table; "" elsewhere."""
        return beyond_end(self.peak_penetration, self.table_end)


def collide(law: Any, rule: Restitution, speed: float, values: tuple[float, float, float, float]) -> Impact:
    """Let a mass strike another at ``speed`` [m/s], from the touch to the parting.

    Parameters
    ----------
    law : contact law
        With its parameters, and damping as it stands.
    rule : Restitution
        e(v).
    speed : float
        Speed of approach [m/s].
    values : (mass, other mass, yield force, rtol)
        [kg], [kg] (inf: a fixed wall), [N], relative tolerance.

    Returns
    -------
    Impact

    Raises
    ------
    PoundingError
        For an e that the law cannot return, a contact that does not end, and one of more steps than `ROWS`.
    """
    beyond = out_of_reach(type(bare(law)), rule.at(speed), getattr(bare(law), "design_penetration", 0.0))
    if beyond:
        raise PoundingError(f"impact: restitution: {beyond}")
    mass, other_mass, *_ = values
    pair, *_, workspace, log = arguments = meeting(by_address(law), rule, speed, values)
    finish, *_ = begin_contact(*arguments)
    if finish not in (FINISHED, AT_END):
        raise PoundingError(f"impact: {STATUS_SENTENCES[finish]}")
    if log.used[1] > ROWS:
        raise PoundingError(f"impact: the contact takes {log.used[1]} steps, more than {ROWS}; raise rtol")
    facts = dict(zip(CONTACT_COLUMNS, log.contacts[0], strict=False))
    rows = _steps_of(law, pair, facts) if needs_floors(law) else log.steps[: log.used[1]]
    end_state = workspace.states[BEGIN]
    momentum = mass * (end_state[2] - speed) + (other_mass * end_state[3] if other_mass < inf else np.nan)
    return Impact(
        law=name_of(type(bare(law))),
        mass=float(mass),
        time=rows[:, 0] - rows[0, 0],
        penetration=rows[:, 1] - rows[:, 2],
        rate=rows[:, 3] - rows[:, 4],
        force=rows[:, 5].copy(),
        approach_speed=float(speed),
        rebound_speed=facts["rebound_speed"],
        restitution_asked=facts["restitution_asked"] if bare(law).needs_restitution else nan,
        restitution=facts["rebound_speed"] / speed,
        peak_force=facts["peak_force"],
        peak_penetration=facts["peak_penetration"],
        duration=facts["end"] - facts["start"],
        impulse=facts["impulse"],
        energy_lost=facts["work"],
        momentum_change=momentum / facts["impulse"],
        table_end=getattr(getattr(bare(law), "table", None), "end", inf),
    )


def meeting(law: Any, rule: Restitution, speed: float, values: tuple[float, float, float, float]) -> tuple[Any, ...]:
    """Arguments of `run.begin_contact` for `collide`, ``law`` as kernels take it; ``values`` as there."""
    mass, other_mass, yield_force, rtol = map(float, values)
    no_map, (high, low) = ((0.0,) * 4,) * 2, np.zeros((2, 1, SIGNALS))
    free = Free(np.zeros(2), NEVER, 4, np.zeros((2, 4)), high, low, no_map, no_map, 0.0, UniformGround())
    start = (0.0, 0.0, float(speed), 0.0)
    log, workspace = make_log(1, ROWS, np.zeros(0)), make_workspace(rtol)
    pair = free_mass(mass), free_mass(other_mass)
    return pair, free, law, Limits(0.0, yield_force, rule), rtol, (0, 0.0), start, workspace, log


def _steps_of(law: Any, pair: Any, facts: dict[str, float]) -> NDArray[np.float64]:
    """The corners of the force between two floors, as rows of the log of a run; nothing penetrates."""
    steps = list(islice(law.course(*(oscillator.inverse_mass for oscillator in pair)), ROWS))
    if len(steps) == ROWS:
        raise PoundingError(
            f"impact: the force has more than {ROWS} steps, since a wave is back in one floor so many times before it "
            "is back in the other; give floors of lengths less far apart"
        )
    rows = np.zeros((2 * len(steps) + 2, 8))
    rows[1:-1, 0] = [time for start, end, _ in steps for time in (start, end)]
    rows[1:-1, 5] = np.repeat([force for *_, force in steps], 2) * facts["approach_speed"]
    rows[-1, 0] = rows[-2, 0]
    rows[0, 3], rows[1:, 3] = facts["approach_speed"], -facts["rebound_speed"]
    return rows


def equal_stiffness(
    law: Callable[[float], Any], reference: Any, speed: float, mass: float, rule: Restitution, same: str
) -> float:
    """The stiffness with which ``law`` agrees with ``reference`` in an impact of ``mass`` [kg] at ``speed`` [m/s].

    ``same`` is "peak force" or "penetration". Both are powers of the stiffness for every law here, so the search
    in its logarithm ends quickly. Uncapped forces are compared: the cap is the building's, not the law's. Raises
    PoundingError where no stiffness within `SOFTEST` and `STIFFEST` agrees.
    """
    from scipy.optimize import brentq

    measure = {"peak force": "peak_force", "penetration": "peak_penetration"}[same]
    target = getattr(collide(reference, rule, speed, (mass, inf, inf, RTOL)), measure)

    def excess(logarithm: float) -> float:
        impact = collide(law(10.0**logarithm), rule, speed, (mass, inf, inf, RTOL))
        return float(np.log(getattr(impact, measure) / target))

    ends = log10(SOFTEST), log10(STIFFEST)
    if excess(ends[0]) * excess(ends[1]) > 0.0:
        raise PoundingError(
            f"equal_terms: no stiffness of {name_of(type(law(1.0)))} from {SOFTEST:g} to {STIFFEST:g} (SI) gives the "
            f"{same} of {name_of(type(bare(reference)))} with {reference.stiffness:g} at {speed:g} m/s, {target:g} "
            f"{'N' if measure == 'peak_force' else 'm'}; check interface.stiffness, its unit and its power of ten"
        )
    return float(10.0 ** brentq(excess, *ends, xtol=1e-12, rtol=1e-12))
