"""The tables of each command, from what its Python call returned."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from pounding_risk.cli._common.files import FIGURES, draw, writable
from pounding_risk.cli._common.notes import FASTER, print_notes, print_unused
from pounding_risk.cli._common.options import NONE, RUN_FAILED, Figure, Overrides, Scene, Strict, read_option
from pounding_risk.cli._common.tables import engineering, print_pairs, print_table
from pounding_risk.errors import PoundingError

if TYPE_CHECKING:
    from pounding_risk.scene.scene import Study

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
    record: Annotated[str | None, typer.Option(help="A record of the scene.", show_default="its first")] = None,
    polarity: Annotated[str | None, typer.Option(help="as recorded, or reversed.", show_default="its first")] = None,
    law: Annotated[str | None, typer.Option(help="Contact model.", show_default="the interface's")] = None,
    gap: Annotated[str | None, typer.Option(help="Clear distance at rest.", show_default="the interface's")] = None,
    yield_force: Annotated[str | None, typer.Option(help="F_E, or inf.", show_default="the interface's")] = None,
    pga: Annotated[str | None, typer.Option(help="Peak ground acceleration.", show_default="the first")] = None,
    out: Annotated[Path | None, typer.Option("--out", "-o", help="Write histories (.nc).", show_default=False)] = None,
    figure: Figure = None,
    animation: Annotated[Path | None, typer.Option(help="A row's run, moving (.html).", show_default=False)] = None,
    strict: Strict = False,
) -> None:
    """Run one case in full: outputs, contacts, histories."""
    dataset_file, figure_file = writable("-o", out, (".nc",)), writable("--figure", figure, FIGURES)
    moving = writable("--animation", animation, (".html",))
    from pounding_risk.ensemble.replacing import OTHER_NAME, check_replaceable
    from pounding_risk.results.files import save
    from pounding_risk.scene.reader import read_scene
    from pounding_risk.studies.simulate import simulate as run
    from pounding_risk.units import GAP, PGA, YIELD_FORCE

    asked = (("gap", gap, GAP), ("yield_force", yield_force, YIELD_FORCE), ("pga", pga, PGA))
    values = {
        name: read_option(f"--{name.replace('_', '-')}", text, quantity)
        for name, text, quantity in asked
        if text is not None
    }
    study = check_moving(read_scene(scene, overrides), moving)
    if dataset_file is not None:
        check_replaceable(dataset_file, "simulate", choice=OTHER_NAME)
    dataset = run(study, record=record, polarity=polarity, law=law, **values)
    print_run(dataset)
    if dataset_file is not None:
        save(dataset, dataset_file)
        typer.echo(f"written: {dataset_file}")
    if figure_file is not None:
        from pounding_risk.figures import simulation_figure

        draw(simulation_figure(dataset), figure_file)
    move(dataset, moving)
    if strict and dataset.attrs["status"] != "complete":
        raise typer.Exit(RUN_FAILED)


def print_run(dataset: Any) -> None:
    """The case, its outputs with what they mean, its contacts, and what is unusual of them."""
    if "interface" in dataset.dims:
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


def check_moving(study: Study, target: Path | None) -> Study:
    """The study; raises PoundingError for a pair that is to be animated."""
    if not study.is_row and target is not None:
        raise PoundingError(
            "--animation: shows a row, and this scene is a pair of single masses; draw its run with --figure run.png"
        )
    return study


def move(dataset: Any, target: Path | None) -> None:
    """Write the animation of a run where a file is named."""
    if target is not None:
        from pounding_risk.reports.animation import animate

        print(f"written: {animate(dataset, target)}")


def print_row_run(dataset: Any) -> None:
    """The case, then tables of interfaces, of the contact points that touch, and of buildings."""
    told = dataset.attrs
    print_pairs(
        [
            ("scene", told["title"]),
            ("record", f"{told['record']}, {told['polarity']}, PGA {engineering(told['pga'], 'm/s2')}"),
            ("contact model", told["contact_model"]),
            ("status", told["status"]),
        ]
    )
    print_unused(dataset)
    heads = ("impacts", "first", "peak force", "impulse", "reaches F_E")
    print()
    gaps = [engineering(float(gap), "m") for gap in dataset["interface_gap"].values]
    rows = [(str(name), gap) for name, gap in zip(dataset["interface"].values, gaps, strict=True)]
    lines = [(*row, *_touch(dataset.isel(interface=at), "")) for at, row in enumerate(rows)]
    print_table(("neighbours", "gap", *heads), lines, "lrrrrrr")
    print()
    _print_points(dataset, heads)
    print_table(
        ("building", *(name.replace("_", " ") for name in OF_BUILDINGS)),
        [
            (
                str(building),
                *(engineering(float(dataset[name].values[at]), unit) for name, unit in OF_BUILDINGS.items()),
            )
            for at, building in enumerate(dataset["building"].values)
        ],
        "lrrrr",
    )


def _print_points(dataset: Any, heads: tuple[str, ...]) -> None:
    touched = [at for at, count in enumerate(dataset["contact_point_impact_count"].values) if count > 0]
    if not touched:
        print("no contact\n")
        return
    points = dataset.isel(contact_point=touched)
    lines = [
        (
            str(name),
            str(points["contact_point_kind"].values[at]),
            *_touch(points.isel(contact_point=at), "contact_point_"),
        )
        for at, name in enumerate(points["contact_point"].values)
    ]
    print_table(("contact point", "kind", *heads), lines, "llrrrrr")
    print()


def _touch(one: Any, prefix: str) -> tuple[str, ...]:
    """Impacts, first touch, peak force, impulse, whether it reaches F_E; – for what a failed run does not have."""
    count, yields = (int(one[f"{prefix}{name}"]) for name in ("impact_count", "yield_exceedance"))
    values = (("first_impact_time", "s"), ("peak_contact_force", "N"), ("impulse", "N s"))
    numbers = [engineering(float(one[f"{prefix}{name}"]), unit) for name, unit in values]
    return (str(count) if count >= 0 else "–", *numbers, {0: "no", 1: "yes"}.get(yields, "–"))
