"""The response of a pair without contact, computed once for all runs that share a ground motion."""

from __future__ import annotations

from math import inf

from pounding_risk._jit.compile import kernel, small
from pounding_risk.solver.pair.flight import (
    BLOCK,
    EVERY_SIGNAL,
    bend_bounds,
    read_signals,
    search_interval,
    search_mask,
    with_free,
    write_series,
)
from pounding_risk.solver.pair.taylor import expand, slope_at, value_at
from pounding_risk.solver.workspace import LEFT, SIGNALS


@kernel
def ramp_map(oscillator, step, terms, workspace):
    """u and u̇ after one node interval from (u, u̇, the load at its start, its slope): 2 x 4 numbers."""
    series = workspace.search.series
    displacements, velocities = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if oscillator.inverse_omega > 0.0:
        for part in range(4):
            displacement, velocity = (1.0 if part == 0 else 0.0), (1.0 if part == 1 else 0.0)
            load = (1.0 if part == 2 else 0.0, 1.0 if part == 3 else 0.0, 0.0, 0.0)
            expand(oscillator, displacement, velocity, load, workspace.search, LEFT, terms)
            workspace.start_signals[part] = value_at(series, LEFT, terms, step)
            workspace.end_signals[part] = slope_at(series, LEFT, terms, step)
        displacements = (
            workspace.start_signals[0],
            workspace.start_signals[1],
            workspace.start_signals[2],
            workspace.start_signals[3],
        )
        velocities = (
            workspace.end_signals[0],
            workspace.end_signals[1],
            workspace.end_signals[2],
            workspace.end_signals[3],
        )
    return displacements, velocities


@small
def advance_under_ramp(ramp_maps, displacement, velocity, load):
    """(u [m], u̇ [m/s]) at the end of a node interval from those at its start.

    ``ramp_maps`` as `ramp_map` gives them, ``load`` = (load on the oscillator at the start [m/s²], its slope [m/s³],
    ...).
    """
    a, b = ramp_maps
    return (
        a[0] * displacement + a[1] * velocity + a[2] * load[0] + a[3] * load[1],
        b[0] * displacement + b[1] * velocity + b[2] * load[0] + b[3] * load[1],
    )


@small
def widen_bounds(pair, state, span, workspace):
    """Widen the bounds of the block by those of an interval: max and min of the end values ± |f''| h²/8."""
    ground, length = span
    bends = bend_bounds(pair, state, ground, length)
    for signal in range(SIGNALS):
        reach = 0.125 * bends[signal] * length * length
        start, end = workspace.start_signals[signal], workspace.end_signals[signal]
        workspace.upper[signal] = max(workspace.upper[signal], max(start, end) + reach)
        workspace.lower[signal] = min(workspace.lower[signal], min(start, end) - reach)


@kernel
def fill_free_response(pair, free, workspace):
    """Fill the free response: states at the nodes, and bounds of every watched signal in every block.

    The bounds of a block that raises a peak of the record so far are that peak, exactly; the largest of all blocks
    is therefore the peak of the whole free motion, and a run that has only flown freely knows its own.
    """
    step, terms, states, passage = free.step, free.terms, free.states, free.passage
    # Even and odd nodes may be followed by intervals of unlike widths.
    even_width, odd_width = passage.width(step, 0), passage.width(step, 1)
    even_maps = ramp_map(pair[0], even_width, terms, workspace), ramp_map(pair[1], even_width, terms, workspace)
    odd_maps = ramp_map(pair[0], odd_width, terms, workspace), ramp_map(pair[1], odd_width, terms, workspace)
    last = free.ground.size - 1
    for block in range(free.high.shape[0]):
        first, stop = block * BLOCK, min(last, block * BLOCK + BLOCK)
        workspace.upper[:] = -inf
        workspace.lower[:] = inf
        state = (states[first, 0], states[first, 1], states[first, 2], states[first, 3])
        read_signals(pair, state, passage.widened(first), workspace.end_signals)
        for node in range(first, stop):
            ground = passage.interval(free.ground, step, node, 0.0)
            interval_maps = odd_maps if node % 2 else even_maps
            left = advance_under_ramp(interval_maps[0], state[0], state[2], ground.load_left(pair[0]))
            right = advance_under_ramp(interval_maps[1], state[1], state[3], ground.load_right(pair[1]))
            next_state = (left[0], right[0], left[1], right[1])
            for signal in range(SIGNALS):
                workspace.start_signals[signal] = workspace.end_signals[signal]
            read_signals(pair, next_state, passage.widened(node + 1), workspace.end_signals)
            widen_bounds(pair, state, (ground, passage.width(step, node)), workspace)
            for part in range(4):
                states[node + 1, part] = next_state[part]
            state = next_state
        measure_block(pair, free, (first, stop), workspace)
        for signal in range(SIGNALS):
            free.high[block, signal] = min(workspace.upper[signal], workspace.high[signal])
            free.low[block, signal] = max(workspace.lower[signal], workspace.low[signal])


@kernel
def measure_block(pair, free, nodes, workspace):
    """Update the largest and smallest signals so far by those of a block that can pass them."""
    has_new_peak = False
    for signal in range(SIGNALS):
        has_new_peak |= (
            workspace.upper[signal] > workspace.high[signal] or workspace.lower[signal] < workspace.low[signal]
        )
    if not has_new_peak:
        return
    no_vibration = (0.0, 0.0, 0.0, 0.0)
    states, passage = free.states, free.passage
    read_signals(pair, with_free(states, nodes[0], no_vibration), passage.widened(nodes[0]), workspace.end_signals)
    for node in range(nodes[0], nodes[1]):
        span = (passage.interval(free.ground, free.step, node, 0.0), passage.width(free.step, node))
        state = with_free(states, node, no_vibration)
        for signal in range(SIGNALS):
            workspace.start_signals[signal] = workspace.end_signals[signal]
        read_signals(pair, with_free(states, node + 1, no_vibration), passage.widened(node + 1), workspace.end_signals)
        mask = search_mask(pair, inf, state, span, EVERY_SIGNAL, workspace)
        if mask:
            write_series(pair, state, span[0], free.terms, workspace)
            search_interval(pair, inf, mask, span, free.terms, workspace)
