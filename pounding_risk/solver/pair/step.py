"""One step in contact and its polynomial, by the method that `implicit.choose_method` has chosen."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.counters import IMPLICIT
from pounding_risk.solver.pair.implicit import implicit_attempt, implicit_spread
from pounding_risk.solver.pair.stages import explicit_attempt, explicit_spread


@kernel
def attempt(impact, phase, s, h, rtol, workspace):
    """One step from BEGIN, whose slopes are known, to END; returns its error in the contact's scales."""
    if workspace.counters[IMPLICIT] > 0.0:
        return implicit_attempt(impact, phase, s, h, rtol, workspace)
    return explicit_attempt(impact, phase, s, h, workspace)


@kernel
def spread(impact, phase, span, workspace):
    """Write the polynomial between both ends of the step just made, ``span`` = (s, h)."""
    if workspace.counters[IMPLICIT] > 0.0:
        implicit_spread(workspace)
    else:
        explicit_spread(impact, phase, span, workspace)
