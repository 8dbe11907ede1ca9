"""Wave passage: the motion reaches one building later than the other."""

from __future__ import annotations

from math import inf
from typing import Any, NamedTuple

from pounding_risk.models.effects._effect import effect
from pounding_risk.models.ground import DelayedGround, delayed
from pounding_risk.units import Quantity

ORDER = 40
APPARENT = Quantity("m/s", 1.0, inf, "apparent velocity of the wave along the row", open_high=True, example="1000 m/s")
DISTANCE = Quantity("m", 0.0, inf, "distance between the buildings' supports", open_high=True, example="20 m")


@effect(
    reference="Der Kiureghian (1996), A coherency model for spatially varying ground motions: the wave-passage effect",
    options={"velocity": APPARENT, "distance": DISTANCE, "towards": ("left", "right")},
)
class WavePassage(NamedTuple):
    """The motion reaches one building later than the other, by τ = distance / apparent velocity; a_far(t) = a(t − τ).

    The ground itself then moves the buildings together and apart, by about τ times its velocity. The later
    motion is the same as the prompt one, sample by sample, whatever part of a sample τ ends in.

    >>> WavePassage.on(velocity=500.0, distance=20.0).lag
    0.04
    """

    lag: float  # s, by which the right building has the motion later; below zero the left one has

    @classmethod
    def on(cls, velocity: float, distance: float, towards: str = "right") -> WavePassage:
        """A wave that travels ``towards`` the right or left building; apparent velocity [m/s], distance [m]."""
        return cls(distance / velocity if towards == "right" else -distance / velocity)

    def grounds(self, ground: Any, step: float) -> DelayedGround:
        """The motion under each building, from a_g [m/s²] at samples ``step`` [s] apart."""
        return delayed(ground, step, self.lag)
