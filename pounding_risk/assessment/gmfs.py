"""Probabilities of a scenario, or of an event set, from ground-motion fields that the OpenQuake engine exports.

A file of fields has a row for each site and event, ``event_id,site_id,gmv_PGA,gmv_SA(0.3)`` or, of older versions,
``rlzi,sid,eid,gmv_PGA``; PGA and SA in g, PGV in cm/s. A site is named by its id, or by its place where the table of
sites, ``sitemesh_1.csv`` with ``site_id,lon,lat``, stands beside the file. The engine leaves rows out whose intensities
are below its minimum: events of the file without a row at the site, and zeros, count as without failure.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field
from math import nan, sqrt
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.tables import AGAIN, Table, read_table
from pounding_risk.assessment.fragility import Fragility
from pounding_risk.assessment.hazard_openquake import measure_of
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import read_sa, sa_at
from pounding_risk.motions.sites.places import find_site, place_of, read_site, site_words, split_site
from pounding_risk.statistics.fragility import fragility_curve
from pounding_risk.statistics.hazard import SEED

Array = NDArray[np.float64]

MESH = "sitemesh"
_NAMES = {"site": ("site_id", "sid"), "event": ("event_id", "eid"), "realisation": ("rlz_id", "rlzi")}


@dataclass(frozen=True)
class Fields:
    """Intensities [SI] at one site, by measure ("pga", "sa(0.3 s)"), one for each event; 0 where it has no row.

    ``reading`` are sentences on the file, the site and the events.
    """

    source: str
    levels: dict[str, Array] = field(repr=False)
    reading: tuple[str, ...] = ()

    @property
    def events(self) -> int:
        """Number of events of the file, at this site or not."""
        return len(next(iter(self.levels.values())))

    def has(self, intensity: str) -> bool:
        """True for an intensity of the file, and for Sa at a period between two of the file."""
        return intensity in self.levels or self._neighbours(intensity) is not None

    def at(self, intensity: str) -> Array:
        """Intensities of all events; Sa between two periods by straight lines in the logarithms, event by event.

        Raises PoundingError for an intensity that the file has not.
        """
        if intensity in self.levels:
            return self.levels[intensity]
        neighbours = self._neighbours(intensity)
        if neighbours is None:
            raise PoundingError(
                f"{self.source}: has no {intensity}, it has {', '.join(self.levels)}; choose one of them with "
                f'--intensity, such as --intensity "{next(iter(self.levels))}"'
            )
        (low, below), (high, above) = neighbours
        share = np.log(_period(intensity) / low) / np.log(high / low)
        both = (below > 0.0) & (above > 0.0)
        fields = [np.where(both, field, 1.0) for field in (below, above)]
        return np.asarray(np.where(both, np.exp((1.0 - share) * np.log(fields[0]) + share * np.log(fields[1])), 0.0))

    def _neighbours(self, intensity: str) -> tuple[tuple[float, Array], tuple[float, Array]] | None:
        """The periods below and above that of an intensity, with their levels."""
        period = _period(intensity)
        by_period = sorted((_period(name), levels) for name, levels in self.levels.items() if _period(name) > 0.0)
        above = [place for place, (known_period, _) in enumerate(by_period) if known_period >= period]
        return (by_period[above[0] - 1], by_period[above[0]]) if period > 0.0 and above and above[0] else None


@dataclass(frozen=True)
class Scenario:
    """Probability of a failure at one gap [m] in an event of a file: the mean over its events of the fragility.

    ``low`` and ``high`` carry what the motions leave open of the fragility (`Fragility.draws`)
    and that the events are a sample; ``left_out`` is what events without a row would add to the probability at most,
    were each as strong as the weakest that has one, and ``high`` includes it.
    """

    what: str
    gap: float
    yield_force: float | None
    contact_model: str | None
    probability: float
    low: float
    high: float
    left_out: float
    fault: str = ""


def scenario_of(levels: Array, fragility: Fragility, confidence: float) -> Scenario:
    """Probability of one fragility over events of these intensities; NaN where it could not be fitted."""
    case = (fragility.what, fragility.gap, fragility.yield_force, fragility.contact_model)
    if fragility.fault:
        return Scenario(*case, nan, nan, nan, nan, fragility.fault)
    probabilities = _probabilities(levels, fragility.median, fragility.dispersion)
    silent = float((levels <= 0.0).mean())
    weakest = levels[levels > 0.0].min(initial=np.inf)
    left_out = silent * float(fragility_curve(weakest, fragility.median, fragility.dispersion)) if silent < 1.0 else nan
    low = high = nan
    medians, dispersions = fragility.draws()
    if medians.size:
        drawn = (_probabilities(levels, *pair) for pair in zip(medians, dispersions, strict=True))
        means, deviations = np.array([(sample.mean(), sample.std(ddof=levels.size > 1)) for sample in drawn]).T
        means += deviations / sqrt(levels.size) * np.random.default_rng(SEED).standard_normal(len(means))
        tail = 50.0 * (1.0 - confidence)
        low, high = np.clip(np.percentile(means, (tail, 100.0 - tail)), 0.0, 1.0)
        high = min(high + left_out, 1.0)
    return Scenario(*case, float(probabilities.mean()), float(low), float(high), left_out)


def _probabilities(levels: Array, median: float, dispersion: float) -> Array:
    """Probability of failure in each event, 0 in those without shaking."""
    shaking = levels > 0.0
    return np.where(shaking, fragility_curve(np.where(shaking, levels, 1.0), median, dispersion), 0.0)


def read_fields(path: str | Path) -> Fields:
    """Read the ground-motion fields of OpenQuake at one site.

    Parameters
    ----------
    path : str or Path
        The file, with the site after "#": ``gmf-data_1.csv#3`` by its id, ``gmf-data_1.csv#23.73,37.98`` by its place.

    Raises
    ------
    PoundingError
        With the line, for a damaged file, for a site that it has not, and for several of which none is named.
    """
    name, site_text = split_site(str(path))
    table = read_table(Path(name), error=PoundingError)
    columns = {what: next((alias for alias in names if alias in table.head), "") for what, names in _NAMES.items()}
    measures = {column: measure_of(column[4:]) for column in table.head if column.startswith("gmv_")}
    if not (columns["site"] and columns["event"] and any(measures.values())):
        raise table.fault(
            "is no file of ground-motion fields: it needs the columns event_id, site_id and gmv_PGA, or gmv_SA(0.3) at "
            f"some period; {AGAIN}"
        )
    site, words = _site(table, columns["site"], site_text)
    realisation_column = columns["realisation"] or columns["event"]
    events: dict[tuple[str, str], int] = {}
    rows = {}
    for row in table.rows:
        key = table.whole_id(row, realisation_column), table.whole_id(row, columns["event"])
        event = events.setdefault(key, len(events))
        if table.whole_id(row, columns["site"]) == site:
            if event in rows:
                raise row.fault(f"has event {key[1]} at site {site} a second time; {AGAIN}")
            rows[event] = row
    levels = {}
    for column, measure in measures.items():
        if measure is None:
            continue
        levels[measure[0]] = event_levels = np.zeros(len(events))
        for event, row in rows.items():
            level = table.number(row, column)
            if level < 0.0:
                raise row.fault(f"{column} is {level:g}; it must be 0 or above: {AGAIN}")
            event_levels[event] = measure[1] * level
    unknown_columns = [column for column, measure in measures.items() if measure is None]
    sentences = [f"{words} {len(events)} events, {len(rows)} of them with a row at the site; all count alike."]
    sentences += [f"Left out, as datasets do not hold it: {', '.join(unknown_columns)}."] if unknown_columns else []
    if columns["realisation"] and len({key[0] for key in events}) > 1:
        sentences.append("Realisations are not weighted.")
    return Fields(f"{Path(name).name}{f'#{site_text}' if site_text else ''}", levels, tuple(sentences))


def _site(table: Table, column: str, site_text: str) -> tuple[str, str]:
    """The id of the site whose fields are read, and a sentence on it."""
    ids = list(dict.fromkeys(table.whole_id(row, column) for row in table.rows))
    site_request = read_site(site_text, str(table.path)) if site_text else None
    if site_request is None or site_request.place is None:
        site = site_request.id if site_request else ids[0] if len(ids) == 1 else ""
        if site not in ids:
            sites_text = f"{len(ids)} sites, {', '.join(ids[:5])}{' ...' if len(ids) > 5 else ''}"
            lacking_text = f"has no site {site}, and {sites_text}" if site else f"has {sites_text}"
            raise table.fault(f"{lacking_text}; choose one with --site, by its id, or by longitude and latitude")
        return site, f"Site {site}."
    mesh = _mesh(table.path)
    places = [place_of(mesh, row) for row in mesh.rows]
    names = [mesh.whole_id(row, "site_id") for row in mesh.rows]
    nearest_site = find_site(places, names, site_request, str(mesh.path))
    return names[nearest_site.position], site_words(nearest_site, site_request)


def _mesh(path: Path) -> Table:
    """The table of sites beside a file of fields: the one of its calculation, or the only one."""
    number = re.search(r"_(\d+)$", path.stem)
    table = path.parent / f"{MESH}_{number[1]}.csv" if number else path.parent / f"{MESH}.csv"
    tables = [table] if table.is_file() else sorted(path.parent.glob(f"{MESH}*.csv"))
    if len(tables) != 1:
        count = f"{len(tables)} are" if tables else "none is"
        raise PoundingError(
            f"{path}: a site by its place needs the table of sites {table.name} beside it, and {count} there; copy "
            "it there, or name the site by its id"
        )
    return read_table(tables[0], error=PoundingError, needed=("site_id", "lon", "lat"))


def _period(intensity: str) -> float:
    """The period [s] of Sa with 5 % damping; 0 of another intensity."""
    measure = read_sa(intensity)
    return measure.period if measure is not None and measure.is_same(sa_at(measure.period)) else 0.0
