"""Explorer of a scan's results: one HTML file that holds data and scripts, and fetches nothing.

Numbers are float32 (seven digits), one compressed array a variable; what the page shows of all motions together it
computes from them. It needs the dataset and Plotly, no solver. The module is not called ``view``, because the package
has a function of that name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk._common.words import listed
from pounding_risk._common.written import write_file
from pounding_risk.assessment.demands import finite_forces
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS, read_measure, say_level
from pounding_risk.reports.html import packed, script_page
from pounding_risk.results import check as form
from pounding_risk.results.amplitudes import axis_words
from pounding_risk.results.attributes import bumper_words, gaps_needed, isolated_notes, status_sentences
from pounding_risk.results.check import kind_of, missing_named
from pounding_risk.results.files import check_target, opened_or_given
from pounding_risk.results.layout import amplitude_axis
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import (
    axes_of,
    has_drawn_motions,
    open_axes,
    own_places,
    with_axes,
    written_values,
)
from pounding_risk.results.variables import NOT_RUN, UNPUSHED
from pounding_risk.scene.scene_axis import SAMPLE, SceneAxis
from pounding_risk.units import SHOWN, STANDARD_GRAVITY, rounded, si

MOST_CASES = 200_000  # a page of more is slow to open
COLUMNS = "columns' own"  # F_E where floors never yield and columns have one
MAP = ("gap", "yield_force")  # the axes of the heat map
MOTIONS = ("record", "polarity")  # axes of which the page shows one, or all together
STATES = ("status", "simulated", "sensitive")  # of each case; the page says them in words
MOST_OF_STOREYS = 1_500_000  # numbers of storey profiles; a page leaves them out where there are more
PROFILES = {"storey_drift": True, "storey_shear": True, "storey_acceleration": False, "storey_displacement": False}
SHARES = ("contact", "yield_exceedance")  # 0 or 1; of several motions, a share
OF_LEVELS = ("floor_level", "contact_point_level")
NO_CASE = ("gap", "yield_force", "contact_model")  # what a quantity without contact does not depend on
OPTIONS = {"record": "--record", "contact_model": "--contact-model", PGA_AXIS: "--pga", LEVEL_AXIS: "--intensity-level"}
TITLES = {PGA_AXIS: "amplitude", "contact_model": "contact model", "yield_force": "yield force F_E"}


@missing_named()
def view(
    results: str | Path | xr.Dataset,
    out: str | Path,
    *,
    records: Sequence[str] = (),
    contact_models: Sequence[str] = (),
    pgas: Sequence[float | str] = (),
    intensity_levels: Sequence[float | str] = (),
) -> Path:
    """Write a page to look around in a scan's results, offline.

    A place along axes of numbers of its scene is chosen there.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or the file it is in.
    out : str or Path
        The page, .html.
    records : sequence of str
        Names of the records to show; all by default.
    contact_models : sequence of str
        Names of the contact models to show; all by default.
    pgas : sequence of float or str
        Amplitudes to show [m/s2, or text with a unit]; all by default.
    intensity_levels : sequence of float or str
        The same in the measure of the grid [SI, or text with a unit], where that may be another than PGA.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    PoundingError
        For what is no scan's results, for a name or amplitude that it does not hold, for more than `MOST_CASES` cases,
        where Plotly is missing, and for an ``out`` that cannot be written.
    """
    target = check_target(out, (".html",))
    dataset, source = opened_or_given(results, "the dataset")
    # All places along axes of numbers of the scene, unless each sample has its own motion: there is no list of these.
    if kind_of(dataset) not in ("scan", "") or not open_axes(dataset) or has_drawn_motions(dataset):
        dataset = with_axes(dataset, source)
    check_scan(dataset, source)
    amplitudes = Results(dataset).amplitudes
    if pgas and (intensity_levels or amplitudes.axis != PGA_AXIS):
        raise PoundingError(
            f"pgas: the motions are scaled to {amplitudes.measure.words}; choose by intensity_levels "
            "(--intensity-level) alone"
        )
    name = "pgas" if pgas else "intensity_levels"
    levels = [si(level, amplitudes.measure.quantity, name) for level in (*pgas, *intensity_levels)]
    part = chosen(dataset, {"record": records, "contact_model": contact_models, amplitudes.axis: levels}, source)
    _check_size(part, source)
    plotly = _plotly()
    page = script_page("explorer_page", page_model(part), plotly, plotly=plotly, pictures=row_pictures(part))
    return write_file(target, page)


def check_scan(dataset: xr.Dataset, source: str) -> None:
    """Raise PoundingError unless the dataset is what `scan` writes."""
    missing = [name for name in ("status", "impact_count") if name not in dataset]
    if missing := missing or [name for name in MAP if name not in dataset.coords]:
        raise PoundingError(
            f"{source}: has no {missing[0]}, so it is not a scan's results; `pounding-risk scan SCENE -o results.nc` "
            "writes such a file"
        )
    form.check_scan(dataset, source, names=(*form.AXES_OF_CASES, "simulated", "building"), attrs=("rtol",))


def chosen(dataset: xr.Dataset, selection: Mapping[str, Sequence[Any]], source: str) -> xr.Dataset:
    """The part of a dataset with these values along these axes, the axes kept; all of an axis where none is given.

    Raises PoundingError for a value that is not there.
    """
    for axis, wanted in selection.items():
        if len(wanted) == 0:
            continue
        labels = np.atleast_1d(dataset[axis].values) if axis in dataset.coords else np.empty(0)
        indices = [_place(Results(dataset).axis_name(axis), label, labels, source) for label in wanted]
        if axis in dataset.dims:
            dataset = dataset.isel({axis: sorted(set(indices))})
    return dataset


def _place(axis: str, label: Any, labels: np.ndarray, source: str) -> int:
    """Index of a value on an axis; amplitudes are equal where they agree to six digits."""
    number = isinstance(label, float)
    equal = np.isclose(labels.astype(float), label, rtol=1e-6, atol=0.0) if number and labels.size else labels == label
    if np.any(equal):
        return int(np.argmax(equal))
    names = [label_words(axis, label) for label in labels]
    near = [] if number else get_close_matches(str(label), names, 1, 0.6)
    meant = f"; did you mean {near[0]}?" if near else ""
    raise PoundingError(
        f"{source}: holds no {TITLES.get(axis, axis_words(axis))} {label_words(axis, label)}; it holds "
        f"{listed(names, 8) or 'none'}{meant}"
    )


def _check_size(dataset: xr.Dataset, source: str) -> None:
    """Raise PoundingError for more cases than a page can hold, with a part that it can."""
    cases = left = dataset["status"].size * dataset.sizes.get("interface", 1)
    if cases <= MOST_CASES:
        return
    long_axes = {axis: option for axis, option in OPTIONS.items() if dataset.sizes.get(axis, 1) > 1}
    selection = []
    for axis, option in long_axes.items():
        if left > MOST_CASES:
            label = label_words(Results(dataset).axis_name(axis), dataset[axis].values[0])
            selection.append(f'{option} "{label}"' if " " in label else f"{option} {label}")
            left //= dataset.sizes[axis]
    hint = "choose a place along an axis with --select" if open_axes(dataset) else "scan fewer gaps or yield forces"
    if left <= MOST_CASES:
        hint = f"choose a part with {' or '.join(long_axes.values())}, such as {' '.join(selection)} ({left:,} cases)"
    scope = " of all interfaces" if dataset.sizes.get("interface", 1) > 1 else ""
    raise PoundingError(
        f"{source}: {cases:,} cases{scope} are more than the {MOST_CASES:,} that a page can hold; {hint}"
    )


def page_model(dataset: xr.Dataset) -> dict[str, Any]:
    """The data of the page: axes with their labels, and every variable as a compressed array (see `packed`)."""
    dataset = _prepared(dataset)
    pickers = [str(dim) for dim in dataset["status"].dims if dim not in MAP]
    # Of a row the page shows one interface and the two buildings beside it.
    pickers += [dim for dim in ("interface",) if dim in dataset.dims and dim not in pickers]
    axes = [*pickers, *MAP, *(dim for dim in ("building",) if dim in dataset.dims)]
    return {
        "title": str(dataset.attrs.get("title") or "Results of a scan"),
        "facts": _facts(dataset),
        "scene": str(dataset.attrs.get("scene", "")),
        "axes": [_axis(dataset, axis) for axis in axes],
        "pickers": pickers,
        "start": Results(dataset).scene_case | own_places(dataset),
        "together": [axis for axis in pickers if axis in MOTIONS],
        "statuses": {str(code): words for code, words in status_sentences(dataset["status"]).items()},
        "states": {name: _variable(dataset[name], axes) for name in STATES if name in dataset},
        "outputs": [_variable(dataset[name], axes) for name in _outputs(dataset, axes)],
        "profiles": _profiles(dataset, axes),
    }


def _profiles(dataset: xr.Dataset, axes: Sequence[str]) -> dict[str, Any] | None:
    """Quantities of storeys, with contact and without; None where there are none, or too many."""
    if not _has_profiles(dataset):
        return None
    deep = [*axes, "storey"]
    floors_of = dataset["floor_level"].transpose("building", "storey").values
    levels = [[float(level) for level in floors if np.isfinite(level)] for floors in floors_of]
    points = zip(dataset["contact_point_interface"].values, dataset["contact_point_level"].values, strict=True)
    return {
        "levels": levels,
        "points": [[int(index), float(level)] for index, level in points if np.isfinite(level)],
        "quantities": [
            {"of_storey": storey_name}
            | {kind: _variable(dataset[name + ending], deep) for kind, ending in (("struck", ""), ("free", "_free"))}
            for name, storey_name in PROFILES.items()
            if name in dataset and f"{name}_free" in dataset
        ],
        "storeys": dataset.sizes["storey"],
    }


def _has_profiles(dataset: xr.Dataset) -> bool:
    """True for a row with storeys whose profiles are few enough, and whose levels are the same at all places."""
    if any(dim in dataset[name].dims for name in OF_LEVELS if name in dataset for dim in axes_by_name(dataset)):
        return False
    names = [name for name in PROFILES if name in dataset]
    return bool(names) and sum(dataset[name].size for name in names) <= MOST_OF_STOREYS


def _prepared(dataset: xr.Dataset) -> xr.Dataset:
    """The dataset with both axes of the map, and whether there was contact as an output of its own.

    The only interface of two buildings without storeys is nothing to choose.
    """
    dataset = dataset.expand_dims([dim for dim in MAP if dim not in dataset.dims])
    if dataset.sizes.get("interface") == 1 and not any(name in dataset for name in PROFILES):
        dataset = dataset.squeeze("interface", drop=True)
    count = dataset["impact_count"]
    touches = count.where(count < 0, count > 0).astype(np.int8)
    touches.attrs = {"units": "1", "long_name": "whether the buildings touch"}
    gaps = gaps_needed(dataset).assign_attrs(dataset["peak_closing_free"].attrs)
    return dataset.assign(contact=touches, peak_closing_free=gaps)


def _outputs(dataset: xr.Dataset, axes: Sequence[str]) -> list[str]:
    """Outputs of each case, whether there was contact first; then those of each motion without contact."""
    dims = {str(name): set(variable.dims) for name, variable in dataset.data_vars.items()}
    names = [name for name, own in dims.items() if set(MAP) <= own <= set(axes)]
    without = [name for name, own in dims.items() if name.endswith("_free") and own and own <= set(axes) - set(NO_CASE)]
    return ["contact", *(name for name in names if name not in ("contact", *STATES)), *without]


def _variable(variable: xr.DataArray, axes: Sequence[str]) -> dict[str, Any]:
    variable = variable.transpose(*(axis for axis in axes if axis in variable.dims))
    unit, factor = SHOWN.get(str(variable.attrs.get("units", "1")), (str(variable.attrs.get("units")), 1.0))
    kind = "f4" if variable.dtype.kind == "f" else "i4"
    return {
        "name": str(variable.name),
        "words": str(variable.attrs.get("long_name", "")),
        "unit": unit,
        "factor": factor,
        "share": variable.name in SHARES,
        "dims": list(variable.dims),
        "kind": kind,
        "data": packed(variable.values, kind),
    }


def _axis(dataset: xr.Dataset, axis: str) -> dict[str, Any]:
    labels = dataset[axis].values if axis in dataset.coords else np.arange(dataset.sizes[axis])
    units = {"gap": "mm", "yield_force": "kN"}
    words = [label_words(Results(dataset).axis_name(axis), label) for label in labels]
    if axis in (scene_axes := axes_by_name(dataset)):  # with the values that move with it
        # The first is named by the axis; samples by their number.
        moving = [
            [label if key == axis else f"{key} {label}" for label in written_values(dataset, key)]
            for key in scene_axes[axis].keys
        ]
        words = [", ".join(row) for row in zip(*([words] if axis == SAMPLE else []), *moving, strict=True)]
    if axis == "yield_force" and np.isinf(finite_forces(dataset)).any():
        words = [COLUMNS if word == "none" else word for word in words]
    has_notes = axis == "record" and "record_event" in dataset.coords
    return {
        "name": axis,
        "title": Results(dataset).measure.words if axis == LEVEL_AXIS else TITLES.get(axis, axis.replace("_", " ")),
        "is_number": axis in scene_axes,
        "unit": units.get(axis, ""),
        "labels": words,
        "notes": [str(note) for note in dataset["record_event"].values] if has_notes else [],
    }


def axes_by_name(dataset: xr.Dataset) -> dict[str, SceneAxis]:
    """The axes of numbers of the scene that the dataset has as dimensions."""
    return {axis.name: axis for axis in axes_of(dataset) if axis.name in dataset.dims}


def label_words(axis: str, label: Any) -> str:
    """Label of a value on an axis: gaps in mm, yield forces in kN or "none", amplitudes in g.

    Levels of another measure, whose axis goes by its word, have their unit.
    """
    if not isinstance(label, float):
        return str(label)
    if axis == "yield_force":
        return "none" if np.isinf(label) else f"{label / 1e3:.6g}"
    if axis == "gap":
        return f"{label * 1e3:.6g}"
    if axis == "pga":
        return "as recorded" if np.isnan(label) else f"{label / STANDARD_GRAVITY:.6g} g"
    measure = read_measure(axis)
    return f"{label:.6g}" if measure is None else say_level(label, measure.quantity)


def _facts(dataset: xr.Dataset) -> list[str]:
    """Sentences at the head of the page on cases, failures and checks."""
    status = dataset["status"]
    facts = [f"{status.size:,} cases."]
    if amplitude_axis(dataset) not in dataset.dims:
        facts.append(f"Motions {Results(dataset).amplitude_words()}.")
    if "rtol" in dataset.attrs:
        facts.append(f"Each case to a relative tolerance of {rounded(float(dataset.attrs['rtol']))}.")
    if "sensitive" in dataset:
        checked, sensitive = int((dataset["sensitive"] >= 0).sum()), int((dataset["sensitive"] == 1).sum())
        facts.append(f"{checked:,} recomputed at a tighter tolerance, {sensitive:,} of them sensitive to it.")
    if "interface_bumper" in dataset.variables:
        facts.append(
            f"Closings and gaps required count the {bumper_words(np.unique(dataset['interface_bumper']).tolist())}."
        )
    facts += _facts_of_places(dataset)
    unpushed = int((status == UNPUSHED).sum())
    failed = int((status != 0).sum()) - unpushed
    if failed:
        facts.append(f"{failed:,} failed: marked × and counted in no number.")
    if unpushed:
        facts.append(f"{unpushed:,} {NOT_RUN}: marked × and counted in no number.")
    return facts


def _facts_of_places(dataset: xr.Dataset) -> list[str]:
    sentences = []
    gap_array = dataset.get("interface_gap")
    drawn_dims = [dim for dim in axes_by_name(dataset) if gap_array is not None and dim in gap_array.dims]
    if drawn_dims:
        origin = "those of the scene"
        if "interface" in dataset.dims:
            origin = f"the scene's own of {dataset['interface'].values[Results(dataset).varied_interface]}"
        sentences.append(f"Each place along {', '.join(drawn_dims)} has gaps of its own; the axis gap has {origin}.")
    elif gap_array is not None:
        gaps = gap_array.transpose("gap", "interface").values
        varied = [str(name) for name in dataset["interface"].values[np.ptp(gaps, axis=0) > 0.0]]
        origin = f"that of {varied[0]}; the others keep" if varied else "that of the first interface; each keeps"
        sentences.append(f"The gap is {origin} {'their' if varied else 'its'} own.")
    if "column" in dataset.get("contact_point_kind", np.empty(0)):
        sentences.append("The yield force is that of contacts between floors; those with a column have the column's.")
    sentences += isolated_notes(dataset)
    if any(name in dataset for name in PROFILES) and not _has_profiles(dataset):
        sentences.append(
            "Storey profiles are left out, there are too many; choose fewer records or models to see them."
            if not open_axes(dataset)
            else "Storey profiles are left out; choose one place with --select to see them."
        )
    if "contact_point_impact_count" in dataset and open_axes(dataset):
        sentences.append("The drawings of the row are left out; choose one place with --select to see them.")
    return sentences


def row_pictures(dataset: xr.Dataset) -> str:
    """The row in elevation and in plan, over all motions, as a part of the page; nothing without contact points.

    Nor with several places along axes of numbers of the scene.
    """
    if "contact_point_impact_count" not in dataset or open_axes(dataset):
        return ""
    from pounding_risk.assessment.row import row_case
    from pounding_risk.figures.row import elevation_figure, plan_figure
    from pounding_risk.figures.style import svg_text

    case = row_case(dataset)
    drawings = [f"<figure>{svg_text(draw(case))}</figure>" for draw in (elevation_figure, plan_figure)]
    heading = '<h2 id="row-head">The row, over all motions: the scene\'s own gap and yield force</h2>'
    return "\n".join(['<section id="row" aria-labelledby="row-head">', heading, *drawings, "</section>"])


def _plotly() -> str:
    try:
        from plotly.offline import get_plotlyjs
    except ImportError:
        raise PoundingError("view needs Plotly, which is not installed; pip install 'pounding-risk[view]'") from None
    return get_plotlyjs()
