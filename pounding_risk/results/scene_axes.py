"""Axes of other numbers of the scene in a dataset of `scan`: their labels, and the dataset at one place along them.

``dataset.sel(polarity="reversed")`` leaves the polarity as a label without an axis, and ``dataset.squeeze()`` the
interface of two buildings; `with_axes` gives the axes back.
At one place a dataset is that of the scene which stands there: its attributes are those that a scan of it has. No
solver is imported, and no scene read.
"""

from __future__ import annotations

import json
import tomllib
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from copy import deepcopy
from functools import reduce
from hashlib import sha256
from itertools import chain
from math import inf, isclose
from operator import getitem
from typing import TYPE_CHECKING, Any

import numpy as np

from pounding_risk._common.words import nearest, short_list
from pounding_risk.errors import PoundingError, SceneError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.attributes import (
    DAMAGED,
    SCENE_AXES,
    TAKE_ANOTHER,
    VARIANTS,
    as_text,
    read_scene_axes,
    variants_of,
)
from pounding_risk.results.layout import AXES, axes_of_cases
from pounding_risk.results.variables import COORDINATES, PLACES, VARIABLES, described
from pounding_risk.scene.overrides import address_of, override, parts_of
from pounding_risk.scene.scene_axis import UNCERTAIN, SceneAxis, has_gap, labels_of, overrides_at
from pounding_risk.scene.toml import write_toml
from pounding_risk.units import GAP, SHOWN, Quantity, QuantityError, parse, say, shown

if TYPE_CHECKING:
    import xarray as xr

# What is no axis of numbers, and the option that chooses it.
LEVEL_OPTION = "--intensity-level, by commands that take one level"
CHOSEN_BY = {"gap": "--gap", PGA_AXIS: LEVEL_OPTION, LEVEL_AXIS: LEVEL_OPTION}
MAY_LACK = (PGA_AXIS, LEVEL_AXIS)  # a scan of one amplitude has no such axis
SAMPLES = "number of a sample of the uncertain numbers, from 0"  # what the coordinate `sample` is
WITHOUT_PLACES = ("sample",)  # axes along which nothing is drawn or reported place by place
MOTIONS_DRAWN = "motions_drawn"  # the attribute of how many motions those of the samples were drawn from
NEAR = 1e-9  # relative: a value that was written down and read again
FEW = 8  # values of an axis that a sentence lists
CHECKED = ("simulated", "sensitive")  # of how a case was found, not of what came of it


def axis_text(axes: Sequence[SceneAxis]) -> str:
    """The axes as an attribute."""
    return as_text(
        [
            {"keys": list(axis.keys), "values": [list(column) for column in axis.values]}
            | ({"dimension": axis.dimension} if axis.dimension else {})
            for axis in axes
        ]
    )


def axes_of(dataset: xr.Dataset) -> tuple[SceneAxis, ...]:
    """The axes of other numbers of the scene that a dataset was made with; none of another dataset."""
    return read_scene_axes(dataset, _axis_of_entry)


def _axis_of_entry(table: Any) -> SceneAxis:
    """An axis of the attribute; raises ValueError or, as what it is made of, another error where it is damaged."""
    keys, columns, dimension = table["keys"], table["values"], table.get("dimension", "")
    is_sound = (
        isinstance(dimension, str)
        and isinstance(keys, list)
        and len(keys) == len(columns) > 0
        and all(isinstance(key, str) for key in keys)
        and all(isinstance(column, list) and len(column) == len(columns[0]) > 0 for column in columns)
        and all(isinstance(value, str | int | float) for column in columns for value in column)
    )
    if not is_sound:
        raise ValueError("no axis")
    return SceneAxis(tuple(keys), tuple(map(tuple, columns)), dimension)


def check_axes(dataset: xr.Dataset, source: str) -> None:
    """Raise PoundingError unless the axes of a dataset, their labels and what else differs along them fit together."""
    try:
        axes, variants = axes_of(dataset), variants_of(dataset)
    except PoundingError as error:
        raise PoundingError(f"{source}: {error}") from None
    needed = ("attributes", "tables") if axes else ()
    missing = [f"the attribute {VARIANTS} has no {name}" for name in needed if name not in variants]
    faults = [*missing, *_label_faults(dataset, axes), *_variant_faults(variants, tuple(axis.size for axis in axes))]
    if faults:
        raise PoundingError(f"{source}: {'; '.join(faults)}: {DAMAGED}; {TAKE_ANOTHER}")


