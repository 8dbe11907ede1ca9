"""Hazard curves and uniform hazard spectra as the OpenQuake engine exports them, at one of their sites.

A file of curves, ``hazard_curve-mean-PGA_1.csv``, has a row for each site and a column ``poe-IML`` for each level, and
says in its comment line the intensity and the investigation time of its probabilities; a file of spectra,
``hazard_uhs-mean_1.csv``, has a column ``POE~IMT`` for each. PGA and SA are in g, PGV in cm/s.
"""

from __future__ import annotations

import glob
import re
from collections.abc import Sequence
from itertools import chain
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from pounding_risk._common.counted import counted
from pounding_risk._common.tables import AGAIN, Row, Table, head_of, read_table, short
from pounding_risk.errors import PoundingError
from pounding_risk.motions.levels import sa_at
from pounding_risk.motions.sites.places import Site, SiteRequest, find_site, place_of, read_site, site_words, split_site
from pounding_risk.units import STANDARD_GRAVITY

Array = NDArray[np.float64]

PGV_UNIT = 0.01  # m/s
_SA = re.compile(r"SA\(\s*(\d+\.?\d*(?:[eE]-?\d+)?|\.\d+)\s*\)")
_POE = re.compile(r"poe-(\d+\.?\d*(?:[eE][+-]?\d+)?)")
_SPECTRUM = re.compile(r"(\d*\.?\d+(?:[eE][+-]?\d+)?)~(.+)")


class Exported(NamedTuple):
    """Curves of one site: by intensity its levels [SI] in rising order, and their probabilities in ``years``."""

    name: str  # of the file or pattern, with the site
    years: float
    intensities: tuple[str, ...]  # "pga", "pgv" or "sa(0.5 s)"
    levels: tuple[Array, ...]
    probabilities: tuple[Array, ...]
    reading: tuple[str, ...]  # sentences on how they were read


def exported(path: str | Path) -> Exported | None:
    """The curves that a name stands for: a file or a pattern of files, with ``#LONGITUDE,LATITUDE`` after it.

    None where that is no export of OpenQuake. Raises PoundingError, with the line, for a damaged one, for a site that
    it has not, and for files of a pattern that do not belong together.
    """
    name, site_text = split_site(str(path))
    files = [Path(name)] if Path(name).exists() else [Path(file) for file in sorted(glob.glob(name))]
    csvs = [file for file in files if {"lon", "lat"} <= set(head_of(file))]
    if not csvs:
        if site_text and files:
            raise PoundingError(f"{name}: is a table without sites; leave the site {site_text} out")
        return None
    if len(csvs) < len(files):
        other = next(file for file in files if file not in csvs)
        raise PoundingError(f"{other}: is no hazard curve of OpenQuake, as others of {name} are; narrow the pattern")
    site = read_site(site_text) if site_text else None
    exports = [_curve_or_spectra(read_table(file, error=PoundingError, needed=("lon", "lat")), site) for file in csvs]
    first = exports[0]
    for file, export in zip(csvs, exports, strict=True):
        if (export.years, export.reading[0]) != (first.years, first.reading[0]):
            raise PoundingError(
                f"{file}: states {export.years:g} years and {export.reading[0]!r}, and {csvs[0]} {first.years:g} years "
                f"and {first.reading[0]!r}; name files of one calculation, one kind and one site"
            )
    reading = tuple(dict.fromkeys(sentence for export in exports for sentence in export.reading))
    return Exported(
        f"{Path(name).name}{f'#{site_text}' if site_text else ''}",
        first.years,
        tuple(chain.from_iterable(export.intensities for export in exports)),
        tuple(chain.from_iterable(export.levels for export in exports)),
        tuple(chain.from_iterable(export.probabilities for export in exports)),
        reading,
    )


def measure_of(imt: str) -> tuple[str, float] | None:
    """The intensity that OpenQuake calls ``imt``, and its unit in SI; None of those that datasets do not hold."""
    if imt in ("PGA", "PGV"):
        return imt.lower(), STANDARD_GRAVITY if imt == "PGA" else PGV_UNIT
    match = _SA.fullmatch(imt)
    return (sa_at(float(match[1])).intensity, STANDARD_GRAVITY) if match and float(match[1]) > 0.0 else None


