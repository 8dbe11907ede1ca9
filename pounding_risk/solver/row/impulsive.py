"""A run of single masses in a row whose velocities jump at a touch: exact motion between jumps, and contacts at rest.

Between two jumps every mass moves alone, or as one with neighbours that it presses on. Over a node interval with linear
a_g that motion is its own Taylor series. Of masses that move as one, with A_b what each would do alone and X_b the
displacement of its ground relative to that of the first,

    Y = Σ m_b (A_b + Ẍ_b) / Σ m_b,   ü_b = Y − Ẍ_b,   F_i = Σ_{b ≤ i} m_b (A_b + Ẍ_b − Y)

order by order; a rigid building among them has Y = Ẍ of its own. F_i is the force at interface i.

At a touch all interfaces that are closed then, and those at rest, form a chain that ends at rigid buildings. With c the
closing speed before and s the separation speed after, the impulses P are those of Newton's restitution as one linear
complementarity problem (Moreau 1988; Glocker 2004):

    s − e c ≥ 0,   P ≥ 0,   P (s − e c) = 0,   s = −c + G P.

With c ≥ 0 at what has just closed, a chain never gains energy: each interface takes (1 − e) c P / 2. What rebounds
slower than rtol times the row's fastest free closing speed, or no higher than displacements round by, does not rebound
where it is pressed: which interfaces are, the forces tell, by the same problem on accelerations (Pfeiffer and Glocker
1996). They rest until their force would be tension.

Each building is written down at its own events alone: what happens elsewhere in the row does not change a bit of it.
"""

from __future__ import annotations

from math import inf, nan
from typing import NamedTuple

import numpy as np

from pounding_risk._jit.compile import borrowed, kernel, small
from pounding_risk._jit.records import record_type
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import (
    APPROACH,
    COMPLETE,
    CONTACT_TIME,
    COUNT,
    DEMAND,
    ENERGY_OPEN,
    FIRST_TOUCH,
    FIRST_YIELD,
    HELD,
    IMPULSE,
    MAX_CONTACTS,
    NOT_FINITE,
    OPEN_FLOOR,
    OPEN_SHARE,
    PEAK_FORCE,
    TALLIED,
    TOO_MANY_CONTACTS,
    VISCOUS,
)
from pounding_risk.solver.pair.impulsive import ROUNDING
from pounding_risk.solver.pair.taylor import SHARES, first_rise, highest
from pounding_risk.solver.row.complementarity import ANSWER, COUPLING, DIAGONAL, GIVEN, SLACK, solve_complementarity
from pounding_risk.solver.row.run import WATCHED
from pounding_risk.solver.row.workspace import (
    ACTING,
    BEGAN,
    CAME_AT,
    MOVED,
    NOTED,
    SO_FAR,
    STRONGEST,
    WHEN,
    WHOSE,
)
from pounding_risk.solver.workspace import LEFT, MAX_TERMS, RIGHT, SIGNAL, Search

CLEAR = 4e-16  # of the displacements: so far apart are set what part, lest rounding make them touch at once
JUST_BEFORE = 1.0 - 4e-16  # of the time of a jump: when the log has the state before it

