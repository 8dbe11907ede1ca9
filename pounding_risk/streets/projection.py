"""Coordinates of any reference system as metres of a plane about the middle of a file, and as degrees of WGS 84."""

from __future__ import annotations

from math import pi
from typing import Any, NamedTuple

import numpy as np
from pyproj import CRS, Transformer
from pyproj.exceptions import CRSError

from pounding_risk.streets.footprints import Array
from pounding_risk.streets.table import DEGREE

DEGREES = "OGC:CRS84"  # longitude and latitude on WGS 84, in this order


class Projection(NamedTuple):
    """From a coordinate reference system to metres east and north of a place, and to longitude and latitude.

    The plane is a transverse Mercator projection on the system's own ellipsoid, with the scale 1 at the place: angles
    hold, and so do lengths to 1 + x² / (2 R²), some 3e-7 at 5 km from it.
    """

    system: Any
    to_metres: Any
    to_degrees: Any

    @classmethod
    def about(cls, corners: Array, system: Any) -> Projection:
        """The projection about the mean corner (n, 2) of coordinates in a system."""
        to_degrees = Transformer.from_crs(system, DEGREES, always_xy=True)
        degrees = np.column_stack(to_degrees.transform(*corners.T))
        degrees = degrees[np.isfinite(degrees).all(axis=1)]
        if not len(degrees):
            degrees = np.zeros((1, 2))
        latitude, first = float(degrees[:, 1].mean()), float(degrees[0, 0])
        # Across the meridian of 180 degrees longitudes go on.
        longitude = float(np.mean((degrees[:, 0] - first + 180.0) % 360.0 - 180.0)) + first
        ellipsoid = system.ellipsoid
        shape = f"+a={ellipsoid.semi_major_metre!r} +b={ellipsoid.semi_minor_metre!r}"
        local = f"+proj=tmerc +lat_0={latitude!r} +lon_0={longitude!r} +k=1 {shape} +units=m +type=crs"
        # A plane on an ellipsoid alone: PROJ shifts no datum on the way.
        return cls(system, Transformer.from_crs(system, CRS(local), always_xy=True), to_degrees)

    def metres(self, corners: Array) -> Array:
        """Coordinates (n, 2) as metres east and north of the middle."""
        return np.column_stack(self.to_metres.transform(*corners.T))

    def degrees(self, corners: Array) -> Array:
        """Coordinates (n, 2) as longitude and latitude."""
        return np.column_stack(self.to_degrees.transform(*corners.T))

    @property
    def unit(self) -> float:
        """One of the system's units on the ground, m."""
        factor = float(self.system.axis_info[0].unit_conversion_factor)
        return factor * 180.0 / pi * DEGREE if self.system.is_geographic else factor


def system_of(given: Any) -> Any:
    """The horizontal coordinate reference system that a file states, None where it states none; raises ValueError."""
    try:
        system: Any = CRS.from_user_input(given)
    except CRSError as error:
        reason = " ".join(str(error).split())[:200]
        raise ValueError(f"its coordinate reference system cannot be read ({reason})") from None
    if system.is_compound:
        system = system.sub_crs_list[0]
    if system.is_bound:
        system = system.source_crs
    if system is None or system.name.lower().startswith(("undefined", "unknown", "undetermined")):
        return None
    if not (system.is_geographic or system.is_projected):
        raise ValueError(f"its coordinate reference system, {system.name}, is tied to no place on the Earth")
    return system.to_2d()
