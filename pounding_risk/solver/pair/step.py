"""One step in contact and its polynomial, by the method that `implicit.choose_method` has chosen."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.counters import IMPLICIT
from pounding_risk.solver.pair.implicit import implicit_attempt, implicit_spread
from pounding_risk.solver.pair.stages import explicit_attempt, explicit_spread
from pounding_risk.solver.pair.taylor import TALLY


@kernel
def attempt(impact, phase, s, h, rtol, desk):
    """One step from row STATE, whose slopes are in row STAGES, to row END; returns its error in its scales."""
    if desk[TALLY, IMPLICIT] > 0.0:
        return implicit_attempt(impact, phase, s, h, rtol, desk)
    return explicit_attempt(impact, phase, s, h, desk)


@kernel
def spread(impact, phase, span, desk):
    """The polynomial between both ends of the step just made, ``span`` = (s, h); rows END and LAST are its end's."""
    if desk[TALLY, IMPLICIT] > 0.0:
        implicit_spread(desk)
    else:
        explicit_spread(impact, phase, span, desk)
