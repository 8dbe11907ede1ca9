"""Signals between both ends of a step in contact, on its polynomial, and their crests.

A crest is searched for only where the tangents at both ends leave room for a new peak.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.equations import transmitted, uncapped
from pounding_risk.solver.row.event_functions import across_between
from pounding_risk.solver.row.explicit import between
from pounding_risk.solver.row.ground_dof import top_of
from pounding_risk.solver.row.implicit import spread
from pounding_risk.solver.row.storey import shear_stiffness
from pounding_risk.solver.row.workspace import (
    ACCELERATION,
    BAND,
    BOTTOM,
    CONSTANT,
    DISPLACEMENT,
    DRIFT,
    FIRST,
    INVERSE,
    START,
    STOREY_FORCE,
    TANGENT,
)

PUSH, REACH, SIDE = -1, -2, -3  # what is watched beside the signals of a dof


@kernel
def reading(row, run, group, what, k, x, span):
    """A watched signal at a place x of the step, 0 to 1, on the polynomial; ``span`` = (s, h, base)."""
    if what == DISPLACEMENT:
        return between(run, 0, k, x)
    if what in (DRIFT, STOREY_FORCE):
        drift = between(run, 0, k, x) - (between(run, 0, k - 1, x) if row.floors[BOTTOM, k] == 0.0 else 0.0)
        return drift if what == DRIFT else shear_stiffness(row, run.dofs, k) * drift + run.dofs[CONSTANT, k]
    if what == ACCELERATION:
        return felt(row, run, group, k, x)
    if what == SIDE:
        total = 0.0
        for end in range(row.passage.point_ends()):
            i = row.ends[k, end]
            if group.low <= i < group.high:
                total += row.shares[k, end] * between(run, 0, i, x)
        return total
    clock = span[0] + x * span[1]
    after = group.origin + clock * clock * clock * clock - span[2]
    place = across_between(row, run, group, k, 0, x, after)
    if what == REACH:
        return place
    rate = across_between(row, run, group, k, 1, x, after)
    return uncapped(run, k, max(place - run.contacts[k].gap, 0.0), rate)


@kernel
def felt(row, run, group, i, x):
    """Absolute acceleration of dof ``i`` at a place x of the step: what storeys, dampers and contacts do to it."""
    dofs = run.dofs
    b = building_of(row, group, i)
    first, last = row.frame[FIRST, b], top_of(row, b)
    place = between(run, 0, i, x)
    drift = place - (between(run, 0, i - 1, x) if i > first else 0.0)
    force = -(dofs[TANGENT, i] * drift + dofs[CONSTANT, i])
    if i + 1 < last:
        force += dofs[TANGENT, i + 1] * (between(run, 0, i + 1, x) - place) + dofs[CONSTANT, i + 1]
    band = row.frame[BAND, b]
    for j in range(max(first, i - band), min(last, i + band + 1)):
        force -= row.damping[i, j - first] * between(run, 1, j, x)
    for k in range(row.frame[START, max(b - 1, group.first)], row.frame[START, min(b + 1, group.last)]):
        if run.contacts[k].closed > 0.0:
            for end in range(4):
                if row.ends[k, end] == i:
                    force -= row.shares[k, end] * push_between(row, run, group, k, x)
    return force * row.floors[INVERSE, i]


@kernel
def building_of(row, group, i):
    """The building of the group that dof ``i`` belongs to."""
    b = group.first
    while row.frame[FIRST, b + 1] <= i:
        b += 1
    return b


@kernel
def push_between(row, run, group, k, x):
    """The force that closed contact ``k`` transmits at a place x of the step."""
    delta = across_between(row, run, group, k, 0, x, 0.0) - run.contacts[k].gap
    rate = across_between(row, run, group, k, 1, x, 0.0)
    return transmitted(run, k, max(delta, 0.0), rate)


@kernel
def crest(row, run, group, what, k, sign, span):
    """(largest sign × reading inside the step, its place): golden section with parabolic steps (Brent 1973, ch. 5)."""
    golden = 0.381966011250105
    low, high = 0.0, 1.0
    x = w = v = golden
    fx = -sign * reading(row, run, group, what, k, x, span)
    fw = fv = fx
    step = before = 0.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        close = 3e-6
        if abs(x - middle) <= 2.0 * close - 0.5 * (high - low):
            break
        parabola = False
        if abs(before) > close:
            r, q = (x - w) * (fx - fv), (x - v) * (fx - fw)
            p = (x - v) * q - (x - w) * r
            q = 2.0 * (q - r)
            p = -p if q > 0.0 else p
            q = abs(q)
            parabola = abs(p) < abs(0.5 * q * before) and q * (low - x) < p < q * (high - x)
            before = step
            if parabola:
                step = p / q
        if not parabola:
            before = high - x if x < middle else low - x
            step = golden * before
        if abs(step) < close:
            step = close if step >= 0.0 else -close
        u = x + step
        fu = -sign * reading(row, run, group, what, k, u, span)
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
def hides(here, there, rise, fall, s, h, best):
    """True where a signal with these end values and slopes may pass ``best`` between both ends of a step."""
    if fall >= 0.0:
        return False
    if s == 0.0:
        # The slope at the touch itself is no measure of what follows.
        return True
    if rise <= 0.0:
        return False
    return max(here, there) + h * rise * fall / (fall - rise) > best


@kernel
def peak_over_step(row, run, group, what, k, best, ends, span, laid):
    """(max(best, |signal| over the step), whether the step is laid out); ``ends`` = values and slopes at both ends."""
    here, there, rise, fall = ends
    best = max(best, abs(there))
    # Error control keeps a step from hiding a crest twice as high as both its ends.
    if 2.0 * max(abs(here), abs(there)) > best:
        for side in range(2):
            sign = 1.0 - 2.0 * side
            if hides(sign * here, sign * there, sign * rise, sign * fall, span[0], span[1], best):
                if not laid:
                    spread(row, run, group, span[0], span[1])
                    laid = True
                best = max(best, crest(row, run, group, what, k, sign, span)[0])
    return best, laid


@kernel
def raise_reach(row, run, group, what, k, sign, best, ends, span, laid):
    """(max(best, sign × distance over the step), whether the step is laid out)."""
    here, there, rise, fall = ends
    best = max(best, there)
    # At a touch elsewhere the motion goes on smoothly here: its slope in time is the measure.
    if hides(here, there, rise, fall, span[0], span[1], best) and (span[0] > 0.0 or there > here):
        if not laid:
            spread(row, run, group, span[0], span[1])
            laid = True
        best = max(best, crest(row, run, group, what, k, sign, span)[0])
    return best, laid