def _label_faults(dataset: xr.Dataset, axes: Sequence[SceneAxis]) -> Iterator[str]:
    """Faults of the labels of axes that a dataset has; one along which a place was selected need have none."""
    for axis in axes:
        for name, labels in axis.labels().items() if axis.name in dataset.dims else ():
            variable = dataset.variables.get(name)
            if variable is None or variable.dims != (axis.name,):
                yield f"the axis {axis.name} has no labels {name}"
                continue
            # A label is that of its own place, or any where places were selected.
            values, is_complete = labels.values, variable.size == len(labels.values)
            allowed_labels = [values[place : place + 1] if is_complete else values for place in range(variable.size)]
            pairs = zip(variable.values.tolist(), allowed_labels, strict=True)
            is_text = variable.dtype.kind in "UOT"
            is_known = (any(_is_label(label, label_here) for label in allowed) for label_here, allowed in pairs)
            if is_text != isinstance(values[0], str) or not all(is_known):
                yield f"the labels {name} are not those of the attribute {SCENE_AXES}"
            elif str(variable.attrs.get("units")) != str(labels.unit):
                yield f"the labels {name} are in {variable.attrs.get('units')!r}, not in {labels.unit!r}"


def _variant_faults(variants: Mapping[str, list[Any]], shape: tuple[int, ...]) -> Iterator[str]:
    """Faults of what differs along axes of this shape: entries of a name, the axes, and values along these."""
    for variant in chain.from_iterable(variants.values()):
        if not isinstance(variant, list) or len(variant) != 3 or not isinstance(variant[0], str):
            yield f"the attribute {VARIANTS} has an entry without a name, its axes and values"
            continue
        name, along, nested = variant
        is_along = isinstance(along, list) and all(type(axis) is int and 0 <= axis < len(shape) for axis in along)
        if not is_along or not _lies_along(nested, [shape[axis] for axis in along]):
            yield f"the attribute {VARIANTS} has values of {name} that do not lie along its axes"


def _lies_along(nested: Any, shape: Sequence[int]) -> bool:
    """True for lists in lists of these lengths."""
    if not shape:
        return True
    length, *rest = shape
    return isinstance(nested, list) and len(nested) == length and all(_lies_along(inner, rest) for inner in nested)


def axis_coordinates(axes: Iterable[SceneAxis], more: Mapping[str, Mapping[str, Any]]) -> dict[str, Any]:
    """Labels of the axes, as xarray takes them: the values of each key along its dimension.

    ``more`` are attributes of labels, by name.
    """
    coords: dict[str, Any] = {}
    for axis in axes:
        for key, labels in axis.labels().items():
            words = f"value of {key} of the scene" if key in axis.keys else SAMPLES
            attrs = {"long_name": words} if labels.unit is None else described(labels.unit, words)
            coords[key] = (axis.name, list(labels.values), {**attrs, **more.get(key, {})})
    return coords


def open_axes(dataset: xr.Dataset) -> tuple[SceneAxis, ...]:
    """The axes along which a dataset has more than one place."""
    return tuple(axis for axis in axes_of(dataset) if dataset.sizes.get(axis.name, 1) > 1)


def own_places(dataset: xr.Dataset) -> dict[str, int]:
    """Along each axis with several places, the one that has the scene's own values; not of axes that have none."""
    places = {}
    tables: Any = tomllib.loads(str(dataset.attrs.get("scene_resolved", "")))
    entries = {section: entry if isinstance(entry, list) else [entry] for section, entry in tables.items()}
    keys = {section: {key for table in entry for key in table} for section, entry in entries.items()}
    for axis in open_axes(dataset):
        values: dict[str, Any] = {}
        with suppress(SceneError, LookupError, TypeError):
            for key in axis.keys:
                (path, *_) = override(deepcopy(tables), f"{key}=0", keys, "")
                values[key] = labels_of([reduce(getitem, path, tables)]).values[0]
        labels = {key: _labels_along(dataset, key) for key in values}
        for place in range(dataset.sizes[axis.name] if len(values) == len(axis.keys) else 0):
            found = {key: labels[key][place] for key in values}
            if all(type(found[key]) is type(values[key]) and _is_label(found[key], values[key]) for key in values):
                places[axis.name] = place
                break
    return places


def without_effect(dataset: xr.Dataset) -> tuple[str, ...]:
    """The axes along which no output of any case changes, by name; other draws for the tolerance check do not count."""
    outputs = [str(name) for name in dataset.data_vars if name not in CHECKED]
    return idle_axes(dataset, open_axes(dataset), [name for name in outputs if not name.startswith("change_")])


