"""Rows for the comparisons with other integrators: buildings, contact points, the ground, and a run by the solver."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np
from oracle import CONCRETE
from oracle_rows import Meeting

from pounding_risk.models.contact.laws import LAWS
from pounding_risk.models.restitution import Restitution, constant
from pounding_risk.models.structures.contact_points import Point
from pounding_risk.models.structures.mdof import Chain, chain_of
from pounding_risk.models.structures.sdof import Building
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.read import read_motion
from pounding_risk.solver import counters
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.cases import Cases, Driven, Limits, Mechanics
from pounding_risk.solver.row.layout import lay_out
from pounding_risk.solver.row.model import RowModel

GRAVITY = 9.80665
LEVELS = np.array([2e6, 5.5e6, 9e6])  # N, the yield forces at which a law without a cap is asked
SOIL = ("soil_flexibility", (("shear_wave_velocity", 150.0), ("radius", 6.0)))
YIELDS = ("inelastic_storeys", (("hardening", 0.03),))
LEANS = ("p_delta", ())


class Shaking(NamedTuple):
    """A record of the catalogue, windowed and scaled."""

    name: str
    start: float  # s
    stop: float
    pga: float  # g
    polarity: str = "as recorded"

    def samples(self) -> tuple[np.ndarray, float]:
        """a_g [m/s²] and its step [s]."""
        window, pga = (self.start, self.stop), self.pga * GRAVITY
        motion = read_motion(self.name, window=window, pga=pga, polarity=self.polarity)
        return motion.acceleration, motion.dt


class Case(NamedTuple):
    """One row under one motion."""

    chains: tuple[Chain, ...]
    meetings: tuple[Meeting, ...]
    shaking: Shaking


def storeys(floors: int, mass: float, stiffness: float, *effects: Any, **more: Any) -> Chain:
    """Equal storeys of 3 m; mass [kg] and stiffness [N/m] of each."""
    strengths = more.pop("strength", None)
    yields = {"strengths": (strengths,) * floors} if strengths else {}
    return chain_of(Storeys("", (mass,) * floors, (stiffness,) * floors, (3.0,) * floors, **yields, **more), effects)


def single(mass: float, period: float, *effects: Any) -> Chain:
    """One mass [kg] of a period [s], 5 % damped."""
    return chain_of(Building("", mass, period, 0.05), effects)


RIGID = chain_of(Building.rigid(""))
SLENDER, STOCKY = (25e3, 3.46e6), (1e6, 2.215e9)  # the buildings of Jankowski (2008), T 1.2 and 0.3 s


def jankowski(*effects: Any, floors: int = 3, **more: Any) -> tuple[Chain, ...]:
    """Three floors of 25 t beside three of 1000 t, damped in proportion to the stiffness."""
    yields = ({"strength": 1.369e5}, {"strength": 1.442e7}) if YIELDS in effects else ({}, {})
    sizes = zip((SLENDER, STOCKY), yields, strict=True)
    return tuple(storeys(floors, *size, *effects, damping_rule="stiffness", **more, **own) for size, own in sizes)


def floors(interface: int, *at: float, gap: float, **more: Any) -> tuple[Meeting, ...]:
    """Floors that meet floors."""
    return tuple(meeting(interface, floor, floor, gap, **more) for floor in at)


def meeting(
    interface: int, left: float, right: float, gap: float, law: str = "viscous_elastoplastic", **more: Any
) -> Meeting:
    """One point of contact, of concrete unless told otherwise."""
    return Meeting(interface, left, right, gap, law, **{"stiffness": 2.75e9, "restitution": CONCRETE, **more})


EL_CENTRO = Shaking("RSN6-180", 1.0, 6.5, 0.3)
STRONG = Shaking("RSN6-180", 1.0, 5.5, 0.6)
CHRISTCHURCH = Shaking("CCC-HN1", 24.0, 29.0, 0.5)
CUT: Any = {"law": "kelvin_voigt_tension_cut", "stiffness": 2e8, "restitution": 0.6}

CASES = {
    "jankowski 2008": Case(jankowski(), floors(0, 1, 2, 3, gap=0.02, restitution=0.65), EL_CENTRO),
    "jankowski 2008, reversed, capped": Case(
        jankowski(), floors(0, 1, 2, 3, gap=0.02, yield_force=6e5), EL_CENTRO._replace(polarity="reversed", pga=0.5)
    ),
    "5 and 3 storeys, floors against columns": Case(
        (storeys(5, 60e3, 6e7), storeys(3, 80e3, 9e7, damping_rule="rayleigh")),
        tuple(
            meeting(0, 0.8 * floor, floor, 0.01, yield_force=force)
            for floor, force in ((1.0, 2e5), (2.0, 3e5), (3.0, math.inf))
        ),
        STRONG,
    ),
    "columns against columns": Case(
        (storeys(4, 90e3, 8e7), storeys(3, 50e3, 3e7)),
        tuple(meeting(0, 1.3 * at, at, 0.004, **CUT) for at in (0.9, 1.5, 2.0, 2.7)),
        STRONG,
    ),
    "single, rigid, storeys": Case(
        (single(200e3, 0.45), RIGID, storeys(3, 80e3, 5e7)),
        (meeting(0, 1.0, 1.0, 0.01), *(meeting(1, 1.0, at, 0.012, yield_force=1e6) for at in (1.0, 2.0, 3.0))),
        EL_CENTRO,
    ),
    "storeys, single, storeys": Case(
        (storeys(3, 70e3, 4e7), single(150e3, 0.25), storeys(2, 300e3, 1.5e8, damping_rule="rayleigh")),
        (meeting(0, 2.5, 1.0, 0.006, **CUT), meeting(1, 1.0, 2.0, 0.012, **CUT)),
        CHRISTCHURCH,
    ),
    "five in a row, closed gaps": Case(
        (single(90e3, 0.2), storeys(2, 100e3, 1e8), single(60e3, 0.5), storeys(2, 80e3, 4e7), RIGID),
        (
            meeting(0, 1.0, 2.0, 0.0),
            meeting(1, 2.0, 1.0, 0.002),
            meeting(2, 1.0, 2.0, 0.0),
            meeting(3, 1.0, 1.0, 0.004),
            meeting(3, 2.0, 1.0, 0.004),
        ),
        EL_CENTRO._replace(stop=4.0),
    ),
    "soil": Case(jankowski(SOIL), floors(0, 1, 2, 3, gap=0.02), EL_CENTRO),
    "p_delta": Case(jankowski(LEANS), floors(0, 1, 2, 3, gap=0.02), EL_CENTRO),
    "yielding storeys": Case(jankowski(YIELDS), floors(0, 1, 2, 3, gap=0.02), EL_CENTRO._replace(pga=0.5)),
    # Pressed against a wall, a contact and the storey below it turn at the same instant.
    "a yielding storey at a wall": Case(
        (RIGID, storeys(1, 52e3, 8.6e6, YIELDS, strength=4.5e4)),
        floors(0, 1.0, gap=0.0, stiffness=1.2e10, restitution=0.62, yield_force=6.5e4),
        EL_CENTRO._replace(stop=5.0, pga=0.7),
    ),
    "yielding storeys between walls": Case(
        (RIGID, storeys(2, 90e3, 4e7, YIELDS, strength=2.5e5), RIGID),
        (meeting(0, 1.0, 1.0, 0.005), meeting(0, 1.0, 2.0, 0.008), meeting(1, 1.0, 1.0, 0.006, yield_force=3e5)),
        EL_CENTRO._replace(pga=0.5),
    ),
    "yielding, leaning, on soil": Case(
        jankowski(YIELDS, LEANS, SOIL), floors(0, 1, 2, 3, gap=0.01, yield_force=8e5), EL_CENTRO._replace(stop=5.0)
    ),
}


# Places of the counters by the names of outputs.
PLACES = {
    "peak_closing": counters.TALLIED,
    "peak_penetration": counters.PENETRATION,
    "peak_contact_force": counters.PEAK_FORCE,
    "peak_approach_speed": counters.APPROACH,
    "uncapped_force": counters.DEMAND,
    "impact_count": counters.COUNT,
    "first_impact_time": counters.FIRST_TOUCH,
    "contact_time": counters.CONTACT_TIME,
    "impulse": counters.IMPULSE,
    "energy_viscous": counters.VISCOUS,
    "lowest_contact_force": counters.LOWEST_FORCE,
    "yielding_contacts": counters.YIELDS,
    "first_yield_time": counters.FIRST_YIELD,
}


def points_of(meetings: Sequence[Meeting]) -> list[Point]:
    return [Point(each.interface, each.left_floor, each.right_floor, "floor", np.nan) for each in meetings]


def contacts_of(meetings: Sequence[Meeting]) -> Any:
    """What the solver is told of the contacts."""
    rules = [
        constant(e) if isinstance(e := each.restitution, float) else Restitution(*e, each.fastest) for each in meetings
    ]
    return rows.Contacts(
        np.array([each.gap for each in meetings]),
        np.array([each.yield_force for each in meetings]),
        [LAWS[each.law](each.stiffness) for each in meetings],
        rules,
    )


def by_solver(case: Case, rtol: float = 1e-9) -> Any:
    acceleration, dt = case.shaking.samples()
    row = lay_out(case.chains, points_of(case.meetings), dt)
    return rows.run_row(row, contacts_of(case.meetings), acceleration, rtol=rtol)


def cases_of(model: RowModel, law: Any, motion: tuple[np.ndarray, float], rules: Any, rtol: float = 1e-6) -> Cases:
    """Every case of a row under ``motion`` = (a_g [m/s²] as `RowModel.under` gives it, its step [s]).

    One law at all points, and one restitution or ``rules`` of each; yielding is counted at `LEVELS`.
    """
    acceleration, dt = motion
    free, count = rows.free_response(model.row(dt, acceleration.ndim > 1), acceleration), len(model.points)
    each = (rules,) * count if isinstance(rules, Restitution) else tuple(rules)
    driven = Driven(acceleration, dt, float(np.abs(acceleration).max()), free.run)
    return Cases(model, Mechanics((law,) * count, each, LEVELS), driven, rtol, lambda: free.motion)


def limits_of(model: RowModel, gaps: Any, strength: float = math.inf, largest: float = math.inf) -> Limits:
    """One gap an interface; every point yields at ``strength``."""
    count = len(model.points)
    return Limits(np.array(gaps, float)[model.interfaces], np.full(count, strength), np.full(count, largest))


def named(run: Any) -> dict[str, np.ndarray]:
    """Outputs of the solver's points by name."""
    return {
        **{name: run.points[:, place] for name, place in PLACES.items()},
        "peak_opening": -run.points[:, counters.TALLIED + 1],
    }
