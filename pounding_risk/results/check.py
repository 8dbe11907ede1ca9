"""What a dataset is, by what only its dataset has, and the check of one of `scan` before it is used.

A file may have been damaged or changed since it was written. Dimensions, units and types of the variables are those of
the table in `results.variables`; declared here are the labels of the axes and the types of the attributes. Each command
names the variables that it needs. No solver is imported.
"""

from __future__ import annotations

import re
import tomllib
from collections.abc import Callable, Iterable, Iterator, Mapping
from contextlib import contextmanager
from hashlib import sha256
from math import isfinite
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.letters import refused, refused_below
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS
from pounding_risk.motions.record import AFTERSHOCK
from pounding_risk.results.attributes import DAMAGED, TAKE_ANOTHER, from_text, name_of, scene_dims
from pounding_risk.results.layout import dims_in
from pounding_risk.results.variables import CHANGES, COORDINATES, NUMBER, TEXT, VARIABLES, WHOLE, Declared
from pounding_risk.units import GAP, YIELD_FORCE, QuantityError, parse

if TYPE_CHECKING:
    import xarray as xr

# Variables, coordinates and attributes that only the dataset of this call has, in the order in which they are looked
# for: a dataset of `compare` or `effects` is that of a scan with more in it.
MARKS = {
    "compare": {"flips", "baseline"},
    "accuracy": {"setting", "time_to_reach"},
    "effects": {"effects", "time_ratio"},
    "uncertainty": {"uncertain_number"},
    "spectra": {"left_period", "required_gap"},
    "amplification": {"period_ratio"},
    "damage": {"demand_ratio", "median_ratio"},
}

# Of such a call: what its datasets always have, and axes with labels, without which its figures and tables cannot be.
ALWAYS = {"spectra": ("required_gap", "separation"), "amplification": ("displacement_amplification",)}
AXES_OF_KIND = {
    "spectra": ("percentile", "rule", "left_period", "right_period"),
    "damage": ("state", "pounding", "im", "level"),
}

POLARITIES = ("as recorded", "reversed")
KINDS = ("floor", "column")  # of contact points
NOT_WHERE = (
    "where() of xarray makes floats of whole numbers and fills in NaN: to select records write isel(record=mask.values)"
)
REPAIR = f"{DAMAGED}: {TAKE_ANOTHER}"
THIS = "the dataset"  # of a call that is given one, not a file
# Attributes that hold JSON, and of what kind: a table, or a list.
TABLES = ("stiffness", "flags", "options", "motions_sha256", "processing", "versions", "plugins", "level_notes")
LISTS = ("left_out", "overrides", "copies", "notes", "unused_keys")
TEXTS = ("title", "source", "references", "scene", "scene_file", "restitution", "restitution_relation", "command")
TEXTS_OF_RECORD = ("event", "date", "station", "component", "source", "sha256")
AXES_OF_CASES = ("record", "polarity", "contact_model", "gap", "yield_force")  # with labels in every dataset of a scan
# Variables that every assessment of a dataset needs.
NEEDED = ("peak_closing_free", "yield_exceedance", "impact_count", "status", "peak_displacement_free")
# Coordinates of every dataset with these dimensions.
OF_PLACES = {
    "contact_point": [name for name in COORDINATES if name.startswith("contact_point_") and "yield" not in name],
    "storey": ["building_height", "building_storeys", "building_position", "floor_level"],
}
# What stands beside any output of contact points, and of storeys.
OF_CONTACTS = ["impact_count", "peak_contact_force", "yield_exceedance"]
BESIDE = {
    "contact_point_": [*(f"contact_point_{name}" for name in OF_CONTACTS), *OF_CONTACTS],
    "storey_": ["storey_displacement_free"],
}


def kind_of(dataset: xr.Dataset) -> str:
    """The call that made a dataset: scan, simulate, histories or one of `MARKS`; "" where none did."""
    return kind_of_names(set(map(str, dataset.dims)), set(map(str, dataset.variables)), set(dataset.attrs))


def kind_of_names(dims: set[str], variables: set[str], attrs: set[str]) -> str:
    """`kind_of` of a dataset with dimensions, variables and attributes of these names."""
    names = variables | (attrs - {"effects"})
    for kind, marks in MARKS.items():
        if marks & names:
            return kind
    if "sample" in dims and "time" in variables:  # a scan may have samples of uncertain numbers
        return "histories"
    if "time" in dims and "contact_force" in variables:
        return "simulate"
    return "scan" if {"impact_count", "record", "gap"} <= names else ""


