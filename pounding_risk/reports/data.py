"""Data of a report: a scan's dataset, its assessment, datasets of other commands on the same scene, and a signature."""

from __future__ import annotations

import tomllib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from pounding_risk._common.files import checksum
from pounding_risk.assessment.along import Place, assess_along, usual_place
from pounding_risk.assessment.assess import Assessment, InterfaceAssessment
from pounding_risk.assessment.row import RowCase, row_case
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.attributes import isolated_buildings, read_attribute
from pounding_risk.results.check import AXES_OF_CASES, check_scan, kind_of
from pounding_risk.results.files import open_results, opened_or_given
from pounding_risk.results.opened import Results
from pounding_risk.results.scene_axes import is_drawn_along, with_axes
from pounding_risk.units import shown

NEEDED = ("impact_count", "yield_exceedance", "peak_relative_displacement", "status", "simulated")
ADDED = ("peak_closing_free", "record_spectral_acceleration", "building_period")
USED = ("building", "period", "record_pga", "peak_displacement_free")
LONGEST = 200  # letters of a line in the head
BESIDE = ("accuracy", "effects", "compare", "uncertainty")  # calls whose datasets a report takes beside a scan


class Signature(NamedTuple):
    """Project, author, revision and date in the head of a report; "" where they are not given. No date is made up."""

    project: str = ""
    author: str = ""
    revision: str = ""
    date: str = ""

    @property
    def lines(self) -> list[list[str]]:
        """Name and text of every line that is given."""
        return [[name, words] for name, words in self._asdict().items() if words]


NOT_SIGNED = Signature()


class Pair(NamedTuple):
    """One interface: its assessment and its part of the dataset."""

    name: str
    anchor: str
    assessed: InterfaceAssessment
    results: xr.Dataset  # at the amplitude that is assessed
    at: str  # this amplitude in words

    @property
    def grid_gap(self) -> float:
        """The gap of the grid that is nearest to the assessed one [m]."""
        gaps = self.results["gap"].values
        return float(gaps[np.abs(gaps - self.assessed.gap).argmin()])


def at_amplitude(results: Any, amplitude: float | None) -> Any:
    """A dataset, or a variable of one, at its amplitude that is nearest to an assessed one [SI]."""
    axis = next((name for name in (PGA_AXIS, LEVEL_AXIS) if name in results.dims), None)
    if axis is None:
        return results
    return results.isel({axis: int(np.abs(results[axis].values - amplitude).argmin())})


class Along(NamedTuple):
    """An assessment along the axes of numbers of the scene, and the place that the other sections are of."""

    assessed: xr.Dataset
    place: Place


@dataclass(frozen=True)
class ReportData:
    """A dataset, its assessment, and datasets of `compare`, `accuracy` and `effects` by the command's name."""

    results: xr.Dataset
    assessment: Assessment
    others: Mapping[str, xr.Dataset]
    checksum: str = ""  # of the results file
    signature: Signature = NOT_SIGNED
    along: Along | None = None
    suffix: str = ".html"  # of the file that is written

    @cached_property
    def pairs(self) -> tuple[Pair, ...]:
        """Every interface with its assessment, left to right."""
        sides = zip(self.assessment.interfaces, Results(self.results).interfaces, strict=True)
        return tuple(
            Pair(one.name, f"interface-{number}", one, at_amplitude(scan.dataset, one.amplitude), f", motions {one.at}")
            for number, (one, (_, scan)) in enumerate(sides, start=1)
        )

    @property
    def several(self) -> bool:
        """True where there are several interfaces."""
        return self.results.sizes["interface"] > 1

    @property
    def has_points(self) -> bool:
        """True where outputs are known at each contact point and storey, and not only at interfaces and buildings."""
        return "contact_point_impact_count" in self.results

    @cached_property
    def row(self) -> RowCase:
        """The row at the assessed amplitude, under the scene's contact model, at the gap that is judged."""
        gaps = {pair.assessed.gap for pair in self.pairs}
        return row_case(
            self.results,
            gap=gaps.pop() if len(gaps) == 1 else None,
            contact_model=self.law,
            yield_force=Results(self.results).scene_force,
            intensity_level=self.assessment.interfaces[0].amplitude,
        )

    @cached_property
    def scene(self) -> dict[str, Any]:
        """The scene with every value stated, as its file would be read."""
        return tomllib.loads(self.results.attrs["scene_resolved"])

    @cached_property
    def isolated_periods(self) -> dict[str, float]:
        """Period of the first mode [s] of each isolated building while its isolators yield, by its name."""
        if "building_isolated_period" not in self.results.coords:  # of buildings without isolators
            return {}
        names, periods = (self.results[name].values for name in ("building", "building_isolated_period"))
        isolated = isolated_buildings(self.scene)
        return {str(name): float(period) for name, period in zip(names, periods, strict=True) if name in isolated}

    def facts(self, name: str, default: Any) -> Any:
        """Value of an attribute of the dataset that holds JSON."""
        return read_attribute(self.results, name, default)

    @cached_property
    def records(self) -> dict[str, dict[str, Any]]:
        """Facts on each record, by its name."""
        return {record["name"]: record for record in self.facts("records", [])}

    @property
    def law(self) -> str:
        """The scene's own contact model where the grid has it, or the grid's first."""
        return Results(self.results).scene_model

    @property
    def laws(self) -> list[str]:
        """Names of the grid's contact models."""
        return list(map(str, self.results["contact_model"].values))


