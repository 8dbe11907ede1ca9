"""Columns of a row's interfaces, gathered from those of its contact points."""

from __future__ import annotations

from collections import Counter

from pounding_risk.solver.counters import STATUS, TALLIED
from pounding_risk.solver.pair.outputs import COLUMNS
from pounding_risk.solver.row.outputs import GATHERED, HIGH, LOW


def test_every_counter_is_gathered_once():
    """One that is in no group would be zero in every row, without an error."""
    gathered = Counter(column for group, _ in GATHERED for column in group)
    assert set(gathered) == {*range(TALLIED), HIGH, LOW} - {STATUS}
    assert set(gathered.values()) == {1} and max(gathered) < COLUMNS
