"""Time of scans of rows: ``python benchmarks/row_scan.py``.

A made street of 30 buildings, 2 to 6 storeys each, gaps of 10 to 80 mm, under the 44 components of the FEMA P-695
far-field set as recorded, through the public `scan` on two threads; without the set, which the extra ``ensembles``
carries, under the shipped records, repeated at several amplitudes to the same number of motions, and it says so. Then
single runs under the full El Centro record at 0.4 g, every building solved at once: pairs with few contacts or none,
rows with a link, a matrix building and an isolated one beside the row without, equal neighbours in turn against their
number, and a pair against its storeys. Medians of repeats that take turns; kernels are compiled before.
"""

from __future__ import annotations

import argparse
import time
from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import partial
from math import inf
from statistics import median
from typing import Any

import numpy as np

from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.figures.style import STYLES, blank, title
from pounding_risk.models.contact.laws import ViscousElastoplastic
from pounding_risk.models.restitution import constant
from pounding_risk.models.structures.contact_points import Point, automatic_points
from pounding_risk.models.structures.hysteresis import Hysteresis
from pounding_risk.models.structures.isolation import Isolators
from pounding_risk.models.structures.links import Link
from pounding_risk.models.structures.mdof import chain_of
from pounding_risk.models.structures.plan import Plan
from pounding_risk.models.structures.storeys import Storeys
from pounding_risk.motions.motion import Motion
from pounding_risk.motions.read import read_motion
from pounding_risk.motions.record_sets import members
from pounding_risk.results.attributes import read_attribute
from pounding_risk.results.summary import counted
from pounding_risk.scene.scene import scene_of
from pounding_risk.solver.counters import COUNT
from pounding_risk.solver.row import api as rows
from pounding_risk.solver.row.api import HIGHEST, Contacts
from pounding_risk.solver.row.layout import RowLayout
from pounding_risk.solver.row.model import RowModel

SET, COMPONENTS = "fema-p695-farfield", 44
SHIPPED = ("RSN6-180", "RSN1690-090")
THREADS, SEED = 2, 20111
LAW, RESTITUTION = ViscousElastoplastic(2.75e9), constant(0.65)
NUMBERS, STOREYS = (2, 4, 8, 16, 32), (1, 2, 4, 8, 16)
FLIGHTS = ((1, 1), (4, 4), (10, 8))
Sizes = list[tuple[int, float, float]]
GAP = 0.01  # m, of the rows that are timed alone
PLAN = Plan((-8.0, 8.0), 0.0, 1.5, 6.0, 1.1)


def street(count: int) -> list[dict[str, Any]]:
    """Made buildings: frames and stiffer walls of 2 to 6 storeys, periods of about 0.2 to 0.9 s; the same each day."""
    chance = np.random.default_rng(SEED)
    buildings = []
    for place in range(count):
        storeys = int(chance.integers(2, 7))
        buildings.append(
            {
                "name": f"{place + 1}",
                "storeys": storeys,
                "floor_masses": f"{chance.uniform(120.0, 300.0):.1f} t",
                "storey_stiffnesses": f"{chance.uniform(100.0, 500.0):.1f} MN/m",
                "storey_heights": f"{chance.choice([2.8, 3.2, 3.6])} m",
            }
        )
    return buildings