Body = record_type(
    mass=float,  # kg, 0 of a rigid building
    inverse=float,  # 1/kg
    omega2=float,  # 1/s²
    two_zeta_omega=float,  # 1/s
    dof=float,  # number of the mass among those of the row
    hit=float,  # above zero once a contact has changed its motion
    since=float,  # start of its series, after the node [s]
    u=float,  # m, then
    v=float,  # m/s, then
    pull=float,  # a_g under it, then [m/s²]
    rise=float,  # m/s³
    after=float,  # velocity after the jump that is being found [m/s]
    series=(MAX_TERMS,),
    peak_displacement=float,  # m
    peak_acceleration=float,  # absolute [m/s²]
)
Link = record_type(
    gap=float,  # m
    rule=(len(Restitution._fields),),
    fastest=float,  # peak closing or parting speed of the row without contact [m/s]
    watched=float,  # above zero where a touch ends the run
    rests=float,  # above zero while both neighbours move as one
    next_event=float,  # touch, or end of a rest, after the node [s]
    is_event=float,  # above zero where the jump that is being found is that event
    closing=float,  # speed before it [m/s]
    target=float,  # e times the closing speed [m/s]
    slow=float,  # above zero where it is not to rebound
    jump=float,  # impulse [N s]
    presses=float,  # above zero where there is a force after it
    begun=float,  # time of the present contact [s]
    came_at=float,  # its approach speed [m/s]
    strongest=float,  # its largest force at rest [N]
    acting=float,  # force at rest, now [N]
    force=(MAX_TERMS,),  # series of that force [N]
    has_rested=float,
    counters=(TALLIED,),
    highest=float,  # u_left − u_right, with the ground's part [m]
    lowest=float,
)
Totals = record_type(
    search=Search,
    status=float,
    energy=float,  # largest at a jump [J]
    residual=float,  # what jumps leave unaccounted for [J]
    steps=float,  # stretches of motion of buildings that rest on each other
    watched_point=float,
    lines_written=float,
)


class Chain(NamedTuple):
    """Arrays of one run; B buildings, L = B − 1 interfaces."""

    bodies: np.ndarray  # (B,) records of the type `Body`
    links: np.ndarray  # (L,) records of the type `Link`
    table: np.ndarray  # (TABLE_ROWS, L) as `complementarity` has it
    totals: np.record  # of the type `Totals`
    log: np.ndarray  # (lines, numbers) as `trace` writes it


# ------------------------------------------------------------------------------------------------ motion


@small
def place_of(body, terms, x):
    """Displacement at x on a building's series."""
    total = 0.0
    for n in range(terms - 1, -1, -1):
        total = total * x + body.series[n]
    return total


@small
def speed_of(body, terms, x):
    """Velocity at x on a building's series."""
    total = 0.0
    for n in range(terms - 1, 0, -1):
        total = total * x + n * body.series[n]
    return total


@kernel
def group_of(chain, b):
    """(first, last) of the buildings that move as one with ``b``; a rigid one ends a group, or begins one."""
    bodies, links = chain.bodies, chain.links
    first = last = b
    while first > 0 and bodies[first].mass > 0.0 and links[first - 1].rests > 0.0:
        first -= 1
    while last < chain.table.shape[1] and links[last].rests > 0.0 and (last == first or bodies[last].mass > 0.0):
        last += 1
    return first, last


@kernel
def mean_of(chain, first, last, n):
    """Mean of coefficient ``n`` of these buildings' series, weighted by mass, or that of a rigid one among them.

    Below zero n stands for their velocities after a jump. A mirrored row adds in the same order.
    """
    bodies = chain.bodies
    mass = total = 0.0
    low, high = first, last
    while low <= high:
        one, other = bodies[low], bodies[high]
        left = one.series[n] if n >= 0 else one.after
        right = other.series[n] if n >= 0 else other.after
        if one.mass == 0.0 and low == first:
            return left
        if other.mass == 0.0 and high == last:
            return right
        if low < high:
            mass += one.mass + other.mass
            total += one.mass * left + other.mass * right
        else:
            mass += one.mass
            total += one.mass * left
        low, high = low + 1, high - 1
    return total / mass


@kernel
def move_as_one(chain, first, last, ground, n):
    """Accelerations of buildings that move as one from those that each would have alone; and the forces between them.

    Coefficient ``n`` − 2 of either: that of an acceleration stands in place ``n`` of its building's series.
    """
    bodies, links = chain.bodies, chain.links
    moved = 0.0
    for b in range(first + 1, last + 1):
        if n < 4:
            moved += ground.ground_moves(b)[n]  # ẅ, and its slope
            bodies[b].series[n] += moved
    common = mean_of(chain, first, last, n)
    from_left = from_right = 0.0
    for i in range(first, last):
        from_left += bodies[i].mass * (bodies[i].series[n] - common)
        links[i].force[n - 2] = from_left
    for i in range(last - 1, first - 1, -1):
        from_right -= bodies[i + 1].mass * (bodies[i + 1].series[n] - common)
        side = 2 * i - (first + last - 1)
        if bodies[first].mass == 0.0 or (side > 0 and bodies[last].mass > 0.0):
            links[i].force[n - 2] = from_right
        elif side == 0 and bodies[last].mass > 0.0:
            links[i].force[n - 2] = 0.5 * (links[i].force[n - 2] + from_right)
    moved = 0.0
    for b in range(first, last + 1):
        if n < 4 and b > first:
            moved += ground.ground_moves(b)[n]
        bodies[b].series[n] = common - moved if bodies[b].mass > 0.0 else 0.0


