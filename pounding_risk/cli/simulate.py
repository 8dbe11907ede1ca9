"""The command `simulate`: one run in full."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterable, Iterator
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
from pounding_risk.errors import PoundingError
from pounding_risk.render.terminal import engineering, print_pairs, print_table

ORDER = 40
MOST_CONTACTS = 60  # rows of the table of contacts
OF_BUILDINGS = {
    "peak_displacement": "m",
    "peak_drift": "m",
    "peak_storey_shear": "N",
    "peak_floor_acceleration": "m/s2",
}
# Columns of the table of contacts: the variable, and how its values are written.
OF_CONTACTS: dict[str, tuple[str, Callable[[float], str]]] = {
    "start": ("contact_start", "{:.4f} s".format),
    "lasts": ("contact_duration", lambda value: f"{1e3 * value:.3g} ms"),
    "approach": ("contact_approach_speed", lambda value: engineering(value, "m/s", 3)),
    "e asked": ("contact_restitution_asked", "{:.3f}".format),
    "rebound": ("contact_rebound_speed", lambda value: engineering(value, "m/s", 3)),
    "peak force": ("contact_peak_force", lambda value: engineering(value, "N")),
    "penetration": ("contact_peak_penetration", lambda value: engineering(value, "m", 3)),
    "energy taken": ("contact_work", lambda value: engineering(value, "J")),
    "yields": ("contact_yields", "{:g}".format),
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
    intensity_level: Annotated[str | None, option("Level of records.intensity.", "the first")] = None,
    out: Annotated[Path | None, out_option("Write histories", ".nc")] = None,
    figure: Figure = None,
    absolute: Annotated[bool, typer.Option("--absolute", help="The figure has displacements in space too.")] = False,
    animation: Annotated[Path | None, file_option("The run, moving", (".html",))] = None,
    strict: Strict = False,
) -> None:
    """Run one case in full: outputs, contacts, histories."""
    if absolute and figure is None:
        raise PoundingError("--absolute: adds a panel to the figure; write it with --figure run.png")
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
    if out is not None:
        check_replaceable(out, "simulate", choice=OTHER_NAME)
    dataset = run(study, record=record, polarity=polarity, law=law, intensity_level=intensity_level, **values)
    print_run(dataset)
    if out is not None:
        save(dataset, out)
    announce(out)
    draw(figure, "simulate.simulation_figure", dataset, absolute=absolute)
    if animation is not None:
        from pounding_risk.reports.animation import animate

        announce(animate(dataset, animation))
    if strict and dataset.attrs["status"] != "complete":
        raise typer.Exit(RUN_FAILED)


def _level(facts: Any) -> str:
    """The level of intensity that the record was scaled to, in words; "" without."""
    from pounding_risk.motions.levels import Level, read_measure

    measure = read_measure(facts.get("intensity", ""))
    return "" if measure is None else f", {Level(measure, facts['intensity_level']).words}"


def print_run(dataset: Any) -> None:
    """Print the case, its outputs, its contacts, and notes on what is unusual."""
    facts = dataset.attrs
    is_one = dataset.sizes["interface"] == 1
    levels = (("gap", "m"), ("yield_force", "N")) if is_one else ()  # of several interfaces the tables have them
    print_pairs(
        [
            ("scene", facts["title"]),
            (
                "record",
                f"{facts['record']}, {facts['polarity']}, PGA {engineering(facts['pga'], 'm/s2')}{_level(facts)}",
            ),
            ("contact model", facts["contact_model"]),
            *((name.replace("_", " "), engineering(facts[name], unit)) for name, unit in levels),
            ("status", facts["status"]),
        ]
    )
    print_unused(dataset)
    print()
    if is_one:
        print_table(("output", "value", "meaning"), _outputs(dataset.isel(interface=0)), "lrl")
    else:
        gaps = [engineering(float(gap), "m") for gap in dataset["interface_gap"]]
        _print_places(dataset, "interface", ("neighbours", "gap"), gaps)
    print()
    _print_buildings(dataset)
    print()
    if dataset.sizes["contact"] == 0:
        print("no contact")
    elif dataset.sizes["contact_point"] == 1:
        _print_contacts(dataset)
    else:
        touched = dataset.isel(contact_point=dataset["contact_point_impact_count"].values > 0)
        _print_places(
            touched, "contact_point", ("contact point", "kind"), touched["contact_point_kind"].values, "contact_point_"
        )
    if (n_held := int(dataset["restitution_held"].sum())) > 0:
        print(f"note: {n_held} contacts are {FASTER}")
    print_notes(json.loads(facts.get("notes", "[]")))


def _outputs(run: Any) -> Iterator[tuple[str, str, str]]:
    """Name, value and meaning of each output of one interface, or of the run."""
    for name, variable in run.data_vars.items():
        if variable.ndim == 0:
            value = variable.item()
            # A count of −1: the run failed, or the contact model does not define it.
            count = f"{value:g}" if value >= 0 else "–"
            is_count = variable.dtype.kind == "i"
            yield name, count if is_count else engineering(value, variable.units), variable.long_name


def _print_buildings(dataset: Any) -> None:
    """Print a table of the peaks of each building."""
    peaks = {name: unit for name, unit in OF_BUILDINGS.items() if name in dataset}
    lines = [
        # A rigid building's −0 is 0.
        (str(building), *(engineering(0.0 + float(dataset[name][number]), unit) for name, unit in peaks.items()))
        for number, building in enumerate(dataset["building"].values)
    ]
    print_table(("building", *(name.replace("_", " ") for name in peaks)), lines, "l" + "r" * len(peaks))


def _print_places(dataset: Any, dim: str, heads: tuple[str, str], facts: Iterable[Any], prefix: str = "") -> None:
    """Print a table of the contact at each interface or contact point, with a fact on each."""
    lines = [
        (str(name), str(fact), *_contact_cells(dataset.isel({dim: number}), prefix))
        for number, (name, fact) in enumerate(zip(dataset[dim].values, facts, strict=True))
    ]
    print_table((*heads, "impacts", "first", "peak force", "impulse", "reaches F_E"), lines, "llrrrrr")


def _print_contacts(dataset: Any) -> None:
    """Print a table of every contact, with what the solver tells of each."""
    from pounding_risk.models.contact.impulsive import CONTACT_MODELS

    contacts = dataset.assign(contact_duration=dataset["contact_end"] - dataset["contact_start"])
    law = CONTACT_MODELS.get(str(dataset.attrs["contact_model"]))  # none where the interfaces differ in theirs
    if law is not None and not getattr(law, "needs_restitution", True):
        contacts = contacts.drop_vars("contact_restitution_asked", errors="ignore")
    shown = contacts.isel(contact=slice(MOST_CONTACTS))
    columns = [
        [written(value) for value in shown[name].values] if name in shown else ["–"] * shown.sizes["contact"]
        for name, written in OF_CONTACTS.values()
    ]
    rows = [(str(number), *cells) for number, cells in enumerate(zip(*columns, strict=True), start=1)]
    print_table(("contact", *OF_CONTACTS), rows, "r" * (1 + len(columns)))
    if dataset.sizes["contact"] > MOST_CONTACTS:
        print(f"... and {dataset.sizes['contact'] - MOST_CONTACTS} more; -o writes them all")


def _contact_cells(values: Any, prefix: str) -> tuple[str, ...]:
    """Impacts, first contact, peak force, impulse and yielding of an interface or contact point; – in a failed run."""
    count, yields = (int(values[f"{prefix}{name}"]) for name in ("impact_count", "yield_exceedance"))
    units = (("first_impact_time", "s"), ("peak_contact_force", "N"), ("impulse", "N s"))
    numbers = [engineering(float(values[f"{prefix}{name}"]), unit) for name, unit in units]
    return (str(count) if count >= 0 else "–", *numbers, {0: "no", 1: "yes"}.get(yields, "–"))
