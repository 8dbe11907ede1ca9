"""Wave passage: the motion reaches one building later than the other."""

from __future__ import annotations

from collections.abc import Sequence
from math import inf
from typing import NamedTuple

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.models.effects import PerInterface, effect
from pounding_risk.models.ground import Support
from pounding_risk.units import Quantity

ORDER = 40
APPARENT = Quantity("m/s", 1.0, inf, "apparent velocity of the wave along the row", open_high=True, example="1000 m/s")
DISTANCE = PerInterface("m", 0.0, inf, "distance between the supports of neighbours", open_high=True, example="20 m")


@effect(
    reference="Der Kiureghian (1996), A coherency model for spatially varying ground motions: the wave-passage effect",
    options={"velocity": APPARENT, "distance": DISTANCE, "towards": ("left", "right")},
)
class WavePassage(NamedTuple):
    """The motion reaches one building later than the other, by τ = distance / apparent velocity; a_far(t) = a(t − τ).

    The ground itself then moves the buildings together and apart, by about τ times its velocity. The later
    motion is the same as the prompt one, sample by sample, whatever part of a sample τ ends in. In a row the wave
    passes from building to building; ``distance`` is that of all neighbours, or a list with one for each interface,
    between the centres of the buildings.

    >>> WavePassage.on(velocity=500.0, distance=20.0).lag
    0.04
    >>> WavePassage.on(velocity=500.0, distance=(20.0, 10.0), towards="left").arrivals(3)
    array([0.06, 0.02, 0.  ])
    """

    lag: float  # s, by which the right of two neighbours has the motion later; below zero the left one has
    lags: tuple[float, ...] = ()  # the same of each interface; ``lag`` is then the longest of them

    @classmethod
    def on(cls, velocity: float, distance: float | Sequence[float], towards: str = "right") -> WavePassage:
        """A wave that travels ``towards`` the right or left building; apparent velocity [m/s], distance [m]."""
        sign = 1.0 if towards == "right" else -1.0
        if not isinstance(distance, Sequence):
            return cls(sign * distance / velocity)
        lags = tuple(sign * each / velocity for each in distance)
        return cls(max(lags, key=abs), lags)

    def arrivals(self, buildings: int) -> np.ndarray:
        """When the motion arrives at each building of a row, the first to be reached at zero [s]."""
        lags = self.lags or (self.lag,) * (buildings - 1)
        if len(lags) != buildings - 1:
            raise PoundingError(
                f"wave_passage: {len(lags)} distances for {buildings} buildings; write one for all, or "
                f"{buildings - 1}, one between each two neighbours from left to right"
            )
        times = np.append(0.0, np.cumsum(lags))
        return times - times.min()

    def supports(self, buildings: int) -> tuple[Support, ...]:
        """What the wave makes of one ground under so many buildings."""
        return tuple(Support(delay=time) for time in self.arrivals(buildings).tolist())
