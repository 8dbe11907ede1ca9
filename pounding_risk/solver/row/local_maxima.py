"""Signals between both ends of a step in contact, on its polynomial, and their local maxima.

A local maximum is searched for only where the tangents at both ends leave room for a new peak.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.equations import ground_at, transmitted, uncapped
from pounding_risk.solver.row.event_functions import across_between
from pounding_risk.solver.row.explicit import between
from pounding_risk.solver.row.ground_dof import top_of
from pounding_risk.solver.row.implicit import write_polynomial
from pounding_risk.solver.row.inertia import has_inertia, response
from pounding_risk.solver.row.link import brace_of, damper_speed, follows_rate, force_in_contact, is_braced, is_link_of
from pounding_risk.solver.row.storey import is_lowest, shear_stiffness
from pounding_risk.solver.row.workspace import (
    ACCELERATION,
    BAND,
    BOTTOM,
    CONSTANT,
    COUPLED,
    DISPLACEMENT,
    DRIFT,
    DRIVEN,
    FIRST,
    INVERSE,
    START,
    STOREY_FORCE,
    TANGENT,
)

PUSH, REACH, SIDE, SPEED = -1, -2, -3, -4  # what is watched beside the signals of a dof


@kernel
def signal_between(row, run, group, kind, k, x, span):
    """A watched signal at a place x of the step, 0 to 1, on the polynomial; ``span`` = (s, h, base)."""
    if kind == DISPLACEMENT:
        return between(run, 0, k, x)
    if kind in (DRIFT, STOREY_FORCE):
        drift = between(run, 0, k, x) - (between(run, 0, k - 1, x) if row.floors[BOTTOM, k] == 0.0 else 0.0)
        return drift if kind == DRIFT else shear_stiffness(row, run.dofs, k) * drift + run.dofs[CONSTANT, k]
    if kind == ACCELERATION:
        return acceleration_between(row, run, group, k, x, span)
    if kind == SIDE:
        total = 0.0
        for end in range(row.passage.point_ends()):
            i = row.ends[k, end]
            if group.low <= i < group.high:
                total += row.shares[k, end] * between(run, 0, i, x)
        return total
    if kind == SPEED:
        if is_braced(run, k):
            return damper_speed(run, k, between(run, 0, brace_of(run, k), x))
        return across_between(row, run, group, k, 1, x, 0.0)
    clock = span[0] + x * span[1]
    time = group.origin + clock * clock * clock * clock - span[2]
    distance = across_between(row, run, group, k, 0, x, time)
    if kind == REACH:
        return distance
    rate = across_between(row, run, group, k, 1, x, time)
    return uncapped(run, k, max(distance - run.contacts[k].gap, 0.0), rate)


@kernel
def acceleration_between(row, run, group, i, x, span):
    """Absolute acceleration of dof ``i`` at a place x of the step: what storeys, dampers and contacts do to it.

    ``span`` is as that of `signal_between`.
    """
    b = building_of(row, group, i)
    if not has_inertia(row, b):
        return force_on(row, run, group, b, i, x) * row.floors[INVERSE, i]
    pull = ground_at(group, span[0] + x * span[1]).under(b)[0].real
    total = pull
    for j in range(row.frame[FIRST, b], top_of(row, b)):
        total += response(row, i, j) * (force_on(row, run, group, b, j, x) - row.floors[DRIVEN, j] * pull)
    return total


@kernel
def force_on(row, run, group, b, i, x):
    """What storeys, dampers, contacts and links do to dof ``i`` of building ``b`` at a place x of the step [N]."""
    dofs = run.dofs
    first, last = row.frame[FIRST, b], top_of(row, b)
    displacement = between(run, 0, i, x)
    is_coupled = row.frame[COUPLED, b] > 0
    drift = displacement - (0.0 if is_lowest(row, first, i, is_coupled) else between(run, 0, i - 1, x))
    force = -(dofs[TANGENT, i] * drift + dofs[CONSTANT, i])
    if i + 1 < last and not is_lowest(row, first, i + 1, is_coupled):
        force += dofs[TANGENT, i + 1] * (between(run, 0, i + 1, x) - displacement) + dofs[CONSTANT, i + 1]
    if is_coupled:
        for j in range(first, last):
            force -= row.coupling[i, j - first] * between(run, 0, j, x)
    band = row.frame[BAND, b]
    for j in range(max(first, i - band), min(last, i + band + 1)):
        force -= row.damping[i, j - first] * between(run, 1, j, x)
    for k in range(row.frame[START, max(b - 1, group.first)], row.frame[START, min(b + 1, group.last)]):
        if run.contacts[k].closed > 0.0:
            for end in range(4):
                if row.ends[k, end] == i:
                    force -= row.shares[k, end] * force_between(row, run, group, k, x)
    for k in range(run.links.shape[0]):
        if is_link_of(run, k, b, b):
            for end in range(4):
                if row.ends[k, end] == i:
                    if is_braced(run, k):
                        moved = between(run, 0, brace_of(run, k), x)
                    else:
                        moved = across_between(row, run, group, k, 1 if follows_rate(run, k) else 0, x, 0.0)
                    force -= row.shares[k, end] * force_in_contact(run, k, moved)
    return force


@kernel
def building_of(row, group, i):
    """The building of the group that dof ``i`` belongs to."""
    b = group.first
    while row.frame[FIRST, b + 1] <= i:
        b += 1
    return b


@kernel
def force_between(row, run, group, k, x):
    """The force that closed contact ``k`` transmits at a place x of the step."""
    delta = across_between(row, run, group, k, 0, x, 0.0) - run.contacts[k].gap
    rate = across_between(row, run, group, k, 1, x, 0.0)
    return transmitted(run, k, max(delta, 0.0), rate)


@kernel
def local_maximum(row, run, group, signal, span):
    """(largest sign × signal inside the step, its place x): golden section with parabolic steps (Brent 1973, ch. 5).

    ``signal`` = (kind, dof or contact point, sign) as `signal_between` takes them; the polynomial of the step stands.
    """
    kind, k, sign = signal
    golden = 0.381966011250105
    low, high = 0.0, 1.0
    x = w = v = golden
    fx = -sign * signal_between(row, run, group, kind, k, x, span)
    fw = fv = fx
    step = step_before = 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        close = 3e-6
        if abs(x - middle) <= 2.0 * close - 0.5 * (high - low):
            break
        parabola = False
        if abs(step_before) > close:
            r, q = (x - w) * (fx - fv), (x - v) * (fx - fw)
            p = (x - v) * q - (x - w) * r
            q = 2.0 * (q - r)
            p = -p if q > 0.0 else p
            q = abs(q)
            parabola = abs(p) < abs(0.5 * q * step_before) and q * (low - x) < p < q * (high - x)
            step_before = step
            if parabola:
                step = p / q
        if not parabola:
            step_before = high - x if x < middle else low - x
            step = golden * step_before
        if abs(step) < close:
            step = close if step >= 0.0 else -close
        u = x + step
        fu = -sign * signal_between(row, run, group, kind, k, u, span)
        if fu <= fx:
            low, high = (x, high) if u >= x else (low, x)
            v, w, x, fv, fw, fx = w, x, u, fw, fx, fu
        else:
            low, high = (u, high) if u < x else (low, u)
            if fu <= fw or w == x:
                v, w, fv, fw = w, u, fw, fu
            elif fu <= fv or v in (x, w):
                v, fv = u, fu
    return -fx, x


@kernel
def may_hide_maximum(start, end, start_slope, end_slope, s, h, best):
    """True where a signal with these end values and slopes may pass ``best`` between both ends of a step."""
    if end_slope >= 0.0:
        return False
    if s == 0.0:
        # The slope at the touch itself is no measure of what follows.
        return True
    if start_slope <= 0.0:
        return False
    return max(start, end) + h * start_slope * end_slope / (end_slope - start_slope) > best


@kernel
def peak_over_step(row, run, group, signal, best, ends, span):
    """max(best, |signal| over the step); ``signal`` = (kind, dof), ``ends`` = values and slopes at both ends."""
    kind, k = signal
    start, end, start_slope, end_slope = ends
    best = max(best, abs(end))
    # Error control keeps a step from hiding a local maximum twice as high as both its ends.
    if 2.0 * max(abs(start), abs(end)) > best:
        for side in range(2):
            sign = 1.0 - 2.0 * side
            if may_hide_maximum(sign * start, sign * end, sign * start_slope, sign * end_slope, span[0], span[1], best):
                write_polynomial(row, run, group, span[0], span[1])
                best = max(best, local_maximum(row, run, group, (kind, k, sign), span)[0])
    return best


@kernel
def extreme_over_step(row, run, group, signal, best, ends, span):
    """max(best, sign × distance over the step); ``signal`` = (kind, contact point, sign).

    ``ends`` = values and slopes at both ends, times the sign.
    """
    start, end, start_slope, end_slope = ends
    best = max(best, end)
    # At a touch elsewhere the motion goes on smoothly here: its slope in time is the measure.
    if may_hide_maximum(start, end, start_slope, end_slope, span[0], span[1], best) and (span[0] > 0.0 or end > start):
        write_polynomial(row, run, group, span[0], span[1])
        best = max(best, local_maximum(row, run, group, signal, span)[0])
    return best
