"""A million cases to disk and back: peak memory and time, block by block beside the whole dataset in memory.

    python benchmarks/big_dataset.py [--cases 1000000]

The dataset has the template of a pair's scan (its variables and labels) with made values; each way runs in a process of
its own, so that its peak of resident memory is its own. "imports" is what Python and the libraries take before.
"""

from __future__ import annotations

import argparse
import json
import resource
import subprocess
import sys
import tempfile
from pathlib import Path
from time import process_time

import numpy as np
import xarray as xr
from shortened import either

from pounding_risk._common.files import AGAIN
from pounding_risk.ensemble.scan import scan
from pounding_risk.results.files import netcdf_encoding
from pounding_risk.results.layout import Template, blocks, template_of
from pounding_risk.scene.reader import parse_scene

SCENE = """
[[building]]
name = "left"
mass = "10 t"
period = "0.5 s"
[[building]]
name = "right"
mass = "20 t"
period = "0.3 s"
[[interface]]
gap = "20 mm"
contact_model = "jankowski"
stiffness = "2e9 N/m^1.5"
restitution = 0.65
[records]
names = ["RSN6-180"]
window = ["0 s", "4 s"]
"""
WAYS = (
    "imports",
    "in memory, to_netcdf",
    "netCDF by block",
    "Zarr by block",
    "summary of netCDF",
    "summary of Zarr",
    "convert Zarr to netCDF",
)


def template_of_cases(cases: int) -> Template:
    """The template of a pair's scan with so many cases: records × 2 polarities × 4 laws × 25 gaps × 20 yield forces."""
    small = template_of(scan(parse_scene(SCENE), check_fraction=1.0))
    sizes = {"record": max(1, cases // 4000), "polarity": 2, "contact_model": 4, "gap": 25, "yield_force": 20}
    larger = small.skeleton.isel({axis: [0] * size for axis, size in sizes.items()})
    labels = {axis: [f"{axis} {place}" for place in range(sizes[axis])] for axis in ("record", "contact_model")}
    labels["polarity"] = ["as recorded", "reversed"]
    larger.attrs["records"] = json.dumps([{"name": name} for name in labels["record"]])  # summaries check it
    numbers = {"gap": np.linspace(0.0, 0.1, 25), "yield_force": np.linspace(1e5, 2e6, 20)}
    shape = tuple(sizes.get(axis, 1) for axis in ("record", "polarity", "pga", "contact_model", "gap", "yield_force"))
    return Template(larger.assign_coords(labels | numbers), small.cases, shape)


def made_values(template: Template, batches: range) -> dict[str, np.ndarray]:
    """Values of a run of batches that do not repeat, so that compressing is work; one run in a hundred made again."""
    random = np.random.default_rng(batches.start)
    found = {}
    for name, variable in template.cases.items():
        sizes = (len(batches), template.width, *template.extra(name))
        if variable.dtype.kind == "i":
            found[name] = random.integers(0, 2, sizes).astype(variable.dtype)
        else:
            found[name] = np.where(random.random(sizes) < 0.1, np.nan, random.lognormal(size=sizes))
    found["status"][:] = 0
    found["sensitive"][:] = np.where(random.random(found["sensitive"].shape) < 0.01, found["sensitive"], -1)
    return found


def work(way: str, folder: Path, cases: int) -> None:
    """Do one of the measured operations in this process."""
    from pounding_risk.results.store import Memory, store_of
    from pounding_risk.results.summary import summary
    from pounding_risk.studies.convert import convert

    if way.startswith("summary"):
        summary(folder / ("by_block.nc" if "netCDF" in way else "by_block.zarr"))
        return
    if way.startswith("convert"):
        convert(folder / "by_block.zarr", folder / "converted.nc")
        return
    template = template_of_cases(cases)
    if way == "in memory, to_netcdf":
        memory = Memory(template)
        for block in blocks(template):
            memory.write(block, made_values(template, block))
        memory.finish({})
        whole: xr.Dataset = memory.dataset()
        whole.to_netcdf(folder / "whole.nc", engine="netcdf4", encoding=netcdf_encoding(whole))
    elif way != "imports":
        with store_of(template, folder / ("by_block.nc" if "netCDF" in way else "by_block.zarr"), AGAIN) as store:
            for block in blocks(template):
                store.write(block, made_values(template, block))
            store.finish({})


def size_of(path: Path) -> float:
    """Bytes of a file or a folder's files."""
    files = path.rglob("*") if path.is_dir() else [path]
    return float(sum(each.stat().st_size for each in files if each.is_file()))


def main() -> None:
    """Run every way in a process of its own and print a table."""
    options = argparse.ArgumentParser(description=__doc__)
    options.add_argument("--cases", type=int, default=either(1_000_000, 8_000))
    options.add_argument("--way", help=argparse.SUPPRESS)
    options.add_argument("--folder", type=Path, help=argparse.SUPPRESS)
    asked = options.parse_args()
    if asked.way:
        start = process_time()
        work(asked.way, asked.folder, asked.cases)
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1e3  # kB on Linux
        print(json.dumps({"peak": peak, "seconds": process_time() - start}))
        return
    template = template_of_cases(asked.cases)
    amount = template.batches * template.width
    size = amount * template.bytes_per_case / 1e6
    print(f"{amount} cases, {len(template.cases)} variables, {size:.0f} MB before compression")
    print(f"{len(list(blocks(template)))} blocks\n\n| way | peak memory [MB] | processor time [s] |\n|---|---|---|")
    with tempfile.TemporaryDirectory() as name:
        for way in WAYS:
            command = [sys.executable, __file__, "--way", way, "--folder", name, "--cases", str(asked.cases)]
            run = subprocess.run(command, capture_output=True, text=True, check=True)
            found = json.loads(run.stdout.splitlines()[-1])
            print(f"| {way} | {found['peak']:.0f} | {found['seconds']:.1f} |", flush=True)
        sizes = ", ".join(f"{path.name} {size_of(path) / 1e6:.0f} MB" for path in sorted(Path(name).iterdir()))
    print(f"\non disk: {sizes}")


if __name__ == "__main__":
    main()