@kernel
def write_group(chain, first, last, since, ground, terms):
    """Series of a building, or of some that move as one, from their u and v; ``ground`` begins at ``since``."""
    bodies = chain.bodies
    for b in range(first, last + 1):
        body = bodies[b]
        if body.mass > 0.0:
            body.since = since
            body.pull, body.rise = ground.under(b)
            body.series[0], body.series[1] = body.u, body.v
    for n in range(2, terms):
        for b in range(first, last + 1):
            body = bodies[b]
            if body.mass > 0.0:
                load = body.pull if n == 2 else (body.rise if n == 3 else 0.0)
                drag = body.two_zeta_omega * ((n - 1) * body.series[n - 1])
                body.series[n] = -(drag + body.omega2 * body.series[n - 2] + load)
        if last > first:
            move_as_one(chain, first, last, ground, n)
        for b in range(first, last + 1):
            bodies[b].series[n] *= SHARES[n]
    if last > first:
        chain.totals.steps += 1.0


@kernel
def write_groups(chain, first, last, since, ground, terms):
    """`write_group` of all groups of these buildings."""
    b = first
    while b <= last:
        begin, end = group_of(chain, b)
        write_group(chain, begin, end, since, ground, terms)
        # A rigid building that ends a group may begin the next.
        b = end if end > b and chain.bodies[end].mass == 0.0 else end + 1


@kernel
def advance(chain, b, t, terms):
    """u and v of building ``b`` become those at ``t``, on its series."""
    body = chain.bodies[b]
    if body.mass > 0.0:
        x = t - body.since
        body.u, body.v = place_of(body, terms, x), speed_of(body, terms, x)


# ------------------------------------------------------------------------------------------------ peaks and events


@kernel
def move_series(body, terms, x, search, row):
    """The series of a building with its x counted from ``x`` on, to a row of the workspace."""
    for n in range(terms):
        search.series[row, n] = body.series[n]
    if x > 0.0 and body.mass > 0.0:
        for k in range(terms - 1):
            for n in range(terms - 2, k - 1, -1):
                search.series[row, n] += x * search.series[row, n + 1]


@kernel
def write_distance(chain, i, since, ground, terms):
    """The series of u_left − u_right − w of interface ``i`` from ``since`` on; ``ground`` begins at the node."""
    left, right, search = chain.bodies[i], chain.bodies[i + 1], chain.totals.search
    move_series(left, terms, since - left.since, search, LEFT)
    move_series(right, terms, since - right.since, search, RIGHT)
    for n in range(terms):
        search.series[SIGNAL, n] = search.series[LEFT, n] - search.series[RIGHT, n]
    w, rate, bend, twist = ground.later(since).ground_moves(i + 1)
    search.series[SIGNAL, 0] -= w
    search.series[SIGNAL, 1] -= rate
    search.series[SIGNAL, 2] -= 0.5 * bend
    search.series[SIGNAL, 3] -= twist / 6.0


