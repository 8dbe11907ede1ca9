"""The hard cases of pounding: each module of `cases` declares its own, `stability` runs and the tests assert them."""

from pounding_risk.lab.stability.case import Bound, Case, Row
from pounding_risk.lab.stability.run import CASES, stability

__all__ = ["CASES", "Bound", "Case", "Row", "stability"]
