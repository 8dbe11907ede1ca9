"""What the motions do to two neighbours under each yield force F_E: the largest response, not whether F_E is reached.

Whether the force reaches F_E depends on F_E by what the words say. What the buildings feel of it is another question:
peaks of displacement, acceleration, force, penetration and ductility, over the motions that bring contact.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from pounding_risk.assessment.demands import by_motion

if TYPE_CHECKING:
    import xarray as xr

# Outputs of a dataset as far as it has them: what they are called, and their unit. Of two buildings or several storeys
# the largest counts.
OUTPUTS = {
    "peak_relative_displacement": ("peak relative displacement", "m"),
    "peak_floor_acceleration": ("peak floor acceleration", "m/s2"),
    "peak_contact_force": ("peak contact force", "N"),
    "peak_penetration": ("peak penetration", "m"),
    "storey_ductility": ("storey ductility", "1"),
}
LOW, MIDDLE, HIGH = 16.0, 50.0, 84.0
CASES = ("contact_model", "yield_force")


@dataclass(frozen=True)
class Response:
    """One output at one gap [m], contact model and F_E [N], over the motions with contact: 16, 50 and 84 %.

    ``output`` is the dataset's variable, the larger of both buildings' where each has its own; values are NaN where no
    motion brings contact or the contact model has no such output.
    """

    output: str
    words: str
    unit: str
    gap: float
    contact_model: str
    yield_force: float
    low: float
    median: float
    high: float
    motions: int


def responses_of(results: xr.Dataset, gap: float) -> tuple[Response, ...]:
    """Every output of `OUTPUTS` that a dataset of one interface and amplitude has, by contact model and F_E.

    Parameters
    ----------
    results : xarray.Dataset
        One interface of what `scan` writes, at one amplitude.
    gap : float
        One of the grid's gaps [m].
    """
    one = results.isel(gap=int(np.abs(results["gap"].values - gap).argmin()))
    touching = by_motion(one["impact_count"], CASES) > 0
    found = []
    for output, (words, unit) in OUTPUTS.items():
        if output not in one:
            continue
        inside = [axis for axis in one[output].dims if axis not in ("record", "polarity", *CASES)]
        values = np.where(touching, by_motion(one[output].max(inside), CASES), np.nan)
        for place, force in np.ndindex(values.shape[1:]):
            known = values[np.isfinite(values[:, place, force]), place, force]
            spread = np.percentile(known, (LOW, MIDDLE, HIGH)) if known.size else np.full(3, np.nan)
            about = (str(one["contact_model"].values[place]), float(one["yield_force"].values[force]))
            low, median, high = map(float, spread)
            found.append(Response(output, words, unit, gap, *about, low, median, high, known.size))
    return tuple(found)
