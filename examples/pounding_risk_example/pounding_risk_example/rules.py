"""A separation rule: a row of `pounding-risk separations`."""

from pounding_risk.assessment.separations.rules import MEMORY, Rule

HEIGHT_RATIO = Rule(
    name="height_ratio",
    title="an example",
    clause="no code",
    year=None,
    formula="0.02 h of the lower building",
    verification=MEMORY,
    source="",
    needs=("heights",),
    assumes=(),
    function=lambda case: 0.02 * case.lower,
)
