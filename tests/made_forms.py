"""Templates of datasets made by hand, and values that are different in every case."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import xarray as xr

from pounding_risk.results.layout import AXES, CaseVariable, Template, blocks

SHAPE = (7, 2, 1, 2, 5, 3)  # 70 batches


def made_template(shape: tuple[int, ...] = SHAPE, variables: int = 4) -> Template:
    """As a scan's: an axis of amplitudes only where there are several, labels beside the axes, an extra axis."""
    sizes = dict(zip(AXES, shape, strict=True))
    values = {
        "record": [f"RSN{number}-é" for number in range(sizes["record"])],
        "polarity": [f"polarity {number}" for number in range(sizes["polarity"])],
        "contact_model": [f"law_{number}" for number in range(sizes["contact_model"])],
    }
    coords = {
        axis: (axis, values.get(axis, np.arange(size) * 0.5), {"long_name": axis})
        for axis, size in sizes.items()
        if axis != "pga" or size > 1
    }
    if sizes["pga"] == 1:
        coords["pga"] = ((), 4.9, {"units": "m/s2"})  # a label of all cases, as one amplitude is
    coords |= {
        "record_event": ("record", ["" if place % 2 else "Kobe" for place in range(sizes["record"])]),
        "building": ("building", ["left", "right"]),
        "building_mass": ("building", [1e4, np.nan], {"units": "kg"}),
        "force_at": (("yield_force", "building"), np.ones((sizes["yield_force"], 2))),
    }
    spectra = (("record", "building"), np.ones((sizes["record"], 2)), {"units": "m/s2"})
    skeleton = xr.Dataset({"spectra": spectra}, coords, {"title": "made", "rtol": 1e-6})
    flags = {"flag_values": np.array([0, 1], dtype=np.int8), "flag_meanings": "complete failed"}
    cases = {f"value_{number}": CaseVariable((), np.dtype(float), {"units": "m"}) for number in range(variables)}
    cases["at_buildings"] = CaseVariable(("building",), np.dtype(float), {"units": "N"})
    cases["count"] = CaseVariable((), np.dtype(np.int32), {"long_name": "contacts"})
    cases["status"] = CaseVariable((), np.dtype(np.int8), flags)
    return Template(skeleton, cases, shape)


def values_of(template: Template, batches: range) -> dict[str, np.ndarray]:
    """Numbers of each case that no other case has, with a few that are missing."""
    found = {}
    for place, (name, variable) in enumerate(template.cases.items()):
        sizes = (template.width, *template.extra(name))
        count = int(np.prod(sizes))
        first = np.array(batches)[:, None] * count + np.arange(count)
        values = (first % 97 if variable.dtype == np.int8 else first).astype(variable.dtype)
        if variable.dtype.kind == "f":
            values = np.where(first % 11 == place, np.nan, np.sin(values))  # every digit counts
        found[name] = values.reshape(len(batches), *sizes)
    return found


def pieces(template: Template) -> Iterator[tuple[range, dict[str, np.ndarray]]]:
    """The blocks to write, with their values."""
    for block in blocks(template):
        yield block, values_of(template, block)
