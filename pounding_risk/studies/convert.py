"""From netCDF to Zarr and back, block by block: what memory holds is one block, however large the dataset is."""

from __future__ import annotations

from pathlib import Path

from pounding_risk._common.files import AGAIN
from pounding_risk.ensemble.replacing import OTHER_NAME, read_finished, recorded_identity
from pounding_risk.errors import PoundingError
from pounding_risk.results.files import RESULTS, check_target, stream_results
from pounding_risk.results.layout import blocks, template_of, values_at
from pounding_risk.results.store import store_of


def convert(source: str | Path, target: str | Path) -> Path:
    """Write a dataset under another name: ``.nc`` for a netCDF file, ``.zarr`` for a Zarr store.

    Values, labels and attributes stay what they are. The target is whole or not there. Raises PoundingError for a
    source that cannot be read and a target that cannot be written, is the source, or holds anything else than the
    results of the same command and the same study.
    """
    place = check_target(target, RESULTS)
    if place.exists() and Path(source).exists() and place.samefile(source):
        raise PoundingError(f"{target}: is the source itself; name another target")
    _check_replaceable(place, Path(source))
    with stream_results(source) as dataset:
        template = template_of(dataset.drop_encoding())
        with store_of(template, place, AGAIN) as store:
            for block in blocks(template):
                store.write(block, values_at(dataset, template, block, template.cases))
            store.finish({})
    return place


def _check_replaceable(target: Path, source: Path) -> None:
    """Raise PoundingError where there is something under the target's name that is not the source, converted."""
    if not target.exists() or not source.exists():
        return
    there, here = (read_finished(path) for path in (target, source))
    same = there.command and there.command == here.command
    if not same or recorded_identity(there.attrs) != recorded_identity(here.attrs):
        what = f"other results of {there.command}" if there.command else "no results of pounding-risk"
        raise PoundingError(f"{target}: is there already and holds {what}; {OTHER_NAME}")
