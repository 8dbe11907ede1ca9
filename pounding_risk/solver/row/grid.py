"""Laws, gaps and yield forces by contact point: the grid of a row in numbers."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk.solver.row.cases import Limits, Mechanics
from pounding_risk.solver.row.model import RowModel
from pounding_risk.solver.row.outputs import Frame

Array = NDArray[np.float64]


class RowGrid(NamedTuple):
    """The grid of a study of a row, as its cases need it."""

    frame: Frame
    mechanics: tuple[Mechanics, ...]  # by contact model
    gaps: Array  # (gaps, interfaces) [m]
    yield_forces: Array  # (yield forces, points of the model) [N]
    rtol: float

    @property
    def model(self) -> RowModel:
        """The row of buildings with its contact points."""
        return self.frame.model

    @property
    def shape(self) -> tuple[int, int, int]:
        """Numbers of contact models, gaps and yield forces."""
        return len(self.mechanics), len(self.gaps), len(self.yield_forces)

    def limits(self, gap: int, strength: int) -> Limits:
        """Gaps and yield forces of one case, by point of the model."""
        return Limits(self.model.gaps(self.gaps[gap]), self.yield_forces[strength], self.yield_forces[-1])
