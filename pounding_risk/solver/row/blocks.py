"""Blocks of nodes that a run passes over: the motion without contact, common to all runs, and what contacts left.

After its last contact a linear building moves as it would have without any, plus a free vibration h, which begins as
what the contacts have added:

    u = u_free + h,   h(next node) = Φ h(node).

The energy of a free vibration only falls. With 2 E of h and 2 E' of ḣ at the start of a block, from there on

    |h_i| ≤ sqrt(2 E (K⁻¹)_ii),   |h_i − h_{i−1}| ≤ sqrt(2 E / k_i),   |ḧ_i| ≤ sqrt(2 E' / m_i),

and with the bounds of the free motion in the block this shows whether a floor can reach a new peak and whether a
contact point can touch or come to a new extreme. Where neither can, nothing is done for that building or interface, but
that h goes on by the map of the whole block. A building that no group has had as a member yet has no h at all: its
peaks are those of the free motion up to any block.

The state of a building at a node does not depend on what is passed over, which its neighbours have a say in: it is
u_free + h, h by steps of a node from the start of the block or from the end of the last contact in it, and at the end
of a block by one step from its start if the building was on its own all the way.

Buildings whose storeys may yield are brought from node to node, and so are the distances to them.
"""

from __future__ import annotations

from math import sqrt

from pounding_risk._jit.compile import kernel
from pounding_risk.solver.row.building import accelerate
from pounding_risk.solver.row.contact_points import compliance
from pounding_risk.solver.row.flight_by_map import predict_by_map, update_distances, update_peaks
from pounding_risk.solver.row.flight_peaks import motion_bound
from pounding_risk.solver.row.ground import window_at
from pounding_risk.solver.row.ground_dof import place_ground, top_of
from pounding_risk.solver.row.node_map import map_motion, map_vibration
from pounding_risk.solver.row.workspace import (
    ACCEL_START,
    ACCELERATION,
    ACCELERATION_BOUND,
    ALONE,
    BLOCK_MAP,
    BY_NODE,
    CAN_YIELD,
    DISPLACEMENT,
    DISPLACEMENT_BOUND,
    DISTANCES_SEARCHED,
    DRIFT,
    FIRST,
    FLOORS_SEARCHED,
    FREE,
    FREE_NODE,
    GIVE,
    MAP,
    MOTION_BOUND,
    MOVED,
    NEXT,
    NODE,
    ROOT,
    START,
    STATE_NODE,
    SWAY,
    VELOCITY,
    VIBRATION,
    VIBRATION_BEFORE,
    VIBRATION_NODE,
    VIBRATION_SPARE,
)

ROUNDING = 1.0 + 1e-9  # on the bounds of a vibration
NOTHING = 1e-150  # sqrt(J): a vibration below it is none, before its numbers lose their precision


@kernel
def advance_vibration(row, run, free, b, node):
    """What contacts have left of building ``b`` goes on to ``node``, at most to the end of the block."""
    node_now = int(run.marks[VIBRATION_NODE, b])
    if run.marks[MOVED, b] == 0.0 or node_now >= node:
        return
    first, last = row.frame[FIRST, b], top_of(row, b)
    if run.marks[ALONE, b] > 0.0 and node % free.block == 0:
        map_vibration(row, b, free.block_maps, row.frame[BLOCK_MAP, b], run.dofs, VIBRATION_BEFORE, VIBRATION)
        node_now = node
    while node_now < node:
        map_start = (
            row.frame[MAP, b]
            + free.ground.from_node(free.step, node_now).map_number() * row.frame[MAP, row.frame.shape[1] - 1]
        )
        map_vibration(row, b, row.maps, map_start, run.dofs, VIBRATION, VIBRATION_SPARE)
        for line in range(2):
            for i in range(first, last):
                run.dofs[VIBRATION + line, i] = run.dofs[VIBRATION_SPARE + line, i]
        node_now += 1
    run.marks[VIBRATION_NODE, b] = node


@kernel
def move_freely(row, run, free, b, node):
    """Rows FREE of building ``b`` to ``node``: its state without any contact, by steps from the start of its block."""
    dofs, block, node_now = run.dofs, node // free.block, int(run.marks[FREE_NODE, b])
    if not block * free.block <= node_now <= node:
        node_now = block * free.block
        if node + 1 == free.ground.node_count():
            node_now, block = node, free.states.shape[0] - 1
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            for line in range(2):
                dofs[FREE + line, i] = free.states[block, line, free.first_dof + i]
    while node_now < node:
        map_motion(row, b, free.ground.from_node(free.step, node_now), dofs, FREE, VIBRATION_SPARE)
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            for line in range(2):
                dofs[FREE + line, i] = dofs[VIBRATION_SPARE + line, i]
        node_now += 1
    run.marks[FREE_NODE, b] = node