def check_kind(dataset: xr.Dataset, kind: str) -> None:
    """Raise PoundingError for another dataset than the call of this name makes, and for one that has lost an axis."""
    if kind_of(dataset) != kind or any(name not in dataset.data_vars for name in ALWAYS.get(kind, ())):
        raise PoundingError(f"this is no dataset of `pounding-risk {kind}`; run it with -o {kind}.nc")
    lost_axes = [name for name in AXES_OF_KIND.get(kind, ()) if name not in dataset.indexes]
    if lost_axes:
        raise PoundingError(f"the dataset of {kind} has lost its {' and '.join(lost_axes)}; run {kind} again")


@contextmanager
def missing_named() -> Iterator[None]:
    """A variable that is read and that a dataset has not becomes a PoundingError that names it; also a decorator.

    What a command reads depends on the scene and its options, so that no list of what it needs can be complete.
    """
    try:
        yield
    except KeyError as error:
        message = str(error.args[0]) if error.args else ""
        # By xarray, of a dataset; and of what it selects by.
        match = re.match(r"No variable named '([^']+)'|'([^']+)' is not a valid dimension or coordinate", message)
        name = (match[1] or match[2]) if match else message  # of an array's coordinates the name alone
        if not match and name not in VARIABLES | COORDINATES:
            raise
        raise PoundingError(f"the results have no variable {name}, which is read here; {REPAIR}") from error


def check_scan(dataset: xr.Dataset, label: str = THIS, *, names: Iterable[str] = (), attrs: Iterable[str] = ()) -> None:
    """Raise PoundingError, with a sentence for each fault, unless a dataset is what `scan` writes, as declared here.

    ``label`` names it in the sentence; variables, coordinates and attributes of these names must be there. Values of
    cases are not read.
    """
    faults = [*_missing(dataset, names, attrs), *_form_faults(dataset), *_attribute_faults(dataset)]
    # Later checks rely on dimensions and kinds of values.
    checks = (_axis_faults, _status_faults, _flag_faults, _scene_faults)
    masked = "status" in dataset and dataset["status"].dtype.kind == "f"
    _refuse(label, faults or [fault for check in checks for fault in check(dataset)], NOT_WHERE if masked else REPAIR)


def check_dataset(results: xr.Dataset, label: str = "", taker: str = "assess") -> None:
    """Raise PoundingError for what is no dataset of `scan` with all its axes, and for a damaged one."""
    label = label or name_of(results)
    kind = kind_of(results)
    if kind not in ("scan", ""):
        is_export = taker == "export" and "displacement" in results
        by_xarray = "; histories are written by xarray: ds.displacement.to_dataframe().to_csv(...)" * is_export
        raise PoundingError(
            f"{label}: is a dataset of `{kind}`, which has not the cases of a scan; {taker} takes what "
            f"`pounding-risk scan SCENE -o results.nc` writes{by_xarray}"
        )
    if "impact_count" not in results or not {"record", "gap"} <= set(results.dims):
        raise PoundingError(f"{label}: is no dataset of a scan; `pounding-risk scan SCENE -o results.nc` writes one")
    missing = [name for name in NEEDED if name not in results]
    if missing:
        raise PoundingError(
            f"{label}: has no {', '.join(missing)}: an older version wrote it, or it was damaged; scan the scene "
            "again, the scene's text is the attribute 'scene'"
        )
    if "scene_resolved" not in results.attrs:
        raise PoundingError(
            f"{label}: has lost its attribute 'scene_resolved', which holds the scene; take the file that scan wrote"
        )
    names = (*AXES_OF_CASES, "building", "building_period", "building_damping")
    check_scan(results, label, names=names, attrs=("records", "title"))
    damping = results["building_damping"]
    if bool((np.isfinite(results["building_period"]) & ~((damping >= 0.0) & (damping <= 1.0))).any()):
        raise PoundingError(f"{label}: a building that has a period has no damping from 0 to 1; {REPAIR}")


def check_scene(dataset: xr.Dataset) -> None:
    """Raise PoundingError where the scene in the attributes of any dataset cannot be read."""
    _refuse(THIS, list(_scene_faults(dataset)))


def check_labels(dataset: xr.Dataset) -> None:
    """Raise PoundingError where a label of an axis of any dataset stands there twice."""
    axes = [axis for axis in dataset.dims if axis in dataset.coords and not dataset.indexes[axis].is_unique]
    _refuse(THIS, [f"a label of the axis {axis} stands there twice" for axis in axes])


FLOORS_OF_POINT = ("contact_point_left_floor", "contact_point_right_floor")


