"""Which call made a dataset, by what only its dataset has."""

from __future__ import annotations

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import xarray as xr

# Variables, coordinates and attributes that only the dataset of this call has, in the order in which they are looked
# for: a dataset of `compare` or `effects` is that of a scan with more in it.
MARKS = {
    "compare": {"flips", "baseline"},
    "accuracy": {"setting", "time_to_reach"},
    "effects": {"effects", "time_ratio"},
    "uncertainty": {"uncertain_number"},
    "spectra": {"left_period", "required_gap"},
    "amplification": {"period_ratio"},
    "damage": {"demand_ratio", "median_ratio"},
}


def kind_of(dataset: xr.Dataset) -> str:
    """The call that made a dataset: scan, simulate, histories or one of `MARKS`; "" where none did."""
    names = set(map(str, dataset.variables)) | (set(dataset.attrs) - {"effects"})
    for kind, marks in MARKS.items():
        if marks & names:
            return kind
    if "sample" in dataset.dims and "time" in dataset.variables:  # a scan may have samples of uncertain numbers
        return "histories"
    if "time" in dataset.dims and "contact_force" in dataset.variables:
        return "simulate"
    return "scan" if {"impact_count", "record", "gap"} <= names else ""
