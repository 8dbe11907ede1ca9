"""The tables of each command, from what its Python call returned."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk.cli_output import engineering, print_pairs, print_table, say_line

if TYPE_CHECKING:
    from pounding_risk.catalogue import Entry
    from pounding_risk.impact import Impact
    from pounding_risk.plan import Plan

MOST_CONTACTS = 60  # rows of the table of contacts


def print_impacts(found: Sequence[Impact], laws: Sequence[Any], energy: float) -> None:
    from pounding_risk.cli_output import engineering, print_table

    heads = ("law", "e asked", "e achieved", "peak force", "penetration", "duration", "energy lost")
    rows = [
        (
            each.law,
            f"{each.restitution_asked:.4f}" if law.needs_restitution else "–",
            f"{each.restitution:.4f}",
            engineering(each.peak_force, "N"),
            engineering(each.peak_penetration, "m"),
            f"{each.duration * 1e3:.4g} ms",
            f"{engineering(each.energy_lost, 'J')} ({100 * each.energy_lost / energy:.0f} %)",
        )
        for each, law in zip(found, laws, strict=True)
    ]
    print_table(heads, rows)


def print_run(dataset: Any) -> None:
    """The case, its outputs with what they mean, and its contacts."""
    from pounding_risk.cli_output import engineering, print_pairs, print_table
    from pounding_risk.outputs import BUILDING, RUN

    told = dataset.attrs
    print_pairs(
        [
            ("scene", told["title"]),
            ("record", f"{told['record']}, {told['polarity']}, PGA {engineering(told['pga'], 'm/s2')}"),
            ("contact model", told["contact_model"]),
            ("gap", engineering(told["gap"], "m")),
            ("yield force", engineering(told["yield_force"], "N")),
            ("status", told["status"]),
        ]
    )
    typer.echo()
    rows = [
        (name, f"{value:g}" if RUN[name].whole else engineering(value, RUN[name].unit), RUN[name].words)
        for name, value in json.loads(told["outputs"]).items()
    ]
    for name, values in json.loads(told["building_outputs"]).items():
        unit, words, _ = BUILDING[name]
        sides = zip(dataset["building"].values, values, strict=True)
        rows += [(f"{name}, {side}", engineering(value, unit), words) for side, value in sides]
    print_table(("output", "value", ""), rows)
    typer.echo()
    _print_contacts(list(_contacts(dataset)))


def _contacts(dataset: Any) -> Iterator[tuple[str, ...]]:
    from pounding_risk.cli_output import engineering

    names = ("start", "end", "approach_speed", "restitution_asked", "rebound_speed", "peak_force", "work", "yields")
    columns = [dataset[f"contact_{name}"].values for name in (*names, "peak_penetration")]
    for number, (start, end, speed, e, rebound, force, work, yields, depth) in enumerate(
        zip(*columns, strict=True), start=1
    ):
        yield (
            str(number),
            f"{start:.4f} s",
            f"{1e3 * (end - start):.3g} ms",
            engineering(speed, "m/s", 3),
            f"{e:.3f}",
            f"{rebound / speed:.3f}" if speed > 0.0 else "–",
            engineering(force, "N"),
            engineering(depth, "m", 3),
            engineering(work, "J"),
            f"{yields:g}",
        )


def _print_contacts(rows: list[tuple[str, ...]]) -> None:
    from pounding_risk.cli_output import print_table

    if not rows:
        typer.echo("no contact")
        return
    heads = ("contact", "start", "lasts", "approach", "e asked", "e achieved", "peak force", "penetration")
    print_table((*heads, "energy taken", "yields"), rows[:MOST_CONTACTS], left=0)
    if len(rows) > MOST_CONTACTS:
        typer.echo(f"... and {len(rows) - MOST_CONTACTS} more; -o writes them all")


def print_scan(dataset: Any, seconds: float, target: Path | None) -> None:
    from pounding_risk.cli_output import print_pairs
    from pounding_risk.ensemble import summary

    counts = summary(dataset)
    usual = ("cases", "simulated", "known without a run of their own")
    pairs = [(name if name in usual else "failed", _counted(name, count, usual)) for name, count in counts.items()]
    rate = counts["cases"] / seconds
    pairs.append(("time", f"{seconds:.3g} s, {rate:.3g} cases a second, reading and compiling included"))
    print_pairs([*pairs, ("written", str(target))])


def _counted(name: str, count: int, usual: Sequence[str]) -> str:
    return str(count) if name in usual else f"{count}: {name}"
