"""Run the study of a results file again and compare the new results with the file, value by value."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._common.counted import counted
from pounding_risk._common.progress import Progress
from pounding_risk._common.short_repr import ShortRepr
from pounding_risk.ensemble.scan import scan
from pounding_risk.errors import PoundingError
from pounding_risk.questions._declaration import Option
from pounding_risk.render.sheet import Block, Row, count, listing, paragraph, table, worded
from pounding_risk.results.attributes import read_attribute, scene_dims, versions, versions_of
from pounding_risk.results.files import open_results, reading
from pounding_risk.results.layout import axes_of_cases
from pounding_risk.results.provenance import check_records, recorded
from pounding_risk.scene.motions import motions_of

ORDER = 160
SUBJECT = "results file"
OPTIONS = {"folder": Option(metavar="FOLDER")}
HELP = "Ends with status 3 where anything differs."
DIFFERS = 3  # exit status
HEADS = ("differs", "in", "of", "largest difference", "unit", "relative", "how")


class Difference(NamedTuple):
    """How a variable or coordinate of the second run differs from that of the first."""

    name: str
    cases: int  # in which a value differs
    of: int  # cases in all; values, of what does not depend on cases
    absolute: float  # largest difference, in the variable's unit; NaN where no two numbers can be compared
    relative: float  # the largest one over the first value
    words: str = ""  # where shape or kind differ


@dataclass(frozen=True, repr=False)
class Rerun(ShortRepr):
    """Outcome of running a study again and comparing it with its results."""

    dataset: xr.Dataset  # of the second run
    compared: int  # variables and coordinates of the results
    differences: tuple[Difference, ...]
    missing: tuple[str, ...]  # variables and coordinates that the second run does not have
    new: tuple[str, ...]  # and those that only it has
    versions: dict[str, tuple[str, str]]  # of what computed, where it was another: (was, is)
    notes: tuple[str, ...]  # what else is not as it was, a sentence each

    def facts(self) -> Iterable[tuple[str, str]]:
        """Whether all is the same, and what differs, as pairs of a name and words."""
        yield "compared", counted(self.compared, "variable")
        yield "the same to the last bit", "yes" if self.same else "no"
        names = {
            "differ": [difference.name for difference in self.differences],
            "missing": self.missing,
            "new": self.new,
        }
        yield from ((label, ", ".join(listed)) for label, listed in names.items() if listed)
        yield from ((name, f"was {was}, is {now}") for name, (was, now) in self.versions.items())
        yield from (("note", note) for note in self.notes)

    @property
    def same(self) -> bool:
        """True where every variable and coordinate is the same to the last bit, and none is missing or new."""
        return not (self.differences or self.missing or self.new)


def rerun(
    results: str | Path,
    out: str | Path | None = None,
    *,
    folder: str | Path | None = None,
    workers: int | None = None,
    new: bool = False,
    progress: Progress | None = None,
) -> Rerun:
    """Run results again from what they carry, and compare.

    Parameters
    ----------
    results : path
        Results of `scan`; scene, options and command are those that the file carries.
    out : path, optional
        File for the new dataset, ``.nc`` or ``.zarr``.
    folder : path, optional
        Where record files are that the scene names relative to itself; by default the folder of the scene file, then
        that of the results.
    workers : int, optional
        Number of threads; as many as there are processors by default.
    new : bool
        Replace other results under the name ``out``.
    progress : callable, optional
        Called with the number of cases done and of all cases.

    Returns
    -------
    Rerun
        The new dataset, the differences to the results, and changes of versions and records.

    Raises
    ------
    PoundingError
        As `scan`; and, before any run, if the results do not carry a scene and records that can be run again.
    """
    path = Path(results)
    if out is not None and Path(out).resolve() == path.resolve():
        raise PoundingError(f"{out}: is the results file itself, which stays as it is; write to another name")
    with open_results(path, lazy=True) as before:
        with reading(path):
            for variable in before.variables.values():  # one at a time, before hours of work
                variable.to_numpy()
        origin = recorded(before, path, folder)
        notes = check_records(before, motions_of(origin.study))
        after = scan(
            origin.study,
            out,
            screening=origin.screening,
            check_fraction=origin.check_fraction,
            workers=workers,
            new=new,
            progress=progress,
            command=str(before.attrs.get("command", "")),
        )
        return compared(before, after, notes)


def compared(before: xr.Dataset, after: xr.Dataset, notes: list[str]) -> Rerun:
    """Compare two datasets of one study."""
    if str(before.attrs.get("scene_sha256")) != str(after.attrs.get("scene_sha256")):
        notes = [*notes, "the scene resolves to other values than it did: another version reads it otherwise"]
    old_names, new_names = set(before.variables), set(after.variables)
    axes = (*scene_dims(before), *axes_of_cases(before))
    common = [name for name in before.variables if name in new_names]
    differences = (_difference(str(name), before[name], after[name], axes) for name in common)
    return Rerun(
        after,
        len(old_names),
        tuple(difference for difference in differences if difference is not None),
        tuple(sorted(map(str, old_names - new_names))),
        tuple(sorted(map(str, new_names - old_names))),
        _changed_versions(before),
        tuple(notes),
    )


def _changed_versions(before: xr.Dataset) -> dict[str, tuple[str, str]]:
    old: Any = read_attribute(before, "versions", {})
    if not isinstance(old, Mapping):
        raise PoundingError(
            'the attribute "versions" of the results holds no table: the file was changed since; run its scene with '
            "scan"
        )
    new = versions()
    new |= versions_of(name for name in old if name not in new)  # plug-ins
    pairs = {name: (str(old.get(name, "not stated")), new[name]) for name in {**old, **new}}
    return {name: pair for name, pair in pairs.items() if pair[0] != pair[1]}


def _difference(name: str, before: xr.DataArray, after: xr.DataArray, axes: tuple[str, ...]) -> Difference | None:
    """How two arrays differ; None where they are the same to the last bit. ``axes`` are those of cases."""
    old, new = before.values, after.values
    shapes = [f"({', '.join(map(str, array.dims))}) of {array.shape}" for array in (before, after)]
    words = "" if old.dtype == new.dtype else f"{new.dtype}, was {old.dtype}"
    numbers = [array.dtype.kind in "biuf" for array in (old, new)]
    if shapes[0] != shapes[1] or numbers[0] != numbers[1]:
        words = f"{shapes[1]}, was {shapes[0]}" if shapes[0] != shapes[1] else words
        return Difference(name, old.size, old.size, np.nan, np.nan, words)
    sizes = np.nan, np.nan
    if not numbers[0]:
        words = ""  # texts of another length
        differs = old.astype(str) != new.astype(str)
    else:
        old, new = old.astype(np.float64), new.astype(np.float64)
        is_same = (old == new) & (np.signbit(old) == np.signbit(new))  # 0 is not −0
        differs = ~np.where(np.isnan(old), np.isnan(new), is_same)
        sizes = _sizes(old[differs], new[differs])
    if not differs.any() and not words:
        return None
    # Cases in which a value differs; values, where the array does not depend on cases.
    inner = tuple(axis for axis, dim in enumerate(before.dims) if dim not in axes)
    by_case = differs if len(inner) == before.ndim else differs.any(axis=inner)
    return Difference(name, int(by_case.sum()), by_case.size, *sizes, words)


def _sizes(old: np.ndarray, new: np.ndarray) -> tuple[float, float]:
    """The largest difference and the largest relative to the first; NaN where none is a number."""
    finite = np.isfinite(old) & np.isfinite(new)
    if not finite.any():
        return np.nan, np.nan
    differences, size = np.abs(new[finite] - old[finite]), np.abs(old[finite])
    with np.errstate(over="ignore"):  # over what is next to nothing
        relative = np.divide(differences, size, out=np.where(differences > 0.0, np.inf, 0.0), where=size > 0.0)
    return float(differences.max()), float(relative.max())


def sheet(comparison: Rerun) -> list[Block]:
    """What differs, or that nothing does, then other versions and notes."""
    names = (("missing", comparison.missing), ("new", comparison.new))
    lines = [f"{heading}: {', '.join(variables)}" for heading, variables in names if variables]
    lines += [f"version: {name} is {now}, was {was}" for name, (was, now) in comparison.versions.items()]
    blocks = [listing(lines, mark=""), listing(comparison.notes)]
    if comparison.same:
        words = f"all {comparison.compared} variables and coordinates are the same to the last bit"
        return [paragraph(words), *(block for block in blocks if block["items"])]
    n_same = comparison.compared - len(comparison.differences) - len(comparison.missing)
    rows = [_row(difference, comparison) for difference in comparison.differences]
    return [
        *([table("Variables that differ.", HEADS, rows)] if rows else []),
        paragraph(f"the other {n_same} variables and coordinates are the same to the last bit"),
        *(block for block in blocks if block["items"]),
    ]


def status(comparison: Rerun) -> int:
    """Exit status of the command."""
    return 0 if comparison.same else DIFFERS


def _row(difference: Difference, comparison: Rerun) -> Row:
    """Cells of a variable that differs."""
    unit = str(comparison.dataset[difference.name].attrs.get("units", ""))
    absolute = worded(difference.absolute, f"{difference.absolute:.2g}")
    relative = worded(difference.relative, f"{difference.relative:.1e}")
    counts = count(difference.cases), count(difference.of)
    return [difference.name, *counts, absolute, unit, relative, difference.words]
