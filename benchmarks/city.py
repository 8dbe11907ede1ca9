"""A made city from its table to its drawings: ``python benchmarks/city.py``.

1,000 made buildings of 2 to 8 storeys stand in rows of 4 to 16 along parallel streets, as footprints in a GeoJSON file.
The stages are those of a user: the table is made (generated); `block` groups it into rows and writes their scenes
(grouped); `validate` checks each scene and its records (planned); `scan` runs each row under the 44 components of the
FEMA P-695 far-field set as recorded (run); `assess` judges every gap (assessed); the city is drawn in plan to scale,
and one row in elevation (drawn). Each stage is a process of its own, so that its peak memory is known. The kernels are
compiled before. ``--buildings 50 --records 4``, with records of the catalogue, is a share that takes a minute.

The table says for each stage how long a row of the second half took beside one of the first, the very first left out:
1 where the cost of a row does not grow with the number of rows before it. What 10,000 buildings take follows from it.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
from collections.abc import Callable, Iterable
from math import cos, radians
from pathlib import Path
from statistics import mean
from tempfile import TemporaryDirectory
from time import perf_counter, process_time
from typing import Any, NamedTuple

import numpy as np
from shortened import IS_SHORT, either

SET, COMPONENTS = "fema-p695-farfield", 44
SEED, THREADS = 20110314, 2
TABLE, SCENES, RESULTS, PLAN, ELEVATION = "city.geojson", "scenes", "results", "plan.png", "elevation.png"
STAGES = ("generated", "grouped", "planned", "run", "assessed", "drawn")
A_STREET = 40  # buildings
ORIGIN, METRES_A_DEGREE = (174.6, -41.25), 111.2e3  # in Cook Strait, in the sea: no such city exists
KINDS = ("masonry", "concrete_frame", "concrete_walls", "steel_frame")
LARGER = 10_000  # buildings that the last column is of


class Cost(NamedTuple):
    """What a stage took."""

    wall: float  # s
    cpu: float  # s
    memory: float  # MB, the largest resident of its process
    growth: float  # time of a row of the second half over that of one of the first; NaN of a stage without rows
    once: float  # s of processor time that does not grow with the city: imports, the first row
    words: str


def make_table(folder: Path, count: int) -> str:
    """Write footprints of so many buildings."""
    chance = np.random.default_rng(SEED)
    features = []
    for street in range(-(-count // A_STREET)):
        along, in_row, length = 0.0, 0, int(chance.integers(4, 17))
        for place in range(min(A_STREET, count - street * A_STREET)):
            width, depth = chance.uniform(10.0, 20.0), chance.uniform(12.0, 20.0)
            features.append(_feature(street, place, (along, width, depth), chance))
            in_row += 1
            is_last = in_row == length
            along += width + (8.0 if is_last else chance.uniform(0.005, 0.08))
            if is_last:
                in_row, length = 0, int(chance.integers(4, 17))
    text = json.dumps({"type": "FeatureCollection", "features": features})
    (folder / TABLE).write_text(text, encoding="utf-8")
    return f"{len(features)} buildings"


def _feature(street: int, place: int, box: tuple[float, float, float], chance: np.random.Generator) -> dict[str, Any]:
    """One building: its place along the street and across, and what a survey knows of it."""
    (left, width, depth), across = box, 60.0 * street
    storeys = int(chance.integers(2, 9))
    storey_height = float(chance.choice([2.8, 3.0, 3.3, 3.6]))
    corners = [(left, across), (left + width, across), (left + width, across + depth), (left, across + depth)]
    east = METRES_A_DEGREE * cos(radians(ORIGIN[1]))
    ring = [[ORIGIN[0] + x / east, ORIGIN[1] + y / METRES_A_DEGREE] for x, y in [*corners, corners[0]]]
    properties = {
        "name": f"{street + 1}-{place + 1}",
        "street": f"street {street + 1}",
        "storeys": storeys,
        "height [m]": round(storeys * storey_height, 2),
        "typology": str(chance.choice(KINDS)),
        "floor mass [t]": round(chance.uniform(0.8, 1.2) * width * depth, 1),
    }
    return {"type": "Feature", "properties": properties, "geometry": {"type": "Polygon", "coordinates": [ring]}}


def group(folder: Path, records: int) -> str:
    """Rows of the table, and their scenes."""
    from pounding_risk.streets.rows import read_block, write_block
    from pounding_risk.streets.scenes import Contact

    street = read_block(folder / TABLE)
    contact = Contact("viscous_elastoplastic", yield_force="2 MN", column_yield_force="600 kN")
    wanted, tables = asked(records)
    write_block(street, folder / SCENES, records=wanted, contact=contact, tables=tables)
    return f"{len(street.rows)} rows, {len(street.in_no_row)} buildings in none"


def asked(records: int) -> tuple[list[str] | None, dict[str, Any]]:
    """The records of the scenes, and what else stands in their [records], in one polarity."""
    from pounding_risk.motions.catalogue import entries

    once = {"polarity": ["as recorded"]}
    if records == COMPONENTS:
        return None, {"records": {"set": SET, **once}}
    return [entry.id for entry in entries() if entry.horizontal][:records], {"records": once}


def each_row(folder: Path, work: Callable[[Path], int], what: str) -> tuple[str, list[float]]:
    """Work on every scene; the sum of what it returns in words, and the processor time of each [s]."""
    total, times = 0, []
    for scene in sorted((folder / SCENES).glob("*.toml")):
        begin = process_time()
        total += work(scene)
        times.append(process_time() - begin)
    return f"{total} {what}", times


def plan_row(scene: Path) -> int:
    """Cases of one row, its records read."""
    from pounding_risk.ensemble.plan.plan import validate

    return validate(scene).cases


def run_row(scene: Path) -> int:
    """Contacts of one row's scan."""
    from pounding_risk.ensemble.scan import scan

    dataset = scan(scene, result_of(scene), new=True, check_fraction=0.0, workers=THREADS)
    failed = int((dataset["status"].values != 0).sum())
    if failed:
        print(f"{scene.name}: {failed} runs failed", file=sys.stderr)
    contacts = int(dataset["impact_count"].values.clip(0).sum())
    dataset.close()
    return contacts