@kernel
def raise_body(chain, b, t, terms):
    """Raise the peaks of building ``b`` by those from the start of its series to ``t``."""
    body, search = chain.bodies[b], chain.totals.search
    x = t - body.since
    if body.mass == 0.0 or x <= 0.0:
        return
    reach, shake, power = 0.0, abs(body.pull) + abs(body.rise) * x, 1.0
    for n in range(terms):
        reach += abs(body.series[n]) * power
        if n + 2 < terms:
            shake += (n + 1) * (n + 2) * abs(body.series[n + 2]) * power
        power *= x
    # Put so that what is not finite is searched.
    if not reach <= body.peak_displacement:
        move_series(body, terms, 0.0, search, SIGNAL)
        for sign in (1.0, -1.0):
            body.peak_displacement = highest(search, SIGNAL, terms, sign, x, body.peak_displacement)
    if not shake <= body.peak_acceleration:
        for n in range(terms - 2):
            search.series[SIGNAL, n] = (n + 1) * (n + 2) * body.series[n + 2]
        search.series[SIGNAL, 0] += body.pull
        search.series[SIGNAL, 1] += body.rise
        for sign in (1.0, -1.0):
            body.peak_acceleration = highest(search, SIGNAL, terms - 2, sign, x, body.peak_acceleration)


@small
def since_of(chain, i):
    """Where the distance at interface ``i`` begins to be that of both series, after the node [s]."""
    return max(chain.bodies[i].since, chain.bodies[i + 1].since)


@kernel
def raise_link(chain, i, t, ground, terms):
    """Raise the extremes of interface ``i`` by those up to ``t``; at rest, its force and impulse."""
    link, search = chain.links[i], chain.totals.search
    since = since_of(chain, i)
    x = t - since
    if x <= 0.0:
        return
    if link.rests > 0.0:
        push, link.acting, power = 0.0, 0.0, 1.0
        for n in range(terms - 2):
            search.series[SIGNAL, n] = link.force[n]
            link.acting += link.force[n] * power
            power *= x
            push += link.force[n] * power / (n + 1)
        link.counters[IMPULSE] += push
        link.strongest = highest(search, SIGNAL, terms - 2, 1.0, x, link.strongest)
        link.acting = max(link.acting, 0.0)
        return
    write_distance(chain, i, since, ground, terms)
    spread, power = 0.0, x
    for n in range(1, terms):
        spread += abs(search.series[SIGNAL, n]) * power
        power *= x
    centre = search.series[SIGNAL, 0]
    if not centre + spread <= link.highest:
        link.highest = highest(search, SIGNAL, terms, 1.0, x, link.highest)
    if not centre - spread >= link.lowest:
        link.lowest = -highest(search, SIGNAL, terms, -1.0, x, -link.lowest)


@kernel
def plan_event(chain, i, ground, width, terms):
    """Find the next event of interface ``i`` in the interval: its touch, or the end of its rest; infinite for none."""
    link, search = chain.links[i], chain.totals.search
    link.next_event = inf
    since = since_of(chain, i)
    if since >= width or chain.bodies[i].mass + chain.bodies[i + 1].mass == 0.0:
        return
    if link.rests > 0.0:
        for n in range(terms - 2):
            search.series[SIGNAL, n] = -link.force[n]
        root = first_rise(search, terms - 2, 0.0, width - since)
    else:
        write_distance(chain, i, since, ground, terms)
        root = first_rise(search, terms, link.gap, width - since)
    if root >= 0.0:
        link.next_event = since + root


@kernel
def is_closed(chain, i, t, ground, terms):
    """True where an interface rests at ``t``, or is closed but for rounding."""
    left, right, link = chain.bodies[i], chain.bodies[i + 1], chain.links[i]
    if link.rests > 0.0:
        return True
    if left.mass + right.mass == 0.0:
        return False
    one, other = place_of(left, terms, t - left.since), place_of(right, terms, t - right.since)
    # Of the largest displacements so far: those of the moment may be none at all.
    rounding = ROUNDING * (left.peak_displacement + right.peak_displacement + link.gap)
    return one - other - ground.later(t).ground_moves(i + 1)[0] >= link.gap - rounding


@kernel
def chain_at(chain, i, t, ground, terms):
    """(first, last) interface of those closed at ``t`` in a line with ``i``, up to rigid buildings."""
    bodies, end = chain.bodies, chain.table.shape[1] - 1
    first = last = i
    while first > 0 and bodies[first].mass > 0.0 and is_closed(chain, first - 1, t, ground, terms):
        first -= 1
    while last < end and bodies[last + 1].mass > 0.0 and is_closed(chain, last + 1, t, ground, terms):
        last += 1
    return first, last


