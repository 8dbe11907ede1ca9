"""Jumps: impulses of the interfaces that are closed at a touch, and which of them press afterwards.

At a touch all interfaces that are closed then, and those at rest, form a chain that ends at rigid buildings. With c the
closing speed before and s the separation speed after, the impulses P are those of Newton's restitution as one linear
complementarity problem (Moreau 1988; Glocker 2004):

    s − e c ≥ 0,   P ≥ 0,   P (s − e c) = 0,   s = −c + G P.

With c ≥ 0 at what has just closed, a chain never gains energy: each interface takes (1 − e) c P / 2. What rebounds
slower than rtol times the row's fastest free closing speed, or no higher than displacements round by, does not rebound
where it is pressed: which interfaces are, the forces tell, by the same problem on accelerations (Pfeiffer and Glocker
1996). They rest until their force would be tension.
"""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel, small
from pounding_risk.models.restitution import Restitution
from pounding_risk.solver.counters import (
    APPROACH,
    CONTACT_TIME,
    COUNT,
    FIRST_TOUCH,
    HELD,
    IMPULSE,
    MAX_CONTACTS,
    PEAK_FORCE,
    TOO_MANY_CONTACTS,
    VISCOUS,
)
from pounding_risk.solver.pair.joined import ROUNDING
from pounding_risk.solver.row.complementarity import ANSWER, COUPLING, DIAGONAL, GIVEN, SLACK, solve_complementarity
from pounding_risk.solver.row.impulsive.events import chain_at, plan_event, raise_body_peaks, raise_link_extremes
from pounding_risk.solver.row.impulsive.motion import advance, weighted_mean, write_groups
from pounding_risk.solver.row.impulsive.state import write_line
from pounding_risk.solver.row.run import WATCHED

CLEAR = 4e-16  # of the displacements: so far apart are set what part, lest rounding make them touch at once
JUST_BEFORE = 1.0 - 4e-16  # of the time of a jump: when the log has the state before it


@small
def rule_of(link):
    """The relation of restitution e(v) of an interface, from the numbers in its record."""
    return Restitution(link.rule[0], link.rule[1], link.rule[2], link.rule[3], link.rule[4])


@kernel
def energy_of(chain, first, last):
    """Kinetic and potential energy of these buildings [J]; a mirrored row adds in the same order."""
    bodies, total = chain.bodies, 0.0
    low, high = first, last
    while low <= high:
        low_body, high_body = bodies[low], bodies[high]
        energy = 0.5 * low_body.mass * (low_body.v * low_body.v + low_body.omega2 * low_body.u * low_body.u)
        if low < high:
            energy += 0.5 * high_body.mass * (high_body.v * high_body.v + high_body.omega2 * high_body.u * high_body.u)
        total += energy
        low, high = low + 1, high - 1
    return total


@kernel
def begin_jump(chain, first, last, t, ground_now):
    """Closing speeds, targets and compliances of the interfaces of a chain; its buildings stand at ``t``."""
    bodies, links, table = chain.bodies, chain.links, chain.table
    for i in range(first, last + 1):
        link, left, right = links[i], bodies[i], bodies[i + 1]
        link.is_event = 1.0 if link.next_event <= t else 0.0
        link.closing = left.v - right.v - ground_now.ground_moves(i + 1)[1] if link.rests == 0.0 else 0.0
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
        links[i].impulse = table[ANSWER, i]
    for b in range(first, last + 2):
        left_impulse = links[b - 1].impulse if b > first else 0.0
        right_impulse = links[b].impulse if b <= last else 0.0
        bodies[b].velocity_after = bodies[b].v + (left_impulse - right_impulse) * bodies[b].inverse


@small
def closing_acceleration(chain, i, ground_now):
    """ü_left − ü_right − ẅ that two buildings would have alone after a jump."""
    left, right = chain.bodies[i], chain.bodies[i + 1]
    left_pull = (
        left.two_zeta_omega * left.velocity_after + left.omega2 * left.u + ground_now.under(i)[0]
        if left.mass > 0.0
        else 0.0
    )
    right_pull = 0.0
    if right.mass > 0.0:
        right_pull = right.two_zeta_omega * right.velocity_after + right.omega2 * right.u + ground_now.under(i + 1)[0]
    return (right_pull - left_pull) - ground_now.ground_moves(i + 1)[2]


