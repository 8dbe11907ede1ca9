"""The table of a scan's dataset: every variable and coordinate with its dimensions, unit and kind.

A variable lives at the cases alone, or at each building, storey, interface or contact point of each case. Those known
without contact live at the motions. No solver is imported.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from pounding_risk.motions.levels import LEVEL_AXIS, PGA_AXIS
from pounding_risk.results.layout import AXES
from pounding_risk.results.tolerance_check import COUNTED, RELATIVE

MOTION = AXES[:3]
NUMBER, WHOLE, TEXT = "iuf", "iu", "UOT"  # kinds of dtypes; netCDF gives texts as objects


class Declared(NamedTuple):
    """A variable or coordinate of a scan's dataset."""

    dims: tuple[str, ...]
    unit: str | None = None  # None for texts, flags and what has no unit of its own
    kinds: str = NUMBER


def _declared(dims: tuple[str, ...], names: Mapping[str, str], kinds: str = NUMBER, wrap: str = "{}") -> Any:
    """Declarations of variables with the same dimensions, from their names by unit; "" is no unit."""
    pairs = ((unit, name) for unit, text in names.items() for name in text.split())
    return {wrap.format(name): Declared(dims, unit or None, kinds) for unit, name in pairs}


STOREYS = ("building", "storey")
# Outputs of a run at each interface, and some of them at each contact point, by unit.
OF_RUNS = {
    "m": "peak_relative_displacement peak_closing peak_opening peak_penetration permanent_set",
    "s": "first_impact_time contact_time first_yield_time",
    "m/s": "peak_approach_speed",
    "N": "peak_contact_force lowest_contact_force",
    "N s": "impulse",
    "J": "energy_viscous energy_plastic",
    "1": "impact_count yield_exceedance yield_demand yield_count energy_residual restitution_held",
}
OF_BUILDINGS = {"m": "peak_displacement peak_drift", "N": "peak_storey_shear", "m/s2": "peak_floor_acceleration"}
OF_STOREYS = {
    "m": "storey_displacement storey_drift storey_residual_drift",
    "N": "storey_shear",
    "m/s2": "storey_acceleration",
    "J": "storey_energy",
    "s": "storey_collapse_time",
    "1": "storey_ductility storey_strength_left",
}
OF_LINKS = {
    "m": "peak_link_stretch peak_link_shortening",
    "N": "peak_link_spring_force peak_link_damper_force",
    "J": "link_energy",
    "1": "broken_links",
}
CHANGES = tuple(f"change_{name}" for name in (*RELATIVE, *COUNTED))