# ------------------------------------------------------------------------------------------------ jumps


@small
def rule_of(link):
    """The relation of restitution of an interface."""
    return Restitution(link.rule[0], link.rule[1], link.rule[2], link.rule[3], link.rule[4])


@kernel
def energy_of(chain, first, last):
    """Kinetic and potential energy of these buildings [J]; a mirrored row adds in the same order."""
    bodies, total = chain.bodies, 0.0
    low, high = first, last
    while low <= high:
        one, other = bodies[low], bodies[high]
        energy = 0.5 * one.mass * (one.v * one.v + one.omega2 * one.u * one.u)
        if low < high:
            energy += 0.5 * other.mass * (other.v * other.v + other.omega2 * other.u * other.u)
        total += energy
        low, high = low + 1, high - 1
    return total


@kernel
def begin_jump(chain, first, last, t, now):
    """Closing speeds, targets and compliances of the interfaces of a chain; its buildings stand at ``t``."""
    bodies, links, table = chain.bodies, chain.links, chain.table
    for i in range(first, last + 1):
        link, left, right = links[i], bodies[i], bodies[i + 1]
        link.is_event = 1.0 if link.next_event <= t else 0.0
        link.closing = left.v - right.v - now.ground_moves(i + 1)[1] if link.rests == 0.0 else 0.0
        speed = max(link.closing, 0.0)
        link.target = rule_of(link).at(speed) * speed if link.rests == 0.0 else 0.0
        table[DIAGONAL, i] = left.inverse + right.inverse
        table[COUPLING, i] = -right.inverse


@kernel
def find_impulses(chain, first, last, all_slow):
    """Impulses of a chain and the velocities after them; slow interfaces, or all, without a rebound."""
    bodies, links, table = chain.bodies, chain.links, chain.table
    for i in range(first, last + 1):
        rebound = 0.0 if all_slow or links[i].slow > 0.0 else links[i].target
        table[GIVEN, i] = -links[i].closing - rebound
    solve_complementarity(table, first, last)
    for i in range(first, last + 1):
        links[i].jump = table[ANSWER, i]
    for b in range(first, last + 2):
        before = links[b - 1].jump if b > first else 0.0
        after = links[b].jump if b <= last else 0.0
        bodies[b].after = bodies[b].v + (before - after) * bodies[b].inverse


@small
def closing_acceleration(chain, i, now):
    """ü_left − ü_right − ẅ that two buildings would have alone after a jump."""
    left, right = chain.bodies[i], chain.bodies[i + 1]
    one = left.two_zeta_omega * left.after + left.omega2 * left.u + now.under(i)[0] if left.mass > 0.0 else 0.0
    other = 0.0
    if right.mass > 0.0:
        other = right.two_zeta_omega * right.after + right.omega2 * right.u + now.under(i + 1)[0]
    return (other - one) - now.ground_moves(i + 1)[2]


@kernel
def mark_slow(chain, first, last, now, rtol):
    """Mark the interfaces whose rebound is too slow or too low to be one, should they be pressed."""
    bodies, links, table = chain.bodies, chain.links, chain.table
    find_impulses(chain, first, last, True)
    for i in range(first, last + 1):
        table[GIVEN, i] = -closing_acceleration(chain, i, now)
    solve_complementarity(table, first, last)
    for i in range(first, last + 1):
        link, back = links[i], links[i].target
        # A bounce of speed w under the acceleration A rises by w² / (2 A): A = G F of the force if all stayed closed.
        height = ROUNDING * (abs(bodies[i].u) + abs(bodies[i + 1].u))
        low = 2.0 * table[DIAGONAL, i] * table[ANSWER, i] * height
        link.slow = 1.0 if link.rests > 0.0 or back <= rtol * link.fastest or back * back <= low else 0.0


