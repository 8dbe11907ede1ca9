"""The tables of each command, from what its Python call returned."""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pounding_risk.cli._common.tables import engineering, print_pairs, print_table, print_unused

if TYPE_CHECKING:
    from pounding_risk.ensemble.plan.plan import Plan
    from pounding_risk.solver.pair.isolated import Impact

FEW_RECORDS = 3  # that share a doubt and are named
MOST_CONTACTS = 60  # rows of the table of contacts
COUNTS = ("cases", "simulated", "known without a run of their own")
FASTER = "faster than the range of the restitution relation, which is held at its end there"


def print_plan(plan: Plan) -> None:
    """The scene in words, its records, and the doubts about them."""
    print_pairs(plan.summary())
    print()
    rows = [
        (
            record.name,
            record.event,
            record.state,
            f"{record.duration:.4g} s",
            f"{record.dt:.4g} s",
            engineering(record.pga, "m/s2"),
        )
        for record in plan.records
    ]
    print_table(("record", "event", "as found", "duration", "dt", "PGA"), rows, "lllrrr")
    _print_flags({record.name: record.flags for record in plan.records})
    print_notes(plan.notes)
    for sentence in plan.left_out:
        print(f"note: left out: {sentence}")


def print_notes(notes: Iterable[str]) -> None:
    """On unusual numbers, a line each."""
    for note in notes:
        print(f"note: {note}")


def _print_flags(flags: Mapping[str, Sequence[str]]) -> None:
    """A line for each doubt; one that many records share is told once."""
    sharing: dict[str, list[str]] = {}
    for record, sentences in flags.items():
        for sentence in sentences:
            sharing.setdefault(sentence, []).append(record)
    for sentence, records in sharing.items():
        who = ", ".join(records) if len(records) <= FEW_RECORDS else f"{records[0]} and {len(records) - 1} others"
        print(f"note: {who}: {sentence}")


def print_impacts(found: Sequence[Impact], laws: Sequence[Any], energy: float) -> None:
    """One line a law; ``energy`` is that of the approach [J]."""
    heads = ("law", "e asked", "e achieved", "peak force", "penetration", "duration", "energy lost")
    rows = [
        (
            each.law,
            f"{each.restitution_asked:.4f}" if law.needs_restitution else "–",
            f"{each.restitution:.4f}",
            engineering(each.peak_force, "N"),
            engineering(each.peak_penetration, "m"),
            f"{each.duration * 1e3:.4g} ms",
            _energy(each.energy_lost, energy),
        )
        for each, law in zip(found, laws, strict=True)
    ]
    print_table(heads, rows, "lrrrrrr")


def _energy(lost: float, approach: float) -> str:
    """Energy and its share; what is within the solver's tolerance of none is none."""
    lost = 0.0 if abs(lost) < 1e-6 * approach else lost
    return f"{engineering(lost, 'J')} ({100 * lost / approach:.0f} %)"


def print_run(dataset: Any) -> None:
    """The case, its outputs with what they mean, its contacts, and what is unusual of them."""
    if "interface" in dataset.dims:
        from pounding_risk.cli.simulate_row import print_row_run

        print_row_run(dataset)
    else:
        _print_pair_run(dataset)
    print_notes(json.loads(dataset.attrs.get("notes", "[]")))


def _print_pair_run(dataset: Any) -> None:
    from pounding_risk.scene.scene import known_law

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
    print_unused(dataset)
    print()
    print_table(("output", "value", "meaning"), _outputs(dataset), "lrl")
    print()
    rows = list(_contacts(dataset, known_law(told["contact_model"]).needs_restitution))
    if not rows:
        print("no contact")
        return
    held = json.loads(told["outputs"])["restitution_held"]
    heads = ("contact", "start", "lasts", "approach", "e asked", "rebound", "peak force", "penetration")
    print_table((*heads, "energy taken", "yields"), rows[:MOST_CONTACTS], "r" * 10)
    if len(rows) > MOST_CONTACTS:
        print(f"... and {len(rows) - MOST_CONTACTS} more; -o writes them all")
    if held > 0:
        print(f"note: {held:g} contacts are {FASTER}")


def _outputs(dataset: Any) -> Iterator[tuple[str, str, str]]:
    """Each output of the run and of its buildings: name, value, meaning."""
    from pounding_risk.solver.pair.outputs import BUILDING, RUN

    values = json.loads(dataset.attrs["outputs"])
    for name, output in RUN.items():
        value = values[name]
        # A count of −1 is none: the run failed, or the contact model does not define it.
        count = f"{value:g}" if value >= 0.0 else "–"
        yield name, count if output.whole else engineering(value, output.unit), output.words
    sides = json.loads(dataset.attrs["building_outputs"])
    for name, (unit, words, _) in BUILDING.items():
        for building, value in zip(dataset["building"].values, sides[name], strict=True):
            yield f"{name}, {building}", engineering(value, unit), words


def _contacts(dataset: Any, damped: bool) -> Iterator[tuple[str, ...]]:
    names = ("start", "end", "approach_speed", "restitution_asked", "rebound_speed", "peak_force", "work", "yields")
    columns = [dataset[f"contact_{name}"].values for name in (*names, "peak_penetration")]
    rows = zip(*columns, strict=True)
    for number, (start, end, speed, e, rebound, force, work, yields, depth) in enumerate(rows, start=1):
        yield (
            str(number),
            f"{start:.4f} s",
            f"{1e3 * (end - start):.3g} ms",
            engineering(speed, "m/s", 3),
            f"{e:.3f}" if damped else "–",
            engineering(rebound, "m/s", 3),
            engineering(force, "N"),
            engineering(depth, "m", 3),
            engineering(work, "J"),
            f"{yields:g}",
        )


def print_scan(dataset: Any, seconds: float, target: Path, kept: int = 0) -> None:
    """How many cases there were, how they ended, how long it took, and where the results are.

    ``kept`` of them were there when it started.
    """
    from pounding_risk.results.contact_notes import of_results
    from pounding_risk.results.summary import counted, failures
    from pounding_risk.results.tolerance_check import findings

    counts = counted(dataset)
    pairs = [(name, str(counts[name])) for name in COUNTS]
    pairs += [*findings(dataset), *(("failed", f"{count}: {name}") for name, count in failures(dataset).items())]
    rate = (counts["cases"] - kept) / seconds
    speed = f"{rate:.0f}" if rate >= 100.0 else f"{rate:.3g}"
    pairs.append(("time", f"{seconds:.3g} s, {speed} cases a second with reading and compiling"))
    print_pairs([*pairs, ("written", str(target))])
    _print_flags(json.loads(dataset.attrs.get("flags", "{}")))
    print_notes(of_results(dataset))
    for sentence in json.loads(dataset.attrs.get("left_out", "[]")):
        print(f"note: left out: {sentence}")
    print_unused(dataset)
    held = int((dataset["restitution_held"] > 0).sum())
    if held:
        print(f"note: {held} cases have contacts {FASTER}")