VARIABLES: dict[str, Declared] = {
    **_declared((*AXES, "interface"), OF_RUNS),
    **_declared((*AXES, "contact_point"), OF_RUNS, wrap="contact_point_{}"),
    **_declared((*AXES, "building"), OF_BUILDINGS),
    **_declared((*MOTION, "building"), OF_BUILDINGS, wrap="{}_free"),
    **_declared((*AXES, *STOREYS), OF_STOREYS),
    **_declared((*MOTION, *STOREYS), OF_STOREYS, wrap="{}_free"),
    **_declared(AXES, {"N s": "row_impulse", "J": "row_energy_lost", "1": " ".join(CHANGES)}),
    **_declared((*MOTION, "interface"), {"m": "peak_closing_free"}),
    **_declared((*AXES, "interface"), OF_LINKS),
    **_declared((*MOTION, "interface"), OF_LINKS, wrap="{}_free"),
    **_declared((*MOTION, "contact_point"), {"m": "contact_point_peak_closing_free"}),
    **_declared(("record", "period"), {"m/s2": "record_spectral_acceleration"}),
    **_declared(AXES, {"": "status simulated sensitive"}, WHOLE),
}
NAMED = ("record", "polarity", "contact_model", "building", "interface", "contact_point")
COORDINATES: dict[str, Declared] = {axis: Declared((axis,), None, TEXT) for axis in NAMED} | {
    "pga": Declared(("pga",), "m/s2"),
    "gap": Declared(("gap",), "m"),
    "yield_force": Declared(("yield_force",), "N"),
    "period": Declared(("period",), "s"),
    LEVEL_AXIS: Declared((LEVEL_AXIS,)),  # in the unit of the measure
    "storey": Declared(("storey",), "1", WHOLE),
    **_declared(("record",), {"": "record_event record_sha256"}, TEXT),
    **_declared(
        ("record",),
        {"m/s2": "record_pga", "1": "record_magnitude", "km": "record_distance", "m/s": "record_vs30 record_pgv"},
    ),
    **_declared(("record",), {"1": "record_recording"}, WHOLE),
    **_declared(("record", "interface"), {"m": "record_ground_widening_largest record_ground_widening_end"}),
    **_declared(("record", "pga"), {"m/s2": "record_pga_felt", "1": "record_scale_factor"}),
    **_declared(
        ("building",), {"kg": "building_mass", "s": "building_period", "1": "building_damping", "m": "building_height"}
    ),
    **_declared(("building",), {"s": "building_isolated_period"}),
    **_declared(("building",), {"1": "building_storeys"}, WHOLE),
    **_declared(("building",), {"": "building_position"}, TEXT),
    **_declared(("gap", "interface"), {"m": "interface_gap"}),
    **_declared(("interface",), {"m": "interface_bumper"}),
    **_declared(("contact_point",), {"": "contact_point_interface"}, WHOLE),
    **_declared(("contact_point",), {"m": "contact_point_level"}),
    **_declared(("contact_point",), {"": "contact_point_kind"}, TEXT),
    **_declared(("contact_point",), {"1": "contact_point_left_floor contact_point_right_floor"}),
    **_declared(("yield_force", "contact_point"), {"N": "contact_point_yield_force"}),
    **_declared(STOREYS, {"m": "floor_level"}),
}


# Status of a case that is not run as a building whose motion is known would have to be pushed; the solvers have others.
UNPUSHED, UNPUSHED_SENTENCE = 8, "not run: contact with a known motion, which cannot be pushed"
NOT_RUN = "not run, as a known motion would have to be pushed"  # of such cases, where they are counted
PLACES = ("interface", "contact_point", "building", "storey")  # where a variable may live, beside the cases


def own_dims(name: str) -> tuple[str, ...]:
    """The dimensions of a variable or coordinate of this table beside the axes of the cases.

    Raises LookupError for one that a solver has and this table has not.
    """
    declared = (VARIABLES | COORDINATES).get(name)
    if declared is None:
        raise LookupError(f"{name}: VARIABLES in pounding_risk/results/variables.py has no row for it; add one there")
    return tuple(dim for dim in declared.dims if dim not in AXES)


def unit_of(name: str) -> str:
    """The unit of a variable of this table, "1" for a flag."""
    return VARIABLES[name].unit or "1"


def coordinates(labels: Mapping[str, tuple[Any, str]], amplitudes: str = PGA_AXIS) -> dict[str, Any]:
    """Coordinates as xarray takes them, from values and words: dimensions and units are those declared here.

    ``amplitudes`` is the axis of the amplitudes.
    """
    coords = {}
    for name, (values, words) in labels.items():
        dims, unit, _ = COORDINATES[name]
        attributes = {"long_name": words} if unit is None else described(unit, words)
        coords[name] = (tuple(amplitudes if dim == PGA_AXIS else dim for dim in dims), values, attributes)
    return coords


def described(unit: str, words: str) -> dict[str, str]:
    """Attributes of a variable or coordinate: unit and long name."""
    return {"units": unit, "long_name": words}


ENDS = {"": "", "_low": "lower bound: ", "_high": "upper bound: "}


def bounded(name: str, dims: Any, columns: Iterable[Any], unit: str, words: str) -> dict[str, Any]:
    """Three variables, of a value, its lower and its upper bound."""
    pairs = zip(ENDS.items(), columns, strict=True)
    return {f"{name}{end}": (dims, column, described(unit, f"{bound}{words}")) for (end, bound), column in pairs}
