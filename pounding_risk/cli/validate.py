"""The command `validate`: a scene and its records, checked and summarised."""

from __future__ import annotations

from typing import TYPE_CHECKING

from pounding_risk.cli._common.options import NONE, Overrides, Scene
from pounding_risk.questions.notes import of_records
from pounding_risk.render.terminal import engineering, print_left_out, print_notes, print_pairs, print_table

if TYPE_CHECKING:
    from pounding_risk.ensemble.plan.plan import Plan

ORDER = 20


def validate(scene: Scene, overrides: Overrides = NONE) -> None:
    """Check a scene and its records; run nothing."""
    from pounding_risk.ensemble.plan.plan import validate as run

    print_plan(run(scene, overrides))


def print_plan(plan: Plan) -> None:
    """Print the summary of a scene, a table of its records, and notes on both."""
    print_pairs(plan.summary())
    print()
    rows = []
    for record in plan.records:
        times = f"{record.duration:.4g} s", f"{record.dt:.4g} s"
        rows.append((record.name, record.event, record.state, *times, engineering(record.pga, "m/s2")))
    print_table(("record", "event", "as found", "duration", "dt", "PGA"), rows, "lllrrr")
    print_notes((*of_records({record.name: record.flags for record in plan.records}), *plan.notes))
    print_left_out(plan.left_out)