@kernel
def write_state(row, run, free, b, node, line):
    """The state of building ``b`` at ``node``, where its VIBRATION rows stand, to rows ``line``."""
    dofs = run.dofs
    move_freely(row, run, free, b, node)
    if run.marks[MOVED, b] > 0.0:
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            dofs[line, i] = dofs[FREE, i] + dofs[VIBRATION, i]
            dofs[line + VELOCITY, i] = dofs[FREE + VELOCITY, i] + dofs[VIBRATION + VELOCITY, i]
    else:
        for i in range(row.frame[FIRST, b], row.frame[FIRST, b + 1]):
            dofs[line, i] = dofs[FREE, i]
            dofs[line + VELOCITY, i] = dofs[FREE + VELOCITY, i]


@kernel
def bring_to_node(row, run, free, b, node):
    """Write the state of building ``b`` at ``node`` to rows NODE; that of one that may yield stands there already."""
    if run.marks[STATE_NODE, b] != node and not row.frame[CAN_YIELD, b]:
        advance_vibration(row, run, free, b, node)
        write_state(row, run, free, b, node, NODE)
        run.marks[STATE_NODE, b] = node
    if node + 1 < free.ground.node_count():
        place_ground(row, b, free.ground.from_node(free.step, node), run.dofs, NODE)


@kernel
def predict_interval(row, run, free, b, node):
    """Building ``b`` over one node interval on its own: rows NODE and NEXT, ü at the node in ACCEL_START.

    Leaves 2 E of its bounds in row MOTION_BOUND of the marks; returns False where a storey yields, or may.
    """
    bring_to_node(row, run, free, b, node)
    if row.frame[CAN_YIELD, b]:
        return predict_by_map(row, run, b, window_at(free.ground, free.step, node))
    advance_vibration(row, run, free, b, node + 1)
    write_state(row, run, free, b, node + 1, NEXT)
    pull, rise = free.ground.from_node(free.step, node).under(b)
    accelerate(row, b, NODE, pull, run.dofs, ACCEL_START)
    run.marks[MOTION_BOUND, b] = motion_bound(row, b, rise, run.dofs, NODE, ACCEL_START)
    return True


@kernel
def separate_vibration(row, run, free, b, node):
    """What contacts have added to the motion of building ``b``, which a group has left in rows NEXT at ``node``."""
    move_freely(row, run, free, b, node)
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        for line in range(2):
            run.dofs[VIBRATION + line, i] = run.dofs[NEXT + line, i] - run.dofs[FREE + line, i]
    run.marks[VIBRATION_NODE, b] = node
    run.marks[ALONE, b] = 0.0


@kernel
def copy_floor_peaks(row, run, free, b, block):
    """The peaks of building ``b`` become those of the free motion up to the start of ``block``."""
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        run.dofs[DISPLACEMENT, i] = free.floor_peaks[block, 0, free.first_dof + i]
        run.dofs[DRIFT, i] = free.floor_peaks[block, 1, free.first_dof + i]
        run.dofs[ACCELERATION, i] = free.floor_peaks[block, 2, free.first_dof + i]


@kernel
def copy_point_peaks(row, run, free, interface, block):
    """The extremes of an interface's distances become those of the free motion up to the start of ``block``."""
    for k in range(row.frame[START, interface], row.frame[START, interface + 1]):
        run.contacts[k].highest = free.point_peaks[block, 0, free.first_point + k]
        run.contacts[k].lowest = free.point_peaks[block, 1, free.first_point + k]


@kernel
def begin_block_vibration(row, run, free, b, node):
    """What is left of contacts at the start of a block: rows VIBRATION and its bounds, of a building that is linear."""
    run.marks[DISPLACEMENT_BOUND, b] = run.marks[ACCELERATION_BOUND, b] = 0.0
    advance_vibration(row, run, free, b, node)
    # 2 E of h: its displacements and velocities stand where those of ḣ and ḧ do for the function that is called.
    bound = sqrt(motion_bound(row, b, 0.0, run.dofs, VIBRATION - VELOCITY, VIBRATION + VELOCITY))
    is_at_rest = bound < NOTHING
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        for line in range(2):
            run.dofs[VIBRATION + line, i] = 0.0 if is_at_rest else run.dofs[VIBRATION + line, i]
            run.dofs[VIBRATION_BEFORE + line, i] = run.dofs[VIBRATION + line, i]
    run.marks[ALONE, b] = 1.0
    if not is_at_rest:
        accelerate(row, b, VIBRATION, 0.0, run.dofs, ACCEL_START)
        run.marks[DISPLACEMENT_BOUND, b] = ROUNDING * bound
        run.marks[ACCELERATION_BOUND, b] = ROUNDING * sqrt(motion_bound(row, b, 0.0, run.dofs, VIBRATION, ACCEL_START))


