"""Building types of FEMA's Hazus Earthquake Model, and the typology that each comes nearest to."""

from __future__ import annotations

from typing import NamedTuple


class Family(NamedTuple):
    """A structural type of Hazus, of any height: what it is, and its typology here, "" where none comes near."""

    words: str
    typology: str


# Types of the Hazus Earthquake Model technical manual, table 5.1. Moment frames that infills stiffen, and reinforced
# masonry, have the period of ASCE 7's "all other structural systems", which is that of the typology masonry.
FAMILIES = {
    "W1": Family("light wood frame", ""),
    "W2": Family("commercial or industrial wood frame", ""),
    "S1": Family("steel moment frame", "steel_frame"),
    "S2": Family("steel braced frame", "braced_frame"),
    "S3": Family("light metal frame", ""),
    "S4": Family("steel frame with concrete walls", "concrete_walls"),
    "S5": Family("steel frame with masonry infill", "masonry"),
    "C1": Family("concrete moment frame", "concrete_frame"),
    "C2": Family("concrete walls", "concrete_walls"),
    "C3": Family("concrete frame with masonry infill", "masonry"),
    "PC1": Family("precast tilt-up walls", "concrete_walls"),
    "PC2": Family("precast frame with concrete walls", "concrete_walls"),
    "RM1": Family("reinforced masonry with flexible floors", "masonry"),
    "RM2": Family("reinforced masonry with stiff floors", "masonry"),
    "URM": Family("unreinforced masonry walls", "masonry"),
    "MH": Family("mobile home", ""),
}
HEIGHTS = ("L", "M", "H")  # behind the family: low-rise, mid-rise, high-rise


def family_of(name: str) -> str:
    """The family of a type, "C1" of "C1M" and of "c1"; "" where it is none."""
    upper = name.strip().upper()
    short = upper[:-1] if upper.endswith(HEIGHTS) else upper
    return upper if upper in FAMILIES else short if short in FAMILIES else ""
