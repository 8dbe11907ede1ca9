"""The hard cases of pounding: one table, which `stability` prints and the tests assert."""

from pounding_risk.studies.stability.case import Bound, Case, Row
from pounding_risk.studies.stability.run import stability
from pounding_risk.studies.stability.table import CASES, LATER

__all__ = ["CASES", "LATER", "Bound", "Case", "Row", "stability"]