@kernel
def mark_slow(chain, first, last, ground_now, rtol):
    """Mark the interfaces whose rebound is too slow or too low to be one, should they be pressed."""
    bodies, links, table = chain.bodies, chain.links, chain.table
    find_impulses(chain, first, last, True)
    for i in range(first, last + 1):
        table[GIVEN, i] = -closing_acceleration(chain, i, ground_now)
    solve_complementarity(table, first, last)
    for i in range(first, last + 1):
        link, rebound = links[i], links[i].target
        # A bounce of speed w under the acceleration A rises by w² / (2 A): A = G F of the force if all stayed closed.
        height = ROUNDING * (abs(bodies[i].u) + abs(bodies[i + 1].u))
        least_square = 2.0 * table[DIAGONAL, i] * table[ANSWER, i] * height
        link.slow = (
            1.0 if link.rests > 0.0 or rebound <= rtol * link.fastest or rebound * rebound <= least_square else 0.0
        )


@kernel
def find_forces(chain, first, last, ground_now):
    """Which slow interfaces press after the jump, in ``presses``; returns whether one of the others must rebound.

    An interface that comes to the end of its rest does not press.
    """
    links, table = chain.links, chain.table
    for i in range(first, last + 1):
        link = links[i]
        ends = link.rests > 0.0 and link.is_event > 0.0
        stays = link.slow > 0.0 and not ends and (table[ANSWER, i] > 0.0 or table[SLACK, i] <= 0.0)
        table[GIVEN, i] = -closing_acceleration(chain, i, ground_now) if stays else inf
    solve_complementarity(table, first, last)
    must_rebound = False
    for i in range(first, last + 1):
        link = links[i]
        link.presses = 1.0 if table[ANSWER, i] > 0.0 else 0.0
        if link.presses == 0.0 and link.slow > 0.0 and link.target > 0.0:
            link.slow = 0.0
            must_rebound = True
    return must_rebound


@kernel
def share_velocity(chain, first, last, ground_now):
    """Buildings that press on each other after a jump get one velocity, to the bit."""
    bodies, links = chain.bodies, chain.links
    b = first
    while b <= last:
        end = b
        while end <= last and links[end].presses > 0.0:
            end += 1
        ground_speed = 0.0
        for member in range(b + 1, end + 1):
            ground_speed += ground_now.ground_moves(member)[1]
            bodies[member].velocity_after += ground_speed
        if end > b:
            common = weighted_mean(chain, b, end, -1)
            ground_speed = 0.0
            for member in range(b, end + 1):
                if member > b:
                    ground_speed += ground_now.ground_moves(member)[1]
                bodies[member].velocity_after = common - ground_speed if bodies[member].mass > 0.0 else 0.0
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
    elif link.rests == 0.0 and (link.is_event > 0.0 or link.impulse > 0.0):
        speed = max(link.closing, 0.0)
        if counters[COUNT] == 0.0:
            counters[FIRST_TOUCH] = time
        counters[COUNT] += 1.0
        counters[APPROACH] = max(counters[APPROACH], speed)
        counters[HELD] += 1.0 if rule_of(link).beyond(speed) else 0.0
        link.touch_time, link.approach_speed, link.peak_force = time, speed, 0.0
        link.highest = max(link.highest, link.gap)
    counters[IMPULSE] += link.impulse
    if link.impulse > 0.0 or link.presses > 0.0:
        left.has_been_struck = right.has_been_struck = 1.0
    # Seen from the own grounds the relative velocity is the closing speed and ẇ.
    ground_speed = (left.v - right.v) - link.closing
    closing_after = (left.velocity_after - right.velocity_after) - ground_speed
    loss = 0.5 * link.impulse * (link.closing + closing_after)
    counters[VISCOUS] += loss
    return loss + link.impulse * ground_speed


