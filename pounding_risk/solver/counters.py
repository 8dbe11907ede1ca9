"""Counters of a run, the ways in which a run may end, and the optional log of its contacts and steps."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# The counters of one run, by place.
(
    PENETRATION, COUNT, FIRST_TOUCH, CONTACT_TIME, APPROACH, PEAK_FORCE, LOWEST_FORCE, IMPULSE, DEMAND, YIELDS,
    FIRST_YIELD, VISCOUS, PLASTIC, SET, DAMAGE, RESIDUAL, ENERGY, HELD, STEPS, STATUS, BUSY, IMPLICIT, WORKED,
) = range(23)  # fmt: skip
COUNTERS = 23
# The first 20 are outputs. BUSY (time at which the contacts so far have ended), IMPLICIT (whether the present step is
# implicit) and WORKED (evaluations of the equations of motion in contact) serve the run alone.
TALLIED = 20

# How a contact phase, and with it a run, may end.
FINISHED, AT_END, UNDERFLOW, EXHAUSTED, NOT_FINITE, TOO_MANY_CONTACTS, ENERGY_OPEN = 0, 1, 2, 3, 4, 5, 6
COLLAPSED = 9  # 7 is `WATCHED` of a row's run, 8 `results.variables.UNPUSHED`
COMPLETE = FINISHED
STATUS_SENTENCES = {
    COMPLETE: "complete",
    UNDERFLOW: "the step in contact fell below what the numbers resolve; raise rtol or lower the stiffness",
    EXHAUSTED: "the step budget ran out; raise rtol or lower the stiffness",
    NOT_FINITE: "the motion is not finite; check the record and the stiffness",
    TOO_MANY_CONTACTS: "more contacts than the limit; check the gap and the record",
    ENERGY_OPEN: "the energy of the contacts does not close; lower rtol",
    COLLAPSED: "a storey collapsed: its drift passed collapse_drift, where the run ends",
}
# Those of every scene; a storey without hysteresis does not collapse.
USUAL_SENTENCES = {code: sentence for code, sentence in STATUS_SENTENCES.items() if code != COLLAPSED}
MAX_CONTACTS = 200_000
# Energy that all contacts of a run may leave unaccounted for, as a share of the largest at a touch: so many times
# rtol, and what rounding leaves. Some thousand random runs at rtol 1e-3 to 1e-12 stay a factor of five below.
OPEN_SHARE, OPEN_FLOOR = 100.0, 1e-9
MAX_STEPS = 20_000_000
# Evaluations of the equations of motion in contact that a run may take: to begin with, and for every second simulated.
# The worst of 400 random rows and pairs, e from 1e-6 to 1, periods from 5 ms to 2 s, stiffnesses over five decades,
# tries 15,000 steps a second: some 3e5 evaluations.
WORK_AT_LEAST, WORK_A_SECOND = 2e7, 2e6

CONTACT_COLUMNS = (
    "start", "end", "approach_speed", "restitution_asked", "peak_force", "uncapped_force", "peak_penetration",
    "yields", "rebound_speed", "impulse", "work",
)  # fmt: skip
STEP_COLUMNS = ("time", "u_left", "u_right", "v_left", "v_right", "force", "work", "impulse")


class Log(NamedTuple):
    """Contacts, steps and timed levels that a run logs; arrays without rows switch each part off.

    ``levels`` are forces [N, ascending] whose first reaching is timed and whose contacts are counted: a law
    without a cap runs once and answers for every yield force.
    """

    contacts: np.ndarray  # (rows, CONTACT_COLUMNS and the number of steps written by then)
    steps: np.ndarray  # (rows, STEP_COLUMNS)
    levels: np.ndarray  # (L,) N
    first: np.ndarray  # (L,) time at which the force first reaches a level, NaN for never [s]
    reached: np.ndarray  # (L,) contacts in which it does
    used: np.ndarray  # (3,) rows written; levels reached


def make_log(contacts, steps, levels):
    """A log with room for so many contacts and steps, timing these levels."""
    return Log(
        np.zeros((contacts, 12)),
        np.zeros((steps, 8)),
        levels,
        np.full(levels.size, np.nan),
        np.zeros(levels.size),
        np.zeros(3, dtype=np.int64),
    )
