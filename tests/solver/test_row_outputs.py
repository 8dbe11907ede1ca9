"""Columns of a row's interfaces, gathered from those of its contact points."""

from __future__ import annotations

from collections import Counter
from types import SimpleNamespace
from typing import Any

import numpy as np

from pounding_risk.models.structures.links import Link
from pounding_risk.results.layout import AXES
from pounding_risk.results.variables import MOTION, VARIABLES
from pounding_risk.solver.counters import APPROACH, PLASTIC, STATUS, TALLIED
from pounding_risk.solver.pair.outputs import BUILDING, COLUMNS, RUN
from pounding_risk.solver.row import outputs
from pounding_risk.solver.row.api import HIGHEST, LOWEST, POINT_COLUMNS
from pounding_risk.solver.row.outputs import GATHERED, HIGH, LOW, OF_LINKS, POINT, Variable


def test_every_counter_is_gathered_once():
    """One that is in no group would be zero in every row, without an error."""
    gathered = Counter(column for group, _ in GATHERED for column in group)
    assert set(gathered) == {*range(TALLIED), HIGH, LOW} - {STATUS}
    assert set(gathered.values()) == {1} and max(gathered) < COLUMNS


def test_every_output_has_its_place_and_its_unit_in_a_dataset():
    """One without a place would end in a KeyError; one of another unit would be read as a thousandth, or as a g."""
    own = [value for value in vars(outputs).values() if isinstance(value, dict) and value]
    of_rows = {name: each for table in own for name, each in table.items() if isinstance(each, Variable)}
    of_rows |= {name: Variable(output.unit, "", ("interface",)) for name, output in RUN.items()}
    of_rows |= {f"{POINT}{name}": Variable(RUN[name].unit, "", ("contact_point",)) for name in outputs.OF_POINTS}
    of_rows |= {name: Variable(unit, "", ("building",)) for name, (unit, _, _) in BUILDING.items()}
    for name, output in of_rows.items():
        assert VARIABLES[name].dims == (*AXES, *output.dims) and VARIABLES[name].unit == output.unit, name
    for name in (*outputs.OF_BUILDINGS, *outputs.OF_STOREYS, *outputs.OF_YIELDING, *outputs.OF_LAWS, *OF_LINKS):
        assert VARIABLES[f"{name}_free"] == VARIABLES[name]._replace(dims=(*MOTION, *of_rows[name].dims)), name


def test_every_output_of_links_is_that_of_its_links():
    """A spring that has broken and a damper of a power law between the same two buildings, none between the others."""
    links = [Link(1, 1.0, 1.0, 2e7, 0.0, breaking=1e5), Link(1, 1.0, 1.0, 0.0, 3e5, exponent=1.0)]
    points = np.zeros((2, POINT_COLUMNS))
    points[:, LOWEST], points[:, HIGHEST] = (-0.004, -0.006), (0.001, 0.002)
    points[:, APPROACH], points[:, PLASTIC] = (0.0, 0.2), (250.0, 40.0)
    model = SimpleNamespace(links=links, chains=[0, 1, 2], is_link=np.array([True, True]), interfaces=np.array([1, 1]))
    frame: Any = SimpleNamespace(model=model, of_links=lambda: list(OF_LINKS))
    found = outputs._of_links(SimpleNamespace(points=points, status=0), frame)  # type: ignore[arg-type]
    expected = {
        "peak_link_stretch": 0.006,
        "peak_link_shortening": 0.002,
        "peak_link_spring_force": 8e4,  # k e of the spring's own stretch
        "link_energy": 290.0,
        "peak_link_damper_force": 6e4,  # c v
        "broken_links": 1.0,
    }
    assert list(found) == list(OF_LINKS) == list(expected)
    for name, value in expected.items():
        np.testing.assert_allclose(found[name], [np.nan, value], rtol=1e-15, err_msg=name)
    failed = outputs._of_links(SimpleNamespace(points=points, status=3), frame)  # type: ignore[arg-type]
    assert np.isnan(list(failed.values())).all()
