"""A table of force against penetration, as a curve that kernels follow, and what it asks of its points.

Through the points runs SciPy's monotone cubic (PCHIP; Fritsch and Butland 1984): its slope is continuous, so that steps
of the integration pass the points, it has no peak between them, and its energy is a polynomial too. Beyond the last
point the force goes on along the last slope, level where that falls.

Unloading is one of three. Without a curve of its own it retraces the loading. With a stiffness K_u the force falls from
the deepest penetration δ_m along the straight line of that slope, F_m / K_u long. With a column the unloading curve,
which the table gives from its last point, holds from every δ_m in a similar form: F = F_m U(x), x from 0 at the set to
1 at δ_m, and the set is the same share of δ_m as in the table; beyond the table's end it moves along with δ_m.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from math import inf, isfinite
from threading import Lock
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._jit.calls import address_of
from pounding_risk.errors import PoundingError
from pounding_risk.units import GAP, YIELD_FORCE, Quantity, say, si

TABULATED = "tabulated"  # the law that reads one, in a scene
MOST_POINTS = 2000
PENETRATION = Quantity("m", 0.0, 100.0, "penetration of a table", example="25 mm")
FORCE = Quantity("N", 0.0, 1e12, "force of a table", example="450 kN")
UNLOADING_STIFFNESS = Quantity(
    "N/m", 0.0, inf, "unloading stiffness of a table", open_low=True, open_high=True, example="8e7 N/m"
)
ROUNDING = 1e-9  # of the force: what a table may give back by the rounding of its numbers
CLOSEST, LEAST = 1e-9, 1e-3  # m between points, and N past the first: less are no measured numbers

# Where its numbers stand at its address: these, then the pieces of loading, and those of unloading. A piece is where it
# begins, its four coefficients, and the energy up to it.
LOADING_PIECES, UNLOADING_PIECES, END, LINE, SHARE, HEAD = range(6)
PIECE = 6


class Points(NamedTuple):
    """The content of a table, in SI."""

    penetration: tuple[float, ...]  # m, from 0
    force: tuple[float, ...]  # N, from 0
    unloading: tuple[float, ...] | None = None  # N at the same penetrations, from the last point back to the set
    unloading_stiffness: float | None = None  # N/m


class TableError(PoundingError):
    """Points that make no table: ``faults`` has the number of the point, from 0, or None, and a sentence of each.

    ``sentences`` are these for a reader, who knows the points of a file by their ``lines``.
    """

    def __init__(self, faults: list[tuple[int | None, str]], source: str = "table", lines: Sequence[int] = ()):
        self.faults = faults
        named = [f"line {line}: " for line in lines] or [f"point {place + 1}: " for place in range(MOST_POINTS)]
        self.sentences = [("" if place is None else named[place]) + sentence for place, sentence in faults]
        super().__init__(f"{source}: " + "; ".join(self.sentences))


class Table(float):
    """A checked table. As a number it is the address of its curve, with forces in units of its stiffness.

    There is one object, and one address, for each content; it lives as long as the process, for a law may stand in a
    kernel by its numbers alone. A copy in another process has its own address there.
    """

    points: Points
    numbers: NDArray[np.float64]

    @property
    def stiffness(self) -> float:
        """Force over penetration at the last point [N/m]."""
        return self.points.force[-1] / self.points.penetration[-1]

    @property
    def end(self) -> float:
        """Penetration of the last point [m]."""
        return self.points.penetration[-1]

    def words(self) -> str:
        """The table for a reader."""
        points = self.points
        back = "the loading is retraced"
        if points.unloading is not None:
            back = "back along its unloading column"
        if points.unloading_stiffness is not None:
            back = f"back with {say(points.unloading_stiffness, UNLOADING_STIFFNESS)}"
        return (
            f"table of {len(points.penetration)} points to {say(self.end, GAP)} and "
            f"{say(points.force[-1], YIELD_FORCE)}, {back}"
        )

    def __reduce__(self) -> tuple[Any, ...]:
        return table_of, tuple(self.points)

    def __repr__(self) -> str:
        return f"<{self.words()}>"

    __str__ = __repr__


_TABLES: dict[Points, Table] = {}
_ENTERING = Lock()


def table_of(
    penetration: Sequence[float | str],
    force: Sequence[float | str],
    unloading: Sequence[float | str] | None = None,
    unloading_stiffness: float | str | None = None,
) -> Table:
    """The table of these points.

    Parameters
    ----------
    penetration, force : sequence of float or str
        Penetrations, rising from 0, and the forces of loading there; numbers in m and N, or text with a unit.
    unloading : sequence of float or str, optional
        Forces at the same penetrations on the way back from the last point, 0 up to what stays of the penetration.
    unloading_stiffness : float or str, optional
        Slope of the way back [N/m], in place of ``unloading``.

    Returns
    -------
    Table

    Raises
    ------
    TableError
        With every fault: a number that is none or negative, penetrations that do not rise, unloading that would give
        back more than loading took.
    """
    points = _checked(penetration, force, unloading, unloading_stiffness)
    with _ENTERING:
        if points not in _TABLES:
            numbers = _numbers(points)
            _TABLES[points] = table = Table(address_of(numbers))
            table.points, table.numbers = points, numbers
        return _TABLES[points]


def beyond_end(depth: float, end: float) -> str:
    """A sentence where a penetration passes the end of a table [m]; "" elsewhere."""
    if not depth > end:
        return ""
    return (
        f"the penetration of {say(depth, GAP, 3)} passes the table's last point, {say(end, GAP, 3)}; beyond it the "
        "force goes on along its last slope, which nothing measured supports: extend the table"
    )


# ------------------------------------------------------------------------------------------------ checks


def _checked(penetration: Any, force: Any, unloading: Any, unloading_stiffness: Any) -> Points:
    faults: list[tuple[int | None, str]] = []
    depths = _column(penetration, PENETRATION, "penetration", faults)
    forces = _column(force, FORCE, "force", faults)
    back = None if unloading is None else _column(unloading, FORCE, "unloading", faults)
    stiffness = None
    if unloading_stiffness is not None:
        try:
            stiffness = si(unloading_stiffness, UNLOADING_STIFFNESS, "unloading_stiffness")
        except ValueError as error:
            faults.append((None, str(error)))
    if faults:
        raise TableError(faults)
    points = Points(depths, forces, back, stiffness)
    if faults := list(_shape_faults(points)) or list(_column_faults(points)) or list(_energy_faults(points)):
        raise TableError(faults)
    return points


def _column(values: Any, quantity: Quantity, name: str, faults: list[tuple[int | None, str]]) -> tuple[float, ...]:
    """The values of a column in SI; faults of those that are none."""
    numbers = []
    try:
        values = list(values) if not isinstance(values, str) else None
    except TypeError:
        values = None
    if values is None:
        faults.append((None, f"{name} is no list of numbers; write one for each point"))
        return ()
    if len(values) > MOST_POINTS:
        faults.append((None, f"{len(values)} values of {name}, more than {MOST_POINTS}; leave some out"))
        return ()
    for place, value in enumerate(values):
        try:
            number = si(value, quantity)
        except ValueError as error:
            faults.append((place, f"{name}: {error}"))
            continue
        if isfinite(number):
            numbers.append(number + 0.0)
        else:
            faults.append((place, f"{name}: {number:g} is no finite number; write one"))
    return tuple(numbers)


def _shape_faults(points: Points) -> Iterator[tuple[int | None, str]]:
    count = len(points.penetration)
    for name, column in (("force", points.force), ("unloading", points.unloading)):
        if column is not None and len(column) != count:
            yield None, f"{len(column)} values of {name} for {count} of penetration; write one for each"
    if count < 2:
        yield None, f"{count} points; write two or more, the first with penetration 0 and force 0"
    if points.unloading is not None and points.unloading_stiffness is not None:
        yield None, "unloading and unloading_stiffness are two ways back; give one of them"


def _column_faults(points: Points) -> Iterator[tuple[int | None, str]]:
    penetration, force, back = points.penetration, points.force, points.unloading
    if penetration[0] != 0.0 or force[0] != 0.0:
        finding = f"penetration {penetration[0]:g} m and force {force[0]:g} N"
        yield 0, f"{finding}; a contact begins at 0 and 0: write that point first, and take a clearance into the gap"
    for place in range(1, len(penetration)):
        if not penetration[place] >= penetration[place - 1] + CLOSEST:
            finding = f"penetration {penetration[place]:g} m after {penetration[place - 1]:g} m"
            yield (
                place,
                f"{finding}; it must rise from point to point, by {CLOSEST:g} m at least: sort them, and leave out the "
                "repeated ones",
            )
        if not force[place] >= LEAST:
            finding = f"force {force[place]:g} N past the first point"
            yield place, f"{finding}; write {LEAST:g} N or more there, and take a clearance into the gap"
        if back is not None and back[place] > force[place] * (1.0 + ROUNDING):
            finding = f"unloading {back[place]:g} N above the loading, {force[place]:g} N"
            yield place, f"{finding}: it would give back more than it took; write at most that"
    if back is None:
        return
    if back[0] != 0.0:
        yield 0, f"unloading {back[0]:g} N at penetration 0; bodies that part feel none: write 0"
    if abs(back[-1] - force[-1]) > ROUNDING * force[-1]:
        finding = f"unloading {back[-1]:g} N, and loading {force[-1]:g} N"
        yield len(back) - 1, f"{finding}; the way back begins at the last point: write the same force there"
    begins = _begin_of_unloading(back)
    for place in range(begins + 1, len(back)):
        if back[place] < back[place - 1]:
            finding = f"unloading {back[place]:g} N after {back[place - 1]:g} N"
            yield place, f"{finding}; it must not fall with penetration: write at least that"


def _begin_of_unloading(back: Sequence[float]) -> int:
    """The last point before the unloading force rises: the set."""
    return max(next((place for place, value in enumerate(back) if value > 0.0), 1) - 1, 0)


def _energy_faults(points: Points) -> Iterator[tuple[int | None, str]]:
    """What a second way in and back could gain: the energy lost up to δ must never fall with δ."""
    edges, coefficients = _pieces(points.penetration, points.force)
    widths = np.diff(edges)
    slope = coefficients * np.array([0.0, 1.0, 2.0, 3.0])
    slope = np.roll(slope, -1, axis=1)  # of each piece, in powers of the distance from where it begins
    if points.unloading_stiffness is not None:
        steepest, place = _lowest(-slope, widths)
        if -steepest > points.unloading_stiffness * (1.0 + ROUNDING):
            yield (
                None,
                f"unloading_stiffness {points.unloading_stiffness:g} N/m is below the slope of the loading at point "
                f"{place + 1}, {-steepest:g} N/m: it would give back more than it took; write at least that",
            )
    if points.unloading is not None:
        # Given back from δ is a F δ, of ∫ F dδ: the loss grows where (1 − a) F − a δ F' is not below 0.
        share, inside = _unloading_shape(points)
        area = share * _energies(*inside)[-1]
        begins = edges[:-1, None] * slope
        along = np.roll(slope, 1, axis=1)
        gain = (1.0 - area) * coefficients - area * (begins + along)
        least, place = _lowest(gain, widths)
        if least < -ROUNDING * points.force[-1]:
            yield (
                place,
                "the unloading curve, in its similar form from here, would give back more than the loading took; write "
                "lower unloading forces, or an unloading_stiffness, or leave the column out where the loading is "
                "retraced",
            )


def _lowest(coefficients: NDArray[np.float64], widths: NDArray[np.float64]) -> tuple[float, int]:
    """The smallest value of cubics on their pieces, and the piece."""
    c0, c1, c2, c3 = coefficients.T
    with np.errstate(all="ignore"):
        root = np.sqrt(c2 * c2 - 3.0 * c1 * c3)
        places = [np.zeros_like(widths), widths, (-c2 + root) / (3.0 * c3), (-c2 - root) / (3.0 * c3), -0.5 * c1 / c2]
        within = [np.where(np.isfinite(x), np.clip(x, 0.0, widths), 0.0) for x in places]
    least = np.min([c0 + x * (c1 + x * (c2 + x * c3)) for x in within], axis=0)
    place = int(np.argmin(least))
    return float(least[place]), place


# ------------------------------------------------------------------------------------------------ numbers


def _pieces(x: Sequence[float], y: Sequence[float]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Points, and the coefficients (pieces, 4) of the cubic from each to the next in powers of the distance from it."""
    edges = np.array(x)
    if len(x) == 2:
        return edges, np.array([[y[0], (y[1] - y[0]) / (x[1] - x[0]), 0.0, 0.0]])
    from scipy.interpolate import PchipInterpolator

    with np.errstate(over="ignore"):  # of a way back that is all but level
        return edges, PchipInterpolator(edges, np.array(y)).c[::-1].T.copy()