def idle_axes(dataset: xr.Dataset, axes: Iterable[SceneAxis], outputs: Collection[str]) -> tuple[str, ...]:
    """Those of the axes along which none of these outputs changes, by name."""

    def changes(axis: str) -> Iterator[bool]:
        """Read until the first that does."""
        for name in outputs:
            if axis in dataset[name].dims:
                first_values = dataset[name].isel({axis: 0}).values
                for place in range(1, dataset.sizes[axis]):
                    values = dataset[name].isel({axis: place}).values
                    yield not np.array_equal(first_values, values, equal_nan=first_values.dtype.kind == "f")

    return tuple(axis.name for axis in axes if not any(changes(axis.name)))


def along_words(dataset: xr.Dataset) -> list[str]:
    """Each axis with more than one place in words: "building.frame.period: 50 from 0.2 s to 2 s"."""
    return [
        f"{key}: {words_of_values(dataset, key)}"
        for axis in open_axes(dataset)
        for key in ((axis.name,) if axis.dimension else axis.keys)
    ]


def value_at(dataset: xr.Dataset, key: str, place: int) -> str:
    """The value of a key at a place along its axis, in the unit that readers see: "500 t"."""
    coordinate = dataset[key]
    label, unit = np.atleast_1d(coordinate.values)[place], str(coordinate.attrs.get("units", "1"))
    shown_unit, factor = SHOWN.get(unit, (unit, 1.0))
    if coordinate.dtype.kind not in "if":
        return str(label)
    return f"{float(label) * factor:.6g} {shown_unit}".strip()


def has_drawn_motions(dataset: xr.Dataset) -> bool:
    """Whether each sample of a dataset has one motion, drawn with it: its record is a label along the samples."""
    return "record" in dataset.variables and dataset["record"].dims == ("sample",)


def is_drawn_along(dataset: xr.Dataset) -> bool:
    """Whether there are several places along axes, none of which has an assessment of its own."""
    axes = open_axes(dataset)
    return bool(axes) and not any(axis.name in WITHOUT_PLACES for axis in axes)


def check_one_place(dataset: xr.Dataset, source: str = "the dataset") -> None:
    """Raise PoundingError for a dataset with more than one place along an axis, with how to choose one."""
    axes = open_axes(dataset)
    if not axes:
        return
    has = "; ".join(along_words(dataset))
    choices = {axis.name: _label_with_unit(dataset, axis.name, _labels_along(dataset, axis.name)[0]) for axis in axes}
    options = " ".join(f"--select '{name}={choice}'" for name, choice in choices.items())
    labels = ", ".join(f'"{axis.name}": {_labels_along(dataset, axis.name)[0]!r}' for axis in axes)
    raise PoundingError(
        f"{source}: has cases along {has}; this is of one value of each: choose with {options}, in Python with "
        f"results.sel({{{labels}}})"
    )


def at_one_place(dataset: xr.Dataset, source: str = "the dataset") -> xr.Dataset:
    """The dataset of the scene at the one place along every axis, without them; any other dataset as it is.

    Raises PoundingError where there is more than one place, or where the label of an axis is lost.
    """
    axes = axes_of(dataset)
    if not axes:
        return dataset
    check_one_place(dataset, source)
    lost = [axis.name for axis in axes if axis.name not in dataset.variables]
    if lost:
        raise PoundingError(
            f"{source}: has lost its {' and '.join(lost)}: select without drop=True, so that it is known what was "
            "selected"
        )
    places = [_place_of_label(dataset, axis, source) for axis in axes]
    is_drawn = "record" not in dataset.dims and MOTIONS_DRAWN in dataset.attrs
    part = dataset.isel({axis.name: 0 for axis in axes if axis.name in dataset.dims})
    part = part.drop_vars([key for axis in axes for key in axis.names if key in part.variables])
    try:
        part.attrs = _attributes_of_scene(dataset, axes, places)
    except (TypeError, ValueError, LookupError, AttributeError, RecursionError):  # of tables that are none too
        fault = f"the attributes {VARIANTS} and scene_resolved cannot be read together"
        raise PoundingError(f"{source}: {fault}: {DAMAGED}") from None
    part = _under_its_motion(part) if is_drawn else part
    return _with_drawn_gap(part) if any(axis.dimension and has_gap(axis.keys) for axis in axes) else part


