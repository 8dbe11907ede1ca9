"""The compiled grid: every gap and yield force of one law under one ground motion.

Runs that are known are not run. Where the free motion closes no gap, the free response is the answer, exactly;
where the yield force lies above the largest force of the run without yielding, that run is. A law without a cap
runs once for every gap.
"""

from __future__ import annotations

from math import inf

import numpy as np

from pounding_risk._jit import kernel
from pounding_risk.collide import DESK, TABLE
from pounding_risk.flight import SIGNALS
from pounding_risk.march import march
from pounding_risk.series import HIGH, LOW, TALLY
from pounding_risk.tally import COMPLETE, DEMAND, FIRST_YIELD, STATUS, TALLIED, YIELDS, make_log

KNOWN, SIMULATED = 0, 1


@kernel
def write_out(desk, out):
    """Copy a run from the desk to its row."""
    for place in range(TALLIED):
        out[place] = desk[TALLY, place]
    for signal in range(SIGNALS):
        out[TALLIED + signal] = desk[HIGH, signal]
        out[TALLIED + SIGNALS + signal] = desk[LOW, signal]


@kernel
def answer_levels(log, row, out):
    """Yielding of a law without a cap: its force reaches the yield force."""
    out[YIELDS] = log.reached[row]
    out[FIRST_YIELD] = log.first[row]


@kernel
def sweep(pair, free, law, grid, rtol, screening, table, out, how):
    """Fill ``out`` (gaps, yield forces, outputs.COLUMNS) and ``how`` (gaps, yield forces).

    ``grid`` = (gaps, yield forces ascending, restitution); ``table`` is a desk with the tableau on it.
    """
    gaps, yield_forces, restitution = grid
    desk = np.zeros(DESK)
    desk[TABLE:] = table[TABLE:]
    capped = law.ceiling(1.0) < inf
    count = yield_forces.size
    nothing = np.zeros(0)
    closing = -inf
    for block in range(free.high.shape[0]):
        closing = max(closing, free.high[block, 0])
    for g in range(gaps.size):
        limits = (gaps[g], inf, restitution)
        first = 0  # yield forces below this place have runs of their own
        if screening:
            contact = closing > gaps[g]
            log = make_log(0, 0, nothing if capped or not contact else yield_forces)
            march(pair, free, law, limits, rtol, desk, log)
            whole = desk[TALLY, STATUS] == COMPLETE
            if capped and contact:
                while first < count and not (whole and yield_forces[first] > desk[TALLY, DEMAND]):
                    first += 1
            for f in range(first, count):
                write_out(desk, out[g, f])
                how[g, f] = KNOWN
                if not capped and contact:
                    answer_levels(log, f, out[g, f])
            # The base run answers for a column of its own: the one without yielding, or the nearest to it.
            if contact and first < count:
                how[g, count - 1] = SIMULATED
        for f in range(first if screening else count):
            limits = (gaps[g], yield_forces[f], restitution)
            log = make_log(0, 0, nothing if capped else yield_forces[f : f + 1])
            march(pair, free, law, limits, rtol, desk, log)
            write_out(desk, out[g, f])
            how[g, f] = SIMULATED
            if not capped:
                answer_levels(log, 0, out[g, f])