@kernel
def end_rest(link, time):
    """Enter the end of a rest at ``time`` [s] in the counters of an interface: contact time and largest force."""
    link.counters[CONTACT_TIME] += time - link.touch_time
    link.counters[PEAK_FORCE] = max(link.counters[PEAK_FORCE], link.peak_force)
    link.has_rested = 1.0


@kernel
def place_on_walls(chain, first, last, ground_now):
    """Put buildings that come to rest in line with a rigid one where the gaps have them, to the bit."""
    bodies, links = chain.bodies, chain.links
    if bodies[first].mass == 0.0:
        for i in range(first, last + 1):
            if links[i].rests == 0.0:
                break
            bodies[i + 1].u = bodies[i].u - ground_now.ground_moves(i + 1)[0] - links[i].gap
    if bodies[last + 1].mass == 0.0:
        for i in range(last, first - 1, -1):
            if links[i].rests == 0.0:
                break
            bodies[i].u = bodies[i + 1].u + ground_now.ground_moves(i + 1)[0] + links[i].gap


@kernel
def set_apart(chain, first, last, ground_now):
    """Set buildings that are not at rest on each other further apart by a rounding, and out of each other.

    Of two, the one that rests on something else stays.
    """
    bodies, links = chain.bodies, chain.links
    for i in range(first, last + 1):
        link, left, right = links[i], bodies[i], bodies[i + 1]
        if link.rests == 0.0:
            left_stays = i > 0 and links[i - 1].rests > 0.0
            right_stays = i < chain.table.shape[1] - 1 and links[i + 1].rests > 0.0
            overlap = (left.u - right.u) - ground_now.ground_moves(i + 1)[0] - link.gap
            clear = CLEAR * (abs(left.u) + abs(right.u) + link.gap) + max(overlap, 0.0)
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
    time, ground_now = moment + t, ground.later(t)
    low, high = max(first - 1, 0), min(last + 1, chain.table.shape[1] - 1)
    for k in range(low, high + 1):
        raise_link_extremes(chain, k, t, ground, terms)
    for b in range(first, last + 2):
        raise_body_peaks(chain, b, t, terms)
        advance(chain, b, t, terms)
    begin_jump(chain, first, last, t, ground_now)
    for k in range(first, last + 1):
        if links[k].watched > 0.0 and links[k].rests == 0.0:
            totals.status, totals.watched_point = float(WATCHED), float(k)
            return False
    if chain.log.shape[0] > 0:
        write_line(chain, first, last + 1, time * JUST_BEFORE, False)
    mark_slow(chain, first, last, ground_now, rtol)
    must_rebound = True
    while must_rebound:
        find_impulses(chain, first, last, False)
        must_rebound = find_forces(chain, first, last, ground_now)
    share_velocity(chain, first, last, ground_now)
    energy_before = energy_of(chain, first, last + 1)
    energy_lost = 0.0
    left, right = first, last
    while left <= right:
        energy_lost += note_jump(chain, left, time) + (note_jump(chain, right, time) if left < right else 0.0)
        left, right = left + 1, right - 1
    for b in range(first, last + 2):
        bodies[b].v = bodies[b].velocity_after
    energy_after = energy_of(chain, first, last + 1)
    totals.energy = max(totals.energy, energy_before, energy_after)
    totals.residual += (energy_after - energy_before) + energy_lost
    for k in range(first, last + 1):
        links[k].rests, links[k].acting_force = links[k].presses, 0.0
    place_on_walls(chain, first, last, ground_now)
    set_apart(chain, first, last, ground_now)
    write_groups(chain, first, last + 1, t, ground_now, terms)
    for k in range(low, high + 1):
        plan_event(chain, k, ground, width, terms)
    for k in range(first, last + 1):
        if links[k].rests > 0.0:
            links[k].acting_force = max(links[k].force[0], 0.0)
            links[k].peak_force = max(links[k].peak_force, links[k].acting_force)
        if links[k].counters[COUNT] > MAX_CONTACTS:
            totals.status = float(TOO_MANY_CONTACTS)
            return False
    if chain.log.shape[0] > 0:
        write_line(chain, first, last + 1, time, True)
    return True
