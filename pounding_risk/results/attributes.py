"""Attributes of datasets: tables as JSON text, and the versions of the libraries."""

from __future__ import annotations

import json
import platform
import re
import tomllib
from collections.abc import Callable, Iterable, Mapping, Sequence
from functools import cache, lru_cache
from importlib import metadata
from itertools import pairwise, product
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from pounding_risk.errors import PoundingError
from pounding_risk.units import STOREY_HEIGHT, TIME, parse, say

if TYPE_CHECKING:
    import xarray as xr

VERSION = "dataset_version"  # the attribute
DATASET_VERSION = 2
SOURCE = "source"  # of a dataset's encoding: the file that it was opened from, where xarray has it too
DAMAGED = "the file was damaged or changed since it was written"  # in sentences on attributes
TAKE_ANOTHER = "take the one that scan wrote, or run the scan again"
POINT = "contact_point_"
JUMPING = ("peak_contact_force", f"{POINT}peak_contact_force", "peak_floor_acceleration", "storey_acceleration")
# Keys of links under which the motion stays in proportion; a link with any other key counts as nonlinear.
LINEAR_OF_LINKS = {"link_stiffness", "link_damping", "link_at"}
SCENE_AXES = "scene_axes"  # the axes of other numbers of the scene, slowest first
VARIANTS = "scene_variants"  # what else differs along the axes
LIBRARIES = ("pounding-risk", "numpy", "scipy", "numba", "xarray", "netCDF4", "obspy")

Axis = TypeVar("Axis")


def versions() -> dict[str, str]:
    """Versions of Python and of the libraries that numbers depend on."""
    return {"python": platform.python_version()} | versions_of(LIBRARIES)


def versions_of(packages: Iterable[str]) -> dict[str, str]:
    """Versions of these packages, in words for one that is not installed."""
    return {name: _version_of(name) for name in packages}


@cache
def _version_of(package: str) -> str:
    try:
        # The library's own way reads the whole description, often a manual, as an e-mail.
        text = metadata.distribution(package).read_text("METADATA") or ""
    except metadata.PackageNotFoundError:
        return "not installed"
    match = re.search(r"^Version: *(\S+)", text, re.MULTILINE)
    return match[1] if match else metadata.version(package)


def read_attribute(dataset: xr.Dataset, name: str, default: Any) -> Any:
    """The value of an attribute that was written by `as_text`, ``default`` where there is none.

    Raises PoundingError where the attribute is damaged, or holds another kind of value than ``default``.
    """
    content = from_text(dataset.attrs[name]) if name in dataset.attrs else default
    if type(content) is not type(default):
        raise unreadable(name, f"{name_of(dataset)}: " if SOURCE in dataset.encoding else "")
    return content


def unreadable(attribute: str, prefix: str = "") -> PoundingError:
    """The error to raise for an attribute that is damaged."""
    fault = f'{prefix}the attribute "{attribute}" of the results cannot be read'
    return PoundingError(f"{fault}: the file was changed since; run the scan again")


def name_of(dataset: xr.Dataset) -> str:
    """How a sentence names a dataset: the file that it was opened from, as `files.open_results` keeps it."""
    return str(getattr(dataset, "encoding", {}).get(SOURCE, "the dataset"))


@lru_cache(maxsize=8)
def tables_of(text: str) -> dict[str, Any]:
    """The tables of a TOML text, such as that of a dataset's scene; raises as `tomllib.loads`.

    Kept, and not to be changed: each interface of a row asks several times, and the text grows with the row.
    """
    return tomllib.loads(text)


def has_own_grounds(scene: Mapping[str, Any]) -> bool:
    """True where the tables of a scene, every value stated, put its buildings on unlike grounds."""
    buildings = [building.items() for building in scene.get("building", [])]
    grounds = [{key: setting for key, setting in keys if key.startswith("ground_")} for keys in buildings]
    return "wave_passage" in scene.get("effects", {}) or any(ground != grounds[0] for ground in grounds)


def has_histories(scene: Mapping[str, Any]) -> bool:
    """True where a building of the tables of a scene moves as files say."""
    return any("displacement_history" in building for building in scene.get("building", []))


def bumper_lengths(dataset: xr.Dataset) -> list[float]:
    """Length of the bumpers in the gap of each interface [m] of one case or run; empty without the key."""
    if "interface_bumper" not in dataset.variables:
        return []
    return [float(length) for length in dataset["interface_bumper"].values]


def bumper_words(lengths: Sequence[float]) -> str:
    """The bumpers of a row in words, such as "bumpers of 40 mm"; "" without any."""
    if not any(lengths):
        return ""
    ends = dict.fromkeys((min(lengths), max(lengths)))
    return f"bumpers of {' to '.join(f'{1e3 * length:.6g}' for length in ends)} mm"


def buildings_with(scene: Mapping[str, Any], *keys: str) -> list[str]:
    """The buildings whose tables in a scene have one of these keys."""
    return [str(table["name"]) for table in scene.get("building", []) if any(key in table for key in keys)]


