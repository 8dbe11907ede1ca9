"""The table of the dataset of one run: histories and contacts with their dimensions, units and words.

The outputs of a run are those of a scan's case, and stand in `results.variables`. No solver is imported.
"""

from __future__ import annotations

TIME = ("time",)
FLOORS = ("time", "building", "storey")
POINTS = ("time", "contact_point")
GROUND = "ground acceleration; on unlike grounds that under the first building"
MOVED = (
    "displacement of the ground under the building since 0 s: the double integral of the ground acceleration, from the "
    "ground velocity of the scene; a record without baseline correction drifts"
)
HISTORIES = {
    "displacement": (FLOORS, "m", "displacement of the floor relative to the ground under the building"),
    "velocity": (FLOORS, "m/s", "velocity of the floor relative to the ground under the building"),
    "absolute_displacement": (FLOORS, "m", "displacement of the floor in space: displacement + ground_displacement"),
    "relative_displacement": (POINTS, "m", "what closes the gap: u_left - u_right, and what the ground adds"),
    "contact_force": (POINTS, "N", "contact force, compression positive"),
    "contact_impulse_so_far": (POINTS, "N s", "impulse of the contact force up to this instant"),
    "ground_acceleration": (TIME, "m/s2", GROUND),
    "building_ground_acceleration": (("time", "building"), "m/s2", "ground acceleration under the building"),
    "ground_displacement": (("time", "building"), "m", MOVED),
    "ground_widening": (("time", "interface"), "m", "widening of the ground between the buildings, x_right - x_left"),
    "energy_ground": (TIME, "J", "work that the ground has done on all buildings"),
    "energy_held": (TIME, "J", "kinetic and strain energy of all buildings"),
    "energy_contact": (TIME, "J", "work of the contact force, dissipated and stored"),
    "energy_damping": (TIME, "J", "energy that the structures' dampers have taken"),
}
GROUNDS = (
    "ground_acceleration",
    "building_ground_acceleration",
    "ground_displacement",
    "ground_widening",
)  # known after a failure too
CONTACTS = {
    "start": ("s", "touch"),
    "end": ("s", "parting, or the end of the record"),
    "approach_speed": ("m/s", "relative speed at the touch"),
    "restitution_asked": ("1", "restitution that the relation gives for this speed"),
    "peak_force": ("N", "largest force transmitted"),
    "uncapped_force": ("N", "largest force without the cap"),
    "peak_penetration": ("m", "largest penetration"),
    "yields": ("1", "times the uncapped force rose through the yield force"),
    "rebound_speed": ("m/s", "relative speed at the parting"),
    "impulse": ("N s", "impulse of the contact force"),
    "work": ("J", "work of the contact force: what the contact took"),
}
CONTACT_PLACE = {"long_name": "contact point of the contact"}
BUILDING = {"long_name": "building, left to right"}
FORCE_OF_RUN = ("N", "yield force F_E")
GAP_OF_RUN = ("m", "clear distance at rest")
