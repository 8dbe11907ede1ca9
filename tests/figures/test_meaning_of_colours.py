"""A colour means one thing in every figure of an assessment."""

from __future__ import annotations

import numpy as np
import pytest
from made_scan import made_scan
from matplotlib.colors import to_hex

from pounding_risk.assessment.assess import assess
from pounding_risk.assessment.separations.rules import VERIFICATIONS
from pounding_risk.assessment.separations.table import Comparison, SeparationRow, code_table
from pounding_risk.figures.assess import assessment_figure
from pounding_risk.figures.separations import draw_rules, separations_figure
from pounding_risk.figures.style import MEANING, RULE_MARKS, STYLES, contact_styles, panel, strength_styles, styles


@pytest.fixture(scope="module")
def scan():
    """A dataset as a scan writes it, made and not solved."""
    return made_scan(5, np.linspace(0.0, 0.1, 6), (2e5, np.inf), 2)


def colours(axis) -> dict[str, str]:
    """Colour of each line by its label."""
    return {str(line.get_label()): to_hex(line.get_color()) for line in axis.get_lines()}


def named(found: dict[str, str], start: str) -> set[str]:
    return {colour.upper() for label, colour in found.items() if label.startswith(start)}


def test_no_two_meanings_share_a_colour():
    assert len(set(MEANING.values())) == len(MEANING)
    forces = {colour.upper() for count in range(7) for colour, _ in strength_styles(count)}
    assert not forces & {colour.upper() for colour in MEANING.values()}
    assert contact_styles(1)[0][0] == MEANING["motions"]


def test_lines_of_one_colour_differ_in_their_dashes():
    """Fourteen contact models stand in one figure of `compare`."""
    assert len(set(styles(24))) == 24 and styles(6) == list(STYLES)


def test_what_is_drawn_twice_has_one_colour(scan):
    """The gap, the target, the required gap and code rules, in the figures of assess and separations."""
    assessed = colours(assessment_figure(assess(scan)).axes[0])
    beside = colours(separations_figure(code_table(scan)).axes[0])
    assert named(assessed, "the gap") == {MEANING["gap"]} and named(assessed, "target") == {MEANING["target"]}
    assert named(assessed, "required by") == named(beside, "required by") == {MEANING["required gap"]}
    assert named(beside, "gap needed") == {MEANING["motions"]}
    for name in ("ABS", "SRSS", "CQC"):
        assert named(beside, name) == named(assessed, name) == {MEANING["rule"]}


def test_how_a_clause_is_known_is_shown_by_the_mark_alone():
    assert set(RULE_MARKS) == set(VERIFICATIONS)
    rows = [SeparationRow(known, known, "", None, known, "", "", 0.1, "") for known in VERIFICATIONS]
    (axis,) = panel(draw_rules, [Comparison(row, 0.1, 0.1, 0.9, 1.0, 1.1, 0.0) for row in rows], 24).axes
    marks = [line for line in axis.get_lines() if line.get_marker() in ("o", "s")]
    assert [line.get_fillstyle() for line in marks] == ["full", "full", "left", "none"]
    assert {to_hex(line.get_color()).upper() for line in marks} == {MEANING["rule"]}
