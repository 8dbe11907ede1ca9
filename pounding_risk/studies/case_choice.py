"""Which cases of a grid: those of chosen values of its axes, or of each contact model that with most of an output."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import product
from math import isclose, isinf
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.words import nearest
from pounding_risk.errors import PoundingError
from pounding_risk.results.layout import AXES
from pounding_risk.scene.scene import Study
from pounding_risk.units import GAP, PGA, YIELD_FORCE, Quantity, say, si

if TYPE_CHECKING:
    import xarray as xr

LAW = AXES.index("contact_model")
NEAR = 1e-9  # relative: a value of the grid that was written down and read again
FEW = 8  # values of a grid that a sentence lists
QUANTITIES = {"pga": PGA, "gap": GAP, "yield_force": YIELD_FORCE}
Asked = dict[str, Sequence[Any] | None]  # by axis; None for all values of it


class Choice(NamedTuple):
    """Chosen cases of a study."""

    places: NDArray[np.int64]  # (cases, axes) along `AXES`, in their order
    shape: tuple[int, ...]  # along `AXES`
    by_law: bool  # one case of each contact model: the other axes are told along it

    @property
    def records(self) -> list[int]:
        """Places of the records that the cases have, ascending."""
        return sorted(set(self.places[:, 0].tolist()))


def values_of(study: Study, records: Sequence[str]) -> dict[str, tuple[Any, ...]]:
    """The values of a study's grid by axis, in the order of `AXES`; ``records`` are the names of its motions."""
    grid = study.grid
    along = (tuple(records), study.records.polarities, grid.pgas, grid.contact_models, grid.gaps, grid.yield_forces)
    return dict(zip(AXES, along, strict=True))


def chosen(values: dict[str, tuple[Any, ...]], asked: Asked) -> Choice:
    """The cases of these values along each axis.

    A number stands for the value of the grid that is as large, within 1e-9 of it. Raises PoundingError for what the
    grid does not have.
    """
    picked = [_places(axis, values[axis], asked.get(axis)) for axis in AXES]
    return Choice(np.array(list(product(*picked)), dtype=np.int64), tuple(map(len, picked)), False)


def largest(results: xr.Dataset, output: str, among: Choice) -> Choice:
    """Of each contact model the case ``among`` these in which an output of the results is largest.

    An output of interfaces, storeys or buildings counts with its largest value. Raises PoundingError for what is no
    output of a case, and where no case of a contact model has one.
    """
    dims = [axis for axis in AXES if axis in results.dims]
    of_cases = [str(name) for name, found in results.data_vars.items() if set(dims) <= set(found.dims)]
    if output not in of_cases:
        raise PoundingError(
            f"{output} is no output of a case{nearest(output, of_cases)}; the results have {', '.join(of_cases)}"
        )
    array = results[output].transpose(*dims, ...)
    whole = tuple(results.sizes.get(axis, 1) for axis in AXES)
    values = array.values.astype(np.float64).reshape(*whole, -1)
    peaks = np.where(np.isnan(values), -np.inf, values).max(axis=-1)[tuple(among.places.T)]
    best = []
    for law in dict.fromkeys(among.places[:, LAW].tolist()):
        own = np.flatnonzero(among.places[:, LAW] == law)
        first = own[peaks[own].argmax()]
        if isinf(peaks[first]):
            name = results["contact_model"].values[law]
            raise PoundingError(f"no chosen case of {name} has a finite {output}; choose other cases or another output")
        best.append(among.places[first])
    shape = [1] * len(AXES)
    shape[LAW] = len(best)
    return Choice(np.array(best), tuple(shape), True)


def _places(axis: str, known: tuple[Any, ...], asked: Sequence[Any] | None) -> list[int]:
    """Places of the values asked for, in the order of the grid; of all where nothing is asked."""
    if asked is None:
        return list(range(len(known)))
    if not asked:
        raise PoundingError(f"{_words(axis)}: the list is empty; name one value at least, or leave it out for all")
    return sorted({_place(axis, known, value) for value in asked})


def _place(axis: str, known: tuple[Any, ...], value: Any) -> int:
    """Place of a value; a number in SI, or text with a unit."""
    if axis in QUANTITIES:
        value = si(value, QUANTITIES[axis], _words(axis))
    if known == (None,):
        raise PoundingError(
            "the scene scales its records to no PGA, so that there is none to choose; leave it out, or choose records"
        )
    for place, one in enumerate(known):
        if one == value or (axis in QUANTITIES and isclose(one, value, rel_tol=NEAR)):
            return place
    raise PoundingError(_absent(axis, known, value))


def _absent(axis: str, known: tuple[Any, ...], value: Any) -> str:
    quantity = QUANTITIES.get(axis)
    if quantity is None:
        return f"{_words(axis)} {value!r} is not in the grid{nearest(str(value), known)}, which has {_listed(known)}"
    told = say(value, quantity, 10)
    beside = sorted(known, key=lambda one: abs(one - value) if not isinf(one) else np.inf)[:2]
    close = f" (next to it are {_numbers(sorted(beside), quantity)})" if len(known) > FEW else ""
    return f"{_words(axis)} {told} is not in the grid, which has {_numbers(known, quantity)}{close}"


def _numbers(values: Sequence[float], quantity: Quantity) -> str:
    return _listed([say(value, quantity, 10) for value in values])


def _listed(values: Sequence[str]) -> str:
    """All where they are few, otherwise how many from which to which."""
    return ", ".join(values) if len(values) <= FEW else f"{len(values)} from {values[0]} to {values[-1]}"


def _words(axis: str) -> str:
    return "PGA" if axis == "pga" else axis.replace("_", " ")
