"""The linear complementarity problem of a chain of contacts: impulses, or forces, that push and never pull.

Contacts i = first … last in a line, each between two masses that it shares with its neighbours. With the compliances
G_ii = 1/m_l + 1/m_r and the couplings G_i,i+1 = −1/m of the mass between contacts i and i + 1,

    w = q + G x ≥ 0,   x ≥ 0,   x·w = 0.

G is a tridiagonal M-matrix: symmetric, positive definite, nothing above zero beside its diagonal. So x exists, is
unique, and is the least x ≥ 0 with w ≥ 0 (Cottle, Pang and Stone 1992, The Linear Complementarity Problem, sections 3.3
and 3.11). It is found without iteration to a tolerance: contacts with w < 0 join those that push, whose x only grow and
stay ≥ 0, at most as often as there are contacts (Chandrasekaran 1970). Each time their equations are solved from both
ends towards the middle: a chain that is mirrored has the mirrored answer, to the bit.
"""

from __future__ import annotations

from pounding_risk._jit.compile import kernel

# Rows of the table of a chain, a column for each contact: G_ii, G_i,i+1, q; x, w; whether it is one of those that push;
# and the rows of an elimination.
DIAGONAL, COUPLING, GIVEN, ANSWER, SLACK, PUSHES, PIVOT, RIGHT = range(8)
TABLE_ROWS = 8


@kernel
def solve_complementarity(table, first, last):
    """Fill ANSWER and SLACK of the contacts ``first`` to ``last``; one with an infinite q does not take part."""
    for i in range(first, last + 1):
        table[ANSWER, i] = table[PUSHES, i] = 0.0
    while True:
        has_grown = False
        for i in range(first, last + 1):
            left_part = table[COUPLING, i - 1] * table[ANSWER, i - 1] if i > first else 0.0
            right_part = table[COUPLING, i] * table[ANSWER, i + 1] if i < last else 0.0
            table[SLACK, i] = (table[DIAGONAL, i] * table[ANSWER, i] + (left_part + right_part)) + table[GIVEN, i]
            if table[SLACK, i] < 0.0 and table[PUSHES, i] == 0.0:
                table[PUSHES, i] = 1.0
                has_grown = True
            elif table[PUSHES, i] > 0.0:
                table[SLACK, i] = 0.0
        if not has_grown:
            return
        i = first
        while i <= last:
            if table[PUSHES, i] > 0.0:
                end = i
                while end < last and table[PUSHES, end + 1] > 0.0:
                    end += 1
                solve_block(table, i, end)
                i = end
            i += 1


@kernel
def solve_block(table, first, last):
    """ANSWER of neighbouring contacts that all push, w = 0, by elimination from both ends."""
    for i in range(first, last + 1):
        table[PIVOT, i], table[RIGHT, i] = table[DIAGONAL, i], -table[GIVEN, i]
    low, high = first, last
    while high - low > 1:
        left, right = table[COUPLING, low] / table[PIVOT, low], table[COUPLING, high - 1] / table[PIVOT, high]
        if high - low == 2:
            middle = low + 1
            table[PIVOT, middle] -= left * table[COUPLING, low] + right * table[COUPLING, high - 1]
            table[RIGHT, middle] -= left * table[RIGHT, low] + right * table[RIGHT, high]
        else:
            table[PIVOT, low + 1] -= left * table[COUPLING, low]
            table[RIGHT, low + 1] -= left * table[RIGHT, low]
            table[PIVOT, high - 1] -= right * table[COUPLING, high - 1]
            table[RIGHT, high - 1] -= right * table[RIGHT, high]
        low, high = low + 1, high - 1
    if low == high:
        table[ANSWER, low] = table[RIGHT, low] / table[PIVOT, low]
    else:
        between = table[COUPLING, low]
        determinant = table[PIVOT, low] * table[PIVOT, high] - between * between
        left = table[RIGHT, low] * table[PIVOT, high] - between * table[RIGHT, high]
        right = table[RIGHT, high] * table[PIVOT, low] - between * table[RIGHT, low]
        table[ANSWER, low], table[ANSWER, high] = left / determinant, right / determinant
    while low > first:
        low, high = low - 1, high + 1
        table[ANSWER, low] = (table[RIGHT, low] - table[COUPLING, low] * table[ANSWER, low + 1]) / table[PIVOT, low]
        right_hand = table[RIGHT, high] - table[COUPLING, high - 1] * table[ANSWER, high - 1]
        table[ANSWER, high] = right_hand / table[PIVOT, high]
    for i in range(first, last + 1):
        table[ANSWER, i] = max(table[ANSWER, i], 0.0)  # below it by rounding only
