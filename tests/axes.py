"""Scenes with axes of their numbers, and the loop of `--set` that a scan of one must equal."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import xarray as xr
from scenes import scene_text, single, storeyed

from pounding_risk.ensemble.scan import scan
from pounding_risk.results.scene_axes import at_one_place, selected
from pounding_risk.scene.reader import parse_scene
from pounding_risk.scene.variants import Variants

PULSE = {"generated": [{"kind": "ricker", "pga": "0.4 g", "period": "0.8 s"}], "polarity": ["as recorded", "reversed"]}
AXES = {
    "interface.restitution": [0.5, 0.8],
    "building.left.period": {"start": "0.3 s", "stop": "0.7 s", "num": 3},
    "building.left.mass": ["500 t", "600 t"],
}
WHEN = ("date_created", "history")


def pair_text(axes: dict[str, Any], grid: dict[str, Any] | None = None, **more: Any) -> str:
    """A pair at two gaps, under a pulse unless ``more`` has other records, with these axes."""
    return scene_text(grid={"gap": ["10 mm", "60 mm"], **(grid or {}), **axes}, **{"records": PULSE} | more)


def row_text(axes: dict[str, Any], interfaces: int = 1, **more: Any) -> str:
    """A row of storeys, a mass and storeys under a pulse, with these axes; so many tables of equal interfaces."""
    buildings = (
        storeyed("A", "200 t", "9e7 N/m", storeys=2),
        single("B", "300 t", "0.5 s", height="3 m"),
        storeyed("C", "150 t", "3e8 N/m", storeys=2),
    )
    text = scene_text(*buildings, records=PULSE, grid={"gap": ["5 mm", "40 mm"], **axes}, **more)
    interface = text[text.index("[[interface]]") : text.index("[records]")]
    return text.replace(interface, interface * interfaces)


def same_scan(one: xr.Dataset, other: xr.Dataset, apart: tuple[str, ...] = ()) -> None:
    """Both have the same variables, bit by bit, with their dimensions, and the same attributes but those ``apart``."""
    assert set(one.variables) == set(other.variables)
    for name in one.variables:
        assert one[name].dims == other[name].dims, name
        assert one[name].dtype == other[name].dtype, name
        assert np.array_equal(one[name], other[name], equal_nan=one[name].dtype.kind == "f"), name
        assert str(one[name].attrs) == str(other[name].attrs), name
    for key in {*one.attrs, *other.attrs} - {*WHEN, *apart}:
        assert str(one.attrs.get(key)) == str(other.attrs.get(key)), key


def equals_the_loop(text: str, apart: tuple[str, ...] = (), **options: Any) -> xr.Dataset:
    """The scan of a scene with axes, which at each place is that of `--set` with the values there."""
    study = parse_scene(text)
    whole = scan(study, **options)
    variants = Variants(study)
    for number in range(variants.count):
        values = variants.overrides(number)
        here = at_one_place(selected(whole, values))
        # The scan lists axes that change the motion without contact first.
        assert sorted(json.loads(here.attrs.pop("overrides"))) == sorted(values)
        alone = scan(parse_scene(text, overrides=values), **options)
        alone.attrs.pop("overrides")
        same_scan(here, alone, apart)
    return whole
