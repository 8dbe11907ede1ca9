"""Small systems of linear equations."""

from __future__ import annotations

from pounding_risk._jit.compile import kernel


@kernel
def solve_linear(matrix, right):
    """Solve ``matrix`` x = ``right`` by Gaussian elimination with row pivots; x is left in ``right``.

    The matrix is used up. The same on every machine, to the bit, which a library's is not.
    """
    size = right.size
    for column in range(size):
        pivot = column
        for i in range(column + 1, size):
            if abs(matrix[i, column]) > abs(matrix[pivot, column]):
                pivot = i
        if pivot != column:
            for j in range(column, size):
                matrix[column, j], matrix[pivot, j] = matrix[pivot, j], matrix[column, j]
            right[column], right[pivot] = right[pivot], right[column]
        for i in range(column + 1, size):
            factor = matrix[i, column] / matrix[column, column]
            if factor != 0.0:
                for j in range(column + 1, size):
                    matrix[i, j] -= factor * matrix[column, j]
                right[i] -= factor * right[column]
    for back in range(size):
        i = size - 1 - back
        total = right[i]
        for j in range(i + 1, size):
            total -= matrix[i, j] * right[j]
        right[i] = total / matrix[i, i]