@kernel
def find_forces(chain, first, last, now):
    """Which slow interfaces press after the jump, in ``presses``; returns whether one of the others must rebound.

    An interface that comes to the end of its rest does not press.
    """
    links, table = chain.links, chain.table
    for i in range(first, last + 1):
        link = links[i]
        ends = link.rests > 0.0 and link.is_event > 0.0
        stays = link.slow > 0.0 and not ends and (table[ANSWER, i] > 0.0 or table[SLACK, i] <= 0.0)
        table[GIVEN, i] = -closing_acceleration(chain, i, now) if stays else inf
    solve_complementarity(table, first, last)
    again = False
    for i in range(first, last + 1):
        link = links[i]
        link.presses = 1.0 if table[ANSWER, i] > 0.0 else 0.0
        if link.presses == 0.0 and link.slow > 0.0 and link.target > 0.0:
            link.slow = 0.0
            again = True
    return again


@kernel
def share_velocity(chain, first, last, now):
    """Buildings that press on each other after a jump get one velocity, to the bit."""
    bodies, links = chain.bodies, chain.links
    b = first
    while b <= last:
        end = b
        while end <= last and links[end].presses > 0.0:
            end += 1
        moved = 0.0
        for member in range(b + 1, end + 1):
            moved += now.ground_moves(member)[1]
            bodies[member].after += moved
        if end > b:
            common = mean_of(chain, b, end, -1)
            moved = 0.0
            for member in range(b, end + 1):
                if member > b:
                    moved += now.ground_moves(member)[1]
                bodies[member].after = common - moved if bodies[member].mass > 0.0 else 0.0
        b = end + 1


@kernel
def note_jump(chain, i, time):
    """Enter the jump of interface ``i`` in its counters; returns the energy that it takes, and gives to the grounds.

    A contact begins where an interface touches, and where one that is closed is struck.
    """
    link, left, right = chain.links[i], chain.bodies[i], chain.bodies[i + 1]
    counters = link.counters
    if link.rests > 0.0 and link.presses == 0.0:
        end_rest(link, time)
    elif link.rests == 0.0 and (link.is_event > 0.0 or link.jump > 0.0):
        speed = max(link.closing, 0.0)
        if counters[COUNT] == 0.0:
            counters[FIRST_TOUCH] = time
        counters[COUNT] += 1.0
        counters[APPROACH] = max(counters[APPROACH], speed)
        counters[HELD] += 1.0 if rule_of(link).beyond(speed) else 0.0
        link.begun, link.came_at, link.strongest = time, speed, 0.0
        link.highest = max(link.highest, link.gap)
    counters[IMPULSE] += link.jump
    if link.jump > 0.0 or link.presses > 0.0:
        left.hit = right.hit = 1.0
    # Seen from the own grounds the relative velocity is the closing speed and ẇ.
    ground_speed = (left.v - right.v) - link.closing
    closing_after = (left.after - right.after) - ground_speed
    loss = 0.5 * link.jump * (link.closing + closing_after)
    counters[VISCOUS] += loss
    return loss + link.jump * ground_speed


@kernel
def end_rest(link, time):
    """Enter the end of a rest in the counters."""
    link.counters[CONTACT_TIME] += time - link.begun
    link.counters[PEAK_FORCE] = max(link.counters[PEAK_FORCE], link.strongest)
    link.has_rested = 1.0


@kernel
def place_on_walls(chain, first, last, now):
    """Put buildings that come to rest in line with a rigid one where the gaps have them, to the bit."""
    bodies, links = chain.bodies, chain.links
    if bodies[first].mass == 0.0:
        for i in range(first, last + 1):
            if links[i].rests == 0.0:
                break
            bodies[i + 1].u = bodies[i].u - now.ground_moves(i + 1)[0] - links[i].gap
    if bodies[last + 1].mass == 0.0:
        for i in range(last, first - 1, -1):
            if links[i].rests == 0.0:
                break
            bodies[i].u = bodies[i + 1].u + now.ground_moves(i + 1)[0] + links[i].gap


