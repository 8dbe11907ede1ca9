"""Sheet of `simulate`: the case, its outputs, its contacts, and notes on what is unusual."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from math import isfinite
from typing import Any

import xarray as xr

from pounding_risk.errors import PoundingError
from pounding_risk.models.contact.impulsive import CONTACT_MODELS
from pounding_risk.motions.levels import Level, read_measure
from pounding_risk.motions.record import AFTERSHOCK
from pounding_risk.questions._declaration import File, Option
from pounding_risk.questions.notes import FASTER, OF_LINKS, of_keys, of_records
from pounding_risk.render.sheet import (
    MISSING,
    Block,
    Cell,
    Row,
    amount,
    count,
    facts,
    head,
    listing,
    milliseconds,
    number,
    paragraph,
    table,
    worded,
)
from pounding_risk.results.attributes import collapses, isolated_of, of_isolators, of_storeys, of_structure
from pounding_risk.units import SHOWN

ORDER = 40
FUNCTION = "studies.simulate"
FIGURES = {"": "simulate.simulation_figure"}
FILES = {"animation": File((".html",), "The run, moving", "reports.animation.animate")}
OPTIONS = {"absolute": Option(kind=bool, help="The figure has displacements in space too.")}
UNKNOWN = "Outputs are not known, as the run ended before the record; -o run.nc writes its histories up to there."
MOST_CONTACTS = 60  # rows of the table of contacts on a terminal
# Columns of the table of buildings: variable, head, unit, and of what it is; of the latter those with a value.
OF_BUILDINGS = (
    ("peak_displacement", "peak displacement", "m", of_structure),
    ("peak_drift", "peak drift", "m", of_structure),
    ("peak_storey_shear", "peak storey shear", "N", of_structure),
    ("peak_floor_acceleration", "peak floor acceleration", "m/s2", of_structure),
)
OF_YIELDING = (
    ("storey_drift", "displacement of isolators", "m", of_isolators),
    ("storey_ductility", "storey ductility", "1", of_storeys),
    ("storey_residual_drift", "residual drift", "m", of_storeys),
)
# Columns of the table of contacts: head, variable, and its cell.
OF_CONTACTS: tuple[tuple[str, str, Callable[[float], Cell]], ...] = (
    ("start [s]", "contact_start", lambda value: worded(value, f"{value:.4f}")),
    ("lasts [ms]", "contact_duration", milliseconds),
    ("approach [m/s]", "contact_approach_speed", lambda value: number(value, "m/s", 3)),
    ("e requested", "contact_restitution_asked", lambda value: worded(value, f"{value:.3f}")),
    ("rebound [m/s]", "contact_rebound_speed", lambda value: number(value, "m/s", 3)),
    ("peak force [kN]", "contact_peak_force", lambda value: number(value, "N")),
    ("penetration [mm]", "contact_peak_penetration", lambda value: number(value, "m", 3)),
    ("energy taken [J]", "contact_work", lambda value: worded(value, f"{value:.4g}")),
    ("yields", "contact_yields", lambda value: worded(value, f"{value:g}")),
)
OF_PLACES = (
    ("first [s]", "first_impact_time", "s"),
    ("peak force [kN]", "peak_contact_force", "N"),
    ("impulse [kN s]", "impulse", "N s"),
)


def sheet(run: xr.Dataset) -> list[Block]:
    """The case, its outputs, its buildings, its contacts, and notes.

    Of several interfaces a table of them takes the place of the outputs.
    """
    attrs = run.attrs
    is_one = run.sizes["interface"] == 1
    levels = (("gap", "m"), ("yield_force", "N")) if is_one else ()  # of several interfaces the table has them
    record = f"{attrs['record']}, {attrs['polarity']}, PGA {amount(attrs['pga'], 'm/s2')['text']}"
    measure = read_measure(attrs.get("intensity", ""))
    if measure is not None:  # the level of intensity that the record was scaled to
        record += f", {Level(measure, attrs['intensity_level']).words}"
    record += f", followed by {attrs[AFTERSHOCK]}" if AFTERSHOCK in attrs else ""
    pairs: list[tuple[str, Cell | str]] = [
        ("scene", attrs["title"]),
        ("record", record),
        ("contact model", attrs["contact_model"]),
        *((name.replace("_", " "), _amount(attrs[name], unit)) for name, unit in levels),
        *_strengths_of_columns(run),
        ("status", attrs["status"]),
        *([("collapsed", words)] if (words := collapses(run)) else []),
    ]
    held_count = int(run["restitution_held"].clip(min=0).sum())  # below zero where the run failed
    notes = [*([f"{held_count} contacts are {FASTER}"] if held_count else []), *json.loads(attrs.get("notes", "[]"))]
    notes += of_records(json.loads(attrs.get("flags", "{}")))
    if isolated := isolated_of(run):
        notes.append(f"{' and '.join(isolated)}: peak drift is that above the isolators, which are storey 1")
    outputs = [
        _outputs(run.isel(interface=0)) if is_one else _places(run, "interface"),
        *([_links(run)] if "peak_link_stretch" in run and not is_one else []),
        _buildings(run),
    ]
    blocks = [
        facts("", pairs),
        listing(of_keys(attrs)),
        *([paragraph(UNKNOWN)] if failed(run) else outputs),
        _contacts(run),
        listing(notes),
    ]
    return [block for block in blocks if block["kind"] != "list" or block["items"]]


def check(options: Mapping[str, Any]) -> None:
    """Raise PoundingError for a panel without a figure."""
    if options.get("absolute") and "figure" not in options:
        raise PoundingError("absolute: adds a panel to the figure; write it with --figure run.png")


def failed(run: xr.Dataset) -> bool:
    """Whether the run failed, by which `--strict` ends the command."""
    return bool(run.attrs["status"] != "complete")


def _strengths_of_columns(run: xr.Dataset) -> list[tuple[str, str]]:
    """The row of the yield forces of columns that floors meet; none where they meet none."""
    forces = run["contact_point_yield_force"].values[run["contact_point_kind"].values == "column"]
    words = dict.fromkeys(str(_amount(float(force), "N")["text"]) for force in sorted(forces))
    return [("of columns", ", ".join(words))] if words else []


def _outputs(run: xr.Dataset) -> Block:
    """Value and meaning of each output of the only interface, or of the run."""
    rows: list[Row] = []
    for name, variable in run.data_vars.items():
        if variable.ndim == 0:
            output = variable.item()
            # A count of -1: the run failed, or the contact model does not define it.
            counted = count(output) if output >= 0 else MISSING
            cell = counted if variable.dtype.kind == "i" else _amount(output, variable.units)
            rows.append([str(name), cell, variable.long_name])
    return table("Outputs.", ("output", "value", "meaning"), rows, keep=range(len(rows)))


def _links(run: xr.Dataset) -> Block:
    """Peaks of the links between each two neighbours that links join."""
    outputs = {name: labels for name, labels in OF_LINKS.items() if name in run}
    rows: list[Row] = [
        [str(name), *(number(float(run[output][place]), unit) for output, (_, unit) in outputs.items())]
        for place, name in enumerate(run["interface"].values)
        if isfinite(run["peak_link_stretch"][place])
    ]
    return table("Links between neighbours.", ["neighbours", *(head(*words) for words in outputs.values())], rows)


def _buildings(run: xr.Dataset) -> Block:
    outputs = [(words, unit, of(run, name)) for name, words, unit, of in OF_BUILDINGS if name in run]
    yielding = [(words, unit, of(run, name)) for name, words, unit, of in OF_YIELDING if name in run]
    outputs += [column for column in yielding if column[2].notnull().any()]
    heads = ["building", *(head(words, unit) for words, unit, _ in outputs)]
    rows = [
        # A rigid building's -0 is 0.
        [str(building), *(number(0.0 + float(peaks[place]), unit) for _, unit, peaks in outputs)]
        for place, building in enumerate(run["building"].values)
    ]
    return table("Peaks of the buildings.", heads, rows)


def _contacts(run: xr.Dataset) -> Block:
    """Every contact of a single contact point; of several points a line for each that was touched."""
    if run.sizes["contact"] == 0:
        return paragraph("contacts are not known: the run failed, see its status" if failed(run) else "no contact")
    if run.sizes["contact_point"] > 1:
        touched = run.isel(contact_point=run["contact_point_impact_count"].values > 0)
        return _places(touched, "contact_point", "contact_point_")
    contacts = run.assign(contact_duration=run["contact_end"] - run["contact_start"])
    law = CONTACT_MODELS.get(str(run.attrs["contact_model"]))  # none where the interfaces differ in theirs
    if law is not None and not getattr(law, "needs_restitution", True):
        contacts = contacts.drop_vars("contact_restitution_asked", errors="ignore")
    heads = ["contact", *(words for words, _, _ in OF_CONTACTS)]
    rows: list[Row] = []
    for place in range(run.sizes["contact"]):
        cells = (cell(float(contacts[name][place])) if name in contacts else MISSING for _, name, cell in OF_CONTACTS)
        rows.append([count(place + 1), *cells])
    first_rows = range(min(len(rows), MOST_CONTACTS))
    return table("Contacts.", heads, rows, keep=first_rows, note="the first; -o writes them all")


def _places(run: xr.Dataset, dim: str, prefix: str = "") -> Block:
    """The contact at each interface with its gap, or at each contact point with its kind."""
    is_interface = dim == "interface"
    heads = ["neighbours", head("gap", "m")] if is_interface else ["contact point", "kind"]
    heads += ["impacts", *(words for words, _, _ in OF_PLACES), "reaches F_E"]
    rows: list[Row] = []
    for place, name in enumerate(run[dim].values):
        part = run.isel({dim: place})
        impacts, yields = (int(part[f"{prefix}{output}"]) for output in ("impact_count", "yield_exceedance"))
        detail = number(part["interface_gap"], "m") if is_interface else str(part["contact_point_kind"].item())
        cells = [number(part[f"{prefix}{output}"], unit) for _, output, unit in OF_PLACES]
        reaches = {0: "no", 1: "yes"}.get(yields, MISSING)
        rows.append([str(name), detail, count(impacts) if impacts >= 0 else MISSING, *cells, reaches])
    return table("Contact at each interface." if is_interface else "Contact points that touched.", heads, rows)


def _amount(output: float, unit: str) -> Cell:
    """A value with its unit; inf where nothing yields."""
    return amount(output, unit) if unit in SHOWN else worded(output, f"{output:.4g} {unit}")
