"""A dataset as `pounding-risk scan` writes it, of any shape, from random numbers that fit together: nothing is solved.

There is contact where the gap is smaller than the one that a motion needs, the force grows with what is missing,
and the yield force is reached where the uncapped force gets there.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from typing import Any

import numpy as np
import xarray as xr

from pounding_risk.models.structures.contact_points import Point, automatic_points
from pounding_risk.models.structures.sdof import Building
from pounding_risk.results.attributes import DATASET_VERSION, VERSION
from pounding_risk.results.labels import place_coordinates
from pounding_risk.results.variables import VARIABLES

CASE = ("record", "polarity", "contact_model", "gap", "yield_force")
PERIODS = np.geomspace(0.05, 5.0, 60)
CAPPED = ("viscous_elastoplastic", "van_mier")
LAWS = ("jankowski", "viscous_elastoplastic", "hertz_damp_exact", "kelvin_voigt", "hertz", "van_mier")
MEANINGS = "complete too_many_contacts step_underflow not_finite"
SCENE = """[scene]
name = "Made, not solved"

[[building]]
name = "left"
mass = "500000.0 kg"
period = "0.5 s"
damping = 0.05

[[building]]
name = "right"
mass = "800000.0 kg"
period = "1.0 s"
damping = 0.05

[[interface]]
gap = "{gap} m"
contact_model = "jankowski"
stiffness = "2750000000.0 N/m^1.5"
restitution = 0.65
yield_force = "inf"

[records]
names = []
polarity = ["as recorded", "reversed"]

[grid]