def check_run(run: xr.Dataset) -> None:
    """Raise PoundingError where a run of `simulate` lost an axis, or where a level in its attributes is no number."""
    faults = [f"the dimension {dim} is missing" for dim in ("time", "building", "storey") if dim not in run.dims]
    time = run["time"].values if "time" in run.coords else np.array([0.0])
    if time.dtype.kind not in NUMBER or not np.all(np.isfinite(time)) or np.any(np.diff(time) < 0.0):
        faults.append("the times are not finite numbers in rising order")
    points = [name for name in ("contact_point_level", *FLOORS_OF_POINT) if name in run.coords]
    numbers = [name for name in points if run[name].dtype.kind in NUMBER]
    faults += [f"the variable {name} is infinite" for name in numbers if np.any(np.isinf(run[name].values))]
    levels = [name for name in ("pga", "gap", "yield_force", "intensity_level") if name in run.attrs]
    wrong_names = [name for name in levels if isinstance(run.attrs[name], str) or np.size(run.attrs[name]) != 1]
    _refuse(THIS, [*faults, *(f"the attribute {name} is {run.attrs[name]!r}, not a number" for name in wrong_names)])


def _refuse(label: str, faults: list[str], repair: str = REPAIR) -> None:
    """Raise PoundingError with a sentence for each fault, where there are any."""
    if len(faults) == 1:
        raise PoundingError(f"{label}: {faults[0]}; {repair}")
    if faults:
        raise PoundingError(
            "\n".join([f"{label}: {len(faults)} faults", *(f"  - {fault}" for fault in faults), repair])
        )


def _missing(dataset: xr.Dataset, names: Iterable[str], attrs: Iterable[str]) -> Iterator[str]:
    yield from (f"the variable {name} is missing" for name in names if name not in dataset.variables)
    yield from (f"the attribute {name} is missing" for name in attrs if name not in dataset.attrs)
    axes = [dim for dim in dataset.dims if dim in COORDINATES and dim not in dataset.coords]
    yield from (f"the axis {axis} has no labels" for axis in axes)
    if "sensitive" in dataset.variables:
        yield from (f"the variable {name} is missing" for name in CHANGES if name not in dataset.variables)
    needed = [name for dim, names in OF_PLACES.items() if dim in dataset.dims for name in names]
    needed += [
        name
        for prefix, names in BESIDE.items()
        if any(str(variable).startswith(prefix) and variable not in COORDINATES for variable in dataset.data_vars)
        for name in names
    ]
    yield from (f"the variable {name} is missing" for name in needed if name not in dataset.variables)
    yield from (f"{name} is not among the coordinates" for name in dataset.data_vars if name in COORDINATES)
    yield from (f"the dimension {dim} has a length of 0" for dim, size in dataset.sizes.items() if size == 0)