def _under_its_motion(part: xr.Dataset) -> xr.Dataset:
    """The dataset of one sample whose motion was drawn.

    Its record and polarity are labels without an axis, as of a dataset of all motions of which one was selected. Where
    its scene names that record alone its attributes have nothing of the others.
    """
    name = str(part["record"].item())
    attrs = {str(key): attribute for key, attribute in part.attrs.items() if key != MOTIONS_DRAWN}
    is_named = tomllib.loads(str(attrs.get("scene_resolved", ""))).get("records", {}).get("names") == [name]
    if is_named:
        attrs["records"] = as_text([record for record in json.loads(attrs["records"]) if record.get("name") == name])
    for key in ("processing", "motions_sha256"):
        if is_named and key in attrs:
            attrs[key] = as_text({record: fact for record, fact in json.loads(attrs[key]).items() if record == name})
    recording = part["record_recording"].variable
    part = part.assign_coords(record_recording=recording.copy(data=np.zeros_like(recording.values)))
    part.attrs = attrs
    return part


def _with_drawn_gap(part: xr.Dataset) -> xr.Dataset:
    """The dataset of one sample of which a gap was drawn, with the gap of its scene in place of the stated one."""
    grid_gaps = tomllib.loads(str(part.attrs["scene_resolved"])).get("grid", {}).get("gap", ())
    if len(grid_gaps) != 1 or "gap" not in part.coords:
        return part
    gap = parse(grid_gaps[0], GAP)
    label = part["gap"].variable
    part = part.assign_coords(gap=label.copy(data=np.full(label.shape, gap)))
    if "interface_gap" in part.coords and (part["interface_gap"].values == gap).all():
        part = part.drop_vars("interface_gap")  # which a scan of one sample has where interfaces differ
    return part


def _place_of_label(dataset: xr.Dataset, axis: SceneAxis, source: str) -> int:
    """The place along an axis whose labels the dataset has left."""
    labels = axis.labels()
    labels_left = {key: np.atleast_1d(dataset[key].values)[0] for key in axis.names if key in dataset.variables}
    for place in range(axis.size):
        if all(_is_label(labels[key].values[place], label) for key, label in labels_left.items()):
            return place
    raise PoundingError(f"{source}: {axis.name} has a value that is none of the scan's: the dataset was changed")


def _is_label(label: Any, other: Any) -> bool:
    if isinstance(label, str):
        return label == str(other)
    return bool(label == other or isclose(label, float(other), rel_tol=NEAR))


def _attributes_of_scene(dataset: xr.Dataset, axes: Sequence[SceneAxis], places: Sequence[int]) -> dict[str, Any]:
    """The attributes of a scan of the scene at a place along every axis."""
    attrs = {str(name): attribute for name, attribute in dataset.attrs.items() if name not in (SCENE_AXES, VARIANTS)}
    variants = variants_of(dataset)
    for name, along, nested in variants.get("attributes", ()):
        attribute = at_places(along, nested, places)
        attrs.pop(name, None) if attribute is None else attrs.update({name: attribute})
    if "scene_resolved" in attrs:
        tables = tomllib.loads(str(attrs["scene_resolved"]))
        for key in ("zip", *(key for axis in axes for key in axis.keys)):
            tables.get("grid", {}).pop(key, None)
        tables.pop(UNCERTAIN, None)
        for path, along, nested in variants.get("tables", ()):
            _set_scene_value(tables, json.loads(path), at_places(along, nested, places))
        attrs["scene_resolved"] = write_toml(tables)
        attrs["scene_sha256"] = sha256(attrs["scene_resolved"].encode()).hexdigest()
    attrs["overrides"] = as_text([*json.loads(attrs.get("overrides", "[]")), *overrides_at(axes, places)])
    return attrs


def at_places(along: Sequence[int], nested: Any, places: Sequence[int]) -> Any:
    """A value of `along.Stack.differing`, as nested lists, at a place along every axis."""
    for axis in along:
        nested = nested[places[axis]]
    return nested


def _set_scene_value(tables: Any, path: Sequence[Any], setting: Any) -> None:
    """Set a value in nested tables by its path, or remove it where it is None."""
    *above, last = path
    table = reduce(getitem, above, tables)
    if setting is None:
        table.pop(last, None)
    else:
        table[last] = setting


# -------------------------------------------------------------------------------------- axes of selected values


