"""Samples of uncertain numbers that a finished dataset of the same scene has already: only the rest is solved."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk.ensemble.chunks import Chunk
from pounding_risk.ensemble.identity import difference
from pounding_risk.ensemble.replacing import OTHER_NAME, comparable, read_finished, recorded_identity
from pounding_risk.errors import PoundingError
from pounding_risk.results.attributes import scene_dims, variants_of
from pounding_risk.results.files import stream_results
from pounding_risk.results.layout import AMPLITUDE, Template, amplitude_axis, axes_of_cases
from pounding_risk.results.scene_axes import at_places, axes_of, has_drawn_motions
from pounding_risk.scene.scene_axis import SAMPLE, UNCERTAIN, SceneAxis
from pounding_risk.scene.uncertain import GROWING

BYTES = 64e6  # of the samples that are read at once
REPLACE = f"{OTHER_NAME}, or replace it (--new, or new=True in Python)"
TABLES = ("scene", "records", "options", "program", "laws")  # of an identity, all of which a dataset must tell


def samples_before(target: Path, identity: Mapping[str, Any]) -> int:
    """How many samples the finished scan at ``target`` has of a scene that now asks for more; 0 where there is none.

    Raises PoundingError where no samples can be added to them.
    """
    requested = identity.get("scene", {}).get(UNCERTAIN, {})
    if "samples" not in requested or not target.exists():
        return 0
    finished = read_finished(target)
    recorded = recorded_identity(finished.attrs) if finished.command == "scan" else {}
    old_table = recorded.get("scene", {}).get(UNCERTAIN, {})
    count = old_table.get("samples", 0) if set(TABLES) <= set(recorded) else 0
    if not isinstance(count, int) or not 0 < count < requested["samples"]:
        return 0
    scene = {**identity["scene"], UNCERTAIN: {**requested, "samples": count}}
    if difference(recorded, {name: comparable({**identity, "scene": scene})[name] for name in TABLES}):
        return 0
    if requested["method"] not in GROWING:
        raise PoundingError(
            f"{target}: holds {count} samples of the same scene, to which none can be added: the points of a "
            f'{requested["method"]} of {requested["samples"]} are others; write method = "{GROWING[0]}" in [uncertain] '
            f"next time, and now {REPLACE}"
        )
    return count


class KnownSamples:
    """The cases of a finished dataset, by place along the axes of the scene; to be closed after use."""

    def __init__(self, dataset: xr.Dataset, target: Path):
        self._dataset, self._target = dataset, target
        self._axes = [axis.name for axis in axes_of(dataset)]
        self._variants = {name: (along, nested) for name, along, nested in variants_of(dataset).get("attributes", [])}
        self.count = dataset.sizes[SAMPLE]
        size = sum(variable.nbytes for variable in dataset.data_vars.values())
        self._step = max(1, int(BYTES * self.count / max(size, 1)))
        self._span = range(0)
        self._arrays: dict[str, tuple[tuple[str, ...], np.ndarray]] = {}

    def has(self, places: Mapping[str, int]) -> bool:
        """True for a place whose cases it has."""
        return places[SAMPLE] < self.count

    def cases(self, places: Mapping[str, int], template: Template) -> Chunk:
        """Every case variable of the scene at a place: (batches, cases in a batch, own dimensions)."""
        width = template.width
        return {name: self._at(name, places).reshape(-1, width, *template.extra(name)) for name in template.cases}

    def free(self, places: Mapping[str, int], names: Iterable[str]) -> dict[str, np.ndarray]:
        """These variables of motions without contact: (record, polarity, amplitude, own dimensions)."""
        arrays = {name: self._at(name, places) for name in names}
        if has_drawn_motions(self._dataset):  # one record and one polarity, which are no axes
            arrays = {name: array[None, None] for name, array in arrays.items()}
        if amplitude_axis(self._dataset) in self._dataset.dims:
            return arrays
        return {name: np.expand_dims(array, AMPLITUDE) for name, array in arrays.items()}

    def attribute(self, name: str, places: Mapping[str, int]) -> Any:
        """An attribute that differs from scene to scene; None where the dataset has none of this name."""
        along, nested = self._variants.get(name, ((), None))
        return at_places(along, nested, [places[axis] for axis in self._axes])

    def _at(self, name: str, places: Mapping[str, int]) -> np.ndarray:
        """The values of a variable at a place; neighbouring samples are read with it."""
        sample = places[SAMPLE]
        if sample not in self._span:
            start = sample - sample % self._step
            self._span, self._arrays = range(start, min(start + self._step, self.count)), {}
        if name not in self._dataset.variables:
            sentence = f"has no variable {name}, so that it was damaged or changed and no samples can be added"
            raise PoundingError(f"{self._target}: {sentence}; {REPLACE}")
        if name not in self._arrays:
            variable = self._dataset[name].variable
            if SAMPLE in variable.dims:
                variable = variable.isel({SAMPLE: slice(self._span.start, self._span.stop)})
            self._arrays[name] = tuple(map(str, variable.dims)), np.asarray(variable.values)
        dims, array = self._arrays[name]
        indices = {**places, SAMPLE: sample - self._span.start}
        return array[tuple(indices[dim] for dim in dims if dim in indices)]

    def close(self) -> None:
        """Close the dataset, so that it can be replaced."""
        self._arrays, self._span = {}, range(0)
        self._dataset.close()


def known_samples(
    target: Path, identity: Mapping[str, Any], axes: Iterable[SceneAxis], shape: tuple[int, ...]
) -> KnownSamples | None:
    """The samples of the finished scan of the same scene at ``target``; None where it has none, or lacks outputs.

    ``axes`` are those of the scene, ``shape`` that of the grid at one place along them. Raises PoundingError where
    no samples can be added to them.
    """
    count = samples_before(target, identity)
    if not count:
        return None
    dataset = stream_results(target)
    if _is_complete(dataset, count, {axis.name: axis for axis in axes}, shape):
        return KnownSamples(dataset, target)
    dataset.close()
    return None


def _is_complete(dataset: xr.Dataset, count: int, axes: Mapping[str, SceneAxis], shape: tuple[int, ...]) -> bool:
    """True for a dataset with every case of the scene's first samples, drawn at the same values."""
    for axis in axes_of(dataset):
        scene_axis, own_size = axes.get(axis.name), dataset.sizes.get(axis.name)
        size_wanted = count if axis.name == SAMPLE else axis.size
        if scene_axis is None or axis.size != size_wanted or own_size != size_wanted or axis.keys != scene_axis.keys:
            return False
        if any(
            tuple(old_labels) != tuple(labels)[:size_wanted]
            for old_labels, labels in zip(axis.values, scene_axis.values, strict=True)
        ):
            return False
    sizes = tuple(dataset.sizes.get(axis, 1) for axis in axes_of_cases(dataset))
    return sizes == shape and len(scene_dims(dataset)) == len(axes)