def _energies(edges: NDArray[np.float64], coefficients: NDArray[np.float64]) -> NDArray[np.float64]:
    """The integral of a curve up to each of its points."""
    h = np.diff(edges)
    c0, c1, c2, c3 = coefficients.T
    return np.concatenate(([0.0], np.cumsum(h * (c0 + h * (c1 / 2.0 + h * (c2 / 3.0 + h * c3 / 4.0))))))


def _unloading_shape(points: Points) -> tuple[float, tuple[NDArray[np.float64], NDArray[np.float64]]]:
    """Share of the penetration that springs back, and the pieces of U(x)."""
    assert points.unloading is not None
    begins = _begin_of_unloading(points.unloading)
    last, left = points.penetration[-1], points.penetration[begins]
    x = [(delta - left) / (last - left) for delta in points.penetration[begins:]]
    y = [value / points.force[-1] for value in points.unloading[begins:]]
    return (last - left) / last, _pieces([*x[:-1], 1.0], [*y[:-1], 1.0])


def _numbers(points: Points) -> NDArray[np.float64]:
    """The numbers at a table's address."""
    stiffness = points.force[-1] / points.penetration[-1]
    force = [value / stiffness for value in points.force]
    loading = _rows(*_pieces(points.penetration, force), force[-1])
    line, share, unloading = 0.0, 1.0, np.zeros((0, PIECE))
    if points.unloading_stiffness is not None:
        line, unloading = points.unloading_stiffness / stiffness, np.array([[0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
    elif points.unloading is not None:
        share, pieces = _unloading_shape(points)
        unloading = _rows(*pieces)
    head = [len(loading), len(unloading), points.penetration[-1], line, share]
    return np.concatenate([head, loading.ravel(), unloading.ravel()])


def _rows(
    edges: NDArray[np.float64], coefficients: NDArray[np.float64], last: float | None = None
) -> NDArray[np.float64]:
    """The pieces of a curve as kernels read them; after a value at its end it goes on along the slope there."""
    energies = _energies(edges, coefficients)
    rows = np.column_stack([edges[:-1], coefficients, energies[:-1]])
    if last is None:
        return rows
    h, (_, c1, c2, c3) = edges[-1] - edges[-2], coefficients[-1]
    slope = c1 + h * (2.0 * c2 + 3.0 * h * c3)
    return np.vstack([rows, [edges[-1], last, max(slope, 0.0), 0.0, 0.0, energies[-1]]])
