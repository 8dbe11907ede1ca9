"""The compiled grid: every gap and yield force of one law under one ground motion.

Runs that are known are not run. Where the free motion closes no gap, the free response is the answer, exactly;
where the yield force lies above the largest force of the run without yielding, that run is. A law without a cap
runs once for every gap.
"""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.counters import COMPLETE, DEMAND, FIRST_YIELD, STATUS, TALLIED, YIELDS, make_log
from pounding_risk.solver.pair.run import march
from pounding_risk.solver.workspace import SIGNALS

KNOWN, SIMULATED = 0, 1


@kernel
def write_out(workspace, out):
    """Copy the counters and the extremes of a run from the workspace to its row of raw columns."""
    for place in range(TALLIED):
        out[place] = workspace.counters[place]
    for signal in range(SIGNALS):
        out[TALLIED + signal] = workspace.high[signal]
        out[TALLIED + SIGNALS + signal] = workspace.low[signal]


@kernel
def answer_levels(log, row, out):
    """Yielding of a law without a cap: its force reaches the yield force."""
    out[YIELDS] = log.reached[row]
    out[FIRST_YIELD] = log.first[row]


@kernel
def sweep(pair, free, law, grid, rtol, screening, workspace, out, how):
    """Fill ``out`` (gaps, yield forces, outputs.COLUMNS) and ``how`` (gaps, yield forces).

    ``grid`` = (gaps, yield forces ascending, restitution); ``workspace`` is this thread's own.
    """
    gaps, yield_forces, restitution = grid
    capped = law.ceiling(1.0) < inf
    count = yield_forces.size
    nothing = np.zeros(0)
    closing = -inf
    for block in range(free.high.shape[0]):
        closing = max(closing, free.high[block, 0])
    for g in range(gaps.size):
        contact = closing > gaps[g]
        # Place −1 is the run without yielding, from which others may be known; without screening there is none.
        f = -1 if screening else 0
        known_from = count
        while f < known_from:
            strength = inf if f < 0 else yield_forces[f]
            levels = nothing
            if not capped and contact:
                levels = yield_forces if f < 0 else yield_forces[f : f + 1]
            log = make_log(0, 0, levels)
            march(pair, free, law, (gaps[g], strength, restitution), rtol, workspace, log)
            if f >= 0:
                write_out(workspace, out[g, f])
                how[g, f] = SIMULATED
                if levels.size > 0:
                    answer_levels(log, 0, out[g, f])
            else:
                known_from = 0
                if capped and contact:
                    whole = workspace.counters[STATUS] == COMPLETE
                    while known_from < count and not (whole and yield_forces[known_from] > workspace.counters[DEMAND]):
                        known_from += 1
                for known in range(known_from, count):
                    write_out(workspace, out[g, known])
                    how[g, known] = KNOWN
                    if levels.size > 0:
                        answer_levels(log, known, out[g, known])
                # That run stands in the last of the columns it answers for.
                if contact and known_from < count:
                    how[g, count - 1] = SIMULATED
            f += 1