[solver]
rtol = 1e-06
"""


def made_scan(
    records: int = 6,
    gaps: Sequence[float] = (0.0, 0.02, 0.04, 0.06, 0.08),
    forces: Sequence[float] = (2e5, 5e5, np.inf),
    laws: int = 2,
    *,
    scene_gap: float = 0.04,
    failed: int = 0,
    seed: int = 20110314,
) -> xr.Dataset:
    """A dataset of so many records in two polarities; ``failed`` cases ended early."""
    random = np.random.default_rng(seed)
    needed = random.lognormal(np.log(0.04), 0.5, (records, 2))
    spaces, strengths = np.asarray(gaps, dtype=float), np.asarray(forces, dtype=float)
    names = LAWS[:laws]
    shape = (records, 2, laws, spaces.size, strengths.size)
    missing = np.broadcast_to((needed[:, :, None, None] - spaces[:, None])[:, :, None], shape)
    missing = np.maximum(missing, 0.0)
    touching = missing > 0.0
    stiff = random.lognormal(np.log(1.6e7), 0.1, (records, 2, laws, 1, 1))
    uncapped = stiff * np.sqrt(missing)
    capped = np.array([name in CAPPED for name in names])[:, None, None]
    force = np.where(capped, np.minimum(uncapped, strengths), uncapped)
    count = np.where(touching, 1 + np.floor(missing * 200.0), 0.0)
    ended = np.ones(shape, dtype=bool)
    ended.reshape(-1)[random.choice(ended.size, failed, replace=False)] = False

    def amount(values: Any, unit: str, words: str) -> Any:
        return CASE, np.where(ended, values, np.nan), {"units": unit, "long_name": words}

    def whole(values: Any, words: str) -> Any:
        return CASE, np.where(ended, values, -1).astype(np.int32), {"units": "1", "long_name": words}

    again = random.random(shape) < 0.01
    moved = np.where(again, random.lognormal(np.log(1e-9), 1.0, shape), np.nan)
    free = np.broadcast_to(needed[:, :, None, None, None], shape)
    reach = np.where(touching, spaces[:, None] + 0.7 * free, 1.1 * free)
    status = np.where(ended, 0, 1).astype(np.int8)
    variables = {
        "peak_relative_displacement": amount(reach, "m", "largest |u_left - u_right|"),
        "peak_closing": amount(np.where(touching, spaces[:, None] + force / 1e9, free), "m", "towards contact"),
        "peak_contact_force": amount(force, "N", "largest contact force"),
        "impact_count": whole(count, "contacts"),
        "yield_exceedance": whole(uncapped >= strengths, "1 where the uncapped force reaches the yield force"),
        "yield_demand": amount(uncapped / strengths, "1", "largest uncapped force over the yield force"),
        "energy_residual": amount(np.where(touching, random.random(shape) * 4e-7, 0.0), "1", "energy unaccounted for"),
        "restitution_held": whole(np.zeros(shape), "contacts beyond the range of the restitution relation"),
        "status": (CASE, status, {"flag_values": np.arange(4, dtype=np.int8), "flag_meanings": MEANINGS}),
        "simulated": (CASE, (touching | ~ended).astype(np.int8)),
        "sensitive": (CASE, np.where(again, (moved > 1e-8).astype(np.int8), -1).astype(np.int8)),
        "change_peak_relative_displacement": (CASE, moved),
        "change_peak_contact_force": (CASE, 3.0 * moved),
        "change_impact_count": (CASE, np.where(again, 0.0, np.nan)),
        "change_yield_exceedance": (CASE, np.where(again, 0.0, np.nan)),
        "peak_closing_free": (("record", "polarity"), needed, {"units": "m"}),
        "peak_displacement": ((*CASE, "building"), reach[..., None] * np.array([0.8, 1.0]), {"units": "m"}),
        "peak_displacement_free": (
            ("record", "polarity", "building"),
            needed[:, :, None] * np.array([0.7, 1.1]),
            {"units": "m"},
        ),
        "record_spectral_acceleration": (("record", "period"), _spectra(needed, random), {"units": "m/s2"}),
    }
    pair = [Building("left", 5e5, 0.5, 0.05), Building("right", 8e5, 1.0, 0.05)]
    points = [Point(0, *meeting) for meeting in automatic_points(*pair)]
    coords = place_coordinates(pair, points, strengths[:, None]) | _coordinates(
        records, names, (spaces, strengths), random
    )
    attributes = _attributes(records, scene_gap) | {VERSION: np.int64(DATASET_VERSION)}
    made = xr.Dataset(variables, coords=coords, attrs=attributes)
    by_interface = [name for name in made.data_vars if name in VARIABLES and "interface" in VARIABLES[str(name)].dims]
    return made.assign({name: made[name].expand_dims(interface=made["interface"], axis=-1) for name in by_interface})


def _spectra(needed: np.ndarray, random: np.random.Generator) -> np.ndarray:
    shape = np.minimum(np.minimum(1.0 + 3.0 * PERIODS / 0.1, 2.5), 1.25 / PERIODS)
    rough = np.exp(0.15 * random.standard_normal((len(needed), PERIODS.size)))
    return needed.mean(axis=1, keepdims=True) * 60.0 * shape * rough


def _coordinates(
    records: int, laws: Sequence[str], grid: tuple[Any, Any], random: np.random.Generator
) -> dict[str, Any]:
    gaps, forces = grid
    return {
        "record": ("record", [f"MADE-{number:02d}" for number in range(1, records + 1)]),
        "polarity": ("polarity", ["as recorded", "reversed"]),
        "contact_model": ("contact_model", list(laws)),
        "gap": ("gap", gaps, {"units": "m"}),
        "yield_force": ("yield_force", forces, {"units": "N"}),
        "building": ("building", ["left", "right"]),
        "building_mass": ("building", [5e5, 8e5], {"units": "kg"}),
        "building_period": ("building", [0.5, 1.0], {"units": "s"}),
        "building_damping": ("building", [0.05, 0.05], {"units": "1"}),
        "period": ("period", PERIODS, {"units": "s"}),
        "record_pga": ("record", random.uniform(1.0, 6.0, records), {"units": "m/s2"}),
    }


def _attributes(records: int, scene_gap: float) -> dict[str, Any]:
    names = [f"MADE-{number:02d}" for number in range(1, records + 1)]
    facts = [
        {
            "name": name,
            "event": "None, made up",
            "date": "2000-01-01",
            "magnitude": 6.5,
            "station": f"S{place}",
            "dt": 0.01,
        }
        | {"state": "processed", "file": f"{name}.AT2", "format": "PEER_AT2", "sha256": f"{place:064x}"}
        for place, name in enumerate(names)
    ]
    scene = SCENE.format(gap=scene_gap)
    return {
        "title": "Made, not solved",
        "references": "Jankowski (2005, 2006); Khatiwada et al. (2011) eq. 3, 3a, 3b",
        "scene": scene,
        "scene_resolved": scene,
        "rtol": 1e-6,
        "restitution": "0.65",
        "restitution_relation": "published",
        "overrides": "[]",
        "records": json.dumps(facts),
        "processing": json.dumps({name: ["units: g, times 9.80665 m/s²"] for name in names}),
        "flags": json.dumps({names[0]: ["the motion starts at 2.1 % of its PGA: a late trigger, or a cut in motion"]}),
        "versions": json.dumps({"pounding-risk": "0.1.0", "python": "3.11"}),
    }
