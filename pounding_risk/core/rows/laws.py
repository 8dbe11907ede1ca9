"""Contact laws for the row solver: called by address, so that one compiled solver serves every law.

The pair's kernels hold the law's own code, and are compiled for every law. A row's are some five times as large, and
what a contact costs there is the buildings' motion: a call costs less than a twentieth of it. Each contact point may
have a law of its own.
"""

from __future__ import annotations

from math import inf, sqrt

from pounding_risk._calls import as_row, call_at, call_on, entry_of, model_of, numbers_of
from pounding_risk._jit import apart, kernel
from pounding_risk.core.rows.layout import (
    BEGIN_VERB,
    BOARD_PLACE,
    FORCE_VERB,
    LAW,
    PART_VERB,
    PLATEAU_VERB,
    TURN_VERB,
    WHOLE,
)

_VERBS: dict[type, tuple[float, ...]] = {}


def verbs_of(law) -> tuple[float, ...]:
    """Addresses of what the row solver asks of a law of this class: force, plateau, begin, turn, part."""
    kind = apart(type(law))
    if kind not in _VERBS:
        _VERBS[kind] = _compiled(law)
    return _VERBS[kind]


def _compiled(law) -> tuple[float, ...]:
    """The verbs of one class of laws; ``law`` is one of them, its numbers play no part."""
    template, count = law, len(numbers_of(law))

    def force(numbers, memory, delta, rate, approaching):
        return model_of(template, as_row(numbers, count), 0, 0).force(memory, delta, rate, approaching > 0.0)

    def plateau(numbers, delta, strength, unused, spare):
        return model_of(template, as_row(numbers, count), 0, 0).plateau(delta, strength)

    def begin(numbers, slots):
        own, board = model_of(template, as_row(numbers, count), 0, 0), as_row(slots, 7)
        e, speed, mass, worn, limit, scale = (
            board[0, 0],
            board[0, 1],
            board[0, 2],
            board[0, 3],
            board[0, 4],
            board[0, 5],
        )
        board[0, 0] = own.resume(own.begin(e, speed, mass), worn)
        board[0, 1] = own.ceiling(limit) * own.hardening(speed)
        board[0, 2] = own.floor()
        # The penetration at which the law has stored the energy of the touch: a scale, good to a tenth.
        energy, depth = 0.5 * mass * scale * scale, 1e-2 * scale
        for _ in range(200):
            stored = own.stored(depth, inf)
            if not stored > 0.0:
                depth *= 1e3
                continue
            ratio = energy / stored
            if 0.8 < ratio < 1.25:
                break
            depth *= sqrt(ratio)
        board[0, 3] = depth
        return 0.0

    def turn(numbers, slots):
        own, board = model_of(template, as_row(numbers, count), 0, 0), as_row(slots, 5)
        memory, delta, strength, approaching = board[0, 0], board[0, 1], board[0, 2], board[0, 3] > 0.0
        memory = own.turned(memory, delta, approaching)
        board[0, 0], board[0, 1], board[0, 2] = memory, -1.0, 0.0
        if approaching and board[0, 4] > 0.0:
            changed, dent, taken = own.turn(memory, delta, strength)
            if dent >= 0.0:
                board[0, 0], board[0, 1], board[0, 2] = changed, dent, taken
        return 0.0

    def part(numbers, slots):
        own, board = model_of(template, as_row(numbers, count), 0, 0), as_row(slots, 4)
        memory, delta, strength, work = board[0, 0], board[0, 1], board[0, 2], board[0, 3]
        loss = work - own.held(memory, delta, strength)
        board[0, 0], board[0, 1], board[0, 2] = loss, own.yielded(loss), own.worn(memory)
        return 0.0

    return (entry_of(force, 4), entry_of(plateau, 4), entry_of(begin, 1), entry_of(turn, 1), entry_of(part, 1))


@kernel
def law_force(run, k, memory, delta, rate, approaching):
    """The uncapped force of contact ``k``."""
    return call_at(run.limits[k, FORCE_VERB], run.limits, k, LAW, memory, delta, rate, approaching)


@kernel
def law_plateau(run, k, delta, strength):
    """The force of contact ``k`` past yield."""
    return call_at(run.limits[k, PLATEAU_VERB], run.limits, k, LAW, delta, strength, 0.0, 0.0)


@kernel
def law_begin(run, k, e, speed, mass, worn, scale, limit):
    """(memory, strength, smallest force, scale of penetration) of a contact that begins."""
    board = run.board
    for place, value in enumerate((e, speed, mass, worn, limit, scale)):
        board[WHOLE, BOARD_PLACE + place] = value
    call_on(run.limits[k, BEGIN_VERB], run.limits, k, LAW, board, WHOLE, BOARD_PLACE)
    return (
        board[WHOLE, BOARD_PLACE],
        board[WHOLE, BOARD_PLACE + 1],
        board[WHOLE, BOARD_PLACE + 2],
        board[WHOLE, BOARD_PLACE + 3],
    )


@kernel
def law_turn(run, k, memory, delta, strength, approaching, yielding):
    """(memory, dent or below zero, energy lost with it) of a contact whose motion turns."""
    board = run.board
    for place, value in enumerate((memory, delta, strength, approaching, yielding)):
        board[WHOLE, BOARD_PLACE + place] = value
    call_on(run.limits[k, TURN_VERB], run.limits, k, LAW, board, WHOLE, BOARD_PLACE)
    return board[WHOLE, BOARD_PLACE], board[WHOLE, BOARD_PLACE + 1], board[WHOLE, BOARD_PLACE + 2]


@kernel
def law_part(run, k, memory, delta, strength, work):
    """(loss, part of it that hysteresis takes, what is left for later contacts) of a contact that parts."""
    board = run.board
    for place, value in enumerate((memory, delta, strength, work)):
        board[WHOLE, BOARD_PLACE + place] = value
    call_on(run.limits[k, PART_VERB], run.limits, k, LAW, board, WHOLE, BOARD_PLACE)
    return board[WHOLE, BOARD_PLACE], board[WHOLE, BOARD_PLACE + 1], board[WHOLE, BOARD_PLACE + 2]
