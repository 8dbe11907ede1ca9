"""A dataset of a row as `pounding-risk scan` writes it, from random numbers that fit together: nothing is solved.

There is contact at a point where its gap is smaller than what the motion closes there, the force grows with what is
missing, floors above a contact drift more, and the floors that touch are shaken most.
"""

from __future__ import annotations

import json
from collections.abc import Sequence
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

G = 9.80665
COLUMN_FORCE = 3e5  # N
MOTION = ("record", "polarity", "pga")
CASE = (*MOTION, "contact_model", "gap", "yield_force")
PERIODS = np.geomspace(0.05, 5.0, 60)
MEANINGS = "complete too_many_contacts step_underflow not_finite"


class Made(NamedTuple):
    """One building: storeys (0 is rigid), their height [m], period [s], the roof's usual displacement [m]."""

    name: str
    storeys: int
    storey_height: float
    period: float
    reach: float


STREET = (
    Made("Corner", 5, 3.2, 0.62, 0.050),
    Made("Arcade", 3, 3.2, 0.38, 0.030),
    Made("Theatre", 2, 4.6, 0.30, 0.018),
    Made("Tower", 7, 3.2, 0.85, 0.070),
    Made("Kiosk", 1, 4.0, 0.20, 0.010),
    Made("Vault", 0, 0.0, np.nan, 0.0),
)


def made_row(
    records: int = 6,
    gaps: Sequence[float] = (0.0, 0.02, 0.05),
    forces: Sequence[float] = (4e5, np.inf),
    *,
    named: int | None = None,
    own_gaps: Sequence[float] = (0.02, 0.02, 0.02, 0.02, 0.02),
    effects: str = "",
    failed: bool = False,
    seed: int = 7,
    street: Sequence[Made] = STREET,
) -> xr.Dataset:
    """A row of buildings, two amplitudes, one contact model. ``named``: the interface whose gap alone varies."""
    random = np.random.default_rng(seed)
    points = [point for at, (one, other) in enumerate(pairwise(street)) for point in _points(at, one, other)]
    free = _free(random, records, street)
    at_points = np.stack([_closing(free, point, random, street) for point in points], axis=-1)
    spaces = np.tile(np.asarray(gaps, dtype=float)[:, None], (1, len(street) - 1))
    if named is not None:
        spaces[:] = own_gaps
        spaces[:, named] = gaps
    variables = _at_points(at_points, points, spaces, np.asarray(forces, dtype=float))
    variables |= _of_storeys(free, variables["contact_point_impact_count"][1], points)
    variables |= _of_runs(variables, records, random)
    dataset = xr.Dataset(variables, coords=_coordinates(records, points, gaps, forces, random, street))
    if named is not None:
        dataset = dataset.assign_coords(interface_gap=(("gap", "interface"), spaces, {"units": "m"}))
    dataset.attrs = _attributes(records, own_gaps[: len(street) - 1], effects, street)
    return _with_a_failure(dataset) if failed else dataset


def _points(at: int, one: Made, other: Made) -> list[tuple[int, float, float, str, float]]:
    """Every floor against the floor at its level, or the column there, up to the lower roof."""
    if not other.storeys or not one.storeys:
        level = max(one.storeys * one.storey_height, other.storeys * other.storey_height)
        return [(at, float(one.storeys or 1), float(other.storeys or 1), "floor", level)]
    heights = [side.storey_height for side in (one, other)]
    roofs = [side.storeys * side.storey_height for side in (one, other)]
    levels = {
        round(h * n, 6) for h, side in zip(heights, (one, other), strict=True) for n in range(1, side.storeys + 1)
    }
    found = []
    for level in sorted(level for level in levels if level <= min(roofs) + 1e-9):
        floors = [round(level / h, 6) for h in heights]
        kind = "floor" if all(abs(floor - round(floor)) < 1e-3 for floor in floors) else "column"
        found.append((at, floors[0], floors[1], kind, level))
    return found


def _free(random: np.random.Generator, records: int, street: Sequence[Made]) -> np.ndarray:
    """Largest displacement without contact of (record, polarity, pga, building, storey); NaN where there is none."""
    strength = random.lognormal(0.0, 0.4, (records, 2, 1, 1, 1)) * np.array([1.0, 2.0])[:, None, None]
    own = random.lognormal(0.0, 0.25, (records, 2, 1, len(street), 1))
    shape = np.full((len(street), max(each.storeys for each in street)), np.nan)
    for at, each in enumerate(street):
        floors = np.arange(1, each.storeys + 1)
        shape[at, : each.storeys] = each.reach * (floors / max(each.storeys, 1)) ** 1.1
    return np.asarray(strength * own * shape)