@kernel
def set_apart(chain, first, last, now):
    """Set buildings that are not at rest on each other further apart by a rounding, and out of each other.

    Of two, the one that rests on something else stays.
    """
    bodies, links = chain.bodies, chain.links
    for i in range(first, last + 1):
        link, left, right = links[i], bodies[i], bodies[i + 1]
        if link.rests == 0.0:
            left_stays = i > 0 and links[i - 1].rests > 0.0
            right_stays = i < chain.table.shape[1] - 1 and links[i + 1].rests > 0.0
            inside = (left.u - right.u) - now.ground_moves(i + 1)[0] - link.gap
            clear = CLEAR * (abs(left.u) + abs(right.u) + link.gap) + max(inside, 0.0)
            if left.mass > 0.0 and (right_stays or right.mass == 0.0 or not left_stays):
                left.u -= clear
            if right.mass > 0.0 and (left_stays or left.mass == 0.0 or not right_stays):
                right.u += clear


@kernel
def jump(chain, i, t, window, rtol, terms):
    """The event of interface ``i`` at ``t`` after the node, with all interfaces that are closed in a line with it.

    ``window`` = (time of the node, time to the next, ground motion from there). Returns False where the run ends:
    a watched interface is touched, or one touches without end.
    """
    moment, width, ground = window
    bodies, links, totals = chain.bodies, chain.links, chain.totals
    first, last = chain_at(chain, i, t, ground, terms)
    time, now = moment + t, ground.later(t)
    low, high = max(first - 1, 0), min(last + 1, chain.table.shape[1] - 1)
    for k in range(low, high + 1):
        raise_link(chain, k, t, ground, terms)
    for b in range(first, last + 2):
        raise_body(chain, b, t, terms)
        advance(chain, b, t, terms)
    begin_jump(chain, first, last, t, now)
    for k in range(first, last + 1):
        if links[k].watched > 0.0 and links[k].rests == 0.0:
            totals.status, totals.watched_point = float(WATCHED), float(k)
            return False
    if chain.log.shape[0] > 0:
        write_line(chain, first, last + 1, time * JUST_BEFORE, False)
    mark_slow(chain, first, last, now, rtol)
    again = True
    while again:
        find_impulses(chain, first, last, False)
        again = find_forces(chain, first, last, now)
    share_velocity(chain, first, last, now)
    before = energy_of(chain, first, last + 1)
    taken = 0.0
    one, other = first, last
    while one <= other:
        taken += note_jump(chain, one, time) + (note_jump(chain, other, time) if one < other else 0.0)
        one, other = one + 1, other - 1
    for b in range(first, last + 2):
        bodies[b].v = bodies[b].after
    after = energy_of(chain, first, last + 1)
    totals.energy = max(totals.energy, before, after)
    totals.residual += (after - before) + taken
    for k in range(first, last + 1):
        links[k].rests, links[k].acting = links[k].presses, 0.0
    place_on_walls(chain, first, last, now)
    set_apart(chain, first, last, now)
    write_groups(chain, first, last + 1, t, now, terms)
    for k in range(low, high + 1):
        plan_event(chain, k, ground, width, terms)
    for k in range(first, last + 1):
        if links[k].rests > 0.0:
            links[k].acting = max(links[k].force[0], 0.0)
            links[k].strongest = max(links[k].strongest, links[k].acting)
        if links[k].counters[COUNT] > MAX_CONTACTS:
            totals.status = float(TOO_MANY_CONTACTS)
            return False
    if chain.log.shape[0] > 0:
        write_line(chain, first, last + 1, time, True)
    return True


# ------------------------------------------------------------------------------------------------ run


@kernel
def write_line(chain, first, last, time, jumped):
    """A line of the log: these buildings now; with ``jumped`` contacts that begin and end at once are in it."""
    bodies, links, log, totals = chain.bodies, chain.links, chain.log, chain.totals
    line = int(totals.lines_written)
    totals.lines_written += 1.0
    if line >= log.shape[0]:
        return
    for place in range(log.shape[1]):
        log[line, place] = nan
    log[line, WHEN], log[line, WHOSE] = time, float(first)
    masses = (log.shape[1] - MOVED - NOTED * chain.table.shape[1]) // 2
    for b in range(first, last + 1):
        if bodies[b].mass > 0.0:
            log[line, MOVED + int(bodies[b].dof)] = bodies[b].u
            log[line, MOVED + masses + int(bodies[b].dof)] = bodies[b].v
    for k in range(first, last):
        link, place = links[k], MOVED + 2 * masses + NOTED * k
        log[line, place + ACTING], log[line, place + SO_FAR] = 0.0, link.counters[IMPULSE]
        if link.rests > 0.0 or (jumped and link.begun == time and link.counters[COUNT] > 0.0):
            log[line, place + ACTING] = link.acting if link.rests > 0.0 else 0.0
            log[line, place + BEGAN], log[line, place + CAME_AT] = link.begun, link.came_at
            log[line, place + STRONGEST] = max(link.strongest, link.acting) if link.rests > 0.0 else nan


