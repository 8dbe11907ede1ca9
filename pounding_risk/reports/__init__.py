"""Reports of a scan from its dataset alone: one document of blocks, written as a page (HTML) or as PDF."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any

import xarray as xr

from pounding_risk.results.check import missing_named
from pounding_risk.results.files import check_target


@missing_named()
def report(
    results: xr.Dataset | str | Path,
    out: str | Path,
    *,
    hazard: str | Path | None = None,
    also: Iterable[xr.Dataset | str | Path] = (),
    project: str = "",
    author: str = "",
    revision: str = "",
    date: str = "",
    **options: Any,
) -> Path:
    """Write a report of a scan: one HTML file, or a PDF.

    The suffix of ``out`` chooses between them. The same dataset gives the same bytes.

    Of a dataset with several values along axes of numbers of its scene a section
    shows contact and the gap required along them; the others are of the scene's own values where they are among them,
    otherwise of those that need the widest gap.

    Parameters
    ----------
    results : xarray.Dataset, str or Path
        A dataset of `scan`, or the file it is in.
    out : str or Path
        The report, .html or .pdf.
    hazard : str or Path, optional
        A hazard curve as `assess` takes it.
    also : iterable of xarray.Dataset, str or Path
        Datasets of `compare`, `accuracy`, `effects` and `uncertainty`.
    project : str
        Project, for the head of the report.
    author : str
        Author, for the head of the report.
    revision : str
        Revision, for the head of the report.
    date : str
        Date, for the head of the report. What is not given is left out; no date is made up.
    **options
        Other options of `assess`, such as gap [m], target and percentile.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    PoundingError
        For what is no dataset of a scan or one that lacks a variable, for a target that cannot be written, as `assess`,
        and for a PDF without the extra ``pdf``.
    """
    from pounding_risk.assessment.assess import assess
    from pounding_risk.reports.data import ReportData, companions, opened, signed
    from pounding_risk.reports.document import build
    from pounding_risk.reports.pages import SUFFIXES, write_document

    target = check_target(out, SUFFIXES)
    signature = signed(project, author, revision, date)
    dataset, checksum, along = opened(results, options)
    companion_results = companions(also)
    assessment = assess(dataset, hazard=hazard, **options)
    model = build(ReportData(dataset, assessment, companion_results, checksum, signature, along, target.suffix.lower()))
    return write_document(model, target)