def _at_floor(free: np.ndarray, building: int, floor: float, street: Sequence[Made]) -> np.ndarray:
    """The displacement at a floor or between two, 0 at the ground."""
    whole = np.concatenate([np.zeros((*free.shape[:3], 1)), np.nan_to_num(free[..., building, :])], axis=-1)
    low = min(int(floor), street[building].storeys)
    share = floor - low
    return whole[..., low] * (1.0 - share) + (share * whole[..., low + 1] if share else 0.0)


def _closing(free: np.ndarray, point: Any, random: np.random.Generator, street: Sequence[Made]) -> np.ndarray:
    at, left, right = point[:3]
    both = _at_floor(free, at, left, street) + _at_floor(free, at + 1, right, street)
    return both * random.uniform(0.55, 0.85, both.shape)


def _at_points(closing: np.ndarray, points: Sequence[Any], spaces: np.ndarray, forces: np.ndarray) -> dict[str, Any]:
    """Contact at every point, and gathered by interface; a column yields at a force of its own."""
    places = np.array([point[0] for point in points])
    missing = np.maximum(
        closing[:, :, :, None, None, None, :] - spaces[:, places][None, None, None, None, :, None], 0.0
    )
    missing = np.repeat(missing, forces.size, axis=-2)
    column = np.array([point[3] == "column" for point in points])
    strength = np.where(column, COLUMN_FORCE, forces[:, None])
    uncapped = 1.2e7 * missing**0.7
    force = np.minimum(uncapped, strength)
    count = np.where(missing > 0.0, 1 + np.floor(missing * 100.0), 0).astype(np.int32)
    yields = ((missing > 0.0) & (uncapped >= strength)).astype(np.int32)
    raw = {
        "impact_count": (count, "1", "sum", "contacts"),
        "peak_contact_force": (force, "N", "max", "largest contact force transmitted"),
        "peak_penetration": (missing * 0.01, "m", "max", "largest penetration"),
        "impulse": (force * 0.02, "N s", "sum", "total impulse of the contact force"),
        "yield_exceedance": (yields, "1", "max", "1 where the uncapped force reaches the yield force"),
        "yield_demand": (uncapped / strength, "1", "max", "largest uncapped force over the yield force"),
        "energy_viscous": (force * 1e-3, "J", "sum", "energy that the contact's damper takes"),
    }
    found: dict[str, Any] = {}
    for name, (values, unit, how, words) in raw.items():
        about = {"units": unit, "long_name": words}
        found[f"contact_point_{name}"] = ((*CASE, "contact_point"), values, about)
        whole = [getattr(values[..., places == at], how)(axis=-1) for at in range(spaces.shape[1])]
        found[name] = ((*CASE, "interface"), np.stack(whole, axis=-1).astype(values.dtype), about)
    free = [closing[..., places == at].max(axis=-1) for at in range(spaces.shape[1])]
    found["peak_closing_free"] = (
        (*MOTION, "interface"),
        np.stack(free, axis=-1),
        {"units": "m", "long_name": "needed"},
    )
    found["contact_point_peak_closing_free"] = (
        (*MOTION, "contact_point"),
        closing,
        {"units": "m", "long_name": "here"},
    )
    reach = found["peak_closing_free"][1][:, :, :, None, None, None] * np.where(found["impact_count"][1] > 0, 0.8, 1.1)
    alone = found["peak_closing_free"][1][:, :, :, None, None, None]
    spread = np.where(found["impact_count"][1] > 0, spaces[:, None] + 1e-3, alone)
    found["peak_closing"] = ((*CASE, "interface"), spread, {"units": "m", "long_name": "towards contact"})
    about = {"units": "m", "long_name": "largest |u_left - u_right|"}
    found["peak_relative_displacement"] = ((*CASE, "interface"), reach, about)
    return found


