"""Motions site by site, as SimCenter's workflows hand them over: a grid of sites, and the motions of each.

``EventGrid.csv`` has a row for each site, ``GP_file,Longitude,Latitude`` and perhaps ``Vs30``; the file that it names,
such as ``site0.csv``, a row for each motion, ``TH_file,factor``; its ``RSN107`` is ``RSN107.json`` beside it, or a file
of any other format that is read here. The unit of the samples stands in the workflow's ``input.json``.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from math import inf, isfinite
from pathlib import Path
from typing import NamedTuple

from pounding_risk._common.inputs import EXPORT, read_text
from pounding_risk._common.tables import head_of, read_table
from pounding_risk.errors import RecordError
from pounding_risk.motions.formats import size_of_unit
from pounding_risk.motions.read import components
from pounding_risk.motions.record import FACTOR_OF_SITE, Source
from pounding_risk.motions.sites.places import FARTHEST, Place, Site, SiteRequest, find_site, place_of, read_site
from pounding_risk.units import shown

GRID = ("GP_file", "Longitude", "Latitude")
AGAIN = "restore that line, or export the file again"
CHOOSE = "write place = {longitude = 23.73, latitude = 37.98} in [records], or EventGrid.csv#23.73,37.98"
WORKFLOW = "input.json"


class GridSite(NamedTuple):
    """A site of a grid: the table of its motions, its place, and Vs30 [m/s] where the grid has it."""

    file: Path
    place: Place
    vs30: float | None


class SiteMotion(NamedTuple):
    """A motion of a site: its file and the factor on its samples."""

    file: Path
    factor: float


def is_grid(path: Path) -> bool:
    """True for a table of sites."""
    return path.suffix.lower() == ".csv" and head_of(path)[:1] == GRID[:1]


def read_grid(path: Path) -> tuple[GridSite, ...]:
    """The sites of a grid; raises RecordError with the line for a damaged one, and for a place that is there twice."""
    table = read_table(path, AGAIN, error=RecordError, needed=GRID)
    sites: dict[Place, GridSite] = {}
    for row in table.rows:
        place = place_of(table, row, *GRID[1:])
        file = row.cells[table.head.index("GP_file")]
        if not file or place in sites:
            what = f"a second site at {place}" if file else "no GP_file"
            raise row.fault(f"has {what}; {AGAIN}")
        vs30 = table.number(row, "Vs30") if "Vs30" in table.head else None
        sites[place] = GridSite(path.parent / file, place, vs30)
    return tuple(sites.values())


def site_motions(site: GridSite) -> tuple[SiteMotion, ...]:
    """The motions of a site; raises RecordError with the line for a damaged table, and one of intensities."""
    table = read_table(site.file, AGAIN, error=RecordError)
    if "TH_file" not in table.head:
        raise table.fault(
            f"its columns are {shown(','.join(table.head)[:60])}, and motions are in TH_file; a grid of intensities "
            "has none: take one of motions"
        )
    motions = []
    for row in table.rows:
        factor = table.number(row, "factor") if "factor" in table.head else 1.0
        if not (isfinite(factor) and factor > 0.0):
            raise row.fault(f"the factor is {factor:g}; it must be greater than 0: {AGAIN}")
        name = row.cells[table.head.index("TH_file")]
        beside = [site.file.parent / f"{name}{suffix}" for suffix in (".json", ".csv", "")]
        file = next((one for one in beside if name and one.is_file()), None)
        if file is None:
            raise row.fault(
                f"no motion {shown(name)} is beside it, as {beside[0].name}, {beside[1].name} or a file of that name; "
                "copy it there, or leave the line out"
            )
        motions.append(SiteMotion(file, factor))
    return tuple(motions)


def grid_sources(
    path: Path, wanted: SiteRequest | None, *, unit: str | None = None, dt: float | None = None
) -> Iterator[Source]:
    """Every component of every motion at the site of a grid that is requested, or at its only one.

    A site that is far is taken, with a doubt. ``unit`` is by default that of the workflow's input.json beside the grid,
    or up to two folders above; ``dt`` [s] is of motions that do not state theirs.
    """
    sites = read_grid(path)
    limitless = None if wanted is None else wanted._replace(within=inf)
    chosen_site = find_site(
        [one.place for one in sites], [one.file.stem for one in sites], limitless, str(path), CHOOSE
    )
    yield from _sources(sites[chosen_site.position], wanted, chosen_site, _unit(path, unit), dt)


def sources_at(path: Path, site: str, *, unit: str | None = None, dt: float | None = None) -> Iterator[Source]:
    """As `grid_sources`, at the site that a text names; at all of them where it is empty."""
    if site:
        return grid_sources(path, read_site(site, str(path)), unit=unit, dt=dt)
    unit, sites = _unit(path, unit), enumerate(read_grid(path))
    return (source for at, one in sites for source in _sources(one, None, Site(at, one.place), unit, dt))


def _sources(
    site: GridSite, wanted: SiteRequest | None, found: Site, unit: str | None, dt: float | None
) -> Iterator[Source]:
    known = {"site": site.file.name, "longitude": site.place.longitude, "latitude": site.place.latitude}
    known |= {} if site.vs30 is None else {"vs30": site.vs30}
    doubts: tuple[str, ...] = ()
    if wanted is not None and wanted.place is not None:
        known["site_distance_km"] = found.distance
        if found.distance > min(wanted.within, FARTHEST):
            doubts = (f"its site {site.file.name} is {found.distance:.3g} km from {wanted.place}: check the place",)
    for motion in site_motions(site):
        for source in components(motion.file, unit=unit, dt=dt):
            record = {**source.record, **known, FACTOR_OF_SITE: motion.factor}
            yield source._replace(record=record, doubts=(*source.doubts, *doubts))


def _unit(path: Path, unit: str | None) -> str | None:
    """The unit that is given, or that of the workflow near a grid; raises RecordError where both differ."""
    for folder in (path.parent, path.parent.parent, path.parent.parent.parent):
        file = folder / WORKFLOW
        try:
            stated = json.loads(read_text(file, EXPORT))["RegionalEvent"]["units"]["TH_file"]
        except (OSError, ValueError, KeyError, TypeError, RecursionError):
            continue
        if unit is not None and size_of_unit(unit, "unit") != size_of_unit(stated, str(file)):
            raise RecordError(
                f"{file}: says that samples are in {shown(stated)}, and the unit {shown(unit)} is given; leave it out"
            )
        return unit or str(stated)
    return unit
