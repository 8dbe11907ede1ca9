"""The value that a share of counted values does not exceed, and places spread evenly over values."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

Array = NDArray[np.float64]

ROUNDING = 1e-9  # of a count: 95 % of 20 values are 19 of them, whatever 0.95 × 20 is in binary


def enough_for(values: ArrayLike, percentiles: ArrayLike, axis: int | None = None) -> Array:
    """The least of the values that at least so many % of them, counted, do not exceed.

    The order statistic of rank ⌈p n⌉, without interpolation: "p % of the values are no more than this" is true, and is
    true of no smaller value. Definition 1 of Hyndman and Fan, Sample Quantiles in Statistical Packages, The American
    Statistician 50 (1996). Infinite values are the largest.

    Parameters
    ----------
    values : array_like
        The values, at least one along ``axis``; those that are NaN are left out.
    percentiles : array_like
        Shares in %, between 0 and 100.
    axis : int, optional
        Of the values that are counted; all of them by default.

    Returns
    -------
    ndarray
        The axes of ``percentiles`` first, then the other axes of ``values``; NaN where all values are.

    >>> float(enough_for([10.0, 20.0, 30.0, 40.0], 75.0))
    30.0
    >>> float(enough_for([10.0, 20.0, 30.0, 40.0], 76.0))  # three of four are 75 %
    40.0
    """
    table = np.asarray(values, dtype=float)
    rising = np.sort(table.ravel() if axis is None else np.moveaxis(table, axis, 0), axis=0)  # NaN last
    counts = (~np.isnan(rising)).sum(axis=0)
    ranks = np.ceil(np.multiply.outer(np.asarray(percentiles) / 100.0, counts) - ROUNDING).astype(int)
    places = np.maximum(ranks, 1) - 1
    return np.take_along_axis(rising, places.reshape(-1, *counts.shape), axis=0).reshape(places.shape)


def evenly(count: int, most: int) -> list[int]:
    """At most ``most`` of the places of ``count`` values, evenly spread, first and last among them; of one the first.

    >>> evenly(7, 3), evenly(2, 3)
    ([0, 3, 6], [0, 1])
    """
    if count <= most:
        return list(range(count))
    return [round(place) for place in np.linspace(0, count - 1, most).tolist()]
