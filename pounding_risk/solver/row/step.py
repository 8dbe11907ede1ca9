"""One step of a group in contact and its polynomial, by the method that `implicit.choose_method` has chosen."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.implicit import implicit_attempt, implicit_spread
from pounding_risk.solver.row.stages import explicit_attempt, explicit_spread


@kernel
def attempt(row, run, group, s, h, rtol):
    """One step from rows NOW, whose slopes stand at stage 0, to rows END; returns its error in the group's scales."""
    if run.workspace.implicit > 0.0:
        return implicit_attempt(row, run, group, s, h, rtol)
    return explicit_attempt(row, run, group, s, h)


@kernel
def spread(row, run, group, s, h):
    """The polynomial between both ends of the step just made; slopes at LAST stand."""
    if run.workspace.implicit > 0.0:
        implicit_spread(run, group)
    else:
        explicit_spread(row, run, group, s, h)
