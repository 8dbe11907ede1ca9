"""Places by longitude and latitude, the distance between two, and the site of a list that is requested.

>>> from pounding_risk.motions.sites.places import Place, distance, read_site
>>> round(distance(Place(23.73, 37.98), Place(22.94, 40.64)), 0)  # km, Athens to Thessaloniki
304.0
>>> read_site("23.73, 37.98 within 20 km")
SiteRequest(place=Place(longitude=23.73, latitude=37.98), id='', within=20.0)
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import asin, ceil, cos, inf, isfinite, radians, sin, sqrt
from pathlib import Path
from typing import NamedTuple

from pounding_risk._common.tables import Row, Table
from pounding_risk._common.words import nearest as nearest_word
from pounding_risk.errors import RecordError
from pounding_risk.units import Quantity, QuantityError, parse, shown

RADIUS = 6371.0088  # km, mean radius of the earth
FARTHEST = 10.0  # km, from a place to the site that stands for it, where no other distance is given
LENGTH = Quantity("m", 0.0, inf, "distance", example="20 km")
EXAMPLE = 'write longitude and latitude in degrees, such as "23.73, 37.98"'
CHOOSE = f"choose one with --site, or #LONGITUDE,LATITUDE after the name of the file: {EXAMPLE}"
_NUMBER = r"[+-]?(?:\d+\.?\d*|\.\d+)"
_SITE = re.compile(rf"\s*({_NUMBER})\s*(?:,|\s)\s*({_NUMBER})\s*(?:\bwithin\b\s*(.+?))?\s*")


class Place(NamedTuple):
    """A place on the earth [degrees], east and north positive."""

    longitude: float
    latitude: float

    def __str__(self) -> str:
        return f"{self.longitude:.6g}, {self.latitude:.6g}"


class SiteRequest(NamedTuple):
    """The site that is requested: the nearest to a place, no farther than ``within`` [km], or the one of an id."""

    place: Place | None
    id: str = ""
    within: float = FARTHEST


class Site(NamedTuple):
    """A site of a list: its position in it, its place, and its distance [km] from the place requested."""

    position: int
    place: Place
    distance: float = 0.0


def distance(first: Place, second: Place) -> float:
    """Distance [km] along the great circle of a sphere, within 0.6 % of that on the ellipsoid."""
    turn, rise = (radians(second[axis] - first[axis]) for axis in (0, 1))
    square = sin(rise / 2) ** 2 + cos(radians(first.latitude)) * cos(radians(second.latitude)) * sin(turn / 2) ** 2
    return 2.0 * RADIUS * asin(min(1.0, sqrt(square)))


def place(longitude: float, latitude: float, where: str) -> Place:
    """A place whose numbers are degrees; raises RecordError, which begins with ``where``, for others."""
    for name, value, most in (("longitude", longitude, 360.0), ("latitude", latitude, 90.0)):
        if not (isfinite(value) and -min(most, 180.0) <= value <= most):
            raise RecordError(
                f"{where}: the {name} is {value:g}, and it goes from {-min(most, 180.0):g} to {most:g} degrees; "
                "check the order, longitude first, and that both are degrees"
            )
    return Place(longitude, latitude)


def read_site(text: str, where: str = "site") -> SiteRequest:
    """The site that a text names: ``23.73, 37.98``, that ``within 20 km``, or an id of the list.

    Raises RecordError, which begins with ``where``, for a place that is none and a distance that is none.
    """
    match = _SITE.fullmatch(text)
    if match is None:
        if not text.strip() or "," in text or "within" in text:
            raise RecordError(f"{where}: {shown(text)} is no site; {EXAMPLE}, with 'within 20 km' after it, or an id")
        return SiteRequest(None, text.strip())
    try:
        within = parse(match[3], LENGTH) / 1e3 if match[3] else FARTHEST
    except QuantityError as error:
        raise RecordError(f"{where}: within {shown(match[3])} is no distance ({error}); write 'within 20 km'") from None
    return SiteRequest(place(float(match[1]), float(match[2]), where), within=within)


def nearest(places: Sequence[Place], at: Place) -> Site:
    """The nearest of some places, the first of several that are equally near."""
    away = [distance(at, one) for one in places]
    position = away.index(min(away))
    return Site(position, places[position], away[position])


def find_site(
    places: Sequence[Place], ids: Sequence[str], wanted: SiteRequest | None, where: str, choose: str = CHOOSE
) -> Site:
    """The site of a list that is requested, or the only one where none is.

    ``ids`` are empty where the places have none. Raises RecordError, which begins with the list, ``where``, for several
    sites where none is requested (``choose`` says how one is), an id that none has, and a nearest one farther than
    allowed.
    """
    if wanted is None:
        if len(places) > 1:
            raise RecordError(f"{where}: has {len(places)} sites, the first at {places[0]}; {choose}")
        return Site(0, places[0])
    if wanted.place is None:
        if wanted.id in ids:
            position = list(ids).index(wanted.id)
            return Site(position, places[position])
        hint = nearest_word(wanted.id, ids)
        known = f"its ids go from {ids[0]} to {ids[-1]}" if ids else "its sites have no ids"
        raise RecordError(f"{where}: has no site {shown(wanted.id)}{hint}; {known}: {EXAMPLE}")
    site = nearest(places, wanted.place)
    if site.distance > wanted.within:
        raise RecordError(
            f"{where}: the nearest of its {len(places)} sites is at {site.place}, {site.distance:.1f} km from "
            f"{wanted.place}, and {wanted.within:g} km are allowed; check longitude and latitude, in this order, or "
            f"write '{wanted.place} within {ceil(1.05 * site.distance)} km'"
        )
    return site


def place_of(table: Table, row: Row, longitude: str = "lon", latitude: str = "lat") -> Place:
    """Longitude and latitude of a row."""
    return place(table.number(row, longitude), table.number(row, latitude), f"{table.path}, line {row.line}")


def split_site(text: str) -> tuple[str, str]:
    """A file, or pattern of files, and the site after "#"; a file whose own name has a # is taken as it is."""
    name, mark, site = text.rpartition("#")
    return (name, site) if mark and name and not Path(text).exists() else (text, "")


def site_words(site: Site, wanted: SiteRequest | None) -> str:
    """Sentence on the site that was taken."""
    if wanted is None or wanted.place is None:
        return f"The site is at {site.place}."
    return f"The site is at {site.place}, {site.distance:.3g} km from {wanted.place}."
