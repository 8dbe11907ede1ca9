"""Hard cases of isolated buildings against the walls of their moats, which their slab strikes."""

from __future__ import annotations

from pounding_risk.lab.stability.case import ENERGY, FORCES, LEDGER, Group
from pounding_risk.lab.stability.trial import WALL, Trial
from pounding_risk.models.structures.contact_points import FLOOR, Point
from pounding_risk.models.structures.isolation import Isolators
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.solver.row.model import RowModel

GROUP = Group("isolated")

ABOVE = Storeys("above the slab", (5e5, 5e5, 4e5), (1e9, 1e9, 8e8), (4.0, 4.0, 4.0))
BEARINGS = Isolators(6e5, 1.5, strength=9e5, stiffness=5e6, yield_displacement=0.01, damping=2e5)
SLIDERS = Isolators(6e5, 1.5, friction=0.05, radius=2.0, yield_displacement=1e-6)  # m, next to a stick


@GROUP.case(
    "50a",
    "lead-rubber bearings between walls without a gap, shaken",
    ENERGY,
    LEDGER,
    FORCES,
    isolators=BEARINGS,
    gap=0.0,
)
@GROUP.case(
    "50b", "friction pendulums beside walls at 10 mm, shaken", ENERGY, LEDGER, FORCES, isolators=SLIDERS, gap=0.01
)
def in_its_moat(trial: Trial, isolators: Isolators, gap: float) -> float:
    """Energy unaccounted for, over the largest; infinite without contact at both walls, or where one pulls."""
    points = [Point(interface, 1.0, 1.0, FLOOR, isolators.height) for interface in range(2)]
    return trial.unsound_row(RowModel([chain_of(one) for one in (WALL, ABOVE.isolated(isolators), WALL)], points), gap)