def with_axes(dataset: xr.Dataset, source: str = "the dataset") -> xr.Dataset:
    """The dataset with every axis of its cases and places; unchanged where none is missing, or it is not of `scan`.

    Axes are of length 1 where ``sel`` or ``isel`` took one value. At one value along each axis of another number of the
    scene it is the dataset of the scene which has these values. Where some interfaces of a row were selected, the
    contact points are those of these alone. Raises PoundingError where the label of an axis is lost (``drop=True``),
    where there are several values along an axis of another number of the scene, and where the buildings or interfaces
    that are left do not stand side by side.
    """
    if not {"impact_count", "contact_model"} <= set(dataset.variables):
        return dataset
    dataset = at_one_place(dataset, source)
    _check_buildings(dataset, source)
    if "interface" not in {*dataset.dims, *dataset.coords} and dataset.sizes.get("building") == 2:
        dataset = dataset.assign_coords(interface=" | ".join(map(str, dataset["building"].values)))
    axes = axes_of_cases(dataset)
    lost = [axis for axis in axes if axis not in {*dataset.dims, *dataset.coords} and axis not in MAY_LACK]
    if lost:
        raise PoundingError(
            f"{source}: has lost its {' and '.join(lost)}: select with a list, such as {lost[0]}=[...], or without "
            "drop=True, so that it is known what was selected"
        )
    missing_dims = [dim for dim in (*axes, *PLACES) if dim in dataset.coords and dim not in {*dataset.dims, *MAY_LACK}]
    if not missing_dims:
        return _with_own_points(dataset)
    if misplaced := [axis for axis in missing_dims if dataset[axis].ndim]:
        raise PoundingError(
            f"{source}: the labels of {', '.join(misplaced)} lie along another dimension; run the scan again"
        )
    rest = dataset.drop_vars(missing_dims)
    variables: dict[Any, Any] = {}
    for name, variable in rest.variables.items():
        added_dims = [dim for dim in missing_dims if dim in _dims_of_output(str(name), name in rest.coords)]
        sizes: dict[Any, int] = dict.fromkeys(added_dims, 1) | dict(variable.sizes)
        ordered = dict.fromkeys([*(dim for dim in (*axes, *PLACES) if dim in sizes), *variable.dims])
        variables[name] = variable.set_dims({dim: sizes[dim] for dim in ordered}) if added_dims else variable
    coords: dict[Any, Any] = {name: variables[name] for name in rest.coords if name not in rest.dims}
    coords |= {axis: dataset[axis].variable.set_dims({axis: 1}) for axis in missing_dims}
    return _with_own_points(rest.assign({name: variables[name] for name in rest.data_vars}).assign_coords(coords))


def _dims_of_output(name: str, is_coordinate: bool) -> tuple[str, ...]:
    """The dimensions of a variable of this name; those of one that is not declared are axes of cases."""
    declared = (VARIABLES | COORDINATES).get(name)
    if declared is not None:
        return declared.dims
    if is_coordinate:
        return ()
    return AXES[:3] if name.endswith("_free") else AXES


