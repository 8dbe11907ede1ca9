"""The command `simulate`: one run in full, of a pair or of a row."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from pounding_risk.cli._common.files import announce, draw
from pounding_risk.cli._common.notes import FASTER, print_notes, print_unused
from pounding_risk.cli._common.options import (
    NONE,
    RUN_FAILED,
    Figure,
    Overrides,
    Scene,
    Strict,
    file_option,
    option,
    out_option,
    read_optional,
)
from pounding_risk.cli._common.tables import engineering, print_pairs, print_table
from pounding_risk.errors import PoundingError

ORDER = 40
MOST_CONTACTS = 60  # rows of the table of contacts
OF_BUILDINGS = {
    "peak_displacement": "m",
    "peak_drift": "m",
    "peak_storey_shear": "N",
    "peak_floor_acceleration": "m/s2",
}


def simulate(
    scene: Scene,
    overrides: Overrides = NONE,
    record: Annotated[str | None, option("A record of the scene.", "its first")] = None,
    polarity: Annotated[str | None, option("as recorded, or reversed.", "its first")] = None,
    law: Annotated[str | None, option("Contact model.", "the interface's")] = None,
    gap: Annotated[str | None, option("Clear distance at rest.", "the interface's")] = None,
    yield_force: Annotated[str | None, option("F_E, or inf.", "the interface's")] = None,
    pga: Annotated[str | None, option("Peak ground acceleration.", "the first")] = None,
    out: Annotated[Path | None, out_option("Write histories", ".nc")] = None,
    figure: Figure = None,
    animation: Annotated[Path | None, file_option("A row's run, moving", (".html",))] = None,
    strict: Strict = False,
) -> None:
    """Run one case in full: outputs, contacts, histories."""
    from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable
    from pounding_risk.results.files import save
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.simulate import simulate as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    values = {
        "gap": read_optional("--gap", gap, GAP),
        "yield_force": read_optional("--yield-force", yield_force, YIELD_FORCE),
        "pga": read_optional("--pga", pga, PGA),
    }
    study = read_scene(scene, overrides)
    if animation is not None and not study.is_row:
        raise PoundingError(
            "--animation: shows a row, and this scene is a pair of single masses; draw its run with --figure run.png"
        )
    if out is not None:
        check_replaceable(out, "simulate", choice=OTHER_NAME)
    dataset = run(study, record=record, polarity=polarity, law=law, **values)
    print_run(dataset)
    if out is not None:
        save(dataset, out)
    announce(out)
    draw(figure, "simulate.simulation_figure", dataset)
    if animation is not None:
        from pounding_risk.reports.animation import animate

        announce(animate(dataset, animation))
    if strict and dataset.attrs["status"] != "complete":
        raise typer.Exit(RUN_FAILED)


def print_run(dataset: Any) -> None:
    """Print the case, its outputs, its contacts, and notes on what is unusual."""
    is_row = "interface" in dataset.dims
    facts = dataset.attrs
    levels = () if is_row else (("gap", "m"), ("yield_force", "N"))  # of a pair's one interface
    print_pairs(
        [
            ("scene", facts["title"]),
            ("record", f"{facts['record']}, {facts['polarity']}, PGA {engineering(facts['pga'], 'm/s2')}"),
            ("contact model", facts["contact_model"]),
            *((name.replace("_", " "), engineering(facts[name], unit)) for name, unit in levels),
            ("status", facts["status"]),
        ]
    )
    print_unused(dataset)
    print()
    if is_row:
        _print_row(dataset)
    else:
        _print_pair(dataset)
    print_notes(json.loads(facts.get("notes", "[]")))


def _print_pair(dataset: Any) -> None:
    """Print the outputs of a pair and a table of its contacts."""
    from pounding_risk.scene.interfaces import known_law

    print_table(("output", "value", "meaning"), _outputs(dataset), "lrl")
    print()
    rows = list(_contacts(dataset, known_law(dataset.attrs["contact_model"]).needs_restitution))
    if not rows:
        print("no contact")
        return
    n_held = json.loads(dataset.attrs["outputs"])["restitution_held"]
    heads = ("contact", "start", "lasts", "approach", "e asked", "rebound", "peak force", "penetration")
    print_table((*heads, "energy taken", "yields"), rows[:MOST_CONTACTS], "r" * 10)
    if len(rows) > MOST_CONTACTS:
        print(f"... and {len(rows) - MOST_CONTACTS} more; -o writes them all")
    if n_held > 0:
        print(f"note: {n_held:g} contacts are {FASTER}")


def _outputs(dataset: Any) -> Iterator[tuple[str, str, str]]:
    """Name, value and meaning of each output of the run and of its buildings."""
    from pounding_risk.solver.pair.outputs import BUILDING, RUN

    values = json.loads(dataset.attrs["outputs"])
    for name, output in RUN.items():
        value = values[name]
        # A count of −1: the run failed, or the contact model does not define it.
        count = f"{value:g}" if value >= 0.0 else "–"
        yield name, count if output.whole else engineering(value, output.unit), output.words
    values_of_buildings = json.loads(dataset.attrs["building_outputs"])
    for name, (unit, words, _) in BUILDING.items():
        for building, value in zip(dataset["building"].values, values_of_buildings[name], strict=True):
            yield f"{name}, {building}", engineering(value, unit), words


def _contacts(dataset: Any, has_restitution: bool) -> Iterator[tuple[str, ...]]:
    """Cells of each contact; the coefficient of restitution only for laws that take one."""
    names = ("start", "end", "approach_speed", "restitution_asked", "rebound_speed", "peak_force", "work", "yields")
    columns = [dataset[f"contact_{name}"].values for name in (*names, "peak_penetration")]
    contacts = zip(*columns, strict=True)
    for number, (start, end, speed, e, rebound, force, work, yields, depth) in enumerate(contacts, start=1):
        yield (
            str(number),
            f"{start:.4f} s",
            f"{1e3 * (end - start):.3g} ms",
            engineering(speed, "m/s", 3),
            f"{e:.3f}" if has_restitution else "–",
            engineering(rebound, "m/s", 3),
            engineering(force, "N"),
            engineering(depth, "m", 3),
            engineering(work, "J"),
            f"{yields:g}",
        )


def _print_row(dataset: Any) -> None:
    """Print tables of a row's interfaces, of the contact points that touch, and of its buildings."""
    heads = ("impacts", "first", "peak force", "impulse", "reaches F_E")
    interfaces = zip(dataset["interface"].values, dataset["interface_gap"].values, strict=True)
    lines = [
        (str(name), engineering(float(gap), "m"), *_contact_cells(dataset.isel(interface=number), ""))
        for number, (name, gap) in enumerate(interfaces)
    ]
    print_table(("neighbours", "gap", *heads), lines, "lrrrrrr")
    print()
    points = dataset.isel(contact_point=dataset["contact_point_impact_count"].values > 0)
    lines = [
        (str(name), str(kind), *_contact_cells(points.isel(contact_point=number), "contact_point_"))
        for number, (name, kind) in enumerate(
            zip(points["contact_point"].values, points["contact_point_kind"].values, strict=True)
        )
    ]
    if lines:
        print_table(("contact point", "kind", *heads), lines, "llrrrrr")
        print()
    else:
        print("no contact\n")
    buildings = [
        (
            str(building),
            *(engineering(float(dataset[name].values[number]), unit) for name, unit in OF_BUILDINGS.items()),
        )
        for number, building in enumerate(dataset["building"].values)
    ]
    print_table(("building", *(name.replace("_", " ") for name in OF_BUILDINGS)), buildings, "lrrrr")


def _contact_cells(values: Any, prefix: str) -> tuple[str, ...]:
    """Impacts, first contact, peak force, impulse and yielding of an interface or contact point; – in a failed run."""
    count, yields = (int(values[f"{prefix}{name}"]) for name in ("impact_count", "yield_exceedance"))
    units = (("first_impact_time", "s"), ("peak_contact_force", "N"), ("impulse", "N s"))
    numbers = [engineering(float(values[f"{prefix}{name}"]), unit) for name, unit in units]
    return (str(count) if count >= 0 else "–", *numbers, {0: "no", 1: "yes"}.get(yields, "–"))
