"""Buildings of a row in flight on their Taylor series, to the first touch or change of a storey."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.counters import COLLAPSED, EXHAUSTED, MAX_CONTACTS
from pounding_risk.solver.row.building import place_on, write_series
from pounding_risk.solver.row.contact_points import compliance, raise_extremes, raise_unwatched_extremes, search_point
from pounding_risk.solver.row.flight_peaks import raise_flight_peaks
from pounding_risk.solver.row.link import note_link_speeds, settle_links
from pounding_risk.solver.row.storey import first_strain, switch_storey
from pounding_risk.solver.row.workspace import CAN_YIELD, FIRST, NEXT, NODE, NOW, START, VELOCITY


@kernel
def copy_state(row, run, first, last, source, target):
    """Copy u and v of the buildings ``first`` to ``last`` from rows ``source`` to rows ``target``."""
    for i in range(row.frame[FIRST, first], row.frame[FIRST, last + 1]):
        run.dofs[target, i] = run.dofs[source, i]
        run.dofs[target + VELOCITY, i] = run.dofs[source + VELOCITY, i]


@kernel
def write_all_series(row, run, watch, ground, terms):
    """Lay the series of all watched buildings from rows NOW; spectators have been brought there."""
    settle_links(row, run, watch[0], watch[1], NOW)
    for b in range(watch[0], watch[1] + 1):
        write_series(row, run, b, NOW, ground, terms)


@kernel
def write_spectator_series(row, run, span, watch, ground, terms):
    """Lay the series of the buildings that only look on, from rows NOW."""
    if watch[0] < span[0]:
        write_series(row, run, watch[0], NOW, ground, terms)
    if watch[1] > span[1]:
        write_series(row, run, watch[1], NOW, ground, terms)


@kernel
def fly_group(row, run, span, watch, stop, ground, terms):
    """Fly from rows NOW, whose series are laid, to the first touch or change of a storey, at most for ``stop``.

    Returns (time flown, contact point that touches or −1, storey that changes or −1). Peaks are raised, but where the
    point is one of a spectator.
    """
    point, storey = -1, -1
    for i in range(watch[0], watch[1]):
        outer = i < span[0] or i >= span[1]
        for k in range(row.frame[START, i], row.frame[START, i + 1]):
            if compliance(row, k) == 0.0:
                continue
            touch = search_point(row, run, k, run.contacts[k].gap, stop, terms)
            if touch >= 0.0:
                if outer:
                    return touch, k, -1
                stop, point = touch, k
    for b in range(span[0], span[1] + 1):
        if row.frame[CAN_YIELD, b]:
            stop, changed = first_strain(row, run, b, stop, terms)
            if changed >= 0:
                point, storey = -1, changed
    for b in range(span[0], span[1] + 1):
        raise_flight_peaks(row, run, b, ground, stop, terms)
    for k in range(row.frame[START, watch[0]], row.frame[START, watch[1]]):
        raise_extremes(row, run, k, stop, terms)
    raise_unwatched_extremes(row, run, span, watch, stop, terms)
    note_link_speeds(row, run, span[0], span[1], stop, terms)
    return stop, point, storey


@kernel
def fly(row, run, span, watch, window, terms):
    """Buildings whose storeys yield, or may, over one node interval without contact: segment by segment.

    A storey that switches back and forth without end sets the run's status.
    """
    moment, step, ground = window
    copy_state(row, run, watch[0], watch[1], NODE, NOW)
    t = 0.0
    for _ in range(MAX_CONTACTS):
        ground_now = ground.later(t)
        write_all_series(row, run, watch, ground_now, terms)
        flown, _, storey = fly_group(row, run, span, watch, step - t, ground_now, terms)
        for b in range(watch[0], watch[1] + 1):
            place_on(row, run, b, flown, terms, NOW)
        t += flown
        if storey < 0:
            break
        switch_storey(row, run, storey, NOW)
        if int(run.workspace.status) == COLLAPSED:
            run.workspace.collapse_time = moment + t
            break
    else:
        run.workspace.status = float(EXHAUSTED)
    copy_state(row, run, span[0], span[1], NOW, NEXT)