def _curve_or_spectra(table: Table, request: SiteRequest | None) -> Exported:
    id_column = table.head.index("custom_site_id") if "custom_site_id" in table.head else -1
    ids = [row.cells[id_column] for row in table.rows] if id_column >= 0 else []
    site = find_site([place_of(table, row) for row in table.rows], ids, request, str(table.path))
    row = table.rows[site.position]
    columns = [name for name in table.head if name not in ("custom_site_id", "lon", "lat", "depth")]
    if columns and all(map(_POE.fullmatch, columns)):
        return _curve(table, row, columns, _reading_words(table, site, request))
    if columns and all(map(_SPECTRUM.fullmatch, columns)):
        return _spectra(table, row, columns, _reading_words(table, site, request, ", uniform hazard spectra"))
    raise table.fault(
        "is an export of OpenQuake, and neither a hazard curve (columns poe-0.1 ...) nor uniform hazard spectra "
        "(columns 0.002105~PGA ...); export hcurves or uhs"
    )


def _reading_words(table: Table, site: Site, request: SiteRequest | None, shape: str = "") -> str:
    """Sentences on the program with the kind and shape of its file, and on the site."""
    kind = table.facts.get("kind", "")
    return f"OpenQuake{f', {kind}' if kind else ''}{shape}. {site_words(site, request)}"


def _intensity(table: Table, imt: str) -> tuple[str, float]:
    measure = measure_of(imt)
    if measure is None:
        imt_text = short(imt) if imt else "an intensity that nothing states"
        raise table.fault(
            f"is of {imt_text}, which datasets do not hold for their motions; export "
            'PGA, PGV, or SA at a period such as SA(0.5), and keep the comment line, which says imt="PGA"'
        )
    return measure


def _curve(table: Table, row: Row, columns: Sequence[str], reading: str) -> Exported:
    """One curve, without what has no finite rate, and without levels that are exceeded as often as a stronger one."""
    intensity, unit = _intensity(table, table.facts.get("imt", ""))
    levels = unit * np.array([float(column.removeprefix("poe-")) for column in columns])
    poes = np.array([table.number(row, column) for column in columns])
    for column, poe in zip(columns, poes.tolist(), strict=True):
        if not 0.0 <= poe <= 1.0:
            raise row.fault(f"{column} is {poe:g}; a probability goes from 0 to 1: {AGAIN}")
    for k in range(1, len(columns)):
        if not (levels[k] > levels[k - 1] and poes[k] <= poes[k - 1]):
            raise row.fault(
                f"{columns[k]}: intensities must rise and probabilities fall from column to column, and {poes[k]:g} "
                f"follows {poes[k - 1]:g}; {AGAIN}"
            )
    is_inside = (levels > 0.0) & (poes > 0.0) & (poes < 1.0)
    is_used = is_inside & np.append(poes[1:] < poes[:-1], True)
    if is_used.sum() < 2:
        raise row.fault(f"has {is_used.sum()} different probabilities between 0 and 1, two are the least; {AGAIN}")
    notes = []
    if (~is_inside).any():
        notes.append(f"{counted((~is_inside).sum(), 'level')} of {intensity} with a probability of 0 or 1 left out.")
    if (is_inside & ~is_used).any():
        equal_text = counted((is_inside & ~is_used).sum(), "level")
        notes.append(f"{equal_text} of {intensity} left out, exceeded as often as the next one.")
    years = table.fact("investigation_time")
    return Exported(table.path.name, years, (intensity,), (levels[is_used],), (poes[is_used],), (reading, *notes))


def _spectra(table: Table, row: Row, columns: Sequence[str], reading: str) -> Exported:
    """Uniform hazard spectra: a curve for each intensity, at the probabilities of the file."""
    by_imt: dict[str, list[tuple[float, float]]] = {}
    for column in columns:
        poe, imt = _SPECTRUM.fullmatch(column).groups()  # type: ignore[union-attr]
        by_imt.setdefault(imt, []).append((float(poe), table.number(row, column)))
    names, levels, probabilities = [], [], []
    for imt, pairs in by_imt.items():
        intensity, unit = _intensity(table, imt)
        poes, ims = np.array(sorted(pairs, reverse=True)).T
        if len(poes) < 2 or not (poes[-1] > 0.0 and poes[0] < 1.0):
            raise table.fault(
                f"has spectra of {len(poes)} probabilities of {imt}; two different ones between 0 and 1 are the least, "
                "from which a rate follows: set poes = 0.1 0.02 in the job, or export hazard curves"
            )
        if not (ims[0] > 0.0 and (np.diff(ims) > 0.0).all() and (np.diff(poes) < 0.0).all()):
            raise row.fault(
                f"{imt} is {', '.join(f'{im:g}' for im in ims)} at probabilities of "
                f"{', '.join(f'{poe:g}' for poe in poes)}; it must be above 0 and rise as they fall (the engine cuts "
                "it at its strongest level): ask for fewer poes, or export hazard curves"
            )
        names.append(intensity)
        levels.append(unit * ims)
        probabilities.append(poes)
    years = table.fact("investigation_time")
    return Exported(table.path.name, years, tuple(names), tuple(levels), tuple(probabilities), (reading,))
