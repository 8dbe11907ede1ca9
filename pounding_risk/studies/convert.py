"""Conversion of datasets between netCDF and Zarr, block by block."""

from __future__ import annotations

from pathlib import Path

from pounding_risk._common.files import AGAIN
from pounding_risk.ensemble.replacing import OTHER_NAME, read_finished, recorded_identity
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import RESULTS, check_target, reading, stream_results
from pounding_risk.results.layout import blocks, template_of, values_at
from pounding_risk.results.store import store_of


def convert(source: str | Path, target: str | Path) -> Path:
    """Write a dataset as Zarr or as netCDF, whatever its size.

    Values, labels and attributes stay what they are; memory holds one block at a time. The target is complete or
    absent.

    Parameters
    ----------
    source : path
        A dataset of any command (.nc or .zarr).
    target : path
        The file or store to write (.zarr or .nc).

    Returns
    -------
    pathlib.Path
        The path of the target.

    Raises
    ------
    PoundingError
        If the source cannot be read, or the target cannot be written, is the source, or holds anything but the results
        of the same command and study.
    """
    path = check_target(target, RESULTS)
    if path.exists() and Path(source).exists() and path.samefile(source):
        raise PoundingError(f"{target}: is the source itself; name another target")
    if path.exists() and Path(source).exists():  # what is there may be the source, converted before
        present, converted = (read_finished(file) for file in (path, Path(source)))
        is_same = present.command and present.command == converted.command
        if not is_same or recorded_identity(present.attrs) != recorded_identity(converted.attrs):
            content = f"other results of {present.command}" if present.command else "no results of pounding-risk"
            raise PoundingError(f"{path}: is there already and holds {content}; {OTHER_NAME}")
    with stream_results(source) as dataset, reading(source, (RuntimeError,)):  # as netCDF has it
        template = template_of(dataset.drop_encoding())
        with store_of(template, path, AGAIN) as store:
            for block in blocks(template):
                store.write(block, values_at(dataset, template, block, template.cases))
            store.finish({})
    return path