def _form_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Variables and coordinates whose dimensions, unit or kind are not those that are declared."""
    variables, scene_axes = dataset.variables, set(scene_dims(dataset))
    for name, declared in (VARIABLES | COORDINATES).items():
        if name not in variables:
            continue
        variable = variables[name]
        expected_dims = _dims(dataset, declared)
        # Along an axis of another number of the scene anything may differ.
        if set(variable.dims) - scene_axes != set(expected_dims):
            yield f"the variable {name} has the dimensions {_list(variable.dims)}, not {_list(expected_dims)}"
        if variable.dtype.kind not in declared.kinds:
            expected_kind = {TEXT: "texts", WHOLE: "whole numbers", NUMBER: "numbers"}[declared.kinds]
            yield f"the variable {name} holds values of type {variable.dtype}, not {expected_kind}"
        unit = variable.attrs.get("units")
        if declared.unit is not None and unit is not None and not (isinstance(unit, str) and unit == declared.unit):
            yield f"the variable {name} is in {unit!r}, not in {declared.unit!r}"


def _dims(dataset: xr.Dataset, declared: Declared) -> tuple[str, ...]:
    """The dimensions that a variable must have; an axis with one value selected is none.

    Then a label has that value, or the scan had one value only.
    """
    selected = {"pga", *dataset.coords} - set(dataset.dims)
    return tuple(dim for dim in dims_in(dataset, declared.dims) if dim not in selected)


def _list(names: Iterable[Any]) -> str:
    return ", ".join(map(str, names)) or "none"


def _attribute_faults(dataset: xr.Dataset) -> Iterator[str]:
    for name in TEXTS:
        if not isinstance(dataset.attrs.get(name, ""), str):
            yield f"the attribute {name} is no text"
    # What `compare` and `effects` leave out are laws or effects, in words.
    lists = [name for name in LISTS if name != "left_out" or kind_of(dataset) not in ("compare", "effects")]
    kinds = dict.fromkeys(TABLES, dict) | dict.fromkeys((*lists, "records"), list)
    contents = {name: from_text(dataset.attrs[name]) for name in kinds if name in dataset.attrs}
    for name, content in contents.items():
        if not isinstance(content, kinds[name]):
            yield f"the attribute {name} cannot be read as a {'table' if kinds[name] is dict else 'list'} in JSON"
    valid = {name: content for name, content in contents.items() if isinstance(content, kinds[name])}
    yield from _entry_faults(dataset, valid)
    rtol = dataset.attrs.get("rtol", 1.0)
    if isinstance(rtol, str) or np.size(rtol) != 1 or not (isfinite(rtol) and rtol > 0.0):
        yield f"the attribute rtol is {rtol!r}, not a number above 0"


def _is_shock(facts: Any) -> bool:
    return isinstance(facts, dict) and _is_texts([facts.get(key) for key in ("name", "source")])


def _entry_faults(dataset: xr.Dataset, contents: Mapping[str, Any]) -> Iterator[str]:
    """Faults of the entries of JSON attributes, which are ``contents``: tables and lists by name."""
    records = contents.get("records", [])
    if not all(isinstance(record, dict) and isinstance(record.get("name"), str) for record in records):
        yield "the attribute records has an entry without a name"
    elif not all(isinstance(record.get(key) or "", str) for record in records for key in TEXTS_OF_RECORD):
        yield f"the attribute records has one of {', '.join(TEXTS_OF_RECORD)} that is no text"
    elif not all(_is_shock(record[AFTERSHOCK]) for record in records if AFTERSHOCK in record):
        yield f"the attribute records has an {AFTERSHOCK} without the texts of its name and source"
    elif records and "record" in dataset.coords:
        names = {record["name"] for record in records}
        unknown = [str(name) for name in np.atleast_1d(dataset["record"].values) if str(name) not in names]
        if unknown:
            yield f"the attribute records says nothing of {', '.join(unknown[:3])}"
    for name in ("motions_sha256", "versions", "notes", "unused_keys", "overrides"):
        texts = contents.get(name, [])
        if not _is_texts(list(texts.values()) if isinstance(texts, dict) else texts):
            yield f"the attribute {name} has an entry that is no text"
    for name in ("processing", "flags"):
        if not all(map(_is_texts, contents.get(name, {}).values())):
            yield f"the attribute {name} holds something else than a list of sentences for each record"


def _is_texts(texts: Any) -> bool:
    return isinstance(texts, list) and all(isinstance(text, str) for text in texts)


def _axis_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Faults of the labels of axes."""
    for name in ("record", "polarity", "contact_model", "building", "interface", "contact_point"):
        # Where motions are drawn with samples, each sample has its own record and polarity.
        if name in dataset.coords and dataset[name].dims in ((), (name,)):
            labels = [str(label) for label in np.atleast_1d(dataset[name].values)]
            if len(set(labels)) < len(labels) or not all(labels):
                yield f"the labels of the axis {name} are empty or stand there twice"
            yield from (f"a label of {name} {fault}" for fault in map(refused, labels) if fault)
    polarities = np.atleast_1d(dataset["polarity"].values) if "polarity" in dataset.coords else ()
    if wrong_polarities := sorted(set(map(str, polarities)) - set(POLARITIES)):
        yield f"the polarity {wrong_polarities[0]!r} is neither {' nor '.join(map(repr, POLARITIES))}"
    limits: tuple[tuple[str, Callable[[Any], Any], str], ...] = (
        ("gap", lambda values: np.isfinite(values) & (values >= 0.0), "distances of 0 or more"),
        ("yield_force", lambda values: values > 0.0, "forces above 0"),
        ("pga", lambda values: np.isnan(values) | (np.isfinite(values) & (values > 0.0)), "accelerations above 0"),
        (LEVEL_AXIS, lambda values: np.isfinite(values) & (values > 0.0), "numbers above 0"),
        ("period", lambda values: np.isfinite(values) & (values > 0.0), "periods above 0"),
        ("interface_gap", lambda values: np.isfinite(values) & (values >= 0.0), "distances of 0 or more"),
        ("interface_bumper", lambda values: np.isfinite(values) & (values >= 0.0), "lengths of 0 or more"),
        ("record_pga", lambda values: np.isfinite(values) & (values >= 0.0), "accelerations of 0 or more"),
        ("record_pgv", lambda values: np.isfinite(values) & (values >= 0.0), "speeds of 0 or more"),
        ("building_period", lambda values: np.isnan(values) | (values > 0.0), "periods above 0"),
        ("building_isolated_period", lambda values: np.isnan(values) | (values > 0.0), "periods above 0"),
    )
    for name, is_allowed, words in limits:
        if name in dataset.coords and not np.all(is_allowed(dataset[name].values)):
            yield f"the values of {name} are not {words}"
    for name in ("gap", "yield_force", "pga", LEVEL_AXIS, "period"):
        if name in dataset.dims and np.unique(dataset[name].values).size < dataset.sizes[name]:
            yield f"a value of the axis {name} stands there twice"
    yield from _place_faults(dataset)


