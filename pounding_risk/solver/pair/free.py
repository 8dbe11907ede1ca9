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
    places, speeds = (0.0, 0.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)
    if oscillator.inverse_omega > 0.0:
        for part in range(4):
            place, speed = (1.0 if part == 0 else 0.0), (1.0 if part == 1 else 0.0)
            load = (1.0 if part == 2 else 0.0, 1.0 if part == 3 else 0.0, 0.0, 0.0)
            expand(oscillator, place, speed, load, workspace.search, LEFT, terms)
            workspace.here[part] = value_at(series, LEFT, terms, step)
            workspace.there[part] = slope_at(series, LEFT, terms, step)
        places = (workspace.here[0], workspace.here[1], workspace.here[2], workspace.here[3])
        speeds = (workspace.there[0], workspace.there[1], workspace.there[2], workspace.there[3])
    return places, speeds


@small
def ramped(ramp_maps, place, speed, load):
    """(u, u̇) at the end of a node interval."""
    a, b = ramp_maps
    return (
        a[0] * place + a[1] * speed + a[2] * load[0] + a[3] * load[1],
        b[0] * place + b[1] * speed + b[2] * load[0] + b[3] * load[1],
    )


@small
def widen(pair, state, span, workspace):
    """Widen the bounds of the block by those of an interval: max and min of the end values ± |f''| h²/8."""
    ground, length = span
    bends = bend_bounds(pair, state, ground, length)
    for signal in range(SIGNALS):
        reach = 0.125 * bends[signal] * length * length
        here, there = workspace.here[signal], workspace.there[signal]
        workspace.upper[signal] = max(workspace.upper[signal], max(here, there) + reach)
        workspace.lower[signal] = min(workspace.lower[signal], min(here, there) - reach)


@kernel
def fill_free_response(pair, free, workspace):
    """Fill the free response: states at the nodes, and bounds of every watched signal in every block.

    The bounds of a block that raises a peak of the record so far are that peak, exactly; the largest of all blocks
    is therefore the peak of the whole free motion, and a run that has only flown freely knows its own.
    """
    step, terms, states, passage = free.step, free.terms, free.states, free.passage
    # Even and odd nodes may be followed by intervals of unlike widths.
    even, odd = passage.width(step, 0), passage.width(step, 1)
    maps = ramp_map(pair[0], even, terms, workspace), ramp_map(pair[1], even, terms, workspace)
    others = ramp_map(pair[0], odd, terms, workspace), ramp_map(pair[1], odd, terms, workspace)
    last = free.ground.size - 1
    for block in range(free.high.shape[0]):
        first, stop = block * BLOCK, min(last, block * BLOCK + BLOCK)
        workspace.upper[:] = -inf
        workspace.lower[:] = inf
        state = (states[first, 0], states[first, 1], states[first, 2], states[first, 3])
        read_signals(pair, state, passage.widened(first), workspace.there)
        for node in range(first, stop):
            ground = passage.stretch(free.ground, step, node, 0.0)
            turn = others if node % 2 else maps
            left = ramped(turn[0], state[0], state[2], ground.load_left(pair[0]))
            right = ramped(turn[1], state[1], state[3], ground.load_right(pair[1]))
            ahead = (left[0], right[0], left[1], right[1])
            for signal in range(SIGNALS):
                workspace.here[signal] = workspace.there[signal]
            read_signals(pair, ahead, passage.widened(node + 1), workspace.there)
            widen(pair, state, (ground, passage.width(step, node)), workspace)
            for part in range(4):
                states[node + 1, part] = ahead[part]
            state = ahead
        measure_block(pair, free, (first, stop), workspace)
        for signal in range(SIGNALS):
            free.high[block, signal] = min(workspace.upper[signal], workspace.high[signal])
            free.low[block, signal] = max(workspace.lower[signal], workspace.low[signal])


@kernel
def measure_block(pair, free, nodes, workspace):
    """Update the largest and smallest signals so far by those of a block that can pass them."""
    record = False
    for signal in range(SIGNALS):
        record |= workspace.upper[signal] > workspace.high[signal] or workspace.lower[signal] < workspace.low[signal]
    if not record:
        return
    still = (0.0, 0.0, 0.0, 0.0)
    states, passage = free.states, free.passage
    read_signals(pair, with_free(states, nodes[0], still), passage.widened(nodes[0]), workspace.there)
    for node in range(nodes[0], nodes[1]):
        span = (passage.stretch(free.ground, free.step, node, 0.0), passage.width(free.step, node))
        state = with_free(states, node, still)
        for signal in range(SIGNALS):
            workspace.here[signal] = workspace.there[signal]
        read_signals(pair, with_free(states, node + 1, still), passage.widened(node + 1), workspace.there)
        wanted = search_mask(pair, inf, state, span, EVERY_SIGNAL, workspace)
        if wanted:
            write_series(pair, state, span[0], free.terms, workspace)
            search_interval(pair, inf, wanted, span, free.terms, workspace)