def _of_storeys(free: np.ndarray, count: np.ndarray, points: Sequence[Any]) -> dict[str, Any]:
    """Displacement, drift, shear and acceleration of every storey, and the largest of each building."""
    drift = np.diff(np.concatenate([np.zeros((*free.shape[:4], 1)), free], axis=-1), axis=-1)
    raised = np.ones((*count.shape[:-1], *free.shape[3:]))
    shaken = raised.copy()
    for place, (at, left, right, _, _) in enumerate(points):
        for building, floor in ((at, left), (at + 1, right)):
            touched = count[..., place] > 0
            first = min(int(np.ceil(floor)), free.shape[4])
            raised[..., building, first:] *= np.where(touched, 1.25, 1.0)[..., None]
            raised[..., building, :first] *= np.where(touched, 0.94, 1.0)[..., None]
            if first:
                shaken[..., building, first - 1] *= np.where(touched, 2.5, 1.1)
    several = (slice(None),) * 3 + (None,) * 3
    found: dict[str, Any] = {}
    alone = {"displacement": (free, "m"), "drift": (drift, "m"), "shear": (drift * 2.5e8, "N")}
    alone["acceleration"] = (free * 90.0 + 1.5, "m/s2")
    peaks = {"displacement": "peak_displacement", "drift": "peak_drift", "shear": "peak_storey_shear"}
    for name, (values, unit) in alone.items():
        factor = shaken if name == "acceleration" else raised
        told = {"units": unit, "long_name": f"largest storey {name}"}
        whole = peaks.get(name, "peak_floor_acceleration")
        for suffix, dims, each in (("", CASE, values[several] * factor), ("_free", MOTION, values)):
            found[f"storey_{name}{suffix}"] = ((*dims, "building", "storey"), each, told)
            found[f"{whole}{suffix}"] = ((*dims, "building"), np.nan_to_num(each).max(axis=-1), told)
    return found


def _of_runs(variables: dict[str, Any], records: int, random: np.random.Generator) -> dict[str, Any]:
    count = variables["impact_count"][1]
    touched = (count > 0).any(axis=-1)
    flags = {"flag_values": np.arange(4, dtype=np.int8), "flag_meanings": MEANINGS}
    spectra = 2.0 * np.minimum(np.minimum(1.0 + 15.0 * PERIODS, 2.5), 1.25 / PERIODS)
    spectra = spectra * random.lognormal(0.0, 0.2, (records, PERIODS.size))
    return {
        "status": (CASE, np.zeros(touched.shape, dtype=np.int8), flags),
        "simulated": (CASE, touched.astype(np.int8)),
        "row_impulse": (
            CASE,
            variables["impulse"][1].sum(axis=-1),
            {"units": "N s", "long_name": "impulse of the row"},
        ),
        "row_energy_lost": (CASE, variables["energy_viscous"][1].sum(axis=-1), {"units": "J", "long_name": "lost"}),
        "record_spectral_acceleration": (("record", "period"), spectra, {"units": "m/s2"}),
    }


def _coordinates(
    records: int,
    points: Sequence[Any],
    gaps: Sequence[float],
    forces: Sequence[float],
    random: np.random.Generator,
    street: Sequence[Made],
) -> dict[str, Any]:
    names = [each.name for each in street]
    most = max(each.storeys for each in street)
    levels = np.full((len(street), most), np.nan)
    for at, each in enumerate(street):
        levels[at, : each.storeys] = each.storey_height * np.arange(1, each.storeys + 1)
    labels = [f"{names[at]} {left:g} | {names[at + 1]} {right:g}" for at, left, right, _, _ in points]
    heights = [each.storeys * each.storey_height or np.nan for each in street]
    return {
        "record": [f"MADE-{number:02d}" for number in range(1, records + 1)],
        "polarity": ["as recorded", "reversed"],
        "pga": ("pga", [0.2 * G, 0.4 * G], {"units": "m/s2"}),
        "contact_model": ["viscous_elastoplastic"],
        "gap": ("gap", np.asarray(gaps, dtype=float), {"units": "m"}),
        "yield_force": ("yield_force", np.asarray(forces, dtype=float), {"units": "N"}),
        "interface": [f"{one} | {other}" for one, other in pairwise(names)],
        "contact_point": labels,
        "building": names,
        "storey": np.arange(1, most + 1),
        "period": ("period", PERIODS, {"units": "s"}),
        "contact_point_interface": ("contact_point", [point[0] for point in points]),
        "contact_point_left_floor": ("contact_point", [point[1] for point in points]),
        "contact_point_right_floor": ("contact_point", [point[2] for point in points]),
        "contact_point_kind": ("contact_point", [point[3] for point in points]),
        "contact_point_yield_force": (
            ("yield_force", "contact_point"),
            [[COLUMN_FORCE if point[3] == "column" else force for point in points] for force in forces],
            {"units": "N"},
        ),
        "contact_point_level": ("contact_point", [point[4] for point in points], {"units": "m"}),
        "building_mass": ("building", [2e5 * each.storeys or np.nan for each in street], {"units": "kg"}),
        "building_period": ("building", [each.period for each in street], {"units": "s"}),
        "building_damping": ("building", [0.05 if each.storeys else np.nan for each in street], {"units": "1"}),
        "building_height": ("building", heights, {"units": "m"}),
        "building_storeys": ("building", [each.storeys for each in street]),
        "building_position": ("building", ["end", *["interior"] * (len(street) - 2), "end"]),
        "floor_level": (("building", "storey"), levels, {"units": "m"}),
        "record_pga": ("record", random.uniform(1.0, 6.0, records), {"units": "m/s2"}),
    }