def rotating_buildings(scene: Mapping[str, Any]) -> list[str]:
    """The buildings whose floors rotate, by the tables of a scene."""
    return buildings_with(scene, "plan")


def rotating_words(name: str) -> str:
    """What the outputs of a building whose floors rotate are of."""
    return (
        f"{name}: its floors rotate; displacements, drifts and floor accelerations are those of their centres of mass, "
        "which the ends of its faces may exceed"
    )


def moves_across(scene: Mapping[str, Any], name: str) -> bool:
    """True where floors of a building move across the row too, by the tables of a scene."""
    plans = next(building["plan"] for building in scene["building"] if building["name"] == name)
    return any("eccentricity_along" in plan for plan in ([plans] if isinstance(plans, dict) else plans))


def flags_of(variable: xr.DataArray) -> dict[int, str]:
    """The meanings of a variable's flags by their numbers; none of a variable without flags."""
    numbers = np.atleast_1d(variable.attrs.get("flag_values", ())).tolist()
    return dict(zip(map(int, numbers), str(variable.attrs.get("flag_meanings", "")).split(), strict=True))


def status_sentences(status: xr.DataArray) -> dict[int, str]:
    """How a run may end, by its code; older files have words without punctuation only."""
    words = {code: words.replace("_", " ") for code, words in flags_of(status).items()}
    return words | {int(code): sentence for code, sentence in json.loads(status.attrs.get("sentences", "{}")).items()}


def collapsed(case: xr.Dataset, *, without: bool = False, building: str = "") -> xr.DataArray:
    """Where a storey, of a building if one is named, collapses in the runs of a case, or in its motion without contact.

    Of datasets without `storey_collapse_time` all that is known is the status of the runs.
    """
    name = "storey_collapse_time" + "_free" * without
    if name in case:
        times = case[name].sel(building=building) if building else case[name]
        return times.notnull().any([dim for dim in ("building", "storey") if dim in times.dims])
    status = case["status"]
    return status.isin([code for code, word in flags_of(status).items() if word.startswith("a_storey_collapsed")])


def collapses(cases: xr.Dataset, *, without: bool = False) -> str:
    """Which storeys collapse, each with its time or, of several cases, with their number and the earliest time."""
    name = "storey_collapse_time" + "_free" * without
    if name not in cases:
        return ""
    times = cases[name].transpose(..., "building", "storey")
    words = []
    for building, storey in product(times["building"].values, times["storey"].values):
        ends = times.sel(building=building, storey=storey).values
        known = ends[np.isfinite(ends)]
        if known.size:
            when = f"at {say(known.min(), TIME, 4)}"
            words.append(f"storey {storey} of {building} " + (f"in {known.size}, first " * (ends.size > 1)) + when)
    return "; ".join(words)


def finite(case: xr.Dataset, name: str) -> xr.DataArray:
    """A variable of cases; forces of contact and accelerations of floors are NaN where velocities jump.

    What the dataset has there is that between the jumps, which have neither that is finite.
    """
    if name not in JUMPING:
        return case[name]
    prefix = POINT if name.startswith(POINT) else ""
    jumps = (case[f"{prefix}impact_count"] > 0) & (case[f"{prefix}yield_exceedance"] < 0)
    run_dims = [dim for dim in ("interface",) if dim in jumps.dims and dim not in case[name].dims]
    return case[name].where(~jumps.any(run_dims))


def of_structure(case: xr.Dataset, name: str) -> xr.DataArray:
    """`finite`; `peak_drift` of isolated buildings is that above the isolators, which are storey 1 and made to move."""
    peaks = finite(case, name)
    if not name.startswith("peak_drift") or not (isolated := isolated_of(case)):
        return peaks
    above = case[name.replace("peak", "storey")].sel(storey=slice(2, None)).max("storey")
    return peaks.where(~peaks["building"].isin(isolated), above)


def of_storeys(case: xr.Dataset, name: str) -> xr.DataArray:
    """The largest value of the storeys of each building that may yield; isolators are none of them."""
    peaks = finite(case, name).where(case["storey_ductility" + "_free" * name.endswith("_free")].notnull())
    return peaks.where((peaks["storey"] > 1) | ~peaks["building"].isin(isolated_of(case))).max("storey")


def of_isolators(case: xr.Dataset, name: str) -> xr.DataArray:
    """The value of the isolators of each building, which are its storey 1; NaN of buildings without."""
    peaks = finite(case, name).sel(storey=1, drop=True)
    return peaks.where(peaks["building"].isin(isolated_of(case)))


def isolated_of(case: xr.Dataset) -> list[str]:
    """The buildings of a dataset that stand on isolators."""
    return isolated_buildings(tables_of(str(case.attrs.get("scene_resolved", ""))))


def isolated_notes(case: xr.Dataset) -> list[str]:
    """What the output `peak_drift` counts of the buildings of a dataset that stand on isolators."""
    isolated = isolated_of(case)
    return [f"Storey 1 of {' and '.join(isolated)} is its isolators, which peak drift counts."] if isolated else []