def records() -> tuple[dict[str, Any], str]:
    """The motions as a scene asks for them, and in words."""
    try:
        whole = len(members(SET)) == COMPONENTS
    except PoundingError:
        whole = False
    if whole:
        return {"set": SET}, f"the {COMPONENTS} components of {SET}, as recorded"
    pgas = [f"{0.1 + 0.02 * step:.2f} g" for step in range(COMPONENTS // len(SHIPPED))]
    return {"names": list(SHIPPED), "pga": pgas}, f"{' and '.join(SHIPPED)} repeated at {len(pgas)} amplitudes"


def block(count: int, asked: dict[str, Any]) -> Any:
    """Scene of one row of a street."""
    chance = np.random.default_rng(SEED + 1)
    common = {"contact_model": "viscous_elastoplastic", "stiffness": "2.75e9 N/m^1.5", "restitution": 0.65}
    # Floors within 50 mm of a level are one: what was timed keeps its 166 contact points.
    strength = {"yield_force": "2 MN", "column_yield_force": "600 kN", "tolerance": "50 mm"}
    gaps = [{"gap": f"{chance.uniform(10.0, 80.0):.0f} mm"} | common | strength for _ in range(count - 1)]
    motions = {key: value for key, value in asked.items() if key != "pga"}
    grid = {"grid": {"pga": asked["pga"]}} if "pga" in asked else {}
    return scene_of({"building": street(count), "interface": gaps, "records": motions, **grid})


def time_block(count: int) -> None:
    """The street under all motions, and what was solved."""
    asked, words = records()
    scan(block(3, {"names": ["RSN6-180"]}), check_fraction=0.0)  # compiles
    begin, spent = time.perf_counter(), time.process_time()
    dataset = scan(block(count, asked), check_fraction=0.0, workers=THREADS)
    wall, cpu = time.perf_counter() - begin, time.process_time() - spent
    counts = counted(dataset)
    failed = int((dataset["status"].values != 0).sum())
    parts = read_attribute(dataset, "parts", {})
    print(f"{count} buildings, {dataset.sizes['contact_point']} contact points, under {words}:")
    print(f"  {counts['cases']} cases, {counts['simulated']} with a run of their own, {failed} failed")
    print(f"  {int(dataset['impact_count'].sum())} contacts; parts: {parts}")
    print(f"  {wall:.1f} s on {THREADS} threads, {cpu:.1f} s of processor time\n")


def frames(*storeys: int) -> list[Storeys]:
    """Neighbours of two kinds in turn, of so many storeys each, floors at equal levels."""
    kinds = ((200e3, 1.5e8), (180e3, 4e8))
    return [
        Storeys(f"{place}", (kinds[place % 2][0],) * count, (kinds[place % 2][1],) * count, (3.0,) * count)
        for place, count in enumerate(storeys)
    ]


def model_of(buildings: list[Storeys], links: Sequence[Link] = ()) -> RowModel:
    """Neighbours that meet wherever their floors do."""
    points = [
        Point(place, *meeting)
        for place in range(len(buildings) - 1)
        for meeting in automatic_points(buildings[place], buildings[place + 1])
    ]
    if any(building.plans for building in buildings):  # contact at both ends of the faces
        effects: list[tuple[str, list[Any]]] = []
        points = [point._replace(across=across) for point in points for across in PLAN.face]
    else:
        effects = [("inelastic_storeys", [])]  # which no building without strengths feels
    return RowModel([chain_of(building, effects) for building in buildings], points, links=links)


def laid_out(buildings: list[Storeys], dt: float) -> RowLayout:
    """The same for the kernels."""
    return model_of(buildings).row(dt)


def contacts_of(laid: RowLayout, gap: float) -> Contacts:
    """Equal contacts at all points that never yield."""
    count = len(laid.row.ends)
    return Contacts(np.full(count, gap), np.full(count, inf), [LAW] * count, [RESTITUTION] * count)


def time_flight(motion: Motion, repeats: int) -> None:
    """A table: processor time of the motion without contact, and of runs with the gap as a share of what it needs."""
    shares = (1.01, 0.8, 0.4)
    heads = [f"gap {share:g} of what it needs | contacts" for share in shares]
    print(f"| storeys | motion without contact, once a record | {' | '.join(heads)} |")
    print(f"| --- | ---: |{' ---: | ---: |' * len(shares)}")
    for storeys in FLIGHTS:
        laid = laid_out(frames(*storeys), motion.dt)
        response = rows.free_response(laid, motion.acceleration)
        need, ground = response.run.points[:, HIGHEST].max(), motion.acceleration
        cells = [f"{1e3 * processor_time(partial(rows.free_response, laid, ground), repeats):.1f} ms"]
        for share in shares:
            solve = partial(rows.run_row, laid, contacts_of(laid, share * need), ground, free=response.motion)
            contacts = solve().points[:, COUNT].sum()
            cells += [f"{1e3 * processor_time(solve, repeats):.2f} ms", f"{contacts:.0f}"]
        print(f"| {' + '.join(map(str, storeys))} | {' | '.join(cells)} |")
    print()


def processor_time(call: Callable[[], Any], repeats: int) -> float:
    """Median of the processor time of so many calls [s]."""
    spent = []
    for _ in range(repeats):
        begin = time.process_time()
        call()
        spent.append(time.process_time() - begin)
    return median(spent)


def one_run(buildings: list[Storeys], motion: Motion) -> Callable[[], tuple[float, float]]:
    """A run of all buildings at once, timed: (seconds, contacts)."""
    laid = laid_out(buildings, motion.dt)
    free, contacts = rows.free_response(laid, motion.acceleration).motion, contacts_of(laid, GAP)

    def timed() -> tuple[float, float]:
        begin = time.perf_counter()
        run = rows.run_row(laid, contacts, motion.acceleration, free=free)
        spent = time.perf_counter() - begin
        if run.status:
            raise PoundingError(f"a run of {len(buildings)} buildings ended with status {run.status}")
        return spent, float(run.points[:, COUNT].sum())

    return timed


def time_sizes(what: str, runs: dict[int, Callable[[], tuple[float, float]]], repeats: int) -> Sizes:
    """A table: time of a run, its contacts, and how both grow; returns (size, median time, contacts) of each."""
    found: dict[int, list[tuple[float, float]]] = {size: [] for size in runs}
    for turn in range(repeats + 1):
        for size, run in runs.items():
            measured = run()
            if turn:
                found[size].append(measured)
    print(f"| {what} | median | fastest to slowest | contacts | each contact | times the row above | contacts do |")
    print("| ---: | ---: | --- | ---: | ---: | ---: | ---: |")
    before: tuple[float, float] | None = None
    for size, measured in found.items():
        times, contacts = [seconds for seconds, _ in measured], measured[0][1]
        now = median(times), contacts
        ratio = f"{now[0] / before[0]:.1f} | {contacts / before[1]:.1f}" if before and before[1] else "|"
        each = f"{1e6 * now[0] / contacts:.0f} µs" if contacts else ""
        spread = f"{1e3 * min(times):.1f} to {1e3 * max(times):.1f} ms"
        print(f"| {size} | {1e3 * now[0]:.1f} ms | {spread} | {contacts:.0f} | {each} | {ratio} |")
        before = now
    print()
    return [(size, median(seconds for seconds, _ in measured), measured[0][1]) for size, measured in found.items()]


def element_rows() -> dict[str, RowModel]:
    """Three buildings of 4 storeys, and the same with a link, another kind of first building, or storeys that yield."""
    first, *others = frames(4, 4, 4)
    above = np.cumsum(first.masses[::-1])[::-1]
    yields = replace(first, strengths=tuple(0.12 * 9.80665 * mass for mass in above))  # 12 % of the weight above
    pinched = Hysteresis("peak_oriented", ((4.0, 1.1), (12.0, 0.3)), pinching_drift=0.5, pinching_force=0.3)
    matrix = tuple(map(tuple, first.matrices()[2].tolist()))
    by_matrix = replace(first, stiffnesses=(), stiffness_matrix=matrix)
    beside = np.eye(len(first.masses), k=1) + np.eye(len(first.masses), k=-1)
    shared = np.diag(first.masses) + 0.1 * first.masses[0] * (beside - np.diag(beside.sum(axis=1)))
    slab = Isolators(200e3, 3.0, strength=4e5, stiffness=4e6, yield_displacement=0.01)  # 5 % of the weight; 3 s
    kinds: dict[str, tuple[Storeys, list[Link]]] = {
        "storeys alone": (first, []),
        "a spring and a dashpot between two roofs": (first, [Link(0, 4.0, 4.0, 2e7, 1e6)]),
        "the first by its matrix": (by_matrix, []),
        "and by a mass matrix": (replace(by_matrix, mass_matrix=tuple(map(tuple, shared.tolist()))), []),
        "the first isolated": (first.isolated(slab), []),
        "a friction damper between two roofs": (first, [Link(0, 4.0, 4.0, 2e7, 0.0, strength=2e5)]),
        "a hook between two roofs": (first, [Link(0, 4.0, 4.0, 2e7, 0.0, slack=0.01)]),
        "a damper of the power 0.3 between two roofs": (first, [Link(0, 4.0, 4.0, 0.0, 5e5, exponent=0.3)]),
        "the same on a brace": (first, [Link(0, 4.0, 4.0, 0.0, 5e5, exponent=0.3, brace=5e7)]),
        "a link that breaks between two roofs": (first, [Link(0, 4.0, 4.0, 2e7, 0.0, breaking=3e5)]),
        "floors of the first that rotate": (replace(first, plans=(PLAN,) * len(first.masses)), []),
        "and move across, under two components": (
            replace(first, plans=(PLAN._replace(eccentricity_along=1.0),) * len(first.masses)),
            [],
        ),
        "the first of bilinear storeys": (yields, []),
        "the first of pinched storeys": (replace(yields, hysteresis=pinched), []),
        "the first of Bouc-Wen storeys": (replace(yields, hysteresis=Hysteresis("bouc_wen")), []),
    }
    return {words: model_of([one, *others], links) for words, (one, links) in kinds.items()}


def time_elements(motion: Motion, repeats: int) -> None:
    """A table: processor time of a row with an element over that of the row without, of runs in turns."""
    calls = {}
    for words, model in element_rows().items():
        laid = model.row(motion.dt)
        contacts = contacts_of(laid, GAP)._replace(gaps=model.gaps(np.full(len(model.chains) - 1, GAP)))
        under = model.under(motion.drive)
        free = partial(rows.free_response, laid, under)
        run = partial(rows.run_row, laid, contacts, under, free=free().motion)
        found = run()
        if found.status:
            raise PoundingError(f"the row with {words} ended with status {found.status}")
        calls[words] = free, run, found.points[~model.is_link, COUNT].sum()
    spent: dict[str, list[tuple[float, float]]] = {words: [] for words in calls}
    for _ in range(repeats):
        for words, (free, run, _) in calls.items():
            spent[words].append((processor_time(free, 1), processor_time(run, 1)))
    print(
        "| three buildings of 4 storeys | motion without contact | ratio | a run | ratio | contacts | ratio of each |"
    )
    print("| --- | ---: | ---: | ---: | ---: | ---: | ---: |")
    before: tuple[float, float, float] | None = None
    for words, times in spent.items():
        now = *(median(column) for column in zip(*times, strict=True)), calls[words][2]
        before = before or now
        ratios = now[0] / before[0], now[1] / before[1], now[1] / now[2] / (before[1] / before[2])
        print(
            f"| {words} | {1e3 * now[0]:.1f} ms | {ratios[0]:.2f} | {1e3 * now[1]:.1f} ms | {ratios[1]:.2f} | "
            f"{now[2]:.0f} | {ratios[2]:.2f} |"
        )
    print()


def draw(sizes: dict[str, Sizes], path: str) -> None:
    """Time of a run against contacts and against sizes, on logarithmic axes; a line of slope 1 beside the first."""
    figure, axes = blank(1, 1 + len(sizes), (13.0, 4.2))
    for (what, found), (colour, dash), axis in zip(sizes.items(), STYLES, axes[0, 1:], strict=False):
        count, seconds, contacts = (np.array(column, dtype=float) for column in zip(*found, strict=True))
        axes[0, 0].loglog(contacts, seconds, color=colour, linestyle=dash, marker="o", label=what)
        axis.loglog(count, seconds, color=colour, linestyle=dash, marker="o")
        axis.set(xlabel=what, ylabel="time of a run [s]")
        axis.set_xticks(count, [f"{each:.0f}" for each in count])
        axis.set_xticks([], minor=True)
        if axis is axes[0, 1]:
            axes[0, 0].loglog(
                contacts, seconds[-1] * contacts / contacts[-1], color="black", linewidth=0.8, label="slope 1"
            )
    axes[0, 0].set(xlabel="contacts", ylabel="time of a run [s]")
    axes[0, 0].legend(fontsize=9)
    (_, first, fewest), *_, (_, last, most) = sizes["buildings of 4 storeys"]
    growth = np.log(last / first) / np.log(most / fewest)
    title(
        figure,
        f"Time grows with the number of contacts to the power {growth:.2f} as buildings are added",
        f"RSN6-180 at 0.4 g, gaps of {1e3 * GAP:g} mm, every building solved at once; medians",
    )
    figure.savefig(path)


def main(arguments: list[str] | None = None) -> int:
    """Time the street and rows of growing size."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--buildings", type=int, default=30, help="of the street; 0 leaves it out")
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--largest", type=int, default=32, help="buildings, and storeys, of a row timed alone")
    parser.add_argument("--figure", help="draw time against contacts, buildings and storeys to this file")
    options = parser.parse_args(arguments)
    motion = read_motion("RSN6-180")
    other = np.zeros(motion.acceleration.size)
    samples = read_motion("RSN6-270").acceleration[: other.size]
    other[: samples.size] = samples
    motion = replace(motion, across=other).scaled_to("0.4 g")
    if options.buildings:
        time_block(options.buildings)
    time_flight(motion, options.repeats)
    time_elements(motion, options.repeats)
    numbers = {count: one_run(frames(*[4] * count), motion) for count in NUMBERS if count <= options.largest}
    sizes = {"buildings of 4 storeys": time_sizes("buildings of 4 storeys", numbers, options.repeats)}
    storeys = {count: one_run(frames(count, count), motion) for count in STOREYS if count <= options.largest}
    sizes["storeys of a pair"] = time_sizes("storeys of a pair", storeys, options.repeats)
    if options.figure:
        draw(sizes, options.figure)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
