"""Digests and means of every variable of the shipped scenes' datasets.

``python tests/shipped_numbers.py`` writes them.

The grids are cut down so that all of them run in some ten seconds once the kernels are compiled.
"""

from __future__ import annotations

import hashlib
import json
import platform
import tomllib
from collections.abc import Iterator
from importlib.metadata import version
from importlib.resources import files
from pathlib import Path
from typing import Any

import llvmlite.binding as llvm
import numpy as np
import xarray as xr

import pounding_risk as pr

KEPT = Path(__file__).parent / "data" / "shipped_numbers.json"
SCENES = files("pounding_risk.scene") / "shipped"
SOFT = [f'interface.{number}.stiffness="2.75e9 N/m^1.5"' for number in (1, 2)]  # of the row when they were taken
LAWS = ["jankowski", "kelvin_voigt", "viscous_elastoplastic", "stereomechanical"]


def _scene(name: str, *overrides: str) -> Any:
    return pr.read_scene(str(SCENES / f"{name}.toml"), list(overrides))


def _street() -> Any:
    block = pr.read_block(str(SCENES / "street.csv"))
    extra = {"records": {"pga": "0.3 g", "window": ["0 s", "8 s"]}}
    contact = pr.streets.Contact(stiffness="2.75e9 N/m^1.5")  # as when they were taken
    texts = block.scenes(["RSN6-180"], contact=contact, tables=extra)
    return pr.read_scene(tomllib.loads(texts["street-row-3.toml"]))


def datasets() -> Iterator[tuple[str, xr.Dataset]]:
    """A name and a dataset for each study of the shipped scenes."""
    ensemble = _scene("ensemble", 'grid.gap=["0 mm", "4 mm", "15 mm"]', 'grid.yield_force=["300 kN", "inf"]')
    compare = _scene("compare", 'grid.gap=["0 mm", "20 mm"]', 'grid.yield_force=["1.5 MN", "inf"]')
    row = _scene("row", 'grid.gap=["10 mm", "30 mm"]', *SOFT)
    for screening in (True, False):
        told = "screened" if screening else "not screened"
        yield f"pair, {told}", without_places(pr.scan(ensemble, screening=screening, check_fraction=0.1))
        yield f"row, {told}", pr.scan(row, screening=screening)
        yield f"street, {told}", pr.scan(_street(), screening=screening)
    yield "compare", without_places(pr.compare(compare, laws=LAWS)).drop_vars("reduced_mass")  # was an attribute
    yield "simulate pair", run_of_version_1(pr.simulate(_scene("paper")))
    yield "simulate row", run_of_version_1(pr.simulate(row))


def without_places(dataset: xr.Dataset) -> xr.Dataset:
    """A pair's dataset as version 1 had it, of which the digests are: without its one interface and contact point."""
    flat = dataset.squeeze("interface", drop=True).drop_dims(["contact_point", "storey"])
    return flat.drop_vars(["building_height", "building_storeys", "building_position"])


def run_of_version_1(run: xr.Dataset) -> xr.Dataset:
    """The variables of a run that version 1 had, of which the digests are, in the shape that they had."""
    run = run.drop_vars(["absolute_displacement", "ground_displacement"])
    if "energy_ground" not in run:  # of a row
        counts = {name: run[name].astype(float) for name in run.data_vars if run[name].dtype.kind == "i"}
        return run.assign(counts).drop_vars("relative_displacement")
    flat = run.squeeze(["interface", "contact_point", "storey"], drop=True)
    named = [name for name in flat.data_vars if {"time", "contact"} & set(flat[name].dims)]
    kept = flat[named].drop_vars(["contact_impulse_so_far", "contact_place"])
    return kept.drop_vars(set(kept.coords) - {"time", "building"}).assign_coords(gap=run.attrs["gap"])


def digests(dataset: xr.Dataset) -> dict[str, list[Any]]:
    """By variable: SHA-256 of its dimensions, shape, type and values; the mean of its finite magnitudes."""
    found = {}
    for name, variable in sorted(dataset.variables.items()):
        values = variable.values
        facts = [str(name), variable.dims, values.shape, values.dtype.str if values.dtype.kind != "O" else "O"]
        if values.dtype.kind in "OUS":
            content, mean = json.dumps(values.astype(str).tolist()).encode(), None
        else:
            content = np.ascontiguousarray(values).tobytes()
            finite = np.abs(values[np.isfinite(values)].astype(float))
            mean = float(finite.mean()) if finite.size else None
        found[str(name)] = [hashlib.sha256(json.dumps(facts).encode() + content).hexdigest()[:24], mean]
    return found


def arithmetic() -> dict[str, str]:
    """What the last digit of a result depends on beside our own code: the libraries and the processor."""
    libraries = {name: version(name) for name in ("numpy", "scipy", "numba", "llvmlite", "obspy")}
    return {**libraries, "machine": platform.machine(), "processor": llvm.get_host_cpu_name()}


if __name__ == "__main__":
    KEPT.write_text(
        json.dumps(
            {"arithmetic": arithmetic(), "datasets": {name: digests(each) for name, each in datasets()}}, indent=1
        )
        + "\n",
        encoding="utf-8",
    )