def signed(project: str = "", author: str = "", revision: str = "", date: str = "") -> Signature:
    """The lines of a report's head, without blanks around them.

    Raises PoundingError for what is no text, is longer than a line, or holds line breaks or other letters that are not
    printed.
    """
    signature = Signature(project, author, revision, date)
    for name, words in signature._asdict().items():
        if not isinstance(words, str):
            raise PoundingError(f"{name}: {shown(words)} is no text; write it in quotes")
        if not words.isprintable():
            raise PoundingError(
                f"{name}: {shown(words)} has line breaks or other letters that cannot be printed; omit them"
            )
        if len(words) > LONGEST:
            raise PoundingError(f"{name}: has {len(words)} letters; the head has room for {LONGEST}: shorten it")
    return Signature(*(words.strip() for words in signature))


def opened(results: xr.Dataset | str | Path, options: Mapping[str, Any]) -> tuple[xr.Dataset, str, Along | None]:
    """A scan's dataset, the checksum of its file where it is one, and what lies along axes of numbers of its scene.

    With several places along them the dataset is of one, which its title names; ``options`` are those of `assess`.
    Raises PoundingError for a file that cannot be read and for what is no dataset of `scan`.
    """
    scan, source = opened_or_given(results, "the dataset")
    along = None
    if kind_of(scan) == "scan" and is_drawn_along(scan):
        check_scan(scan, source)
        option_names = ("gap", "confidence", "percentile", "target", "pga", "intensity_level")
        assessed = assess_along(scan, **{name: option for name, option in options.items() if name in option_names})
        along = Along(assessed, usual_place(assessed))
        scan = scan.isel({axis: [place] for axis, place in along.place.places.items()})
    dataset = with_axes(scan, source)
    if along is not None:
        dataset = dataset.assign_attrs(title=f"{dataset.attrs.get('title', '')} ({along.place.words})")
    _check(dataset, source)
    return dataset, checksum(Path(results)) if isinstance(results, str | Path) else "", along


def _check(dataset: xr.Dataset, source: str) -> None:
    """Raise PoundingError for what is no dataset of `scan`, for one of an older version, and for a damaged one."""
    missing = [name for name in NEEDED if name not in dataset]
    if missing or "scene_resolved" not in dataset.attrs:
        fault, repair = f"a dataset without {', '.join(missing) or 'scene'}", ""
        if (kind := kind_of(dataset)) in BESIDE:
            fault = f"a dataset of `pounding-risk {kind}`"
            repair = f": name the scan first, and this one with --with {source}"
        raise PoundingError(f"{source}: is {fault}; a report is written from what `pounding-risk scan` writes{repair}")
    late = [name for name in ADDED if name not in dataset.variables]
    if late:
        raise PoundingError(
            f"{source}: has no {', '.join(late)}: it was written by an older version, or damaged; run the scan again"
        )
    attributes = ("records", "processing", "versions", "rtol", "scene", "restitution")
    check_scan(dataset, source, names=(*AXES_OF_CASES, *USED), attrs=attributes)


def companions(also: Iterable[xr.Dataset | str | Path]) -> dict[str, xr.Dataset]:
    """Datasets of other commands by the command's name; raises PoundingError for another, or two of one kind."""
    datasets: dict[str, xr.Dataset] = {}
    for other in also:
        if isinstance(other, str | Path):
            source = str(other)
            dataset = open_results(other).assign_attrs(file=source, sha256=checksum(Path(other)))
        else:
            source, dataset = "a dataset", other
        kind = kind_of(dataset)
        if kind not in BESIDE:
            raise PoundingError(f"{source}: was written by none of {', '.join(BESIDE)}; leave it out")
        if kind in datasets:
            raise PoundingError(f"{source}: is the second dataset of `pounding-risk {kind}`; name one of each kind")
        datasets[kind] = dataset
    return datasets