def gaps_needed(dataset: xr.Dataset) -> xr.DataArray:
    """`peak_closing_free`, NaN for motions without a finite response, such as those in which a storey collapses.

    The dataset has what they close up to there, and no gap is wide enough for them.
    """
    closing = dataset["peak_closing_free"]
    if "peak_displacement_free" not in dataset:
        return closing
    return closing.where(np.isfinite(dataset["peak_displacement_free"].max("building", skipna=False)))


def collapsible_buildings(scene: Mapping[str, Any]) -> list[str]:
    """The buildings whose storeys may collapse: with hysteresis, or that yield under a weight that acts."""
    yield_under_weight = {"inelastic_storeys", "p_delta"} <= set(scene.get("effects", {}))
    return buildings_with(scene, "hysteresis", *["storey_strengths"] * yield_under_weight)


def yielding_buildings(scene: Mapping[str, Any]) -> list[str]:
    """The buildings whose storeys or isolators may yield, by the tables of a scene."""
    storeys_yield = "inelastic_storeys" in scene.get("effects", {})
    return buildings_with(scene, "isolation", *["storey_strengths"] * storeys_yield)


def no_response(dataset: xr.Dataset, of: str = "", at: str = "assessed") -> str:
    """A sentence for motions, ``at`` an amplitude, of which none can be assessed, ``of`` a building if it is of one."""
    if "status" in dataset and bool(np.all(collapsed(dataset, without=True))):
        return (
            f"in every motion {at} a storey collapses, for which no gap is wide enough; give it more strength, or "
            "assess a smaller amplitude"
        )
    response = f"a finite response of {of}" if of else "a finite response"
    return f"no motion of the dataset moves the ground and has {response}; check the records and the buildings"


def has_laws_of_links(scene: Mapping[str, Any]) -> bool:
    """True where links of a scene slip, are slack, break, or have dampers of a power law."""
    return any(key.startswith("link_") and key not in LINEAR_OF_LINKS for key in _keys_of(scene, "interface"))


def has_initial_motion(scene: Mapping[str, Any]) -> bool:
    """True where buildings of a scene, or the ground below them, are displaced or move when the motion begins."""
    return bool({"initial_displacement", "initial_velocity", "ground_velocity"} & _keys_of(scene, "building"))


def _keys_of(scene: Mapping[str, Any], section: str) -> set[str]:
    """Keys of the tables of a section, and of the addresses in the grid and of uncertain numbers."""
    tables = [*scene.get(section, []), scene.get("grid", {}), scene.get("uncertain", {})]
    return {name.rpartition(".")[2] for table in tables for name in table}


def isolated_buildings(scene: Mapping[str, Any]) -> list[str]:
    """The buildings on isolators, by the tables of a scene; isolators are storey 1."""
    return buildings_with(scene, "isolation")


def moat_walls(scene: Mapping[str, Any]) -> list[str]:
    """The walls that give, by the tables of a scene: of one storey, no taller than an isolated neighbour's slab."""
    walls: dict[str, None] = {}
    for pair in pairwise(scene.get("building", [])):
        for wall, other in (pair, pair[::-1]):
            heights = wall.get("storey_heights", ())
            if "isolation" in wall or "isolation" not in other or len(heights) != 1:
                continue
            height, slab = (parse(text, STOREY_HEIGHT) for text in (heights[0], other["isolation"]["height"]))
            if height <= slab * (1.0 + 1e-9):
                walls[str(wall["name"])] = None
    return list(walls)


def as_text(content: Any) -> str:
    """A value as JSON, for an attribute: netCDF attributes hold no tables."""
    return json.dumps(content, ensure_ascii=False, sort_keys=True, default=str)


def from_text(text: Any) -> Any:
    """The value of an attribute that `as_text` wrote; None where it cannot be read as JSON."""
    try:
        return json.loads(text)
    except (TypeError, ValueError, RecursionError):
        return None


def scene_dims(dataset: xr.Dataset) -> tuple[str, ...]:
    """The dimensions of a dataset that are other numbers of its scene, in order."""
    names = read_scene_axes(dataset, lambda axis: str(axis.get("dimension") or axis["keys"][0]))
    return tuple(name for name in names if name in dataset.sizes)


def read_scene_axes(dataset: xr.Dataset, read: Callable[[Any], Axis]) -> tuple[Axis, ...]:
    """The axes of other numbers of the scene that a dataset was made with, each as ``read`` takes it; () of others."""
    text = dataset.attrs.get(SCENE_AXES)
    if not text:
        return ()
    try:
        return tuple(map(read, json.loads(text)))
    except (TypeError, ValueError, LookupError, AttributeError, RecursionError):
        raise PoundingError(f"the attribute {SCENE_AXES} cannot be read: {DAMAGED}") from None


def variants_of(dataset: xr.Dataset) -> dict[str, list[Any]]:
    """What else differs along the axes: lists of attributes and of tables; raises PoundingError where it is damaged."""
    variants = from_text(dataset.attrs.get(VARIANTS, "{}"))
    if not isinstance(variants, dict) or not all(isinstance(entries, list) for entries in variants.values()):
        raise PoundingError(f"the attribute {VARIANTS} cannot be read: {DAMAGED}; {TAKE_ANOTHER}")
    return variants
