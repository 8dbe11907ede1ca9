"""The command of `histories`: time histories of chosen cases, as one dataset."""

from __future__ import annotations

from pounding_risk.questions._declaration import File, Option

ORDER = 170
FUNCTION = "studies.histories"
FILES = {"out": File((".nc", ".zarr"), "Histories", usual="{}-histories.nc")}
OPTIONS = {
    "source": Option(metavar="SOURCE", is_argument=True),
    "records": Option("--record"),
    "polarities": Option("--polarity"),
    "pgas": Option("--pga"),
    "intensity_levels": Option("--intensity-level"),
    "laws": Option("--law"),
    "gaps": Option("--gap"),
    "yield_forces": Option("--yield-force"),
    "largest_of": Option("--largest"),
}