def _place_faults(dataset: xr.Dataset) -> Iterator[str]:
    buildings = dataset.sizes.get("building", 2)
    if "interface" in dataset.dims and dataset.sizes["interface"] != buildings - 1:
        yield f"{dataset.sizes['interface']} interfaces do not stand between {buildings} buildings"
    if "contact_point" not in dataset.dims or "interface" not in dataset.dims:
        return
    places = dataset["contact_point_interface"].values
    if places.min() < 0 or places.max() >= dataset.sizes["interface"]:
        yield "the contact points are not all at the interfaces"
    if wrong_kinds := set(map(str, np.atleast_1d(dataset["contact_point_kind"].values))) - set(KINDS):
        yield f"a contact point is of the kind {sorted(wrong_kinds)[0]!r}, not {' or '.join(KINDS)}"


def _status_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Faults of the attributes that explain the codes of the variable ``status``."""
    if "status" not in dataset.variables:
        return
    attrs = dataset["status"].attrs
    meanings = str(attrs.get("flag_meanings", "")).split()
    codes = np.atleast_1d(attrs.get("flag_values", ()))
    if codes.dtype.kind not in WHOLE or len(codes) != len(meanings) or "complete" not in meanings:
        yield "the attributes flag_values and flag_meanings of the variable status do not say what its codes mean"
    elif int(codes[meanings.index("complete")]) != 0:
        yield "the variable status calls another code than 0 complete"
    sentences = from_text(attrs.get("sentences", "{}"))
    if not isinstance(sentences, dict) or not all(
        key.lstrip("-").isdecimal() and isinstance(text, str) for key, text in sentences.items()
    ):
        yield "the attribute sentences of the variable status cannot be read"


def _flag_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Faults of the attributes that explain the codes of any other variable."""
    for name, variable in dataset.data_vars.items():
        codes, words = (variable.attrs.get(f"flag_{kind}") for kind in ("values", "meanings"))
        if name == "status" or (codes is None and words is None):
            continue
        if not isinstance(words, str) or codes is None or np.size(codes) != len(words.split()):
            yield f"the attributes flag_values and flag_meanings of the variable {name} do not fit together"


def _scene_faults(dataset: xr.Dataset) -> Iterator[str]:
    """Faults of the scene in the attributes: its title; it must be whole, and that of this dataset."""
    if why := refused(str(dataset.attrs.get("title", ""))):
        yield f"the attribute title {why}"
    text = dataset.attrs.get("scene_resolved")
    if text is None:
        return
    digest = dataset.attrs.get("scene_sha256")
    if not isinstance(text, str) or (digest is not None and str(digest) != sha256(text.encode()).hexdigest()):
        yield "the attribute scene_resolved is not the one that scene_sha256 was taken of"
        return
    try:
        scene = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError) as error:
        yield f"the scene in the attribute scene_resolved cannot be read ({error})"
        return
    yield from (f"the scene in scene_resolved, {'.'.join(map(str, path))}: {why}" for path, why in refused_below(scene))
    interfaces = scene.get("interface", [])
    if not isinstance(interfaces, list) or not interfaces or not all(map(_is_interface, interfaces)):
        yield "the scene in the attribute scene_resolved has no [[interface]] with a gap, or one that cannot be read"
    for name in ("effects", "grid", "records", "solver", "uncertain"):
        if not isinstance(scene.get(name, {}), dict):
            yield f"the {name} of the scene in the attribute scene_resolved are no table"
    buildings = scene.get("building", [])
    if not isinstance(buildings, list) or not all(isinstance(building, dict) for building in buildings):
        yield "the buildings of the scene in the attribute scene_resolved are no tables"


def _is_interface(table: Any) -> bool:
    """True where an interface of a resolved scene has the values that are read from it."""
    if not isinstance(table, dict) or not isinstance(table.get("contact_model", ""), str):
        return False
    try:
        parse(table["gap"], GAP)
        return parse(table.get("yield_force", "inf"), YIELD_FORCE) > 0.0
    except (KeyError, QuantityError):
        return False