def assess_row(scene: Path) -> int:
    """Adequate gaps of one row."""
    from pounding_risk.assessment.assess import assess
    from pounding_risk.assessment.verdict import ADEQUATE

    return sum(interface.verdict.word == ADEQUATE for interface in assess(result_of(scene)).interfaces)


def result_of(scene: Path) -> Path:
    """The dataset of a scene."""
    return scene.parent.parent / RESULTS / f"{scene.stem}.nc"


def draw_city(folder: Path) -> str:
    """The plan of all rows, and the first row in elevation."""
    from pounding_risk.reports.drawings import draw

    results = [result_of(scene) for scene in sorted((folder / SCENES).glob("*.toml"))]
    draw(results, plan=folder / PLAN, street=folder / TABLE)
    draw(results[0], elevation=folder / ELEVATION)
    return f"{PLAN}, {ELEVATION}"


def stage(name: str, folder: Path, buildings: int, records: int) -> Cost:
    """Do one stage in this process."""
    works: dict[str, Callable[[], str | tuple[str, list[float]]]] = {
        "generated": lambda: make_table(folder, buildings),
        "grouped": lambda: group(folder, records),
        "planned": lambda: each_row(folder, plan_row, "cases"),
        "run": lambda: each_row(folder, run_row, "contacts"),
        "assessed": lambda: each_row(folder, assess_row, "gaps adequate"),
        "drawn": lambda: draw_city(folder),
    }
    (folder / RESULTS).mkdir(exist_ok=True)
    begin = perf_counter()
    done = works[name]()
    words, times = done if isinstance(done, tuple) else (done, [])
    memory = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024.0
    cpu, rest = process_time(), times[1:]
    middle = len(rest) // 2
    growth = mean(rest[middle:]) / mean(rest[:middle]) if middle else float("nan")
    once = cpu - mean(rest) * len(times) if rest else 0.0
    return Cost(perf_counter() - begin, cpu, memory, growth, once, words)


def print_costs(costs: Iterable[tuple[str, Cost]], buildings: int) -> None:
    """The table of all stages, and what a larger city takes."""
    times = LARGER / buildings
    print(f"| stage | time | processor | peak memory | second half / first | {LARGER:,} buildings, processor | |")
    print("| --- | ---: | ---: | ---: | ---: | ---: | --- |")
    total = 0.0
    for name, cost in costs:
        growth = "" if np.isnan(cost.growth) else f"{cost.growth:.2f}"
        larger = cost.once + times * (cost.cpu - cost.once)
        total += larger
        print(
            f"| {name} | {cost.wall:.1f} s | {cost.cpu:.1f} s | {cost.memory:.0f} MB | {growth} "
            f"| {_span(larger)} | {cost.words} |"
        )
    print(
        f"\n{LARGER:,} buildings at the cost of a row here: {_span(total)} of processor time. Rows are independent: "
        f"on 10 nodes of 16 processors {_span(total / 160.0)}, each process with the memory above."
    )


def _span(seconds: float) -> str:
    return (
        f"{seconds:.0f} s"
        if seconds < 120.0
        else f"{seconds / 60.0:.0f} min"
        if seconds < 7200.0
        else (f"{seconds / 3600.0:.1f} h")
    )


def main(arguments: list[str] | None = None) -> int:
    """Do all stages, each in a process of its own, and print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])  # type: ignore[union-attr]
    parser.add_argument("--buildings", type=int, default=either(1000, 6))
    parser.add_argument(
        "--records", type=int, default=either(COMPONENTS, 1), help="44 of the far-field set, or fewer of the catalogue"
    )
    parser.add_argument("--folder", type=Path, help="keep scenes, datasets and figures here; else they are removed")
    parser.add_argument("--stage", choices=STAGES, help=argparse.SUPPRESS)
    options = parser.parse_args(arguments)
    if options.stage:
        print(json.dumps(stage(options.stage, options.folder, options.buildings, options.records)))
        return 0
    # In a process of its own, as a process that this one starts counts the memory of this one as its own at first.
    if not IS_SHORT:
        command = [sys.executable, "-m", "pounding_risk", "cache", "--shipped"]
        subprocess.run(command, check=True, stdout=sys.stderr)
    with TemporaryDirectory() as temporary:
        folder = options.folder or Path(temporary)
        folder.mkdir(parents=True, exist_ok=True)
        costs = []
        for name in STAGES:
            words = [f"--{key}={value}" for key, value in (vars(options) | {"stage": name, "folder": folder}).items()]
            done = subprocess.run([sys.executable, __file__, *words], stdout=subprocess.PIPE, text=True, check=True)
            costs.append((name, Cost(*json.loads(done.stdout.splitlines()[-1]))))
            print(f"{name}: {costs[-1][1].wall:.1f} s", file=sys.stderr)
        print(f"{options.buildings} buildings under {options.records} records, {THREADS} threads:\n")
        print_costs(costs, options.buildings)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