@kernel
def has_new_peaks(row, run, free, b, block):
    """True where a floor of building ``b`` may pass a peak in the block; put so that it may where a bound is NaN."""
    bound, acceleration_bound = run.marks[DISPLACEMENT_BOUND, b], run.marks[ACCELERATION_BOUND, b]
    for i in range(row.frame[FIRST, b], top_of(row, b)):
        dof = free.first_dof + i
        if not free.floor_bounds[block, 0, dof] + bound * row.floors[SWAY, i] <= run.dofs[DISPLACEMENT, i]:
            return True
        if not free.floor_bounds[block, 1, dof] + bound * row.floors[GIVE, i] <= run.dofs[DRIFT, i]:
            return True
        if not free.floor_bounds[block, 2, dof] + acceleration_bound * row.floors[ROOT, i] <= run.dofs[ACCELERATION, i]:
            return True
    return False


@kernel
def has_events(row, run, free, interface, block):
    """True where a contact point of an interface may touch in the block, or come to a new extreme.

    Extremes between two buildings without any contact so far are those of the free motion.
    """
    have_moved = run.marks[MOVED, interface] + run.marks[MOVED, interface + 1] > 0.0
    for k in range(row.frame[START, interface], row.frame[START, interface + 1]):
        reach = 0.0
        for end in range(4):
            i = row.ends[k, end]
            if i >= 0:
                # Both ends are of one body where the point stands between linked buildings.
                bound = run.marks[DISPLACEMENT_BOUND, interface + (i >= row.frame[FIRST, interface + 1])]
                reach += abs(row.shares[k, end]) * row.floors[SWAY, i] * bound
        high = free.point_bounds[block, 0, free.first_point + k] + reach
        low = free.point_bounds[block, 1, free.first_point + k] - reach
        contact = run.contacts[k]
        if not high <= contact.gap and compliance(row, k) > 0.0:
            return True
        if have_moved and not (high <= contact.highest and low >= contact.lowest):
            return True
    return False


@kernel
def join_group(row, run, free, b, node):
    """Make building ``b`` ready to be a member of a group over the interval after ``node``.

    What has been passed over of this block, of its floors and of the distances to its neighbours, is made up for where
    the free motion has new peaks in it; its neighbours are brought to the node, and go from node to node from there on.
    """
    begin = node - node % free.block
    for i in range(max(b - 1, 0), min(b + 1, row.frame.shape[1] - 2)):
        if run.marks[DISTANCES_SEARCHED, i] > 0.0:
            continue
        if run.marks[MOVED, i] + run.marks[MOVED, i + 1] == 0.0:
            copy_point_peaks(row, run, free, i, node // free.block)
            for earlier in range(begin, node):
                for side in range(i, i + 2):
                    predict_interval(row, run, free, side, earlier)
                update_distances(row, run, i, window_at(free.ground, free.step, earlier), free.terms)
        run.marks[DISTANCES_SEARCHED, i] = 1.0
        for side in range(i, i + 2):
            run.marks[BY_NODE, side] = 1.0
            predict_interval(row, run, free, side, node)
    if run.marks[MOVED, b] == 0.0:
        copy_floor_peaks(row, run, free, b, node // free.block)
        for earlier in range(begin, node):
            predict_interval(row, run, free, b, earlier)
            update_peaks(row, run, b, window_at(free.ground, free.step, earlier), free.terms)
        predict_interval(row, run, free, b, node)
        run.marks[MOVED, b], run.marks[VIBRATION_NODE, b] = 1.0, node + 1
    run.marks[BY_NODE, b] = run.marks[FLOORS_SEARCHED, b] = 1.0


@kernel
def end_blocks(row, run, free, node):
    """The state of every building at the last node to rows NODE, and the peaks of what has been passed over."""
    buildings = row.frame.shape[1] - 1
    last = free.floor_peaks.shape[0] - 1
    for b in range(buildings):
        bring_to_node(row, run, free, b, node)
        if run.marks[MOVED, b] == 0.0:
            copy_floor_peaks(row, run, free, b, last)
    for i in range(buildings - 1):
        if run.marks[MOVED, i] + run.marks[MOVED, i + 1] == 0.0:
            copy_point_peaks(row, run, free, i, last)
