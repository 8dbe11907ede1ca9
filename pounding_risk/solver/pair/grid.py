"""The compiled grid: every gap and yield force of one law under one ground motion.

Cases whose result is known are not simulated: where the free motion does not close the gap, the result is the free
response, exactly; where the yield force lies above the largest force of the run without yielding, it is that run. A
law without a cap is simulated once for every gap.
"""

from __future__ import annotations

from math import inf, nan

import numpy as np

from pounding_risk._jit.compile import kernel, lowered
from pounding_risk.solver.counters import COMPLETE, DEMAND, FIRST_YIELD, STATUS, TALLIED, YIELDS, make_log
from pounding_risk.solver.pair.equations import Limits
from pounding_risk.solver.pair.laws import by_address
from pounding_risk.solver.pair.run import march
from pounding_risk.solver.workspace import SIGNALS

KNOWN, SIMULATED = 0, 1


@kernel
def copy_to_row(workspace, out):
    """Copy the counters and the extremes of a run from the workspace to its row of raw columns."""
    for counter in range(TALLIED):
        out[counter] = workspace.counters[counter]
    for signal in range(SIGNALS):
        out[TALLIED + signal] = workspace.high[signal]
        out[TALLIED + SIGNALS + signal] = workspace.low[signal]


@kernel
def copy_levels(log, row, out):
    """Yielding of a law without a cap: its force reaches the yield force."""
    out[YIELDS] = log.reached[row]
    out[FIRST_YIELD] = log.first[row]


@kernel
def clear_levels(log):
    """Set the log back: no level reached, nothing written."""
    for level in range(log.levels.size):
        log.first[level] = nan
        log.reached[level] = 0.0
    for part in range(log.used.size):
        log.used[part] = 0


def solve_grid(pair, free, law, grid, rtol, screening, workspace, out, case_kinds, own_kernel=False):
    """Fill ``out`` (gaps, yield forces, outputs.COLUMNS) and ``case_kinds`` (gaps, yield forces).

    ``grid`` = (gaps, yield forces ascending, restitution); ``workspace`` belongs to the calling thread. With
    ``own_kernel`` the law's code is in the kernel, which is compiled for this kind of law: faster, with the same bits.
    """
    called = lowered(law) if own_kernel else by_address(law)
    logs = make_log(0, 0, np.zeros(0)), make_log(0, 0, np.zeros(1)), make_log(0, 0, grid[1])
    march_grid(pair, free, called, grid, rtol, screening, logs, workspace, out, case_kinds)


@kernel
def march_grid(pair, free, law, grid, rtol, screening, logs, workspace, out, case_kinds):
    """As `solve_grid`, of a law as kernels take it; ``logs`` are those without a level, with one, with all of them."""
    gaps, yield_forces, restitution = grid
    capped = law.ceiling(1.0) < inf
    count = yield_forces.size
    closing = -inf
    for block in range(free.high.shape[0]):
        closing = max(closing, free.high[block, 0])
    for g in range(gaps.size):
        touches = closing > gaps[g]
        # Index −1 is the run without yielding, from which others may be known; without screening there is none.
        f = -1 if screening else 0
        first_answered = count
        while f < first_answered:
            strength = inf if f < 0 else yield_forces[f]
            log = logs[0]
            if not capped and touches:
                log = logs[2] if f < 0 else logs[1]
                if f >= 0:
                    log.levels[0] = strength
            clear_levels(log)
            march(pair, free, law, Limits(gaps[g], strength, restitution), rtol, workspace, log)
            if f >= 0:
                copy_to_row(workspace, out[g, f])
                case_kinds[g, f] = SIMULATED
                if log.levels.size > 0:
                    copy_levels(log, 0, out[g, f])
            else:
                first_answered = 0
                if capped and touches:
                    completed = workspace.counters[STATUS] == COMPLETE
                    while first_answered < count and not (
                        completed and yield_forces[first_answered] > workspace.counters[DEMAND]
                    ):
                        first_answered += 1
                for answered in range(first_answered, count):
                    copy_to_row(workspace, out[g, answered])
                    case_kinds[g, answered] = KNOWN
                    if log.levels.size > 0:
                        copy_levels(log, answered, out[g, answered])
                # The run without yielding is counted as the last of the cases that it answers.
                if touches and first_answered < count:
                    case_kinds[g, count - 1] = SIMULATED
            f += 1
