"""From netCDF to Zarr and back, block by block: what memory holds is one block, however large the dataset is."""

from __future__ import annotations

from pathlib import Path

from pounding_risk.errors import PoundingError
from pounding_risk.layout import blocks, form_of, values_at
from pounding_risk.results import RESULTS, check_target, stream_results
from pounding_risk.stores import store_of
from pounding_risk.whole_files import AGAIN


def convert(source: str | Path, target: str | Path) -> Path:
    """Write a dataset under another name: ``.nc`` for a netCDF file, ``.zarr`` for a Zarr store.

    Values, labels and attributes stay what they are. The target is whole or not there. Raises PoundingError for a
    source that cannot be read and a target that cannot be written, or is the source.
    """
    place = check_target(target, RESULTS)
    if place.exists() and Path(source).exists() and place.samefile(source):
        raise PoundingError(f"{target}: is the source itself; name another target")
    with stream_results(source) as dataset:
        form = form_of(dataset.drop_encoding())
        with store_of(form, place, AGAIN) as store:
            for block in blocks(form):
                store.write(block, values_at(dataset, form, block, form.cases))
            store.finish({})
    return place