@kernel
def first_event(chain):
    """The interface whose event comes first in the interval, the leftmost of several, or −1."""
    earliest, best = inf, -1
    for i in range(chain.table.shape[1]):
        if chain.links[i].next_event < earliest:
            earliest, best = chain.links[i].next_event, i
    return best


@kernel
def cross_interval(chain, window, rtol, terms):
    """All buildings over one node interval, with its jumps; returns False where the run ends."""
    moment, width, ground = window
    buildings = chain.table.shape[1] + 1
    for b in range(buildings):
        chain.bodies[b].since = 0.0
    write_groups(chain, 0, buildings - 1, 0.0, ground, terms)
    for i in range(buildings - 1):
        plan_event(chain, i, ground, width, terms)
    i = first_event(chain)
    while i >= 0:
        if not jump(chain, i, chain.links[i].next_event, window, rtol, terms):
            return False
        i = first_event(chain)
    for i in range(buildings - 1):
        raise_link(chain, i, width, ground, terms)
    for b in range(buildings):
        raise_body(chain, b, width, terms)
        advance(chain, b, width, terms)
    if chain.log.shape[0] > 0:
        b = 0
        while b < buildings:
            first, last = group_of(chain, b)
            if last > first:
                write_line(chain, first, last, moment + width, False)
            b = last if last > b and chain.bodies[last].mass == 0.0 else last + 1
    return True


@kernel
def march_jumps(chain, ground, step, terms, rtol, states):
    """One run from u and v of the bodies to the end of the record; those at nodes to ``states`` if it has rows."""
    states = borrowed(states)
    bodies, links, totals = chain.bodies, chain.links, chain.totals
    totals.watched_point = -1.0
    for i in range(chain.table.shape[1]):
        links[i].counters[FIRST_TOUCH] = links[i].counters[FIRST_YIELD] = nan
    nodes = ground.node_count() - 1
    for node in range(nodes):
        window = ground.node_time(step, node), ground.node_width(step, node), ground.from_node(step, node)
        if not cross_interval(chain, window, rtol, terms):
            break
        for b in range(chain.table.shape[1] + 1):
            if states.shape[0] > node + 1:
                states[node + 1, 0, b], states[node + 1, 1, b] = bodies[b].u, bodies[b].v
    end_jumps(chain, ground.node_time(step, nodes), rtol)


@kernel
def end_jumps(chain, time, rtol):
    """Close the contacts that outlast the record, and set the status where nothing has set it."""
    totals, size = chain.totals, 0.0
    for b in range(chain.table.shape[1] + 1):
        body = chain.bodies[b]
        size += abs(body.u) + abs(body.v) + body.peak_displacement + body.peak_acceleration
    for i in range(chain.table.shape[1]):
        link = chain.links[i]
        if link.rests > 0.0 and totals.status == COMPLETE:
            end_rest(link, time)
        size += abs(link.highest) + abs(link.lowest) + link.counters[IMPULSE]
        if link.counters[COUNT] > 0.0:
            # A jump has no finite force: the largest is that of a rest, if there has been one.
            link.counters[DEMAND] = nan
            link.counters[PEAK_FORCE] = link.counters[PEAK_FORCE] if link.has_rested > 0.0 else nan
    if totals.status != COMPLETE:
        return
    if not size < inf:
        totals.status = float(NOT_FINITE)
    elif not abs(totals.residual) <= (OPEN_SHARE * rtol + OPEN_FLOOR) * totals.energy:
        totals.status = float(ENERGY_OPEN)
