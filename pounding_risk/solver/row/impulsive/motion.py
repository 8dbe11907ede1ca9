"""Motion of single masses between two jumps, alone or as one with neighbours that they press on.

Between two jumps every mass moves alone, or as one with neighbours that it presses on. Over a node interval with linear
a_g that motion is its own Taylor series. Of masses that move as one, with A_b what each would do alone and X_b the
displacement of its ground relative to that of the first,

    Y = Σ m_b (A_b + Ẍ_b) / Σ m_b,   ü_b = Y − Ẍ_b,   F_i = Σ_{b ≤ i} m_b (A_b + Ẍ_b − Y)

order by order; a rigid building among them has Y = Ẍ of its own. F_i is the force at interface i.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.taylor import SHARES


@small
def displacement_of(body, terms, x):
    """Displacement [m] of a building at ``x`` [s] after the start of its series."""
    total = 0.0
    for n in range(terms - 1, -1, -1):
        total = total * x + body.series[n]
    return total


@small
def velocity_of(body, terms, x):
    """Velocity [m/s] of a building at ``x`` [s] after the start of its series."""
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
def weighted_mean(chain, first, last, n):
    """Mean of coefficient ``n`` of these buildings' series, weighted by mass, or that of a rigid one among them.

    Below zero n stands for their velocities after a jump. A mirrored row adds in the same order.
    """
    bodies = chain.bodies
    mass = total = 0.0
    low, high = first, last
    while low <= high:
        low_body, high_body = bodies[low], bodies[high]
        left = low_body.series[n] if n >= 0 else low_body.velocity_after
        right = high_body.series[n] if n >= 0 else high_body.velocity_after
        if low_body.mass == 0.0 and low == first:
            return left
        if high_body.mass == 0.0 and high == last:
            return right
        if low < high:
            mass += low_body.mass + high_body.mass
            total += low_body.mass * left + high_body.mass * right
        else:
            mass += low_body.mass
            total += low_body.mass * left
        low, high = low + 1, high - 1
    return total / mass


@kernel
def move_as_one(chain, first, last, ground, n):
    """Accelerations of buildings that move as one from those that each would have alone; and the forces between them.

    Coefficient ``n`` − 2 of either: that of an acceleration stands in place ``n`` of its building's series.
    """
    bodies, links = chain.bodies, chain.links
    ground_part = 0.0
    for b in range(first + 1, last + 1):
        if n < 4:
            ground_part += ground.ground_moves(b)[n]  # ẅ, and its slope
            bodies[b].series[n] += ground_part
    common = weighted_mean(chain, first, last, n)
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
    ground_part = 0.0
    for b in range(first, last + 1):
        if n < 4 and b > first:
            ground_part += ground.ground_moves(b)[n]
        bodies[b].series[n] = common - ground_part if bodies[b].mass > 0.0 else 0.0


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
    """`write_group` of each group among the buildings ``first`` to ``last``, none of which moves as one with others."""
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
        body.u, body.v = displacement_of(body, terms, x), velocity_of(body, terms, x)