def _with_own_points(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset without the contact points of other interfaces, where neighbours were selected from a row."""
    if not {"interface", "contact_point"} <= set(dataset.dims):
        return dataset
    try:
        count, places = dataset.sizes["interface"], dataset["contact_point_interface"]
        if places.values.max(initial=0) < count:  # it has no others
            return dataset
        tables = tomllib.loads(str(dataset.attrs["scene_resolved"]))["building"]
        start = [str(table.get("name")) for table in tables].index(str(dataset["building"].values[0]))
    except (LookupError, TypeError, ValueError, AttributeError, RecursionError):
        return dataset  # `check_scan` reports it
    own_points = np.flatnonzero((places.values >= start) & (places.values < start + count))
    return dataset.isel(contact_point=own_points).assign_coords(
        contact_point_interface=("contact_point", places.values[own_points] - start, places.attrs)
    )


def _check_buildings(dataset: xr.Dataset, source: str) -> None:
    """Refuse a selection of buildings and interfaces that do not stand side by side."""
    count = dataset.sizes.get("building", 1)
    if count < 2:
        raise PoundingError(
            f"{source}: has one building left, and a gap is between two: select two neighbours, such as "
            "building=slice(0, 2)"
        )
    interfaces = dataset.sizes.get("interface", 1 if "interface" in dataset.coords else count - 1)
    if interfaces != count - 1:
        raise PoundingError(
            f"{source}: has {count} buildings and {interfaces} of the {count - 1} interfaces between them: select the "
            "buildings on both sides of each interface too, such as building=slice(0, 2) with interface=[0]"
        )


# ------------------------------------------------------------------------------------------------ choosing


def selected(dataset: xr.Dataset, choices: Sequence[str], source: str = "the dataset") -> xr.Dataset:
    """The dataset at the values that are chosen, such as "building.frame.period=0.5 s".

    A number without a unit is in SI. Raises PoundingError for what is no axis, and for a value that it has not.
    """
    for text in choices:
        key_text, equals, value_text = text.partition("=")
        if not equals:
            raise PoundingError(f"--select {shown(text)} is not axis=value; write building.frame.period=0.5")
        key = address_of(parts_of(key_text)) or key_text.strip()
        axis = next((axis for axis in axes_of(dataset) if key in axis.names), None)
        if axis is None:
            names = [name for axis in axes_of(dataset) for name in axis.names]
            names_text = f"it has {', '.join(names)}" if names else "it has none"
            names_text += f"; {key} is chosen by {CHOSEN_BY[key]}" if key in CHOSEN_BY else ""
            raise PoundingError(f"--select {key}: {source} has no such axis{nearest(key, names)}; {names_text}")
        place = _place_of_choice(dataset, key, value_text.strip())
        dataset = dataset.isel({axis.name: [place]} if axis.name in dataset.dims else {})
    return dataset


def overrides_of(axes: Sequence[SceneAxis], choices: Sequence[str], source: str) -> tuple[str, ...]:
    """What `--set` takes for the values that are chosen along axes of a scene; raises as `selected`."""
    import xarray as xr

    dataset = xr.Dataset(coords=axis_coordinates(axes, {}), attrs={SCENE_AXES: axis_text(axes)})
    part = selected(dataset, choices, source)
    single = [axis for axis in axes if part.sizes[axis.name] == 1]
    return tuple(text for axis in single for text in axis.overrides(_place_of_label(part, axis, source)))


def title_at(dataset: xr.Dataset, choices: Sequence[str]) -> xr.Dataset:
    """The dataset with the values that were chosen in its title."""
    words = ", ".join(text.replace("=", " = ", 1) for text in choices)
    return dataset.assign_attrs(title=f"{dataset.attrs.get('title', '')} ({words})")


def _place_of_choice(dataset: xr.Dataset, key: str, text: str) -> int:
    """Index along a dimension of the value that is asked for."""
    labels, unit = _labels_along(dataset, key), dataset[key].attrs.get("units")
    value: Any = text.strip("\"'")
    if unit is not None:
        try:
            value = float(value)
        except ValueError:
            quantity = Quantity(str(unit).replace("m/s2", "m/s^2"), -inf, inf, "value")
            try:
                value = parse(value, quantity)
            except QuantityError as error:
                raise PoundingError(f"--select {key}: {error}") from None
    places = [place for place, label in enumerate(labels) if _is_label(label, value)]
    if not places:
        raise PoundingError(
            f"--select {key}: {text} is none of its values; it has {words_of_values(dataset, key, value)}"
        )
    if len(places) > 1:
        raise PoundingError(f"--select {key}: {len(places)} places have {text}; choose by another key of the axis")
    return places[0]


def _labels_along(dataset: xr.Dataset, key: str) -> list[Any]:
    return np.atleast_1d(dataset[key].values).tolist()


def words_of_values(dataset: xr.Dataset, key: str, near: Any = None) -> str:
    """The values of an axis: all where they are few, otherwise how many, the ends, and those next to one."""
    labels, words = _labels_along(dataset, key), written_values(dataset, key)
    ends = short_list(words, FEW)
    if len(words) <= FEW or not isinstance(near, float):
        return ends
    nearest_places = sorted(sorted(range(len(labels)), key=lambda place: abs(labels[place] - near))[:2])
    return f"{ends} (next to it are {', '.join(words[place] for place in nearest_places)})"


def written_values(dataset: xr.Dataset, key: str) -> list[str]:
    """The values of a key along its axis, with their unit."""
    return [_label_with_unit(dataset, key, label) for label in _labels_along(dataset, key)]


def _label_with_unit(dataset: xr.Dataset, key: str, label: Any) -> str:
    """A value of an axis in the unit that an engineer writes, exact enough to be chosen by: 4 MN s/m."""
    unit = str(dataset[key].attrs.get("units", "1")).replace("m/s2", "m/s^2")
    return label if isinstance(label, str) else say(label, Quantity(unit, -inf, inf, "value"), 10)