def _attributes(records: int, own_gaps: Sequence[float], effects: str, street: Sequence[Made]) -> dict[str, Any]:
    scene = '[scene]\nname = "A street, made, not solved"\n'
    for each in street:
        kind = f'floor_masses = "200000 kg"\nstoreys = {each.storeys}' if each.storeys else "rigid = true"
        scene += f'\n[[building]]\nname = "{each.name}"\n{kind}\n'
    for gap in own_gaps:
        scene += (
            f'\n[[interface]]\ngap = "{gap} m"\ncontact_model = "viscous_elastoplastic"\nyield_force = "400000 N"\n'
        )
    scene += f"\n[effects]\n{effects}\n"
    facts = [{"name": f"MADE-{number:02d}", "station": f"S{number}"} for number in range(1, records + 1)]
    return {
        "title": "A street, made, not solved",
        "source": "pounding_risk: event-driven row solver",
        "references": "Khatiwada et al. (2011) eq. 3, 3a, 3b",
        "scene": scene,
        "scene_resolved": scene,
        "rtol": 1e-6,
        "restitution": "0.65",
        "restitution_relation": "published",
        "records": json.dumps(facts),
        "processing": json.dumps({each["name"]: ["units: g, times 9.80665 m/s²"] for each in facts}),
        "versions": json.dumps({"pounding-risk": "0.1.0", "python": "3.11"}),
    }


def _with_a_failure(dataset: xr.Dataset) -> xr.Dataset:
    """The first motion's run at the larger amplitude, the smallest gap and F_E did not complete."""
    place = {"record": 0, "polarity": 0, "pga": 1, "contact_model": 0, "gap": 0, "yield_force": 0}
    for name, found in dataset.data_vars.items():
        if set(CASE) <= set(found.dims) and name not in ("status", "simulated"):
            found[place] = np.nan if found.dtype.kind == "f" else -1
    dataset["status"][place] = 2
    return dataset


def made_run(seconds: float = 20.0, gap: float = 0.02, dt: float = 0.005) -> xr.Dataset:
    """One run of the same row with its histories: each building swings at its period, forces are pulses."""
    row = made_row(records=2)
    time = np.arange(0.0, seconds + dt / 2, dt)
    swell = np.sin(np.pi * time / seconds) ** 2
    moved = np.full((time.size, len(STREET), row.sizes["storey"]), np.nan)
    for at, each in enumerate(STREET):
        for floor in range(each.storeys):
            phase = 2.0 * np.pi * time / each.period + at
            moved[:, at, floor] = each.reach * ((floor + 1) / each.storeys) ** 1.1 * swell * np.sin(phase)
    force = np.zeros((time.size, row.sizes["contact_point"]))
    for place in range(row.sizes["contact_point"]):
        at = int(row["contact_point_interface"][place])
        floors = [float(row[f"contact_point_{name}_floor"][place]) for name in ("left", "right")]
        left, right = (
            _at_floor(moved[:, None, None], at + side, floor, STREET)[:, 0, 0] for side, floor in enumerate(floors)
        )
        force[:, place] = 5e7 * np.maximum(left - right - gap, 0.0)
    coordinates = [name for name in row.coords if set(row[name].dims) & {"building", "contact_point", "interface"}]
    run = xr.Dataset(
        {
            "displacement": (("time", "building", "storey"), moved, {"units": "m"}),
            "contact_force": (("time", "contact_point"), force, {"units": "N"}),
        },
        coords={"time": ("time", time, {"units": "s"})}
        | {name: row[name].isel(yield_force=0, missing_dims="ignore") for name in coordinates},
    )
    facts = {"title": "A street, made, not solved", "record": "MADE-01", "polarity": "as recorded", "pga": 0.4 * G}
    return run.assign_attrs(facts, contact_model="viscous_elastoplastic", gap=gap)
